/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Divides the work of the voxelizer into tiles for threads, and writes the results.
 * voxelize.h describes the method.
 *
 * Triangles set bits of a tile's two planes at random positions.  Tiles are small
 * enough that the planes and the result bits of a tile stay in a core's L2 cache.  Tiles are as
 * square as possible, so that few triangles cross their borders.  With one thread, a
 * grid that fits in the L2 cache is one tile, and its triangles are not sorted.
 */
#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "core/conditions.h"
#include "core/floats.h"
#include "cpu/voxelize/embree.h"
#include "cpu/tool.h"
#include "cpu/voxelize/voxelize.h"

/* The minimum size in bytes of one plane of a tile, sufficient for one row of any width. */
enum { PLANE_MIN = 1 << 9 };

typedef struct job {
    const cpu_backend *backend;
    const ost_snapped_mesh *mesh[2]; /* the cutting mesh, and the non-cutting mesh or NULL */
    ost_fill_rule rule;
    int threads;
    ost_vox_plan plan;
    ost_vox_bins bins[2];
    ost_embree *embree[2]; /* the Embree scenes that find candidate triangles; NULL if bins are used */
    ost_vox_result result;
    /*
     * True if the fill kernel writes directly to the result. This requires that there is one mesh, that the bits of the
     * other class are not requested, and that rows fill complete blocks.
     */
    bool direct;
} job;

/* Scratch memory of one thread, for one tile at a time. */
typedef struct scratch {
    ost_vox_tile tile;
    uint64_t *bits[2];
    ost_embree_scratch *embree[2];
    size_t plane_words; /* number of 64-bit words of one plane of a tile, including padding */
} scratch;

/*
 * Estimates the time that the work takes on one thread. Additional threads reduce the total time only if this time is
 * at least about a millisecond (docs/log/0.1.md), because starting a thread takes time, and the thread may have to wait
 * for a core that another process uses. The estimate uses times measured on one core at 2.5 GHz: for each mesh, 9 ns
 * per triangle and 25 ns per row (a closed surface crosses a row at least twice or not at all); in addition, 0.03 ns
 * per voxel.
 */
static int64_t estimated_ns(const job *j)
{
    const double rows = (double)j->plan.dims.y * j->plan.dims.z, voxels = rows * j->plan.dims.x;
    double ns = voxels * 0.03;
    for (int m = 0; m < 2; m++)
        ns += j->mesh[m] ? 9.0 * (double)j->mesh[m]->triangle_count + 25.0 * rows : 0;
    return (int64_t)ns;
}

static int32_t floor_log2(int64_t v)
{
    return v < 1 ? 0 : 63 - __builtin_clzll((unsigned long long)v);
}

static int32_t tiles_of(int32_t n, int32_t shift)
{
    return (int32_t)(((int64_t)n + (INT64_C(1) << shift) - 1) >> shift);
}

/*
 * The number of tiles per thread. Several tiles per thread are needed to balance the work, because some
 * tiles contain far more triangles than others.
 */
enum { TILES_A_THREAD = 4 };

static void make_plan(ost_vox_plan *plan, const ost_snapped_mesh *mesh, const ost_cpu_sharing *sharing, int threads)
{
    const int64_t most = (sharing->least[OST_PATH_TILED] - 1) / 2, plane_bytes = most > PLANE_MIN ? most : PLANE_MIN;
    const ost_dims dims = mesh->grid.dims;
    *plan = (ost_vox_plan){
        .dims = dims, .f = mesh->fraction_bits, .words = ost_vox_words(dims.x), .tiles_y = 1, .tiles_z = 1};
    const int64_t row_bytes = 8 * plan->words;
    if (threads == 1 && (int64_t)dims.y * dims.z * row_bytes <= 2 * plane_bytes) {
        plan->shift_y = floor_log2(dims.y) + 1;
        plan->shift_z = floor_log2(dims.z) + 1;
        return;
    }
    int32_t rows = floor_log2(plane_bytes / row_bytes);
    if (threads > 1) {
        const int32_t shared = floor_log2((int64_t)dims.y * dims.z / (TILES_A_THREAD * threads));
        rows = shared < rows ? shared : rows;
    }
    plan->shift_y = (rows + 1) / 2;
    if (plan->shift_y > floor_log2(dims.y))
        plan->shift_y = floor_log2(dims.y);
    plan->shift_z = rows - plan->shift_y;
    if (plan->shift_z > floor_log2(dims.z))
        plan->shift_z = floor_log2(dims.z);
    plan->tiles_y = tiles_of(dims.y, plan->shift_y);
    plan->tiles_z = tiles_of(dims.z, plan->shift_z);
}

