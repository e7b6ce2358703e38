/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Removal events (thesis, Tables 3.3 to 3.5).
 *
 *   fresh   all voxels were restored and then loaded into the caches, as far as they fit:
 *           osteon's bone was processed once by ost_bone_collide, which changes no voxel, and
 *           the baseline's chunks were read once
 *   cold    the event runs immediately after the voxels were restored; osteon restores complete
 *           slices, but the baseline restores only the event's chunks, so the caches contain
 *           less of the event's data for osteon than for the baseline
 *   steady  the event is repeated without restoring the voxels, so no voxel remains to be removed
 *
 * In each repetition, osteon and then the baseline run the steps restore, cold, restore, collide (for
 * the baseline: read), fresh, steady, steady. The first steady step is a warm-up.
 */
#include "bench/path.h"
#include "bench/thesis_cl.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { REPEAT = 61, REPEAT_LARGE = 15 };
static const char THESIS[] = "the thesis' kernel in C, float affine map a voxel, over the event's chunks";
static const char THESIS_CL[] =
    "the thesis' kernel in OpenCL on the same device, a launch for each of the event's chunks";

typedef struct removal {
    const bench_options *options;
    bench_table *table;
    ost_error *err;
    bench_scene *scene;
    int chunk_size, threads;
    /* OpenCL device that runs the baseline; NULL if the baseline is in C */
    bench_cl *cl;

    ost_backend *backend;
    ost_tool *tool;
    ost_bone *bone;
    ost_removal_report report;
    int16_t *slices; /* densities of the slices that the event's box contains */
    int32_t z0, z_count;
    bench_thesis thesis;
    bench_work work;
    bool baseline; /* true if the baseline can run on this machine */
    char baseline_reason[BENCH_TEXT];
    double removed, in_chunks, differs;
    bool equal;
} removal;

typedef struct removal_series {
    bench_series fresh, cold, steady, thesis_fresh, thesis_cold, thesis_steady, stores;
} removal_series;

static void free_series(removal_series *s)
{
    bench_series_free(&s->fresh);
    bench_series_free(&s->cold);
    bench_series_free(&s->steady);
    bench_series_free(&s->thesis_fresh);
    bench_series_free(&s->thesis_cold);
    bench_series_free(&s->thesis_steady);
    bench_series_free(&s->stores);
}

static ost_status open_case(removal *r)
{
    r->z0 = r->scene->box.lo[2];
    r->z_count = r->scene->box.hi[2] - r->z0;
    r->slices = bench_scene_slices(r->scene, r->z0, r->z_count);
    r->baseline = r->cl || bench_baseline_runs(r->baseline_reason, sizeof r->baseline_reason);
    if (!r->slices)
        return ost_fail(r->err, OST_ERR_MEMORY, "out of memory for a bone's slices");
    ost_status status = bench_backend(r->options, r->threads, &r->backend, r->err);
    if (status == OST_OK)
        status = ost_tool_upload(r->backend, &r->scene->tool, &r->tool, r->err);
    if (status == OST_OK)
        status = bench_scene_bone(r->scene, r->backend, r->chunk_size, &r->bone, r->err);
    if (status == OST_OK)
        status = bench_thesis_init(&r->thesis, r->scene, r->chunk_size, r->err);
    if (status == OST_OK && r->cl && !bench_cl_take(r->cl, &r->thesis)) {
        r->baseline = false;
        snprintf(r->baseline_reason, sizeof r->baseline_reason, "OpenCL device '%.100s' cannot hold the event",
                 bench_cl_name(r->cl));
    }
    return status;
}

static void close_case(removal *r)
{
    ost_removal_report_free(&r->report);
    ost_bone_free(r->bone);
    ost_tool_free(r->tool);
    ost_backend_close(r->backend);
    bench_thesis_free(&r->thesis);
    free(r->work.rows);
    free(r->slices);
}

static ost_status restore(removal *r)
{
    return ost_bone_upload(r->bone, r->z0, r->z_count, r->slices, r->err);
}

