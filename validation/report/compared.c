/* SPDX-License-Identifier: Apache-2.0 */
/* Writes the two tables of the comparison: one of backends and families, and one of the reference's stages. */
#include <string.h>

#include "validation/bundle/evidence.h"
#include "validation/report/sections.h"

static bool in_family(const json_t *one, const char *family)
{
    const char *id = evidence_text(one, "id");
    const size_t n = strlen(family);
    return strncmp(id, family, n) == 0 && id[n] == '/';
}

typedef struct tally {
    json_int_t cases, equal, bad, records;
} tally;

/* Counts the results of one backend in one family, or in all families if `family` is NULL. */
static tally count(const page *p, const char *backend, const char *family)
{
    tally t = {0};
    for (size_t i = 0; i < json_array_size(p->cases); i++) {
        const json_t *one = json_array_get(p->cases, i);
        if (family && !in_family(one, family))
            continue;
        const char *verdict = evidence_text(json_object_get(json_object_get(one, "results"), backend), "verdict");
        t.cases++;
        if (strcmp(verdict, case_verdict_name(CASE_EQUAL)) == 0 && evidence_refused(one))
            continue; /* both refused the input, so there is nothing to compare */
        if (strcmp(verdict, case_verdict_name(CASE_EQUAL)) == 0) {
            t.equal++;
            t.records += (json_int_t)json_array_size(json_object_get(one, "reference"));
        } else
            t.bad += strcmp(verdict, case_verdict_name(CASE_NOT_RUN)) != 0;
    }
    return t;
}

/* Returns true if the bundle has cases of the family, so that the table has a column for it. */
static bool has_cases(const page *p, int family)
{
    return family == PLAN_FAMILIES || count(p, "", plan_family_name((plan_family)family)).cases > 0;
}

static void cell(const page *p, tally t)
{
    if (!t.cases)
        fputs("<td class=\"n no\">none</td>", p->to);
    else if (t.bad)
        fprintf(p->to, "<td class=\"n bad\">%lld of %lld<br>%lld NOT equal</td>", (long long)t.equal,
                (long long)t.cases, (long long)t.bad);
    else
        fprintf(p->to, "<td class=\"n\">%lld of %lld</td>", (long long)t.equal, (long long)t.cases);
}

void section_compared(const page *p)
{
    const json_t *backends = json_object_get(p->protocol, "backends");
    fputs("<h2>Comparison of the backends</h2>\n"
          "<p>A <b>case</b> consists of a bone, tools and a motion, generated or from the user's own files. Each "
          "backend (a "
          "program for one kind of processor) ran each case in its own process. "
          "All its results were compared byte by byte with those of the <b>scalar reference</b>, "
          "a plain, serial program that states the arithmetic. The table contains the numbers of equal cases.</p>\n"
          "<div class=\"wide\"><table><thead><tr><th>Backend, device, driver</th>",
          p->to);
    int columns = 1;
    for (int f = 0; f < PLAN_FAMILIES; f++)
        columns += has_cases(p, f);
    for (int f = 0; f < PLAN_FAMILIES; f++)
        if (has_cases(p, f))
            fprintf(p->to, "<th class=\"n\">%s</th>", plan_family_name((plan_family)f));
    fputs("<th class=\"n\">all cases</th></tr></thead>\n", p->to);
    for (size_t s = 0; s < json_array_size(backends); s++) {
        const json_t *one = json_array_get(backends, s);
        const char *name = evidence_text(one, "name");
        fputs("<tr><td><b>", p->to);
        page_text(p, evidence_text(one, "what"));
        fputs("</b><br><code>", p->to);
        page_text(p, name);
        fputs("</code></td>", p->to);
        if (!json_is_true(json_object_get(one, "available"))) {
            fprintf(p->to, "<td colspan=\"%d\" class=\"no\"><b>not run:</b> ", columns);
            page_text(p, evidence_text(one, "reason"));
            fputs("</td></tr>\n", p->to);
            continue;
        }
        if (s == 0) {
            for (int f = 0; f <= PLAN_FAMILIES; f++)
                if (has_cases(p, f))
                    fprintf(
                        p->to, "<td class=\"n\">%lld</td>",
                        (long long)count(p, name, f < PLAN_FAMILIES ? plan_family_name((plan_family)f) : NULL).cases);
        } else {
            for (int f = 0; f <= PLAN_FAMILIES; f++)
                if (has_cases(p, f))
                    cell(p, count(p, name, f < PLAN_FAMILIES ? plan_family_name((plan_family)f) : NULL));
        }
        fputs("</tr>\n", p->to);
    }
    int printed = 0;
    fputs("</table></div>\n<p>", p->to);
    for (int f = 0; f < PLAN_FAMILIES; f++) {
        if (!has_cases(p, f))
            continue;
        fprintf(p->to, "%s<b>%s</b>: ", printed++ ? "; " : "", plan_family_name((plan_family)f));
        page_text(p, plan_family_about((plan_family)f));
    }
    fputs(".</p>\n<p><b>Criterion for passing</b>, fixed before anything ran: ", p->to);
    page_text(p, evidence_text(p->protocol, "accept"));
    fputs("</p>\n<p class=\"from\">From ", p->to);
    page_link(p, EVIDENCE_PROTOCOL);
    fputs(" (its hash is in ", p->to);
    page_link(p, "audit.log");
    fputs(" before the first result) and ", p->to);
    page_link(p, EVIDENCE_CASES);
    fputs("; for test harnesses, ", p->to);
    page_link(p, "junit.xml");
    fputs(" and ", p->to);
    page_link(p, "results.tap");
    fputs(".</p>\n", p->to);
}

