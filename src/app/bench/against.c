/* SPDX-License-Identifier: Apache-2.0 */
#include "app/bench/against.h"

#include <stdlib.h>
#include <string.h>

#include "app/common/print.h"
#include "app/common/result.h"
#include "core/file.h"
#include "validation/bundle/limits.h"

enum { FILE_MAX = 1 << 24, LIMIT_MAX = 1000 };

static ost_status read_limit(const app_state *app, const char *text, double *out, ost_error *err)
{
    int64_t thousandths;
    ost_decimal value;
    const char *end = ost_decimal_read(text, text + strlen(text), &value);
    if (!end || strcmp(end + (*end == '%'), "") != 0 || !ost_decimal_scale(&value, 1000, &thousandths, NULL) ||
        thousandths < 0 || thousandths > LIMIT_MAX * 1000)
        return usage_error(app, err, "--max-slowdown '%.40s': expected a percentage from 0 to %d, for example 10%%",
                           text, LIMIT_MAX);
    *out = (double)thousandths / 1000;
    return OST_OK;
}

ost_status bench_against_read(const app_state *app, const char *path, const char *limit, bool quick,
                              bench_against *out, ost_error *err)
{
    char *bytes = NULL;
    size_t size = 0;
    *out = (bench_against){.path = path};
    if (!path)
        return limit ? usage_error(app, err, "--max-slowdown needs --against FILE") : OST_OK;
    ost_status status = read_limit(app, limit ? limit : "10", &out->limit, err);
    if (status == OST_OK)
        status = ost_file_read(path, FILE_MAX, &bytes, &size, NULL, err);
    if (status == OST_OK)
        status = limits_parse(path, bytes, size, &out->root, err);
    free(bytes);
    if (status != OST_OK)
        return status;
    const json_t *was_quick = json_object_get(out->root, "quick");
    out->rows = json_object_get(out->root, "rows");
    if (!json_is_array(out->rows) || !json_is_boolean(was_quick))
        status = ost_fail(err, OST_ERR_INPUT, "%s: no array 'rows' or no 'quick'; expected a file that osteon bench "
                          "--json printed", path);
    else if (json_is_true(was_quick) != quick)
        status = ost_fail(err, OST_ERR_INPUT, "%s: was measured %s --quick, which uses small inputs; measure both runs "
                          "alike", path, quick ? "without" : "with");
    if (status != OST_OK)
        bench_against_free(out);
    return status;
}

void bench_against_free(bench_against *against)
{
    json_decref(against->root);
    *against = (bench_against){.path = NULL};
}

/* Returns the ratio of the shortest times of a row, or 0 if the row contains no ratio. */
static double ratio_of(const json_t *row)
{
    const json_t *ratio = json_object_get(row, "ratio_of_minima");
    return json_is_number(ratio) ? json_number_value(ratio) : 0;
}

static double ratio_before(const bench_against *against, const char *name)
{
    for (size_t i = 0; i < json_array_size(against->rows); i++) {
        const json_t *row = json_array_get(against->rows, i);
        const char *other = json_string_value(json_object_get(row, "name"));
        if (other && strcmp(other, name) == 0)
            return ratio_of(row);
    }
    return 0;
}

/* Prints each setting that differs between the two runs, because the ratios may depend on it. */
static void print_settings(const app_state *app, const bench_against *against)
{
    static const char *const keys[] = {"backend", "isa", "threads", "cpu", "compiler", "baseline_flags"};
    for (size_t i = 0; i < sizeof keys / sizeof *keys; i++) {
        const json_t *then = json_object_get(against->root, keys[i]), *now = json_object_get(app->result, keys[i]);
        if (then && now && json_equal(then, now))
            continue;
        if (json_is_string(then) && json_is_string(now))
            print_line(app, "  %s then: %.100s; now: %.100s", keys[i], json_string_value(then), json_string_value(now));
        else if (json_is_integer(then) && json_is_integer(now))
            print_line(app, "  %s then: %lld; now: %lld", keys[i], (long long)json_integer_value(then),
                       (long long)json_integer_value(now));
        else
            print_line(app, "  %s differs", keys[i]);
    }
}

ost_status bench_against_compare(app_state *app, const bench_against *against, ost_error *err)
{
    const json_t *rows = json_object_get(app->result, "rows");
    json_t *compared = json_array();
    size_t slower = 0;
    for (size_t i = 0; i < json_array_size(rows); i++) {
        const json_t *row = json_array_get(rows, i);
        const char *name = json_string_value(json_object_get(row, "name"));
        const double then = ratio_before(against, name), now = ratio_of(row);
        if (!(then > 0) || !(now > 0))
            continue;
        if (json_array_size(compared) == 0) {
            print_line(app, "%s", "");
            print_line(app, "%-30s %10s %10s %10s", "compared with the earlier run", "ratio then", "ratio now",
                       "slowdown");
        }
        const double slowdown = 100 * (then / now - 1);
        const bool is_slower = slowdown > against->limit;
        print_line(app, "%-30s %10.3g %10.3g %9.1f%%%s", name, then, now, slowdown, is_slower ? "  slower" : "");
        json_t *o = json_object();
        put_text(o, "name", name);
        put_real(o, "ratio_then", then);
        put_real(o, "ratio_now", now);
        put_real(o, "slowdown_percent", slowdown);
        put_bool(o, "slower", is_slower);
        append(compared, o);
        slower += is_slower;
    }
    const size_t count = json_array_size(compared);
    json_t *o = json_object();
    put_text(o, "file", against->path);
    put_real(o, "max_slowdown_percent", against->limit);
    put_integer(o, "slower", (int64_t)slower);
    put(o, "rows", compared);
    put(app->result, "against", o);
    app->answered = true;
    print_settings(app, against);
    if (count == 0)
        return ost_fail(err, OST_ERR_INPUT, "%s: no row with a ratio is in both runs", against->path);
    print_line(app, "  slower than allowed: %zu of %zu rows; allowed is a slowdown of %g %%", slower, count,
               against->limit);
    return slower ? ost_fail(err, OST_ERR_DIFFER, "%zu of %zu rows are slower than allowed", slower, count) : OST_OK;
}
