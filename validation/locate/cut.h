/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Which parts of a generated scene are kept: how a case that shows a
 * difference is made small.  What a case file (case_file.h) says.
 *
 *   scene of a case --scene_cut_apply--> the same with fewer samples, a part of the grid, fewer tools, triangles, ticks
 *
 * Indices are those of the whole scene.  Cutting a grid moves its origin, so
 * block borders and rounding move with it: whoever cuts runs it again to see
 * whether the difference is still there (minimise.h).
 */
#ifndef OST_VALIDATION_CUT_H
#define OST_VALIDATION_CUT_H

#include "validation/scene.h"

enum { CUT_RANGES = 64 };

/* Half-open ranges, ascending and apart; some false: everything is kept. */
typedef struct cut_list {
    bool some;
    int count;
    uint32_t range[CUT_RANGES][2];
} cut_list;

struct scene_cut {
    bool no_ct, no_collide;
    bool cropped;
    int32_t lo[3], hi[3]; /* of the rect grid */
    cut_list samples, ticks;
    uint32_t no_tools;    /* a bit each */
    cut_list triangles[SCENE_TOOLS_MAX][2]; /* cutting, not cutting */
};
typedef struct scene_cut scene_cut;

bool cut_keeps(const cut_list *list, size_t i);
/* OST_ERR_INPUT when nothing is left of a grid that is to be kept. */
ost_status scene_cut_apply(const scene_cut *cut, scene *s, ost_error *err);

#endif
