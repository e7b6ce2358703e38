/* SPDX-License-Identifier: Apache-2.0 */
/* Measurements of generated bones, computed only from the voxels. */
#ifndef OST_TESTS_PHANTOM_CHECKS_H
#define OST_TESTS_PHANTOM_CHECKS_H

#include "harness.h"

#include <osteon/digest.h>
#include <osteon/phantom.h>

enum { ACTIVE_HU = 120, CHUNK = 32 };

typedef struct chunk_count {
    int64_t all, active, active_voxels;
} chunk_count;

/*
 * Counts the chunks of the bone that an import of the volume creates. Implements the rule AR-CUB again:
 * cubic dims = ceil(dims * rect / cubic), source = floor(i * cubic / rect).
 */
static inline chunk_count count_chunks(const ost_volume *v)
{
    const ost_geometry *g = &v->geometry;
    const int64_t rect[3] = {g->spacing.x, g->spacing.y, g->spacing.z}, n[3] = {g->dims.x, g->dims.y, g->dims.z},
                  cubic = rect[0];
    int64_t dims[3], chunks[3];
    for (int a = 0; a < 3; a++) {
        dims[a] = (n[a] * rect[a] + cubic - 1) / cubic;
        chunks[a] = (dims[a] + CHUNK - 1) / CHUNK;
    }
    chunk_count c = {chunks[0] * chunks[1] * chunks[2], 0, 0};
    unsigned char *hit = calloc((size_t)c.all, 1);
    assert_non_null(hit);
    for (int64_t k = 0; k < dims[2]; k++)
        for (int64_t j = 0; j < dims[1]; j++)
            for (int64_t i = 0; i < dims[0]; i++) {
                int64_t x = i * cubic / rect[0], y = j * cubic / rect[1], z = k * cubic / rect[2];
                if (v->voxels[x + n[0] * (y + n[1] * z)] < ACTIVE_HU)
                    continue;
                c.active_voxels++;
                hit[i / CHUNK + chunks[0] * (j / CHUNK + chunks[1] * (k / CHUNK))] = 1;
            }
    for (int64_t i = 0; i < c.all; i++)
        c.active += hit[i];
    free(hit);
    return c;
}

/*
 * Computes the size of the largest set of active voxels that are connected by faces, and the
 * number of all active voxels.
 */
static inline void count_connected(const ost_volume *v, int64_t *greatest, int64_t *all)
{
    ost_dims d = v->geometry.dims;
    int64_t count = ost_dims_count(d), row = d.x, slice = (int64_t)d.x * d.y;
    unsigned char *seen = calloc((size_t)count, 1);
    int64_t *stack = malloc((size_t)count * sizeof *stack);
    assert_non_null(seen);
    assert_non_null(stack);
    *greatest = *all = 0;
    for (int64_t start = 0; start < count; start++) {
        if (seen[start] || v->voxels[start] < ACTIVE_HU)
            continue;
        int64_t size = 0, top = 0;
        seen[start] = 1;
        stack[top++] = start;
        while (top) {
            int64_t at = stack[--top], x = at % row, y = at / row % d.y, z = at / slice;
            const int64_t next[6] = {x > 0 ? at - 1 : -1,     x + 1 < d.x ? at + 1 : -1,
                                     y > 0 ? at - row : -1,   y + 1 < d.y ? at + row : -1,
                                     z > 0 ? at - slice : -1, z + 1 < d.z ? at + slice : -1};
            size++;
            for (int k = 0; k < 6; k++)
                if (next[k] >= 0 && !seen[next[k]] && v->voxels[next[k]] >= ACTIVE_HU) {
                    seen[next[k]] = 1;
                    stack[top++] = next[k];
                }
        }
        *all += size;
        *greatest = size > *greatest ? size : *greatest;
    }
    free(stack);
    free(seen);
}

static inline ost_digest digest_of(const ost_volume *v)
{
    ost_error err = {0};
    ost_digest digest;
    assert_ok(ost_digest_volume(OST_GRID_RECT, v, &digest, &err));
    return digest;
}

static inline void read_vector(const ost_volume *v, const char *key, double out[3])
{
    const char *text = ost_meta_get(&v->meta, key);
    assert_non_null(text);
    assert_int_equal(sscanf(text, "%lf %lf %lf", &out[0], &out[1], &out[2]), 3);
}

/*
 * Interpolates the density between voxel centres at a point that is given in patient coordinates in mm.
 * Outside the grid, returns the density of the nearest voxel.
 */
static inline double density_at(const ost_volume *v, const double mm[3])
{
    const ost_geometry *g = &v->geometry;
    const double origin[3] = {(double)g->origin.x / 1e9, (double)g->origin.y / 1e9, (double)g->origin.z / 1e9};
    const double step[3] = {(double)g->spacing.x / 1e9, (double)g->spacing.y / 1e9, (double)g->spacing.z / 1e9};
    const int n[3] = {g->dims.x, g->dims.y, g->dims.z};
    int lo[3];
    double f[3], sum = 0;
    for (int a = 0; a < 3; a++) {
        double c = (mm[a] - origin[a]) / step[a];
        c = c < 0 ? 0 : c > n[a] - 1.001 ? n[a] - 1.001 : c;
        lo[a] = (int)c;
        f[a] = c - lo[a];
    }
    for (int c = 0; c < 8; c++) {
        int x = lo[0] + (c & 1), y = lo[1] + (c >> 1 & 1), z = lo[2] + (c >> 2);
        double weight = (c & 1 ? f[0] : 1 - f[0]) * (c >> 1 & 1 ? f[1] : 1 - f[1]) * (c >> 2 ? f[2] : 1 - f[2]);
        sum += weight * v->voxels[x + (int64_t)n[0] * (y + (int64_t)n[1] * z)];
    }
    return sum;
}

#endif
