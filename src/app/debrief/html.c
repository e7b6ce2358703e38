/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writes the debrief's page, sized for one sheet of paper. The page contains the verdict in one line (verdict.c), a
 * table of figures, pictures (plots.c), the technique, and a list of what was not measured. The table gives, for each
 * figure, the planned value, the aim and values from the literature.
 *
 * Readers with red-green colour blindness can distinguish the colours, and each colour is accompanied
 * by a sign and a word. The page loads no other file.
 */
#include "app/debrief/debrief.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "app/debrief/plots.h"
#include "app/debrief/verdict.h"

static const char head[] =
    "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
    "content=\"width=device-width\"><title>Debrief</title>\n<style>\n"
    ":root{--ink:#1b2028;--soft:#5a6370;--line:#d8dde3;--ground:#fff;--panel:#f3f5f7;--good:#00639c;--watch:#9a5b00;--"
    "bad:#b3201a;--old:#8a929c}\n"
    "@media screen and "
    "(prefers-color-scheme:dark){:root{--ink:#e6e9ed;--soft:#a3acb8;--line:#3a424d;--ground:#14181d;--panel:#1d2229;"
    "--good:#62b5ea;--watch:#e8a33d;--bad:#ff8276;--old:#78818c}}\n"
    "body{font:14px/1.4 system-ui,sans-serif;color:var(--ink);background:var(--ground);max-width:72em;margin:1.5em "
    "auto;padding:0 1em}\n"
    "h1{font-size:1.45em;margin:0}h2{font-size:1.02em;margin:1.1em 0 .3em}p{margin:.3em "
    "0}small,figcaption,.soft{color:var(--soft)}small{font-size:.85em}\n"
    ".verdict{border-left:.5em solid;padding:.4em .9em;margin:.7em 0;background:var(--panel);font-size:1.12em}\n"
    ".good{color:var(--good)}.watch{color:var(--watch)}.bad{color:var(--bad);font-weight:600}.verdict p,.verdict "
    "li{color:var(--ink);font-weight:400}\n"
    ".verdict b{font-size:1.1em}.verdict ul{margin:.2em 0;padding-left:1.2em}\n"
    "table{border-collapse:collapse;font-variant-numeric:tabular-nums;width:100%}\n"
    "td,th{padding:.16em .7em .16em 0;text-align:left;vertical-align:top;border-bottom:1px solid "
    "var(--line)}th{font-weight:600;color:var(--soft)}\n"
    "td.n,th.n{text-align:right}td.n,td.a{white-space:nowrap}\n"
    "figure{margin:0 0 .6em}figcaption{font-size:.85em}img,svg{max-width:100%;height:auto;display:block}svg "
    "text{font:3px system-ui,sans-serif;fill:var(--ink)}\n"
    ".cols{display:grid;gap:0 1.8em}.main{grid-template-columns:minmax(0,1.65fr) "
    "minmax(0,1fr)}.two{grid-template-columns:minmax(0,1.15fr) minmax(0,1fr)}\n"
    ".pics{grid-template-columns:minmax(0,2fr) minmax(0,1fr)}\n"
    "@media screen and (max-width:50em){.cols{grid-template-columns:minmax(0,1fr)}}\n"
    "@page{size:A4;margin:9mm}\n"
    "@media print{.main{grid-template-columns:minmax(0,2.2fr) "
    "minmax(0,1fr)}body{margin:0;padding:0;max-width:none;font-size:8.3px;line-height:1.25}h2{margin:.7em 0 "
    ".2em}figure,tr,.verdict{break-inside:avoid}"
    "*{-webkit-print-color-adjust:exact;print-color-adjust:exact}}\n"
    "</style></head><body>\n";

static const char *const level_class[] = {"good", "watch", "bad", ""};
static const char *const level_sign[] = {"&#10003;", "&#9650;", "&#10007;", ""};
static const char *const level_word[] = {"within tolerance", "to be reviewed", "outside tolerance", ""};

static void print_verdict(html_page *p, const verdict *v)
{
    html_print(p, "<div class=\"verdict %s\"><b>%s ", level_class[v->worst], level_sign[v->worst]);
    html_escaped(p, v->line);
    html_text(p, "</b>\n");
    if (v->count)
        html_text(p, "<ul>");
    for (int i = 0; i < v->count; i++)
        html_print(p, "<li><span class=\"%s\">%s</span> %c%s.</li>\n", level_class[v->of[i]], level_sign[v->of[i]],
                   v->remark[i][0] - (v->remark[i][0] >= 'a' ? 32 : 0), v->remark[i] + 1);
    html_text(p, v->count ? "</ul></div>\n" : "</div>\n");
}

