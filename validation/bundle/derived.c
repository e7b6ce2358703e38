/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writes the machine-readable files that are derived from the protocol and the cases. Each file has its own function.
 */
#include "core/memory_stream.h"
#include "validation/bundle/evidence.h"
#include "validation/bundle/csv.h"
#include "validation/margin.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef void derive(FILE *to, const json_t *protocol, const json_t *cases, const json_t *summary);

void evidence_describe(const json_t *result, char text[EVIDENCE_DESCRIPTION])
{
    const json_t *voxel = json_object_get(result, "voxel");
    char location[64] = "";
    if (*evidence_text(result, "stage"))
        snprintf(location, sizeof location, "%.20s %lld: ", evidence_text(result, "stage"),
                 (long long)json_integer_value(json_object_get(result, "item")));
    const long long is = json_integer_value(json_object_get(result, "got")),
                    ref = json_integer_value(json_object_get(result, "reference"));
    if (voxel)
        snprintf(text, EVIDENCE_DESCRIPTION,
                 "%s%lld voxels differ, the first at (%lld, %lld, %lld): %lld where the reference has %lld", location,
                 (long long)json_integer_value(json_object_get(result, "different_voxels")),
                 (long long)json_integer_value(json_array_get(voxel, 0)),
                 (long long)json_integer_value(json_array_get(voxel, 1)),
                 (long long)json_integer_value(json_array_get(voxel, 2)), is, ref);
    else if (*evidence_text(result, "word"))
        snprintf(text, EVIDENCE_DESCRIPTION, "%s%.40s is %lld where the reference has %lld", location,
                 evidence_text(result, "word"), is, ref);
    else
        snprintf(text, EVIDENCE_DESCRIPTION, "%s%.300s", location, evidence_text(result, "text"));
    const size_t used = strlen(text);
    if (*evidence_text(result, "class") && used < EVIDENCE_DESCRIPTION)
        snprintf(text + used, EVIDENCE_DESCRIPTION - used, "; class %.40s (%.160s)",
                 evidence_text(result, "class"), evidence_text(result, "class_text"));
}

static bool is_verdict(const json_t *result, case_verdict verdict)
{
    return strcmp(evidence_text(result, "verdict"), case_verdict_name(verdict)) == 0;
}

/* Returns the result of a backend in case i. */
static const json_t *result_at(const json_t *cases, size_t i, const json_t *backend)
{
    return json_object_get(json_object_get(json_array_get(cases, i), "results"), evidence_text(backend, "name"));
}

const char *evidence_skipped(const json_t *one, const json_t *r, const json_t *backend)
{
    if (is_verdict(r, CASE_NOT_RUN))
        return evidence_text(backend, "reason");
    return is_verdict(r, CASE_EQUAL) && evidence_refused(one)
               ? "the reference refused this input, and so did the backend"
               : NULL;
}

static bool compared_nothing(const json_t *summary)
{
    return json_integer_value(json_object_get(summary, "compared")) == 0;
}

static void tap(FILE *to, const json_t *protocol, const json_t *cases, const json_t *summary)
{
    const json_t *backends = json_object_get(protocol, "backends");
    size_t number = 1;
    char text[EVIDENCE_DESCRIPTION];
    const size_t results = json_array_size(backends) ? json_array_size(cases) * (json_array_size(backends) - 1) : 0;
    fprintf(to, "TAP version 13\n1..%zu\n", results + compared_nothing(summary));
    if (compared_nothing(summary))
        fprintf(to, "not ok %zu - something was compared\n# " EVIDENCE_NOTHING "\n", number++);
    for (size_t s = 1; s < json_array_size(backends); s++)
        for (size_t i = 0; i < json_array_size(cases); i++) {
            const json_t *backend = json_array_get(backends, s), *r = result_at(cases, i, backend);
            const bool equal = is_verdict(r, CASE_EQUAL);
            const char *skip = !evidence_skipped(json_array_get(cases, i), r, backend) ? NULL
                               : equal ? " # SKIP the reference refused this input, and so did the backend"
                                       : " # SKIP not available here";
            fprintf(to, "%s %zu - %s on %s%s\n", skip || equal ? "ok" : "not ok", number++,
                    evidence_text(json_array_get(cases, i), "id"), evidence_text(backend, "name"), skip ? skip : "");
            if (!skip && !equal) {
                evidence_describe(r, text);
                fprintf(to, "# %s\n", text);
            }
        }
}

