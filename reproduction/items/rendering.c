/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tables 3.7 and 3.8, Figures 3.13, 3.14 and 3.16, and section 3.3.3: comparison of triangle meshes of the visible
 * faces with GL_POINTs, from the measurements of bench/voxel_methods.h.
 *
 * The frames of a model are measured once per run, for all methods and numbers of chunks.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "reproduction/item.h"
#include "reproduction/stated.h"

enum { REPEAT_FRAMES = 5, REPEAT_FRAMES_QUICK = 1, REPEAT_MESH = 9, CUT_FRAMES = 40, CUT_FRAMES_QUICK = 4 };
/*
 * Upper limits for the number of chunks drawn. They limit the time of a measurement: with software OpenGL, a frame of
 * the thesis' points takes milliseconds per chunk.
 */
enum { CHUNKS_MOST = 512, CHUNKS_MOST_QUICK = 64 };

static const struct {
    ost_phantom_kind kind;
    const char *name;
} kinds[REPRODUCTION_MODELS] = {{OST_PHANTOM_FOAM, "Cellular foam"},
                                {OST_PHANTOM_TRABECULAR2, "Trabecular core 2"},
                                {OST_PHANTOM_TRABECULAR, "Trabecular core 1"},
                                {OST_PHANTOM_SCAPULA, "Scapula"},
                                {OST_PHANTOM_GLENOID, "Glenoid"}};
enum { FOAM = 0, SCAPULA = 3 };

static const char *const method_titles[BENCH_VOXEL_METHODS] = {"triangle mesh", "points of the thesis",
                                                               "points of osteon"};

static double mb(int64_t bytes)
{
    return 1e-6 * (double)bytes;
}

static void remark_opengl(result *out, const char *opengl, bool software)
{
    result_add_remark(out, "1280 x 720 pixels, each frame ended by glFinish. OpenGL: %.200s%s.", opengl,
                      software
                          ? ", executed by the processor, so that the work per pixel and per vertex weighs more than "
                            "on a graphics card"
                          : "");
}

/* --------------------------------------------------------------- Table 3.7 */

enum { MEMORY_METHOD, MEMORY_VOXEL, MEMORY_CHUNKS, MEMORY_ACTIVE, MEMORY_VOXELS, MEMORY_DRAWING, MEMORY_TOTAL };

static void add_memory(result *out, const char *method, const bench_voxel_grid *g, int64_t drawing,
                       const stated_rendering *stated)
{
    const ost_pm3 s = g->geometry.spacing;
    result_add_row(out);
    result_set_text(out, MEMORY_METHOD, "%s", method);
    result_set_text(out, MEMORY_VOXEL, "%.4g x %.4g x %.4g", ost_pm_to_mm(s.x), ost_pm_to_mm(s.y), ost_pm_to_mm(s.z));
    result_set(out, MEMORY_CHUNKS, (double)g->chunks);
    result_set(out, MEMORY_ACTIVE, (double)g->active_chunks);
    result_set(out, MEMORY_VOXELS, mb(g->voxel_bytes));
    result_set(out, MEMORY_DRAWING, mb(drawing));
    result_set(out, MEMORY_TOTAL, mb(g->voxel_bytes + drawing));
    if (!stated)
        return;
    result_set_thesis(out, MEMORY_CHUNKS, stated->chunks);
    result_set_thesis(out, MEMORY_ACTIVE, stated->active_chunks);
    result_set_thesis(out, MEMORY_VOXELS, stated->voxel_mb);
    result_set_thesis(out, MEMORY_DRAWING, stated->mesh_mb);
    result_set_thesis(out, MEMORY_TOTAL, stated->total_mb);
}

