/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Makes ticks in which tools overlap the bone. A pose is chosen at random in double precision and then
 * quantised as a device's pose is (AR-POSE), so that all backends get the same integers.
 */
#include "validation/scene_parts.h"

#include <osteon/motor.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "validation/resample.h"

enum { TICK_NS = 1000000 };

/* Returns a random target: the centre of a voxel of the CT, a point on the border between two voxels, or any point up
   to one voxel from a centre along each axis. */
static ost_pm3 drawn_target(const scene *s, draw *d)
{
    const ost_geometry *g = &s->rect;
    const int32_t dims[3] = {g->dims.x, g->dims.y, g->dims.z};
    const ost_pm spacing[3] = {g->spacing.x, g->spacing.y, g->spacing.z},
                 origin[3] = {g->origin.x, g->origin.y, g->origin.z};
    ost_pm p[3];
    for (int a = 0; a < 3; a++) {
        p[a] = origin[a] + spacing[a] * draw_between(d, 0, dims[a] - 1);
        if (draw_one_in(d, 4))
            p[a] += spacing[a] / 2;
        else if (draw_one_in(d, 2))
            p[a] += draw_between(d, -spacing[a], spacing[a]);
    }
    return (ost_pm3){p[0], p[1], p[2]};
}

/*
 * Draws a unit quaternion: in one case of three a rotation by 0, 90 or 180 degrees about an axis, in all other cases
 * any rotation.
 */
static ost_status drawn_turn(draw *d, double q[4])
{
    static const double root = 0.70710678118654752440;
    for (int c = 0; c < 4; c++)
        q[c] = 0;
    if (draw_one_in(d, 3)) {
        const int64_t which = draw_between(d, 0, 2), axis = draw_between(d, 1, 3);
        if (which == 0)
            q[draw_between(d, 0, 3)] = 1; /* no rotation, or a half turn about an axis */
        else {
            q[0] = root; /* a quarter turn */
            q[axis] = which == 1 ? root : -root;
        }
        return OST_OK;
    }
    double square;
    do {
        square = 0;
        for (int c = 0; c < 4; c++) {
            q[c] = draw_real(d, -1, 1);
            square += q[c] * q[c];
        }
    } while (square > 1 || square < 0.01);
    for (int c = 0; c < 4; c++)
        q[c] /= sqrt(square);
    return OST_OK;
}

ost_status scene_unrelated_poses(scene *s, draw *d, size_t count, ost_error *err)
{
    ost_status status = ost_path_init(&s->path, count, err);
    s->world.sweep_off = true; /* sweeps are off, because the poses are unrelated */
    for (size_t i = 0; i < count && status == OST_OK; i++) {
        const ost_pm3 at = drawn_target(s, d);
        const double none[3] = {0, 0, 0};
        double q[4];
        ost_tick *tick = &s->path.ticks[i];
        drawn_turn(d, q);
        *tick = (ost_tick){.t_ns = (int64_t)(i + 1) * TICK_NS,
                           .tool = (int32_t)draw_between(d, 0, s->tool_count - 1),
                           .rpm = OST_RPM_ON};
        status = ost_pose_from_doubles(none, q, &tick->pose, err);
        tick->pose.t = at;
    }
    return status;
}

/* Appends a tick in which the last tool has no rotation. Returns NULL if memory is exhausted. */
static ost_tick *another(scene *s, ost_error *err)
{
    const size_t i = s->path.count;
    ost_tick *ticks = realloc(s->path.ticks, (i + 1) * sizeof *ticks);
    if (!ticks) {
        ost_fail(err, OST_ERR_MEMORY, "out of memory for %zu ticks", i + 1);
        return NULL;
    }
    s->path.ticks = ticks;
    s->path.count = i + 1;
    ticks[i] = (ost_tick){
        .t_ns = (int64_t)(i + 1) * TICK_NS, .tool = s->tool_count - 1, .rpm = OST_RPM_ON, .pose = ost_pose_identity()};
    return &ticks[i];
}

ost_status scene_add_poses_inside(scene *s, draw *d, size_t count, ost_error *err)
{
    const ost_geometry *g = &s->rect;
    ost_status status = OST_OK;
    for (size_t i = 0; i < count && status == OST_OK; i++) {
        const double none[3] = {0, 0, 0};
        double q[4];
        ost_tick *tick = another(s, err);
        if (!tick)
            return err->status;
        drawn_turn(d, q);
        status = ost_pose_from_doubles(none, q, &tick->pose, err);
        ost_pm3 *t = &tick->pose.t;
        t->x = g->origin.x + g->spacing.x * g->dims.x / 2 + draw_between(d, -2 * g->spacing.x, 2 * g->spacing.x);
        t->y = g->origin.y + g->spacing.y * g->dims.y / 2 + draw_between(d, -2 * g->spacing.y, 2 * g->spacing.y);
        t->z = g->origin.z + g->spacing.z * g->dims.z / 2 + draw_between(d, -2 * g->spacing.z, 2 * g->spacing.z);
    }
    return status;
}

/* The cubic grid along one axis: the centres of its first and middle voxel, and the number of voxels. */
typedef struct along {
    ost_pm first, middle;
    int32_t n;
} along;

static along along_axis(const scene *s, int a)
{
    const ost_geometry *g = &s->rect;
    const ost_pm3 first = resample_origin(g, s->cubic);
    const ost_pm origin[3] = {first.x, first.y, first.z}, size[3] = {g->spacing.x, g->spacing.y, g->spacing.z};
    const int32_t dims[3] = {g->dims.x, g->dims.y, g->dims.z};
    const int32_t n = (int32_t)((dims[a] * size[a] + s->cubic - 1) / s->cubic);
    return (along){origin[a], origin[a] + s->cubic * (n / 2), n};
}

