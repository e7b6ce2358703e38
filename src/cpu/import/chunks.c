/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Converts a cubic grid to chunks (AR-CHK). The chunks are computed directly from rows of
 * the rect grid; the resampled grid is never stored.
 *
 *   a task: the row of chunks at one (y, z) of the chunk grid
 *
 *     for every layer of bricks    four slices, from up to eight source slices
 *       for every source slice     the columns of chunks with an active voxel in the slice are found
 *       for every chunk            the chunk is skipped if it has had no active voxel so far
 *         for every four rows      these rows of the four slices are written as a row of bricks
 *
 * Memory for a chunk is allocated at its first layer with an active voxel, and zeros are then written to its earlier
 * layers. A chunk without an active voxel is therefore never written. A source row is read from memory once, and
 * afterwards from the nearest cache. Tasks write to disjoint chunks.
 *
 * Interpolated rows are computed sixteen at a time, just before they are written. A
 * weighted mean is never greater than the greatest of its voxels. Therefore a layer
 * whose source rows have no active voxel has no active voxel either, and is not
 * interpolated.
 */
#include "core/conditions.h"

#include <stdlib.h>
#include <string.h>

#include "core/chunk_grid.h"
#include "cpu/bone/bone.h"
#include "cpu/import/grid.h"
#include "cpu/import/import.h"

enum { N_MAX = OST_ROW_STRIDE, PART_MIN = 64, COLUMNS_MAX = OST_DIM_MAX / 16, SLICES = 8 };

typedef struct filling {
    const cpu_bone *bone;
    const ost_cpu_kernels *kernels;
    ost_chunk_pool *pool; /* may be NULL */
    cpu_view view;
    bool linear; /* true if voxels are interpolated, that is, if the view has weights */
    /*
     * For each column of chunks, true if the column's source voxels are adjacent along x and the column is not clipped
     * by the grid.
     */
    bool *run;
    bool stream;
} filling;

static const int16_t nothing[N_MAX];

static int32_t min32(int32_t a, int32_t b)
{
    return a < b ? a : b;
}

/*
 * The source rows and source slices of a task and of the task's current layer of bricks. All offsets are in elements.
 * Each slice is given by its offset from view.voxels, and each row by its offset within a slice.
 */
typedef struct task {
    int32_t height;
    cpu_tap y[N_MAX], z[4];
    int slices; /* number of the layer's slices that lie in the grid */
    size_t row[2 * N_MAX]; /* the source rows of the task's rows, in ascending order, without duplicates */
    /* row[] has `rows` elements, of which row[0] to row[first[g] - 1] are the source rows of y[0] to y[4 g - 1]. */
    int rows, first[N_MAX / 4];
    size_t source[SLICES]; /* the source slices of the current layer, in ascending order, without duplicates */
    int sources;
    size_t next_source; /* the slice that is prefetched while the last slice in source[] is read */
    /*
     * box[g] contains the source rows from which y[4 g] to y[4 g + 3] of the layer are interpolated, as offsets from
     * view.voxels. boxes[g] is the number of these rows. Both are set only if the view has weights.
     */
    size_t box[N_MAX / 4][SLICES * SLICES];
    int boxes[N_MAX / 4];
    /*
     * for each column of chunks, 1 plus the offset of the last searched source slice that has an active voxel in the
     * column; 0 if there is none
     */
    size_t last_active[COLUMNS_MAX];
    size_t searched; /* 1 plus the offset of the last source slice that was searched; 0 before the first one */
    /* for each source column x, the greatest density in the task's rows of the slice that is searched */
    _Alignas(64) int16_t greatest[OST_DIM_MAX];
} task;

/* Computes the taps of the layer of bricks that begins at slice z, and lists the layer's source slices. */
static void list_slices(const filling *f, task *t, int32_t z)
{
    const int32_t slices = min32(4, f->bone->base.geometry.dims.z - z);
    t->slices = slices > 0 ? (int)slices : 0;
    t->sources = 0;
    for (int k = 0; k < t->slices; k++) {
        t->z[k] = ost_cpu_view_tap(&f->view, 2, z + k);
        for (int i = 0; i < t->z[k].count; i++)
            if (t->sources == 0 || t->z[k].from[i] > t->source[t->sources - 1])
                t->source[t->sources++] = t->z[k].from[i];
    }
}

