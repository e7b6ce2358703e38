/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The inputs of a case, which are equal for every backend. They are integers and
 * depend only on the case's name and the campaign's seed.
 *
 *   plan_case --scene_make--> samples, snapped meshes, ticks
 *
 * Files and the floats of meshes and phantoms are converted to these integers
 * before any backend runs. The digest of the input is computed from the integers.
 */
#ifndef OST_VALIDATION_SCENE_H
#define OST_VALIDATION_SCENE_H

#include <osteon/backend.h>
#include <osteon/digest.h>
#include <osteon/sim.h>

#include "validation/plan.h"

enum { SCENE_TOOLS_MAX = 4, SCENE_NAME = 32 };

typedef struct scene_tool {
    char name[SCENE_NAME];
    ost_snapped_mesh cutting, noncutting; /* `noncutting` has no triangles if all parts of the tool cut */
    ost_fill_rule rule;
    /* the two meshes before snapping; without triangles if they are not available, as in a reduced case */
    ost_mesh raw[2];
    bool grid_given; /* true if the tool's grid was specified instead of computed from the meshes (AR-TOOL-2) */
} scene_tool;

typedef struct scene {
    /* the CT; without samples, the stages up to chunks do not run */
    ost_geometry rect;
    ost_sample *samples; /* in scattering order; owned unless `lent` is true */
    bool lent;           /* true if the samples belong to a user_store and must not be changed */
    size_t sample_count, batch; /* number of samples in total, and per batch */
    ost_duplicates duplicates;
    ost_pm cubic;
    ost_resample resample;
    /* Number of slices per call if a CT with one sample per lattice point is uploaded as slices; 0 if the CT is passed
       as samples. */
    int32_t slices;
    int chunk_size;
    int32_t threshold;

    int tool_count;
    scene_tool tools[SCENE_TOOLS_MAX];

    /* The ticks. If there are none, the case ends after the tools. If there are ticks but no samples, the bone's grid
       is `rect`, and only the steps (steps_record.h) are computed. */
    ost_world_options world;
    ost_path path;
    /* Poses of the handle, if there is a motor. `path` is computed from these poses and the motor speed
       `handle_rpm`. */
    ost_path handle_path;
    int32_t handle_rpm;
    /* The backend also collides the tool before each tick whose number is a multiple of this value. 0 means never. */
    int collide_every;

    ost_digest digest; /* digest of all other members, set by scene_digest; the trace contains it */
} scene;

ost_status scene_make(const plan_case *c, scene *out, ost_error *err);
void scene_free(scene *s);
void scene_tool_free(scene_tool *tool);
/* Applies a motor to a path whose rows are poses of the handle: moves the rows of s->path to s->handle_path, and sets
   s->path to the resulting poses of the tool. */
ost_status scene_turn(scene *s, int32_t rpm, ost_error *err);

/* Computes the SHA-256 of all members, field by field in a fixed form. The evidence records it as the digest of the
   case's input. */
ost_status scene_digest(const scene *s, ost_digest *out, ost_error *err);

#endif