ost_status item_render_memory(reproduction *r, result *out, ost_error *err)
{
    bench_voxel_model *drawn = NULL;
    bench_voxel_counts counts;
    bench_options options = r->bench;
    options.quick = false; /* counting the complete model is fast enough even for --quick */
    result_add_column(out, "method", "method", "text");
    result_add_column(out, "voxel_mm", "voxel (mm)", "text");
    result_add_column(out, "chunks", "chunks", "");
    result_add_column(out, "active_chunks", "active chunks", "");
    result_add_column(out, "voxels_MB", "active voxels", "MB");
    result_add_column(out, "drawing_MB", "mesh or list", "MB");
    result_add_column(out, "total_MB", "total", "MB");
    reproduction_show(r, "memory of the scapula's pictures", 0);
    ost_status status = bench_voxel_open(&options, OST_PHANTOM_SCAPULA, 1, &drawn, err);
    if (status == OST_OK)
        status = bench_voxel_memory(drawn, &counts, err);
    if (status == OST_OK) {
        add_memory(out, "triangle mesh, voxels of the CT", &counts.rect, counts.rect.mesh_bytes, &stated_as_mesh);
        add_memory(out, "points of the thesis", &counts.cubic, 0, &stated_as_points);
        add_memory(out, "triangle mesh, cubic voxels", &counts.cubic, counts.cubic.mesh_bytes, NULL);
        add_memory(out, "points of osteon", &counts.cubic, counts.cubic.point_bytes, NULL);
        const double mesh = mb(counts.rect.voxel_bytes + counts.rect.mesh_bytes), points = mb(counts.cubic.voxel_bytes);
        const double ratio = points / mesh;
        result_add_finding(
            out, ratio < 1.1 ? RESULT_CONFIRMED : RESULT_CONTRADICTED, "section 3.3.2, Table 3.7",
            "Filler voxels for points take no more memory than the triangle mesh of the CT's voxels.",
            "%.2f MB for points and %.2f MB for voxels of the CT with their mesh (thesis: %.2f and %.2f MB).", points,
            mesh, stated_as_points.total_mb, stated_as_mesh.total_mb);
    }
    bench_voxel_close(drawn);
    result_add_remark(
        out, "The phantom of the scapula. A face of the mesh takes 16 bytes here. The thesis does not state the "
             "layout of its mesh.");
    return status;
}

/* --------------------------------------------------------------- Table 3.8 */

enum { STAGE_NAME, STAGE_ONE, STAGE_ONE_LEAST, STAGE_ALL, STAGE_ALL_LEAST };

ost_status item_mesh_stages(reproduction *r, result *out, ost_error *err)
{
    bench_voxel_model *drawn = NULL;
    bench_voxel_stages one, all;
    const char *backend = r->cl[0] ? r->cl : r->bench.backend;
    const int repeat = bench_repeat(&r->bench, REPEAT_MESH);
    result_add_column(out, "stage", "stage", "text");
    result_add_column(out, "chunk_us", "a chunk at a time, per chunk", "us");
    result_add_column(out, "chunk_min_us", "shortest", "us");
    result_add_column(out, "all_us", "all chunks in one call, per chunk", "us");
    result_add_column(out, "all_min_us", "shortest, all chunks", "us");
    reproduction_show(r, "meshing the scapula", 0);
    ost_status status = bench_voxel_open(&r->bench, OST_PHANTOM_SCAPULA, 1, &drawn, err);
    if (status == OST_OK)
        status = bench_voxel_mesh(drawn, backend, true, repeat, &one, err);
    if (status == OST_OK)
        status = bench_voxel_mesh(drawn, backend, false, repeat, &all, err);
    bench_voxel_close(drawn);
    if (status == OST_OK && one.reason[0])
        status = ost_fail(err, OST_ERR_UNAVAILABLE, "%s", one.reason);
    if (status != OST_OK)
        return status;
    for (int s = 0; s <= BENCH_VOXEL_STAGES; s++) {
        const bool total = s == BENCH_VOXEL_STAGES;
        const bench_figures *a = total ? &one.total : &one.stage[s], *b = total ? &all.total : &all.stage[s];
        result_add_row(out);
        result_set_text(out, STAGE_NAME, "%s", total ? "total" : bench_voxel_stage_name((bench_voxel_stage)s));
        result_set(out, STAGE_ONE, a->median);
        result_set(out, STAGE_ONE_LEAST, a->min);
        result_set_thesis(out, STAGE_ONE, 1e3 * stated_mesh_stages[s].ms);
        if (!all.reason[0]) {
            result_set(out, STAGE_ALL, b->median);
            result_set(out, STAGE_ALL_LEAST, b->min);
        }
    }
    result_add_remark(out,
                      "%d chunks of the scapula with %.0f faces each on average, by the backend %s%s%s. The stages are "
                      "those of the thesis' Table 3.8.",
                      one.chunks, one.faces_per_chunk, one.backend, *one.device ? " on " : "", one.device);
    result_plot *p =
        result_add_plot(out, RESULT_PLOT_BARS, "Generating the mesh of a chunk", "stage", "time per chunk (us)");
    p->x = STAGE_NAME;
    p->value[p->values++] = STAGE_ONE;
    p->value[p->values++] = STAGE_ALL;
    p->log_y = true;
    return OST_OK;
}

