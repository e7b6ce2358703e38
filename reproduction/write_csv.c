/* SPDX-License-Identifier: Apache-2.0 */
/* Writes the CSV, the plots and the pictures of a result. */
#include "reproduction/write.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/memory_stream.h"
#include "io/outfile.h"
#include "reproduction/write_json.h"

const char *write_value(char text[WRITE_VALUE], double value)
{
    const double size = fabs(value);
    if (value == floor(value) && size < 1e12) {
        char digits[WRITE_VALUE];
        int length = snprintf(digits, sizeof digits, "%.0f", value), at = 0;
        for (int i = 0; i < length && at < WRITE_VALUE - 2; i++) {
            text[at++] = digits[i];
            if (digits[i] != '-' && (length - 1 - i) % 3 == 0 && i + 1 < length)
                text[at++] = ',';
        }
        text[at] = 0;
        return text;
    }
    snprintf(text, WRITE_VALUE, "%.*f",
             size >= 1000  ? 0
             : size >= 100 ? 1
             : size >= 10  ? 2
             : size >= 0.1 ? 3
                           : 5,
             value);
    return text;
}

/* --------------------------------------------------------------------- CSV */

/* Writes a string as a field of CSV (RFC 4180). */
static void csv_text(FILE *to, const char *text)
{
    if (!strpbrk(text, ",\"\r\n")) {
        fputs(text, to);
        return;
    }
    fputc('"', to);
    for (; *text; text++) {
        if (*text == '"')
            fputc('"', to);
        fputc(*text, to);
    }
    fputc('"', to);
}

static void csv_head(FILE *to, const result *r)
{
    fputs("machine", to);
    for (int c = 0; c < r->column_count; c++) {
        fputc(',', to);
        csv_text(to, r->column[c].key);
        if (r->column[c].has_thesis)
            fprintf(to, ",%s_thesis", r->column[c].key);
    }
    fputc('\n', to);
}

static void csv_row(FILE *to, const result *r, const result_row *row)
{
    csv_text(to, r->machine[row->machine].label);
    for (int c = 0; c < r->column_count; c++) {
        const result_cell *cell = &row->cell[c];
        fputc(',', to);
        if (r->column[c].text)
            csv_text(to, cell->text);
        else if (cell->known)
            fprintf(to, "%.12g", cell->value);
        if (r->column[c].has_thesis) {
            fputc(',', to);
            if (cell->stated)
                fprintf(to, "%.12g", cell->thesis);
        }
    }
    fputc('\n', to);
}

/* -------------------------------------------------------------------- plots */

/* The coordinates of one series. A series contains the rows with the same machine and the same text in the column
   `group`. */
typedef struct curve {
    double *x, *y;
} curve;

/* Returns the index of the row's category in `names`, or `count` if the category is not in `names`. */
static size_t category_of(const result *r, int column, size_t row, const char *const *names, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (strcmp(names[i], r->row[row].cell[column].text) == 0)
            return i;
    return count;
}

/* Returns true if no earlier row has the same machine and the same text in the column `group`. */
static bool begins_group(const result *r, const result_plot *p, size_t row)
{
    for (size_t i = 0; i < row; i++)
        if (r->row[i].machine == r->row[row].machine &&
            (p->group < 0 || strcmp(r->row[i].cell[p->group].text, r->row[row].cell[p->group].text) == 0))
            return false;
    return true;
}

/* Returns true if the plot contains values of the thesis in more than one column. */
static bool several_stated(const result *r, const result_plot *p)
{
    int count = 0;
    for (int i = 0; i < p->values; i++)
        count += r->column[p->value[i]].has_thesis;
    return count > 1;
}

static void label_series(const result *r, const result_plot *p, size_t row, int value, bool thesis, char *text)
{
    const result_row *first = &r->row[row];
    const char *group = p->group >= 0 ? first->cell[p->group].text : "";
    const char *machine = r->machine_count > 1 && !thesis ? r->machine[first->machine].label : "";
    const bool named = thesis ? several_stated(r, p) : p->values > 1 || !*group;
    const char *column = named ? r->column[p->value[value]].title : "";
    snprintf(text, PLOT_LABEL, "%s%s%s%s%s%s%s", thesis ? "stated in the thesis" : "",
             thesis && (*column || *group) ? ": " : "", column, *column && *group ? ", " : "", group,
             *machine && (*column || *group) ? "; " : "", machine);
}

typedef struct plotting {
    const result *r;
    const result_plot *p;
    plot drawing;
    const char **names; /* names of the categories; owned */
    size_t name_count;
    double *numbers; /* coordinates of all series; owned */
    size_t used;
} plotting;

/* Adds the series that begins at row `first`, if at least one of its rows has a value. */
static void add_series(plotting *g, size_t first, int value, bool thesis)
{
    plot *d = &g->drawing;
    const result *r = g->r;
    const int column = g->p->value[value];
    if (d->count == PLOT_SERIES)
        return;
    plot_series *s = &d->series[d->count];
    *s = (plot_series){.thesis = thesis, .x = g->numbers + g->used, .y = g->numbers + g->used + r->row_count};
    for (size_t i = first; i < r->row_count; i++) {
        const result_cell *cell = &r->row[i].cell[column], *x = &r->row[i].cell[g->p->x];
        if (r->row[i].machine != r->row[first].machine ||
            (g->p->group >= 0 && strcmp(r->row[i].cell[g->p->group].text, r->row[first].cell[g->p->group].text) != 0))
            continue;
        if (!(thesis ? cell->stated : cell->known) || (!r->column[g->p->x].text && !x->known && !x->stated))
            continue;
        const size_t at = s->count++;
        g->numbers[g->used + at] = r->column[g->p->x].text ? (double)category_of(r, g->p->x, i, g->names, g->name_count)
                                   : x->known              ? x->value
                                                           : x->thesis;
        g->numbers[g->used + r->row_count + at] = thesis ? cell->thesis : cell->value;
    }
    if (s->count == 0)
        return;
    label_series(r, g->p, first, value, thesis, s->label);
    g->used += 2 * r->row_count;
    d->count++;
}

