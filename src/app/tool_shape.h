/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Where a tool's axis and tip are in its grid, and what it is to the metrics.
 *
 *        |z|          the axis is the frame's z axis where that passes through
 *      .-'-'-.        the cutting part, else the middle of that part; the tip is
 *      '--.--'        the bottom of the lowest cutting voxel, on the axis
 *         tip
 */
#ifndef OST_APP_TOOL_SHAPE_H
#define OST_APP_TOOL_SHAPE_H

#include <osteon/backend.h>
#include <osteon/metrics.h>

typedef struct tool_shape {
    double tip_mm[3];     /* in the tool's frame */
    ost_metrics_tool is;  /* narrower than 16 mm: a drill when it is twice as long as wide, else another tool; wider: a reamer */
} tool_shape;

ost_status tool_shape_of(const ost_tool *tool, tool_shape *out, ost_error *err);
/* Finds the tip and the working direction (-z of the tool's frame), in the bone's frame, of a tool at a pose. */
void tool_shape_at(const tool_shape *shape, const ost_pose *pose, double tip_mm[3], double axis[3]);

#endif
