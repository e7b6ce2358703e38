/* SPDX-License-Identifier: Apache-2.0 */
/* Checks that the measured files agree with each other and with the protocol: they must come from one run and one
   build. */
#include "validation/bundle/planned.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "validation/bundle/devices.h"
#include "validation/bundle/environment.h"
#include "validation/bundle/evidence.h"
#include "validation/bundle/faults.h"
#include "validation/bundle/folder.h"
#include "validation/bundle/limits.h"
#include "validation/bundle/tools.h"
#include "validation/bundle/trace_table.h"
#include "validation/common/common.h"
#include "validation/subjects.h"

typedef struct check {
    const char *folder;
    const json_t *protocol;
    bundle_problem *problem;
    void *user;
    int *found;
    json_t *tools, *environment, *devices, *times, *faults, *common;
} check;

static void report(const check *c, const char *file, const char *text)
{
    char plain[400];
    c->problem(c->user, BUNDLE_DIFFERENT, file, limits_printable(text, plain, sizeof plain));
    ++*c->found;
}

static ost_status load(const check *c, const char *name, bool needed, json_t **out, ost_error *err)
{
    ost_error why = {0};
    const ost_status status = bundle_find_json(c->folder, name, out, &why);
    if (status == OST_ERR_INPUT) {
        const char *text = strstr(why.text, name); /* omits the folder's name */
        report(c, name, text ? text + strlen(name) + strspn(text + strlen(name), ": ") : why.text);
        return OST_OK;
    }
    if (status != OST_OK)
        return ost_fail(err, status, "%s", why.text);
    if (!*out && needed) {
        c->problem(c->user, BUNDLE_ABSENT, name, "is missing");
        ++*c->found;
    } else if (*out && !needed)
        report(c, name, "belongs to no bundle of this protocol");
    return OST_OK;
}

static const json_t *backend_named(const check *c, const char *name)
{
    const json_t *backends = json_object_get(c->protocol, "backends");
    for (size_t s = 0; s < json_array_size(backends); s++)
        if (strcmp(evidence_text(json_array_get(backends, s), "name"), name) == 0)
            return json_array_get(backends, s);
    return NULL;
}

static bool all_checked(const check *c)
{
    return !*evidence_text(c->protocol, "chosen");
}

/* ------------------------------------------------------------------ checks */

static void check_program(const check *c)
{
    const json_t *tools, *machine;
    for (size_t t = 0; (tools = evidence_part(c->tools, "program", t)); t++)
        if (strcmp(evidence_text(json_object_get(tools, "program"), "version"),
                   evidence_text(c->protocol, "version")) != 0)
            report(c, TOOLS_FILE, "is of another version of osteon than the protocol");
    for (size_t m = 0; (machine = evidence_part(c->environment, "program_sha256", m)); m++) {
        bool known = false;
        for (size_t t = 0; (tools = evidence_part(c->tools, "program", t)); t++)
            known |= strcmp(evidence_text(json_object_get(tools, "program"), "sha256"),
                            evidence_text(machine, "program_sha256")) == 0;
        if (!known)
            report(c, ENVIRONMENT_FILE, "is of another program than " TOOLS_FILE);
    }
}

static plan_tier tier_of(const json_t *protocol)
{
    int t = 0;
    while (t + 1 < PLAN_TIERS && strcmp(evidence_text(protocol, "tier"), plan_tier_name((plan_tier)t)) != 0)
        t++;
    return (plan_tier)t;
}

static bool has_text(const json_t *list, const char *text)
{
    for (size_t i = 0; i < json_array_size(list); i++) {
        const char *one = json_string_value(json_array_get(list, i));
        if (one && strcmp(one, text) == 0)
            return true;
    }
    return false;
}

/* Reads the instruction set from a name such as "cpu:isa=avx2,...". Returns false if the name contains none. */
static bool isa_of(const char *name, char isa[32])
{
    static const char head[] = "cpu:isa=";
    if (strncmp(name, head, sizeof head - 1) != 0)
        return false;
    snprintf(isa, 32, "%.*s", (int)strcspn(name + sizeof head - 1, ","), name + sizeof head - 1);
    return true;
}

/* Checks that the bundle lists no available backend for an instruction set that the processor lacks. If all backends
   were requested, also checks that there are backends for all instruction sets of the processor. */
static ost_status check_processor(const check *c, const json_t *devices, ost_error *err)
{
    enum { SETS = 64 };
    const json_t *sets = json_object_get(json_object_get(devices, "cpu"), "instruction_sets"),
                 *backends = json_object_get(c->protocol, "backends");
    bool here[SETS] = {false};
    char text[700], isa[32];
    subject_list expected = {0};
    for (int i = 0; i < SETS && subjects_isa(i); i++)
        here[i] = has_text(sets, subjects_isa(i));
    const ost_status status = all_checked(c) ? subjects_cpu(tier_of(c->protocol), here, &expected, err) : OST_OK;
    for (int s = 0; s < expected.count; s++) {
        const char *spec = expected.subjects[s].spec;
        /* Backends that use Embree may be missing, because the bundle may come from a build without Embree. */
        if (backend_named(c, spec) || strstr(spec, "embree"))
            continue;
        snprintf(text, sizeof text, "the processor can run the backend %.200s, and the protocol does not have it",
                 spec);
        report(c, DEVICES_FILE, text);
    }
    subjects_free(&expected);
    for (size_t s = 0; s < json_array_size(backends); s++) {
        const char *name = evidence_text(json_array_get(backends, s), "name");
        if (!isa_of(name, isa) || has_text(sets, isa) ||
            !json_is_true(json_object_get(json_array_get(backends, s), "available")))
            continue;
        snprintf(text, sizeof text, "the processor has no %.30s, and the protocol has the backend %.200s", isa, name);
        report(c, DEVICES_FILE, text);
    }
    return status;
}