ost_status write_plot(FILE *to, const result *r, int index, ost_error *err)
{
    const result_plot *p = &r->plot[index];
    const size_t rows = r->row_count ? r->row_count : 1;
    plotting g = {.r = r, .p = p};
    g.names = malloc(rows * sizeof *g.names);
    g.numbers = malloc(2 * rows * PLOT_SERIES * sizeof *g.numbers);
    if (!g.names || !g.numbers) {
        free(g.names);
        free(g.numbers);
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a plot of %s", r->id);
    }
    for (size_t i = 0; i < r->row_count && r->column[p->x].text; i++)
        if (category_of(r, p->x, i, g.names, g.name_count) == g.name_count)
            g.names[g.name_count++] = r->row[i].cell[p->x].text;
    g.drawing = (plot){.title = p->title,
                       .x_label = p->x_label,
                       .y_label = p->y_label,
                       .log_x = p->log_x,
                       .log_y = p->log_y,
                       .bars = p->kind == RESULT_PLOT_BARS,
                       .category = g.names,
                       .categories = g.name_count};
    for (size_t i = 0; i < r->row_count; i++)
        if (begins_group(r, p, i))
            for (int v = 0; v < p->values; v++)
                add_series(&g, i, v, false);
    /* The values that the thesis states are the same for every machine, so they are drawn only once. */
    for (size_t i = 0; i < r->row_count; i++)
        if (r->row[i].machine == r->row[0].machine && begins_group(r, p, i))
            for (int v = 0; v < p->values; v++)
                add_series(&g, i, v, true);
    plot_write(to, &g.drawing);
    free(g.names);
    free(g.numbers);
    return OST_OK;
}

/* -------------------------------------------------------------------- files */

static ost_status write_bytes(const char *folder, const char *name, const void *bytes, size_t size, write_files *files,
                              ost_error *err)
{
    char path[WRITE_PATH];
    ost_outfile *file = NULL;
    ost_status status = write_path(path, folder, name, err);
    if (status == OST_OK)
        status = ost_outfile_open(path, &file, err);
    if (status != OST_OK)
        return status;
    status = ost_outfile_write(file, bytes, size, err);
    if (status != OST_OK) {
        ost_outfile_discard(file);
        return status;
    }
    status = ost_outfile_commit(file, err);
    if (status == OST_OK && files && files->count < WRITE_FILES)
        snprintf(files->name[files->count++], WRITE_NAME, "%s", name);
    return status;
}

/* Writes a file whose content the function `fill` writes to a stream. */
static ost_status write_stream(const char *folder, const char *name, const result *r, int index,
                               ost_status (*fill)(FILE *to, const result *r, int index, ost_error *err),
                               write_files *files, ost_error *err)
{
    ost_memory_stream memory;
    FILE *to = ost_memory_stream_open(&memory);
    if (!to)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %s", name);
    ost_status status = fill(to, r, index, err);
    if (!ost_memory_stream_close(to, &memory))
        return status != OST_OK ? status : ost_fail(err, OST_ERR_MEMORY, "out of memory for %s", name);
    if (status == OST_OK)
        status = write_bytes(folder, name, memory.bytes, memory.size, files, err);
    free(memory.bytes);
    return status;
}

static ost_status fill_csv(FILE *to, const result *r, int index, ost_error *err)
{
    (void)index;
    (void)err;
    csv_head(to, r);
    for (size_t i = 0; i < r->row_count; i++)
        csv_row(to, r, &r->row[i]);
    return OST_OK;
}

static ost_status write_json_file(const char *folder, const result *r, write_files *files, ost_error *err)
{
    char name[WRITE_NAME];
    snprintf(name, sizeof name, "%.55s.json", r->id);
    char *text = write_json_text(r);
    if (!text)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %s", name);
    ost_status status = write_bytes(folder, name, text, strlen(text), files, err);
    free(text);
    return status;
}

ost_status write_result(const char *folder, const result *r, write_files *files, ost_error *err)
{
    char name[WRITE_NAME];
    ost_status status = result_check(r, err);
    if (files)
        files->count = 0;
    if (status == OST_OK && r->row_count) {
        snprintf(name, sizeof name, "%.55s.csv", r->id);
        status = write_stream(folder, name, r, 0, fill_csv, files, err);
    }
    for (int i = 0; i < r->plot_count && status == OST_OK; i++) {
        char number[16] = "";
        if (i > 0)
            snprintf(number, sizeof number, "-%d", i + 1);
        snprintf(name, sizeof name, "%.40s%s.svg", r->id, number);
        status = write_stream(folder, name, r, i, write_plot, files, err);
    }
    for (size_t i = 0; i < r->picture_count && status == OST_OK; i++)
        status = write_bytes(folder, r->picture[i].file, r->picture[i].bytes, r->picture[i].size, files, err);
    /* The JSON is written last, so that it never refers to a file that does not exist. */
    return status == OST_OK ? write_json_file(folder, r, files, err) : status;
}
