/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Connected components of voxels, found from runs along x.
 *
 *   flags of each row --ost_segment_runs_make--> runs --joined with the previous rows--> component of each run
 *
 * Two voxels are connected if they share a face.  Components are numbered in the order of
 * their first voxels, x fastest.  A run needs 12 bytes; the number of runs is at most about
 * half the number of voxels.
 */
#ifndef OST_SEGMENT_RUNS_H
#define OST_SEGMENT_RUNS_H

#include <osteon/grid.h>

typedef struct segment_run {
    int32_t begin, end; /* voxels [begin, end) of the row */
    /* number of the component; before all runs are joined, the index of this run or of an earlier run of the same
     * component */
    uint32_t component;
} segment_run;

typedef struct segment_runs {
    segment_run *items; /* owned */
    size_t count, capacity;
    size_t rows_count;  /* number of rows, ny nz */
    size_t *rows;       /* owned; row (y, z) consists of the runs [rows[i], rows[i + 1]), i = y + ny * z */
    uint32_t components;
} segment_runs;

/* Sets in[x] for each voxel x of row (y, z) that belongs to a component. */
typedef void segment_row(void *user, int32_t y, int32_t z, bool *in);

/* Finds the connected components. The caller frees *out with ost_segment_runs_free, even after a failure. */
ost_status ost_segment_runs_make(ost_dims dims, segment_row *row, void *user, segment_runs *out, ost_error *err);
void ost_segment_runs_free(segment_runs *runs);

#endif
