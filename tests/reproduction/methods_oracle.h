/* SPDX-License-Identifier: Apache-2.0 */
/*
 * An oracle for the compared removal methods: it implements AR-MAP-1 to AR-MAP-4, AR-REM-1 and
 * reproduction/methods/points.h with fractions of 128-bit integers, and calls no function of the methods or of
 * src/core.
 */
#ifndef OST_TESTS_METHODS_ORACLE_H
#define OST_TESTS_METHODS_ORACLE_H

#include "harness.h"

#include "reproduction/methods/points.h"

__extension__ typedef __int128 wide;

static inline wide floor_of(wide n, wide d)
{
    wide q = n / d;
    return q * d > n ? q - 1 : q;
}

/* Returns n / d, rounded half to even. Twice the remainder is compared with the divisor. */
static inline wide rhe(wide n, wide d)
{
    const wide q = floor_of(n, d), twice = 2 * (n - q * d);
    return twice > d || (twice == d && q % 2 != 0) ? q + 1 : q;
}

typedef struct rotation {
    wide m[3][3], n;
} rotation;

static inline rotation rotation_of(const ost_pose *p)
{
    const wide w = p->qw, x = p->qx, y = p->qy, z = p->qz;
    rotation r = {.n = w * w + x * x + y * y + z * z};
    const wide m[3][3] = {{w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)},
                          {2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)},
                          {2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z}};
    memcpy(r.m, m, sizeof m);
    return r;
}

static inline void vector(ost_pm3 v, wide out[3])
{
    out[0] = v.x;
    out[1] = v.y;
    out[2] = v.z;
}

static inline uint8_t class_at(const ost_tool_volume *tool, const wide v[3])
{
    const ost_dims d = tool->geometry.dims;
    if (v[0] < 0 || v[1] < 0 || v[2] < 0 || v[0] >= d.x || v[1] >= d.y || v[2] >= d.z)
        return OST_TOOL_VOID;
    return tool->voxels[v[0] + d.x * (v[1] + d.y * v[2])];
}

/* Implements AR-MAP-1 to AR-MAP-4 for one bone voxel. Returns true if the tool voxel at its centre is cutting. */
static inline bool oracle_covered(const bench_scene *e, const int32_t voxel[3])
{
    const rotation r = rotation_of(&e->pose);
    const wide s = e->bone.spacing.x, s_t = e->tool.geometry.voxel, unit = 1 << 20;
    wide o[3], t[3], corner[3], tool_voxel[3];
    vector(e->bone.origin, o);
    vector(e->pose.t, t);
    vector(e->tool.geometry.corner, corner);
    for (int a = 0; a < 3; a++) {
        wide first = -r.n * corner[a];
        for (int b = 0; b < 3; b++)
            first += r.m[b][a] * (o[b] - t[b] + voxel[b] / 16 * 16 * s);
        wide u = rhe(unit * first, r.n * s_t);
        for (int b = 0; b < 3; b++)
            u += voxel[b] % 16 * rhe(unit * r.m[b][a] * s, r.n * s_t);
        tool_voxel[a] = floor_of(u, unit);
    }
    return class_at(&e->tool, tool_voxel) == OST_TOOL_CUTTING;
}

/*
 * Returns true if the tool voxel is a point. It must be cutting and, for surface points, have a face neighbour that is
 * not cutting.
 */
static inline bool oracle_point(const ost_tool_volume *tool, methods_points which, int32_t i, int32_t j, int32_t k)
{
    static const int32_t faces[6][3] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    const wide v[3] = {i, j, k};
    if (class_at(tool, v) != OST_TOOL_CUTTING)
        return false;
    for (int f = 0; f < 6; f++) {
        const wide next[3] = {i + faces[f][0], j + faces[f][1], k + faces[f][2]};
        if (class_at(tool, next) != OST_TOOL_CUTTING)
            return true;
    }
    return which == METHODS_POINTS_SOLID;
}

/* The map of points.h, which maps tool points to bone voxels. Its integers have `fraction` fraction bits. */
typedef struct oracle_map {
    int fraction;
    wide anchor[3], base[3], step[3][3];
} oracle_map;

