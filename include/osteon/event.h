/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A removal event: the poses through which a tool has moved since the last event.
 * Each pose is represented by an integer map from bone voxels to tool voxels
 * (docs/spec/arithmetic.md, AR-SWEEP, AR-MAP, AR-REM).
 *
 *   previous pose, pose --ost_sweep_count, ost_sweep_pose--> n poses --ost_map_make--> n maps
 *                                                                                       |
 *   report per chunk and density class <------------- ost_bone_remove <------------------'
 *
 * The functions below compute with integers on the host and are shared by every
 * backend.  tests/oracle compares them with an independent implementation that
 * computes with fractions.
 *
 * Threads: the functions share no state; an object may be used by one thread at a time, or read by several.
 */
#ifndef OSTEON_EVENT_H
#define OSTEON_EVENT_H

#include <osteon/pose.h>
#include <osteon/tool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A 128-bit integer in two's complement: high * 2^64 + low. */
typedef struct ost_int128 {
    uint64_t low;
    int64_t high;
} ost_int128;

/* ------------------------------------------------------------------ sweep */

enum { OST_SWEEP_MAX = 4096 };

/*
 * Computes the number n of poses in a sweep (AR-SWEEP-2): the least n >= 1 with 4 * max|d|^2 <= n^2 * s^2. Here, s is
 * the edge length of a bone voxel, and d is the displacement of a corner of the tool's box from pose a to pose b. The
 * maximum is over all corners, whose positions are rounded half to even to picometres. Returns OST_ERR_RANGE if n would
 * exceed OST_SWEEP_MAX, if the rotation exceeds 90 degrees, or if a pose is invalid.
 */
OST_API ost_status ost_sweep_count(const ost_pose *a, const ost_pose *b, const ost_tool_geometry *tool,
                                   ost_pm bone_voxel, int *count, ost_error *err);

/*
 * Returns pose number k of a sweep of n poses from a to b, 1 <= k <= n (AR-SWEEP-4). The pose is ((n-k) a + k b) / n
 * with each component rounded half to even. If the dot product of the two quaternions is negative, the quaternion of b
 * is negated before this computation.
 */
OST_API ost_pose ost_sweep_pose(const ost_pose *a, const ost_pose *b, int k, int n);

/* ------------------------------------------------------------------- map */

/*
 * Tool coordinates are fixed-point numbers in which one tool voxel is 2^20. Blocks of 16^3 bone voxels are aligned
 * to voxel (0, 0, 0).
 */
enum { OST_MAP_FRACTION = 20, OST_MAP_BLOCK = 16, OST_MAP_RATIO_MAX = 16 };

/*
 * Tool coordinate of the centre of bone voxel (i, j, k) along axis a, times 2^20:
 *
 *   exact  (origin[a] + i column[0][a] + j column[1][a] + k column[2][a]) / divisor
 *   used   base[a] + di step[0][a] + dj step[1][a] + dk step[2][a]
 *
 * Here, (di, dj, dk) is the position of the voxel in its block, 0 to 15 on each axis. RHE rounds half to even: base is
 * RHE(exact) at the first voxel of the block, and step is RHE(column / divisor). The used coordinate differs from the
 * exact coordinate by at most 23 / 2^20 of a tool voxel. Ranges: |origin| < 2^126, divisor < 2^98, |step| <= 2^24. The
 * edge of a bone voxel is at most OST_MAP_RATIO_MAX tool voxels long.
 */
typedef struct ost_map {
    ost_int128 origin[3];
    ost_int128 column[3][3];
    ost_int128 divisor;
    int32_t step[3][3]; /* [bone axis][tool axis] */
} ost_map;

/*
 * Computes the map of a pose. Returns OST_ERR_RANGE if the pose is invalid, if bone or tool is outside the ranges of
 * AR-GRID or AR-TOOL-1, or if the map exceeds a limit of AR-MAP-2. Returns OST_ERR_USAGE unless bone has equal spacing
 * on all axes.
 */
OST_API ost_status ost_map_make(const ost_pose *pose, const ost_geometry *bone, const ost_tool_geometry *tool,
                                ost_map *out, ost_error *err);

