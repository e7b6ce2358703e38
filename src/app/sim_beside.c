/* SPDX-License-Identifier: Apache-2.0 */
#include "app/sim_beside.h"

#include <osteon/haptics.h>

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

/* Lists that are newer than those of the frame before; no two have the same version. */
static void keep(sim_beside *b, const ost_viewer *viewer)
{
    sim_beside_frame *f = &b->kept[b->next];
    uint64_t newest = b->version;
    *f = (sim_beside_frame){.pose = viewer->state.pose};
    for (int32_t i = 0; i < viewer->bone.used; i++) {
        const uint64_t version = viewer->bone.slot[i]->version;
        if (version <= b->version)
            continue;
        newest = version > newest ? version : newest;
        if (f->count < SIM_BESIDE_BLOCKS)
            f->block[f->count++] = i;
    }
    /* The first that is seen is all of the bone; before the first tick the tool is nowhere. */
    if (b->version > 0 && viewer->has_state && viewer->state.ticks > 0) {
        b->next = (b->next + 1) % SIM_BESIDE_FRAMES;
        b->count += b->count < SIM_BESIDE_FRAMES;
    }
    b->version = newest;
}

/* Back to the oldest and forward to the newest, so that the tool never jumps. */
static ost_status put(sim_beside *b, ost_viewer *viewer, ost_error *err)
{
    const int way = b->count > 1 ? 2 * (b->count - 1) : 1, at = b->turn++ % way, back = at < b->count ? at : way - at;
    const sim_beside_frame *f = &b->kept[(b->next + SIM_BESIDE_FRAMES - 1 - back) % SIM_BESIDE_FRAMES];
    viewer->state.pose = f->pose;
    for (int i = 0; i < f->count; i++)
        viewer->bone.slot[f->block[i]]->dirty = true;
    return ost_surface_update(&viewer->bone, err);
}

ost_status sim_beside_update(sim_beside *beside, ost_viewer *viewer, ost_error *err)
{
    if (sim_beside_again(beside))
        return put(beside, viewer, err);
    if (beside->wanted && sim_beside_ticks(beside))
        keep(beside, viewer);
    return OST_OK;
}

/* By turns, since what a machine takes it takes in bursts. */
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
