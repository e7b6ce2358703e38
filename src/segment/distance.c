/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Computes squared Euclidean distances, one axis after the other:
 *
 *   along x   (distance to the nearest unlabelled voxel of the row)^2
 *   along y   g(j) = min over i of f(i) + (s (j - i))^2, for each column of a slice
 *   along z   the same, for each column of a plane y = constant
 *
 * s is the spacing along the axis, and f is the result for the previous axis. Only one slice or plane is stored as a
 * dense array. A column is divided at its unlabelled voxels, at which f is 0. A voxel beyond an unlabelled voxel never
 * gives a smaller value than the unlabelled voxel itself, so the parts of a column are processed separately. The
 * minimum is found as the lower envelope of the parabolas f(i) + (s (j - i))^2 (Meijster, Roerdink, Hesselink 2000), in
 * time proportional to the number of voxels.
 *
 * Ranges: s <= 10^5 um (AR-GRID-1) and 0 <= i, j < 2^14, so (s j)^2 < 2^62; f <= FAR < 2^32.
 */
#include "core/conditions.h"

#include "segment/distance.h"

#include <stdlib.h>

#include "core/integer.h"

#define FAR ((uint32_t)SEGMENT_DISTANCE_MAX * SEGMENT_DISTANCE_MAX)

static uint32_t nearer(uint32_t f, int64_t s, int64_t voxels)
{
    const int64_t d = s * voxels * s * voxels;
    return d < f ? (uint32_t)d : f;
}

/* ------------------------------------------------------------------ along x */

/* Stores the squared distances along x in `row`; they are 0 for voxels without a label. */
static void along_x(const segment_sparse *sparse, size_t i, int64_t s, uint32_t *row)
{
    const int32_t nx = sparse->dims.x;
    for (int32_t x = 0; x < nx; x++)
        row[x] = 0;
    for (uint32_t r = sparse->rows[i]; r < sparse->rows[i + 1];) {
        const int32_t begin = sparse->runs[r].begin;
        int32_t end = sparse->runs[r++].end;
        /* the next run begins where this run ends, so it has another label */
        while (r < sparse->rows[i + 1] && sparse->runs[r].begin == end)
            end = sparse->runs[r++].end;
        for (int32_t x = begin; x < end; x++) {
            row[x] = begin > 0 ? nearer(FAR, s, x - begin + 1) : FAR;
            row[x] = end < nx ? nearer(row[x], s, end - x) : row[x];
        }
    }
}

/* ---------------------------------------------------------- along y and z */

/*
 * Scratch for one column. From voxel start[q] on, the lowest parabola is that of voxel vertex[q]. This range ends at
 * start[q + 1] or at the end of the column.
 */
typedef struct envelope {
    uint32_t *f;
    int32_t *vertex, *start;
} envelope;

static int64_t parabola(const envelope *e, int64_t s, int32_t vertex, int32_t j)
{
    const int64_t d = s * (j - vertex);
    return e->f[vertex] + d * d;
}

/*
 * Computes the minimum over i of f(i) + (s (j - i))^2 for n consecutive voxels j of a column, which are
 * `stride` elements apart.
 */
static void minimum(envelope *e, uint32_t *column, size_t stride, int32_t n, int64_t s)
{
    int32_t q = -1;
    for (int32_t u = 0; u < n; u++) {
        e->f[u] = column[(size_t)u * stride];
        if (e->f[u] == FAR)
            continue;
        while (q >= 0 && parabola(e, s, e->vertex[q], e->start[q]) > parabola(e, s, u, e->start[q]))
            q--;
        if (q < 0) {
            e->vertex[++q] = u;
            e->start[q] = 0;
            continue;
        }
        /*
         * v < u is the vertex of the previous parabola. Up to and including voxel `last`, the parabola of v is not
         * above that of u.
         */
        const int64_t v = e->vertex[q];
        const int64_t last = ost_floor_div((int64_t)e->f[u] - e->f[v] + s * s * ((int64_t)u * u - v * v),
                                           2 * s * s * (u - v));
        if (last + 1 < n) {
            e->vertex[++q] = u;
            e->start[q] = (int32_t)(last + 1);
        }
    }
    for (int32_t j = n - 1; j >= 0 && q >= 0; j--) {
        const int64_t least = parabola(e, s, e->vertex[q], j);
        column[(size_t)j * stride] = least < FAR ? (uint32_t)least : FAR;
        if (j == e->start[q])
            q--;
    }
}

