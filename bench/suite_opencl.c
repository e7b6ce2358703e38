/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Measures the backend cl on one device. The rows have these baselines:
 *
 *   opencl/{reamer,peg}/{16,32,64}/{fresh,steady}   the thesis' kernel, one launch per chunk (suite_removal.c)
 *   opencl/transfer/scapula, opencl/voxelize/...    the backend cpu on the same data
 *   opencl/launch                                   none; the row measures launching an empty kernel and waiting for
 *                                                   its end; this time is a lower bound on an event's time
 */
#include "bench/meshes.h"
#include "bench/path.h"
#include "bench/thesis_cl.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { REPEAT = 15, REPEAT_LAUNCH = 301, CHUNK = 32, THRESHOLD = 120 };

enum { CL, CPU, REF, SIDES };

typedef struct opencl {
    const bench_options *options;
    bench_table *table;
    ost_error *err;
    ost_backend *backend[SIDES];
    bench_series series[SIDES]; /* times of the backends CL and CPU */
    bool equal;
} opencl;

static ost_status add_row(opencl *o, const char *name)
{
    bench_row *row = bench_row_add(o->table, name, "ms", o->options->threads);
    if (!row)
        return ost_fail(o->err, OST_ERR_MEMORY, "out of memory for a row");
    row->equal = o->equal;
    if (o->equal) {
        bench_row_ours(row, &o->series[CL]);
        bench_row_baseline(row, &o->series[CPU], "backend cpu on the same data");
    }
    for (int s = 0; s < SIDES; s++)
        bench_series_free(&o->series[s]);
    return OST_OK;
}

static ost_status add_or_not_run(opencl *o, const char *name, ost_status status)
{
    if (status == OST_OK)
        return add_row(o, name);
    for (int i = 0; i < SIDES; i++) /* discards the times, so that no other row contains them */
        bench_series_free(&o->series[i]);
    return bench_row_not_run(o->options, o->table, &name, 1, "ms", o->options->threads, status, o->err);
}

/* ---------------------------------------------------------------- transfer */

static ost_status convert(opencl *o, const ost_grid *rect, ost_pm spacing, bench_series *series, ost_bone **bone)
{
    ost_grid *cubic = NULL;
    const int64_t begin = bench_now();
    ost_status status = ost_rect_to_cubic(rect, spacing, OST_RESAMPLE_LINEAR, &cubic, o->err);
    if (status == OST_OK)
        status = ost_cubic_to_chunks(cubic, CHUNK, THRESHOLD, bone, o->err);
    if (series)
        bench_series_add(series, (double)(bench_now() - begin));
    ost_grid_free(cubic);
    return status;
}

static ost_status same_bones(opencl *o, ost_bone *const bones[SIDES])
{
    ost_bone_info info;
    ost_status status = ost_bone_info_get(bones[CL], &info, o->err);
    const size_t bytes = status == OST_OK ? (size_t)ost_dims_count(info.geometry.dims) * sizeof(int16_t) : 1;
    int16_t *ours = malloc(bytes), *expected = malloc(bytes);
    if (status == OST_OK && (!ours || !expected))
        status = ost_fail(o->err, OST_ERR_MEMORY, "out of memory for the comparison of bones");
    if (status == OST_OK)
        status = ost_bone_download(bones[CL], 0, info.geometry.dims.z, ours, o->err);
    if (status == OST_OK)
        status = ost_bone_download(bones[REF], 0, info.geometry.dims.z, expected, o->err);
    o->equal = status == OST_OK && memcmp(ours, expected, bytes) == 0;
    free(ours);
    free(expected);
    return status;
}

