/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Draws the pictures as the surgeon sees the glenoid: en face, along the planned axis, with superior up. Anterior is
 * on the right for a right shoulder, and on the left for a left shoulder. The map's u axis points to the viewer's
 * left.
 */
#include "app/debrief/plots.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <osteon/picture.h>

#include "render/marks.h"

enum { MAP = OST_METRICS_MAP };
#define REACH_MM (MAP / 2 * OST_METRICS_PITCH_MM)

/*
 * Computes a colour of the Cividis scale by interpolating between five colours. Readers with colour blindness can
 * distinguish the colours of this scale.
 */
static void colour(double share, int rgb[3])
{
    static const double stops[5][3] = {{0, 32, 77}, {66, 78, 108}, {124, 123, 120}, {188, 174, 108}, {255, 234, 70}};
    const double at = fmin(fmax(share, 0), 1) * 4;
    const int k = at >= 4 ? 3 : (int)at;
    for (int c = 0; c < 3; c++)
        rgb[c] = (int)lrint(stops[k][c] + (stops[k + 1][c] - stops[k][c]) * (at - k));
}

static const char *right_of(const debrief *d)
{
    return d->plan.left ? "P" : "A";
}

static const char *left_of(const debrief *d)
{
    return d->plan.left ? "A" : "P";
}

/* ---------------------------------------------------------------- depth map */

typedef enum shade { NOTHING, SHADED, BEYOND, HOLE } shade;
enum { STEPS = 24 };

/*
 * Returns true if the cell or one of its neighbours was drilled. A cell next to a drilled cell contains a part of the
 * hole.
 */
static bool at_hole(const ost_metrics *m, int i)
{
    for (int dy = -1; dy <= 1; dy++)
        for (int dx = -1; dx <= 1; dx++) {
            const int x = i % MAP + dx, y = i / MAP + dy;
            if (x >= 0 && y >= 0 && x < MAP && y < MAP && m->drilled[x + MAP * y])
                return true;
        }
    return false;
}

/* Returns the shade of a cell, and sets *step to the cell's step on the depth scale. */
static shade shade_of(const debrief *d, const ost_metrics *m, int i, int *step)
{
    const double depth = (double)m->depth_mm[i], after = (double)m->after_mm[i];
    *step = 0;
    if (isnan(depth))
        return NOTHING;
    if (m->drilled[i])
        return HOLE;
    if (isnan(after) || after > d->plan.depth_mm + 1)
        return at_hole(m, i) ? HOLE : BEYOND;
    *step = (int)fmin(STEPS - 1, floor(depth / (d->plan.depth_mm + 1) * STEPS));
    return SHADED;
}

static void fill(html_page *p, shade s, int step)
{
    int rgb[3];
    if (s == BEYOND)
        html_text(p, "#d3430d");
    else if (s == HOLE)
        html_text(p, "#111");
    else {
        colour(1 - (step + 0.5) / STEPS, rgb);
        html_print(p, "#%02x%02x%02x", (unsigned)rgb[0], (unsigned)rgb[1], (unsigned)rgb[2]);
    }
}

static void legend(html_page *p, const debrief *d)
{
    const double deepest = d->plan.depth_mm + 1;
    for (int k = 0; k < STEPS; k++) {
        html_print(p, "<rect x=\"%.2f\" y=\"85\" width=\"%.2f\" height=\"3\" fill=\"", 2 + k * 40.0 / STEPS,
                   40.0 / STEPS + 0.1);
        fill(p, SHADED, k);
        html_text(p, "\"/>");
    }
    html_print(p,
               "<text x=\"2\" y=\"92\">0</text><text x=\"%.1f\" y=\"92\" text-anchor=\"middle\">%.0f: plan</text><text "
               "x=\"42\" y=\"92\" text-anchor=\"middle\">%.0f mm</text>\n",
               2 + 40 * d->plan.depth_mm / deepest - 4, d->plan.depth_mm, deepest);
    html_text(p, "<rect x=\"50\" y=\"85\" width=\"3\" height=\"3\" fill=\"#d3430d\"/><text x=\"54\" y=\"87.6\">&gt; 1 "
                 "mm too deep</text>"
                 "<rect x=\"50\" y=\"89.3\" width=\"3\" height=\"3\" fill=\"#111\" stroke=\"#888\" "
                 "stroke-width=\".2\"/><text x=\"54\" y=\"92\">hole</text>\n");
}

