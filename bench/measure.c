/* SPDX-License-Identifier: Apache-2.0 */
/* Series of times and their order statistics, the rows of a table, and properties of the machine. */
#include "bench/bench.h"

#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "core/file.h"
#include "core/isa.h"

int64_t bench_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec * INT64_C(1000000000) + t.tv_nsec;
}

/* ------------------------------------------------------------------ figures */

/* Adds a value to the series. Drops the value if memory is exhausted, so the series may have fewer values than the
   measurement had repetitions. */
void bench_series_add(bench_series *series, double ns)
{
    if (series->count == series->capacity) {
        size_t capacity = series->capacity ? 2 * series->capacity : 256;
        double *grown = realloc(series->ns, capacity * sizeof *grown);
        if (!grown)
            return;
        series->ns = grown;
        series->capacity = capacity;
    }
    series->ns[series->count++] = ns;
}

void bench_series_free(bench_series *series)
{
    free(series->ns);
    *series = (bench_series){0};
}

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

double bench_series_at(bench_series *series, double share)
{
    if (series->count == 0)
        return 0;
    qsort(series->ns, series->count, sizeof *series->ns, by_value);
    size_t rank = (size_t)(share * (double)series->count);
    return series->ns[rank < series->count ? rank : series->count - 1];
}

double bench_series_mean(const bench_series *series)
{
    double sum = 0;
    for (size_t i = 0; i < series->count; i++)
        sum += series->ns[i];
    return series->count ? sum / (double)series->count : 0;
}

static double unit_ns(const char *unit)
{
    return strcmp(unit, "ms") == 0 ? 1e6 : 1e3;
}

static bench_figures figures_of(bench_series *series, double unit)
{
    return (bench_figures){
        .count = series->count,
        .median = bench_series_at(series, 0.5) / unit,
        .min = bench_series_at(series, 0) / unit,
        .max = bench_series_at(series, 1) / unit,
    };
}

/* --------------------------------------------------------------------- rows */

bool bench_wanted(const bench_options *options, const char *name)
{
    if (options->filter && !strstr(name, options->filter))
        return false;
    if (options->show)
        options->show(options->user, name);
    return true;
}

bench_row *bench_row_add(bench_table *table, const char *name, const char *unit, int threads)
{
    if (table->count == table->capacity) {
        size_t capacity = table->capacity ? 2 * table->capacity : 64;
        bench_row *grown = realloc(table->rows, capacity * sizeof *grown);
        if (!grown)
            return NULL;
        table->rows = grown;
        table->capacity = capacity;
    }
    bench_row *row = &table->rows[table->count++];
    *row = (bench_row){.unit = unit, .threads = threads, .equal = true};
    snprintf(row->name, sizeof row->name, "%s", name);
    return row;
}

static bool has_row(const bench_table *table, const char *name)
{
    for (size_t i = 0; i < table->count; i++)
        if (strcmp(table->rows[i].name, name) == 0)
            return true;
    return false;
}

ost_status bench_row_not_run(const bench_options *options, bench_table *table, const char *const names[], int count,
                             const char *unit, int threads, ost_status status, ost_error *err)
{
    if (status == OST_OK || status == OST_ERR_CANCELLED || status == OST_ERR_INTERNAL)
        return status;
    for (int i = 0; i < count; i++) {
        if (!names[i] || (options->filter && !strstr(names[i], options->filter)) || has_row(table, names[i]))
            continue;
        bench_row *row = bench_row_add(table, names[i], unit, threads);
        if (!row)
            return ost_fail(err, OST_ERR_MEMORY, "out of memory for a row");
        snprintf(row->reason, sizeof row->reason, "%.*s", BENCH_TEXT - 1,
                 err->text[0] ? err->text : ost_status_text(status));
    }
    *err = (ost_error){.status = OST_OK};
    return OST_OK;
}

void bench_table_free(bench_table *table)
{
    free(table->rows);
    *table = (bench_table){0};
}

void bench_row_ours(bench_row *row, bench_series *series)
{
    row->ours = figures_of(series, unit_ns(row->unit));
}

void bench_row_baseline(bench_row *row, bench_series *series, const char *what)
{
    row->baseline = figures_of(series, unit_ns(row->unit));
    snprintf(row->baseline_is, sizeof row->baseline_is, "%s", what);
}

