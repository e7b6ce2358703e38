/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/report/report.h"

#include <stdlib.h>
#include <string.h>

#include "core/memory_stream.h"
#include "validation/bundle/bundle.h"
#include "validation/bundle/impact.h"
#include "validation/bundle/record.h"
#include "validation/bundle/suite.h"
#include "validation/common/common.h"
#include "validation/report/pictures.h"
#include "validation/report/sections.h"

#define TITLE "Backend equivalence verification report"

/* ------------------------------------------------------------ the verdict */

static json_int_t findings(const page *p)
{
    static const case_verdict bad[] = {CASE_DIFFERS, CASE_FAILED, CASE_CRASHED, CASE_LATE};
    json_int_t n = 0;
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
        n += json_integer_value(json_object_get(json_object_get(p->summary, "results"), case_verdict_name(bad[i])));
    return n;
}

/* Counts the results of a backend: those that are equal, and all others. */
static void tally(const page *p, const char *backend, size_t *equal, size_t *other)
{
    *equal = *other = 0;
    for (size_t i = 0; i < json_array_size(p->cases); i++) {
        const char *is = evidence_text(
            json_object_get(json_object_get(json_array_get(p->cases, i), "results"), backend), "verdict");
        *equal += strcmp(is, case_verdict_name(CASE_EQUAL)) == 0;
        *other += *is && strcmp(is, case_verdict_name(CASE_EQUAL)) != 0 &&
                  strcmp(is, case_verdict_name(CASE_NOT_RUN)) != 0;
    }
}

/* Writes the names of the differing backends, so that the reader does not have to search a table. */
static void who_differs(const page *p)
{
    const json_t *backends = json_object_get(p->protocol, "backends");
    size_t others = 0;
    fputs("<ul>", p->to);
    for (size_t s = 1; s < json_array_size(backends); s++) {
        size_t equal, other;
        tally(p, evidence_text(json_array_get(backends, s), "name"), &equal, &other);
        others += equal && !other;
        if (!other)
            continue;
        fputs("<li><strong>", p->to);
        page_text(p, evidence_text(json_array_get(backends, s), "what"));
        fputs("</strong>: ", p->to);
        page_count(p, (json_int_t)other);
        fputs(" of ", p->to);
        page_many(p, other + equal, "case");
        fputs("</li>", p->to);
    }
    fputs("</ul>", p->to);
    if (others) {
        fputs(others == 1 ? "The other backend is equal in all its cases." : "The other ", p->to);
        if (others > 1) {
            page_many(p, others, "backend");
            fputs(" are equal in all their cases.", p->to);
        }
    }
}

static void verdict(const page *p)
{
    const json_t *counts = json_object_get(p->summary, "results");
    const bool equal = json_is_true(json_object_get(p->summary, "equal")),
               evidence = json_is_true(json_object_get(p->summary, "evidence"));
    const json_int_t same = json_integer_value(json_object_get(counts, case_verdict_name(CASE_EQUAL))),
                     other = findings(p);
    if (other) {
        fputs("<div class=\"verdict differ\"><b>&#10007; NOT EQUAL</b>", p->to);
        fputs("In ", p->to);
        page_count(p, other);
        fputs(" of ", p->to);
        page_many(p, (size_t)(other + same), "result");
        fputs(", the result of a backend differs from the reference's.", p->to);
        who_differs(p);
        if (!evidence)
            fputs(" This was also a reduced run.", p->to);
    } else if (!equal) {
        fputs(json_integer_value(json_object_get(p->summary, "compared"))
                  ? "<div class=\"verdict none\"><b>&#9888; NO VERDICT: NOT EVERYTHING WAS COMPARED</b>No difference "
                    "was found, but cases are missing."
                  : "<div class=\"verdict none\"><b>&#9888; NO VERDICT: NOTHING WAS COMPARED</b>"
                    "No backend other than the reference ran a case that the reference accepted.",
              p->to);
    } else {
        fputs(evidence ? "<div class=\"verdict equal\"><b>&#10003; EQUAL</b>"
                       : "<div class=\"verdict none\"><b>&#9888; REDUCED RUN: NO EVIDENCE</b>",
              p->to);
        fputs(evidence    ? "Every backend's results are byte-identical to the reference's: "
              : same == 1 ? "<strong>Equal in the "
                          : "<strong>Equal in all ",
              p->to);
        page_many(p, (size_t)same, "result");
        fputs(evidence ? ", 0 differing bytes." : same == 1 ? " that was compared" : " that were compared", p->to);
        fputs(evidence ? "" : "</strong>; too little was compared for evidence.", p->to);
    }
    fputs("<br><span class=\"from\">From ", p->to);
    page_link(p, "results.json");
    if (other) {
        fputs(" and ", p->to);
        page_link(p, EVIDENCE_CASES);
    }
    fputs("</span></div>\n", p->to);
}

