/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Compares the voxels and the reports of the CPU backend's voxelizer with those of the reference. The tests use
 * every instruction set of this machine, 1, 2, 3 and 7 threads, both voxelizers if both are built, both fill
 * rules, and one or two meshes.
 *
 * Covers: AR-VOX-1, AR-VOX-2, AR-VOX-3, AR-VOX-4, AR-VOX-5, AR-VOX-6, AR-VOX-7
 */
#include "mesh/mesh_make.h"

#include <math.h>

#include <osteon/backend.h>

#include "core/isa.h"
#include "cpu/voxelize/voxelize.h"

/* --------------------------------------------------------------- compare */

/* Compares the filled bits of one or two meshes with the expected classes. */
static void compare_bits(const ost_backend *backend, const ost_snapped_mesh *cutting,
                         const ost_snapped_mesh *noncutting, ost_fill_rule rule, const uint8_t *expected,
                         const char *what)
{
    ost_error err = {0};
    const ost_dims d = cutting->grid.dims;
    const size_t words = (size_t)ost_vox_words(d.x), rows = (size_t)d.y * (size_t)d.z,
                 size = (rows * words * 8 + 63) / 64 * 64;
    ost_voxelize_report report;
    uint64_t *bits[2] = {aligned_alloc(64, size), aligned_alloc(64, size)};
    assert_true(bits[0] && bits[1]);
    for (int both = 0; both < 2; both++) { /* Without noncutting bits, the cutting bits may be filled in place. */
        memset(bits[0], 0x5a, size);
        memset(bits[1], 0x5a, size);
        assert_ok(ost_cpu_voxelize((const cpu_backend *)backend, cutting, noncutting, rule, &report,
                                   &(ost_vox_result){.cutting = bits[0], .noncutting = both ? bits[1] : NULL}, &err));
        for (size_t r = 0; r < rows; r++)
            for (size_t i = 0; i < 64 * words; i++) {
                const int want = i < (size_t)d.x ? expected[r * (size_t)d.x + i] : 0;
                const int cuts = bits[0][r * words + i / 64] >> (i % 64) & 1,
                          touches = bits[1][r * words + i / 64] >> (i % 64) & 1;
                if (cuts != (want == OST_TOOL_CUTTING) || (both && touches != (want == OST_TOOL_NONCUTTING)))
                    fail_msg("%s, rule %d: bit %zu of row %zu: cutting %d, not cutting %d; the reference's class is %d",
                             what, (int)rule, i, r, cuts, touches, want);
            }
    }
    free(bits[0]);
    free(bits[1]);
}

/*
 * Compares one backend with the expected grid. If `tiny` is true, tiles have only a few rows, and meshes of
 * any size use all threads.
 */
static void compare_one(const char *spec, bool tiny, const ost_snapped_mesh *cutting,
                        const ost_snapped_mesh *noncutting, ost_fill_rule rule, const uint8_t *expected,
                        const ost_voxelize_report *expected_report, const char *what)
{
    ost_error err = {0};
    ost_backend *backend;
    ost_tool *tool;
    ost_tool_volume volume;
    ost_voxelize_report report;
    assert_ok(ost_backend_open(spec, &backend, &err));
    if (tiny)
        ost_cpu_sharing_init(((cpu_backend *)backend)->sharing, 1, 0);
    for (int again = 0; again < 2; again++) { /* The first call must not affect the second. */
        memset(&report, 0x5a, sizeof report);
        assert_ok(ost_voxelize(backend, cutting, noncutting, rule, &report, &tool, &err));
        assert_ok(ost_tool_download(tool, &volume, &err));
        const ost_dims d = cutting->grid.dims;
        for (size_t i = 0; i < (size_t)ost_dims_count(d); i++)
            if (volume.voxels[i] != expected[i])
                fail_msg("%s, %s, rule %d: voxel (%d, %d, %d) of %d x %d x %d is %d, in the reference %d", what, spec,
                         (int)rule, (int)(i % (size_t)d.x), (int)(i / (size_t)d.x % (size_t)d.y),
                         (int)(i / (size_t)d.x / (size_t)d.y), d.x, d.y, d.z, volume.voxels[i], expected[i]);
        if (report.solid_voxels != expected_report->solid_voxels ||
            report.cutting_voxels != expected_report->cutting_voxels ||
            report.leaking_rows != expected_report->leaking_rows)
            fail_msg("%s, %s, rule %d: %llu solid and %llu cutting voxels, %llu leaking rows; "
                     "the reference has %llu, %llu and %llu",
                     what, spec, (int)rule, (unsigned long long)report.solid_voxels,
                     (unsigned long long)report.cutting_voxels, (unsigned long long)report.leaking_rows,
                     (unsigned long long)expected_report->solid_voxels,
                     (unsigned long long)expected_report->cutting_voxels,
                     (unsigned long long)expected_report->leaking_rows);
        ost_tool_volume_free(&volume);
        ost_tool_free(tool);
    }
    compare_bits(backend, cutting, noncutting, rule, expected, what);
    ost_backend_close(backend);
}

