/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Measures frames of 1280 x 720 pixels, in which the processor draws the scapula from a list of surface voxels. As in
 * the thesis (Fig. 3.3), the baseline draws every active voxel of every active chunk as a point. The baseline uses the
 * same inner loops. Before anything is timed, osteon and the baseline must produce the same picture as the scalar
 * loops.
 */
#include "bench/bench.h"
#include "bench/inputs.h"
#include "bench/render_gl.h"
#include "bench/render_kept.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <osteon/phantom.h>
#include <osteon/sim.h>

#include "render/points/frame.h"
#include "render/points/uncut.h"
#include "render/points/renew.h"

enum { REPEAT = 101, WIDTH = 1280, HEIGHT = 720, THRESHOLD = 120, DIRTY = 20 };

typedef struct view {
    const char *name;
    /* distance of the camera from the glenoid's face or, if `glenoid` is false, from the bone's middle */
    double distance_mm;
    bool glenoid;
    /* sideways component of the view direction, relative to the component along the glenoid's axis */
    double side;
} view;

static const view views[] = {
    {"whole", 420, false, 0}, {"oblique", 300, false, 2}, {"glenoid", 90, true, 0}, {"close", 38, true, 0}};

typedef struct show {
    const bench_options *options;
    ost_error *err;
    ost_volume bone;
    ost_glenoid glenoid;
    ost_surface surface, all; /* `surface` has the surface voxels as points; `all` has every active voxel */
    ost_isa isa;
} show;

static ost_status make_bone(show *s)
{
    const ost_phantom_options options = {.scale = s->options->quick ? 0.25 : 1};
    ost_volume ct = {0};
    ost_backend *backend = NULL;
    ost_grid *rect = NULL, *cubic = NULL;
    ost_status status = ost_phantom_make(OST_PHANTOM_SCAPULA, &options, &ct, s->err);
    if (status == OST_OK)
        status = ost_glenoid_from_meta(&ct.meta, &s->glenoid, s->err);
    if (status == OST_OK)
        status = ost_backend_open("ref", &backend, s->err);
    if (status == OST_OK)
        status = ost_grid_create(backend, &ct.geometry, &rect, s->err);
    if (status == OST_OK)
        status = ost_grid_upload(rect, 0, ct.geometry.dims.z, ct.voxels, s->err);
    if (status == OST_OK)
        status = ost_rect_to_cubic(rect, ct.geometry.spacing.x, OST_RESAMPLE_LINEAR, &cubic, s->err);
    if (status == OST_OK)
        status = ost_volume_init(&s->bone, ost_grid_geometry(cubic), s->err);
    if (status == OST_OK)
        status = ost_grid_download(cubic, 0, s->bone.geometry.dims.z, s->bone.voxels, s->err);
    ost_grid_free(cubic);
    ost_grid_free(rect);
    ost_backend_close(backend);
    ost_volume_free(&ct);
    return status;
}

/* Creates a surface in which every active voxel is a point with six visible faces, as in the thesis. */
static ost_status take_all(ost_surface *s, ost_error *err)
{
    s->points = 0;
    for (int32_t i = 0; i < s->used; i++) {
        ost_surface_block *b = s->slot[i];
        uint32_t count = 0;
        for (int row = 0; row < OST_BLOCK_ROWS; row++)
            count += (uint32_t)__builtin_popcount(b->occupancy[row]);
        uint32_t *points = realloc(b->points, ((size_t)count + 1) * sizeof *points);
        if (!points)
            return ost_fail(err, OST_ERR_MEMORY, "out of memory for %u points", (unsigned)count);
        uint32_t *shades = realloc(b->shades, ((size_t)count + 1) * sizeof *shades);
        if (shades)
            b->shades = shades;
        b->points = points;
        if (!shades)
            return ost_fail(err, OST_ERR_MEMORY, "out of memory for %u points", (unsigned)count);
        memset(shades, 0, ((size_t)count + 1) * sizeof *shades);
        b->count = b->capacity = count;
        s->points += count;
        for (uint32_t row = 0; row < OST_BLOCK_ROWS; row++)
            for (uint32_t left = b->occupancy[row]; left; left &= left - 1)
                *points++ = (uint32_t)__builtin_ctz(left) | row << 5 | 63u << OST_FACES_SHIFT;
    }
    return OST_OK;
}

