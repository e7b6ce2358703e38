/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/scene.h"

#include <endian.h>
#include <stdlib.h>
#include <string.h>

#include <osteon/motor.h>
#include <osteon/phantom.h>

#include "core/integer.h"
#include "validation/locate/cut.h"
#include "validation/perform.h"
#include "validation/scene_parts.h"
#include "validation/user_store.h"

#define UM (OST_PM_PER_MM / 1000)

/* Draws the spacing of a CT. The spacing is equal or different on the three axes, and is a round decimal or any number
   of picometres. */
static void draw_lattice(scene *s, draw *d)
{
    static const ost_pm usual[] = {470 * UM, 1000 * UM, 488281250, 300 * UM, 32 * UM, 625 * UM};
    ost_pm x = draw_one_in(d, 3) ? draw_between(d, 100 * UM, 2000 * UM) : usual[draw_between(d, 0, 5)];
    ost_pm z = draw_one_in(d, 2) ? x : draw_one_in(d, 2) ? 1000 * UM : draw_between(d, x / 2, 3 * x);
    s->rect.spacing = (ost_pm3){x, draw_one_in(d, 4) ? draw_between(d, x / 2, 2 * x) : x, z};
    s->rect.origin = draw_point(d, -200000 * UM, 200000 * UM);
    s->cubic = draw_one_in(d, 2) ? x : draw_between(d, x * 2 / 3, x * 3 / 2);
    s->resample = (ost_resample)draw_between(d, OST_RESAMPLE_LINEAR, OST_RESAMPLE_THESIS);
    s->duplicates = (ost_duplicates)draw_between(d, 0, 3);
}

/* Makes a bone for cases with ticks. The CT has the bone's spacing, so the size of the bone is predictable. */
static ost_status make_bone(scene *s, draw *d, int32_t side, ost_error *err)
{
    draw_lattice(s, d);
    s->rect.spacing.y = s->rect.spacing.z = s->cubic = s->rect.spacing.x = draw_one_in(d, 2)
                                                                               ? 470 * UM
                                                                               : draw_between(d, 300 * UM, 700 * UM);
    s->resample = OST_RESAMPLE_LINEAR;
    s->threshold = 120;
    return scene_ct(s, d, draw_dims(d, side, side + 15), err);
}

static ost_pm drawn_voxel(draw *d)
{
    static const ost_pm usual[] = {500 * UM, 1000 * UM, 750 * UM, 250 * UM};
    return draw_one_in(d, 3) ? draw_between(d, 250 * UM, 1200 * UM) : usual[draw_between(d, 0, 3)];
}

static ost_status make_import(const plan_case *c, scene *s, draw *d, ost_error *err)
{
    const int32_t most = c->tier == PLAN_SMOKE ? 56 : 120;
    draw_lattice(s, d);
    ost_dims dims = draw_dims(d, 1, most);
    if (c->number == 7) {
        /*
         * Only y is interpolated, and spacings are odd numbers of picometres. The distance of a sample from its lattice
         * point grows from sample to sample. In ppm of the spacing, this distance takes odd and even values. Along each
         * axis, the bone has 31 or 32 voxels, so it fits in one leaf.
         */
        const ost_pm odd = 1000 * UM + 1;
        s->rect.spacing = (ost_pm3){odd, 1300 * UM + 7, odd};
        s->cubic = odd;
        s->resample = OST_RESAMPLE_LINEAR;
        return scene_ct_drifting(s, d, (ost_dims){31, 24, 32}, err);
    }
    if (c->number % 6 == 0) {
        /* Every source index is an exact integer quotient, so a quotient that is computed slightly too small selects
           a different layer. */
        s->rect.spacing.y = s->rect.spacing.z = s->cubic = s->rect.spacing.x;
        s->resample = draw_one_in(d, 2) ? OST_RESAMPLE_LINEAR : OST_RESAMPLE_THESIS;
        dims = (ost_dims){dims.x < 8 ? 8 : dims.x, dims.y < 8 ? 8 : dims.y, dims.z < 8 ? 8 : dims.z};
    }
    if (c->number % 7 == 6) {
        /* Means are computed along all axes. Along x, the source voxels of the first 16 means (one vector)
           span more than 64 voxels, and those of the remaining means span more than 32 voxels. */
        const ost_pm x = s->rect.spacing.x;
        s->rect.spacing = (ost_pm3){x, draw_between(d, x * 3 / 2, 2 * x), draw_between(d, x / 2, x * 4 / 5)};
        s->cubic = draw_between(d, x * 9 / 2, 5 * x);
        s->resample = OST_RESAMPLE_LINEAR;
        dims = (ost_dims){130, dims.y < 8 ? 8 : dims.y, dims.z < 24 ? 24 : dims.z};
    } else if (c->number % 6 == 3 || c->number % 6 == 4) {
        /* The exact value of i * (cubic / rect) is an integer, but rounding gives a value just below it: in double
           precision along x and y, in single precision along z. */
        s->cubic = 900 * UM;
        s->rect.spacing = (ost_pm3){390 * UM, 330 * UM, 870 * UM};
        s->resample = c->number % 6 == 3 ? OST_RESAMPLE_NEAREST : OST_RESAMPLE_THESIS;
        dims = draw_dims(d, 46, 56);
    }
    return scene_ct(s, d, dims, err);
}

