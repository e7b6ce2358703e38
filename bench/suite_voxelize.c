/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Measures the conversion of a snapped mesh to a tool grid (thesis, section 2.3, Table 2.1), by
 * the winding rule.
 *
 *   voxelize/sphere80k/N, voxelize/knot524k/N   cubes of N = 256, 512, 1024
 *   voxelize/reamer/0.5, voxelize/peg/0.5       the parametric tools
 *   NAME/tool, for each of these names          osteon creates a tool
 *   NAME/bytes                                  osteon creates a tool and copies it to the host, one byte per voxel
 *
 * The baseline is Embree with a packet of rays for sixteen rows, a filter that records every hit, and parity bits as
 * output. Its time includes building the hierarchy. Both of Embree's build qualities are measured, and the row contains
 * the times of the faster one. For a fair comparison, osteon's and the baseline's memory for the bits is written
 * once before the measurement. osteon's time is the time of the voxelizer alone, without the creation of a tool. A
 * /tool row compares the same baseline with the public call, which allocates the tool's memory. A /bytes row also
 * includes the download, which allocates the bytes and assigns each voxel its class.
 */
#include "bench/baseline_embree.h"
#include "bench/bench.h"
#include "bench/meshes.h"
#include "bench/tool_bits.h"

#include <osteon/phantom.h>

#include "core/backend.h"
#include "cpu/voxelize/voxelize.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { REPEAT = 9, REPEAT_SMALL = 101 };
#define CUBE_VOXEL (OST_PM_PER_MM / 10)

typedef struct voxelize {
    const bench_options *options;
    bench_table *table;
    ost_error *err;
    ost_snapped_mesh mesh;
    ost_backend *backend;
    ost_voxelize_report report;
    bench_series ours_bits, ours_tool, ours_bytes;
    bench_series embree[2]; /* embree[1] contains the times of Embree's fast, low-quality build */
    uint64_t *bits;     /* output buffer for the baseline's bits */
    uint64_t *own_bits; /* output buffer for osteon's bits; NULL if the backend writes only bytes */
    int64_t embree_solid;
    bool has_embree, equal;
} voxelize;

/* ---------------------------------------------------------------- equality */

/* Computes the bits with the voxelizer of the CPU backend. v->backend must be the CPU backend. */
static ost_status make_bits(voxelize *v, ost_voxelize_report *report)
{
    return ost_cpu_voxelize((const cpu_backend *)v->backend, &v->mesh, NULL, OST_FILL_WINDING, report,
                            &(ost_vox_result){.cutting = v->own_bits}, v->err);
}

static ost_status verify(voxelize *v)
{
    ost_backend *ref = NULL;
    ost_tool_volume expected = {0}, ours = {0};
    ost_voxelize_report report;
    ost_status status = ost_backend_open("ref", &ref, v->err);
    if (status == OST_OK)
        status = bench_tool_voxels(ref, &v->mesh, &expected, &report, v->err);
    if (status == OST_OK)
        status = bench_tool_voxels(v->backend, &v->mesh, &ours, &v->report, v->err);
    if (status == OST_OK)
        v->equal = report.solid_voxels == v->report.solid_voxels && report.leaking_rows == v->report.leaking_rows &&
                   memcmp(expected.voxels, ours.voxels, (size_t)ost_dims_count(v->mesh.grid.dims)) == 0;
    if (status == OST_OK && v->own_bits) {
        status = make_bits(v, &v->report);
        v->equal = v->equal && report.solid_voxels == v->report.solid_voxels &&
                   bench_tool_bits_are(v->own_bits, v->mesh.grid.dims, expected.voxels);
    }
    ost_tool_volume_free(&expected);
    ost_tool_volume_free(&ours);
    ost_backend_close(ref);
    return status;
}

/* --------------------------------------------------------------- measuring */

/* Creates a tool and downloads it. If `timed` is true, records the time of the creation and the time of both steps. */
static ost_status time_tool(voxelize *v, bool timed)
{
    ost_tool *tool = NULL;
    ost_tool_volume volume = {0};
    ost_voxelize_report report;
    const int64_t begin = bench_now();
    ost_status status = ost_voxelize(v->backend, &v->mesh, NULL, OST_FILL_WINDING, &report, &tool, v->err);
    const int64_t created = bench_now();
    if (status == OST_OK)
        status = ost_tool_download(tool, &volume, v->err);
    const int64_t end = bench_now();
    ost_tool_volume_free(&volume);
    ost_tool_free(tool);
    if (timed) {
        bench_series_add(&v->ours_tool, (double)(created - begin));
        bench_series_add(&v->ours_bytes, (double)(end - begin));
    }
    return status;
}

