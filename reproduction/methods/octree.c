/* SPDX-License-Identifier: Apache-2.0 */
/*
 * An octree of the bone (thesis, section 3.2.5). An event visits nodes of the tree and compares them with the tool.
 *
 *   node    8 children; a child is void (0), a node, or at the lowest level a brick
 *   brick   4^3 voxels: a word with one bit per active voxel, and 64 densities. The word replaces the two lowest
 *           levels of the tree, whose nodes would be larger than their content
 *   tool    cells of 2^3, 4^3, ... tool voxels; one flag states whether the cell contains a cutting voxel, and one
 *           flag states whether all its voxels are cutting
 *   event   the nodes of 16^3 voxels that overlap the event's box are divided among the threads; each of these
 *           nodes has one map (AR-MAP-4). The bounds of a node are mapped to the tool's grid, and the flags of the
 *           cells in these bounds are read:
 *                 no cutting voxel: the node is skipped;  only cutting voxels: the node becomes void
 *                 mixed: its 8 children or, for a brick, its 64 voxels are tested
 *   refresh after each event, a node without children becomes void
 *
 * In the thesis, nodes are homogeneous in content. Here, only a void node is homogeneous, and it needs no memory. The
 * densities of all other nodes are stored, because densities of a CT differ from voxel to voxel.
 */
#include "reproduction/methods/matrix.h"
#include "reproduction/methods/pyramid.h"

#include <stdlib.h>
#include <string.h>

enum { BRICK = 4, TASK_LEVEL = 2, LEVEL_MIN = 3 };

/* child[x + 2 (y + 2 z)] is 0 if child (x, y, z) is void. Otherwise, it is the child's index + 1. In a node of level 1,
   this is the index of a brick; in all other nodes, it is the index of a node. */
typedef struct node {
    int32_t child[8];
} node;

typedef struct tree {
    node *nodes;        /* owned */
    uint64_t *masks;    /* owned; one word per brick, in which bit x + 4 (y + 4 z) belongs to voxel (x, y, z) */
    int16_t *densities; /* owned; 64 densities per brick */
    size_t node_count, node_capacity, brick_count, brick_capacity;
    int32_t root;
} tree;

typedef struct task {
    int32_t node, corner[3];
    int64_t tested; /* number of voxels that were mapped to the tool's grid */
    bool is_void;
} task;

typedef struct octree {
    const methods_scene *scene;
    tree full, live; /* the tree before the event, and the tree that events change; both use the same indices */
    int level;       /* level of the root, whose edge is 4 << level voxels */
    matrix_tool tool;
    pyramid cells;
    matrix_map map;
    task *tasks; /* owned */
    size_t task_count, task_capacity;
    int threads;
    int64_t visited;
} octree;

/* ------------------------------------------------------------------- building */

static bool grow(void **at, size_t *capacity, size_t count, size_t size)
{
    if (count < *capacity)
        return true;
    const size_t more = *capacity ? 2 * *capacity : 1024;
    void *grown = realloc(*at, more * size);
    if (!grown)
        return false;
    *at = grown;
    *capacity = more;
    return true;
}

static bool add_brick(tree *t, const methods_scene *scene, const int32_t corner[3], int32_t *out)
{
    const ost_dims d = scene->event.bone.dims;
    int16_t densities[64] = {0};
    uint64_t mask = 0;
    for (int n = 0; n < 64; n++) {
        const int32_t i = corner[0] + (n & 3), j = corner[1] + (n >> 2 & 3), k = corner[2] + (n >> 4);
        if (i >= d.x || j >= d.y || k >= d.z)
            continue;
        densities[n] = scene->voxels[i + (int64_t)d.x * (j + (int64_t)d.y * k)];
        mask |= (uint64_t)(densities[n] != 0) << n;
    }
    *out = 0;
    if (mask == 0)
        return true;
    size_t capacity = t->brick_capacity;
    if (!grow((void **)&t->masks, &t->brick_capacity, t->brick_count, sizeof *t->masks) ||
        !grow((void **)&t->densities, &capacity, t->brick_count, sizeof densities))
        return false;
    t->masks[t->brick_count] = mask;
    memcpy(t->densities + 64 * t->brick_count, densities, sizeof densities);
    *out = (int32_t)++t->brick_count;
    return true;
}

