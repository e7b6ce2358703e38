/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Table 2.1: the times to voxelize the tools, with the voxel size of the thesis and with coarser and finer voxels.
 *
 * Each time is the duration of ost_voxelize, including the allocation of the tool. Before the timing, the tool is
 * compared with the result of the reference.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <osteon/phantom.h>

#include "reproduction/item.h"
#include "reproduction/stated.h"

enum { TOOL, VOXEL, DIMS, SOLID, TRIANGLES, TIME, LEAST, PASS };
enum { REPEAT = 41 };

typedef struct job {
    reproduction *r;
    result *out;
    ost_backend *backend, *reference;
    ost_error *err;
} job;

static ost_status digest_of(ost_backend *backend, const ost_snapped_mesh *mesh, ost_voxelize_report *report,
                            ost_digest *digest, ost_error *err)
{
    ost_tool *tool = NULL;
    ost_status status = ost_voxelize(backend, mesh, NULL, OST_FILL_WINDING, report, &tool, err);
    if (status == OST_OK)
        status = ost_tool_digest(tool, digest, err);
    ost_tool_free(tool);
    return status;
}

static ost_status measure(job *j, const ost_snapped_mesh *mesh, ost_voxelize_report *report, bench_series *series)
{
    ost_digest ours, expected;
    ost_voxelize_report by_reference;
    ost_status status = digest_of(j->backend, mesh, report, &ours, j->err);
    if (status == OST_OK)
        status = digest_of(j->reference, mesh, &by_reference, &expected, j->err);
    if (status == OST_OK && memcmp(&ours, &expected, sizeof ours) != 0)
        status = ost_fail(j->err, OST_ERR_DIFFER, "the voxelized tool differs from the reference's");
    for (int i = 0; i < bench_repeat(&j->r->bench, REPEAT) && status == OST_OK; i++) {
        ost_tool *tool = NULL;
        const int64_t begin = bench_now();
        status = ost_voxelize(j->backend, mesh, NULL, OST_FILL_WINDING, report, &tool, j->err);
        if (status == OST_OK)
            status = ost_backend_finish(j->backend, j->err);
        bench_series_add(series, (double)(bench_now() - begin));
        ost_tool_free(tool);
    }
    return status;
}

static ost_status add(job *j, ost_tool_kind kind, ost_pm voxel)
{
    ost_mesh mesh = {.vertices = NULL};
    ost_snapped_mesh snapped = {.triangles = NULL};
    ost_tool_geometry grid;
    ost_voxelize_report report;
    bench_series series = {.ns = NULL};
    ost_pm3 lo, hi;
    ost_status status = ost_tool_make(kind, NULL, &mesh, j->err);
    if (status == OST_OK)
        status = ost_mesh_bounds(&mesh, &lo, &hi, j->err);
    if (status == OST_OK)
        status = ost_tool_geometry_from_bounds(lo, hi, voxel, &grid, j->err);
    if (status == OST_OK)
        status = ost_mesh_snap(&mesh, &grid, &snapped, j->err);
    if (status == OST_OK)
        status = measure(j, &snapped, &report, &series);
    if (status == OST_OK) {
        const bool reamer = kind == OST_TOOL_REAMER;
        result_add_row(j->out);
        result_set_text(j->out, TOOL, "%s", reamer ? "reamer" : "peg drill");
        result_set(j->out, VOXEL, ost_pm_to_mm(voxel));
        result_set_text(j->out, DIMS, "%d x %d x %d", grid.dims.x, grid.dims.y, grid.dims.z);
        result_set(j->out, SOLID, (double)report.solid_voxels);
        result_set(j->out, TRIANGLES, (double)mesh.triangle_count);
        result_set(j->out, TIME, bench_series_at(&series, 0.5) / 1e6);
        result_set(j->out, LEAST, bench_series_at(&series, 0) / 1e6);
        if (voxel == OST_PM_PER_MM / 2) { /* the voxel size of the thesis */
            result_set_thesis(j->out, TIME, reamer ? STATED_VOXELIZE_REAMER_MS : STATED_VOXELIZE_PEG_MS);
            if (reamer)
                result_set_thesis(j->out, PASS, STATED_VOXELIZE_REAMER_PASS_MS);
        }
    }
    bench_series_free(&series);
    ost_snapped_mesh_free(&snapped);
    ost_mesh_free(&mesh);
    return status;
}

ost_status item_voxelize(reproduction *r, result *out, ost_error *err)
{
    static const ost_pm voxels[] = {OST_PM_PER_MM, 3 * OST_PM_PER_MM / 4, OST_PM_PER_MM / 2, OST_PM_PER_MM / 4};
    job j = {.r = r, .out = out, .err = err};
    result_add_column(out, "tool", "tool", "text");
    result_add_column(out, "tool_voxel_mm", "tool voxel", "mm");
    result_add_column(out, "dims", "voxels per axis", "text");
    result_add_column(out, "solid_voxels", "solid voxels", "");
    result_add_column(out, "triangles", "triangles", "");
    result_add_column(out, "voxelize_ms", "voxelization", "ms");
    result_add_column(out, "voxelize_min_ms", "shortest", "ms");
    result_add_column(out, "pass_ms", "additional pass along x", "ms");
    ost_status status = bench_backend(&r->bench, r->bench.threads, &j.backend, err);
    if (status == OST_OK)
        status = ost_backend_open("ref", &j.reference, err);
    for (int kind = OST_TOOL_REAMER; kind <= OST_TOOL_PEG; kind++)
        for (size_t i = 0; i < sizeof voxels / sizeof voxels[0] && status == OST_OK; i++) {
            reproduction_show(r, "voxelizing tools", (kind * 4.0 + (double)i) / 8);
            status = add(&j, (ost_tool_kind)kind, voxels[i]);
        }
    ost_backend_close(j.reference);
    ost_backend_close(j.backend);
    result_add_remark(out,
                      "The thesis voxelizes the surface and then fills the reamer by a second pass along x; osteon "
                      "fills each row of voxels by the winding number as it is marked, so that there is no second "
                      "pass. The thesis' meshes are not public; the parametric tools have the same bounds, but "
                      "other numbers of triangles.");
    result_plot *p =
        result_add_plot(out, RESULT_PLOT_LINES, "Time of voxelizing a tool", "edge of a tool voxel (mm)", "time (ms)");
    p->x = VOXEL;
    p->group = TOOL;
    p->value[p->values++] = TIME;
    p->log_x = p->log_y = true;
    return status;
}