/* ------------------------------------------------- Figures 3.13, 3.14, 3.16 */

/* Measures the frames of a model for all methods, unless they have already been measured. */
static ost_status measure_frames(reproduction *r, int k, ost_error *err)
{
    int32_t counts[16];
    int count = 0;
    bench_voxel_model *drawn = NULL;
    if (r->frames_measured[k])
        return OST_OK;
    reproduction_show(r, kinds[k].name, 0);
    ost_status status = bench_voxel_open(&r->bench, kinds[k].kind, 1, &drawn, err);
    const int32_t chunks = status == OST_OK ? bench_voxel_chunks(drawn) : 0,
                  limit = r->bench.quick ? CHUNKS_MOST_QUICK : CHUNKS_MOST, most = chunks < limit ? chunks : limit;
    for (int32_t n = 1; n < most && count < 15; n *= 2)
        counts[count++] = n;
    if (most > 0)
        counts[count++] = most;
    for (int m = 0; m < BENCH_VOXEL_METHODS && status == OST_OK; m++) {
        reproduction_show(r, method_titles[m], (double)m / BENCH_VOXEL_METHODS);
        bench_voxel_frames_free(&r->frames[k][m]); /* frees the frames of an earlier measurement that failed */
        status = bench_voxel_idle(drawn, (bench_voxel_method)m, counts, count,
                                  r->bench.quick ? REPEAT_FRAMES_QUICK : REPEAT_FRAMES, &r->frames[k][m], err);
    }
    bench_voxel_close(drawn);
    r->frames_measured[k] = status == OST_OK;
    return status;
}

enum { FRAME_SERIES, FRAME_CHUNKS, FRAME_MS, FRAME_LEAST, FRAME_CHUNK_US, FRAME_VERTICES };

static void add_frame_columns(result *out)
{
    result_add_column(out, "model", "model", "text");
    result_add_column(out, "chunks", "chunks drawn", "");
    result_add_column(out, "frame_ms", "frame", "ms");
    result_add_column(out, "frame_min_ms", "shortest", "ms");
    result_add_column(out, "chunk_us", "per chunk", "us");
    result_add_column(out, "vertices", "vertices", "");
}

/* Adds the frames of one model and method. Returns OST_ERR_UNAVAILABLE with the reason if no frames were measured. */
static ost_status add_frames(result *out, const bench_voxel_frames *f, const char *series, ost_error *err)
{
    if (f->reason[0])
        return ost_fail(err, OST_ERR_UNAVAILABLE, "%s", f->reason);
    for (int32_t i = 0; i < f->count; i++) {
        result_add_row(out);
        result_set_text(out, FRAME_SERIES, "%s", series);
        result_set(out, FRAME_CHUNKS, f->frame[i].chunks);
        result_set(out, FRAME_MS, f->frame[i].ms.median);
        result_set(out, FRAME_LEAST, f->frame[i].ms.min);
        result_set(out, FRAME_CHUNK_US, 1e3 * f->frame[i].ms.median / f->frame[i].chunks);
        result_set(out, FRAME_VERTICES, (double)f->frame[i].vertices);
    }
    return OST_OK;
}

