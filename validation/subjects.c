/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/subjects.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "config.h"

#include "core/isa.h"
#include "validation/dump/dump.h"
#include "validation/worker.h"

static subject *add(subject_list *list, const char *spec, const char *what, ost_error *err)
{
    subject *grown = realloc(list->subjects, ((size_t)list->count + 1) * sizeof *grown);
    if (!grown) {
        ost_fail(err, OST_ERR_MEMORY, "out of memory for a list of backends");
        return NULL;
    }
    list->subjects = grown;
    subject *s = &grown[list->count++];
    *s = (subject){.available = true};
    snprintf(s->spec, sizeof s->spec, "%s", spec);
    snprintf(s->what, sizeof s->what, "%.300s", what);
    return s;
}

static ost_status add_dense(subject_list *list, ost_error *err)
{
    return add(list, SUBJECT_DENSE, "a second implementation, with its own sweep, map, poses and snapping", err)
               ? OST_OK
               : OST_ERR_MEMORY;
}

ost_status subjects_cpu(plan_tier tier, const bool here[], subject_list *list, ost_error *err)
{
    static const int threads[] = {1, 2, 3, 7};
    bool taken[4] = {false};
    int left = 0;
    char spec[SUBJECT_SPEC], what[SUBJECT_REASON];
    for (int i = 0; i < OST_ISA_COUNT; i++)
        left += here[i];
    for (int i = 0, turn = 1; i < OST_ISA_COUNT; i++) {
        if (!here[i])
            continue;
        left--;
        for (int t = 0; t < 4; t++) {
            /* In the smoke tier the instruction sets run alternately with 2, 3 and 7 threads. The last set also runs
               with the counts that no earlier set used. */
            if (tier == PLAN_SMOKE && t != 0 && t != turn && (left > 0 || taken[t]))
                continue;
            taken[t] = true;
            /* In the larger tiers, subjects with 3 or 7 threads start their work items in different orders, with
               pauses. */
            const char *const order = tier == PLAN_SMOKE || t < 2 ? "" : t == 2 ? ",order=1" : ",order=2";
            snprintf(spec, sizeof spec, "cpu:isa=%s,threads=%d%s%s", ost_isa_name((ost_isa)i), threads[t],
                     t ? ",grain=1" : "", order);
            snprintf(what, sizeof what, "CPU, %s, %d thread%s%s", ost_isa_name((ost_isa)i), threads[t],
                     t ? "s that share the smallest work" : "", order[0] ? ", in another order" : "");
            if (!add(list, spec, what, err))
                return OST_ERR_MEMORY;
        }
        turn = turn % 3 + 1;
    }
    if (!add(list, "cpu:threads=3", "CPU, 3 threads that share work from the sizes on that pay", err))
        return OST_ERR_MEMORY;
#if defined HAVE_EMBREE3 || defined HAVE_EMBREE4
    if (!add(list, "cpu:voxelizer=embree,threads=2", "CPU, candidates by Embree's rays", err))
        return OST_ERR_MEMORY;
#endif
    return OST_OK;
}

const char *subjects_isa(int isa)
{
    return isa < OST_ISA_COUNT ? ost_isa_name((ost_isa)isa) : NULL;
}

static ost_status add_cpu(plan_tier tier, subject_list *list, ost_error *err)
{
    bool here[OST_ISA_COUNT];
    for (int i = 0; i < OST_ISA_COUNT; i++)
        here[i] = ost_isa_available((ost_isa)i);
    return subjects_cpu(tier, here, list, err);
}

/* The configurations in which each OpenCL device runs: both kernel sets, and large data in parts (staging). */
static const struct {
    const char *options, *what;
    bool smoke;
} cl_ways[] = {
    {"kernels=cpu", "kernels for CPUs", true},
    {"kernels=gpu", "kernels for GPUs", false},
    {"kernels=cpu,staging=65536", "kernels for CPUs, parts of 64 KiB", false},
    {"kernels=gpu,staging=65536", "kernels for GPUs, parts of 64 KiB", true},
};

const char *subjects_cl_options(plan_tier tier, int n)
{
    for (size_t i = 0; i < sizeof cl_ways / sizeof cl_ways[0]; i++)
        if ((tier != PLAN_SMOKE || cl_ways[i].smoke) && n-- == 0)
            return cl_ways[i].options;
    return NULL;
}

