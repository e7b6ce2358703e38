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
 * Threads: a world, its bone and its tools may be used by one thread at a time. Functions that
 * take no world, bone or tool share no state.
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
    bool sweep_off;                /* true if an event has only one pose, as in the thesis (AR-SWEEP-6) */
    /* True to test every voxel of the bone, as in the definition of removal. Intended for tests. */
    bool broad_phase_off;
    /* Period of the events in ns. With 0, every tick is an event; otherwise, the first tick of every period is an event
     * (AR-REM-7). */
    int64_t removal_period_ns;
    ost_density_classes classes;   /* density classes; a count of 0 selects the default classes */
    /*
     * Number of ticks stored for ost_world_failover, up to OST_WORLD_SAVED_TICKS_MAX. With 0, failover is not
     * available.
     */
    int32_t saved_ticks;
} ost_world_options;

enum { OST_WORLD_SAVED_TICKS_MAX = 1000000 };

enum { OST_WORLD_TOOLS_MAX = 16 };

/*
 * Creates a world. The bone, and the tools that are added later, are borrowed and must outlive the world. `options` is
 * copied and may be NULL. Returns OST_ERR_USAGE if bone is NULL or an option is out of range, and OST_ERR_MEMORY if
 * memory is exhausted. If options->saved_ticks is not 0, the bone is copied, which can return backend errors
 * (backend.h). The caller frees *out with ost_world_free.
 */
OST_API ost_status ost_world_create(ost_bone *bone, const ost_world_options *options, ost_world **out, ost_error *err);
/* Frees a world. Its bone and its tools are not freed. NULL is allowed. */
OST_API void ost_world_free(ost_world *world);
/*
 * Adds a tool and writes its index, counted from 0, to *index, which may be NULL.  A world has at most
 * OST_WORLD_TOOLS_MAX tools.  The name is copied.  Returns OST_ERR_USAGE if tool is NULL, if it belongs to another
 * backend than the bone, if the world has no room for another tool, or if the voxels of the bone are not cubes.
 * Returns OST_ERR_RANGE if the tool cannot be used with the bone (AR-MAP-2), OST_ERR_MEMORY if memory is exhausted, and
 * backend errors (backend.h).
 */
OST_API ost_status ost_world_add_tool(ost_world *world, const char *name, const ost_tool *tool, int *index,
                                      ost_error *err);

/*
 * Allocates the memory for the longest sweep and the largest report of a tick (1 MB plus 104 bytes per chunk), so
 * that later ticks do not allocate. Should be called before a real-time loop. A backend reserves its own memory
 * when it is opened. Returns OST_ERR_MEMORY if memory is exhausted, and backend errors (backend.h).
 */
OST_API ost_status ost_world_reserve(ost_world *world, ost_error *err);

/* The result of a tick. */
typedef struct ost_step_result {
    bool removal;               /* true if the tick was an event */
    /* true if the oriented boxes of bone and tool intersect in at least one pose of the sweep */
    bool boxes_meet;
    int pose_count;             /* number of poses of the sweep; 0 if the tick was not an event */
    /* The event can change only chunks in the range chunk_lo <= chunk < chunk_hi. If the boxes do not intersect, the
     * range is empty. */
    int32_t chunk_lo[3];
    int32_t chunk_hi[3];
    /* report of the event, valid until the next step; NULL if the tick was not an event */
    const ost_removal_report *report;
} ost_step_result;

/*
 * Advances the world by one tick. Returns OST_ERR_RANGE if the pose is invalid, if the tool jumps or rotates beyond the
 * limits of AR-SWEEP, or if the motor has rotated it by more than 90 degrees since the last event. Returns
 * OST_ERR_USAGE if the world has no tool with the index tick->tool, if time does not increase, or if tick->rpm is out
 * of range or equals OST_RPM_OF_DEVICE. Returns OST_ERR_MEMORY if memory is exhausted, and backend errors (backend.h).
 * After an error, the world remains unchanged. If the backend fails while it changes the bone, however, the bone may be
 * lost (backend.h); ost_world_failover restores it. Does not allocate after ost_world_reserve, except for a new copy of
 * the bone (saved_ticks). result may be NULL.
 */