/* Builds the subtree of a node with an edge of 4 << level voxels. Returns false if memory is exhausted. */
static bool build(tree *t, const methods_scene *scene, int level, const int32_t corner[3], int32_t *out)
{
    const ost_dims d = scene->event.bone.dims;
    node children = {{0}};
    bool any = false;
    *out = 0;
    if (corner[0] >= d.x || corner[1] >= d.y || corner[2] >= d.z)
        return true;
    if (level == 0)
        return add_brick(t, scene, corner, out);
    const int32_t half = (BRICK << level) / 2;
    for (int c = 0; c < 8; c++) {
        const int32_t at[3] = {corner[0] + half * (c & 1), corner[1] + half * (c >> 1 & 1),
                               corner[2] + half * (c >> 2)};
        if (!build(t, scene, level - 1, at, &children.child[c]))
            return false;
        any = any || children.child[c] != 0;
    }
    if (!any)
        return true;
    if (!grow((void **)&t->nodes, &t->node_capacity, t->node_count, sizeof *t->nodes))
        return false;
    t->nodes[t->node_count] = children;
    *out = (int32_t)++t->node_count;
    return true;
}

static void tree_free(tree *t)
{
    free(t->nodes);
    free(t->masks);
    free(t->densities);
    *t = (tree){0};
}

static bool tree_copy(tree *to, const tree *from)
{
    *to = (tree){.node_count = from->node_count, .brick_count = from->brick_count, .root = from->root};
    to->nodes = malloc((from->node_count + 1) * sizeof *to->nodes);
    to->masks = malloc((from->brick_count + 1) * sizeof *to->masks);
    to->densities = malloc((from->brick_count + 1) * 64 * sizeof *to->densities);
    if (!to->nodes || !to->masks || !to->densities)
        return false;
    if (from->node_count)
        memcpy(to->nodes, from->nodes, from->node_count * sizeof *to->nodes);
    if (from->brick_count) {
        memcpy(to->masks, from->masks, from->brick_count * sizeof *to->masks);
        memcpy(to->densities, from->densities, from->brick_count * 64 * sizeof *to->densities);
    }
    return true;
}

/* ------------------------------------------------------------------ the event */

/*
 * Determines the tool's content in the region of a node with `edge` voxels per edge. `u` is the tool coordinate of the
 * node's first voxel.
 */
static pyramid_found content_over(const octree *s, const int32_t u[3], int32_t edge)
{
    int32_t lo[3], hi[3];
    for (int a = 0; a < 3; a++) {
        int32_t least = u[a], greatest = u[a];
        for (int b = 0; b < 3; b++) {
            const int32_t end = (edge - 1) * s->map.step[b][a];
            least += end < 0 ? end : 0;
            greatest += end < 0 ? 0 : end;
        }
        lo[a] = least >> OST_MAP_FRACTION;
        hi[a] = greatest >> OST_MAP_FRACTION;
    }
    return pyramid_content(&s->cells, lo, hi, s->tool.dims);
}

/* Returns a word with one bit per voxel of a brick. The bit is set if a cutting tool voxel covers the voxel. */
static uint64_t hits_of(const octree *s, const int32_t u[3])
{
    const int32_t nx = s->tool.dims[0], ny = s->tool.dims[1], nz = s->tool.dims[2];
    const uint32_t *restrict words = s->tool.words;
    int32_t step[3][3];
    uint8_t hit[64];
    uint64_t mask = 0;
    memcpy(step, s->map.step, sizeof step);
    for (int32_t n = 0; n < 64; n++) {
        const int32_t i = n & 3, j = n >> 2 & 3, k = n >> 4;
        const int32_t x = (u[0] + i * step[0][0] + j * step[1][0] + k * step[2][0]) >> OST_MAP_FRACTION;
        const int32_t y = (u[1] + i * step[0][1] + j * step[1][1] + k * step[2][1]) >> OST_MAP_FRACTION;
        const int32_t z = (u[2] + i * step[0][2] + j * step[1][2] + k * step[2][2]) >> OST_MAP_FRACTION;
        const bool inside = ((uint32_t)x < (uint32_t)nx) & ((uint32_t)y < (uint32_t)ny) & ((uint32_t)z < (uint32_t)nz);
        const uint32_t bit = inside ? (uint32_t)(x + nx * (y + ny * z)) : 0;
        hit[n] = (uint8_t)((words[bit >> 5] >> (bit & 31)) & (uint32_t)inside);
    }
    for (int32_t b = 0; b < 8; b++) {
        /* The multiplication collects the lowest bits of eight bytes in the highest byte of the product. */
        uint64_t eight;
        memcpy(&eight, hit + 8 * b, sizeof eight);
        mask |= (eight * UINT64_C(0x0102040810204080) >> 56) << 8 * b;
    }
    return mask;
}

