/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Figures 3.6 and 3.7: a picture of the static event of a tool on the scapula, and the time of the event.
 *
 *   scapula, tool at the deepest pose of its built-in path --> event --> number of chunks in the intersection box,
 *                                                                        number of active and of changed chunks,
 *                                                                        number of removed voxels, time
 *
 * In contrast to the bone of Tables 3.3 to 3.5, this bone is surrounded by air, as in an operation.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/inputs.h"
#include "reproduction/item.h"
#include "reproduction/view.h"
#include "sim/box.h"

enum { SIZE, IN_BOX, ACTIVE, CHANGED, REMOVED, TIME, LEAST, STEADY };
enum { REPEAT = 31 };

typedef struct job {
    reproduction *r;
    result *out;
    ost_error *err;
    ost_volume bone;
    ost_tool_volume volume;
    ost_glenoid glenoid;
    ost_pose pose;
    ost_map map;
    ost_voxel_box box;
    ost_density_classes classes;
    ost_removal_event event;
} job;

/* Counts the active chunks of n^3 voxels that overlap the event's box. */
static int64_t count_chunks(const job *j, int32_t n, int64_t *all)
{
    const ost_dims d = j->bone.geometry.dims;
    int64_t active = 0;
    *all = 0;
    for (int32_t z = j->box.lo[2] / n; z * n < j->box.hi[2]; z++)
        for (int32_t y = j->box.lo[1] / n; y * n < j->box.hi[1]; y++)
            for (int32_t x = j->box.lo[0] / n; x * n < j->box.hi[0]; x++) {
                bool any = false;
                for (int32_t c = z * n; c < (z + 1) * n && c < d.z && !any; c++)
                    for (int32_t b = y * n; b < (y + 1) * n && b < d.y && !any; b++)
                        for (int32_t a = x * n; a < (x + 1) * n && a < d.x && !any; a++)
                            any = j->bone.voxels[a + d.x * (b + (int64_t)d.y * c)] >= MODEL_THRESHOLD;
                ++*all;
                active += any;
            }
    return active;
}

/* Restores the slices that the event may change. */
static ost_status restore(const job *j, ost_bone *bone)
{
    const ost_dims d = j->bone.geometry.dims;
    const int32_t z0 = j->box.lo[2], count = j->box.hi[2] - z0;
    return ost_bone_upload(bone, z0, count, j->bone.voxels + (int64_t)d.x * d.y * z0, j->err);
}

static ost_status timed(const job *j, ost_bone *bone, const ost_tool *tool, ost_backend *backend,
                        ost_removal_report *report, bench_series *series)
{
    const int64_t begin = bench_now();
    ost_status status = ost_bone_remove(bone, tool, &j->event, report, j->err);
    if (status == OST_OK)
        status = ost_backend_finish(backend, j->err);
    if (series)
        bench_series_add(series, (double)(bench_now() - begin));
    return status;
}

static ost_status measure(const job *j, ost_backend *backend, const ost_tool *tool, int chunk, bench_series *fresh,
                          bench_series *steady, ost_removal_report *report)
{
    const model *m;
    ost_bone *bone = NULL;
    ost_status status = model_get(&j->r->models, MODEL_SCAPULA, &m, j->err);
    if (status == OST_OK)
        status = model_bone(m, backend, chunk, &bone, j->err);
    for (int i = -1; i < bench_repeat(&j->r->bench, REPEAT) && status == OST_OK; i++) {
        ost_removal_report after = {.count = 0};
        status = restore(j, bone);
        if (status == OST_OK)
            status = ost_bone_collide(bone, tool, &j->event, report, j->err);
        if (status == OST_OK)
            status = timed(j, bone, tool, backend, report, i >= 0 ? fresh : NULL);
        if (status == OST_OK)
            status = timed(j, bone, tool, backend, &after, NULL);
        if (status == OST_OK)
            status = timed(j, bone, tool, backend, &after, i >= 0 ? steady : NULL);
        ost_removal_report_free(&after);
    }
    ost_bone_free(bone);
    return status;
}

static ost_status add_size(const job *j, ost_backend *backend, const ost_tool *tool, int chunk)
{
    bench_series fresh = {.ns = NULL}, steady = {.ns = NULL};
    ost_removal_report report = {.count = 0};
    int64_t all;
    ost_status status = measure(j, backend, tool, chunk, &fresh, &steady, &report);
    if (status == OST_OK) {
        result_add_row(j->out);
        result_set(j->out, SIZE, chunk);
        result_set(j->out, ACTIVE, (double)count_chunks(j, chunk, &all));
        result_set(j->out, IN_BOX, (double)all);
        result_set(j->out, CHANGED, (double)report.count);
        result_set(j->out, REMOVED, (double)report.total_voxels);
        result_set(j->out, TIME, bench_series_at(&fresh, 0.5) / 1e3);
        result_set(j->out, LEAST, bench_series_at(&fresh, 0) / 1e3);
        result_set(j->out, STEADY, bench_series_at(&steady, 0.5) / 1e3);
    }
    ost_removal_report_free(&report);
    bench_series_free(&fresh);
    bench_series_free(&steady);
    return status;
}

