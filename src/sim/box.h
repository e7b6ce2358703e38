/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Oriented boxes: whether they meet, and which voxels a tool at a pose can hit.
 *
 * Both results are computed with integers and are conservative: a meeting or a
 * voxel may be reported in excess but is never missed, because the set of
 * removed voxels is defined by a test of every voxel and a broad phase may only
 * skip (AR-REM-2).
 */
#ifndef OST_SIM_BOX_H
#define OST_SIM_BOX_H

#include "sim/entity.h"

/* Returns the box of a bone's voxel centres, in the bone's frame. */
ost_box ost_box_of_bone(const ost_geometry *bone);

/* Returns the box of a tool's grid, inflated by one tool voxel, in the tool's frame. */
ost_box ost_box_of_tool(const ost_tool_geometry *tool);

/*
 * The separating-axis test (thesis 2.1, [116]): returns false only if the tool's
 * box at the pose and the bone's box have no common point.  The pose's
 * quaternion must have nearly unit length, as ost_map_make requires.
 */
bool ost_boxes_meet(const ost_box *bone, const ost_box *tool, const ost_pose *pose);

/*
 * Returns the bone voxels whose centres lie in the bone-aligned bounds of the
 * tool's box at the pose (Algs. 2.8 and 2.9): half-open, within the grid,
 * possibly empty.
 */
ost_voxel_box ost_box_voxels(const ost_geometry *bone, const ost_box *tool, const ost_pose *pose);

/* Returns true if the box contains at least one voxel. */
bool ost_voxel_box_holds(const ost_voxel_box *box);

#endif
