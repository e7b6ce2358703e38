/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Compares the voxelizer with an oracle, which is a different implementation of AR-VOX, and checks
 * invariants of voxelization.
 *
 * The oracle classifies one voxel at a time and has no rules for ties. It scales coordinates by 2^50 and
 * displaces the row by (2^22, 1) in (y, z). The displacement resolves ties and is small enough to change no
 * other sign. The sign of a 3 x 3 determinant states on which side of the triangle's plane the centre lies.
 * All computations use 128 bits.
 *
 * Covers: AR-VOX-1, AR-VOX-2, AR-VOX-3, AR-VOX-4, AR-VOX-5, AR-VOX-6, AR-VOX-7
 */
#include "mesh_make.h"

__extension__ typedef __int128 wide;

/* ----------------------------------------------------------------- oracle */

static int sign(wide v)
{
    return (v > 0) - (v < 0);
}

/*
 * Returns the side of the edge a -> b on which the displaced point of the row lies in the (y, z)
 * plane. Scaled values are below 2^71, products below 2^92.
 */
static int side(const int32_t *a, const int32_t *b, int64_t y, int64_t z)
{
    const wide scale = (wide)1 << 50;
    wide py = y * scale + (1 << 22), pz = z * scale + 1;
    return sign((wide)(b[1] - a[1]) * (pz - a[2] * scale) - (wide)(b[2] - a[2]) * (py - a[1] * scale));
}

/* Computes det(b - a, c - a, p - a), which is positive on the side to which the outward normal points. */
static wide plane(const int32_t *a, const int32_t *b, const int32_t *c, const int64_t p[3])
{
    wide m[3][3];
    for (int i = 0; i < 3; i++) {
        m[0][i] = (wide)b[i] - a[i];
        m[1][i] = (wide)c[i] - a[i];
        m[2][i] = (wide)p[i] - a[i];
    }
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

/*
 * Counts in *count the triangles that cross the row of p at or before p or, if `all` is true, at any
 * position. Stores the sum of the signs of these triangles in *winding.
 */
static void crossings(const ost_snapped_mesh *mesh, const int64_t p[3], bool all, int *winding, int *count)
{
    *winding = *count = 0;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const int32_t *a = mesh->vertices[mesh->triangles[t][0]];
        const int32_t *b = mesh->vertices[mesh->triangles[t][1]];
        const int32_t *c = mesh->vertices[mesh->triangles[t][2]];
        int s = side(a, b, p[1], p[2]);
        if (s == 0 || s != side(b, c, p[1], p[2]) || s != side(c, a, p[1], p[2]))
            continue;
        /*
         * A triangle that is counter-clockwise in (y, z) has an outward normal toward +x. The row
         * leaves the mesh there, and p is past the plane if the determinant is not negative.
         * Clockwise triangles have the opposite signs.
         */
        if (!all && s * sign(plane(a, b, c, p)) < 0)
            continue;
        *winding -= s;
        ++*count;
    }
}

/* Fills the oracle's grid and returns the number of rows in which the mesh is not closed. */
static uint64_t oracle_grid(const ost_snapped_mesh *mesh, ost_fill_rule rule, uint8_t *voxels)
{
    const ost_dims d = mesh->grid.dims;
    uint64_t leaks = 0;
    for (int32_t k = 0; k < d.z; k++)
        for (int32_t j = 0; j < d.y; j++) {
            int64_t p[3] = {0, j * MAKE_ONE + MAKE_HALF, k * MAKE_ONE + MAKE_HALF};
            int winding, count;
            crossings(mesh, p, true, &winding, &count);
            const bool leak = rule == OST_FILL_WINDING ? winding != 0 : count % 2 != 0;
            leaks += leak;
            for (int32_t i = 0; i < d.x; i++) {
                p[0] = i * MAKE_ONE + MAKE_HALF;
                crossings(mesh, p, false, &winding, &count);
                const bool solid = !leak && (rule == OST_FILL_WINDING ? winding != 0 : count % 2 != 0);
                voxels[i + (size_t)d.x * ((size_t)j + (size_t)d.y * (size_t)k)] = solid ? OST_TOOL_CUTTING
                                                                                        : OST_TOOL_VOID;
            }
        }
    return leaks;
}

