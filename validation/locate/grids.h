/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The complete grids of one record in two traces, with the input of their stage,
 * in the form that pattern.h uses.
 *
 * A tick's record has only the leaves that changed, so the bone is made by
 * applying the earlier records in order.  Up to the first difference both bones
 * are the reference's.
 */
#ifndef OST_VALIDATION_GRIDS_H
#define OST_VALIDATION_GRIDS_H

#include "validation/compare.h"
#include "validation/locate/pattern.h"
#include "validation/scene.h"

typedef struct grids {
    trace_stage stage;
    uint32_t item;
    ost_dims dims;
    int16_t *ref, *got;  /* owned; the classes of tools are widened to int16 */
    int16_t *before;     /* owned; input: previous bone (ticks), cubic grid (chunks) or rect grid (cubic); or NULL */
    ost_dims before_dims;
    int32_t *source[3];  /* owned; only for cubic: the source voxels along each axis */
    int32_t *weight[3];  /* owned; only for cubic: the weights of the next voxels along each axis */
    int32_t *behind;     /* owned; only for rect: the number of samples after the last sample of each voxel */
} grids;

/* Makes the grids of record `at` of both ranges. Returns false and allocates nothing if the record has no grids of
   equal size. */
bool grids_at(const scene *s, const trace *ref, compare_range in_ref, const trace *got, compare_range in_got, size_t at,
              grids *out);
void grids_free(grids *g);

/* Returns the view for pattern_find. The view is valid until g is freed. */
pattern_view grids_view(const grids *g, const scene *s, bool reported_too);

/* Finds the only block of a complete grid. Returns false if the case has no record of this stage and item. */
bool grids_block(const trace *t, compare_range in, trace_stage stage, uint32_t item, trace_block_view *out);
int16_t grids_voxel(const trace_block_view *b, size_t i);

#endif
