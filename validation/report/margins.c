/* SPDX-License-Identifier: Apache-2.0 */
/* Writes the margins of differing voxels: a table and a histogram for each backend that differs. */
#include <string.h>

#include "validation/bundle/evidence.h"
#include "validation/margin.h"
#include "validation/report/sections.h"

typedef struct sums {
    json_int_t voxels, inherited, below_threshold, unexplained, unmeasured, decided, max;
    json_int_t bins[MARGIN_BINS];
} sums;

static json_int_t integer(const json_t *o, const char *key)
{
    return json_integer_value(json_object_get(o, key));
}

static sums sum_of(const page *p, const char *backend, trace_stage stage)
{
    sums s = {0};
    for (size_t i = 0; i < json_array_size(p->cases); i++) {
        const json_t *list = json_object_get(
            json_object_get(json_object_get(json_array_get(p->cases, i), "results"), backend), "margins");
        for (size_t k = 0; k < json_array_size(list); k++) {
            const json_t *m = json_array_get(list, k), *bins = json_object_get(m, "bins");
            if (strcmp(evidence_text(m, "stage"), trace_stage_name(stage)) != 0)
                continue;
            s.voxels += integer(m, "voxels");
            s.inherited += integer(m, "inherited");
            s.below_threshold += integer(m, "below_threshold");
            s.unexplained += integer(m, "unexplained");
            s.unmeasured += integer(m, "unmeasured");
            s.decided += integer(m, "decided");
            s.max = integer(m, "max_2_20") > s.max ? integer(m, "max_2_20") : s.max;
            for (size_t b = 0; b < MARGIN_BINS; b++)
                s.bins[b] += json_integer_value(json_array_get(bins, b));
        }
    }
    return s;
}

static void number(const page *p, json_int_t value)
{
    fputs("<td class=\"n\">", p->to);
    page_count(p, value);
    fputs("</td>", p->to);
}

/* Writes one bar for each bin of margins. The bins are powers of two: the first bar is for margins of 0 (on the
   border), and the last bar for margins of one voxel or more. The height of a bar is proportional to the number of
   binary digits of its count, so that a single voxel is visible next to a million voxels. */
static void histogram(const page *p, const sums *s)
{
    enum { BAR = 9, HEIGHT = 36 };
    fprintf(p->to,
            "<svg role=\"img\" aria-label=\"voxels by margin\" width=\"%d\" height=\"%d\" viewBox=\"0 0 %d %d\"><path "
            "d=\"M0 %d.5H%d\" stroke=\"#777\"/>",
            BAR * MARGIN_BINS, HEIGHT + 2, BAR * MARGIN_BINS, HEIGHT + 2, HEIGHT, BAR * MARGIN_BINS);
    for (int b = 0; b < MARGIN_BINS; b++) {
        int height = 0;
        for (json_int_t left = s->bins[b]; left > 0 && height < HEIGHT; left /= 2)
            height += 2;
        height = height > HEIGHT ? HEIGHT : height;
        if (height)
            fprintf(p->to,
                    "<rect x=\"%d\" y=\"%d\" width=\"%d\" height=\"%d\" fill=\"#2467bd\"><title>%lld "
                    "voxel%s</title></rect>",
                    b * BAR + 1, HEIGHT - height, BAR - 2, height, (long long)s->bins[b], s->bins[b] == 1 ? "" : "s");
    }
    fputs("</svg>", p->to);
}

static void stage_row(const page *p, trace_stage stage, const sums *s)
{
    fprintf(p->to, "<tr><td><b>%s</b></td>", trace_stage_name(stage));
    number(p, s->voxels);
    number(p, s->inherited);
    number(p, s->below_threshold);
    number(p, s->unexplained);
    number(p, s->decided);
    if (s->decided) {
        fprintf(p->to, "<td class=\"n\">%lld.%07lld<br>of a %s</td><td>", (long long)(s->max / MARGIN_ONE),
                (long long)(s->max % MARGIN_ONE * 10000000 / MARGIN_ONE), margin_unit(stage));
        histogram(p, s);
        fputs("</td></tr>\n", p->to);
    } else
        fputs("<td class=\"n\">-</td><td></td></tr>\n", p->to);
}

