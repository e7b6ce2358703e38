/* SPDX-License-Identifier: Apache-2.0 */
/*
 * When a case that shows a difference is reduced, only some parts of its scene are retained. A cut lists these parts.
 * It is stored in a case file (case_file.h).
 *
 *   scene of a case --scene_cut_apply--> scene with a part of the grid and fewer samples, tools, triangles, ticks
 *
 * Indices refer to the complete scene. Cutting a grid moves its origin, which changes block borders and rounding. The
 * cut case must therefore be run again to check that it still shows the difference (minimise.h).
 */
#ifndef OST_VALIDATION_CUT_H
#define OST_VALIDATION_CUT_H

#include "validation/scene.h"

enum { CUT_RANGES = 64 };

/* The retained items, as ascending, disjoint, half-open ranges. If `some` is false, all items are retained. */
typedef struct cut_list {
    bool some;
    int count;
    uint32_t range[CUT_RANGES][2];
} cut_list;

struct scene_cut {
    bool no_ct, no_collide;
    bool cropped;
    int32_t lo[3], hi[3]; /* retained voxels of the rect grid, lo <= voxel < hi */
    cut_list samples, ticks;
    uint32_t no_tools;    /* tools that are omitted; bit t stands for tool t */
    /* retained triangles of each tool; index 0 is the cutting mesh, index 1 the non-cutting mesh */
    cut_list triangles[SCENE_TOOLS_MAX][2];
};
typedef struct scene_cut scene_cut;

/* Removes all parts of the scene that the cut does not retain. Returns OST_ERR_INPUT if no voxel of the grid would
   remain. */
ost_status scene_cut_apply(const scene_cut *cut, scene *s, ost_error *err);

#endif