/*
 * If `all` is true, compares all combinations of options. If `all` is false, compares all instruction sets with one
 * thread.
 */
static void compare(const ost_snapped_mesh *cutting, const ost_snapped_mesh *noncutting, bool all, const char *what)
{
    static const char *const voxelizers[] = {"triangles", "embree"};
    static const int threads[] = {1, 2, 3, 7};
    static unsigned tiny_too; /* number of comparisons with one thread; every second one uses tiny tiles */
    ost_error err = {0};
    uint8_t *expected = malloc((size_t)ost_dims_count(cutting->grid.dims));
    assert_non_null(expected);
    for (int rule = 0; rule < 2; rule++) {
        ost_voxelize_report report;
        assert_ok(ost_ref_voxelize(cutting, noncutting, (ost_fill_rule)rule, &report, expected, &err));
        for (int isa = 0; isa < OST_ISA_COUNT; isa++)
            for (size_t t = 0; t < (all ? sizeof threads / sizeof *threads : 1); t++)
                for (size_t v = 0; v < sizeof voxelizers / sizeof *voxelizers; v++) {
                    char spec[100];
                    ost_backend *backend;
                    if (!ost_isa_available((ost_isa)isa))
                        continue;
                    if (v == 1 && !(all && t % 2 == 0) && (ost_isa)isa != ost_isa_best())
                        /* Embree is omitted, because opening its device takes longer than voxelizing these grids. */
                        continue;
                    snprintf(spec, sizeof spec, "cpu:isa=%s,threads=%d,voxelizer=%s", ost_isa_name((ost_isa)isa),
                             threads[t], voxelizers[v]);
                    if (ost_backend_open(spec, &backend, &err) == OST_ERR_UNAVAILABLE)
                        continue; /* This build has no Embree. The test `options` checks that "triangles" is
                                     always available. */
                    ost_backend_close(backend);
                    compare_one(spec, threads[t] > 1 || tiny_too++ % 2, cutting, noncutting, (ost_fill_rule)rule,
                                expected, &report, what);
                }
    }
    free(expected);
}

/* ---------------------------------------------------------------- meshes */

#ifndef OST_TEST_SHARE
#define OST_TEST_SHARE 3 /* tests/simd/portable tests a smaller share */
#endif

/* Returns the number of random meshes to test: n with OST_TEST_LONG=1, otherwise a fraction of n. */
static int rounds(int n)
{
    const char *given = getenv("OST_TEST_LONG");
    return given && strcmp(given, "1") == 0 ? n : n / OST_TEST_SHARE;
}

static ost_dims random_dims(test_rng *rng)
{
    static const int32_t widths[] = {1,   7,   8,   31,  32,  33,  63,  64,  65,  100, 127,
                                     128, 129, 200, 256, 257, 300, 511, 512, 513, 700};
    return (ost_dims){widths[rng_range(rng, 0, (int64_t)(sizeof widths / sizeof *widths) - 1)],
                      (int32_t)rng_range(rng, 1, 20), (int32_t)rng_range(rng, 1, 20)};
}