static bool same_report(const ost_removal_report *a, const ost_removal_report *b)
{
    return a->count == b->count && a->total_voxels == b->total_voxels && a->touched_voxels == b->touched_voxels &&
           memcmp(a->voxels, b->voxels, sizeof a->voxels) == 0 &&
           memcmp(a->density, b->density, sizeof a->density) == 0;
}

/* Compares two bones slab by slab, so that no complete copy of a large bone is needed on the host. */
static ost_status compare_bones(removal *r, const ost_bone *expected)
{
    enum { SLAB = 32 };
    const ost_dims d = r->scene->bone.dims;
    const size_t slice = (size_t)d.x * (size_t)d.y;
    int16_t *a = malloc(slice * SLAB * sizeof *a), *b = malloc(slice * SLAB * sizeof *b);
    ost_status status = a && b ? OST_OK : ost_fail(r->err, OST_ERR_MEMORY, "out of memory for the comparison of bones");
    for (int32_t z = 0; z < d.z && status == OST_OK; z += SLAB) {
        int32_t count = d.z - z < SLAB ? d.z - z : SLAB;
        status = ost_bone_download(r->bone, z, count, a, r->err);
        if (status == OST_OK)
            status = ost_bone_download(expected, z, count, b, r->err);
        if (status == OST_OK && memcmp(a, b, slice * (size_t)count * sizeof *a) != 0)
            r->equal = false;
    }
    free(a);
    free(b);
    return status;
}

/* Runs the event once on the reference and once on the measured backend, and checks that the bones and the reports are
   equal. */
static ost_status verify(removal *r)
{
    ost_backend *ref = NULL;
    ost_tool *tool = NULL;
    ost_bone *bone = NULL;
    ost_removal_report report = {0};
    ost_status status = ost_backend_open("ref", &ref, r->err);
    if (status == OST_OK)
        status = ost_tool_upload(ref, &r->scene->tool, &tool, r->err);
    if (status == OST_OK)
        status = bench_scene_bone(r->scene, ref, r->chunk_size, &bone, r->err);
    if (status == OST_OK)
        status = ost_bone_remove(bone, tool, &r->scene->event, &report, r->err);
    if (status == OST_OK)
        status = ost_bone_remove(r->bone, r->tool, &r->scene->event, &r->report, r->err);
    if (status == OST_OK) {
        r->equal = same_report(&report, &r->report);
        r->removed = (double)report.total_voxels;
        r->in_chunks = (double)report.count;
        status = compare_bones(r, bone);
    }
    ost_removal_report_free(&report);
    ost_bone_free(bone);
    ost_tool_free(tool);
    ost_backend_close(ref);
    return status;
}

/* Counts the voxels for which the thesis' kernel, which rounds to floats, and osteon produce different results. Needs
   memory for two copies of the bone. */
static ost_status compare_thesis(removal *r)
{
    const ost_dims d = r->scene->bone.dims;
    int16_t *voxels = malloc((size_t)ost_dims_count(d) * sizeof *voxels);
    if (!voxels)
        return ost_fail(r->err, OST_ERR_MEMORY, "out of memory for the comparison with the thesis' kernel");
    ost_status status = ost_bone_download(r->bone, 0, d.z, voxels, r->err);
    if (status == OST_OK) {
        if (r->cl)
            r->baseline = bench_cl_remove(r->cl, &r->thesis) && bench_cl_fetch(r->cl, &r->thesis);
        else
            bench_thesis_remove(&r->thesis.event, 1);
        r->differs = (double)bench_thesis_differs(&r->thesis, r->scene, voxels);
        status = bench_work_count(&r->work, &r->thesis, r->err);
    }
    free(voxels);
    return status;
}

static ost_status time_ours(removal *r, bench_series *series)
{
    int64_t begin = bench_now();
    ost_status status = ost_bone_remove(r->bone, r->tool, &r->scene->event, &r->report, r->err);
    int64_t end = bench_now();
    if (series)
        bench_series_add(series, (double)(end - begin));
    return status;
}

static void time_thesis(removal *r, bench_series *series)
{
    int64_t begin = bench_now();
    if (r->cl)
        r->baseline = bench_cl_remove(r->cl, &r->thesis) && r->baseline;
    else
        bench_thesis_remove(&r->thesis.event, r->threads);
    int64_t end = bench_now();
    if (series)
        bench_series_add(series, (double)(end - begin));
}

