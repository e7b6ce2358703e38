/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Finds the position of a tool's axis and tip in the tool's grid, and the tool's kind for the metrics.
 *
 *         |z|          the axis is the z axis of the tool's frame if this axis passes
 *       .-'-'-.        through the cutting part; otherwise, it passes through the middle
 *       '--.--'        of the cutting part; the tip is the bottom of the lowest cutting
 *          tip         voxel, on the axis
 */
#ifndef OST_APP_INPUT_TOOL_SHAPE_H
#define OST_APP_INPUT_TOOL_SHAPE_H

#include <osteon/backend.h>
#include <osteon/metrics.h>

typedef struct tool_shape {
    double tip_mm[3];     /* position of the tip in mm, in the tool's frame */
    /* The kind of the tool. A tool that is at least 16 mm wide is a reamer. A narrower tool that is at least twice as
       long as it is wide is a drill. All other tools are of a third kind. */
    ost_metrics_tool is;
} tool_shape;

ost_status tool_shape_of(const ost_tool *tool, tool_shape *out, ost_error *err);
/*
 * Computes the tip of a tool at a pose and its working direction, which is -z of the tool's frame. Both are in the
 * bone's frame.
 */
void tool_shape_at(const tool_shape *shape, const ost_pose *pose, double tip_mm[3], double axis[3]);

#endif
