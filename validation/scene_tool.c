/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Makes meshes for tools, from simple to degenerate. Corners are random integers, so that every machine
 * generates the same triangles.
 */
#include "validation/scene_parts.h"

#include <osteon/phantom.h>

#include <stdio.h>
#include <string.h>

/* The faces of a box. Bit a of a corner's number is set if the corner is at the far end of edge a. The normals point
   outward if the three edges of the box are right-handed. */
static const uint32_t box_faces[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                                          {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};

/* Makes `count` solids in random orientations. If inside_out is true, the faces of every second solid are turned inside
   out. If `same` is true, all solids are identical. */
static ost_status boxes(draw *d, ost_pm size, int count, bool same, bool inside_out, ost_mesh *out, ost_error *err)
{
    ost_status status = ost_mesh_init(out, 8 * (size_t)count, 12 * (size_t)count, err);
    if (status != OST_OK)
        return status;
    ost_pm3 at = {0, 0, 0}, e[3] = {{0}};
    for (int b = 0; b < count; b++) {
        if (b == 0 || !same) {
            const ost_pm wide = b == 0 ? size : size / 3;
            const ost_pm off = (b == 0 ? size / 8 : size / 4) / 2;
            at = draw_point(d, -off, off);
            const ost_pm slant = wide / 3;
            for (int a = 0; a < 3; a++) {
                e[a].x = a == 0 ? wide : draw_between(d, -slant, slant);
                e[a].y = a == 1 ? wide : draw_between(d, -slant, slant);
                e[a].z = a == 2 ? wide : draw_between(d, -slant, slant);
                at.x -= e[a].x / 2;
                at.y -= e[a].y / 2;
                at.z -= e[a].z / 2;
            }
        }
        for (int c = 0; c < 8; c++) {
            ost_pm3 p = at;
            for (int a = 0; a < 3; a++)
                if (c >> a & 1) {
                    p.x += e[a].x;
                    p.y += e[a].y;
                    p.z += e[a].z;
                }
            out->vertices[8 * b + c] = p;
        }
        for (int t = 0; t < 12; t++)
            for (int c = 0; c < 3; c++)
                out->triangles[12 * b + t][c] = (uint32_t)(8 * b) + box_faces[t][inside_out && b % 2 ? 2 - c : c];
    }
    return OST_OK;
}

static ost_status loose_triangles(draw *d, ost_pm size, int count, bool thin, ost_mesh *out, ost_error *err)
{
    ost_status status = ost_mesh_init(out, 3 * (size_t)count, (size_t)count, err);
    if (status != OST_OK)
        return status;
    for (int t = 0; t < count; t++) {
        const ost_pm half = size / 2, half_along = (thin ? size / 2 : size) / 2,
                     half_aside = (thin ? size / 20000 : size) / 2;
        const ost_pm3 at = draw_point(d, -half, half), along = draw_point(d, -half_along, half_along),
                      aside = draw_point(d, -half_aside, half_aside);
        out->vertices[3 * t] = at;
        out->vertices[3 * t + 1] = (ost_pm3){at.x + along.x, at.y + along.y, at.z + along.z};
        out->vertices[3 * t + 2] = (ost_pm3){at.x + along.x / 2 + aside.x, at.y + along.y / 2 + aside.y,
                                             at.z + along.z / 2 + aside.z};
        for (uint32_t c = 0; c < 3; c++)
            out->triangles[t][c] = (uint32_t)(3 * t) + c;
    }
    return OST_OK;
}

/* Removes each triangle with probability 1 / n, but keeps at least one. */
static void lose_triangles(draw *d, int n, ost_mesh *mesh)
{
    size_t kept = 0;
    for (size_t t = 0; t < mesh->triangle_count; t++)
        if (!draw_one_in(d, n) || (t + 1 == mesh->triangle_count && kept == 0))
            memmove(mesh->triangles[kept++], mesh->triangles[t], sizeof mesh->triangles[t]);
    mesh->triangle_count = kept;
}

static ost_status mesh_of(draw *d, scene_shape shape, ost_pm size, ost_mesh *out, ost_error *err)
{
    ost_tool_options how = {.diameter = size, .segments = 4 * (int)draw_between(d, 3, 24)};
    ost_status status;
    switch (shape) {
    case SHAPE_REAMER:
        return ost_tool_make(OST_TOOL_REAMER, &(ost_tool_options){.diameter = size, .length = size / 2}, out, err);
    case SHAPE_PEG: how.length = 2 * size; return ost_tool_make(OST_TOOL_PEG, &how, out, err);
    case SHAPE_BURR: how.length = size; return ost_tool_make(OST_TOOL_BURR, &how, out, err);
    case SHAPE_TWICE: return boxes(d, size, 2, true, false, out, err);
    case SHAPE_HOLLOW: return boxes(d, size, 2, false, true, out, err);
    case SHAPE_OPEN:
        status = boxes(d, size, 3, false, false, out, err);
        if (status == OST_OK)
            lose_triangles(d, 8, out);
        return status;
    case SHAPE_SOUP: return loose_triangles(d, size, 60, false, out, err);
    case SHAPE_SLIVERS: return loose_triangles(d, size, 400, true, out, err);
    case SHAPE_BOX:
    case SHAPE_COUNT: break;
    }
    return boxes(d, size, 1, false, false, out, err);
}

/* Moves the vertices to multiples of half a voxel. Corners, edges and faces then pass through the centres of voxels,
   where voxelization has ties. */
static void align(ost_mesh *mesh, ost_pm voxel)
{
    const ost_pm step = voxel / 2;
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        ost_pm3 *p = &mesh->vertices[v];
        *p = (ost_pm3){p->x / step * step, p->y / step * step, p->z / step * step};
    }
}

