/* SPDX-License-Identifier: Apache-2.0 */
/* Runs events on dense arrays (AR-REM, AR-CLS): makes the marks of all poses, then makes the report, and then removes
   the voxels. */
#include "validation/dense/parts.h"

#include <stdlib.h>
#include <string.h>

/* A chunk, with the range lo <= v < hi of its voxels. */
typedef struct cube {
    int32_t number;
    int32_t lo[3], hi[3];
} cube;

static ost_dims chunk_dims(const dense_bone *bone)
{
    const int32_t n = bone->base.chunk_size;
    const ost_dims d = bone->base.geometry.dims;
    return (ost_dims){(d.x + n - 1) / n, (d.y + n - 1) / n, (d.z + n - 1) / n};
}

static cube cube_of(const dense_bone *bone, int32_t number)
{
    const ost_dims c = chunk_dims(bone), d = bone->base.geometry.dims;
    const int32_t n = bone->base.chunk_size, at[3] = {number % c.x, number / c.x % c.y, number / c.x / c.y},
                  dims[3] = {d.x, d.y, d.z};
    cube k = {.number = number};
    for (int a = 0; a < 3; a++) {
        k.lo[a] = at[a] * n;
        k.hi[a] = (at[a] + 1) * n < dims[a] ? (at[a] + 1) * n : dims[a];
    }
    return k;
}

/* Iterates over the voxels of a cube. `v` receives the coordinates of each voxel, and `at` its index. */
#define EACH_VOXEL(bone, k, v, at)                                                                         \
    for (int32_t v[3] = {0, 0, (k).lo[2]}; v[2] < (k).hi[2]; v[2]++)                                       \
        for (v[1] = (k).lo[1]; v[1] < (k).hi[1]; v[1]++)                                                   \
            for (int64_t at = (v[0] = (k).lo[0], dense_at((bone)->base.geometry.dims, v[0], v[1], v[2]));  \
                 v[0] < (k).hi[0]; v[0]++, at++)

static ost_status marks_for(const dense_bone *bone, dense_marks *out, ost_error *err)
{
    const size_t count = (size_t)ost_dims_count(bone->base.geometry.dims);
    out->cut = calloc(count, sizeof *out->cut);
    out->touch = calloc(count, sizeof *out->touch);
    out->met = calloc((size_t)ost_dims_count(chunk_dims(bone)), sizeof *out->met);
    return out->cut && out->touch && out->met
               ? OST_OK
               : ost_fail(err, OST_ERR_MEMORY, "out of memory for the marks of %zu voxels", count);
}

static void free_marks(dense_marks *marks)
{
    free(marks->cut);
    free(marks->touch);
    free(marks->met);
}

static void mark(deviant *m, const dense_bone *bone, const dense_tool *tool, const ost_removal_event *event,
                 const ost_map *stale, dense_marks marks)
{
    bool fused;
    for (int p = 0; p < event->pose_count; p++) {
        const ost_map *map = &event->maps[p];
        if (p == 0 && stale && deviates(m, DEVIATION_STALE_POSE, 0)) {
            map = stale;
            deviant_acted(m, 0, NULL);
        }
        if (p + 1 < event->pose_count && deviates(m, DEVIATION_OMITTED_SWEEP_STEP, (uint64_t)p)) {
            deviant_acted(m, (uint64_t)p, NULL);
            continue;
        }
        if (deviant_thesis(m, &fused))
            dense_thesis_pose(bone, tool, map, fused, marks);
        else
            dense_map_pose(m, bone, tool, map, &event->boxes[p], p, marks);
    }
}

/* Clears all marks in the last chunk that has a hit. This is one of the deliberate mistakes. */
static void lose_last_chunk(deviant *m, const dense_bone *bone, dense_marks marks)
{
    if (!deviates(m, DEVIATION_LAST_CHUNK_LOST, 0))
        return;
    for (int32_t number = (int32_t)ost_dims_count(chunk_dims(bone)) - 1; number >= 0; number--) {
        const cube k = cube_of(bone, number);
        bool hit = false;
        if (!marks.met[number])
            continue;
        EACH_VOXEL (bone, k, v, at)
            hit = hit || marks.cut[at];
        if (!hit)
            continue;
        EACH_VOXEL (bone, k, v, at)
            marks.cut[at] = marks.touch[at] = 0;
        deviant_acted(m, 0, k.lo);
        return;
    }
}

/* ---------------------------------------------------------------- report */

/* Returns the density class by AR-CLS-1. If `above` is true, the function makes a deliberate mistake: it compares
   density > border instead of density >= border. */
