/* SPDX-License-Identifier: Apache-2.0 */
/* Tests three kinds of kernels. The voxelizer kernels are compared with the reference, the reach in a tool's cells with
   its definition, and the results of the fingerprint kernel with a list of expected results. */
#include "cl/machine.h"

#include "cl/fingerprint_expect.h"
#include "mesh/mesh_make.h"

static void *zeros(size_t count, size_t size)
{
    void *p = calloc(count ? count : 1, size);
    assert_non_null(p);
    return p;
}

/* ------------------------------------------------------------ voxelizer */

static ost_snapped_mesh soup(test_rng *rng, ost_dims dims)
{
    const size_t vertices = (size_t)rng_range(rng, 3, 12), triangles = (size_t)rng_range(rng, 1, 30);
    ost_snapped_mesh mesh = make_snapped(dims, vertices, triangles);
    for (size_t i = 0; i < vertices; i++)
        make_random_vertex(&mesh, rng);
    while (mesh.triangle_count < triangles)
        make_triangle(&mesh, (uint32_t)rng_range(rng, 0, (int64_t)vertices - 1),
                      (uint32_t)rng_range(rng, 0, (int64_t)vertices - 1),
                      (uint32_t)rng_range(rng, 0, (int64_t)vertices - 1));
    return mesh;
}

/* Makes a closed mesh of tetrahedra between random points, oriented outward or inward. The mesh may intersect
   itself. */
static ost_snapped_mesh tetrahedra(test_rng *rng, ost_dims dims)
{
    const size_t count = (size_t)rng_range(rng, 1, 5);
    ost_snapped_mesh mesh = make_snapped(dims, 4 * count, 4 * count);
    for (size_t i = 0; i < count; i++) {
        uint32_t v[4];
        for (int k = 0; k < 4; k++)
            v[k] = make_random_vertex(&mesh, rng);
        make_triangle(&mesh, v[0], v[2], v[1]);
        make_triangle(&mesh, v[0], v[1], v[3]);
        make_triangle(&mesh, v[1], v[2], v[3]);
        make_triangle(&mesh, v[2], v[0], v[3]);
    }
    return mesh;
}

/* Sets each coordinate to an end of its range, or to a value that is one unit inside the range. Does not change the
   number of fraction bits. */
static void stretch(ost_snapped_mesh *mesh, test_rng *rng)
{
    const int32_t n[3] = {mesh->grid.dims.x, mesh->grid.dims.y, mesh->grid.dims.z};
    for (size_t i = 0; i < mesh->vertex_count; i++)
        for (int a = 0; a < 3; a++)
            mesh->vertices[i][a] = (int32_t)(rng_range(rng, 0, 1)
                                                 ? n[a] * (1 << mesh->fraction_bits) - rng_range(rng, 0, 1)
                                                 : rng_range(rng, 0, 1));
}

static void voxelize_mesh(machine *m, test_rng *rng, const ost_snapped_mesh *mesh, ost_fill_rule rule, int tool_class,
                          uint8_t *classes, uint32_t *leaks)
{
    const ost_dims d = mesh->grid.dims;
    /* z index at which the grid is divided into two slabs; 0 or d.z gives a single slab */
    const int32_t cut = (int32_t)rng_range(rng, 0, d.z);
    ost_cl_vox vox = {.dims = {d.x, d.y, d.z},
                      .fraction = mesh->fraction_bits,
                      .triangles = (uint32_t)mesh->triangle_count,
                      .bands = (uint32_t)rng_range(rng, 1, 4),
                      .rule = (int)rule,
                      .tool_class = tool_class};
    const size_t row = (size_t)d.x + 1, capacity = row * (size_t)d.y * (size_t)(cut > d.z - cut ? cut : d.z - cut);
    int32_t *steps = zeros(capacity, 4);
    for (int part = 0; part < 2; part++) {
        vox.k0 = part ? cut : 0;
        vox.k1 = part ? d.z : cut;
        if (vox.k0 == vox.k1)
            continue;
        LAUNCH(m, ost_vox_steps, mesh->triangle_count, vox.bands, 1, ONE(&vox),
               BUFFER(&mesh->vertices[0][0], 3 * mesh->vertex_count),
               BUFFER(&mesh->triangles[0][0], 3 * mesh->triangle_count), BUFFER(steps, capacity));
        LAUNCH(m, ost_vox_fill, d.y, vox.k1 - vox.k0, 1, ONE(&vox), BUFFER(steps, capacity),
               BUFFER(classes, ost_dims_count(d)), ONE(leaks));
    }
    for (size_t i = 0; i < capacity; i++)
        assert_int_equal(steps[i], 0);
    free(steps);
}

