/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Functions for oriented boxes. They test whether two boxes intersect, and compute the voxels that a tool at a pose can
 * hit.
 *
 * Both results are computed with integers and are conservative: too many intersections or voxels may be reported,
 * but none is missed. This is required, because the set of removed voxels is defined by a test of every voxel. A
 * broad phase may therefore skip only voxels that are not hit (AR-REM-2).
 */
#ifndef OST_SIM_BOX_H
#define OST_SIM_BOX_H

#include "sim/entity.h"

/* Returns the box of a bone's voxel centres, in the bone's frame. */
ost_box ost_box_of_bone(const ost_geometry *bone);

/* Returns the box of a tool's grid, inflated by one tool voxel, in the tool's frame. */
ost_box ost_box_of_tool(const ost_tool_geometry *tool);

/*
 * Performs the separating-axis test (thesis 2.1, [116]). Returns false only if the tool's box at the given pose and
 * the bone's box have no common point. The length of the pose's quaternion must be near 1, as for ost_map_make.
 */
bool ost_boxes_meet(const ost_box *bone, const ost_box *tool, const ost_pose *pose);

/*
 * Returns the bone voxels whose centres lie within the bone-aligned bounds of the tool's box at the given pose
 * (Algs. 2.8 and 2.9). The result is half-open, lies within the grid, and may be empty.
 */
ost_voxel_box ost_box_voxels(const ost_geometry *bone, const ost_box *tool, const ost_pose *pose);

/* Returns true if the box contains at least one voxel. */
bool ost_voxel_box_holds(const ost_voxel_box *box);

#endif
