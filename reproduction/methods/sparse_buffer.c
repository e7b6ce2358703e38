/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The sparse single buffer of thesis section 2.2: the bone is a list of its active voxels. The list contains the
 * position of each voxel, because the position does not follow from the index. The voxels near the tool can be anywhere
 * in the list, so an event compares all voxels of the list with the tool's grid. The voxels after a removed voxel are
 * then shifted, so that the list has no gaps.
 *
 *   part by part: mark the hit voxels, close the gaps within the part    (threads)
 *   move the parts together, from the first part with a removed voxel    (one thread, memmove)
 *
 * A voxel takes 8 bytes: three int16 for the position and one for the density. In the thesis' CT files, a position
 * consists of three floats.
 */
#include "reproduction/methods/matrix.h"

#include <stdlib.h>
#include <string.h>

enum { PART = 4096, TILE = 256 };

typedef struct voxel_list {
    int16_t *field[4]; /* owned: x, y, z, density */
    size_t count;
} voxel_list;

typedef struct sparse_buffer {
    const methods_scene *scene;
    voxel_list full, live; /* the list before the event, and the list that the event modifies */
    matrix_tool tool;
    matrix_map map;
    size_t *kept; /* owned; number of voxels that remain in each part */
    int threads;
} sparse_buffer;

static bool list_init(voxel_list *list, size_t count)
{
    bool made = true;
    list->count = count;
    for (int f = 0; f < 4; f++)
        made = (list->field[f] = malloc((count + 1) * sizeof *list->field[f])) && made;
    return made;
}

static void list_free(voxel_list *list)
{
    for (int f = 0; f < 4; f++)
        free(list->field[f]);
    *list = (voxel_list){0};
}

static void close_buffer(void *state)
{
    sparse_buffer *s = state;
    list_free(&s->full);
    list_free(&s->live);
    matrix_tool_free(&s->tool);
    matrix_map_free(&s->map);
    free(s->kept);
    free(s);
}

static void fill(voxel_list *list, const methods_scene *scene)
{
    const ost_dims d = scene->event.bone.dims;
    const int16_t *at = scene->voxels;
    size_t n = 0;
    for (int32_t k = 0; k < d.z; k++)
        for (int32_t j = 0; j < d.y; j++)
            for (int32_t i = 0; i < d.x; i++, at++) {
                if (*at == 0)
                    continue;
                list->field[0][n] = (int16_t)i;
                list->field[1][n] = (int16_t)j;
                list->field[2][n] = (int16_t)k;
                list->field[3][n] = *at;
                n++;
            }
}

static ost_status open_buffer(const methods_scene *scene, const method_setup *setup, void **state, ost_error *err)
{
    sparse_buffer *s = calloc(1, sizeof *s);
    size_t active = 0;
    if (!s)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a method");
    s->scene = scene;
    s->threads = setup->threads;
    const size_t voxels = (size_t)ost_dims_count(scene->event.bone.dims);
    for (size_t v = 0; v < voxels; v++)
        active += scene->voxels[v] != 0;
    ost_status status = OST_OK;
    s->kept = malloc((active / PART + 1) * sizeof *s->kept);
    if (!list_init(&s->full, active) || !list_init(&s->live, active) || !s->kept)
        status = ost_fail(err, OST_ERR_MEMORY, "out of memory for a list of %zu voxels", active);
    if (status == OST_OK)
        status = matrix_tool_init(&s->tool, &scene->event.tool, err);
    if (status != OST_OK) {
        close_buffer(s);
        return status;
    }
    fill(&s->full, scene);
    *state = s;
    return OST_OK;
}

static ost_status restore(void *state, ost_error *err)
{
    sparse_buffer *s = state;
    (void)err;
    for (int f = 0; f < 4; f++)
        memcpy(s->live.field[f], s->full.field[f], s->full.count * sizeof *s->full.field[f]);
    s->live.count = s->full.count;
    matrix_touch(s->tool.words, s->tool.count * sizeof *s->tool.words);
    return OST_OK;
}

/* Sets hit[n] to 1 for each voxel of [first, first + count) that is hit. */
static void mark(uint8_t *restrict hit, const sparse_buffer *s, size_t first, int32_t count)
{
    const int16_t *restrict vx = s->live.field[0] + first, *restrict vy = s->live.field[1] + first,
                  *restrict vz = s->live.field[2] + first;
    const ost_voxel_box box = s->scene->event.box;
    const matrix_map *m = &s->map;
    const int32_t *restrict base = m->base[0];
    const uint32_t *restrict words = s->tool.words;
    const int32_t nx = s->tool.dims[0], ny = s->tool.dims[1], nz = s->tool.dims[2];
    const int32_t fx = m->first[0], fy = m->first[1], fz = m->first[2], cx = m->count[0], cy = m->count[1];
    for (int32_t n = 0; n < count; n++) {
        const int32_t i = vx[n], j = vy[n], k = vz[n];
        const bool in = (i >= box.lo[0]) & (j >= box.lo[1]) & (k >= box.lo[2]) & (i < box.hi[0]) & (j < box.hi[1]) &
                        (k < box.hi[2]);
        const int32_t block = in ? 3 * ((i >> 4) - fx + cx * ((j >> 4) - fy + cy * ((k >> 4) - fz))) : 0;
        const int32_t di = i & 15, dj = j & 15, dk = k & 15;
        const int32_t x = (base[block] + di * m->step[0][0] + dj * m->step[1][0] + dk * m->step[2][0]) >> 20;
        const int32_t y = (base[block + 1] + di * m->step[0][1] + dj * m->step[1][1] + dk * m->step[2][1]) >> 20;
        const int32_t z = (base[block + 2] + di * m->step[0][2] + dj * m->step[1][2] + dk * m->step[2][2]) >> 20;
        const bool inside =
            in & ((uint32_t)x < (uint32_t)nx) & ((uint32_t)y < (uint32_t)ny) & ((uint32_t)z < (uint32_t)nz);
        const uint32_t bit = inside ? (uint32_t)(x + nx * (y + ny * z)) : 0;
        hit[n] = (uint8_t)((words[bit >> 5] >> (bit & 31)) & (uint32_t)inside);
    }
}

