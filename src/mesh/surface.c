/* SPDX-License-Identifier: Apache-2.0 */
#include "mesh/surface.h"

#include <stdlib.h>
#include <string.h>

/*
 * A cell is the cube between eight voxel centres. Corner c is at (c & 1, c >> 1 & 1, c >> 2). Edge e = 4 * axis + p is
 * parallel to `axis`; bits 0 and 1 of p are the edge's positions along the axes axis + 1 and axis + 2 (mod 3).
 */
enum { CORNERS = 8, EDGES = 12, LOOP_MAX = 12 };

static int edge_corner(int edge, int end)
{
    int axis = edge / 4, u = (axis + 1) % 3, v = (axis + 2) % 3;
    return (edge & 1) << u | (edge >> 1 & 1) << v | end << axis;
}

static int edge_between(int a, int b)
{
    for (int e = 0; e < EDGES; e++)
        if ((edge_corner(e, 0) == a && edge_corner(e, 1) == b) || (edge_corner(e, 0) == b && edge_corner(e, 1) == a))
            return e;
    abort();
}

/* The loops of the surface in a cell, for one of the 256 sets of solid corners. */
typedef struct pattern {
    uint8_t loop_count;
    struct {
        uint8_t length;
        /*
         * index of a vertex around which a fan of triangles fills the loop without a diagonal in a face of the cell; -1
         * if there is no such vertex; the loop then has an additional vertex in its middle
         */
        int8_t apex;
        uint8_t edge[LOOP_MAX];
    } loop[4];
} pattern;

/* Computes the four corners of the face (axis, side), counter-clockwise as seen from outside the cell. */
static void face_corners(int axis, int side, int corner[4])
{
    int u = (axis + 1) % 3, v = (axis + 2) % 3, base = side << axis;
    const int walk[4] = {base, base | 1 << u, base | 1 << u | 1 << v, base | 1 << v};
    for (int i = 0; i < 4; i++)
        corner[i] = walk[side ? i : 3 - i];
}

/*
 * Computes next[e], the edge that follows edge e in a loop of the surface. The corners of each face are visited
 * counter-clockwise, as seen from outside the cell. A run of solid corners is entered across one edge and left across
 * another; the surface connects the first edge to the second. Loops are therefore counter-clockwise as seen from the
 * empty side.
 */
static void join_faces(int solid, int next[EDGES])
{
    for (int face = 0; face < 6; face++) {
        int corner[4];
        face_corners(face / 2, face & 1, corner);
        for (int i = 0; i < 4; i++) {
            bool here = solid >> corner[i] & 1, before = solid >> corner[(i + 3) % 4] & 1;
            if (!here || before)
                continue;
            int last = i;
            while (solid >> corner[(last + 1) % 4] & 1)
                last = (last + 1) % 4;
            next[edge_between(corner[(i + 3) % 4], corner[i])] = edge_between(corner[last], corner[(last + 1) % 4]);
        }
    }
}

/* Returns true if two edges lie in a common face of the cell, that is, if all four ends agree in one coordinate. */
static bool share_face(int e, int f)
{
    int all = edge_corner(e, 0) & edge_corner(e, 1) & edge_corner(f, 0) & edge_corner(f, 1);
    int none = ~(edge_corner(e, 0) | edge_corner(e, 1) | edge_corner(f, 0) | edge_corner(f, 1)) & 7;
    return all || none;
}

static int find_apex(const uint8_t *edge, int length)
{
    for (int a = 0; a < length; a++) {
        bool fits = true;
        for (int k = 2; k < length - 1; k++)
            fits &= !share_face(edge[a], edge[(a + k) % length]);
        if (fits)
            return a;
    }
    return -1;
}

static void pattern_make(int solid, pattern *p)
{
    int next[EDGES];
    bool done[EDGES] = {false};
    memset(next, -1, sizeof next);
    memset(p, 0, sizeof *p);
    join_faces(solid, next);
    for (int start = 0; start < EDGES; start++) {
        if (next[start] < 0 || done[start])
            continue;
        int length = 0;
        for (int e = start; !done[e]; e = next[e]) {
            done[e] = true;
            p->loop[p->loop_count].edge[length++] = (uint8_t)e;
        }
        p->loop[p->loop_count].length = (uint8_t)length;
        p->loop[p->loop_count].apex = (int8_t)find_apex(p->loop[p->loop_count].edge, length);
        p->loop_count++;
    }
}