/* Removes the hit voxels of a brick. Returns true if the brick is void afterwards. */
static bool remove_from_brick(octree *s, task *t, int32_t brick, const int32_t u[3])
{
    uint64_t *mask = &s->live.masks[brick - 1];
    const pyramid_found tool = content_over(s, u, BRICK);
    if (tool == PYRAMID_NONE)
        return false;
    if (tool == PYRAMID_ALL)
        return true;
    const uint64_t hits = hits_of(s, u) & *mask;
    t->tested += 64;
    if (hits == 0)
        return false;
    int16_t *densities = s->live.densities + 64 * (size_t)(brick - 1);
    for (int n = 0; n < 64; n++)
        densities[n] = hits >> n & 1 ? 0 : densities[n];
    *mask &= ~hits;
    return *mask == 0;
}

/* Removes the hit voxels of a node with an edge of 4 << level voxels. `level` must be at most TASK_LEVEL. `corner` is
   the position of the node's first voxel in its block of 16^3 voxels. Returns true if the node is void afterwards. */
static bool remove_from(octree *s, task *t, int32_t index, int level, const int32_t corner[3], const int32_t base[3])
{
    int32_t u[3];
    for (int a = 0; a < 3; a++)
        u[a] = base[a] + corner[0] * s->map.step[0][a] + corner[1] * s->map.step[1][a] + corner[2] * s->map.step[2][a];
    if (level == 0)
        return remove_from_brick(s, t, index, u);
    const pyramid_found tool = content_over(s, u, BRICK << level);
    if (tool != PYRAMID_MIXED)
        return tool == PYRAMID_ALL;
    node *at = &s->live.nodes[index - 1];
    const int32_t half = (BRICK << level) / 2;
    bool any = false;
    for (int c = 0; c < 8; c++) {
        const int32_t next[3] = {corner[0] + half * (c & 1), corner[1] + half * (c >> 1 & 1),
                                 corner[2] + half * (c >> 2)};
        if (at->child[c] != 0 && remove_from(s, t, at->child[c], level - 1, next, base))
            at->child[c] = 0;
        any = any || at->child[c] != 0;
    }
    return !any;
}

static bool overlaps(const ost_voxel_box *box, const int32_t corner[3], int32_t edge)
{
    for (int a = 0; a < 3; a++)
        if (corner[a] >= box->hi[a] || corner[a] + edge <= box->lo[a])
            return false;
    return true;
}

/* Appends the nodes of 16^3 voxels that overlap the event's box. Returns false if memory is exhausted. */
static bool list_tasks(octree *s, int32_t index, int level, const int32_t corner[3])
{
    if (index == 0 || !overlaps(&s->scene->event.box, corner, BRICK << level))
        return true;
    if (level == TASK_LEVEL) {
        if (!grow((void **)&s->tasks, &s->task_capacity, s->task_count, sizeof *s->tasks))
            return false;
        s->tasks[s->task_count++] = (task){.node = index, .corner = {corner[0], corner[1], corner[2]}};
        return true;
    }
    const int32_t half = (BRICK << level) / 2;
    for (int c = 0; c < 8; c++) {
        const int32_t at[3] = {corner[0] + half * (c & 1), corner[1] + half * (c >> 1 & 1),
                               corner[2] + half * (c >> 2)};
        if (!list_tasks(s, s->live.nodes[index - 1].child[c], level - 1, at))
            return false;
    }
    return true;
}

