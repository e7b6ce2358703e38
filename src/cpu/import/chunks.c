/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Cubic grid to chunks (AR-CHK), from the rect grid's own rows: a resampled
 * grid is never made.
 *
 *   a task: the chunks of one (y, z) of the chunk grid, side by side
 *
 *     for every layer of bricks    four slices, of which some are the same rows
 *       for every chunk            has one of its rows an active voxel?
 *         for every four rows      sixteen rows into a row of bricks
 *
 * A chunk takes memory at the first layer with an active voxel; the layers
 * before it are void then, and are written as such.  So a source row comes
 * from memory once, from the nearest cache after that, and an empty chunk is
 * never written.  Tasks write to disjoint chunks.
 */
#include "core/conditions.h"

#include <stdlib.h>
#include <string.h>

#include "core/chunk_grid.h"
#include "cpu/bone/bone.h"
#include "cpu/import/grid.h"
#include "cpu/import/import.h"

/* With more result than this the caches cannot keep it anyway. */
#define STREAM_BYTES ((int64_t)8 << 20)

enum { N_MAX = 64, BATCH_CHUNKS = 1 << 14 };

typedef struct filling {
    const cpu_bone *bone;
    const ost_cpu_kernels *kernels;
    ost_chunk_pool *pool; /* may be NULL */
    cpu_view view;
    bool *linear; /* a column of chunks: the x map is a run in it, and all of its width is there */
    bool stream;
} filling;

static const int16_t nothing[N_MAX];

static int32_t min32(int32_t a, int32_t b)
{
    return a < b ? a : b;
}

/* A task's rows. */
typedef struct task {
    int32_t height;
    size_t row[N_MAX];       /* offsets of y in a slice */
    const int16_t *slice[4]; /* of the layer at hand; NULL beyond the grid */
    const int16_t *before;   /* the slice before slice[0] */
    const int16_t *ahead[4]; /* slices of the next layer that this one has not */
    int ahead_count;
    const int16_t *rows[N_MAX / 4][16]; /* of every four y of the layer; NULL beyond the grid */
} task;

static const int16_t *slice_at(const filling *f, int32_t z)
{
    if (z >= f->bone->base.geometry.dims.z)
        return NULL;
    return f->view.voxels + (size_t)(f->view.map[2] ? f->view.map[2][z] : z) * f->view.slice;
}

static void enter_layer(const filling *f, task *t, int32_t z, bool last)
{
    t->before = t->slice[3];
    for (int i = 0; i < 4; i++)
        t->slice[i] = slice_at(f, z + i);
    t->ahead_count = 0;
    for (int i = 0; i < 4 && !last; i++) {
        const int16_t *next = slice_at(f, z + 4 + i), *least = t->ahead_count > 0 ? t->ahead[t->ahead_count - 1] : t->slice[3];
        if (next && next != least)
            t->ahead[t->ahead_count++] = next;
    }
    for (int32_t y = 0; y < f->bone->base.chunk_size; y += 4)
        for (int32_t r = 0; r < 16; r++) {
            bool there = t->slice[r / 4] && y + r % 4 < t->height;
            t->rows[y / 4][r] = there ? t->slice[r / 4] + t->row[y + r % 4] : NULL;
        }
}

/* Whether the layer has an active voxel in the chunk, which has no memory: its slices so far are known to have none. */
static bool layer_is_active(const filling *f, const task *t, int32_t x0, int32_t width, bool linear)
{
    const int32_t *map = f->view.map[0];
    const int16_t threshold = (int16_t)f->bone->base.threshold;
    const int16_t *seen = t->before;
    for (int i = 0; i < 4; i++) {
        const int16_t *slice = t->slice[i];
        if (!slice || slice == seen)
            continue;
        seen = slice;
        if (!map || linear) { /* a narrower chunk without a map is a run as well */
            if (f->kernels->any_active(slice + (map ? map[x0] : x0), t->row, t->height, width, threshold))
                return true;
            continue;
        }
        int16_t gathered[N_MAX];
        static const size_t first = 0;
        for (int32_t y = 0; y < t->height; y++) {
            f->kernels->gather_row(slice + t->row[y], map + x0, width, gathered);
            if (f->kernels->any_active(gathered, &first, 1, width, threshold))
                return true;
        }
    }
    return false;
}

