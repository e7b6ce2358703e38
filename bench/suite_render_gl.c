/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Measures frames drawn by OpenGL. The first row is the thesis' frame, and the last rows are osteon's frame. Most of
 * the rows in between differ from an earlier row by one change. Each frame ends with glFinish. Before a row is timed,
 * its picture is compared with the picture that the processor draws. osteon's picture may differ in at most 30 of
 * 921,600 pixels. The other methods lose points at the frame's edge or near the camera. Their rows are measured
 * nevertheless and report the number of pixels that differ.
 */
#include "bench/render_gl.h"

#include <malloc.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "render/gl/gl.h"

enum { NORMAL = 31, SLOW = 7, MAY_DIFFER = 30 };

typedef struct step {
    const char *name, *is;
    ost_gl_variant variant;
    enum {
        STILL,
        MOVING, /* the camera moves back and forth sideways by 1.5 voxels per frame */
        READ    /* the picture is copied from the GPU to memory after each frame, as in render/viewer.c */
    } how;
} step;

#define SURFACE .true_depth = true, .target = OST_GL_WIDE
#define TURNED .frustum = true, .facing = true
#define TIGHT TURNED, .order = true, .tight = true

static const step steps[] = {
    {"thesis",
     "every voxel of the blocks in use, G-buffer of 2 x 128 bits and depth",
     {.every_voxel = true, SURFACE},
     STILL},
    {"surface", "surface voxels alone", {SURFACE}, STILL},
    {"frustum", "and only blocks in sight", {.frustum = true, SURFACE}, STILL},
    {"facing", "and only points turned to the eye", {TURNED, SURFACE}, STILL},
    {"order", "and near blocks first", {TURNED, .order = true, SURFACE}, STILL},
    {"small", "G-buffer of 2 x 32 bits", {TURNED, .order = true, .true_depth = true, .target = OST_GL_SMALL}, STILL},
    {"compact", "G-buffer of 64 bits: colour, face, depth", {TURNED, .order = true, .true_depth = true}, STILL},
    {"tight", "the cube's own rectangle", {TIGHT, .true_depth = true}, STILL},
    {"distance", "depth by the distance of the voxel's centre", {TIGHT}, STILL},
    {"lines", "coverage by lines, not slabs", {TIGHT, .lines = true}, STILL},
    {"occlusion", "and only cells of 8^3 voxels that no others hide", {TIGHT, .lines = true, .occlusion = true}, STILL},
    {"tiles",
     "the same, and a shader finds what hides, as on a graphics card",
     {TIGHT, .lines = true, .occlusion = true, .tiles = true},
     STILL},
    {"moving", "lines, from an eye that moves", {TIGHT, .lines = true}, MOVING},
    {"moving-occlusion",
     "the same, and only cells that no others hide",
     {TIGHT, .lines = true, .occlusion = true},
     MOVING},
    {"forward", "lines without a G-buffer", {TIGHT, .lines = true, .target = OST_GL_FORWARD}, STILL},
    {"bricks", "a point for 4^3 voxels", {.frustum = true, .order = true, .tight = true, .bricks = true}, STILL},
    {"bricks-occlusion",
     "the same of cells that no others hide",
     {.frustum = true, .order = true, .tight = true, .bricks = true, .occlusion = true},
     STILL},
    {"bricks-forward",
     "bricks without a G-buffer",
     {.frustum = true, .order = true, .tight = true, .bricks = true, .target = OST_GL_FORWARD},
     STILL},
    {"ours",
     "points or bricks, whichever suits: --renderer gl",
     {TIGHT, .lines = true, .occlusion = true, .choose = true},
     STILL},
    {"ours-read",
     "the same, and the picture read back",
     {TIGHT, .lines = true, .occlusion = true, .choose = true},
     READ},
};
enum { STEPS = sizeof steps / sizeof *steps };

struct bench_gl {
    ost_gl *gl; /* NULL if OpenGL is unavailable; `missing` then contains the reason */
    char missing[BENCH_TEXT];
};

bool bench_gl_wanted(const char *filter)
{
    static const char *const views[] = {"whole", "glenoid", "close"};
    char name[BENCH_NAME];
    for (int i = 0; filter && i < 3 * STEPS; i++) {
        snprintf(name, sizeof name, "render/gl/%s/%s", views[i % 3], steps[i / 3].name);
        if (strstr(name, filter))
            return true;
    }
    return !filter;
}

ost_status bench_gl_open(bench_gl **out, ost_error *err)
{
    ost_error why = {0};
    *out = calloc(1, sizeof **out);
    if (!*out)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for the rows of OpenGL");
#ifdef __GLIBC__
    /* Software drivers free the memory of every frame and allocate it again. These settings keep freed memory in the
       process, so that the system need not clear the pages for each frame. */
    mallopt(M_TRIM_THRESHOLD, 1 << 30);
    mallopt(M_TOP_PAD, 1 << 26);
    mallopt(M_MMAP_THRESHOLD, 1 << 30);
#endif
    if (ost_gl_open(NULL, &(*out)->gl, &why) != OST_OK)
        snprintf((*out)->missing, sizeof (*out)->missing, "%.*s", BENCH_TEXT - 1, why.text);
    return OST_OK;
}

void bench_gl_close(bench_gl *gl)
{
    if (!gl)
        return;
    ost_gl_close(gl->gl);
    free(gl);
}

