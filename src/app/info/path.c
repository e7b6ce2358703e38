/* SPDX-License-Identifier: Apache-2.0 */
#include "app/info/info.h"

#include "app/common/print.h"
#include "app/common/result.h"

ost_status info_path(const app_state *app, const char *name, ost_error *err)
{
    ost_path path = {0};
    ost_path_report report;
    ost_status status = ost_path_read(name, NULL, &path, &report, err);
    if (status != OST_OK)
        return status;
    int32_t tools = 0;
    double seconds = path.count ? (double)(path.ticks[path.count - 1].t_ns - path.ticks[0].t_ns) * 1e-9 : 0;
    for (size_t i = 0; i < path.count; i++)
        tools = path.ticks[i].tool + 1 > tools ? path.ticks[i].tool + 1 : tools;
    char a[FORMAT_TEXT];
    put_text(app->result, "kind", "path");
    put_text(app->result, "format", "CSV");
    put(app->result, "dims", json_pack("[I]", (json_int_t)path.count));
    put_integer(app->result, "ticks", (int64_t)path.count);
    put_real(app->result, "seconds", seconds);
    put_integer(app->result, "tools", tools);
    put_integer(app->result, "gaps", (int64_t)report.gaps);
    put_integer(app->result, "lost_rows", (int64_t)report.lost_rows);
    print_line(app, "%s: a path of %s ticks in %.3f s, for %d tool%s", name, format_count(a, (int64_t)path.count),
               seconds, tools, tools == 1 ? "" : "s");
    if (report.gaps || report.lost_rows)
        print_line(app, "  %zu rows without a pose; the tool is lifted %zu time%s on its way", report.lost_rows,
                   report.gaps, report.gaps == 1 ? "" : "s");
    ost_path_free(&path);
    return OST_OK;
}
