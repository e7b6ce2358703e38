/* SPDX-License-Identifier: Apache-2.0 */
#include "reproduction/result.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *const result_verdict_names[RESULT_VERDICTS] = {"confirmed", "contradicted", "undecided", "answered"};

void result_init(result *r, const char *id, const char *title, const result_machine *machine)
{
    *r = (result){.machine_count = machine ? 1 : 0};
    snprintf(r->id, sizeof r->id, "%s", id);
    snprintf(r->title, sizeof r->title, "%s", title);
    if (machine)
        r->machine[0] = *machine;
}

void result_free(result *r)
{
    for (size_t i = 0; i < r->picture_count; i++)
        free(r->picture[i].bytes);
    free(r->row);
    free(r->finding);
    free(r->remark);
    free(r->picture);
    *r = (result){.machine_count = 0};
}

int result_add_column(result *r, const char *key, const char *title, const char *unit)
{
    if (r->column_count == RESULT_COLUMNS) {
        r->out_of_memory = true;
        return RESULT_COLUMNS - 1;
    }
    result_column *column = &r->column[r->column_count];
    *column = (result_column){.text = strcmp(unit, "text") == 0};
    snprintf(column->key, sizeof column->key, "%s", key);
    snprintf(column->title, sizeof column->title, "%s", title);
    snprintf(column->unit, sizeof column->unit, "%s", column->text ? "" : unit);
    return r->column_count++;
}

/* Enlarges an array of `count` elements by one element, and returns it. If memory is exhausted, returns NULL and sets
   r->out_of_memory. */
static void *grow(result *r, void *array, size_t count, size_t element)
{
    void *grown = realloc(array, (count + 1) * element);
    r->out_of_memory = r->out_of_memory || !grown;
    return grown;
}

result_row *result_add_row(result *r)
{
    if (r->row_count == r->row_capacity) {
        const size_t capacity = r->row_capacity ? 2 * r->row_capacity : 16;
        result_row *grown = realloc(r->row, capacity * sizeof *grown);
        if (!grown) {
            r->out_of_memory = true;
            return &r->spare;
        }
        r->row = grown;
        r->row_capacity = capacity;
    }
    result_row *row = &r->row[r->row_count++];
    memset(row, 0, sizeof *row);
    return row;
}

static result_cell *last_cell(result *r, int column)
{
    return r->row_count && !r->out_of_memory ? &r->row[r->row_count - 1].cell[column] : &r->spare.cell[column];
}

void result_set(result *r, int column, double value)
{
    result_cell *cell = last_cell(r, column);
    cell->known = true;
    cell->value = value;
}

void result_set_thesis(result *r, int column, double value)
{
    result_cell *cell = last_cell(r, column);
    cell->stated = true;
    cell->thesis = value;
    r->column[column].has_thesis = true;
}

void result_set_text(result *r, int column, const char *format, ...)
{
    result_cell *cell = last_cell(r, column);
    va_list args;
    va_start(args, format);
    vsnprintf(cell->text, sizeof cell->text, format, args);
    va_end(args);
}

void result_add_remark(result *r, const char *format, ...)
{
    result_remark *grown = grow(r, r->remark, r->remark_count, sizeof *grown);
    if (!grown)
        return;
    r->remark = grown;
    result_remark *remark = &r->remark[r->remark_count++];
    *remark = (result_remark){.machine = 0};
    va_list args;
    va_start(args, format);
    vsnprintf(remark->text, sizeof remark->text, format, args);
    va_end(args);
}

void result_add_finding(result *r, result_verdict verdict, const char *source, const char *claim, const char *format,
                        ...)
{
    result_finding *grown = grow(r, r->finding, r->finding_count, sizeof *grown);
    if (!grown)
        return;
    r->finding = grown;
    result_finding *finding = &r->finding[r->finding_count++];
    *finding = (result_finding){.verdict = verdict};
    snprintf(finding->source, sizeof finding->source, "%s", source);
    snprintf(finding->claim, sizeof finding->claim, "%s", claim);
    va_list args;
    va_start(args, format);
    vsnprintf(finding->reason, sizeof finding->reason, format, args);
    va_end(args);
}

void result_add_picture(result *r, const char *file, const char *caption, uint8_t *bytes, size_t size)
{
    result_picture *grown = grow(r, r->picture, r->picture_count, sizeof *grown);
    if (!grown) {
        free(bytes);
        return;
    }
    r->picture = grown;
    result_picture *picture = &r->picture[r->picture_count++];
    *picture = (result_picture){.bytes = bytes, .size = size};
    snprintf(picture->file, sizeof picture->file, "%s", file);
    snprintf(picture->caption, sizeof picture->caption, "%s", caption);
}