static void run_task(octree *s, task *t)
{
    const matrix_map *m = &s->map;
    const int32_t none[3] = {0, 0, 0};
    int64_t block = 0;
    for (int a = 2; a >= 0; a--)
        block = block * m->count[a] + t->corner[a] / OST_MAP_BLOCK - m->first[a];
    t->is_void = remove_from(s, t, t->node, TASK_LEVEL, none, m->base[block]);
}

/* After an event, updates a node and its descendants down to the tasks, which are nodes of 16^3 voxels: sets each child
   that became void to 0. *next is the index of the next task in the order of list_tasks. Returns true if the node is
   void. */
static bool refresh(octree *s, int32_t index, int level, const int32_t corner[3], size_t *next)
{
    if (!overlaps(&s->scene->event.box, corner, BRICK << level))
        return false;
    if (level == TASK_LEVEL)
        return s->tasks[(*next)++].is_void;
    node *at = &s->live.nodes[index - 1];
    const int32_t half = (BRICK << level) / 2;
    bool any = false;
    for (int c = 0; c < 8; c++) {
        const int32_t to[3] = {corner[0] + half * (c & 1), corner[1] + half * (c >> 1 & 1),
                               corner[2] + half * (c >> 2)};
        if (at->child[c] != 0 && refresh(s, at->child[c], level - 1, to, next))
            at->child[c] = 0;
        any = any || at->child[c] != 0;
    }
    return !any;
}

static ost_status remove_event(void *state, ost_error *err)
{
    octree *s = state;
    const bench_scene *event = &s->scene->event;
    const int32_t first[3] = {0, 0, 0};
    size_t next = 0;
    s->task_count = 0;
    s->visited = 0;
    if (method_box_count(&event->box) == 0 || s->live.root == 0)
        return OST_OK;
    ost_status status = matrix_map_make(&s->map, &event->map, &event->box, err);
    if (status == OST_OK && !list_tasks(s, s->live.root, s->level, first))
        status = ost_fail(err, OST_ERR_MEMORY, "out of memory for the nodes of an event");
    if (status != OST_OK)
        return status;
#if defined _OPENMP
#pragma omp parallel for schedule(dynamic, 2) num_threads(s->threads) if (s->threads > 1)
#endif
    for (size_t t = 0; t < s->task_count; t++)
        run_task(s, &s->tasks[t]);
    if (refresh(s, s->live.root, s->level, first, &next))
        s->live.root = 0;
    for (size_t t = 0; t < s->task_count; t++)
        s->visited += s->tasks[t].tested;
    return OST_OK;
}

/* -------------------------------------------------------------------- the rest */

static void close_octree(void *state)
{
    octree *s = state;
    tree_free(&s->full);
    tree_free(&s->live);
    matrix_tool_free(&s->tool);
    pyramid_free(&s->cells);
    matrix_map_free(&s->map);
    free(s->tasks);
    free(s);
}

static ost_status open_octree(const methods_scene *scene, const method_setup *setup, void **state, ost_error *err)
{
    const ost_dims d = scene->event.bone.dims;
    const int32_t first[3] = {0, 0, 0};
    octree *s = calloc(1, sizeof *s);
    if (!s)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a method");
    s->scene = scene;
    s->threads = setup->threads;
    s->level = LEVEL_MIN;
    while (BRICK << s->level < d.x || BRICK << s->level < d.y || BRICK << s->level < d.z)
        s->level++;
    ost_status status = OST_OK;
    if (!build(&s->full, scene, s->level, first, &s->full.root) || !tree_copy(&s->live, &s->full) ||
        !pyramid_init(&s->cells, &scene->event.tool))
        status = ost_fail(err, OST_ERR_MEMORY, "out of memory for an octree");
    if (status == OST_OK)
        status = matrix_tool_init(&s->tool, &scene->event.tool, err);
    if (status == OST_OK)
        *state = s;
    else
        close_octree(s);
    return status;
}

