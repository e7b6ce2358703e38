/* SPDX-License-Identifier: Apache-2.0 */
#include "reproduction/write_json.h"

#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ----------------------------------------------------------------- writing */

static json_t *json_of_machine(const result_machine *m)
{
    return json_pack("{s:s, s:s, s:s, s:s, s:s, s:s, s:s, s:i, s:i, s:f, s:b}", "label", m->label, "cpu", m->cpu,
                     "backend", m->backend, "device", m->device, "isa", m->isa, "compiler", m->compiler, "version",
                     m->version, "threads", m->threads, "processors", m->processors, "memory_gb", m->memory_gb, "quick",
                     m->quick);
}

static json_t *json_of_cell(const result_column *column, const result_cell *cell)
{
    if (column->text)
        return json_string(cell->text);
    json_t *value = cell->known ? json_real(cell->value) : json_null();
    if (!column->has_thesis)
        return value;
    return json_pack("{s:o, s:o}", "value", value, "thesis", cell->stated ? json_real(cell->thesis) : json_null());
}

static json_t *json_of_row(const result *r, const result_row *row)
{
    json_t *o = json_object();
    json_object_set_new(o, "machine", json_integer(row->machine));
    for (int c = 0; c < r->column_count; c++)
        json_object_set_new(o, r->column[c].key, json_of_cell(&r->column[c], &row->cell[c]));
    return o;
}

static json_t *json_of_plot(const result *r, const result_plot *p)
{
    json_t *values = json_array();
    for (int i = 0; i < p->values; i++)
        json_array_append_new(values, json_string(r->column[p->value[i]].key));
    return json_pack("{s:s, s:s, s:s, s:s, s:s, s:o, s:o, s:b, s:b}", "kind",
                     p->kind == RESULT_PLOT_BARS ? "bars" : "lines", "title", p->title, "x_label", p->x_label,
                     "y_label", p->y_label, "x", r->column[p->x].key, "group",
                     p->group >= 0 ? json_string(r->column[p->group].key) : json_null(), "values", values, "log_x",
                     p->log_x, "log_y", p->log_y);
}

char *write_json_text(const result *r)
{
    json_t *machines = json_array(), *columns = json_array(), *rows = json_array(), *plots = json_array(),
           *pictures = json_array(), *findings = json_array(), *remarks = json_array();
    for (int i = 0; i < r->machine_count; i++)
        json_array_append_new(machines, json_of_machine(&r->machine[i]));
    for (int i = 0; i < r->column_count; i++)
        json_array_append_new(columns, json_pack("{s:s, s:s, s:s, s:b, s:b}", "key", r->column[i].key, "title",
                                                 r->column[i].title, "unit", r->column[i].unit, "text",
                                                 r->column[i].text, "thesis", r->column[i].has_thesis));
    for (size_t i = 0; i < r->row_count; i++)
        json_array_append_new(rows, json_of_row(r, &r->row[i]));
    for (int i = 0; i < r->plot_count; i++)
        json_array_append_new(plots, json_of_plot(r, &r->plot[i]));
    for (size_t i = 0; i < r->picture_count; i++)
        json_array_append_new(pictures,
                              json_pack("{s:s, s:s}", "file", r->picture[i].file, "caption", r->picture[i].caption));
    for (size_t i = 0; i < r->finding_count; i++)
        json_array_append_new(findings,
                              json_pack("{s:i, s:s, s:s, s:s, s:s}", "machine", r->finding[i].machine, "verdict",
                                        result_verdict_names[r->finding[i].verdict], "source", r->finding[i].source,
                                        "claim", r->finding[i].claim, "reason", r->finding[i].reason));
    for (size_t i = 0; i < r->remark_count; i++)
        json_array_append_new(remarks,
                              json_pack("{s:i, s:s}", "machine", r->remark[i].machine, "text", r->remark[i].text));
    json_t *o = json_pack("{s:s, s:s, s:s, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "format", WRITE_JSON_FORMAT, "item",
                          r->id, "title", r->title, "machines", machines, "columns", columns, "rows", rows, "findings",
                          findings, "remarks", remarks, "plots", plots, "pictures", pictures);
    char *text = o ? json_dumps(o, JSON_INDENT(1) | JSON_REAL_PRECISION(12)) : NULL;
    json_decref(o);
    const size_t length = text ? strlen(text) : 0;
    char *ended = text ? realloc(text, length + 2) : NULL;
    if (ended)
        memcpy(ended + length, "\n", 2);
    else
        free(text);
    return ended;
}

