/* SPDX-License-Identifier: Apache-2.0 */
/* Runs the task that the options of `osteon validate` select, on the selected cases. */
#include "app/validate/validate.h"

#include <unistd.h>

#include "app/common/print.h"
#include "app/common/result.h"
#include "validation/dump/dump.h"
#include "validation/export.h"
#include "validation/locate/case_file.h"
#include "validation/scratch.h"
#include "validation/worker.h"

/* Writes the results of one backend to a trace, and then converts the trace to the files of a dump. */
static ost_status dump_worker(const plan *p, const char *spec, const char *folder, ost_error *err)
{
    char path[SCRATCH_NAME];
    trace t = {0};
    int fd;
    ost_status status = scratch_file(&fd, err);
    if (status != OST_OK)
        return status;
    scratch_name(fd, path);
    status = worker_run(p, 0, p->count, spec, path, NULL, err);
    if (status == OST_OK)
        status = trace_open(path, &t, err);
    if (status == OST_OK)
        status = dump_write(folder, spec, p, &t, err);
    trace_free(&t);
    close(fd);
    return status;
}

/* Runs the task on the cases of the plan. `from_file` contains the cases of --case, or is NULL. */
static ost_status run_task(app_state *app, const validate_args *args, const plan *p, json_t *from_file, ost_error *err)
{
    ost_status status;
    if (args->export_to)
        status = export_cases(args->export_to, p, err);
    else if (args->dump)
        status = dump_worker(p, args->worker, args->dump, err);
    else if (args->worker)
        status = worker_run(p, (int)args->from, args->to ? (int)args->to : p->count, args->worker, args->trace,
                            args->given, err);
    else
        status = validate_run(app, args, p, from_file, err);
    if (status == OST_OK && args->export_to) {
        print_line(app, "%s: inputs of %d case%s", args->export_to, p->count, p->count == 1 ? "" : "s");
        put_text(app->result, "out", args->export_to);
        put_integer(app->result, "cases", p->count);
    }
    return status;
}

ost_status validate_task(app_state *app, validate_args *args, int argc, char **argv, ost_error *err)
{
    static const int64_t limits[PLAN_TIERS] = {120, 1800, 36000};
    enum { LIMIT_OWN = 36000 }; /* ten hours, because the user's own cases may take any length of time */
    ost_status status;
    if (args->sign && (status = sign_key_open(args->sign, args->passphrase, &args->key, err)) != OST_OK)
        return status;
    if (args->merge) {
        status = validate_merge(app, args, err);
        sign_key_free(args->key);
        return status;
    }
    plan p;
    user_store *store = NULL;
    json_t *from_file = NULL;
    status = args->from_parent ? user_store_open(WORKER_USER, &store, err)
                              : user_files_of(app, &args->own, argc, argv, &store, &args->record, err);
    const plan_user own = {.count = user_store_count(store), .store = store};
    if (!args->limit_s)
        args->limit_s = own.count ? LIMIT_OWN : limits[args->tier];
    if (status == OST_OK)
        status = args->case_file ? case_file_read(args->case_file, own.count ? &own : NULL, &p, &from_file, err)
                                 : plan_make((plan_tier)args->tier, (uint64_t)args->seed, args->shard_index,
                                             args->shard_count, args->only, &own, &p, err);
    if (status != OST_OK) {
        json_decref(args->record);
        sign_key_free(args->key);
        user_store_free(store);
        return status;
    }
    status = run_task(app, args, &p, from_file, err);
    plan_free(&p);
    json_decref(from_file);
    json_decref(args->record);
    sign_key_free(args->key);
    user_store_free(store);
    return status;
}