static void on_centres(ost_snapped_mesh *mesh, test_rng *rng)
{
    const int32_t n[3] = {mesh->grid.dims.x, mesh->grid.dims.y, mesh->grid.dims.z};
    for (size_t i = 0; i < mesh->vertex_count; i++)
        for (int a = 0; a < 3; a++)
            mesh->vertices[i][a] = (int32_t)(rng_range(rng, 0, n[a] - 1) * MAKE_ONE + MAKE_HALF);
}

/*
 * Returns triangles between random vertices. The mesh is open, crosses itself, and has degenerate and duplicate
 * triangles.
 */
static ost_snapped_mesh make_soup(test_rng *rng, ost_dims dims, size_t vertices, size_t triangles)
{
    ost_snapped_mesh mesh = make_snapped(dims, vertices, triangles);
    for (size_t i = 0; i < vertices; i++)
        make_random_vertex(&mesh, rng);
    while (mesh.triangle_count < triangles)
        make_triangle(&mesh, (uint32_t)rng_range(rng, 0, (int64_t)vertices - 1),
                      (uint32_t)rng_range(rng, 0, (int64_t)vertices - 1),
                      (uint32_t)rng_range(rng, 0, (int64_t)vertices - 1));
    return mesh;
}

/* Returns a tube about a (p, q) torus knot. The tube lies within a grid of these dimensions. */
static ost_snapped_mesh make_knot(ost_dims dims, uint32_t along, uint32_t around, double p, double q)
{
    ost_snapped_mesh mesh = make_snapped(dims, (size_t)along * around, 2 * (size_t)along * around);
    const double n[3] = {dims.x, dims.y, dims.z}, two_pi = 6.283185307179586;
    for (uint32_t i = 0; i < along; i++)
        for (uint32_t k = 0; k < around; k++) {
            const double t = two_pi * i / along, s = two_pi * k / around, ring = 0.3 + 0.1 * cos(q * t) + 0.06 * cos(s);
            const double v[3] = {0.5 + ring * cos(p * t), 0.5 + ring * sin(p * t),
                                 0.5 + 0.25 * sin(q * t) + 0.06 * sin(s)};
            make_vertex(&mesh, (int64_t)(v[0] * n[0] * MAKE_ONE), (int64_t)(v[1] * n[1] * MAKE_ONE),
                        (int64_t)(v[2] * n[2] * MAKE_ONE));
        }
    for (uint32_t i = 0; i < along; i++)
        for (uint32_t k = 0; k < around; k++) {
            const uint32_t i1 = (i + 1) % along, k1 = (k + 1) % around;
            const uint32_t a = i * around + k, b = i1 * around + k, c = i1 * around + k1, d = i * around + k1;
            make_triangle(&mesh, a, b, c);
            make_triangle(&mesh, a, c, d);
        }
    return mesh;
}

static ost_snapped_mesh make_sphere(ost_dims dims, uint32_t rings, uint32_t sectors, double radius)
{
    ost_snapped_mesh mesh = make_snapped(dims, (size_t)(rings + 1) * sectors, 2 * (size_t)rings * sectors);
    for (uint32_t i = 0; i <= rings; i++)
        for (uint32_t k = 0; k < sectors; k++) {
            const double t = 3.141592653589793 * i / rings, s = 6.283185307179586 * k / sectors;
            const double x = sin(t) * cos(s), y = sin(t) * sin(s), z = cos(t);
            make_vertex(&mesh, (int64_t)((0.5 + radius * (0.8 * x + 0.6 * z)) * dims.x * MAKE_ONE), /* tilted */
                        (int64_t)((0.5 + radius * y) * dims.y * MAKE_ONE),
                        (int64_t)((0.5 + radius * (0.8 * z - 0.6 * x)) * dims.z * MAKE_ONE));
        }
    for (uint32_t i = 0; i < rings; i++)
        for (uint32_t k = 0; k < sectors; k++) {
            const uint32_t k1 = (k + 1) % sectors, a = i * sectors + k, b = (i + 1) * sectors + k,
                           c = (i + 1) * sectors + k1, d = i * sectors + k1;
            make_triangle(&mesh, a, b, c); /* At the poles, one of these two triangles is degenerate. */
            make_triangle(&mesh, a, c, d);
        }
    return mesh;
}