static void compare_with_oracle(const ost_snapped_mesh *mesh, ost_fill_rule rule, const char *what, int round)
{
    const size_t count = (size_t)ost_dims_count(mesh->grid.dims);
    uint8_t *expected = malloc(count);
    assert_non_null(expected);
    const uint64_t leaks = oracle_grid(mesh, rule, expected);
    ost_voxelize_report report;
    uint8_t *got = make_grid(mesh, rule, &report);
    uint64_t solid = 0;
    for (size_t i = 0; i < count; i++) {
        if (got[i] != expected[i])
            fail_msg("%s, round %d: voxel %zu is %d, in the oracle %d", what, round, i, got[i], expected[i]);
        solid += got[i] != 0;
    }
    assert_int_equal(report.leaking_rows, leaks);
    assert_int_equal(report.solid_voxels, solid);
    assert_int_equal(report.cutting_voxels, solid);
    free(expected);
    free(got);
}

static void random_triangles_equal_the_oracle(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("soups");
    for (int round = 0; round < 300; round++) {
        ost_dims dims = {(int32_t)rng_range(&rng, 1, 9), (int32_t)rng_range(&rng, 1, 8),
                         (int32_t)rng_range(&rng, 1, 7)};
        const size_t triangles = (size_t)rng_range(&rng, 1, 16);
        ost_snapped_mesh mesh = make_snapped(dims, 8, triangles);
        for (int i = 0; i < 8; i++)
            make_random_vertex(&mesh, &rng);
        while (mesh.triangle_count < triangles)
            make_triangle(&mesh, (uint32_t)rng_range(&rng, 0, 7), (uint32_t)rng_range(&rng, 0, 7),
                          (uint32_t)rng_range(&rng, 0, 7));
        compare_with_oracle(&mesh, round & 1 ? OST_FILL_PARITY : OST_FILL_WINDING, "soup", round);
        ost_snapped_mesh_free(&mesh);
    }
}

static void closed_meshes_equal_the_oracle(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("closed");
    for (int round = 0; round < 120; round++) {
        ost_snapped_mesh mesh = make_closed(&rng, (ost_dims){7, 6, 8}, (uint32_t)rng_range(&rng, 3, 5),
                                            (uint32_t)rng_range(&rng, 3, 5));
        ost_voxelize_report report;
        free(make_grid(&mesh, OST_FILL_WINDING, &report));
        assert_int_equal(report.leaking_rows, 0);
        free(make_grid(&mesh, OST_FILL_PARITY, &report));
        assert_int_equal(report.leaking_rows, 0);
        compare_with_oracle(&mesh, OST_FILL_WINDING, "closed", round);
        ost_snapped_mesh_free(&mesh);
    }
}

/* Every vertex is a voxel centre, so that as many edges and corners as possible lie on rows. */
static void meshes_on_centres_do_not_leak(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("centres");
    for (int round = 0; round < 400; round++) {
        ost_snapped_mesh mesh = make_closed(&rng, (ost_dims){9, 9, 9}, 3, 6);
        for (size_t i = 0; i < mesh.vertex_count; i++)
            for (int a = 0; a < 3; a++)
                mesh.vertices[i][a] = (int32_t)(rng_range(&rng, 0, 8) * MAKE_ONE + MAKE_HALF);
        ost_voxelize_report report;
        free(make_grid(&mesh, OST_FILL_WINDING, &report));
        assert_int_equal(report.leaking_rows, 0);
        if (round % 8 == 0)
            compare_with_oracle(&mesh, OST_FILL_WINDING, "centres", round);
        ost_snapped_mesh_free(&mesh);
    }
}