/* Returns a number from a JSON file of the bundle, or -1. */
static json_int_t number_in(const page *p, const char *file, const char *key)
{
    json_t *o = page_json(p, file);
    const json_int_t n = json_is_integer(json_object_get(o, key)) ? json_integer_value(json_object_get(o, key)) : -1;
    json_decref(o);
    return n;
}

/* Writes the failed tests. A failed test is not a difference between backends, but it is equally important. */
static void suite_failed(const page *p)
{
    const json_int_t failed = number_in(p, SUITE_FILE, "failed");
    if (failed <= 0)
        return;
    fputs("<div class=\"verdict differ\"><b>&#10007; THE TEST SUITE FAILED</b>", p->to);
    page_many(p, (size_t)failed, "test");
    fputs(" that requirements name failed; they are listed <a href=\"#suite\">below</a>.<br><span class=\"from\">From ",
          p->to);
    page_link(p, SUITE_FILE);
    fputs("</span></div>\n", p->to);
}

/* Writes short statements on sensitivity, common mistakes and limits. Each statement has a link to its file. */
static void in_short(const page *p)
{
    const json_int_t kinds = number_in(p, "sensitivity.json", "kinds_total"),
                     kinds_changed = number_in(p, "sensitivity.json", "kinds_changed");
    const json_int_t changed = number_in(p, "sensitivity.json", "changed"),
                     detected = number_in(p, "sensitivity.json", "detected"),
                     alarms = number_in(p, "sensitivity.json", "false_alarms"),
                     passed = number_in(p, COMMON_FILE, "passed"), failed = number_in(p, COMMON_FILE, "failed");
    fputs("<ul>\n", p->to);
    if (changed > 0) {
        fputs("<li>Sensitivity: ", p->to);
        page_count(p, detected);
        fputs(" of ", p->to);
        page_count(p, changed);
        fputs(" deliberate mistakes, made in a second implementation and in no backend, were detected", p->to);
        if (kinds >= 0)
            fprintf(p->to, "; %lld kinds of mistakes were tried, %lld of which changed nothing in this tier",
                    (long long)kinds, (long long)(kinds - kinds_changed));
        fputs("; ", p->to);
        page_many(p, alarms > 0 ? (size_t)alarms : 0, "false alarm");
        fputs(" (", p->to);
        page_link(p, "sensitivity.json");
        fputs(").</li>\n", p->to);
    }
    if (passed >= 0) {
        fprintf(
            p->to,
            "<li>Mistakes that all backends could have in common: the reference passed %lld of %lld checks by hand, "
            "by volume and by law (",
            (long long)passed, (long long)(passed + failed));
        page_link(p, COMMON_FILE);
        fputs(").</li>\n", p->to);
    }
    fprintf(p->to, "<li>Limits: %zu points are not shown; they are listed <a href=\"#not-shown\">below</a> (",
            json_array_size(json_object_get(p->summary, "not_shown")));
    page_link(p, "deviations.csv");
    fputs(").</li>\n</ul>\n", p->to);
}