/* Restores the voxels of the baseline. If the baseline is in C, also loads the voxels into the caches. */
static void refresh_thesis(removal *r)
{
    if (r->cl) {
        r->baseline = bench_cl_restore(r->cl, &r->thesis) && r->baseline;
        return;
    }
    bench_thesis_restore(&r->thesis);
    bench_read_bytes((const uint8_t *)r->thesis.live, r->thesis.bytes, 1);
}

static void time_stores(removal *r, bench_series *series)
{
    bench_thesis_restore(&r->thesis);
    bench_read_bytes((const uint8_t *)r->thesis.live, r->thesis.bytes, 1);
    int64_t begin = bench_now();
    bench_store_rows(r->work.rows, (size_t)r->work.changed_rows);
    bench_series_add(series, (double)(bench_now() - begin));
}

static ost_status repeat(removal *r, int count, bool cold, removal_series *s)
{
    ost_status status = OST_OK;
    for (int i = -1; i < count && status == OST_OK; i++) {
        bool keep = i >= 0;
        status = restore(r);
        if (status == OST_OK && cold) {
            status = time_ours(r, keep ? &s->cold : NULL);
            if (status == OST_OK)
                status = restore(r);
        }
        if (status == OST_OK)
            status = ost_bone_collide(r->bone, r->tool, &r->scene->event, &r->report, r->err);
        if (status == OST_OK)
            status = time_ours(r, keep ? &s->fresh : NULL);
        if (status == OST_OK)
            status = time_ours(r, NULL);
        if (status == OST_OK)
            status = time_ours(r, keep ? &s->steady : NULL);
        if (status != OST_OK || !r->baseline)
            continue;
        if (cold) {
            bench_thesis_restore(&r->thesis);
            time_thesis(r, keep ? &s->thesis_cold : NULL);
        }
        refresh_thesis(r);
        time_thesis(r, keep ? &s->thesis_fresh : NULL);
        time_thesis(r, NULL);
        time_thesis(r, keep ? &s->thesis_steady : NULL);
        if (keep && r->work.rows && !r->cl)
            time_stores(r, &s->stores);
    }
    return status;
}

/* Adds a row. `stores` is NULL or contains the times of the event's stores alone (bench_store_rows), which the row
   shows as a lower bound. */
static ost_status add_row(removal *r, const char *name, bench_series *ours, bench_series *baseline,
                          bench_series *stores)
{
    bench_row *row = bench_row_add(r->table, name, "us", r->threads);
    if (!row)
        return ost_fail(r->err, OST_ERR_MEMORY, "out of memory for a row");
    row->equal = r->equal;
    if (r->equal)
        bench_row_ours(row, ours);
    bench_row_baseline(row, baseline, r->cl ? THESIS_CL : THESIS);
    snprintf(row->baseline_reason, sizeof row->baseline_reason, "%s", r->baseline_reason);
    bench_row_extra(row, "chunks", r->thesis.event.chunk_count);
    bench_row_extra(row, "chunks_with_removed", r->in_chunks);
    bench_row_extra(row, "removed_voxels", r->removed);
    if (r->baseline)
        bench_row_extra(row, "baseline_different_voxels", r->differs);
    if (r->work.complete_bricks + r->work.mixed_bricks) {
        bench_row_extra(row, "whole_bricks", (double)r->work.complete_bricks);
        bench_row_extra(row, "mixed_bricks", (double)r->work.mixed_bricks);
    }
    if (r->work.changed_rows && stores) {
        bench_row_extra(row, "changed_rows", (double)r->work.changed_rows);
        bench_row_extra(row, "store_floor", bench_series_at(stores, 0.5) / 1e3);
        bench_row_extra(row, "store_floor_min", bench_series_at(stores, 0) / 1e3);
    }
    return OST_OK;
}

static ost_status not_run(const removal *r, const char *fresh, const char *cold, const char *steady, ost_status status)
{
    const char *const names[] = {fresh, cold, steady};
    return bench_row_not_run(r->options, r->table, names, 3, "us", r->threads, status, r->err);
}

