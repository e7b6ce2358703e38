/* SPDX-License-Identifier: Apache-2.0 */
/* Writes the results that are not equal, and the detection of the deliberate mistakes. */
#include <stdlib.h>
#include <string.h>

#include "validation/bundle/bundle.h"
#include "validation/bundle/reproduce.h"
#include "validation/campaign.h"
#include "validation/report/pictures.h"
#include "validation/report/sections.h"

enum { LISTED = 200 }; /* maximum number of rows; anomalies.csv contains all results */

static json_int_t integer(const json_t *o, const char *key)
{
    return json_integer_value(json_object_get(o, key));
}

static bool is_finding(const json_t *result)
{
    const char *verdict = evidence_text(result, "verdict");
    return strcmp(verdict, case_verdict_name(CASE_EQUAL)) != 0 && strcmp(verdict, case_verdict_name(CASE_NOT_RUN)) != 0;
}

/* Writes the stage; if a case has several items of this stage, also writes the item, as in "tick 12". */
static void where(const page *p, const json_t *r)
{
    const char *stage = evidence_text(r, "stage");
    page_text(p, stage);
    if (strcmp(stage, "tick") == 0 || strcmp(stage, "collide") == 0 || strcmp(stage, "tool") == 0)
        fprintf(p->to, " %lld", (long long)integer(r, "item"));
}

static void row(const page *p, int number, const json_t *one, const json_t *backend, const json_t *r)
{
    const json_t *voxel = json_object_get(r, "voxel");
    fprintf(p->to, "<tr><td class=\"n\">A%d</td><td><code>", number);
    page_text(p, evidence_text(one, "id"));
    fputs("</code><br>", p->to);
    page_text(p, evidence_text(backend, "what"));
    fputs("</td><td><b>", p->to);
    page_text(p, evidence_text(r, "verdict"));
    fputs("</b></td><td>", p->to);
    where(p, r);
    fputs("</td><td>", p->to);
    if (voxel) {
        json_int_t at[3];
        for (size_t a = 0; a < 3; a++)
            at[a] = json_integer_value(json_array_get(voxel, a));
        page_count(p, integer(r, "different_voxels"));
        const json_int_t size = integer(r, "chunk_size") > 0 ? integer(r, "chunk_size") : 32;
        fprintf(p->to,
                " voxel%s in this record; the first at (%lld, %lld, %lld), chunk (%lld, %lld, %lld) of "
                "%lld<sup>3</sup>: <b>%lld</b>, the reference has <b>%lld</b>",
                integer(r, "different_voxels") == 1 ? "" : "s", (long long)at[0], (long long)at[1], (long long)at[2],
                (long long)(at[0] / size), (long long)(at[1] / size), (long long)(at[2] / size), (long long)size,
                (long long)integer(r, "got"), (long long)integer(r, "reference"));
    } else if (*evidence_text(r, "word")) {
        fputs("reported: ", p->to);
        page_text(p, evidence_text(r, "word"));
        fprintf(p->to, " is <b>%lld</b>; the reference has <b>%lld</b>", (long long)integer(r, "got"),
                (long long)integer(r, "reference"));
        const json_t *chunk = json_object_get(r, "chunk");
        if (chunk)
            fprintf(p->to, "; of chunk (%lld, %lld, %lld) first",
                    (long long)json_integer_value(json_array_get(chunk, 0)),
                    (long long)json_integer_value(json_array_get(chunk, 1)),
                    (long long)json_integer_value(json_array_get(chunk, 2)));
    } else
        page_text(p, evidence_text(r, "text"));
    if (*evidence_text(r, "class")) {
        fputs("<br>Class <b>", p->to);
        page_text(p, evidence_text(r, "class"));
        fputs("</b>: ", p->to);
        page_text(p, evidence_text(r, "class_text"));
        fputs(*evidence_text(r, "class_hint") ? "; " : "", p->to);
        page_text(p, evidence_text(r, "class_hint"));
    }
    fputs("</td></tr>\n", p->to);
}

