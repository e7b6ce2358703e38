/* SPDX-License-Identifier: Apache-2.0 */
/* Loads the meshes and tools named on the command line: reads or generates a mesh, then voxelizes it. */
#include "app/input/load.h"

#include <stdio.h>
#include <string.h>

#include "app/common/print.h"
#include "app/common/progress.h"

/* Returns the kind of the built-in tool with the given name, or OST_TOOL_KIND_COUNT if there is no such tool. */
static ost_tool_kind builtin_tool(const char *name)
{
    const char *kind = builtin_name(name);
    int k = 0;
    while (k < OST_TOOL_KIND_COUNT && !(kind && strcmp(kind, ost_tool_kind_name((ost_tool_kind)k)) == 0))
        k++;
    return (ost_tool_kind)k;
}

static ost_status load_part(const char *name, ost_unit unit, ost_tool_part part, ost_mesh *out, ost_mesh_report *report,
                            ost_error *err)
{
    const ost_tool_kind k = builtin_tool(name);
    progress_show(NULL, "reading the mesh", 0);
    if (!builtin_name(name))
        return ost_mesh_read(name, unit, out, report, err);
    if (k == OST_TOOL_KIND_COUNT)
        return ost_fail(err, OST_ERR_USAGE, "%s: unknown tool; see osteon tool --help", name);
    ost_status status = ost_tool_make(k, &(ost_tool_options){.part = part}, out, err);
    if (status == OST_OK) {
        snprintf(report->format, sizeof report->format, "built in");
        report->file_triangles = out->triangle_count;
        report->bodies = 1;
    }
    return status;
}

ost_status load_mesh(const char *name, ost_unit unit, ost_mesh *out, ost_mesh_report *report, ost_error *err)
{
    return load_part(name, unit, OST_TOOL_COMPLETE, out, report, err);
}

char *load_other_units(char out[LOAD_UNITS_TEXT], double mm)
{
    static const struct {
        const char *name;
        double mm;
    } units[] = {{"centimetres", 10}, {"inches", 25.4}, {"metres", 1000}, {"micrometres", 0.001}};
    size_t used = 0;
    out[0] = '\0';
    for (size_t u = 0; u < sizeof units / sizeof units[0]; u++)
        if (mm * units[u].mm >= 20 && mm * units[u].mm <= 600)
            used += (size_t)snprintf(out + used, LOAD_UNITS_TEXT - used, "%s%.3g mm if its lengths are %s",
                                     used ? ", or " : ": it would be ", mm * units[u].mm, units[u].name);
    return out;
}

/*
 * Warns if a mesh whose unit is not given is smaller than 5 mm. Burrs may be this small, but bones and reamers are
 * larger.
 */
static void warn_mesh_size(const app_state *app, const char *name, const ost_mesh_report *r)
{
    char text[LOAD_UNITS_TEXT];
    double largest = 0;
    for (int a = 0; a < 3; a++)
        largest = r->bounds_mm[3 + a] - r->bounds_mm[a] > largest ? r->bounds_mm[3 + a] - r->bounds_mm[a] : largest;
    if (largest < 5)
        warn(app,
             "%s: the mesh is %.3g mm across when its lengths are taken as millimetres%s; --unit mm confirms "
             "millimetres",
             name, largest, load_other_units(text, largest));
}

/* Loads the meshes of a tool, the cutting part first. *count is their number, even after an error. */
static ost_status load_parts(const char *name, const char *noncutting, ost_unit unit, ost_mesh parts[LOAD_TOOL_PARTS],
                             int *count, ost_mesh_report *report, ost_error *err)
{
    /* The shaft of a built-in tool is a separate mesh, because it touches bone without cutting it. */
    const ost_tool_kind kind = builtin_tool(name);
    const bool two_parts = !noncutting && kind < OST_TOOL_KIND_COUNT && ost_tool_has_shaft(kind);
    ost_mesh_report shaft_report = {0};
    ost_status status = load_part(name, unit, two_parts ? OST_TOOL_HEAD : OST_TOOL_COMPLETE, &parts[0], report, err);
    *count = status == OST_OK;
    if (status != OST_OK || !(noncutting || two_parts))
        return status;
    status = load_part(two_parts ? name : noncutting, unit, two_parts ? OST_TOOL_SHAFT : OST_TOOL_COMPLETE, &parts[1],
                       &shaft_report, err);
    *count += status == OST_OK;
    return status;
}

/* Returns true if the name denotes a mesh or a built-in tool. If not, *kind is the type of the file. */
static ost_status find_kind(const char *name, ost_file_kind *kind, ost_error *err)
{
    *kind = OST_FILE_MESH;
    return builtin_name(name) ? OST_OK : ost_file_kind_find(name, kind, err);
}

