/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Makes random meshes for tests. Their vertices are on the lattice, and many of them are on voxel centres,
 * where the ownership of a centre is hardest to determine.
 */
#ifndef OST_TESTS_MESH_MAKE_H
#define OST_TESTS_MESH_MAKE_H

#include "backends.h"

#include <osteon/phantom.h>

#include "cpu/ref/voxelize.h"

enum { MAKE_F = 10, MAKE_ONE = 1 << MAKE_F, MAKE_HALF = MAKE_ONE / 2 };

/* Returns an empty snapped mesh with memory for the given numbers of vertices and triangles. Its voxels are 1 mm
   wide, and the corner of its grid is at the origin. */
static inline ost_snapped_mesh make_snapped(ost_dims dims, size_t vertices, size_t triangles)
{
    ost_snapped_mesh m = {.grid = {.dims = dims, .voxel = OST_PM_PER_MM}, .fraction_bits = MAKE_F};
    m.vertices = calloc(vertices, sizeof *m.vertices);
    m.triangles = calloc(triangles, sizeof *m.triangles);
    assert_non_null(m.vertices);
    assert_non_null(m.triangles);
    return m;
}

static inline uint32_t make_vertex(ost_snapped_mesh *m, int64_t x, int64_t y, int64_t z)
{
    m->vertices[m->vertex_count][0] = (int32_t)x;
    m->vertices[m->vertex_count][1] = (int32_t)y;
    m->vertices[m->vertex_count][2] = (int32_t)z;
    return (uint32_t)m->vertex_count++;
}

static inline void make_triangle(ost_snapped_mesh *m, uint32_t a, uint32_t b, uint32_t c)
{
    m->triangles[m->triangle_count][0] = a;
    m->triangles[m->triangle_count][1] = b;
    m->triangles[m->triangle_count][2] = c;
    m->triangle_count++;
}

/*
 * Returns a coordinate on the lattice, from 0 to n voxels. It is a voxel centre, a voxel border, a
 * multiple of a quarter of a voxel, or any lattice point.
 */
static inline int64_t make_coordinate(test_rng *rng, int32_t n)
{
    switch (rng_range(rng, 0, 3)) {
    case 0: return rng_range(rng, 0, n - 1) * MAKE_ONE + MAKE_HALF;
    case 1: return rng_range(rng, 0, n) * MAKE_ONE;
    case 2: return rng_range(rng, 0, 4 * n) * (MAKE_ONE / 4);
    default: return rng_range(rng, 0, (int64_t)n * MAKE_ONE);
    }
}

static inline uint32_t make_random_vertex(ost_snapped_mesh *m, test_rng *rng)
{
    const ost_dims d = m->grid.dims;
    int64_t x = make_coordinate(rng, d.x), y = make_coordinate(rng, d.y), z = make_coordinate(rng, d.z);
    return make_vertex(m, x, y, z);
}

/*
 * Returns a closed mesh: an n x m net bent into a torus. Its vertices are at random positions, so
 * that it intersects itself.
 */
static inline ost_snapped_mesh make_closed(test_rng *rng, ost_dims dims, uint32_t n, uint32_t m)
{
    ost_snapped_mesh mesh = make_snapped(dims, (size_t)n * m, 2 * (size_t)n * m);
    for (uint32_t i = 0; i < n * m; i++)
        make_random_vertex(&mesh, rng);
    for (uint32_t i = 0; i < n; i++)
        for (uint32_t k = 0; k < m; k++) {
            uint32_t a = i * m + k, b = (i + 1) % n * m + k, c = (i + 1) % n * m + (k + 1) % m, d = i * m + (k + 1) % m;
            make_triangle(&mesh, a, b, c);
            make_triangle(&mesh, a, c, d);
        }
    return mesh;
}

/* Makes a box with outward faces from lo to hi, in lattice units. */
static inline void make_box(ost_snapped_mesh *m, const int64_t lo[3], const int64_t hi[3])
{
    static const uint32_t faces[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                                          {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    const uint32_t first = (uint32_t)m->vertex_count;
    for (int i = 0; i < 8; i++)
        make_vertex(m, i & 1 ? hi[0] : lo[0], i & 2 ? hi[1] : lo[1], i & 4 ? hi[2] : lo[2]);
    for (int t = 0; t < 12; t++)
        make_triangle(m, first + faces[t][0], first + faces[t][1], first + faces[t][2]);
}

/* Reverses the orientation of triangle t and of all triangles after it. */
static inline void make_inside_out(ost_snapped_mesh *m, size_t t)
{
    for (; t < m->triangle_count; t++) {
        uint32_t swap = m->triangles[t][1];
        m->triangles[t][1] = m->triangles[t][2];
        m->triangles[t][2] = swap;
    }
}

/*
 * Returns the grid that the test group's backend computes from two meshes. The caller frees the grid.
 * noncutting and report may be NULL.
 */
static inline uint8_t *make_grid_of_two(const ost_snapped_mesh *cutting, const ost_snapped_mesh *noncutting,
                                        ost_fill_rule rule, ost_voxelize_report *report)
{
    ost_error err = {0};
    ost_backend *backend;
    ost_tool *tool;
    ost_tool_volume volume;
    assert_ok(ost_backend_open(test_backend, &backend, &err));
    assert_ok(ost_voxelize(backend, cutting, noncutting, rule, report, &tool, &err));
    assert_ok(ost_tool_download(tool, &volume, &err));
    const size_t size = (size_t)ost_dims_count(cutting->grid.dims);
    uint8_t *voxels = malloc(size);
    assert_non_null(voxels);
    memcpy(voxels, volume.voxels, size);
    ost_tool_volume_free(&volume);
    ost_tool_free(tool);
    ost_backend_close(backend);
    return voxels;
}

static inline uint8_t *make_grid(const ost_snapped_mesh *mesh, ost_fill_rule rule, ost_voxelize_report *report)
{
    return make_grid_of_two(mesh, NULL, rule, report);
}

#endif
