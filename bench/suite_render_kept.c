/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Measures frames while a reamer cuts and the camera does not move.
 *
 *   world --16 ticks of the reamer per frame, about 60 frames a second--> ost_live_channel
 *   ost_live_channel --> viewer --> the incremental frame
 *                          '------> the complete frame
 *
 * The incremental and the complete frame are drawn alternately from the same state, and must be bit-identical
 * every time. The stages are measured in one of STAGES_EVERY frames. The other times exclude this frame,
 * because timing every call of an inner loop makes a frame slower.
 */
#include "bench/render_kept.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <osteon/motor.h>

#include "bench/scene.h"
#include "render/viewer.h"
#include "render/views.h"

enum { FRAMES = 200, QUICK = 6, WIDTH = 1280, HEIGHT = 720, TICKS = 16, CHUNK = 32, STAGES_EVERY = 4 };

typedef struct view {
    const char *name;
    ost_view_name from;
    double distance_mm; /* distance of the camera; 0 selects the default distance of the named view */
} view;

/* The views of the rows. In the view `close`, the reamer fills the frame. */
static const view views[] = {{"whole", OST_VIEW_OVERVIEW, 0},
                             {"en-face", OST_VIEW_EN_FACE, 0},
                             {"operator", OST_VIEW_OPERATOR, 0},
                             {"close", OST_VIEW_EN_FACE, 38}};

/* ------------------------------------------------------------------- stages */

typedef enum stage { POINTS, TINTS, SPLAT, HIDDEN, RESOLVE, MERGE, STAGES } stage;

/* The inner loops of a frame, and the total time of each stage on one thread. Each function below calls one of these
   inner loops and adds the time of the call to the total of its stage. */
static struct {
    ost_splat_kernels kernels;
    ost_light_tint_of *tint;
    int64_t ns[STAGES];
} clocked;

static uint32_t facing(const ost_surface_block *block, uint32_t slot, const uint8_t turned[3][OST_BLOCK],
                       ost_chosen *out)
{
    const int64_t begin = bench_now();
    const uint32_t count = clocked.kernels.facing(block, slot, turned, out);
    clocked.ns[POINTS] += bench_now() - begin;
    return count;
}

static void tint(const ost_light *light, const uint32_t *shade, uint32_t count, uint32_t *out)
{
    const int64_t begin = bench_now();
    clocked.tint(light, shade, count, out);
    clocked.ns[TINTS] += bench_now() - begin;
}

static void splat(const ost_splat_eye *eye, const ost_visible *visible, uint32_t slot, uint32_t count,
                  const ost_planes *planes, const ost_extent *part)
{
    const int64_t begin = bench_now();
    clocked.kernels.splat(eye, visible, slot, count, planes, part);
    clocked.ns[SPLAT] += bench_now() - begin;
}

static void resolve(const ost_splat_eye *eye, const ost_visible *visible, const ost_planes *planes, int y, int x0,
                    int x1)
{
    const int64_t begin = bench_now();
    clocked.kernels.resolve(eye, visible, planes, y, x0, x1);
    clocked.ns[RESOLVE] += bench_now() - begin;
}

static uint64_t farthest(const ost_planes *planes, int x, int y, int rows)
{
    const int64_t begin = bench_now();
    const uint64_t key = clocked.kernels.farthest(planes, x, y, rows);
    clocked.ns[HIDDEN] += bench_now() - begin;
    return key;
}

static void merge(const ost_planes *to, const ost_planes *from, float scale, int y, int x0, int x1, uint64_t *taken)
{
    const int64_t begin = bench_now();
    clocked.kernels.merge(to, from, scale, y, x0, x1, taken);
    clocked.ns[MERGE] += bench_now() - begin;
}

/* ------------------------------------------------------------------ a cut */

typedef struct cut {
    const bench_options *options;
    ost_error *err;
    ost_backend *backend;
    bench_scene scene; /* provides the tool */
    ost_bone *bone;
    ost_tool *tool;
    ost_world *world;
    ost_live_channel *live;
    ost_viewer viewer; /* the viewer whose frame is drawn incrementally */
    ost_frame redrawn;
    ost_path path;
    size_t at;         /* index in the path */
    ost_view_subject subject;
} cut;