static ost_status make_surface(show *s, ost_surface *surface)
{
    ost_status status = ost_surface_init(surface, &s->bone.geometry, s->err);
    if (status == OST_OK)
        status = ost_surface_set_volume(surface, &s->bone, THRESHOLD, s->err);
    return status == OST_OK ? ost_surface_update(surface, s->err) : status;
}

static ost_status camera_of(const show *s, const view *v, ost_camera *camera)
{
    const ost_geometry *g = &s->bone.geometry;
    const ost_pm3 *at = &s->glenoid.at;
    const double scale = s->options->quick ? 0.25 : 1, up[3] = {0, 0, 1};
    const double middle[3] = {1e-9 * ((double)g->origin.x + 0.5 * (double)(g->dims.x * g->spacing.x)),
                              1e-9 * ((double)g->origin.y + 0.5 * (double)(g->dims.y * g->spacing.y)),
                              1e-9 * ((double)g->origin.z + 0.5 * (double)(g->dims.z * g->spacing.z))};
    const double face[3] = {1e-9 * (double)at->x, 1e-9 * (double)at->y, 1e-9 * (double)at->z};
    const double *inward = s->glenoid.axis,
                 axis[3] = {inward[0] - v->side * inward[1], inward[1] + v->side * inward[0], inward[2]};
    const double length = sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
    double from[3];
    for (int a = 0; a < 3; a++)
        from[a] = (v->glenoid ? face : middle)[a] - scale * v->distance_mm * axis[a] / length;
    /* This focal length results in a vertical field of view of 45 degrees. */
    *camera = (ost_camera){.focal_milli = 869117, .width = WIDTH, .height = HEIGHT};
    return ost_camera_look_at(from, v->glenoid ? face : middle, up, camera, s->err);
}

static bool same(const ost_frame *a, const ost_frame *b)
{
    for (int y = 0; y < HEIGHT; y++) {
        const size_t at = (size_t)y * (size_t)a->planes.stride;
        if (memcmp(a->planes.face + at, b->planes.face + at, WIDTH) != 0)
            return false;
    }
    return true;
}

static size_t covered(const ost_frame *f)
{
    size_t count = 0;
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++)
            count += f->planes.face[(size_t)y * (size_t)f->planes.stride + (size_t)x] != OST_NO_FACE;
    return count;
}

typedef struct frames {
    /* set[isa] is the frame that is drawn with the instruction set isa */
    ost_frame ours, thesis, set[OST_ISA_COUNT];
    bench_series drawn, baseline, by_set[OST_ISA_COUNT];
} frames;

static void free_frames(frames *f)
{
    ost_frame_free(&f->ours);
    ost_frame_free(&f->thesis);
    for (int isa = 0; isa < OST_ISA_COUNT; isa++) {
        ost_frame_free(&f->set[isa]);
        bench_series_free(&f->by_set[isa]);
    }
    bench_series_free(&f->drawn);
    bench_series_free(&f->baseline);
}

static ost_status open_frames(show *s, frames *f, int threads)
{
    ost_status status = ost_frame_init(&f->ours, WIDTH, HEIGHT, OST_STYLE_SMOOTH, s->isa, threads, s->err);
    if (status == OST_OK)
        status = ost_frame_init(&f->thesis, WIDTH, HEIGHT, OST_STYLE_FACES, s->isa, threads, s->err);
    for (int isa = 0; isa < OST_ISA_COUNT && status == OST_OK; isa++)
        if (ost_isa_available((ost_isa)isa))
            status = ost_frame_init(&f->set[isa], WIDTH, HEIGHT, OST_STYLE_SMOOTH, (ost_isa)isa, threads, s->err);
    return status;
}