static void add(cpu_chunk *chunk, ost_brick_sums sums)
{
    chunk->active += sums.active;
    chunk->highest = sums.highest > chunk->highest ? sums.highest : chunk->highest;
}

/* Sixteen rows of bricks of the chunk, numbered from y and z, out of rows of n voxels. */
static ost_brick_sums write_rows(const filling *f, const cpu_chunk *chunk, const int16_t *const rows[16], int32_t y, int32_t z)
{
    const size_t brick = (size_t)ost_brick_number(0, y / 4, z / 4);
    return f->kernels->brick_row(rows, (size_t)f->bone->base.chunk_size / 4, (int16_t)f->bone->base.threshold, f->stream,
                                 chunk->density + brick * OST_BRICK_VOXELS, chunk->occupancy + brick);
}

static void write_void_layer(const filling *f, cpu_chunk *chunk, int32_t z)
{
    const int16_t *rows[16];
    for (int r = 0; r < 16; r++)
        rows[r] = nothing;
    for (int32_t y = 0; y < f->bone->base.chunk_size; y += 4)
        add(chunk, write_rows(f, chunk, rows, y, z));
}

/* What the next layer will read from memory comes nearer while this one is written. */
static void prefetch(const task *t, size_t from, int32_t y)
{
    for (int i = 0; i < t->ahead_count; i++)
        for (int32_t j = y; j < y + 4 && j < t->height; j++)
            __builtin_prefetch(t->ahead[i] + t->row[j] + from, 0, 3);
}

static void write_layer(const filling *f, cpu_chunk *chunk, const task *t, int32_t x0, int32_t width, bool linear, int32_t z)
{
    const int32_t n = f->bone->base.chunk_size;
    const int32_t *map = f->view.map[0];
    const size_t from = (size_t)(map ? map[x0] : x0);
    _Alignas(64) int16_t spare[16][N_MAX];
    for (int32_t y = 0; y < n; y += 4) {
        const int16_t *const *base = t->rows[y / 4];
        const int16_t *rows[16];
        prefetch(t, from, y);
        if (linear && base[15]) { /* the last of sixteen is there, so all are */
            for (int r = 0; r < 16; r++)
                rows[r] = base[r] + from;
            add(chunk, write_rows(f, chunk, rows, y, z));
            continue;
        }
        for (int r = 0; r < 16; r++) {
            rows[r] = !base[r] ? nothing : linear ? base[r] + from : spare[r];
            if (rows[r] != spare[r])
                continue;
            if (map)
                f->kernels->gather_row(base[r], map + x0, width, spare[r]);
            else
                memcpy(spare[r], base[r] + x0, (size_t)width * sizeof *spare[r]);
            memset(spare[r] + width, 0, (size_t)(n - width) * sizeof *spare[r]);
        }
        add(chunk, write_rows(f, chunk, rows, y, z));
    }
}

/* False when there is no memory. */
static bool fill_task(const filling *f, int32_t cy, int32_t cz)
{
    const cpu_bone *bone = f->bone;
    const ost_dims dims = bone->base.geometry.dims;
    const int32_t n = bone->base.chunk_size, columns = bone->chunk_dims.x;
    task t = {.height = min32(n, dims.y - cy * n)};
    for (int32_t y = 0; y < t.height; y++)
        t.row[y] = (size_t)(f->view.map[1] ? f->view.map[1][cy * n + y] : cy * n + y) * f->view.row;
    cpu_chunk *chunks = bone->chunks + (int64_t)columns * (cy + (int64_t)bone->chunk_dims.y * cz);
    for (int32_t z = 0; z < n; z += 4) {
        enter_layer(f, &t, cz * n + z, z + 4 == n);
        for (int32_t cx = 0; cx < columns; cx++) {
            const int32_t width = min32(n, dims.x - cx * n);
            if (!chunks[cx].density) {
                if (!layer_is_active(f, &t, cx * n, width, f->linear[cx]))
                    continue;
                if (!ost_cpu_chunk_take(bone, f->pool, &chunks[cx]))
                    return false;
                for (int32_t before = 0; before < z; before += 4)
                    write_void_layer(f, &chunks[cx], before);
            }
            write_layer(f, &chunks[cx], &t, cx * n, width, f->linear[cx], z);
        }
    }
    return true;
}