void debrief_depth_map(html_page *p, const debrief *d, const ost_metrics *m)
{
    html_text(p, "<figure><h2>Depth of the cut</h2><svg width=\"420\" height=\"486\" viewBox=\"0 0 81 94\" "
                 "role=\"img\" aria-label=\"depth of the cut over the face\">\n"
                 "<rect width=\"81\" height=\"81\" fill=\"var(--panel)\"/><g shape-rendering=\"crispEdges\">\n");
    for (int y = 0; y < MAP; y++)
        for (int x = 0; x < MAP;) {
            /* The u axis points to the left. Adjacent cells of the same colour are drawn as one rectangle. */
            int step, next, run = 1;
            const shade s = shade_of(d, m, MAP - 1 - x + MAP * y, &step);
            while (x + run < MAP && shade_of(d, m, MAP - 1 - (x + run) + MAP * y, &next) == s && next == step)
                run++;
            if (s != NOTHING) {
                html_print(p, "<rect x=\"%d\" y=\"%d\" width=\"%d\" height=\"1\" fill=\"", x, MAP - 1 - y, run);
                fill(p, s, step);
                html_text(p, "\"/>\n");
            }
            x += run;
        }
    html_print(p,
               "</g><path d=\"M40.5 0V81M0 40.5H81\" stroke=\"var(--ink)\" stroke-width=\".15\"/>"
               "<text x=\"42\" y=\"4\">S</text><text x=\"42\" y=\"80\">I</text><text x=\"1.5\" "
               "y=\"39.5\">%s</text><text x=\"77\" y=\"39.5\">%s</text>"
               "<path d=\"M3 76v2h20v-2\" fill=\"none\" stroke=\"var(--ink)\" stroke-width=\".4\"/><text x=\"13\" "
               "y=\"76\" text-anchor=\"middle\">10 mm</text>\n",
               left_of(d), right_of(d));
    legend(p, d);
    html_text(p, "</svg><figcaption>Along the planned axis, as the tool sees it. A anterior, P posterior, S superior, "
                 "I inferior.</figcaption></figure>\n");
}

/* ----------------------------------------------------------------- profiles */

/* Draws the profile of a surface along u or v. The profile has gaps where the surface has no height. */
static void surface_line(html_page *p, const float *surface, bool upward, const char *style)
{
    bool down = false;
    html_text(p, "<path fill=\"none\" d=\"");
    for (int k = 0; k < MAP; k++) {
        const int i = upward ? MAP / 2 + MAP * k : MAP - 1 - k + MAP * (MAP / 2);
        const double w = (double)surface[i], x = k * OST_METRICS_PITCH_MM;
        if (isnan(w)) {
            down = false;
            continue;
        }
        html_print(p, "%c%.1f %.2f", down ? 'L' : 'M', x, w);
        down = true;
    }
    html_print(p, "\" %s/>", style);
}

