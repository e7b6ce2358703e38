/* SPDX-License-Identifier: Apache-2.0 */
#include "bench/meshes.h"

#include <math.h>

static const double TURN = 6.283185307179586;

typedef struct vec {
    double x, y, z;
} vec;

static vec cross(vec a, vec b)
{
    return (vec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static vec unit(vec a)
{
    double length = sqrt(a.x * a.x + a.y * a.y + a.z * a.z);
    return (vec){a.x / length, a.y / length, a.z / length};
}

/* Rotates a point about y and then about x, so that no edge of the mesh is parallel to an axis. */
static vec tilted(vec p)
{
    const double a = 0.3, b = 0.2;
    vec q = {p.x * cos(a) + p.z * sin(a), p.y, p.z * cos(a) - p.x * sin(a)};
    return (vec){q.x, q.y * cos(b) - q.z * sin(b), q.z * cos(b) + q.y * sin(b)};
}

static ost_pm3 placed(vec p, ost_pm side)
{
    const double scale = 0.49 * (double)side, middle = 0.5 * (double)side;
    return (ost_pm3){llrint(middle + scale * p.x), llrint(middle + scale * p.y), llrint(middle + scale * p.z)};
}

static void put_triangle(ost_mesh *mesh, size_t *at, size_t a, size_t b, size_t c)
{
    mesh->triangles[*at][0] = (uint32_t)a;
    mesh->triangles[*at][1] = (uint32_t)b;
    mesh->triangles[(*at)++][2] = (uint32_t)c;
}

/* Adds a sphere. Its centre and radius are given in units of half the cube's side. *vertex and *triangle are the
   indices of the first free vertex and the first free triangle; the function advances them. */
static void put_sphere(ost_mesh *mesh, size_t *vertex, size_t *triangle, ost_pm side, size_t meridians, size_t rings,
                       vec centre, double radius)
{
    const size_t first = *vertex, north = first + meridians * rings, south = north + 1;
    for (size_t r = 0; r <= rings + 1; r++) /* the last two iterations add the poles */
        for (size_t m = 0; m < (r < rings ? meridians : 1); m++) {
            const double ring = r < rings ? (double)(r + 1) : r == rings ? 0 : (double)(rings + 1);
            const double polar = TURN / 2 * ring / (double)(rings + 1);
            const double around = TURN * (double)m / (double)meridians;
            const vec p = tilted((vec){sin(polar) * cos(around), sin(polar) * sin(around), cos(polar)});
            mesh->vertices[(*vertex)++] = placed(
                (vec){centre.x + radius * p.x, centre.y + radius * p.y, centre.z + radius * p.z}, side);
        }
    for (size_t m = 0; m < meridians; m++) {
        const size_t next = (m + 1) % meridians, last = first + meridians * (rings - 1);
        put_triangle(mesh, triangle, north, first + m, first + next);
        put_triangle(mesh, triangle, south, last + next, last + m);
        for (size_t r = 0; r + 1 < rings; r++) {
            const size_t a = first + r * meridians + m, b = first + r * meridians + next;
            put_triangle(mesh, triangle, a, a + meridians, b + meridians);
            put_triangle(mesh, triangle, a, b + meridians, b);
        }
    }
}

ost_status bench_balls(ost_pm side, int across, int meridians, int rings, ost_mesh *out, ost_error *err)
{
    const size_t count = (size_t)across * (size_t)across * (size_t)across, ring = (size_t)meridians * (size_t)rings;
    ost_status status = ost_mesh_init(out, count * (ring + 2), 2 * count * ring, err);
    const double step = 2.0 / across;
    size_t vertex = 0, triangle = 0;
    for (size_t i = 0; i < count && status == OST_OK; i++) {
        const size_t n = (size_t)across;
        const vec place = {(double)(i % n), (double)(i / n % n), (double)(i / n / n)};
        put_sphere(out, &vertex, &triangle, side, (size_t)meridians, (size_t)rings,
                   (vec){step * (place.x + 0.5) - 1, step * (place.y + 0.5) - 1, step * (place.z + 0.5) - 1},
                   across > 1 ? 0.45 * step : 1);
    }
    return status;
}

ost_status bench_sphere(ost_pm side, ost_mesh *out, ost_error *err)
{
    return bench_balls(side, 1, 300, 134, out, err);
}

static vec knot_point(double t)
{
    double ring = 2 + cos(3 * t);
    return (vec){ring * cos(2 * t), ring * sin(2 * t), sin(3 * t)};
}

ost_status bench_knot(ost_pm side, ost_mesh *out, ost_error *err)
{
    enum { U = 2048, V = 128 };
    /* radius of the tube; outer radius of the knot */
    const double radius = 0.42, reach = 3 + radius;
    ost_status status = ost_mesh_init(out, (size_t)U * V, 2 * (size_t)U * V, err);
    if (status != OST_OK)
        return status;
    for (int u = 0; u < U; u++) {
        /* The axes of the tube's cross-section. They are derived from the tangent and from the normal
           of the torus, so they do not depend on the previous point of the knot. */
        const double t = TURN * u / U, h = 1e-5;
        const vec p = knot_point(t), ahead = knot_point(t + h), behind = knot_point(t - h);
        const vec tangent = unit((vec){ahead.x - behind.x, ahead.y - behind.y, ahead.z - behind.z});
        const vec outward = {cos(3 * t) * cos(2 * t), cos(3 * t) * sin(2 * t), sin(3 * t)};
        const vec side_ways = unit(cross(tangent, outward)), up = cross(side_ways, tangent);
        for (int v = 0; v < V; v++) {
            const double c = radius * cos(TURN * v / V), s = radius * sin(TURN * v / V);
            const vec q = {p.x + c * up.x + s * side_ways.x, p.y + c * up.y + s * side_ways.y,
                           p.z + c * up.z + s * side_ways.z};
            out->vertices[(size_t)u * V + (size_t)v] = placed((vec){q.x / reach, q.y / reach, q.z / reach}, side);
        }
    }
    size_t at = 0;
    for (size_t u = 0; u < U; u++)
        for (size_t v = 0; v < V; v++) {
            size_t a = u * V + v, b = u * V + (v + 1) % V, c = (u + 1) % U * V + v, d = (u + 1) % U * V + (v + 1) % V;
            put_triangle(out, &at, a, c, d);
            put_triangle(out, &at, a, d, b);
        }
    return OST_OK;
}