/* Tests the widest lattice: x up to 2^20 at f = 8. */
static void widest_lattice_equals_the_oracle(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("widest");
    for (int round = 0; round < 12; round++) {
        ost_snapped_mesh mesh = make_snapped((ost_dims){4096, 3, 2}, 9, 18);
        mesh.fraction_bits = 8;
        const int64_t top[3] = {4096 << 8, 3 << 8, 2 << 8};
        for (int i = 0; i < 9; i++)
            make_vertex(&mesh, rng_range(&rng, 0, 1) ? top[0] - rng_range(&rng, 0, 3) : rng_range(&rng, 0, 3),
                        rng_range(&rng, 0, top[1]), rng_range(&rng, 0, top[2]));
        for (uint32_t i = 0; i < 3; i++)
            for (uint32_t k = 0; k < 3; k++) {
                make_triangle(&mesh, 3 * i + k, (i + 1) % 3 * 3 + k, (i + 1) % 3 * 3 + (k + 1) % 3);
                make_triangle(&mesh, 3 * i + k, (i + 1) % 3 * 3 + (k + 1) % 3, 3 * i + (k + 1) % 3);
            }
        ost_voxelize_report report;
        uint8_t *grid = make_grid(&mesh, OST_FILL_WINDING, &report);
        assert_int_equal(report.leaking_rows, 0);
        for (int check = 0; check < 3000; check++) {
            const int64_t i = rng_range(&rng, 0, 4095), j = rng_range(&rng, 0, 2), k = rng_range(&rng, 0, 1);
            const int64_t p[3] = {(2 * i + 1) << 7, (2 * j + 1) << 7, (2 * k + 1) << 7};
            int winding, count;
            crossings(&mesh, p, false, &winding, &count);
            assert_int_equal(grid[i + 4096 * (j + 3 * k)], winding != 0);
        }
        free(grid);
        ost_snapped_mesh_free(&mesh);
    }
}

/* ------------------------------------------------------------- invariants */

/* Returns true if p lies within a triangle or on the border of a triangle. */
static bool on_surface(const ost_snapped_mesh *mesh, const int64_t p[3])
{
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const int32_t *v[3] = {mesh->vertices[mesh->triangles[t][0]], mesh->vertices[mesh->triangles[t][1]],
                               mesh->vertices[mesh->triangles[t][2]]};
        if (plane(v[0], v[1], v[2], p) != 0)
            continue;
        bool positive = false, negative = false;
        /* p is inside the triangle if and only if it is inside in all three projections */
        for (int axis = 0; axis < 3; axis++)
            for (int e = 0; e < 3; e++) {
                const int32_t *a = v[e], *b = v[(e + 1) % 3];
                const int u = (axis + 1) % 3, w = (axis + 2) % 3;
                wide area = (wide)(v[1][u] - v[0][u]) * (v[2][w] - v[0][w]) -
                            (wide)(v[2][u] - v[0][u]) * (v[1][w] - v[0][w]);
                wide s = (wide)(b[u] - a[u]) * (p[w] - a[w]) - (wide)(b[w] - a[w]) * (p[u] - a[u]);
                positive |= sign(s) * sign(area) > 0;
                negative |= sign(s) * sign(area) < 0;
            }
        if (positive && !negative)
            return true;
    }
    return false;
}

/*
 * A map of the grid onto another grid. Axis a of the new grid is axis from[a] of the old one,
 * reversed if flip[a] is set.
 */
typedef struct placing {
    int from[3];
    bool flip[3];
    bool odd; /* true if the map reverses the orientation of triangles */
} placing;

static int32_t dim(ost_dims d, int a)
{
    return a == 0 ? d.x : a == 1 ? d.y : d.z;
}

static ost_snapped_mesh placed(const ost_snapped_mesh *mesh, const placing *q)
{
    const ost_dims d = mesh->grid.dims;
    const ost_dims dims = {dim(d, q->from[0]), dim(d, q->from[1]), dim(d, q->from[2])};
    ost_snapped_mesh out = make_snapped(dims, mesh->vertex_count, mesh->triangle_count);
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        int64_t v[3];
        for (int a = 0; a < 3; a++) {
            v[a] = mesh->vertices[i][q->from[a]];
            if (q->flip[a])
                v[a] = (int64_t)dim(dims, a) * MAKE_ONE - v[a];
        }
        make_vertex(&out, v[0], v[1], v[2]);
    }
    memcpy(out.triangles, mesh->triangles, mesh->triangle_count * sizeof *out.triangles);
    out.triangle_count = mesh->triangle_count;
    if (q->odd)
        make_inside_out(&out, 0);
    return out;
}