static void profile(html_page *p, const debrief *d, const ost_metrics *m, bool upward)
{
    const double low = d->plan.depth_mm + 6;
    const int id = upward ? 2 : 1;
    html_print(p,
               "<svg width=\"420\" height=\"%.0f\" viewBox=\"0 -7 40 %.1f\" role=\"img\" aria-label=\"cut through the "
               "face\"><clipPath id=\"c%d\"><rect x=\"0\" y=\"-7\" width=\"40\" "
               "height=\"%.1f\"/></clipPath><rect y=\"-7\" width=\"40\" height=\"%.1f\" fill=\"var(--panel)\"/><g "
               "clip-path=\"url(#c%d)\">\n",
               (low + 7) * 10.5, low + 7, id, low + 7, low + 7, id);
    surface_line(p, m->before_mm, upward, "stroke=\"var(--old)\" stroke-width=\".3\"");
    if (m->sphere) {
        /* The sphere that was fitted to the floor is drawn at its planned position: centred on the axis, with its
         * deepest point at the planned depth. */
        html_text(p, "<path fill=\"none\" d=\"");
        for (int k = 0; k <= 40; k++) {
            const double x = k - 20.0, under = m->sphere_mm * m->sphere_mm - x * x;
            if (under > 0)
                html_print(p, "%c%d %.2f", k && m->sphere_mm * m->sphere_mm > (x - 1) * (x - 1) ? 'L' : 'M', k,
                           d->plan.depth_mm - m->sphere_mm + sqrt(under));
        }
        html_text(p, "\" stroke=\"#d3430d\" stroke-width=\".3\" stroke-dasharray=\"1 .6\"/>");
    }
    surface_line(p, m->after_mm, upward, "stroke=\"var(--good)\" stroke-width=\".45\"");
    html_print(p,
               "</g><path d=\"M20 -7V%.1f\" stroke=\"var(--ink)\" stroke-width=\".06\"/><g style=\"font-size:1.6px\">"
               "<text x=\".6\" y=\"-5\" style=\"font-size:1.6px\">%s</text><text x=\"38.2\" y=\"-5\" "
               "style=\"font-size:1.6px\">%s</text>"
               "<path d=\"M1 %.1fv.8h5v-.8\" fill=\"none\" stroke=\"var(--ink)\" stroke-width=\".15\"/><text x=\"3.5\" "
               "y=\"%.1f\" text-anchor=\"middle\" style=\"font-size:1.6px\">5 mm</text></g></svg>\n",
               low, upward ? "I" : left_of(d), upward ? "S" : right_of(d), low - 1.4, low - 1.6);
}

void debrief_profiles(html_page *p, const debrief *d, const ost_metrics *m)
{
    html_text(p, "<figure>\n");
    profile(p, d, m, false);
    html_text(p, "<div style=\"height:.3em\"></div>\n");
    profile(p, d, m, true);
    html_print(p,
               "<figcaption>Cut through the centre, across and upward; the joint is above. <span "
               "style=\"color:var(--old)\">&#9644; before</span>, "
               "<span style=\"color:var(--good)\">&#9644; after</span>%s</figcaption></figure>\n",
               m->sphere ? ", <span style=\"color:#d3430d\">- - the same sphere where it was planned</span>" : "");
}

/* ----------------------------------------------------------------- pictures */

static void picture(html_page *p, const ost_picture *image, const char *caption)
{
    uint8_t *bytes = NULL;
    size_t size = 0;
    ost_error why = {0};
    const ost_status status = ost_picture_encode_png(image, &bytes, &size, &why);
    if (status == OST_ERR_UNAVAILABLE)
        return; /* Without libpng, the page shows tables and maps only. */
    if (status != OST_OK && p->status == OST_OK)
        p->status = ost_fail(p->err, status, "%s", why.text);
    html_print(p, "<figure><img alt=\"%s\" src=\"data:image/png;base64,", caption);
    html_base64(p, bytes, size);
    html_print(p, "\"><figcaption>%s</figcaption></figure>\n", caption);
    free(bytes);
}

/*
 * Copies the voxels within HALF_MM of the centre, because the glenoid would be too small in a slice of the complete
 * scapula.
 */