/* ----------------------------------------------------------------- reading */

static bool take_text(const json_t *o, const char *key, char *out, size_t size)
{
    const char *text = json_string_value(json_object_get(o, key));
    if (!text || strlen(text) >= size)
        return false;
    snprintf(out, size, "%s", text);
    return true;
}

static bool take_bool(const json_t *o, const char *key, bool *out)
{
    const json_t *value = json_object_get(o, key);
    *out = json_is_true(value);
    return json_is_boolean(value);
}

static bool take_index(const json_t *o, const char *key, int count, int *out)
{
    const json_t *value = json_object_get(o, key);
    const json_int_t index = json_integer_value(value);
    if (!json_is_integer(value) || index < 0 || index >= count)
        return false;
    *out = (int)index;
    return true;
}

static bool parse_machine(const json_t *o, result *r)
{
    if (r->machine_count == RESULT_MACHINES)
        return false;
    result_machine *m = &r->machine[r->machine_count++];
    return take_text(o, "label", m->label, sizeof m->label) && take_text(o, "cpu", m->cpu, sizeof m->cpu) &&
           take_text(o, "backend", m->backend, sizeof m->backend) &&
           take_text(o, "device", m->device, sizeof m->device) && take_text(o, "isa", m->isa, sizeof m->isa) &&
           take_text(o, "compiler", m->compiler, sizeof m->compiler) &&
           take_text(o, "version", m->version, sizeof m->version) && take_index(o, "threads", 1 << 20, &m->threads) &&
           take_index(o, "processors", 1 << 20, &m->processors) && take_bool(o, "quick", &m->quick) &&
           ((m->memory_gb = json_number_value(json_object_get(o, "memory_gb"))), true);
}

static bool parse_column(const json_t *o, result *r)
{
    if (r->column_count == RESULT_COLUMNS)
        return false;
    result_column *c = &r->column[r->column_count++];
    return take_text(o, "key", c->key, sizeof c->key) && take_text(o, "title", c->title, sizeof c->title) &&
           take_text(o, "unit", c->unit, sizeof c->unit) && take_bool(o, "text", &c->text) &&
           take_bool(o, "thesis", &c->has_thesis);
}

static bool parse_number(const json_t *value, bool *known, double *out)
{
    *known = json_is_number(value);
    *out = json_number_value(value);
    return *known || json_is_null(value);
}

static bool parse_cell(const json_t *value, const result_column *column, result_cell *cell)
{
    if (column->text) {
        const char *text = json_string_value(value);
        if (!text || strlen(text) >= sizeof cell->text)
            return false;
        snprintf(cell->text, sizeof cell->text, "%s", text);
        return true;
    }
    if (!column->has_thesis)
        return parse_number(value, &cell->known, &cell->value);
    return parse_number(json_object_get(value, "value"), &cell->known, &cell->value) &&
           parse_number(json_object_get(value, "thesis"), &cell->stated, &cell->thesis);
}

static bool parse_row(const json_t *o, result *r)
{
    result_row *row = result_add_row(r);
    if (!take_index(o, "machine", r->machine_count, &row->machine))
        return false;
    for (int c = 0; c < r->column_count; c++)
        if (!parse_cell(json_object_get(o, r->column[c].key), &r->column[c], &row->cell[c]))
            return false;
    return true;
}

static int column_index(const result *r, const char *key)
{
    for (int c = 0; key && c < r->column_count; c++)
        if (strcmp(r->column[c].key, key) == 0)
            return c;
    return -1;
}

static bool parse_plot(const json_t *o, result *r)
{
    char kind[16];
    result_plot p = {.group = -1};
    const json_t *group = json_object_get(o, "group"), *values = json_object_get(o, "values");
    if (!take_text(o, "kind", kind, sizeof kind) || !take_text(o, "title", p.title, sizeof p.title) ||
        !take_text(o, "x_label", p.x_label, sizeof p.x_label) ||
        !take_text(o, "y_label", p.y_label, sizeof p.y_label) || !take_bool(o, "log_x", &p.log_x) ||
        !take_bool(o, "log_y", &p.log_y) || json_array_size(values) > RESULT_PLOT_VALUES)
        return false;
    p.kind = strcmp(kind, "bars") == 0 ? RESULT_PLOT_BARS : RESULT_PLOT_LINES;
    p.x = column_index(r, json_string_value(json_object_get(o, "x")));
    p.group = column_index(r, json_string_value(group));
    for (size_t i = 0; i < json_array_size(values); i++)
        if ((p.value[p.values++] = column_index(r, json_string_value(json_array_get(values, i)))) < 0)
            return false;
    if (p.x < 0 || (p.group < 0 && !json_is_null(group)) || r->plot_count == (int)(sizeof r->plot / sizeof r->plot[0]))
        return false;
    r->plot[r->plot_count++] = p;
    return true;
}