static int differing(const ost_frame *a, const ost_frame *b)
{
    int count = 0;
    for (int y = 0; y < a->height; y++)
        for (int x = 0; x < a->width; x++) {
            const size_t at = (size_t)y * (size_t)a->planes.stride + (size_t)x;
            count += a->planes.colour[at] != b->planes.colour[at];
        }
    return count;
}

/* Draws frame `number`. In frame 0, the camera is at the position that the view defines. */
static ost_status draw(ost_gl *gl, const step *s, const ost_frame_thing *still, int number, ost_frame *frame,
                       bench_series *series, ost_error *err)
{
    enum { PERIOD = 32 };
    const int along = number % PERIOD < PERIOD / 2 ? number % PERIOD : PERIOD - number % PERIOD;
    ost_frame_thing moved = *still;
    for (int a = 0; a < 3 && s->how == MOVING; a++)
        moved.eye.at[a] += 1.5f * (float)along * still->eye.right[a];
    const ost_frame_thing *thing = &moved;
    const int64_t begin = bench_now();
    ost_status status = ost_gl_draw(gl, &s->variant, thing, 1, OST_STYLE_FACES, err);
    if (status == OST_OK)
        status = s->how == READ ? ost_gl_read(gl, frame, false, err) : ost_gl_finish(gl, err);
    if (series)
        bench_series_add(series, (double)(bench_now() - begin));
    return status;
}

static ost_status add(bench_gl *b, const bench_options *options, bench_table *table, const char *name, const step *s,
                      const ost_frame_thing *thing, const ost_frame *reference, ost_frame *frame, ost_error *err)
{
    bench_series series = {0}, thesis = {0};
    const bool is_ours = strcmp(s->name, "ours") == 0, slow = s->variant.target == OST_GL_WIDE;
    int differ = 0;
    ost_status status = OST_OK;
    if (b->gl) {
        /* The picture of frame 0 is compared, so this frame is drawn last. The two frames before it are drawn from
           other positions, because a frame omits the cells that were hidden in the previous frame. */
        for (int i = 2; i >= 0 && status == OST_OK; i--)
            status = draw(b->gl, s, thing, i, frame, NULL, err);
        if (status == OST_OK)
            status = ost_gl_read(b->gl, frame, false, err);
        differ = status == OST_OK ? differing(frame, reference) : 0;
    }
    const ost_gl_counts counts = b->gl && status == OST_OK ? ost_gl_counts_get(b->gl) : (ost_gl_counts){0};
    const bool equal = differ <= MAY_DIFFER || !s->variant.lines;
    const int repeat = bench_repeat(options, slow ? SLOW : NORMAL);
    for (int i = 0; b->gl && equal && i < repeat && status == OST_OK; i++) {
        status = draw(b->gl, s, thing, i, frame, &series, err);
        if (status == OST_OK && is_ours && i % 8 == 0)
            status = draw(b->gl, &steps[0], thing, 0, frame, &thesis, err);
    }
    bench_row *row = status == OST_OK ? bench_row_add(table, name, "ms", 0) : NULL;
    if (row && !b->gl) {
        snprintf(row->reason, sizeof row->reason, "%s", b->missing);
        snprintf(row->baseline_reason, sizeof row->baseline_reason, "%s", b->missing);
    } else if (row) {
        row->equal = equal;
        if (equal)
            bench_row_ours(row, &series);
        if (equal && is_ours)
            bench_row_baseline(row, &thesis,
                               "the thesis' frame by the same OpenGL: every voxel of every block in use a point");
        else
            snprintf(row->baseline_reason, sizeof row->baseline_reason, "a step on the way: %s", s->is);
        bench_row_extra(row, "p99_ms", bench_series_at(&series, 0.99) / 1e6);
        bench_row_extra(row, "fps", series.count ? 1e9 / bench_series_at(&series, 0.5) : 0);
        bench_row_extra(row, "points", (double)counts.points);
        bench_row_extra(row, "bricks", counts.bricks);
        bench_row_extra(row, "hidden_cells", counts.hidden);
        bench_row_extra(row, "pixels_that_differ", differ);
    } else if (status == OST_OK) {
        status = ost_fail(err, OST_ERR_MEMORY, "out of memory for a row");
    }
    bench_series_free(&series);
    bench_series_free(&thesis);
    return status;
}

ost_status bench_gl_view(bench_gl *gl, const bench_options *options, bench_table *table, const char *view,
                         const ost_surface *surface, const ost_camera *camera, ost_isa isa, ost_error *err)
{
    const ost_frame_thing thing = {
        .surface = surface, .eye = ost_eye_make(camera, &surface->geometry), .paint = OST_PAINT_BONE};
    ost_frame reference = {0}, frame = {0};
    ost_status status = ost_frame_init(&reference, camera->width, camera->height, OST_STYLE_FACES, isa,
                                       options->threads, err);
    if (status == OST_OK)
        status = ost_frame_init(&frame, camera->width, camera->height, OST_STYLE_FACES, isa, 1, err);
    if (status == OST_OK)
        status = ost_frame_draw_things(&reference, &thing, 1, err);
    for (int i = 0; i < STEPS && status == OST_OK; i++) {
        char name[BENCH_NAME];
        snprintf(name, sizeof name, "render/gl/%s/%s", view, steps[i].name);
        if (bench_wanted(options, name))
            status = add(gl, options, table, name, &steps[i], &thing, &reference, &frame, err);
        const char *const names[] = {name};
        status = bench_row_not_run(options, table, names, 1, "ms", 0, status, err);
    }
    ost_frame_free(&reference);
    ost_frame_free(&frame);
    return status;
}
