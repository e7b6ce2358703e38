/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The world and its step (thesis 2.1, 2.5, Algs. 2.7-2.10).
 *
 *   tick -> tool's pose -> oriented boxes, separating axes -> sweep
 *        -> per pose: intersection box, voxel box -> backend.remove -> result
 *
 * ost_world_step is the only function that advances the world; live, scripted
 * and replayed sessions all call it.
 *
 * Threads: a world, its bone and its tools are used by one thread at a time.
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
    bool sweep_off;                /* one pose an event, as in the thesis (AR-SWEEP-6) */
    bool broad_phase_off;          /* test every voxel of the bone, as the definition says; for tests */
    int64_t removal_period_ns;     /* 0: every tick is an event; otherwise the first tick of every period (AR-REM-7) */
    ost_density_classes classes;   /* count 0: the default classes */
    /* 0: ost_world_failover is not available; otherwise 1 to OST_WORLD_SAVED_TICKS_MAX */
    int32_t saved_ticks;
} ost_world_options;

enum { OST_WORLD_SAVED_TICKS_MAX = 1000000 };

enum { OST_WORLD_TOOLS_MAX = 16 };

/* Creates a world. The bone and the tools are borrowed and must outlive it. options is copied and may be NULL. */
OST_API ost_status ost_world_create(ost_bone *bone, const ost_world_options *options, ost_world **out, ost_error *err);
/* Frees a world; the bone and the tools remain. NULL is allowed. */
OST_API void ost_world_free(ost_world *world);
/*
 * Adds a tool and returns its index, counted from 0, at most OST_WORLD_TOOLS_MAX in all.  The name is copied.
 * OST_ERR_USAGE or OST_ERR_RANGE if the tool cannot be used with the bone (AR-MAP-2).
 */
OST_API ost_status ost_world_add_tool(ost_world *world, const char *name, const ost_tool *tool, int *index,
                                      ost_error *err);

/*
 * Allocates the memory for the longest sweep and report of a tick, 1 MB and 104 bytes a chunk, so that no later tick
 * allocates.  Call it before a real-time loop.  A backend reserves its own memory when it is opened.
 */
OST_API ost_status ost_world_reserve(ost_world *world, ost_error *err);

typedef struct ost_step_result {
    bool removal;               /* the tick was an event */
    bool boxes_meet;            /* the oriented boxes of bone and tool intersect at one or more poses of the sweep */
    int pose_count;             /* number of poses of the sweep; 0 without an event */
    int32_t chunk_lo[3];        /* half-open range of chunks that the event can change; empty if no boxes intersect */
    int32_t chunk_hi[3];
    const ost_removal_report *report;   /* report of the event, valid until the next step; NULL without an event */
} ost_step_result;

/*
 * Advances the world by one tick.  On an error, for instance a jump or a turn beyond the limits of AR-SWEEP, the world
 * is unchanged.  If the backend failed while it changed the bone, the world is unchanged but the bone may be lost
 * (backend.h); ost_world_failover restores it.  Does not allocate after ost_world_reserve.
 */
OST_API ost_status ost_world_step(ost_world *world, const ost_tick *tick, ost_step_result *result, ost_error *err);
/*
 * Reads everything that a step with the tool at this pose would read, without a change, so that code, tables and bone
 * are in the caches when the tick is due.  Invalidates the report of the last step.
 */
OST_API ost_status ost_world_rehearse(ost_world *world, int tool, const ost_pose *pose, ost_error *err);

/*
 * Returns the 64-bit digest of a step (docs/spec/session.md, SES-DIGEST).  Equal steps have equal digests on every
 * backend.
 * Steps that differ in the chunk, class or density of a removed voxel, or in the number of poses, have different ones.
 * The report of result must still be valid; classes is the number of the world's density classes.
 */
OST_API uint64_t ost_step_digest(const ost_step_result *result, int classes);

/*
 * Failover: continues on another backend after a permanent failure, for instance a lost device.  Bone and tools are
 * made on the other backend, bit-identical to their state after the last complete tick, and the world continues with
 * them.
 *
 *   stored copy --upload--> bone --repeat the ticks since--> state after the last complete tick
 *
 * Requires saved_ticks > 0. Such a world stores in host memory the bone's complete grid (2 bytes a
 * voxel), each tool's grid (1 byte a voxel) and up to saved_ticks ticks of 48 bytes. It copies the
 * bone when it is created and before every tick that finds saved_ticks ticks stored; the previous
 * copy is freed only after the new one is complete. Must not be called if the bone was changed
 * other than by the world's ticks.
 *
 * The caller owns *bone and tools[], an array of OST_WORLD_TOOLS_MAX in the order of their indices; they must outlive
 * the world.  The previous bone and tools may be freed.  On an error the world is unchanged and both are NULL.
 */
OST_API ost_status ost_world_failover(ost_world *world, ost_backend *backend, ost_bone **bone, ost_tool **tools,
                                      ost_error *err);

/* Totals since the world was created. */
typedef struct ost_world_totals {
    uint64_t ticks, removals, poses;
    uint64_t removed_voxels;
    uint64_t removed_by_class[OST_CLASS_MAX];
    int64_t density_by_class[OST_CLASS_MAX];
} ost_world_totals;
/* Copies the totals since the world was created. */
OST_API void ost_world_totals_get(const ost_world *world, ost_world_totals *out);
/* Returns the world's density classes; valid until it is freed. */
OST_API const ost_density_classes *ost_world_classes(const ost_world *world);