static ost_status run_case(removal *r, const char *fresh, const char *cold, const char *steady, int count)
{
    bool want_fresh = bench_wanted(r->options, fresh), want_steady = bench_wanted(r->options, steady);
    bool want_cold = cold && bench_wanted(r->options, cold);
    removal_series s = {0};
    if (!want_fresh && !want_cold && !want_steady)
        return OST_OK;
    ost_status status = open_case(r);
    if (status == OST_OK)
        status = verify(r);
    if (status == OST_OK && r->baseline && r->scene->bone.dims.x == SCENE_SIDE)
        status = compare_thesis(r);
    if (status == OST_OK && r->equal)
        status = repeat(r, bench_repeat(r->options, count), want_cold, &s);
    if (status == OST_OK && want_fresh)
        status = add_row(r, fresh, &s.fresh, &s.thesis_fresh, r->cl ? NULL : &s.stores);
    if (status == OST_OK && want_cold)
        status = add_row(r, cold, &s.cold, &s.thesis_cold, NULL);
    if (status == OST_OK && want_steady)
        status = add_row(r, steady, &s.steady, &s.thesis_steady, NULL);
    free_series(&s);
    close_case(r);
    return not_run(r, fresh, cold, steady, status);
}

static ost_status static_event(const bench_options *options, bench_table *table, bench_scene *scene, int chunk_size,
                               bool one, ost_error *err)
{
    char fresh[BENCH_NAME], cold[BENCH_NAME], steady[BENCH_NAME];
    snprintf(cold, sizeof cold, "removal/%s/%d/cold%s", scene->tool_name, chunk_size, one ? "/1" : "");
    snprintf(fresh, sizeof fresh, "removal/%s/%d/fresh%s", scene->tool_name, chunk_size, one ? "/1" : "");
    snprintf(steady, sizeof steady, "removal/%s/%d/steady%s", scene->tool_name, chunk_size, one ? "/1" : "");
    removal r = {.options = options, .table = table, .err = err, .scene = scene, .chunk_size = chunk_size,
                 .threads = one ? 1 : options->threads};
    return run_case(&r, fresh, cold, steady, REPEAT);
}

static ost_status static_events(const bench_options *options, bench_table *table, ost_tool_kind kind, ost_error *err)
{
    static const int sizes[] = {16, 32, 64};
    bench_scene scene;
    ost_status status = bench_scene_init(&scene, kind, OST_PM_PER_MM / 2, SCENE_SIDE, err);
    for (int one = 0; one < 2; one++)
        for (int s = 0; s < 3 && status == OST_OK; s++)
            status = static_event(options, table, &scene, sizes[s], one, err);
    bench_scene_free(&scene);
    return status;
}

/* Adds the rows of Table 3.5, which measure one event with tool voxels of several sizes. The row for 0.5 mm measures
   the same event as the row removal/reamer/32. */
static ost_status tool_voxels(const bench_options *options, bench_table *table, ost_error *err)
{
    static const struct {
        const char *name;
        ost_pm voxel;
    } voxels[] = {
        {"1", OST_PM_PER_MM}, {"0.75", 3 * OST_PM_PER_MM / 4}, {"0.5", OST_PM_PER_MM / 2}, {"0.25", OST_PM_PER_MM / 4}};
    ost_status status = OST_OK;
    for (size_t v = 0; v < sizeof voxels / sizeof voxels[0] && status == OST_OK; v++) {
        char fresh[BENCH_NAME], steady[BENCH_NAME];
        bench_scene scene;
        snprintf(fresh, sizeof fresh, "removal/voxel/%s/fresh/1", voxels[v].name);
        snprintf(steady, sizeof steady, "removal/voxel/%s/steady/1", voxels[v].name);
        status = bench_scene_init(&scene, OST_TOOL_REAMER, voxels[v].voxel, SCENE_SIDE, err);
        removal r = {.options = options, .table = table, .err = err, .scene = &scene, .chunk_size = 32, .threads = 1};
        if (status == OST_OK)
            status = run_case(&r, fresh, NULL, steady, REPEAT);
        else
            status = not_run(&r, fresh, NULL, steady, status);
        bench_scene_free(&scene);
    }
    return status;
}