/* Copies the nodes and bricks that overlap the event's box. The event changes no others, and it changes no indices. */
static void restore_node(octree *s, int32_t index, int level, const int32_t corner[3])
{
    if (index == 0 || !overlaps(&s->scene->event.box, corner, BRICK << level))
        return;
    if (level == 0) {
        const size_t brick = (size_t)(index - 1);
        s->live.masks[brick] = s->full.masks[brick];
        memcpy(s->live.densities + 64 * brick, s->full.densities + 64 * brick, 64 * sizeof *s->live.densities);
        return;
    }
    const node *from = &s->full.nodes[index - 1];
    const int32_t half = (BRICK << level) / 2;
    s->live.nodes[index - 1] = *from;
    for (int c = 0; c < 8; c++) {
        const int32_t at[3] = {corner[0] + half * (c & 1), corner[1] + half * (c >> 1 & 1),
                               corner[2] + half * (c >> 2)};
        restore_node(s, from->child[c], level - 1, at);
    }
}

static ost_status restore(void *state, ost_error *err)
{
    octree *s = state;
    const int32_t first[3] = {0, 0, 0};
    (void)err;
    s->live.root = s->full.root;
    restore_node(s, s->full.root, s->level, first);
    matrix_touch(s->tool.words, s->tool.count * sizeof *s->tool.words);
    for (int l = 0; l < s->cells.levels; l++)
        matrix_touch(s->cells.flags[l], (size_t)s->cells.dims[l][0] * (size_t)s->cells.dims[l][1] *
                                           (size_t)s->cells.dims[l][2]);
    return OST_OK;
}

static int16_t density_of(const octree *s, int32_t i, int32_t j, int32_t k)
{
    int32_t index = s->live.root;
    for (int level = s->level; level > 0 && index != 0; level--) {
        const int bit = level + 1; /* a child has an edge of 2^(level + 1) voxels */
        index = s->live.nodes[index - 1].child[(i >> bit & 1) + 2 * (j >> bit & 1) + 4 * (k >> bit & 1)];
    }
    if (index == 0)
        return 0;
    const int n = (i & 3) + 4 * ((j & 3) + 4 * (k & 3));
    return s->live.masks[index - 1] >> n & 1 ? s->live.densities[64 * (size_t)(index - 1) + (size_t)n] : 0;
}

static ost_status result(void *state, method_set *set, ost_error *err)
{
    const octree *s = state;
    int16_t *voxels = malloc((method_box_count(&set->box) + 1) * sizeof *voxels), *at = voxels;
    if (!voxels)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a region");
    for (int32_t k = set->box.lo[2]; k < set->box.hi[2]; k++)
        for (int32_t j = set->box.lo[1]; j < set->box.hi[1]; j++)
            for (int32_t i = set->box.lo[0]; i < set->box.hi[0]; i++)
                *at++ = density_of(s, i, j, k);
    method_set_add_removed(set, s->scene, voxels);
    free(voxels);
    return OST_OK;
}

static void work(void *state, method_work *out)
{
    const octree *s = state;
    int64_t cells = 0;
    for (int l = 0; l < s->cells.levels; l++)
        cells += (int64_t)s->cells.dims[l][0] * s->cells.dims[l][1] * s->cells.dims[l][2];
    *out = (method_work){.visited = s->visited,
                         .bone_bytes = (int64_t)(s->full.brick_count * 64 * sizeof(int16_t)),
                         .index_bytes = (int64_t)(s->full.brick_count * sizeof(uint64_t) +
                                                  s->full.node_count * sizeof(node)),
                         .tool_bytes = (int64_t)(s->tool.count * sizeof *s->tool.words) + cells};
}

const method method_octree = {
    .info = {.name = "octree", .title = "octree of the bone with void nodes, refreshed after removal",
             .source = "thesis, 3.2.5",
             .definition = METHODS_BONE_TO_TOOL},
    .per_bone_voxel = 10, .per_tool_voxel = 0.5,
    .native = true,
    .open = open_octree, .close = close_octree, .restore = restore, .remove = remove_event, .result = result,
    .work = work,
};
