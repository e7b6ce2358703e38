/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writes the differences as one self-contained page. Pictures are data URIs and the chunk map is
 * SVG. The page can be printed on white paper.
 */
#include "app/diff/compare.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "app/common/html.h"
#include "app/common/print.h"

static const char head[] =
    "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>osteon diff</title>\n<style>\n"
    "body{font:15px/1.45 system-ui,sans-serif;color:#222;background:#fff;max-width:70em;margin:2em auto;padding:0 "
    "1em}\n"
    "h1{font-size:1.5em;margin:0 0 .2em}h2{font-size:1.1em;margin:1.8em 0 .5em}\n"
    ".verdict{font-size:1.15em;padding:.5em .8em;border-left:5px solid}\n"
    ".equal{border-color:#2a8a4a;background:#eef7f0}.differ{border-color:#c8402f;background:#fbefed}\n"
    "table{border-collapse:collapse;font-variant-numeric:tabular-nums}\n"
    "td,th{padding:.2em .8em .2em 0;text-align:left;vertical-align:top;border-bottom:1px solid #ddd}\n"
    "td.n,th.n{text-align:right}img{max-width:100%;display:block;margin:.3em 0 1em}\n"
    "figure{margin:0}figcaption{color:#555}svg{margin:0 .6em .6em 0}code{font-size:.95em}\n"
    ".key i{display:inline-block;width:.8em;height:.8em;margin:0 .3em 0 1em}\n"
    "@media print{body{margin:0;max-width:none;font-size:11px}h2{break-after:avoid}figure,tr,svg{break-inside:avoid}"
    "*{-webkit-print-color-adjust:exact;print-color-adjust:exact}}\n"
    "</style></head><body>\n";

/* ---------------------------------------------------------------- pictures */

static void figure(html_page *p, const ost_picture *picture, const char *caption)
{
    uint8_t *png = NULL;
    size_t size = 0;
    if (p->status != OST_OK)
        return;
    p->status = ost_picture_encode_png(picture, &png, &size, p->err);
    html_print(p, "<figure><figcaption>%s</figcaption><img alt=\"%s\" width=\"%d\" src=\"data:image/png;base64,",
               caption, caption, picture->width);
    html_base64(p, png, size);
    html_text(p, "\"></figure>\n");
    free(png);
}

/*
 * Draws slices of a grid. The voxels of a tool have the values 0, 1 and 2, so a tool is drawn with a grey-scale window
 * of width 3 around 1.
 */
static void slices(html_page *p, const loaded_volume *in, const diff_result *r, const char *caption)
{
    ost_picture picture = {0};
    const ost_slices_options options = {.at = {r->busiest[0], r->busiest[1], r->busiest[2]},
                                        .threshold = in->threshold,
                                        .level = in->kind == LOAD_TOOL ? 1 : 0,
                                        .width = in->kind == LOAD_TOOL ? 3 : 0,
                                        .pixels = 420,
                                        .unoriented = diff_unoriented(in)};
    if (p->status == OST_OK)
        p->status = ost_picture_slices(&in->volume, NULL, &options, &picture, p->err);
    if (p->status == OST_OK)
        figure(p, &picture, caption);
    ost_picture_free(&picture);
}

static void view(html_page *p, const loaded_volume *a, const loaded_volume *b, const diff_result *r)
{
    ost_picture picture = {0};
    if (p->status != OST_OK || !diff_has_view(a, b, r))
        return;
    p->status = diff_view(a, b, r, &picture, p->err);
    if (p->status == OST_OK)
        figure(p, &picture,
               "Surface of B where most differs; what A has and B has not is coloured by its depth below the surface "
               "of A");
    ost_picture_free(&picture);
}

