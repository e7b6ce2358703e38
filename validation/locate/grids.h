/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The grids of one record in two traces, whole, with what the stage began
 * with, laid out so that pattern.h can be asked about them.
 *
 * A tick's record has only the leaves that changed, so the bone is made by
 * laying the records before it over each other: until the first difference
 * both bones are the reference's.
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
    int16_t *ref, *got;  /* owned; tools' classes widened */
    int16_t *before;     /* owned; of ticks the bone before, of chunks the cubic grid, of cubic the rect grid; or NULL */
    ost_dims before_dims;
    int32_t *source[3];  /* owned; of cubic */
    int32_t *weight[3];  /* owned; of the next */
    int32_t *behind;     /* owned; of rect */
} grids;

/* at: the record's place in both ranges.  False, and nothing owned, where it has no grids of one size. */
bool grids_at(const scene *s, const trace *ref, compare_range in_ref, const trace *got, compare_range in_got, size_t at, grids *out);
void grids_free(grids *g);

/* What pattern_find is to be asked; lives as long as g. */
pattern_view grids_view(const grids *g, const scene *s, bool reported_too);

/* A whole grid's only block; false when the case has none of this stage (and item). *at: its place in the range. */
bool grids_block(const trace *t, compare_range in, trace_stage stage, uint32_t item, trace_block_view *out);
int16_t grids_voxel(const trace_block_view *b, size_t i);

#endif