/* ----------------------------------------------------------------- tests */

static void random_triangles(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("soups");
    for (int round = 0; round < rounds(120); round++) {
        ost_snapped_mesh mesh = make_soup(&rng, random_dims(&rng), 12, (size_t)rng_range(&rng, 1, 40));
        if (round % 3 == 0)
            on_centres(&mesh, &rng);
        compare(&mesh, NULL, round % 10 == 0, "soup");
        ost_snapped_mesh_free(&mesh);
    }
}

static void self_intersecting_closed_meshes(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("closed");
    for (int round = 0; round < rounds(60); round++) {
        ost_snapped_mesh mesh =
            make_closed(&rng, random_dims(&rng), (uint32_t)rng_range(&rng, 3, 9), (uint32_t)rng_range(&rng, 3, 9));
        if (round % 3 == 0)
            on_centres(&mesh, &rng);
        compare(&mesh, NULL, round % 10 == 0, "closed mesh");
        ost_snapped_mesh_free(&mesh);
    }
}

/* Many triangles cross a row at the same centre. Bits are therefore toggled several times, and counts are far
   greater than one. */
static void many_triangles_at_one_centre(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("piles");
    for (int round = 0; round < rounds(20); round++) {
        const ost_dims dims = {(int32_t)rng_range(&rng, 1, 140), 9, 9};
        ost_snapped_mesh mesh = make_soup(&rng, dims, 5, 3000);
        compare(&mesh, NULL, round == 0, "pile");
        make_inside_out(&mesh, 1500);
        compare(&mesh, NULL, false, "pile, half inside out");
        ost_snapped_mesh_free(&mesh);
    }
}

/* Tests crossings beyond the last centre of a row, with and without padding in the row's last word. */
static void crossings_beyond_the_last_centre(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("border");
    for (int32_t n = 62; n <= 66; n++) {
        const ost_dims dims = {n, 6, 7};
        ost_snapped_mesh mesh = make_closed(&rng, dims, 5, 5);
        for (size_t i = 0; i < mesh.vertex_count; i += 2)
            mesh.vertices[i][0] = (int32_t)(n * MAKE_ONE - rng_range(&rng, 0, MAKE_ONE));
        compare(&mesh, NULL, n == 64, "border");
        ost_snapped_mesh_free(&mesh);
        mesh = make_snapped(dims, 8, 12);
        make_box(&mesh, (const int64_t[3]){0, 0, 0}, (const int64_t[3]){n * MAKE_ONE, 6 * MAKE_ONE, 7 * MAKE_ONE});
        compare(&mesh, NULL, false, "the whole grid");
        mesh.triangle_count = 11;
        compare(&mesh, NULL, false, "the whole grid with a hole");
        ost_snapped_mesh_free(&mesh);
    }
}

static void nested_boxes(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("boxes");
    for (int round = 0; round < rounds(20); round++) {
        const ost_dims dims = {(int32_t)rng_range(&rng, 20, 150), 20, 20};
        ost_snapped_mesh mesh = make_snapped(dims, 8 * 6, 12 * 6);
        for (int b = 0; b < 6; b++) {
            const int64_t n[3] = {dims.x, dims.y, dims.z};
            int64_t lo[3], hi[3];
            for (int a = 0; a < 3; a++) {
                lo[a] = rng_range(&rng, 0, n[a] / 2 * 4) * MAKE_ONE / 4;
                hi[a] = lo[a] + rng_range(&rng, 1, (n[a] * 4 - lo[a] * 4 / MAKE_ONE)) * MAKE_ONE / 4;
            }
            make_box(&mesh, lo, hi);
            if (rng_range(&rng, 0, 1))
                make_inside_out(&mesh, mesh.triangle_count - 12);
        }
        compare(&mesh, NULL, round == 0, "boxes");
        ost_snapped_mesh_free(&mesh);
    }
}

/* Tests grids of several tiles. Some triangles lie within one tile, some extend over several tiles, and some over
   all tiles. */
