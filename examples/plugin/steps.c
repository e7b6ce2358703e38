/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Implements snapping, sweep and map: sections 9, 11 and 12 of docs/spec/arithmetic.md. A plugin that does
 * not implement the slots `snap` and `steps` uses the host's results. If a plugin implements them, `osteon
 * validate` compares the plugin's results with the host's results.
 */
#include "steps.h"

#include <stdio.h>

__extension__ typedef __int128 wide;

/* Returns n / d, rounded half to even (AR-INT-2). d must be positive. */
static wide nearest(wide n, wide d)
{
    wide q = n / d, r = n % d;
    if (r < 0) {
        q--;
        r += d;
    }
    return q + (r > d - r || (r == d - r && q % 2 != 0));
}

/* ---------------------------------------------------------------- snapping */

/* Implements AR-MESH-3 and AR-MESH-4. The host has checked that every vertex lies in the grid. */
int32_t example_snap(ost_plugin_instance *self, const ost_plugin_tool_geometry *g, const ost_plugin_raw_mesh *mesh,
                     ost_plugin_snapped *made, ost_plugin_error *error)
{
    int f = 10;
    (void)self;
    (void)error;
    for (int a = 0; a < 3; a++)
        while ((int64_t)g->dims[a] << f > 1 << 20)
            f--;
    made->fraction_bits = f;
    made->triangle_count = 0;
    for (uint64_t t = 0; t < mesh->triangle_count; t++)
        for (int c = 0; c < 3; c++) {
            const uint64_t v = mesh->triangles[3 * t + (uint64_t)c];
            for (uint64_t a = 0; a < 3; a++)
                made->vertices[3 * v + a] =
                    (int32_t)nearest((wide)(mesh->vertices_pm[3 * v + a] - g->corner_pm[a]) << f, g->voxel_pm);
        }
    for (uint64_t t = 0; t < mesh->triangle_count; t++) {
        const uint32_t *index = mesh->triangles + 3 * t;
        const int32_t *p = made->vertices + 3 * (uint64_t)index[0], *q = made->vertices + 3 * (uint64_t)index[1],
                      *r = made->vertices + 3 * (uint64_t)index[2];
        int64_t u[3], v[3];
        for (int a = 0; a < 3; a++) {
            u[a] = (int64_t)q[a] - p[a];
            v[a] = (int64_t)r[a] - p[a];
        }
        if (u[1] * v[2] == u[2] * v[1] && u[2] * v[0] == u[0] * v[2] && u[0] * v[1] == u[1] * v[0])
            continue;
        for (uint64_t c = 0; c < 3; c++)
            made->triangles[3 * made->triangle_count + c] = index[c];
        made->triangle_count++;
    }
    return OST_PLUGIN_OK;
}

/* -------------------------------------------------------------------- sweep */

typedef struct rotation {
    wide m[3][3], n; /* AR-POSE-4 */
} rotation;

static rotation rotation_of(const ost_plugin_pose *pose)
{
    const wide w = pose->q[0], x = pose->q[1], y = pose->q[2], z = pose->q[3];
    return (rotation){{{w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)},
                       {2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)},
                       {2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z}},
                      w * w + x * x + y * y + z * z};
}

static wide dot(const ost_plugin_pose *a, const ost_plugin_pose *b)
{
    wide sum = 0;
    for (int c = 0; c < 4; c++)
        sum += (wide)a->q[c] * b->q[c];
    return sum;
}

/* AR-SWEEP-1 */
static wide image(const ost_plugin_pose *pose, const rotation *r, const ost_plugin_tool_geometry *g, int corner,
                  int axis)
{
    wide sum = 0;
    for (int a = 0; a < 3; a++)
        sum += r->m[axis][a] * (g->corner_pm[a] + (corner >> a & 1 ? g->dims[a] * g->voxel_pm : 0));
    return nearest(sum, r->n) + pose->t_pm[axis];
}

/* Implements AR-SWEEP-2 and AR-SWEEP-3. Returns 0 if the rotation or the distance is too large. */
static int poses_between(const ost_plugin_pose *a, const ost_plugin_pose *b, const ost_plugin_tool_geometry *g,
                         int64_t voxel)
{
    const rotation ra = rotation_of(a), rb = rotation_of(b);
    const wide p = dot(a, b);
    wide most = 0, n = 1;
    if (2 * p * p < ra.n * rb.n)
        return 0;
    for (int corner = 0; corner < 8; corner++) {
        wide square = 0;
        for (int axis = 0; axis < 3; axis++) {
            const wide d = image(b, &rb, g, corner, axis) - image(a, &ra, g, corner, axis);
            square += d * d;
        }
        most = square > most ? square : most;
    }
    while (n <= 4096 && n * n * voxel * voxel < 4 * most)
        n++;
    return n > 4096 ? 0 : (int)n;
}

/* AR-SWEEP-4 */
static ost_plugin_pose pose_between(const ost_plugin_pose *a, const ost_plugin_pose *b, int k, int n)
{
    const int sign = dot(a, b) < 0 ? -1 : 1;
    ost_plugin_pose out = {.size = sizeof out};
    for (int c = 0; c < 4; c++)
        out.q[c] = (int32_t)nearest((wide)(n - k) * a->q[c] + (wide)k * sign * b->q[c], n);
    for (int c = 0; c < 3; c++)
        out.t_pm[c] = (int64_t)nearest((wide)(n - k) * a->t_pm[c] + (wide)k * b->t_pm[c], n);
    return out;
}

/* ---------------------------------------------------------------------- map */

static ost_plugin_int128 halves(wide v)
{
    return (ost_plugin_int128){(uint64_t)v, (int64_t)(v >> 64)};
}

/* AR-MAP-1, AR-MAP-3 */
static ost_plugin_map map_of(const ost_plugin_pose *pose, const ost_plugin_geometry *bone,
                             const ost_plugin_tool_geometry *g)
{
    const rotation r = rotation_of(pose);
    const wide one = 1 << 20, divisor = r.n * g->voxel_pm;
    ost_plugin_map map = {.size = sizeof map, .divisor = halves(divisor)};
    for (int a = 0; a < 3; a++) {
        wide turned = 0;
        for (int b = 0; b < 3; b++) {
            const wide column = one * r.m[b][a] * bone->spacing_pm[b];
            turned += r.m[b][a] * (bone->origin_pm[b] - pose->t_pm[b]);
            map.column[b][a] = halves(column);
            map.step[b][a] = (int32_t)nearest(column, divisor);
        }
        map.origin[a] = halves(one * (turned - r.n * g->corner_pm[a]));
    }
    return map;
}

int32_t example_steps(ost_plugin_instance *self, const ost_plugin_steps *in, ost_plugin_error *error)
{
    const int n = in->from ? poses_between(in->from, in->to, in->tool, in->bone->spacing_pm[0]) : 1;
    (void)self;
    if (n == 0) {
        snprintf(error->text, error->text_size, "the tool moves or turns too far in one tick");
        return OST_PLUGIN_RANGE;
    }
    for (int k = 1; k <= n; k++) {
        const ost_plugin_pose pose = n == 1 ? *in->to : pose_between(in->from, in->to, k, n);
        const ost_plugin_map map = map_of(&pose, in->bone, in->tool);
        const int32_t answer = in->add(in->sink, &pose, &map);
        if (answer != OST_PLUGIN_OK)
            return answer;
    }
    return OST_PLUGIN_OK;
}
