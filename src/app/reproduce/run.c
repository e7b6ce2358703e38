/* SPDX-License-Identifier: Apache-2.0 */
#include "app/reproduce/reproduce.h"

#include <stdlib.h>

#include "app/common/print.h"
#include "app/common/result.h"

ost_status reproduce_items(app_state *app, const reproduce_args *args, const bool chosen[REPRODUCE_ITEMS_MAX],
                           ost_error *err)
{
    reproduce_run *run = calloc(1, sizeof *run);
    if (!run)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for the results");
    put(app->result, "items", json_array());
    ost_status status = args->merge.count ? reproduce_merge(app, args, chosen, run, err)
                                          : reproduce_measure(app, args, chosen, run, err);
    if (status == OST_OK)
        status = reproduction_report(args->out, run->entry, (size_t)run->count, err);
    if (status == OST_OK) {
        char path[WRITE_PATH];
        status = write_path(path, args->out, "report.html", err);
        put_text(app->result, "report", path);
        put_integer(app->result, "measured", run->measured);
        put_integer(app->result, "not_measured", run->count - run->measured);
        print_line(app, "%s: %d items", path, run->measured);
    }
    if (status == OST_OK && run->measured == 0) {
        app->answered = true;
        status = ost_fail(err, OST_ERR_UNAVAILABLE, "no item could be measured: %s", run->reason);
    }
    for (int i = 0; i < run->count; i++)
        result_free(&run->results[i]);
    free(run);
    return status;
}
