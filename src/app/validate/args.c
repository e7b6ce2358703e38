/* SPDX-License-Identifier: Apache-2.0 */
/* Checks the options of `osteon validate` before any case is made. */
#include "app/validate/validate.h"

#include "app/common/options.h"
#include "validation/bundle/impact.h"
#include "validation/suite_run.h"

/* Reads a number of up to six digits. Returns the position after the number, or NULL if there is no digit. */
static const char *small_number(const char *at, int *out)
{
    const char *begin = at;
    for (*out = 0; *at >= '0' && *at <= '9' && at - begin < 6; at++)
        *out = 10 * *out + (*at - '0');
    return at > begin ? at : NULL;
}

/* Parses the value of --shard, such as "2/8". If the option is not given, the result is shard 1 of 1. */
static ost_status shard_of(const app_state *app, const char *text, int *shard, int *shards, ost_error *err)
{
    *shard = *shards = 1;
    if (!text)
        return OST_OK;
    const char *at = small_number(text, shard);
    at = at && *at == '/' ? small_number(at + 1, shards) : NULL;
    if (!at || *at || *shard < 1 || *shard > *shards)
        return usage_error(app, err, "--shard %s: must be I/N with 1 <= I <= N", text);
    return OST_OK;
}

/* Checks the options of a worker. */
static ost_status check_worker(const app_state *app, const validate_args *args, ost_error *err)
{
    if (!args->worker != !(args->trace || args->dump))
        return usage_error(app, err, args->worker ? "--worker needs --trace or --dump"
                                     : args->trace ? "--trace needs --worker" : "--dump needs --worker");
    if (args->trace && args->dump)
        return usage_error(app, err, "--trace cannot be combined with --dump");
    if (!args->worker && (args->from || args->to))
        return usage_error(app, err, "--from and --to need --worker");
    if (args->to && args->from > args->to)
        return usage_error(app, err, "--from %lld: must not be greater than --to %lld", (long long)args->from,
                           (long long)args->to);
    if (args->given && !args->trace)
        return usage_error(app, err, "--given needs --worker and --trace");
    return OST_OK;
}

/* Checks the options that select the task. */
static ost_status check_task(const app_state *app, const validate_args *args, ost_error *err)
{
    if (args->export_to && (args->worker || args->out))
        return usage_error(app, err, "--export-cases cannot be combined with --worker or --out");
    if (args->cpu_only && args->backends)
        return usage_error(app, err, "--cpu-only cannot be combined with --backends");
    if (args->faults_only && args->out)
        return usage_error(app, err, "--faults-only cannot be combined with --out, because it writes no bundle");
    if (args->apart && (args->out || args->worker || args->merge || args->faults_only || args->export_to))
        return usage_error(app, err, "--apart cannot be combined with --out, --worker, --merge, --faults-only or "
                           "--export-cases: evidence needs complete runs");
    if (args->merge && (!args->out || args->worker || args->shard))
        return usage_error(app, err, "--merge needs --out, and cannot be combined with --shard or --worker");
    if ((args->merge || args->faults_only) && user_files_given(&args->own))
        return usage_error(app, err, "%s cannot be combined with --ct, --tool or --path",
                           args->merge ? "--merge" : "--faults-only");
    return OST_OK;
}

/* Checks the options of the bundle. */
static ost_status check_bundle_options(const app_state *app, const validate_args *args, ost_error *err)
{
    ost_status status;
    if (args->against && (!args->out || args->merge || args->faults_only))
        return usage_error(app, err, "--against needs --out, and cannot be combined with --merge or --faults-only");
    if (args->against && (status = impact_check(args->against, err)) != OST_OK)
        return status;
    if (args->suite && (!args->out || args->merge || args->faults_only || args->worker))
        return usage_error(app, err, "--with-suite needs --out, and cannot be combined with --merge, --faults-only or "
                           "--worker");
    if (args->suite && args->shard_index != 1)
        return usage_error(app, err, "--with-suite with --shard %s: only the first shard runs the tests; pass --shard "
                           "1/%d", args->shard, args->shard_count);
    if (args->suite && (status = suite_find(args->suite, err)) != OST_OK)
        return status;
    if ((args->sign && (!args->out || args->faults_only)) || (args->passphrase && !args->sign))
        return usage_error(app, err, args->sign ? "--sign needs --out" : "--passphrase-file needs --sign");
    if (args->faults && !args->faults_only)
        return usage_error(app, err, "--faults needs --faults-only");
    if (!args->faults_only && args->case_file && !args->worker && (args->only || args->shard))
        return usage_error(app, err, "--case cannot be combined with --only or --shard");
    return OST_OK;
}

ost_status validate_check(const app_state *app, validate_args *args, ost_error *err)
{
    ost_status status = shard_of(app, args->shard, &args->shard_index, &args->shard_count, err);
    if (status == OST_OK)
        status = check_worker(app, args, err);
    if (status == OST_OK)
        status = check_task(app, args, err);
    return status == OST_OK ? check_bundle_options(app, args, err) : status;
}