/* Adds a row that was not measured, with the reason. */
static ost_status add_not_run(bench_table *table, const bench_options *options, const char *name, const char *reason,
                              ost_error *err)
{
    bench_row *row;
    if (!bench_wanted(options, name))
        return OST_OK;
    if (!(row = bench_row_add(table, name, "us", 1)))
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a row");
    snprintf(row->reason, sizeof row->reason, "%s", reason);
    return OST_OK;
}

/* Adds rows for bones of increasing size, with the same event at the far corner of each bone. */
static ost_status bone_sizes(const bench_options *options, bench_table *table, ost_error *err)
{
    static const int32_t sides[] = {128, 256, 512, 1024};
    ost_status status = OST_OK;
    for (size_t i = 0; i < sizeof sides / sizeof sides[0] && status == OST_OK; i++) {
        char fresh[BENCH_NAME], steady[BENCH_NAME];
        /* memory in bytes for the densities and the occupancy of two bones, and for slabs */
        double bytes = 2 * (2 + 0.25) * (double)sides[i] * (double)sides[i] * (double)sides[i] + 4e8;
        bench_scene scene;
        snprintf(fresh, sizeof fresh, "removal/bone/%d/fresh/1", sides[i]);
        snprintf(steady, sizeof steady, "removal/bone/%d/steady/1", sides[i]);
        if ((options->quick && sides[i] > 256) || bytes > (double)bench_memory()) {
            char reason[BENCH_TEXT];
            if (options->quick)
                continue;
            snprintf(reason, sizeof reason, "two bones of %d^3 voxels take %.1f GB; less is free here", sides[i],
                     bytes * 1e-9);
            status = add_not_run(table, options, fresh, reason, err);
            if (status == OST_OK)
                status = add_not_run(table, options, steady, reason, err);
            continue;
        }
        status = bench_scene_init(&scene, OST_TOOL_REAMER, OST_PM_PER_MM / 2, sides[i], err);
        removal r = {.options = options, .table = table, .err = err, .scene = &scene, .chunk_size = 32, .threads = 1};
        if (status == OST_OK)
            status = run_case(&r, fresh, NULL, steady, REPEAT_LARGE);
        else
            status = not_run(&r, fresh, NULL, steady, status);
        bench_scene_free(&scene);
    }
    return status;
}

ost_status bench_removal(const bench_options *options, bench_table *table, ost_error *err)
{
    ost_status status = static_events(options, table, OST_TOOL_REAMER, err);
    if (status == OST_OK)
        status = static_events(options, table, OST_TOOL_PEG, err);
    if (status == OST_OK)
        status = bench_removal_sequence(options, table, err);
    if (status == OST_OK)
        status = tool_voxels(options, table, err);
    if (status == OST_OK)
        status = bone_sizes(options, table, err);
    return status;
}

ost_status bench_removal_opencl(const bench_options *options, bench_table *table, bench_cl *cl, ost_error *err)
{
    static const int sizes[] = {16, 32, 64};
    static const ost_tool_kind kinds[] = {OST_TOOL_REAMER, OST_TOOL_PEG};
    ost_status status = OST_OK;
    for (int k = 0; k < 2 && status == OST_OK; k++) {
        bench_scene scene;
        status = bench_scene_init(&scene, kinds[k], OST_PM_PER_MM / 2, SCENE_SIDE, err);
        for (int i = 0; i < 3 && status == OST_OK; i++) {
            char fresh[BENCH_NAME], steady[BENCH_NAME];
            snprintf(fresh, sizeof fresh, "opencl/%s/%d/fresh", scene.tool_name, sizes[i]);
            snprintf(steady, sizeof steady, "opencl/%s/%d/steady", scene.tool_name, sizes[i]);
            removal r = {.options = options, .table = table, .err = err, .scene = &scene, .chunk_size = sizes[i],
                         .threads = options->threads, .cl = cl};
            status = run_case(&r, fresh, NULL, steady, REPEAT);
        }
        bench_scene_free(&scene);
    }
    return status;
}
