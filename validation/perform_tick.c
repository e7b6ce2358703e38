/* SPDX-License-Identifier: Apache-2.0 */
/* Runs the ticks of a case: poses and maps, the event on the backend, its report, and the leaves that it changed. */
#include "validation/perform_parts.h"

#include <stdlib.h>
#include <string.h>

/*
 * A bone of up to PERFORM_ALL_VOXELS voxels is downloaded completely after each tick. For a larger bone
 * only the slices that the event could reach are downloaded after a tick. The complete bone is downloaded
 * every ALL_VOXELS_EVERY ticks and at the end, so a change outside the event's reach is detected only at
 * these times. For a million voxels the download takes nine tenths of a tick's time, and more on a device.
 */
enum { ALL_VOXELS_EVERY = 32 };

/* If the number of voxels times the number of ticks is at most SECOND_WORK, the second implementation runs the events
   of the case. Per tick, it needs about a microsecond for a thousand voxels. */
#define SECOND_WORK ((int64_t)1 << 25)

/* Returns the density classes of the scene or, if it has none, the default classes of AR-CLS-2. */
static ost_density_classes classes_of(const performer *p)
{
    if (p->world)
        return *ost_world_classes(p->world);
    return p->s->world.classes.count ? p->s->world.classes
                                     : (ost_density_classes){.count = 3, .border = {120, 150, 650}};
}

ost_status perform_begin_ticks(performer *p, ost_error *err)
{
    const scene *s = p->s;
    ost_status status = OST_OK;
    if (perform_is_of_steps(s)) {
        p->geometry = s->rect;
        p->dims = s->rect.dims;
        return OST_OK;
    }
    if (!p->second) {
        status = ost_world_create(p->bone, &s->world, &p->world, err);
        for (int i = 0; i < s->tool_count && status == OST_OK; i++)
            status = ost_world_add_tool(p->world, s->tools[i].name, p->tools[i], NULL, err);
        return status;
    }
    const ost_pose identity = {.qw = OST_Q30_ONE};
    steps_pose ignored;
    /* Tools that AR-MAP-2 does not allow are refused before the first tick. */
    for (int i = 0; i < s->tool_count && status == OST_OK; i++)
        status = steps_pose_of(true, &identity, &p->geometry, &p->grids[i], &ignored, err);
    if (status == OST_OK)
        status = steps_history_begin(&p->path, s->world.sweep_off, s->world.removal_period_ns, &p->history, err);
    p->light = ost_dims_count(p->dims) * (int64_t)p->path.count > SECOND_WORK;
    if (status != OST_OK || p->light)
        return status;
    p->maps = calloc(OST_SWEEP_MAX, sizeof *p->maps);
    p->boxes = calloc(OST_SWEEP_MAX, sizeof *p->boxes);
    return p->maps && p->boxes ? OST_OK : ost_fail(err, OST_ERR_MEMORY, "out of memory for an event of %d poses",
                                                   OST_SWEEP_MAX);
}

/* Writes the totals of a report. Then writes for each chunk its number and, for each class, the voxel count and the
   density sum. */
static void record_report(performer *p, const ost_removal_report *r)
{
    const int classes = classes_of(p).count;
    trace_word(p->w, r ? r->total_voxels : 0);
    trace_word(p->w, r ? r->touched_voxels : 0);
    trace_word(p->w, r ? r->count : 0);
    for (size_t i = 0; r && i < r->count; i++) {
        trace_word(p->w, (uint64_t)(int64_t)r->chunks[i].chunk);
        for (int c = 0; c < classes; c++) {
            trace_word(p->w, r->chunks[i].voxels[c]);
            trace_word(p->w, (uint64_t)r->chunks[i].density[c]);
        }
    }
}

/* Writes blocks for the leaves in slices [z0, z1) in which the array `is` differs from the array `was`. Copies these
   leaves to `was`. */
static void record_changed(performer *p, int32_t z0, int32_t z1)
{
    const ost_dims d = p->dims;
    for (int32_t z = z0; z < z1; z += OST_LEAF)
        for (int32_t y = 0; y < d.y; y += OST_LEAF)
            for (int32_t x = 0; x < d.x; x += OST_LEAF) {
                const ost_dims n = {d.x - x < OST_LEAF ? d.x - x : OST_LEAF, d.y - y < OST_LEAF ? d.y - y : OST_LEAF,
                                    d.z - z < OST_LEAF ? d.z - z : OST_LEAF};
                bool changed = false;
                for (int32_t k = 0; k < n.z && !changed; k++)
                    for (int32_t j = 0; j < n.y && !changed; j++) {
                        const size_t at = perform_at(d, x, y + j, z + k);
                        changed = memcmp(p->is + at, p->was + at, (size_t)n.x * 2) != 0;
                    }
                if (!changed)
                    continue;
                const int32_t lo[3] = {x, y, z};
                int16_t *to = trace_block(p->w, lo, n, 2);
                for (int32_t k = 0; k < n.z; k++)
                    for (int32_t j = 0; j < n.y; j++) {
                        const size_t at = perform_at(d, x, y + j, z + k);
                        if (to)
                            memcpy(to + (size_t)n.x * ((size_t)j + (size_t)n.y * (size_t)k), p->is + at,
                                   (size_t)n.x * 2);
                        memcpy(p->was + at, p->is + at, (size_t)n.x * 2);
                    }
            }
}