static ost_status draw(ost_frame *frame, const ost_surface *surface, const ost_eye *eye, bench_series *series,
                       ost_error *err)
{
    const int64_t begin = bench_now();
    ost_status status = ost_frame_draw(frame, surface, eye, err);
    const int64_t end = bench_now();
    if (series)
        bench_series_add(series, (double)(end - begin));
    return status;
}

static ost_status measure(show *s, frames *f, const ost_eye *eye, bool *equal)
{
    enum { SETS_EVERY = 8 };
    ost_status status = draw(&f->ours, &s->surface, eye, NULL, s->err);
    if (status == OST_OK)
        status = draw(&f->thesis, &s->all, eye, NULL, s->err);
    *equal = status == OST_OK && same(&f->ours, &f->thesis);
    for (int isa = 0; isa < OST_ISA_COUNT && status == OST_OK; isa++)
        if (f->set[isa].width) {
            status = draw(&f->set[isa], &s->surface, eye, NULL, s->err);
            *equal &= status == OST_OK && same(&f->ours, &f->set[isa]);
        }
    const int count = bench_repeat(s->options, REPEAT);
    for (int i = 0; i < count && status == OST_OK && *equal; i++) {
        status = draw(&f->ours, &s->surface, eye, &f->drawn, s->err);
        if (status == OST_OK && i % 4 == 0)
            status = draw(&f->thesis, &s->all, eye, &f->baseline, s->err);
        for (int isa = 0; isa < OST_ISA_COUNT && status == OST_OK && i % SETS_EVERY == 0; isa++)
            if (f->set[isa].width)
                status = draw(&f->set[isa], &s->surface, eye, &f->by_set[isa], s->err);
    }
    return status;
}

/* Adds to the row the minimum time of a frame for each instruction set. */
static void add_sets(bench_row *row, frames *f)
{
    char name[32];
    for (int isa = 0; isa < OST_ISA_COUNT; isa++)
        if (f->set[isa].width) {
            snprintf(name, sizeof name, "%s_min_ms", ost_isa_name((ost_isa)isa));
            bench_row_extra(row, name, bench_series_at(&f->by_set[isa], 0) / 1e6);
        }
}

static ost_status add_view(show *s, bench_table *table, const view *v, int threads, const char *suffix)
{
    char name[BENCH_NAME];
    snprintf(name, sizeof name, "render/scapula/%s%s", v->name, suffix);
    if (!bench_wanted(s->options, name))
        return OST_OK;
    frames f = {0};
    ost_camera camera;
    bool equal = false;
    ost_status status = camera_of(s, v, &camera);
    if (status == OST_OK)
        status = open_frames(s, &f, threads);
    if (status == OST_OK) {
        const ost_eye eye = ost_eye_make(&camera, &s->bone.geometry);
        status = measure(s, &f, &eye, &equal);
    }
    bench_row *row = status == OST_OK ? bench_row_add(table, name, "ms", threads) : NULL;
    if (row) {
        row->equal = equal;
        if (equal) {
            bench_row_ours(row, &f.drawn);
            bench_row_baseline(row, &f.baseline,
                               "every active voxel as a point, as in the thesis, by the same inner loops");
            bench_row_extra(row, "p50_ms", bench_series_at(&f.drawn, 0.5) / 1e6);
            bench_row_extra(row, "p99_ms", bench_series_at(&f.drawn, 0.99) / 1e6);
            bench_row_extra(row, "fps", 1e9 / bench_series_at(&f.drawn, 0.5));
            add_sets(row, &f);
            bench_row_extra(row, "surface_voxels", (double)s->surface.points);
            bench_row_extra(row, "active_voxels", (double)s->all.points);
            bench_row_extra(row, "covered_pixels", (double)covered(&f.ours));
        }
    } else if (status == OST_OK) {
        status = ost_fail(s->err, OST_ERR_MEMORY, "out of memory for a row");
    }
    free_frames(&f);
    const char *const names[] = {name};
    return bench_row_not_run(s->options, table, names, 1, "ms", threads, status, s->err);
}

/* ------------------------------------------------------- lists and shades */

/* The parts of a surface block that are recomputed in a row of the benchmark. */
typedef enum renewal { RENEW_LIST, RENEW_SHADES, RENEW_ALL, RENEWALS } renewal;

