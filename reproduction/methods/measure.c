/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Measures all methods on one scene.
 *
 *   open each method --> restore, remove, result: compare the set with the one that the definition requires
 *                    --> one untimed event, to estimate the number of repetitions
 *                    --> repetition by repetition, method by method: restore, remove (fresh), remove, remove (steady)
 *
 * A repetition runs all methods in turn, so other load on the machine affects all of them. For this, all methods must
 * be open at the same time, each with its own bone. If half of the free memory is too small for all bones, the methods
 * are measured one after the other. A method whose set is wrong is not timed; a method for which there is no memory has
 * a row with the reason.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "reproduction/methods/device.h"
#include "reproduction/methods/measure.h"
#include "reproduction/methods/points.h"

enum { METHODS_MAX = 32, REPEAT = 21, REPEAT_SLOW = 3, QUICK = 3 };
static const double SLOW_NS = 1e8;

/* One of the methods compared in a case. */
typedef struct entrant {
    const method *method;
    void *state; /* the method's state; NULL if the method does not run */
    methods_row row;
    bench_series fresh, steady;
    double estimate; /* estimated time of one event in ns */
} entrant;

void methods_table_free(methods_table *table)
{
    free(table->rows);
    *table = (methods_table){.rows = NULL};
}

static ost_status methods_table_add(methods_table *table, const methods_row *row, ost_error *err)
{
    if (table->count == table->capacity) {
        const size_t capacity = table->capacity ? 2 * table->capacity : 64;
        methods_row *grown = realloc(table->rows, capacity * sizeof *grown);
        if (!grown)
            return ost_fail(err, OST_ERR_MEMORY, "out of memory for the rows of a measurement");
        table->rows = grown;
        table->capacity = capacity;
    }
    table->rows[table->count++] = *row;
    return OST_OK;
}

/* Returns true if the options select the method with this name. */
static bool methods_selected(const methods_options *options, const char *name)
{
    const size_t length = strlen(name);
    for (const char *at = options->methods; at; at = strchr(at, ',') ? strchr(at, ',') + 1 : NULL)
        if (strncmp(at, name, length) == 0 && (at[length] == 0 || at[length] == ','))
            return true;
    return options->methods == NULL;
}

ost_status methods_check(const methods_options *options, ost_error *err)
{
    for (const char *at = options->methods; at && *at;) {
        const size_t length = strcspn(at, ",");
        bool found = false;
        for (int m = 0; m < methods_count(); m++)
            found = found || (strlen(methods_info_get(m)->name) == length &&
                              strncmp(methods_info_get(m)->name, at, length) == 0);
        if (!found)
            return ost_fail(err, OST_ERR_USAGE, "there is no removal method '%.*s'", (int)length, at);
        at += length + (at[length] == ',');
    }
    if (options->threads < 1)
        return ost_fail(err, OST_ERR_USAGE, "the number of threads is %d; it must be at least 1", options->threads);
    return OST_OK;
}

/* Fills the parts of a row that describe the scene. */
static methods_row describe(const methods_options *options, const methods_scene *scene, int chunk_size, int chunks,
                            int64_t points, const methods_info *info)
{
    const ost_dims t = scene->event.tool.geometry.dims;
    const int32_t side = t.x > t.y ? t.x : t.y;
    return (methods_row){
        .method = info,
        .tool = scene->event.tool_name,
        .tool_voxel = scene->event.tool.geometry.voxel,
        .bone_voxel = scene->event.bone.spacing.x,
        .tool_side = side > t.z ? side : t.z,
        .bone_side = scene->event.bone.dims.x,
        .tool_voxels = ost_tool_volume_count(&scene->event.tool, OST_TOOL_CUTTING),
        .tool_points = points,
        .chunk_size = chunk_size,
        .chunks = chunks,
        .points = options->points,
        .threads = info->device ? 0 : options->threads,
    };
}

static void close_entrant(entrant *e)
{
    if (e->state)
        e->method->close(e->state);
    e->state = NULL;
}

static void fail_entrant(entrant *e, const ost_error *err)
{
    snprintf(e->row.reason, sizeof e->row.reason, "%.*s", BENCH_TEXT - 1, err->text);
    close_entrant(e);
}

