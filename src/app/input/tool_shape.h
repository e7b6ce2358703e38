/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Finds the position of a tool's axis and tip in the tool's grid, and its kind for the metrics.
 *
 *        |z|          the axis is the frame's z axis if that passes through the
 *      .-'-'-.        cutting part, else the middle of that part; the tip is the
 *      '--.--'        bottom of the lowest cutting voxel, on the axis
 *         tip
 */
#ifndef OST_APP_INPUT_TOOL_SHAPE_H
#define OST_APP_INPUT_TOOL_SHAPE_H

#include <osteon/backend.h>
#include <osteon/metrics.h>

typedef struct tool_shape {
    double tip_mm[3];     /* in the tool's frame */
    /* Kind of tool. A tool that is at least 16 mm wide is a reamer. A narrower tool that is at least twice as long as
       it is wide is a drill. All other tools are of a third kind. */
    ost_metrics_tool is;
} tool_shape;

ost_status tool_shape_of(const ost_tool *tool, tool_shape *out, ost_error *err);
/*
 * Computes the tip of a tool at a pose and its working direction, which is -z of the tool's frame. Both are in the
 * bone's frame.
 */
void tool_shape_at(const tool_shape *shape, const ost_pose *pose, double tip_mm[3], double axis[3]);

#endif
