/* SPDX-License-Identifier: Apache-2.0 */
/* The world's state. world.c makes it, step.c advances it; nothing else changes it. */
#ifndef OST_SIM_WORLD_H
#define OST_SIM_WORLD_H

#include "sim/entity.h"

/* What one tick leaves to the next, apart from the tools' poses. */
typedef struct ost_world_clock {
    int tool;          /* in use; -1 before the first tick */
    bool running;      /* the motor was on in the last tick */
    int64_t t_ns;      /* of the last tick */
    int64_t removal_t; /* of the last removal event while this tool is in use */
    int64_t turned;    /* by the motor since the last event or stop, in rpm ns; at most OST_MOTOR_TURN */
    ost_world_totals totals;
} ost_world_clock;

/* What a rescue begins with (rescue.c). */
typedef struct ost_world_kept {
    int16_t *voxels; /* owned; of the bone, before the first of ticks */
    uint8_t *tools[OST_WORLD_TOOLS_MAX]; /* owned; each tool's classes */
    ost_tick *ticks; /* owned; room for options.keep_ticks; whole ticks since */
    int32_t count;
    /* The world's state before the first of ticks. */
    ost_input_component inputs[OST_WORLD_TOOLS_MAX];
    ost_world_clock clock;
} ost_world_kept;

struct ost_world {
    ost_world_options options;
    ost_geometry geometry; /* of the bone */
    int chunk_size;
    ost_entity bone;
    ost_entity tools[OST_WORLD_TOOLS_MAX];
    int tool_count;

    ost_world_clock clock;

    ost_world_kept *kept; /* owned; NULL with keep_ticks 0 */

    /* Scratch of one event, grown when a sweep needs more. */
    int capacity;
    ost_map *maps;        /* owned */
    ost_voxel_box *boxes; /* owned */
    ost_report report;    /* owned; of the last event */
};

/* ---------------------------------------------------------------- rescue.c */

/* All of these do nothing without keep_ticks. */
ost_status ost_world_kept_make(ost_world *world, ost_error *err);
void ost_world_kept_free(ost_world *world);
ost_status ost_world_keep_tool(ost_world *world, int index, const ost_tool *tool, ost_error *err);
/* Before a tick: a copy of the bone if the ticks fill their room. */
ost_status ost_world_keep(ost_world *world, ost_error *err);
/* After a whole tick; cannot fail. */
void ost_world_keep_tick(ost_world *world, const ost_tick *tick);

/* -------------------------------------------------------------------- world.c */

/* Scratch for an event of count poses. */
ost_status ost_world_make_room(ost_world *world, int count, ost_error *err);

/* -------------------------------------------------------------------- step.c */

/* ost_world_step without keeping; result is not NULL. */
ost_status ost_world_advance(ost_world *world, const ost_tick *tick, ost_step_result *result, ost_error *err);

#endif
