/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Measures the conversion of the scapula from a rect grid to a cubic grid and from there to chunks
 * (AR-CUB; thesis, Algs. 2.5 and 2.6, Table 2.2). The conversion begins with a rect grid on the backend
 * and ends with a bone and its counts. Every resampling rule has a row. The repetitions of all rows
 * alternate, so that the ratios of the rows show the cost of a rule independently of other load on the
 * machine.
 *
 * The baseline only moves bytes: it writes as many bytes as the bone's active chunks contain, and reads the rect grid.
 * If the rect grid has fewer bytes than are written, the baseline reads it repeatedly. The baseline's buffers were
 * written before the measurement, whereas osteon allocates its results within the measured time.
 */
#include "bench/baseline.h"
#include "bench/bench.h"

#include <osteon/phantom.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { REPEAT = 31, CHUNK = 32, THRESHOLD = 120 };

typedef struct variant {
    const char *name;
    ost_resample rule;
    /* spacing of the cubic grid; 0 selects the x spacing of the rect grid, so that only z is resampled */
    ost_pm cubic;
    bool wanted, equal;
    bench_series both, to_cubic, to_chunks, floor[BENCH_COPY_COUNT];
    ost_bone_info info;
} variant;

enum { VARIANTS = 4 };

typedef struct transfer {
    const bench_options *options;
    ost_error *err;
    ost_volume ct;
    ost_backend *backend;
    ost_grid *rect;
    variant variants[VARIANTS];
    uint8_t *in, *out; /* buffers of the baseline */
    size_t in_bytes;
} transfer;

static ost_status make_ct(transfer *t)
{
    const ost_phantom_options options = {.scale = t->options->quick ? 0.2 : 1};
    return ost_phantom_make(OST_PHANTOM_SCAPULA, &options, &t->ct, t->err);
}

static ost_status make_rect(transfer *t, ost_backend *backend, ost_grid **out)
{
    ost_status status = ost_grid_create(backend, &t->ct.geometry, out, t->err);
    return status == OST_OK ? ost_grid_upload(*out, 0, t->ct.geometry.dims.z, t->ct.voxels, t->err) : status;
}

/* Converts the grid with the two public calls that a program also uses. The results are freed after the time is
   measured. */
static ost_status convert(transfer *t, variant *v, const ost_grid *rect, bool timed, ost_bone **bone)
{
    ost_grid *cubic = NULL;
    int64_t begin = bench_now(), middle = begin;
    ost_status status =
        ost_rect_to_cubic(rect, v->cubic ? v->cubic : t->ct.geometry.spacing.x, v->rule, &cubic, t->err);
    middle = bench_now();
    if (status == OST_OK)
        status = ost_cubic_to_chunks(cubic, CHUNK, THRESHOLD, bone, t->err);
    int64_t end = bench_now();
    if (timed) {
        bench_series_add(&v->both, (double)(end - begin));
        bench_series_add(&v->to_cubic, (double)(middle - begin));
        bench_series_add(&v->to_chunks, (double)(end - middle));
    }
    ost_grid_free(cubic);
    return status;
}

static ost_status compare(transfer *t, variant *v, const ost_bone *a, const ost_bone *b)
{
    ost_bone_info ia, ib;
    ost_status status = ost_bone_info_get(a, &ia, t->err);
    if (status == OST_OK)
        status = ost_bone_info_get(b, &ib, t->err);
    if (status != OST_OK)
        return status;
    const ost_dims d = ia.geometry.dims;
    const size_t bytes = (size_t)ost_dims_count(d) * sizeof(int16_t);
    v->equal = ost_geometry_equal(&ia.geometry, &ib.geometry) && ia.active_chunks == ib.active_chunks &&
               ia.active_voxels == ib.active_voxels && ia.chunk_bytes == ib.chunk_bytes;
    if (!v->equal)
        return OST_OK;
    int16_t *va = malloc(bytes), *vb = malloc(bytes);
    status = va && vb ? ost_bone_download(a, 0, d.z, va, t->err)
                      : ost_fail(t->err, OST_ERR_MEMORY, "out of memory for the comparison of bones");
    if (status == OST_OK)
        status = ost_bone_download(b, 0, d.z, vb, t->err);
    if (status == OST_OK)
        v->equal = memcmp(va, vb, bytes) == 0;
    free(va);
    free(vb);
    return status;
}