static ost_status make_mesh(const plan_case *c, scene *s, draw *d, ost_error *err)
{
    /* every tier contains every shape */
    ost_status status = OST_OK;
    for (int i = 0; i < 2 && status == OST_OK; i++) {
        const ost_fill_rule rule = draw_one_in(d, 3) ? OST_FILL_PARITY : OST_FILL_WINDING;
        const bool noncutting = draw_one_in(d, 2);
        const ost_pm voxel = drawn_voxel(d), size = draw_between(d, 6000 * UM, 36000 * UM);
        status = scene_add_tool(s, d, (scene_shape)((2 * c->number + i) % SHAPE_COUNT), size, voxel, noncutting, rule,
                                err);
    }
    return status;
}

static ost_status add_tools(scene *s, draw *d, int count, ost_pm least, ost_pm most, ost_error *err)
{
    ost_status status = OST_OK;
    for (int i = 0; i < count && status == OST_OK; i++) {
        const bool noncutting = draw_one_in(d, 2);
        const ost_pm voxel = drawn_voxel(d), size = draw_between(d, least, most);
        const scene_shape shape = (scene_shape)draw_between(d, SHAPE_REAMER, SHAPE_HOLLOW);
        status = scene_add_tool(s, d, shape, size, voxel, noncutting, OST_FILL_WINDING, err);
    }
    return status;
}

static ost_status make_poses(const plan_case *c, scene *s, draw *d, ost_error *err)
{
    static const int counts[] = {0, 8, 2, 4, 1};
    if (c->number == 4)
        return scene_corners(s, d, err);
    if (counts[c->number % 5]) /* a count of 0 selects the default classes of AR-CLS-2 */
        s->world.classes = scene_classes(counts[c->number % 5], 149);
    ost_status status = make_bone(s, d, c->tier == PLAN_SMOKE ? 48 : 80, err);
    if (status == OST_OK)
        status = add_tools(s, d, 3, 3000 * UM, 24000 * UM, err);
    if (status == OST_OK)
        status = scene_unrelated_poses(s, d, c->tier == PLAN_SMOKE ? 24 : 80, err);
    s->collide_every = 2;
    return status;
}

static ost_status make_sweep(const plan_case *c, scene *s, draw *d, ost_error *err)
{
    ost_status status = make_bone(s, d, 56, err);
    if (status == OST_OK)
        status = add_tools(s, d, 2, 3000 * UM, 10000 * UM, err);
    if (status == OST_OK)
        status = scene_drive(s, d, c->tier == PLAN_SMOKE ? 16 : 60, draw_between(d, 500 * UM, 4000 * UM), 0.2, err);
    return status;
}

static ost_status make_session(const plan_case *c, scene *s, draw *d, ost_error *err)
{
    static const size_t ticks[PLAN_TIERS] = {300, 1500, 10000};
    ost_status status = make_bone(s, d, c->tier == PLAN_SMOKE ? 56 : 96, err);
    if (status == OST_OK)
        status = add_tools(s, d, 3, 4000 * UM, 16000 * UM, err);
    if (status == OST_OK)
        status = scene_drive(s, d, ticks[c->tier], draw_between(d, 10 * UM, 60 * UM), 0.008, err);
    if (draw_one_in(d, 3))
        s->world.removal_period_ns = 3000000; /* an event every 3 ms, 333 Hz, as in the thesis */
    s->collide_every = 50;
    return status;
}