/*
 * If a mesh is mirrored or rotated by quarter turns, or if its axes are permuted, its grid must change in
 * the same way. Only voxels whose centres lie on the surface may differ.
 */
static void symmetries_transform_the_grid(void **state)
{
    (void)state;
    static const placing placings[] = {
        {{0, 1, 2}, {true, false, false}, true},   {{0, 1, 2}, {false, true, false}, true},
        {{0, 1, 2}, {false, false, true}, true},   {{1, 0, 2}, {true, false, false}, false},
        {{2, 1, 0}, {false, false, true}, false},  {{0, 2, 1}, {false, true, false}, false},
        {{1, 2, 0}, {false, false, false}, false}, {{2, 0, 1}, {false, false, false}, false},
        {{1, 0, 2}, {false, false, false}, true},  {{0, 1, 2}, {true, true, false}, false},
    };
    test_rng rng = rng_seeded("placings");
    size_t compared = 0, on = 0;
    for (int round = 0; round < 60; round++) {
        ost_snapped_mesh mesh = make_closed(&rng, (ost_dims){8, 7, 6}, 3, 4);
        uint8_t *grid = make_grid(&mesh, OST_FILL_WINDING, NULL);
        for (size_t n = 0; n < sizeof placings / sizeof placings[0]; n++) {
            const placing *q = &placings[n];
            ost_snapped_mesh other = placed(&mesh, q);
            uint8_t *moved = make_grid(&other, OST_FILL_WINDING, NULL);
            const ost_dims d = mesh.grid.dims, e = other.grid.dims;
            for (int32_t k = 0; k < e.z; k++)
                for (int32_t j = 0; j < e.y; j++)
                    for (int32_t i = 0; i < e.x; i++) {
                        const int32_t at[3] = {i, j, k};
                        int64_t from[3], p[3];
                        for (int a = 0; a < 3; a++)
                            from[q->from[a]] = q->flip[a] ? dim(e, a) - 1 - at[a] : at[a];
                        for (int a = 0; a < 3; a++)
                            p[a] = from[a] * MAKE_ONE + MAKE_HALF;
                        const uint8_t here = moved[i + e.x * (j + e.y * k)],
                                      there = grid[from[0] + d.x * (from[1] + d.y * from[2])];
                        compared++;
                        if (here != there) {
                            on++;
                            if (!on_surface(&mesh, p))
                                fail_msg("round %d, placing %zu: voxel (%d, %d, %d) differs, but is not on the surface",
                                         round, n, i, j, k);
                        }
                    }
            free(moved);
            ost_snapped_mesh_free(&other);
        }
        free(grid);
        ost_snapped_mesh_free(&mesh);
    }
    assert_true(on < compared / 20); /* centres on the surface are rare */
}

/*
 * Two tetrahedra with a shared face form a bipyramid. The union of their grids must be the grid of the
 * bipyramid, and each centre on the shared face must belong to only one tetrahedron.
 */
static void union_of_two_halves_equals_the_bipyramid(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("halves");
    for (int round = 0; round < 200; round++) {
        ost_snapped_mesh complete = make_snapped((ost_dims){8, 8, 8}, 5, 6);
        for (int i = 0; i < 5; i++)
            make_random_vertex(&complete, &rng);
        int64_t top[3], bottom[3];
        for (int a = 0; a < 3; a++) {
            top[a] = complete.vertices[3][a];
            bottom[a] = complete.vertices[4][a];
        }
        if (plane(complete.vertices[0], complete.vertices[1], complete.vertices[2], top) <= 0 ||
            plane(complete.vertices[0], complete.vertices[1], complete.vertices[2], bottom) >= 0) {
            ost_snapped_mesh_free(&complete);
            continue;
        }
        ost_snapped_mesh upper = make_snapped(complete.grid.dims, 5, 4), lower = make_snapped(complete.grid.dims, 5, 4);
        for (int i = 0; i < 5; i++) {
            make_vertex(&upper, complete.vertices[i][0], complete.vertices[i][1], complete.vertices[i][2]);
            make_vertex(&lower, complete.vertices[i][0], complete.vertices[i][1], complete.vertices[i][2]);
        }
        make_triangle(&upper, 0, 2, 1);
        make_triangle(&lower, 0, 1, 2);
        for (uint32_t i = 0; i < 3; i++) {
            make_triangle(&upper, i, (i + 1) % 3, 3);
            make_triangle(&lower, (i + 1) % 3, i, 4);
            make_triangle(&complete, i, (i + 1) % 3, 3);
            make_triangle(&complete, (i + 1) % 3, i, 4);
        }
        uint8_t *w = make_grid(&complete, OST_FILL_WINDING, NULL), *u = make_grid(&upper, OST_FILL_WINDING, NULL),
                *l = make_grid(&lower, OST_FILL_WINDING, NULL);
        for (int i = 0; i < 512; i++) {
            assert_int_equal(w[i], u[i] | l[i]);
            assert_int_equal(u[i] & l[i], 0); /* a centre on the cut must belong to only one half */
        }
        free(w), free(u), free(l);
        ost_snapped_mesh_free(&complete), ost_snapped_mesh_free(&upper), ost_snapped_mesh_free(&lower);
    }
}