OST_API ost_status ost_world_step(ost_world *world, const ost_tick *tick, ost_step_result *result, ost_error *err);
/*
 * Reads the data that a step with the tool at this pose would read, so that the caches contain this data when the tick
 * is due. Changes neither the bone nor the state of the world. Invalidates the report of the last step. Returns
 * OST_ERR_USAGE if the world has no tool with this index, OST_ERR_RANGE if the pose is invalid, OST_ERR_MEMORY if
 * memory is exhausted, and backend errors (backend.h).
 */
OST_API ost_status ost_world_rehearse(ost_world *world, int tool, const ost_pose *pose, ost_error *err);

/*
 * Returns the 64-bit digest of a step (docs/spec/session.md, SES-DIGEST). Equal steps have equal digests on every
 * backend. Steps that differ in the chunk, class or density of a removed voxel, or in the number of poses, have
 * different digests. result->report must still be valid. `classes` is the number of the world's density classes.
 */
OST_API uint64_t ost_step_digest(const ost_step_result *result, int classes);

/*
 * Failover: continues a world on another backend after a permanent failure, for instance a lost device. The bone and
 * the tools, in their state after the last complete tick, are copied bit-identically to the other backend. The copies
 * replace the bone and the tools of the world.
 *
 *   stored copy --upload--> bone --repeat the later ticks--> state after the last complete tick
 *
 * Requires saved_ticks > 0. The world then stores in host memory the complete grid of the bone (2 bytes per voxel), the
 * grid of each tool (1 byte per voxel) and up to saved_ticks ticks of 48 bytes. The bone is copied when the world is
 * created, and again before a tick if saved_ticks ticks are already stored; the previous copy is freed only after the
 * new copy is complete. Must not be called if any function other than ost_world_step has changed the bone since the
 * world was created.
 *
 * The caller owns *bone and the tools, which must outlive the world, and frees them with ost_bone_free and
 * ost_tool_free.  `tools` is an array of OST_WORLD_TOOLS_MAX elements, in the order of the tools' indices.  The
 * previous bone and tools may then be freed.  Returns OST_ERR_USAGE if saved_ticks is 0, OST_ERR_MEMORY if memory is
 * exhausted, and backend errors of the new backend (backend.h).  After an error, the world is unchanged, and *bone and
 * all elements of tools are NULL.
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
/* Returns the density classes of a world; valid until the world is freed. */
OST_API const ost_density_classes *ost_world_classes(const ost_world *world);

/* ----------------------------------------------------- checks before an operation */

struct ost_glenoid;

/*
 * Counts the active voxels in front of the face of a glenoid. Let w be the position along the inward axis, measured
 * from the centre of the face, and r the distance from this axis, in mm. A voxel is in front of the face if w < -(3 +
 * min(r, 18)^2 / 60); a healthy rim has no such voxels. Only voxels with r <= radius_mm and w >= -reach_mm are counted.
 * A radius_mm or reach_mm of 0 means no limit. Returns OST_ERR_USAGE if the axis is zero or not finite, OST_ERR_MEMORY
 * if memory is exhausted, and backend errors (backend.h).
 */
OST_API ost_status ost_bone_in_front(const ost_bone *bone, const struct ost_glenoid *glenoid, double radius_mm,
                                     double reach_mm, int64_t *voxels, ost_error *err);
/*
 * Computes the percentage of bone in two cylinders around the axis. One cylinder extends from 1 to 11 mm inward of the
 * centre, the other from 1 to 11 mm outward. Both have a radius of 4 mm. The errors are those of ost_bone_in_front.
 */
OST_API ost_status ost_bone_along_axis(const ost_bone *bone, const struct ost_glenoid *glenoid, double *inward_percent,
                                       double *outward_percent, ost_error *err);
/*
 * Counts the active voxels that the solid voxels of a tool cover at the given pose. The errors are those of
 * ost_map_make and ost_bone_collide.
 */
OST_API ost_status ost_bone_overlap(const ost_bone *bone, const ost_tool *tool, const ost_pose *pose, int64_t *voxels,
                                    ost_error *err);

/* ---------------------------------------------------------- built-in paths */

/* A glenoid: the centre of its face and the inward direction, in the bone's frame. */
typedef struct ost_glenoid {
    ost_pm3 at;
    double axis[3]; /* inward direction, of any length except 0 */
    bool left;
} ost_glenoid;

