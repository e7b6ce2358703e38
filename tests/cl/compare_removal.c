/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Compares ost_remove and ost_remove_blocks with the reference. Each event is run three times: as a collision, as a
 * removal, and as the same removal again. The test compares the reports, summed over blocks, and every density and
 * occupancy word. Poses, tools and boxes are random. At some poses, centres of bone voxels lie exactly on the
 * borders of tool voxels.
 */
#include "cl/machine.h"

#include "cpu/ref/ref.h"
#include "ref/scene.h"

enum { BLOCK = OST_MAP_BLOCK };

typedef struct bone_pool {
    const ost_chunk_grid *grid; /* the reference's grid before the event */
    size_t used, voxels;
    uint32_t *slots;
    int16_t *density;
    uint32_t *words;
} bone_pool;

static void *zeros(size_t count, size_t size)
{
    void *p = calloc(count ? count : 1, size);
    assert_non_null(p);
    return p;
}

/* Makes a pool in which the chunks are in random order, because a device need not store them in order. */
static bone_pool pool_of(const ost_chunk_grid *grid, test_rng *rng)
{
    bone_pool p = {.grid = grid, .voxels = (size_t)grid->size * (size_t)grid->size * (size_t)grid->size};
    p.slots = zeros((size_t)grid->count, 4);
    for (int64_t c = 0; c < grid->count; c++)
        if (grid->chunks[c].density)
            p.slots[c] = (uint32_t)p.used++;
        else
            p.slots[c] = OST_CL_NONE;
    for (int64_t c = 0; c < grid->count; c++) {
        const int64_t other = rng_range(rng, c, grid->count - 1);
        if (p.slots[c] != OST_CL_NONE && p.slots[other] != OST_CL_NONE) {
            const uint32_t swap = p.slots[c];
            p.slots[c] = p.slots[other];
            p.slots[other] = swap;
        }
    }
    p.density = zeros(p.used * p.voxels, 2);
    p.words = zeros(p.used * p.voxels / 32, 4);
    for (int64_t c = 0; c < grid->count; c++)
        if (p.slots[c] != OST_CL_NONE) {
            memcpy(p.density + p.slots[c] * p.voxels, grid->chunks[c].density, p.voxels * 2);
            memcpy(p.words + p.slots[c] * p.voxels / 32, grid->chunks[c].occupancy, p.voxels / 8);
        }
    return p;
}

static void pool_free(bone_pool *p)
{
    free(p->slots);
    free(p->density);
    free(p->words);
}

static int32_t clamped(int32_t v, int32_t most)
{
    return v < 0 ? 0 : v > most ? most : v;
}

/* The blocks and entries of an event, in the form that shared.h defines. */
typedef struct plan {
    ost_cl_event event;
    ost_cl_block *blocks;
    ost_cl_entry *entries;
    ost_cl_pose *poses;
    int32_t *chunk; /* chunk index of each block */
    size_t entry_count, pose_count;
} plan;