static void head(const page *p)
{
    const json_t *backends = json_object_get(p->protocol, "backends");
    size_t run = 0;
    for (size_t s = 1; s < json_array_size(backends); s++)
        run += json_is_true(json_object_get(json_array_get(backends, s), "available"));
    fputs("<h1>" TITLE "</h1>\n", p->to);
    verdict(p);
    suite_failed(p);
    in_short(p);
    fputs("<p class=\"scope\">Scope: verification that all backends of osteon compute the same voxels (code "
          "verification). This report is not a clinical validation.</p>\n"
          "<p>osteon simulates the reaming of bone for surgery. The same operation can be computed by different "
          "programs, on processors and graphics cards. "
          "This report states whether their results are bit-identical, for ",
          p->to);
    fputs("<b>", p->to);
    page_many(p, run, "backend");
    fputs("</b> on <b>", p->to);
    page_many(p, json_array_size(p->cases), "case");
    fputs("</b>, against the scalar reference. osteon ", p->to);
    page_text(p, evidence_text(p->protocol, "version"));
    fprintf(p->to, ", arithmetic version %lld; tier ",
            (long long)json_integer_value(json_object_get(p->protocol, "arithmetic")));
    page_text(p, evidence_text(p->protocol, "tier"));
    fputs(", seed ", p->to);
    page_text(p, evidence_text(p->protocol, "seed"));
    fputs(" (", p->to);
    page_link(p, EVIDENCE_PROTOCOL);
    fputs("). The times are in ", p->to);
    page_link(p, "times.json");
    fputs("; the log of all steps is ", p->to);
    page_link(p, "audit.log");
    fputs(".</p>\n", p->to);
}

static void not_shown(const page *p)
{
    const json_t *list = json_object_get(p->summary, "not_shown");
    fputs("<h2 id=\"not-shown\">Not shown</h2>\n<ul>\n", p->to);
    for (size_t i = 0; i < json_array_size(list); i++) {
        const char *text = json_string_value(json_array_get(list, i));
        fputs("<li>", p->to);
        page_text(p, text ? text : "");
        fputs("</li>\n", p->to);
    }
    fputs("</ul>\n<p class=\"from\">From ", p->to);
    page_link(p, "deviations.csv");
    if (page_has(p, KNOWN_ANOMALIES_FILE)) {
        fputs("; known anomalies of this release: ", p->to);
        page_link(p, KNOWN_ANOMALIES_FILE);
    }
    fputs(".</p>\n", p->to);
}

static void operation(const page *p)
{
    fputs("<h2>Pictures</h2>\n", p->to);
    if (!page_has(p, PICTURE_AFTER)) {
        fputs("<p>There are no pictures: the case of the built-in operation was not run, or the program was built "
              "without "
              "pictures.</p>\n",
              p->to);
        return;
    }
    fputs("<p>Case <code>operation/0</code> as the reference computed it: the glenoid of a generated scapula, with a "
          "peg hole drilled into it and its surface reamed. Cut surfaces are coloured by their depth below the uncut "
          "surface; in slices, removed bone is red. The pictures are illustrations; the voxels were "
          "compared.</p>\n<div class=\"pair\">\n",
          p->to);
    page_picture(p, PICTURE_BEFORE, "The bone before");
    page_picture(p, PICTURE_AFTER, "The bone after; cut surfaces are coloured");
    fputs("</div>\n", p->to);
    page_picture(p, PICTURE_SLICES_BEFORE, "Slices before: axial, coronal, sagittal");
    page_picture(p, PICTURE_SLICES_AFTER, "The same slices after; removed bone is red");
    fputs("<p class=\"from\">The digests of the case's input and of its results at every tick are in ", p->to);
    page_link(p, EVIDENCE_CASES);
    fputs(".</p>\n", p->to);
}

