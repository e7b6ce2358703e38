/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the computation of a tool's grid from the bounds of its mesh, and the snapping of vertices to the
 * lattice. The tests include the numbers of the thesis, ties, limits, and a mesh that is moved by an
 * integer number of voxels.
 *
 * Covers: AR-TOOL-1, AR-TOOL-2, AR-TOOL-3, AR-MESH-3, AR-MESH-4, AR-DIG-7
 */
#include "mesh_make.h"

static ost_pm mm(double value)
{
    /* rounds to the nearest nanometre; used for literals */
    return (ost_pm)(value * 1e6 + (value < 0 ? -0.5 : 0.5)) * 1000;
}

/* The expected numbers are computed by hand in docs/spec/arithmetic.md, AR-TOOL-2. */
static void the_reamer_has_the_thesis_grids(void **state)
{
    (void)state;
    static const struct {
        double voxel, corner[3];
        ost_dims dims;
    } rows[] = {
        {1.0, {-19, -19, -1}, {38, 38, 23}},
        {0.75, {-18.75, -18.75, -0.75}, {50, 50, 30}},
        {0.5, {-18.5, -18.5, -0.5}, {73, 74, 43}},
    };
    for (size_t i = 0; i < 3; i++) {
        ost_error err = {0};
        ost_tool_geometry g;
        assert_ok(ost_tool_geometry_from_bounds((ost_pm3){mm(-18), mm(-18), 0}, (ost_pm3){mm(17.4), mm(18), mm(20.3)},
                                                mm(rows[i].voxel), &g, &err));
        assert_int_equal(g.dims.x, rows[i].dims.x);
        assert_int_equal(g.dims.y, rows[i].dims.y);
        assert_int_equal(g.dims.z, rows[i].dims.z);
        assert_int_equal(g.corner.x, mm(rows[i].corner[0]));
        assert_int_equal(g.corner.y, mm(rows[i].corner[1]));
        assert_int_equal(g.corner.z, mm(rows[i].corner[2]));
    }
}

/*
 * For any position of the mesh, a tool's grid must have a margin of one or two empty voxels on each side.
 * The grid must contain every point of the mesh's bounds.
 */
static void every_grid_has_a_margin(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("margin");
    for (int round = 0; round < 20000; round++) {
        ost_error err = {0};
        const ost_pm voxel = rng_range(&rng, 0, 1) ? rng_range(&rng, 1, 340) * 25 * 1000 * 1000
                                                   : rng_range(&rng, OST_TOOL_VOXEL_MIN, mm(9));
        ost_pm lo[3], hi[3];
        for (int a = 0; a < 3; a++) {
            lo[a] = rng_range(&rng, 0, 1) ? rng_range(&rng, -700, 700) * voxel / 2 : rng_range(&rng, mm(-900), mm(900));
            hi[a] = lo[a] + rng_range(&rng, 0, 500) * voxel / rng_range(&rng, 1, 3);
        }
        ost_tool_geometry g;
        assert_ok(ost_tool_geometry_from_bounds((ost_pm3){lo[0], lo[1], lo[2]}, (ost_pm3){hi[0], hi[1], hi[2]}, voxel,
                                                &g, &err));
        const ost_pm corner[3] = {g.corner.x, g.corner.y, g.corner.z};
        const int32_t dims[3] = {g.dims.x, g.dims.y, g.dims.z};
        for (int a = 0; a < 3; a++) {
            const ost_pm before = lo[a] - corner[a], after = corner[a] + dims[a] * voxel - hi[a];
            assert_true(before >= voxel && before <= 2 * voxel);
            assert_true(after >= voxel && after <= 2 * voxel);
            assert_int_equal(corner[a] % voxel, 0);
        }
    }
}