static void close_cut(cut *c)
{
    ost_viewer_free(&c->viewer);
    ost_frame_free(&c->redrawn);
    ost_path_free(&c->path);
    ost_live_free(c->live);
    ost_world_free(c->world);
    ost_tool_free(c->tool);
    ost_bone_free(c->bone);
    ost_backend_close(c->backend);
    bench_scene_free(&c->scene);
}

/* Draws the tool as its mesh, as the simulator does. */
static ost_status smooth_tool(cut *c)
{
    ost_mesh mesh = {0};
    ost_status status = ost_tool_make(OST_TOOL_REAMER, NULL, &mesh, c->err);
    if (status == OST_OK)
        status = ost_viewer_smooth_tool(&c->viewer, &mesh, 1, c->err);
    ost_mesh_free(&mesh);
    return status;
}

static ost_status open_cut(cut *c, const ost_volume *bone, const ost_glenoid *glenoid, int32_t threshold, ost_isa isa)
{
    const ost_geometry *g = &bone->geometry;
    ost_status status = bench_scene_init(&c->scene, OST_TOOL_REAMER, OST_PM_PER_MM / 2, SCENE_SIDE, c->err);
    if (status == OST_OK)
        status = ost_backend_open("cpu:threads=1", &c->backend, c->err);
    if (status == OST_OK)
        status = ost_tool_upload(c->backend, &c->scene.tool, &c->tool, c->err);
    if (status == OST_OK)
        status = ost_bone_create(c->backend, g, CHUNK, threshold, &c->bone, c->err);
    if (status == OST_OK)
        status = ost_bone_upload(c->bone, 0, g->dims.z, bone->voxels, c->err);
    if (status == OST_OK)
        status = ost_world_create(c->bone, NULL, &c->world, c->err);
    if (status == OST_OK)
        status = ost_world_add_tool(c->world, c->scene.tool_name, c->tool, NULL, c->err);
    if (status == OST_OK)
        status = ost_builtin_path(OST_BUILTIN_GLENOID_SLOW, glenoid, &c->scene.tool.geometry, 0, &c->path, c->err);
    ost_motor motor = {0};
    if (status == OST_OK)
        status = ost_motor_path(&c->path, OST_RPM_REAMER, &motor, c->err);
    if (status == OST_OK)
        status = ost_live_create(c->bone, &c->live, c->err);
    if (status == OST_OK)
        status = ost_viewer_init(&c->viewer, g, OST_STYLE_SMOOTH, ost_isa_name(isa), 1, c->err);
    if (status == OST_OK)
        status = ost_viewer_add_tool(&c->viewer, &c->scene.tool, c->err);
    if (status == OST_OK)
        status = smooth_tool(c);
    c->viewer.antialiased = true;
    if (status == OST_OK)
        status = ost_frame_init(&c->redrawn, WIDTH, HEIGHT, OST_STYLE_SMOOTH, isa, 1, c->err);
    if (status == OST_OK)
        status = ost_frame_antialias(&c->redrawn, isa, c->err);
    ost_viewer_follow(&c->viewer, c->live);
    c->subject = ost_view_subject_make(g, &glenoid->at, glenoid->axis, glenoid->left);
    return status;
}

/* Runs the ticks until the next frame is due. Sets *removed to true if at least one tick so far has removed voxels. */
static ost_status go_on(cut *c, bool *removed)
{
    ost_status status = OST_OK;
    *removed = false;
    for (int i = 0; i < TICKS && c->at < c->path.count && status == OST_OK; i++, c->at++) {
        ost_step_result result = {0};
        const ost_tick *tick = &c->path.ticks[c->at];
        status = ost_world_step(c->world, tick, &result, c->err);
        if (status != OST_OK)
            break;
        ost_world_totals totals;
        ost_world_totals_get(c->world, &totals);
        *removed = totals.removed_voxels > 0;
        ost_live_changed(c->live, result.report);
        const ost_live_state state = {.ticks = c->at + 1, .t_ns = tick->t_ns, .pose = tick->pose, .device = tick->pose};
        status = ost_live_publish(c->live, &state, c->err);
    }
    return status == OST_OK ? ost_viewer_update(&c->viewer, c->err) : status;
}

