/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Measures the frames that OpenGL draws by the two voxel rendering methods (voxel_methods.h), while nothing changes and
 * while bone is removed. The camera looks along +y, slightly from the side and from above, and sees the complete model.
 * To remove bone, a ball moves along +y into the surface that the camera sees.
 */
#include "bench/voxel_model.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/inputs.h"
#include "render/gl/gl.h"
#include "render/points/extract.h"

#ifdef __GLIBC__
#include <malloc.h>
#endif

enum { WIDTH = 1280, HEIGHT = 720, MS = 1000000 };
/* depth of the ball in the first measured frame, and distance that the ball moves per frame, both in voxels */
static const double FIRST_DEPTH = 3, STEP = 0.25;

typedef struct canvas {
    ost_gl *gl;
    ost_backend *mesher;
    ost_gl_variant variant;
    ost_frame_thing thing;
} canvas;

static void keep_memory(void)
{
#ifdef __GLIBC__
    /* Software drivers free the memory of every frame and allocate it again. These settings keep freed memory in the
       process, so that the system need not clear the pages for each frame. */
    mallopt(M_TRIM_THRESHOLD, 1 << 30);
    mallopt(M_TOP_PAD, 1 << 26);
    mallopt(M_MMAP_THRESHOLD, 1 << 30);
#endif
}

static ost_status camera_of(const ost_geometry *g, ost_camera *camera, ost_error *err)
{
    static const double direction[3] = {0.3, -1, 0.35}, up[3] = {0, 0, 1};
    const double mm = 1e-9 * (double)g->spacing.x;
    const double size[3] = {mm * g->dims.x, mm * g->dims.y, mm * g->dims.z};
    const double diagonal = sqrt(size[0] * size[0] + size[1] * size[1] + size[2] * size[2]);
    const double length = sqrt(direction[0] * direction[0] + direction[1] * direction[1] + direction[2] * direction[2]);
    const double middle[3] = {1e-9 * (double)g->origin.x + size[0] / 2, 1e-9 * (double)g->origin.y + size[1] / 2,
                              1e-9 * (double)g->origin.z + size[2] / 2};
    double from[3];
    /* at this distance, a ball around the grid fits into the vertical field of view of 45 degrees */
    for (int a = 0; a < 3; a++)
        from[a] = middle[a] + 1.31 * diagonal * direction[a] / length;
    *camera = (ost_camera){.focal_milli = 869117, .width = WIDTH, .height = HEIGHT};
    return ost_camera_look_at(from, middle, up, camera, err);
}

static void copy_reason(char to[BENCH_TEXT], const ost_error *why)
{
    snprintf(to, BENCH_TEXT, "%.*s", BENCH_TEXT - 1, why->text);
}

/* Opens OpenGL and the mesher. Returns OST_ERR_UNAVAILABLE if one of them cannot be opened. */
static ost_status open_canvas(canvas *c, const bench_voxel_model *m, bench_voxel_method method, const char *mesher,
                              char opengl[BENCH_TEXT], bool *software, ost_error *err)
{
    static const ost_gl_variant *const variants[BENCH_VOXEL_METHODS] = {&ost_gl_mesh, &ost_gl_thesis, &ost_gl_ours};
    ost_camera camera;
    *c = (canvas){.variant = *variants[method]};
    keep_memory();
    ost_status status = camera_of(&m->cubic.geometry, &camera, err);
    if (status == OST_OK)
        status = ost_gl_open(NULL, &c->gl, err);
    if (status == OST_OK && method == BENCH_VOXEL_MESH)
        status = ost_backend_open(mesher, &c->mesher, err);
    if (status != OST_OK)
        return status;
    ost_gl_set_mesher(c->gl, c->mesher);
    const ost_gl_info info = ost_gl_info_get(c->gl);
    snprintf(opengl, BENCH_TEXT, "OpenGL %.80s, %.120s", info.version, info.driver);
    *software = info.software;
    c->thing = (ost_frame_thing){
        .surface = &m->surface, .eye = ost_eye_make(&camera, &m->cubic.geometry), .paint = OST_PAINT_BONE};
    return OST_OK;
}

static void close_canvas(canvas *c)
{
    ost_gl_close(c->gl);
    ost_backend_close(c->mesher);
}

static ost_status draw(canvas *c, ost_error *err)
{
    ost_status status = ost_gl_draw(c->gl, &c->variant, &c->thing, 1, OST_STYLE_FACES, err);
    return status == OST_OK ? ost_gl_finish(c->gl, err) : status;
}

/* --------------------------------------------------------------------- idle */

void bench_voxel_frames_free(bench_voxel_frames *frames)
{
    free(frames->frame);
    frames->frame = NULL;
    frames->count = 0;
}

static ost_status measure_idle(canvas *c, int repeat, bench_voxel_frame *out, ost_error *err)
{
    bench_series series = {0};
    c->variant.slots = out->chunks;
    ost_status status = draw(c, err); /* uploads the model and compiles the shaders */
    if (status == OST_OK)
        status = draw(c, err); /* the second frame omits everything that was hidden in the first frame */
    for (int i = 0; i < repeat && status == OST_OK; i++) {
        const int64_t begin = bench_now();
        status = draw(c, err);
        bench_series_add(&series, (double)(bench_now() - begin));
    }
    out->vertices = ost_gl_counts_get(c->gl).points;
    out->ms = bench_voxel_figures(&series, MS);
    return status;
}

