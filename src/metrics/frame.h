/* SPDX-License-Identifier: Apache-2.0 */
#ifndef OST_METRICS_FRAME_H
#define OST_METRICS_FRAME_H

#include <osteon/metrics.h>

/* The frame of a scapula: unit vectors, perpendicular to each other. */
typedef struct ost_scapular {
    double lateral[3], superior[3], posterior[3];
} ost_scapular;

/* Computes the frame. Returns false if the plan has no landmarks, or if the landmarks are collinear. */
bool ost_scapular_frame(const ost_metrics_plan *plan, ost_scapular *out);
/*
 * Computes two angles between the outward direction of a face and the lateral axis of the frame: one towards posterior,
 * the other towards superior. The face is given by its inward direction.
 */
void ost_scapular_angles(const ost_scapular *frame, const double inward[3], double *retroversion_deg,
                         double *superior_deg);

#endif