/* Writes the command that runs the small case. This case shows the same difference as the complete case. */
static void reproduction(const page *p, const json_t *backend, const json_t *r)
{
    const char *file = evidence_text(r, "reproduce");
    if (!reproduce_name_ok(file) || !page_has(p, file))
        return;
    fputs("<p>The reduced case still differs in the same stage and with the same class: ", p->to);
    page_text(p, evidence_text(r, "small_case"));
    fputs(" (", p->to);
    page_link(p, file);
    fputs("). In the folder of this page:</p>\n<pre>osteon validate --case ", p->to);
    page_shell_word(p, file);
    fputs(" --backends ", p->to);
    page_shell_word(p, evidence_text(backend, "name"));
    char *own = strncmp(file, "cases/user-", 11) == 0 ? evidence_own_options(p->protocol, true) : NULL;
    page_text(p, own ? own : "");
    free(own);
    fputs("</pre>\n", p->to);
}

/* Writes the operands from which the reference computed the first voxel that differs. */
static void operand_table(const page *p, const json_t *r)
{
    const json_t *list = json_object_get(r, "operands"), *voxel = json_object_get(r, "voxel");
    if (!json_array_size(list))
        return;
    fprintf(p->to,
            "<p>Operands that decide voxel (%lld, %lld, %lld), computed by the reference. They show how the correct "
            "result comes about, not the error of the other backend:</p>\n"
            "<div class=\"wide\"><table>\n",
            (long long)json_integer_value(json_array_get(voxel, 0)),
            (long long)json_integer_value(json_array_get(voxel, 1)),
            (long long)json_integer_value(json_array_get(voxel, 2)));
    for (size_t i = 0; i < json_array_size(list) && i < LISTED; i++) {
        fputs("<tr><td>", p->to);
        page_text(p, evidence_text(json_array_get(list, i), "name"));
        fputs("</td><td>", p->to);
        page_text(p, evidence_text(json_array_get(list, i), "value"));
        fputs("</td></tr>\n", p->to);
    }
    fputs("</table></div>\n", p->to);
}

/* The number of findings, the number of findings with pictures, and the number of findings with small cases. */
typedef struct totals {
    int found, drawn, small;
} totals;

/* Writes the details of a finding: its reduced case, operands and pictures. A finding that has neither a reduced case
   nor a picture appears only in the table. */
static void detail(const page *p, int number, const json_t *one, size_t s, const json_t *r, totals *n)
{
    static const char *const captions[PICTURE_ROLES] = {"Reference: axial, coronal, sagittal", "Backend", "Difference"};
    char name[PICTURE_NAME];
    picture_name(name, evidence_text(one, "id"), s, PICTURE_DIFFERENCE);
    const bool drawn = page_has(p, name), small = *evidence_text(r, "reproduce") != '\0';
    n->drawn += drawn;
    n->small += small;
    if (!drawn && !small)
        return;
    fprintf(p->to, "<h3>A%d: <code>", number);
    page_text(p, evidence_text(one, "id"));
    fputs("</code>, ", p->to);
    page_text(p, evidence_text(json_array_get(json_object_get(p->protocol, "backends"), s), "what"));
    fputs("</h3>\n", p->to);
    reproduction(p, json_array_get(json_object_get(p->protocol, "backends"), s), r);
    operand_table(p, r);
    for (int role = 0; drawn && role < PICTURE_ROLES; role++) {
        picture_name(name, evidence_text(one, "id"), s, (picture_role)role);
        page_picture(p, name, captions[role]);
    }
}

/* Writes all findings in the order of cases, then backends. They have the same numbers as in anomalies.csv. */
static totals each_finding(const page *p, bool pictures)
{
    const json_t *backends = json_object_get(p->protocol, "backends");
    totals n = {.found = 0};
    for (size_t i = 0; i < json_array_size(p->cases); i++)
        for (size_t s = 1; s < json_array_size(backends); s++) {
            const json_t *one = json_array_get(p->cases, i), *backend = json_array_get(backends, s);
            const json_t *r = json_object_get(json_object_get(one, "results"), evidence_text(backend, "name"));
            if (!is_finding(r))
                continue;
            n.found++;
            if (pictures)
                detail(p, n.found, one, s, r, &n);
            else if (n.found <= LISTED)
                row(p, n.found, one, backend, r);
        }
    return n;
}

