/* SPDX-License-Identifier: Apache-2.0 */
#include "reproduction/report.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/memory_stream.h"
#include "io/outfile.h"
#include "reproduction/write.h"

enum { ROWS_MAX = 48 };

static const char head[] =
    "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
    "content=\"width=device-width\"><title>Tables and figures of the thesis, made again</title>\n<style>\n"
    "body{font:15px/1.45 system-ui,-apple-system,'Segoe UI','Liberation Sans','DejaVu Sans',sans-serif;color:#1b2028;"
    "background:#fff;max-width:62em;margin:1.5em auto;padding:0 1em}\n"
    "h1{font-size:1.5em;margin:0 0 .2em}h2{font-size:1.15em;margin:2em 0 .4em;border-top:1px solid "
    "#ccc;padding-top:.5em}\n"
    "p{margin:.4em 0}small,figcaption,.soft{color:#555}figcaption{font-size:.88em}\n"
    "table{border-collapse:collapse;font-variant-numeric:tabular-nums;margin:.5em 0;font-size:.86em}\n"
    "td,th{padding:.18em .55em;text-align:left;vertical-align:top;border-bottom:1px solid #d8dde3}\n"
    "th{font-weight:600;border-bottom:1.5px solid #888;vertical-align:bottom}td.n,th.n{text-align:right}\n"
    "td.n{white-space:nowrap}td.t,th.t{background:#f3f1ea}th small{font-weight:400}\n"
    "figure{margin:.6em 0;break-inside:avoid}img,svg{max-width:100%;height:auto}\n"
    ".pics{display:grid;grid-template-columns:repeat(auto-fit,minmax(19em,1fr));gap:.6em 1em}\n"
    ".pics figure{min-width:0}.pics svg,.pics img{width:100%;max-width:100%}\n"
    ".v{font-weight:600;white-space:nowrap}.scroll{overflow-x:auto}\n"
    "@page{size:A4;margin:13mm}\n"
    "@media print{body{margin:0;padding:0;max-width:none;font-size:10px}h2{break-after:avoid}tr,figure{break-inside:"
    "avoid}table{font-size:8px}td,th{padding:.15em .35em}.scroll{overflow:visible}.pics{grid-template-columns:1fr 1fr}"
    ".pics svg,.pics figure>img{max-width:100%}"
    "svg{max-width:140mm}figure>img{max-width:120mm}a{color:inherit;text-decoration:none}"
    "*{-webkit-print-color-adjust:exact;print-color-adjust:exact}}\n"
    "</style></head><body>\n";

/* A verdict is shown by a sign and a word, so that readers need not distinguish colours. */
static const char *const signs[RESULT_VERDICTS] = {"&#10003;", "&#10007;", "&#8776;", "&#8594;"};

/* Writes "Table 3.3" for "table-3.3". */
static void write_name(FILE *to, const char *id)
{
    const char *number = strchr(id, '-');
    fprintf(to, "%c%.*s %s", toupper((unsigned char)id[0]), number ? (int)(number - id) - 1 : 0, id + 1,
            number ? number + 1 : "");
}

static void base64(FILE *to, const uint8_t *bytes, size_t size)
{
    static const char digit[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < size; i += 3) {
        const size_t left = size - i;
        const uint32_t three =
            (uint32_t)bytes[i] << 16 | (left > 1 ? (uint32_t)bytes[i + 1] << 8 : 0) | (left > 2 ? bytes[i + 2] : 0u);
        fputc(digit[three >> 18], to);
        fputc(digit[three >> 12 & 63], to);
        fputc(left > 1 ? digit[three >> 6 & 63] : '=', to);
        fputc(left > 2 ? digit[three & 63] : '=', to);
    }
}

/* ----------------------------------------------------------------- summary */

static void write_machines(FILE *to, const report_entry *entries, size_t count)
{
    const char *seen[RESULT_MACHINES];
    int seen_count = 0;
    fputs("<h2>Machines</h2>\n<table><tr><th>name</th><th>processor</th><th>OpenCL device</th><th>backend</th><th "
          "class=\"n\">threads</th><th>compiler</th><th>osteon</th></tr>\n",
          to);
    for (size_t i = 0; i < count; i++)
        for (int k = 0; entries[i].result && k < entries[i].result->machine_count; k++) {
            const result_machine *m = &entries[i].result->machine[k];
            bool known = false;
            for (int s = 0; s < seen_count; s++)
                known = known || strcmp(seen[s], m->label) == 0;
            if (known || seen_count == RESULT_MACHINES)
                continue;
            seen[seen_count++] = m->label;
            const char *const texts[] = {m->label, m->cpu, m->device[0] ? m->device : "none", m->backend};
            fputs("<tr>", to);
            for (size_t t = 0; t < sizeof texts / sizeof texts[0]; t++) {
                fputs("<td>", to);
                plot_text(to, texts[t]);
                fputs("</td>", to);
            }
            fprintf(to, "<td class=\"n\">%d</td><td>", m->threads);
            plot_text(to, m->compiler);
            fputs("</td><td>", to);
            plot_text(to, m->version);
            fprintf(to, "%s</td></tr>\n", m->quick ? ", --quick" : "");
        }
    fputs("</table>\n", to);
}