static plan plan_event(const bone_pool *p, const ost_removal_event *event, const ost_tool_geometry *tool, test_rng *rng)
{
    const ost_dims d = p->grid->dims;
    const int32_t bx = (d.x + BLOCK - 1) / BLOCK, by = (d.y + BLOCK - 1) / BLOCK, bz = (d.z + BLOCK - 1) / BLOCK,
                  n = p->grid->size;
    const size_t most = (size_t)bx * (size_t)by * (size_t)bz;
    plan e = {.pose_count = (size_t)event->pose_count,
              .event = {.tool_dims = {tool->dims.x, tool->dims.y, tool->dims.z},
                        .size = n,
                        .classes = event->classes->count}};
    for (int c = 0; c < event->classes->count; c++)
        e.event.border[c] = event->classes->border[c];
    e.blocks = zeros(most, sizeof *e.blocks);
    e.chunk = zeros(most, sizeof *e.chunk);
    e.entries = zeros(most * (size_t)event->pose_count, sizeof *e.entries);
    e.poses = zeros((size_t)event->pose_count, sizeof *e.poses);
    for (int k = 0; k < event->pose_count; k++) {
        memcpy(e.poses[k].step, event->maps[k].step, sizeof e.poses[k].step);
        for (int a = 0; a < 3; a++) {
            const int32_t wide = a == 0 ? d.x : a == 1 ? d.y : d.z;
            e.poses[k].lo[a] = clamped(event->boxes[k].lo[a], wide);
            e.poses[k].hi[a] = clamped(event->boxes[k].hi[a], wide);
        }
        ost_cl_pose_reach(&e.poses[k]);
    }
    /* The blocks are in cyclic order, beginning with a random block. */
    const int64_t turn = rng_range(rng, 0, (int64_t)most - 1);
    for (size_t i = 0; i < most; i++) {
        const int32_t b = (int32_t)((i + (size_t)turn) % most);
        const ost_dims at = {b % bx, b / bx % by, b / bx / by};
        const int32_t chunk = at.x * BLOCK / n +
                              p->grid->chunk_dims.x * (at.y * BLOCK / n + p->grid->chunk_dims.y * (at.z * BLOCK / n));
        ost_cl_block block = {.first = {BLOCK * at.x, BLOCK * at.y, BLOCK * at.z},
                              .slot = p->slots[chunk],
                              .entry = (uint32_t)e.entry_count};
        if (block.slot == OST_CL_NONE)
            continue;
        for (int k = 0; k < event->pose_count; k++) {
            bool meets = true;
            for (int a = 0; a < 3; a++)
                meets = meets && e.poses[k].lo[a] < block.first[a] + BLOCK && e.poses[k].hi[a] > block.first[a];
            ost_cl_entry entry = {.pose = (uint32_t)k};
            if (meets && ost_map_block_base(&event->maps[k], at, entry.base)) {
                e.entries[e.entry_count++] = entry;
                block.entries++;
            }
        }
        if (block.entries > 0) {
            e.chunk[e.event.blocks] = chunk;
            e.blocks[e.event.blocks++] = block;
        }
    }
    return e;
}

static void plan_free(plan *e)
{
    free(e->blocks);
    free(e->entries);
    free(e->poses);
    free(e->chunk);
}

/* Cells and windows of a tool, computed by the kernels. */
typedef struct tool_tables {
    uint8_t *cells[2]; /* cells[0] contains the result; cells[1] is scratch memory */
    uint8_t *windows;
    size_t bytes; /* size of `windows` in bytes */
    bool touches;
} tool_tables;

static tool_tables tables_of(machine *m, const uint8_t *classes, ost_dims d)
{
    const size_t voxels = (size_t)ost_dims_count(d);
    tool_tables t = {.cells = {zeros(voxels, 1), zeros(voxels, 1)}};
    ost_cl_tool shape = {.dims = {d.x, d.y, d.z}};
    for (shape.axis = 0; shape.axis < 3; shape.axis++)
        LAUNCH(m, ost_tool_reach, d.x, d.y, d.z, ONE(&shape),
               BUFFER(shape.axis ? t.cells[(shape.axis + 1) % 2] : classes, voxels),
               BUFFER(t.cells[shape.axis % 2], voxels));
    t.touches = memchr(classes, OST_TOOL_NONCUTTING, voxels) != NULL;
    shape.axis = t.touches ? 2 : 1;
    t.bytes = (size_t)shape.axis * (size_t)OST_CL_WINDOWS_X(d.x) * (size_t)OST_CL_WINDOWS_Y(d.y) *
              (size_t)OST_CL_WINDOWS_Z(d.z);
    t.windows = zeros(t.bytes, 1);
    memset(t.windows, 0x55, t.bytes); /* The kernel must write every byte. */
    LAUNCH(m, ost_tool_windows, OST_CL_WINDOWS_Y(d.y), OST_CL_WINDOWS_Z(d.z), OST_CL_WINDOWS_X(d.x) * shape.axis,
           ONE(&shape), BUFFER(classes, voxels), BUFFER(t.windows, t.bytes));
    return t;
}

static void tables_free(tool_tables *t)
{
    free(t->cells[0]);
    free(t->cells[1]);
    free(t->windows);
}