/* Writes dims in the form "230 x 270 x 40". */
static void dims(const page *p, const json_t *list)
{
    for (size_t a = 0; a < 3; a++)
        fprintf(p->to, "%s%lld", a ? " &times; " : "", (long long)json_integer_value(json_array_get(list, a)));
}

static void own_file(const page *p, size_t number, const json_t *f)
{
    fprintf(p->to, "<tr><td class=\"n\">%zu</td><td>", number);
    page_text(p, strcmp(evidence_text(f, "option"), "ct") == 0 ? "CT" : evidence_text(f, "option"));
    if (*evidence_text(f, "builtin")) {
        fputs("</td><td class=\"n\">-</td><td>built in: ", p->to);
        page_text(p, evidence_text(f, "builtin"));
    } else {
        fputs("</td><td class=\"n\">", p->to);
        page_count(p, json_integer_value(json_object_get(f, "bytes")));
        fputs("</td><td><code>", p->to);
        page_text(p, evidence_text(f, "sha256"));
        fputs("</code>", p->to);
    }
    fputs("</td></tr>\n", p->to);
}

static void own_case(const page *p, const json_t *one)
{
    const json_t *spacing = json_object_get(one, "rect_spacing_mm");
    fputs("<li><code>", p->to);
    page_text(p, evidence_text(one, "id"));
    fputs("</code>: ", p->to);
    if (json_object_get(one, "ct")) {
        fprintf(p->to, "CT %lld of ", (long long)json_integer_value(json_object_get(one, "ct")));
        dims(p, json_object_get(one, "rect_dims"));
        fputs(" voxels at ", p->to);
        for (size_t a = 0; a < 3; a++) {
            const char *mm = json_string_value(json_array_get(spacing, a));
            fputs(a ? " &times; " : "", p->to);
            page_text(p, mm ? mm : "?");
        }
        fputs(" mm, resampled to ", p->to);
        dims(p, json_object_get(one, "cubic_dims"));
        fputs(" cubes of ", p->to);
        page_text(p, evidence_text(one, "cubic_mm"));
        fputs(" mm; ", p->to);
    }
    const json_int_t ticks = json_integer_value(json_object_get(one, "ticks"));
    page_many(p, ticks > 0 ? (size_t)ticks : 0, "tick");
    fputs(" of movement</li>\n", p->to);
}

