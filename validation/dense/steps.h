/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A second implementation of the steps: the computations that precede the voxels. It was written only from
 * the text of docs/spec/arithmetic.md. src/core computes these steps once for all backends.
 *
 *   steps_snap.c    mesh in pm, voxel -> tool's grid, snapped mesh   AR-TOOL-2, AR-MESH-3, AR-MESH-4
 *   steps_motor.c   poses of a handle, speed -> ticks of a tool      AR-MOTOR-2 to 4, AR-MOTOR-7
 *   steps_event.c   ticks -> events and their poses                  AR-REM-7, AR-SWEEP-5,
 *                                                                    AR-SWEEP-6, AR-MOTOR-5,
 *                                                                    AR-MOTOR-6
 *   steps_sweep.c   two poses -> number of poses, and each pose      AR-SWEEP-1 to 4
 *   steps_map.c     pose -> the map's integers, a block's base       AR-POSE-4, AR-MAP-1 to 5
 *   steps_box.c     pose -> voxels that a broad phase must include   AR-REM-5
 *   steps_grid.c    rect grid -> the bone's grid                     AR-CUB-1
 *   steps_turn.c    vector, pose -> the rotated vector               AR-POSE-4
 *
 * The second implementation uses wide integers (wide.h), quaternion products where src/core uses matrices,
 * and bisection where src/core divides. The only functions of src/core that it calls are ost_fail, which
 * writes a message, and the free functions of meshes and paths.
 */
#ifndef OST_VALIDATION_DENSE_STEPS_H
#define OST_VALIDATION_DENSE_STEPS_H

#include <osteon/event.h>
#include <osteon/path.h>

#include "validation/dense/wide.h"

/* Computes q v q* = M v, where q is the quaternion and M the rotation matrix of a pose (AR-POSE-4). If `back` is
   true, computes q* v q = M^T v instead. steps_norm returns the N of a pose. */
void steps_turn(const ost_pose *pose, bool back, const wide v[3], wide out[3]);
wide steps_norm(const ost_pose *pose);

/* Returns the geometry of the cubic grid (AR-CUB-1). The rect grid must satisfy AR-GRID-3. */
ost_geometry steps_cubic(const ost_geometry *rect, ost_pm cubic);

/* Computes the tool's grid by AR-TOOL-2 from the cutting and the non-cutting mesh. The second mesh may have no
   triangles. Returns false if the first mesh has no triangles or a limit of AR-TOOL-1 is exceeded. */
bool steps_tool_grid(const ost_mesh meshes[2], ost_pm voxel, ost_tool_geometry *out);
/* Snaps a mesh by AR-MESH-3 and AR-MESH-4. The caller frees `out` with ost_snapped_mesh_free. */
ost_status steps_snap(const ost_mesh *mesh, const ost_tool_geometry *grid, ost_snapped_mesh *out, ost_error *err);

/* Returns the number of poses by AR-SWEEP-2 and AR-SWEEP-3. Returns 0 if one of these rules refuses the motion. */
int steps_sweep_count(const ost_pose *a, const ost_pose *b, const ost_tool_geometry *tool, ost_pm bone_voxel);
/* Returns pose number k of a sweep of n poses (AR-SWEEP-4). */
ost_pose steps_sweep_pose(const ost_pose *a, const ost_pose *b, int k, int n);

/* Computes the map of a pose by AR-MAP-1 and AR-MAP-3, in the form in which an event contains it. */
void steps_map(const ost_pose *pose, const ost_geometry *bone, const ost_tool_geometry *tool, ost_map *out);
/* Computes the base of a block by AR-MAP-4 and AR-MAP-5. Returns false if the block is far. */
bool steps_block_base(const ost_map *map, const int32_t first[3], int32_t base[3]);

/* Computes the bounds that the box of sim/box.h must contain. Returns false and sets an empty box if the bounds
   contain no voxel. */
bool steps_bounds(const ost_pose *pose, const ost_geometry *bone, const ost_tool_geometry *tool, ost_voxel_box *out);
/* Returns true if a voxel of the bone, whether active or not, is inside the tool's grid. Only the blocks within
   `bounds` are searched. */
bool steps_reaches(const ost_map *map, const ost_geometry *bone, const ost_tool_geometry *tool,
                   const ost_voxel_box *bounds);

/* Computes the ticks of AR-MOTOR-7 for a path whose rows are poses of the handle. The caller frees `out` with
   ost_path_free. */
ost_status steps_motor_path(const ost_path *rows, int32_t rpm, ost_path *out, ost_error *err);

/* The state that determines the events: the ticks that were not refused, and for each tool the pose at which its next
   sweep begins. */
enum { STEPS_TOOLS = 16 };
typedef struct steps_history {
    bool sweep_off;
    int64_t period_ns;     /* period in which only the first tick has a removal event; 0 if every tick has one */
    const ost_tick *ticks; /* borrowed */
    size_t *taken;         /* owned; indices of the accepted ticks */
    size_t count;
    size_t begin[STEPS_TOOLS]; /* for each tool, the index in `taken` of the tick whose pose begins the next sweep */
    size_t last_event;         /* index in `taken` of the tick that had the last event */
} steps_history;

typedef struct steps_event {
    bool refused, removal;
    int count;     /* number of poses of the event; 0 if the tick has no event */
    ost_pose from; /* pose at which the sweep starts; valid if count > 1 */
} steps_event;

ost_status steps_history_begin(const ost_path *path, bool sweep_off, int64_t period_ns, steps_history *out,
                               ost_error *err);
void steps_history_free(steps_history *h);
/* Determines the event of tick i. The function must be called for all ticks in order. `grid` is the grid of the tick's
   tool. */
steps_event steps_next(steps_history *h, size_t i, const ost_tool_geometry *grid, ost_pm bone_voxel);

#endif