/*
 * Returns the source slice to prefetch while the last source slice of the layer at slice z is read: the following
 * slice, but at most the last source slice of the next layer.
 */
static size_t next_source(const filling *f, const task *t, int32_t z)
{
    const cpu_tap tap = ost_cpu_view_tap(&f->view, 2, min32(z + 7, f->bone->base.geometry.dims.z - 1));
    const size_t next = t->source[t->sources - 1] + f->view.slice, last = tap.from[tap.count - 1];
    return next < last ? next : last;
}

static void enter_task(const filling *f, task *t, int32_t y0, int32_t height)
{
    t->height = height;
    t->rows = 0;
    t->searched = 0;
    memset(t->last_active, 0, (size_t)f->bone->chunk_dims.x * sizeof t->last_active[0]);
    for (int32_t y = 0; y < t->height; y++) {
        if (y % 4 == 0)
            t->first[y / 4] = t->rows;
        t->y[y] = ost_cpu_view_tap(&f->view, 1, y0 + y);
        for (int i = 0; i < t->y[y].count; i++)
            if (t->rows == 0 || t->y[y].from[i] > t->row[t->rows - 1])
                t->row[t->rows++] = t->y[y].from[i];
    }
}

static void enter_layer(const filling *f, task *t, int32_t z)
{
    list_slices(f, t, z);
    if (t->sources > 0)
        t->next_source = next_source(f, t, z);
    for (int32_t y = 0; y < t->height && f->linear; y += 4) {
        /* Because the taps ascend, the rows y to y + 3 share at most two source rows with earlier rows. */
        const int begin = t->first[y / 4] > 2 ? t->first[y / 4] - 2 : 0;
        const int end = y + 4 < t->height ? t->first[y / 4 + 1] : t->rows;
        int count = 0;
        for (int i = 0; i < t->sources; i++)
            for (int r = begin; r < end; r++)
                if (t->row[r] >= t->y[y].from[0])
                    t->box[y / 4][count++] = t->source[i] + t->row[r];
        t->boxes[y / 4] = count;
    }
}

/* -------------------------------------------------------- active voxels */

/* Sets greatest[x] to the maximum of greatest[x] and row[x] for each x < n. Prefetches the n elements of `next`. */
static void max_row(const int16_t *restrict row, size_t n, int16_t *restrict greatest, const int16_t *next)
{
    enum { BLOCK = 32 }; /* elements per cache line; constant, so that the compiler vectorizes the loop */
    size_t x = 0;
    for (; x + BLOCK <= n; x += BLOCK) {
        __builtin_prefetch(next + x, 0, 2);
        for (size_t i = x; i < x + BLOCK; i++)
            greatest[i] = row[i] > greatest[i] ? row[i] : greatest[i];
    }
    for (; x < n; x++)
        greatest[x] = row[x] > greatest[x] ? row[x] : greatest[x];
}

/*
 * Finds the source voxels along x from which the voxels x0 to x0 + width - 1 are computed. Sets *first to the first
 * source voxel and returns the number of source voxels.
 */
static int32_t span_of(const filling *f, int32_t x0, int32_t width, int32_t *first)
{
    const int32_t *map = f->view.map[0];
    *first = map ? map[x0] : x0;
    return map ? min32(map[x0 + width - 1] + (f->view.minus[0] ? 2 : 1), (int32_t)f->view.row) - *first : width;
}

/* Returns true if one of the source rows has an active voxel with first <= x < first + span. */
static bool any_in_box(const filling *f, const int16_t *base, const size_t *row, int rows, int32_t first,
                       int32_t span)
{
    const int16_t threshold = (int16_t)f->bone->base.threshold;
    for (int32_t x = 0; x < span; x += N_MAX)
        if (f->kernels->any_active(base + first + x, row, rows, min32(span - x, N_MAX), threshold))
            return true;
    return false;
}

/*
 * Sets greatest[x] to the greatest density of source column x in the task's rows of the layer's source slice i. The
 * rows are read completely and in ascending order, because the processor prefetches ascending addresses. The function
 * itself prefetches the next slice, because the distance to that slice is too great for the processor to prefetch it.
 */