ost_status load_tool_parts(const char *name, const tool_options *options, ost_mesh parts[LOAD_TOOL_PARTS], int *count,
                           ost_error *err)
{
    ost_file_kind kind;
    ost_mesh_report report = {0};
    *count = 0;
    ost_status status = find_kind(name, &kind, err);
    if (status != OST_OK || kind == OST_FILE_NRRD)
        return status;
    status = load_parts(name, NULL, (ost_unit)options->unit, parts, count, &report, err);
    for (int i = 0; status != OST_OK && i < *count; i++)
        ost_mesh_free(&parts[i]);
    *count = status == OST_OK ? *count : 0;
    progress_end();
    return status;
}

static ost_status bounds_of(const ost_mesh *parts, int count, ost_pm3 *lo, ost_pm3 *hi, ost_error *err)
{
    ost_status status = ost_mesh_bounds(&parts[0], lo, hi, err);
    for (int i = 1; i < count && status == OST_OK; i++) {
        ost_pm3 lo2, hi2;
        status = ost_mesh_bounds(&parts[i], &lo2, &hi2, err);
        if (status == OST_OK) {
            ost_pm3_widen(lo, hi, lo2);
            ost_pm3_widen(lo, hi, hi2);
        }
    }
    return status;
}

static ost_status voxelize_meshes(const app_state *app, ost_backend *backend, const char *name, const char *noncutting,
                                  const tool_options *options, ost_tool **out, tool_report *report, ost_error *err)
{
    ost_mesh parts[LOAD_TOOL_PARTS];
    ost_snapped_mesh snapped[LOAD_TOOL_PARTS] = {{.vertices = NULL}};
    ost_tool_geometry grid;
    ost_pm3 lo, hi;
    char text[FORMAT_TEXT];
    int count = 0;

    ost_status status = load_parts(name, noncutting, (ost_unit)options->unit, parts, &count, &report->mesh, err);
    if (status == OST_OK && !builtin_name(name) && options->unit == OST_UNIT_AUTO)
        warn_mesh_size(app, name, &report->mesh);
    if (status == OST_OK)
        status = bounds_of(parts, count, &lo, &hi, err);
    if (status == OST_OK)
        status = ost_mesh_open_edges(&parts[0], &report->open_edges, err);
    if (status == OST_OK && (status = ost_tool_geometry_from_bounds(lo, hi, options->voxel, &grid, err)) != OST_OK)
        ost_fail_context(err, "%s", name);
    for (int i = 0; i < count && status == OST_OK; i++)
        status = ost_mesh_snap(&parts[i], &grid, &snapped[i], err);
    if (status == OST_OK)
        status = ost_snapped_mesh_digest(&snapped[0], &report->snapped, err);
    if (status == OST_OK) {
        double start = now_ms();
        progress_show(NULL, "voxelizing", 0);
        status = ost_voxelize(backend, &snapped[0], count > 1 ? &snapped[1] : NULL, (ost_fill_rule)options->rule,
                              &report->voxels, out, err);
        report->time_ms = now_ms() - start;
        progress_end();
    }
    if (status == OST_OK) {
        report->mesh_volume_mm3 = ost_mesh_volume_mm3(&parts[0]);
        if (report->voxels.leaking_rows)
            warn(app, "%s: the surface is not closed (%zu open edges): %s rows of voxels leak and were left empty",
                 name, report->open_edges, format_count(text, (int64_t)report->voxels.leaking_rows));
        if (!report->voxels.solid_voxels)
            warn(app, "%s: no voxel of %g mm is inside the mesh; use a smaller --voxel", name,
                 ost_pm_to_mm(options->voxel));
    }
    for (int i = 0; i < count; i++) {
        report->triangles += parts[i].triangle_count;
        report->dropped_triangles += snapped[i].dropped_triangles;
        ost_snapped_mesh_free(&snapped[i]);
        ost_mesh_free(&parts[i]);
    }
    return status;
}

ost_status load_tool(const app_state *app, ost_backend *backend, const char *name, const char *noncutting,
                     const tool_options *options, ost_tool **out, tool_report *report, ost_error *err)
{
    tool_report own = {0};
    if (!report)
        report = &own;
    *report = (tool_report){0};
    ost_file_kind kind;
    const ost_status known = find_kind(name, &kind, err);
    if (known != OST_OK)
        return known;
    if (kind == OST_FILE_NRRD && !noncutting) {
        ost_tool_volume volume = {0};
        ost_status status = ost_tool_volume_read(name, &volume, err);
        if (status == OST_OK)
            status = ost_tool_upload(backend, &volume, out, err);
        ost_tool_volume_free(&volume);
        return status;
    }
    if (kind != OST_FILE_MESH && kind != OST_FILE_UNKNOWN)
        return ost_fail(err, OST_ERR_INPUT, "%s: not a mesh or a tool grid", name);
    return voxelize_meshes(app, backend, name, noncutting, options, out, report, err);
}
