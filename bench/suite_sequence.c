/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Measures 2,000 ticks of a cutting tool.
 *
 *   removal/sequence/1   only the removal events; their maps and boxes are computed beforehand
 *   tick/sequence/1      complete ticks of the world, including maps and boxes
 *   tick/force/1         complete ticks, each preceded by the computation of a force. The device follows
 *                        the same path, and this computation determines the tool's pose.
 *
 * All rows use one thread and chunks of 32^3 voxels. Every tick is timed separately.
 *
 * The thesis' kernel runs only at every twentieth tick, because all ticks would take a minute, and always on
 * unmodified chunks. Its time depends only on the number of chunks that the tool's box enters, so this does not change
 * the result.
 */
#include "bench/path.h"

#include <osteon/force.h>

#include <stdlib.h>
#include <string.h>

enum { REPEAT = 7, CHUNK = 32, THESIS_EVERY = 20 };

typedef struct sequence_run {
    const bench_options *options;
    ost_error *err;
    bench_scene scene;
    ost_tick *ticks;
    int count;
    ost_map *maps;
    ost_voxel_box *boxes;
    double *ns; /* times of the ticks of one repetition */
    int16_t *full, *ours, *expected;
} sequence_run;

static size_t bone_bytes(const sequence_run *s)
{
    return (size_t)ost_dims_count(s->scene.bone.dims) * sizeof(int16_t);
}

static ost_status prepare(sequence_run *s)
{
    ost_status status = bench_scene_init(&s->scene, OST_TOOL_REAMER, OST_PM_PER_MM / 2, SCENE_SIDE, s->err);
    if (status != OST_OK)
        return status;
    s->count = s->options->quick ? PATH_TICKS_QUICK : PATH_TICKS;
    s->maps = malloc((size_t)s->count * sizeof *s->maps);
    s->boxes = malloc((size_t)s->count * sizeof *s->boxes);
    s->ns = malloc((size_t)s->count * sizeof *s->ns);
    s->full = bench_scene_slices(&s->scene, 0, s->scene.bone.dims.z);
    s->ours = malloc(bone_bytes(s));
    s->expected = malloc(bone_bytes(s));
    if (!s->maps || !s->boxes || !s->ns || !s->full || !s->ours || !s->expected)
        return ost_fail(s->err, OST_ERR_MEMORY, "out of memory for a sequence of %d ticks", s->count);
    status = bench_path_make(&s->scene, s->count, &s->ticks, s->err);
    for (int i = 0; i < s->count && status == OST_OK; i++) {
        status = bench_scene_set_pose(&s->scene, &s->ticks[i].pose, s->err);
        s->maps[i] = s->scene.map;
        s->boxes[i] = s->scene.box;
    }
    return status;
}

static void unprepare(sequence_run *s)
{
    bench_scene_free(&s->scene);
    free(s->ticks);
    free(s->maps);
    free(s->boxes);
    free(s->ns);
    free(s->full);
    free(s->ours);
    free(s->expected);
}

/* The backend, the bone and the tool with which all ticks run. */
typedef struct machine {
    ost_backend *backend;
    ost_tool *tool;
    ost_bone *bone;
} machine;

static ost_status open_machine(sequence_run *s, const char *backend, machine *m)
{
    ost_status status = backend ? ost_backend_open(backend, &m->backend, s->err)
                                : bench_backend(s->options, 1, &m->backend, s->err);
    if (status == OST_OK)
        status = ost_tool_upload(m->backend, &s->scene.tool, &m->tool, s->err);
    if (status == OST_OK)
        status = bench_scene_bone(&s->scene, m->backend, CHUNK, &m->bone, s->err);
    return status;
}

static void close_machine(machine *m)
{
    ost_bone_free(m->bone);
    ost_tool_free(m->tool);
    ost_backend_close(m->backend);
}

static ost_status run_events(sequence_run *s, machine *m, ost_removal_report *report)
{
    ost_status status = OST_OK;
    for (int i = 0; i < s->count && status == OST_OK; i++) {
        const ost_removal_event event = {
            .pose_count = 1, .maps = &s->maps[i], .boxes = &s->boxes[i], .classes = &s->scene.classes};
        int64_t begin = bench_now();
        status = ost_bone_remove(m->bone, m->tool, &event, report, s->err);
        s->ns[i] = (double)(bench_now() - begin);
    }
    return status;
}

typedef enum sequence_kind { EVENTS, TICKS, TICKS_WITH_FORCE } sequence_kind;

static ost_status run_ticks(sequence_run *s, machine *m, bool felt)
{
    ost_world *world = NULL;
    ost_force *force = NULL;
    ost_status status = ost_world_create(m->bone, NULL, &world, s->err);
    if (status == OST_OK)
        status = ost_world_add_tool(world, s->scene.tool_name, m->tool, NULL, s->err);
    if (status == OST_OK && felt)
        status = ost_force_create(m->bone, NULL, &force, s->err);
    if (status == OST_OK && felt)
        status = ost_force_add_tool(force, m->tool, s->err);
    for (int i = 0; i < s->count && status == OST_OK; i++) {
        ost_step_result result;
        ost_force_result hand;
        ost_tick tick = s->ticks[i];
        int64_t begin = bench_now();
        if (felt) {
            status = ost_force_step(force, 0, &s->ticks[i].pose, 1e-3, &hand, s->err);
            tick.pose = hand.tool;
        }
        if (status == OST_OK)
            status = ost_world_step(world, &tick, &result, s->err);
        s->ns[i] = (double)(bench_now() - begin);
    }
    ost_force_free(force);
    ost_world_free(world);
    return status;
}