typedef struct device_visit {
    plan_tier tier;
    subject_list *list;
    ost_error *err;
    ost_status status;
    subject *named; /* the subject whose device is searched for; NULL to add all devices */
} device_visit;

/* Adds one subject of a device. `reason` is "" if the subject can run. */
static void add_way(device_visit *v, const ost_device_info *device, const char *spec, const char *what,
                    const char *reason)
{
    subject *s = v->status == OST_OK ? add(v->list, spec, what, v->err) : NULL;
    if (!s) {
        v->status = OST_ERR_MEMORY;
        return;
    }
    s->available = !*reason;
    snprintf(s->device, sizeof s->device, "%s", device->spec);
    snprintf(s->reason, sizeof s->reason, "%.300s", reason);
    v->list->opencl |= s->available;
}

static void add_device(const ost_device_info *device, void *user)
{
    device_visit *v = user;
    char what[SUBJECT_REASON];
    const bool named = device->name && *device->name; /* the entry of a platform without devices has no device name */
    snprintf(what, sizeof what, "OpenCL, %.140s%s%.140s", named ? device->name : "", named ? ", " : "",
             device->platform);
    if (v->named) {
        if (strcmp(v->named->device, device->spec) == 0)
            memcpy(v->named->what, what, sizeof what);
        return;
    }
    if (!device->available)
        add_way(v, device, device->spec, what, device->reason ? device->reason : "");
    for (size_t i = 0; device->available && i < sizeof cl_ways / sizeof cl_ways[0]; i++) {
        char spec[SUBJECT_SPEC], how[SUBJECT_REASON];
        ost_backend *backend = NULL;
        ost_error why = {0};
        if (v->tier == PLAN_SMOKE && !cl_ways[i].smoke)
            continue;
        snprintf(spec, sizeof spec, "%.100s,%s", device->spec, cl_ways[i].options);
        snprintf(how, sizeof how, "%.270s; %s", what, cl_ways[i].what);
        ost_backend_open(spec, &backend, &why);
        ost_backend_close(backend);
        add_way(v, device, spec, how, why.text);
    }
}

/* Stores the name of the opened device. A report must contain this name, and a user's spec such as
   "cl:platform=portable" can match any device. */
static ost_status name_device(int platform, int device, subject *s, ost_error *err)
{
    device_visit v = {.status = OST_OK, .named = s};
    snprintf(s->device, sizeof s->device, "cl:platform=%d,device=%d", platform, device);
    for (int i = 0; i < ost_backend_count(); i++) {
        ost_backend_info info;
        ost_status status = ost_backend_describe(i, &info, err);
        if (status == OST_OK && strcmp(info.name, "cl") == 0)
            status = ost_backend_devices(i, add_device, &v, err);
        if (status != OST_OK)
            return status;
    }
    return OST_OK;
}

static ost_status add_cl(plan_tier tier, subject_list *list, ost_error *err)
{
    for (int i = 0; i < ost_backend_count(); i++) {
        ost_backend_info info;
        ost_status status = ost_backend_describe(i, &info, err);
        if (status != OST_OK)
            return status;
        if (strcmp(info.name, "cl") != 0)
            continue;
        snprintf(list->no_opencl, sizeof list->no_opencl, "%s", info.available ? "no device is usable" : info.reason);
        if (info.available) {
            device_visit v = {.tier = tier, .list = list, .err = err};
            status = ost_backend_devices(i, add_device, &v, err);
            if (status == OST_OK)
                status = v.status;
        }
        return status;
    }
    return OST_OK;
}