/* ------------------------------------------------------------ the volume */

/*
 * Processes cells in slabs of ascending z. Vertex indices are stored for the edges of two slices of voxel centres:
 * those along x and y within each slice, and those along z between the slices.
 */
typedef struct builder {
    const ost_volume *volume;
    int32_t threshold;
    int64_t nx, ny;          /* number of voxel centres along x and along y, including an empty border: dims + 2 */
    /* vertex indices: slice[0][a] for the edges along axis a in the lower slice, slice[1][a] for those in the upper
     * slice */
    uint32_t *slice[2][2];
    uint32_t *between;       /* vertex indices of the edges along z */
    ost_mesh mesh;
    size_t vertex_capacity, triangle_capacity;
    /* position of each vertex on its edge, from 0 (lower end) to 1; -1 for a vertex in the middle of a loop */
    float *coordinates;
    uint8_t *along;          /* axis of each vertex's edge in bits 0 and 1; bit 2 is 1 if the lower end is solid */
    pattern patterns[256];
} builder;

static bool solid_at(const builder *b, int64_t i, int64_t j, int64_t k)
{
    const ost_dims d = b->volume->geometry.dims;
    if (i < 0 || j < 0 || k < 0 || i >= d.x || j >= d.y || k >= d.z)
        return false;
    return b->volume->voxels[i + d.x * (j + d.y * k)] >= b->threshold;
}

static int density_at(const builder *b, int64_t i, int64_t j, int64_t k)
{
    const ost_dims d = b->volume->geometry.dims;
    if (i < 0 || j < 0 || k < 0 || i >= d.x || j >= d.y || k >= d.z)
        return b->threshold - 1000;
    return b->volume->voxels[i + d.x * (j + d.y * k)];
}

/* Returns the next capacity, about 1.5 times the current one. */
static size_t more(size_t capacity)
{
    return capacity + capacity / 2 + 4096;
}

static ost_status vertex_capacity(builder *b, ost_error *err)
{
    size_t capacity = more(b->vertex_capacity);
    if (b->mesh.vertex_count < b->vertex_capacity)
        return OST_OK;
    if (capacity > UINT32_MAX / 2)
        return ost_fail(err, OST_ERR_RANGE, "the surface has more than %zu vertices", b->vertex_capacity);
    ost_pm3 *vertices = realloc(b->mesh.vertices, capacity * sizeof *vertices);
    if (vertices)
        b->mesh.vertices = vertices;
    float *coordinates = realloc(b->coordinates, capacity * sizeof *coordinates);
    if (coordinates)
        b->coordinates = coordinates;
    uint8_t *along = realloc(b->along, capacity * sizeof *along);
    if (along)
        b->along = along;
    if (!vertices || !coordinates || !along)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a surface of %zu vertices", capacity);
    b->vertex_capacity = capacity;
    return OST_OK;
}

static ost_pm3 centre(const builder *b, int64_t i, int64_t j, int64_t k)
{
    const ost_geometry *g = &b->volume->geometry;
    return (ost_pm3){g->origin.x + i * g->spacing.x, g->origin.y + j * g->spacing.y, g->origin.z + k * g->spacing.z};
}

/*
 * Clamps the position of a vertex to a minimum distance from the ends of its edge, so that no triangle is degenerate.
 */
static float clamped_off_ends(float t)
{
    return t < 0.05f ? 0.05f : t > 0.95f ? 0.95f : t;
}

/*
 * Adds the vertex on the edge that begins at centre (i, j, k) and runs along `axis`. Until place_vertices is
 * called, the vertex has the coordinates of the edge's lower end.
 */
