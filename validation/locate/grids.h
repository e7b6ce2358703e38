/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Makes the complete grids of one record from two traces, and the input of the record's stage. The grids and
 * the input have the form that pattern.h requires.
 *
 * A tick's record has only the leaves that changed, so the bone is made by applying all earlier records in
 * order. Before the first difference, the bones of both traces are equal, so the reference's records are
 * used for both.
 */
#ifndef OST_VALIDATION_GRIDS_H
#define OST_VALIDATION_GRIDS_H

#include "validation/compare.h"
#include "difference/pattern.h"
#include "validation/scene.h"

typedef struct grids {
    trace_stage stage;
    uint32_t item;
    ost_dims dims;
    int16_t *ref, *got;  /* owned; the densities, or the classes of a tool, of both backends */
    /* owned; input of the stage: for a tick, the bone before the tick; for the stages chunks and resample, the cubic
       grid; for the stage cubic, the rect grid; may be NULL */
    int16_t *before;
    ost_dims before_dims;
    int32_t *source[3];  /* owned; for the cubic grid, the source voxel of each voxel on each axis; otherwise NULL */
    /* owned; weights of the voxels after the source voxels along each axis; only for the cubic grid */
    int32_t *weight[3];
    /* owned; only for the rect grid: for each voxel, how many samples of the same batch follow its last sample; -1
       if it has no sample */
    int32_t *behind;
} grids;

/* Makes the grids of the record with index `at` in both ranges. Returns false and allocates nothing if the record has
   no grids of equal size. */
bool grids_at(const scene *s, const trace *ref, compare_range in_ref, const trace *got, compare_range in_got, size_t at,
              grids *out);
void grids_free(grids *g);

/* Returns both grids in the form that pattern_find takes. The result is valid until g is freed. */
pattern_view grids_view(const grids *g, const scene *s, bool reported_too);

/* Finds the block of a complete grid. Returns false if the case has no record of this stage and item. */
bool grids_block(const trace *t, compare_range in, trace_stage stage, uint32_t item, trace_block_view *out);
int16_t grids_voxel(const trace_block_view *b, size_t i);

#endif
