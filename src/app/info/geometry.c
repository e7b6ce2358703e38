/* SPDX-License-Identifier: Apache-2.0 */
#include "app/info/info.h"

#include "app/common/print.h"
#include "app/common/result.h"

void info_put_geometry(const app_state *app, const ost_geometry *g)
{
    char a[FORMAT_TEXT], b[FORMAT_TEXT];
    double size[3] = {g->dims.x * ost_pm_to_mm(g->spacing.x), g->dims.y * ost_pm_to_mm(g->spacing.y),
                      g->dims.z * ost_pm_to_mm(g->spacing.z)};
    put_dims(app->result, "dims", g->dims);
    put_mm3(app->result, "spacing_mm", g->spacing);
    put_mm3(app->result, "origin_mm", g->origin);
    put(app->result, "size_mm", json_pack("[f,f,f]", size[0], size[1], size[2]));
    put_integer(app->result, "voxels", ost_dims_count(g->dims));
    print_line(app, "  %s voxels of %s, %.4g x %.4g x %.4g mm", format_dims(a, g->dims), format_spacing(b, g->spacing),
               size[0], size[1], size[2]);
    print_line(app, "  first voxel at %s", format_point(a, g->origin));
}

void info_print_meta(const app_state *app, const ost_meta *meta)
{
    put_meta(app->result, "meta", meta);
    for (int i = 0; i < meta->count; i++)
        print_line(app, "  %s: %s", meta->entry[i].key, meta->entry[i].value);
}
