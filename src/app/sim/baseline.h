/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Frames during the control runs that an operation is compared with (ost_servo_stage in haptics.h).
 *
 *   ticks        frames are drawn and counted; the tool's pose and the removed voxels of each are stored
 *   busy, quiet  the last stored frames are drawn again, backward and forward, with the bone of that
 *                moment: the same work, but not counted
 *   rested       no frames are drawn: a loop that only wakes when a frame would be due alternates with
 *                one that spins for the median duration of a frame. The intervals of the two show the
 *                machine's share in the frame times, independent of any renderer.
 *
 * Before anything else is drawn the bone is restored to its current state.
 */
#ifndef OST_APP_SIM_BASELINE_H
#define OST_APP_SIM_BASELINE_H

#include <stdatomic.h>

#include "app/film/frame_times.h"
#include "render/viewer.h"

enum { SIM_BESIDE_FRAMES = 256, SIM_BESIDE_ROWS = 512, SIM_BESIDE_NOT_BEGUN = -1 };

/* The removed voxels of a row of a block. */
typedef struct sim_beside_row {
    int32_t slot;
    int32_t row;
    uint32_t went;
} sim_beside_row;

typedef struct sim_beside_frame {
    ost_pose pose;
    int count;
    sim_beside_row row[SIM_BESIDE_ROWS]; /* changes since the previous frame */
} sim_beside_frame;

typedef struct sim_beside {
    _Atomic int stage; /* an ost_servo_stage, set by the servo thread */
    bool wanted;       /* there will be a control run */
    /* The remaining fields belong to the thread that draws the frames. */
    sim_beside_frame *kept;  /* owned; ring of SIM_BESIDE_FRAMES; the newest is the one before next */
    int count, next;
    int back;                /* number of frames by which the bone is behind the newest */
    bool forward, begun;
    uint32_t (*bone)[OST_BLOCK_ROWS]; /* owned; occupancy of each slot at the newest frame */
    int32_t slots;
    int64_t rest_ns, last_ns; /* begin of the rested stage, and its last turn; 0: not yet */
    bool spends;             /* the last turn spun */
    frame_times woken, spent; /* intervals between turns */
} sim_beside;

void sim_beside_free(sim_beside *beside);
/* Returns true if frames show the operation and are to be counted and filmed. */
bool sim_beside_ticks(const sim_beside *beside);
/* Returns true if frames are to be drawn although nothing has changed. */
bool sim_beside_again(const sim_beside *beside);
/* Updates the viewer. During the ticks the frame's changes are stored; during a control run a
   stored frame is restored instead. */
ost_status sim_beside_update(sim_beside *beside, ost_viewer *viewer, ost_error *err);
/* Executes one turn of the rested stage in place of a frame; its duration is the median of drawn.
   Returns false in any other stage: then a frame is to be drawn. */
bool sim_beside_rests(sim_beside *beside, const frame_times *drawn);

#endif