static int32_t spoil(ost_surface *s, renewal what)
{
    const int32_t step = s->used > DIRTY ? s->used / DIRTY : 1;
    int32_t count = 0;
    for (int32_t i = 0; i < s->used; i += step, count++) {
        ost_surface_block *b = s->slot[i];
        b->dirty = true;
        b->unlisted = what != RENEW_SHADES;
        b->remade = what != RENEW_LIST;
        b->unmeasured = what == RENEW_ALL;
    }
    return count;
}

/* Measures how long it takes to recompute surface blocks at various positions of the bone. Recomputes either the
   blocks' lists of points, or the shades of the points, or both. */
static ost_status add_renewal(show *s, bench_table *table, renewal what)
{
    static const char *const name[RENEWALS] = {"render/scapula/list", "render/scapula/looks", "render/scapula/extract"};
    bench_series series = {0};
    ost_status status = ost_surface_use(&s->surface, s->isa, s->err);
    if (status != OST_OK || !bench_wanted(s->options, name[what]))
        return status;
    const int count = bench_repeat(s->options, REPEAT);
    int32_t blocks = 0;
    for (int i = -1; i < count && status == OST_OK; i++) {
        blocks = spoil(&s->surface, what);
        const int64_t begin = bench_now();
        status = ost_surface_update(&s->surface, s->err);
        if (i >= 0)
            bench_series_add(&series, (double)(bench_now() - begin));
    }
    bench_row *row = status == OST_OK ? bench_row_add(table, name[what], "us", 1) : NULL;
    if (row) {
        bench_row_ours(row, &series);
        snprintf(row->baseline_reason, sizeof row->baseline_reason, "lists of changed blocks: nothing else makes them");
        bench_row_extra(row, "changed_blocks", (double)blocks);
        bench_row_extra(row, "us_a_block", bench_series_at(&series, 0.5) / 1e3 / blocks);
    }
    bench_series_free(&series);
    return bench_row_not_run(s->options, table, &name[what], 1, "us", 1, status, s->err);
}

/* Measures the time of a surface update while bone is reamed. A ball with a radius of 20 mm enters the glenoid at
   1.5 mm/s, at 60 frames per second. The row contains the time of the update and the number of changed blocks per
   frame. */
static ost_status add_reaming(show *s, bench_table *table)
{
    enum { PICTURES = 120, BEGIN = 40 }; /* BEGIN is the first measured frame, in which the depth is 1 mm */
    static const double RADIUS_MM = 20, STEP_MM = 1.5 / 60;
    static const char *const name = "render/scapula/ream";
    ost_surface surface = {0};
    ost_uncut reference = {0};
    ost_volume before = {0};
    bench_series series = {0};
    uint64_t blocks = 0, changed = 0;
    if (!bench_wanted(s->options, name))
        return OST_OK;
    const ost_geometry *g = &s->bone.geometry;
    const ost_density_classes classes = ost_density_classes_default();
    ost_status status = ost_volume_init(&before, g, s->err);
    if (status == OST_OK) {
        memcpy(before.voxels, s->bone.voxels,
               (size_t)g->dims.x * (size_t)g->dims.y * (size_t)g->dims.z * sizeof *before.voxels);
        status = ost_uncut_init(&reference, &before, THRESHOLD, &classes, NULL, NULL, s->err);
    }
    if (status == OST_OK)
        status = ost_surface_init(&surface, g, s->err);
    if (status == OST_OK)
        status = ost_surface_use(&surface, s->isa, s->err);
    if (status == OST_OK)
        status = ost_surface_set_volume(&surface, &s->bone, THRESHOLD, s->err);
    if (status == OST_OK)
        status = ost_surface_set_uncut(&surface, &reference, s->err);
    surface.shows_contact = true;
    const ost_pm at[3] = {s->glenoid.at.x - g->origin.x, s->glenoid.at.y - g->origin.y, s->glenoid.at.z - g->origin.z};
    const double mm = 1e-9 * (double)g->spacing.x, scale = s->options->quick ? 0.25 : 1;
    const int pictures = bench_repeat(s->options, PICTURES);
    for (int i = -1; i < pictures && status == OST_OK; i++) {
        double middle[3];
        for (int a = 0; a < 3; a++)
            middle[a] = (double)at[a] / (double)g->spacing.x +
                        (STEP_MM * (BEGIN + i) - RADIUS_MM * scale) / mm * s->glenoid.axis[a];
        if (i >= 0 && i % 9 == 0)
            ost_surface_age(&surface);
        int32_t carved;
        status = bench_carve(&surface, middle, RADIUS_MM * scale / mm, &carved, s->err);
        changed += i >= 0 ? (uint64_t)carved : 0;
        const int64_t begin = bench_now();
        if (status == OST_OK)
            status = ost_surface_update(&surface, s->err);
        if (i >= 0)
            bench_series_add(&series, (double)(bench_now() - begin));
        blocks += i >= 0 ? (uint64_t)surface.renewals : 0;
    }
    bench_row *row = status == OST_OK ? bench_row_add(table, name, "us", 1) : NULL;
    if (row) {
        bench_row_ours(row, &series);
        snprintf(row->baseline_reason, sizeof row->baseline_reason, "lists of changed blocks: nothing else makes them");
        bench_row_extra(row, "p99_us", bench_series_at(&series, 0.99) / 1e3);
        bench_row_extra(row, "changed_blocks", (double)changed / pictures);
        bench_row_extra(row, "renewed_blocks", (double)blocks / pictures);
    }
    bench_series_free(&series);
    ost_surface_free(&surface);
    ost_uncut_free(&reference);
    ost_volume_free(&before);
    return bench_row_not_run(s->options, table, &name, 1, "us", 1, status, s->err);
}

