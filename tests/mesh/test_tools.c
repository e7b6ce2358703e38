/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the parametric tools. Their meshes must be closed and have outward normals and the expected sizes.
 * They must give the grids of the thesis, even after their coordinates are rounded to float32 as in an STL
 * file. A rotating reamer must sweep the expected shape.
 *
 * Covers: REQ-VOLUME, AR-TOOL-2
 */
#include <math.h>

#include "mesh_make.h"

enum { SIZES = 3 };
static const ost_pm voxels[SIZES] = {1000000000, 750000000, 500000000};

static void make(ost_tool_kind kind, const ost_tool_options *options, ost_mesh *mesh)
{
    ost_error err = {0};
    size_t open = 1;
    assert_ok(ost_tool_make(kind, options, mesh, &err));
    assert_ok(ost_mesh_open_edges(mesh, &open, &err));
    assert_int_equal(open, 0);
    assert_true(ost_mesh_volume_mm3(mesh) > 0);
}

static void assert_bounds(const ost_mesh *mesh, ost_pm3 min, ost_pm3 max)
{
    ost_error err = {0};
    ost_pm3 lo, hi;
    assert_ok(ost_mesh_bounds(mesh, &lo, &hi, &err));
    assert_memory_equal(&lo, &min, sizeof lo);
    assert_memory_equal(&hi, &max, sizeof hi);
}

/* Rounds coordinates to float32, as an STL file stores them. */
static void round_to_float(ost_mesh *mesh)
{
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        ost_pm3 *p = &mesh->vertices[i];
        assert_true(ost_pm_from_binary((float)ost_pm_to_mm(p->x), &p->x) &&
                    ost_pm_from_binary((float)ost_pm_to_mm(p->y), &p->y) &&
                    ost_pm_from_binary((float)ost_pm_to_mm(p->z), &p->z));
    }
}

static ost_snapped_mesh snap(const ost_mesh *mesh, ost_pm voxel)
{
    ost_error err = {0};
    ost_pm3 min, max;
    ost_tool_geometry grid;
    ost_snapped_mesh out;
    assert_ok(ost_mesh_bounds(mesh, &min, &max, &err));
    assert_ok(ost_tool_geometry_from_bounds(min, max, voxel, &grid, &err));
    assert_ok(ost_mesh_snap(mesh, &grid, &out, &err));
    return out;
}

/*
 * Returns the number of voxels that overlap the bounding box of at least one triangle. The count of solid
 * voxels can deviate from the volume only because of these voxels.
 */
static int64_t surface_voxels(const ost_snapped_mesh *mesh)
{
    const ost_dims d = mesh->grid.dims;
    const int f = mesh->fraction_bits;
    uint8_t *touched = calloc((size_t)ost_dims_count(d), 1);
    assert_non_null(touched);
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        int32_t lo[3], hi[3];
        for (int a = 0; a < 3; a++) {
            lo[a] = hi[a] = mesh->vertices[mesh->triangles[t][0]][a] >> f;
            for (int c = 1; c < 3; c++) {
                int32_t v = mesh->vertices[mesh->triangles[t][c]][a] >> f;
                lo[a] = v < lo[a] ? v : lo[a];
                hi[a] = v > hi[a] ? v : hi[a];
            }
        }
        for (int32_t k = lo[2]; k <= hi[2]; k++)
            for (int32_t j = lo[1]; j <= hi[1]; j++)
                for (int32_t i = lo[0]; i <= hi[0]; i++)
                    touched[i + d.x * (j + (int64_t)d.y * k)] = 1;
    }
    int64_t count = 0;
    for (int64_t i = 0; i < ost_dims_count(d); i++)
        count += touched[i];
    free(touched);
    return count;
}

static void assert_volumes_agree(const ost_mesh *mesh, ost_pm voxel)
{
    ost_snapped_mesh snapped = snap(mesh, voxel);
    ost_voxelize_report report;
    free(make_grid(&snapped, OST_FILL_WINDING, &report));
    const double one = pow(ost_pm_to_mm(voxel), 3), solid = (double)report.solid_voxels * one;
    assert_int_equal(report.leaking_rows, 0);
    assert_true(fabs(solid - ost_mesh_volume_mm3(mesh)) <= (double)surface_voxels(&snapped) * one);
    ost_snapped_mesh_free(&snapped);
}

