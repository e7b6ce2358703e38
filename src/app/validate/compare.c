/* SPDX-License-Identifier: Apache-2.0 */
#include "app/validate/compare.h"

#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "app/common/progress.h"
#include "validation/dump/dump.h"

static void show(void *user, const char *what, double share)
{
    (void)user;
    progress_show(NULL, what, share);
}

/* Returns true if the text up to the first ':' is the name of a backend. */
static bool is_backend(const char *spec)
{
    ost_backend_info info;
    for (int i = 0; i < ost_backend_count(); i++)
        if (ost_backend_describe(i, &info, NULL) == OST_OK && spec_is(spec, info.name))
            return true;
    return spec_is(spec, SUBJECT_DENSE);
}

/*
 * Finds the subject to compare. If the name is a folder, the subject is a dump, whose header contains the tier and
 * the seed of its campaign. Any other name denotes a backend.
 */
static ost_status find_subject(const app_state *app, compare_args *args, char spec[SUBJECT_SPEC], char only[PLAN_ID],
                               ost_error *err)
{
    struct stat info;
    dump_head head;
    const bool folder = stat(args->subject_spec, &info) == 0 && S_ISDIR(info.st_mode);
    const int n = snprintf(spec, SUBJECT_SPEC, "%s%s", folder ? SUBJECT_DUMP : "", args->subject_spec);
    if (n < 0 || n >= SUBJECT_SPEC || strchr(args->subject_spec, ';'))
        return usage_error(app, err, "'%.60s': expected one folder or one backend, shorter than %d bytes and without "
                           "a semicolon", args->subject_spec, SUBJECT_SPEC);
    if (strncmp(spec, SUBJECT_DUMP, strlen(SUBJECT_DUMP)) != 0) {
        if (!is_backend(spec))
            return ost_fail(err, OST_ERR_USAGE, "%s: neither a folder of dumps nor a backend; 'osteon devices' lists "
                            "the backends", spec);
        return OST_OK;
    }
    const ost_status status = dump_read_head(spec + strlen(SUBJECT_DUMP), &head, err);
    if (status != OST_OK)
        return status;
    if (args->apart)
        return usage_error(app, err, "--apart needs a backend that runs now, not a dump");
    if (args->tier_given || args->seed_given)
        return usage_error(app, err, "--tier and --seed cannot be combined with a dump: dump.json states them");
    args->tier = (int)head.tier;
    args->seed = (int64_t)head.seed;
    memcpy(only, head.only, sizeof head.only);
    if (!args->only && only[0])
        args->only = only;
    return OST_OK;
}

ost_status compare_run(app_state *app, const compare_args *given, int argc, char **argv, ost_error *err)
{
    compare_args args = *given; /* find_subject sets the tier, the seed and the cases of a dump */
    char spec[SUBJECT_SPEC], only[PLAN_ID], program[1024];
    plan p = {.count = 0};
    subject_list subjects = {.count = 0};
    campaign run = {.plan = NULL};
    ost_status status = find_subject(app, &args, spec, only, err);
    if (status != OST_OK)
        return status;
    const ssize_t n = readlink("/proc/self/exe", program, sizeof program - 1);
    if (n < 0)
        return ost_fail(err, OST_ERR_IO, "/proc/self/exe cannot be read");
    program[n] = '\0';
    user_store *store = NULL;
    json_t *record = NULL;
    status = user_files_of(app, &args.own, argc, argv, &store, &record, err);
    const plan_user own = {.count = user_store_count(store), .store = store};
    if (status == OST_OK)
        status = plan_make((plan_tier)args.tier, (uint64_t)args.seed, 1, 1, args.only, &own, &p, err);
    if (status == OST_OK)
        status = subjects_find(p.tier, spec, &subjects, err);
    if (status == OST_OK && subjects.count > 1 && !subjects.subjects[1].available)
        status = ost_fail(err, OST_ERR_UNAVAILABLE, "%s", subjects.subjects[1].reason);
    if (status == OST_OK) {
        const campaign_options how = {
            .program = program, .limit_s = (double)args.limit_s, .apart = args.apart, .show = show};
        status = campaign_run(&p, &subjects, &how, &run, err);
        progress_end();
    }
    if (status == OST_OK)
        status = compare_report(app, &run, args.apart, err);
    if (run.plan)
        campaign_free(&run);
    subjects_free(&subjects);
    plan_free(&p);
    json_decref(record);
    user_store_free(store);
    return status;
}