static int class_of(const ost_density_classes *classes, int16_t density, bool above)
{
    int found = 0;
    for (int c = 0; c < classes->count; c++)
        if (above ? classes->border[c] < density : classes->border[c] <= density)
            found = c;
    return found;
}

static ost_status report_chunk(deviant *m, const dense_bone *bone, const cube *k, dense_marks marks,
                               const ost_density_classes *classes, ost_removal_report *report, ost_error *err)
{
    const uint64_t item = (uint64_t)k->number;
    const bool above = deviates(m, DEVIATION_CLASS_BORDER, item), often = deviates(m, DEVIATION_COUNTED_PER_POSE, item),
               floats = deviates(m, DEVIATION_FLOAT_SUM, item), twice = deviates(m, DEVIATION_TOUCHED_THOUGH_HIT, 0);
    ost_chunk_report part = {.chunk = k->number};
    float sums[OST_CLASS_MAX] = {0};
    bool hit = false;
    EACH_VOXEL (bone, *k, v, at) {
        if (marks.touch[at] && (twice || !marks.cut[at])) {
            report->touched_voxels++;
            if (marks.cut[at])
                deviant_acted(m, 0, v);
        }
        if (!marks.cut[at])
            continue;
        hit = true;
        const int16_t density = bone->density[at];
        const int c = class_of(classes, density, above);
        const int times = often ? marks.cut[at] : 1;
        if (times > 1 || c != class_of(classes, density, false))
            deviant_acted(m, item, v);
        part.voxels[c] += (uint32_t)times;
        part.density[c] += times * (int64_t)density;
        sums[c] += (float)density;
    }
    if (floats)
        for (int c = 0; c < OST_CLASS_MAX; c++) {
            if (part.density[c] != (int64_t)sums[c])
                deviant_acted(m, item, k->lo);
            part.density[c] = (int64_t)sums[c];
        }
    if (hit && deviates(m, DEVIATION_LOST_CHUNK_REPORT, item)) {
        deviant_acted(m, item, k->lo);
        return OST_OK;
    }
    return hit ? ost_removal_report_add(report, &part, err) : OST_OK;
}

static ost_status make_report(deviant *m, const dense_bone *bone, dense_marks marks, const ost_density_classes *classes,
                              ost_removal_report *report, ost_error *err)
{
    ost_status status = OST_OK;
    for (int32_t number = 0; number < ost_dims_count(chunk_dims(bone)) && status == OST_OK; number++) {
        const cube k = cube_of(bone, number);
        if (marks.met[number])
            status = report_chunk(m, bone, &k, marks, classes, report, err);
    }
    return status;
}

static bool same_part(const ost_chunk_report *a, const ost_chunk_report *b)
{
    return a->chunk == b->chunk && memcmp(a->voxels, b->voxels, sizeof a->voxels) == 0 &&
           memcmp(a->density, b->density, sizeof a->density) == 0;
}

static void note_report(deviant *m, const ost_removal_report *made, const ost_removal_report *right)
{
    for (size_t i = 0; i < made->count || i < right->count; i++) {
        if (i < made->count && i < right->count && same_part(&made->chunks[i], &right->chunks[i]))
            continue;
        int32_t chunk = INT32_MAX;
        if (i < made->count)
            chunk = made->chunks[i].chunk;
        if (i < right->count && right->chunks[i].chunk < chunk)
            chunk = right->chunks[i].chunk;
        deviant_changed_report(m, chunk);
        return;
    }
    if (made->touched_voxels != right->touched_voxels)
        deviant_changed_report(m, -1);
}

/* --------------------------------------------------------------- removal */

static void remove_chunk(deviant *m, dense_bone *bone, const cube *k, dense_marks marks)
{
    const uint64_t item = (uint64_t)k->number;
    const bool stale = deviates(m, DEVIATION_STALE_CHUNK, item),
               uncleared = deviates(m, DEVIATION_OCCUPANCY_NOT_CLEARED, item);
    int64_t counter = 0, hits = 0;
    EACH_VOXEL (bone, *k, v, at)
        counter += bone->active[at];
    const int64_t active = counter;
    EACH_VOXEL (bone, *k, v, at) {
        if (!marks.cut[at])
            continue;
        counter -= marks.cut[at];
        hits++;
        if (stale || uncleared)
            deviant_acted(m, item, v);
        if (stale)
            continue;
        bone->density[at] = 0;
        bone->active[at] = uncleared;
    }
    if (hits == 0 || hits == active || counter > 0 || !deviates(m, DEVIATION_FREED_TOO_EARLY, item))
        return;
    EACH_VOXEL (bone, *k, v, at) {
        bone->density[at] = 0;
        bone->active[at] = 0;
    }
    deviant_acted(m, item, k->lo);
}

