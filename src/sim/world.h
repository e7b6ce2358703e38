/* SPDX-License-Identifier: Apache-2.0 */
/* The world's state. world.c makes it, step.c advances it; nothing else changes it. */
#ifndef OST_SIM_WORLD_H
#define OST_SIM_WORLD_H

#include "sim/entity.h"

struct ost_world {
    ost_world_options options;
    ost_geometry geometry; /* of the bone */
    int chunk_size;
    ost_entity bone;
    ost_entity tools[OST_WORLD_TOOLS_MAX];
    int tool_count;

    /* Between ticks. */
    int tool;          /* in use; -1 before the first tick */
    int64_t t_ns;      /* of the last tick */
    int64_t removal_t; /* of the last removal event of this tool selection */
    ost_world_totals totals;

    /* Scratch of one event, grown when a sweep needs more. */
    int capacity;
    ost_map *maps;        /* owned */
    ost_voxel_box *boxes; /* owned */
    ost_report report;    /* owned; of the last event */
};

#endif