ost_status bench_voxel_idle(const bench_voxel_model *model, bench_voxel_method method, const int32_t *counts, int count,
                            int repeat, bench_voxel_frames *out, ost_error *err)
{
    ost_error why = {0};
    canvas c;
    *out = (bench_voxel_frames){.count = 0};
    for (int i = 0; i < count; i++)
        if (counts[i] < 1 || counts[i] > model->surface.used)
            return ost_fail(err, OST_ERR_USAGE, "%d chunks to draw; expected 1 to %d", (int)counts[i],
                            (int)model->surface.used);
    if (repeat < 1)
        return ost_fail(err, OST_ERR_USAGE, "%d frames; expected at least 1", repeat);
    out->frame = calloc((size_t)count + 1, sizeof *out->frame);
    if (!out->frame)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %d measurements", count);
    ost_status status = open_canvas(&c, model, method, "cpu", out->opengl, &out->software, &why);
    for (int i = 0; i < count && status == OST_OK; i++) {
        out->frame[i].chunks = counts[i];
        status = measure_idle(&c, repeat, &out->frame[i], &why);
        out->count = status == OST_OK ? i + 1 : 0;
    }
    close_canvas(&c);
    if (status == OST_ERR_UNAVAILABLE) {
        copy_reason(out->reason, &why);
        return OST_OK;
    }
    if (status != OST_OK)
        bench_voxel_frames_free(out);
    return status == OST_OK ? OST_OK : ost_fail(err, status, "%s", why.text);
}

/* ------------------------------------------------------------------ removal */

static bool is_active(const ost_volume *v, int x, int y, int z)
{
    const ost_dims d = v->geometry.dims;
    return v->voxels[x + (size_t)d.x * ((size_t)y + (size_t)d.y * (size_t)z)] >= BENCH_VOXEL_THRESHOLD;
}

/*
 * Finds the column along y that contains an active voxel and is closest to the grid's middle. Stores the position of
 * this column's first active voxel in `at`.
 */
static bool find_surface(const ost_volume *v, double at[3])
{
    const ost_dims d = v->geometry.dims;
    double best = HUGE_VAL;
    for (int z = 0; z < d.z; z++)
        for (int x = 0; x < d.x; x++) {
            const double dx = x - 0.5 * d.x, dz = z - 0.5 * d.z, away = dx * dx + dz * dz;
            for (int y = 0; y < d.y && away < best; y++)
                if (is_active(v, x, y, z)) {
                    best = away;
                    at[0] = x;
                    at[1] = y;
                    at[2] = z;
                }
        }
    return best < HUGE_VAL;
}

typedef struct cut_sums {
    bench_series busy, idle;
    double changed, meshed, mesh, copy, update, uploaded;
} cut_sums;

static ost_status measure_cut(canvas *c, bench_voxel_model *m, const double surface[3], int frames, cut_sums *sums,
                              ost_error *err)
{
    ost_surface *s = &m->surface;
    ost_status status = OST_OK;
    /* the first two frames are not measured, because they include uploading and compiling */
    for (int i = -2; i < frames && status == OST_OK; i++) {
        const double at[3] = {surface[0], surface[1] - m->radius + FIRST_DEPTH + STEP * i, surface[2]};
        int32_t changed = 0;
        status = bench_carve(s, at, m->radius, &changed, err);
        const int64_t begin = bench_now();
        if (status == OST_OK)
            status = ost_surface_update(s, err);
        const int64_t updated = bench_now();
        if (status == OST_OK)
            status = draw(c, err);
        const int64_t drawn = bench_now();
        const ost_gl_counts did = ost_gl_counts_get(c->gl);
        if (status == OST_OK)
            status = draw(c, err);
        const int64_t again = bench_now();
        if (i < 0)
            continue;
        bench_series_add(&sums->busy, (double)(drawn - begin));
        bench_series_add(&sums->idle, (double)(again - drawn));
        sums->changed += changed;
        sums->meshed += did.meshed;
        sums->mesh += (double)did.mesh_ns;
        sums->copy += (double)did.copy_ns;
        sums->update += (double)(updated - begin);
        sums->uploaded += (double)did.uploaded;
    }
    return status;
}

ost_status bench_voxel_removal(bench_voxel_model *model, bench_voxel_method method, const char *mesher, int frames,
                               bench_voxel_cut *out, ost_error *err)
{
    ost_error why = {0};
    canvas c;
    bool software;
    double surface[3] = {0};
    cut_sums sums = {.changed = 0};
    *out = (bench_voxel_cut){.frames = frames};
    if (frames < 1)
        return ost_fail(err, OST_ERR_USAGE, "%d frames; expected at least 1", frames);
    if (!find_surface(&model->cubic, surface))
        return ost_fail(err, OST_ERR_USAGE, "the model has no active voxel");
    ost_status status = open_canvas(&c, model, method, mesher, out->opengl, &software, &why);
    if (status == OST_OK)
        status = measure_cut(&c, model, surface, frames, &sums, &why);
    close_canvas(&c);
    out->ms = bench_voxel_figures(&sums.busy, MS);
    out->idle_ms = bench_voxel_figures(&sums.idle, MS);
    out->changed_chunks = sums.changed / frames;
    out->meshed_chunks = sums.meshed / frames;
    out->mesh_ms = sums.mesh / frames / MS;
    out->copy_ms = sums.copy / frames / MS;
    out->update_ms = sums.update / frames / MS;
    out->uploaded = (uint64_t)(sums.uploaded / frames);
    ost_status restored = ost_surface_set_volume(&model->surface, &model->cubic, BENCH_VOXEL_THRESHOLD, err);
    if (restored == OST_OK)
        restored = ost_surface_update(&model->surface, err);
    if (restored != OST_OK)
        return restored;
    if (status == OST_ERR_UNAVAILABLE) {
        *out = (bench_voxel_cut){.frames = frames};
        copy_reason(out->reason, &why);
        return OST_OK;
    }
    return status == OST_OK ? OST_OK : ost_fail(err, status, "%s", why.text);
}
