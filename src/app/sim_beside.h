/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Frames beside the loops that a run is compared with (haptics.h).
 *
 *   ticks        frames are drawn and counted, and of each is kept what it took: where the tool was, which blocks were listed
 *   busy, quiet  the last of them again, backward and forward: as many frames of the same work, not counted
 *   rested       no frames: a loop that only wakes when one would be due, then one that spends what a frame took at median.
 *                How often these two come is what the machine makes of frames, whoever draws them.
 */
#ifndef OST_APP_SIM_BESIDE_H
#define OST_APP_SIM_BESIDE_H

#include <stdatomic.h>

#include "app/frame_times.h"
#include "render/viewer.h"

enum { SIM_BESIDE_FRAMES = 256, SIM_BESIDE_BLOCKS = 64, SIM_BESIDE_NOT_BEGUN = -1 };

typedef struct sim_beside_frame {
    ost_pose pose;
    int count;
    int32_t block[SIM_BESIDE_BLOCKS]; /* slots of the bone's surface */
} sim_beside_frame;

typedef struct sim_beside {
    _Atomic int stage; /* an ost_servo_stage, set by the loop's thread */
    bool wanted;       /* there will be something to compare with */
    /* The rest is whose frames they are. */
    sim_beside_frame kept[SIM_BESIDE_FRAMES]; /* the newest is before next, around */
    int count, next, turn;
    uint64_t version;        /* of the newest list of a block */
    int64_t rest_ns, last_ns; /* when the rest began, and its last turn; 0: not yet */
    bool spends;             /* that turn did */
    frame_times woken, spent; /* from one turn to the next */
} sim_beside;

/* Whether frames are of the operation, to be counted and filmed. */
bool sim_beside_ticks(const sim_beside *beside);
/* Whether they are to be drawn although nothing has changed. */
bool sim_beside_again(const sim_beside *beside);
/* After an update of the viewer: keeps what it was, or puts what was kept in its place. */
ost_status sim_beside_update(sim_beside *beside, ost_viewer *viewer, ost_error *err);
/* In place of a frame, which took what drawn says: false when one is to be drawn. */
bool sim_beside_rests(sim_beside *beside, const frame_times *drawn);

#endif