static ost_status edge_vertex(builder *b, int64_t i, int64_t j, int64_t k, int axis, uint32_t *out, ost_error *err)
{
    ost_status status = vertex_capacity(b, err);
    if (status != OST_OK)
        return status;
    int low = density_at(b, i, j, k), high = density_at(b, i + (axis == 0), j + (axis == 1), k + (axis == 2));
    uint32_t v = (uint32_t)b->mesh.vertex_count++;
    b->mesh.vertices[v] = centre(b, i, j, k);
    /* A voxel at the threshold is solid, so the surface is placed half a density unit below the threshold. */
    b->coordinates[v] = clamped_off_ends(((float)b->threshold - 0.5f - (float)low) / (float)(high - low));
    b->along[v] = (uint8_t)(axis | (low >= b->threshold ? 4 : 0));
    *out = v;
    return OST_OK;
}

static ost_status triangle(builder *b, uint32_t x, uint32_t y, uint32_t z, ost_error *err)
{
    if (b->mesh.triangle_count >= OST_MESH_TRIANGLES_MAX)
        return ost_fail(err, OST_ERR_RANGE,
                        "the surface has more than %d triangles; crop the bone or take larger voxels",
                        OST_MESH_TRIANGLES_MAX);
    if (b->mesh.triangle_count == b->triangle_capacity) {
        size_t capacity = more(b->triangle_capacity);
        uint32_t(*triangles)[3] = realloc(b->mesh.triangles, capacity * sizeof *triangles);
        if (!triangles)
            return ost_fail(err, OST_ERR_MEMORY, "out of memory for a surface of %zu triangles", capacity);
        b->mesh.triangles = triangles;
        b->triangle_capacity = capacity;
    }
    uint32_t *t = b->mesh.triangles[b->mesh.triangle_count++];
    t[0] = x;
    t[1] = y;
    t[2] = z;
    return OST_OK;
}

/*
 * Fills a loop with a fan of triangles around its apex or, if there is none, around a new vertex in its middle. The
 * position of a middle vertex depends on the final positions of the other vertices, so place_vertices computes it
 * later. A value of -1 in b->coordinates marks a middle vertex.
 */
static ost_status fill_loop(builder *b, const uint32_t *ring, int length, int apex, ost_error *err)
{
    ost_status status = OST_OK;
    if (apex >= 0) {
        for (int k = 1; k < length - 1 && status == OST_OK; k++)
            status = triangle(b, ring[apex], ring[(apex + k) % length], ring[(apex + k + 1) % length], err);
        return status;
    }
    if ((status = vertex_capacity(b, err)) != OST_OK)
        return status;
    uint32_t middle = (uint32_t)b->mesh.vertex_count++;
    b->mesh.vertices[middle] = (ost_pm3){0, 0, 0};
    b->coordinates[middle] = -1;
    b->along[middle] = 0;
    for (int k = 0; k < length && status == OST_OK; k++)
        status = triangle(b, middle, ring[k], ring[(k + 1) % length], err);
    return status;
}

static uint32_t *edge_slot(builder *b, int64_t i, int64_t j, int edge)
{
    int low = edge_corner(edge, 0), axis = edge / 4;
    int64_t at = (i + 1 + (low & 1)) + b->nx * (j + 1 + (low >> 1 & 1));
    return axis == 2 ? &b->between[at] : &b->slice[low >> 2][axis][at];
}

static ost_status cell(builder *b, int64_t i, int64_t j, int solid, ost_error *err)
{
    const pattern *p = &b->patterns[solid];
    ost_status status = OST_OK;
    for (int l = 0; l < p->loop_count && status == OST_OK; l++) {
        uint32_t ring[LOOP_MAX];
        for (int e = 0; e < p->loop[l].length; e++)
            ring[e] = *edge_slot(b, i, j, p->loop[l].edge[e]);
        status = fill_loop(b, ring, p->loop[l].length, p->loop[l].apex, err);
    }
    return status;
}