/* Opens a backend in a worker that runs no case. If this fails, the error line is the worker's message. */
static ost_status try_apart(const char *spec, ost_error *err)
{
    char program[1024];
    ost_status status = worker_program(program, sizeof program, err);
    if (status != OST_OK)
        return status;
    const char *const words[] = {program,     "validate", "--worker", spec, "--trace",
                                 "/dev/null", "--from",   "1000000",  NULL};
    char *argv[sizeof words / sizeof words[0]];
    for (size_t i = 0; i < sizeof words / sizeof words[0]; i++)
        argv[i] = (char *)(uintptr_t)words[i];
    worker w;
    worker_result end;
    status = worker_start(argv, -1, -1, 60, &w, err);
    if (status == OST_OK)
        status = worker_wait(&w, &end, err);
    if (status != OST_OK || end.end == WORKER_DONE)
        return status;
    if (end.end == WORKER_CRASHED)
        return ost_fail(err, OST_ERR_INPUT, "%.300s: ended by signal %d (%s) when it was opened", spec, end.code,
                        strsignal(end.code));
    if (end.end == WORKER_LATE)
        return ost_fail(err, OST_ERR_INPUT, "%.300s: did not open within a minute", spec);
    static const char prefix[] = "osteon validate: ";
    const char *text = strncmp(end.text, prefix, sizeof prefix - 1) == 0 ? end.text + sizeof prefix - 1 : end.text;
    return ost_fail(err, end.code == 3 ? OST_ERR_UNAVAILABLE : OST_ERR_USAGE, "%s", text);
}

/* Adds one of the user's specs. Opens its backend immediately, so that a mistake in the spec is reported as an error
   and not as a result of the campaign. */
static ost_status add_wanted(plan_tier tier, const char *spec, subject_list *list, ost_error *err)
{
    if (strcmp(spec, "cpu") == 0)
        return add_cpu(tier, list, err);
    if (strcmp(spec, "cl") == 0)
        return add_cl(tier, list, err);
    if (strcmp(spec, "ref") == 0)
        return OST_OK;
    if (strcmp(spec, SUBJECT_DENSE) == 0)
        return add_dense(list, err);
    ost_backend *backend = NULL;
    if (strncmp(spec, SUBJECT_DUMP, strlen(SUBJECT_DUMP)) == 0) {
        dump_head head;
        const ost_status read = dump_read_head(spec + strlen(SUBJECT_DUMP), &head, err);
        char what[SUBJECT_REASON];
        snprintf(what, sizeof what, "grids that were dumped%s%.200s", head.program[0] ? " by " : "", head.program);
        return read != OST_OK ? read : add(list, spec, what, err) ? OST_OK : OST_ERR_MEMORY;
    }
    ost_status status = strncmp(spec, "plugin", 6) == 0 ? try_apart(spec, err) : ost_backend_open(spec, &backend, err);
    if (status != OST_OK && status != OST_ERR_UNAVAILABLE)
        return status;
    const ost_backend_settings on = backend ? ost_backend_settings_get(backend) : (ost_backend_settings){.device = -1};
    ost_backend_close(backend);
    subject *s = add(list, spec, spec, err);
    if (!s)
        return OST_ERR_MEMORY;
    if (status != OST_OK) {
        s->available = false;
        snprintf(s->reason, sizeof s->reason, "%.300s", err->text);
    } else if (strncmp(spec, "cl", 2) == 0)
        list->opencl = true;
    return on.device >= 0 ? name_device(on.platform, on.device, s, err) : OST_OK;
}

ost_status subjects_find(plan_tier tier, const char *wanted, subject_list *out, ost_error *err)
{
    *out = (subject_list){0};
    snprintf(out->no_opencl, sizeof out->no_opencl, "it was not selected");
    ost_status status = add(out, "ref", "the scalar reference", err) ? OST_OK : OST_ERR_MEMORY;
    if (!wanted || strcmp(wanted, "cpu") == 0)
        status = status == OST_OK ? add_dense(out, err) : status;
    if (!wanted) {
        if (status == OST_OK)
            status = add_cpu(tier, out, err);
        if (status == OST_OK)
            status = add_cl(tier, out, err);
    }
    for (const char *at = wanted; at && *at && status == OST_OK;) {
        const size_t length = strcspn(at, ";");
        char spec[SUBJECT_SPEC];
        if (length >= sizeof spec)
            status = ost_fail(err, OST_ERR_USAGE, "--backends: '%.40s...' is too long for a backend's name", at);
        else {
            snprintf(spec, sizeof spec, "%.*s", (int)length, at);
            status = add_wanted(tier, spec, out, err);
        }
        at += length;
        at += *at == ';';
    }
    if (status != OST_OK)
        subjects_free(out);
    return status;
}

void subjects_free(subject_list *list)
{
    free(list->subjects);
    list->subjects = NULL;
    list->count = 0;
}