static inline oracle_map oracle_map_of(const bench_scene *e)
{
    const rotation r = rotation_of(&e->pose);
    const ost_dims d = e->tool.geometry.dims;
    const wide dims[3] = {d.x, d.y, d.z}, s = e->bone.spacing.x, s_t = e->tool.geometry.voxel;
    oracle_map m = {.fraction = 21};
    bool fits;
    do {
        fits = true;
        m.fraction--;
        for (int b = 0; b < 3; b++) {
            wide sum = (wide)1 << m.fraction;
            for (int a = 0; a < 3; a++) {
                m.step[a][b] = rhe(((wide)1 << m.fraction) * r.m[b][a] * s_t, 2 * r.n * s);
                sum += dims[a] * (m.step[a][b] < 0 ? -m.step[a][b] : m.step[a][b]);
            }
            fits = fits && sum < (wide)1 << 30;
        }
    } while (!fits);
    wide corner[3], t[3], o[3];
    vector(e->tool.geometry.corner, corner);
    vector(e->pose.t, t);
    vector(e->bone.origin, o);
    for (int b = 0; b < 3; b++) {
        /* points.h defines the symbols: 2 N s V_b = 2 (R c)_b N + 2 N (t - o)_b + N s, and 2 c = 2 corner + dims s_t */
        wide n = 2 * r.n * (t[b] - o[b]) + r.n * s;
        for (int a = 0; a < 3; a++)
            n += r.m[b][a] * (2 * corner[a] + dims[a] * s_t);
        m.anchor[b] = floor_of(n, 2 * r.n * s);
        m.base[b] = rhe(((wide)1 << m.fraction) * (n - m.anchor[b] * 2 * r.n * s), 2 * r.n * s);
    }
    return m;
}

/*
 * Checks that the fixed-point coordinate of a point differs from the exact coordinate by at most the bound in points.h.
 */
static inline void check_error(const bench_scene *e, const oracle_map *m, const wide half[3], int b, wide u)
{
    const rotation r = rotation_of(&e->pose);
    const ost_dims d = e->tool.geometry.dims;
    const wide s = e->bone.spacing.x, s_t = e->tool.geometry.voxel, divisor = 2 * r.n * s;
    wide corner[3], t[3], o[3];
    vector(e->tool.geometry.corner, corner);
    vector(e->pose.t, t);
    vector(e->bone.origin, o);
    const wide dims[3] = {d.x, d.y, d.z};
    /*
     * The exact position p of the point, relative to the anchor, follows from 2 p = 2 corner + (dims + half) s_t in
     * the tool's frame.
     */
    wide n = 2 * r.n * (t[b] - o[b]) + r.n * s - m->anchor[b] * divisor;
    for (int a = 0; a < 3; a++)
        n += r.m[b][a] * (2 * corner[a] + (dims[a] + half[a]) * s_t);
    const wide off = u * divisor - ((wide)1 << m->fraction) * n, bound = (1 + dims[0] + dims[1] + dims[2]) * divisor;
    assert_true(2 * (off < 0 ? -off : off) <= bound);
}

/* Computes which voxels of the complete bone are removed. The result has one byte per voxel. */
static inline void oracle_bone_to_tool(const methods_scene *scene, uint8_t *in)
{
    const ost_dims d = scene->event.bone.dims;
    for (int32_t v = 0; v < d.x * d.y * d.z; v++) {
        const int32_t at[3] = {v % d.x, v / d.x % d.y, v / d.x / d.y};
        in[v] = scene->voxels[v] != 0 && oracle_covered(&scene->event, at);
    }
}

static inline void oracle_tool_to_bone(const methods_scene *scene, methods_points which, uint8_t *in)
{
    const bench_scene *e = &scene->event;
    const ost_dims d = e->bone.dims, t = e->tool.geometry.dims;
    const oracle_map m = oracle_map_of(e);
    memset(in, 0, (size_t)(d.x * d.y * d.z));
    for (int32_t v = 0; v < t.x * t.y * t.z; v++) {
        const int32_t i = v % t.x, j = v / t.x % t.y, k = v / t.x / t.y;
        const wide half[3] = {2 * i + 1 - t.x, 2 * j + 1 - t.y, 2 * k + 1 - t.z};
        wide at[3];
        if (!oracle_point(&e->tool, which, i, j, k))
            continue;
        for (int b = 0; b < 3; b++) {
            const wide u = m.base[b] + half[0] * m.step[0][b] + half[1] * m.step[1][b] + half[2] * m.step[2][b];
            check_error(e, &m, half, b, u);
            at[b] = m.anchor[b] + floor_of(u, (wide)1 << m.fraction);
        }
        if (at[0] < 0 || at[1] < 0 || at[2] < 0 || at[0] >= d.x || at[1] >= d.y || at[2] >= d.z)
            continue;
        const size_t voxel = (size_t)(at[0] + d.x * (at[1] + d.y * at[2]));
        in[voxel] = scene->voxels[voxel] != 0;
    }
}

#endif
