/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Table 2.2: the time of each phase of an import, from the text of a CT to the chunk grid.
 *
 *   model --ost_volume_write--> text in TMPDIR --ost_import--> samples, rect, cubic, chunks
 *                                      '--fscanf (baseline, at most LINES lines)
 *
 * As in the thesis' files, the text has one line for each voxel whose density is not 0. The file is in the page cache.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <osteon/io.h>

#include "bench/baseline.h"
#include "core/file.h"
#include "reproduction/item.h"
#include "reproduction/stated.h"
#include "reproduction/write.h"

enum { MODEL_COLUMN, LINES_COLUMN, TEXT_MB, READ, RECT, CUBIC, CHUNKS, TOTAL, LINE, FSCANF };
enum { REPEAT = 3, LINES = 1000000, SCANS = 2, LINE_BYTES = 40, QUICK_SLICES = 40 };

/*
 * Copies the model and sets the densities below the threshold to 0. With --quick, copies only the slices in the middle.
 */
static ost_status active_part(const reproduction *r, const model *m, ost_volume *out, int64_t *lines, ost_error *err)
{
    ost_geometry g = m->rect.geometry;
    const int32_t all = g.dims.z;
    const int64_t slice = (int64_t)g.dims.x * g.dims.y;
    if (r->bench.quick && all > QUICK_SLICES)
        g.dims.z = QUICK_SLICES;
    const int16_t *from = m->rect.voxels + slice * ((all - g.dims.z) / 2);
    ost_status status = ost_volume_init(out, &g, err);
    *lines = 0;
    for (int64_t i = 0; i < ost_dims_count(g.dims) && status == OST_OK; i++) {
        out->voxels[i] = from[i] >= MODEL_THRESHOLD ? from[i] : 0;
        *lines += out->voxels[i] != 0;
    }
    return status;
}

/* Returns an error if the folder has too little free space for the text. */
static ost_status check_space(const char *folder, double bytes, ost_error *err)
{
    struct statvfs space;
    if (statvfs(folder, &space) != 0)
        return ost_fail(err, OST_ERR_IO, "%.200s: cannot be used for the text of a CT (TMPDIR)", folder);
    const double there = (double)space.f_bavail * (double)space.f_frsize;
    if (there < bytes)
        return ost_fail(err, OST_ERR_IO, "%.200s: the text takes %.1f GB, but %.1f GB are free (TMPDIR)", folder,
                        bytes * 1e-9, there * 1e-9);
    return OST_OK;
}

typedef struct phases {
    bench_series samples, rect, cubic, chunks, total;
} phases;

static void add_stages(phases *p, const ost_import_result *imported)
{
    double total = 0;
    for (int i = 0; i < imported->stage_count; i++) {
        const ost_stage *s = &imported->stages[i];
        bench_series *to = strcmp(s->name, "samples") == 0 ? &p->samples
                           : strcmp(s->name, "rect") == 0  ? &p->rect
                           : strcmp(s->name, "cubic") == 0 ? &p->cubic
                                                           : &p->chunks;
        bench_series_add(to, s->time_ms);
        total += s->time_ms;
    }
    bench_series_add(&p->total, total);
}

static ost_status import_text(reproduction *r, const char *path, ost_pm3 spacing, phases *p, ost_error *err)
{
    ost_backend *backend = NULL;
    const ost_import_options options = {.spacing = spacing, .threads = r->bench.threads};
    ost_status status = bench_backend(&r->bench, r->bench.threads, &backend, err);
    for (int i = 0; i < bench_repeat(&r->bench, REPEAT) && status == OST_OK; i++) {
        ost_bone *bone = NULL;
        ost_import_result imported;
        status = ost_import(backend, path, &options, &bone, &imported, err);
        if (status == OST_OK)
            add_stages(p, &imported);
        ost_bone_free(bone);
    }
    ost_backend_close(backend);
    return status;
}

/*
 * Reads the first lines of the text with fscanf. Returns the shortest measured time per line in nanoseconds, or 0 if
 * the baseline cannot run.
 */
static double scan_text(const char *path, int64_t lines)
{
    char reason[BENCH_TEXT];
    const size_t capacity = (size_t)(lines < LINES ? lines : LINES);
    float *positions = malloc((3 * capacity + 1) * sizeof *positions);
    int16_t *densities = malloc((capacity + 1) * sizeof *densities);
    bench_series series = {.ns = NULL};
    for (int i = 0; i < SCANS && positions && densities && bench_baseline_runs(reason, sizeof reason); i++) {
        const int64_t begin = bench_now();
        const size_t count = bench_fscanf_lines(path, positions, densities, capacity);
        if (count)
            bench_series_add(&series, (double)(bench_now() - begin) / (double)count);
    }
    const double least = bench_series_at(&series, 0);
    bench_series_free(&series);
    free(positions);
    free(densities);
    return least;
}

