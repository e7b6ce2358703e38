/* SPDX-License-Identifier: Apache-2.0 */
#include "app/reproduce/reproduce.h"

/* Merges an item from all folders that contain it. If there is no such folder, the result names no machine. */
static ost_status merge_item(const reproduce_args *args, const reproduction_item *item, result *out, ost_error *err)
{
    ost_status status = OST_OK;
    bool any = false;
    for (int i = 0; i < args->merge.count && status == OST_OK; i++) {
        result one;
        bool absent = false;
        status = write_read(args->merge.value[i], item->id, &one, &absent, err);
        if (absent) {
            *err = (ost_error){.status = OST_OK};
            result_free(&one);
            status = OST_OK;
            continue;
        }
        if (status == OST_OK && !any) {
            *out = one;
            any = true;
            continue;
        }
        if (status == OST_OK)
            status = result_merge(out, &one, err);
        result_free(&one);
    }
    return status;
}

ost_status reproduce_merge(app_state *app, const reproduce_args *args, const bool chosen[REPRODUCE_ITEMS_MAX],
                           reproduce_run *run, ost_error *err)
{
    ost_status status = OST_OK;
    for (const reproduction_item *item = reproduction_items; item->id && status == OST_OK; item++) {
        result *to = &run->results[run->count];
        report_entry *e = &run->entry[run->count];
        if (!chosen[item - reproduction_items])
            continue;
        status = merge_item(args, item, to, err);
        if (status != OST_OK || to->machine_count == 0)
            continue;
        *e = (report_entry){.item = item, .result = to};
        status = run->count++ == 0 ? reproduce_make_folder(args->out, err) : OST_OK;
        if (status == OST_OK)
            status = reproduce_finish_item(app, args, run, e, err);
    }
    if (status == OST_OK && run->measured == 0)
        return ost_fail(err, OST_ERR_INPUT, "%s: contains no result of osteon reproduce", args->merge.value[0]);
    return status;
}
