/* SPDX-License-Identifier: Apache-2.0 */
/* Declares removal and collision of the CPU backend, and their scratch memory, which all events share. */
#ifndef OST_CPU_REMOVE_EVENT_H
#define OST_CPU_REMOVE_EVENT_H

#include "cpu/remove/block_base.h"
#include "cpu/bone/bone.h"
#include "cpu/kernels.h"

/* The tables of one pose. They are computed before the pose is applied to the first chunk. */
typedef struct ost_pose_plan {
    /* split[0] divides blocks into cubes of 8^3 voxels; split[1] divides cubes into bricks of 4^3 voxels */
    ost_split split[2];
    ost_match match;
    ost_block_bases bases;
    ost_voxel_box box; /* the pose's box, clipped to the bone's grid */
    ost_block_reach reach;
} ost_pose_plan;

typedef struct ost_event_chunk {
    int32_t index, first[3];
    cpu_chunk *chunk;
    uint64_t *occupancy; /* occupancy words of the chunk, or a copy of them that the event may change */
    ost_tally tally, touched;
} ost_event_chunk;

typedef struct ost_event_scratch {
    ost_pose_plan plan;
    ost_event_chunk *chunks; /* owned */
    size_t count, capacity;
    uint64_t *copies; /* owned */
    size_t copy_capacity;
} ost_event_scratch;

void ost_event_scratch_free(ost_event_scratch *scratch);

ost_status ost_cpu_remove(ost_bone *bone, const ost_tool *tool, const ost_removal_event *event,
                          ost_removal_report *report, ost_error *err);
ost_status ost_cpu_collide(const ost_bone *bone, const ost_tool *tool, const ost_removal_event *event,
                           ost_removal_report *report, ost_error *err);

#endif
