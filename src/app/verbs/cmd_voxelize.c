/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Implements `osteon voxelize`: makes a tool grid from a mesh (thesis, Alg. 2.1 and section 2.3).
 */
#include <string.h>

#include "app/common/backend_choice.h"
#include "app/input/load.h"
#include "app/common/result.h"
#include "app/common/print.h"

static void put_result(const app_state *app, const tool_report *r, const ost_tool_geometry *g, const ost_digest *digest)
{
    json_t *o = app->result;
    double voxel = ost_pm_to_mm(g->voxel);
    put_text(o, "format", r->mesh.format);
    put_integer(o, "bodies", (int64_t)r->mesh.bodies);
    put_dims(o, "dims", g->dims);
    put_mm(o, "voxel_mm", g->voxel);
    put_mm3(o, "corner_mm", g->corner);
    put_integer(o, "solid_voxels", (int64_t)r->voxels.solid_voxels);
    put_integer(o, "cutting_voxels", (int64_t)r->voxels.cutting_voxels);
    put_integer(o, "triangles", (int64_t)r->triangles);
    put_integer(o, "dropped_triangles", (int64_t)r->dropped_triangles);
    put_integer(o, "leaking_rows", (int64_t)r->voxels.leaking_rows);
    put_integer(o, "open_edges", (int64_t)r->open_edges);
    put_real(o, "solid_mm3", (double)r->voxels.solid_voxels * voxel * voxel * voxel);
    put_real(o, "mesh_mm3", r->mesh_volume_mm3);
    put_digest(o, "mesh_sha256", &r->snapped);
    put_digest(o, "sha256", digest);
    put_real(o, "time_ms", r->time_ms);
}

ost_status cmd_voxelize(app_state *app, int argc, char **argv, ost_error *err)
{
    const char *mesh = NULL, *out = NULL, *noncutting = NULL;
    tool_options how = TOOL_OPTIONS_DEFAULT;
    const operand operands[] = {{"MESH", &mesh, "no mesh given"}, {0}};
    const option options[] = {
        {.name = "out", .kind = OPTION_OUTPUT, .out = &out, .value = "FILE", .required = true,
         .help = "the tool grid: .nrrd"},
        TOOL_OPTIONS(how),
        {.name = "noncutting", .kind = OPTION_TEXT, .out = &noncutting, .value = "MESH",
         .help = "part that touches bone but does not cut, such as a shaft"},
        {.name = NULL}};
    const usage_text usage = {
        .synopsis = "MESH --voxel MM --out TOOL.nrrd [options]",
        .about = "Converts a mesh (STL, OBJ, PLY, 3DS, or builtin:reamer, builtin:peg, builtin:burr)\n"
                 "into a tool grid. A voxel is solid if its centre lies inside the mesh.",
        .operands = operands,
        .options = options,
        .notes = "Lengths are in millimetres. The grid has the frame of the mesh. If the mesh is not\n"
                 "closed in a row of voxels, the row is left empty and counted as a leak.",
        .example = "  osteon tool reamer --out reamer.stl\n  osteon voxelize reamer.stl --voxel 0.5 --out reamer.nrrd",
    };
    ost_status status;
    if (!options_parse(app, &usage, argc, argv, &status, err) || (status = out_check(app, out, "nrrd", err)) != OST_OK)
        return status;

    ost_backend *backend = NULL;
    ost_tool *tool = NULL;
    ost_tool_volume volume = {0};
    tool_report report;
    ost_digest digest, file;
    ost_file_kind kind = OST_FILE_MESH;
    if (strncmp(mesh, "builtin:", 8) != 0)
        status = ost_file_kind_find(mesh, &kind, err);
    if (status == OST_OK && kind != OST_FILE_MESH && kind != OST_FILE_UNKNOWN)
        status = ost_fail(err, OST_ERR_INPUT, "%s: is of kind %s; expected a mesh: STL, OBJ, PLY or 3DS", mesh,
                          load_kind_name(kind));
    if (status == OST_OK)
        status = backend_choose(app, &backend, err);
    if (status == OST_OK)
        status = load_tool(app, backend, mesh, noncutting, &how, &tool, &report, err);
    if (status == OST_OK)
        status = ost_tool_digest(tool, &digest, err);
    if (status == OST_OK)
        status = ost_tool_download(tool, &volume, err);
    if (status == OST_OK)
        status = ost_tool_volume_write(out, &volume, err);
    if (status == OST_OK && (status = file_digest(out, &file, err)) == OST_OK) {
        const ost_tool_geometry *g = ost_tool_geometry_get(tool);
        char a[FORMAT_TEXT], b[FORMAT_TEXT], c[FORMAT_TEXT], d[FORMAT_TEXT];
        double voxel = ost_pm_to_mm(g->voxel);
        put_text(app->result, "in", mesh);
        put_text(app->result, "out", out);
        put_result(app, &report, g, &digest);
        put_digest(app->result, "file_sha256", &file);
        print_line(app, "%s: %s, %s triangles, %.4g mm3", mesh, report.mesh.format,
                   format_count(a, (int64_t)report.triangles), report.mesh_volume_mm3);
        print_line(app, "%s: %s voxels of %s, %s solid (%.4g mm3), in %s", out, format_dims(a, g->dims),
                   format_spacing(b, (ost_pm3){g->voxel, g->voxel, g->voxel}),
                   format_count(c, (int64_t)report.voxels.solid_voxels),
                   (double)report.voxels.solid_voxels * voxel * voxel * voxel, format_time(d, report.time_ms));
        if (report.dropped_triangles)
            print_line(app, "  %zu triangle%s without area dropped", report.dropped_triangles,
                       report.dropped_triangles == 1 ? "" : "s");
        if (g->dims.x > OST_TOOL_DIM_REMOVE_MAX || g->dims.y > OST_TOOL_DIM_REMOVE_MAX ||
            g->dims.z > OST_TOOL_DIM_REMOVE_MAX)
            warn(app, "%s: more than %d voxels per side, too many for osteon ream; use a larger --voxel", out,
                 OST_TOOL_DIM_REMOVE_MAX);
    }
    ost_tool_volume_free(&volume);
    ost_tool_free(tool);
    ost_backend_close(backend);
    return status;
}