static void free_scratch(scratch *d)
{
    free(d->tile.planes);
    free(d->tile.row_state);
    free(d->bits[0]);
    free(d->bits[1]);
    ost_embree_scratch_free(d->embree[0]);
    ost_embree_scratch_free(d->embree[1]);
}

static void *blocks(size_t words)
{
    void *p;
    return posix_memalign(&p, 64, words * 8) == 0 ? p : NULL;
}

static bool make_scratch(scratch *d, const job *j)
{
    const ost_vox_plan *plan = &j->plan;
    const int64_t rows_y = INT64_C(1) << plan->shift_y, rows_z = INT64_C(1) << plan->shift_z;
    const size_t rows = (size_t)(rows_y < plan->dims.y ? rows_y : plan->dims.y) *
                        (size_t)(rows_z < plan->dims.z ? rows_z : plan->dims.z);
    *d = (scratch){.plane_words = (rows * (size_t)plan->words + OST_VOX_BLOCK - 1) / OST_VOX_BLOCK * OST_VOX_BLOCK};
    d->tile = (ost_vox_tile){
        .f = plan->f,
        .nx = plan->dims.x,
        .row_bits = 64 * (uint32_t)plan->words,
        .minus = 64 * (uint32_t)d->plane_words,
        .planes = blocks(2 * d->plane_words),
        .row_state = calloc(rows + OST_VOX_BLOCK, 1),
    };
    d->bits[0] = blocks(d->plane_words);
    d->bits[1] = j->mesh[1] ? blocks(d->plane_words) : NULL;
    if (!d->tile.planes || !d->tile.row_state || !d->bits[0] || (j->mesh[1] && !d->bits[1]))
        return false;
    for (int m = 0; m < 2; m++)
        if (j->embree[m] && !(d->embree[m] = ost_embree_scratch_new(j->embree[m])))
            return false;
    memset(d->tile.planes, 0, 2 * d->plane_words * 8);
    return true;
}

/* Finds the slice that contains row `row` of the tile. Returns the grid's row number of the tile's first row in this
   slice. */
static size_t result_row(const job *j, const ost_vox_tile *tile, size_t row)
{
    const size_t k = (size_t)tile->k0 + row / (size_t)(tile->j1 - tile->j0);
    return k * (size_t)j->plan.dims.y + (size_t)tile->j0;
}

/* Returns true if the lists contain no triangle of mesh m for tile `number`. */
static bool is_void(const job *j, int m, size_t number)
{
    const ost_vox_bins *bins = &j->bins[m];
    return !j->mesh[m] || (bins->start && bins->start[number] == bins->start[number + 1] && bins->large_count == 0);
}

/*
 * Computes the solid bits of mesh m in the current tile. Writes them to the result if j->direct is true, and
 * otherwise to d->bits[m]. Returns the number of solid voxels.
 */
static uint64_t fill_mesh(const job *j, scratch *d, int m, size_t number, uint64_t *leaking_rows)
{
    const ost_cpu_kernels *kernels = &j->backend->kernels;
    const ost_vox_bins *bins = &j->bins[m];
    ost_vox_tile *tile = &d->tile;
    tile->mesh = j->mesh[m];
    if (j->embree[m]) {
        ost_embree_mark(j->embree[m], d->embree[m], tile, kernels->vox_mark);
    } else if (!bins->start) {
        kernels->vox_mark(tile, NULL, tile->mesh->triangle_count);
    } else {
        kernels->vox_mark(tile, bins->list + bins->start[number], bins->start[number + 1] - bins->start[number]);
        kernels->vox_mark(tile, bins->large, bins->large_count);
    }
    uint64_t count = 0;
    const size_t rows = ost_vox_rows(tile), words = (size_t)j->plan.words,
                 run = j->direct ? (size_t)(tile->j1 - tile->j0) : rows;
    for (size_t r = 0; r < rows; r += run) {
        uint64_t *bits = j->direct ? j->result.cutting + result_row(j, tile, r) * words : d->bits[m];
        count += kernels->vox_fill(tile, r, run, bits);
        if (tile->any_unproven && !tile->no_memory)
            count += (uint64_t)ost_vox_fill_unproven(tile, r, run, j->rule, bits, leaking_rows);
    }
    if (tile->any_unproven) { /* otherwise, the kernel has cleared the planes */
        memset(tile->planes, 0, 2 * d->plane_words * 8);
        memset(tile->row_state, 0, rows);
        tile->any_unproven = false;
        free(tile->spill);
        tile->spill = NULL;
    }
    return count;
}