/* Voxelizes the mesh in tiles of random size. Each list of triangles contains all triangles in cyclic order and begins
   with a different one. Stores the numbers of solid voxels, cutting voxels and leaking rows in counts. */
static void voxelize_tiles(machine *m, test_rng *rng, const ost_snapped_mesh *mesh, ost_fill_rule rule, int tool_class,
                           bool over, uint8_t *classes, uint64_t counts[3])
{
    const ost_dims d = mesh->grid.dims;
    ost_cl_tiles tiles = {.dims = {d.x, d.y, d.z},
                          .fraction = mesh->fraction_bits,
                          .rule = (int)rule,
                          .tool_class = tool_class,
                          .over = over};
    tiles.height = (int32_t)rng_range(rng, 1, d.y);
    tiles.depth = (int32_t)rng_range(rng, d.z > 100 ? 100 : 1, d.z);
    tiles.count[0] = (d.y + tiles.height - 1) / tiles.height;
    tiles.count[1] = (d.z + tiles.depth - 1) / tiles.depth;
    tiles.layer = (int32_t)rng_range(rng, d.z > 100 ? 100 : 1, d.z);
    tiles.pass = (int32_t)rng_range(rng, d.z > 100 ? 50 : 1, d.z);
    const size_t count = (size_t)tiles.count[0] * (size_t)tiles.count[1], n = mesh->triangle_count;
    const size_t rows = count * (size_t)tiles.pass * (size_t)tiles.height, steps_capacity = rows * ((size_t)d.x + 1),
                 marks_capacity = rows * ((size_t)d.x / 64 + 1);
    const size_t lists = (size_t)tiles.count[0] * (size_t)((d.z + tiles.layer - 1) / tiles.layer);
    uint32_t *start = zeros(lists + 1, 4), *list = zeros(lists * n, 4);
    int32_t *steps = zeros(steps_capacity, 4);
    uint64_t *marks = zeros(marks_capacity, 8), *of_tile = zeros(3 * count, 8);
    memset(steps, 0x33, steps_capacity * 4);
    memset(marks, 0x33, marks_capacity * 8);
    /*
     * of_tile[2] is the number of leaking rows before the launch. If `over` is true, the kernel must add to this
     * number. Otherwise, the kernel must overwrite it.
     */
    of_tile[2] = over ? counts[2] : 99;
    for (size_t t = 0; t < lists; t++) {
        start[t + 1] = start[t] + (uint32_t)n;
        for (size_t i = 0; i < n; i++)
            list[start[t] + i] = (uint32_t)((i + t) % n);
    }
    LAUNCH(m, ost_vox_tiles, tiles.count[0], tiles.count[1], 1, ONE(&tiles),
           BUFFER(&mesh->vertices[0][0], 3 * mesh->vertex_count), BUFFER(&mesh->triangles[0][0], 3 * n),
           BUFFER(start, lists + 1), BUFFER(list, lists * n), BUFFER(steps, steps_capacity),
           BUFFER(marks, marks_capacity), BUFFER(classes, ost_dims_count(d)), BUFFER(of_tile, 3 * count));
    for (int c = 0; c < 3; c++) {
        counts[c] = 0;
        for (size_t t = 0; t < count; t++)
            counts[c] += of_tile[3 * t + (size_t)c];
    }
    free(of_tile);
    free(marks);
    free(steps);
    free(list);
    free(start);
}