static ost_status time_bits(voxelize *v)
{
    ost_voxelize_report report;
    int64_t begin = bench_now();
    ost_status status = make_bits(v, &report);
    bench_series_add(&v->ours_bits, (double)(bench_now() - begin));
    return status;
}

static void time_embree(voxelize *v, bool low_quality, bench_series *series)
{
    ost_baseline_embree_times times;
    int64_t begin = bench_now();
    v->embree_solid = ost_baseline_embree(&v->mesh, v->options->threads, low_quality, v->bits, &times);
    int64_t end = bench_now();
    v->has_embree = v->embree_solid >= 0;
    if (series && v->has_embree)
        bench_series_add(series, (double)(end - begin));
}

static ost_status repeat(voxelize *v, int count)
{
    const ost_dims d = v->mesh.grid.dims;
    v->bits = calloc((size_t)(d.x + 63) / 64 * (size_t)d.y * (size_t)d.z, sizeof *v->bits);
    ost_status status = v->bits ? time_tool(v, false)
                                : ost_fail(v->err, OST_ERR_MEMORY, "out of memory for the baseline's bits");
    if (status == OST_OK)
        time_embree(v, false, NULL);
    for (int i = 0; i < count && status == OST_OK; i++) {
        status = time_tool(v, true);
        if (status == OST_OK && v->own_bits)
            status = time_bits(v);
        for (int low = 0; low < 2 && v->has_embree; low++)
            time_embree(v, low, &v->embree[low]);
    }
    return status;
}

/* The names of the three rows of a mesh: bits, tool and bytes. */
typedef struct row_names {
    char name[3][BENCH_NAME];
} row_names;

static row_names names_of(const char *mesh)
{
    static const char *const suffix[3] = {"", "/tool", "/bytes"};
    row_names names;
    for (int i = 0; i < 3; i++)
        snprintf(names.name[i], BENCH_NAME, "voxelize/%.32s%s", mesh, suffix[i]);
    return names;
}

static bool any_wanted(const bench_options *options, const row_names *names)
{
    return bench_wanted(options, names->name[0]) || bench_wanted(options, names->name[1]) ||
           bench_wanted(options, names->name[2]);
}

static ost_status not_run(const bench_options *options, bench_table *table, const row_names *names, ost_status status,
                          ost_error *err)
{
    const char *const list[] = {names->name[0], names->name[1], names->name[2]};
    return bench_row_not_run(options, table, list, 3, "ms", options->threads, status, err);
}

static ost_status add_row(voxelize *v, const char *name, bench_series *ours)
{
    if (v->options->filter && !strstr(name, v->options->filter))
        return OST_OK;
    bench_row *row = bench_row_add(v->table, name, "ms", v->options->threads);
    if (!row)
        return ost_fail(v->err, OST_ERR_MEMORY, "out of memory for a row");
    row->equal = v->equal;
    if (!v->equal)
        return OST_OK;
    if (ours->count == 0) {
        snprintf(row->reason, sizeof row->reason, "this backend makes bytes alone");
        return OST_OK;
    }
    const bool low = bench_series_at(&v->embree[1], 0) < bench_series_at(&v->embree[0], 0);
    bench_row_ours(row, ours);
    bench_row_baseline(row, &v->embree[low],
                       low ? "Embree ray packets with an all-hits filter, bits out, fast build"
                           : "Embree ray packets with an all-hits filter, bits out");
    if (!v->has_embree)
        snprintf(row->baseline_reason, sizeof row->baseline_reason,
                 "Embree is not built in; install libembree-dev and build again");
    bench_row_extra(row, "triangles", (double)v->mesh.triangle_count);
    bench_row_extra(row, "voxels", (double)ost_dims_count(v->mesh.grid.dims));
    bench_row_extra(row, "solid_voxels", (double)v->report.solid_voxels);
    if (v->has_embree)
        bench_row_extra(row, "baseline_solid_voxels", (double)v->embree_solid);
    return OST_OK;
}