static const char *const shape_names[SHAPE_COUNT] = {"reamer", "peg",  "burr", "box",    "twice",
                                                     "hollow", "open", "soup", "slivers"};

ost_status scene_add_tool(scene *s, draw *d, scene_shape shape, ost_pm size, ost_pm voxel, bool noncutting,
                          ost_fill_rule rule, ost_error *err)
{
    scene_tool *tool = &s->tools[s->tool_count];
    ost_mesh mesh = {0}, shaft = {0};
    ost_pm3 lo, hi, shaft_lo, shaft_hi;
    ost_tool_geometry grid;
    *tool = (scene_tool){.rule = rule};
    s->tool_count++;
    snprintf(tool->name, sizeof tool->name, "%s", shape_names[shape]);
    ost_status status = mesh_of(d, shape, size, &mesh, err);
    if (status == OST_OK && draw_one_in(d, 2))
        align(&mesh, voxel);
    if (status == OST_OK)
        status = ost_mesh_bounds(&mesh, &lo, &hi, err);
    if (status == OST_OK && noncutting) {
        status = boxes(d, size / 2, 1, false, false, &shaft, err);
        if (status == OST_OK)
            status = ost_mesh_bounds(&shaft, &shaft_lo, &shaft_hi, err);
        if (status == OST_OK) {
            ost_pm3_widen(&lo, &hi, shaft_lo);
            ost_pm3_widen(&lo, &hi, shaft_hi);
        }
    }
    if (status == OST_OK)
        status = ost_tool_geometry_from_bounds(lo, hi, voxel, &grid, err);
    if (status == OST_OK)
        status = ost_mesh_snap(&mesh, &grid, &tool->cutting, err);
    if (status == OST_OK && noncutting)
        status = ost_mesh_snap(&shaft, &grid, &tool->noncutting, err);
    tool->raw[0] = mesh;
    tool->raw[1] = shaft;
    return status;
}

ost_status scene_add_fine_tool(scene *s, draw *d, ost_pm voxel, ost_error *err)
{
    enum { SOLIDS = 20000, SIDE = 40, SIZE = 3 };
    static const uint32_t faces[4][3] = {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {0, 2, 3}};
    const ost_tool_geometry grid = {
        {SIDE, SIDE, SIDE}, voxel, {-SIDE / 2 * voxel, -SIDE / 2 * voxel, -SIDE / 2 * voxel}};
    const ost_pm far = (SIDE / 2 - SIZE) * voxel, size = SIZE * voxel / 2;
    scene_tool *tool = &s->tools[s->tool_count];
    ost_mesh *mesh = &tool->raw[0];
    *tool = (scene_tool){.rule = OST_FILL_WINDING, .name = "fine", .grid_given = true};
    s->tool_count++;
    const ost_status status = ost_mesh_init(mesh, 4 * (size_t)SOLIDS, 4 * (size_t)SOLIDS, err);
    for (size_t b = 0; b < SOLIDS && status == OST_OK; b++) {
        const ost_pm3 at = draw_point(d, -far, far);
        for (int v = 0; v < 4; v++) {
            const ost_pm3 off = draw_point(d, -size, size);
            mesh->vertices[4 * b + (size_t)v] = (ost_pm3){at.x + off.x, at.y + off.y, at.z + off.z};
        }
        for (int t = 0; t < 4; t++)
            for (int c = 0; c < 3; c++)
                mesh->triangles[4 * b + (size_t)t][c] = (uint32_t)(4 * b) + faces[t][c];
    }
    return status == OST_OK ? ost_mesh_snap(mesh, &grid, &tool->cutting, err) : status;
}