static void pictures(html_page *p, const loaded_volume *a, const loaded_volume *b, const diff_result *r)
{
    if (!r->same_dims || p->status != OST_OK)
        return;
    html_text(p, "<h2>Slices</h2>\n");
    html_print(p, "<p>Axial, coronal and sagittal, through voxel (%d, %d, %d), where most differs.</p>\n",
               r->busiest[0], r->busiest[1], r->busiest[2]);
    ost_picture picture = {0};
    p->status = diff_picture(a, b, r, &picture, p->err);
    if (p->status == OST_OK) {
        /* Without libpng, the page has no pictures. */
        uint8_t *png = NULL;
        size_t size = 0;
        bool none = ost_picture_encode_png(&picture, &png, &size, NULL) == OST_ERR_UNAVAILABLE;
        free(png);
        if (none) {
            html_text(p, "<p>This osteon was built without libpng, so there are no pictures here.</p>\n");
        } else {
            html_text(
                p,
                "<p class=\"key\"><i style=\"background:#d63c34\"></i>removed<i style=\"background:#2678d6\"></i>added"
                "<i style=\"background:#e6a01e\"></i>changed<i style=\"background:#965abe\"></i>below the "
                "threshold</p>\n");
            figure(p, &picture, "Difference");
            view(p, a, b, r);
            slices(p, a, r, "A");
            slices(p, b, r, "B");
        }
    }
    ost_picture_free(&picture);
}

/* --------------------------------------------------------------- chunk map */

static void chunk_map(html_page *p, const diff_result *r)
{
    enum { CELL = 14 };
    if (!r->chunk_count)
        return;
    int64_t greatest = 1;
    for (size_t c = 0; c < r->chunk_count; c++)
        greatest = r->chunks[c].different > greatest ? r->chunks[c].different : greatest;
    html_print(p,
               "<h2>Chunks</h2>\n<p>%zu of %lld chunks of %d<sup>3</sup> differ; one square a chunk, one map a layer "
               "from the feet up, "
               "darker for more. x to the right, y down.</p>\n",
               r->chunk_count, (long long)ost_dims_count(r->chunk_dims), r->chunk_size);
    size_t c = 0;
    for (int32_t z = 0; z < r->chunk_dims.z; z++) {
        int w = r->chunk_dims.x * CELL, h = r->chunk_dims.y * CELL;
        html_print(p, "<svg width=\"%d\" height=\"%d\"><rect width=\"%d\" height=\"%d\" fill=\"#f4f4f4\"/>"
                 "<text x=\"0\" y=\"%d\" font-size=\"11\" fill=\"#555\">z = %d</text>",
              w + 1, h + 16, w, h, h + 13, z);
        for (; c < r->chunk_count && r->chunks[c].at[2] == z; c++) {
            const diff_chunk *k = &r->chunks[c];
            double share = log1p((double)k->different) / log1p((double)greatest);
            html_print(p,
                       "<rect x=\"%d\" y=\"%d\" width=\"%d\" height=\"%d\" fill=\"#c8402f\" fill-opacity=\"%.2f\">"
                       "<title>chunk (%d, %d, %d): %lld voxels</title></rect>",
                       k->at[0] * CELL, k->at[1] * CELL, CELL - 1, CELL - 1, 0.2 + 0.8 * share, k->at[0], k->at[1],
                       k->at[2], (long long)k->different);
        }
        html_text(p, "</svg>\n");
    }
}

/* ------------------------------------------------------------------ tables */

static void grids_table(html_page *p, const char *name_a, const char *name_b, const loaded_volume *a,
                        const loaded_volume *b)
{
    static const char *const kind[] = {"CT", "bone", "tool"};
    const char *names[2] = {name_a, name_b};
    const loaded_volume *in[2] = {a, b};
    char d[FORMAT_TEXT], s[FORMAT_TEXT], o[FORMAT_TEXT];
    html_text(
        p, "<table><tr><th></th><th>file</th><th>kind</th><th>voxels</th><th>spacing</th><th>first voxel</th></tr>\n");
    for (int i = 0; i < 2; i++) {
        const ost_geometry *g = &in[i]->volume.geometry;
        html_print(p, "<tr><th>%c</th><td><code>", 'A' + i);
        html_escaped(p, names[i]);
        html_print(p, "</code></td><td>%s</td><td>%s</td><td>%s</td><td>%s</td></tr>\n", kind[in[i]->kind],
                   format_dims(d, g->dims), format_spacing(s, g->spacing), format_point(o, g->origin));
    }
    html_text(p, "</table>\n");
}