static int64_t cubic_voxels(const scene *s)
{
    const ost_geometry *g = &s->rect;
    return ost_ceil_div(g->dims.x * g->spacing.x, s->cubic) * ost_ceil_div(g->dims.y * g->spacing.y, s->cubic) *
           ost_ceil_div(g->dims.z * g->spacing.z, s->cubic);
}

/* Makes a small case. Its CT has a different spacing on each axis, so that resampling computes means. It has two
   tools, and one of them has a part that does not cut. */
static ost_status make_small(const plan_case *c, scene *s, draw *d, ost_error *err)
{
    static const scene_shape shapes[] = {SHAPE_BOX, SHAPE_TWICE, SHAPE_HOLLOW, SHAPE_OPEN, SHAPE_SOUP, SHAPE_PEG};
    ost_status status = OST_OK;
    draw_lattice(s, d);
    const ost_pm unit = s->rect.spacing.x;
    ost_dims dims;
    dims.x = (int32_t)draw_between(d, 18, 40);
    dims.y = (int32_t)draw_between(d, 18, 40);
    dims.z = (int32_t)draw_between(d, 12, 30);
    s->rect.dims = dims;
    /* reduces the bone until it is small enough to be downloaded after every tick */
    while (cubic_voxels(s) > PERFORM_ALL_VOXELS)
        s->cubic *= 2;
    status = scene_ct(s, d, dims, err);
    s->batch = (size_t)draw_between(d, 500, 20000);
    for (size_t i = 0; i < s->sample_count; i++)
        s->samples[i].line = (uint32_t)(i % s->batch);
    /* uses the densities of metal, so that sums of densities exceed 2^24 */
    for (size_t i = 0; i < s->sample_count && c->number % 4 == 3; i++)
        if (s->samples[i].density >= s->threshold)
            s->samples[i].density = 32000 + (s->samples[i].density & 511);
    for (int i = 0; i < 2 && status == OST_OK; i++) {
        const ost_pm size = draw_between(d, 6 * unit, 14 * unit);
        status = scene_add_tool(s, d, shapes[(c->number + i) % 6], size, draw_between(d, size / 22, size / 9), i == 0,
                                c->number % 5 == 0 ? OST_FILL_PARITY : OST_FILL_WINDING, err);
    }
    if (status == OST_OK)
        status = c->number % 2 ? scene_unrelated_poses(s, d, 6, err)
                               : scene_drive(s, d, 10, unit + unit / 2, 0.15, err);
    if (status == OST_OK)
        status = scene_add_full_tool(s, d, draw_between(d, s->cubic / 11, s->cubic / 9), err);
    /* Poses on borders are added only if sweeps are off, because the tool's voxels are small and a sweep would have
       hundreds of poses. */
    if (status == OST_OK && s->world.sweep_off)
        status = scene_add_border_poses(s, d, err);
    /* adds an event with more hits than a chunk has voxels; some bone remains after it */
    if (status == OST_OK && c->number % 4 == 0) {
        s->chunk_size = 16;
        status = scene_add_crossing(s, err);
    }
    if (status == OST_OK)
        status = scene_add_poses_inside(s, d, 3, err);
    if (status == OST_OK && s->world.sweep_off)
        status = scene_add_far_pose(s, err);
    s->collide_every = 3; /* a collision precedes tick 12, whose pose is far away */
    return status;
}

/* Appends the ticks of a path. Its first tick is a millisecond after the last tick of the scene. */
static ost_status append_path(scene *s, const ost_path *more, ost_error *err)
{
    const size_t before = s->path.count;
    ost_tick *ticks = realloc(s->path.ticks, (before + more->count) * sizeof *ticks);
    if (!ticks)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %zu ticks", before + more->count);
    s->path.ticks = ticks;
    const int64_t from = before ? ticks[before - 1].t_ns + 1000000 - more->ticks[0].t_ns : 0;
    for (size_t i = 0; i < more->count; i++) {
        ticks[before + i] = more->ticks[i];
        ticks[before + i].t_ns += from;
    }
    s->path.count += more->count;
    return OST_OK;
}

/* Keeps only every `step`-th tick, so that the complete operation fits into the tier's time. The sweeps cover the
   motion between the remaining ticks. */
static void thin_path(ost_path *path, size_t step)
{
    size_t kept = 0;
    for (size_t i = 0; i < path->count; i += step)
        path->ticks[kept++] = path->ticks[i];
    path->count = kept;
}

