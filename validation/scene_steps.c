/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Makes the inputs of cases that test only sweep, map, motor and snapping (steps_record.h), without voxels.
 * In random cases with a bone, the situations tested here are rare.
 *
 *   even cases   lengths are multiples of a unit of 1000 pm; the bone's voxel has an
 *                odd number of units, and the voxel of the first tool has 2^21 units,
 *                so that steps of the map and bases of blocks are ties; some snapped
 *                vertices are also ties
 *   odd cases    lengths are any number of picometres; grids are at the ends of the
 *                range of 8 m
 *   every third  the path consists of poses of the handle, and a motor also rotates
 *                the tool
 *
 * The distance between two ticks is an integer number of half voxels, or one
 * picometre more or less, so that the case of equality in AR-SWEEP-2 is tested.
 */
#include "validation/scene_parts.h"

#include <math.h>
#include <string.h>

#include <osteon/motor.h>

enum { VERTICES = 24, TRIANGLES = 40, TICKS = 24 };
#define FARTHEST INT64_C(8000000000000)

/* Returns a random length in [lo, hi], rounded to a multiple of `unit`. */
static ost_pm drawn(draw *d, ost_pm lo, ost_pm hi, ost_pm unit)
{
    return draw_between(d, lo / unit, hi / unit) * unit;
}

static void make_grid(scene *s, draw *d, int number, ost_pm unit)
{
    ost_geometry *g = &s->rect;
    const ost_pm voxel = (2 * draw_between(d, 100000, 900000) + 1) * unit; /* 0.2 to 1.8 mm if unit is 1000 pm */
    ost_pm origin[3];
    g->dims = draw_dims(d, 1, 200);
    g->spacing = (ost_pm3){voxel, voxel, voxel};
    const int32_t dims[3] = {g->dims.x, g->dims.y, g->dims.z};
    for (int a = 0; a < 3; a++) {
        const ost_pm way = (dims[a] - 1) * voxel;
        const int where = number % 2 ? (int)draw_between(d, 0, 2) : 3;
        origin[a] = where == 0   ? -FARTHEST
                    : where == 1 ? FARTHEST - way
                                 : drawn(d, -(INT64_C(1) << 40), INT64_C(1) << 40, unit);
    }
    g->origin = (ost_pm3){origin[0], origin[1], origin[2]};
    s->cubic = voxel;
    s->chunk_size = 32;
    s->threshold = 120;
}

/* Makes a tool whose corners are multiples of 2^-11 of a voxel, so that some of them lie half-way between two lattice
   points. The ends of the tool are at multiples of a voxel, which are ties in AR-TOOL-2. */
static ost_status make_tool(scene *s, draw *d, ost_pm voxel, int32_t wide, ost_error *err)
{
    scene_tool *tool = &s->tools[s->tool_count];
    ost_mesh *mesh = &tool->raw[0];
    const ost_pm part = voxel % 2048 ? 1 : voxel / 2048;
    ost_pm3 lo, hi;
    ost_tool_geometry grid;
    *tool = (scene_tool){.rule = OST_FILL_WINDING, .name = "points"};
    s->tool_count++;
    ost_status status = ost_mesh_init(mesh, VERTICES, TRIANGLES, err);
    for (int v = 0; v < VERTICES && status == OST_OK; v++) {
        const ost_pm reach = wide * voxel / 2 / (v % 4 == 3 ? 8 : 1), aside = reach < 500 * voxel ? reach : 500 * voxel;
        mesh->vertices[v] =
            (ost_pm3){drawn(d, -reach, reach, part), drawn(d, -aside, aside, part), drawn(d, -aside, aside, part)};
    }
    for (int t = 0; t < TRIANGLES && status == OST_OK; t++)
        for (int c = 0; c < 3; c++) /* in some triangles, two corners coincide */
            mesh->triangles[t][c] = (uint32_t)draw_between(d, 0, VERTICES - 2);
    if (status == OST_OK) { /* a few triangles lose their area by snapping */
        mesh->vertices[1] = mesh->vertices[0];
        mesh->vertices[1].x += 1;
        mesh->vertices[2] = (ost_pm3){wide / 2 * voxel, -(wide < 1000 ? wide / 2 : 500) * voxel, 0};
        mesh->triangles[0][0] = 0;
        mesh->triangles[0][1] = 1;
        mesh->triangles[0][2] = 2;
        status = ost_mesh_bounds(mesh, &lo, &hi, err);
    }
    if (status == OST_OK)
        status = ost_tool_geometry_from_bounds(lo, hi, voxel, &grid, err);
    return status == OST_OK ? ost_mesh_snap(mesh, &grid, &tool->cutting, err) : status;
}