/* Creates the vertices on the x and y edges within slice k and stores their indices in `slot`. */
static ost_status slice_vertices(builder *b, int64_t k, uint32_t *slot[2], ost_error *err)
{
    ost_status status = OST_OK;
    for (int64_t j = -1; j < b->ny - 1; j++)
        for (int64_t i = -1; i < b->nx - 1 && status == OST_OK; i++) {
            bool here = solid_at(b, i, j, k);
            for (int axis = 0; axis < 2 && status == OST_OK; axis++)
                if (here != solid_at(b, i + (axis == 0), j + (axis == 1), k))
                    status = edge_vertex(b, i, j, k, axis, &slot[axis][(i + 1) + b->nx * (j + 1)], err);
        }
    return status;
}

static ost_status between_vertices(builder *b, int64_t k, ost_error *err)
{
    ost_status status = OST_OK;
    for (int64_t j = -1; j < b->ny - 1; j++)
        for (int64_t i = -1; i < b->nx - 1 && status == OST_OK; i++)
            if (solid_at(b, i, j, k) != solid_at(b, i, j, k + 1))
                status = edge_vertex(b, i, j, k, 2, &b->between[(i + 1) + b->nx * (j + 1)], err);
    return status;
}

static ost_status slab(builder *b, int64_t k, ost_error *err)
{
    ost_status status = slice_vertices(b, k + 1, b->slice[1], err);
    if (status == OST_OK)
        status = between_vertices(b, k, err);
    for (int64_t j = -1; j < b->ny - 2; j++)
        for (int64_t i = -1; i < b->nx - 2 && status == OST_OK; i++) {
            int solid = 0;
            for (int c = 0; c < CORNERS; c++)
                solid |= solid_at(b, i + (c & 1), j + (c >> 1 & 1), k + (c >> 2)) << c;
            if (solid != 0 && solid != 255)
                status = cell(b, i, j, solid, err);
        }
    for (int axis = 0; axis < 2; axis++) {
        uint32_t *swap = b->slice[0][axis];
        b->slice[0][axis] = b->slice[1][axis];
        b->slice[1][axis] = swap;
    }
    return status;
}

/* ------------------------------------------------------------- placement */

static double step_mm(const builder *b, int axis)
{
    const ost_pm3 s = b->volume->geometry.spacing;
    return ost_pm_to_mm(axis == 0 ? s.x : axis == 1 ? s.y : s.z);
}

static void position(const builder *b, uint32_t v, double out[3])
{
    const ost_pm3 p = b->mesh.vertices[v];
    out[0] = ost_pm_to_mm(p.x);
    out[1] = ost_pm_to_mm(p.y);
    out[2] = ost_pm_to_mm(p.z);
    if (b->coordinates[v] >= 0)
        out[b->along[v] & 3] += b->coordinates[v] * step_mm(b, b->along[v] & 3);
}

/*
 * Smooths the surface, so that the steps between voxels become slopes. All vertices start in the middle of their edges.
 * In each round, each vertex moves along its edge to the projection of the mean of its neighbours.
 */
static ost_status smooth(builder *b, ost_error *err)
{
    enum { ROUNDS = 8 };
    size_t n = b->mesh.vertex_count;
    float(*sum)[4] = calloc(n, sizeof *sum);
    if (!sum)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory to smooth %zu vertices", n);
    for (size_t v = 0; v < n; v++)
        if (b->coordinates[v] >= 0)
            b->coordinates[v] = 0.5f;
    const ost_pm3 origin = b->volume->geometry.origin;
    const double o[3] = {ost_pm_to_mm(origin.x), ost_pm_to_mm(origin.y), ost_pm_to_mm(origin.z)};
    for (int round = 0; round < ROUNDS; round++) {
        memset(sum, 0, n * sizeof *sum);
        for (size_t t = 0; t < b->mesh.triangle_count; t++)
            for (int c = 0; c < 3; c++) {
                uint32_t from = b->mesh.triangles[t][c], to = b->mesh.triangles[t][(c + 1) % 3];
                double p[3];
                if (b->coordinates[from] < 0 || b->coordinates[to] < 0)
                    continue;
                position(b, from, p);
                for (int a = 0; a < 3; a++)
                    sum[to][a] += (float)(p[a] - o[a]);
                sum[to][3] += 1;
            }
        for (size_t v = 0; v < n; v++)
            if (b->coordinates[v] >= 0 && sum[v][3] > 0) {
                int axis = b->along[v] & 3;
                const ost_pm3 low = b->mesh.vertices[v];
                double start = ost_pm_to_mm(axis == 0 ? low.x : axis == 1 ? low.y : low.z) - o[axis];
                b->coordinates[v] = clamped_off_ends((float)((sum[v][axis] / sum[v][3] - start) / step_mm(b, axis)));
            }
    }
    free(sum);
    return OST_OK;
}