static ost_status transfer(opencl *o)
{
    static const char name[] = "opencl/transfer/scapula";
    if (!bench_wanted(o->options, name))
        return OST_OK;
    const ost_phantom_options how = {.scale = o->options->quick ? 0.2 : 1};
    ost_volume ct = {0};
    ost_grid *rect[SIDES] = {NULL};
    ost_bone *bones[SIDES] = {NULL};
    ost_status status = ost_phantom_make(OST_PHANTOM_SCAPULA, &how, &ct, o->err);
    for (int s = 0; s < SIDES && status == OST_OK; s++) {
        status = ost_grid_create(o->backend[s], &ct.geometry, &rect[s], o->err);
        if (status == OST_OK)
            status = ost_grid_upload(rect[s], 0, ct.geometry.dims.z, ct.voxels, o->err);
        if (status == OST_OK)
            status = convert(o, rect[s], ct.geometry.spacing.x, NULL, &bones[s]);
    }
    if (status == OST_OK)
        status = same_bones(o, bones);
    for (int s = 0; s < SIDES; s++)
        ost_bone_free(bones[s]);
    for (int i = 0; i < bench_repeat(o->options, REPEAT) && status == OST_OK; i++)
        for (int s = CL; s <= CPU && status == OST_OK; s++) {
            ost_bone *bone = NULL;
            status = convert(o, rect[s], ct.geometry.spacing.x, &o->series[s], &bone);
            ost_bone_free(bone);
        }
    for (int s = 0; s < SIDES; s++)
        ost_grid_free(rect[s]);
    ost_volume_free(&ct);
    return add_or_not_run(o, name, status);
}

/* --------------------------------------------------------------- voxelizer */

static ost_status make_tool(opencl *o, int side, const ost_snapped_mesh *mesh, bool timed, ost_tool_volume *out)
{
    ost_tool *tool = NULL;
    ost_voxelize_report report;
    const int64_t begin = bench_now();
    ost_status status = ost_voxelize(o->backend[side], mesh, NULL, OST_FILL_WINDING, &report, &tool, o->err);
    if (timed)
        bench_series_add(&o->series[side], (double)(bench_now() - begin));
    if (status == OST_OK && out)
        status = ost_tool_download(tool, out, o->err);
    ost_tool_free(tool);
    return status;
}

static ost_status voxelize(opencl *o, const char *name, const ost_mesh *mesh, const ost_tool_geometry *grid)
{
    ost_snapped_mesh snapped = {0};
    ost_tool_volume volumes[SIDES] = {{.voxels = NULL}};
    ost_status status = ost_mesh_snap(mesh, grid, &snapped, o->err);
    for (int s = 0; s < SIDES && status == OST_OK; s++)
        status = make_tool(o, s, &snapped, false, &volumes[s]);
    o->equal = status == OST_OK &&
               memcmp(volumes[CL].voxels, volumes[REF].voxels, (size_t)ost_dims_count(grid->dims)) == 0;
    for (int i = 0; i < bench_repeat(o->options, REPEAT) && status == OST_OK; i++)
        for (int s = CL; s <= CPU && status == OST_OK; s++)
            status = make_tool(o, s, &snapped, true, NULL);
    for (int s = 0; s < SIDES; s++)
        ost_tool_volume_free(&volumes[s]);
    ost_snapped_mesh_free(&snapped);
    return add_or_not_run(o, name, status);
}

static ost_status voxelize_tool(opencl *o, ost_tool_kind kind)
{
    char name[BENCH_NAME];
    ost_mesh mesh = {0};
    ost_tool_geometry grid;
    ost_pm3 lo, hi;
    snprintf(name, sizeof name, "opencl/voxelize/%s/0.5", ost_tool_kind_name(kind));
    if (!bench_wanted(o->options, name))
        return OST_OK;
    ost_status status = ost_tool_make(kind, NULL, &mesh, o->err);
    if (status == OST_OK)
        status = ost_mesh_bounds(&mesh, &lo, &hi, o->err);
    if (status == OST_OK)
        status = ost_tool_geometry_from_bounds(lo, hi, OST_PM_PER_MM / 2, &grid, o->err);
    if (status == OST_OK)
        status = voxelize(o, name, &mesh, &grid);
    ost_mesh_free(&mesh);
    return status;
}

