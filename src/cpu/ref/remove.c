/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Removal and collision (thesis, Alg. 2.10 and section 3.2.1; AR-MAP, AR-REM).
 *
 *   for each chunk with memory, ascending
 *     for each aligned block of 16^3 voxels in it
 *       for each pose whose box overlaps the block     marks the voxels that the tool covers
 *         base of the block
 *         for each active voxel: u = base + i step[0] + j step[1] + k step[2]
 *                                inside iff 0 <= u >> 20 < dims on every axis
 *       for each marked voxel: count it, and for a removal, remove it
 *
 * A voxel is removed if at least one pose covers it with a cutting tool voxel. It is
 * removed and counted once, even if several poses cover it.  The only difference between
 * removal and collision is that a collision does not change the bone.
 */
#include "cpu/ref/ref.h"

#include <stdlib.h>
#include <string.h>

#include "core/conditions.h"

enum { BLOCK = OST_MAP_BLOCK };

/*
 * For each bone voxel of a block, the class (OST_TOOL_*) of the tool voxel that covers it. If several poses cover the
 * bone voxel, the cutting class has priority.
 */
typedef struct block_marks {
    uint8_t mark[BLOCK][BLOCK][BLOCK]; /* [z][y][x] */
    bool any;
} block_marks;

static uint8_t tool_at(const ref_tool *tool, int32_t ux, int32_t uy, int32_t uz)
{
    const ost_dims dims = tool->base.geometry.dims;
    const int32_t x = ux >> OST_MAP_FRACTION, y = uy >> OST_MAP_FRACTION, z = uz >> OST_MAP_FRACTION;
    if ((uint32_t)x >= (uint32_t)dims.x || (uint32_t)y >= (uint32_t)dims.y || (uint32_t)z >= (uint32_t)dims.z)
        return OST_TOOL_VOID;
    return tool->voxels[x + (int64_t)dims.x * (y + (int64_t)dims.y * z)];
}

static int32_t min32(int32_t a, int32_t b)
{
    return a < b ? a : b;
}

static int32_t max32(int32_t a, int32_t b)
{
    return a > b ? a : b;
}

/*
 * Returns true if all corners of a block lie on the same side of the tool's grid on one axis. All voxels of the block
 * then lie on that side, because their tool coordinate u is a linear function of the voxel's indices. The least and the
 * greatest u of a block occur at corners of the block, so they fit in int32 (AR-MAP-5).
 */
static bool block_misses(const ost_dims dims, const int32_t base[3], const int32_t step[3][3])
{
    const int32_t end[3] = {dims.x << OST_MAP_FRACTION, dims.y << OST_MAP_FRACTION, dims.z << OST_MAP_FRACTION};
    for (int a = 0; a < 3; a++) {
        int32_t least = base[a], greatest = base[a];
        for (int b = 0; b < 3; b++) {
            least += min32((BLOCK - 1) * step[b][a], 0);
            greatest += max32((BLOCK - 1) * step[b][a], 0);
        }
        if (greatest < 0 || least >= end[a])
            return true;
    }
    return false;
}

/*
 * Returns true if both ends of a row lie on the same side of the tool's grid. The entire row then lies on that side,
 * because the tool coordinate u is a linear function of the voxel's index.
 */
static bool row_misses(const ost_dims dims, const int32_t u[3], const int32_t step[3])
{
    const int32_t end[3] = {dims.x << OST_MAP_FRACTION, dims.y << OST_MAP_FRACTION, dims.z << OST_MAP_FRACTION};
    bool misses = false;
    for (int a = 0; a < 3; a++) {
        const int32_t last = u[a] + (BLOCK - 1) * step[a];
        misses |= (u[a] < 0 && last < 0) || (u[a] >= end[a] && last >= end[a]);
    }
    return misses;
}

/* Returns the part of the box that lies in the grid, so that no block whose first voxel lies outside the grid is
   evaluated. */
static ost_voxel_box clipped(const ost_voxel_box *box, ost_dims dims)
{
    return (ost_voxel_box){
        .lo = {max32(box->lo[0], 0), max32(box->lo[1], 0), max32(box->lo[2], 0)},
        .hi = {min32(box->hi[0], dims.x), min32(box->hi[1], dims.y), min32(box->hi[2], dims.z)},
    };
}