static void inputs(FILE *to, const json_t *protocol, const json_t *cases, const json_t *summary)
{
    const json_t *files = json_object_get(json_object_get(protocol, "user"), "files");
    (void)summary;
    fputs("input,sha256,bytes,what\n", to);
    for (size_t i = 0; i < json_array_size(cases); i++) {
        put_csv(to, evidence_text(json_array_get(cases, i), "id"), ',');
        put_csv(to, evidence_text(json_array_get(cases, i), "input_sha256"), ',');
        fputs(",\"the case's integers\"\n", to);
    }
    /* The user's own files are listed by number, because the name of a file may identify a patient. */
    for (size_t i = 0; i < json_array_size(files); i++) {
        const json_t *f = json_array_get(files, i);
        char text[64];
        if (*evidence_text(f, "builtin"))
            continue;
        snprintf(text, sizeof text, "file %zu", i + 1);
        put_csv(to, text, ',');
        put_csv(to, evidence_text(f, "sha256"), ',');
        fprintf(to, "%lld,", (long long)json_integer_value(json_object_get(f, "bytes")));
        snprintf(text, sizeof text, "a file given with --%.20s", evidence_text(f, "option"));
        put_csv(to, text, '\n');
    }
}

static void anomalies(FILE *to, const json_t *protocol, const json_t *cases, const json_t *summary)
{
    const json_t *backends = json_object_get(protocol, "backends");
    int number = 1;
    char text[EVIDENCE_DESCRIPTION];
    (void)summary;
    fputs("id,case,backend,verdict,description,root_cause,impact,disposition\n", to);
    for (size_t i = 0; i < json_array_size(cases); i++)
        for (size_t s = 1; s < json_array_size(backends); s++) {
            const json_t *backend = json_array_get(backends, s), *r = result_at(cases, i, backend);
            if (is_verdict(r, CASE_NOT_RUN) || is_verdict(r, CASE_EQUAL))
                continue;
            evidence_describe(r, text);
            fprintf(to, "A%d,", number++);
            put_csv(to, evidence_text(json_array_get(cases, i), "id"), ',');
            put_csv(to, evidence_text(backend, "name"), ',');
            put_csv(to, evidence_text(r, "verdict"), ',');
            put_csv(to, text, ',');
            fputs("to be found,to be judged,open\n", to);
        }
}

static void deviations(FILE *to, const json_t *protocol, const json_t *cases, const json_t *summary)
{
    const json_t *list = json_object_get(summary, "not_shown");
    (void)protocol;
    (void)cases;
    fputs("id,what was not shown\n", to);
    for (size_t i = 0; i < json_array_size(list); i++) {
        fprintf(to, "D%zu,", i + 1);
        put_csv(to, json_string_value(json_array_get(list, i)), '\n');
    }
}

static void results(FILE *to, const json_t *protocol, const json_t *cases, const json_t *summary)
{
    (void)protocol;
    (void)cases;
    json_dumpf(summary, to, JSON_SORT_KEYS | JSON_INDENT(1));
    fputc('\n', to);
}

