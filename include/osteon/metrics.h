/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What an operation on a glenoid has come to: the bone before and after,
 * against a plan.  Floats; nothing here decides a voxel.
 *
 *   outward  ^        before            frame of the plan: w along its inward
 *            |   ___________            axis from the face's centre, u and v across
 *      ------+--'-. dish .-'--
 *            |     '.___.'   <- floor: what is bared; a sphere is fitted to it
 *          w v       | |     <- peg hole: where a drill removed bone
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

/* What a tool is to the metrics. */
typedef enum ost_metrics_tool_kind { OST_METRICS_REAMER, OST_METRICS_DRILL, OST_METRICS_OTHER } ost_metrics_tool_kind;
typedef struct ost_metrics_tool {
    ost_metrics_tool_kind kind;
    double radius_mm, length_mm; /* of its cutting part */
} ost_metrics_tool;

/* A tick, as the device and the tool had it. */
typedef struct ost_motion {
    double t_s, mm[3];         /* of the tool's tip, the lowest point of its axis */
    double axis[3];            /* the tool's working direction, -z of its frame; unit */
    double force_n;            /* on the device; 0 when there was none */
    uint32_t removed, touched; /* voxels */
    int32_t tool;
} ost_motion;

/* Ticks in the order of their times, and the tools that they name by index. */
typedef struct ost_metrics_motion {
    const ost_metrics_tool *tools;
    int tool_count;
    const ost_motion *ticks;
    size_t count;
} ost_metrics_motion;

typedef struct ost_metrics {
    double removed_mm3, removed_by_class_mm3[OST_CLASS_MAX];
    /* The floor: what was bared, without the holes of drills. */
    double floor_mm2;
    double depth_mean_mm, depth_p95_mm, depth_max_mm; /* below the native face, along the plan's axis */
    bool reamed;            /* a reamer removed bone: the next are known, from its poses */
    double reach_mm;        /* depth of reaming: its tip's deepest place below the plan's centre, along the plan's axis */
    double tilt_deg;        /* of its axis against the plan's */
    double entry_mm;        /* from the plan's centre to where its axis passes through the plane of the face */
    /* In the scapula's own frame with landmarks, else in the CT's axial and coronal planes: retroversion and superior are positive. */
    bool scapular;
    double version_planned_deg, inclination_planned_deg; /* of the plan's axis */
    double version_deg, inclination_deg;                 /* of the reamer's axis */
    double version_error_deg, inclination_error_deg;     /* reamed less planned */
    bool sphere;                                      /* the floor is large enough to fit one */
    double sphere_mm, fit_rms_mm;                     /* its radius; deviation from it */
    double centre_depth_mm;                           /* how far the floor's sphere reaches in at the axis: below the plan's centre */
    /* An implant with that sphere as its back. */
    double contact_percent, gap_max_mm; /* of all but 1 % of the floor */
    /* Hard bone (650 HU or more) within 4.5 mm below the native face, under the floor. */
    double plate_mm3, plate_kept_percent;
    double over_mm3; /* over-reaming: removed deeper than the plan's depth and a millimetre, holes of drills apart */
    double over_percent, over_max_mm; /* share of the floor that lies so deep; the deepest of it, below the plan's depth */
    /* The face's rim: how much of it is on the map; of that, lowered by more than a millimetre; the most. */
    double rim_seen_percent, rim_lowered_percent, rim_lowered_mm;
    double width_before_mm, width_after_mm, height_before_mm, height_after_mm; /* rim to rim across and upward; NAN: not seen */
    bool hole;                          /* a drill removed bone below the floor */
    double hole_depth_mm;               /* its tip's deepest place, as reach_mm */
    double hole_angle_deg, hole_entry_mm; /* as tilt_deg and entry_mm */
    double hole_diameter_mm;            /* of a circle of its slices' mean area; NAN when it has no complete slice */
    double hole_wall_mm; /* from the hole, 6 mm or more below the face, to the nearest outside, at most 6 */
    bool hole_breach;    /* it is open to the outside there */
    float before_mm[OST_METRICS_MAP * OST_METRICS_MAP], after_mm[OST_METRICS_MAP * OST_METRICS_MAP]; /* surfaces: w */
    float depth_mm[OST_METRICS_MAP * OST_METRICS_MAP];
    bool drilled[OST_METRICS_MAP * OST_METRICS_MAP]; /* a drill removed bone there: no floor */
} ost_metrics;

enum { OST_METRICS_CONTACT_UM = 500 }; /* a gap up to there, or to 0.6 voxels of the bone, is contact */

/* Volumes of one geometry with equal spacing; motion may be NULL. OST_ERR_INPUT when nothing was removed. */
OST_API ost_status ost_metrics_make(const ost_volume *before, const ost_volume *after, int threshold, const ost_density_classes *classes,
                                    const ost_metrics_plan *plan, const ost_metrics_motion *motion, ost_metrics *out, ost_error *err);

/* A plunge begins where the tip goes inward in contact faster than the first over 50 ms, and ends where it is slower than the second. */
#define OST_PLUNGE_MM_S 25.0
#define OST_PLUNGE_END_MM_S 15.0

typedef struct ost_technique {
    double seconds, path_mm;     /* from the first tick to the last */
    int contacts, passes;        /* spells of touching, of bone going */
    double contact_s, cutting_s, contact_path_mm;
    bool felt;                   /* there was a force at all */
    double force_mean_n, force_p95_n, force_max_n; /* on the device; mean and 95 % in contact */
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