static void shapes_over_many_tiles(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("tiles");
    static const ost_dims dims[] = {{70, 61, 52}, {5, 260, 130}, {513, 40, 21}};
    for (size_t i = 0; i < sizeof dims / sizeof *dims; i++) {
        ost_snapped_mesh knot = make_knot(dims[i], 80, 8, 2, 3), sphere = make_sphere(dims[i], 12, 17, 0.48);
        compare(&knot, NULL, i == 0, "knot");
        compare(&sphere, NULL, i == 0, "sphere");
        compare(&knot, &sphere, i == 1, "knot and sphere");
        make_inside_out(&knot, 0);
        compare(&sphere, &knot, false, "sphere and knot inside out");
        ost_snapped_mesh_free(&sphere);
        ost_snapped_mesh_free(&knot);
        ost_snapped_mesh soup = make_soup(&rng, dims[i], 30, 60);
        compare(&soup, NULL, i == 2, "large soup");
        ost_snapped_mesh_free(&soup);
    }
}

/* The mesh has 32,000 triangles on a grid of 1,599 rows. Most triangles cross no row. */
static void triangles_smaller_than_a_voxel(void **state)
{
    (void)state;
    ost_snapped_mesh knot = make_knot((ost_dims){40, 41, 39}, 400, 40, 2, 3);
    compare(&knot, NULL, true, "fine knot");
    ost_snapped_mesh_free(&knot);
}

/* Two shells are less than a voxel apart, so that their crossings belong to the same voxel centre. */
static void shells_closer_than_a_voxel(void **state)
{
    (void)state;
    const ost_dims dims = {90, 91, 92};
    for (int outward = 0; outward < 2; outward++) {
        ost_snapped_mesh a = make_sphere(dims, 40, 50, 0.48), b = make_sphere(dims, 40, 50, 0.477);
        ost_snapped_mesh both = make_snapped(dims, a.vertex_count + b.vertex_count,
                                             a.triangle_count + b.triangle_count);
        for (size_t i = 0; i < a.vertex_count; i++)
            make_vertex(&both, a.vertices[i][0], a.vertices[i][1], a.vertices[i][2]);
        for (size_t i = 0; i < b.vertex_count; i++)
            make_vertex(&both, b.vertices[i][0], b.vertices[i][1], b.vertices[i][2]);
        const uint32_t shift = (uint32_t)a.vertex_count;
        for (size_t i = 0; i < a.triangle_count; i++)
            make_triangle(&both, a.triangles[i][0], a.triangles[i][1], a.triangles[i][2]);
        for (size_t i = 0; i < b.triangle_count; i++)
            make_triangle(&both, b.triangles[i][0] + shift, b.triangles[i][1] + shift, b.triangles[i][2] + shift);
        if (!outward)
            make_inside_out(&both, a.triangle_count);
        compare(&both, NULL, outward, "shells");
        ost_snapped_mesh_free(&both);
        ost_snapped_mesh_free(&b);
        ost_snapped_mesh_free(&a);
    }
}

/* Tests every number of fraction bits. */
static void every_number_of_fraction_bits(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("lattices");
    for (int f = 1; f <= 10; f++) {
        ost_snapped_mesh mesh = make_closed(&rng, (ost_dims){90, 15, 16}, 6, 5);
        mesh.fraction_bits = f;
        for (size_t i = 0; i < mesh.vertex_count; i++)
            for (int a = 0; a < 3; a++)
                mesh.vertices[i][a] >>= MAKE_F - f;
        compare(&mesh, NULL, false, "lattice");
        ost_snapped_mesh_free(&mesh);
    }
}

/* Tests the greatest coordinates along each axis, and a large slice. */
static void grids_of_the_maximum_size(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("greatest");
    static const ost_dims dims[] = {{4096, 5, 4}, {3, 4096, 2}, {3, 2, 4096}, {1500, 1400, 2}};
    for (size_t i = 0; i < sizeof dims / sizeof *dims; i++) {
        ost_snapped_mesh mesh = make_closed(&rng, dims[i], 5, 6);
        mesh.fraction_bits = 8;
        for (size_t v = 0; v < mesh.vertex_count; v++)
            for (int a = 0; a < 3; a++)
                mesh.vertices[v][a] >>= MAKE_F - 8;
        compare(&mesh, NULL, false, "greatest grid");
        ost_snapped_mesh_free(&mesh);
    }
}

