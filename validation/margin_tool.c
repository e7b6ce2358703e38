/* SPDX-License-Identifier: Apache-2.0 */
/* Computes the margins of tools: exact distances between voxel centres and the mesh. */
#include "validation/margin_parts.h"

#include "core/integer.h"

/* Maximum number of distances that are computed between voxel centres and triangles. After this number, the
   remaining voxels of the record are not measured. */
enum { TRIANGLE_TESTS = 200 * 1000 * 1000 };

typedef struct vector {
    int64_t x, y, z;
} vector;

static vector minus(vector a, vector b)
{
    return (vector){a.x - b.x, a.y - b.y, a.z - b.z};
}

static ost_i128 dot(vector a, vector b)
{
    return (ost_i128)a.x * b.x + (ost_i128)a.y * b.y + (ost_i128)a.z * b.z;
}

static vector cross(vector a, vector b)
{
    return (vector){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/*
 * A squared distance as a fraction of 128-bit integers. Coordinates are twice those of the lattice, so that
 * voxel centres have integer coordinates. The maximum magnitudes are 2^21 for coordinates, 2^22 for
 * differences, 2^45 for cross products, and 2^92 for the squares of cross products. The square (n . p)^2 for
 * a plane with normal n is up to 2^136 and would not fit. The squared distance to a plane is therefore
 * computed only for |n . p| < 2^63, which is sufficient for triangles of this size. For larger values the
 * distance to the edges is used.
 */
typedef struct fraction {
    unsigned __int128 top, bottom;
} fraction;

static bool less(fraction a, fraction b)
{
    const unsigned __int128 p = a.top / a.bottom, q = b.top / b.bottom;
    if (p != q)
        return p < q;
    /* The integer parts are equal, so the fractions are compared bit by bit. */
    unsigned __int128 r = a.top % a.bottom, s = b.top % b.bottom;
    for (int bit = 0; bit < 64; bit++) {
        r <<= 1;
        s <<= 1;
        const bool x = r >= a.bottom, y = s >= b.bottom;
        if (x != y)
            return y;
        r -= x ? a.bottom : 0;
        s -= y ? b.bottom : 0;
    }
    return false;
}

static fraction to_edge(vector p, vector a, vector b)
{
    const vector ab = minus(b, a), ap = minus(p, a);
    const ost_i128 t = dot(ap, ab), length = dot(ab, ab);
    if (t <= 0 || length == 0)
        return (fraction){(unsigned __int128)dot(ap, ap), 1};
    if (t >= length)
        return (fraction){(unsigned __int128)dot(minus(p, b), minus(p, b)), 1};
    const vector c = cross(ap, ab);
    return (fraction){(unsigned __int128)dot(c, c), (unsigned __int128)length};
}

static fraction to_triangle(vector p, vector a, vector b, vector c)
{
    const vector n = cross(minus(b, a), minus(c, a));
    const ost_i128 length = dot(n, n), height = dot(n, minus(p, a));
    const bool over = dot(cross(minus(b, a), minus(p, a)), n) >= 0 && dot(cross(minus(c, b), minus(p, b)), n) >= 0 &&
                      dot(cross(minus(a, c), minus(p, c)), n) >= 0;
    if (length > 0 && over && height > -((ost_i128)1 << 63) && height < ((ost_i128)1 << 63))
        return (fraction){(unsigned __int128)(height * height), (unsigned __int128)length};
    fraction best = to_edge(p, a, b);
    const fraction second = to_edge(p, b, c), third = to_edge(p, c, a);
    best = less(second, best) ? second : best;
    return less(third, best) ? third : best;
}

static uint64_t square_root(unsigned __int128 x)
{
    unsigned __int128 root = 0, bit = (unsigned __int128)1 << 126;
    while (bit > x)
        bit >>= 2;
    for (; bit; bit >>= 2) {
        if (x >= root + bit) {
            x -= root + bit;
            root = (root >> 1) + bit;
        } else
            root >>= 1;
    }
    return (uint64_t)root;
}

/* Returns floor(2^20 sqrt(f) / 2^bits). q begins as the integer part of f. The loop appends 2 (20 - bits) binary
   fraction digits of f to q, one at a time. The result is the integer part of the square root of q. */
static uint64_t in_voxels(fraction f, int bits)
{
    unsigned __int128 q = f.top / f.bottom, r = f.top % f.bottom;
    for (int i = 0; i < 2 * (20 - bits); i++) {
        r <<= 1;
        q = 2 * q + (r >= f.bottom);
        r -= r >= f.bottom ? f.bottom : 0;
    }
    return square_root(q);
}

static vector vertex_of(const ost_snapped_mesh *mesh, uint32_t v)
{
    return (vector){2 * (int64_t)mesh->vertices[v][0], 2 * (int64_t)mesh->vertices[v][1],
                    2 * (int64_t)mesh->vertices[v][2]};
}

/* Returns a lower bound on the distance from p to a triangle, along one axis. a, b and c are the corners' coordinates
   on this axis. */
static int64_t beyond(int64_t p, int64_t a, int64_t b, int64_t c)
{
    const int64_t lo = a < b ? (a < c ? a : c) : b < c ? b : c, hi = a > b ? (a > c ? a : c) : b > c ? b : c;
    return p < lo ? lo - p : p > hi ? p - hi : 0;
}

static bool nearest_surface(const ost_snapped_mesh *mesh, vector p, int64_t *tests, bool had, fraction *best)
{
    for (size_t t = 0; t < mesh->triangle_count; t++, --*tests) {
        const vector a = vertex_of(mesh, mesh->triangles[t][0]), b = vertex_of(mesh, mesh->triangles[t][1]),
                     c = vertex_of(mesh, mesh->triangles[t][2]);
        const int64_t x = beyond(p.x, a.x, b.x, c.x), y = beyond(p.y, a.y, b.y, c.y), z = beyond(p.z, a.z, b.z, c.z);
        const ost_i128 least = (ost_i128)x * x + (ost_i128)y * y + (ost_i128)z * z;
        if (had && (unsigned __int128)least > best->top / best->bottom)
            continue;
        const fraction f = to_triangle(p, a, b, c);
        if (!had || less(f, *best))
            *best = f;
        had = true;
    }
    return had;
}

void margin_tool(margin_walk *w, uint32_t item, const trace_block_view *a, const trace_block_view *b)
{
    margin_stage *m = &w->out->of[TRACE_TOOL];
    const scene_tool *tool = &w->s->tools[item];
    const size_t all = (size_t)ost_dims_count(a->dims);
    const int bits = tool->cutting.fraction_bits;
    int64_t tests = TRIANGLE_TESTS;
    for (size_t i = 0; i < all; i++) {
        int32_t at[3];
        fraction best = {0, 1};
        if (a->voxels[i] == b->voxels[i])
            continue;
        if (tests < 0) {
            margin_other(m, &m->unmeasured);
            continue;
        }
        margin_position(a->dims, i, at);
        const int64_t one = INT64_C(1) << bits;
        const vector p = {(2 * (int64_t)at[0] + 1) * one, (2 * (int64_t)at[1] + 1) * one,
                          (2 * (int64_t)at[2] + 1) * one};
        bool had = nearest_surface(&tool->cutting, p, &tests, false, &best);
        had = nearest_surface(&tool->noncutting, p, &tests, had, &best);
        if (had)
            margin_decided(m, in_voxels(best, bits + 1), item, at);
        else
            margin_other(m, &m->unexplained);
    }
}
