/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The page: verdicts first, then the map of depths, slices and a view, the
 * force over time, and how each number is made.  Pictures are data URIs, maps
 * SVG; nothing is fetched, and it prints.
 */
#include "app/debrief.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <osteon/picture.h>

#include "app/html.h"

static const char head[] =
    "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>Debrief</title>\n<style>\n"
    "body{font:15px/1.45 system-ui,sans-serif;color:#222;background:#fff;max-width:62em;margin:2em auto;padding:0 1em}\n"
    "h1{font-size:1.5em;margin:0 0 .2em}h2{font-size:1.1em;margin:1.6em 0 .4em}\n"
    "table{border-collapse:collapse;font-variant-numeric:tabular-nums}\n"
    "td,th{padding:.2em 1em .2em 0;text-align:left;border-bottom:1px solid #ddd}td.n{text-align:right}\n"
    ".good{color:#1d7a3d}.watch{color:#a86400}.bad{color:#b3261e;font-weight:600}\n"
    "img{max-width:100%;display:block}figure{margin:0 0 1em}figcaption{color:#555}\n"
    ".two{display:flex;gap:2em;flex-wrap:wrap}small{color:#555}\n"
    "@media print{body{margin:0;max-width:none;font-size:11px}figure,tr,svg{break-inside:avoid}"
    "*{-webkit-print-color-adjust:exact;print-color-adjust:exact}}\n"
    "</style></head><body>\n";

static void picture(html_page *p, const ost_picture *picture, const char *caption)
{
    uint8_t *bytes = NULL;
    size_t size = 0;
    ost_error why = {0};
    const ost_status status = ost_picture_encode_png(picture, &bytes, &size, &why);
    if (status == OST_ERR_UNAVAILABLE)
        return; /* built without libpng: the page has its tables and maps */
    if (status != OST_OK && p->status == OST_OK)
        p->status = ost_fail(p->err, status, "%s", why.text);
    html_text(p, "<figure><img alt=\"\" src=\"data:image/png;base64,");
    html_base64(p, bytes, size);
    html_print(p, "\"><figcaption>%s</figcaption></figure>\n", caption);
    free(bytes);
}

/* ------------------------------------------------------------------ tables */

/* A row with a verdict: good up to good, watch up to watch. */
static void judged(html_page *p, const char *what, double value, const char *unit, double good, double watch, const char *aim)
{
    const double size = fabs(value);
    html_print(p, "<tr><td>%s</td><td class=\"n %s\">%.1f %s</td><td><small>%s</small></td></tr>\n", what,
          size <= good ? "good" : size <= watch ? "watch" : "bad", value, unit, aim);
}

static void plain(html_page *p, const char *what, double value, const char *unit, const char *remark)
{
    html_print(p, "<tr><td>%s</td><td class=\"n\">%.1f %s</td><td><small>%s</small></td></tr>\n", what, value, unit, remark);
}