static ost_status voxelize_sphere(opencl *o)
{
    static const char name[] = "opencl/voxelize/sphere80k/256";
    enum { SIDE = 256 };
    const ost_pm voxel = OST_PM_PER_MM / 10;
    const ost_tool_geometry grid = {.dims = {SIDE, SIDE, SIDE}, .voxel = voxel};
    ost_mesh mesh = {0};
    if (!bench_wanted(o->options, name))
        return OST_OK;
    ost_status status = bench_sphere(SIDE * voxel, &mesh, o->err);
    if (status == OST_OK)
        status = voxelize(o, name, &mesh, &grid);
    ost_mesh_free(&mesh);
    return status;
}

/* ------------------------------------------------------------------- suite */

static ost_status launches(opencl *o, bench_cl *cl)
{
    static const char name[] = "opencl/launch";
    bench_series series = {0};
    if (!bench_wanted(o->options, name))
        return OST_OK;
    /* an untimed launch precedes the measurement, because a driver may build the kernel at the first launch */
    bool done = bench_cl_launch(cl);
    for (int i = 0; i < bench_repeat(o->options, REPEAT_LAUNCH) && done; i++) {
        const int64_t begin = bench_now();
        done = bench_cl_launch(cl);
        bench_series_add(&series, (double)(bench_now() - begin));
    }
    bench_row *row = bench_row_add(o->table, name, "us", o->options->threads);
    if (!row)
        return ost_fail(o->err, OST_ERR_MEMORY, "out of memory for a row");
    if (done)
        bench_row_ours(row, &series);
    else
        snprintf(row->reason, sizeof row->reason, "OpenCL device '%.100s' cannot run an empty kernel",
                 bench_cl_name(cl));
    snprintf(row->baseline_reason, sizeof row->baseline_reason, "an empty kernel on %.150s, enqueued and waited for",
             bench_cl_name(cl));
    bench_series_free(&series);
    return OST_OK;
}

/* Adds one row that contains only the reason why no device is available. */
static ost_status nothing_here(const bench_options *options, bench_table *table, const char *reason, ost_error *err)
{
    static const char name[] = "opencl/reamer/32/fresh";
    if (!bench_wanted(options, name))
        return OST_OK;
    bench_row *row = bench_row_add(table, name, "us", options->threads);
    if (!row)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a row");
    snprintf(row->reason, sizeof row->reason, "%s", reason);
    return OST_OK;
}

ost_status bench_opencl(const bench_options *options, bench_table *table, ost_error *err)
{
    char reason[BENCH_TEXT] = "";
    bench_cl *cl = bench_cl_open(options->backend, reason);
    if (!cl)
        return nothing_here(options, table, reason, err);
    bench_options with = *options;
    with.backend = strncmp(options->backend, "cl:", 3) == 0 ? options->backend : bench_cl_spec(cl);
    opencl o = {.options = &with, .table = table, .err = err};
    ost_error why = {0};
    ost_status status = ost_backend_open(with.backend, &o.backend[CL], &why);
    if (status == OST_ERR_UNAVAILABLE) {
        bench_cl_close(cl);
        return nothing_here(options, table, why.text, err);
    }
    if (status != OST_OK)
        status = ost_fail(err, status, "%s", why.text);
    char cpu[64];
    snprintf(cpu, sizeof cpu, "cpu:threads=%d", options->threads);
    if (status == OST_OK)
        status = ost_backend_open(cpu, &o.backend[CPU], err);
    if (status == OST_OK)
        status = ost_backend_open("ref", &o.backend[REF], err);
    if (status == OST_OK)
        status = bench_removal_opencl(&with, table, cl, err);
    if (status == OST_OK)
        status = launches(&o, cl);
    if (status == OST_OK)
        status = transfer(&o);
    if (status == OST_OK)
        status = voxelize_tool(&o, OST_TOOL_REAMER);
    if (status == OST_OK)
        status = voxelize_tool(&o, OST_TOOL_PEG);
    if (status == OST_OK)
        status = voxelize_sphere(&o);
    for (int s = 0; s < SIDES; s++) {
        bench_series_free(&o.series[s]);
        ost_backend_close(o.backend[s]);
    }
    bench_cl_close(cl);
    return status;
}