/* Computes the poses and maps of an event on the backend, so that they are recorded and compared. The sweep begins at
   *from and ends at the pose of the tick. The event itself runs with the poses and maps that the host computed. */
static ost_status steps_by_backend(performer *p, const ost_tick *tick, int handed, const ost_pose *from, int *count,
                                   bool *made, ost_error *err)
{
    if (p->second || !p->backend->ops->steps)
        return OST_OK;
    if (!p->made_poses)
        p->made_poses = malloc(OST_SWEEP_MAX * sizeof *p->made_poses);
    if (!p->made_maps)
        p->made_maps = malloc(OST_SWEEP_MAX * sizeof *p->made_maps);
    if (!p->made_poses || !p->made_maps)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %d poses", OST_SWEEP_MAX);
    int its = handed;
    const bool sweeps = memcmp(from, &tick->pose, sizeof *from) != 0;
    const ost_status status =
        p->backend->ops->steps(p->backend, &p->geometry, &p->grids[tick->tool], sweeps ? from : NULL, &tick->pose, &its,
                               p->made_poses, p->made_maps, err);
    if (status == OST_ERR_UNAVAILABLE)
        return OST_OK;
    *made = status == OST_OK || status == OST_ERR_RANGE; /* OST_ERR_RANGE: the event is refused and has no poses */
    *count = status == OST_OK ? its : status == OST_ERR_RANGE ? 0 : handed;
    return *made ? OST_OK : status;
}

/* Extends p->range, the range of chunks that the event must cover, by the chunks that the box meets. */
static void widen_range(performer *p, const ost_voxel_box *box)
{
    const int32_t size = p->s->chunk_size;
    for (int a = 0; a < 3; a++) {
        const int32_t lo = box->lo[a] / size, hi = (box->hi[a] - 1) / size + 1;
        p->range.chunk_lo[a] = !p->range.boxes_meet || lo < p->range.chunk_lo[a] ? lo : p->range.chunk_lo[a];
        p->range.chunk_hi[a] = !p->range.boxes_meet || hi > p->range.chunk_hi[a] ? hi : p->range.chunk_hi[a];
    }
    p->range.boxes_meet = true;
}

/* Records the poses of the sweep from `from` to the pose of tick i. If p->maps is not NULL, also stores the map of each
   pose in p->maps. The event is executed later with these maps. */
static ost_status record_steps(performer *p, size_t i, bool refused, bool removal, int count, const ost_pose *from,
                               ost_error *err)
{
    const ost_tick *tick = &p->path.ticks[i];
    bool made_by_backend = false;
    ost_status status = removal ? steps_by_backend(p, tick, count, from, &count, &made_by_backend, err) : OST_OK;
    trace_begin(p->w, TRACE_STEPS, p->case_index, (uint32_t)i);
    trace_flags(p->w, (p->second ? TRACE_BOUNDS : 0) | (made_by_backend ? TRACE_MADE : 0));
    steps_put_tick(p->w, refused, removal, count, tick);
    for (int k = 1; k <= count && status == OST_OK; k++) {
        const ost_pose pose = made_by_backend ? p->made_poses[k - 1]
                                              : steps_between(p->second, from, &tick->pose, k, count);
        steps_pose made;
        status = steps_pose_of(p->second, &pose, &p->geometry, &p->grids[tick->tool], &made, err);
        if (status != OST_OK)
            break;
        if (made_by_backend)
            made.map = p->made_maps[k - 1];
        steps_put_pose(p->w, &made);
        if (p->second && made.reaches)
            widen_range(p, &made.box);
        if (p->maps) {
            p->maps[k - 1] = made.map;
            p->boxes[k - 1] = (ost_voxel_box){.hi = {p->dims.x, p->dims.y, p->dims.z}};
        }
    }
    const ost_status written = perform_end_record(p, TRACE_STEPS, (uint32_t)i, err);
    return status != OST_OK ? status : written;
}

/* Advances the world by tick i. */
static ost_status step_of_world(performer *p, size_t i, ost_step_result *r, bool *refused, ost_error *err)
{
    const ost_tick *tick = &p->path.ticks[i];
    const ost_world *world = p->world;
    const bool restarts = tick->tool != world->clock.tool || tick->lifted || world->options.sweep_off;
    const ost_pose from = restarts ? tick->pose : world->tools[tick->tool].input.event;
    ost_error why = {0};
    const ost_status stepped = ost_world_step(p->world, tick, r, &why);
    /* a motion that is too long is a result and is recorded; any other error is a failure */
    *refused = stepped == OST_ERR_RANGE;
    if (stepped != OST_OK && !*refused) {
        *err = why;
        return stepped;
    }
    return record_steps(p, i, *refused, r->removal, r->pose_count, &from, err);
}