static void values_beyond_the_limits_are_refused(void **state)
{
    (void)state;
    static const struct {
        double size[3], voxel;
        const char *message;
    } rows[] = {
        {{10, 10, 10}, 0.0009, "0.0009 mm"}, {{10, 10, 10}, 100.1, "100.1 mm"},
        {{10, 10, 10}, 0, "0 mm"},           {{4095, 1, 1}, 1, "4098 voxels long in x"},
        {{1, 1, 7000}, 0.5, "long in z"},    {{2100, 2100, 2100}, 1, "2^33"},
        {{8001, 1, 1}, 100, "8000 mm"},      {{10, -10, 10}, 1, "y runs"},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ost_error err = {0};
        ost_tool_geometry g;
        ost_status status = ost_tool_geometry_from_bounds(
            (ost_pm3){0, 0, 0}, (ost_pm3){mm(rows[i].size[0]), mm(rows[i].size[1]), mm(rows[i].size[2])},
            mm(rows[i].voxel), &g, &err);
        assert_int_equal(ost_status_exit(status), 2);
        if (!strstr(err.text, rows[i].message))
            fail_msg("row %zu: the error '%s' does not contain '%s'", i, err.text, rows[i].message);
    }
    ost_error err = {0};
    ost_tool_geometry g;
    assert_ok(ost_tool_geometry_from_bounds((ost_pm3){0, 0, 0}, (ost_pm3){mm(4093), mm(1), mm(1)}, mm(1), &g, &err));
}

/* Makes a triangle with coordinates in picometres, and one unused vertex. */
static void four_vertices(ost_mesh *mesh, const ost_pm3 p[4], uint32_t a, uint32_t b, uint32_t c)
{
    ost_error err = {0};
    assert_ok(ost_mesh_init(mesh, 4, 1, &err));
    memcpy(mesh->vertices, p, 4 * sizeof *p);
    mesh->triangles[0][0] = a;
    mesh->triangles[0][1] = b;
    mesh->triangles[0][2] = c;
}

static void vertices_are_rounded_half_to_even(void **state)
{
    (void)state;
    /* The lattice has a step of 2000 pm. */
    const ost_tool_geometry grid = {.dims = {8, 8, 8}, .voxel = 1024 * 2000, .corner = {-4000, 0, 0}};
    const ost_pm3 p[4] = {
        {-4000 + 1000, 3000, 0}, {5000 - 4000, 4999, 1024 * 2000}, {0, 8 * 1024 * 2000, 5001}, {1, 2, 3}};
    ost_error err = {0};
    ost_mesh mesh;
    ost_snapped_mesh out;
    four_vertices(&mesh, p, 0, 1, 2);
    assert_ok(ost_mesh_snap(&mesh, &grid, &out, &err));
    assert_int_equal(out.fraction_bits, 10);
    static const int32_t expected[4][3] = {{0, 2, 0}, {2, 2, 1024}, {2, 8192, 3}, {0, 0, 0}};
    assert_memory_equal(out.vertices, expected, sizeof expected);
    assert_int_equal(out.triangle_count, 1);
    ost_snapped_mesh_free(&out);
    assert_null(out.vertices);

    mesh.vertices[2].y++; /* the vertex is now one picometre outside the grid */
    assert_int_equal(ost_mesh_snap(&mesh, &grid, &out, &err), OST_ERR_RANGE);
    assert_non_null(strstr(err.text, "vertex 2"));
    mesh.triangles[0][1] = 4;
    assert_int_equal(ost_mesh_snap(&mesh, &grid, &out, &err), OST_ERR_USAGE);
    assert_non_null(strstr(err.text, "vertex 4 of 4"));
    ost_mesh_free(&mesh);
}

static void fraction_bits_fit_the_grid(void **state)
{
    (void)state;
    static const struct {
        int32_t width;
        int bits;
    } rows[] = {{2, 10}, {1024, 10}, {1025, 9}, {2048, 9}, {2049, 8}, {4096, 8}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ost_error err = {0};
        ost_mesh mesh = {0};
        ost_snapped_mesh out;
        const ost_tool_geometry grid = {.dims = {2, rows[i].width, 2}, .voxel = OST_PM_PER_MM};
        assert_ok(ost_mesh_snap(&mesh, &grid, &out, &err));
        assert_int_equal(out.fraction_bits, rows[i].bits);
        assert_int_equal(out.triangle_count, 0);
        ost_snapped_mesh_free(&out);
    }
}