/* The sets of removed voxels required by the two definitions. */
typedef struct demands {
    method_set bone_to_tool, tool_to_bone;
} demands;

static void free_demands(demands *d)
{
    method_set_free(&d->bone_to_tool);
    method_set_free(&d->tool_to_bone);
}

static ost_status make_demands(demands *d, const methods_scene *scene, methods_points which, int64_t *count,
                               ost_error *err)
{
    const bench_scene *event = &scene->event;
    method_points points = {0};
    points_map map;
    *d = (demands){.bone_to_tool = {.in = NULL}};
    ost_status status = method_set_init(&d->bone_to_tool, &scene->region, err);
    if (status == OST_OK)
        status = method_set_init(&d->tool_to_bone, &scene->region, err);
    if (status == OST_OK)
        status = method_points_init(&points, &event->tool, which, 0, err);
    if (status == OST_OK)
        status = points_map_make(&map, &event->pose, &event->bone, &event->tool.geometry, err);
    if (status == OST_OK) {
        method_define_bone_to_tool(&d->bone_to_tool, event, scene->voxels);
        method_define_tool_to_bone(&d->tool_to_bone, &points, &map, event->bone.dims, scene->voxels);
        *count = points.count;
    }
    method_points_free(&points);
    return status;
}

/*
 * Runs the event once and compares the result with the required set. The time of this event determines the number of
 * repetitions.
 */
static ost_status verify(entrant *e, const demands *d, const methods_scene *scene, ost_error *err)
{
    const method *m = e->method;
    method_set set = {.in = NULL};
    method_difference difference, from_demand;
    ost_status status = method_set_init(&set, &scene->region, err);
    if (status == OST_OK)
        status = m->restore(e->state, err);
    const int64_t begin = bench_now();
    if (status == OST_OK)
        status = m->remove(e->state, err);
    e->estimate = (double)(bench_now() - begin);
    if (status == OST_OK)
        status = m->result(e->state, &set, err);
    if (status == OST_OK) {
        method_work work;
        m->work(e->state, &work);
        method_set_compare(&d->bone_to_tool, &set, &difference);
        method_set_compare(m->info.definition == METHODS_TOOL_TO_BONE ? &d->tool_to_bone : &d->bone_to_tool, &set,
                           &from_demand);
        e->row.exact = m->info.definition == METHODS_BONE_TO_TOOL_FLOAT
                           ? method_beyond_floats(&d->bone_to_tool, &set, &scene->event) == 0
                           : from_demand.missed == 0 && from_demand.extra == 0;
        e->row.visited = work.visited;
        e->row.bone_bytes = work.bone_bytes;
        e->row.index_bytes = work.index_bytes;
        e->row.tool_bytes = work.tool_bytes;
        e->row.removed = difference.removed;
        e->row.expected = difference.expected;
        e->row.missed = difference.missed;
        e->row.missed_inside = difference.missed_inside;
        e->row.extra = difference.extra;
    }
    method_set_free(&set);
    return status;
}

static ost_status time_event(entrant *e, bench_series *series, ost_error *err)
{
    const int64_t begin = bench_now();
    ost_status status = e->method->remove(e->state, err);
    const int64_t end = bench_now();
    if (series)
        bench_series_add(series, (double)(end - begin));
    return status;
}

/* Runs one repetition of one method. Its times are stored only if `keep` is true. */
static void repeat(entrant *e, bool keep)
{
    ost_error err = {.status = OST_OK};
    ost_status status = e->method->restore(e->state, &err);
    if (status == OST_OK)
        status = time_event(e, keep ? &e->fresh : NULL, &err);
    if (status == OST_OK)
        status = time_event(e, NULL, &err);
    if (status == OST_OK)
        status = time_event(e, keep ? &e->steady : NULL, &err);
    if (status != OST_OK)
        fail_entrant(e, &err);
}

static int repetitions(const methods_options *options, const entrant *e)
{
    if (options->repeat)
        return options->repeat;
    if (options->quick)
        return QUICK;
    return e->estimate > SLOW_NS ? REPEAT_SLOW : REPEAT;
}