/* --------------------------------------------------- checking the bundle */

static void checking(const page *p)
{
    const json_t *shard = json_object_get(p->protocol, "shard");
    fputs("<h2>Verification and repetition</h2>\n<p>To verify this bundle, run in the folder of this page (neither a "
          "network "
          "nor a device is needed):</p>\n"
          "<pre>osteon verify .</pre>\n<p>The command checks every file against ",
          p->to);
    page_link(p, "manifest.json");
    fputs(", the chain of the log, that the protocol was written before the first result, and that this page and all "
          "other derived files follow, byte for byte, from ",
          p->to);
    page_link(p, EVIDENCE_PROTOCOL);
    fputs(", ", p->to);
    page_link(p, EVIDENCE_CASES);
    fputs(" and the pictures. To repeat the campaign, on any machine:</p>\n<pre>osteon validate --tier ", p->to);
    page_shell_word(p, evidence_text(p->protocol, "tier"));
    fputs(" --seed ", p->to);
    page_shell_word(p, evidence_text(p->protocol, "seed"));
    if (json_integer_value(json_array_get(shard, 1)) > 1)
        fprintf(p->to, " --shard %lld/%lld", (long long)json_integer_value(json_array_get(shard, 0)),
                (long long)json_integer_value(json_array_get(shard, 1)));
    if (json_object_get(p->protocol, "case"))
        fputs(" --case case.json", p->to);
    if (*evidence_text(p->protocol, "only")) {
        fputs(" --only ", p->to);
        page_shell_word(p, evidence_text(p->protocol, "only"));
    }
    if (json_is_true(json_object_get(p->protocol, "cpu_only")))
        fputs(" --cpu-only", p->to);
    if (*evidence_text(p->protocol, "chosen")) {
        fputs(" --backends ", p->to);
        page_shell_word(p, evidence_text(p->protocol, "chosen"));
    }
    char *own = evidence_own_options(p->protocol, true);
    page_text(p, own ? own : "");
    free(own);
    fputs(json_object_get(p->protocol, "suite") ? " --with-suite FOLDER" : "", p->to);
    fputs(" --out BUNDLE</pre>\n<p>The same build with the same list of backends gives the same "
          "<code>results_root</code> in ",
          p->to);
    page_link(p, "manifest.json");
    fputs(".</p>\n", p->to);
}

static void signing(const page *p)
{
    fputs("<h2>Tested and reviewed by</h2>\n<div class=\"sign\">\n", p->to);
    for (int i = 0; i < 2; i++)
        fprintf(p->to,
                "<div><b>%s</b><span>Name</span><span>Role</span><span>Date and time "
                "(UTC)</span><span>%s</span><span>Signature</span></div>\n",
                i ? "Reviewer" : "Tester",
                i ? "Meaning: reviewed, and accepted / not accepted" : "Meaning: performed according to the protocol");
    fputs("</div>\n<p class=\"from\">A digital signature signs ", p->to);
    page_link(p, "manifest.json");
    fputs(", which names every other file by its SHA-256: <code>osteon sign . --key KEY --by NAME --meaning "
          "TEXT</code> signs, "
          "and <code>osteon verify . --trust KEYS</code> verifies the signature.</p>\n",
          p->to);
}