/*
 * Marks the voxels of one block that the tool covers at one pose. `first` is the block's first voxel. All
 * sums fit in int32 (AR-MAP-5).
 */
static void mark_pose(const ost_chunk_grid *grid, const ost_chunk *chunk, const int32_t first[3], const ref_tool *tool,
                      const ost_map *map, const ost_voxel_box *all, block_marks *marks)
{
    const ost_voxel_box box = clipped(all, grid->dims);
    int32_t lo[3], hi[3], base[3];
    for (int a = 0; a < 3; a++) {
        lo[a] = max32(box.lo[a] - first[a], 0);
        hi[a] = min32(box.hi[a] - first[a], BLOCK);
        if (lo[a] >= hi[a])
            return;
    }
    if (!ost_map_block_base(map, (ost_dims){first[0] / BLOCK, first[1] / BLOCK, first[2] / BLOCK}, base) ||
        block_misses(tool->base.geometry.dims, base, map->step))
        return;
    const int32_t n = grid->size, *step = map->step[0];
    const int32_t x = first[0] % n, y = first[1] % n, z = first[2] % n;
    for (int32_t k = lo[2]; k < hi[2]; k++)
        for (int32_t j = lo[1]; j < hi[1]; j++) {
            /*
             * A row of a block has 16 bits and begins at a multiple of 16 bits, so it lies in one 32-bit word of the
             * occupancy.
             */
            const uint32_t v = (uint32_t)(x + n * ((y + j) + n * (z + k)));
            const uint32_t active = chunk->occupancy[v / 32] >> (v % 32) & 0xffff;
            int32_t u[3];
            if (!active)
                continue;
            for (int a = 0; a < 3; a++)
                u[a] = base[a] + j * map->step[1][a] + k * map->step[2][a];
            if (row_misses(tool->base.geometry.dims, u, step))
                continue;
            for (int32_t i = lo[0]; i < hi[0]; i++) {
                if (!(active >> i & 1) || marks->mark[k][j][i] == OST_TOOL_CUTTING)
                    continue;
                const uint8_t found = tool_at(tool, u[0] + i * step[0], u[1] + i * step[1], u[2] + i * step[2]);
                if (found == OST_TOOL_VOID)
                    continue;
                marks->mark[k][j][i] = found;
                marks->any = true;
            }
        }
}

/*
 * Returns the density class of a density (AR-CLS): the last class whose border is not above the density,
 * or class 0 if the density is below all borders.
 */
static int class_of(const ost_density_classes *classes, int16_t density)
{
    int c = classes->count - 1;
    while (c > 0 && density < classes->border[c])
        c--;
    return c;
}

static void take_marks(const ost_chunk_grid *grid, ost_chunk *chunk, const int32_t first[3], const block_marks *marks,
                       const ost_density_classes *classes, bool apply, ost_chunk_report *report, uint64_t *touched)
{
    int32_t n = grid->size;
    for (int32_t k = 0; k < BLOCK; k++)
        for (int32_t j = 0; j < BLOCK; j++)
            for (int32_t i = 0; i < BLOCK; i++) {
                uint8_t mark = marks->mark[k][j][i];
                if (mark == OST_TOOL_VOID)
                    continue;
                if (mark != OST_TOOL_CUTTING) {
                    ++*touched;
                    continue;
                }
                int32_t v = (first[0] % n + i) + n * ((first[1] % n + j) + n * (first[2] % n + k));
                int c = class_of(classes, chunk->density[v]);
                report->voxels[c]++;
                report->density[c] += chunk->density[v];
                if (apply) {
                    chunk->density[v] = 0;
                    chunk->occupancy[v / 32] &= ~(UINT32_C(1) << (v % 32));
                    chunk->active--;
                }
            }
}

/* Applies the event to one chunk and adds the results to *report. On entry, *report contains the chunk's index and
   is otherwise zero. */