/* Clears the bits of noncutting that are set in cutting. Returns the number of bits that remain set in noncutting. */
static uint64_t subtract(uint64_t *noncutting, const uint64_t *cutting, size_t words)
{
    uint64_t count = 0;
    for (size_t w = 0; w < words; w++) {
        noncutting[w] &= ~cutting[w];
        count += noncutting[w] ? (uint64_t)__builtin_popcountll(noncutting[w]) : 0;
    }
    return count;
}

static void deliver_void(const job *j, const ost_vox_tile *tile)
{
    const size_t run = (size_t)(tile->j1 - tile->j0), words = (size_t)j->plan.words;
    for (size_t r = 0; r < ost_vox_rows(tile); r += run) {
        const size_t row = result_row(j, tile, r);
        memset(j->result.cutting + row * words, 0, run * words * 8);
        if (j->result.noncutting)
            memset(j->result.noncutting + row * words, 0, run * words * 8);
    }
}

/* Writes the rows of a finished tile to all output buffers. */
static void deliver(const job *j, const scratch *d)
{
    const ost_vox_tile *tile = &d->tile;
    const ost_vox_plan *plan = &j->plan;
    const size_t run = (size_t)(tile->j1 - tile->j0), words = (size_t)plan->words;
    for (int32_t k = tile->k0; k < tile->k1; k++) {
        const size_t here = (size_t)(k - tile->k0) * run * words;
        const size_t row = (size_t)k * (size_t)plan->dims.y + (size_t)tile->j0;
        memcpy(j->result.cutting + row * words, d->bits[0] + here, run * words * 8);
        if (j->result.noncutting && j->mesh[1])
            memcpy(j->result.noncutting + row * words, d->bits[1] + here, run * words * 8);
        else if (j->result.noncutting)
            memset(j->result.noncutting + row * words, 0, run * words * 8);
    }
}

static void run_tile(const job *j, scratch *d, size_t number, ost_voxelize_report *report)
{
    const ost_vox_plan *plan = &j->plan;
    const int32_t y = (int32_t)(number % (size_t)plan->tiles_y), z = (int32_t)(number / (size_t)plan->tiles_y);
    ost_vox_tile *tile = &d->tile;
    const int64_t j1 = ((int64_t)y + 1) << plan->shift_y, k1 = ((int64_t)z + 1) << plan->shift_z;
    tile->j0 = y << plan->shift_y;
    tile->k0 = z << plan->shift_z;
    tile->j1 = j1 < plan->dims.y ? (int32_t)j1 : plan->dims.y;
    tile->k1 = k1 < plan->dims.z ? (int32_t)k1 : plan->dims.z;

    if (is_void(j, 0, number) && is_void(j, 1, number)) {
        deliver_void(j, tile);
        return;
    }
    const uint64_t cutting = fill_mesh(j, d, 0, number, &report->leaking_rows);
    uint64_t noncutting = 0;
    if (j->mesh[1]) {
        fill_mesh(j, d, 1, number, &report->leaking_rows);
        noncutting = subtract(d->bits[1], d->bits[0], ost_vox_rows(tile) * (size_t)plan->words);
    }
    report->cutting_voxels += cutting;
    report->solid_voxels += cutting + noncutting;
    if (!j->direct)
        deliver(j, d);
}

