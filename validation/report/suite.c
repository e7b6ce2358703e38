/* SPDX-License-Identifier: Apache-2.0 */
/* Writes the results of the test suite (suite.json): the counts, and every test that did not pass. */
#include <stdlib.h>
#include <string.h>

#include "validation/bundle/suite.h"
#include "validation/bundle/trace_table.h"
#include "validation/report/sections.h"

static json_int_t number(const json_t *o, const char *key)
{
    const json_int_t n = json_integer_value(json_object_get(o, key));
    return n > 0 ? n : 0;
}

/* Writes a row for each test with this result. */
static void rows(const page *p, const json_t *tests, const char *result)
{
    for (size_t i = 0; i < json_array_size(tests); i++) {
        const json_t *one = json_array_get(tests, i);
        if (strcmp(evidence_text(one, "result"), result) != 0)
            continue;
        fputs("<tr><td><code>", p->to);
        page_text(p, evidence_text(one, "test"));
        fprintf(p->to, "</code></td><td%s>%s</td><td>", strcmp(result, "failed") == 0 ? " class=\"bad\"" : "",
                strcmp(result, "failed") == 0 ? "&#10007; FAILED" : "skipped");
        page_text(p, evidence_text(one, "reason"));
        fputs("</td></tr>\n", p->to);
    }
}

void section_suite(const page *p)
{
    char *bytes;
    size_t size;
    if (!page_read(p, SUITE_FILE, &bytes, &size))
        return;
    json_t *o = json_loadb(bytes, size, JSON_REJECT_DUPLICATES, NULL);
    const json_t *tests = json_object_get(o, "tests");
    const json_int_t failed = number(o, "failed"), skipped = number(o, "skipped");
    fputs("<h2 id=\"suite\">The test suite</h2>\n<p>The programs that requirements name as their tests were run with "
          "this campaign: ",
          p->to);
    page_count(p, number(o, "passed"));
    fputs(" passed, ", p->to);
    page_count(p, failed);
    fputs(" failed, ", p->to);
    page_count(p, skipped);
    fputs(" were skipped. A skipped test is no evidence.</p>\n", p->to);
    if (failed + skipped) {
        page_fold_begin(p, "suite-tests", failed > 0, "Tests that did not pass");
        fputs("<div class=\"wide\"><table><thead><tr><th>Test</th><th>Result</th><th>Reason</th></tr></thead>\n",
              p->to);
        rows(p, tests, "failed");
        rows(p, tests, "skipped");
        fputs("</table></div>\n", p->to);
        page_fold_end(p);
    }
    fputs("<p class=\"from\">From ", p->to);
    page_link(p, SUITE_FILE);
    fputs("; the tests of each requirement are in ", p->to);
    page_link(p, TRACE_FILE);
    fputs(".</p>\n", p->to);
    json_decref(o);
    free(bytes);
}