static void run_chunk(const ost_chunk_grid *grid, ost_chunk *chunk, const int32_t corner[3], const ref_tool *tool,
                      const ost_removal_event *event, bool apply, ost_chunk_report *report, uint64_t *touched)
{
    for (int32_t z = 0; z < grid->size; z += BLOCK)
        for (int32_t y = 0; y < grid->size; y += BLOCK)
            for (int32_t x = 0; x < grid->size; x += BLOCK) {
                const int32_t first[3] = {corner[0] + x, corner[1] + y, corner[2] + z};
                block_marks marks;
                memset(&marks, 0, sizeof marks);
                for (int p = 0; p < event->pose_count; p++)
                    mark_pose(grid, chunk, first, tool, &event->maps[p], &event->boxes[p], &marks);
                if (marks.any)
                    take_marks(grid, chunk, first, &marks, event->classes, apply, report, touched);
            }
}

/* Computes the half-open range of chunks that contains the boxes of all poses. lo > hi if all boxes are empty. */
static void chunk_range(const ost_chunk_grid *grid, const ost_removal_event *event, int32_t lo[3], int32_t hi[3])
{
    for (int a = 0; a < 3; a++) {
        lo[a] = INT32_MAX;
        hi[a] = 0;
    }
    for (int p = 0; p < event->pose_count; p++) {
        const ost_voxel_box box = clipped(&event->boxes[p], grid->dims);
        if (box.lo[0] >= box.hi[0] || box.lo[1] >= box.hi[1] || box.lo[2] >= box.hi[2])
            continue;
        for (int a = 0; a < 3; a++) {
            lo[a] = min32(lo[a], box.lo[a] / grid->size);
            hi[a] = max32(hi[a], (box.hi[a] - 1) / grid->size + 1);
        }
    }
}

/*
 * Reserves memory in the report for every chunk of the range, so that no allocation can fail after the
 * first voxel has been removed.
 */
static ost_status reserve(ost_removal_report *report, const ost_chunk_grid *grid, const int32_t lo[3],
                          const int32_t hi[3], ost_error *err)
{
    size_t needed = report->count;
    for (int32_t z = lo[2]; z < hi[2]; z++)
        for (int32_t y = lo[1]; y < hi[1]; y++)
            for (int32_t x = lo[0]; x < hi[0]; x++)
                needed += grid->chunks[x + grid->chunk_dims.x * (y + (int64_t)grid->chunk_dims.y * z)].active > 0;
    if (needed <= report->capacity)
        return OST_OK;
    ost_chunk_report *grown = realloc(report->chunks, needed * sizeof *grown);
    if (!grown)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a report of %zu chunks", needed);
    report->chunks = grown;
    report->capacity = needed;
    return OST_OK;
}

static ost_status run_event(const ost_chunk_grid *grid, const ref_tool *tool, const ost_removal_event *event,
                            bool apply, ost_removal_report *report, ost_error *err)
{
    int32_t lo[3], hi[3];
    chunk_range(grid, event, lo, hi);
    ost_status status = reserve(report, grid, lo, hi, err);
    for (int32_t z = lo[2]; z < hi[2] && status == OST_OK; z++)
        for (int32_t y = lo[1]; y < hi[1] && status == OST_OK; y++)
            for (int32_t x = lo[0]; x < hi[0] && status == OST_OK; x++) {
                int32_t index = x + grid->chunk_dims.x * (y + grid->chunk_dims.y * z);
                ost_chunk *chunk = &grid->chunks[index];
                if (chunk->active == 0)
                    continue;
                const int32_t corner[3] = {x * grid->size, y * grid->size, z * grid->size};
                ost_chunk_report part = {.chunk = index};
                run_chunk(grid, chunk, corner, tool, event, apply, &part, &report->touched_voxels);
                bool hit = false;
                for (int c = 0; c < OST_CLASS_MAX; c++)
                    hit = hit || part.voxels[c] > 0;
                if (hit)
                    status = ost_removal_report_add(report, &part, err);
                if (chunk->active == 0)
                    ost_chunk_release(chunk);
            }
    return status;
}

ost_status ost_ref_remove(ost_bone *bone, const ost_tool *tool, const ost_removal_event *event,
                          ost_removal_report *report, ost_error *err)
{
    return run_event(&((ref_bone *)bone)->chunks, (const ref_tool *)tool, event, true, report, err);
}

ost_status ost_ref_collide(const ost_bone *bone, const ost_tool *tool, const ost_removal_event *event,
                           ost_removal_report *report, ost_error *err)
{
    return run_event(&((const ref_bone *)bone)->chunks, (const ref_tool *)tool, event, false, report, err);
}
