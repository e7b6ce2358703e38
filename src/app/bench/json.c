/* SPDX-License-Identifier: Apache-2.0 */
/* Describes the settings of a benchmark and its rows in JSON. */
#include "app/bench/rows.h"

#include <stdio.h>

#include "config.h"

#include "app/common/result.h"

static void put_figures(json_t *o, const char *name, const bench_figures *f)
{
    char key[64];
    const bool known = f->count > 0;
    put(o, name, known ? json_real(f->median) : json_null());
    snprintf(key, sizeof key, "%s_min", name);
    put(o, key, known ? json_real(f->min) : json_null());
    snprintf(key, sizeof key, "%s_max", name);
    put(o, key, known ? json_real(f->max) : json_null());
    snprintf(key, sizeof key, "%s_repetitions", name);
    put_integer(o, key, (int64_t)f->count);
}

/* Stores a number as a JSON integer if it is integral, otherwise as a real. */
static void put_extra(json_t *o, const char *key, double value)
{
    if (value >= 0 && value < 9e15 && (double)(int64_t)value == value)
        put_integer(o, key, (int64_t)value);
    else
        put_real(o, key, value);
}

json_t *bench_row_json(const bench_row *row)
{
    json_t *o = json_object();
    const double ratio = bench_row_ratio(row);
    put_text(o, "name", row->name);
    put_text(o, "unit", row->unit);
    put_integer(o, "threads", row->threads);
    put_bool(o, "run", !row->reason[0]);
    put(o, "equal", row->reason[0] ? json_null() : json_boolean(row->equal));
    put_figures(o, "ours", &row->ours);
    put_figures(o, "baseline", &row->baseline);
    put(o, "ratio", ratio > 0 ? json_real(ratio) : json_null());
    put(o, "ratio_of_minima", ratio > 0 ? json_real(bench_row_ratio_of_minima(row)) : json_null());
    if (row->reason[0])
        put_text(o, "reason", row->reason);
    if (row->baseline_reason[0])
        put_text(o, "baseline_reason", row->baseline_reason);
    if (row->baseline_is[0])
        put_text(o, "baseline_is", row->baseline_is);
    for (int i = 0; i < row->extra_count; i++)
        put_extra(o, row->extra[i].key, row->extra[i].value);
    return o;
}

void bench_put_setting(app_state *app, const bench_options *options, const char *suite)
{
    char cpu[BENCH_TEXT];
    json_t *o = app->result;
    put_text(o, "suite", suite);
    put_text(o, "backend", options->backend);
    put_text(o, "isa", bench_isa(options));
    put_integer(o, "threads", options->threads);
    put_text(o, "cpu", bench_cpu_model(cpu));
    put_integer(o, "cpus", bench_cpus());
    put_text(o, "clock", "CLOCK_MONOTONIC");
    put_text(o, "compiler", BENCH_COMPILER);
    put_text(o, "baseline_flags", OST_BENCH_CFLAGS);
    put_bool(o, "quick", options->quick);
    put(o, "rows", json_array());
}