static void plot_frames(result *out, const char *title)
{
    result_plot *p = result_add_plot(out, RESULT_PLOT_LINES, title, "chunks drawn", "time of a frame (ms)");
    p->x = FRAME_CHUNKS;
    p->group = FRAME_SERIES;
    p->value[p->values++] = FRAME_MS;
    p->log_x = p->log_y = true;
}

/* Adds the frames of all models for one method. */
static ost_status all_models(reproduction *r, result *out, bench_voxel_method method, const char *title, ost_error *err)
{
    ost_status status = OST_OK;
    add_frame_columns(out);
    for (int k = 0; k < REPRODUCTION_MODELS && status == OST_OK; k++) {
        status = measure_frames(r, k, err);
        if (status == OST_OK)
            status = add_frames(out, &r->frames[k][method], kinds[k].name, err);
    }
    if (status != OST_OK)
        return status;
    remark_opengl(out, r->frames[FOAM][method].opengl, r->frames[FOAM][method].software);
    result_add_remark(out, "The plot of the thesis has no printed values. At most %d chunks are drawn%s.",
                      r->bench.quick ? CHUNKS_MOST_QUICK : CHUNKS_MOST,
                      r->bench.quick ? ", and the models have a quarter of their size (--quick)" : "");
    plot_frames(out, title);
    return OST_OK;
}

/*
 * Judges the times of idle frames. For each model, compares the mesh with the thesis' points at the greatest number of
 * chunks.
 */
static void judge_idle(const reproduction *r, result *out)
{
    double least = 0, most = 0;
    for (int k = 0; k < REPRODUCTION_MODELS; k++) {
        const bench_voxel_frames *mesh = &r->frames[k][BENCH_VOXEL_MESH], *points = &r->frames[k][BENCH_VOXEL_THESIS];
        if (mesh->count == 0 || points->count == 0)
            return;
        const double ratio = points->frame[points->count - 1].ms.min / mesh->frame[mesh->count - 1].ms.min;
        least = k == 0 || ratio < least ? ratio : least;
        most = k == 0 || ratio > most ? ratio : most;
    }
    result_add_finding(
        out,
        r->bench.quick ? RESULT_UNDECIDED
        : least > 1    ? RESULT_CONFIRMED
                       : RESULT_CONTRADICTED,
        "section 3.3.3", "Idle frames of triangle meshes are faster than those of points, up to 6 times.",
        "The thesis' points take %.1f to %.1f times as long as the mesh, depending on the model (shortest "
        "frames of the greatest number of chunks). The thesis' points pass every voxel of a chunk to the "
        "vertex shader, the mesh only the visible faces%s.",
        least, most, r->frames[FOAM][BENCH_VOXEL_MESH].software ? "; here the processor executes OpenGL" : "");
}

ost_status item_mesh_frames(reproduction *r, result *out, ost_error *err)
{
    return all_models(r, out, BENCH_VOXEL_MESH, "Frames of triangle meshes", err);
}

ost_status item_point_frames(reproduction *r, result *out, ost_error *err)
{
    ost_status status = all_models(r, out, BENCH_VOXEL_THESIS, "Frames of the thesis' points", err);
    if (status == OST_OK)
        judge_idle(r, out);
    return status;
}

ost_status item_foam_frames(reproduction *r, result *out, ost_error *err)
{
    ost_status status = measure_frames(r, FOAM, err);
    add_frame_columns(out);
    for (int m = 0; m < BENCH_VOXEL_METHODS && status == OST_OK; m++)
        status = add_frames(out, &r->frames[FOAM][m], method_titles[m], err);
    if (status != OST_OK)
        return status;
    remark_opengl(out, r->frames[FOAM][0].opengl, r->frames[FOAM][0].software);
    result_add_remark(
        out, "Cellular foam. The thesis plots its points on three computers; --merge adds the lines of further "
             "machines and devices to this plot. The triangle mesh and osteon's points are additions.");
    plot_frames(out, "Frames of the cellular foam");
    return OST_OK;
}

/* ------------------------------------------------------------ section 3.3.3 */

