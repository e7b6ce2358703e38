/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The steps of a case (steps_record.h), made by src/core and src/sim, as for
 * every backend, or by the second implementation of them (dense/steps.h).
 *
 *   a pose, the bone's grid, a tool's grid --steps_pose_of--> map, bases, box
 */
#ifndef OST_VALIDATION_STEPS_MAKE_H
#define OST_VALIDATION_STEPS_MAKE_H

#include "validation/scene.h"
#include "validation/steps_record.h"

/* OST_ERR_RANGE where the map's limits do not hold (AR-MAP-2). */
ost_status steps_pose_of(bool second, const ost_pose *pose, const ost_geometry *bone, const ost_tool_geometry *tool,
                         steps_pose *out, ost_error *err);
/* AR-SWEEP-2, AR-SWEEP-3: 0 poses where the way or the turn is too great. */
int steps_count_of(bool second, const ost_pose *a, const ost_pose *b, const ost_tool_geometry *tool, ost_pm bone_voxel);
/* AR-SWEEP-4; a count of 1 is b as it is (AR-SWEEP-5). */
ost_pose steps_between(bool second, const ost_pose *a, const ost_pose *b, int k, int count);

/*
 * A tool's two meshes on its grid.  *own is true where they were made here and are to be freed; else they are the scene's.
 * The second implementation makes them of the meshes before they were snapped, where the scene has these.
 */
ost_status steps_meshes_of(bool second, const scene_tool *t, ost_snapped_mesh out[2], bool *own, ost_error *err);
void steps_meshes_free(ost_snapped_mesh meshes[2], bool own);

/* The ticks: the scene's, or the hand's rows turned once more. *own as above. */
ost_status steps_path_of(bool second, const scene *s, ost_path *out, bool *own, ost_error *err);

#endif