/* Removes the hit voxels of a part of the list and closes the gaps. Returns the number of voxels that remain. */
static size_t compact(const sparse_buffer *s, size_t first, size_t count)
{
    uint8_t hit[TILE];
    size_t kept = 0;
    for (size_t at = 0; at < count; at += TILE) {
        const int32_t n = count - at < TILE ? (int32_t)(count - at) : TILE;
        bool any = false;
        mark(hit, s, first + at, n);
        for (int32_t i = 0; i < n; i++)
            any |= hit[i] != 0;
        if (!any) {
            for (int f = 0; f < 4 && kept != at; f++)
                memmove(s->live.field[f] + first + kept, s->live.field[f] + first + at,
                        (size_t)n * sizeof *s->live.field[f]);
            kept += (size_t)n;
            continue;
        }
        for (int32_t i = 0; i < n; i++) {
            for (int f = 0; f < 4; f++)
                s->live.field[f][first + kept] = s->live.field[f][first + at + (size_t)i];
            kept += !hit[i];
        }
    }
    return kept;
}

static ost_status remove_event(void *state, ost_error *err)
{
    sparse_buffer *s = state;
    const bench_scene *event = &s->scene->event;
    const int64_t parts = (int64_t)((s->live.count + PART - 1) / PART);
    if (method_box_count(&event->box) == 0)
        return OST_OK;
    ost_status status = matrix_map_make(&s->map, &event->map, &event->box, err);
    if (status != OST_OK)
        return status;
#if defined _OPENMP
#pragma omp parallel for schedule(static) num_threads(s->threads) if (s->threads > 1)
#endif
    for (int64_t p = 0; p < parts; p++) {
        const size_t first = (size_t)p * PART, left = s->live.count - first;
        s->kept[p] = compact(s, first, left < PART ? left : PART);
    }
    size_t to = 0;
    for (int64_t p = 0; p < parts; p++) {
        const size_t from = (size_t)p * PART;
        for (int f = 0; f < 4 && to != from; f++)
            memmove(s->live.field[f] + to, s->live.field[f] + from, s->kept[p] * sizeof *s->live.field[f]);
        to += s->kept[p];
    }
    s->live.count = to;
    return OST_OK;
}

static ost_status result(void *state, method_set *set, ost_error *err)
{
    const sparse_buffer *s = state;
    const size_t count = method_box_count(&set->box);
    const int32_t nx = set->box.hi[0] - set->box.lo[0], ny = set->box.hi[1] - set->box.lo[1];
    int16_t *voxels = calloc(count + 1, sizeof *voxels);
    if (!voxels)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a region of %zu voxels", count);
    for (size_t n = 0; n < s->live.count; n++) {
        const int32_t i = s->live.field[0][n], j = s->live.field[1][n], k = s->live.field[2][n];
        if (i >= set->box.lo[0] && j >= set->box.lo[1] && k >= set->box.lo[2] && i < set->box.hi[0] &&
            j < set->box.hi[1] && k < set->box.hi[2])
            voxels[i - set->box.lo[0] + (int64_t)nx * (j - set->box.lo[1] + (int64_t)ny * (k - set->box.lo[2]))] =
                s->live.field[3][n];
    }
    method_set_add_removed(set, s->scene, voxels);
    free(voxels);
    return OST_OK;
}

static void work(void *state, method_work *out)
{
    const sparse_buffer *s = state;
    const int64_t voxels = (int64_t)s->full.count;
    *out = (method_work){.visited = voxels, .bone_bytes = voxels * (int64_t)sizeof(int16_t),
                         .index_bytes = voxels * (int64_t)(3 * sizeof(int16_t)),
                         .tool_bytes = (int64_t)(s->tool.count * sizeof *s->tool.words)};
}

const method method_sparse_buffer = {
    .info = {.name = "sparse_buffer",
             .title = "list of active bone voxels with positions, shifted after removal",
             .source = "thesis, 2.2: one sparse buffer",
             .definition = METHODS_BONE_TO_TOOL},
    .per_bone_voxel = 18, .per_tool_voxel = 0.2,
    .native = true,
    .open = open_buffer, .close = close_buffer, .restore = restore, .remove = remove_event, .result = result,
    .work = work,
};