/* ------------------------------------------------------------------- tables */

enum { CELL = 48 };

/* Writes one row of a table. `got` and `plan` are formatted numbers; `unit` is printed after each of these numbers. */
static void row(html_page *p, level l, const char *what, const char *got, const char *plan, const char *unit,
                const char *aim, const char *known)
{
    html_print(p,
               "<tr><td>%s</td><td class=\"n %s\" title=\"%s\">%s %s %s</td><td class=\"n\">%s%s%s</td><td "
               "class=\"a\">%s</td><td><small>%s</small></td></tr>\n",
               what, level_class[l], level_word[l], level_sign[l], got, unit, plan, *plan ? " " : "", *plan ? unit : "",
               aim, known);
}

static const char *number(char text[CELL], const char *format, ...) OST_PRINTF(2, 3);

static const char *number(char text[CELL], const char *format, ...)
{
    va_list args;
    va_start(args, format);
    vsnprintf(text, CELL, format, args);
    va_end(args);
    return text;
}

/* Returns 0 for a value that would be printed as zero, so that no minus sign is printed. */
static double plain(double value)
{
    return fabs(value) < 0.05 ? 0 : value;
}

static void face_table(html_page *p, const debrief *d, const ost_metrics *m, const verdict *l)
{
    char a[CELL], b[CELL], text[REMARK];
    html_text(p, "<h2>Comparison with the plan</h2>\n<table><tr><th></th><th class=\"n\">measured</th><th "
                 "class=\"n\">plan</th><th>aim</th><th>known</th></tr>\n");
    if (m->reamed) {
        const char *frame = m->scapular ? "" : "in the CT's planes, not in the scapula's frame";
        row(p, l->depth, "Depth of reaming", number(a, "%.1f", m->reach_mm), number(b, "%.1f", d->plan.depth_mm), "mm",
            "plan &plusmn; 0.5", "cartilage 2, subchondral plate 1.2 to 2.9 [5]");
        row(p, l->tilt, "Axis tilt", number(a, "%.1f", m->tilt_deg), "0", "&deg;", "2 or less",
            "surgeons on a simulator: within 1 [4]");
        row(p, l->entry, "Entry, off the planned centre", number(a, "%.1f", m->entry_mm), "0", "mm", "1 or less",
            "where the reamer's axis passes through the face");
        row(p, NONE, "Version, retroversion +", number(a, "%+.1f", plain(m->version_deg)),
            number(b, "%+.1f", plain(m->version_planned_deg)), "&deg;", "",
            m->scapular ? "native: 2.1, from 16.7 retro to 11.6 ante [1]; from 15 on a peg leaves the vault [2]"
                        : frame);
        row(p, l->version, "Version, error", number(a, "%+.1f", plain(m->version_error_deg)), "0", "&deg;",
            "&plusmn; 2", "");
        row(p, NONE, "Inclination, superior +", number(a, "%+.1f", plain(m->inclination_deg)),
            number(b, "%+.1f", plain(m->inclination_planned_deg)), "&deg;", "",
            m->scapular ? "elderly donors: 8.4 [3]" : frame);
        row(p, l->inclination, "Inclination, error", number(a, "%+.1f", plain(m->inclination_error_deg)), "0", "&deg;",
            "&plusmn; 2", "");
    }
    if (m->floor_mm2 > 0) {
        snprintf(text, sizeof text, "%.1f / %.1f", m->depth_mean_mm, m->depth_max_mm);
        row(p, NONE, "Depth of the cut, mean / most", text, "", "mm", "",
            "below the native face, along the planned axis");
    }
    snprintf(text, sizeof text,
             "more than 1 mm deeper than planned; %.1f %% of the floor, down to %.1f mm below the plan",
             m->over_percent, m->over_max_mm);
    row(p, l->over, "Over-reaming", number(a, "%.0f", m->over_mm3), "0", "mm&sup3;", "20 or less", text);
    if (m->plate_mm3 > 0)
        row(p, l->plate, "Subchondral bone preserved", number(a, "%.0f", m->plate_kept_percent), "", "%", "50 or more",
            "650 HU or more, to 4.5 mm deep; it carries the implant [6]");
    if (m->sphere) {
        snprintf(text, sizeof text, "within 0.5 mm of a back of radius %.1f mm", m->sphere_mm);
        row(p, l->contact, "Backing contact", number(a, "%.0f", m->contact_percent), "", "%", "90 or more", text);
        snprintf(text, sizeof text, "%.1f / %.2f", m->gap_max_mm, m->fit_rms_mm);
        row(p, l->gap, "Backing: widest gap / rms", text, "", "mm", "1 or less",
            "reamed by hand or power: median 0.08 to 0.11 [7]");
    }
    if (m->rim_seen_percent > 0) {
        snprintf(text, sizeof text, "most: %.1f mm", m->rim_lowered_mm);
        row(p, NONE, "Rim lowered by more than 1 mm", number(a, "%.0f", m->rim_lowered_percent), "", "%", "", text);
        if (!isnan(m->width_before_mm) && !isnan(m->width_after_mm)) {
            snprintf(text, sizeof text, "%.0f &rarr; %.0f", m->width_before_mm, m->width_after_mm);
            row(p, NONE, "Face: width", text, "", "mm", "", "before &rarr; after; native 26 &plusmn; 3.4 [8]");
        }
        if (!isnan(m->height_before_mm) && !isnan(m->height_after_mm)) {
            snprintf(text, sizeof text, "%.0f &rarr; %.0f", m->height_before_mm, m->height_after_mm);
            row(p, NONE, "Face: height", text, "", "mm", "", "before &rarr; after; native 35 &plusmn; 4.1 [8]");
        }
    }
    if (m->hole) {
        row(p, l->hole_angle, "Peg hole: axis tilt", number(a, "%.1f", m->hole_angle_deg), "0", "&deg;", "2 or less",
            "");
        row(p, l->hole_entry, "Peg hole: entry, off the plan", number(a, "%.1f", m->hole_entry_mm), "0", "mm",
            "1 or less", "on the native face");
        if (isnan(m->hole_diameter_mm))
            snprintf(text, sizeof text, "%.1f / unknown", m->hole_depth_mm);
        else
            snprintf(text, sizeof text, "%.1f / %.1f", m->hole_depth_mm, m->hole_diameter_mm);
        row(p, NONE, "Peg hole: depth / width", text, "", "mm", "", "below the native face");
        row(p, l->wall, "Peg hole: bone to the wall",
            m->hole_breach ? "perforated"
                           : number(a, "%.1f%s", m->hole_wall_mm, m->hole_wall_mm > 5.99 ? " or more" : ""),
            "", m->hole_breach ? "" : "mm", "2 or more", "thinnest, 6 mm or more below the face");
    }
    html_text(p, "</table>\n");
}

