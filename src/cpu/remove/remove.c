/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Removal and collision (AR-REM). The results are the same as those of the reference. Cubes are
 * classified by distances to the tool's surface before single voxels are tested (remove.h).
 *
 *   for each pose
 *     for each chunk with memory in its box          divided among threads
 *       for each unit of up to 32^3 voxels
 *         blocks of 16^3 in the box and in reach     bases of blocks: block_base.h
 *         split: 8^3 cubes inside, mixed             cubes outside are dropped
 *         split: bricks inside, mixed                bricks without active voxels are dropped
 *         match: the hits of mixed bricks
 *         hits &= active voxels, which become inactive
 *         take: densities are added to the tally and set to 0
 *   reports in the order of chunks
 *
 * Poses are processed in order. A voxel that a pose hits becomes inactive for the
 * later poses, so that it is counted once, even if several poses hit it. A collision
 * makes voxels inactive only in copies of the occupancy, and does not change densities.
 *
 * Touched voxels (AR-REM-1) are the voxels that are still active after all poses and
 * that at least one pose covers with a tool voxel of class 2. A second pass, with the
 * shape of class 2, counts the touched voxels on copies of the remaining occupancy.
 *
 * Kernels process complete cubes of a unit, so they also test voxels outside a pose's box, which the reference does not
 * test. If a cube lies partly outside the box, its hits are clipped to the box. Therefore the results are the same as
 * those of the reference even if a box does not contain all voxels that the tool covers.
 */
#include "cpu/remove/event.h"

#include <stdlib.h>
#include <string.h>

#include "core/conditions.h"
#include "cpu/cpu.h"
#include "cpu/tool.h"

enum { BLOCK = OST_MAP_BLOCK };

static int32_t min32(int32_t a, int32_t b)
{
    return a < b ? a : b;
}

static int32_t max32(int32_t a, int32_t b)
{
    return a > b ? a : b;
}

/* ------------------------------------------------------------- boxes */

static bool clip_box(const ost_voxel_box *box, ost_dims dims, ost_voxel_box *out)
{
    const int32_t d[3] = {dims.x, dims.y, dims.z};
    bool any = true;
    for (int a = 0; a < 3; a++) {
        out->lo[a] = max32(box->lo[a], 0);
        out->hi[a] = min32(box->hi[a], d[a]);
        any = any && out->lo[a] < out->hi[a];
    }
    return any;
}

static int32_t within(int32_t v, int32_t lo, int32_t hi)
{
    return min32(max32(v, lo), hi);
}

/* Returns the set of the unit's cubes of 8^3 voxels that lie entirely in the box. Bit i of the set is for cube number
   i (0..63). */
static uint64_t cubes_within(const int32_t unit[3], const ost_voxel_box *box)
{
    enum { CUBES = OST_UNIT / 8 };
    /*
     * below[a][i] is the set of the cubes whose index along axis a is below i. The low bit of a cube's
     * index along axis a is bit a of the cube's number, and the high bit of the index is bit a + 3.
     */
    static const uint64_t below[3][CUBES + 1] = {
        {0, UINT64_C(0x0055005500550055), UINT64_C(0x00ff00ff00ff00ff), UINT64_C(0x55ff55ff55ff55ff), ~UINT64_C(0)},
        {0, UINT64_C(0x0000333300003333), UINT64_C(0x0000ffff0000ffff), UINT64_C(0x3333ffff3333ffff), ~UINT64_C(0)},
        {0, UINT64_C(0x000000000f0f0f0f), UINT64_C(0x00000000ffffffff), UINT64_C(0x0f0f0f0fffffffff), ~UINT64_C(0)},
    };
    uint64_t cubes = ~UINT64_C(0);
    for (int a = 0; a < 3; a++) {
        const int32_t from = (within(box->lo[a] - unit[a], 0, OST_UNIT) + 7) / 8,
                      to = within(box->hi[a] - unit[a], 0, OST_UNIT) / 8;
        cubes &= below[a][to] & ~below[a][from];
    }
    return cubes;
}

/* Returns the set of the cubes in the lists `mixed` and `inside` that do not lie entirely in the box. A cube has 8^3
   voxels. */
static uint64_t cubes_across(const int32_t unit[3], const ost_cubes *mixed, const ost_numbers *inside,
                             const ost_voxel_box *box)
{
    const uint64_t beyond = ~cubes_within(unit, box);
    uint64_t met = 0;
    if (beyond == 0)
        return 0;
    for (size_t i = 0; i < mixed->count; i++)
        met |= UINT64_C(1) << mixed->number[i];
    for (size_t i = 0; i < inside->count; i++)
        met |= UINT64_C(1) << inside->number[i];
    return met & beyond;
}