static ost_status run_tiles(const job *j, ost_voxelize_report *report, ost_error *err)
{
    const size_t tiles = (size_t)j->plan.tiles_y * (size_t)j->plan.tiles_z;
    ost_cpu_sharing *sharing = j->backend->sharing;
    ost_team team = ost_team_of(sharing, tiles < (size_t)j->threads ? (int)tiles : j->threads, OST_PATH_TILES,
                                INT64_MAX, (int64_t)tiles, 1);
    uint64_t solid = 0, cutting = 0, leaking = 0;
    bool failed = false;
#pragma omp parallel num_threads(team.threads) reduction(+ : solid, cutting, leaking) reduction(|| : failed) \
    if (team.threads > 1)
    {
        const ost_floats caller = ost_floats_enter();
        ost_voxelize_report sums = {0};
        scratch d;
        const bool ready = make_scratch(&d, j);
        ost_member me = ost_team_join(&team);
        for (int64_t t; ready && (t = ost_team_next(&team, &me)) >= 0;)
            run_tile(j, &d, (size_t)t, &sums);
        failed = !ready || d.tile.no_memory;
        free_scratch(&d);
        solid = sums.solid_voxels;
        cutting = sums.cutting_voxels;
        leaking = sums.leaking_rows;
        ost_floats_leave(caller);
    }
    ost_team_end(sharing, &team);
    if (failed)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for tiles of %d x %d rows", 1 << j->plan.shift_y,
                        1 << j->plan.shift_z);
    *report = (ost_voxelize_report){.solid_voxels = solid, .cutting_voxels = cutting, .leaking_rows = leaking};
    return OST_OK;
}

ost_status ost_cpu_voxelize(const cpu_backend *backend, const ost_snapped_mesh *cutting,
                            const ost_snapped_mesh *noncutting, ost_fill_rule rule, ost_voxelize_report *report,
                            const ost_vox_result *result, ost_error *err)
{
    assert(cutting->fraction_bits >= 1 && cutting->fraction_bits <= 10);
    job j = {.backend = backend, .mesh = {cutting, noncutting}, .rule = rule, .result = *result};
    j.plan.dims = cutting->grid.dims;
    j.threads = estimated_ns(&j) < backend->sharing->least[OST_PATH_TILES] ? 1 : backend->threads;
    make_plan(&j.plan, cutting, backend->sharing, j.threads);
    if (j.plan.tiles_y > 1 || j.plan.tiles_z > 1)
        ost_cpu_enters(backend->sharing, OST_PATH_TILED, INT64_MAX);
    j.direct = !noncutting && !result->noncutting && j.plan.words % OST_VOX_BLOCK == 0 &&
               (uintptr_t)result->cutting % 64 == 0;
    ost_status status = OST_OK;
    for (int m = 0; m < 2 && status == OST_OK; m++)
        if (j.mesh[m] && backend->voxelizer == OST_VOXELIZER_EMBREE)
            status = ost_embree_new(j.mesh[m], j.threads, &j.embree[m], err);
        else if (j.mesh[m])
            status = ost_vox_bins_make(&j.bins[m], &j.plan, j.mesh[m], backend, j.threads, err);
    if (status == OST_OK)
        status = run_tiles(&j, report, err);
    for (int m = 0; m < 2; m++) {
        ost_vox_bins_free(&j.bins[m]);
        ost_embree_free(j.embree[m]);
    }
    return status;
}

ost_status ost_cpu_voxelize_tool(ost_backend *base, const ost_snapped_mesh *cutting, const ost_snapped_mesh *noncutting,
                                 ost_fill_rule rule, ost_voxelize_report *report, ost_tool **out, ost_error *err)
{
    const cpu_backend *backend = (const cpu_backend *)base;
    cpu_tool *tool;
    ost_status status = ost_cpu_tool_create(base, &cutting->grid, noncutting != NULL, &tool, err);
    if (status != OST_OK)
        return status;
    const ost_vox_result result = {.cutting = tool->cutting, .noncutting = tool->noncutting};
    status = ost_cpu_voxelize(backend, cutting, noncutting, rule, report, &result, err);
    if (status != OST_OK) {
        ost_cpu_tool_free(&tool->base);
        return status;
    }
    if (report->solid_voxels == report->cutting_voxels) {
        free(tool->noncutting);
        tool->noncutting = NULL;
    }
    *out = &tool->base;
    return OST_OK;
}