/*
 * A zero-area triangle, whose vertices coincide or lie on a line, must be dropped. This also applies to
 * triangles that lose their area by rounding to the lattice.
 */
static void triangles_without_area_are_dropped(void **state)
{
    (void)state;
    const ost_tool_geometry grid = {.dims = {8, 8, 8}, .voxel = 1024 * 2000};
    static const ost_pm3 p[][4] = {
        {{0, 0, 0}, {4000, 0, 0}, {4000, 0, 0}, {0, 0, 0}},
        {{0, 0, 0}, {4000, 4000, 4000}, {8000, 8000, 8000}, {0, 0, 0}},
        {{0, 0, 0}, {4000, 4000, 900}, {8000, 8000, -0}, {0, 0, 0}},
    };
    for (size_t i = 0; i < 3; i++) {
        ost_error err = {0};
        ost_mesh mesh;
        ost_snapped_mesh out;
        four_vertices(&mesh, p[i], 0, 1, 2);
        assert_ok(ost_mesh_snap(&mesh, &grid, &out, &err));
        assert_int_equal(out.triangle_count, 0);
        assert_int_equal(out.dropped_triangles, 1);
        ost_snapped_mesh_free(&out);
        mesh.vertices[1].z += 2000; /* one more lattice step gives the triangle an area */
        assert_ok(ost_mesh_snap(&mesh, &grid, &out, &err));
        assert_int_equal(out.triangle_count, 1);
        ost_snapped_mesh_free(&out);
        ost_mesh_free(&mesh);
    }
}

/*
 * If a mesh is moved by an integer number of voxels, its solid voxels must move by the same number, even if
 * points of the mesh lie on surfaces of voxels. Only the bounds of the grid may differ, and only if the
 * rounding of a bound is a tie.
 */
static void shift_by_voxels_moves_the_grid(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("shift");
    for (int round = 0; round < 40; round++) {
        ost_error err = {0};
        const ost_pm voxel = rng_range(&rng, 1, 40) * (OST_PM_PER_MM / 20);
        ost_snapped_mesh net = make_closed(&rng, (ost_dims){6, 6, 6}, 3, 4);
        const ost_pm origin[3] = {rng_range(&rng, -mm(20), mm(20)), rng_range(&rng, -50, 50) * voxel / 2,
                                  rng_range(&rng, -50, 50) * voxel};
        uint8_t *grids[2];
        ost_tool_geometry g[2];
        int64_t solid[2] = {0};
        const int64_t shift[3] = {rng_range(&rng, -300, 300), rng_range(&rng, -300, 300), rng_range(&rng, -300, 300)};
        for (int n = 0; n < 2; n++) {
            ost_mesh mesh;
            ost_snapped_mesh snapped;
            ost_pm3 min, max;
            assert_ok(ost_mesh_init(&mesh, net.vertex_count, net.triangle_count, &err));
            for (size_t i = 0; i < net.vertex_count; i++) {
                ost_pm p[3];
                for (int a = 0; a < 3; a++)
                    p[a] = origin[a] + net.vertices[i][a] * voxel / MAKE_ONE + n * shift[a] * voxel;
                mesh.vertices[i] = (ost_pm3){p[0], p[1], p[2]};
            }
            memcpy(mesh.triangles, net.triangles, net.triangle_count * sizeof *mesh.triangles);
            assert_ok(ost_mesh_bounds(&mesh, &min, &max, &err));
            assert_ok(ost_tool_geometry_from_bounds(min, max, voxel, &g[n], &err));
            assert_ok(ost_mesh_snap(&mesh, &g[n], &snapped, &err));
            grids[n] = make_grid(&snapped, OST_FILL_WINDING, NULL);
            for (int64_t i = 0; i < ost_dims_count(g[n].dims); i++)
                solid[n] += grids[n][i] != 0;
            ost_snapped_mesh_free(&snapped);
            ost_mesh_free(&mesh);
        }
        assert_int_equal(solid[0], solid[1]);
        const int64_t by[3] = {(g[0].corner.x - g[1].corner.x) / voxel + shift[0],
                               (g[0].corner.y - g[1].corner.y) / voxel + shift[1],
                               (g[0].corner.z - g[1].corner.z) / voxel + shift[2]};
        for (int32_t k = 0; k < g[0].dims.z; k++)
            for (int32_t j = 0; j < g[0].dims.y; j++)
                for (int32_t i = 0; i < g[0].dims.x; i++)
                    if (grids[0][i + g[0].dims.x * (j + g[0].dims.y * k)]) {
                        const int64_t x = i + by[0], y = j + by[1], z = k + by[2];
                        assert_true(x >= 0 && x < g[1].dims.x && y >= 0 && y < g[1].dims.y && z >= 0 &&
                                    z < g[1].dims.z);
                        assert_int_equal(grids[1][x + g[1].dims.x * (y + g[1].dims.y * z)], OST_TOOL_CUTTING);
                    }
        free(grids[0]);
        free(grids[1]);
        ost_snapped_mesh_free(&net);
    }
}