static void find_greatest(const filling *f, task *t, int i)
{
    const size_t width = f->view.row, next = i + 1 < t->sources ? t->source[i + 1] : t->next_source;
    memset(t->greatest, 0, width * sizeof t->greatest[0]);
    for (int r = 0; r < t->rows; r++)
        max_row(f->view.voxels + t->source[i] + t->row[r], width, t->greatest, f->view.voxels + next + t->row[r]);
}

/* Returns true if the slice for which `greatest` was computed has an active voxel in the chunk at x0. */
static bool greatest_is_active(const filling *f, const task *t, bool run, int32_t x0, int32_t width)
{
    static const size_t one_row[1] = {0};
    int16_t gathered[N_MAX];
    int32_t first;
    const int32_t span = span_of(f, x0, width, &first);
    /* Source voxels that are adjacent along x need not be gathered. Without x indices, they are always adjacent, even
       if `run` is false because the chunk is clipped. */
    if (f->linear || run || !f->view.map[0])
        return any_in_box(f, t->greatest, one_row, 1, first, span);
    f->kernels->gather_row(t->greatest, f->view.map[0] + x0, width, gathered);
    return any_in_box(f, gathered, one_row, 1, 0, width);
}

/* Searches for active voxels in the source slices of the current layer that have not been searched yet. */
static void search_slices(const filling *f, task *t)
{
    const int32_t n = f->bone->base.chunk_size, columns = f->bone->chunk_dims.x;
    for (int i = 0; i < t->sources; i++) {
        if (t->source[i] < t->searched)
            continue;
        t->searched = t->source[i] + 1;
        find_greatest(f, t, i);
        for (int32_t cx = 0; cx < columns; cx++)
            if (greatest_is_active(f, t, f->run[cx], cx * n, min32(n, f->bone->base.geometry.dims.x - cx * n)))
                t->last_active[cx] = t->source[i] + 1;
    }
}

/*
 * Interpolates up to four rows, beginning with row y, in each slice of the layer. Returns false and writes no rows if
 * no source voxel is active, because no interpolated voxel is active then.
 */
static bool interpolate(const filling *f, const task *t, int32_t x0, int32_t width, int32_t y,
                        int16_t (*to)[OST_ROW_STRIDE])
{
    const int rows = (int)min32(4, t->height - y);
    if (rows <= 0 || t->slices == 0)
        return false;
    int32_t first;
    const int32_t span = span_of(f, x0, width, &first);
    if (!any_in_box(f, f->view.voxels, t->box[y / 4], t->boxes[y / 4], first, span))
        return false;
    ost_cpu_linear_rows(&f->view, f->kernels, x0, width, t->y + y, rows, t->z, t->slices, to);
    return true;
}

/* Returns true if the current layer of the chunk at x0 has an active voxel after interpolation. */
static bool means_are_active(const filling *f, const task *t, int32_t x0, int32_t width)
{
    static const size_t rows[4] = {0, OST_ROW_STRIDE, 2 * OST_ROW_STRIDE, 3 * OST_ROW_STRIDE};
    _Alignas(64) int16_t made[16][OST_ROW_STRIDE];
    const int16_t threshold = (int16_t)f->bone->base.threshold;
    for (int32_t y = 0; y < t->height; y += 4) {
        const int count = (int)min32(4, t->height - y);
        const int slices = interpolate(f, t, x0, width, y, made) ? t->slices : 0;
        for (int k = 0; k < slices; k++)
            if (f->kernels->any_active(made[4 * k], rows, count, width, threshold))
                return true;
    }
    return false;
}

/*
 * Returns true if the current layer has an active voxel in the chunk at column cx. The function is called for chunks
 * whose memory has not been allocated yet.
 */
static bool layer_is_active(const filling *f, const task *t, int32_t cx, int32_t x0, int32_t width)
{
    return t->sources > 0 && t->last_active[cx] > t->source[0] &&
           (!f->linear || means_are_active(f, t, x0, width));
}

/* ----------------------------------------------------------------- writing */

static void add(cpu_chunk *chunk, ost_brick_sums sums)
{
    chunk->active += sums.active;
    chunk->highest = sums.highest > chunk->highest ? sums.highest : chunk->highest;
}

