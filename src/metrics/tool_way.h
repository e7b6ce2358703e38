/* SPDX-License-Identifier: Apache-2.0 */
#ifndef OST_METRICS_TOOL_WAY_H
#define OST_METRICS_TOOL_WAY_H

#include <osteon/metrics.h>

/* The plan's frame: its centre in mm, and the unit vectors u, v and w (inward). */
typedef struct ost_plan_frame {
    double at[3], u[3], v[3], w[3];
} ost_plan_frame;

/* A tool's pose relative to the plan while it cut. */
typedef struct ost_tool_way {
    bool cut;            /* it removed bone; otherwise no other field is set */
    double reach_mm;     /* deepest position of its tip along w */
    double tilt_deg;     /* angle between its axis and w */
    double entry_mm;     /* distance from the plan's centre to where its axis meets the plane w = 0 */
    double axis[3];      /* mean direction, unit length, in the bone's frame */
} ost_tool_way;

/*
 * Computes the mean tip and the mean axis of all tools of a kind, over the ticks in which they
 * removed bone with the tip within window_mm of the deepest.
 */
ost_tool_way ost_tool_way_of(const ost_metrics_motion *motion, ost_metrics_tool_kind kind, const ost_plan_frame *frame,
                             double window_mm);

/* Sets mark[i] for each voxel that a drill reached where it removed bone: the voxels of the hole. */
void ost_tool_way_mark(const ost_metrics_motion *motion, const ost_geometry *geometry, uint8_t *mark);

#endif
