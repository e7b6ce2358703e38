/* SPDX-License-Identifier: Apache-2.0 */
#include "segment/sparse.h"

#include <stdlib.h>

/*
 * Counts the runs of all rows, and also stores them if out->runs is not NULL. Returns false if the number of labelled
 * voxels or of runs is too large for a 32-bit index.
 */
static bool visit(const ost_volume *labels, segment_sparse *out)
{
    const ost_dims d = out->dims;
    const size_t rows = (size_t)d.y * (size_t)d.z;
    uint64_t voxels = 0, runs = 0;
    for (size_t i = 0; i < rows; i++) {
        const int16_t *row = labels->voxels + (size_t)d.x * i;
        if (out->runs)
            out->rows[i] = (uint32_t)runs;
        for (int32_t x = 0; x < d.x;) {
            const int32_t begin = x;
            const int label = abs(row[x]);
            while (x < d.x && abs(row[x]) == label)
                x++;
            if (!label)
                continue;
            if (out->runs)
                out->runs[runs] = (segment_sparse_run){
                    .begin = begin, .end = x, .first = (uint32_t)voxels, .label = (int16_t)label};
            runs++;
            voxels += (uint64_t)(x - begin);
        }
    }
    if (voxels >= UINT32_MAX)
        return false;
    if (out->runs)
        out->rows[rows] = (uint32_t)runs;
    out->run_count = (size_t)runs;
    out->count = (uint32_t)voxels;
    return true;
}

/* Computes near[a] and past[a] for each run of row i. Row `other` is neighbour number a of row i. */
static void find_near(segment_sparse *s, size_t i, int a, size_t other)
{
    uint32_t k = s->rows[other];
    for (uint32_t r = s->rows[i]; r < s->rows[i + 1]; r++) {
        while (k < s->rows[other + 1] && s->runs[k].end <= s->runs[r].begin)
            k++;
        s->runs[r].near[a] = k;
        s->runs[r].past[a] = s->rows[other + 1];
    }
}

ost_status ost_segment_sparse_make(const ost_volume *labels, segment_sparse *out, ost_error *err)
{
    const ost_dims d = labels->geometry.dims;
    const size_t ny = (size_t)d.y, nz = (size_t)d.z;
    *out = (segment_sparse){.dims = d};
    if (!visit(labels, out))
        return ost_fail(err, OST_ERR_RANGE, "more than 2^32 dense voxels cannot be separated; crop the CT first");
    out->rows = malloc((ny * nz + 1) * sizeof *out->rows);
    out->runs = malloc((out->run_count + 1) * sizeof *out->runs);
    out->run_of = malloc(((size_t)out->count + 1) * sizeof *out->run_of);
    if (!out->rows || !out->runs || !out->run_of)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for the separation of %lu voxels",
                        (unsigned long)out->count);
    (void)visit(labels, out);
    for (uint32_t r = 0; r < out->run_count; r++)
        for (int32_t x = out->runs[r].begin; x < out->runs[r].end; x++)
            out->run_of[out->runs[r].first + (uint32_t)(x - out->runs[r].begin)] = r;
    for (size_t z = 0; z < nz; z++)
        for (size_t y = 0; y < ny; y++) {
            const size_t i = y + ny * z;
            if (y > 0)
                find_near(out, i, 0, i - 1);
            if (y + 1 < ny)
                find_near(out, i, 1, i + 1);
            if (z > 0)
                find_near(out, i, 2, i - ny);
            if (z + 1 < nz)
                find_near(out, i, 3, i + ny);
        }
    return OST_OK;
}

void ost_segment_sparse_free(segment_sparse *sparse)
{
    free(sparse->runs);
    free(sparse->rows);
    free(sparse->run_of);
    *sparse = (segment_sparse){.count = 0};
}
