/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Makes two of the six types of cases of scene_reach.c:
 *
 *   lone      The bone's chunks form a row along x. In each chunk, all active voxels
 *             are in one column: column 0 in the first chunk, column 1 in the next
 *             one, and so on; in the last chunk, it is the last column. By the
 *             `linear` rule, all active voxels are means of two slices of the CT.
 *             The tool has more than 2^16 triangles.
 *   emptied   The bone has no active voxels, either from the beginning or after an
 *             event that removes the last one. A tool then collides with this bone.
 *             In the larger tiers, there is also a tool of more than 2^16 rows with
 *             triangles of the smallest area.
 */
#include "validation/scene_parts.h"

#include <stdlib.h>

#define UM (OST_PM_PER_MM / 1000)

enum { TICK_NS = 1000000, THRESHOLD = 120 };

static ost_status add_ticks(scene *s, const ost_pm3 *at, const int32_t *tool, size_t count, ost_error *err)
{
    const ost_status status = ost_path_init(&s->path, count, err);
    for (size_t i = 0; i < count && status == OST_OK; i++) {
        s->path.ticks[i] = (ost_tick){
            .t_ns = (int64_t)(i + 1) * TICK_NS, .tool = tool[i], .rpm = OST_RPM_ON, .pose = ost_pose_identity()};
        s->path.ticks[i].pose.t = at[i];
    }
    s->world.sweep_off = true;
    s->collide_every = 1;
    return status;
}

static ost_pm3 centre_of(const ost_geometry *g, int32_t x, int32_t y, int32_t z)
{
    return (ost_pm3){g->origin.x + g->spacing.x * x, g->origin.y + g->spacing.y * y, g->origin.z + g->spacing.z * z};
}

static ost_status reserve_voxels(scene *s, ost_error *err)
{
    const size_t voxels = (size_t)ost_dims_count(s->rect.dims);
    s->samples = malloc(voxels * sizeof *s->samples);
    s->batch = voxels;
    return s->samples ? OST_OK : ost_fail(err, OST_ERR_MEMORY, "out of memory for %zu samples", voxels);
}

static void add_sample(scene *s, int32_t x, int32_t y, int32_t z, int64_t density)
{
    const ost_pm3 at = centre_of(&s->rect, x, y, z);
    s->samples[s->sample_count] = (ost_sample){at.x, at.y, at.z, (int32_t)density, (uint32_t)s->sample_count};
    s->sample_count++;
}

ost_status scene_lone(int kind, scene *s, draw *d, ost_error *err)
{
    enum { CHUNK = 64, LAST = 37, WIDE = CHUNK * CHUNK + LAST, HIGH = 3, SLICES = 4 };
    const ost_pm cube = 500 * UM;
    /* Layer k of the bone lies at (4 * k - 1) / 6, counted in slices, so every layer except the first is a mean of two
       slices. */
    s->rect = (ost_geometry){{WIDE, HIGH, SLICES}, {cube, cube, cube * 3 / 2}, {-1000000 * UM, 0, 0}};
    s->cubic = cube;
    s->resample = (ost_resample[]){OST_RESAMPLE_LINEAR, OST_RESAMPLE_NEAREST}[kind % 2];
    s->chunk_size = CHUNK;
    s->threshold = THRESHOLD;
    ost_status status = reserve_voxels(s, err);
    for (int32_t z = 0; z < SLICES && status == OST_OK; z++)
        for (int32_t y = 0; y < HIGH; y++)
            for (int32_t x = 0; x < WIDE; x++) {
                const int32_t chunk = x / CHUNK, index = chunk == CHUNK ? LAST - 1 : chunk;
                const bool on = x % CHUNK == index && y == chunk % HIGH && z == (chunk % 5 == 4 ? 2 : 1);
                add_sample(s, x, y, z, on ? draw_between(d, 800, 32767) : draw_between(d, -1000, THRESHOLD - 1));
            }
    if (status == OST_OK)
        status = scene_add_fine_tool(s, d, cube * 3 / 4, err);
    const ost_pm3 at[] = {centre_of(&s->rect, 5 * CHUNK + 5, 0, 1),
                          centre_of(&s->rect, CHUNK * CHUNK + LAST - 1, 1, 1)};
    return status == OST_OK ? add_ticks(s, at, (const int32_t[]){0, 0}, 2, err) : status;
}

ost_status scene_emptied(const plan_case *c, int kind, scene *s, draw *d, ost_error *err)
{
    enum { SIDE = 21 };
    const ost_pm cube = 500 * UM;
    const bool never = kind % 2 == 0;
    s->rect = (ost_geometry){{SIDE, SIDE, SIDE}, {cube, cube, cube}, draw_point(d, -90000 * UM, 90000 * UM)};
    s->cubic = cube;
    s->chunk_size = 16;
    s->threshold = THRESHOLD;
    ost_status status = reserve_voxels(s, err);
    for (int32_t z = 0; z < SIDE && status == OST_OK; z++)
        for (int32_t y = 0; y < SIDE; y++)
            for (int32_t x = 0; x < SIDE; x++)
                add_sample(s, x, y, z, draw_between(d, 0, never ? THRESHOLD - 1 : 3000));
    if (status == OST_OK)
        status = scene_add_bar(s, (ost_dims){29, 30, 31}, 0, cube, err);
    /* the smoke tier omits the thin tool, because preparing this tool takes longer than the rest of the case */
    const bool thin = c->tier != PLAN_SMOKE;
    if (status == OST_OK && thin)
        status = scene_add_thin_tool(s, cube / 2, err);
    const ost_pm3 middle = centre_of(&s->rect, SIDE / 2, SIDE / 2, SIDE / 2);
    const ost_pm3 at[] = {middle, middle, middle};
    return status == OST_OK ? add_ticks(s, at, (const int32_t[]){0, 0, 1}, thin ? 3 : 2, err) : status;
}
