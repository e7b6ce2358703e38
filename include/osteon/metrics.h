/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The outcome of an operation on a glenoid: the bone before and after, compared
 * with a plan.  The values are floating-point numbers and are used only in reports.
 *
 *   outward  ^        before            frame of the plan: w along its inward axis,
 *            |   ___________            from the centre of the face; u and v across
 *      ------+--'-. dish .-'--
 *            |     '.___.'   <- floor: the exposed bone; a sphere is fitted to it
 *          w v       | |     <- peg hole: where a drill removed bone
 *                    '-'
 *
 * docs/reference/metrics.md documents how each value is computed and how accurate it is.
 *
 * Threads: the functions share no state; an object may be used by one thread at a time, or read by several.
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
    double axis[3];  /* inward direction, of any length except 0 */
    bool left;
    double depth_mm; /* depth of reaming at the centre */
    /* Landmarks of the scapula, used to measure angles in the scapula's own frame. */
    bool landmarks;
    ost_pm3 trigonum, inferior; /* point at which the spine meets the medial border; lowest point of the scapula */
} ost_metrics_plan;

/* Size of the maps: OST_METRICS_MAP^2 cells, centred on the axis, OST_METRICS_PITCH_MM apart. */
enum { OST_METRICS_MAP = 81 };
#define OST_METRICS_PITCH_MM 0.5

/* The role of a tool in the metrics. */
typedef enum ost_metrics_tool_kind { OST_METRICS_REAMER, OST_METRICS_DRILL, OST_METRICS_OTHER } ost_metrics_tool_kind;
/* The properties of a tool that the metrics use. */
typedef struct ost_metrics_tool {
    ost_metrics_tool_kind kind;
    double radius_mm, length_mm; /* size of the cutting part */
} ost_metrics_tool;

/* A tick: the position of the tool, the force, and the numbers of voxels removed and touched. */
typedef struct ost_motion {
    double t_s, mm[3];         /* time; position of the tool's tip, the lowest point of its axis */
    double axis[3];            /* working direction of the tool (-z of its frame), a unit vector */
    double force_n;            /* hand force; 0 if there is no force */
    uint32_t removed, touched; /* numbers of voxels */
    int32_t tool;
} ost_motion;

/* Ticks in ascending order of time, and the tools to which their indices refer. */
typedef struct ost_metrics_motion {
    const ost_metrics_tool *tools;
    int tool_count;
    const ost_motion *ticks;
    size_t count;
} ost_metrics_motion;

