/* SPDX-License-Identifier: Apache-2.0 */
#include "app/sim/baseline.h"

#include <osteon/haptics.h>
#include <stdlib.h>
#include <string.h>

#include "core/clock.h"

static const int64_t TURN_NS = 250000000;

static int stage_of(const sim_beside *b)
{
    return atomic_load(&b->stage);
}

bool sim_beside_ticks(const sim_beside *beside)
{
    return stage_of(beside) == OST_SERVO_TICKING;
}

bool sim_beside_again(const sim_beside *beside)
{
    return beside->count > 0 && (stage_of(beside) == OST_SERVO_BUSY || stage_of(beside) == OST_SERVO_QUIET);
}

void sim_beside_free(sim_beside *beside)
{
    free(beside->kept);
    free(beside->bone);
    beside->kept = NULL;
    beside->bone = NULL;
}

static sim_beside_frame *frame_at(const sim_beside *b, int back)
{
    return &b->kept[(b->next + SIM_BESIDE_FRAMES - 1 - back) % SIM_BESIDE_FRAMES];
}

/* Copies the bone when the first frame is about to be stored. Without memory no frame is stored. */
static bool begin(sim_beside *b, const ost_surface *bone)
{
    b->slots = bone->used;
    b->kept = calloc(SIM_BESIDE_FRAMES, sizeof *b->kept);
    b->bone = malloc(((size_t)b->slots + 1) * sizeof *b->bone);
    for (int32_t i = 0; b->bone && i < b->slots; i++)
        memcpy(b->bone[i], bone->slot[i]->occupied, sizeof b->bone[i]);
    b->wanted = b->kept && b->bone;
    return b->wanted;
}

/* Stores the voxels of a block that were removed since the previous frame. Rows for which there is
   no space go into the next frame. */
static void keep_block(sim_beside *b, sim_beside_frame *f, const ost_surface *bone, int32_t slot)
{
    const uint32_t *is = bone->slot[slot]->occupied;
    uint32_t *was = b->bone[slot];
    for (int row = 0; row < OST_BLOCK_ROWS && f->count < SIM_BESIDE_ROWS; row++) {
        if (was[row] == is[row])
            continue;
        f->row[f->count++] = (sim_beside_row){slot, row, was[row] ^ is[row]};
        was[row] = is[row];
    }
}

static void keep(sim_beside *b, const ost_viewer *viewer)
{
    const ost_surface *bone = &viewer->bone;
    if (!b->kept && !begin(b, bone))
        return;
    /* Before the first tick the tool has no pose. */
    if (!viewer->has_state || viewer->state.ticks == 0)
        return;
    sim_beside_frame *f = &b->kept[b->next];
    f->pose = viewer->state.pose;
    f->count = 0;
    for (int32_t i = 0; i < bone->renewals; i++)
        if (bone->renewed[i] < b->slots)
            keep_block(b, f, bone, bone->renewed[i]);
    b->next = (b->next + 1) % SIM_BESIDE_FRAMES;
    b->count += b->count < SIM_BESIDE_FRAMES;
}

/* Toggles the voxels of a frame: removed ones are restored, and restored ones removed again. Rows
   of one block are consecutive. */
static ost_status turn(const sim_beside_frame *f, ost_surface *bone, ost_error *err)
{
    ost_status status = OST_OK;
    for (int i = 0; i < f->count && status == OST_OK;) {
        const int32_t slot = f->row[i].slot;
        uint32_t words[OST_BLOCK_ROWS];
        memcpy(words, bone->slot[slot]->occupied, sizeof words);
        for (; i < f->count && f->row[i].slot == slot; i++)
            words[f->row[i].row] ^= f->row[i].went;
        status = ost_surface_set(bone, bone->slot[slot]->at, words, err);
    }
    return status;
}

/* Steps one frame back until the oldest one, then forward until the newest, so that the tool never jumps. */
static ost_status step(sim_beside *b, ost_surface *bone, ost_error *err)
{
    if (b->back == 0 || b->back == b->count - 1)
        b->forward = b->back > 0;
    if (b->count == 1)
        return OST_OK;
    const ost_status status = turn(frame_at(b, b->forward ? b->back - 1 : b->back), bone, err);
    b->back += b->forward ? -1 : 1;
    return status;
}

ost_status sim_beside_update(sim_beside *beside, ost_viewer *viewer, ost_error *err)
{
    const bool again = sim_beside_again(beside);
    ost_status status = OST_OK;
    beside->forward = beside->forward || !again;
    while (!again && beside->back > 0 && status == OST_OK)
        status = step(beside, &viewer->bone, err);
    if (status == OST_OK)
        status = ost_viewer_update(viewer, err);
    if (status != OST_OK)
        return status;
    /* The changes of the last tick may arrive with the first frame after it. */
    if (beside->wanted && (sim_beside_ticks(beside) || (again && !beside->begun)))
        keep(beside, viewer);
    if (!again)
        return OST_OK;
    beside->begun = true;
    status = step(beside, &viewer->bone, err);
    viewer->state.pose = frame_at(beside, beside->back)->pose;
    return status == OST_OK ? ost_surface_update(&viewer->bone, err) : status;
}

/* Alternates between turns that wake only and turns that spin, since other load on a machine comes
   in bursts. */
bool sim_beside_rests(sim_beside *beside, const frame_times *drawn)
{
    if (stage_of(beside) != OST_SERVO_RESTED)
        return false;
    const int64_t begin = ost_clock_ns();
    if (!beside->rest_ns)
        beside->rest_ns = begin;
    const bool spends = (begin - beside->rest_ns) / TURN_NS % 2 != 0;
    if (beside->last_ns && spends == beside->spends)
        frame_times_add(spends ? &beside->spent : &beside->woken, begin - beside->last_ns);
    beside->last_ns = begin;
    beside->spends = spends;
    const int64_t takes = spends ? (int64_t)(frame_times_ms(drawn, 0.5) * 1e6) : 0;
    while (ost_clock_ns() - begin < takes)
        ;
    return true;
}
