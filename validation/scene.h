/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A case's inputs, as every backend is given them: integers, made from the
 * case's name and the campaign's seed and nothing else.
 *
 *   plan_case --scene_make--> samples, snapped meshes, ticks
 *
 * What lies before them (files, floats of meshes and phantoms) ends here and
 * is hashed as input.
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
    ost_snapped_mesh cutting, noncutting; /* noncutting has no triangle where there is none */
    ost_fill_rule rule;
    ost_mesh raw[2]; /* of both before they were snapped; without triangles where they are not known, as in a case that was cut */
    bool grid_given; /* the grid is not laid around them (AR-TOOL-2) */
} scene_tool;

typedef struct scene {
    /* A CT; no samples: none of the stages up to chunks runs. */
    ost_geometry rect;
    ost_sample *samples; /* owned, but when lent; in the order in which they are scattered */
    bool lent;           /* samples are the user's own, in user_store.h: not to be changed */
    size_t sample_count, batch; /* batch samples a call */
    ost_duplicates duplicates;
    ost_pm cubic;
    ost_resample resample;
    int32_t slices; /* 0: the CT comes in samples; else it is uploaded in so many slices a call, and its samples are one a voxel, on the lattice */
    int chunk_size;
    int32_t threshold;

    int tool_count;
    scene_tool tools[SCENE_TOOLS_MAX];

    /* Ticks; none: the case ends with the tools. Without samples the bone's grid is rect, and no more than the steps are made. */
    ost_world_options world;
    ost_path path;
    ost_path hand;    /* the rows of a hand that path was made of by a motor of hand_rpm; none: path is the tools' */
    int32_t hand_rpm;
    int collide_every; /* before every so-manieth tick collide is asked as well; 0: never */

    ost_digest digest; /* of all above, where somebody has set it by scene_digest; it goes into the trace */
} scene;

ost_status scene_make(const plan_case *c, scene *out, ost_error *err);
void scene_free(scene *s);
void scene_tool_free(scene_tool *tool);
/* Gives the path, whose rows are a hand's, a motor: the rows stay in hand. */
ost_status scene_turn(scene *s, int32_t rpm, ost_error *err);

/* SHA-256 over all of it, field by field in a fixed form: what the evidence calls the case's input. */
ost_status scene_digest(const scene *s, ost_digest *out, ost_error *err);

#endif