/* ----------------------------------------------------- checks before an operation */

struct ost_glenoid;

/*
 * Counts the active voxels in front of a glenoid's face.  With w the position along its inward axis from its centre and
 * r the distance from that axis, in mm, these are the voxels with w < -(3 + min(r, 18)^2 / 60); a healthy rim has none.
 * Only voxels with r <= radius_mm and w >= -reach_mm count; 0 means no limit.
 */
OST_API ost_status ost_bone_in_front(const ost_bone *bone, const struct ost_glenoid *glenoid, double radius_mm,
                                     double reach_mm, int64_t *voxels, ost_error *err);
/* Computes the percentage of bone within 4 mm of the axis, 1 to 11 mm inward and 1 to 11 mm outward of the centre. */
OST_API ost_status ost_bone_along_axis(const ost_bone *bone, const struct ost_glenoid *glenoid, double *inward_percent,
                                       double *outward_percent, ost_error *err);
/* Counts the active voxels that a tool at this pose covers, with cutting and with other voxels. */
OST_API ost_status ost_bone_overlap(const ost_bone *bone, const ost_tool *tool, const ost_pose *pose, int64_t *voxels,
                                    ost_error *err);

/* ---------------------------------------------------------- built-in paths */

/* A glenoid: the centre of its face and the inward direction, in the bone's frame. */
typedef struct ost_glenoid {
    ost_pm3 at;
    double axis[3]; /* not zero; any length */
    bool left;
} ost_glenoid;

/* The side of the body of a glenoid. */
typedef enum ost_side { OST_SIDE_UNKNOWN, OST_SIDE_LEFT, OST_SIDE_RIGHT } ost_side;
/*
 * Returns the side that an inward axis implies.  A glenoid faces laterally: the inward axis of a left one points to the
 * patient's right, and vice versa.  Returns OST_SIDE_UNKNOWN within 15 degrees of the sagittal plane.
 */
OST_API ost_side ost_side_of_axis(const double axis[3]);
/*
 * Determines the side: the stated one, or that of the axis if stated is OST_SIDE_UNKNOWN.  OST_ERR_INPUT if the two
 * contradict each other, OST_ERR_USAGE if neither determines the side.
 */
OST_API ost_status ost_glenoid_side(const double axis[3], ost_side stated, bool *left, ost_error *err);
/* Reads OST_META_SIDE; OST_SIDE_UNKNOWN if it is absent. OST_ERR_INPUT for a word other than left and right. */
OST_API ost_status ost_side_from_meta(const ost_meta *meta, ost_side *out, ost_error *err);
/* Reads OST_META_GLENOID_AXIS; *there is false if it is absent. OST_ERR_INPUT if it is not a direction. */
OST_API ost_status ost_axis_from_meta(const ost_meta *meta, double axis[3], bool *there, ost_error *err);
/*
 * Reads a point of three decimals in mm by its key; *there is false if it is absent.  OST_ERR_INPUT or OST_ERR_RANGE
 * with key and value in err.
 */
OST_API ost_status ost_point_from_meta(const ost_meta *meta, const char *key, ost_pm3 *out, bool *there,
                                       ost_error *err);
/*
 * Reads a glenoid from OST_META_*.  OST_ERR_USAGE with the missing key in err.  The side may be absent if the axis
 * determines it.
 */
OST_API ost_status ost_glenoid_from_meta(const ost_meta *meta, ost_glenoid *out, ost_error *err);

/* The built-in paths on a glenoid. */
typedef enum ost_builtin {
    OST_BUILTIN_PEG_HOLE,
    OST_BUILTIN_GLENOID_REAM,
    OST_BUILTIN_GLENOID_SLOW,
    OST_BUILTIN_GLENOID_PRESS,
    OST_BUILTIN_COUNT
} ost_builtin;
/* Returns the name of a built-in path, as `--path builtin:NAME` takes it; static. */
OST_API const char *ost_builtin_name(
    ost_builtin which);

/*
 * Makes a built-in path of 1 kHz ticks of a hand (OST_RPM_OF_DEVICE): approach, advance along the axis, dwell, retreat.
 * glenoid-press is ost_builtin_press for one minute.  ost_motor_path converts it to ticks of a turning tool.  tool is
 * the index stored in the ticks; geometry is the tool's grid, whose working face is towards -z.  The caller frees
 * *out.
 */
OST_API ost_status ost_builtin_path(ost_builtin which, const ost_glenoid *glenoid, const ost_tool_geometry *geometry,
                                    int32_t tool, ost_path *out, ost_error *err);
/*
 * Makes the intended path of a hand that presses the tool into the face, moves over it and wobbles, with the given
 * number of ticks, at most OST_PATH_TICKS_MAX.  The caller frees *out.
 */
OST_API ost_status ost_builtin_press(const ost_glenoid *glenoid, const ost_tool_geometry *geometry, int32_t tool,
                                     size_t ticks, ost_path *out, ost_error *err);

#ifdef __cplusplus
}
#endif
#endif