static void add_row(const reproduction *r, result *out, model_id id, const char *name, double bytes, int64_t lines,
                    phases *p, double scan)
{
    const stated_model *s = &stated_models[id];
    const double samples = bench_series_at(&p->samples, 0.5), rect = bench_series_at(&p->rect, 0.5);
    result_add_row(out);
    result_set_text(out, MODEL_COLUMN, "%s", name);
    result_set(out, LINES_COLUMN, (double)lines);
    result_set(out, TEXT_MB, bytes * 1e-6);
    result_set(out, READ, samples);
    result_set(out, RECT, rect);
    result_set(out, CUBIC, bench_series_at(&p->cubic, 0.5));
    result_set(out, CHUNKS, bench_series_at(&p->chunks, 0.5));
    result_set(out, TOTAL, bench_series_at(&p->total, 0.5));
    if (lines > 0)
        result_set(out, LINE, 1e6 * (samples + rect) / (double)lines);
    if (scan > 0)
        result_set(out, FSCANF, scan);
    if (r->bench.quick || model_is_own(&r->models, id))
        return; /* the thesis reports values only for complete models */
    result_set_thesis(out, TEXT_MB, s->text_mb);
    result_set_thesis(out, READ, s->read_ms);
    result_set_thesis(out, RECT, s->rect_ms);
    result_set_thesis(out, CUBIC, s->cubic_ms);
    result_set_thesis(out, CHUNKS, s->chunks_ms);
    result_set_thesis(out, TOTAL, s->read_ms + s->rect_ms + s->cubic_ms + s->chunks_ms);
}

static ost_status measure(reproduction *r, result *out, model_id id, const char *folder, ost_error *err)
{
    const ost_write_options how = {.omit_empty = true};
    char path[WRITE_PATH], name[WRITE_NAME];
    ost_file text = {.fd = -1};
    ost_volume part = {.voxels = NULL};
    phases p = {.total = {.ns = NULL}};
    const model *m;
    int64_t lines = 0;
    snprintf(name, sizeof name, "osteon-reproduce-%ld-%s.txt", (long)getpid(), model_words[id]);
    ost_status status = write_path(path, folder, name, err);
    if (status == OST_OK)
        status = model_get(&r->models, id, &m, err);
    if (status == OST_OK)
        status = active_part(r, m, &part, &lines, err);
    if (status == OST_OK)
        status = check_space(folder, (double)lines * LINE_BYTES, err);
    if (status == OST_OK)
        status = ost_volume_write(path, &part, &how, err);
    if (status == OST_OK)
        status = ost_file_open(path, &text, err);
    unlink(path); /* unlinked while open, so that no file remains if the run is interrupted */
    snprintf(path, sizeof path, "/proc/self/fd/%d", text.fd);
    if (status == OST_OK)
        status = import_text(r, path, part.geometry.spacing, &p, err);
    if (status == OST_OK)
        add_row(r, out, id, m->name, (double)text.size, lines, &p, scan_text(path, lines));
    if (text.fd >= 0)
        close(text.fd);
    ost_volume_free(&part);
    bench_series *const all[] = {&p.samples, &p.rect, &p.cubic, &p.chunks, &p.total};
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++)
        bench_series_free(all[i]);
    return status;
}

ost_status item_import(reproduction *r, result *out, ost_error *err)
{
    const char *given = getenv("TMPDIR"), *folder = given && *given ? given : "/tmp";
    ost_status status = OST_OK;
    result_add_column(out, "model", "model", "text");
    result_add_column(out, "lines", "lines of text", "");
    result_add_column(out, "text_MB", "text", "MB");
    result_add_column(out, "read_ms", "reading the text", "ms");
    result_add_column(out, "rect_ms", "to the rect grid", "ms");
    result_add_column(out, "cubic_ms", "to the cubic grid", "ms");
    result_add_column(out, "chunks_ms", "to the chunks", "ms");
    result_add_column(out, "total_ms", "total", "ms");
    result_add_column(out, "line_ns", "reading and rect grid, per line", "ns");
    result_add_column(out, "fscanf_line_ns", "fscanf, per line", "ns");
    for (int id = 0; id < MODELS && status == OST_OK; id++) {
        ost_error why = {.status = OST_OK};
        reproduction_show(r, stated_models[id].name, (double)id / MODELS);
        status = measure(r, out, (model_id)id, folder, &why);
        if (status == OST_ERR_IO || status == OST_ERR_MEMORY) {
            /* A model is skipped, with the reason as a remark, if there is not enough space for its text. */
            result_add_remark(out, "%s was not measured: %.300s.", stated_models[id].name, why.text);
            status = OST_OK;
        } else if (status != OST_OK) {
            *err = why;
        }
    }
    if (status == OST_OK && out->row_count == 0)
        return ost_fail(err, OST_ERR_UNAVAILABLE, "%s: no model could be measured", folder);
    result_add_remark(
        out, "In osteon, the first phase determines the lattice of the positions and the second parses the densities; "
             "only their sum can be compared with the sum of the thesis' first two phases. The cubic grid is not "
             "stored: the chunks are computed directly from the rect grid, so that the work of both phases is in the "
             "last one. With the backend cpu, nothing is uploaded to a device.");
    result_add_remark(out, "The texts of the thesis are larger or smaller than ours because the phantoms have other "
                           "active voxels and because some of its files list empty voxels, too. The time per line does "
                           "not depend on this.");
    if (r->bench.quick)
        result_add_remark(out, "--quick: only the %d middle slices of each model.", QUICK_SLICES);
    result_plot *p =
        result_add_plot(out, RESULT_PLOT_BARS, "From the text of a CT to the chunk grid", "model", "total time (ms)");
    p->x = MODEL_COLUMN;
    p->value[p->values++] = TOTAL;
    p->log_y = true;
    return status;
}
