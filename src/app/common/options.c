/* SPDX-License-Identifier: Apache-2.0 */
#include "app/common/options.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app/common/help.h"
#include "app/common/output_names.h"
#include "core/file.h"
#include "app/common/progress.h"

enum { COMMON_MAX = 6, NAMES_MAX = 128 };

/* Stores in `out` the options that all verbs share. In --help, these options follow the options of the verb. */
static void common_options(app_state *app, bool *help, option out[COMMON_MAX])
{
    const option common[COMMON_MAX] = {
        {.name = "backend", .kind = OPTION_TEXT, .out = &app->backend, .value = "NAME",
         .help = "backend: cpu (default), cpu:isa=avx2, cl, ref or plugin:FILE.so; osteon devices lists them"},
        {.name = "threads", .kind = OPTION_INTEGER, .out = &app->threads, .value = "N", .min = 1, .max = 1024,
         .help = "maximum number of threads (default: one per core); no result depends on it"},
        {.name = "json", .kind = OPTION_FLAG, .out = &app->json, .help = "print one JSON object on standard output"},
        {.name = "quiet", .kind = OPTION_FLAG, .out = &app->quiet, .help = "print no summary, warnings or progress"},
        {.name = "help", .kind = OPTION_FLAG, .out = help, .help = "show this help"},
        {.name = NULL}};
    memcpy(out, common, sizeof common);
}

static const option *find(const option *table, const char *name, size_t length)
{
    for (; table->name; table++)
        if (table->kind != OPTION_HEADING && strlen(table->name) == length && memcmp(table->name, name, length) == 0)
            return table;
    return NULL;
}

bool spec_is(const char *spec, const char *name)
{
    const size_t length = strcspn(spec, ":");
    return strlen(name) == length && memcmp(spec, name, length) == 0;
}

ost_status usage_error(const app_state *app, ost_error *err, const char *format, ...)
{
    char text[OST_ERROR_TEXT];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    return ost_fail(err, OST_ERR_USAGE, "%s (see osteon %s --help)", text, app->verb);
}

static ost_status unknown_option(const app_state *app, const char *name, size_t length, const option *own,
                                 const option *common, ost_error *err)
{
    const char *names[NAMES_MAX];
    int count = 0;
    for (const option *o = own; o->name && count < NAMES_MAX; o++)
        if (o->kind != OPTION_HEADING)
            names[count++] = o->name;
    for (const option *o = common; o->name && count < NAMES_MAX; o++)
        names[count++] = o->name;
    char text[64];
    snprintf(text, sizeof text, "%.*s", (int)(length < 60 ? length : 60), name);
    const char *near = nearest_name(text, names, count);
    if (near)
        return usage_error(app, err, "--%s is not an option of %s; did you mean --%s?", text, app->verb, near);
    return usage_error(app, err, "--%s is not an option of %s", text, app->verb);
}

/*
 * Parses one decimal number, which ends at a comma or at the end of the text. Returns the position after the number,
 * or NULL if the number is invalid.
 */
static const char *decimal_field(const char *text, ost_decimal *out)
{
    const char *end = text + strcspn(text, ",");
    return ost_decimal_read(text, end, out) == end ? end : NULL;
}

/* Parses "x,y,z". If `one` is true, a single value for all three axes is also accepted. */
static bool three_decimals(const char *text, bool one, ost_decimal out[3])
{
    int n = 0;
    for (; n < 3; n++) {
        text = decimal_field(text, &out[n]);
        if (!text)
            return false;
        if (!*text)
            break;
        text++;
    }
    if (n == 0 && one) {
        out[1] = out[2] = out[0];
        return true;
    }
    return n == 2;
}

static ost_status take_lengths(const app_state *app, const option *o, const char *text, bool one, bool positive,
                               ost_pm3 *out, ost_error *err)
{
    ost_decimal d[3];
    ost_pm pm[3];
    if (!three_decimals(text, one, d))
        return usage_error(app, err, "--%s '%s': expected %s in millimetres", o->name, text,
                           one ? "a length or x,y,z" : "x,y,z");
    for (int a = 0; a < 3; a++)
        if (!ost_decimal_to_pm(&d[a], &pm[a], NULL) || (positive && pm[a] <= 0))
            return usage_error(app, err, "--%s '%s': each length must be %s 8000 mm", o->name, text,
                               positive ? "more than 0 and at most" : "within");
    *out = (ost_pm3){pm[0], pm[1], pm[2]};
    return OST_OK;
}

