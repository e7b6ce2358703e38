/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Makes cases for situations that require a certain size or position. There are six types of cases, which
 * alternate. Two types, `lone` and `emptied`, are in scene_lone.c; the other four are:
 *
 *   large    CT: sparse samples. The bone has 1025 x 65 x 65 voxels, made from 32
 *            slices, so that the last chunk, brick and vector along each axis has
 *            one voxel. The chunks of one event have more than 2^22 voxels. There
 *            are duplicates at every distance within a batch.
 *            First tool: a bar of 530 voxels along x. A quarter of it does not
 *            cut. At the end of the bar, the base of a distant block is a tie.
 *   rods     CT: slices, 8 m from the origin; 1 to 8 density classes. One event
 *            empties chunks of 64^3 voxels (counts beyond 2^16, sums beyond 2^32).
 *            In another event, the densities require 14 bits.
 *            Tools: along each axis, a rod that is one to three voxels thick. The
 *            rods are at ties or at most 6 / 65536 of a tool voxel away from ties.
 *   refused  CT: samples at a distance of 1/8 or 3/8 of a voxel from the lattice
 *            point, or one picometre farther away; samples half a voxel away from
 *            the lattice point, outside the grid, or beyond 8 m; conflicting samples
 *   hollow   CT: 50 voxels along x, from which 73 bone voxels are made.
 *            First tool: two plates with a gap of two blocks between them. It is
 *            swept until blocks in the gap are cut, and then moved out of the bone
 *            within one event. In some rows, its non-cutting mesh is not closed,
 *            but its cutting mesh is. Some triangles have collinear corners.
 *            Next two tools: poses at a distance of 2048 and 4096 tool voxels, at
 *            which a base of 32 bits wraps.
 *            Last tool: a bar of 1024 voxels, rotated by 180 degrees. Its end lies
 *            in a block with a base beyond 2^30. Its rows are complete words, and a
 *            part of it does not cut.
 */
#include "validation/scene_parts.h"

#include <stdlib.h>

#define UM (OST_PM_PER_MM / 1000)

enum { TICK_NS = 1000000, KINDS = 6 };

static ost_tick *next_tick(scene *s, int32_t tool)
{
    ost_tick *tick = &s->path.ticks[s->path.count++];
    *tick = (ost_tick){
        .t_ns = (int64_t)s->path.count * TICK_NS, .tool = tool, .rpm = OST_RPM_ON, .pose = ost_pose_identity()};
    return tick;
}

static ost_status reserve_ticks(scene *s, size_t count, ost_error *err)
{
    const ost_status status = ost_path_init(&s->path, count, err);
    s->path.count = 0;
    return status;
}

/* --------------------------------------------------------- the large cases */

enum { LARGE_X = 1025, LARGE_Y = 65, LARGE_Z = 32, LARGE_SAMPLES = 140000, LARGE_BAR = 530 };

/* LARGE_UNIT is the unit of the map in picometres; it is even, so that half a unit is an integer. LARGE_VOXEL is the
   tool's voxel size that results from this unit, about 0.35 mm. */
#define LARGE_UNIT ((ost_pm)334)
#define LARGE_VOXEL (LARGE_UNIT << OST_MAP_FRACTION)

/* Returns a coordinate that is at most 3/8 of a voxel away from the lattice point `index`. Distances of 0, 1/8 and 3/8
   of a voxel are frequent, and so is 1/8 of a voxel plus one picometre. */
static ost_pm jittered(draw *d, ost_pm origin, ost_pm spacing, int32_t index)
{
    const ost_pm eighth = spacing / 8, offs[] = {0, eighth, eighth + 1, 3 * eighth};
    const ost_pm off = draw_one_in(d, 3) ? draw_between(d, 0, 3 * eighth) : offs[draw_between(d, 0, 3)];
    return origin + spacing * index + (draw_one_in(d, 2) ? off : -off);
}