/*
 * Returns the set of those voxels of a brick that lie in the box. `across` is the set of the cubes that do not lie
 * entirely in the box; if the brick's cube is not in `across`, all 64 voxels lie in the box.
 */
static inline uint64_t brick_within(const int32_t unit[3], int32_t number, const ost_voxel_box *box, uint64_t across)
{
    if (!(across >> (number >> 3) & 1))
        return ~UINT64_C(0);
    static const uint64_t first[3] = {UINT64_C(0x1111111111111111), UINT64_C(0x000f000f000f000f), UINT64_C(0xffff)};
    uint64_t mask = ~UINT64_C(0);
    for (int a = 0; a < 3; a++) {
        const int32_t at = unit[a] + OST_BRICK * ost_brick_gather(number >> a);
        uint64_t along = 0;
        for (int32_t i = 0; i < OST_BRICK; i++)
            if (at + i >= box->lo[a] && at + i < box->hi[a])
                along |= first[a] << (i << (2 * a));
        mask &= along;
    }
    return mask;
}

/* ---------------------------------------------------------------- a unit */

/* The bricks of a unit that have hits. For each of these bricks, hits[] contains the set of voxels that are hit. */
typedef struct hit_list {
    int32_t number[OST_UNIT_BRICKS];
    uint64_t hits[OST_UNIT_BRICKS];
    size_t count;
} hit_list;

/*
 * Clears the occupancy bits of the voxels of a brick that are in the set `hits`. If some of these voxels were active,
 * appends the brick with these active voxels to the list.
 */
static inline void add_hits(hit_list *list, uint64_t *occupancy, int32_t number, uint64_t hits)
{
    const uint64_t active = occupancy[number], hit = active & hits;
    occupancy[number] = active ^ hit;
    list->number[list->count] = number;
    list->hits[list->count] = hit;
    list->count += hit != 0;
}

/*
 * Lists the blocks of the unit that overlap the box and that can have voxels in the tool's grid. The plan must contain
 * the bases of all blocks that overlap the box.
 */
static void collect_blocks(const ost_cpu_kernels *kernels, const ost_pose_plan *plan, const int32_t unit[3],
                           int32_t edge, ost_cubes *blocks)
{
    const ost_block_bases *bases = &plan->bases;
    int32_t from[3], to[3], first[3];
    for (int a = 0; a < 3; a++) {
        first[a] = (int32_t)((uint32_t)unit[a] / BLOCK);
        from[a] = max32(first[a], bases->lo[a]);
        to[a] = min32(first[a] + edge / BLOCK, bases->lo[a] + bases->count[a]);
    }
    kernels->blocks(bases, &plan->reach, first, from, to, blocks);
}

/* Lists the hits of a unit and clears the occupancy bits of the voxels that are hit. The hits are in mixed bricks, in
   bricks that are inside the tool, and in cubes that are inside the tool. */
static inline __attribute__((always_inline)) void apply_hits(hit_list *list, uint64_t *occupancy,
                                                             const ost_cubes *bricks, const uint64_t *hits,
                                                             const ost_numbers *inside_bricks,
                                                             const ost_numbers *inside, const int32_t unit[3],
                                                             const ost_voxel_box *box, uint64_t across)
{
    /* In most mixed bricks, no active voxel is hit, so the bricks in which an active voxel is hit are selected
       first. */
    int32_t hit[OST_UNIT_BRICKS + 1];
    size_t n = 0;
    for (size_t i = 0; i < bricks->count; i++) {
        hit[n] = (int32_t)i;
        n += (hits[i] & occupancy[bricks->number[i]]) != 0;
    }
    for (size_t i = 0; i < n; i++)
        add_hits(list, occupancy, bricks->number[hit[i]],
                 hits[hit[i]] & brick_within(unit, bricks->number[hit[i]], box, across));
    for (size_t i = 0; i < inside_bricks->count; i++)
        add_hits(list, occupancy, inside_bricks->number[i], brick_within(unit, inside_bricks->number[i], box, across));
    for (size_t i = 0; i < inside->count; i++)
        for (int32_t part = 8 * inside->number[i]; part < 8 * inside->number[i] + 8; part++)
            if (occupancy[part])
                add_hits(list, occupancy, part, brick_within(unit, part, box, across));
}