void bench_row_extra(bench_row *row, const char *key, double value)
{
    if (row->extra_count == BENCH_EXTRA_MAX)
        return;
    snprintf(row->extra[row->extra_count].key, sizeof row->extra->key, "%s", key);
    row->extra[row->extra_count++].value = value;
}

double bench_row_ratio(const bench_row *row)
{
    if (row->ours.count == 0 || row->baseline.count == 0 || !(row->ours.median > 0))
        return 0;
    return row->baseline.median / row->ours.median;
}

double bench_row_ratio_of_minima(const bench_row *row)
{
    if (row->ours.count == 0 || row->baseline.count == 0 || !(row->ours.min > 0))
        return 0;
    return row->baseline.min / row->ours.min;
}

bool bench_row_disturbed(const bench_row *row)
{
    return (row->baseline.count && row->ours.median > 1.5 * row->ours.min) ||
           row->baseline.median > 1.5 * row->baseline.min;
}

int bench_repeat(const bench_options *options, int normal)
{
    if (options->repeat)
        return options->repeat;
    if (!options->quick)
        return normal;
    return normal < 3 ? normal : 3;
}

/* ------------------------------------------------------------------ machine */

int bench_cpus(void)
{
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof set, &set) == 0 && CPU_COUNT(&set) > 0)
        return CPU_COUNT(&set);
    long n = sysconf(_SC_NPROCESSORS_ONLN);
    return n > 0 ? (int)n : 1;
}

/* Finds the first line that begins with `key` in a file of /proc, and copies the part of the line
   after the colon to `text`. */
static bool proc_line(const char *path, const char *key, char *text, size_t size)
{
    char line[512];
    bool found = false;
    FILE *file;
    (void)ost_file_stream(path, &file, NULL, NULL);
    if (!file)
        return false;
    while (!found && fgets(line, sizeof line, file)) {
        char *colon = strchr(line, ':');
        if (strncmp(line, key, strlen(key)) != 0 || !colon)
            continue;
        char *value = colon + 1 + strspn(colon + 1, " \t");
        value[strcspn(value, "\n")] = 0;
        snprintf(text, size, "%s", value);
        found = true;
    }
    fclose(file);
    return found;
}

const char *bench_cpu_model(char text[BENCH_TEXT])
{
    if (!proc_line("/proc/cpuinfo", "model name", text, BENCH_TEXT) &&
        !proc_line("/proc/cpuinfo", "CPU part", text, BENCH_TEXT))
        snprintf(text, BENCH_TEXT, "unknown");
    return text;
}

int64_t bench_memory(void)
{
    char text[64];
    if (!proc_line("/proc/meminfo", "MemAvailable", text, sizeof text))
        return INT64_MAX;
    return strtoll(text, NULL, 10) * 1024;
}

static bool is_cpu(const char *backend)
{
    return strncmp(backend, "cpu", 3) == 0 && (backend[3] == 0 || backend[3] == ':');
}

const char *bench_isa(const bench_options *options)
{
    char name[32] = "";
    const char *given = strstr(options->backend, "isa=");
    ost_isa isa;
    if (given)
        snprintf(name, sizeof name, "%.*s", (int)strcspn(given + 4, ","), given + 4);
    if (!is_cpu(options->backend) || ost_isa_choose(given ? name : NULL, &isa, NULL) != OST_OK)
        return "scalar";
    return ost_isa_name(isa);
}

ost_status bench_backend(const bench_options *options, int threads, ost_backend **out, ost_error *err)
{
    char spec[256], remainder[200] = "";
    const char *given = strchr(options->backend, ':');
    if (!is_cpu(options->backend))
        return ost_backend_open(options->backend, out, err);
    /* Copies all options except threads=, because the row determines the number of threads. */
    for (const char *at = given ? given + 1 : ""; *at;) {
        size_t length = strcspn(at, ","), used = strlen(remainder);
        if (strncmp(at, "threads=", 8) != 0)
            snprintf(remainder + used, sizeof remainder - used, ",%.*s", (int)length, at);
        at += length + (at[length] == ',');
    }
    snprintf(spec, sizeof spec, "cpu:threads=%d%s", threads, remainder);
    return ost_backend_open(spec, out, err);
}