static bench_figures figures_of(bench_series *series)
{
    return (bench_figures){.count = series->count, .median = bench_series_at(series, 0.5) / 1e3,
                           .min = bench_series_at(series, 0) / 1e3, .max = bench_series_at(series, 1) / 1e3};
}

static void measure_all(const methods_options *options, entrant *entrants, int count)
{
    bool more = true;
    /* Repetition -1 is the warm-up. */
    for (int r = -1; more; r++) {
        more = false;
        for (int n = 0; n < count; n++) {
            entrant *e = &entrants[n];
            if (!e->state || !e->row.exact || r >= repetitions(options, e))
                continue;
            repeat(e, r >= 0);
            more = true;
        }
    }
    for (int n = 0; n < count; n++) {
        entrants[n].row.fresh = figures_of(&entrants[n].fresh);
        entrants[n].row.steady = figures_of(&entrants[n].steady);
        bench_series_free(&entrants[n].fresh);
        bench_series_free(&entrants[n].steady);
    }
}

/* The data of a case that all methods share. */
typedef struct measured_case {
    const methods_options *options;
    const methods_scene *scene;
    method_setup setup;
    demands demands;
    char reason[BENCH_TEXT]; /* why no device is available */
} measured_case;

static void open_entrant(const measured_case *c, entrant *e)
{
    ost_error err = {.status = OST_OK};
    if (e->method->info.device && !c->setup.device)
        ost_fail(&err, OST_ERR_UNAVAILABLE, "%s", c->reason);
    else if (method_open(e->method, c->scene, &c->setup, &e->state, &err) == OST_OK)
        verify(e, &c->demands, c->scene, &err);
    if (err.status != OST_OK)
        fail_entrant(e, &err);
}

static void run_entrants(const measured_case *c, entrant *entrants, int count)
{
    for (int n = 0; n < count; n++)
        open_entrant(c, &entrants[n]);
    measure_all(c->options, entrants, count);
    for (int n = 0; n < count; n++)
        close_entrant(&entrants[n]);
}

ost_status methods_measure(const methods_options *options, const methods_scene *scene, int chunk_size,
                           methods_table *table, ost_error *err)
{
    entrant entrants[METHODS_MAX];
    int count = 0;
    int64_t points = 0;
    double bytes = 0;
    measured_case c = {.options = options, .scene = scene, .reason = "no OpenCL device was selected"};
    const int chunks = methods_scene_active_chunks(scene, chunk_size);
    struct method_device *device = options->cl ? method_device_open(options->cl, c.reason) : NULL;
    c.setup = (method_setup){.chunk_size = chunk_size, .threads = options->threads, .points = options->points,
                             .backend = options->backend, .device = device};
    ost_status status = make_demands(&c.demands, scene, options->points, &points, err);
    for (int m = 0; m < methods_count() && status == OST_OK; m++) {
        const method *one = method_get(m);
        if (!methods_selected(options, one->info.name))
            continue;
        bytes += method_needs(one, scene);
        entrants[count++] = (entrant){
            .method = one, .row = describe(options, scene, chunk_size, chunks, points, &one->info)};
    }
    if (bytes < 0.5 * (double)bench_memory())
        run_entrants(&c, entrants, count);
    else
        for (int n = 0; n < count; n++)
            run_entrants(&c, &entrants[n], 1);
    free_demands(&c.demands);
    for (int n = 0; n < count && status == OST_OK; n++)
        status = methods_table_add(table, &entrants[n].row, err);
    method_device_close(device);
    return status;
}

ost_status methods_not_measured(const methods_options *options, const methods_row *scene, const char *reason,
                                methods_table *table, ost_error *err)
{
    ost_status status = OST_OK;
    for (int m = 0; m < methods_count() && status == OST_OK; m++) {
        methods_row row = *scene;
        row.method = methods_info_get(m);
        row.threads = row.method->device ? 0 : options->threads;
        row.points = options->points;
        snprintf(row.reason, sizeof row.reason, "%.*s", BENCH_TEXT - 1, reason);
        if (methods_selected(options, row.method->name))
            status = methods_table_add(table, &row, err);
    }
    return status;
}
