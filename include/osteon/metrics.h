/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The metrics of an operation on a glenoid. They compare the bone before and after the operation with a plan. The
 * values are floating-point numbers and are used only in reports.
 *
 *   outward  ^        before            frame of the plan: w along its inward axis, from the
 *            |   ___________            centre of the face; u and v perpendicular to w
 *      ------+--'-. dish .-'--
 *            |     '.___.'   <- floor: the exposed bone; a sphere is fitted to it
 *          w v       | |     <- peg hole: where a drill removed bone
 *                    '-'
 *
 * docs/reference/metrics.md documents the definition and the accuracy of each value.
 *
 * Threads: the functions share no state; an object may be used by one thread at a time, or read by several.
 */
#ifndef OSTEON_METRICS_H
#define OSTEON_METRICS_H

#include <osteon/backend.h>
#include <osteon/event.h>
#include <osteon/grid.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct ost_metrics_plan {
    ost_pm3 at;      /* centre of the face */
    double axis[3];  /* inward direction, of any length except 0 */
    bool left;
    double depth_mm; /* planned depth of reaming at the centre of the face */
    /* true if the following landmarks are set; angles are then measured in the scapula's own frame */
    bool landmarks;
    /*
     * The trigonum is the point at which the scapular spine meets the medial border. The inferior angle is the
     * lowest point of the scapula.
     */
    ost_pm3 trigonum, inferior;
} ost_metrics_plan;

/*
 * Size of the surface maps. A map is centred on the plan's axis and has OST_METRICS_MAP^2 cells. Adjacent cells are
 * OST_METRICS_PITCH_MM apart.
 */
enum { OST_METRICS_MAP = 81 };
#define OST_METRICS_PITCH_MM 0.5

/* The role of a tool in the metrics. */
typedef enum ost_metrics_tool_kind { OST_METRICS_REAMER, OST_METRICS_DRILL, OST_METRICS_OTHER } ost_metrics_tool_kind;
/* Minimum width of a reamer's cutting part. */
#define OST_METRICS_REAMER_MM 16.0
/* Properties of a tool that the metrics use. */
typedef struct ost_metrics_tool {
    ost_metrics_tool_kind kind;
    double radius_mm, length_mm; /* radius and length of the cutting part */
    double tip_mm[3];            /* tip in the tool's frame; ost_metrics_make does not use it */
} ost_metrics_tool;

/*
 * Determines the properties of a tool from its cutting voxels. A tool that is at least OST_METRICS_REAMER_MM wide is
 * a reamer. A narrower tool that is at least twice as long as wide is a drill. All other tools, and tools without
 * cutting voxels, have the kind OST_METRICS_OTHER. The length is measured along z, and the width is the larger of the
 * sizes along x and y. The tool's axis is the z axis of its frame or, if the z axis misses the cutting part, a parallel
 * line through the middle of the cutting part. The tip is the lowest point of the cutting part on this axis. The errors
 * are those of ost_tool_download.
 */
OST_API ost_status ost_metrics_tool_make(const ost_tool *tool, ost_metrics_tool *out, ost_error *err);
/*
 * Computes the position of the tip in mm, and the working direction (-z of the tool's frame), for a pose of the tool.
 * Both results are in the bone's frame, as in an ost_motion.
 */
OST_API void ost_metrics_tip(const ost_metrics_tool *tool, const ost_pose *pose, double mm[3], double axis[3]);

/* A tick: the position of the tool, the force, and the numbers of voxels removed and touched. */
typedef struct ost_motion {
    /* Time in s, and position in mm of the tool's tip, which is the lowest point of the tool's axis. */
    double t_s, mm[3];
    double axis[3];            /* working direction of the tool (-z of its frame), a unit vector */
    double force_n;            /* hand force, N; 0 if there is no force */
    uint32_t removed, touched; /* number of voxels removed, and number of voxels touched */
    int32_t tool;
} ost_motion;

/* Ticks in ascending order of time, and the tools to which the ticks refer by index. */
typedef struct ost_metrics_motion {
    const ost_metrics_tool *tools;
    int tool_count;
    const ost_motion *ticks;
    size_t count;
} ost_metrics_motion;

/*
 * The metrics of an operation; docs/reference/metrics.md defines each value. The struct has a size of about 86 kB,
 * because it contains maps. It should not be placed on the stack of a thread whose stack is small.
 */