static void exchange(cut *c)
{
    const ost_frame other = c->viewer.frame;
    c->viewer.frame = c->redrawn;
    c->redrawn = other;
}

/* Draws the viewer's frame. If `stages` is true, also measures the stages of the frame by timing every call
   of an inner loop. */
static ost_status draw(cut *c, const ost_camera *camera, bool stages, bench_series *series)
{
    ost_frame *f = &c->viewer.frame;
    if (stages && f->width) {
        clocked.kernels = f->kernels;
        clocked.tint = f->tint;
        f->kernels = (ost_splat_kernels){facing, splat, resolve, farthest, merge};
        f->tint = tint;
    }
    const int64_t begin = bench_now();
    ost_status status = ost_viewer_draw(&c->viewer, camera, c->err);
    bench_series_add(series, (double)(bench_now() - begin));
    if (stages && f->kernels.splat == splat) {
        f->kernels = clocked.kernels;
        f->tint = clocked.tint;
    }
    return status;
}

static bool same(const ost_frame *a, const ost_frame *b)
{
    bool equal = true;
    for (int y = 0; y < HEIGHT && equal; y++) {
        const size_t at = (size_t)y * (size_t)a->planes.stride;
        equal = memcmp(a->planes.face + at, b->planes.face + at, WIDTH) == 0 &&
                memcmp(a->planes.colour + at, b->planes.colour + at, WIDTH * sizeof(uint32_t)) == 0;
    }
    return equal;
}

typedef struct figures {
    bench_series kept, redrawn, other;
    /* times in ms of the stages, in stages[0] for the incremental frame and in stages[1] for the complete frame */
    double stages[2][STAGES];
    int staged, frames;
    uint64_t cells, stale, chunks;
    bool equal;
} figures;

static uint64_t cells_in(const ost_cells *cells)
{
    uint64_t count = 0;
    for (int i = 0; i < cells->words * cells->rows; i++)
        count += (uint64_t)__builtin_popcountll(cells->bit[i]);
    return count;
}

/* Draws the incremental and the complete frame of the current state. */
static ost_status draw_both(cut *c, const ost_camera *camera, figures *f, bool stages)
{
    memset(clocked.ns, 0, sizeof clocked.ns);
    ost_status status = draw(c, camera, stages, stages ? &f->other : &f->kept);
    for (int i = 0; i < STAGES && stages; i++)
        f->stages[0][i] += (double)clocked.ns[i] / 1e6;
    if (status != OST_OK)
        return status;
    f->cells += cells_in(&c->viewer.frame.part);
    f->stale += cells_in(&c->viewer.frame.stale);
    memset(clocked.ns, 0, sizeof clocked.ns);
    exchange(c);
    status = draw(c, camera, stages, stages ? &f->other : &f->redrawn);
    exchange(c);
    for (int i = 0; i < STAGES && stages; i++)
        f->stages[1][i] += (double)clocked.ns[i] / 1e6;
    f->staged += stages;
    f->frames++;
    f->equal = f->equal && same(&c->viewer.frame, &c->redrawn);
    return status;
}

