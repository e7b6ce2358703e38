/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The state of a world. world.c creates it and step.c advances it; a failover (failover.c) replaces the
 * bone and the tools.
 */
#ifndef OST_SIM_WORLD_H
#define OST_SIM_WORLD_H

#include "sim/entity.h"

/* The state that the next tick needs, except for the poses of the tools. */
typedef struct ost_world_clock {
    int tool;          /* tool in use; -1 before the first tick */
    bool running;      /* true if the motor was on in the last tick */
    int64_t t_ns;      /* time of the last tick */
    int64_t removal_t; /* time of the last removal event with the tool in use */
    int64_t turned;    /* rotation since the last event or stop of the motor, in rpm ns; at most OST_MOTOR_TURN */
    ost_world_totals totals;
} ost_world_clock;

/* The data from which a failover starts; see failover.c. */
typedef struct ost_world_saved {
    int16_t *voxels; /* owned; the bone's voxels before ticks[0] */
    uint8_t *tools[OST_WORLD_TOOLS_MAX]; /* owned; classes of all voxels of each tool */
    ost_tick *ticks; /* owned; options.saved_ticks elements; the first `count` are the ticks since the copy */
    int32_t count;
    /* State of the world before ticks[0]. */
    ost_input_component inputs[OST_WORLD_TOOLS_MAX];
    ost_world_clock clock;
} ost_world_saved;

struct ost_world {
    ost_world_options options;
    ost_geometry geometry; /* geometry of the bone */
    int chunk_size;
    ost_entity bone;
    ost_entity tools[OST_WORLD_TOOLS_MAX];
    int tool_count;

    ost_world_clock clock;

    ost_world_saved *saved; /* owned; NULL if saved_ticks is 0 */

    /* Scratch for one event. The scratch grows if a longer sweep needs more. */
    int capacity;
    ost_map *maps;        /* owned */
    ost_voxel_box *boxes; /* owned */
    ost_removal_report report;    /* owned; report of the last event */
};

/* ----------------------------------------------------------------- saved.c */

/* The functions of saved.c do nothing if saved_ticks is 0. */
ost_status ost_world_saved_make(ost_world *world, ost_error *err);
void ost_world_saved_free(ost_world *world);
ost_status ost_world_save_tool(ost_world *world, int index, const ost_tool *tool, ost_error *err);
/* Called before a tick. If `ticks` is full, copies the bone. */
ost_status ost_world_save(ost_world *world, ost_error *err);
/* Stores the tick. Called after a completed tick. Cannot fail. */
void ost_world_save_tick(ost_world *world, const ost_tick *tick);

/* -------------------------------------------------------------------- world.c */

/* Reserves scratch for an event of `count` poses. */
ost_status ost_world_reserve_poses(ost_world *world, int count, ost_error *err);

/* -------------------------------------------------------------------- step.c */

/* Advances the world as ost_world_step does, but does not store the tick for a failover. `result` must not be NULL. */
ost_status ost_world_advance(ost_world *world, const ost_tick *tick, ost_step_result *result, ost_error *err);

#endif