/* Makes the event's buffer. The order of its arrays differs from the order that the backend uses. */
static uint8_t *input_of(plan *e, size_t *bytes)
{
    const size_t entries = e->entry_count * sizeof *e->entries, poses = e->pose_count * sizeof *e->poses,
                 blocks = e->event.blocks * sizeof *e->blocks;
    e->event.entries_at = sizeof e->event;
    e->event.poses_at = (uint32_t)(e->event.entries_at + entries);
    e->event.blocks_at = (uint32_t)(e->event.poses_at + poses);
    *bytes = e->event.blocks_at + blocks;
    uint8_t *input = zeros(*bytes, 1);
    memcpy(input, &e->event, sizeof e->event);
    memcpy(input + e->event.entries_at, e->entries, entries);
    memcpy(input + e->event.poses_at, e->poses, poses);
    memcpy(input + e->event.blocks_at, e->blocks, blocks);
    return input;
}

/* Runs one launch, sums the reports of its blocks for each chunk and compares the sums with the reference's report. */
static void run(machine *m, const bone_pool *p, plan *e, const tool_tables *tables, const ost_tool_geometry *tool,
                bool apply, const ost_removal_report *expected)
{
    const size_t blocks = e->event.blocks;
    ost_cl_block_report *reports = zeros(blocks, sizeof *reports);
    ost_chunk_report *sums = zeros((size_t)p->grid->count, sizeof *sums);
    uint64_t touched = 0, total = 0;
    e->event.apply = apply;
    e->event.touches = tables->touches;
    size_t bytes;
    uint8_t *input = input_of(e, &bytes);
    if (blocks > 0 && m->rows == 256)
        LAUNCH(m, ost_remove_blocks, (blocks + OST_CL_BATCHES - 1) / OST_CL_BATCHES * OST_CL_BATCHES, 1, 1,
               BUFFER(input, bytes), BUFFER(tables->cells[0], ost_dims_count(tool->dims)),
               BUFFER(tables->windows, tables->bytes), BUFFER(p->density, p->used * p->voxels),
               BUFFER(p->words, p->used * p->voxels / 32), BUFFER(reports, blocks));
    else if (blocks > 0)
        LAUNCH(m, ost_remove, blocks * 256 / (size_t)m->rows, 1, 1, BUFFER(input, bytes),
               BUFFER(tables->cells[0], ost_dims_count(tool->dims)), BUFFER(p->density, p->used * p->voxels),
               BUFFER(p->words, p->used * p->voxels / 32), BUFFER(reports, blocks));
    free(input);
    for (size_t b = 0; b < blocks; b++) {
        touched += reports[b].touched;
        for (int c = 0; c < OST_CL_CLASSES; c++) {
            sums[e->chunk[b]].voxels[c] += reports[b].voxels[c];
            sums[e->chunk[b]].density[c] += reports[b].density[c];
            total += reports[b].voxels[c];
        }
    }
    if (touched != expected->touched_voxels || total != expected->total_voxels)
        fail_msg("%s: %llu hits and %llu touched voxels; the reference has %llu and %llu", m->name,
                 (unsigned long long)total, (unsigned long long)touched, (unsigned long long)expected->total_voxels,
                 (unsigned long long)expected->touched_voxels);
    size_t at = 0;
    for (int64_t c = 0; c < p->grid->count; c++) {
        uint64_t any = 0;
        for (int k = 0; k < OST_CL_CLASSES; k++)
            any += sums[c].voxels[k];
        if (any == 0)
            continue;
        assert_true(at < expected->count);
        assert_int_equal(expected->chunks[at].chunk, c);
        assert_memory_equal(expected->chunks[at].voxels, sums[c].voxels, sizeof sums[c].voxels);
        assert_memory_equal(expected->chunks[at].density, sums[c].density, sizeof sums[c].density);
        at++;
    }
    assert_int_equal(at, expected->count);
    free(reports);
    free(sums);
}

/* ---------------------------------------------------------------- scenes */

