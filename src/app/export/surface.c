/* SPDX-License-Identifier: Apache-2.0 */
#include "app/export/export.h"

#include "app/common/print.h"
#include "app/common/progress.h"
#include "app/common/result.h"
#include "io/mesh/write_any.h"
#include "mesh/surface.h"

ost_status export_surface(const app_state *app, const export_args *args, const loaded_volume *in, ost_error *err)
{
    ost_mesh mesh = {0};
    ost_pm3 lo, hi;
    /* A bone stores 0 for each density below its threshold, so its densities cannot be interpolated. */
    const bool densities = in->kind == LOAD_CT && !args->before;
    ost_surface_placement placement = densities ? OST_SURFACE_DENSITY : OST_SURFACE_SMOOTH;
    progress_show(NULL, "extracting the surface", 0);
    ost_status status = ost_surface_extract(&in->volume, in->threshold, placement, &mesh, err);
    if (status != OST_OK)
        ost_fail_context(err, "%s", args->bone);
    if (status == OST_OK)
        status = ost_mesh_bounds(&mesh, &lo, &hi, err);
    if (status == OST_OK)
        status = ost_mesh_write_any(args->out, &mesh, in->kind == LOAD_TOOL ? OST_MESH_OWN : OST_MESH_LPS, err);
    if (status == OST_OK) {
        char n[FORMAT_TEXT];
        double volume = ost_mesh_volume_mm3(&mesh);
        put_integer(app->result, "triangles", (int64_t)mesh.triangle_count);
        put_integer(app->result, "vertices", (int64_t)mesh.vertex_count);
        put_real(app->result, "volume_mm3", volume);
        put(app->result, "bounds_mm",
            json_pack("[[f,f,f],[f,f,f]]", ost_pm_to_mm(lo.x), ost_pm_to_mm(lo.y), ost_pm_to_mm(lo.z),
                      ost_pm_to_mm(hi.x), ost_pm_to_mm(hi.y), ost_pm_to_mm(hi.z)));
        print_line(app, "%s: a closed surface of %s triangles, %.4g mm3, millimetres", args->out,
                   format_count(n, (int64_t)mesh.triangle_count), volume);
    }
    ost_mesh_free(&mesh);
    return status;
}
