/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Computes the scapula's own frame, which is based on Friedman's line in three dimensions:
 *
 *        GC--------> lateral = GC - TS        TS  trigonum: root of the spine on the medial border
 *        /|                                   GC  centre of the glenoid's face, from the plan
 *       / superior, in the plane TS, GC, IA   IA  inferior angle
 *     TS  |
 *      \  IA          posterior = perpendicular to that plane
 */
#include "metrics/frame.h"

#include <math.h>

#include "core/vector.h"

#define DEG (180 / 3.14159265358979323846)

bool ost_scapular_frame(const ost_metrics_plan *plan, ost_scapular *out)
{
    const ost_pm3 *from = &plan->trigonum, *to = &plan->at, *low = &plan->inferior;
    const double lateral[3] = {ost_pm_to_mm(to->x - from->x), ost_pm_to_mm(to->y - from->y),
                               ost_pm_to_mm(to->z - from->z)};
    const double down[3] = {ost_pm_to_mm(low->x - from->x), ost_pm_to_mm(low->y - from->y),
                            ost_pm_to_mm(low->z - from->z)};
    for (int a = 0; a < 3; a++)
        out->lateral[a] = lateral[a];
    if (!plan->landmarks || !(ost_vector_unit(out->lateral, 0) > 1))
        return false;
    const double along = ost_vector_dot(down, out->lateral);
    for (int a = 0; a < 3; a++)
        out->superior[a] = along * out->lateral[a] - down[a];
    if (!(ost_vector_unit(out->superior, 2) > 1))
        return false;
    /* The cross product lateral x superior points posteriorly on a right shoulder and anteriorly on a left one. */
    const double side = plan->left ? -1 : 1, *l = out->lateral, *s = out->superior;
    for (int a = 0; a < 3; a++)
        out->posterior[a] = side * (l[(a + 1) % 3] * s[(a + 2) % 3] - l[(a + 2) % 3] * s[(a + 1) % 3]);
    return true;
}

void ost_scapular_angles(const ost_scapular *frame, const double inward[3], double *retroversion_deg,
                         double *superior_deg)
{
    const double lateral = -ost_vector_dot(inward, frame->lateral);
    *retroversion_deg = atan2(-ost_vector_dot(inward, frame->posterior), lateral) * DEG;
    *superior_deg = atan2(-ost_vector_dot(inward, frame->superior), lateral) * DEG;
}

bool ost_metrics_angles(const ost_metrics_plan *plan, double *retroversion_deg, double *superior_deg)
{
    ost_scapular frame;
    double inward[3] = {plan->axis[0], plan->axis[1], plan->axis[2]};
    if (!(ost_vector_unit(inward, 0) > 0) || !ost_scapular_frame(plan, &frame))
        return false;
    ost_scapular_angles(&frame, inward, retroversion_deg, superior_deg);
    return true;
}
