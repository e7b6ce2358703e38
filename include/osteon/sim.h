/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The world and its step (thesis 2.1, 2.5, Algs. 2.7-2.10), without a window.
 *
 *   tick -> tool's pose -> oriented boxes, separating axes -> sweep
 *        -> per pose: intersection box, voxel box -> backend.remove -> result
 *
 * ost_world_step is the one function that advances the world by a tick; live,
 * scripted and replayed sessions all go through it.
 */
#ifndef OSTEON_SIM_H
#define OSTEON_SIM_H

#include <osteon/backend.h>
#include <osteon/path.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct ost_world ost_world;

typedef struct ost_world_options {
    bool sweep_off;                /* the thesis: one pose an event */
    bool broad_phase_off;          /* plain definition: every voxel of the bone is tested (for tests) */
    int64_t removal_period_ns;     /* 0: every tick removes; else the first tick of every period */
    ost_density_classes classes;   /* count 0: the default ones */
    int32_t keep_ticks;            /* 0: nothing is kept for ost_world_rescue; else 1 to OST_WORLD_KEEP_MAX */
} ost_world_options;

enum { OST_WORLD_KEEP_MAX = 1000000 };

enum { OST_WORLD_TOOLS_MAX = 16 };

/* The world borrows bone and tools: they outlive it. options may be NULL. */
OST_API ost_status ost_world_create(ost_bone *bone, const ost_world_options *options, ost_world **out, ost_error *err);
OST_API void ost_world_free(ost_world *world); /* NULL is allowed */
OST_API ost_status ost_world_add_tool(ost_world *world, const char *name, const ost_tool *tool, int *index, ost_error *err);

/*
 * Room for every sweep and report that a tick of this world can have, 1 MB and
 * 104 bytes a chunk, so that no tick asks for memory.  For loops that must be on
 * time; a backend may have made the same of its own when it was opened.
 */
OST_API ost_status ost_world_reserve(ost_world *world, ost_error *err);

typedef struct ost_step_result {
    bool removal;               /* this tick ran a removal event */
    bool boxes_meet;            /* the oriented boxes met at one of its poses */
    int pose_count;             /* of the sweep, 0 when no event ran */
    int32_t chunk_lo[3];        /* range of chunks that the event may touch, half-open; empty when boxes do not meet */
    int32_t chunk_hi[3];
    const ost_report *report;   /* of this event; valid until the next step; NULL when no event ran */
} ost_step_result;

/*
 * On an error (a jump too far, a turn too sharp) the world is as before the
 * tick.  If the backend failed while the bone was changed, the world still is,
 * and the bone may be lost (backend.h): ost_world_rescue brings it back.
 */
OST_API ost_status ost_world_step(ost_world *world, const ost_tick *tick, ost_step_result *result, ost_error *err);
/*
 * All that a step with the tool at this pose would look at, and no change: so
 * that code, tables and bone are in the caches when the tick comes.  What the
 * last step reported is no longer valid.
 */
OST_API ost_status ost_world_rehearse(ost_world *world, int tool, const ost_pose *pose, ost_error *err);

/*
 * What a step did, in 64 bits: equal steps have equal ones on every backend,
 * and steps that differ in a removed voxel's chunk, class or density, or in
 * how many poses there were, do not (docs/session.md, SES-DIGEST).  For the
 * record of a session; the world keeps nothing of it.  result is of a step
 * whose report is still valid, classes the number of the world's classes.
 */
OST_API uint64_t ost_step_digest(const ost_step_result *result, int classes);

/*
 * Goes on elsewhere when a backend fails for good, a device that is lost for
 * instance: bone and tools are made on the other backend as they were after
 * the last whole tick, to the bit, and the world continues with these.
 *
 *   kept copy --upload--> bone --the ticks since, once more--> after the last whole tick
 *
 * For worlds with keep_ticks > 0.  They keep in the host's memory the bone's
 * grid (2 bytes a voxel, padding and void too), each tool's (1 byte a voxel)
 * and up to keep_ticks ticks of 48 bytes.  The bone is copied when the world
 * is made and before every tick that finds keep_ticks of them recorded; while
 * it is copied both copies are held, so that one that fails half-way is no
 * loss.  Who changes the bone but through the world's ticks must not call this.
 *
 * *bone and tools (room for OST_WORLD_TOOLS_MAX, in the order of their
 * indices) belong to the caller and must outlive the world; what the world had
 * before may be freed.  On an error the world is as before and both are NULL.
 */
OST_API ost_status ost_world_rescue(ost_world *world, ost_backend *backend, ost_bone **bone, ost_tool **tools, ost_error *err);