/* ----------------------------------------------- a tool that fills its grid */

/*
 * The edge from a to b of a small solid passes through the centre C of a row:
 *
 *   a = C - n (p, q),  b = a + m (p, q),  with random odd integers p, q, m and n
 *
 * Both products in the edge function are then m n p q, an odd integer. In most solids its magnitude exceeds 2^24, so
 * that a float cannot represent it.
 *
 * Coordinates are in units of the snapped mesh, 2^10 per voxel.
 */
enum { FULL_SIDE = 58, FULL_UNITS = FULL_SIDE << 10, FULL_SOLIDS = 8, REACH = 14000 };

static int64_t drawn_odd(draw *d, int64_t lo, int64_t hi)
{
    return draw_between(d, lo / 2, (hi - 1) / 2) * 2 + 1;
}

static void solid_on_a_centre(draw *d, int64_t at[4][3])
{
    const int64_t p = drawn_odd(d, 3, 7), size = drawn_odd(d, 3, 7), q = draw_one_in(d, 2) ? size : -size,
                  most = REACH / (p > 7 || q > 7 ? 9 : 7);
    const int64_t m = drawn_odd(d, most * 3 / 4, most), n = drawn_odd(d, m * 2 / 5, m * 3 / 5);
    for (int v = 0; v < 4; v++)
        for (int a = 0; a < 3; a++)
            at[v][a] = draw_between(d, FULL_UNITS / 4, FULL_UNITS * 3 / 4);
    const int64_t y = drawn_odd(d, 44, 72) * 512, z = drawn_odd(d, 44, 72) * 512;
    at[0][1] = y - n * p;
    at[0][2] = z - n * q;
    at[1][1] = at[0][1] + m * p;
    at[1][2] = at[0][2] + m * q;
}

ost_status scene_add_full_tool(scene *s, draw *d, ost_pm voxel, ost_error *err)
{
    static const uint32_t faces[4][3] = {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {0, 2, 3}};
    const ost_pm half = FULL_SIDE / 2 * voxel;
    const ost_tool_geometry grid = {{FULL_SIDE, FULL_SIDE, FULL_SIDE}, voxel, {-half, -half, -half}};
    scene_tool *tool = &s->tools[s->tool_count];
    ost_mesh mesh = {0};
    *tool = (scene_tool){.rule = OST_FILL_WINDING, .name = "full"};
    s->tool_count++;
    ost_status status = ost_mesh_init(&mesh, 8 + 4 * FULL_SOLIDS, 12 + 4 * FULL_SOLIDS, err);
    if (status != OST_OK)
        return status;
    for (int c = 0; c < 8; c++)
        mesh.vertices[c] = (ost_pm3){c & 1 ? half : -half, c & 2 ? half : -half, c & 4 ? half : -half};
    memcpy(mesh.triangles, box_faces, sizeof box_faces);
    for (int b = 0; b < FULL_SOLIDS; b++) {
        int64_t at[4][3];
        solid_on_a_centre(d, at);
        /* Coordinates are rounded to picometres here; snapping yields the exact lattice units again. */
        for (int v = 0; v < 4; v++)
            mesh.vertices[8 + 4 * b + v] = (ost_pm3){(at[v][0] * voxel + 512) / 1024 - half,
                                                     (at[v][1] * voxel + 512) / 1024 - half,
                                                     (at[v][2] * voxel + 512) / 1024 - half};
        for (int t = 0; t < 4; t++)
            for (int c = 0; c < 3; c++)
                mesh.triangles[12 + 4 * b + t][c] = (uint32_t)(8 + 4 * b) + faces[t][c];
    }
    status = ost_mesh_snap(&mesh, &grid, &tool->cutting, err);
    tool->raw[0] = mesh;
    tool->grid_given = true;
    return status;
}