static void run_unit(const ost_cpu_kernels *kernels, const ost_pose_plan *plan, const int32_t unit[3], int32_t edge,
                     int16_t *density, uint64_t *occupancy, const ost_take *take, ost_tally *tally)
{
    const ost_cells *cells = &plan->match.shape->cells;
    ost_cubes blocks, cubes, bricks;
    ost_numbers inside, inside_bricks;
    _Alignas(64) uint64_t hits[OST_UNIT_BRICKS + OST_CUBES_SLACK];
    hit_list list;
    list.count = cubes.count = bricks.count = inside.count = inside_bricks.count = 0;

    collect_blocks(kernels, plan, unit, edge, &blocks);
    if (blocks.count == 0)
        return;
    kernels->split(&plan->split[0], cells, &blocks, NULL, &cubes, &inside);
    if (cubes.count + inside.count == 0)
        return;
    const uint64_t across = cubes_across(unit, &cubes, &inside, &plan->box);
    kernels->split(&plan->split[1], cells, &cubes, occupancy, &bricks, &inside_bricks);
    kernels->match(&plan->match, &bricks, hits);

    if (across == 0)
        apply_hits(&list, occupancy, &bricks, hits, &inside_bricks, &inside, unit, &plan->box, 0);
    else
        apply_hits(&list, occupancy, &bricks, hits, &inside_bricks, &inside, unit, &plan->box, across);
    if (list.count > 0)
        kernels->take(take, density, list.number, list.hits, list.count, tally);
}

/* -------------------------------------------------------------- an event */

static void run_chunk(const ost_cpu_kernels *kernels, const ost_pose_plan *plan, int32_t n,
                      const ost_event_chunk *chunk, bool apply, const ost_density_classes *classes, ost_tally *tally)
{
    ost_take take = {.borders = classes ? classes->count - 1 : 0, .highest = chunk->chunk->highest, .apply = apply};
    for (int b = 0; b < take.borders; b++)
        take.border[b] = classes->border[b + 1];
    const int32_t edge = min32(n, OST_UNIT);
    for (int32_t part = 0; part < (n == edge ? 1 : 8); part++) {
        int32_t unit[3];
        bool meets = true;
        for (int a = 0; a < 3; a++) {
            unit[a] = chunk->first[a] + (part >> a & 1) * OST_UNIT;
            meets = meets && unit[a] < plan->box.hi[a] && unit[a] + edge > plan->box.lo[a];
        }
        if (meets)
            run_unit(kernels, plan, unit, edge,
                     chunk->chunk->density + (size_t)part * OST_UNIT_BRICKS * OST_BRICK_VOXELS,
                     chunk->occupancy + (size_t)part * OST_UNIT_BRICKS, &take, tally);
    }
}

/* Computes the range lo <= block < hi of the blocks that overlap a box of voxels. */
static void block_range(const ost_voxel_box *box, int32_t lo[3], int32_t hi[3])
{
    for (int a = 0; a < 3; a++) {
        lo[a] = box->lo[a] / BLOCK;
        hi[a] = (box->hi[a] - 1) / BLOCK + 1;
    }
}

static void plan_pose(const ost_cpu_kernels *kernels, const ost_map *map, const ost_voxel_box *box,
                      const ost_shape *shape, ost_pose_plan *plan)
{
    int32_t lo[3], hi[3];
    block_range(box, lo, hi);
    plan->box = *box;
    plan->reach = ost_block_reach_of(map->step, shape->dims);
    ost_split_make(map->step, 16, &shape->cells, &plan->split[0]);
    ost_split_make(map->step, 8, &shape->cells, &plan->split[1]);
    ost_match_make(map->step, shape, &plan->match);
    if (plan->match.windows || plan->match.wide)
        kernels->match_tables(&plan->match);
    ost_block_bases_make(&plan->bases, map, lo, hi);
}

static void run_listed(const cpu_backend *backend, ost_event_scratch *scratch, int32_t n, size_t i, bool apply,
                       const ost_density_classes *classes)
{
    ost_event_chunk *chunk = &scratch->chunks[i];
    run_chunk(&backend->kernels, &scratch->plan, n, chunk, apply, classes, classes ? &chunk->tally : &chunk->touched);
}

/*
 * Processes the listed chunks with several threads. The function is not called if one thread suffices, because even a
 * parallel region with a single thread ends with a system call, which would occur in every tick.
 */
static void run_shared(const cpu_backend *backend, ost_event_scratch *scratch, int32_t n, bool apply,
                       const ost_density_classes *classes)
{
    ost_team team = ost_team_of(backend->sharing, backend->threads, OST_PATH_REMOVAL, INT64_MAX,
                                (int64_t)scratch->count, 4);
#pragma omp parallel num_threads(team.threads)
    {
        ost_member me = ost_team_join(&team);
        for (int64_t i; (i = ost_team_next(&team, &me)) >= 0;)
            run_listed(backend, scratch, n, (size_t)i, apply, classes);
    }
    ost_team_end(backend->sharing, &team);
}