/* Layers of chunks [c0, c1). */
static bool fill_layers(const cpu_backend *backend, const filling *f, int32_t c0, int32_t c1)
{
    const ost_dims dims = f->bone->chunk_dims;
    const int32_t tasks = dims.y * (c1 - c0);
    const int threads = ost_cpu_threads(backend, ost_dims_count(f->bone->base.geometry.dims));
    int missing = 0;
    (void)threads;
#pragma omp parallel num_threads(threads) if (threads > 1) reduction(+ : missing)
    {
#pragma omp for schedule(dynamic, 1) nowait
        for (int32_t i = 0; i < tasks; i++)
            missing += !fill_task(f, i % dims.y, c0 + i / dims.y);
        f->kernels->drain();
    }
    return missing == 0;
}

static bool mark_linear(filling *f)
{
    const int32_t n = f->bone->base.chunk_size, columns = f->bone->chunk_dims.x, width = f->bone->base.geometry.dims.x;
    const int32_t *map = f->view.map[0];
    f->linear = malloc((size_t)columns * sizeof *f->linear);
    for (int32_t cx = 0; cx < columns && f->linear; cx++) {
        f->linear[cx] = width - cx * n >= n;
        for (int32_t x = cx * n + 1; map && x < min32(cx * n + n, width); x++)
            f->linear[cx] = f->linear[cx] && map[x] == map[x - 1] + 1;
    }
    return f->linear != NULL;
}

static ost_chunk_pool *pool_for(cpu_backend *backend, int n)
{
    ost_chunk_pool **pool = &backend->pools[n == 16 ? 0 : n == 32 ? 1 : 2];
    if (!*pool)
        *pool = ost_chunk_pool_open(ost_chunk_bytes(n));
    return *pool;
}

/* So many layers at a time that addresses for all of their chunks can be reserved; without, malloc serves. */
static bool fill_bone(cpu_backend *backend, filling *f)
{
    const ost_dims dims = f->bone->chunk_dims;
    const int64_t layer = (int64_t)dims.x * dims.y;
    const int32_t step = layer < BATCH_CHUNKS ? (int32_t)(BATCH_CHUNKS / layer) : 1;
    bool enough = mark_linear(f);
    f->stream = f->bone->count * (int64_t)ost_chunk_bytes(f->bone->base.chunk_size) > STREAM_BYTES;
    ost_chunk_pool *pool = pool_for(backend, f->bone->base.chunk_size);
    for (int32_t c = 0; c < dims.z && enough; c += step) {
        int32_t end = min32(c + step, dims.z);
        f->pool = pool && ost_chunk_pool_reserve(pool, layer * (end - c)) ? pool : NULL;
        enough = fill_layers(backend, f, c, end);
    }
    free(f->linear);
    if (pool)
        ost_chunk_pool_trim(pool);
    return enough;
}

ost_status ost_cpu_cubic_to_chunks(const ost_grid *base, int chunk_size, int32_t threshold, ost_bone **out, ost_error *err)
{
    cpu_backend *backend = (cpu_backend *)base->backend;
    ost_bone *bone;
    ost_status status = ost_cpu_bone_create(base->backend, &base->geometry, chunk_size, threshold, &bone, err);
    if (status != OST_OK)
        return status;
    filling f = {.bone = (cpu_bone *)bone, .kernels = &backend->kernels, .view = ost_cpu_grid_view((const cpu_grid *)base)};
    if (!fill_bone(backend, &f)) {
        ost_cpu_bone_free(bone);
        return ost_fail(err, OST_ERR_MEMORY, "no memory for chunks of %zu bytes each", ost_chunk_bytes(chunk_size));
    }
    *out = bone;
    return OST_OK;
}