ost_status bench_render(const bench_options *options, bench_table *table, ost_error *err)
{
    show s = {.options = options, .err = err};
    const bool gl_wanted = bench_gl_wanted(options->filter), kept_wanted = bench_kept_wanted(options->filter);
    bench_gl *gl = NULL;
    if (!gl_wanted && !kept_wanted && options->filter &&
        !strstr("render/scapula/list render/scapula/looks render/scapula/extract render/scapula/ream "
                "render/scapula/whole/1 render/scapula/oblique/1 render/scapula/glenoid/1 render/scapula/close/1",
                options->filter))
        return OST_OK;
    ost_status status = ost_isa_choose(bench_isa(options), &s.isa, err);
    if (status == OST_OK)
        status = make_bone(&s);
    if (status == OST_OK)
        status = make_surface(&s, &s.surface);
    if (status == OST_OK)
        status = make_surface(&s, &s.all);
    if (status == OST_OK)
        status = take_all(&s.all, err);
    for (size_t v = 0; v < sizeof views / sizeof *views && status == OST_OK; v++) {
        status = add_view(&s, table, &views[v], options->threads, "");
        if (status == OST_OK)
            status = add_view(&s, table, &views[v], 1, "/1");
    }
    if (status == OST_OK && gl_wanted)
        status = bench_gl_open(&gl, err);
    for (size_t v = 0; v < sizeof views / sizeof *views && status == OST_OK && gl; v++) {
        if (views[v].side > 0)
            continue;
        ost_camera camera;
        status = camera_of(&s, &views[v], &camera);
        if (status == OST_OK)
            status = bench_gl_view(gl, options, table, views[v].name, &s.surface, &camera, s.isa, err);
    }
    bench_gl_close(gl);
    if (status == OST_OK)
        status = add_renewal(&s, table, RENEW_LIST);
    if (status == OST_OK)
        status = add_renewal(&s, table, RENEW_SHADES);
    if (status == OST_OK)
        status = add_renewal(&s, table, RENEW_ALL);
    if (status == OST_OK)
        status = add_reaming(&s, table);
    if (status == OST_OK && kept_wanted)
        status = bench_kept(options, table, &s.bone, &s.glenoid, THRESHOLD, s.isa, err);
    ost_surface_free(&s.surface);
    ost_surface_free(&s.all);
    ost_volume_free(&s.bone);
    return status;
}