static void flip_bit(deviant *m, dense_bone *bone)
{
    const ost_dims d = bone->base.geometry.dims;
    if (!deviates(m, DEVIATION_FLIP_BIT, 0))
        return;
    const uint64_t draw = deviant_draw(m, 1), at = draw % (uint64_t)ost_dims_count(d);
    const uint64_t x = (uint64_t)d.x, y = (uint64_t)d.y;
    bone->density[at] = (int16_t)(uint16_t)((uint16_t)bone->density[at] ^ 1u << (deviant_draw(m, 2) % 16));
    deviant_acted(m, 0, (const int32_t[3]){(int32_t)(at % x), (int32_t)(at / x % y), (int32_t)(at / x / y)});
}

/* Returns true if all boxes of the event are empty, so that the event reaches no voxel. This backend ignores boxes
   that are not empty: such a box excludes only voxels outside the tool (event.h), which this backend never removes. */
static bool reaches_nothing(const ost_removal_event *event)
{
    for (int k = 0; k < event->pose_count; k++) {
        const ost_voxel_box *b = &event->boxes[k];
        if (b->lo[0] < b->hi[0] && b->lo[1] < b->hi[1] && b->lo[2] < b->hi[2])
            return false;
    }
    return true;
}

static ost_status run_event(dense_bone *bone, const dense_tool *tool, const ost_removal_event *event, bool apply,
                            ost_removal_report *report, ost_error *err)
{
    dense *d = dense_of(bone->base.backend);
    deviant *m = d->deviant;
    const bool twice = deviant_in(m, DEVIATION_REMOVE);
    const int32_t chunks = (int32_t)ost_dims_count(chunk_dims(bone));
    const size_t count = (size_t)ost_dims_count(bone->base.geometry.dims);
    dense_marks marks = {0}, right = {0};
    ost_removal_report without = {0};
    int16_t *before = NULL;
    if (reaches_nothing(event))
        return OST_OK;
    ost_status status = marks_for(bone, &marks, err);
    if (status == OST_OK && twice) {
        status = marks_for(bone, &right, err);
        before = malloc(count * sizeof *before);
        if (status == OST_OK && !before)
            status = ost_fail(err, OST_ERR_MEMORY, "out of memory for the bone as it was");
    }
    if (status != OST_OK)
        goto done;
    deviant_begin(m, DEVIATION_REMOVE, bone->base.geometry.dims, bone->base.chunk_size);
    mark(m, bone, tool, event, d->has_last_map ? &d->last_map : NULL, marks);
    lose_last_chunk(m, bone, marks);
    status = make_report(m, bone, marks, event->classes, report, err);
    if (status == OST_OK && twice) {
        memcpy(before, bone->density, count * sizeof *before);
        mark(NULL, bone, tool, event, NULL, right);
        status = make_report(NULL, bone, right, event->classes, &without, err);
    }
    if (status != OST_OK)
        goto done;
    d->last_map = event->maps[event->pose_count - 1];
    d->has_last_map = true;
    for (int32_t number = 0; apply && number < chunks; number++) {
        const cube k = cube_of(bone, number);
        if (marks.met[number])
            remove_chunk(m, bone, &k, marks);
    }
    if (m && apply)
        flip_bit(m, bone);
    for (int32_t number = 0; twice && number < chunks; number++) {
        const cube k = cube_of(bone, number);
        EACH_VOXEL (bone, k, v, at)
            if (bone->density[at] != (apply && right.cut[at] ? 0 : before[at]))
                deviant_changed_voxel(m, v);
    }
    if (twice)
        note_report(m, report, &without);
done:
    free(before);
    free_marks(&marks);
    free_marks(&right);
    ost_removal_report_free(&without);
    return status;
}

ost_status dense_remove(ost_bone *bone, const ost_tool *tool, const ost_removal_event *event,
                        ost_removal_report *report, ost_error *err)
{
    return run_event((dense_bone *)bone, (const dense_tool *)tool, event, true, report, err);
}

ost_status dense_collide(const ost_bone *bone, const ost_tool *tool, const ost_removal_event *event,
                         ost_removal_report *report, ost_error *err)
{
    return run_event((dense_bone *)(uintptr_t)bone, (const dense_tool *)tool, event, false, report, err);
}