static uint8_t *some_classes(test_rng *rng, ost_dims d)
{
    uint8_t *classes = zeros((size_t)ost_dims_count(d), 1), *v = classes;
    const int form = (int)rng_range(rng, 0, 5);
    for (int32_t z = 0; z < d.z; z++)
        for (int32_t y = 0; y < d.y; y++)
            for (int32_t x = 0; x < d.x; x++, v++) {
                const int64_t cx = 2 * x + 1 - d.x, cy = 2 * y + 1 - d.y, cz = 2 * z + 1 - d.z,
                              all = cx * cx + cy * cy + cz * cz;
                switch (form) {
                case 0: *v = all <= (int64_t)d.x * d.x ? OST_TOOL_CUTTING : OST_TOOL_VOID; break;
                case 1:
                    *v = all > (int64_t)d.x * d.x       ? OST_TOOL_VOID
                         : all * 4 > (int64_t)d.x * d.x ? OST_TOOL_CUTTING
                                                        : OST_TOOL_NONCUTTING;
                    break;
                case 2: *v = z == d.z / 2 ? OST_TOOL_CUTTING : OST_TOOL_VOID; break;
                case 3: *v = (uint8_t)rng_range(rng, 0, 2); break;
                case 4: *v = OST_TOOL_CUTTING; break;
                default:
                    *v = x < d.x / 2                ? OST_TOOL_NONCUTTING
                         : (x / 5 + y / 5) % 3 == 0 ? OST_TOOL_CUTTING
                                                    : OST_TOOL_VOID;
                    break;
                }
            }
    return classes;
}

/*
 * Returns a pose on or near the bone. Some poses are rotated by quarter turns, so that the voxels of tool and bone are
 * aligned.
 */
static ost_pose some_pose(test_rng *rng, const ost_geometry *g)
{
    const ost_pm s = g->spacing.x;
    ost_pose pose = random_pose(rng, (ost_pm3){-2 * s, -2 * s, -2 * s},
                                (ost_pm3){g->dims.x * s, g->dims.y * s, g->dims.z * s});
    const int64_t how = rng_range(rng, 0, 5);
    if (how < 2) {
        const int32_t c = 759250125;
        const ost_pose quarters[] = {
            {{0}, OST_Q30_ONE, 0, 0, 0}, {{0}, c, c, 0, 0}, {{0}, c, 0, -c, 0}, {{0}, 0, 0, 0, OST_Q30_ONE}};
        const ost_pm3 at = pose.t;
        pose = quarters[rng_range(rng, 0, 3)];
        pose.t = at;
    }
    if (how % 2 == 0)
        pose.t = (ost_pm3){pose.t.x / s * s, pose.t.y / s * s, pose.t.z / s * s};
    pose.t.x += g->origin.x;
    pose.t.y += g->origin.y;
    pose.t.z += g->origin.z;
    return pose;
}