/* Writes sixteen rows of n voxels to the chunk as a row of bricks. The first of the rows is row (y, z) of the chunk. */
static ost_brick_sums write_rows(const filling *f, const cpu_chunk *chunk, const int16_t *const rows[16], int32_t y,
                                 int32_t z)
{
    const size_t brick = (size_t)ost_brick_number(0, y / 4, z / 4);
    return f->kernels->brick_row(rows, (size_t)f->bone->base.chunk_size / 4, (int16_t)f->bone->base.threshold,
                                 f->stream, chunk->density + brick * OST_BRICK_VOXELS, chunk->occupancy + brick);
}

static void write_void_layer(const filling *f, cpu_chunk *chunk, int32_t z)
{
    const int16_t *rows[16];
    for (int r = 0; r < 16; r++)
        rows[r] = nothing;
    for (int32_t y = 0; y < f->bone->base.chunk_size; y += 4)
        add(chunk, write_rows(f, chunk, rows, y, z));
}

/*
 * Finds the sixteen rows of n voxels from which a row of bricks is built. A row that the store contains unchanged is
 * used without a copy; any other row is computed in `spare`.
 */
static void find_rows(const filling *f, const task *t, int32_t x0, int32_t width, bool run, int32_t y,
                      int16_t (*spare)[OST_ROW_STRIDE], const int16_t *rows[16])
{
    const int32_t n = f->bone->base.chunk_size, *map = f->view.map[0];
    const bool made = f->linear && interpolate(f, t, x0, width, y, spare);
    for (int r = 0; r < 16; r++) {
        const bool there = r / 4 < t->slices && y + r % 4 < t->height && (made || !f->linear);
        if (!there) {
            rows[r] = nothing;
            continue;
        }
        const int16_t *const row = f->view.voxels + t->z[r / 4].from[0] + t->y[y + r % 4].from[0];
        rows[r] = run && !f->linear ? row + (map ? map[x0] : x0) : spare[r];
        if (rows[r] != spare[r])
            continue;
        if (!f->linear && map)
            f->kernels->gather_row(row, map + x0, width, spare[r]);
        else if (!f->linear)
            memcpy(spare[r], row + x0, (size_t)width * sizeof spare[r][0]);
        if (width < n)
            memset(spare[r] + width, 0, (size_t)(n - width) * sizeof spare[r][0]);
    }
}

static void write_layer(const filling *f, cpu_chunk *chunk, const task *t, int32_t x0, int32_t width, bool run,
                        int32_t z)
{
    _Alignas(64) int16_t spare[16][OST_ROW_STRIDE];
    for (int32_t y = 0; y < f->bone->base.chunk_size; y += 4) {
        const int16_t *rows[16];
        find_rows(f, t, x0, width, run, y, spare, rows);
        add(chunk, write_rows(f, chunk, rows, y, z));
    }
}

/* Fills the chunks of one task, which is the row of chunks at (cy, cz). Returns false if memory is exhausted. */
static bool fill_task(const filling *f, int32_t cy, int32_t cz)
{
    const cpu_bone *bone = f->bone;
    const ost_dims dims = bone->base.geometry.dims;
    const int32_t n = bone->base.chunk_size, columns = bone->chunk_dims.x;
    task t;
    enter_task(f, &t, cy * n, min32(n, dims.y - cy * n));
    cpu_chunk *chunks = bone->chunks + (int64_t)columns * (cy + (int64_t)bone->chunk_dims.y * cz);
    for (int32_t z = 0; z < n; z += 4) {
        enter_layer(f, &t, cz * n + z);
        search_slices(f, &t);
        for (int32_t cx = 0; cx < columns; cx++) {
            const int32_t width = min32(n, dims.x - cx * n);
            if (!chunks[cx].density) {
                if (!layer_is_active(f, &t, cx, cx * n, width))
                    continue;
                if (!ost_cpu_chunk_take(bone, f->pool, &chunks[cx]))
                    return false;
                for (int32_t before = 0; before < z; before += 4)
                    write_void_layer(f, &chunks[cx], before);
            }
            write_layer(f, &chunks[cx], &t, cx * n, width, f->run[cx], z);
        }
    }
    return true;
}

