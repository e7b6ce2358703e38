/* SPDX-License-Identifier: Apache-2.0 */
/* Tests bounds, signed volume and open edges of meshes for which these values are computed by hand. */
#include "harness.h"

#include <osteon/mesh.h>

/* Makes a box of a x b x c mm with outward triangles. Each vertex is stored once. */
static void make_box(ost_mesh *mesh, int64_t a, int64_t b, int64_t c)
{
    static const uint32_t faces[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                                          {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    ost_error err = {0};
    assert_ok(ost_mesh_init(mesh, 8, 12, &err));
    for (int i = 0; i < 8; i++)
        mesh->vertices[i] = (ost_pm3){i & 1 ? a * OST_PM_PER_MM : 0, i & 2 ? b * OST_PM_PER_MM : 0,
                                      i & 4 ? c * OST_PM_PER_MM : 0};
    memcpy(mesh->triangles, faces, sizeof faces);
}

static void volume_and_open_edges_of_a_box(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_mesh mesh;
    make_box(&mesh, 2, 3, 5);
    assert_true(ost_mesh_volume_mm3(&mesh) > 29.999999 && ost_mesh_volume_mm3(&mesh) < 30.000001);
    size_t open = 99;
    assert_ok(ost_mesh_open_edges(&mesh, &open, &err));
    assert_int_equal(open, 0);
    ost_pm3 min, max;
    assert_ok(ost_mesh_bounds(&mesh, &min, &max, &err));
    assert_int_equal(min.x, 0);
    assert_int_equal(max.z, 5 * OST_PM_PER_MM);
    mesh.triangle_count = 11;
    assert_ok(ost_mesh_open_edges(&mesh, &open, &err));
    assert_int_equal(open, 3);
    mesh.triangle_count = 0;
    assert_int_equal(ost_mesh_bounds(&mesh, &min, &max, NULL), OST_ERR_INPUT);
    ost_mesh_free(&mesh);
}

static void reversed_face_has_open_edges(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_mesh mesh;
    make_box(&mesh, 1, 1, 1);
    uint32_t swap = mesh.triangles[4][0];
    mesh.triangles[4][0] = mesh.triangles[4][1];
    mesh.triangles[4][1] = swap;
    size_t open = 0;
    assert_ok(ost_mesh_open_edges(&mesh, &open, &err));
    assert_int_equal(open, 3);
    ost_mesh_free(&mesh);
}

static void too_many_triangles_are_refused(void **state)
{
    (void)state;
    ost_mesh mesh;
    assert_int_equal(ost_mesh_init(&mesh, 3, (size_t)OST_MESH_TRIANGLES_MAX + 1, NULL), OST_ERR_RANGE);
    ost_mesh_free(&mesh);
}

static void edges_of_four_faces_are_open(void **state)
{
    /*
     * The mesh contains the same box twice. Each of its 18 edges occurs twice in each direction. An edge is closed
     * only if it occurs once in each direction, so all edges are open.
     */
    (void)state;
    ost_error err = {0};
    ost_mesh box, twice;
    size_t open = 0;
    make_box(&box, 1, 1, 1);
    assert_ok(ost_mesh_init(&twice, 8, 24, &err));
    memcpy(twice.vertices, box.vertices, 8 * sizeof *box.vertices);
    memcpy(twice.triangles, box.triangles, 12 * sizeof *box.triangles);
    memcpy(twice.triangles + 12, box.triangles, 12 * sizeof *box.triangles);
    assert_ok(ost_mesh_open_edges(&twice, &open, &err));
    assert_int_equal(open, 18);
    ost_mesh_free(&twice);
    ost_mesh_free(&box);
}

static void the_widest_tool_grid_is_accepted(void **state)
{
    (void)state;
    ost_tool_geometry g = {{OST_TOOL_DIM_MAX, 1, 1}, OST_PM_PER_MM, {0, 0, 0}};
    assert_int_equal(ost_tool_geometry_check(&g, NULL), OST_OK);
    g.dims.x++;
    assert_int_equal(ost_tool_geometry_check(&g, NULL), OST_ERR_RANGE);
}

static void absent_vertex_is_refused(void **state)
{
    (void)state;
    ost_mesh mesh;
    ost_pm3 min, max;
    size_t open;
    ost_error err = {0};
    make_box(&mesh, 1, 1, 1);
    mesh.triangles[11][2] = 8;
    assert_int_equal(ost_mesh_bounds(&mesh, &min, &max, &err), OST_ERR_USAGE);
    assert_string_equal(err.text, "mesh: triangle 11 uses vertex 8 of 8");
    assert_int_equal(ost_mesh_open_edges(&mesh, &open, NULL), OST_ERR_USAGE);
    ost_mesh_free(&mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(volume_and_open_edges_of_a_box),
        cmocka_unit_test(reversed_face_has_open_edges),
        cmocka_unit_test(too_many_triangles_are_refused),
        cmocka_unit_test(edges_of_four_faces_are_open),
        cmocka_unit_test(the_widest_tool_grid_is_accepted),
        cmocka_unit_test(absent_vertex_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