/* Measures the voxelization of a mesh. The caller retains the ownership of mesh and grid. */
static ost_status measure(const bench_options *options, bench_table *table, const row_names *names,
                          const ost_mesh *mesh, const ost_tool_geometry *grid, int count, ost_error *err)
{
    voxelize v = {.options = options, .table = table, .err = err};
    ost_status status = ost_mesh_snap(mesh, grid, &v.mesh, err);
    if (status == OST_OK)
        status = bench_backend(options, options->threads, &v.backend, err);
    if (status == OST_OK && v.backend->ops == &ost_backend_cpu) {
        v.own_bits = bench_tool_bits(v.mesh.grid.dims, err);
        status = v.own_bits ? OST_OK : err->status;
    }
    if (status == OST_OK)
        status = verify(&v);
    if (status == OST_OK && v.equal)
        status = repeat(&v, bench_repeat(options, count));
    bench_series *const ours[] = {&v.ours_bits, &v.ours_tool, &v.ours_bytes};
    for (int i = 0; i < 3 && status == OST_OK; i++)
        status = add_row(&v, names->name[i], ours[i]);
    bench_series_free(&v.ours_tool);
    bench_series_free(&v.ours_bytes);
    bench_series_free(&v.ours_bits);
    free(v.own_bits);
    bench_series_free(&v.embree[0]);
    bench_series_free(&v.embree[1]);
    free(v.bits);
    ost_snapped_mesh_free(&v.mesh);
    ost_backend_close(v.backend);
    return status;
}

static ost_status cube(const bench_options *options, bench_table *table, const char *name,
                       ost_status (*make)(ost_pm side, ost_mesh *out, ost_error *err), int32_t side, ost_error *err)
{
    char name_of_cube[BENCH_NAME];
    ost_mesh mesh = {0};
    const ost_tool_geometry grid = {.dims = {side, side, side}, .voxel = CUBE_VOXEL};
    /* the total size of two volumes on the host and one grid on a backend, all of which exist at the same time */
    const double bytes = 3.0 * (double)side * (double)side * (double)side + 2e8;
    snprintf(name_of_cube, sizeof name_of_cube, "%s/%d", name, side);
    const row_names names = names_of(name_of_cube);
    if ((options->quick && side > 512) || !any_wanted(options, &names))
        return OST_OK;
    if (bytes > (double)bench_memory()) {
        bench_row *row = bench_row_add(table, names.name[0], "ms", options->threads);
        if (row)
            snprintf(row->reason, sizeof row->reason,
                     "comparing two grids of %d^3 voxels takes %.1f GB; less is free here", side, bytes * 1e-9);
        return row ? OST_OK : ost_fail(err, OST_ERR_MEMORY, "out of memory for a row");
    }
    ost_status status = make(side * CUBE_VOXEL, &mesh, err);
    if (status == OST_OK)
        status = measure(options, table, &names, &mesh, &grid, REPEAT, err);
    ost_mesh_free(&mesh);
    return not_run(options, table, &names, status, err);
}

static ost_status tool(const bench_options *options, bench_table *table, ost_tool_kind kind, ost_error *err)
{
    char name[BENCH_NAME];
    ost_mesh mesh = {0};
    ost_tool_geometry grid;
    ost_pm3 lo, hi;
    snprintf(name, sizeof name, "%s/0.5", ost_tool_kind_name(kind));
    const row_names names = names_of(name);
    if (!any_wanted(options, &names))
        return OST_OK;
    ost_status status = ost_tool_make(kind, NULL, &mesh, err);
    if (status == OST_OK)
        status = ost_mesh_bounds(&mesh, &lo, &hi, err);
    if (status == OST_OK)
        status = ost_tool_geometry_from_bounds(lo, hi, OST_PM_PER_MM / 2, &grid, err);
    if (status == OST_OK)
        status = measure(options, table, &names, &mesh, &grid, REPEAT_SMALL, err);
    ost_mesh_free(&mesh);
    return not_run(options, table, &names, status, err);
}

ost_status bench_voxelize(const bench_options *options, bench_table *table, ost_error *err)
{
    static const int32_t sides[] = {256, 512, 1024};
    ost_status status = OST_OK;
    for (size_t i = 0; i < sizeof sides / sizeof sides[0]; i++) {
        if (status == OST_OK)
            status = cube(options, table, "sphere80k", bench_sphere, sides[i], err);
        if (status == OST_OK)
            status = cube(options, table, "knot524k", bench_knot, sides[i], err);
    }
    if (status == OST_OK)
        status = tool(options, table, OST_TOOL_REAMER, err);
    if (status == OST_OK)
        status = tool(options, table, OST_TOOL_PEG, err);
    return status;
}