static void voxelize_round(machine *m, test_rng *rng)
{
    ost_error err = {0};
    const bool wide = !m->small && rng_range(rng, 0, 29) == 0;
    const ost_dims dims = wide ? (ost_dims){(int32_t)rng_range(rng, 1000, 1024), (int32_t)rng_range(rng, 1, 3), 1024}
                               : (ost_dims){(int32_t)rng_range(rng, 1, 40), (int32_t)rng_range(rng, 1, 14),
                                            (int32_t)rng_range(rng, 1, 14)};
    ost_snapped_mesh mesh[2];
    for (int i = 0; i < 2; i++) {
        mesh[i] = rng_range(rng, 0, 2) ? tetrahedra(rng, dims) : soup(rng, dims);
        if (wide)
            stretch(&mesh[i], rng);
    }
    const bool both = rng_range(rng, 0, 1);
    const ost_fill_rule rule = (ost_fill_rule)rng_range(rng, 0, 1);
    const size_t count = (size_t)ost_dims_count(dims);
    uint8_t *expected = zeros(count, 1), *found = zeros(count, 1);
    uint32_t leaks = 0, *counts = zeros(2 * (size_t)dims.z, 4);
    ost_voxelize_report report;
    assert_ok(ost_ref_voxelize(&mesh[0], both ? &mesh[1] : NULL, rule, &report, expected, &err));
    if (both)
        voxelize_mesh(m, rng, &mesh[1], rule, OST_TOOL_NONCUTTING, found, &leaks);
    voxelize_mesh(m, rng, &mesh[0], rule, OST_TOOL_CUTTING, found, &leaks);
    if (memcmp(found, expected, count) != 0)
        fail_msg("%s: a tool of %d x %d x %d voxels differs from the reference, rule %d", m->name, dims.x, dims.y,
                 dims.z, (int)rule);
    assert_int_equal(leaks, report.leaking_rows);
    const ost_cl_vox vox = {.dims = {dims.x, dims.y, dims.z}, .k1 = dims.z};
    LAUNCH(m, ost_vox_count, dims.y, dims.z, 1, ONE(&vox), BUFFER(found, count), BUFFER(counts, 2 * dims.z));
    uint64_t solid = 0, cutting = 0;
    for (int32_t k = 0; k < dims.z; k++) {
        solid += counts[2 * k];
        cutting += counts[2 * k + 1];
    }
    assert_int_equal(solid, report.solid_voxels);
    assert_int_equal(cutting, report.cutting_voxels);

    uint64_t tiled[3] = {0, 0, 0};
    memset(found, 0x77, count); /* The kernel must write every byte. */
    if (both)
        voxelize_tiles(m, rng, &mesh[1], rule, OST_TOOL_NONCUTTING, false, found, tiled);
    voxelize_tiles(m, rng, &mesh[0], rule, OST_TOOL_CUTTING, both, found, tiled);
    if (!m->brief && memcmp(found, expected, count) != 0)
        fail_msg("%s: a tool of %d x %d x %d voxels, made in tiles, differs from the reference, rule %d", m->name,
                 dims.x, dims.y, dims.z, (int)rule);
    if (!m->brief) {
        assert_int_equal(tiled[0], report.solid_voxels);
        assert_int_equal(tiled[1], report.cutting_voxels);
        assert_int_equal(tiled[2], report.leaking_rows);
    }
    free(expected);
    free(found);
    free(counts);
    ost_snapped_mesh_free(&mesh[0]);
    ost_snapped_mesh_free(&mesh[1]);
}

void compare_voxelizer(machine *m, test_rng *rng, int rounds)
{
    for (int i = 0; i < rounds; i++)
        voxelize_round(m, rng);
}

/* ----------------------------------------------------------------- reach */

static int class_at(const uint8_t *classes, const int32_t d[3], int32_t x, int32_t y, int32_t z)
{
    if (x < 0 || y < 0 || z < 0 || x >= d[0] || y >= d[1] || z >= d[2])
        return OST_TOOL_VOID;
    return classes[x + d[0] * (y + d[1] * z)];
}

/* Computes the reach by its definition, by testing one shell of voxels after another. */
static int reach_at(const uint8_t *classes, const int32_t d[3], int32_t x, int32_t y, int32_t z)
{
    const int own = class_at(classes, d, x, y, z);
    for (int r = 1; r < OST_CL_REACH_MAX; r++)
        for (int k = -r; k <= r; k++)
            for (int j = -r; j <= r; j++) {
                const bool face = k == -r || k == r || j == -r || j == r;
                for (int i = -r; i <= r; i += face ? 1 : 2 * r)
                    if (class_at(classes, d, x + i, y + j, z + k) != own)
                        return r;
            }
    return OST_CL_REACH_MAX;
}

void compare_reach(machine *m, test_rng *rng, int rounds)
{
    for (int round = 0; round < rounds; round++) {
        ost_cl_tool tool;
        for (int a = 0; a < 3; a++)
            tool.dims[a] = (int32_t)rng_range(rng, 1, m->small ? 6 : round % 4 == 0 && a == round % 3 ? 150 : 12);
        const size_t count = (size_t)tool.dims[0] * (size_t)tool.dims[1] * (size_t)tool.dims[2];
        uint8_t *classes = zeros(count, 1), *cells[2] = {zeros(count, 1), zeros(count, 1)};
        const int rare = (int)rng_range(rng, 1, 400), most = (int)rng_range(rng, 0, 2);
        for (size_t v = 0; v < count; v++)
            classes[v] = (uint8_t)(rng_range(rng, 0, rare) == 0 ? rng_range(rng, 0, 2) : most);
        for (tool.axis = 0; tool.axis < 3; tool.axis++)
            LAUNCH(m, ost_tool_reach, tool.dims[0], tool.dims[1], tool.dims[2], ONE(&tool),
                   BUFFER(tool.axis == 0 ? classes : cells[(tool.axis + 1) % 2], count),
                   BUFFER(cells[tool.axis % 2], count));
        for (int32_t z = 0; z < tool.dims[2]; z++)
            for (int32_t y = 0; y < tool.dims[1]; y++)
                for (int32_t x = 0; x < tool.dims[0]; x++) {
                    const size_t v = (size_t)(x + tool.dims[0] * (y + tool.dims[1] * z));
                    const bool probe = count < 800 || rng_range(rng, 0, (int64_t)count / 100) == 0;
                    assert_int_equal(cells[0][v] & 3, classes[v]);
                    if (probe && cells[0][v] >> 2 != reach_at(classes, tool.dims, x, y, z))
                        fail_msg("%s: the reach of cell (%d, %d, %d) of %d x %d x %d is %d, expected %d", m->name, x, y,
                                 z, tool.dims[0], tool.dims[1], tool.dims[2], cells[0][v] >> 2,
                                 reach_at(classes, tool.dims, x, y, z));
                }
        free(classes);
        free(cells[0]);
        free(cells[1]);
    }
}

