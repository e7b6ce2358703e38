/* SPDX-License-Identifier: Apache-2.0 */
#ifndef OST_METRICS_TOOL_WAY_H
#define OST_METRICS_TOOL_WAY_H

#include <osteon/metrics.h>

/* The plan's frame: mm from its centre along u, v and w (inward). */
typedef struct ost_plan_frame {
    double at[3], u[3], v[3], w[3];
} ost_plan_frame;

/* How a tool stood to the plan while it cut. */
typedef struct ost_tool_way {
    bool cut;            /* it removed bone; else nothing here is set */
    double reach_mm;     /* the deepest place of its tip, along w */
    double tilt_deg;     /* of its axis against w */
    double entry_mm;     /* from the centre to where its axis passes through the plane w = 0 */
    double axis[3];      /* mean direction, unit, in the bone's frame */
} ost_tool_way;

/*
 * Of all tools of a kind: over the ticks in which they removed bone with the
 * tip within window_mm of the deepest, the mean tip and the mean axis.
 */
ost_tool_way ost_tool_way_of(const ost_metrics_motion *motion, ost_metrics_tool_kind kind, const ost_plan_frame *frame, double window_mm);

/* Sets mark[i] for each voxel of the geometry within reach of a drill where it removed bone: the hole that it made. */
void ost_tool_way_mark(const ost_metrics_motion *motion, const ost_geometry *geometry, uint8_t *mark);

#endif