/* Sets q to the rotation `last`, followed by a rotation of up to `turn` about each axis. */
static void turn_on(draw *d, double turn, const double last[4], double q[4])
{
    const double h[4] = {1, draw_real(d, -turn, turn), draw_real(d, -turn, turn), draw_real(d, -turn, turn)};
    q[0] = last[0] * h[0] - last[1] * h[1] - last[2] * h[2] - last[3] * h[3];
    q[1] = last[0] * h[1] + last[1] * h[0] + last[2] * h[3] - last[3] * h[2];
    q[2] = last[0] * h[2] - last[1] * h[3] + last[2] * h[0] + last[3] * h[1];
    q[3] = last[0] * h[3] + last[1] * h[2] - last[2] * h[1] + last[3] * h[0];
    const double square = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    for (int c = 0; c < 4; c++)
        q[c] /= sqrt(square);
}

static ost_status make_ticks(scene *s, draw *d, int number, ost_pm unit, ost_error *err)
{
    static const double none[3] = {0, 0, 0}, upright[4] = {1, 0, 0, 0},
                        quarter[4] = {0.70710678118654752440, 0, 0.70710678118654752440, 0};
    const ost_geometry *g = &s->rect;
    const bool handle_path = number % 3 == 2;
    const ost_pm3 middle = {g->origin.x + g->dims.x / 2 * s->cubic, g->origin.y + g->dims.y / 2 * s->cubic,
                            g->origin.z + g->dims.z / 2 * s->cubic};
    double q[4] = {1, 0, 0, 0};
    int64_t t_ns = draw_between(d, -4000000000, 4000000000);
    ost_pm at[3] = {middle.x, middle.y, middle.z};
    ost_status status = ost_path_init(&s->path, TICKS, err);
    for (int i = 0; i < TICKS && status == OST_OK; i++) {
        ost_tick *tick = &s->path.ticks[i];
        const ost_pm off = draw_between(d, 0, 3) ? 0 : draw_between(d, -1, 1);
        t_ns += draw_between(d, 1, handle_path ? 90000000 : 3000000);
        *tick = (ost_tick){
            .t_ns = t_ns, .tool = (int32_t)(i / 8) % 2, .rpm = handle_path ? OST_RPM_OF_DEVICE : OST_RPM_ON};
        /* The corners of this tool are far from the axis, so it rotates by small angles only. */
        const bool wide = tick->tool == 1;
        const bool straight = i % 4 == 1 || i % 4 == 2;
        if (straight) { /* Without a rotation, the number of poses depends only on the distance. */
            const int64_t n = draw_between(d, 1, 12);
            /* a distance of 0 results in one pose */
            at[draw_between(d, 0, 2)] += i % 8 == 6 ? 0 : n * s->cubic / 2 + off;
        } else {
            const double last[4] = {q[0], q[1], q[2], q[3]};
            turn_on(d, wide ? 0.01 : i % 8 == 7 && !handle_path ? 1.2 : 0.1, last, q);
            for (int a = 0; a < 3; a++)
                at[a] = (a == 0   ? middle.x
                         : a == 1 ? middle.y
                                  : middle.z) +
                        drawn(d, -6 * s->cubic, 6 * s->cubic, unit);
        }
        /* In two successive ticks, the rotation is first 0 and then 90 degrees, the limit of AR-SWEEP-3. */
        if (!handle_path && !wide && (i % 8 == 4 || i % 8 == 5))
            memcpy(q, i % 8 == 4 ? upright : quarter, sizeof q);
        if (status == OST_OK)
            status = ost_pose_from_doubles(none, q, &tick->pose, err);
        for (int a = 0; a < 3; a++)
            at[a] = at[a] < -FARTHEST ? -FARTHEST : at[a] > FARTHEST ? FARTHEST : at[a];
        tick->pose.t = (ost_pm3){at[0], at[1], at[2]};
        if (i % 5 == 4) { /* the negated quaternion is the same rotation */
            ost_pose *p = &tick->pose;
            *p = (ost_pose){p->t, -p->qw, -p->qx, -p->qy, -p->qz};
        }
    }
    return status == OST_OK && handle_path ? scene_turn(s, (int32_t)draw_between(d, 1, 600), err) : status;
}

ost_status scene_steps(scene *s, draw *d, int number, ost_error *err)
{
    const ost_pm unit = number % 2 ? 1 : 1000,
                 fine = number % 2 ? draw_between(d, 250000000, 1200000000) : (INT64_C(1) << 21) * unit;
    make_grid(s, d, number, number % 2 ? 1001 : unit);
    ost_status status = make_tool(s, d, fine, 20, err);
    if (status == OST_OK)
        status = make_tool(s, d, draw_between(d, 200, 900) * 2048000, 900, err);
    if (status == OST_OK) /* this tool is too wide for a removal; its mesh is snapped with 9 or 8 fraction bits */
        status = make_tool(s, d, draw_between(d, 200, 400) * 2048000, number % 4 < 2 ? 1500 : 4000, err);
    return status == OST_OK ? make_ticks(s, d, number, unit, err) : status;
}