static void readme(FILE *to, const json_t *protocol, const json_t *cases, const json_t *summary)
{
    const json_t *shard = json_object_get(protocol, "shard"), *list = json_object_get(summary, "not_shown");
    fprintf(to, "# Backend equivalence verification: %s\n\n", evidence_text(summary, "verdict"));
    fprintf(to,
            "osteon %s, arithmetic %lld, tier %s, seed %s: %zu case%s on %zu backend%s, each compared with the scalar "
            "reference byte by byte.\n\n",
            evidence_text(protocol, "version"), (long long)json_integer_value(json_object_get(protocol, "arithmetic")),
            evidence_text(protocol, "tier"), evidence_text(protocol, "seed"), json_array_size(cases),
            json_array_size(cases) == 1 ? "" : "s", json_array_size(json_object_get(protocol, "backends")),
            json_array_size(json_object_get(protocol, "backends")) == 1 ? "" : "s");
    if (!json_is_true(json_object_get(summary, "evidence")))
        fputs("**This is a reduced run; it is not evidence.**\n\n", to);
    fputs("Not shown:\n\n", to);
    for (size_t i = 0; i < json_array_size(list); i++)
        fprintf(to, "- %s\n", json_string_value(json_array_get(list, i)));
    char *files = evidence_own_options(protocol, false), *own = evidence_own_options(protocol, true);
    fprintf(
        to,
        "\n## Verify this bundle\n\nNeither a network nor a device is needed.\n\n```\nosteon verify .            # "
        "every hash, every derived file\nosteon verify "
        ". --rerun%s    # also computes the reference's results again; --backend NAME: and those of a backend\n```\n\n",
        files ? files : "");
    if (files && *files)
        fputs("FILE stands for the user's own files, which are not in this bundle; inputs.csv has their sizes and "
              "SHA-256.\n\n",
              to);
    fputs("## Repeat the campaign\n\n```\n", to);
    fprintf(to, "osteon validate --tier %s --seed %s", evidence_text(protocol, "tier"),
            evidence_text(protocol, "seed"));
    if (json_integer_value(json_array_get(shard, 1)) > 1)
        fprintf(to, " --shard %lld/%lld", (long long)json_integer_value(json_array_get(shard, 0)),
                (long long)json_integer_value(json_array_get(shard, 1)));
    if (json_object_get(protocol, "case"))
        fputs(" --case case.json", to);
    if (*evidence_text(protocol, "only"))
        fprintf(to, " --only %s", evidence_text(protocol, "only"));
    if (json_is_true(json_object_get(protocol, "cpu_only")))
        fputs(" --cpu-only", to);
    if (*evidence_text(protocol, "chosen"))
        fprintf(to, " --backends '%s'", evidence_text(protocol, "chosen"));
    fputs(own ? own : "", to);
    fputs(json_object_get(protocol, "suite") ? " --with-suite FOLDER" : "", to);
    free(files);
    free(own);
    fputs(" --out BUNDLE\n```\n\nThe same build with the same list of backends gives the same `results_root` in "
          "manifest.json.\n\n",
          to);
    fputs(
        "## Files\n\n"
        "| file | content |\n|---|---|\n"
        "| protocol.json | the plan and the criteria for passing, written before anything ran (its hash is in the "
        "first "
        "lines of audit.log) |\n"
        "| cases.jsonl | one line per case: the digest of its input, the digests of the reference's results, the "
        "digest "
        "of each backend's results, and the verdict that follows from them |\n"
        "| results.json, junit.xml, results.tap | the verdicts |\n"
        "| inputs.csv, anomalies.csv, margins.csv, deviations.csv | digests of the inputs; the differences; the margin "
        "of each differing decision; what was not shown |\n"
        "| sensitivity.json | deliberate mistakes, made in a second implementation (validation/dense) and in no "
        "backend, "
        "and the number of them that the comparison detected; kinds_silent lists the kinds that changed nothing in "
        "this tier (in a sharded campaign, the first shard makes this file) |\n"
        "| common.json | checks of the reference by hand, by volume and by law, for mistakes that all backends could "
        "have "
        "in common |\n"
        "| requirements.csv, trace.csv | the requirements, their tests, and the parts of this bundle that concern "
        "them; "
        "orphans in both directions |\n"
        "| suite.json | with --with-suite: the result of each test that a requirement names, and the digest of its "
        "output |\n"
        "| known-anomalies.csv | the known anomalies of this release |\n"
        "| devices.json | OpenCL devices: the information of their drivers, and their numeric fingerprints |\n"
        "| tools.json | commit, compiler, flags, and the SHA-256 of every library that was loaded |\n"
        "| sbom.spdx.json, soup.csv | the same as a bill of materials (SPDX 2.3) and as a list of software of unknown "
        "provenance |\n"
        "| environment.json, times.json, audit.log | the machine, the times, and a log of every step |\n"
        "| report.html, pictures/ | the same content as one page for people, and its pictures |\n"
        "| manifest.json | size and SHA-256 of every file, and two roots |\n"
        "| signatures/ | signatures over manifest.json (`osteon sign`); manifest.json does not list them |\n\n"
        "## Files that differ from run to run\n\n"
        "Two runs of one build on one machine give byte-identical files, except these:\n\n"
        "| file | run-dependent content |\n|---|---|\n"
        "| audit.log | the time of each step, and the digests of the files in this table |\n"
        "| times.json | the begin and the duration of each backend's runs |\n"
        "| environment.json | the kernel and the environment variables of the run; after a merge, those of each shard "
        "|\n"
        "| junit.xml | the times and the host |\n"
        "| report.html | the date, the machine and the threads of the run |\n"
        "| manifest.json | the digests of these files, and `root` over all files |\n"
        "| suite.json, trace.csv | with --with-suite: the results and the times of the tests |\n"
        "| signatures/ | the signers and the times of signing |\n\n"
        "`results_root` covers none of these files, none that depend on the machine and its drivers (tools.json, "
        "devices.json, sbom.spdx.json, soup.csv), and not impact.json, which concerns an older bundle. "
        "The other files depend only on the cases, the code and the list of backends, so two machines with the same "
        "list have the same `results_root`. "
        "Merging the bundles of shards gives the bundle of a single run, with the same exceptions.\n",
        to);
}