/*
 * Applies all poses to all listed chunks. In the pass for touched voxels, `classes` is NULL, because touched
 * voxels are only counted.
 */
static void run_poses(const cpu_bone *bone, const ost_shape *shape, const ost_removal_event *event,
                      ost_event_scratch *scratch, const ost_density_classes *classes, bool apply)
{
    const cpu_backend *backend = (const cpu_backend *)bone->base.backend;
    const int32_t n = bone->base.chunk_size;
    const int64_t voxels = (int64_t)scratch->count * n * n * n;
    const bool many = backend->threads > 1 && voxels >= backend->sharing->least[OST_PATH_REMOVAL];
    for (int p = 0; p < event->pose_count; p++) {
        ost_voxel_box box;
        if (!clip_box(&event->boxes[p], bone->base.geometry.dims, &box))
            continue;
        plan_pose(&backend->kernels, &event->maps[p], &box, shape, &scratch->plan);
        if (many)
            run_shared(backend, scratch, n, apply, classes);
        else
            for (size_t i = 0; i < scratch->count; i++)
                run_listed(backend, scratch, n, i, apply, classes);
    }
}

/*
 * Initialises an element of the list of chunks. Of its two tallies, only the elements that the kernels change are set
 * to 0, because clearing both tallies of every chunk would take 4 % of the time of a tick.
 */
static void list_chunk(ost_event_chunk *out, int32_t index, const int32_t first[3], cpu_chunk *chunk, int classes)
{
    out->index = index;
    memcpy(out->first, first, sizeof out->first);
    out->chunk = chunk;
    out->occupancy = chunk->occupancy;
    for (int c = 0; c < classes; c++)
        out->tally.voxels[c] = out->tally.density[c] = 0;
    out->touched.voxels[0] = out->touched.density[0] = 0;
}

/*
 * Lists, in ascending order, the chunks that have memory and overlap the bounding box of all poses' boxes. Reserves
 * memory for the tables of bases: on each axis, for the greatest number of blocks that a single box overlaps.
 */
static ost_status list_chunks(const cpu_bone *bone, const ost_removal_event *event, ost_event_scratch *scratch,
                              ost_error *err)
{
    const int32_t n = bone->base.chunk_size;
    int32_t lo[3] = {INT32_MAX, INT32_MAX, INT32_MAX}, hi[3] = {0, 0, 0}, blocks[3] = {0, 0, 0}, begin[3], end[3];
    for (int p = 0; p < event->pose_count; p++) {
        ost_voxel_box box;
        if (!clip_box(&event->boxes[p], bone->base.geometry.dims, &box))
            continue;
        block_range(&box, begin, end);
        for (int a = 0; a < 3; a++) {
            blocks[a] = max32(blocks[a], end[a] - begin[a]);
            lo[a] = min32(lo[a], box.lo[a] / n);
            hi[a] = max32(hi[a], (box.hi[a] - 1) / n + 1);
        }
    }
    scratch->count = 0;
    for (int32_t z = lo[2]; z < hi[2]; z++)
        for (int32_t y = lo[1]; y < hi[1]; y++)
            for (int32_t x = lo[0]; x < hi[0]; x++) {
                const int32_t index = x + bone->chunk_dims.x * (y + bone->chunk_dims.y * z);
                cpu_chunk *chunk = &bone->chunks[index];
                if (chunk->active == 0)
                    continue;
                if (scratch->count == scratch->capacity) {
                    const size_t capacity = scratch->capacity ? 2 * scratch->capacity : 64;
                    ost_event_chunk *grown = realloc(scratch->chunks, capacity * sizeof *grown);
                    if (!grown)
                        return ost_fail(err, OST_ERR_MEMORY, "out of memory for an event of %zu chunks", capacity);
                    scratch->chunks = grown;
                    scratch->capacity = capacity;
                }
                const int32_t first[3] = {x * n, y * n, z * n};
                list_chunk(&scratch->chunks[scratch->count++], index, first, chunk, event->classes->count);
            }
    return ost_block_bases_reserve(&scratch->plan.bases, blocks, err);
}

/*
 * Reserves memory in the report for every listed chunk, so that no allocation can fail after the first
 * voxel has been removed.
 */