/* Measures the frames that follow the first tick that removes voxels. */
static ost_status measure(cut *c, const view *from, figures *f)
{
    ost_orbit orbit = ost_view_orbit(from->from, &c->subject, NULL);
    const int count = c->options->quick ? QUICK : bench_repeat(c->options, FRAMES);
    ost_camera camera;
    bool removed = false;
    orbit.distance = from->distance_mm > 0 ? from->distance_mm : orbit.distance;
    ost_status status = ost_orbit_camera(&orbit, WIDTH, HEIGHT, &camera, c->err);
    while (status == OST_OK && !removed && c->at < c->path.count)
        status = go_on(c, &removed);
    /* Both frames are drawn twice before the measurement, because a stored frame is complete only after the second
       drawing. */
    for (int i = 0; i < 2 && status == OST_OK; i++) {
        status = ost_viewer_draw(&c->viewer, &camera, c->err);
        exchange(c);
        if (status == OST_OK)
            status = ost_viewer_draw(&c->viewer, &camera, c->err);
        exchange(c);
    }
    f->equal = status == OST_OK;
    const uint64_t before = c->viewer.changed;
    for (int i = 0; i < count && status == OST_OK && f->equal; i++) {
        status = go_on(c, &removed);
        if (status == OST_OK)
            status = draw_both(c, &camera, f, i % STAGES_EVERY == 1);
    }
    f->chunks = c->viewer.changed - before;
    return status;
}

static void add_row(bench_row *row, figures *f)
{
    static const char *const names[2][STAGES] = {
        {"kept_points_ms", "kept_tints_ms", "kept_splat_ms", "kept_hidden_ms", "kept_resolve_ms", "kept_merge_ms"},
        {"whole_points_ms", "whole_tints_ms", "whole_splat_ms", "whole_hidden_ms", "whole_resolve_ms",
         "whole_merge_ms"}};
    bench_row_ours(row, &f->kept);
    bench_row_baseline(row, &f->redrawn, "the same frame drawn whole");
    bench_row_extra(row, "p99_ms", bench_series_at(&f->kept, 0.99) / 1e6);
    bench_row_extra(row, "drawn_share",
                    (double)f->cells / f->frames / (WIDTH / OST_CELL_WIDTH * HEIGHT / OST_CELL_HEIGHT));
    bench_row_extra(row, "put_back_share",
                    (double)f->stale / f->frames / (WIDTH / OST_CELL_WIDTH * HEIGHT / OST_CELL_HEIGHT));
    bench_row_extra(row, "changed_chunks", (double)f->chunks / f->frames);
    for (int i = 0; i < 2; i++)
        for (int j = 0; j < STAGES && f->staged; j++)
            bench_row_extra(row, names[i][j], f->stages[i][j] / f->staged);
}

static const char *name_of(const view *from, char text[BENCH_NAME])
{
    snprintf(text, BENCH_NAME, "render/frame/%s/1", from->name);
    return text;
}

bool bench_kept_wanted(const char *filter)
{
    char name[BENCH_NAME];
    bool wanted = !filter;
    for (size_t i = 0; i < sizeof views / sizeof *views && !wanted; i++)
        wanted = strstr(name_of(&views[i], name), filter) != NULL;
    return wanted;
}

ost_status bench_kept(const bench_options *options, bench_table *table, const ost_volume *bone,
                      const ost_glenoid *glenoid, int32_t threshold, ost_isa isa, ost_error *err)
{
    char name[BENCH_NAME];
    ost_status status = OST_OK;
    for (size_t i = 0; i < sizeof views / sizeof *views && status == OST_OK; i++) {
        if (!bench_wanted(options, name_of(&views[i], name)))
            continue;
        cut c = {.options = options, .err = err};
        figures f = {0};
        status = open_cut(&c, bone, glenoid, threshold, isa);
        if (status == OST_OK)
            status = measure(&c, &views[i], &f);
        close_cut(&c);
        bench_row *row = status == OST_OK ? bench_row_add(table, name, "ms", 1) : NULL;
        if (row)
            row->equal = f.equal;
        else if (status == OST_OK)
            status = ost_fail(err, OST_ERR_MEMORY, "out of memory for a row");
        if (row && f.equal)
            add_row(row, &f);
        bench_series_free(&f.kept);
        bench_series_free(&f.redrawn);
        bench_series_free(&f.other);
        const char *const names[] = {name};
        status = bench_row_not_run(options, table, names, 1, "ms", 1, status, err);
    }
    return status;
}