static ost_sample sample_at(const scene *s, draw *d, int32_t x, int32_t y, int32_t z)
{
    const ost_geometry *g = &s->rect;
    ost_sample one = {.line = (uint32_t)s->sample_count};
    one.x = jittered(d, g->origin.x, g->spacing.x, x);
    one.y = jittered(d, g->origin.y, g->spacing.y, y);
    one.z = jittered(d, g->origin.z, g->spacing.z, z);
    one.density = (int32_t)(draw_one_in(d, 3) ? draw_between(d, s->threshold - 1, s->threshold + 1)
                                              : draw_between(d, 0, 32767));
    return one;
}

/* Makes samples for the last column and the last row, and then for random voxels. Some samples have the position of
   an earlier sample. */
static void large_samples(scene *s, draw *d)
{
    for (int32_t z = 0; z < LARGE_Z; z++) {
        for (int32_t y = 0; y < LARGE_Y; y++, s->sample_count++)
            s->samples[s->sample_count] = sample_at(s, d, LARGE_X - 1, y, z);
        for (int32_t x = 0; x < LARGE_X - 1; x++, s->sample_count++)
            s->samples[s->sample_count] = sample_at(s, d, x, LARGE_Y - 1, z);
    }
    for (; s->sample_count < LARGE_SAMPLES; s->sample_count++) {
        const int32_t x = (int32_t)draw_between(d, 0, LARGE_X - 1), y = (int32_t)draw_between(d, 0, LARGE_Y - 1),
                      z = (int32_t)draw_between(d, 0, LARGE_Z - 1);
        ost_sample one = sample_at(s, d, x, y, z);
        if (draw_one_in(d, 5)) {
            const int32_t density = one.density;
            /* Repeats the position of an earlier sample: the previous sample, one of the last 64 samples (the length
               of a vector), or any earlier sample. */
            const int64_t reach = draw_one_in(d, 3) ? 1 : draw_one_in(d, 2) ? 64 : (int64_t)s->sample_count;
            one = s->samples[(int64_t)s->sample_count - draw_between(d, 1, reach)];
            one.density = density;
            one.line = (uint32_t)s->sample_count;
        }
        s->samples[s->sample_count] = one;
    }
    /* Pairs of samples with equal position: the first and the last sample of a batch, and pairs on both sides of the
       border of a block of 2^16 samples. */
    const size_t pairs[][2] = {{0, LARGE_SAMPLES - 1}, {65535, 65536}, {65534, 131072}, {131071, 131072}};
    for (size_t i = 0; i < sizeof pairs / sizeof pairs[0]; i++) {
        ost_sample *to = &s->samples[pairs[i][1]];
        const ost_sample keep = *to;
        *to = s->samples[pairs[i][0]];
        to->density = keep.density;
        to->line = keep.line;
    }
}

static ost_status make_large(const plan_case *c, scene *s, draw *d, ost_error *err)
{
    static const ost_duplicates rules[] = {OST_DUPLICATES_LAST, OST_DUPLICATES_FIRST, OST_DUPLICATES_MAX};
    /* 32 slices of 1.42 mm give 65 voxels of 0.7 mm; the quotient 71 / 35 has no finite binary representation. */
    s->rect = (ost_geometry){
        {LARGE_X, LARGE_Y, LARGE_Z}, {700 * UM, 700 * UM, 1420 * UM}, {-360000 * UM, 8000 * UM, -1000 * UM}};
    s->cubic = 700 * UM;
    s->resample = c->number / KINDS % 2 ? OST_RESAMPLE_NEAREST : OST_RESAMPLE_LINEAR;
    s->duplicates = rules[c->number / KINDS % 3];
    s->chunk_size = 64;
    s->threshold = 120;
    s->batch = LARGE_SAMPLES;
    s->samples = malloc(LARGE_SAMPLES * sizeof *s->samples);
    if (!s->samples)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %d samples", LARGE_SAMPLES);
    large_samples(s, d);
    /* On a device, preparing a tool takes as long as the rest of the case, so the bar of the smoke tier has a third of
       the volume. */
    const bool slim = c->tier == PLAN_SMOKE;
    const ost_dims bar = {LARGE_BAR, slim ? 59 : 101, slim ? 57 : 99};
    ost_status status = scene_add_bar(s, bar, (bar.z + 1) / 4, LARGE_VOXEL, err);
    if (status == OST_OK)
        status = scene_add_bar(s, (ost_dims){257, 3, 5}, 0, 350 * UM, err);
    if (status == OST_OK)
        status = reserve_ticks(s, 4, err);
    for (int i = 0; i < 4 && status == OST_OK; i++) {
        ost_pose *pose = &next_tick(s, i == 3)->pose;
        /* The poses lead from one end of the bone to the other and include its last rows and slices. */
        pose->t = (ost_pm3){s->rect.origin.x + (95000 + 180000 * i) * UM,
                            s->rect.origin.y + (slim ? 38000 : 30000) * UM,
                            s->rect.origin.z + (slim ? 38000 : 29000) * UM};
        /* The base of a block that is far from the box's first block lies half a unit of the map before the bar's
           end. This position is a tie, which rounding half to even moves outside the bar. */
        if (i < 3)
            pose->t.x = s->rect.origin.x + s->cubic * OST_MAP_BLOCK * (17 + 16 * i) - LARGE_BAR / 2 * LARGE_VOXEL +
                        LARGE_UNIT / 2;
        else
            pose->t.x += draw_between(d, -700 * UM, 700 * UM);
    }
    s->world.sweep_off = true;
    s->collide_every = 3;
    return status;
}

