/* SPDX-License-Identifier: Apache-2.0 */
/* Writes the sections on mistakes that all backends have in common, on the build and on requirements. */
#include <stdlib.h>
#include <string.h>

#include "validation/bundle/bundle.h"
#include "validation/bundle/devices.h"
#include "validation/bundle/software.h"
#include "validation/bundle/tools.h"
#include "validation/bundle/trace_table.h"
#include "validation/common/common.h"
#include "validation/report/sections.h"

static const char *about_kind(const char *kind)
{
    return strcmp(kind, "golden") == 0 ? "by hand" : strcmp(kind, "volume") == 0 ? "by volume" : "by law";
}

/* Writes the sums in a sentence such as "Passed by hand: 9 of 9; by volume: 4 of 4; by law: 11 of 11." */
static void common_sums(const page *p, const json_t *checks)
{
    static const char *const kinds[] = {"by hand", "by volume", "by law"};
    for (size_t k = 0; k < sizeof kinds / sizeof kinds[0]; k++) {
        size_t all = 0, passed = 0;
        for (size_t i = 0; i < json_array_size(checks); i++) {
            const json_t *one = json_array_get(checks, i);
            const bool its = strcmp(about_kind(evidence_text(one, "kind")), kinds[k]) == 0;
            all += its;
            passed += its && json_is_true(json_object_get(one, "passed"));
        }
        fprintf(p->to, "%s%s: %zu of %zu", k ? "; " : "Passed ", kinds[k], passed, all);
    }
    fputs(".", p->to);
}

void section_common(const page *p)
{
    json_t *o = page_json(p, COMMON_FILE);
    const json_t *checks = json_object_get(o, "checks"), *tests = json_object_get(o, "by_the_tests");
    if (!o)
        return;
    const json_int_t failed = json_integer_value(json_object_get(o, "failed"));
    fputs("<h2>Mistakes that all backends could have in common</h2>\n<p>If every backend made the same mistake, all "
          "results would be equal and wrong. The reference was therefore also compared with results that are known "
          "without a program: small grids computed by hand, bodies whose volume a formula gives, and laws that hold "
          "for all voxels. ",
          p->to);
    fprintf(p->to, "<b>%s</b> ", failed ? "Some checks failed." : "All checks passed.");
    common_sums(p, checks);
    fputs("</p>\n", p->to);
    page_fold_begin(p, "checks", failed, "Check by check");
    fputs("<div class=\"wide\"><table><thead><tr><th>Check</th><th>rule</th><th>expected</th>"
          "<th>result</th><th>&#8203;</th></tr></thead>\n",
          p->to);
    for (size_t i = 0; i < json_array_size(checks); i++) {
        const json_t *one = json_array_get(checks, i);
        const bool passed = json_is_true(json_object_get(one, "passed"));
        fputs("<tr><td><b>", p->to);
        page_text(p, evidence_text(one, "name"));
        fprintf(p->to, "</b><br>%s</td><td>", about_kind(evidence_text(one, "kind")));
        page_text(p, evidence_text(one, "what"));
        fputs("</td><td>", p->to);
        page_text(p, evidence_text(one, "expected"));
        fputs("</td><td>", p->to);
        page_text(p, evidence_text(one, "got"));
        fprintf(p->to, "</td><td%s>%s</td></tr>\n", passed ? "" : " class=\"bad\"",
                passed ? "&#10003;" : "&#10007; FAILED");
    }
    fputs("</table></div>\n", p->to);
    page_fold_end(p);
    fputs("<p><b>Not part of this bundle</b>, because these checks need the source tree and its tests (<code>make "
          "check</code>):</p>\n<ul>\n",
          p->to);
    for (size_t i = 0; i < json_array_size(tests); i++) {
        fputs("<li>", p->to);
        page_text(p, evidence_text(json_array_get(tests, i), "what"));
        fputs(" (<code>", p->to);
        page_text(p, evidence_text(json_array_get(tests, i), "tests"));
        fputs("</code>)</li>\n", p->to);
    }
    fputs("</ul>\n<p class=\"from\">From ", p->to);
    page_link(p, COMMON_FILE);
    fputs(".</p>\n", p->to);
    json_decref(o);
}

/* ---------------------------------------------------- build and machine */

