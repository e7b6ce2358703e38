/* SPDX-License-Identifier: Apache-2.0 */
/* Passes removal and collision events to a plugin: converts the poses to the plugin's format, and checks the
   plugin's report chunk by chunk. */
#include "plugin/adapt.h"

#include <stdlib.h>

static ost_plugin_int128 split(ost_int128 value)
{
    return (ost_plugin_int128){.low = value.low, .high = value.high};
}

static ost_plugin_map map_of(const ost_map *m, const ost_voxel_box *box)
{
    ost_plugin_map to = {.size = sizeof to, .divisor = split(m->divisor)};
    const long double unit = (long double)ost_i128_of(m->divisor) * (1 << OST_MAP_FRACTION);
    for (int a = 0; a < 3; a++) {
        to.origin[a] = split(m->origin[a]);
        to.affine[a][3] = (double)((long double)ost_i128_of(m->origin[a]) / unit);
        to.box_lo[a] = box->lo[a];
        to.box_hi[a] = box->hi[a];
        for (int b = 0; b < 3; b++) {
            to.column[b][a] = split(m->column[b][a]);
            to.step[b][a] = m->step[b][a];
            to.affine[a][b] = (double)((long double)ost_i128_of(m->column[b][a]) / unit);
        }
    }
    return to;
}

/* The receiver of a plugin's report. `status` is the error of the first invalid entry. */
typedef struct sink {
    const plugin_backend *b;
    ost_removal_report *report;
    int64_t chunks, last;
    int64_t chunk_voxels;
    int classes;
    ost_status status;
    ost_error *err;
} sink;

static int32_t add_chunk(void *user, int32_t chunk, const uint32_t *voxels, const int64_t *density)
{
    sink *s = user;
    ost_chunk_report line = {.chunk = chunk};
    int64_t total = 0;
    if (s->status != OST_OK)
        return OST_PLUGIN_FAILED;
    if (chunk < 0 || chunk >= s->chunks || chunk <= s->last || !voxels || !density) {
        s->status = ost_fail(
            s->err, OST_ERR_UNAVAILABLE,
            "plugin %s: reported chunk %d after chunk %lld; the bone has %lld, and they come ascending", s->b->name,
            (int)chunk, (long long)s->last, (long long)s->chunks);
        return OST_PLUGIN_FAILED;
    }
    for (int c = 0; c < s->classes; c++) {
        line.voxels[c] = voxels[c];
        line.density[c] = density[c];
        total += voxels[c];
    }
    if (total < 1 || total > s->chunk_voxels) {
        s->status = ost_fail(s->err, OST_ERR_UNAVAILABLE,
                             "plugin %s: reported %lld voxels in chunk %d; a chunk has 1 to %lld to report", s->b->name,
                             (long long)total, (int)chunk, (long long)s->chunk_voxels);
        return OST_PLUGIN_FAILED;
    }
    s->last = chunk;
    s->status = ost_removal_report_add(s->report, &line, s->err);
    return s->status == OST_OK ? OST_PLUGIN_OK : OST_PLUGIN_MEMORY;
}

static ost_status run_event(ost_bone *base, const ost_tool *tool, const ost_removal_event *event, bool apply,
                            ost_removal_report *report, ost_error *err)
{
    plugin_bone *bone = (plugin_bone *)base;
    plugin_backend *b = adapt_backend(base->backend);
    const ost_dims d = base->geometry.dims;
    const int32_t n = base->chunk_size;
    ost_plugin_map one, *maps = event->pose_count == 1 ? &one : malloc((size_t)event->pose_count * sizeof *maps);
    if (bone->lost || !maps) {
        if (maps != &one)
            free(maps);
        return bone->lost ? ost_adapt_is_lost(b, err)
                          : ost_fail(err, OST_ERR_MEMORY, "out of memory for the maps of %d poses", event->pose_count);
    }
    for (int p = 0; p < event->pose_count; p++)
        maps[p] = map_of(&event->maps[p], &event->boxes[p]);
    const ost_plugin_event e = {.size = sizeof e, .map_count = event->pose_count, .stride = sizeof *maps, .maps = maps,
                                .class_count = event->classes->count, .class_from = event->classes->border};
    sink s = {.b = b,
              .report = report,
              .chunks = (int64_t)((d.x + n - 1) / n) * ((d.y + n - 1) / n) * ((d.z + n - 1) / n),
              .last = -1,
              .chunk_voxels = (int64_t)n * n * n,
              .classes = event->classes->count,
              .err = err};
    ost_plugin_report r = {.size = sizeof r, .sink = &s, .add = add_chunk};
    plugin_error_sink t;
    adapt_listening(&t);
    const int32_t answer = apply ? b->table.remove(bone->own, ((const plugin_tool *)tool)->own, &e, &r, &t.error)
                               : b->table.collide(bone->own, ((const plugin_tool *)tool)->own, &e, &r, &t.error);
    if (maps != &one)
        free(maps);
    if (s.status != OST_OK) { /* the plugin may have removed voxels without reporting them */
        bone->lost = apply;
        return s.status;
    }
    report->touched_voxels = r.touched_voxels;
    return ost_adapt_heard(b, apply ? "remove" : "collide", answer, &t, &bone->lost, err);
}

ost_status ost_adapt_remove(ost_bone *bone, const ost_tool *tool, const ost_removal_event *event,
                            ost_removal_report *report, ost_error *err)
{
    return run_event(bone, tool, event, true, report, err);
}

ost_status ost_adapt_collide(const ost_bone *bone, const ost_tool *tool, const ost_removal_event *event,
                             ost_removal_report *report, ost_error *err)
{
    return run_event((ost_bone *)(uintptr_t)bone, tool, event, false, report, err);
}