/* ------------------------------------------------- boxes computed by hand */

static const int64_t lo3[3] = {MAKE_ONE, MAKE_ONE, MAKE_ONE}, hi3[3] = {7 * MAKE_ONE, 6 * MAKE_ONE, 5 * MAKE_ONE};

static void inside_out_box_is_solid(void **state)
{
    (void)state;
    ost_voxelize_report report;
    ost_snapped_mesh mesh = make_snapped((ost_dims){8, 7, 6}, 8, 12);
    make_box(&mesh, lo3, hi3);
    free(make_grid(&mesh, OST_FILL_WINDING, &report));
    assert_int_equal(report.solid_voxels, 6 * 5 * 4);
    make_inside_out(&mesh, 0);
    free(make_grid(&mesh, OST_FILL_WINDING, &report));
    assert_int_equal(report.solid_voxels, 6 * 5 * 4);
    assert_int_equal(report.leaking_rows, 0);
    ost_snapped_mesh_free(&mesh);
}

/*
 * All faces of the box pass through voxel centres. On each axis, centres on the face with the lower
 * coordinate are inside, and centres on the opposite face are outside. Therefore the number of solid
 * voxels equals the volume.
 */
static void box_on_centres_is_half_open(void **state)
{
    (void)state;
    const int64_t lo[3] = {MAKE_ONE + MAKE_HALF, MAKE_ONE + MAKE_HALF, MAKE_ONE + MAKE_HALF};
    const int64_t hi[3] = {4 * MAKE_ONE + MAKE_HALF, 3 * MAKE_ONE + MAKE_HALF, 2 * MAKE_ONE + MAKE_HALF};
    ost_voxelize_report report;
    ost_snapped_mesh mesh = make_snapped((ost_dims){8, 7, 6}, 8, 12);
    make_box(&mesh, lo, hi);
    uint8_t *grid = make_grid(&mesh, OST_FILL_WINDING, &report);
    assert_int_equal(report.solid_voxels, 3 * 2 * 1);
    assert_int_equal(grid[1 + 8 * (1 + 7 * 1)], OST_TOOL_CUTTING);
    assert_int_equal(grid[4 + 8 * (1 + 7 * 1)], OST_TOOL_VOID);
    free(grid);
    ost_snapped_mesh_free(&mesh);
}

static void nested_shells(void **state)
{
    (void)state;
    const int64_t lo[3] = {2 * MAKE_ONE, 2 * MAKE_ONE, 2 * MAKE_ONE},
                  hi[3] = {5 * MAKE_ONE, 4 * MAKE_ONE, 3 * MAKE_ONE};
    const uint64_t outer = 6 * 5 * 4, inner = 3 * 2 * 1;
    ost_voxelize_report report;
    ost_snapped_mesh mesh = make_snapped((ost_dims){8, 7, 6}, 16, 24);
    make_box(&mesh, lo3, hi3);
    make_box(&mesh, lo, hi);
    /* both boxes have outward normals, so the winding number is 2 in the inner box */
    free(make_grid(&mesh, OST_FILL_WINDING, &report));
    assert_int_equal(report.solid_voxels, outer);
    free(make_grid(&mesh, OST_FILL_PARITY, &report));
    assert_int_equal(report.solid_voxels, outer - inner);
    make_inside_out(&mesh, 12); /* the inner box becomes a cavity with winding number 0 */
    free(make_grid(&mesh, OST_FILL_WINDING, &report));
    assert_int_equal(report.solid_voxels, outer - inner);
    free(make_grid(&mesh, OST_FILL_PARITY, &report));
    assert_int_equal(report.solid_voxels, outer - inner);
    ost_snapped_mesh_free(&mesh);
}

