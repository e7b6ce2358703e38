/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Measures how a CT in text form is read into a rect grid (thesis, Algs. 2.2 to 2.4, Table 2.2). The
 * text is the scapula: 256 x 234 x 201 lines of "x y z density" with six decimals, 424 MB. The option
 * --scale selects a fraction of its slices.
 *
 *   parse/text        the baseline is fscanf on one thread
 *   parse/text/floor  the baseline reads every byte of the mapped file, with as many
 *                     threads as osteon uses
 *
 * osteon's time covers an import up to the rect grid: opening the file, finding the spacing, converting every number
 * exactly, checking every line, and scattering the samples. The file is in the page cache. It has no name while it is
 * used, so the system deletes it when the program ends for any reason.
 */
#include "bench/baseline.h"
#include "bench/bench.h"

#include <osteon/io.h>

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

enum { NX = 256, NY = 234, NZ = 201, REPEAT = 9, REPEAT_FSCANF = 3, LINE = 64 };

typedef struct parse {
    const bench_options *options;
    ost_error *err;
    int fd;
    char path[64]; /* the file's path in /proc/self/fd, because the file has no other name */
    size_t bytes, lines;
    bench_series ours, fscanf, floor;
    bool equal;
} parse;

/* --------------------------------------------------------------- the file */

/* Writes a length in mm and a blank, such as "-57.340000 ". The six decimal places represent every length
   in nanometres exactly. */
static char *put_mm(char *at, int64_t nm)
{
    if (nm < 0) {
        *at++ = '-';
        nm = -nm;
    }
    at += sprintf(at, "%d", (int)(nm / 1000000));
    *at++ = '.';
    for (int64_t digit = 100000, remainder = nm % 1000000; digit; digit /= 10)
        *at++ = (char)('0' + remainder / digit % 10);
    *at++ = ' ';
    return at;
}

static ost_status write_all(parse *p, const char *text, size_t bytes)
{
    while (bytes) {
        ssize_t n = write(p->fd, text, bytes);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return ost_fail(p->err, OST_ERR_IO, "the text of parse/text: %s; TMPDIR needs %zu MB", strerror(errno),
                            (size_t)NX * NY * 36 / 1000000 * NZ);
        text += n;
        bytes -= (size_t)n;
        p->bytes += (size_t)n;
    }
    return OST_OK;
}

/* Writes the file, the lines of one slice at a time. */
static ost_status write_text(parse *p, int layers)
{
    char x[NX][LINE], *layer = malloc((size_t)NX * NY * LINE);
    ost_status status = layer ? OST_OK : ost_fail(p->err, OST_ERR_MEMORY, "out of memory for a layer of text");
    for (int i = 0; i < NX; i++)
        *put_mm(x[i], -57340000 + i * INT64_C(470000)) = 0;
    for (int k = 0; k < layers && status == OST_OK; k++) {
        char *at = layer, z[LINE], y[LINE];
        *put_mm(z, -98500000 + k * INT64_C(1000000)) = 0;
        for (int j = 0; j < NY; j++) {
            *put_mm(y, -43610000 + j * INT64_C(470000)) = 0;
            for (int i = 0; i < NX; i++) {
                at = stpcpy(stpcpy(stpcpy(at, x[i]), y), z);
                at += sprintf(at, "%d\n", (i * 7 + j * 131 + k * 29) % 2600 - 1024);
            }
        }
        status = write_all(p, layer, (size_t)(at - layer));
    }
    free(layer);
    p->lines = (size_t)NX * NY * (size_t)layers;
    return status;
}

static ost_status make_file(parse *p)
{
    const char *folder = getenv("TMPDIR");
    char name[512];
    int layers = (int)(NZ * (p->options->quick ? 0.02 : p->options->scale) + 0.5);
    snprintf(name, sizeof name, "%s/osteon-bench-XXXXXX", folder && *folder ? folder : "/tmp");
    p->fd = mkstemp(name);
    if (p->fd < 0)
        return ost_fail(p->err, OST_ERR_IO, "%s: %s", name, strerror(errno));
    unlink(name);
    snprintf(p->path, sizeof p->path, "/proc/self/fd/%d", p->fd);
    return write_text(p, layers < 2 ? 2 : layers);
}

/* --------------------------------------------------------------- measuring */

static ost_status import(parse *p, ost_backend *backend, bool digests, bench_series *series, ost_digest *rect)
{
    ost_bone *bone = NULL;
    ost_import_result result;
    const ost_import_options options = {.digests = digests, .threads = p->options->threads};
    int64_t begin = bench_now();
    ost_status status = ost_import(backend, p->path, &options, &bone, &result, p->err);
    double ns = (double)(bench_now() - begin);
    for (int s = 0; s < result.stage_count && status == OST_OK; s++) {
        if (strcmp(result.stages[s].name, "cubic") == 0 || strcmp(result.stages[s].name, "chunks") == 0)
            ns -= result.stages[s].time_ms * 1e6;
        if (rect && strcmp(result.stages[s].name, "rect") == 0)
            *rect = result.stages[s].digest;
    }
    if (series && status == OST_OK)
        bench_series_add(series, ns);
    ost_bone_free(bone);
    return status;
}

