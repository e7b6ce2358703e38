/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Compares two methods by which the cpu backend's voxelizer finds the triangles that a row may cross. One method sorts
 * the triangles into bins, one bin per tile (cpu/voxelize/bins.c). The other method casts rays with Embree
 * (cpu/voxelize/embree.c). The same code then computes the crossings, and the grids are equal.
 *
 *   candidates/sphere/TRIANGLES/N   one sphere in a cube of N^3 voxels
 *   candidates/balls/TRIANGLES/N    1,000 spheres that do not touch, in one mesh
 *   NAME/1                          one thread
 *
 * osteon's time is measured with bins (voxelizer=auto), and the baseline's time with Embree (voxelizer=embree). The
 * baseline's time includes building Embree's hierarchy, because a mesh is usually voxelized only once. With both
 * methods, the memory for the bits is written once before the measurement.
 */
#include "bench/bench.h"
#include "bench/meshes.h"
#include "bench/tool_bits.h"

#include "cpu/voxelize/voxelize.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { REPEAT = 7, QUICK_SIDE = 64, QUICK_TRIANGLES = 10000 };
#define CUBE_VOXEL (OST_PM_PER_MM / 10)

typedef struct shape {
    const char *name;
    int across, meridians, rings; /* bench_balls */
} shape;

static const shape shapes[] = {
    {"sphere", 1, 8, 4},       {"sphere", 1, 64, 32}, {"sphere", 1, 512, 256},
    {"sphere", 1, 1024, 1024}, {"balls", 10, 16, 8},
};
static const int32_t sides[] = {64, 256, 1024};

static size_t triangles_of(const shape *s)
{
    return 2 * (size_t)s->meridians * (size_t)s->rings * (size_t)s->across * (size_t)s->across * (size_t)s->across;
}

static ost_status voxelize(ost_backend *backend, const ost_snapped_mesh *mesh, uint64_t *bits, bench_series *series,
                           ost_error *err)
{
    ost_voxelize_report report;
    const int64_t begin = bench_now();
    ost_status status = ost_cpu_voxelize((const cpu_backend *)backend, mesh, NULL, OST_FILL_WINDING, &report,
                                         &(ost_vox_result){.cutting = bits}, err);
    if (series)
        bench_series_add(series, (double)(bench_now() - begin));
    return status;
}

/* Sets *equal to true if the grids of both methods equal the reference's grid, and to false if not. */
static ost_status verify(ost_backend *const backends[2], const ost_snapped_mesh *mesh, uint64_t *bits, bool *equal,
                         ost_error *err)
{
    ost_backend *ref = NULL;
    ost_tool_volume expected = {0};
    ost_voxelize_report report;
    ost_status status = ost_backend_open("ref", &ref, err);
    if (status == OST_OK)
        status = bench_tool_voxels(ref, mesh, &expected, &report, err);
    *equal = true;
    for (int b = 0; b < 2 && status == OST_OK; b++) {
        status = voxelize(backends[b], mesh, bits, NULL, err);
        *equal = *equal && bench_tool_bits_are(bits, mesh->grid.dims, expected.voxels);
    }
    ost_tool_volume_free(&expected);
    ost_backend_close(ref);
    return status;
}

/* Adds a row that compares the two methods for a snapped mesh. */
static ost_status compare(const bench_options *options, bench_table *table, const char *name, int threads,
                          const ost_snapped_mesh *mesh, ost_error *err)
{
    static const char *const voxelizers[2] = {"auto", "embree"};
    ost_backend *backends[2] = {NULL, NULL};
    bench_series series[2] = {{0}, {0}};
    bool equal = false;
    uint64_t *bits = bench_tool_bits(mesh->grid.dims, err);
    ost_status status = bits ? OST_OK : err->status;
    for (int b = 0; b < 2 && status == OST_OK; b++) {
        char spec[64];
        snprintf(spec, sizeof spec, "cpu:threads=%d,voxelizer=%s", threads, voxelizers[b]);
        status = ost_backend_open(spec, &backends[b], err);
    }
    if (status == OST_OK)
        status = verify(backends, mesh, bits, &equal, err);
    for (int i = 0; equal && i < bench_repeat(options, REPEAT); i++)
        for (int b = 0; b < 2 && status == OST_OK; b++)
            status = voxelize(backends[b], mesh, bits, &series[b], err);
    bench_row *row = status == OST_OK ? bench_row_add(table, name, "ms", threads) : NULL;
    if (status == OST_OK && !row)
        status = ost_fail(err, OST_ERR_MEMORY, "out of memory for a row");
    if (row) {
        row->equal = equal;
        if (equal) {
            bench_row_ours(row, &series[0]);
            bench_row_baseline(row, &series[1], "the same voxelizer, for which Embree finds the triangles");
            bench_row_extra(row, "triangles", (double)mesh->triangle_count);
            bench_row_extra(row, "voxels", (double)ost_dims_count(mesh->grid.dims));
        }
    }
    for (int b = 0; b < 2; b++) {
        bench_series_free(&series[b]);
        ost_backend_close(backends[b]);
    }
    free(bits);
    return status;
}

static ost_status measure(const bench_options *options, bench_table *table, const shape *s, int32_t side,
                          ost_error *err)
{
    char full[BENCH_NAME], one[BENCH_NAME];
    snprintf(full, sizeof full, "candidates/%s/%zu/%d", s->name, triangles_of(s), side);
    snprintf(one, sizeof one, "%.40s/1", full);
    if (options->quick && (side > QUICK_SIDE || triangles_of(s) > QUICK_TRIANGLES))
        return OST_OK;
    const bool wanted[2] = {bench_wanted(options, full), options->threads > 1 && bench_wanted(options, one)};
    if (!wanted[0] && !wanted[1])
        return OST_OK;
    const ost_tool_geometry grid = {.dims = {side, side, side}, .voxel = CUBE_VOXEL};
    ost_mesh mesh = {0};
    ost_snapped_mesh snapped = {0};
    ost_status status = bench_balls(side * CUBE_VOXEL, s->across, s->meridians, s->rings, &mesh, err);
    if (status == OST_OK)
        status = ost_mesh_snap(&mesh, &grid, &snapped, err);
    if (status == OST_OK && wanted[0])
        status = compare(options, table, full, options->threads, &snapped, err);
    if (status == OST_OK && wanted[1])
        status = compare(options, table, one, 1, &snapped, err);
    ost_snapped_mesh_free(&snapped);
    ost_mesh_free(&mesh);
    const char *const names[] = {full, wanted[1] ? one : NULL};
    return bench_row_not_run(options, table, names, 2, "ms", options->threads, status, err);
}

ost_status bench_candidates(const bench_options *options, bench_table *table, ost_error *err)
{
    ost_status status = OST_OK;
    for (size_t s = 0; s < sizeof shapes / sizeof shapes[0]; s++)
        for (size_t i = 0; i < sizeof sides / sizeof sides[0] && status == OST_OK; i++)
            status = measure(options, table, &shapes[s], sides[i], err);
    return status;
}
