/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The steps before the voxels, written a second time from docs/arithmetic.md
 * alone: what src/core makes once for all backends.
 *
 *   steps_snap.c    mesh in pm, voxel -> tool's grid, snapped mesh   AR-TOOL-2, AR-MESH-3, AR-MESH-4
 *   steps_motor.c   rows of a hand, speed -> ticks of a tool         AR-MOTOR-2 to 4, AR-MOTOR-7
 *   steps_event.c   ticks -> which are events, and their poses       AR-REM-7, AR-SWEEP-5, AR-SWEEP-6, AR-MOTOR-5, AR-MOTOR-6
 *   steps_sweep.c   two poses -> how many, and each of them          AR-SWEEP-1 to 4
 *   steps_map.c     pose -> the map's integers, a block's base       AR-POSE-4, AR-MAP-1 to 5
 *   steps_box.c     pose -> what a broad phase may not leave out      AR-REM-5
 *   steps_grid.c    rect grid -> the bone's grid                     AR-CUB-1
 *   steps_turn.c    a vector turned by a pose                        AR-POSE-4
 *
 * Integers of any width (wide.h), quaternion products where src/core has
 * matrices, bisection where it divides.  Nothing of src/core is called but
 * ost_fail, which words an error, and free functions of meshes and paths.
 */
#ifndef OST_VALIDATION_DENSE_STEPS_H
#define OST_VALIDATION_DENSE_STEPS_H

#include <osteon/event.h>
#include <osteon/path.h>

#include "validation/dense/wide.h"

/* Computes q v q*, which is M v, or q* v q, which is M transposed v, where back (AR-POSE-4). N of a pose is steps_norm. */
void steps_turn(const ost_pose *pose, bool back, const wide v[3], wide out[3]);
wide steps_norm(const ost_pose *pose);

/* AR-CUB-1 for a grid that AR-GRID-3 allows. */
ost_geometry steps_cubic(const ost_geometry *rect, ost_pm cubic);

/* AR-TOOL-2 over both meshes; the second may have no triangle. False when the mesh has no triangle or a limit of AR-TOOL-1 does not hold. */
bool steps_tool_grid(const ost_mesh meshes[2], ost_pm voxel, ost_tool_geometry *out);
/* AR-MESH-3, AR-MESH-4. out is freed by ost_snapped_mesh_free. */
ost_status steps_snap(const ost_mesh *mesh, const ost_tool_geometry *grid, ost_snapped_mesh *out, ost_error *err);

/* AR-SWEEP-2 and AR-SWEEP-3: the number of poses, or 0 where either is an error. */
int steps_sweep_count(const ost_pose *a, const ost_pose *b, const ost_tool_geometry *tool, ost_pm bone_voxel);
/* AR-SWEEP-4 */
ost_pose steps_sweep_pose(const ost_pose *a, const ost_pose *b, int k, int n);

/* AR-MAP-1 and AR-MAP-3, in the form that events have. */
void steps_map(const ost_pose *pose, const ost_geometry *bone, const ost_tool_geometry *tool, ost_map *out);
/* AR-MAP-4 and AR-MAP-5; false for a far block. */
bool steps_block_base(const ost_map *map, const int32_t first[3], int32_t base[3]);

/* The bounds of box.h's promise; false, and an empty box, where they hold no voxel. */
bool steps_bounds(const ost_pose *pose, const ost_geometry *bone, const ost_tool_geometry *tool, ost_voxel_box *out);
/* True where a voxel of the bone, active or not, is inside the tool's grid; looked for in the blocks of the bounds. */
bool steps_reaches(const ost_map *map, const ost_geometry *bone, const ost_tool_geometry *tool, const ost_voxel_box *bounds);

/* AR-MOTOR-7 for a path all of whose rows may be a hand's. Freed by ost_path_free. */
ost_status steps_motor_path(const ost_path *rows, int32_t rpm, ost_path *out, ost_error *err);

/* Which ticks are events: the ticks that were taken, and where each tool's next sweep begins. */
enum { STEPS_TOOLS = 16 };
typedef struct steps_history {
    bool sweep_off;
    int64_t period_ns;     /* 0: every tick */
    const ost_tick *ticks; /* borrowed */
    size_t *taken;         /* owned; numbers of the ticks that were not refused */
    size_t count;
    size_t begin[STEPS_TOOLS]; /* per tool: position in taken of the pose where its next sweep begins */
    size_t last_event;         /* position in taken */
} steps_history;

typedef struct steps_event {
    bool refused, removal;
    int count;     /* of poses; 0 when no event runs */
    ost_pose from; /* where the sweep begins, when count > 1 */
} steps_event;

ost_status steps_history_begin(const ost_path *path, bool sweep_off, int64_t period_ns, steps_history *out, ost_error *err);
void steps_history_free(steps_history *h);
/* Tick i, of which all before it were given in their order; grid is its tool's. */
steps_event steps_next(steps_history *h, size_t i, const ost_tool_geometry *grid, ost_pm bone_voxel);

#endif