/*
 * Divides a column at its unlabelled voxels, and computes the minimum for each part. A part includes the unlabelled
 * voxels at its ends.
 */
static void along_column(envelope *e, uint32_t *column, size_t stride, int32_t n, int64_t s)
{
    for (int32_t j = 0; j < n;) {
        if (column[(size_t)j * stride] == 0) {
            j++;
            continue;
        }
        const int32_t from = j > 0 ? j - 1 : 0;
        while (j < n && column[(size_t)j * stride] != 0)
            j++;
        const int32_t to = j < n ? j + 1 : n;
        minimum(e, column + (size_t)from * stride, stride, to - from, s);
    }
}

/* Returns the greatest integer whose square is at most v. */
static uint32_t root(uint32_t v)
{
    uint32_t r = 0;
    for (uint32_t bit = 1u << 15; bit; bit >>= 1)
        if ((uint64_t)(r | bit) * (r | bit) <= v)
            r |= bit;
    return r;
}

/* ------------------------------------------------------------------- passes */

static void store_row(const segment_sparse *sparse, size_t i, const uint32_t *row, uint32_t *height)
{
    for (uint32_t r = sparse->rows[i]; r < sparse->rows[i + 1]; r++)
        for (int32_t x = sparse->runs[r].begin; x < sparse->runs[r].end; x++)
            height[sparse->runs[r].first + (uint32_t)(x - sparse->runs[r].begin)] = row[x];
}

static void load_row(const segment_sparse *sparse, size_t i, const uint32_t *height, uint32_t *row)
{
    for (int32_t x = 0; x < sparse->dims.x; x++)
        row[x] = 0;
    for (uint32_t r = sparse->rows[i]; r < sparse->rows[i + 1]; r++)
        for (int32_t x = sparse->runs[r].begin; x < sparse->runs[r].end; x++)
            row[x] = height[sparse->runs[r].first + (uint32_t)(x - sparse->runs[r].begin)];
}

/* Returns a spacing in whole micrometres, at least 1. */
static int64_t micrometres(ost_pm spacing)
{
    const int64_t um = ost_rhe_div(spacing, 1000000);
    return um > 0 ? um : 1;
}

ost_status ost_segment_distance(const segment_sparse *sparse, ost_pm3 spacing, uint32_t *height, ost_error *err)
{
    const size_t nx = (size_t)sparse->dims.x, ny = (size_t)sparse->dims.y, nz = (size_t)sparse->dims.z,
                 longest = ny > nz ? ny : nz;
    uint32_t *plane = malloc(nx * longest * sizeof *plane);
    envelope e = {malloc(longest * sizeof *e.f), malloc(longest * sizeof *e.vertex), malloc(longest * sizeof *e.start)};
    ost_status status = OST_OK;
    if (!plane || !e.f || !e.vertex || !e.start)
        status = ost_fail(err, OST_ERR_MEMORY, "out of memory for a slice of distances of %zu x %zu voxels", nx,
                          longest);
    for (size_t z = 0; z < nz && status == OST_OK; z++) {
        for (size_t y = 0; y < ny; y++)
            along_x(sparse, y + ny * z, micrometres(spacing.x), plane + nx * y);
        for (size_t x = 0; x < nx; x++)
            along_column(&e, plane + x, nx, sparse->dims.y, micrometres(spacing.y));
        for (size_t y = 0; y < ny; y++)
            store_row(sparse, y + ny * z, plane + nx * y, height);
    }
    for (size_t y = 0; y < ny && status == OST_OK; y++) {
        for (size_t z = 0; z < nz; z++)
            load_row(sparse, y + ny * z, height, plane + nx * z);
        for (size_t x = 0; x < nx; x++)
            along_column(&e, plane + x, nx, sparse->dims.z, micrometres(spacing.z));
        for (size_t z = 0; z < nz; z++)
            store_row(sparse, y + ny * z, plane + nx * z, height);
    }
    for (uint32_t i = 0; i < sparse->count && status == OST_OK; i++)
        height[i] = root(height[i]);
    free(plane);
    free(e.f);
    free(e.vertex);
    free(e.start);
    return status;
}
