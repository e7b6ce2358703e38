/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Computes the mean pose of a tool over the ticks in which it removed bone. The entry is the point at which the line
 * through the tip along the axis meets the plane of the face, w = 0.
 *
 *   tip, axis of a tick        the axis is the tool's working direction, which
 *     \                        does not change when the tool rotates about it
 *      \_____ entry, w = 0
 *       \
 *        '  tip
 */
#include "metrics/tool_way.h"

#include <math.h>

#include "core/vector.h"

#define DEG (180 / 3.14159265358979323846)

static const ost_metrics_tool *cutting_tool(const ost_metrics_motion *motion, const ost_motion *tick)
{
    return tick->removed > 0 && tick->tool >= 0 && tick->tool < motion->tool_count ? &motion->tools[tick->tool] : NULL;
}

static double depth_of(const ost_motion *tick, const ost_plan_frame *frame)
{
    const double p[3] = {tick->mm[0] - frame->at[0], tick->mm[1] - frame->at[1], tick->mm[2] - frame->at[2]};
    return ost_vector_dot(p, frame->w);
}

ost_tool_way ost_tool_way_of(const ost_metrics_motion *motion, ost_metrics_tool_kind kind, const ost_plan_frame *frame,
                             double window_mm)
{
    ost_tool_way way = {.reach_mm = -INFINITY};
    double tip[3] = {0};
    size_t ticks = 0;
    for (size_t i = 0; i < motion->count; i++) {
        const ost_metrics_tool *tool = cutting_tool(motion, &motion->ticks[i]);
        if (tool && tool->kind == kind)
            way.reach_mm = fmax(way.reach_mm, depth_of(&motion->ticks[i], frame));
    }
    for (size_t i = 0; i < motion->count; i++) {
        const ost_motion *t = &motion->ticks[i];
        const ost_metrics_tool *tool = cutting_tool(motion, t);
        if (!tool || tool->kind != kind || depth_of(t, frame) < way.reach_mm - window_mm)
            continue;
        ticks++;
        for (int a = 0; a < 3; a++) {
            tip[a] += t->mm[a] - frame->at[a];
            way.axis[a] += t->axis[a];
        }
    }
    const double size = sqrt(ost_vector_dot(way.axis, way.axis));
    if (ticks == 0 || !(size > 0))
        return (ost_tool_way){0};
    for (int a = 0; a < 3; a++) {
        way.axis[a] /= size;
        tip[a] /= (double)ticks;
    }
    const double along = ost_vector_dot(way.axis, frame->w),
                 s = along > 0.01 ? ost_vector_dot(tip, frame->w) / along : 0;
    const double entry[3] = {tip[0] - s * way.axis[0], tip[1] - s * way.axis[1], tip[2] - s * way.axis[2]};
    /* Uses atan2 instead of acos, because acos is imprecise for small angles. */
    const double across[2] = {ost_vector_dot(way.axis, frame->u), ost_vector_dot(way.axis, frame->v)};
    way.cut = true;
    way.tilt_deg = atan2(sqrt(across[0] * across[0] + across[1] * across[1]), along) * DEG;
    way.entry_mm = sqrt(ost_vector_dot(entry, frame->u) * ost_vector_dot(entry, frame->u) +
                        ost_vector_dot(entry, frame->v) * ost_vector_dot(entry, frame->v));
    return way;
}

/*
 * Marks the voxels whose centres lie within the drill's cylinder at one pose. The cylinder is enlarged by half a voxel.
 */
static void mark_cylinder(const ost_motion *t, const ost_metrics_tool *tool, const ost_geometry *g, uint8_t *mark)
{
    const double s = ost_pm_to_mm(g->spacing.x), radius = tool->radius_mm + s / 2, length = tool->length_mm;
    const double origin[3] = {ost_pm_to_mm(g->origin.x), ost_pm_to_mm(g->origin.y), ost_pm_to_mm(g->origin.z)};
    const int32_t dims[3] = {g->dims.x, g->dims.y, g->dims.z};
    int32_t lo[3], hi[3];
    for (int a = 0; a < 3; a++) {
        const double from = t->mm[a], to = from - length * t->axis[a];
        lo[a] = (int32_t)fmax(0, fmin(dims[a], floor((fmin(from, to) - radius - origin[a]) / s)));
        hi[a] = (int32_t)fmax(0, fmin(dims[a], ceil((fmax(from, to) + radius - origin[a]) / s) + 1));
    }
    for (int32_t z = lo[2]; z < hi[2]; z++)
        for (int32_t y = lo[1]; y < hi[1]; y++)
            for (int32_t x = lo[0]; x < hi[0]; x++) {
                const double p[3] = {origin[0] + x * s - t->mm[0], origin[1] + y * s - t->mm[1],
                                     origin[2] + z * s - t->mm[2]};
                const double along = ost_vector_dot(p, t->axis), square = ost_vector_dot(p, p) - along * along;
                if (along <= s / 2 && along >= -length && square <= radius * radius)
                    mark[x + dims[0] * (y + (int64_t)dims[1] * z)] = 1;
            }
}

void ost_tool_way_mark(const ost_metrics_motion *motion, const ost_geometry *geometry, uint8_t *mark)
{
    const double step = ost_pm_to_mm(geometry->spacing.x) / 4;
    const ost_motion *last = NULL;
    for (size_t i = 0; i < motion->count; i++) {
        const ost_motion *t = &motion->ticks[i];
        const ost_metrics_tool *tool = cutting_tool(motion, t);
        if (!tool || tool->kind != OST_METRICS_DRILL)
            continue;
        /* A pose within a quarter of a voxel of the last marked pose marks the same voxels and is skipped. */
        bool near = last && last->tool == t->tool;
        for (int a = 0; a < 3 && near; a++)
            near = fabs(t->mm[a] - last->mm[a]) < step && fabs(t->axis[a] - last->axis[a]) * tool->length_mm < step;
        if (near)
            continue;
        mark_cylinder(t, tool, geometry, mark);
        last = t;
    }
}