/*
 * Computes the base of the block whose first voxel is (16 block.x, 16 block.y, 16 block.z). Returns false if the base
 * is outside [-2^29, 2^30 + 2^29) on an axis; no voxel of the block is then inside the tool's grid (AR-MAP-5 contains
 * the proof). If the function returns true, every coordinate of the block fits in an int32.
 */
OST_API bool ost_map_block_base(const ost_map *map, ost_dims block, int32_t base[3]);

/* ------------------------------------------------------------------ event */

/*
 * A box of voxels. It contains the voxels (i, j, k) with lo <= (i, j, k) < hi on each axis. If lo >= hi on any
 * axis, the box is empty.
 */
typedef struct ost_voxel_box {
    int32_t lo[3], hi[3];
} ost_voxel_box;

enum { OST_CLASS_MAX = 8, OST_CLASS_NAME = 24 };
/* Density classes as half-open ranges: class c is [border[c], border[c + 1]). The last class has no upper border. */
typedef struct ost_density_classes {
    int count;                    /* 1..OST_CLASS_MAX */
    /*
     * Lower borders of the classes, at least 1 and strictly increasing. A voxel with a lower density than border[0]
     * belongs to class 0.
     */
    int16_t border[OST_CLASS_MAX];
    char name[OST_CLASS_MAX][OST_CLASS_NAME];
} ost_density_classes;

/*
 * Returns the default classes: cartilage [threshold, 150), cancellous [150, 650), cortical [650, ...).  AR-CLS lists
 * the sources.
 */
OST_API ost_density_classes ost_density_classes_default(void);
/*
 * Returns OST_ERR_USAGE unless there are 1 to OST_CLASS_MAX classes whose borders are at least 1 and strictly increase
 * (AR-CLS-1).
 */
OST_API ost_status ost_density_classes_check(const ost_density_classes *classes, ost_error *err);
/* Parses density classes of the form "name:border,name:border,...", as used on the command line. Returns OST_ERR_USAGE
 * if the text has a different form or contains invalid classes; *out is then unchanged. */
OST_API ost_status ost_density_classes_parse(const char *text, ost_density_classes *out, ost_error *err);

/*
 * An event. All pointers are borrowed until the call returns. boxes[k] must contain every voxel that pose k maps
 * into the tool's grid. A box that contains the complete bone is always valid.
 */
typedef struct ost_removal_event {
    int pose_count; /* 1..OST_SWEEP_MAX */
    const ost_map *maps;
    const ost_voxel_box *boxes;
    const ost_density_classes *classes;
} ost_removal_event;

typedef struct ost_chunk_report {
    int32_t chunk; /* number of the chunk: cx + chunk_dims.x * (cy + chunk_dims.y * cz) */
    uint32_t voxels[OST_CLASS_MAX];
    int64_t density[OST_CLASS_MAX]; /* for each class, the sum of the densities that the removed voxels had */
} ost_chunk_report;

/*
 * The report of an event. It contains totals, and the chunks with at least one hit in ascending order.
 * Zero-initialise a report once, reuse it for every event, and free it with ost_removal_report_free.
 */
typedef struct ost_removal_report {
    size_t count, capacity;
    ost_chunk_report *chunks; /* owned */
    uint64_t voxels[OST_CLASS_MAX];
    int64_t density[OST_CLASS_MAX];
    uint64_t total_voxels;
    uint64_t touched_voxels; /* number of active voxels covered by non-cutting voxels only; they are not removed */
} ost_removal_report;

/* Clears the content of a report. Its memory is kept for reuse. */
OST_API void ost_removal_report_clear(ost_removal_report *report);
/* Appends a copy of *chunk and adds its counts to the totals. Returns OST_ERR_MEMORY on failure. */
OST_API ost_status ost_removal_report_add(ost_removal_report *report, const ost_chunk_report *chunk, ost_error *err);
/* Frees the memory of a report. The report is then empty and may be used again. */
OST_API void ost_removal_report_free(ost_removal_report *report);

#ifdef __cplusplus
}
#endif
#endif