static ost_status verify(transfer *t, const ost_grid *reference, variant *v)
{
    ost_bone *expected = NULL, *bone = NULL;
    ost_status status = convert(t, v, reference, false, &expected);
    if (status == OST_OK)
        status = convert(t, v, t->rect, false, &bone);
    if (status == OST_OK)
        status = ost_bone_info_get(bone, &v->info, t->err);
    if (status == OST_OK)
        status = compare(t, v, expected, bone);
    ost_bone_free(bone);
    ost_bone_free(expected);
    return status;
}

static ost_status verify_all(transfer *t)
{
    ost_backend *ref = NULL;
    ost_grid *rect = NULL;
    ost_status status = ost_backend_open("ref", &ref, t->err);
    if (status == OST_OK)
        status = make_rect(t, ref, &rect);
    for (int i = 0; i < VARIANTS && status == OST_OK; i++)
        if (t->variants[i].wanted)
            status = verify(t, rect, &t->variants[i]);
    ost_grid_free(rect);
    ost_backend_close(ref);
    return status;
}

static ost_status make_floor(transfer *t)
{
    size_t out_bytes = 64;
    for (int i = 0; i < VARIANTS; i++)
        if ((size_t)t->variants[i].info.chunk_bytes > out_bytes)
            out_bytes = (size_t)t->variants[i].info.chunk_bytes;
    t->in_bytes = (size_t)ost_dims_count(t->ct.geometry.dims) * sizeof(int16_t);
    t->in = aligned_alloc(64, (t->in_bytes + 63) / 64 * 64);
    t->out = aligned_alloc(64, (out_bytes + 63) / 64 * 64);
    if (!t->in || !t->out)
        return ost_fail(t->err, OST_ERR_MEMORY, "out of memory for a copy of %zu bytes", out_bytes);
    memcpy(t->in, t->ct.voxels, t->in_bytes);
    memset(t->out, 1, out_bytes);
    return OST_OK;
}

static ost_status repeat_once(transfer *t, variant *v, bool timed, bool baseline)
{
    ost_bone *bone = NULL;
    ost_status status = convert(t, v, t->rect, timed, &bone);
    ost_bone_free(bone);
    for (int how = 0; how < BENCH_COPY_COUNT && baseline; how++) {
        int64_t begin = bench_now();
        bench_copy_bytes((bench_copy)how, t->out, (size_t)v->info.chunk_bytes, t->in, t->in_bytes, t->options->threads);
        int64_t end = bench_now();
        if (timed)
            bench_series_add(&v->floor[how], (double)(end - begin));
    }
    return status;
}

static ost_status repeat(transfer *t, bool baseline)
{
    ost_status status = OST_OK;
    const int count = bench_repeat(t->options, REPEAT);
    for (int i = -1; i < count && status == OST_OK; i++)
        for (int k = 0; k < VARIANTS && status == OST_OK; k++)
            if (t->variants[k].wanted && t->variants[k].equal)
                status = repeat_once(t, &t->variants[k], i >= 0, baseline);
    return status;
}