/* For each result that differs from the reference, writes one line for each stage that has margins. */
static void margins_csv(FILE *to, const json_t *protocol, const json_t *cases, const json_t *summary)
{
    static const char *const keys[] = {"records",     "reports",    "voxels",  "inherited", "below_threshold",
                                       "unexplained", "unmeasured", "decided", "max_2_20"};
    (void)protocol;
    (void)summary;
    fputs("case,backend,stage", to);
    for (size_t k = 0; k < sizeof keys / sizeof keys[0]; k++)
        fprintf(to, ",%s", keys[k]);
    fputs(",unit,at_0", to);
    for (int b = 1; b < MARGIN_BINS; b++)
        fprintf(to, b < MARGIN_BINS - 1 ? ",below_%d" : ",more", 1 << b);
    fputc('\n', to);
    for (size_t i = 0; i < json_array_size(cases); i++) {
        const json_t *one = json_array_get(cases, i);
        const char *backend;
        json_t *result;
        json_object_foreach(json_object_get(one, "results"), backend, result)
            for (size_t k = 0; k < json_array_size(json_object_get(result, "margins")); k++) {
            const json_t *m = json_array_get(json_object_get(result, "margins"), k), *bins = json_object_get(m, "bins");
            fprintf(to, "%s,\"%s\",%s", evidence_text(one, "id"), backend, evidence_text(m, "stage"));
            for (size_t x = 0; x < sizeof keys / sizeof keys[0]; x++)
                fprintf(to, ",%lld", (long long)json_integer_value(json_object_get(m, keys[x])));
            fprintf(to, ",2^-20 %s", evidence_text(m, "unit"));
            for (size_t b = 0; b < json_array_size(bins); b++)
                fprintf(to, ",%lld", (long long)json_integer_value(json_array_get(bins, b)));
            fputc('\n', to);
            }
    }
}

static const struct {
    const char *name;
    derive *make;
} derived[] = {{"README.md", readme},         {"results.json", results},    {"results.tap", tap},
               {"inputs.csv", inputs},        {"anomalies.csv", anomalies}, {"margins.csv", margins_csv},
               {"deviations.csv", deviations}};

static ost_status write_one(const char *name, derive *make, const json_t *protocol, const json_t *cases,
                            const json_t *summary, evidence_sink *sink, void *user, ost_error *err)
{
    ost_memory_stream made;
    FILE *to = ost_memory_stream_open(&made);
    if (!to)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %s", name);
    make(to, protocol, cases, summary);
    if (!ost_memory_stream_close(to, &made))
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %s", name);
    const ost_status status = sink(user, name, made.bytes, made.size, err);
    free(made.bytes);
    return status;
}

static void case_lines(FILE *to, const json_t *protocol, const json_t *cases, const json_t *summary)
{
    (void)protocol;
    (void)summary;
    for (size_t i = 0; i < json_array_size(cases); i++) {
        json_dumpf(json_array_get(cases, i), to, JSON_SORT_KEYS | JSON_COMPACT);
        fputc('\n', to);
    }
}

static void protocol_text(FILE *to, const json_t *protocol, const json_t *cases, const json_t *summary)
{
    (void)cases;
    (void)summary;
    json_dumpf(protocol, to, JSON_SORT_KEYS | JSON_INDENT(1));
    fputc('\n', to);
}

ost_status evidence_write(const json_t *protocol, const json_t *cases, evidence_sink *sink, void *user, ost_error *err)
{
    json_t *summary;
    ost_status status = evidence_summary(protocol, cases, &summary, err);
    if (status == OST_OK)
        status = write_one(EVIDENCE_PROTOCOL, protocol_text, protocol, cases, summary, sink, user, err);
    if (status == OST_OK)
        status = write_one(EVIDENCE_CASES, case_lines, protocol, cases, summary, sink, user, err);
    for (size_t i = 0; i < sizeof derived / sizeof derived[0] && status == OST_OK; i++)
        status = write_one(derived[i].name, derived[i].make, protocol, cases, summary, sink, user, err);
    json_decref(summary);
    return status;
}
