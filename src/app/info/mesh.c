/* SPDX-License-Identifier: Apache-2.0 */
#include "app/info/info.h"

#include "app/common/print.h"
#include "app/common/progress.h"
#include "app/common/result.h"

ost_status info_mesh(const app_state *app, const char *name, ost_error *err)
{
    ost_mesh mesh = {0};
    ost_mesh_report report = {0};
    ost_pm3 lo, hi;
    size_t open_edges = 0;
    /* Any unit will do, because the file's own numbers are printed. */
    progress_show(NULL, "reading the mesh", 0);
    ost_status status = ost_mesh_read(name, OST_UNIT_MM, &mesh, &report, err);
    if (status == OST_OK)
        status = ost_mesh_bounds(&mesh, &lo, &hi, err);
    if (status == OST_OK)
        status = ost_mesh_open_edges(&mesh, &open_edges, err);
    if (status == OST_OK) {
        char a[FORMAT_TEXT], b[FORMAT_TEXT], c[FORMAT_TEXT];
        double volume = ost_mesh_volume_mm3(&mesh);
        put_text(app->result, "kind", "mesh");
        put_text(app->result, "format", report.format);
        put_integer(app->result, "triangles", (int64_t)mesh.triangle_count);
        put_integer(app->result, "vertices", (int64_t)mesh.vertex_count);
        put_integer(app->result, "bodies", (int64_t)report.bodies);
        put_integer(app->result, "open_edges", (int64_t)open_edges);
        put(app->result, "bounds_mm",
            json_pack("[[f,f,f],[f,f,f]]", ost_pm_to_mm(lo.x), ost_pm_to_mm(lo.y), ost_pm_to_mm(lo.z),
                      ost_pm_to_mm(hi.x), ost_pm_to_mm(hi.y), ost_pm_to_mm(hi.z)));
        put(app->result, "dims",
            json_pack("[f,f,f]", ost_pm_to_mm(hi.x - lo.x), ost_pm_to_mm(hi.y - lo.y), ost_pm_to_mm(hi.z - lo.z)));
        put_real(app->result, "volume_mm3", volume);
        print_line(app, "%s: a mesh, %s, %s triangles, %zu part%s, %s", name, report.format,
                   format_count(a, (int64_t)mesh.triangle_count), report.bodies, report.bodies == 1 ? "" : "s",
                   open_edges ? "not closed" : "closed");
        print_line(app, "  from %s to %s, if its unit is the millimetre", format_point(b, lo), format_point(c, hi));
        print_line(app, "  volume %.4g mm3, %s open edge%s", volume, format_count(a, (int64_t)open_edges),
                   open_edges == 1 ? "" : "s");
    }
    ost_mesh_free(&mesh);
    return status;
}