static ost_status make_operation(const plan_case *c, scene *s, draw *d, ost_error *err)
{
    static const size_t step[PLAN_TIERS] = {12, 3, 1};
    const ost_tool_kind kinds[2] = {OST_TOOL_PEG, OST_TOOL_REAMER};
    ost_volume ct = {0};
    ost_glenoid glenoid;
    const ost_phantom_options how = {.seed = (uint64_t)draw_between(d, 1, 1 << 20), .left = c->number % 2 == 1};
    ost_status status = ost_phantom_make(OST_PHANTOM_GLENOID, &how, &ct, err);
    if (status == OST_OK)
        status = ost_glenoid_from_meta(&ct.meta, &glenoid, err);
    if (status == OST_OK)
        status = scene_ct_of_volume(s, &ct, err);
    ost_volume_free(&ct);
    s->cubic = s->rect.spacing.x;
    s->chunk_size = 32;
    s->threshold = 120;
    for (int i = 0; i < 2 && status == OST_OK; i++) {
        ost_mesh mesh = {0};
        ost_pm3 lo, hi;
        ost_tool_geometry grid;
        ost_path path = {0};
        scene_tool *tool = &s->tools[s->tool_count];
        *tool = (scene_tool){.rule = OST_FILL_WINDING, .name = "peg"};
        if (i == 1)
            *tool = (scene_tool){.rule = OST_FILL_WINDING, .name = "reamer"};
        s->tool_count++;
        status = ost_tool_make(kinds[i], NULL, &mesh, err);
        if (status == OST_OK)
            status = ost_mesh_bounds(&mesh, &lo, &hi, err);
        if (status == OST_OK)
            status = ost_tool_geometry_from_bounds(lo, hi, 500 * UM, &grid, err);
        if (status == OST_OK)
            status = ost_mesh_snap(&mesh, &grid, &tool->cutting, err);
        if (status == OST_OK)
            status = ost_builtin_path(i == 0 ? OST_BUILTIN_PEG_HOLE : OST_BUILTIN_GLENOID_REAM, &glenoid, &grid, i,
                                      &path, err);
        if (status == OST_OK) {
            thin_path(&path, step[c->tier]);
            status = append_path(s, &path, err);
        }
        ost_path_free(&path);
        tool->raw[0] = mesh;
    }
    return status == OST_OK ? scene_turn(s, OST_RPM_REAMER, err) : status;
}

static ost_status make_static(const plan_case *c, scene *s, draw *d, ost_error *err)
{
    (void)d;
    return scene_static(s, c->number, err);
}

static ost_status make_steps(const plan_case *c, scene *s, draw *d, ost_error *err)
{
    return scene_steps(s, d, c->number, err);
}

static ost_status make_user(const plan_case *c, scene *s, draw *d, ost_error *err)
{
    (void)d;
    return user_scene(c->store, c->number, s, err);
}

ost_status scene_make(const plan_case *c, scene *out, ost_error *err)
{
    static ost_status (*const makers[PLAN_FAMILIES])(const plan_case *, scene *, draw *, ost_error *) = {
        [PLAN_IMPORT] = make_import, [PLAN_MESH] = make_mesh,       [PLAN_POSES] = make_poses,
        [PLAN_SWEEP] = make_sweep,   [PLAN_SESSION] = make_session, [PLAN_OPERATION] = make_operation,
        [PLAN_SMALL] = make_small,   [PLAN_STATIC] = make_static,   [PLAN_STEPS] = make_steps,
        [PLAN_USER] = make_user,     [PLAN_REACH] = scene_reach,
    };
    draw d = draw_named(c->seed, c->id);
    *out = (scene){0};
    ost_status status = makers[c->family](c, out, &d, err);
    if (status == OST_OK && c->cut)
        status = scene_cut_apply(c->cut, out, err);
    if (status != OST_OK) {
        ost_fail_context(err, "case %s", c->id);
        scene_free(out);
    }
    return status;
}

void scene_free(scene *s)
{
    if (!s->lent)
        free(s->samples);
    for (int i = 0; i < s->tool_count; i++)
        scene_tool_free(&s->tools[i]);
    ost_path_free(&s->path);
    ost_path_free(&s->handle_path);
    *s = (scene){0};
}

/* ------------------------------------------------------------------- digest */

