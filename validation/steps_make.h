/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Computes the steps of a case (steps_record.h), either with src/core and src/sim or with the second implementation
 * (dense/steps.h). Every backend uses the results of src/core and src/sim.
 *
 *   a pose, the bone's grid, a tool's grid --steps_pose_of--> map, bases, box
 */
#ifndef OST_VALIDATION_STEPS_MAKE_H
#define OST_VALIDATION_STEPS_MAKE_H

#include "validation/scene.h"
#include "validation/steps_record.h"

/* Computes the map of a pose, its bases and its box. Returns OST_ERR_RANGE if the map exceeds the limits of
   AR-MAP-2. */
ost_status steps_pose_of(bool second, const ost_pose *pose, const ost_geometry *bone, const ost_tool_geometry *tool,
                         steps_pose *out, ost_error *err);
/* Returns the number of poses of an event by AR-SWEEP-2 and AR-SWEEP-3. Returns 0 if the distance or the rotation is
   too large. */
int steps_count_of(bool second, const ost_pose *a, const ost_pose *b, const ost_tool_geometry *tool, ost_pm bone_voxel);
/* Returns pose k of an event of `count` poses (AR-SWEEP-4). If count is 1, returns b unchanged (AR-SWEEP-5). */
ost_pose steps_between(bool second, const ost_pose *a, const ost_pose *b, int k, int count);

/*
 * Returns the two meshes of a tool on its grid. If the scene has the meshes before snapping, the second implementation
 * snaps them itself. If *own is true, this function allocated the meshes, and steps_meshes_free must free them. If *own
 * is false, the scene owns them.
 */
ost_status steps_meshes_of(bool second, const scene_tool *t, ost_snapped_mesh out[2], bool *own, ost_error *err);
void steps_meshes_free(ost_snapped_mesh meshes[2], bool own);

/* Returns the scene's ticks. If `second` is true, they are computed again from the handle's poses and the motor's
   rotation. *own has the same meaning as in steps_meshes_of. */
ost_status steps_path_of(bool second, const scene *s, ost_path *out, bool *own, ost_error *err);

#endif