static ost_status add_picture(const job *j, const char *id, const char *caption)
{
    char file[RESULT_KEY];
    uint8_t *png = NULL;
    size_t size = 0;
    const view_scene scene = {.bone = &j->bone,
                              .tool = &j->volume,
                              .pose = j->pose,
                              .glenoid = &j->glenoid,
                              .view = OST_VIEW_OPERATOR,
                              .extent_mm = 110,
                              .style = OST_STYLE_FACES,
                              .overlays = 1u << OST_OVERLAY_HITS | 1u << OST_OVERLAY_BOXES,
                              .threads = j->r->bench.threads};
    snprintf(file, sizeof file, "%.40s.png", id);
    ost_status status = view_draw(&scene, &png, &size, j->err);
    if (status == OST_OK)
        result_add_picture(j->out, file, caption, png, size);
    return status;
}

static ost_status prepare(job *j, ost_tool_kind kind, ost_builtin path)
{
    const model *m;
    ost_status status = model_get(&j->r->models, MODEL_SCAPULA, &m, j->err);
    if (status == OST_OK)
        status = model_glenoid(m, &j->glenoid, j->err);
    if (status == OST_OK)
        status = model_cubic(m, &j->bone, j->err);
    if (status == OST_OK)
        status = bench_tool_volume("cpu", kind, OST_PM_PER_MM / 2, &j->volume, j->err);
    if (status == OST_OK)
        status = view_deepest(path, &j->glenoid, &j->volume.geometry, &j->pose, j->err);
    if (status == OST_OK)
        status = ost_map_make(&j->pose, &j->bone.geometry, &j->volume.geometry, &j->map, j->err);
    if (status != OST_OK)
        return status;
    const ost_box box = ost_box_of_tool(&j->volume.geometry);
    j->box = ost_box_voxels(&j->bone.geometry, &box, &j->pose);
    j->classes = ost_density_classes_default();
    j->event = (ost_removal_event){.pose_count = 1, .maps = &j->map, .boxes = &j->box, .classes = &j->classes};
    return ost_voxel_box_holds(&j->box)
               ? OST_OK
               : ost_fail(j->err, OST_ERR_INPUT, "the %s does not reach the bone", ost_tool_kind_name(kind));
}

static ost_status run(reproduction *r, result *out, ost_tool_kind kind, ost_builtin path, const char *caption,
                      const char *title, ost_error *err)
{
    job j = {.r = r, .out = out, .err = err};
    ost_backend *backend = NULL;
    ost_tool *tool = NULL;
    result_add_column(out, "chunk_voxels", "chunk side (voxels)", "");
    result_add_column(out, "chunks_in_box", "chunks in the intersection box", "");
    result_add_column(out, "active_chunks", "active ones", "");
    result_add_column(out, "changed_chunks", "changed ones", "");
    result_add_column(out, "removed_voxels", "removed voxels", "");
    result_add_column(out, "fresh_us", "osteon, fresh", "us");
    result_add_column(out, "fresh_min_us", "shortest", "us");
    result_add_column(out, "steady_us", "nothing left to remove", "us");
    ost_status status = prepare(&j, kind, path);
    if (status == OST_OK)
        status = add_picture(&j, out->id, caption);
    if (status == OST_OK)
        status = bench_backend(&r->bench, 1, &backend, err);
    if (status == OST_OK)
        status = ost_tool_upload(backend, &j.volume, &tool, err);
    for (int i = 0; i < MODEL_CHUNK_SIZES && status == OST_OK; i++) {
        reproduction_show(r, title, (double)i / MODEL_CHUNK_SIZES);
        status = add_size(&j, backend, tool, model_chunk[i]);
    }
    ost_tool_free(tool);
    ost_backend_close(backend);
    ost_tool_volume_free(&j.volume);
    ost_volume_free(&j.bone);
    result_add_remark(
        out, "The pose is the deepest of the built-in path in the uncut scapula. One thread. The thesis passes "
             "all active chunks of the intersection box to its kernel; osteon excludes chunks that the "
             "tool's oriented box does not enter.");
    result_plot *p =
        result_add_plot(out, RESULT_PLOT_LINES, title, "side of a chunk (voxels)", "time of an event (us)");
    p->x = SIZE;
    p->value[p->values++] = TIME;
    p->value[p->values++] = STEADY;
    p->log_x = true;
    return status;
}

ost_status item_static_reamer(reproduction *r, result *out, ost_error *err)
{
    return run(
        r, out, OST_TOOL_REAMER, OST_BUILTIN_GLENOID_REAM,
        "The reamer on the glenoid. White: box of the bone; green: box of the reamer; amber: their intersection; red: "
        "active chunks in it.",
        "Static event of the reamer on a scapula", err);
}

ost_status item_static_peg(reproduction *r, result *out, ost_error *err)
{
    return run(
        r, out, OST_TOOL_PEG, OST_BUILTIN_PEG_HOLE,
        "The peg drill in the glenoid. White: box of the bone; green: box of the drill; amber: their intersection; "
        "red: active chunks in it.",
        "Static event of the peg drill in a scapula", err);
}
