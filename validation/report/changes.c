/* SPDX-License-Identifier: Apache-2.0 */
/* Writes the section about changes since an older bundle (impact.json) and their possible causes. */
#include <string.h>

#include "validation/bundle/impact.h"
#include "validation/report/sections.h"

static void rows(const page *p, const json_t *list, const char *kind)
{
    for (size_t i = 0; i < json_array_size(list); i++) {
        const json_t *one = json_array_get(list, i);
        fprintf(p->to, "<tr><td>%s</td><td>", kind);
        page_text(p, evidence_text(one, "what"));
        fputs("</td><td>", p->to);
        page_text(p, evidence_text(one, "old"));
        fputs("</td><td>", p->to);
        page_text(p, evidence_text(one, "new"));
        fputs("</td></tr>\n", p->to);
    }
}

/* Writes the identifiers of changed requirements; impact.json contains their complete rows. */
static void requirements(const page *p, const json_t *list)
{
    for (size_t i = 0; i < json_array_size(list); i++) {
        const json_t *one = json_array_get(list, i);
        const bool new = strcmp(evidence_text(one, "old"), "absent") == 0,
                   gone = strcmp(evidence_text(one, "new"), "absent") == 0;
        fputs("<tr><td>requirement</td><td>", p->to);
        page_text(p, evidence_text(one, "what"));
        fprintf(p->to, "</td><td>%s</td><td>%s</td></tr>\n", new ? "absent" : "present",
                new    ? "present"
                : gone ? "absent"
                       : "changed text or tests");
    }
}

static void counts(const page *p, const json_t *o)
{
    const json_t *results = json_object_get(o, "results");
    const json_int_t compared = json_integer_value(json_object_get(results, "compared")),
                     different = json_integer_value(json_object_get(results, "different_cases"));
    fputs("<p>", p->to);
    page_many(p, compared > 0 ? (size_t)compared : 0, "case");
    fputs(" compared by the digests of the reference's results: ", p->to);
    page_count(p, different);
    fputs(" different; ", p->to);
    page_many(p, json_array_size(json_object_get(results, "not_compared")), "case");
    fputs(" not compared; ", p->to);
    page_many(p, json_array_size(json_object_get(o, "verdicts")), "verdict");
    fputs(" of backends changed. Conclusion: <b>", p->to);
    page_text(p, evidence_text(o, "conclusion"));
    fputs("</b>.</p>\n", p->to);
}

void section_changes(const page *p)
{
    json_t *o = page_json(p, IMPACT_FILE);
    if (!o)
        return;
    fputs("<h2>Changes since an older bundle</h2>\n", p->to);
    counts(p, o);
    fputs("<table class=\"changes\"><thead><tr><th>Changed</th><th>item</th><th>before</th><th>now</th></tr></thead>\n",
          p->to);
    rows(p, json_object_get(o, "causes"), "run");
    rows(p, json_object_get(o, "libraries"), "library");
    rows(p, json_object_get(o, "devices"), "device");
    requirements(p, json_object_get(o, "requirements"));
    fputs("</table>\n<p class=\"from\">From ", p->to);
    page_link(p, IMPACT_FILE);
    fputs(", which contains the root of the older bundle, and each case.</p>\n", p->to);
    json_decref(o);
}