static ost_status cut_out(const ost_volume *in, const ost_pm3 *centre, ost_volume *out, ost_error *err)
{
    enum { HALF_MM = 33 };
    ost_geometry g = in->geometry;
    const ost_pm c[3] = {centre->x, centre->y, centre->z}, s[3] = {g.spacing.x, g.spacing.y, g.spacing.z};
    ost_pm o[3] = {g.origin.x, g.origin.y, g.origin.z};
    int32_t n[3] = {g.dims.x, g.dims.y, g.dims.z}, from[3];
    for (int a = 0; a < 3; a++) {
        const double middle = (double)(c[a] - o[a]) / (double)s[a], half = HALF_MM / ost_pm_to_mm(s[a]);
        const double lo = fmin(fmax(0, floor(middle - half)), n[a] - 1),
                     hi = fmin(fmax(lo + 1, ceil(middle + half)), n[a]);
        from[a] = (int32_t)lo;
        n[a] = (int32_t)(hi - lo);
        o[a] += from[a] * s[a];
    }
    const ost_dims complete = g.dims;
    g.dims = (ost_dims){n[0], n[1], n[2]};
    g.origin = (ost_pm3){o[0], o[1], o[2]};
    ost_status status = ost_volume_init(out, &g, err);
    for (int32_t z = 0; status == OST_OK && z < n[2]; z++)
        for (int32_t y = 0; y < n[1]; y++)
            memcpy(out->voxels + (size_t)n[0] * ((size_t)y + (size_t)n[1] * (size_t)z),
                   in->voxels + (size_t)from[0] +
                       (size_t)complete.x * ((size_t)(from[1] + y) + (size_t)complete.y * (size_t)(from[2] + z)),
                   (size_t)n[0] * sizeof *out->voxels);
    return status;
}

static ost_status slices(const debrief *d, const ost_volume *after, int threshold, ost_picture *image, ost_error *err)
{
    ost_volume now = {0}, then = {0};
    ost_slices_options how = {.threshold = threshold, .pixels = 480};
    ost_status status = cut_out(after, &d->plan.at, &now, err);
    if (status == OST_OK)
        status = cut_out(&d->before, &d->plan.at, &then, err);
    if (status == OST_OK) {
        const ost_geometry *g = &now.geometry;
        const ost_pm at[3] = {d->plan.at.x - g->origin.x, d->plan.at.y - g->origin.y, d->plan.at.z - g->origin.z};
        const int32_t dims[3] = {g->dims.x, g->dims.y, g->dims.z};
        for (int a = 0; a < 3; a++) {
            const double voxel = rint((ost_pm_to_mm(at[a]) + d->plan.axis[a] * d->plan.depth_mm / 2) /
                                      ost_pm_to_mm(g->spacing.x));
            how.at[a] = voxel < 0 ? 0 : voxel >= dims[a] ? dims[a] - 1 : (int32_t)voxel;
        }
        status = ost_picture_slices(&now, &then, &how, image, err);
    }
    ost_volume_free(&now);
    ost_volume_free(&then);
    return status;
}

void debrief_pictures(html_page *p, const debrief *d, const ost_volume *after, int threshold)
{
    ost_picture image = {0};
    ost_view_options view = {
        .threshold = threshold,
        .width = 440,
        .height = 440,
        .extent_mm = 60,
        .centre_mm = {ost_pm_to_mm(d->plan.at.x), ost_pm_to_mm(d->plan.at.y), ost_pm_to_mm(d->plan.at.z)}};
    memcpy(view.direction, d->plan.axis, sizeof view.direction);
    if (p->status != OST_OK)
        return;
    html_text(p, "<div class=\"cols pics\">\n");
    ost_status status = slices(d, after, threshold, &image, p->err);
    if (status == OST_OK)
        picture(p, &image, "CT through the plan's centre: axial, coronal, sagittal; what was removed is orange.");
    ost_picture_free(&image);
    if (status == OST_OK && (status = ost_picture_view(after, &d->before, &view, &image, p->err)) == OST_OK)
        picture(p, &image,
                "The glenoid along the planned axis; bared bone is coloured by its depth below the old surface.");
    ost_picture_free(&image);
    html_text(p, "</div>\n");
    p->status = p->status == OST_OK ? status : p->status;
}