static void empty_mesh_gives_an_empty_grid(void **state)
{
    (void)state;
    ost_snapped_mesh mesh = make_snapped((ost_dims){33, 5, 6}, 3, 1);
    compare(&mesh, NULL, true, "no triangle");
    ost_snapped_mesh_free(&mesh);
}

/*
 * The caller's rounding mode and floating-point traps must not affect the grid, and the call must
 * not change them. Embree sets flush-to-zero and divides by zero.
 */
static void floating_point_state_is_preserved(void **state)
{
    (void)state;
#if defined __SSE__ && !defined __SANITIZE_ADDRESS__
    static const char *const specs[] = {"cpu:voxelizer=triangles,threads=1", "cpu:voxelizer=embree,threads=1",
                                        "cpu:voxelizer=embree,threads=3"};
    enum { TRAPS_BUT_PRECISION = 0x1000, DOWNWARD = 0x2000, ZERO_DENORMALS = 0x8040, AT_START = 0x1f80 };
    const unsigned int states[] = {TRAPS_BUT_PRECISION | DOWNWARD, AT_START | ZERO_DENORMALS, AT_START};
    ost_error err = {0};
    ost_snapped_mesh mesh = make_sphere((ost_dims){70, 61, 52}, 12, 17, 0.48);
    ost_voxelize_report report;
    const size_t size = (size_t)ost_dims_count(mesh.grid.dims);
    uint8_t *expected = malloc(size);
    assert_non_null(expected);
    assert_ok(ost_ref_voxelize(&mesh, NULL, OST_FILL_WINDING, &report, expected, &err));
    for (size_t i = 0; i < sizeof specs / sizeof *specs; i++)
        for (size_t s = 0; s < sizeof states / sizeof *states; s++) {
            ost_backend *backend;
            ost_tool *tool;
            ost_tool_volume volume;
            if (ost_backend_open(specs[i], &backend, &err) == OST_ERR_UNAVAILABLE)
                continue;
            __builtin_ia32_ldmxcsr(states[s]);
            const ost_status status = ost_voxelize(backend, &mesh, NULL, OST_FILL_WINDING, &report, &tool, &err);
            const unsigned int left = __builtin_ia32_stmxcsr();
            __builtin_ia32_ldmxcsr(AT_START);
            assert_ok(status);
            enum { FLAGS = 0x3f }; /* the status flags, which the computations of the test itself may set */
            assert_int_equal(left & ~(unsigned int)FLAGS, states[s]);
            assert_ok(ost_tool_download(tool, &volume, &err));
            assert_memory_equal(volume.voxels, expected, size);
            ost_tool_volume_free(&volume);
            ost_tool_free(tool);
            ost_backend_close(backend);
        }
    free(expected);
    ost_snapped_mesh_free(&mesh);
#else
    skip();
#endif
}

/* The voxelizer "triangles" is always available; an unknown name is an error. */
static void options(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_backend *backend;
    assert_ok(ost_backend_open("cpu:voxelizer=triangles", &backend, &err));
    ost_backend_close(backend);
    assert_ok(ost_backend_open("cpu:voxelizer=auto", &backend, &err));
    ost_backend_close(backend);
    assert_int_equal(ost_backend_open("cpu:voxelizer=triangle", &backend, &err), OST_ERR_USAGE);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_triangles),
        cmocka_unit_test(self_intersecting_closed_meshes),
        cmocka_unit_test(many_triangles_at_one_centre),
        cmocka_unit_test(crossings_beyond_the_last_centre),
        cmocka_unit_test(nested_boxes),
        cmocka_unit_test(shapes_over_many_tiles),
        cmocka_unit_test(triangles_smaller_than_a_voxel),
        cmocka_unit_test(shells_closer_than_a_voxel),
        cmocka_unit_test(every_number_of_fraction_bits),
        cmocka_unit_test(grids_of_the_maximum_size),
        cmocka_unit_test(empty_mesh_gives_an_empty_grid),
        cmocka_unit_test(floating_point_state_is_preserved),
        cmocka_unit_test(options),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