static void fact(html_page *p, level l, const char *what, const char *format, ...) OST_PRINTF(4, 5);

static void fact(html_page *p, level l, const char *what, const char *format, ...)
{
    char text[96];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    html_print(p, "<tr><td>%s</td><td class=\"n %s\">%s %s</td></tr>\n", what, level_class[l], level_sign[l], text);
}

static void technique_table(html_page *p, const debrief *d, const verdict *l)
{
    const ost_technique *t = &d->technique;
    html_text(p, "<div><h2>Technique</h2>\n");
    if (!d->count) {
        html_text(p, "<p>No motion was recorded.</p></div>\n");
        return;
    }
    html_text(p, "<table>\n");
    fact(p, NONE, "Time; in contact", "%.1f s; %.1f s", t->seconds, t->contact_s);
    fact(p, NONE, "Path; in contact", "%.0f mm; %.0f mm", t->path_mm, t->contact_path_mm);
    fact(p, NONE, "Contacts; passes", "%d; %d", t->contacts, t->passes);
    fact(p, NONE, "Tilt in contact, mean; most", "%.1f&deg;; %.1f&deg;", t->tilt_mean_deg, t->tilt_max_deg);
    fact(p, NONE, "Fastest inward in contact", "%.0f mm/s", t->inward_max_mm_s);
    if (t->plunges)
        fact(p, l->plunge, "Plunges, faster than 25 mm/s", "%d, to %.1f mm", t->plunges, t->plunge_mm);
    else
        fact(p, l->plunge, "Plunges, faster than 25 mm/s", "none");
    if (t->felt) {
        fact(p, NONE, "Hand force, mean; 95 %", "%.2f N; %.2f N", t->force_mean_n, t->force_p95_n);
        fact(p, NONE, "Hand force, most", "%.2f N", t->force_max_n);
    }
    html_text(p, "</table></div>\n");
}

