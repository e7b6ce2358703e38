/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Entities and their components (thesis 2.1), as plain structs.
 *
 *   entity --+-- box      extents in the entity's own frame
 *            +-- input    pose of the last tick, and start of the next sweep
 *            +-- mesh     surface for pictures
 *            '-- voxels   voxels on the backend
 *
 * The bone is an entity that does not move; its frame is the frame of the world.
 * Tools are moved by ticks.  In the thesis the box also contains the pose and is
 * centred on the entity; here the pose maps the entity's own frame to the bone's
 * frame, and the box is a property of the entity (docs/design/thesis-notes.md).
 */
#ifndef OST_SIM_ENTITY_H
#define OST_SIM_ENTITY_H

#include <osteon/sim.h>

/* A box, given by two opposite corners in the entity's own frame, lo <= hi. */
typedef struct ost_box {
    ost_pm3 lo, hi;
} ost_box;

typedef struct ost_input_component {
    ost_pose pose;  /* pose of the last tick */
    ost_pose event; /* start of the next sweep: pose of the last event, or of the last tick with the motor off */
} ost_input_component;

typedef struct ost_mesh_component {
    const ost_mesh *mesh; /* borrowed; NULL in a world without pictures */
} ost_mesh_component;

/* The voxels of an entity. Either the bone or the tool is set; both are borrowed. */
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