/* ------------------------------------------------------------------- charts */

enum { COLUMNS = 300, W = 170, H = 26 };

/*
 * Draws a chart. `lo` and `hi` contain the minimum and the maximum of each column. The time axis begins at `begun`
 * and covers `span` seconds.
 */
static void chart(html_page *p, const char *what, const double lo[COLUMNS], const double hi[COLUMNS], double begun,
                  double span)
{
    double most = 0;
    for (int x = 0; x < COLUMNS; x++)
        most = fmax(most, hi[x]);
    if (!(most > 0) || !(span > 0))
        return;
    const double step = ost_round_down(most / 2); /* chosen so that the plot has two to five grid lines */
    html_print(p,
               "<svg width=\"552\" height=\"111\" viewBox=\"-12 -4 184 37\" role=\"img\" aria-label=\"%s over "
               "time\"><rect width=\"%d\" height=\"%d\" fill=\"var(--panel)\"/>\n",
               what, W, H);
    for (double y = 0; y <= most; y += step)
        html_print(p,
                   "<path d=\"M0 %.2fH%d\" stroke=\"var(--line)\" stroke-width=\".2\"/><text x=\"-1\" y=\"%.2f\" "
                   "text-anchor=\"end\">%g</text>\n",
                   H - y / most * H, W, H - y / most * H + 1, y);
    for (double t = 0; t <= span; t += ost_round_down(span / 2))
        html_print(p,
                   "<path d=\"M%.2f %dv1\" stroke=\"var(--soft)\" stroke-width=\".2\"/><text x=\"%.2f\" y=\"%d\" "
                   "text-anchor=\"middle\">%g</text>\n",
                   t / span * W, H, t / span * W, H + 5, begun + t);
    html_text(p, "<path fill=\"none\" stroke=\"var(--good)\" stroke-width=\".4\" d=\"");
    for (int x = 0; x < COLUMNS; x++)
        if (isfinite(lo[x]))
            html_print(p, "M%.2f %.2fV%.2f", x * (double)W / COLUMNS, H - lo[x] / most * H + 0.1,
                       H - hi[x] / most * H - 0.1);
    html_print(p, "\"/><text x=\"0\" y=\"-1.2\">%s</text><text x=\"%d\" y=\"%d\" text-anchor=\"end\">s</text></svg>\n",
               what, W, H - 1);
}

void debrief_charts(html_page *p, const debrief *d)
{
    double lo[COLUMNS], hi[COLUMNS], bone[COLUMNS] = {0}, none[COLUMNS] = {0};
    if (d->count < 2)
        return;
    html_text(p, "<h2>Over time</h2><div class=\"cols two\">\n");
    const ost_geometry *g = &d->before.geometry;
    const double mm3 = ost_pm_to_mm(g->spacing.x) * ost_pm_to_mm(g->spacing.y) * ost_pm_to_mm(g->spacing.z);
    const double from = d->motion[0].t_s, span = d->motion[d->count - 1].t_s - from;
    for (int x = 0; x < COLUMNS; x++) {
        lo[x] = INFINITY;
        hi[x] = -INFINITY;
    }
    for (size_t i = 0; i < d->count && span > 0; i++) {
        const double at = fmin(fmax((d->motion[i].t_s - from) / span, 0), 1);
        const int x = (int)(at * (COLUMNS - 1));
        lo[x] = fmin(lo[x], d->motion[i].force_n);
        hi[x] = fmax(hi[x], d->motion[i].force_n);
        bone[x] += d->motion[i].removed * mm3 * COLUMNS / span;
    }
    chart(p, "bone removed, mm&sup3;/s", none, bone, from, span);
    if (d->technique.felt)
        chart(p, "force on the hand, N", lo, hi, from, span);
    html_text(p, "</div>\n");
}
