/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The inputs of a case, which are equal for every backend.  They are integers and
 * depend only on the case's name and the campaign's seed.
 *
 *   plan_case --scene_make--> samples, snapped meshes, ticks
 *
 * Files and the floats of meshes and phantoms are converted to these integers
 * before any backend runs.  The digest of the input is computed from the integers.
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
    ost_snapped_mesh cutting, noncutting; /* noncutting has no triangles if the tool has no non-cutting part */
    ost_fill_rule rule;
    /* both meshes before snapping; they have no triangles if they are not known, as in a reduced case */
    ost_mesh raw[2];
    bool grid_given; /* true: the grid is given and not computed from the meshes (AR-TOOL-2) */
} scene_tool;

typedef struct scene {
    /* The CT. If there are no samples, the stages up to chunks do not run. */
    ost_geometry rect;
    ost_sample *samples; /* owned unless `lent` is true; in the order in which the samples are scattered */
    bool lent;           /* true: the samples are borrowed from user_store.h and must not be changed */
    size_t sample_count, batch; /* batch: samples per call */
    ost_duplicates duplicates;
    ost_pm cubic;
    ost_resample resample;
    /* slices per call if a CT with one sample per lattice point is uploaded as slices; 0: it is passed as samples */
    int32_t slices;
    int chunk_size;
    int32_t threshold;

    int tool_count;
    scene_tool tools[SCENE_TOOLS_MAX];

    /* The ticks. If there are none, the case ends after the tools. If there are no samples, the bone's grid is rect,
       and only the steps (steps_record.h) are computed. */
    ost_world_options world;
    ost_path path;
    /* poses of the handle, from which path was computed with a motor speed of handle_rpm; empty without a motor */
    ost_path handle_path;
    int32_t handle_rpm;
    /* the backend also collides before each tick whose number is a multiple of this value; 0: never */
    int collide_every;

    ost_digest digest; /* digest of the members above if scene_digest was called; recorded in the trace */
} scene;

ost_status scene_make(const plan_case *c, scene *out, ost_error *err);
void scene_free(scene *s);
void scene_tool_free(scene_tool *tool);
/* Applies a motor to s->path, whose rows are poses of the handle. Moves these rows to s->handle_path and sets s->path
   to the tool's poses. */
ost_status scene_turn(scene *s, int32_t rpm, ost_error *err);

/* Computes the SHA-256 of all members, field by field in a fixed form. The evidence records it as the digest of the
   case's input. */
ost_status scene_digest(const scene *s, ost_digest *out, ost_error *err);

#endif
