/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Oriented boxes: do they meet, and which voxels can a tool at a pose hit.
 *
 * Both answers are integer and conservative: they may say yes, or too much,
 * but never no, or too little, as the set of removed voxels is defined by
 * the test of every voxel and a broad phase may only skip (AR-REM-2).
 */
#ifndef OST_SIM_BOX_H
#define OST_SIM_BOX_H

#include "sim/entity.h"

/* The centres of a bone's voxels, as a box in the bone's frame. */
ost_box ost_box_of_bone(const ost_geometry *bone);

/* A tool's grid and one tool voxel around it, in the tool's frame. */
ost_box ost_box_of_tool(const ost_tool_geometry *tool);

/*
 * The separating-axis test (thesis 2.1, [116]): false only when the tool's
 * box at the pose and the bone's box have no common point.  The pose's
 * quaternion is near unit length (ost_map_make would take it).
 */
bool ost_boxes_meet(const ost_box *bone, const ost_box *tool, const ost_pose *pose);

/*
 * Bone voxels whose centres lie in the bone-aligned bounds of the tool's box
 * at the pose (Algs. 2.8 and 2.9): half-open, within the grid, may be empty.
 */
ost_voxel_box ost_box_voxels(const ost_geometry *bone, const ost_box *tool, const ost_pose *pose);

/* Whether the box holds a voxel at all. */
bool ost_voxel_box_holds(const ost_voxel_box *box);

#endif