void section_differences(const page *p)
{
    fputs("<h2>Differences</h2>\n", p->to);
    const json_t *counts = json_object_get(p->summary, "results");
    const json_int_t found = integer(counts, case_verdict_name(CASE_DIFFERS)) +
                             integer(counts, case_verdict_name(CASE_FAILED)) +
                             integer(counts, case_verdict_name(CASE_CRASHED)) +
                             integer(counts, case_verdict_name(CASE_LATE));
    if (!found) {
        fputs("<p><b>None.</b> All compared results are byte-identical to the reference's.</p>\n<p "
              "class=\"from\">From ",
              p->to);
        page_link(p, "anomalies.csv");
        fputs(", which has only its header line.</p>\n", p->to);
        return;
    }
    fputs("<p>", p->to);
    page_count(p, found);
    fprintf(p->to,
            " result%s from the reference's. For each case, the table shows the first difference in the order of the "
            "stages; later ones may be its consequences. The class of a difference is a fact about its voxels (A "
            "is the reference's grid, B the other's) and only a hint about the cause.</p>\n<table><thead><tr><th "
            "class=\"n\">No.</th><th>Case, backend</th><th>Verdict</th><th>Where</th>"
            "<th>What</th></tr></thead>\n",
            found == 1 ? " differs" : "s differ");
    const int listed = each_finding(p, false).found;
    fputs("</table>\n", p->to);
    if (listed > LISTED)
        fprintf(p->to, "<p>The first %d of %d are listed here.</p>\n", LISTED, listed);
    fputs("<p class=\"from\">All differences, with fields for cause, impact and disposition, are in ", p->to);
    page_link(p, "anomalies.csv");
    fputs("; as values: ", p->to);
    page_link(p, EVIDENCE_CASES);
    fputs(
        ".</p>\n<h2>Each difference</h2>\n"
        "<p>The pictures are axial, coronal and sagittal slices through the position where most voxels differ, in the "
        "first record with differing voxels; a square is a voxel. "
        "<span class=\"key\"><i class=\"a\"></i>striped: solid only in the reference<i class=\"b\"></i>plain: solid "
        "only in the other"
        "<i class=\"c\"></i>barred: different values</span></p>\n<p class=\"from\">Positions and operands are from ",
        p->to);
    page_link(p, EVIDENCE_CASES);
    fputs(".</p>\n", p->to);
    const totals n = each_finding(p, true);
    if (!n.drawn && !n.small)
        fputs("<p>There are no pictures: no voxels differ, or the program was built without pictures.</p>\n", p->to);
    else
        fprintf(p->to,
                "<p>There are pictures of %d of them and reduced cases of %d: of the first differences of each "
                "backend, and "
                "of the first of each stage and class. If only a report differs, there is no picture.</p>\n",
                n.drawn, n.small);
}

/* ------------------------------------------------------------ sensitivity */

static const char *const fault_counts[] = {"injected", "changed", "detected", "localized", "survived"};
static const char *const fault_heads[] = {"made", "changed a result", "detected", "located", "without effect"};
enum { FAULT_COUNTS = sizeof fault_counts / sizeof fault_counts[0] };

static void fault_cells(const page *p, const json_t *o)
{
    for (int i = 0; i < FAULT_COUNTS; i++) {
        fputs("<td class=\"n\">", p->to);
        page_count(p, integer(o, fault_counts[i]));
        fputs("</td>", p->to);
    }
}

static void fault_head(const page *p, const char *first)
{
    fprintf(p->to, "<div class=\"wide\"><table><thead><tr><th>%s</th>", first);
    for (int i = 0; i < FAULT_COUNTS; i++)
        fprintf(p->to, "<th class=\"n\">%s</th>", fault_heads[i]);
    fputs("</tr></thead>\n", p->to);
}

static void fault_row(const page *p, const json_t *kind)
{
    fputs("<tr><td><b>", p->to);
    page_text(p, evidence_text(kind, "name"));
    fputs("</b> (", p->to);
    page_text(p, evidence_text(kind, "stage"));
    fputs(")<br>", p->to);
    page_text(p, evidence_text(kind, "what"));
    fputs("</td>", p->to);
    fault_cells(p, kind);
    fputs("</tr>\n", p->to);
}

static bool fault_missed(const json_t *kind)
{
    return integer(kind, "detected") != integer(kind, "changed") ||
           integer(kind, "localized") != integer(kind, "changed");
}