/* Compares the digests of the rect grids that the measured backend and the reference have imported. */
static ost_status verify(parse *p, ost_backend *backend)
{
    ost_backend *ref = NULL;
    ost_digest expected, rect;
    memset(&expected, 1, sizeof expected);
    memset(&rect, 2, sizeof rect);
    ost_status status = ost_backend_open("ref", &ref, p->err);
    if (status == OST_OK)
        status = import(p, ref, true, NULL, &expected);
    if (status == OST_OK)
        status = import(p, backend, true, NULL, &rect);
    if (status == OST_OK)
        p->equal = memcmp(&expected, &rect, sizeof rect) == 0;
    ost_backend_close(ref);
    return status;
}

static ost_status time_fscanf(parse *p)
{
    float *positions = malloc(p->lines * 3 * sizeof *positions);
    int16_t *densities = malloc(p->lines * sizeof *densities);
    ost_status status = OST_OK;
    if (!positions || !densities) {
        status = ost_fail(p->err, OST_ERR_MEMORY, "out of memory for %zu lines", p->lines);
    } else {
        int64_t begin = bench_now();
        size_t lines = bench_fscanf_lines(p->path, positions, densities, p->lines);
        bench_series_add(&p->fscanf, (double)(bench_now() - begin));
        if (lines != p->lines)
            status = ost_fail(p->err, OST_ERR_INTERNAL, "fscanf read %zu of %zu lines", lines, p->lines);
    }
    free(positions);
    free(densities);
    return status;
}

static ost_status time_floor(parse *p)
{
    int64_t begin = bench_now();
    void *map = mmap(NULL, p->bytes, PROT_READ, MAP_PRIVATE, p->fd, 0);
    if (map == MAP_FAILED)
        return ost_fail(p->err, OST_ERR_IO, "mapping the text of parse/text: %s", strerror(errno));
    bench_read_bytes(map, p->bytes, p->options->threads);
    munmap(map, p->bytes);
    bench_series_add(&p->floor, (double)(bench_now() - begin));
    return OST_OK;
}

static ost_status repeat(parse *p, ost_backend *backend, bool baseline)
{
    ost_status status = OST_OK;
    const int count = bench_repeat(p->options, REPEAT);
    for (int i = 0; i < count && status == OST_OK; i++) {
        status = import(p, backend, false, &p->ours, NULL);
        if (status == OST_OK && baseline)
            status = time_floor(p);
        if (status == OST_OK && baseline && i < REPEAT_FSCANF)
            status = time_fscanf(p);
    }
    return status;
}

static ost_status add_row(parse *p, bench_table *table, const char *name, bench_series *baseline, const char *what,
                          const char *reason)
{
    if (p->options->filter && !strstr(name, p->options->filter))
        return OST_OK;
    bench_row *row = bench_row_add(table, name, "ms", p->options->threads);
    if (!row)
        return ost_fail(p->err, OST_ERR_MEMORY, "out of memory for a row");
    row->equal = p->equal;
    if (p->equal)
        bench_row_ours(row, &p->ours);
    bench_row_baseline(row, baseline, what);
    snprintf(row->baseline_reason, sizeof row->baseline_reason, "%s", reason);
    bench_row_extra(row, "lines", (double)p->lines);
    bench_row_extra(row, "bytes", (double)p->bytes);
    if (p->equal && p->ours.count)
        bench_row_extra(row, "gb_per_s", (double)p->bytes / bench_series_at(&p->ours, 0.5));
    return OST_OK;
}

ost_status bench_parse(const bench_options *options, bench_table *table, ost_error *err)
{
    static const char text[] = "parse/text", floor[] = "parse/text/floor";
    parse p = {.options = options, .err = err, .fd = -1};
    ost_backend *backend = NULL;
    char reason[BENCH_TEXT];
    if (!bench_wanted(options, text) && !bench_wanted(options, floor))
        return OST_OK;
    const bool baseline = bench_baseline_runs(reason, sizeof reason);
    ost_status status = make_file(&p);
    if (status == OST_OK)
        status = bench_backend(options, options->threads, &backend, err);
    if (status == OST_OK)
        status = verify(&p, backend);
    if (status == OST_OK && p.equal)
        status = repeat(&p, backend, baseline);
    if (status == OST_OK)
        status = add_row(&p, table, text, &p.fscanf, "fscanf(\"%f %f %f %d\") on one thread", reason);
    if (status == OST_OK)
        status = add_row(&p, table, floor, &p.floor, "mapping the file and reading every byte", reason);
    bench_series_free(&p.ours);
    bench_series_free(&p.fscanf);
    bench_series_free(&p.floor);
    ost_backend_close(backend);
    if (p.fd >= 0)
        close(p.fd);
    const char *const names[] = {text, floor};
    return bench_row_not_run(options, table, names, 2, "ms", options->threads, status, err);
}
