/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Frames beside the loops that a run is compared with (haptics.h).
 *
 *   ticks        frames are drawn and counted, and of each is kept what it took: where the tool was, which voxels went
 *   busy, quiet  the last of them again, backward and forward, the bone with them: frames of the same work, not counted
 *   rested       no frames: a loop that only wakes when one would be due, then one that spends what a frame took at median.
 *                How often these two come is what the machine makes of frames, whoever draws them.
 *
 * Before anything else is drawn the bone is as it was.
 */
#ifndef OST_APP_SIM_BESIDE_H
#define OST_APP_SIM_BESIDE_H

#include <stdatomic.h>

#include "app/frame_times.h"
#include "render/viewer.h"

enum { SIM_BESIDE_FRAMES = 256, SIM_BESIDE_ROWS = 512, SIM_BESIDE_NOT_BEGUN = -1 };

/* Voxels of a row of a block that went. */
typedef struct sim_beside_row {
    int32_t slot;
    int32_t row;
    uint32_t went;
} sim_beside_row;

typedef struct sim_beside_frame {
    ost_pose pose;
    int count;
    sim_beside_row row[SIM_BESIDE_ROWS]; /* since the frame before */
} sim_beside_frame;

typedef struct sim_beside {
    _Atomic int stage; /* an ost_servo_stage, set by the loop's thread */
    bool wanted;       /* there will be something to compare with */
    /* The rest is whose frames they are. */
    sim_beside_frame *kept;  /* owned; SIM_BESIDE_FRAMES, the newest before next, around */
    int count, next;
    int back;                /* how many frames before the newest the bone is */
    bool forward, begun;
    uint32_t (*bone)[OST_BLOCK_ROWS]; /* owned; of each slot, at the newest */
    int32_t slots;
    int64_t rest_ns, last_ns; /* when the rest began, and its last turn; 0: not yet */
    bool spends;             /* that turn did */
    frame_times woken, spent; /* from one turn to the next */
} sim_beside;

void sim_beside_free(sim_beside *beside);
/* Whether frames are of the operation, to be counted and filmed. */
bool sim_beside_ticks(const sim_beside *beside);
/* Whether they are to be drawn although nothing has changed. */
bool sim_beside_again(const sim_beside *beside);
/* The viewer's update, and what it was is kept, or what was kept is put in its place. */
ost_status sim_beside_update(sim_beside *beside, ost_viewer *viewer, ost_error *err);
/* In place of a frame, which took what drawn says: false when one is to be drawn. */
bool sim_beside_rests(sim_beside *beside, const frame_times *drawn);

#endif