/* The side of the body on which a glenoid is. */
typedef enum ost_side { OST_SIDE_UNKNOWN, OST_SIDE_LEFT, OST_SIDE_RIGHT } ost_side;
/*
 * Returns the side that the inward axis of a glenoid implies. A glenoid faces laterally, so the inward axis of a
 * left glenoid points to the patient's right, and the axis of a right glenoid points to the patient's left. Returns
 * OST_SIDE_UNKNOWN if the axis is within 15 degrees of the sagittal plane.
 */
OST_API ost_side ost_side_of_axis(const double axis[3]);
/*
 * Determines the side of a glenoid.  The result is `stated` or, if `stated` is OST_SIDE_UNKNOWN, the side that the axis
 * implies.  Returns OST_ERR_INPUT if `stated` contradicts the axis, and OST_ERR_USAGE if neither `stated` nor the axis
 * determines the side.
 */
OST_API ost_status ost_glenoid_side(const double axis[3], ost_side stated, bool *left, ost_error *err);
/*
 * Reads the header fact OST_META_SIDE. If it is missing, *out is set to OST_SIDE_UNKNOWN. Returns OST_ERR_INPUT if the
 * value is neither left nor right.
 */
OST_API ost_status ost_side_from_meta(const ost_meta *meta, ost_side *out, ost_error *err);
/*
 * Reads the header fact OST_META_GLENOID_AXIS. If it is missing, *there is set to false. Returns OST_ERR_INPUT if
 * the value is not three numbers, or if all three are 0.
 */
OST_API ost_status ost_axis_from_meta(const ost_meta *meta, double axis[3], bool *there, ost_error *err);
/*
 * Reads the header fact `key`, a point given by three numbers in mm. If the fact is missing, *there is set to
 * false. Returns OST_ERR_INPUT or OST_ERR_RANGE, with key and value in err, if the value is not a valid point.
 */
OST_API ost_status ost_point_from_meta(const ost_meta *meta, const char *key, ost_pm3 *out, bool *there,
                                       ost_error *err);
/*
 * Reads a glenoid from the header facts OST_META_*. Returns OST_ERR_USAGE, with the key in err, if a fact is
 * missing. The side may be missing if the axis determines it. The other errors are those of ost_point_from_meta,
 * ost_axis_from_meta, ost_side_from_meta and ost_glenoid_side.
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
/* Returns the name of a built-in path, as used in `--path builtin:NAME`; static. */
OST_API const char *ost_builtin_name(
    ost_builtin which);

/*
 * Creates a built-in path of a hand: approach, advance along the axis, dwell, retreat. The ticks are 1 ms apart, and
 * their rpm is OST_RPM_OF_DEVICE. For `glenoid-press`, the path is that of ost_builtin_press with a length of one
 * minute. ost_motor_path converts such a path to the ticks of a rotating tool. `tool` is the tool index that the ticks
 * contain. `geometry` is the grid of the tool, whose working face points to -z. Returns OST_ERR_USAGE if `which` is
 * unknown or the axis of the glenoid is zero or not finite. Returns OST_ERR_RANGE if `geometry` exceeds a limit of
 * AR-TOOL-1 or the path leaves the range of 8 m, and OST_ERR_MEMORY if memory is exhausted; *out is then empty. The
 * caller frees *out with ost_path_free.
 */
OST_API ost_status ost_builtin_path(ost_builtin which, const ost_glenoid *glenoid, const ost_tool_geometry *geometry,
                                    int32_t tool, ost_path *out, ost_error *err);
/*
 * Creates the intended path of a hand that presses the tool into the face, moves over the face and wobbles. `ticks`
 * is the length of the path, 1 to OST_PATH_TICKS_MAX. Returns OST_ERR_USAGE if ticks is out of range. The other errors
 * are those of ost_builtin_path. The caller frees *out with ost_path_free.
 */
OST_API ost_status ost_builtin_press(const ost_glenoid *glenoid, const ost_tool_geometry *geometry, int32_t tool,
                                     size_t ticks, ost_path *out, ost_error *err);

#ifdef __cplusplus
}
#endif
#endif