/* Fills the chunk layers c0 <= z < c1 of the chunk grid. Returns false if memory is exhausted. */
static bool fill_layers(const cpu_backend *backend, const filling *f, int32_t c0, int32_t c1)
{
    const ost_dims dims = f->bone->chunk_dims;
    const int32_t tasks = dims.y * (c1 - c0);
    const int64_t voxels = ost_dims_count(f->bone->base.geometry.dims);
    ost_team team = ost_team_of(backend->sharing, backend->threads, OST_PATH_CHUNKS, voxels, tasks, 1);
    int missing = 0;
#pragma omp parallel num_threads(team.threads) if (team.threads > 1) reduction(+ : missing)
    {
        ost_member me = ost_team_join(&team);
        for (int64_t i; (i = ost_team_next(&team, &me)) >= 0;)
            missing += !fill_task(f, (int32_t)i % dims.y, c0 + (int32_t)i / dims.y);
        f->kernels->drain();
    }
    ost_team_end(backend->sharing, &team);
    return missing == 0;
}

static bool mark_runs(filling *f)
{
    const int32_t n = f->bone->base.chunk_size, columns = f->bone->chunk_dims.x, width = f->bone->base.geometry.dims.x;
    const int32_t *map = f->view.map[0];
    f->run = malloc((size_t)columns * sizeof *f->run);
    for (int32_t cx = 0; cx < columns && f->run; cx++) {
        f->run[cx] = width - cx * n >= n;
        for (int32_t x = cx * n + 1; map && x < min32(cx * n + n, width); x++)
            f->run[cx] = f->run[cx] && map[x] == map[x - 1] + 1;
    }
    return f->run != NULL;
}

static ost_chunk_pool *pool_for(cpu_backend *backend, int n)
{
    ost_chunk_pool **pool = &backend->pools[n == 16 ? 0 : n == 32 ? 1 : 2];
    if (!*pool)
        *pool = ost_chunk_pool_open(ost_chunk_bytes(n));
    return *pool;
}

/*
 * Fills the bone in parts of several chunk layers each. Before a part is filled, addresses for all of its chunks are
 * reserved. If the reservation fails, malloc allocates the memory of the chunks.
 */
static bool fill_bone(cpu_backend *backend, filling *f)
{
    const ost_dims dims = f->bone->chunk_dims;
    const int64_t layer = (int64_t)dims.x * dims.y;
    /* maximum number of chunks per part */
    const int64_t least = backend->sharing->least[OST_PATH_LAYERS], most = least > PART_MIN ? least - 1 : PART_MIN;
    const int32_t step = layer < most ? (int32_t)(most / layer) : 1;
    if (step < dims.z)
        ost_cpu_enters(backend->sharing, OST_PATH_LAYERS, INT64_MAX);
    bool enough = mark_runs(f);
    f->stream = ost_cpu_enters(backend->sharing, OST_PATH_CHUNK_STREAM,
                               f->bone->count * (int64_t)ost_chunk_bytes(f->bone->base.chunk_size));
    ost_chunk_pool *pool = pool_for(backend, f->bone->base.chunk_size);
    for (int32_t c = 0; c < dims.z && enough; c += step) {
        int32_t end = min32(c + step, dims.z);
        f->pool = pool && ost_chunk_pool_reserve(pool, layer * (end - c)) ? pool : NULL;
        enough = fill_layers(backend, f, c, end);
    }
    free(f->run);
    if (pool)
        ost_chunk_pool_trim(pool);
    return enough;
}

ost_status ost_cpu_cubic_to_chunks(const ost_grid *base, int chunk_size, int32_t threshold, ost_bone **out,
                                   ost_error *err)
{
    cpu_backend *backend = (cpu_backend *)base->backend;
    ost_bone *bone;
    ost_status status = ost_cpu_bone_create(base->backend, &base->geometry, chunk_size, threshold, &bone, err);
    if (status != OST_OK)
        return status;
    filling f = {
        .bone = (cpu_bone *)bone, .kernels = &backend->kernels, .view = ost_cpu_grid_view((const cpu_grid *)base)};
    f.linear = ost_cpu_view_linear(&f.view);
    if (!fill_bone(backend, &f)) {
        ost_cpu_bone_free(bone);
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for chunks of %zu bytes each",
                        ost_chunk_bytes(chunk_size));
    }
    *out = bone;
    return OST_OK;
}