/* ----------------------------------------------------- the cases with rods */

enum { RODS_X = 97, RODS_Y = 67, RODS_Z = 93, ROD_TICKS = 6 };

/* Returns a position for a rod. The position is at most 6 / 65536 of a tool voxel away from a position at which
   centres of bone voxels can lie exactly on borders between tool voxels (ties). */
static ost_pm near_tie(draw *d, ost_pm at, ost_pm voxel)
{
    const int64_t off = draw_one_in(d, 3) ? 0 : draw_between(d, -6, 6);
    return at + (draw_one_in(d, 2) ? voxel / 2 : 0) + off * voxel / 65536;
}

static void rod_ticks(scene *s, draw *d, int32_t tool)
{
    const ost_geometry *g = &s->rect;
    const ost_pm voxel = s->tools[tool].cutting.grid.voxel;
    ost_pm3 at = g->origin;
    for (int i = 0; i < ROD_TICKS; i++) {
        ost_pose *pose = &next_tick(s, tool)->pose;
        if (i % 2 == 0) { /* in the next tick, the tool moves by a short distance, in tens of poses */
            at.x = near_tie(d, g->origin.x + s->cubic * draw_between(d, 10, RODS_X - 10), voxel);
            at.y = near_tie(d, g->origin.y + s->cubic * draw_between(d, 10, RODS_Y - 10), voxel);
            at.z = near_tie(d, g->origin.z + s->cubic * draw_between(d, 10, RODS_Z * 7 / 10 - 10), voxel);
        } else {
            at.x += voxel * draw_between(d, -16, 16);
            at.y += voxel * draw_between(d, -16, 16);
            at.z += voxel * draw_between(d, -16, 16);
        }
        pose->t = at;
    }
}