/* Totals since the world was made. */
typedef struct ost_world_totals {
    uint64_t ticks, removals, poses;
    uint64_t removed_voxels;
    uint64_t removed_by_class[OST_CLASS_MAX];
    int64_t density_by_class[OST_CLASS_MAX];
} ost_world_totals;
OST_API void ost_world_totals_get(const ost_world *world, ost_world_totals *out);
OST_API const ost_density_classes *ost_world_classes(const ost_world *world);

/* ------------------------------------------------- the site of an operation */

struct ost_glenoid;

/*
 * Counts the active voxels in front of a glenoid's face: with w along its
 * inward axis from its centre and r from that axis, in mm, those with
 * w < -(3 + min(r, 18)^2 / 60), which a healthy rim does not reach.  At most
 * radius_mm from the axis and reach_mm out; 0 is without a limit.
 */
OST_API ost_status ost_bone_in_front(const ost_bone *bone, const struct ost_glenoid *glenoid, double radius_mm, double reach_mm, int64_t *voxels,
                                     ost_error *err);
/* The share of bone within 4 mm of the axis, from 1 to 11 mm inward of the face's centre and as far outward. */
OST_API ost_status ost_bone_along_axis(const ost_bone *bone, const struct ost_glenoid *glenoid, double *inward_percent, double *outward_percent,
                                       ost_error *err);
/* Counts the active voxels that a tool at this pose covers, by cutting voxels and by others. */
OST_API ost_status ost_bone_overlap(const ost_bone *bone, const ost_tool *tool, const ost_pose *pose, int64_t *voxels, ost_error *err);

/* ---------------------------------------------------------- built-in paths */

/* A glenoid: the centre of its face and the inward direction, in the bone's frame. */
typedef struct ost_glenoid {
    ost_pm3 at;
    double axis[3]; /* need not be unit; not zero */
    bool left;
} ost_glenoid;

/*
 * A glenoid faces laterally, so its inward axis points to the patient's right
 * at a left one and to the left at a right one.  Within 15 degrees of the
 * sagittal plane the axis determines no side.
 */
typedef enum ost_side { OST_SIDE_UNKNOWN, OST_SIDE_LEFT, OST_SIDE_RIGHT } ost_side;
OST_API ost_side ost_side_of_axis(const double axis[3]);
/*
 * The side as stated, or by the axis where stated is OST_SIDE_UNKNOWN.
 * OST_ERR_INPUT when the two contradict each other, OST_ERR_USAGE when
 * neither determines the side.
 */
OST_API ost_status ost_glenoid_side(const double axis[3], ost_side stated, bool *left, ost_error *err);
/* OST_META_SIDE, unknown when it is not there. OST_ERR_INPUT for any other word than left and right. */
OST_API ost_status ost_side_from_meta(const ost_meta *meta, ost_side *out, ost_error *err);
/* OST_META_GLENOID_AXIS; *there is false without it. OST_ERR_INPUT for what is no direction. */
OST_API ost_status ost_axis_from_meta(const ost_meta *meta, double axis[3], bool *there, ost_error *err);
/* A point of three decimals, by its key; *there is false without it. OST_ERR_INPUT or OST_ERR_RANGE naming key and value. */
OST_API ost_status ost_point_from_meta(const ost_meta *meta, const char *key, ost_pm3 *out, bool *there, ost_error *err);
/* From OST_META_*; OST_ERR_USAGE naming the missing key. The side may be missing where the axis determines it. */
OST_API ost_status ost_glenoid_from_meta(const ost_meta *meta, ost_glenoid *out, ost_error *err);

typedef enum ost_builtin { OST_BUILTIN_PEG_HOLE, OST_BUILTIN_GLENOID_REAM, OST_BUILTIN_GLENOID_SLOW, OST_BUILTIN_GLENOID_PRESS, OST_BUILTIN_COUNT } ost_builtin;
OST_API const char *ost_builtin_name(ost_builtin which); /* "peg-hole", "glenoid-ream", "glenoid-slow", "glenoid-press" */

/*
 * 1 kHz ticks of a hand (OST_RPM_HAND): approach, advance along the axis, dwell,
 * retreat; glenoid-press is a hand that presses, and is ost_builtin_press for
 * a minute.  ost_motor_path makes ticks of a tool that turns of them.  tool is the index the ticks carry; geometry is the tool's grid,
 * whose working face is toward -z.
 */
OST_API ost_status ost_builtin_path(ost_builtin which, const ost_glenoid *glenoid, const ost_tool_geometry *geometry, int32_t tool,
                                    ost_path *out, ost_error *err);
/* What a hand wants that presses the tool into the face, sweeps over it and wobbles, for so many ticks, OST_PATH_TICKS_MAX at most. */
OST_API ost_status ost_builtin_press(const ost_glenoid *glenoid, const ost_tool_geometry *geometry, int32_t tool, size_t ticks, ost_path *out,
                                     ost_error *err);

#ifdef __cplusplus
}
#endif
#endif