static void tables(html_page *p, const debrief *d, const ost_density_classes *classes, const ost_metrics *m)
{
    html_text(p, "<h2>Reaming</h2><table>\n");
    if (m->sphere) {
        judged(p, "Direction off the plan", m->angle_deg, "&deg;", 2, 5, "aim: 2&deg; or less");
        judged(p, "&nbsp; toward retroversion", m->retroversion_deg, "&deg;", 2, 5, "in the CT's axial plane; negative: anteversion");
        judged(p, "&nbsp; toward superior", m->superior_deg, "&deg;", 2, 5, "in the CT's coronal plane; negative: inferior");
        judged(p, "Depth at the centre, off the plan", m->centre_depth_mm - d->plan.depth_mm, "mm", 0.5, 1, "of the surface fitted to the floor");
    }
    plain(p, "Bared area", m->floor_mm2, "mm&sup2;", "without the hole");
    plain(p, "Depth on average", m->depth_mean_mm, "mm", "below the old surface");
    plain(p, "Depth at most", m->depth_max_mm, "mm", "");
    judged(p, "Removed deeper than planned", m->over_mm3, "mm&sup3;", 20, 100, "beyond the planned depth and 1 mm");
    if (m->plate_mm3 > 0)
        html_print(p, "<tr><td>Hard bone kept under the floor</td><td class=\"n %s\">%.0f %%</td><td><small>650 HU or more, within 4.5 mm</small></td></tr>\n",
              m->plate_kept_percent >= 50 ? "good" : m->plate_kept_percent >= 25 ? "watch" : "bad", m->plate_kept_percent);
    if (m->sphere) {
        html_print(p, "<tr><td>Seat: contact</td><td class=\"n %s\">%.0f %%</td><td><small>gap up to 0.5 mm to a back of radius %.1f mm</small></td></tr>\n",
              m->contact_percent >= 90 ? "good" : m->contact_percent >= 75 ? "watch" : "bad", m->contact_percent, m->sphere_mm);
        judged(p, "Seat: widest gap", m->gap_max_mm, "mm", 1, 2, "");
    }
    html_text(p, "</table>\n<h2>Peg hole</h2>\n");
    if (m->hole) {
        html_text(p, "<table>\n");
        judged(p, "Direction off the plan", m->hole_angle_deg, "&deg;", 2, 5, "");
        judged(p, "Entry off the plan", m->hole_entry_mm, "mm", 1, 2, "on the old face");
        plain(p, "Depth", m->hole_depth_mm, "mm", "from the old face");
        plain(p, "Width", m->hole_diameter_mm, "mm", "");
        html_print(p, "<tr><td>Wall of the vault</td><td class=\"n %s\">%s</td><td><small>thinnest: %.1f mm%s</small></td></tr>\n</table>\n",
              m->hole_breach ? "bad" : m->hole_wall_mm < 2 ? "watch" : "good", m->hole_breach ? "perforated" : "whole", m->hole_wall_mm,
              m->hole_wall_mm > 5.99 ? " or more" : "");
    } else
        html_text(p, "<p>None was found.</p>\n");
    html_text(p, "<h2>What was removed</h2><table>\n");
    for (int c = 0; c < classes->count; c++) {
        html_text(p, "<tr><td>");
        html_escaped(p, classes->name[c]);
        html_print(p, "</td><td class=\"n\">%.0f mm&sup3;</td><td><small>from %d HU</small></td></tr>\n", m->removed_by_class_mm3[c], classes->border[c]);
    }
    html_print(p, "<tr><td>together</td><td class=\"n\">%.0f mm&sup3;</td><td></td></tr></table>\n", m->removed_mm3);
}

/* -------------------------------------------------------------------- maps */

static void depth_map(html_page *p, const debrief *d, const ost_metrics *m)
{
    const double deepest = d->plan.depth_mm + 2;
    html_text(p, "<figure><svg width=\"324\" height=\"324\" viewBox=\"0 0 81 81\" shape-rendering=\"crispEdges\">\n"
            "<rect width=\"81\" height=\"81\" fill=\"#f3f3f3\"/>\n");
    for (int i = 0; i < OST_METRICS_MAP * OST_METRICS_MAP; i++) {
        const double depth = (double)m->depth_mm[i];
        if (isnan(depth))
            continue;
        /* Pale where little went, blue to the plan, red beyond it. */
        const bool beyond = (double)m->after_mm[i] > d->plan.depth_mm + 1 || isnan(m->after_mm[i]);
        const double share = fmin(1, depth / deepest);
        html_print(p, "<rect x=\"%d\" y=\"%d\" width=\"1\" height=\"1\" fill=\"rgb(%d,%d,%d)\"/>\n", i % OST_METRICS_MAP,
              OST_METRICS_MAP - 1 - i / OST_METRICS_MAP, beyond ? 200 : (int)(215 - 185 * share), beyond ? 60 : (int)(232 - 130 * share),
              beyond ? 50 : (int)(245 - 70 * share));
    }
    html_text(p, "<path d=\"M40.5 0V81M0 40.5H81\" stroke=\"#000\" stroke-width=\".2\"/></svg>\n"
            "<figcaption>Depth below the old surface, seen along the planned axis; 40 mm wide, up is toward the head. The darker the "
            "deeper; red is deeper than the plan and 1 mm, the hole among it.</figcaption></figure>\n");
}