/* Writes the sums of each stage, in the order in which the stages occur in the list of kinds. Then writes the kinds
   of mistakes that were not always detected and located. */
static void fault_stages(const page *p, const json_t *all, const json_t *kinds)
{
    const size_t count = json_array_size(kinds) < LISTED ? json_array_size(kinds) : LISTED;
    size_t missed = 0;
    fault_head(p, "Mistakes in");
    for (size_t i = 0; i < count; i++) {
        const char *stage = evidence_text(json_array_get(kinds, i), "stage");
        /* the sums are unsigned, because numbers from an untrusted bundle may overflow them */
        uint64_t sum[FAULT_COUNTS] = {0};
        bool first = true;
        size_t alike = 0;
        missed += fault_missed(json_array_get(kinds, i));
        for (size_t k = 0; k < count; k++) {
            const json_t *kind = json_array_get(kinds, k);
            if (strcmp(evidence_text(kind, "stage"), stage) != 0)
                continue;
            first = first && k >= i;
            alike++;
            for (int c = 0; c < FAULT_COUNTS; c++)
                sum[c] += (uint64_t)integer(kind, fault_counts[c]);
        }
        if (!first)
            continue;
        fputs("<tr><td><b>", p->to);
        page_text(p, stage);
        fputs("</b>, ", p->to);
        page_many(p, alike, "kind");
        fputs("</td>", p->to);
        for (int c = 0; c < FAULT_COUNTS; c++) {
            fputs("<td class=\"n\">", p->to);
            page_count(p, (json_int_t)sum[c]);
            fputs("</td>", p->to);
        }
        fputs("</tr>\n", p->to);
    }
    fputs("<tr><td><b>all</b></td>", p->to);
    fault_cells(p, all);
    fputs("</tr></table></div>\n", p->to);
    if (!missed)
        return;
    fputs("<p><b>Not all detected, or not all located:</b></p>\n", p->to);
    fault_head(p, "Mistake");
    for (size_t i = 0; i < count; i++)
        if (fault_missed(json_array_get(kinds, i)))
            fault_row(p, json_array_get(kinds, i));
    fputs("</table></div>\n", p->to);
}

/* Writes every kind of mistake. On a screen the list is hidden until the reader opens it; on paper it is always
   visible. */
static void fault_kinds(const page *p, const json_t *kinds)
{
    char label[64];
    snprintf(label, sizeof label, "Kind by kind: %zu kind%s of mistakes", json_array_size(kinds),
             json_array_size(kinds) == 1 ? "" : "s");
    page_fold_begin(p, "kinds", false, label);
    fault_head(p, "Mistake");
    for (size_t i = 0; i < json_array_size(kinds) && i < LISTED; i++)
        fault_row(p, json_array_get(kinds, i));
    fputs("</table></div>\n", p->to);
    page_fold_end(p);
}

void section_sensitivity(const page *p)
{
    static const char file[] = "sensitivity.json";
    json_t *o = page_json(p, file);
    const json_t *kinds = json_object_get(o, "kinds");
    if (!o)
        return;
    fputs("<h2>Sensitivity proof</h2>\n<p>The second implementation (validation/dense), which is no "
          "backend, was run with deliberate mistakes at random positions, and its results were compared in the same "
          "way. ",
          p->to);
    page_count(p, integer(o, "detected"));
    fputs(" of the ", p->to);
    page_count(p, integer(o, "changed"));
    fputs(" mistakes that changed a result were detected and ", p->to);
    page_count(p, integer(o, "localized"));
    fputs(" located; ", p->to);
    page_count(p, integer(o, "false_alarms"));
    fputs(" false alarms in ", p->to);
    page_count(p, integer(o, "clean_runs"));
    fprintf(p->to, " runs without a mistake. <b>%s</b></p>\n",
            json_is_true(json_object_get(o, "proved")) ? "Every mistake that had an effect was detected and located."
                                                       : "This does not show that mistakes are detected.");
    fault_stages(p, o, kinds);
    fault_kinds(p, kinds);
    fputs("<p class=\"from\">From ", p->to);
    page_link(p, file);
    fputs(", which lists every kind of mistake with its cause and the conditions under which it has no effect.</p>\n",
          p->to);
    json_decref(o);
}