static double decimal_double(const ost_decimal *d)
{
    double value = (double)d->mantissa;
    for (int32_t e = d->exponent; e < 0 && value != 0; e++)
        value /= 10;
    for (int32_t e = d->exponent; e > 0 && value < 1e300 && value > -1e300; e--)
        value *= 10;
    return value;
}

static ost_status take_choice(const app_state *app, const option *o, const char *text, ost_error *err)
{
    const char *choice = o->value;
    for (int index = 0;; index++) {
        size_t length = strcspn(choice, "|");
        if (strlen(text) == length && memcmp(choice, text, length) == 0) {
            *(int *)o->out = index;
            return OST_OK;
        }
        if (!choice[length]) {
            char spoken[OPTION_SPOKEN];
            return usage_error(app, err, "--%s '%s': expected %s", o->name, text, spoken_list(spoken, o->value, ""));
        }
        choice += length + 1;
    }
}

static ost_status take_integer(const app_state *app, const option *o, const char *text, ost_error *err)
{
    ost_decimal d;
    int64_t value = 0;
    bool exact = false;
    if (!decimal_field(text, &d) || *decimal_field(text, &d) || !ost_decimal_scale(&d, 1, &value, &exact) || !exact)
        return usage_error(app, err, "--%s '%s': expected a whole number", o->name, text);
    if (value < o->min || value > o->max)
        return usage_error(app, err, "--%s %s: must be from %lld to %lld", o->name, text, (long long)o->min,
                           (long long)o->max);
    *(int64_t *)o->out = value;
    return OST_OK;
}

static ost_status take(const app_state *app, const option *o, const char *text, ost_error *err)
{
    switch (o->kind) {
    case OPTION_FLAG:
        *(bool *)o->out = true;
        return OST_OK;
    case OPTION_TEXT:
    case OPTION_OUTPUT:
        if (!*text)
            return usage_error(app, err, "--%s must not be empty; expected %s", o->name, o->value);
        *(const char **)o->out = text;
        return OST_OK;
    case OPTION_LIST: {
        option_list *list = o->out;
        if (list->count == OPTION_LIST_MAX)
            return usage_error(app, err, "--%s may be given %d times at most", o->name, OPTION_LIST_MAX);
        list->value[list->count++] = text;
        return OST_OK;
    }
    case OPTION_INTEGER:
        return take_integer(app, o, text, err);
    case OPTION_DECIMAL: {
        option_decimal *out = o->out;
        const char *end = decimal_field(text, &out->value);
        if (!end || *end)
            return usage_error(app, err, "--%s '%s': expected a number", o->name, text);
        out->text = text;
        return OST_OK;
    }
    case OPTION_LENGTH: {
        ost_pm pm;
        ost_error why = {0};
        if (ost_pm_parse(text, &pm, &why) != OST_OK || pm <= 0)
            return usage_error(app, err, "--%s '%s': expected a length in millimetres, more than 0 and at most 8000",
                               o->name, text);
        *(ost_pm *)o->out = pm;
        return OST_OK;
    }
    case OPTION_LENGTHS:
        return take_lengths(app, o, text, true, true, o->out, err);
    case OPTION_POINT:
        return take_lengths(app, o, text, false, false, o->out, err);
    case OPTION_VECTOR: {
        ost_decimal d[3];
        if (!three_decimals(text, false, d))
            return usage_error(app, err, "--%s '%s': expected a direction x,y,z", o->name, text);
        if (!d[0].mantissa && !d[1].mantissa && !d[2].mantissa)
            return usage_error(app, err, "--%s '%s': a direction cannot be zero", o->name, text);
        double *out = o->out, greatest = 0;
        for (int a = 0; a < 3; a++) {
            out[a] = decimal_double(&d[a]);
            greatest = fmax(greatest, fabs(out[a]));
        }
        /* beyond these limits, the squares of the components might overflow or underflow */
        if (!(greatest >= 1e-9 && greatest <= 1e9))
            return usage_error(app, err, "--%s '%s': expected a direction whose greatest component is from 1e-9 to 1e9",
                               o->name, text);
        return OST_OK;
    }
    case OPTION_CHOICE:
        return take_choice(app, o, text, err);
    case OPTION_HEADING:
        break; /* find() never returns a heading */
    }
    return ost_fail(err, OST_ERR_INTERNAL, "option kind %d", (int)o->kind);
}