static void removed_table(html_page *p, const ost_density_classes *classes, const ost_metrics *m)
{
    html_text(p, "<div><h2>Removed bone</h2>\n<table>\n");
    for (int c = 0; c < classes->count; c++) {
        html_text(p, "<tr><td>");
        html_escaped(p, classes->name[c]);
        html_print(p, ", from %d HU</td><td class=\"n\">%.0f mm&sup3;</td></tr>\n", classes->border[c],
                   m->removed_by_class_mm3[c]);
    }
    html_print(p, "<tr><td>together</td><td class=\"n\">%.0f mm&sup3;</td></tr></table></div>\n", m->removed_mm3);
}

static void not_measured(html_page *p, const debrief *d, const ost_metrics *m)
{
    html_text(p, "<p><small><b>Not measured:</b> how the implant is turned about its axis; soft tissue; the bone's "
                 "strength beyond its HU");
    if (!m->reamed)
        html_text(p, "; depth, tilt and entry of reaming, since no reamer removed bone");
    if (!m->sphere)
        html_text(p, "; backing contact, since less than 50 mm&sup2; were bared");
    if (!m->scapular)
        html_text(p, "; version and inclination in the scapula's own frame, since its landmarks are not set "
                     "(--trigonum, --inferior-angle): angles are in the CT's planes");
    if (m->rim_seen_percent < 99.9)
        html_print(p, "; the %.0f %% of the rim that lie beyond the map", 100 - m->rim_seen_percent);
    if (!d->count)
        html_text(p, "; the motion of the hand");
    else if (!d->technique.felt)
        html_text(p, "; forces, since the device rendered none");
    html_text(p, ".</small></p>\n");
}

static const char sources[] = "<p><small><b>How it is measured:</b> depth, tilt and entry are of the reamer's axis "
                              "where it was deepest; version and "
                              "inclination are that axis in the scapula's frame (trigonum, inferior angle, centre of "
                              "the glenoid). Angles hold to 0.1&deg;, lengths to 0.1 mm and half a "
                              "voxel of the tool, volumes to the bone's voxels; on CT, version is accurate to 3 or "
                              "4&deg; [9]. For training; this is not a medical device.</small></p>\n"
                              "<p><small><b>Sources:</b> [1] 104 shoulders on CT, at mid height, BMC Musculoskelet "
                              "Disord 2016, 10.1186/s12891-016-1381-4. [2] Clavert et al. 2007: 15&deg; of "
                              "retroversion corrected by reaming, the peg left the vault in all five. [3] 19 donors, "
                              "mean age 81, retroversion 5.2&deg;, BMC Musculoskelet Disord 2021, "
                              "10.1186/s12891-021-04660-4. [4] Axford, thesis 2019. [5] Frich: mean 1.9 mm. [6] "
                              "Stephens et al., review in JBJS: ream 10 to 15&deg; at most, preserve subchondral bone. "
                              "[7] deviation from a sphere of 40 mm: reamers by hand, power, Marksman (SiftDesk). [8] "
                              "501 scapulae, Folia Morphol 2023; 82: 325. [9] Robertson et al. 2022.</small></p>\n";

ost_status debrief_page(const char *file, const char *name, const debrief *d, const ost_volume *after,
                        const ost_density_classes *classes, int threshold, const ost_metrics *m, const verdict *v,
                        ost_error *err)
{
    html_page p = {.err = err};
    p.status = ost_outfile_open(file, &p.file, err);
    if (p.status != OST_OK)
        return p.status;
    html_text(&p, head);
    print_verdict(&p, v);
    html_text(&p, "<h1>Debrief: ");
    html_escaped(&p, name);
    html_print(&p,
               "</h1>\n<p class=\"soft\">Glenoid of the %s shoulder; planned: %.1f mm deep at its centre. <span "
               "class=\"good\">&#10003; within tolerance</span>, "
               "<span class=\"watch\">&#9650; to be reviewed</span>, <span class=\"bad\">&#10007; outside "
               "tolerance</span>.</p>\n",
               d->plan.left ? "left" : "right", d->plan.depth_mm);
    html_text(&p, "<div class=\"cols main\"><div>\n");
    face_table(&p, d, m, v);
    html_text(&p, "<div class=\"cols two\">\n");
    technique_table(&p, d, v);
    removed_table(&p, classes, m);
    html_text(&p, "</div></div><div>\n");
    debrief_depth_map(&p, d, m);
    debrief_profiles(&p, d, m);
    html_text(&p, "</div></div>\n");
    debrief_pictures(&p, d, after, threshold);
    debrief_charts(&p, d);
    not_measured(&p, d, m);
    html_text(&p, sources);
    html_text(&p, "</body></html>\n");
    if (p.status == OST_OK)
        return ost_outfile_commit(p.file, err);
    ost_outfile_discard(p.file);
    return p.status;
}