/* ----------------------------------------------------------- fingerprint */

/* Returns a random word, often one that causes carries. */
static uint64_t some_word(test_rng *rng)
{
    switch (rng_range(rng, 0, 6)) {
    case 0: return (uint64_t)rng_range(rng, -2, 2);
    case 1: return UINT64_C(1) << rng_range(rng, 0, 63);
    case 2: return (UINT64_C(1) << rng_range(rng, 0, 63)) - 1;
    case 3: return ~(UINT64_C(1) << rng_range(rng, 0, 63));
    case 4: return rng_next(rng) >> rng_range(rng, 0, 63);
    case 5: return UINT64_C(0x8000000080000000) ^ rng_next(rng) >> rng_range(rng, 30, 63);
    default: return rng_next(rng);
    }
}

uint32_t machine_turns(machine *m)
{
    uint32_t end = 0, x = 0, turns[2] = {0};
    for (uint32_t n = 0; n < OST_CL_TURNS; n++)
        end = OST_CL_NEXT_TURN(end);
    LAUNCH(m, ost_fingerprint_turns, 1, 1, 1, number_arg(end), BUFFER(turns, 2));
    assert_in_range(turns[0], OST_CL_TURNS_LEAST, OST_CL_TURNS);
    for (uint32_t n = 0; n < turns[0]; n++)
        x = OST_CL_NEXT_TURN(x);
    assert_int_equal(turns[1], x);
    return turns[0];
}

void compare_fingerprint(machine *m, test_rng *rng, int rounds)
{
    const size_t words = m->small ? 100 : 4096;
    uint64_t *in = zeros(2 * words, 8), *out = zeros(words * OST_CL_FINGERPRINT, 8), expected[OST_CL_FINGERPRINT];
    for (int round = 0; round < rounds; round++) {
        for (size_t i = 0; i < 2 * words; i++)
            in[i] = some_word(rng);
        LAUNCH(m, ost_fingerprint, words, 1, 1, number_arg((int64_t)words), BUFFER(in, 2 * words),
               BUFFER(out, words * OST_CL_FINGERPRINT));
        for (size_t i = 0; i < words; i++) {
            ost_cl_fingerprint_expect(in[2 * i], in[2 * i + 1], expected);
            for (size_t k = 0; k < OST_CL_FINGERPRINT; k++)
                if (out[i * OST_CL_FINGERPRINT + k] != expected[k])
                    fail_msg("%s: result %zu for the inputs %llx and %llx is %llx, expected %llx", m->name, k,
                             (unsigned long long)in[2 * i], (unsigned long long)in[2 * i + 1],
                             (unsigned long long)out[i * OST_CL_FINGERPRINT + k], (unsigned long long)expected[k]);
        }
        uint32_t counters[OST_CL_FINGERPRINT_COUNTERS] = {0}, right[OST_CL_FINGERPRINT_COUNTERS];
        counters[5] = counters[7] = UINT32_MAX;
        LAUNCH(m, ost_fingerprint_atomics, words, 1, 1, number_arg((int64_t)words), BUFFER(in, 2 * words),
               BUFFER(counters, OST_CL_FINGERPRINT_COUNTERS));
        ost_cl_fingerprint_expect_atomics(in, (uint32_t)words, right);
        for (size_t k = 0; k < OST_CL_FINGERPRINT_COUNTERS; k++)
            if (counters[k] != right[k])
                fail_msg("%s: counter %zu is %x, expected %x", m->name, k, counters[k], right[k]);
    }
    assert_true(m->brief || machine_turns(m) == OST_CL_TURNS);
    free(in);
    free(out);
}