static void reamer_has_the_dimensions_of_the_thesis(void **state)
{
    (void)state;
    static const ost_dims dims[SIZES] = {{38, 38, 23}, {50, 50, 30}, {73, 74, 43}};
    ost_mesh mesh;
    make(OST_TOOL_REAMER, NULL, &mesh);
    assert_bounds(&mesh, (ost_pm3){-18000000000, -18000000000, 0}, (ost_pm3){17400000000, 18000000000, 20300000000});
    for (int rounded = 0; rounded < 2; rounded++) {
        for (int i = 0; i < SIZES; i++) {
            ost_snapped_mesh snapped = snap(&mesh, voxels[i]);
            assert_memory_equal(&snapped.grid.dims, &dims[i], sizeof dims[i]);
            ost_snapped_mesh_free(&snapped);
            assert_volumes_agree(&mesh, voxels[i]);
        }
        round_to_float(&mesh);
    }
    ost_mesh_free(&mesh);
}

static void grid_volume_equals_mesh_volume(void **state)
{
    (void)state;
    for (int kind = 0; kind < OST_TOOL_KIND_COUNT; kind++) {
        ost_mesh mesh;
        make((ost_tool_kind)kind, NULL, &mesh);
        assert_volumes_agree(&mesh, 250000000);
        ost_mesh_free(&mesh);
    }
    ost_mesh mesh;
    make(OST_TOOL_PEG, &(ost_tool_options){.segments = 3072}, &mesh);
    assert_true(fabs(ost_mesh_volume_mm3(&mesh) / (3.14159265358979 * 9 * 30) - 1) < 1e-5);
    assert_bounds(&mesh, (ost_pm3){-3000000000, -3000000000, 0}, (ost_pm3){3000000000, 3000000000, 30000000000});
    ost_mesh_free(&mesh);
    make(OST_TOOL_BURR, &(ost_tool_options){.segments = 1024}, &mesh);
    /*
     * The expected volume is the volume of a sphere of radius 3 mm plus that of a shaft of radius 1 mm, minus the
     * cap of the sphere that lies within the shaft. The shaft begins at the height where its side meets the
     * sphere, and ends at the height of 26 mm.
     */
    const double pi = 3.14159265358979, root = 3 + sqrt(8.0), cap = 6 - root;
    const double volume = pi * 4 / 3 * 27 - pi * cap * cap * (9 - cap) / 3 + pi * (26 - root);
    assert_true(fabs(ost_mesh_volume_mm3(&mesh) / volume - 1) < 1e-4);
    assert_bounds(&mesh, (ost_pm3){-3000000000, -3000000000, 0}, (ost_pm3){3000000000, 3000000000, 26000000000});
    ost_mesh_free(&mesh);
}

/*
 * Head and shaft of a tool must be closed and must coincide at the seam. Together they must have
 * the volume of the complete tool. The sphere of a burr is complete, and the burr's shaft begins
 * inside the sphere.
 */
static void head_and_shaft_form_the_tool(void **state)
{
    (void)state;
    const double pi = 3.14159265358979;
    ost_mesh complete, head, shaft;
    ost_error err = {0};
    make(OST_TOOL_REAMER, NULL, &complete);
    make(OST_TOOL_REAMER, &(ost_tool_options){.part = OST_TOOL_HEAD}, &head);
    make(OST_TOOL_REAMER, &(ost_tool_options){.part = OST_TOOL_SHAFT}, &shaft);
    assert_true(fabs(ost_mesh_volume_mm3(&head) + ost_mesh_volume_mm3(&shaft) - ost_mesh_volume_mm3(&complete)) < 1e-3);
    /* The hub has a diameter of 13.2 to 14.8 mm at its widest point, and lies behind the cutting face. */
    ost_pm3 lo, hi;
    assert_ok(ost_mesh_bounds(&shaft, &lo, &hi, &err));
    assert_true(hi.x <= 7400000000 && hi.z == 20300000000 && lo.z > 12000000000);
    ost_mesh_free(&complete);
    ost_mesh_free(&head);
    ost_mesh_free(&shaft);
    make(OST_TOOL_BURR, &(ost_tool_options){.part = OST_TOOL_HEAD, .segments = 1024}, &head);
    make(OST_TOOL_BURR, &(ost_tool_options){.part = OST_TOOL_SHAFT, .segments = 1024}, &shaft);
    assert_true(fabs(ost_mesh_volume_mm3(&head) / (pi * 36) - 1) < 1e-4);
    assert_true(fabs(ost_mesh_volume_mm3(&shaft) / (pi * 23) - 1) < 1e-4);
    ost_mesh_free(&head);
    ost_mesh_free(&shaft);
    assert_false(ost_tool_has_shaft(OST_TOOL_PEG));
    assert_int_equal(ost_tool_make(OST_TOOL_PEG, &(ost_tool_options){.part = OST_TOOL_SHAFT}, &shaft, &err),
                     OST_ERR_USAGE);
    assert_int_equal(ost_tool_make(OST_TOOL_REAMER, &(ost_tool_options){.part = OST_TOOL_SHAFT, .length = 16200000000},
                                   &shaft, &err),
                     OST_ERR_USAGE);
}