/* Makes a box that covers layers [z0, z1) of a grid completely along x and y. */
static ost_status layers(const ost_tool_geometry *grid, int32_t z0, int32_t z1, ost_mesh *out, ost_error *err)
{
    const ost_pm3 lo = grid->corner;
    const ost_status status = ost_mesh_init(out, 8, 12, err);
    if (status != OST_OK)
        return status;
    for (int c = 0; c < 8; c++)
        out->vertices[c] =
            (ost_pm3){lo.x + (c & 1 ? grid->dims.x * grid->voxel : 0), lo.y + (c & 2 ? grid->dims.y * grid->voxel : 0),
                      lo.z + (c & 4 ? z1 : z0) * grid->voxel};
    memcpy(out->triangles, box_faces, sizeof box_faces);
    return OST_OK;
}

ost_status scene_add_bar(scene *s, ost_dims size, int32_t shaft, ost_pm voxel, ost_error *err)
{
    const ost_pm3 lo = {-size.x / 2 * voxel, -size.y / 2 * voxel, -size.z / 2 * voxel};
    const ost_tool_geometry grid = {size, voxel, lo};
    const int32_t cuts = size.z - shaft;
    scene_tool *tool = &s->tools[s->tool_count];
    ost_mesh mesh = {0};
    *tool = (scene_tool){.rule = OST_FILL_WINDING, .name = "bar"};
    s->tool_count++;
    ost_status status = layers(&grid, 0, cuts, &mesh, err);
    if (status == OST_OK)
        status = ost_mesh_snap(&mesh, &grid, &tool->cutting, err);
    ost_mesh_free(&mesh);
    if (status == OST_OK && shaft)
        status = layers(&grid, cuts, size.z, &mesh, err);
    if (status == OST_OK && shaft)
        status = ost_mesh_snap(&mesh, &grid, &tool->noncutting, err);
    ost_mesh_free(&mesh);
    return status;
}

/* ------------------------------------------------------------------ plates */

enum { PLATES_X = 48, PLATES_YZ = 40, PLATES_ON_A_LINE = 4 };

/* Adds the corners of a box and its triangles, without the last `open` triangles. lo and hi are in voxels from the
   grid's corner. */
static void put_box(const ost_tool_geometry *grid, const int32_t lo[3], const int32_t hi[3], size_t open,
                    ost_mesh *mesh, size_t *corners)
{
    for (int c = 0; c < 8; c++)
        mesh->vertices[*corners + (size_t)c] = (ost_pm3){grid->corner.x + grid->voxel * (c & 1 ? hi : lo)[0],
                                                         grid->corner.y + grid->voxel * (c & 2 ? hi : lo)[1],
                                                         grid->corner.z + grid->voxel * (c & 4 ? hi : lo)[2]};
    for (size_t t = 0; t < 12 - open; t++, mesh->triangle_count++)
        for (int c = 0; c < 3; c++)
            mesh->triangles[mesh->triangle_count][c] = (uint32_t)*corners + box_faces[t][c];
    *corners += 8;
}

ost_status scene_add_plates(scene *s, ost_pm voxel, ost_error *err)
{
    static const int32_t at[3][2][3] = {{{4, 0, 0}, {8, PLATES_YZ, PLATES_YZ}},
                                        {{40, 0, 0}, {44, PLATES_YZ, PLATES_YZ}},
                                        {{20, 10, 10}, {28, 30, 30}}};
    const ost_tool_geometry grid = {{PLATES_X, PLATES_YZ, PLATES_YZ},
                                    voxel,
                                    {-PLATES_X / 2 * voxel, -PLATES_YZ / 2 * voxel, -PLATES_YZ / 2 * voxel}};
    scene_tool *tool = &s->tools[s->tool_count];
    ost_mesh *cutting = &tool->raw[0], *leaking = &tool->raw[1];
    *tool = (scene_tool){.rule = OST_FILL_WINDING, .name = "plates", .grid_given = true};
    s->tool_count++;
    ost_status status = ost_mesh_init(cutting, 16 + 3 * PLATES_ON_A_LINE, 24 + PLATES_ON_A_LINE, err);
    if (status == OST_OK)
        status = ost_mesh_init(leaking, 8, 12, err);
    if (status != OST_OK)
        return status;
    size_t corners = 0, of_leaking = 0;
    cutting->triangle_count = leaking->triangle_count = 0;
    put_box(&grid, at[0][0], at[0][1], 0, cutting, &corners);
    put_box(&grid, at[1][0], at[1][1], 0, cutting, &corners);
    put_box(&grid, at[2][0], at[2][1], 2, leaking, &of_leaking); /* the box lacks the face at its upper end along x */
    for (int t = 0; t < PLATES_ON_A_LINE; t++, cutting->triangle_count++)
        for (int c = 0; c < 3; c++, corners++) { /* the corners lie on a line along x and on three oblique lines */
            const ost_pm along = (3 + 5 * c) * voxel + voxel / 2;
            cutting->vertices[corners] =
                (ost_pm3){grid.corner.x + along, grid.corner.y + (t & 1 ? along : 9 * voxel + voxel / 2),
                          grid.corner.z + (t & 2 ? along : 11 * voxel + voxel / 2)};
            cutting->triangles[cutting->triangle_count][c] = (uint32_t)corners;
        }
    status = ost_mesh_snap(cutting, &grid, &tool->cutting, err);
    return status == OST_OK ? ost_mesh_snap(leaking, &grid, &tool->noncutting, err) : status;
}