static void write_findings(FILE *to, const report_entry *entries, size_t count)
{
    bool any = false;
    for (size_t i = 0; i < count; i++)
        for (size_t k = 0; entries[i].result && k < entries[i].result->finding_count; k++) {
            const result_finding *f = &entries[i].result->finding[k];
            if (!any)
                fputs("<h2>Statements of the thesis</h2>\n<table><tr><th>statement</th><th>in the thesis</th>"
                      "<th>verdict</th><th>measured, and why</th></tr>\n",
                      to);
            any = true;
            fputs("<tr><td>", to);
            plot_text(to, f->claim);
            fputs("</td><td>", to);
            plot_text(to, f->source);
            fprintf(to, "</td><td class=\"v\">%s %s</td><td>", signs[f->verdict], result_verdict_names[f->verdict]);
            plot_text(to, f->reason);
            if (entries[i].result->machine_count > 1) {
                fputs(" <small>(", to);
                plot_text(to, entries[i].result->machine[f->machine].label);
                fputs(")</small>", to);
            }
            fputs("</td></tr>\n", to);
        }
    if (any)
        fputs("</table>\n", to);
}

/* -------------------------------------------------------------------- items */

static void write_table_head(FILE *to, const result *r)
{
    fputs("<tr>", to);
    if (r->machine_count > 1)
        fputs("<th>machine</th>", to);
    for (int c = 0; c < r->column_count; c++) {
        const result_column *column = &r->column[c];
        fprintf(to, "<th%s>", column->text ? "" : " class=\"n\"");
        plot_text(to, column->title);
        if (column->unit[0]) {
            fputs(" <small>(", to);
            plot_text(to, column->unit);
            fputs(")</small>", to);
        }
        fputs("</th>", to);
        if (column->has_thesis)
            fputs("<th class=\"n t\">thesis</th>", to);
    }
    fputs("</tr>\n", to);
}

static void write_table(FILE *to, const result *r)
{
    char value[WRITE_VALUE];
    if (r->row_count == 0)
        return;
    if (r->row_count > ROWS_MAX) {
        fprintf(to, "<p class=\"soft\">The %zu rows are in %s.csv and %s.json.</p>\n", r->row_count, r->id, r->id);
        return;
    }
    fputs("<div class=\"scroll\"><table>", to);
    write_table_head(to, r);
    for (size_t i = 0; i < r->row_count; i++) {
        fputs("<tr>", to);
        if (r->machine_count > 1) {
            fputs("<td>", to);
            plot_text(to, r->machine[r->row[i].machine].label);
            fputs("</td>", to);
        }
        for (int c = 0; c < r->column_count; c++) {
            const result_cell *cell = &r->row[i].cell[c];
            if (r->column[c].text) {
                fputs("<td>", to);
                plot_text(to, cell->text);
                fputs("</td>", to);
                continue;
            }
            fprintf(to, "<td class=\"n\">%s</td>", cell->known ? write_value(value, cell->value) : "");
            if (r->column[c].has_thesis)
                fprintf(to, "<td class=\"n t\">%s</td>", cell->stated ? write_value(value, cell->thesis) : "");
        }
        fputs("</tr>\n", to);
    }
    fputs("</table></div>\n", to);
}

static void write_pictures(FILE *to, const result *r)
{
    if (r->picture_count == 0)
        return;
    fprintf(to, "<div class=\"%s\">\n", r->picture_count > 1 ? "pics" : "");
    for (size_t i = 0; i < r->picture_count; i++) {
        const result_picture *p = &r->picture[i];
        const char *end = strrchr(p->file, '.');
        const bool svg = end && strcmp(end, ".svg") == 0;
        fputs("<figure>", to);
        if (svg) {
            fwrite(p->bytes, 1, p->size, to);
        } else {
            fputs("<img alt=\"", to);
            plot_text(to, p->caption);
            fputs("\" src=\"data:image/png;base64,", to);
            base64(to, p->bytes, p->size);
            fputs("\">", to);
        }
        fputs("<figcaption>", to);
        plot_text(to, p->caption);
        fputs("</figcaption></figure>\n", to);
    }
    fputs("</div>\n", to);
}