void section_own_files(const page *p)
{
    const json_t *user = json_object_get(p->protocol, "user"), *list = json_object_get(user, "files"),
                 *cases = json_object_get(user, "cases");
    if (!user)
        return;
    fputs("<h2>The user's own files</h2>\n<p>Neither the files nor their names are in this bundle; the SHA-256 "
          "identifies "
          "them.</p>\n"
          "<div class=\"wide\"><table><thead><tr><th class=\"n\">File</th><th>content</th><th "
          "class=\"n\">bytes</th><th>SHA-256</th></tr></thead>\n",
          p->to);
    for (size_t i = 0; i < json_array_size(list); i++)
        own_file(p, i + 1, json_array_get(list, i));
    fputs("</table></div>\n<ul>\n", p->to);
    for (size_t i = 0; i < json_array_size(cases); i++)
        own_case(p, json_array_get(cases, i));
    fputs("</ul>\n<p class=\"from\">From ", p->to);
    page_link(p, "inputs.csv");
    fputs(" and ", p->to);
    page_link(p, EVIDENCE_PROTOCOL);
    fputs(", which also contains the options by which they were read.</p>\n", p->to);
}

void section_reference(const page *p)
{
    static const char *const what[TRACE_STAGES] = {
        [TRACE_RECT] = "the samples of a CT in the rect grid",
        [TRACE_CUBIC] = "the rect grid resampled to cubic voxels",
        [TRACE_RESAMPLE] = "the cubic grid resampled once more, to larger voxels",
        [TRACE_CHUNKS] = "the bone in chunks",
        [TRACE_SNAP] = "a tool's grid and the mesh snapped to it, before voxelization",
        [TRACE_STEPS] =
            "the poses of a tick's event, and the integers that map bone voxels to tool voxels at each pose",
        [TRACE_TOOL] = "a tool's mesh as voxels",
        [TRACE_COLLIDE] = "the collision of a tool with the bone, without removal",
        [TRACE_TICK] = "a tick of an operation: every changed voxel, and the report of the removal",
        [TRACE_SAMPLE] = "densities of single voxels, which forces are computed from, and the occupancy of every chunk",
        [TRACE_UPLOAD] = "a bone made from uploaded slices, some of them uploaded twice",
        [TRACE_FINAL] = "the complete bone at the end",
        [TRACE_FAILED] = "the refusal of a case that must be refused",
    };
    json_int_t records[TRACE_STAGES] = {0}, all = 0;
    for (size_t i = 0; i < json_array_size(p->cases); i++) {
        const json_t *list = json_object_get(json_array_get(p->cases, i), "reference");
        for (size_t k = 0; k < json_array_size(list); k++)
            for (int s = 0; s < TRACE_STAGES; s++)
                if (strcmp(evidence_text(json_array_get(list, k), "stage"), trace_stage_name((trace_stage)s)) == 0) {
                    records[s]++;
                    all++;
                }
    }
    fputs("<h2>Results of the reference</h2>\n<p>", p->to);
    page_many(p, json_array_size(p->cases), "case");
    fputs(" gave ", p->to);
    page_many(p, (size_t)all, "record");
    fputs(". Each record is compared with that of every backend, in the order of the table; cases.jsonl contains the "
          "SHA-256 digests.</p>\n"
          "<table><thead><tr><th>Stage</th><th class=\"n\">records</th><th>is</th></tr></thead>\n",
          p->to);
    for (int s = 0; s < TRACE_STAGES; s++)
        if (records[s]) {
            fprintf(p->to, "<tr><td><b>%s</b></td><td class=\"n\">", trace_stage_name((trace_stage)s));
            page_count(p, records[s]);
            fprintf(p->to, "</td><td>%s</td></tr>\n", what[s] ? what[s] : "");
        }
    fputs("</table>\n<p class=\"from\">Digests of inputs: ", p->to);
    page_link(p, "inputs.csv");
    fputs("; digests of all results: ", p->to);
    page_link(p, EVIDENCE_CASES);
    fputs(".</p>\n", p->to);
}