static ost_status run(sequence_run *s, machine *m, sequence_kind kind)
{
    ost_removal_report report = {0};
    ost_status status = ost_bone_upload(m->bone, 0, s->scene.bone.dims.z, s->full, s->err);
    if (status == OST_OK)
        status = kind == EVENTS ? run_events(s, m, &report) : run_ticks(s, m, kind == TICKS_WITH_FORCE);
    ost_removal_report_free(&report);
    return status;
}

static ost_status verify(sequence_run *s, machine *ours, sequence_kind kind, bool *equal)
{
    machine ref = {0};
    const int32_t slices = s->scene.bone.dims.z;
    ost_status status = open_machine(s, "ref", &ref);
    if (status == OST_OK)
        status = run(s, &ref, kind);
    if (status == OST_OK)
        status = ost_bone_download(ref.bone, 0, slices, s->expected, s->err);
    if (status == OST_OK)
        status = run(s, ours, kind);
    if (status == OST_OK)
        status = ost_bone_download(ours->bone, 0, slices, s->ours, s->err);
    if (status == OST_OK)
        *equal = memcmp(s->ours, s->expected, bone_bytes(s)) == 0;
    close_machine(&ref);
    return status;
}

/* Measures the thesis' kernel at every twentieth tick and adds the mean time to `means`. */
static ost_status run_thesis(sequence_run *s, bench_series *means, double *chunks)
{
    double ns = 0, count = 0;
    ost_status status = OST_OK;
    *chunks = 0;
    for (int i = THESIS_EVERY / 2; i < s->count && status == OST_OK; i += THESIS_EVERY) {
        bench_thesis thesis;
        status = bench_scene_set_pose(&s->scene, &s->ticks[i].pose, s->err);
        if (status == OST_OK)
            status = bench_thesis_init(&thesis, &s->scene, CHUNK, s->err);
        if (status != OST_OK)
            break;
        int64_t begin = bench_now();
        bench_thesis_remove(&thesis.event, 1);
        ns += (double)(bench_now() - begin);
        *chunks += thesis.event.chunk_count;
        count++;
        bench_thesis_free(&thesis);
    }
    if (status == OST_OK) {
        bench_series_add(means, ns / count);
        *chunks /= count;
    }
    return status;
}

static ost_status sequence(const bench_options *options, bench_table *table, const char *name, sequence_kind kind,
                           ost_error *err)
{
    sequence_run s = {.options = options, .err = err};
    machine ours = {0};
    bench_sequence times = {0};
    bench_series thesis = {0};
    double chunks = 0;
    bool equal = true;
    char reason[BENCH_TEXT];
    if (!bench_wanted(options, name))
        return OST_OK;
    const bool baseline = bench_baseline_runs(reason, sizeof reason);
    const int repeat = bench_repeat(options, REPEAT);
    ost_status status = prepare(&s);
    if (status == OST_OK)
        status = bench_sequence_init(&times, s.count, err);
    if (status == OST_OK)
        status = open_machine(&s, NULL, &ours);
    if (status == OST_OK)
        status = verify(&s, &ours, kind, &equal);
    for (int i = 0; i < repeat && status == OST_OK && equal; i++) {
        status = run(&s, &ours, kind);
        if (status == OST_OK)
            bench_sequence_add(&times, s.ns);
        if (status == OST_OK && baseline && i < 3)
            status = run_thesis(&s, &thesis, &chunks);
    }
    bench_row *row = status == OST_OK ? bench_row_add(table, name, "us", 1) : NULL;
    if (row) {
        row->equal = equal;
        if (equal)
            bench_sequence_row(&times, row);
        bench_row_baseline(row, &thesis, "the thesis' kernel in C at every 20th tick, mean a tick");
        memcpy(row->baseline_reason, reason, sizeof reason);
        if (baseline && equal)
            bench_row_extra(row, "chunks_mean", chunks);
    } else if (status == OST_OK) {
        status = ost_fail(err, OST_ERR_MEMORY, "out of memory for a row");
    }
    bench_series_free(&thesis);
    bench_sequence_free(&times);
    close_machine(&ours);
    unprepare(&s);
    return bench_row_not_run(options, table, &name, 1, "us", 1, status, err);
}

ost_status bench_removal_sequence(const bench_options *options, bench_table *table, ost_error *err)
{
    return sequence(options, table, "removal/sequence/1", EVENTS, err);
}

ost_status bench_tick_sequence(const bench_options *options, bench_table *table, ost_error *err)
{
    ost_status status = sequence(options, table, "tick/sequence/1", TICKS, err);
    return status == OST_OK ? sequence(options, table, "tick/force/1", TICKS_WITH_FORCE, err) : status;
}