static ost_status reserve(ost_removal_report *report, size_t needed, ost_error *err)
{
    if (needed <= report->capacity)
        return OST_OK;
    ost_chunk_report *grown = realloc(report->chunks, needed * sizeof *grown);
    if (!grown)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a report of %zu chunks", needed);
    report->chunks = grown;
    report->capacity = needed;
    return OST_OK;
}

static size_t words(const cpu_bone *bone)
{
    const size_t n = (size_t)bone->base.chunk_size;
    return n * n * n / 64;
}

static ost_status reserve_copies(const cpu_bone *bone, ost_event_scratch *scratch, ost_error *err)
{
    const size_t needed = scratch->count * words(bone);
    if (needed <= scratch->copy_capacity)
        return OST_OK;
    uint64_t *copies = realloc(scratch->copies, needed * sizeof *copies);
    if (!copies)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a copy of the occupancy of %zu chunks",
                        scratch->count);
    scratch->copies = copies;
    scratch->copy_capacity = needed;
    return OST_OK;
}

/* Copies the occupancy of the listed chunks. Afterwards, the elements of the list point to the copies. */
static void copy_occupancy(const cpu_bone *bone, ost_event_scratch *scratch)
{
    for (size_t i = 0; i < scratch->count; i++) {
        uint64_t *copy = scratch->copies + i * words(bone);
        memcpy(copy, scratch->chunks[i].occupancy, words(bone) * sizeof *copy);
        scratch->chunks[i].occupancy = copy;
    }
}

/*
 * Adds a chunk to the report. For each class border, the chunk's tally counts all densities that are not below the
 * border. The report counts each density class separately, so its values are differences between values of the tally.
 */
static ost_status report_chunk(const ost_event_chunk *chunk, const ost_density_classes *classes,
                               ost_removal_report *report, ost_error *err)
{
    if (chunk->tally.voxels[0] == 0)
        return OST_OK;
    ost_chunk_report part = {.chunk = chunk->index};
    for (int c = 0; c < classes->count; c++) {
        const bool last = c == classes->count - 1;
        part.voxels[c] = (uint32_t)(chunk->tally.voxels[c] - (last ? 0 : chunk->tally.voxels[c + 1]));
        part.density[c] = (int64_t)(chunk->tally.density[c] - (last ? 0 : chunk->tally.density[c + 1]));
    }
    return ost_removal_report_add(report, &part, err);
}

static ost_status run_event(const cpu_bone *bone, const cpu_tool *tool, const ost_removal_event *event, bool apply,
                            ost_removal_report *report, ost_error *err)
{
    ost_event_scratch *scratch = &((cpu_backend *)bone->base.backend)->event;
    const cpu_shapes *shapes = tool->shapes;
    ost_status status = ost_cpu_tool_prepare(tool, bone->base.geometry.spacing.x, err);
    if (status == OST_OK)
        status = list_chunks(bone, event, scratch, err);
    if (status == OST_OK)
        status = reserve(report, scratch->count, err);
    if (status == OST_OK && (!apply || tool->noncutting))
        status = reserve_copies(bone, scratch, err);
    if (status != OST_OK)
        return status;
    if (!apply)
        copy_occupancy(bone, scratch);
    run_poses(bone, &shapes->cutting, event, scratch, event->classes, apply);
    if (tool->noncutting) {
        if (apply)
            copy_occupancy(bone, scratch);
        run_poses(bone, &shapes->touching, event, scratch, NULL, false);
    }
    for (size_t i = 0; i < scratch->count && status == OST_OK; i++) {
        ost_event_chunk *chunk = &scratch->chunks[i];
        status = report_chunk(chunk, event->classes, report, err);
        report->touched_voxels += chunk->touched.voxels[0];
        if (!apply)
            continue;
        chunk->chunk->active -= (int32_t)chunk->tally.voxels[0];
        if (chunk->chunk->active == 0)
            ost_cpu_chunk_release(chunk->chunk);
    }
    return status;
}

ost_status ost_cpu_remove(ost_bone *bone, const ost_tool *tool, const ost_removal_event *event,
                          ost_removal_report *report, ost_error *err)
{
    return run_event((const cpu_bone *)bone, (const cpu_tool *)tool, event, true, report, err);
}

ost_status ost_cpu_collide(const ost_bone *bone, const ost_tool *tool, const ost_removal_event *event,
                           ost_removal_report *report, ost_error *err)
{
    return run_event((const cpu_bone *)bone, (const cpu_tool *)tool, event, false, report, err);
}

void ost_event_scratch_free(ost_event_scratch *scratch)
{
    ost_block_bases_free(&scratch->plan.bases);
    free(scratch->chunks);
    free(scratch->copies);
    *scratch = (ost_event_scratch){0};
}