static ost_status make_rods(const plan_case *c, scene *s, draw *d, ost_error *err)
{
    static const int counts[] = {1, 8, 2, 3};
    const int kind = c->number / KINDS;
    const ost_pm spacing = 500 * UM, far = OST_LENGTH_MAX - 60000 * UM;
    s->rect = (ost_geometry){{RODS_X, RODS_Y, RODS_Z},
                             {spacing, spacing, 350 * UM},
                             {far, -OST_LENGTH_MAX + 10000 * UM, kind % 2 ? -far : far}};
    s->cubic = spacing;
    s->resample = (ost_resample)(kind % 3);
    s->chunk_size = kind % 2 ? 32 : 64;
    s->threshold = 120;
    s->slices = 29; /* each call uploads more than 2^17 voxels; the last call uploads fewer slices */
    s->batch = 1 << 16;
    s->samples = malloc((size_t)ost_dims_count(s->rect.dims) * sizeof *s->samples);
    if (!s->samples)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a CT of %d slices", RODS_Z);
    for (int32_t z = 0; z < RODS_Z; z++)
        for (int32_t y = 0; y < RODS_Y; y++)
            for (int32_t x = 0; x < RODS_X; x++, s->sample_count++) {
                const bool dense = x < s->chunk_size;
                const int32_t density = (int32_t)draw_between(d, dense ? 31000 : 8000, dense ? 32767 : 16383);
                const ost_pm3 at = {s->rect.origin.x + spacing * x, s->rect.origin.y + spacing * y,
                                    s->rect.origin.z + 350 * UM * z};
                s->samples[s->sample_count] = (ost_sample){at.x, at.y, at.z, density,
                                                           (uint32_t)(s->sample_count % s->batch)};
            }
    s->world.classes = scene_classes(counts[kind % 4], 4096); /* classes with 0, 7, 1 or 2 borders */
    const ost_dims rods[3] = {{61, 1, 2}, {3, 59, 1}, {2, 3, 63}};
    ost_status status = reserve_ticks(s, 3 * ROD_TICKS + 2, err);
    for (int32_t t = 0; t < 3 && status == OST_OK; t++) {
        status = scene_add_bar(s, rods[t], 0, 250 * UM, err);
        if (status == OST_OK)
            rod_ticks(s, d, t);
    }
    if (status == OST_OK) /* a row has two words; there are 2^6 + 3 rows per layer, and 2^6 + 3 layers */
        status = scene_add_bar(s, (ost_dims){65, 67, 67}, 7, 1000 * UM, err);
    for (int i = 0; i < 2 && status == OST_OK; i++)
        next_tick(s, 3)->pose.t = (ost_pm3){s->rect.origin.x + (i ? 40000 : 12000) * UM, s->rect.origin.y + 15000 * UM,
                                            s->rect.origin.z + 15000 * UM};
    s->collide_every = 5;
    return status;
}

/* ------------------------------------------------------- the refused cases */

static ost_status make_refused(const plan_case *c, scene *s, draw *d, ost_error *err)
{
    enum { SIDE = 19, MOST = SIDE * SIDE * SIDE + 4096 };
    const ost_pm spacing = 800 * UM;
    const bool conflicts_alone = c->number / KINDS % 2 == 1;
    s->rect = (ost_geometry){{SIDE, SIDE, SIDE}, {spacing, spacing, spacing}, {1000 * UM, -2000 * UM, 3000 * UM}};
    s->cubic = spacing;
    s->chunk_size = 16;
    s->threshold = 120;
    s->batch = 5000;
    s->samples = malloc(MOST * sizeof *s->samples);
    if (!s->samples)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %d samples", (int)MOST);
    for (int i = 0; i < MOST; i++, s->sample_count++) {
        const int32_t x = (int32_t)draw_between(d, 0, SIDE - 1), y = (int32_t)draw_between(d, 0, SIDE - 1),
                      z = (int32_t)draw_between(d, 0, SIDE - 1);
        ost_sample one = sample_at(s, d, x, y, z);
        /* Samples are refused only in the second half, so that the first refused sample is not the first sample of
           its batch. */
        if (!conflicts_alone && i > MOST / 2 && draw_one_in(d, 9)) {
            const ost_pm offs[] = {3 * spacing / 8 + 1, spacing / 2, -spacing / 2, spacing * SIDE, -spacing * SIDE};
            ost_pm *const axes[] = {&one.x, &one.y, &one.z}, *at = axes[draw_between(d, 0, 2)];
            if (draw_one_in(d, 4))
                *at = draw_one_in(d, 2) ? OST_LENGTH_MAX + 1 : -OST_LENGTH_MAX - 1;
            else
                *at += offs[draw_between(d, 0, 4)];
        }
        one.line = (uint32_t)((size_t)i % s->batch);
        s->samples[s->sample_count] = one;
    }
    s->duplicates = OST_DUPLICATES_ERROR;
    return OST_OK;
}

/* -------------------------------------------------------- the hollow cases */

enum { HOLLOW_X = 50, HOLLOW_Y = 35, HOLLOW_Z = 33, HOLLOW_BAR = 1024 };

