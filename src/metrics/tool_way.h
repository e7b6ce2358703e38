/* SPDX-License-Identifier: Apache-2.0 */
#ifndef OST_METRICS_TOOL_WAY_H
#define OST_METRICS_TOOL_WAY_H

#include <osteon/metrics.h>

/* The frame of the plan. `at` is the plan's centre in mm; u, v and w are unit vectors, and w points inward. */
typedef struct ost_plan_frame {
    double at[3], u[3], v[3], w[3];
} ost_plan_frame;

/* The mean pose of a tool while the tool removed bone, relative to the plan. */
typedef struct ost_tool_way {
    bool cut;            /* true if the tool removed bone; the other fields are set only in this case */
    double reach_mm;     /* deepest position of the tip along w */
    double tilt_deg;     /* angle between the tool's axis and w */
    double entry_mm;     /* distance from the plan's centre to the point where the tool's axis meets the plane w = 0 */
    double axis[3];      /* mean direction of the axis, unit length, in the bone's frame */
} ost_tool_way;

/*
 * Computes the mean tip and the mean axis of the tools of one kind. Uses only ticks in which such a tool removed bone
 * and its tip was within window_mm of its deepest position.
 */
ost_tool_way ost_tool_way_of(const ost_metrics_motion *motion, ost_metrics_tool_kind kind, const ost_plan_frame *frame,
                             double window_mm);

/* Sets mark[i] to 1 for each voxel that a drill may have reached in a tick in which the drill removed bone. */
void ost_tool_way_mark(const ost_metrics_motion *motion, const ost_geometry *geometry, uint8_t *mark);

#endif