/* ------------------------------------------------------------- a thin tool */

enum { THIN_X = 2, THIN_Y = 257, THIN_Z = 256, NEEDLES = 6, RING = 4 };

/*
 * Adds a needle that fills the voxel of a row in column 1, but no voxel of the neighbouring rows. Along x, the
 * needle is as long as a voxel; along y and z, it extends one unit from the row's centre.
 *
 *         1           Each end consists of four triangles around the row's
 *       / | \         centre.  Twice the area of each projection is 1.  One of
 *      2--*--0        the four triangles owns the row: two of its edge functions
 *       \ | /         are 0, the third is 1, and the rule of ownership subtracts
 *         3           1 from the third.
 */
static void put_needle(const ost_tool_geometry *grid, const int32_t row[2], bool inside_out, ost_mesh *mesh,
                       size_t *corners)
{
    static const int across[RING + 1][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}, {0, 0}};
    /* The two ends of the needle have corresponding corners; `far` is the difference of their indices. */
    const uint32_t first = (uint32_t)*corners, far = RING + 1;
    for (uint32_t end = 0; end < 2; end++)
        /* Coordinates are rounded to picometres here; snapping yields the exact lattice units again. */
        for (int c = 0; c <= RING; c++, ++*corners)
            mesh->vertices[*corners] =
                (ost_pm3){grid->corner.x + (1 + end) * grid->voxel,
                          grid->corner.y + ((row[0] * 1024 + 512 + across[c][0]) * grid->voxel + 512) / 1024,
                          grid->corner.z + ((row[1] * 1024 + 512 + across[c][1]) * grid->voxel + 512) / 1024};
    for (uint32_t c = 0; c < RING; c++) {
        const uint32_t next = (c + 1) % RING;
        const uint32_t faces[4][3] = {
            {RING, next, c}, {far + RING, far + c, far + next}, {c, next, far + next}, {c, far + next, far + c}};
        for (int t = 0; t < 4; t++, mesh->triangle_count++)
            for (int i = 0; i < 3; i++)
                mesh->triangles[mesh->triangle_count][i] = first + faces[t][inside_out ? 2 - i : i];
    }
}

ost_status scene_add_thin_tool(scene *s, ost_pm voxel, ost_error *err)
{
    static const int32_t all[2][3] = {{0, 0, 0}, {1, THIN_Y, THIN_Z}};
    static const int32_t rows[NEEDLES][2] = {{0, 0},    {THIN_Y - 1, THIN_Z - 1}, {7, 8},
                                             {128, 64}, {100, 201},               {255, 255}};
    const ost_tool_geometry grid = {
        {THIN_X, THIN_Y, THIN_Z}, voxel, {-THIN_X / 2 * voxel, -THIN_Y / 2 * voxel, -THIN_Z / 2 * voxel}};
    scene_tool *tool = &s->tools[s->tool_count];
    ost_mesh *mesh = &tool->raw[0];
    *tool = (scene_tool){.rule = OST_FILL_WINDING, .name = "thin", .grid_given = true};
    s->tool_count++;
    const ost_status status = ost_mesh_init(mesh, 8 + NEEDLES * 2 * (RING + 1), 12 + NEEDLES * 4 * RING, err);
    if (status != OST_OK)
        return status;
    size_t corners = 0;
    mesh->triangle_count = 0;
    put_box(&grid, all[0], all[1], 0, mesh, &corners);
    for (int n = 0; n < NEEDLES; n++)
        put_needle(&grid, rows[n], n % 2, mesh, &corners);
    return ost_mesh_snap(mesh, &grid, &tool->cutting, err);
}

void scene_tool_free(scene_tool *tool)
{
    ost_snapped_mesh_free(&tool->cutting);
    ost_snapped_mesh_free(&tool->noncutting);
    ost_mesh_free(&tool->raw[0]);
    ost_mesh_free(&tool->raw[1]);
}