enum { CUT_METHOD, CUT_MS, CUT_LEAST, CUT_IDLE, CUT_CHANGED, CUT_MESHED, CUT_MESHING, CUT_COPYING, CUT_UPDATE };

static void judge_removal(const reproduction *r, result *out, const char *opengl)
{
    const result_cell *mesh = out->row[BENCH_VOXEL_MESH].cell, *points = out->row[BENCH_VOXEL_THESIS].cell,
                      *ours = out->row[BENCH_VOXEL_POINTS].cell;
    const bool faster = points[CUT_LEAST].value < mesh[CUT_LEAST].value;
    result_add_finding(
        out,
        r->bench.quick ? RESULT_UNDECIDED
        : faster       ? RESULT_CONFIRMED
                       : RESULT_CONTRADICTED,
        "section 3.3.3", "Frames of points are faster than those of meshes while bone is removed.",
        "Shortest frames during removal: %.1f ms with the mesh, %.1f ms with the thesis' points and %.1f ms "
        "with osteon's points. Meshing the %.1f changed chunks of a frame takes %.2f ms. OpenGL: %.100s.",
        mesh[CUT_LEAST].value, points[CUT_LEAST].value, ours[CUT_LEAST].value, mesh[CUT_MESHED].value,
        mesh[CUT_MESHING].value, opengl);
}

ost_status item_removal_frames(reproduction *r, result *out, ost_error *err)
{
    bench_voxel_model *drawn = NULL;
    bench_voxel_cut cut = {.frames = 0};
    result_add_column(out, "method", "method", "text");
    result_add_column(out, "frame_ms", "frame during removal", "ms");
    result_add_column(out, "frame_min_ms", "shortest", "ms");
    result_add_column(out, "idle_min_ms", "the same frames, idle, shortest", "ms");
    result_add_column(out, "changed_chunks", "changed chunks per frame", "");
    result_add_column(out, "meshed_chunks", "meshed chunks per frame", "");
    result_add_column(out, "meshing_ms", "meshing", "ms");
    result_add_column(out, "copying_ms", "copying meshes", "ms");
    result_add_column(out, "update_ms", "surface voxels", "ms");
    reproduction_show(r, "frames during removal", 0);
    ost_status status = bench_voxel_open(&r->bench, OST_PHANTOM_SCAPULA, 1, &drawn, err);
    for (int m = 0; m < BENCH_VOXEL_METHODS && status == OST_OK; m++) {
        status = bench_voxel_removal(drawn, (bench_voxel_method)m, r->cl[0] ? r->cl : r->bench.backend,
                                     r->bench.quick ? CUT_FRAMES_QUICK : CUT_FRAMES, &cut, err);
        if (status == OST_OK && cut.reason[0])
            status = ost_fail(err, OST_ERR_UNAVAILABLE, "%s", cut.reason);
        if (status != OST_OK)
            break;
        result_add_row(out);
        result_set_text(out, CUT_METHOD, "%s", method_titles[m]);
        result_set(out, CUT_MS, cut.ms.median);
        result_set(out, CUT_LEAST, cut.ms.min);
        result_set(out, CUT_IDLE, cut.idle_ms.min);
        result_set(out, CUT_CHANGED, cut.changed_chunks);
        result_set(out, CUT_MESHED, cut.meshed_chunks);
        result_set(out, CUT_MESHING, cut.mesh_ms);
        result_set(out, CUT_COPYING, cut.copy_ms);
        result_set(out, CUT_UPDATE, cut.update_ms);
    }
    bench_voxel_close(drawn);
    if (status != OST_OK)
        return status;
    if (!out->out_of_memory)
        judge_removal(r, out, cut.opengl);
    remark_opengl(out, cut.opengl, false);
    result_add_remark(out,
                      "A ball with the radius of the reamer moves into the scapula, a quarter of a voxel per frame.");
    result_plot *p = result_add_plot(out, RESULT_PLOT_BARS, "Frames during removal, and idle", "method",
                                     "shortest time of a frame (ms)");
    p->x = CUT_METHOD;
    p->value[p->values++] = CUT_LEAST;
    p->value[p->values++] = CUT_IDLE;
    return OST_OK;
}