/* Runs tick i with the second implementation, which has no world and no bounding box: every pose is tested against
   the complete grid. */
static ost_status step_of_second(performer *p, size_t i, ost_step_result *r, bool *refused, ost_error *err)
{
    const ost_tick *tick = &p->path.ticks[i];
    const steps_event e = steps_next(&p->history, i, &p->grids[tick->tool], p->geometry.spacing.x);
    const ost_density_classes classes = classes_of(p);
    *refused = e.refused;
    p->range = (ost_step_result){.chunk_lo = {INT32_MAX, INT32_MAX, INT32_MAX}}; /* empty; widen_range extends it */
    ost_status status = record_steps(p, i, e.refused, e.removal, e.count, &e.from, err);
    *r = p->range;
    r->removal = e.removal;
    r->pose_count = e.count;
    if (status != OST_OK || !e.removal || p->light)
        return status;
    const ost_removal_event event = {.pose_count = e.count, .maps = p->maps, .boxes = p->boxes, .classes = &classes};
    r->report = &p->removed;
    return ost_bone_remove(p->bone, p->tools[tick->tool], &event, &p->removed, err);
}

ost_status perform_tick(performer *p, size_t i, ost_error *err)
{
    const ost_dims d = p->dims;
    ost_step_result r = {0};
    bool refused;
    ost_status status = (p->second ? step_of_second : step_of_world)(p, i, &r, &refused, err);
    if (status != OST_OK)
        return status;
    if (p->light)
        return perform_record_nothing(p, TRACE_TICK, (uint32_t)i, err);
    trace_begin(p->w, TRACE_TICK, p->case_index, (uint32_t)i);
    if (p->second)
        trace_flags(p->w, TRACE_BOUNDS);
    trace_word(p->w, refused ? OST_ERR_RANGE : OST_OK);
    trace_word(p->w, r.removal);
    trace_word(p->w, r.boxes_meet);
    trace_word(p->w, (uint64_t)r.pose_count);
    for (int a = 0; a < 3; a++) {
        trace_word(p->w, (uint64_t)(int64_t)r.chunk_lo[a]);
        trace_word(p->w, (uint64_t)(int64_t)r.chunk_hi[a]);
    }
    record_report(p, r.report);
    int32_t z0 = 0, z1 = d.z;
    if (ost_dims_count(d) > PERFORM_ALL_VOXELS && (i + 1) % ALL_VOXELS_EVERY != 0 && !p->second) {
        const int32_t size = p->s->chunk_size;
        z0 = r.chunk_lo[2] * size / OST_LEAF * OST_LEAF;
        z1 = (r.chunk_hi[2] * size + OST_LEAF - 1) / OST_LEAF * OST_LEAF;
        z0 = z0 < 0 ? 0 : z0;
        z1 = z1 > d.z ? d.z : z1;
    }
    if (z0 < z1) {
        status = ost_bone_download(p->bone, z0, z1 - z0, p->is + perform_at(d, 0, 0, z0), err);
        if (status == OST_OK)
            record_changed(p, z0, z1);
    }
    ost_status written = perform_end_record(p, TRACE_TICK, (uint32_t)i, err);
    if (status == OST_OK && written == OST_OK)
        status = perform_give_tick(p, (uint32_t)i, z0, z1, err);
    return status != OST_OK ? status : written;
}

ost_status perform_steps(performer *p, size_t i, ost_error *err)
{
    const ost_tick *tick = &p->path.ticks[i];
    int count = 1;
    ost_pose from = tick->pose;
    if (i > 0 && tick[-1].tool == tick->tool && !tick->lifted && !p->s->world.sweep_off) {
        from = tick[-1].pose;
        count = steps_count_of(p->second, &from, &tick->pose, &p->grids[tick->tool], p->geometry.spacing.x);
    }
    return record_steps(p, i, count == 0, count > 0, count, &from, err);
}

ost_status perform_collide(performer *p, size_t i, ost_error *err)
{
    const ost_tick *tick = &p->path.ticks[i];
    steps_pose made;
    if (p->light)
        return perform_record_nothing(p, TRACE_COLLIDE, (uint32_t)i, err);
    ost_status status = steps_pose_of(p->second, &tick->pose, &p->geometry, &p->grids[tick->tool], &made, err);
    if (status != OST_OK)
        return status;
    const ost_voxel_box box = {{0, 0, 0}, {p->dims.x, p->dims.y, p->dims.z}};
    const ost_density_classes classes = classes_of(p);
    const ost_removal_event event = {.pose_count = 1, .maps = &made.map, .boxes = &box, .classes = &classes};
    status = ost_bone_collide(p->bone, p->tools[tick->tool], &event, &p->collided, err);
    if (status != OST_OK)
        return status;
    trace_begin(p->w, TRACE_COLLIDE, p->case_index, (uint32_t)i);
    record_report(p, &p->collided);
    return perform_end_record(p, TRACE_COLLIDE, (uint32_t)i, err);
}