static void put(ost_tick *tick, int a, ost_pm at)
{
    *(a == 0 ? &tick->pose.t.x : a == 1 ? &tick->pose.t.y : &tick->pose.t.z) = at;
}

ost_status scene_add_border_poses(scene *s, draw *d, ost_error *err)
{
    const ost_tool_geometry *tool = &s->tools[s->tool_count - 1].cutting.grid;
    const ost_pm corner[3] = {tool->corner.x, tool->corner.y, tool->corner.z}, voxel = tool->voxel;
    for (int a = 0; a < 3; a++) {
        ost_tick *tick = another(s, err);
        if (!tick)
            return err->status;
        for (int b = 0; b < 3; b++)
            put(tick, b, along_axis(s, b).middle);
        const along x = along_axis(s, a);
        const int32_t block = OST_MAP_BLOCK * (int32_t)draw_between(d, 0, (x.n - 1) / OST_MAP_BLOCK),
                      last = block + OST_MAP_BLOCK - 1;
        /* A unit is voxel / 2^20. The first voxel of a block is placed up to half a unit before the border, so that
           it is rounded onto the border. The last voxel of a block is placed up to 15 units beyond the border, so
           that a step of the map that is one unit too short changes the result. */
        const bool at_last = draw_one_in(d, 2) && last < x.n;
        const ost_pm off = at_last ? draw_between(d, 0, voxel * 15 >> OST_MAP_FRACTION)
                                   : draw_between(d, -(voxel >> (OST_MAP_FRACTION + 1)), -1);
        put(tick, a, x.first + s->cubic * (at_last ? last : block) - corner[a] - off);
    }
    return OST_OK;
}

ost_status scene_add_crossing(scene *s, ost_error *err)
{
    for (int end = 0; end < 2; end++) {
        ost_tick *tick = another(s, err);
        if (!tick)
            return err->status;
        for (int a = 0; a < 3; a++) {
            const along x = along_axis(s, a);
            const int32_t chunk = x.n / 2 / s->chunk_size * s->chunk_size, far = chunk + s->chunk_size + 3;
            put(tick, a, x.first + s->cubic * (a > 0 ? chunk + s->chunk_size / 2 : end ? far : chunk - 4));
        }
    }
    return OST_OK;
}

ost_status scene_add_far_pose(scene *s, ost_error *err)
{
    const ost_pm voxel = s->tools[s->tool_count - 1].cutting.grid.voxel;
    ost_tick *tick = another(s, err);
    if (!tick)
        return err->status;
    for (int a = 0; a < 3; a++)
        put(tick, a, along_axis(s, a).middle);
    tick->pose.t.x -= voxel << (32 - OST_MAP_FRACTION);
    return OST_OK;
}

/*
 * Adds ticks along straight lines between random targets. From tick to tick, the tool rotates by about
 * `turn` radians about a random axis. The tool and the axis may change at each target.
 */
ost_status scene_drive(scene *s, draw *d, size_t count, ost_pm speed, double turn, ost_error *err)
{
    ost_status status = ost_path_init(&s->path, count, err);
    if (status != OST_OK)
        return status;
    ost_pm3 at = drawn_target(s, d), to = drawn_target(s, d);
    double q[4], axis[4];
    int32_t tool = 0;
    drawn_turn(d, q);
    drawn_turn(d, axis);
    for (size_t i = 0; i < count && status == OST_OK; i++) {
        const double way[3] = {(double)(to.x - at.x), (double)(to.y - at.y), (double)(to.z - at.z)};
        const double left = sqrt(way[0] * way[0] + way[1] * way[1] + way[2] * way[2]);
        if (left <= (double)speed) {
            to = drawn_target(s, d);
            if (draw_one_in(d, 2))
                tool = (int32_t)draw_between(d, 0, s->tool_count - 1);
            if (draw_one_in(d, 2))
                drawn_turn(d, axis);
        } else {
            at.x += (ost_pm)(way[0] / left * (double)speed);
            at.y += (ost_pm)(way[1] / left * (double)speed);
            at.z += (ost_pm)(way[2] / left * (double)speed);
        }
        /* q becomes the normalised product of (1, turn/2 axis) and q, which adds a rotation by about `turn` */
        const double h = turn / 2, r[4] = {1, h * axis[1], h * axis[2], h * axis[3]};
        double n[4] = {r[0] * q[0] - r[1] * q[1] - r[2] * q[2] - r[3] * q[3],
                       r[0] * q[1] + r[1] * q[0] + r[2] * q[3] - r[3] * q[2],
                       r[0] * q[2] - r[1] * q[3] + r[2] * q[0] + r[3] * q[1],
                       r[0] * q[3] + r[1] * q[2] - r[2] * q[1] + r[3] * q[0]};
        const double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2] + n[3] * n[3]);
        for (int c = 0; c < 4; c++)
            q[c] = n[c] / length;
        const double none[3] = {0, 0, 0};
        ost_tick *tick = &s->path.ticks[i];
        *tick = (ost_tick){.t_ns = (int64_t)(i + 1) * TICK_NS, .tool = tool, .rpm = OST_RPM_ON};
        status = ost_pose_from_doubles(none, q, &tick->pose, err);
        tick->pose.t = at;
    }
    return status;
}

ost_status scene_turn(scene *s, int32_t rpm, ost_error *err)
{
    ost_motor motor = {0};
    ost_status status = ost_path_init(&s->handle_path, s->path.count, err);
    if (status != OST_OK)
        return status;
    memcpy(s->handle_path.ticks, s->path.ticks, s->path.count * sizeof *s->path.ticks);
    s->handle_rpm = rpm;
    return ost_motor_path(&s->path, rpm, &motor, err);
}