static ost_pm nearest_pm(double mm)
{
    ost_pm pm = 0;
    return ost_pm_from_binary(mm, &pm) ? pm : 0;
}

/*
 * Computes the positions of the vertices on edges. Then sets the position of each vertex in the middle of a loop to the
 * mean of the loop's vertices.
 */
static ost_status place_vertices(builder *b, ost_error *err)
{
    for (size_t v = 0; v < b->mesh.vertex_count; v++)
        if (b->coordinates[v] >= 0) {
            double p[3];
            position(b, (uint32_t)v, p);
            b->mesh.vertices[v] = (ost_pm3){nearest_pm(p[0]), nearest_pm(p[1]), nearest_pm(p[2])};
        }
    uint8_t *ring = calloc(b->mesh.vertex_count ? b->mesh.vertex_count : 1, 1);
    if (!ring)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %zu vertices", b->mesh.vertex_count);
    for (size_t t = 0; t < b->mesh.triangle_count; t++) {
        const uint32_t *x = b->mesh.triangles[t];
        if (b->coordinates[x[0]] >= 0)
            continue;
        ost_pm3 *m = &b->mesh.vertices[x[0]], p = b->mesh.vertices[x[1]];
        *m = (ost_pm3){m->x + p.x, m->y + p.y, m->z + p.z};
        ring[x[0]]++;
    }
    for (size_t v = 0; v < b->mesh.vertex_count; v++)
        if (ring[v]) {
            ost_pm3 *m = &b->mesh.vertices[v];
            *m = (ost_pm3){m->x / ring[v], m->y / ring[v], m->z / ring[v]};
        }
    free(ring);
    return OST_OK;
}

ost_status ost_surface_extract(const ost_volume *volume, int32_t threshold, ost_surface_placement coordinates,
                               ost_mesh *out, ost_error *err)
{
    const ost_dims d = volume->geometry.dims;
    *out = (ost_mesh){0};
    builder *b = calloc(1, sizeof *b);
    if (!b)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a surface");
    b->volume = volume;
    b->threshold = threshold;
    b->nx = (int64_t)d.x + 2;
    b->ny = (int64_t)d.y + 2;
    size_t area = (size_t)(b->nx * b->ny);
    ost_status status = OST_OK;
    uint32_t *slots = calloc(area, 5 * sizeof *slots);
    if (!slots)
        status = ost_fail(err, OST_ERR_MEMORY, "out of memory for slices of %zu voxels", area);
    for (int s = 0; s < 4 && slots; s++)
        b->slice[s / 2][s % 2] = slots + (size_t)s * area;
    if (slots)
        b->between = slots + 4 * area;
    for (int p = 0; p < 256; p++)
        pattern_make(p, &b->patterns[p]);
    for (int64_t k = -1; k < d.z && status == OST_OK; k++)
        status = slab(b, k, err);
    if (status == OST_OK && b->mesh.triangle_count == 0)
        status = ost_fail(err, OST_ERR_INPUT,
                          "no voxel has a density of %d or more, so there is no surface; use a lower threshold",
                          threshold);
    if (status == OST_OK && coordinates == OST_SURFACE_SMOOTH)
        status = smooth(b, err);
    if (status == OST_OK)
        status = place_vertices(b, err);
    free(slots);
    free(b->coordinates);
    free(b->along);
    if (status == OST_OK)
        *out = b->mesh;
    else
        ost_mesh_free(&b->mesh);
    free(b);
    return status;
}