/* The bytes of AR-DIG-7 for a mesh of one triangle, written by hand. */
static void digest_of_the_documented_bytes(void **state)
{
    (void)state;
    static const uint8_t bytes[] = {
        'O', 'S', 'T', 'E', 'O', 'N', 'M', '1', 2, 0, 0, 0,                          /* arithmetic 2 */
        8, 0, 0, 0, 7, 0, 0, 0, 6, 0, 0, 0,                                          /* dims */
        0x00, 0xca, 0x9a, 0x3b, 0, 0, 0, 0,                                          /* voxel: 10^9 */
        /* corner -1 0 5 */
        0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0, 0, 0, 0, 0, 0, 0, 0, 5, 0, 0, 0, 0, 0, 0, 0,
        10, 0, 0, 0,                                                                 /* f */
        /* numbers of vertices, triangles and dropped triangles */
        3, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 0,
        0, 4, 0, 0, 0, 8, 0, 0, 1, 0, 0, 0,                                          /* first vertex: 1024 2048 1 */
        2, 0, 0, 0, 3, 0, 0, 0, 4, 0, 0, 0, 5, 0, 0, 0, 6, 0, 0, 0, 7, 0, 0, 0,      /* the other two vertices */
        /* the vertex numbers of the triangle: 2 0 1 */
        2, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0,
    };
    ost_error err = {0};
    ost_snapped_mesh mesh = make_snapped((ost_dims){8, 7, 6}, 3, 1);
    mesh.grid.corner = (ost_pm3){-1, 0, 5};
    mesh.dropped_triangles = 2;
    make_vertex(&mesh, 1024, 2048, 1);
    make_vertex(&mesh, 2, 3, 4);
    make_vertex(&mesh, 5, 6, 7);
    make_triangle(&mesh, 2, 0, 1);
    ost_digest got, expected;
    assert_ok(ost_snapped_mesh_digest(&mesh, &got, &err));
    assert_ok(ost_digest_bytes(bytes, sizeof bytes, &expected, &err));
    assert_true(ost_digest_equal(&got, &expected));
    ost_snapped_mesh_free(&mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_reamer_has_the_thesis_grids),
        cmocka_unit_test(every_grid_has_a_margin),
        cmocka_unit_test(values_beyond_the_limits_are_refused),
        cmocka_unit_test(vertices_are_rounded_half_to_even),
        cmocka_unit_test(fraction_bits_fit_the_grid),
        cmocka_unit_test(triangles_without_area_are_dropped),
        cmocka_unit_test(shift_by_voxels_moves_the_grid),
        cmocka_unit_test(digest_of_the_documented_bytes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