/* The metrics of an operation; docs/reference/metrics.md defines each. */
typedef struct ost_metrics {
    double removed_mm3, removed_by_class_mm3[OST_CLASS_MAX];
    /* The floor: the exposed bone, without the holes of drills. */
    double floor_mm2;
    double depth_mean_mm, depth_p95_mm, depth_max_mm; /* below the native face, along the plan's axis */
    bool reamed;            /* a reamer removed bone; the values of the reamer below are computed from its poses */
    /* depth of reaming: deepest position of the reamer's tip below the plan's centre, along the plan's axis */
    double reach_mm;
    double tilt_deg;        /* angle between the axes of the reamer and the plan */
    double entry_mm;        /* distance in the plane of the face from the plan's centre to the reamer's axis */
    /*
     * Angles in the scapula's own frame if there are landmarks, otherwise in the CT's axial and
     * coronal planes. Retroversion and superior inclination are positive.
     */
    bool scapular;
    double version_planned_deg, inclination_planned_deg; /* angles of the plan's axis */
    double version_deg, inclination_deg;                 /* angles of the reamer's axis */
    double version_error_deg, inclination_error_deg;     /* reamed minus planned */
    bool sphere;                                      /* the floor is large enough to fit a sphere */
    double sphere_mm, fit_rms_mm;                     /* radius of the sphere; RMS deviation of the floor from it */
    /* depth of the sphere on the plan's axis, below the plan's centre */
    double centre_depth_mm;
    /*
     * Fit of an implant whose back is the sphere: backing contact as a share of the floor; largest gap, without the
     * worst 1 % of the floor.
     */
    double contact_percent, gap_max_mm;
    /* Hard bone (650 HU or more) within 4.5 mm below the native face, under the floor. */
    double plate_mm3, plate_kept_percent;
    double over_mm3; /* over-reaming: volume removed more than 1 mm below the plan's depth, except by drills */
    /* share of the floor more than 1 mm below the plan's depth; greatest depth of the floor below the plan's depth */
    double over_percent, over_max_mm;
    /*
     * The rim of the face: share of the rim that is on the map; share of this part that was lowered by more than 1 mm;
     * greatest lowering.
     */
    double rim_seen_percent, rim_lowered_percent, rim_lowered_mm;
    /* distances from rim to rim, across and upward; NAN: not on the map */
    double width_before_mm, width_after_mm, height_before_mm, height_after_mm;
    bool hole;                          /* a drill removed bone below the plan's centre */
    double hole_depth_mm;               /* deepest position of the drill's tip, measured as reach_mm */
    double hole_angle_deg, hole_entry_mm; /* measured as tilt_deg and entry_mm */
    double hole_diameter_mm;            /* from the mean area of the hole's slices; NAN without a complete slice */
    /* distance from the part of the hole at least 6 mm below the face to the nearest voxel outside the bone; <= 6 mm */
    double hole_wall_mm;
    bool hole_breach;    /* this part of the hole is open to the outside */
    /* positions of the surfaces along w; NAN: no bone */
    float before_mm[OST_METRICS_MAP * OST_METRICS_MAP], after_mm[OST_METRICS_MAP * OST_METRICS_MAP];
    float depth_mm[OST_METRICS_MAP * OST_METRICS_MAP]; /* NAN where no bone was exposed */
    bool drilled[OST_METRICS_MAP * OST_METRICS_MAP]; /* a drill removed bone in this cell; not part of the floor */
} ost_metrics;

enum { OST_METRICS_CONTACT_UM = 500 }; /* a gap up to this value, or up to 0.6 bone voxels, counts as contact */

/*
 * Computes the metrics. The two volumes must have the same geometry, with equal spacing on all axes. motion may
 * be NULL. Returns OST_ERR_INPUT if no bone was removed.
 */
OST_API ost_status ost_metrics_make(const ost_volume *before, const ost_volume *after, int threshold,
                                    const ost_density_classes *classes, const ost_metrics_plan *plan,
                                    const ost_metrics_motion *motion, ost_metrics *out, ost_error *err);

/*
 * A plunge begins when the tip, in contact, moves inward faster than OST_PLUNGE_MM_S on average over 50 ms.
 * It ends when the tip moves slower than OST_PLUNGE_END_MM_S.
 */
#define OST_PLUNGE_MM_S 25.0
#define OST_PLUNGE_END_MM_S 15.0

typedef struct ost_technique {
    double seconds, path_mm;     /* duration and path length from the first tick to the last */
    int contacts, passes;        /* numbers of intervals in contact and of intervals in which bone was removed */
    double contact_s, cutting_s, contact_path_mm;
    bool felt;                   /* there was a force in at least one tick */
    double force_mean_n, force_p95_n, force_max_n; /* hand force: mean and 95th percentile in contact; maximum */
    double tilt_mean_deg, tilt_max_deg; /* angle between the tool's working direction and the plan's axis, in contact */
    double inward_max_mm_s;      /* greatest inward speed over 50 ms, in contact */
    int plunges;
    double plunge_mm;            /* depth of the deepest plunge */
} ost_technique;

/* Computes the technique from ticks, which must be in ascending order of time. */
OST_API ost_status ost_technique_make(const ost_motion *motion, size_t count, const ost_metrics_plan *plan,
                                      ost_technique *out, ost_error *err);

#ifdef __cplusplus
}
#endif
#endif