/*
 * If the campaign used all backends, checks that the protocol lists all backends of every usable OpenCL device, and
 * that it lists every refused device as not available.
 */
static void check_opencl(const check *c, const json_t *devices)
{
    const json_t *list = json_object_get(json_object_get(devices, "opencl"), "devices");
    const char *options;
    char text[500], spec[SUBJECT_SPEC];
    if (!all_checked(c) || json_is_true(json_object_get(c->protocol, "cpu_only")))
        return;
    for (size_t i = 0; i < json_array_size(list); i++) {
        const json_t *one = json_array_get(list, i);
        const bool usable = json_is_true(json_object_get(one, "usable"));
        for (int n = 0; usable ? (options = subjects_cl_options(tier_of(c->protocol), n)) != NULL : n < 1; n++) {
            snprintf(spec, sizeof spec, "%.120s%s%s", evidence_text(one, "backend"), usable ? "," : "",
                     usable ? options : "");
            const json_t *backend = backend_named(c, spec);
            if (backend && (usable || !json_is_true(json_object_get(backend, "available"))))
                continue;
            snprintf(text, sizeof text, "lists the OpenCL device %.120s as %s, but the protocol %s %.200s",
                     evidence_text(one, "backend"), usable ? "usable" : "refused",
                     backend ? "states the opposite for" : "does not list", spec);
            report(c, DEVICES_FILE, text);
        }
    }
}

static ost_status check_devices(const check *c, ost_error *err)
{
    const json_t *devices;
    ost_status status = OST_OK;
    for (size_t m = 0; status == OST_OK && (devices = evidence_part(c->devices, "cpu", m)); m++) {
        status = check_processor(c, devices, err);
        check_opencl(c, devices);
    }
    return status;
}

/* Checks that there is a running time for every backend of the protocol, and for no other backend. */
static void check_times(const check *c)
{
    const json_t *backends = json_object_get(c->protocol, "backends"), *times;
    for (size_t m = 0; (times = evidence_part(c->times, "seconds", m)); m++) {
        const json_t *seconds = json_object_get(times, "seconds");
        bool same = json_object_size(seconds) == json_array_size(backends);
        for (size_t s = 0; same && s < json_array_size(backends); s++)
            same = json_is_number(json_object_get(seconds, evidence_text(json_array_get(backends, s), "name")));
        if (!same)
            report(c, TIMES_FILE, "has other backends than the protocol");
    }
}

static ost_status check_case_file(const check *c, ost_error *err)
{
    json_t *file = NULL;
    const json_t *given = json_object_get(c->protocol, "case");
    const ost_status status = load(c, "case.json", given != NULL, &file, err);
    if (file && given && !json_equal(file, given))
        report(c, "case.json", "is not the case of the protocol");
    json_decref(file);
    return status;
}

/* Checks that requirements.csv is present. No other check reads this file, because it is neither a JSON file nor a
   derived file. */
static ost_status check_requirements(const check *c, ost_error *err)
{
    ost_file file;
    ost_error why = {0};
    if (folder_open(c->folder, REQUIREMENTS_FILE, &file, &why) == OST_OK) {
        close(file.fd);
        return OST_OK;
    }
    if (!file.absent)
        return ost_fail(err, why.status, "%s", why.text);
    c->problem(c->user, BUNDLE_ABSENT, REQUIREMENTS_FILE, "is missing");
    ++*c->found;
    return OST_OK;
}

ost_status linked_check(const char *folder, const json_t *protocol, bundle_problem *problem, void *user, int *found,
                        ost_error *err)
{
    check c = {.folder = folder, .protocol = protocol, .problem = problem, .user = user, .found = found};
    const bool proof = json_integer_value(json_array_get(json_object_get(protocol, "shard"), 0)) == 1 &&
                       !*evidence_text(protocol, "only") && !json_object_get(protocol, "case");
    ost_status status = load(&c, TOOLS_FILE, true, &c.tools, err);
    if (status == OST_OK)
        status = load(&c, ENVIRONMENT_FILE, true, &c.environment, err);
    if (status == OST_OK)
        status = load(&c, DEVICES_FILE, true, &c.devices, err);
    if (status == OST_OK)
        status = load(&c, TIMES_FILE, true, &c.times, err);
    if (status == OST_OK)
        status = load(&c, COMMON_FILE, true, &c.common, err);
    if (status == OST_OK)
        status = load(&c, FAULTS_FILE, proof, &c.faults, err);
    if (status == OST_OK)
        status = check_case_file(&c, err);
    if (status == OST_OK)
        status = check_requirements(&c, err);
    if (status == OST_OK) {
        check_program(&c);
        check_times(&c);
        status = check_devices(&c, err);
        if (c.faults && strcmp(evidence_text(c.faults, "seed"), evidence_text(protocol, "seed")) != 0)
            report(&c, FAULTS_FILE, "is of another seed than the protocol");
    }
    json_decref(c.tools);
    json_decref(c.environment);
    json_decref(c.devices);
    json_decref(c.times);
    json_decref(c.common);
    json_decref(c.faults);
    return status;
}