result_plot *result_add_plot(result *r, result_plot_kind kind, const char *title, const char *x_label,
                             const char *y_label)
{
    const int count = (int)(sizeof r->plot / sizeof r->plot[0]);
    if (r->plot_count == count)
        r->out_of_memory = true;
    else
        r->plot_count++;
    result_plot *plot = &r->plot[r->plot_count - 1];
    *plot = (result_plot){.kind = kind, .group = -1};
    snprintf(plot->title, sizeof plot->title, "%s", title);
    snprintf(plot->x_label, sizeof plot->x_label, "%s", x_label);
    snprintf(plot->y_label, sizeof plot->y_label, "%s", y_label);
    return plot;
}

ost_status result_check(const result *r, ost_error *err)
{
    return r->out_of_memory ? ost_fail(err, OST_ERR_MEMORY, "out of memory for the result %s", r->id) : OST_OK;
}

/* ----------------------------------------------------------------- merging */

static bool same_columns(const result *a, const result *b)
{
    if (a->column_count != b->column_count)
        return false;
    for (int i = 0; i < a->column_count; i++)
        if (strcmp(a->column[i].key, b->column[i].key) != 0 || a->column[i].text != b->column[i].text)
            return false;
    return true;
}

static bool has_label(const result *r, const char *label)
{
    for (int i = 0; i < r->machine_count; i++)
        if (strcmp(r->machine[i].label, label) == 0)
            return true;
    return false;
}

/*
 * Appends the machines of `from`. If the result already contains a label, a number is added to the new label, so that
 * rows remain distinguishable.
 */
static ost_status merge_machines(result *into, const result *from, ost_error *err)
{
    if (into->machine_count + from->machine_count > RESULT_MACHINES)
        return ost_fail(err, OST_ERR_RANGE, "%s: a report has at most %d machines", from->id, RESULT_MACHINES);
    for (int i = 0; i < from->machine_count; i++) {
        result_machine machine = from->machine[i];
        for (int number = 2; has_label(into, machine.label); number++)
            snprintf(machine.label, sizeof machine.label, "%.80s (%d)", from->machine[i].label, number);
        into->machine[into->machine_count++] = machine;
    }
    return OST_OK;
}

static bool has_picture(const result *r, const char *file)
{
    for (size_t i = 0; i < r->picture_count; i++)
        if (strcmp(r->picture[i].file, file) == 0)
            return true;
    return false;
}

static void merge_pictures(result *into, const result *from)
{
    for (size_t i = 0; i < from->picture_count; i++) {
        const result_picture *picture = &from->picture[i];
        if (has_picture(into, picture->file))
            continue;
        uint8_t *bytes = malloc(picture->size ? picture->size : 1);
        if (!bytes) {
            into->out_of_memory = true;
            return;
        }
        memcpy(bytes, picture->bytes, picture->size);
        result_add_picture(into, picture->file, picture->caption, bytes, picture->size);
    }
}

static void merge_texts(result *into, const result *from, int first)
{
    for (size_t i = 0; i < from->finding_count; i++) {
        const result_finding *f = &from->finding[i];
        result_add_finding(into, f->verdict, f->source, f->claim, "%s", f->reason);
        if (!into->out_of_memory)
            into->finding[into->finding_count - 1].machine = first + f->machine;
    }
    for (size_t i = 0; i < from->remark_count; i++) {
        bool there = false;
        for (size_t k = 0; k < into->remark_count; k++)
            there = there || strcmp(into->remark[k].text, from->remark[i].text) == 0;
        if (there)
            continue;
        result_add_remark(into, "%s", from->remark[i].text);
        if (!into->out_of_memory)
            into->remark[into->remark_count - 1].machine = first + from->remark[i].machine;
    }
}

ost_status result_merge(result *into, const result *from, ost_error *err)
{
    const int first = into->machine_count;
    if (!same_columns(into, from))
        return ost_fail(err, OST_ERR_INPUT,
                        "%s: its columns differ between the merged runs, which were made by "
                        "different versions of osteon",
                        from->id);
    ost_status status = merge_machines(into, from, err);
    if (status != OST_OK)
        return status;
    for (int i = 0; i < from->column_count; i++)
        into->column[i].has_thesis = into->column[i].has_thesis || from->column[i].has_thesis;
    for (size_t i = 0; i < from->row_count; i++) {
        result_row *row = result_add_row(into);
        *row = from->row[i];
        row->machine += first;
    }
    merge_texts(into, from, first);
    merge_pictures(into, from);
    return result_check(into, err);
}

int result_order(double a, double b, double tolerance)
{
    const double least = a < b ? a : b;
    if (a - b > tolerance * least)
        return 1;
    return b - a > tolerance * least ? -1 : 0;
}
