/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Entities and their components (thesis 2.1), as plain structs.
 *
 *   entity --+-- box      where it ends, in its own frame
 *            +-- input    where it is: the pose, and the one before
 *            +-- mesh     what a picture draws of it
 *            '-- voxels   what it is made of, on the backend
 *
 * The bone is an entity that never moves: its frame is the world's.  Tools
 * are moved by ticks.  The thesis' box is also the pose, centred on the
 * entity; here the pose takes the entity's own frame into the bone's, and the
 * box is data about the entity (docs/thesis-notes.md).
 */
#ifndef OST_SIM_ENTITY_H
#define OST_SIM_ENTITY_H

#include <osteon/sim.h>

/* Corners in the entity's own frame, lo <= hi. */
typedef struct ost_box {
    ost_pm3 lo, hi;
} ost_box;

typedef struct ost_input_component {
    ost_pose pose;  /* of the last tick */
    ost_pose event; /* where the next sweep begins: of the last event's tick, or of the last tick with the motor off */
} ost_input_component;

typedef struct ost_mesh_component {
    const ost_mesh *mesh; /* borrowed; NULL in a world without pictures */
} ost_mesh_component;

/* One of the two; borrowed. */
typedef struct ost_voxel_component {
    ost_bone *bone;
    const ost_tool *tool;
} ost_voxel_component;

typedef struct ost_entity {
    char name[64];
    ost_box box;
    ost_input_component input;
    ost_mesh_component mesh;
    ost_voxel_component voxels;
} ost_entity;

#endif