typedef struct ost_metrics {
    double removed_mm3, removed_by_class_mm3[OST_CLASS_MAX];
    /* The following values describe the floor, which is the exposed bone excluding drill holes. */
    double floor_mm2;
    /* Depths of the floor below the native face, measured along the plan's axis. */
    double depth_mean_mm, depth_p95_mm, depth_max_mm;
    /* true if a reamer removed bone; the following values are then computed from the reamer's poses */
    bool reamed;
    /* Depth of reaming, which is the deepest position of the reamer's tip below the plan's centre, measured along
     * the plan's axis. */
    double reach_mm;
    double tilt_deg;        /* angle between the reamer's axis and the plan's axis */
    double entry_mm;        /* distance from the plan's centre to the reamer's axis, in the plane of the face */
    /*
     * True if the plan has landmarks; angles are then measured in the scapula's own frame. Otherwise, they are
     * measured in the axial and coronal planes of the CT. Retroversion and superior inclination are positive.
     */
    bool scapular;
    double version_planned_deg, inclination_planned_deg; /* angles of the plan's axis */
    double version_deg, inclination_deg;                 /* angles of the reamer's axis */
    double version_error_deg, inclination_error_deg;     /* angle of the reamer's axis minus planned angle */
    bool sphere;                                      /* true if the floor is large enough to fit a sphere */
    /* Radius of the fitted sphere, and RMS deviation of the floor from this sphere. */
    double sphere_mm, fit_rms_mm;
    /* Depth of the fitted sphere below the plan's centre, measured along the plan's axis. */
    double centre_depth_mm;
    /*
     * Fit of an implant whose back is the fitted sphere. contact_percent is the percentage of the floor with backing
     * contact. gap_max_mm is the largest gap, excluding the worst 1 % of the floor.
     */
    double contact_percent, gap_max_mm;
    /*
     * Hard bone (650 HU or more) under the floor, within 4.5 mm below the native face. plate_mm3 is its volume
     * before the operation, and plate_kept_percent is the percentage of this volume that remains.
     */
    double plate_mm3, plate_kept_percent;
    double over_mm3; /* over-reaming: volume removed more than 1 mm below the planned depth, excluding drill holes */
    /*
     * Percentage of the floor that is more than 1 mm below the planned depth, and maximum depth of the floor below the
     * planned depth.
     */
    double over_percent, over_max_mm;
    /*
     * The rim of the face. rim_seen_percent is the percentage of the rim that lies on the map. rim_lowered_percent
     * is the percentage of this part that was lowered by more than 1 mm, and rim_lowered_mm is the maximum lowering.
     */
    double rim_seen_percent, rim_lowered_percent, rim_lowered_mm;
    /* Width and height of the face from rim to rim. NAN if the rim is not on the map. */
    double width_before_mm, width_after_mm, height_before_mm, height_after_mm;
    bool hole;                          /* true if a drill removed bone below the plan's centre */
    double hole_depth_mm;               /* deepest position of the drill's tip, defined as reach_mm is */
    /* angle of the drill, defined as tilt_deg is, and distance to its axis, defined as entry_mm is */
    double hole_angle_deg, hole_entry_mm;
    /* Diameter, computed from the mean area of the hole's slices; NAN if no slice is complete. */
    double hole_diameter_mm;
    /*
     * Distance from the hole to the nearest voxel outside the bone, at most 6 mm. Only the part of the hole that is
     * at least 6 mm below the face is measured.
     */
    double hole_wall_mm;
    bool hole_breach;    /* true if the hole perforates the wall at a depth of at least 6 mm below the face */
    /* maps of the w coordinates of the surfaces before and after the operation; NAN where there is no bone */
    float before_mm[OST_METRICS_MAP * OST_METRICS_MAP], after_mm[OST_METRICS_MAP * OST_METRICS_MAP];
    float depth_mm[OST_METRICS_MAP * OST_METRICS_MAP]; /* map of the depth below the native face; NAN where no bone
                                                        * was exposed */
    /* For each cell, true if a drill removed bone in the cell. Such a cell is not part of the floor. */
    bool drilled[OST_METRICS_MAP * OST_METRICS_MAP];
} ost_metrics;

/* An implant has contact where its gap to the floor is at most 500 um or at most 0.6 bone voxels. */
enum { OST_METRICS_CONTACT_UM = 500 };

/*
 * Computes the metrics. The two volumes must have the same geometry, with equal spacing on all axes. motion may be
 * NULL. Returns OST_ERR_USAGE if the geometries differ, if the voxels are not cubes, if the axis of the plan is zero or
 * not finite, or if its depth is negative. Returns OST_ERR_INPUT if no bone was removed, and OST_ERR_MEMORY if memory
 * is exhausted.
 */
OST_API ost_status ost_metrics_make(const ost_volume *before, const ost_volume *after, int threshold,
                                    const ost_density_classes *classes, const ost_metrics_plan *plan,
                                    const ost_metrics_motion *motion, ost_metrics *out, ost_error *err);

/*
 * Computes version and inclination of the plan's axis in the scapula's own frame; retroversion and superior inclination
 * are positive.  Returns false if the plan has no landmarks, if they are collinear, or if the axis is 0.
 */
OST_API bool ost_metrics_angles(const ost_metrics_plan *plan, double *retroversion_deg, double *superior_deg);

/*
 * A plunge begins when the tip is in contact and moves inward faster than OST_PLUNGE_MM_S, averaged over 50 ms. It
 * ends when the tip moves slower than OST_PLUNGE_END_MM_S.
 */
#define OST_PLUNGE_MM_S 25.0
#define OST_PLUNGE_END_MM_S 15.0

typedef struct ost_technique {
    double seconds, path_mm;     /* duration, and length of the path from the first tick to the last */
    int contacts, passes;        /* number of intervals in contact, and number of intervals in which bone was removed
                                  * (docs/reference/metrics.md) */
    double contact_s, cutting_s, contact_path_mm;
    bool felt;                   /* true if the force was nonzero in at least one tick */
    /* Hand force: mean and 95th percentile during contact, and maximum. */
    double force_mean_n, force_p95_n, force_max_n;
    /* Angle between the tool's working direction and the plan's axis during contact. */
    double tilt_mean_deg, tilt_max_deg;
    double inward_max_mm_s;      /* maximum inward speed during contact, averaged over 50 ms */
    int plunges;
    double plunge_mm;            /* depth of the deepest plunge */
} ost_technique;

/*
 * Computes the values of an ost_technique from the ticks, which must be in ascending order of time. The axis of the
 * plan must not be zero. The only error is OST_ERR_MEMORY.
 */
OST_API ost_status ost_technique_make(const ost_motion *motion, size_t count, const ost_metrics_plan *plan,
                                      ost_technique *out, ost_error *err);

#ifdef __cplusplus
}
#endif
#endif