/* Adds a tick. The tool is at bone voxel (x, y, z), moved by `before` tool voxels towards lower x. */
static void hollow_tick(scene *s, int32_t tool, int32_t x, int32_t y, int32_t z, int32_t before)
{
    const ost_pm3 o = s->rect.origin;
    next_tick(s, tool)->pose.t = (ost_pm3){o.x + s->cubic * x - s->tools[tool].cutting.grid.voxel * before,
                                           o.y + s->cubic * y, o.z + s->cubic * z};
}

static ost_status make_hollow(scene *s, draw *d, ost_error *err)
{
    const ost_pm cube = 500 * UM;
    s->rect = (ost_geometry){
        {HOLLOW_X, HOLLOW_Y, HOLLOW_Z}, {730 * UM, 510 * UM, 520 * UM}, draw_point(d, -90000 * UM, 90000 * UM)};
    s->cubic = cube;
    s->resample = OST_RESAMPLE_LINEAR;
    s->chunk_size = 16;
    s->threshold = 120;
    s->batch = 9001;
    const size_t voxels = (size_t)ost_dims_count(s->rect.dims);
    s->samples = malloc(voxels * sizeof *s->samples);
    if (!s->samples)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %zu samples", voxels);
    for (int32_t z = 0; z < HOLLOW_Z; z++)
        for (int32_t y = 0; y < HOLLOW_Y; y++)
            for (int32_t x = 0; x < HOLLOW_X; x++, s->sample_count++) {
                const ost_geometry *g = &s->rect;
                const ost_pm3 at = {g->origin.x + g->spacing.x * x, g->origin.y + g->spacing.y * y,
                                    g->origin.z + g->spacing.z * z};
                s->samples[s->sample_count] = (ost_sample){at.x, at.y, at.z, (int32_t)draw_between(d, 100, 3000),
                                                           (uint32_t)(s->sample_count % s->batch)};
            }
    ost_status status = scene_add_plates(s, cube, err);
    if (status == OST_OK)
        status = scene_add_bar(s, (ost_dims){9, 17, 33}, 8, cube / 2, err);
    if (status == OST_OK)
        status = scene_add_bar(s, (ost_dims){33, 9, 17}, 0, cube / 2, err);
    if (status == OST_OK)
        status = scene_add_bar(s, (ost_dims){HOLLOW_BAR, 3, 3}, 1, cube / 2, err);
    if (status == OST_OK)
        status = reserve_ticks(s, 7, err);
    if (status != OST_OK)
        return status;
    /* The plates lie 16 to 20 voxels from the tool's middle, one on each side. They reach neither the last rows nor
       the first slices of the bone. */
    hollow_tick(s, 0, 12, 10, 25, 0);
    hollow_tick(s, 0, 38, 10, 25, 0);
    hollow_tick(s, 0, 98, 10, 25, 0);
    hollow_tick(s, 1, 40, 32, 3, 1 << 11);
    hollow_tick(s, 2, 40, 32, 3, 1 << 12);
    hollow_tick(s, 1, 40, 32, 3, 0); /* this tool is oblique, so that rows of the bone cross rows of the tool */
    const double none[3] = {0, 0, 0}, slanted[4] = {0.8, 0.36, 0.48, 0};
    ost_pose *pose = &s->path.ticks[s->path.count - 1].pose;
    const ost_pm3 at = pose->t;
    status = ost_pose_from_doubles(none, slanted, pose, err);
    pose->t = at;
    /* moves the tool one third of a bone voxel beyond voxel 10 along x */
    hollow_tick(s, 3, 10, 32, 3, -HOLLOW_BAR / 2);
    pose = &s->path.ticks[s->path.count - 1].pose;
    pose->t.x += cube / 3;
    pose->qw = 0;
    pose->qz = OST_Q30_ONE;
    s->collide_every = 1;
    return status;
}

ost_status scene_reach(const plan_case *c, scene *s, draw *d, ost_error *err)
{
    switch (c->number % KINDS) {
    case 0: return make_large(c, s, d, err);
    case 1: return make_rods(c, s, d, err);
    case 3: return make_hollow(s, d, err);
    case 4: return scene_lone(c->number / KINDS, s, d, err);
    case 5: return scene_emptied(c, c->number / KINDS, s, d, err);
    default: return make_refused(c, s, d, err);
    }
}
