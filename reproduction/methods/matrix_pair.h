/* SPDX-License-Identifier: Apache-2.0 */
/* The state of the methods that compare a box of bone voxels in one buffer with the tool's grid. */
#ifndef OST_REPRODUCTION_METHODS_MATRIX_PAIR_H
#define OST_REPRODUCTION_METHODS_MATRIX_PAIR_H

#include "reproduction/methods/matrix.h"

typedef struct matrix_pair {
    matrix_bone bone;
    matrix_tool tool;
    matrix_map map;
    int threads;
} matrix_pair;

/* These functions implement the members of `method`. The state is a matrix_pair. */
ost_status matrix_pair_open(const methods_scene *scene, const method_setup *setup, void **state, ost_error *err);
void matrix_pair_close(void *state);
ost_status matrix_pair_restore(void *state, ost_error *err);
ost_status matrix_pair_result(void *state, method_set *set, ost_error *err);

/* Removes the hit voxels of a box. */
ost_status matrix_pair_remove(matrix_pair *pair, const ost_voxel_box *box, ost_error *err);
/* Returns the work of an event in which `visited` voxels are visited. */
method_work matrix_pair_work(const matrix_pair *pair, int64_t visited);

#endif