/*
 * At each distance from the axis, a rotating tool sweeps the space down to the lowest point of the mesh at
 * that distance. No vertex of the reamer may lie below the sphere of radius 27 mm around (0, 0, 27). On
 * every ring, some vertices must lie on the sphere, distributed over the complete circumference.
 */
static void rotating_reamer_sweeps_a_sphere(void **state)
{
    (void)state;
    ost_mesh mesh;
    make(OST_TOOL_REAMER, NULL, &mesh);
    int crests[37] = {0};
    for (size_t i = 0; i < mesh.vertex_count; i++) {
        const double x = ost_pm_to_mm(mesh.vertices[i].x), y = ost_pm_to_mm(mesh.vertices[i].y),
                     z = ost_pm_to_mm(mesh.vertices[i].z);
        const double r = sqrt(x * x + y * y), dome = 27 - sqrt(27 * 27 - fmin(r, 18) * fmin(r, 18));
        assert_true(z >= dome - 1e-8);
        if (z <= dome + 1e-8)
            crests[(int)(r * 2 + 0.001)]++;
    }
    /* a ring is 18/28 mm wide, so at least one of two adjacent bins contains a ring */
    for (int half_mm = 2; half_mm < 36; half_mm++)
        assert_true(crests[half_mm] + crests[half_mm + 1] >= 24);
    ost_mesh_free(&mesh);
}

static void sizes_scale_and_are_limited(void **state)
{
    (void)state;
    ost_mesh mesh;
    make(OST_TOOL_REAMER, &(ost_tool_options){.diameter = 40000000000, .length = 30000000000, .segments = 48}, &mesh);
    assert_int_equal(mesh.vertices[mesh.vertex_count - 1].x, 0);
    ost_error bounds_err = {0};
    ost_pm3 lo, hi;
    assert_int_equal(ost_mesh_bounds(&mesh, &lo, &hi, &bounds_err), OST_OK);
    assert_int_equal(lo.x, -20000000000);
    assert_int_equal(hi.z, 30000000000);
    ost_mesh_free(&mesh);
    static const int segments[] = {12, 16, 96, 400, 3072};
    for (int kind = OST_TOOL_PEG; kind <= OST_TOOL_BURR; kind++)
        for (size_t i = 0; i < sizeof segments / sizeof segments[0]; i++) {
            make((ost_tool_kind)kind,
                 &(ost_tool_options){.segments = segments[i] > 400 && kind == OST_TOOL_BURR ? 400 : segments[i]},
                 &mesh);
            ost_mesh_free(&mesh);
        }

    static const struct {
        ost_tool_kind kind;
        ost_tool_options options;
        const char *message;
    } rows[] = {
        {OST_TOOL_REAMER, {.segments = 100}, "multiple of 24 segments, not 100"},
        {OST_TOOL_REAMER, {.length = 10000000000}, "at least 16.2 mm"},
        {OST_TOOL_PEG, {.segments = 30}, "multiple of 4"},
        {OST_TOOL_PEG, {.segments = 8}, "from 12 to 3072"},
        {OST_TOOL_PEG, {.diameter = -1}, "diameter of"},
        {OST_TOOL_BURR, {.length = 2000000000000}, "length of 2000 mm"},
        {OST_TOOL_KIND_COUNT, {0}, "reamer, peg and burr"},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ost_error err = {0};
        assert_int_equal(ost_tool_make(rows[i].kind, &rows[i].options, &mesh, &err), OST_ERR_USAGE);
        if (!strstr(err.text, rows[i].message))
            fail_msg("row %zu: the error '%s' does not contain '%s'", i, err.text, rows[i].message);
    }
    assert_string_equal(ost_tool_kind_name(OST_TOOL_BURR), "burr");
    assert_string_equal(ost_tool_kind_name(OST_TOOL_KIND_COUNT), "unknown");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(head_and_shaft_form_the_tool),
        cmocka_unit_test(reamer_has_the_dimensions_of_the_thesis),
        cmocka_unit_test(grid_volume_equals_mesh_volume),
        cmocka_unit_test(rotating_reamer_sweeps_a_sphere),
        cmocka_unit_test(sizes_scale_and_are_limited),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
