/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Measures a complete tick of ost_world_step on one thread: oriented boxes, sweep, map, voxel box,
 * removal, report, totals. The event is the static event of the reamer: the time of the ticks advances,
 * but the tool does not move.
 */
#include "bench/path.h"

#include <stdlib.h>
#include <string.h>

enum { REPEAT = 101, CHUNK = 32 };

typedef struct ticker {
    ost_backend *backend;
    ost_tool *tool;
    ost_bone *bone;
    ost_world *world;
    int64_t t_ns;
} ticker;

static ost_status open_ticker(const bench_scene *scene, ost_backend *backend, ticker *t, ost_error *err)
{
    t->backend = backend;
    ost_status status = ost_tool_upload(backend, &scene->tool, &t->tool, err);
    if (status == OST_OK)
        status = bench_scene_bone(scene, backend, CHUNK, &t->bone, err);
    if (status == OST_OK)
        status = ost_world_create(t->bone, NULL, &t->world, err);
    if (status == OST_OK)
        status = ost_world_add_tool(t->world, scene->tool_name, t->tool, NULL, err);
    return status;
}

static void close_ticker(ticker *t)
{
    ost_world_free(t->world);
    ost_bone_free(t->bone);
    ost_tool_free(t->tool);
    ost_backend_close(t->backend);
}

static ost_status step(const bench_scene *scene, ticker *t, bench_series *series, ost_error *err)
{
    ost_step_result result;
    const ost_tick tick = {.t_ns = t->t_ns += 1000000, .tool = 0, .rpm = OST_RPM_ON, .pose = scene->pose};
    int64_t begin = bench_now();
    ost_status status = ost_world_step(t->world, &tick, &result, err);
    int64_t end = bench_now();
    if (series)
        bench_series_add(series, (double)(end - begin));
    return status;
}

static ost_status verify(const bench_scene *scene, ticker *ours, bool *equal, ost_error *err)
{
    ticker ref = {0};
    ost_backend *backend = NULL;
    const size_t bytes = (size_t)ost_dims_count(scene->bone.dims) * sizeof(int16_t);
    int16_t *a = malloc(bytes), *b = malloc(bytes);
    ost_status status = a && b ? ost_backend_open("ref", &backend, err)
                               : ost_fail(err, OST_ERR_MEMORY, "out of memory for the comparison of bones");
    if (status == OST_OK)
        status = open_ticker(scene, backend, &ref, err);
    if (status == OST_OK)
        status = step(scene, &ref, NULL, err);
    if (status == OST_OK)
        status = step(scene, ours, NULL, err);
    if (status == OST_OK)
        status = ost_bone_download(ref.bone, 0, scene->bone.dims.z, a, err);
    if (status == OST_OK)
        status = ost_bone_download(ours->bone, 0, scene->bone.dims.z, b, err);
    if (status == OST_OK)
        *equal = memcmp(a, b, bytes) == 0;
    close_ticker(&ref);
    free(a);
    free(b);
    return status;
}

static ost_status add_row(const bench_options *options, bench_table *table, const char *name, bool equal,
                          bench_series *ours, bench_series *thesis, const char *reason, int chunks, ost_error *err)
{
    if (options->filter && !strstr(name, options->filter))
        return OST_OK;
    bench_row *row = bench_row_add(table, name, "us", 1);
    if (!row)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a row");
    row->equal = equal;
    bench_row_ours(row, ours);
    bench_row_baseline(row, thesis, "the thesis' kernel in C over the event's chunks, nothing else of a tick");
    memcpy(row->baseline_reason, reason, BENCH_TEXT);
    bench_row_extra(row, "chunks", chunks);
    return OST_OK;
}

static ost_status static_tick(const bench_options *options, bench_table *table, ost_error *err)
{
    bench_scene scene;
    bench_thesis thesis = {0};
    ticker ours = {0};
    ost_backend *backend = NULL;
    ost_removal_report seen = {0};
    bench_series fresh = {0}, steady = {0}, thesis_fresh = {0}, thesis_steady = {0};
    int16_t *slices = NULL;
    bool equal = true;
    char reason[BENCH_TEXT];
    const bool baseline = bench_baseline_runs(reason, sizeof reason);
    ost_status status = bench_scene_init(&scene, OST_TOOL_REAMER, OST_PM_PER_MM / 2, SCENE_SIDE, err);
    const int32_t z0 = scene.box.lo[2], z_count = scene.box.hi[2] - z0;
    if (status == OST_OK && !(slices = bench_scene_slices(&scene, z0, z_count)))
        status = ost_fail(err, OST_ERR_MEMORY, "out of memory for a bone's slices");
    if (status == OST_OK)
        status = bench_thesis_init(&thesis, &scene, CHUNK, err);
    if (status == OST_OK)
        status = bench_backend(options, 1, &backend, err);
    if (status == OST_OK)
        status = open_ticker(&scene, backend, &ours, err);
    if (status == OST_OK)
        status = verify(&scene, &ours, &equal, err);
    for (int i = 0; i < bench_repeat(options, REPEAT) && status == OST_OK && equal; i++) {
        status = ost_bone_upload(ours.bone, z0, z_count, slices, err);
        if (status == OST_OK) /* loads the event's data into the caches, as for the "fresh" rows of suite_removal.c */
            status = ost_bone_collide(ours.bone, ours.tool, &scene.event, &seen, err);
        if (status == OST_OK)
            status = step(&scene, &ours, &fresh, err);
        if (status == OST_OK)
            status = step(&scene, &ours, NULL, err);
        if (status == OST_OK)
            status = step(&scene, &ours, &steady, err);
        for (int k = 0; k < 3 && baseline; k++) {
            if (k == 0) {
                bench_thesis_restore(&thesis);
                bench_read_bytes((const uint8_t *)thesis.live, thesis.bytes, 1);
            }
            int64_t begin = bench_now();
            bench_thesis_remove(&thesis.event, 1);
            int64_t end = bench_now();
            if (k != 1)
                bench_series_add(k == 0 ? &thesis_fresh : &thesis_steady, (double)(end - begin));
        }
    }
    if (status == OST_OK)
        status = add_row(options, table, "tick/reamer/32", equal, &fresh, &thesis_fresh, reason,
                         thesis.event.chunk_count, err);
    if (status == OST_OK)
        status = add_row(options, table, "tick/reamer/32/steady", equal, &steady, &thesis_steady, reason,
                         thesis.event.chunk_count, err);
    bench_series_free(&fresh);
    bench_series_free(&steady);
    bench_series_free(&thesis_fresh);
    bench_series_free(&thesis_steady);
    close_ticker(&ours);
    ost_removal_report_free(&seen);
    bench_thesis_free(&thesis);
    free(slices);
    bench_scene_free(&scene);
    static const char *const names[] = {"tick/reamer/32", "tick/reamer/32/steady"};
    return bench_row_not_run(options, table, names, 2, "us", 1, status, err);
}

ost_status bench_tick(const bench_options *options, bench_table *table, ost_error *err)
{
    ost_status status = OST_OK;
    if (bench_wanted(options, "tick/reamer/32") || bench_wanted(options, "tick/reamer/32/steady"))
        status = static_tick(options, table, err);
    return status == OST_OK ? bench_tick_sequence(options, table, err) : status;
}
