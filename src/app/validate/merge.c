/* SPDX-License-Identifier: Apache-2.0 */
/* Merges the bundles of shards into the bundle of the campaign. No case is run. */
#include "app/validate/validate.h"

#include "app/common/result.h"
#include "app/common/print.h"
#include "validation/bundle/environment.h"
#include "validation/bundle/evidence.h"
#include "validation/bundle/faults.h"
#include "validation/bundle/log.h"
#include "validation/bundle/merge.h"
#include "validation/bundle/record.h"
#include "validation/bundle/suite.h"
#include "validation/report/pictures.h"
#include "validation/report/report.h"

ost_status validate_merge(app_state *app, const validate_args *args, ost_error *err)
{
    merged m;
    bundle *b = NULL;
    json_t *summary = NULL;
    ost_status status = merge_read(args->merge, &m, err);
    if (status != OST_OK)
        return status;
    status = bundle_begin(args->out, &b, err);
    if (status == OST_OK)
        status = validate_freeze(b, m.protocol, err);
    if (status == OST_OK)
        status = bundle_log(b, "merged", err, "%d shards of %s, their machines in environment.json", m.shards,
                            args->merge);
    if (status == OST_OK)
        status = evidence_write(m.protocol, m.cases, validate_into_bundle, b, err);
    if (status == OST_OK)
        status = bundle_put_json(b, ENVIRONMENT_FILE, m.environment, err);
    if (status == OST_OK)
        status = bundle_put_json(b, TIMES_FILE, m.times, err);
    if (status == OST_OK && m.faults)
        status = bundle_put_json(b, FAULTS_FILE, m.faults, err);
    if (status == OST_OK && m.suite)
        status = bundle_put_json(b, SUITE_FILE, m.suite, err);
    if (status == OST_OK)
        status = record_merge(args->merge, validate_into_bundle, b, err);
    if (status == OST_OK)
        status = record_derive(bundle_folder(b), m.protocol, m.cases, validate_into_bundle, b, err);
    if (status == OST_OK)
        status = pictures_of_shards(args->merge, m.protocol, m.cases, validate_into_bundle, b, err);
    if (status == OST_OK)
        status = report_write(bundle_folder(b), m.protocol, m.cases, validate_into_bundle, b, err);
    if (status == OST_OK)
        status = evidence_summary(m.protocol, m.cases, &summary, err);
    if (status == OST_OK)
        status = log_end(b, summary, err);
    if (status == OST_OK) {
        status = bundle_end(b, err);
        b = NULL;
        if (status == OST_OK)
            status = validate_sign(app, args, err);
    }
    if (status == OST_OK) {
        const bool equal = json_is_true(json_object_get(summary, "equal"));
        json_object_update(app->result, summary);
        put_text(app->result, "out", args->out);
        put_integer(app->result, "shards", m.shards);
        print_line(app, "%s: %zu case%s from %d shard%s", evidence_text(summary, "verdict"), json_array_size(m.cases),
                   json_array_size(m.cases) == 1 ? "" : "s", m.shards, m.shards == 1 ? "" : "s");
        if (m.suite) {
            put(app->result, "suite", json_incref(m.suite));
            validate_print_suite(app, m.suite);
        }
        validate_print_last(app, args->out, summary);
        if (!json_integer_value(json_object_get(summary, "compared")))
            status = validate_nothing(err);
        else if (!equal)
            status = ost_fail(err, OST_ERR_DIFFER, "%s: results differ from the reference's; see anomalies.csv",
                              args->out);
        else if (m.suite)
            status = validate_judge_suite(m.suite, err);
    }
    bundle_abandon(b);
    json_decref(summary);
    merge_free(&m);
    return status;
}