static void fill_row(const transfer *t, variant *v, bench_row *row)
{
    row->equal = v->equal;
    if (!v->equal)
        return;
    const bool stream =
        bench_series_at(&v->floor[BENCH_COPY_STREAM], 0.5) < bench_series_at(&v->floor[BENCH_COPY_MEMCPY], 0.5);
    bench_row_ours(row, &v->both);
    bench_row_baseline(row, &v->floor[stream ? BENCH_COPY_STREAM : BENCH_COPY_MEMCPY],
                       stream ? "copying the same bytes around the caches" : "copying the same bytes by memcpy");
    bench_row_extra(row, "rect_to_cubic_ms", bench_series_at(&v->to_cubic, 0.5) / 1e6);
    bench_row_extra(row, "cubic_to_chunks_ms", bench_series_at(&v->to_chunks, 0.5) / 1e6);
    bench_row_extra(row, "rect_bytes", (double)t->in_bytes);
    bench_row_extra(row, "chunk_bytes", (double)v->info.chunk_bytes);
    bench_row_extra(row, "active_chunks", (double)v->info.active_chunks);
    bench_row_extra(row, "active_voxels", (double)v->info.active_voxels);
    bench_row_extra(row, "memcpy_ms", bench_series_at(&v->floor[BENCH_COPY_MEMCPY], 0.5) / 1e6);
    bench_row_extra(row, "streaming_copy_ms", bench_series_at(&v->floor[BENCH_COPY_STREAM], 0.5) / 1e6);
}

static ost_status add_rows(transfer *t, bench_table *table, const char *reason)
{
    for (int i = 0; i < VARIANTS; i++) {
        variant *v = &t->variants[i];
        bench_row *row = v->wanted ? bench_row_add(table, v->name, "ms", t->options->threads) : NULL;
        if (v->wanted && !row)
            return ost_fail(t->err, OST_ERR_MEMORY, "out of memory for a row");
        if (row) {
            fill_row(t, v, row);
            snprintf(row->baseline_reason, sizeof row->baseline_reason, "%s", reason);
        }
    }
    return OST_OK;
}

ost_status bench_transfer(const bench_options *options, bench_table *table, ost_error *err)
{
    transfer t = {
        .options = options,
        .err = err,
        .variants =
            {
                {.name = "transfer/scapula", .rule = OST_RESAMPLE_LINEAR},
                {.name = "transfer/scapula/nearest", .rule = OST_RESAMPLE_NEAREST},
                {.name = "transfer/scapula/thesis", .rule = OST_RESAMPLE_THESIS},
                {.name = "transfer/scapula/0.6", .rule = OST_RESAMPLE_LINEAR, .cubic = OST_PM_PER_MM * 6 / 10},
            },
    };
    char reason[BENCH_TEXT];
    bool any = false;
    for (int i = 0; i < VARIANTS; i++)
        any = (t.variants[i].wanted = bench_wanted(options, t.variants[i].name)) || any;
    if (!any)
        return OST_OK;
    const bool baseline = bench_baseline_runs(reason, sizeof reason);
    ost_status status = make_ct(&t);
    if (status == OST_OK)
        status = bench_backend(options, options->threads, &t.backend, err);
    if (status == OST_OK)
        status = make_rect(&t, t.backend, &t.rect);
    if (status == OST_OK)
        status = verify_all(&t);
    if (status == OST_OK)
        status = make_floor(&t);
    if (status == OST_OK)
        status = repeat(&t, baseline);
    if (status == OST_OK)
        status = add_rows(&t, table, reason);
    for (int i = 0; i < VARIANTS; i++) {
        variant *v = &t.variants[i];
        bench_series_free(&v->both);
        bench_series_free(&v->to_cubic);
        bench_series_free(&v->to_chunks);
        for (int how = 0; how < BENCH_COPY_COUNT; how++)
            bench_series_free(&v->floor[how]);
    }
    free(t.in);
    free(t.out);
    ost_grid_free(t.rect);
    ost_backend_close(t.backend);
    ost_volume_free(&t.ct);
    const char *names[VARIANTS];
    for (int i = 0; i < VARIANTS; i++)
        names[i] = t.variants[i].name;
    return bench_row_not_run(options, table, names, VARIANTS, "ms", options->threads, status, err);
}