static ost_status add_ints(ost_hasher *h, const int64_t *values, size_t count, ost_error *err)
{
    unsigned char bytes[1024];
    ost_status status = OST_OK;
    for (size_t i = 0; i < count && status == OST_OK;) {
        size_t used = 0;
        for (; i < count && used < sizeof bytes; i++, used += 8) {
            const uint64_t value = htole64((uint64_t)values[i]);
            memcpy(bytes + used, &value, 8);
        }
        status = ost_hasher_add(h, bytes, used, err);
    }
    return status;
}

static ost_status add_ct(ost_hasher *h, const scene *s, ost_error *err)
{
    const ost_geometry *g = &s->rect;
    const int64_t head[] = {g->dims.x,     g->dims.y,     g->dims.z,         g->spacing.x,
                            g->spacing.y,  g->spacing.z,  g->origin.x,       g->origin.y,
                            g->origin.z,   s->duplicates, s->cubic,          s->resample,
                            s->chunk_size, s->threshold,  (int64_t)s->batch, (int64_t)s->sample_count};
    ost_status status = add_ints(h, head, sizeof head / sizeof head[0], err);
    /* Number of samples per call of add_ints. A CT has millions of samples, so calls with one sample would be slow. */
    enum { AT_ONCE = 24 };
    for (size_t i = 0; i < s->sample_count && status == OST_OK;) {
        int64_t rows[5 * AT_ONCE];
        size_t n = 0;
        for (; i < s->sample_count && n < sizeof rows / sizeof rows[0]; i++) {
            const ost_sample *one = &s->samples[i];
            const int64_t row[5] = {one->x, one->y, one->z, one->density, one->line};
            memcpy(rows + n, row, sizeof row);
            n += 5;
        }
        status = add_ints(h, rows, n, err);
    }
    /* The number of slices is added only if it is not 0, so that the digests of cases without slices remain
       unchanged. */
    return status == OST_OK && s->slices ? add_ints(h, (const int64_t[]){s->slices}, 1, err) : status;
}

static ost_status add_path(ost_hasher *h, const scene *s, ost_error *err)
{
    const int64_t head[] = {s->world.sweep_off, s->world.removal_period_ns, s->collide_every, (int64_t)s->path.count};
    ost_status status = add_ints(h, head, sizeof head / sizeof head[0], err);
    for (int c = 0; c < s->world.classes.count && status == OST_OK; c++)
        status = add_ints(h, (const int64_t[]){s->world.classes.border[c]}, 1, err);
    for (size_t i = 0; i < s->path.count && status == OST_OK; i++) {
        const ost_tick *t = &s->path.ticks[i];
        const int64_t row[] = {t->t_ns,    t->tool,    t->pose.t.x, t->pose.t.y, t->pose.t.z,
                               t->pose.qw, t->pose.qx, t->pose.qy,  t->pose.qz,  t->rpm};
        /* The speed is omitted if it is unknown (OST_RPM_ON), so that the digests of older cases remain unchanged. */
        status = add_ints(h, row, sizeof row / sizeof row[0] - (t->rpm == OST_RPM_ON), err);
    }
    return status;
}

ost_status scene_digest(const scene *s, ost_digest *out, ost_error *err)
{
    ost_hasher *h = NULL;
    ost_status status = ost_hasher_open(&h, err);
    if (status != OST_OK)
        return status;
    status = add_ct(h, s, err);
    for (int i = 0; i < s->tool_count && status == OST_OK; i++) {
        const scene_tool *t = &s->tools[i];
        ost_digest mesh;
        status = add_ints(h, (const int64_t[]){t->rule}, 1, err);
        for (int part = 0; part < 2 && status == OST_OK; part++) {
            const ost_snapped_mesh *m = part ? &t->noncutting : &t->cutting;
            status = add_ints(h, (const int64_t[]){(int64_t)m->triangle_count}, 1, err);
            if (status == OST_OK && m->triangle_count)
                status = ost_snapped_mesh_digest(m, &mesh, err);
            if (status == OST_OK && m->triangle_count)
                status = ost_hasher_add(h, mesh.bytes, sizeof mesh.bytes, err);
        }
    }
    if (status == OST_OK)
        status = add_path(h, s, err);
    ost_error *no_error = status == OST_OK ? err : NULL;
    ost_status closed = ost_hasher_close(h, status == OST_OK ? out : NULL, no_error);
    return status != OST_OK ? status : closed;
}