static bool parse_finding(const json_t *o, result *r)
{
    char claim[RESULT_TEXT], source[RESULT_LABEL], reason[RESULT_TEXT], verdict[24];
    int machine;
    if (!take_text(o, "claim", claim, sizeof claim) || !take_text(o, "source", source, sizeof source) ||
        !take_text(o, "reason", reason, sizeof reason) || !take_text(o, "verdict", verdict, sizeof verdict) ||
        !take_index(o, "machine", r->machine_count, &machine))
        return false;
    for (int v = 0; v < RESULT_VERDICTS; v++)
        if (strcmp(verdict, result_verdict_names[v]) == 0) {
            result_add_finding(r, (result_verdict)v, source, claim, "%s", reason);
            if (!r->out_of_memory)
                r->finding[r->finding_count - 1].machine = machine;
            return true;
        }
    return false;
}

static bool parse_remark(const json_t *o, result *r)
{
    char text[RESULT_TEXT];
    int machine;
    if (!take_text(o, "text", text, sizeof text) || !take_index(o, "machine", r->machine_count, &machine))
        return false;
    result_add_remark(r, "%s", text);
    if (!r->out_of_memory)
        r->remark[r->remark_count - 1].machine = machine;
    return true;
}

/* The name of a picture becomes part of a path, so only names without a folder are accepted. */
static bool parse_picture(const json_t *o, result *r)
{
    char file[RESULT_KEY], caption[RESULT_TEXT];
    if (!take_text(o, "file", file, sizeof file) || !take_text(o, "caption", caption, sizeof caption) ||
        strspn(file, "abcdefghijklmnopqrstuvwxyz0123456789.-") != strlen(file) || file[0] == '.')
        return false;
    result_add_picture(r, file, caption, NULL, 0);
    return true;
}

static bool parse_array(const json_t *o, const char *key, result *r, bool (*parse)(const json_t *, result *))
{
    const json_t *array = json_object_get(o, key);
    if (!json_is_array(array))
        return false;
    for (size_t i = 0; i < json_array_size(array); i++)
        if (!parse(json_array_get(array, i), r))
            return false;
    return true;
}

ost_status write_json_parse(const char *text, size_t size, const char *name, result *out, ost_error *err)
{
    static const struct {
        const char *key;
        bool (*parse)(const json_t *, result *);
    } parts[] = {{"machines", parse_machine}, {"columns", parse_column},   {"rows", parse_row},
                 {"plots", parse_plot},       {"findings", parse_finding}, {"remarks", parse_remark},
                 {"pictures", parse_picture}};
    json_error_t where;
    char format[32] = "";
    json_t *o = json_loadb(text, size, JSON_REJECT_DUPLICATES, &where);
    if (!o)
        return ost_fail(err, OST_ERR_INPUT, "%s:%d: %s", name, where.line, where.text);
    ost_status status = OST_OK;
    if (!take_text(o, "format", format, sizeof format) || strcmp(format, WRITE_JSON_FORMAT) != 0)
        status = ost_fail(err, OST_ERR_INPUT, "%s: is not a result of osteon reproduce: its format is '%s', not '%s'",
                          name, format, WRITE_JSON_FORMAT);
    else if (!take_text(o, "item", out->id, sizeof out->id) || !take_text(o, "title", out->title, sizeof out->title))
        status = ost_fail(err, OST_ERR_INPUT, "%s: 'item' or 'title' is missing or too long", name);
    for (size_t i = 0; i < sizeof parts / sizeof parts[0] && status == OST_OK; i++)
        if (!parse_array(o, parts[i].key, out, parts[i].parse))
            status = ost_fail(err, OST_ERR_INPUT, "%s: an element of '%s' is missing, too long or out of range", name,
                              parts[i].key);
    json_decref(o);
    return status == OST_OK ? result_check(out, err) : status;
}
