/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The labelled voxels of a label map, in a compact order.
 *
 *   row (y, z)   . . 1 1 1 . 2 2 .      runs [2, 5) of label 1 and [6, 8) of label 2
 *   compact          0 1 2   3 4        x fastest, then y, then z
 *
 * In a CT, about one voxel in ten belongs to a bone.  An array with one element for each of
 * these voxels is therefore much smaller than the grid.  A run contains voxels of one label; the
 * sign of a label is ignored.
 */
#ifndef OST_SEGMENT_SPARSE_H
#define OST_SEGMENT_SPARSE_H

#include <osteon/grid.h>

typedef struct segment_sparse_run {
    int32_t begin, end; /* the run consists of the voxels [begin, end) of its row */
    uint32_t first;     /* compact index of voxel `begin` */
    /* near and past have one element for each of the neighbouring rows y - 1, y + 1, z - 1 and z + 1. */
    uint32_t near[4];   /* index of the row's first run that ends after `begin`; equal to past[] if there is none */
    uint32_t past[4];   /* index after the row's last run */
    int16_t label;
} segment_sparse_run;

typedef struct segment_sparse {
    ost_dims dims;
    uint32_t count;           /* number of labelled voxels */
    size_t run_count;
    segment_sparse_run *runs; /* owned */
    uint32_t *rows;           /* owned; row (y, z) consists of the runs [rows[i], rows[i + 1]), i = y + ny * z */
    uint32_t *run_of;         /* owned; for each voxel, the index of its run */
} segment_sparse;

enum { SEGMENT_NEIGHBOURS = 6 };

/* Collects the labelled voxels. The caller frees *out with ost_segment_sparse_free, even after a failure. */
ost_status ost_segment_sparse_make(const ost_volume *labels, segment_sparse *out, ost_error *err);
void ost_segment_sparse_free(segment_sparse *sparse);

/*
 * Writes the compact indices of the neighbours of voxel i to `out` and returns their number. A neighbour shares
 * a face with voxel i and has the same label. The order is x - 1, x + 1, y - 1, y + 1, z - 1, z + 1.
 */
static inline int segment_neighbours(const segment_sparse *s, uint32_t i, uint32_t out[SEGMENT_NEIGHBOURS])
{
    const segment_sparse_run *run = &s->runs[s->run_of[i]];
    const int32_t x = run->begin + (int32_t)(i - run->first);
    int count = 0;
    if (x > run->begin)
        out[count++] = i - 1;
    if (x + 1 < run->end)
        out[count++] = i + 1;
    for (int a = 0; a < 4; a++) {
        uint32_t k = run->near[a];
        while (k < run->past[a] && s->runs[k].end <= x)
            k++;
        if (k < run->past[a] && s->runs[k].begin <= x && s->runs[k].label == run->label)
            out[count++] = s->runs[k].first + (uint32_t)(x - s->runs[k].begin);
    }
    return count;
}

#endif