static void files(const page *p)
{
    static const struct {
        const char *name, *is;
        bool always;
    } list[] = {
        {EVIDENCE_PROTOCOL, "the plan and the criteria for passing, written before anything ran", true},
        {EVIDENCE_CASES,
         "one line per case: digests of its input and of the reference's results, each backend's digest and verdict",
         true},
        {"results.json", "the verdict and its counts", true},
        {"junit.xml", "the verdicts as a JUnit report", true},
        {"results.tap", "the verdicts as TAP", true},
        {"inputs.csv", "digests of the cases' inputs", true},
        {"anomalies.csv", "the differences, with fields for cause, impact and disposition", true},
        {"margins.csv", "the margins of differing decisions, by case and stage", true},
        {"deviations.csv", "the list of what is not shown", true},
        {"environment.json", "the machine, the system, the program's own digest", true},
        {"times.json", "the time of each backend", true},
        {"audit.log", "every step with its time; each line contains the hash of the previous one", true},
        {"manifest.json", "size and SHA-256 of every file, and two root digests", true},
        {"README.md", "the verdict in a few lines of text", true},
        {"case.json", "the cases that were run, as a file", false},
        {"sensitivity.json", "deliberate mistakes, and how many were detected", false},
        {"common.json", "checks by hand, by volume and by law, for mistakes that all backends could have in common",
         false},
        {"requirements.csv", "requirements, and the tests that verify them", false},
        {"trace.csv", "requirements, tests, results and files, orphans in both directions", false},
        {SUITE_FILE, "the test suite's results, test by test", false},
        {IMPACT_FILE, "the changes since an older bundle, with known possible causes", false},
        {KNOWN_ANOMALIES_FILE, "the known anomalies of this release", false},
        {"devices.json", "the devices, the information of their drivers, and their numeric fingerprints", false},
        {"tools.json", "commit, compiler, flags, and every library that was loaded", false},
        {"sbom.spdx.json", "the same as a bill of materials, SPDX 2.3", false},
        {"soup.csv", "software of unknown provenance: purpose, licence, known limits", false},
        {PICTURE_BEFORE, "the bone before the operation", false},
        {PICTURE_AFTER, "the bone after it", false},
        {PICTURE_SLICES_BEFORE, "slices before", false},
        {PICTURE_SLICES_AFTER, "slices after", false},
    };
    fputs("<h2>Files</h2>\n<table><thead><tr><th>File</th><th>is</th></tr></thead>\n", p->to);
    for (size_t i = 0; i < sizeof list / sizeof list[0]; i++)
        if (list[i].always || page_has(p, list[i].name)) {
            fputs("<tr><td>", p->to);
            page_link(p, list[i].name);
            fputs("</td><td>", p->to);
            page_text(p, list[i].is);
            fputs("</td></tr>\n", p->to);
        }
    fputs("</table>\n", p->to);
}

ost_status report_write(const char *folder, const json_t *protocol, const json_t *cases, evidence_sink *sink,
                        void *user, ost_error *err)
{
    ost_memory_stream made;
    json_t *summary;
    ost_status status = evidence_summary(protocol, cases, &summary, err);
    if (status != OST_OK)
        return status;
    FILE *to = ost_memory_stream_open(&made);
    if (!to) {
        json_decref(summary);
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %s", REPORT_FILE);
    }
    ost_error unread = {0};
    const page p = {to, folder, protocol, cases, summary, &unread};
    page_begin(&p, TITLE);
    head(&p);
    section_machine(&p);
    not_shown(&p); /* what the bundle does not show must be on the first page */
    section_compared(&p);
    if (findings(&p)) { /* differences matter most, so they precede everything else */
        section_differences(&p);
        section_margins(&p);
    }
    section_own_files(&p);
    section_paths(&p);
    section_changes(&p);
    operation(&p);
    section_reference(&p);
    if (!findings(&p))
        section_differences(&p);
    section_sensitivity(&p);
    section_common(&p);
    section_requirements(&p);
    section_suite(&p);
    section_made_with(&p);
    checking(&p);
    signing(&p);
    files(&p);
    page_end(&p);
    status = ost_memory_stream_close(to, &made) ? OST_OK
                                                : ost_fail(err, OST_ERR_MEMORY, "out of memory for %s", REPORT_FILE);
    if (status == OST_OK && unread.status != OST_OK)
        status = ost_fail(err, unread.status, "%s", unread.text);
    if (status == OST_OK)
        status = sink(user, REPORT_FILE, made.bytes, made.size, err);
    free(made.bytes);
    json_decref(summary);
    return status;
}