static void force_plot(html_page *p, const debrief *d)
{
    enum { W = 700, H = 160, COLUMNS = 700 };
    double most = 0.1;
    if (d->count < 2 || !d->technique.felt)
        return;
    for (size_t i = 0; i < d->count; i++)
        most = fmax(most, d->motion[i].force_n);
    const double from = d->motion[0].t_s, span = fmax(1e-3, d->motion[d->count - 1].t_s - from);
    html_text(p, "<h2>Force on the hand</h2><figure><svg width=\"700\" height=\"160\" viewBox=\"0 0 700 160\"><rect width=\"700\" height=\"160\" fill=\"#f3f3f3\"/>"
            "<path fill=\"none\" stroke=\"#2a5da8\" d=\"");
    /* A column a pixel: from its least to its greatest. */
    size_t i = 0;
    for (int x = 0; x < COLUMNS && i < d->count; x++) {
        double lo = INFINITY, hi = 0;
        for (; i < d->count && (d->motion[i].t_s - from) / span * (COLUMNS - 1) < x + 1; i++) {
            lo = fmin(lo, d->motion[i].force_n);
            hi = fmax(hi, d->motion[i].force_n);
        }
        if (isfinite(lo))
            html_print(p, "M%d %.1fV%.1f", x, H - 5 - lo / most * (H - 10), H - 5 - hi / most * (H - 10) - 0.5);
    }
    html_print(p, "\"/></svg><figcaption>From 0 to %.2f N over %.1f s.</figcaption></figure>\n", most, span);
}

/* Slices through the plan's centre at half the depth, and a view along its axis. */
static void pictures(html_page *p, const debrief *d, const ost_volume *after, int threshold)
{
    ost_picture image = {0};
    ost_slices_options slices = {.threshold = threshold, .pixels = 420};
    ost_view_options view = {.threshold = threshold, .width = 420, .height = 420, .extent_mm = 70,
                             .centre_mm = {ost_pm_to_mm(d->plan.at.x), ost_pm_to_mm(d->plan.at.y), ost_pm_to_mm(d->plan.at.z)}};
    memcpy(view.direction, d->plan.axis, sizeof view.direction);
    const ost_geometry *g = &after->geometry;
    const ost_pm at[3] = {d->plan.at.x - g->origin.x, d->plan.at.y - g->origin.y, d->plan.at.z - g->origin.z};
    const int32_t dims[3] = {g->dims.x, g->dims.y, g->dims.z};
    const double size = sqrt(d->plan.axis[0] * d->plan.axis[0] + d->plan.axis[1] * d->plan.axis[1] + d->plan.axis[2] * d->plan.axis[2]);
    for (int a = 0; a < 3; a++) {
        const double mm = ost_pm_to_mm(at[a]) + d->plan.axis[a] / size * d->plan.depth_mm / 2;
        const double voxel = rint(mm / ost_pm_to_mm(g->spacing.x));
        slices.at[a] = voxel < 0 ? 0 : voxel >= dims[a] ? dims[a] - 1 : (int32_t)voxel;
    }
    html_text(p, "<h2>Pictures</h2>\n");
    ost_status status = ost_picture_slices(after, &d->before, &slices, &image, p->err);
    if (status == OST_OK)
        picture(p, &image, "Axial, coronal and sagittal slice through the plan's centre; what was removed is coloured.");
    ost_picture_free(&image);
    if (status == OST_OK && (status = ost_picture_view(after, &d->before, &view, &image, p->err)) == OST_OK) {
        picture(p, &image, "The glenoid as the tool sees it, along the planned axis; bared bone is tinted.");
        ost_picture_free(&image);
    }
    p->status = p->status == OST_OK ? status : p->status;
}

ost_status debrief_page(const char *file, const char *name, const debrief *d, const ost_volume *after, const ost_density_classes *classes,
                        int threshold, const ost_metrics *m, ost_error *err)
{
    html_page p = {.err = err};
    p.status = ost_outfile_open(file, &p.file, err);
    if (p.status != OST_OK)
        return p.status;
    html_text(&p, head);
    html_text(&p, "<h1>Debrief: ");
    html_escaped(&p, name);
    html_print(&p, "</h1>\n<p>A glenoid of the %s shoulder, planned %.1f mm deep at its centre. Green is within the aim, amber is to be looked at, "
              "red is beyond.</p>\n<div class=\"two\"><div>\n",
          d->plan.left ? "left" : "right", d->plan.depth_mm);
    tables(&p, d, classes, m);
    html_text(&p, "</div><div>\n");
    depth_map(&p, d, m);
    html_text(&p, "</div></div>\n");
    force_plot(&p, d);
    if (p.status == OST_OK)
        pictures(&p, d, after, threshold);
    html_text(&p, "<h2>How to read this</h2><p><small>Direction is that from the centre of the sphere fitted to the bared floor to the planned centre. Angles "
             "are in the CT's planes, not in the scapula's. Numbers hold to about a voxel and half a degree. For training; it is no medical "
             "device.</small></p>\n</body></html>\n");
    if (p.status == OST_OK)
        return ost_outfile_commit(p.file, err);
    ost_outfile_discard(p.file);
    return p.status;
}