/*
 * One of the two triangles of the face x = hi is missing. In the rows that would cross this triangle the
 * mesh is not closed, so these rows stay empty. The other rows are filled.
 */
static void rows_through_a_hole_stay_empty(void **state)
{
    (void)state;
    ost_voxelize_report report;
    ost_snapped_mesh mesh = make_snapped((ost_dims){8, 7, 6}, 8, 12);
    make_box(&mesh, lo3, hi3);
    mesh.triangle_count = 11;
    uint8_t *grid = make_grid(&mesh, OST_FILL_WINDING, &report);
    assert_true(report.leaking_rows > 0 && report.leaking_rows < 5 * 4);
    assert_int_equal(report.solid_voxels, 6 * (5 * 4 - report.leaking_rows));
    free(grid);
    mesh.triangle_count = 10;
    free(make_grid(&mesh, OST_FILL_WINDING, &report));
    assert_int_equal(report.leaking_rows, 5 * 4);
    assert_int_equal(report.solid_voxels, 0);
    free(make_grid(&mesh, OST_FILL_PARITY, &report));
    assert_int_equal(report.leaking_rows, 5 * 4);
    ost_snapped_mesh_free(&mesh);
}

static void cutting_class_takes_precedence(void **state)
{
    (void)state;
    const int64_t lo[3] = {4 * MAKE_ONE, MAKE_ONE, MAKE_ONE}, hi[3] = {8 * MAKE_ONE, 6 * MAKE_ONE, 5 * MAKE_ONE};
    ost_snapped_mesh head = make_snapped((ost_dims){9, 7, 6}, 8, 12), shaft = make_snapped((ost_dims){9, 7, 6}, 8, 12);
    make_box(&head, lo3, hi3);
    make_box(&shaft, lo, hi);
    ost_voxelize_report report;
    uint8_t *grid = make_grid_of_two(&head, &shaft, OST_FILL_WINDING, &report);
    assert_int_equal(report.cutting_voxels, 6 * 5 * 4);
    assert_int_equal(report.solid_voxels, 7 * 5 * 4);
    assert_int_equal(grid[1 + 9 * (1 + 7 * 1)], OST_TOOL_CUTTING);
    assert_int_equal(grid[5 + 9 * (1 + 7 * 1)], OST_TOOL_CUTTING);
    assert_int_equal(grid[7 + 9 * (1 + 7 * 1)], OST_TOOL_NONCUTTING);
    assert_int_equal(grid[8 + 9 * (1 + 7 * 1)], OST_TOOL_VOID);
    shaft.triangle_count = 10; /* a face of the shaft is removed, so its rows stay empty; the head is complete */
    free(grid);
    free(make_grid_of_two(&head, &shaft, OST_FILL_WINDING, &report));
    assert_int_equal(report.leaking_rows, 5 * 4);
    assert_int_equal(report.solid_voxels, 6 * 5 * 4);
    ost_snapped_mesh_free(&head);
    ost_snapped_mesh_free(&shaft);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_triangles_equal_the_oracle),
        cmocka_unit_test(closed_meshes_equal_the_oracle),
        cmocka_unit_test(meshes_on_centres_do_not_leak),
        cmocka_unit_test(widest_lattice_equals_the_oracle),
        cmocka_unit_test(symmetries_transform_the_grid),
        cmocka_unit_test(union_of_two_halves_equals_the_bipyramid),
        cmocka_unit_test(inside_out_box_is_solid),
        cmocka_unit_test(box_on_centres_is_half_open),
        cmocka_unit_test(nested_shells),
        cmocka_unit_test(rows_through_a_hole_stay_empty),
        cmocka_unit_test(cutting_class_takes_precedence),
    };
    return run_on_backends(tests, NULL, NULL);
}