static void device_rows(const page *p)
{
    json_t *o = page_json(p, DEVICES_FILE), *one;
    const json_t *devices = json_object_get(json_object_get(o, "opencl"), "devices");
    size_t i;
    json_array_foreach(devices, i, one) {
        const json_t *says = json_object_get(one, "driver_says");
        fputs("<tr><td>", p->to);
        page_text(p, *evidence_text(one, "name") ? evidence_text(one, "name") : evidence_text(one, "platform"));
        fputs("<br><code>", p->to);
        page_text(p, evidence_text(one, "backend"));
        fputs("</code></td><td>", p->to);
        if (*evidence_text(says, "CL_DEVICE_VERSION")) {
            page_text(p, evidence_text(says, "CL_DEVICE_VERSION"));
            fputs("; ", p->to);
        }
        page_text(p, *evidence_text(one, "fingerprint") ? evidence_text(one, "fingerprint")
                                                        : evidence_text(one, "reason"));
        fputs("</td></tr>\n", p->to);
    }
    json_decref(o);
}

static void row(const page *p, const char *what, const char *text)
{
    if (!*text)
        return;
    fprintf(p->to, "<tr><td>%s</td><td>", what);
    page_text(p, text);
    fputs("</td></tr>\n", p->to);
}

void section_made_with(const page *p)
{
    json_t *o = page_json(p, TOOLS_FILE);
    if (!o)
        return;
    const json_t *build = json_object_get(o, "build"), *program = json_object_get(o, "program");
    fputs("<h2>Made with</h2>\n<div class=\"wide\"><table>\n", p->to);
    if (build) {
        row(p, "Source", evidence_text(build, "commit"));
        row(p, "Compiler", evidence_text(build, "compiler"));
        row(p, "Flags", evidence_text(build, "cflags"));
        row(p, "Program, SHA-256", evidence_text(program, "sha256"));
    } else
        row(p, "Machines", "several, one for each shard; see the files");
    device_rows(p);
    fprintf(
        p->to,
        "</table></div>\n<p>%zu libraries were loaded, drivers included. A device's fingerprint records the results of "
        "its integer and float operations; a device with wrong integer results is refused.</p>\n"
        "<p class=\"from\">From ",
        json_array_size(json_object_get(o, "libraries")));
    page_link(p, TOOLS_FILE);
    fputs(", ", p->to);
    page_link(p, DEVICES_FILE);
    fputs("; as a bill of materials (SPDX): ", p->to);
    page_link(p, SBOM_FILE);
    fputs("; software of unknown provenance, with purpose, licence and known limits: ", p->to);
    page_link(p, SOUP_FILE);
    fputs("; the machine: ", p->to);
    page_link(p, "environment.json");
    fputs(".</p>\n", p->to);
    json_decref(o);
}

/* ---------------------------------------------------------- requirements */

static size_t rows_that_begin(const char *text, const char *begin, const char *also)
{
    size_t n = 0;
    for (const char *at = text; *at;) {
        const size_t length = strcspn(at, "\n");
        if (strncmp(at, begin, strlen(begin)) == 0) {
            const char *found = also ? strstr(at, also) : at;
            n += found && found < at + length;
        }
        at += length + (at[length] == '\n');
    }
    return n;
}

void section_requirements(const page *p)
{
    char *bytes;
    size_t size;
    if (!page_read(p, TRACE_FILE, &bytes, &size))
        return;
    const size_t tested = rows_that_begin(bytes, "requirement,", NULL),
                 shown = tested - rows_that_begin(bytes, "requirement,", "\"not by this bundle");
    const size_t untested = rows_that_begin(bytes, "orphan requirement,", NULL),
                 tests = rows_that_begin(bytes, "orphan test,", NULL),
                 results = rows_that_begin(bytes, "orphan result,", NULL);
    fprintf(p->to,
            "<h2>Requirements</h2>\n<p>Of %zu requirements, %zu have tests, and %zu of these are also supported by "
            "results in this "
            "bundle. Orphans in both directions: "
            "<b>%zu requirements without a test</b>, <b>%zu tests that no requirement names</b>, <b>%zu results that "
            "concern no requirement</b>.</p>\n<p class=\"from\">From ",
            tested + untested, tested, shown, untested, tests, results);
    page_link(p, TRACE_FILE);
    fputs(" (requirement, tests, results, files) and ", p->to);
    page_link(p, REQUIREMENTS_FILE);
    fputs(".</p>\n", p->to);
    free(bytes);
}
