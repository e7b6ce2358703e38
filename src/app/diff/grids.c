/* SPDX-License-Identifier: Apache-2.0 */
#include "app/diff/diff.h"

#include "app/common/print.h"
#include "app/common/progress.h"
#include "app/common/result.h"

ost_status diff_grids(const app_state *app, const diff_args *args, ost_error *err)
{
    loaded_volume a = {0}, b = {0};
    diff_result r = {0};
    ost_status status = load_volume(app, args->name_a, &a, err);
    if (status == OST_OK)
        status = load_volume(app, args->name_b, &b, err);
    const bool tool = a.kind == LOAD_TOOL;
    if (status == OST_OK && tool != (b.kind == LOAD_TOOL))
        status = ost_fail(err, OST_ERR_INPUT,
                          "%s is a tool and %s is not; expected two grids, two tools or two bundles",
                          tool ? args->name_a : args->name_b, tool ? args->name_b : args->name_a);
    progress_show(NULL, "comparing", 0);
    if (status == OST_OK)
        status = diff_compare(&a, &b, 16 << args->chunk, (size_t)args->limit, &r, err);
    if (status == OST_OK && args->html)
        status = diff_html(args->html, args->name_a, args->name_b, &a, &b, &r, err);
    if (status == OST_OK) {
        diff_report(app, args, &a, &b, &r);
        if (args->html) {
            put_text(app->result, "html", args->html);
            print_line(app, "  page: %s", args->html);
        }
        status = r.equal ? OST_OK : OST_ERR_DIFFER;
    }
    diff_free(&r);
    ost_volume_free(&a.volume);
    ost_volume_free(&b.volume);
    return status;
}
