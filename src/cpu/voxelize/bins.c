/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Lists the triangles of each tile by a counting sort.
 *
 * A triangle is listed in every tile that its bounds overlap, so that the list of a
 * tile contains all triangles that cross the tile's rows. Further triangles in a list
 * do not affect the result. A triangle that overlaps more than FEW tiles is large: it
 * is listed only once, and every tile processes it. Therefore the lists have at most
 * FEW entries per triangle.
 *
 * The triangles are divided into pieces, which are processed in parallel:
 *
 *   1  keys     computes each triangle's tile (vector kernel)
 *   2  count    counts the triangles of each piece and tile
 *   3  place    writes the triangles of each piece to the lists, from the piece's own
 *               offset on; the order of a list does not depend on the threads, and
 *               does not affect any result
 */
#include <stdlib.h>
#include <string.h>

#include "core/conditions.h"
#include "cpu/voxelize/voxelize.h"

enum { FEW = 9, PIECES_MAX = 16 };

typedef struct rect {
    int32_t y0, y1, z0, z1; /* tiles, inclusive */
} rect;

static rect bounds(const ost_vox_plan *plan, const ost_snapped_mesh *mesh, size_t triangle)
{
    const int32_t h = 1 << (plan->f - 1);
    int32_t lo[3], hi[3];
    for (int a = 1; a < 3; a++) {
        lo[a] = INT32_MAX;
        hi[a] = INT32_MIN;
        for (int i = 0; i < 3; i++) {
            const int32_t v = mesh->vertices[mesh->triangles[triangle][i]][a];
            lo[a] = v < lo[a] ? v : lo[a];
            hi[a] = v > hi[a] ? v : hi[a];
        }
        lo[a] = (lo[a] + h - 1) >> plan->f;
        hi[a] = (hi[a] - h) >> plan->f;
    }
    return (rect){lo[1] >> plan->shift_y, hi[1] >> plan->shift_y, lo[2] >> plan->shift_z, hi[2] >> plan->shift_z};
}

static bool is_large(rect r)
{
    return (int64_t)(r.y1 - r.y0 + 1) * (r.z1 - r.z0 + 1) > FEW;
}

/* Counts the triangles of a piece for each tile. The last element of `counts`, after those of the tiles, counts the
   large triangles. */
static void count_piece(const ost_vox_plan *plan, const ost_snapped_mesh *mesh, size_t first, size_t end,
                        const uint32_t *keys, size_t *counts)
{
    const size_t tiles = (size_t)plan->tiles_y * (size_t)plan->tiles_z;
    for (size_t t = first; t < end; t++) {
        if (keys[t] == OST_VOX_KEY_NONE)
            continue;
        if (keys[t] != OST_VOX_KEY_MANY) {
            counts[keys[t]]++;
            continue;
        }
        const rect r = bounds(plan, mesh, t);
        if (is_large(r)) {
            counts[tiles]++;
            continue;
        }
        for (int32_t z = r.z0; z <= r.z1; z++)
            for (int32_t y = r.y0; y <= r.y1; y++)
                counts[y + (size_t)plan->tiles_y * (size_t)z]++;
    }
}

/* Writes the triangles of a piece to the lists of the tiles in which count_piece has counted them. next[t] is the
   index of the next entry of tile t. */
static void place_piece(const ost_vox_plan *plan, const ost_snapped_mesh *mesh, size_t first, size_t end,
                        const uint32_t *keys, size_t *next, ost_vox_bins *bins)
{
    const size_t tiles = (size_t)plan->tiles_y * (size_t)plan->tiles_z;
    for (size_t t = first; t < end; t++) {
        if (keys[t] == OST_VOX_KEY_NONE)
            continue;
        if (keys[t] != OST_VOX_KEY_MANY) {
            bins->list[next[keys[t]]++] = (uint32_t)t;
            continue;
        }
        const rect r = bounds(plan, mesh, t);
        if (is_large(r)) {
            bins->large[next[tiles]++] = (uint32_t)t;
            continue;
        }
        for (int32_t z = r.z0; z <= r.z1; z++)
            for (int32_t y = r.y0; y <= r.y1; y++)
                bins->list[next[y + (size_t)plan->tiles_y * (size_t)z]++] = (uint32_t)t;
    }
}

void ost_vox_bins_free(ost_vox_bins *bins)
{
    free(bins->start);
    free(bins->list);
    free(bins->large);
    *bins = (ost_vox_bins){0};
}

ost_status ost_vox_bins_make(ost_vox_bins *bins, const ost_vox_plan *plan, const ost_snapped_mesh *mesh,
                             const cpu_backend *backend, int threads, ost_error *err)
{
    *bins = (ost_vox_bins){0};
    const size_t tiles = (size_t)plan->tiles_y * (size_t)plan->tiles_z, triangles = mesh->triangle_count;
    if (tiles == 1)
        return OST_OK;
    const size_t piece = (size_t)backend->sharing->least[OST_PATH_SORT]; /* minimum number of triangles per thread */
    size_t pieces = triangles / piece + (triangles % piece > 0);
    pieces = pieces < 1 ? 1 : pieces > PIECES_MAX ? PIECES_MAX : pieces;
    if (pieces > (size_t)threads)
        pieces = (size_t)threads;
    const size_t stride = tiles + 1;
    ost_team team = ost_team_of(backend->sharing, (int)pieces, OST_PATH_SORT, INT64_MAX, (int64_t)pieces, 0),
             placing = team;
    uint32_t *keys = malloc((triangles + 1) * sizeof *keys);
    size_t *counts = calloc(pieces * stride, sizeof *counts);
    bins->start = malloc((tiles + 1) * sizeof *bins->start);
    ost_status status = OST_OK;
    if (!keys || !counts || !bins->start)
        goto no_memory;

#pragma omp parallel num_threads(team.threads) if (team.threads > 1)
    {
        ost_member me = ost_team_join(&team);
        for (int64_t i; (i = ost_team_next(&team, &me)) >= 0;) {
            const size_t p = (size_t)i, first = triangles * p / pieces, end = triangles * (p + 1) / pieces;
            backend->kernels.vox_keys(plan, mesh, first, end - first, keys + first);
            count_piece(plan, mesh, first, end, keys, counts + p * stride);
        }
    }
    ost_team_end(backend->sharing, &team);

    size_t listed = 0;
    for (size_t t = 0; t < stride; t++) {
        if (t < tiles)
            bins->start[t] = listed;
        size_t *sum = t < tiles ? &listed : &bins->large_count;
        for (size_t p = 0; p < pieces; p++) {
            const size_t n = counts[p * stride + t];
            counts[p * stride + t] = *sum;
            *sum += n;
        }
    }
    bins->start[tiles] = listed;
    bins->list = malloc((listed + 1) * sizeof *bins->list);
    bins->large = malloc((bins->large_count + 1) * sizeof *bins->large);
    if (!bins->list || !bins->large)
        goto no_memory;

#pragma omp parallel num_threads(placing.threads) if (placing.threads > 1)
    {
        ost_member me = ost_team_join(&placing);
        for (int64_t i; (i = ost_team_next(&placing, &me)) >= 0;) {
            const size_t p = (size_t)i;
            place_piece(plan, mesh, triangles * p / pieces, triangles * (p + 1) / pieces, keys, counts + p * stride,
                        bins);
        }
    }
    goto done;

no_memory:
    ost_vox_bins_free(bins);
    status = ost_fail(err, OST_ERR_MEMORY, "out of memory to sort %zu triangles by tile", triangles);
done:
    free(counts);
    free(keys);
    return status;
}
