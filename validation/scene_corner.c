/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Makes a case for backends that exclude a cube of 8^3 bone voxels if the tool is too far from the cube's middle. Each
 * tool has one voxel. In each pose, the tool contains the centre of one corner voxel of the cube [8, 16)^3. This centre
 * is about a hundredth of a tool voxel below the tool's surface, measured along the cube's diagonal:
 *
 *   middle of the cube ---- R = 3.5 sqrt(3) bone voxels ----> centre of the corner voxel
 *                      ---- r ---------------------------> the tool
 *
 * In tool voxels, r is sqrt(34), sqrt(20), sqrt(26) or sqrt(30), depending on the tool. R is greater than r but less
 * than the next multiple of 1/8 above r. A backend that rounds r up to this multiple therefore excludes the cube. The
 * distance from the tool to the cell of 2^3 tool voxels that contains the cube's middle is also r, because the middle
 * is near a multiple of two tool voxels. tests/validation/test_scene checks these properties.
 */
#include "validation/scene_parts.h"

#include <stdlib.h>

#define UM (OST_PM_PER_MM / 1000)

enum { SIDE = 24, TICK_NS = 1000000 };

/* The tool's voxel size, its rotation, and its origin relative to the middle of the cube. The comment of each row gives
   the components of r along the three axes, in tool voxels. */
static const struct {
    ost_pm voxel;
    int32_t q[4];
    ost_pm3 at;
} corners[SCENE_TOOLS_MAX] = {
    {517093107, {1071093810, 0, 53289562, -53289562}, {1640994217, -2256367051, -2256367051}},            /* 4, 3, 3 */
    {674828878, {1011427373, 147159875, -294319751, 147159875}, {1905092454, 1857480844, 1470100231}},    /* 4, 2, 0 */
    {592332808, {1048156176, 124545041, 186817562, -62272521}, {1459950815, -2170769091, -2407740014}},   /* 4, 3, 1 */
    {551792535, {1030812855, -58947944, -235791777, -176843833}, {-1990949731, 1808707869, -2483683958}}, /* 5, 2, 1 */
};

ost_status scene_corners(scene *s, draw *d, ost_error *err)
{
    const ost_pm cube = 500 * UM;
    s->rect = (ost_geometry){{SIDE, SIDE, SIDE}, {cube, cube, cube}, draw_point(d, -90000 * UM, 90000 * UM)};
    s->cubic = cube;
    s->chunk_size = 16;
    s->threshold = 120;
    s->batch = SIDE * SIDE * SIDE;
    s->samples = malloc(s->batch * sizeof *s->samples);
    if (!s->samples)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %zu samples", s->batch);
    const ost_pm3 o = s->rect.origin;
    const ost_pm middle = cube * 23 / 2;
    for (int32_t z = 0; z < SIDE; z++)
        for (int32_t y = 0; y < SIDE; y++)
            for (int32_t x = 0; x < SIDE; x++, s->sample_count++)
                s->samples[s->sample_count] =
                    (ost_sample){o.x + cube * x, o.y + cube * y, o.z + cube * z,
                                 (int32_t)draw_between(d, s->threshold, 3000), (uint32_t)s->sample_count};
    ost_status status = ost_path_init(&s->path, SCENE_TOOLS_MAX, err);
    for (int i = 0; i < SCENE_TOOLS_MAX && status == OST_OK; i++) {
        const ost_pm3 at = corners[i].at;
        const int32_t *q = corners[i].q;
        status = scene_add_bar(s, (ost_dims){1, 1, 1}, 0, corners[i].voxel, err);
        s->path.ticks[i] = (ost_tick){
            .t_ns = (int64_t)(i + 1) * TICK_NS,
            .tool = i,
            .rpm = OST_RPM_ON,
            .pose = {.t = {o.x + middle + at.x, o.y + middle + at.y, o.z + middle + at.z},
                     .qw = q[0], .qx = q[1], .qy = q[2], .qz = q[3]}};
    }
    s->world.sweep_off = true;
    s->collide_every = 2;
    return status;
}
