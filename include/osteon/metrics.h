/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What an operation on a glenoid has come to: the bone before and after,
 * against a plan.  Floats; nothing here decides a voxel.
 *
 *   outward  ^        before            frame of the plan: w along its inward
 *            |   ___________            axis from the face's centre, u and v across
 *      ------+--'-. dish .-'--
 *            |     '.___.'   <- floor: what is bared; a sphere is fitted to it
 *          w v       | |     <- peg hole: a line is fitted to its slices
 *                    '-'
 *
 * docs/metrics.md says how each number is made and how near it is.
 */
#ifndef OSTEON_METRICS_H
#define OSTEON_METRICS_H

#include <osteon/event.h>
#include <osteon/grid.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct ost_metrics_plan {
    ost_pm3 at;      /* centre of the face */
    double axis[3];  /* inward; need not be unit */
    bool left;
    double depth_mm; /* of the reaming, at the centre */
    /* Of the whole scapula, for angles in its own frame. */
    bool landmarks;
    ost_pm3 trigonum, inferior; /* where its spine meets the medial border; its lowest point */
} ost_metrics_plan;

/* The map's cells, MAP x MAP about the axis, PITCH mm apart; NAN where nothing was bared. */
enum { OST_METRICS_MAP = 81 };
#define OST_METRICS_PITCH_MM 0.5

typedef struct ost_metrics {
    double removed_mm3, removed_by_class_mm3[OST_CLASS_MAX];
    /* The floor: what was bared, without the peg hole. */
    double floor_mm2;
    double depth_mean_mm, depth_p95_mm, depth_max_mm; /* below the old surface, along the axis */
    double centre_depth_mm;                           /* how far the floor's sphere reaches in at the axis: below the plan's centre */
    bool sphere;                                      /* the floor is large enough to fit one */
    double sphere_mm, fit_rms_mm;                     /* its radius; deviation from it */
    /* Of the direction from the sphere's centre to the plan's centre, got less planned; in the CT's axial and coronal planes. */
    double retroversion_deg, superior_deg, angle_deg;
    /* In the scapula's own frame: toward the back, toward the top; the plan's face, and the floor's when there is a sphere. */
    bool scapular;
    double version_planned_deg, inclination_planned_deg, version_deg, inclination_deg;
    /* An implant with that sphere as its back. */
    double contact_percent, gap_max_mm;
    /* Hard bone (650 HU or more) within 4.5 mm below the old surface, under the floor. */
    double plate_mm3, plate_kept_percent;
    double over_mm3; /* deeper than the plan's depth and a millimetre, the hole apart */
    double over_percent, over_max_mm; /* share of the floor that lies so deep; the deepest of it, below the plan's depth */
    /* The face's rim: how much of it is on the map; of that, lowered by more than a millimetre; the most. */
    double rim_seen_percent, rim_lowered_percent, rim_lowered_mm;
    double width_before_mm, width_after_mm, height_before_mm, height_after_mm; /* rim to rim across and upward; NAN: not seen */
    bool hole;
    double hole_depth_mm, hole_diameter_mm, hole_angle_deg, hole_entry_mm;
    double hole_wall_mm; /* from the hole, 5 mm or more below the face, to the nearest outside, at most 6 */
    bool hole_breach;    /* it is open to the outside there */
    float before_mm[OST_METRICS_MAP * OST_METRICS_MAP], after_mm[OST_METRICS_MAP * OST_METRICS_MAP]; /* surfaces: w */
    float depth_mm[OST_METRICS_MAP * OST_METRICS_MAP];
} ost_metrics;

enum { OST_METRICS_CONTACT_UM = 500 }; /* a gap up to there is contact */

/* Volumes of one geometry with equal spacing. OST_ERR_INPUT when nothing was removed. */
OST_API ost_status ost_metrics_make(const ost_volume *before, const ost_volume *after, int threshold, const ost_density_classes *classes,
                                    const ost_metrics_plan *plan, ost_metrics *out, ost_error *err);

/* A tick, as the hand and the tool had it. */
typedef struct ost_motion {
    double t_s, mm[3];         /* of the tool's origin */
    double axis[3];            /* the tool's working direction, -z of its frame; unit */
    double force_n;            /* on the hand; 0 when nobody felt any */
    uint32_t removed, touched; /* voxels */
    int32_t tool;
} ost_motion;

#define OST_PLUNGE_MM_S 20.0 /* inward, in contact, faster than this for 50 ms: a plunge */

typedef struct ost_technique {
    double seconds, path_mm;     /* from the first tick to the last */
    int contacts, passes;        /* spells of touching, of bone going */
    double contact_s, cutting_s, contact_path_mm;
    bool felt;                   /* there was a force at all */
    double force_mean_n, force_p95_n, force_max_n; /* on the hand; mean and 95 % in contact */
    double tilt_mean_deg, tilt_max_deg; /* of the tool's working direction against the plan, in contact */
    double inward_max_mm_s;      /* in contact, over 50 ms */
    int plunges;
    double plunge_mm;            /* the deepest of them */
} ost_technique;

/* Times ascend. */
OST_API ost_status ost_technique_make(const ost_motion *motion, size_t count, const ost_metrics_plan *plan, ost_technique *out, ost_error *err);

#ifdef __cplusplus
}
#endif
#endif