static ost_status parse_all(app_state *app, const usage_text *usage, int argc, char **argv, const option *common,
                            const bool *help, ost_error *err)
{
    const operand *next = usage->operands;
    bool seen[NAMES_MAX] = {false};
    for (int i = 0; usage->options[i].name; i++)
        if (i == NAMES_MAX)
            return ost_fail(err, OST_ERR_INTERNAL, "%s has more than %d options", app->verb, NAMES_MAX);
    bool only_operands = false;
    ost_status status = OST_OK;
    for (int i = 1; i < argc; i++) {
        const char *word = argv[i];
        if (only_operands || word[0] != '-' || !word[1]) {
            if (!next || !next->name)
                return usage_error(app, err, "unexpected argument '%s'", word);
            if (!*word)
                return usage_error(app, err, "empty argument: %s", next->missing ? next->missing : next->name);
            *next++->out = word;
            continue;
        }
        if (strcmp(word, "--") == 0) {
            only_operands = true;
            continue;
        }
        if (strcmp(word, "-h") == 0)
            word = "--help";
        if (strcmp(word, "-o") == 0)
            word = "--out";
        if (word[1] != '-')
            return usage_error(app, err, "unknown option '%s'; expected --NAME", word);
        const char *name = word + 2;
        size_t length = strcspn(name, "=");
        const option *o = find(usage->options, name, length);
        bool own = o != NULL;
        if (!o)
            o = find(common, name, length);
        if (!o)
            return unknown_option(app, name, length, usage->options, common, err);
        const char *value = name[length] == '=' ? name + length + 1 : NULL;
        if (o->kind == OPTION_FLAG) {
            if (value)
                return usage_error(app, err, "--%s takes no value", o->name);
        } else if (!value) {
            if (i + 1 >= argc || strncmp(argv[i + 1], "--", 2) == 0)
                return usage_error(app, err, "--%s needs a value: %s", o->name, o->value);
            value = argv[++i];
        }
        if (own && o->kind != OPTION_LIST && o->kind != OPTION_FLAG) {
            if (seen[o - usage->options])
                return usage_error(app, err, "--%s is given twice", o->name);
            seen[o - usage->options] = true;
        }
        if ((status = take(app, o, value, err)) != OST_OK)
            return status;
        if (o->given)
            *o->given = true;
        if (*help)
            return OST_OK;
        if (own)
            seen[o - usage->options] = true;
    }
    if (next && next->name && next->missing)
        return usage_error(app, err, "%s", next->missing);
    for (const operand *o = usage->operands; usage->streams && o && o->name; o++)
        if ((status = ost_file_spool(*o->out, err)) != OST_OK)
            return status;
    for (const option *o = usage->options; o->name; o++)
        if (o->required && !seen[o - usage->options])
            return usage_error(app, err, "--%s %s is missing", o->name, o->value);
    return output_names_check(usage->options, argc, argv, err);
}

/* Returns true if an argument is --help, which takes precedence over errors in other arguments. */
static bool is_help(int argc, char **argv)
{
    for (int i = 1; i < argc && strcmp(argv[i], "--") != 0; i++)
        if (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0)
            return true;
    return false;
}

bool options_parse(app_state *app, const usage_text *usage, int argc, char **argv, ost_status *status, ost_error *err)
{
    bool help = false;
    option common[COMMON_MAX];
    common_options(app, &help, common);
    const bool complete = argc == 2 && strcmp(argv[1], "--complete") == 0;
    if (complete || is_help(argc, argv)) {
        if (complete)
            help_print_candidates(usage, common);
        else
            help_print(app, usage, common);
        app->json = false;
        app->quiet = true;
        *status = OST_OK;
        return false;
    }
    *status = parse_all(app, usage, argc, argv, common, &help, err);
    if (*status == OST_OK)
        progress_begin(app);
    return *status == OST_OK;
}