static void kinds_table(html_page *p, const diff_result *r)
{
    char n[FORMAT_TEXT];
    if (!r->different)
        return;
    html_text(p, "<h2>Kinds</h2>\n<table>\n");
    for (int k = 0; k < DIFF_KIND_COUNT; k++)
        html_print(p, "<tr><td>%s</td><td class=\"n\">%s</td><td>%s</td></tr>\n", diff_kind_name((diff_kind)k),
                   format_count(n, r->count[k]), diff_kind_text((diff_kind)k));
    html_text(p, "</table>\n");
}

static void voxels_table(html_page *p, const loaded_volume *a, const loaded_volume *b, const diff_result *r)
{
    const ost_geometry *g = &a->volume.geometry;
    if (!r->first_count)
        return;
    html_print(p,
               "<h2>The first %zu voxels</h2>\n<table><tr><th class=\"n\">i</th><th class=\"n\">j</th><th "
               "class=\"n\">k</th><th>mm</th>"
               "<th class=\"n\">A</th><th class=\"n\">B</th><th>kind</th></tr>\n",
               r->first_count);
    for (size_t v = 0; v < r->first_count; v++) {
        const diff_voxel *x = &r->first[v];
        char point[FORMAT_TEXT];
        const ost_pm3 at = {g->origin.x + x->at[0] * g->spacing.x, g->origin.y + x->at[1] * g->spacing.y,
                            g->origin.z + x->at[2] * g->spacing.z};
        html_print(p,
                   "<tr><td class=\"n\">%d</td><td class=\"n\">%d</td><td class=\"n\">%d</td><td>%s</td><td "
                   "class=\"n\">%d</td><td class=\"n\">%d</td>"
                   "<td>%s</td></tr>\n",
                   x->at[0], x->at[1], x->at[2], format_point(point, at), x->a, x->b,
                   diff_kind_name(diff_kind_of(x->a, x->b, a->threshold, b->threshold)));
    }
    html_text(p, "</table>\n");
}

ost_status diff_html(const char *path, const char *name_a, const char *name_b, const loaded_volume *a,
                     const loaded_volume *b, const diff_result *r, ost_error *err)
{
    html_page p = {.err = err};
    char n[FORMAT_TEXT];
    p.status = ost_outfile_open(path, &p.file, err);
    if (p.status != OST_OK)
        return p.status;
    html_text(&p, head);
    html_print(&p, "<h1>What differs between two grids</h1>\n<p class=\"verdict %s\">", r->equal ? "equal" : "differ");
    if (r->equal)
        html_text(&p, "Equal: the same geometry, and every voxel the same.");
    else if (!r->same_dims)
        html_text(&p, "They differ: the grids differ in dims, so no voxel was compared.");
    else
        html_print(&p, "They differ in %s voxels.", format_count(n, r->different));
    html_text(&p, "</p>\n");
    grids_table(&p, name_a, name_b, a, b);
    if (r->pattern_count) {
        html_text(&p, "<h2>What it looks like</h2>\n<ul>\n");
        for (int i = 0; i < r->pattern_count; i++)
            html_print(&p, "<li><b>%s</b>: %s</li>\n", r->patterns[i].name, r->patterns[i].text);
        html_text(&p, "</ul>\n");
    }
    kinds_table(&p, r);
    pictures(&p, a, b, r);
    chunk_map(&p, r);
    voxels_table(&p, a, b, r);
    html_text(&p, "</body></html>\n");
    if (p.status == OST_OK)
        return ost_outfile_commit(p.file, err);
    ost_outfile_discard(p.file);
    return p.status;
}