static ost_status write_item(FILE *to, const report_entry *e, ost_error *err)
{
    const result *r = e->result;
    ost_status status = OST_OK;
    fprintf(to, "<section id=\"%s\"><h2>", e->item->id);
    write_name(to, e->item->id);
    fputs(": ", to);
    plot_text(to, e->item->title);
    fputs("</h2>\n", to);
    if (!r) {
        fputs("<p>Not measured: ", to);
        plot_text(to, e->reason);
        fputs(".</p></section>\n", to);
        return OST_OK;
    }
    write_pictures(to, r);
    write_table(to, r);
    for (int i = 0; i < r->plot_count && status == OST_OK; i++) {
        fputs("<figure>", to);
        status = write_plot(to, r, i, err);
        fputs("</figure>\n", to);
    }
    for (size_t i = 0; i < r->remark_count; i++) {
        fputs("<p>", to);
        plot_text(to, r->remark[i].text);
        fputs("</p>\n", to);
    }
    fputs("</section>\n", to);
    return status;
}

/* --------------------------------------------------------------------- list */

static void write_line(FILE *to, const char *id, const char *title, const char *state)
{
    fputs("<tr><td>", to);
    write_name(to, id);
    fputs("</td><td>", to);
    plot_text(to, title);
    fputs("</td><td>", to);
    plot_text(to, state);
    fputs("</td></tr>\n", to);
}

static void write_list(FILE *to, const report_entry *entries, size_t count)
{
    fputs("<h2>All tables and figures</h2>\n<table><tr><th>item</th><th>content</th><th>state</th></tr>\n", to);
    for (const reproduction_item *item = reproduction_items; item->id; item++) {
        const report_entry *found = NULL;
        char state[OST_ERROR_TEXT + 32] = "not part of this run";
        for (size_t i = 0; i < count; i++)
            found = entries[i].item == item ? &entries[i] : found;
        if (found)
            snprintf(state, sizeof state, "%s%s", found->result ? "reproduced" : "not measured: ", found->reason);
        write_line(to, item->id, item->title, state);
    }
    for (const reproduction_absent *absent = reproduction_missing; absent->id; absent++) {
        char state[RESULT_TEXT];
        snprintf(state, sizeof state, "missing: %s", absent->reason);
        write_line(to, absent->id, absent->title, state);
    }
    fputs("</table>\n", to);
}

static ost_status write_page(FILE *to, const report_entry *entries, size_t count, ost_error *err)
{
    fputs(head, to);
    fputs(
        "<h1>Tables and figures of the thesis, made again</h1>\n"
        "<p>The thesis is <i>Haptics-enabled, GPU augmented surgical simulation platform for glenoid reaming</i>. Its "
        "values stand next to those of this run, on a shaded ground. Only values that occur in its text are shown; its "
        "plots have no printed values. <code>osteon reproduce</code> makes this page; docs/reproduction.md describes "
        "the "
        "method. Times depend on the machine and on other work that it does, so that ratios of one run say more than "
        "times of two machines.</p>\n",
        to);
    write_machines(to, entries, count);
    write_findings(to, entries, count);
    ost_status status = OST_OK;
    for (size_t i = 0; i < count && status == OST_OK; i++)
        status = write_item(to, &entries[i], err);
    write_list(to, entries, count);
    fputs("</body></html>\n", to);
    return status;
}

ost_status reproduction_report(const char *folder, const report_entry *entries, size_t count, ost_error *err)
{
    char path[WRITE_PATH];
    ost_memory_stream memory;
    ost_outfile *file = NULL;
    FILE *to = ost_memory_stream_open(&memory);
    if (!to)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for the report");
    ost_status status = write_page(to, entries, count, err);
    if (!ost_memory_stream_close(to, &memory))
        return status == OST_OK ? ost_fail(err, OST_ERR_MEMORY, "out of memory for the report") : status;
    if (status == OST_OK)
        status = write_path(path, folder, "report.html", err);
    if (status == OST_OK)
        status = ost_outfile_open(path, &file, err);
    if (status == OST_OK)
        status = ost_outfile_write(file, memory.bytes, memory.size, err);
    if (status == OST_OK)
        status = ost_outfile_commit(file, err);
    else
        ost_outfile_discard(file);
    free(memory.bytes);
    return status;
}