/* Writes a sentence that states whether the margins are consistent with "only rounding at borders". */
static void meaning(const page *p, const sums *all, json_int_t near)
{
    const json_int_t other = all->unexplained + all->below_threshold;
    fputs("<p>", p->to);
    if (other) {
        fputs("For ", p->to);
        page_count(p, other);
        fputs(" of these voxels, no border explains the other backend's value, <b>so the difference is not only "
              "rounding</b>. ",
              p->to);
    }
    if (all->decided > near) {
        page_count(p, all->decided - near);
        fputs(" of these decisions lay farther than 1/1024 of a voxel from the nearest border that could explain them, "
              "<b>so the difference is not only rounding</b>. ",
              p->to);
    }
    if (all->unmeasured) {
        page_count(p, all->unmeasured);
        fputs(" voxels were not measured, because there are too many. ", p->to);
    }
    if (!other && !all->unmeasured && all->decided && all->decided == near) {
        fputs("Decisions within 1/1024 of a voxel of a border: ", p->to);
        page_count(p, all->decided);
        fputs(
            ", which are all measured decisions. This is consistent with <b>rounding at borders only</b> but does not "
            "prove it: another mistake can also have its effect at borders, and the greatest margin is a bound for "
            "these cases only.",
            p->to);
    }
    fputs("</p>\n", p->to);
}

static void backend_table(const page *p, const json_t *backend)
{
    sums all = {0};
    json_int_t near = 0;
    for (int stage = 0; stage < TRACE_STAGES; stage++) {
        const sums s = sum_of(p, evidence_text(backend, "name"), (trace_stage)stage);
        if (!s.voxels)
            continue;
        if (!all.voxels) {
            fputs("<h3>", p->to);
            page_text(p, evidence_text(backend, "what"));
            fputs("</h3>\n<div class=\"wide\"><table><thead><tr><th>Stage</th><th class=\"n\">voxels "
                  "that<br>differ</th><th class=\"n\">inherited</th><th class=\"n\">below the<br>threshold</th>"
                  "<th class=\"n\">no border<br>explains</th><th class=\"n\">near a<br>border</th><th "
                  "class=\"n\">greatest<br>margin</th><th>on the border &rarr; a voxel away</th></tr></thead>\n",
                  p->to);
        }
        stage_row(p, (trace_stage)stage, &s);
        all.voxels += s.voxels;
        all.below_threshold += s.below_threshold;
        all.unexplained += s.unexplained;
        all.unmeasured += s.unmeasured;
        all.decided += s.decided;
        for (int b = 0; b <= 10; b++) /* bins 0 to 10: margins below 1/1024 of a voxel */
            near += s.bins[b];
    }
    if (!all.voxels)
        return;
    fputs("</table></div>\n", p->to);
    meaning(p, &all, near);
}

void section_margins(const page *p)
{
    const json_t *backends = json_object_get(p->protocol, "backends");
    bool any = false;
    for (size_t s = 1; s < json_array_size(backends) && !any; s++)
        for (int stage = 0; stage < TRACE_STAGES && !any; stage++)
            any = sum_of(p, evidence_text(json_array_get(backends, s), "name"), (trace_stage)stage).voxels > 0;
    if (!any)
        return;
    fputs("<h2>Margins of differing decisions</h2>\n<p>A margin is the distance, in the reference, of the deciding "
          "point from the nearest border beyond which the other backend's result would be correct. "
          "A voxel is counted in the first stage in which it differs; <i>inherited</i> are the voxels whose input "
          "already "
          "differed. Both axes of the bar charts are logarithmic, by powers of two.</p>\n",
          p->to);
    for (size_t s = 1; s < json_array_size(backends); s++)
        backend_table(p, json_array_get(backends, s));
    fputs("<p class=\"from\">One line per case and stage: ", p->to);
    page_link(p, "margins.csv");
    fputs(".</p>\n", p->to);
}