static void removal_round(machine *m, test_rng *rng, ost_backend *ref)
{
    /* edge lengths of tool voxels, in thousandths of the edge length of a bone voxel */
    static const int64_t shares[] = {3000, 2128, 1064, 1000, 900, 750, 400, 150, 63};
    ost_error err = {0};
    const ost_pm s = 470 * UM;
    const int32_t most = m->small ? 14 : 50;
    const ost_geometry g = cubic_geometry((int32_t)rng_range(rng, 1, most), (int32_t)rng_range(rng, 1, most + most / 2),
                                          (int32_t)rng_range(rng, 1, most), s,
                                          (ost_pm3){rng_range(rng, -50000, 50000) * UM, 123456789, -s});
    const int64_t share = shares[rng_range(rng, 0, 8)];
    const int32_t wide = m->small ? 14 : share < 500 ? 80 : 30;
    ost_tool_volume volume;
    const ost_dims d = {(int32_t)rng_range(rng, 1, wide), (int32_t)rng_range(rng, 1, wide),
                        (int32_t)rng_range(rng, 1, wide)};
    const ost_pm v = s * share / 1000;
    assert_ok(
        ost_tool_volume_init(&volume, &(ost_tool_geometry){d, v, {-v * d.x / 2, -v * d.y / 2, -v * d.z / 2}}, &err));
    free(volume.voxels);
    volume.voxels = some_classes(rng, d);
    int16_t *voxels = random_densities(rng, &g, (int)rng_range(rng, 1, 8));
    if (rng_range(rng, 0, 3) == 0)
        for (size_t i = 0; i < voxel_count(&g); i++)
            voxels[i] = (int16_t)rng_range(rng, -32768, 32767);
    if (rng_range(rng, 0, 3) == 0) /* Sets half of the voxels to 0, so that some chunks are absent. */
        memset(voxels, 0, voxel_count(&g) / 2 * sizeof *voxels);

    scene_event scene;
    const int poses = (int)rng_range(rng, 1, 6);
    ost_pose pose = some_pose(rng, &g);
    for (int k = 0; k < poses; k++) {
        assert_ok(ost_map_make(&pose, &g, &volume.geometry, &scene.maps[k], &err));
        scene.boxes[k] = (ost_voxel_box){.hi = {g.dims.x, g.dims.y, g.dims.z}};
        if (rng_range(rng, 0, 2) == 0) /* Replaces the box by a random box, which may exclude a part of the tool. */
            for (int a = 0; a < 3; a++) {
                scene.boxes[k].lo[a] = (int32_t)rng_range(rng, -3, 40);
                scene.boxes[k].hi[a] = (int32_t)rng_range(rng, scene.boxes[k].lo[a], 75);
            }
        pose.t.x += s / 3;
        pose.t.z -= s / 2;
    }
    scene.classes = ost_density_classes_default();
    if (rng_range(rng, 0, 2) == 0) {
        scene.classes.count = (int)rng_range(rng, 1, OST_CLASS_MAX);
        for (int c = 0; c < scene.classes.count; c++)
            scene.classes.border[c] = (int16_t)(rng_range(rng, 1, 900) + 1000 * c); /* strictly increasing */
    }
    scene.event = (ost_removal_event){
        .pose_count = poses, .maps = scene.maps, .boxes = scene.boxes, .classes = &scene.classes};

    ost_bone *bone = bone_of(ref, &g, 16 << rng_range(rng, 0, m->small ? 1 : 2), voxels);
    ost_tool *tool;
    ost_removal_report report = {0};
    assert_ok(ost_tool_upload(ref, &volume, &tool, &err));
    const ost_chunk_grid *grid = &((const ref_bone *)bone)->chunks;
    bone_pool p = pool_of(grid, rng);
    plan e = plan_event(&p, &scene.event, &volume.geometry, rng);
    tool_tables tables = tables_of(m, volume.voxels, d);

    assert_ok(ost_bone_collide(bone, tool, &scene.event, &report, &err));
    run(m, &p, &e, &tables, &volume.geometry, false, &report);
    assert_ok(ost_bone_remove(bone, tool, &scene.event, &report, &err));
    run(m, &p, &e, &tables, &volume.geometry, true, &report);
    for (int64_t c = 0; c < grid->count; c++) {
        if (p.slots[c] == OST_CL_NONE)
            continue;
        const ost_chunk *chunk = &grid->chunks[c];
        for (size_t i = 0; i < p.voxels; i++) {
            const int16_t want = chunk->density ? chunk->density[i] : 0, found = p.density[p.slots[c] * p.voxels + i];
            const uint32_t bit = p.words[(p.slots[c] * p.voxels + i) / 32] >> (i % 32) & 1;
            if (want != found || bit != (want != 0))
                fail_msg("%s: voxel %zu of chunk %d is %d, occupancy %u; the reference has %d", m->name, i, (int)c,
                         found, bit, want);
        }
    }
    assert_ok(ost_bone_remove(bone, tool, &scene.event, &report, &err));
    run(m, &p, &e, &tables, &volume.geometry, true, &report);

    ost_removal_report_free(&report);
    plan_free(&e);
    pool_free(&p);
    tables_free(&tables);
    free(voxels);
    ost_tool_free(tool);
    ost_bone_free(bone);
    ost_tool_volume_free(&volume);
}

void compare_removal(machine *m, test_rng *rng, int rounds)
{
    ost_backend *ref;
    assert_int_equal(ost_backend_open("ref", &ref, NULL), OST_OK);
    for (int i = 0; i < rounds; i++)
        removal_round(m, rng, ref);
    ost_backend_close(ref);
}
