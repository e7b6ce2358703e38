/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/locate/operands.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include "core/conditions.h"
#include "core/integer.h"
#include "validation/locate/grids.h"
#include "validation/resample.h"

static void add(operands *o, const char *name, const char *format, ...) OST_PRINTF(3, 4);
static void add(operands *o, const char *name, const char *format, ...)
{
    if (o->count == OPERANDS_MAX)
        return;
    operand_line *line = &o->lines[o->count++];
    va_list args;
    va_start(args, format);
    snprintf(line->name, sizeof line->name, "%s", name);
    vsnprintf(line->value, sizeof line->value, format, args);
    va_end(args);
}

/* ---------------------------------------------------------- the rect grid */

static void rect_operands(const scene *s, const compare_difference *d, operands *o)
{
    static const char *const rules[] = {"equal ones only", "the first stays", "the last stays", "the greatest stays"};
    const ost_geometry *g = &s->rect;
    const ost_pm p0[3] = {g->origin.x, g->origin.y, g->origin.z}, sp[3] = {g->spacing.x, g->spacing.y, g->spacing.z};
    int met = 0;
    for (size_t i = 0; i < s->sample_count; i++) {
        const ost_sample *one = &s->samples[i];
        const ost_pm p[3] = {one->x, one->y, one->z};
        bool here = true;
        for (int a = 0; a < 3 && here; a++)
            here = ost_rhe_div(p[a] - p0[a], sp[a]) == d->voxel[a];
        if (!here)
            continue;
        if (++met <= 8)
            add(o, "sample",
                "no. %zu (number %zu of batch %zu): density %d at (%lld, %lld, %lld) pm; less the origin, over the "
                "spacing: (%lld/%lld, %lld/%lld, %lld/%lld)",
                i, i % s->batch, i / s->batch, (int)one->density, (long long)p[0], (long long)p[1], (long long)p[2],
                (long long)(p[0] - p0[0]), (long long)sp[0], (long long)(p[1] - p0[1]), (long long)sp[1],
                (long long)(p[2] - p0[2]), (long long)sp[2]);
    }
    add(o, "samples", "%d fall on this voxel, of %zu in batches of %zu%s", met, s->sample_count, s->batch,
        met > 8 ? "; the first 8 are above" : "");
    if (met > 1)
        add(o, "duplicates", "%s", rules[s->duplicates]);
}

/* --------------------------------------------------------- the cubic grid */

/* Adds the operands of a voxel in the stage TRACE_CUBIC or TRACE_RESAMPLE. The source of TRACE_RESAMPLE is the cubic
   grid. */
static void cubic_operands(const scene *s, const trace *ref, compare_range in_ref, const compare_difference *d,
                           operands *o)
{
    static const char *const rules[] = {
        [OST_RESAMPLE_LINEAR] = "linear: t = ((2 i + 1) cubic - rect) / (2 rect), from 0 to the last",
        [OST_RESAMPLE_NEAREST] = "nearest: floor((2 i + 1) cubic / (2 rect)), at most the last",
        [OST_RESAMPLE_THESIS] = "thesis: floor(i cubic / rect)"};
    const bool again = d->stage == TRACE_RESAMPLE;
    const ost_pm to = again ? resample_again(s->cubic) : s->cubic;
    ost_pm spacing[3] = {s->rect.spacing.x, s->rect.spacing.y, s->rect.spacing.z};
    ost_dims dims = s->rect.dims;
    resample_tap tap[3];
    trace_block_view rect;
    const bool found = grids_block(ref, in_ref, again ? TRACE_CUBIC : TRACE_RECT, 0, &rect);
    if (again && !found)
        return;
    for (int a = 0; a < 3 && again; a++)
        spacing[a] = s->cubic;
    if (again)
        dims = rect.dims;
    const int32_t n[3] = {dims.x, dims.y, dims.z};
    add(o, "rule", "%s", rules[s->resample]);
    for (int a = 0; a < 3; a++) {
        const resample_tap *t = &tap[a];
        const char name[] = {"xyz"[a], '\0'};
        tap[a] = resample_at(d->voxel[a], to, spacing[a], n[a], s->resample);
        add(o, name, "%lld / %lld: source %lld of %d%s", (long long)t->top, (long long)t->bottom, (long long)t->index,
            n[a], t->weight ? " and the next" : "");
        if (t->weight)
            add(o, "weight", "%lld / 32768 of the next along %s", (long long)t->weight, name);
    }
    if (!found || rect.dims.x != n[0] || rect.dims.y != n[1] || rect.dims.z != n[2])
        return;
    int64_t sum = 0;
    for (int corner = 0; corner < 8; corner++) {
        int64_t q[3];
        const int64_t weight = resample_corner(tap, corner, q);
        if (weight == 0)
            continue;
        const int density = grids_voxel(&rect, (size_t)(q[0] + n[0] * (q[1] + n[1] * q[2])));
        sum += weight * density;
        add(o, "source", "%s voxel (%lld, %lld, %lld) has %d", again ? "cubic" : "rect", (long long)q[0],
            (long long)q[1], (long long)q[2], density);
    }
    if (tap[0].weight || tap[1].weight || tap[2].weight)
        add(o, "mean", "%lld / 2^45, rounded half to even: %lld", (long long)sum,
            (long long)ost_rhe_div(sum, INT64_C(1) << 45));
}

/* ------------------------------------------------------------- the chunks */

static void chunk_operands(const scene *s, const trace *ref, compare_range in_ref, const compare_difference *d,
                           operands *o)
{
    trace_block_view cubic;
    const int32_t *v = d->voxel;
    if (!grids_block(ref, in_ref, TRACE_CUBIC, 0, &cubic) || v[0] >= cubic.dims.x || v[1] >= cubic.dims.y ||
        v[2] >= cubic.dims.z)
        return;
    const int density = grids_voxel(&cubic, (size_t)v[0] + (size_t)cubic.dims.x *
                                                               ((size_t)v[1] + (size_t)cubic.dims.y * (size_t)v[2]));
    add(o, "density", "%d in the cubic grid", density);
    add(o, "threshold", "%d: %s", s->threshold,
        density >= s->threshold ? "active, stored as it is" : "below it, stored as 0");
}

/* ----------------------------------------------------------------- a tool */

typedef struct crossing_sums {
    int32_t winding, total;
    /* `times` counts the row's crossings up to the voxel; `owners` counts all crossings of the row */
    uint32_t times, owners;
    int shown;
} crossing_sums;

static bool owns(const int32_t *a, const int32_t *b, int64_t y, int64_t z)
{
    const int64_t dy = (int64_t)b[1] - a[1], dz = (int64_t)b[2] - a[2];
    const int64_t e = dy * (z - a[2]) - dz * (y - a[1]);
    return e > 0 || (e == 0 && (dz < 0 || (dz == 0 && dy > 0)));
}

/*
 * Computes AR-VOX-1 to 3 for one triangle and the row of voxel v. The ranges are the same as in src/cpu/ref/voxelize.c.
 */
static void cross(const ost_snapped_mesh *m, size_t t, const int32_t v[3], const char *part, crossing_sums *sums,
                  operands *o)
{
    const int32_t *a = m->vertices[m->triangles[t][0]], *b = m->vertices[m->triangles[t][1]],
                  *c = m->vertices[m->triangles[t][2]];
    const int f = m->fraction_bits;
    const int64_t half = INT64_C(1) << (f - 1), width = 2 * half, y = v[1] * width + half, z = v[2] * width + half;
    int64_t p[3], q[3];
    for (int i = 0; i < 3; i++) {
        p[i] = (int64_t)b[i] - a[i];
        q[i] = (int64_t)c[i] - a[i];
    }
    int64_t nx = p[1] * q[2] - p[2] * q[1], ny = p[2] * q[0] - p[0] * q[2], nz = p[0] * q[1] - p[1] * q[0];
    int step = -1;
    if (nx == 0)
        return;
    if (nx < 0) {
        const int32_t *swap = b;
        b = c;
        c = swap;
        nx = -nx;
        ny = -ny;
        nz = -nz;
        step = 1;
    }
    if (!owns(a, b, y, z) || !owns(b, c, y, z) || !owns(c, a, y, z))
        return;
    const int64_t crossing = nx * a[0] - ny * (y - a[1]) - nz * (z - a[2]),
                  from = ost_ceil_div(crossing - nx * half, nx * width);
    sums->total += step;
    sums->owners++;
    if (from <= v[0]) {
        sums->winding += step;
        sums->times++;
    }
    if (++sums->shown <= 6)
        add(o, part,
            "triangle %zu crosses the row at x = %lld / %lld (lattice units, a voxel has %lld): %+d from voxel %lld on",
            t, (long long)crossing, (long long)nx, (long long)width, step, (long long)from);
}

static void mesh_operands(const ost_snapped_mesh *m, ost_fill_rule rule, const int32_t v[3], const char *part,
                          operands *o)
{
    crossing_sums n = {0};
    const bool parity = rule == OST_FILL_PARITY;
    for (size_t t = 0; t < m->triangle_count; t++)
        cross(m, t, v, part, &n, o);
    const bool leaks = parity ? n.owners % 2 : n.total != 0, solid = parity ? n.times % 2 : n.winding != 0;
    add(o, part, "%u crossings in the row%s, their sum %d%s; at the voxel the %s is %d: %s", n.owners,
        n.shown > 6 ? " (the first 6 above)" : "", n.total, leaks ? ": it leaks and is void" : "",
        parity ? "number of crossings" : "winding number", parity ? (int)n.times : n.winding,
        solid && !leaks ? "solid" : "void");
}

static void tool_operands(const scene *s, const compare_difference *d, operands *o)
{
    if ((int)d->item >= s->tool_count)
        return;
    const scene_tool *t = &s->tools[d->item];
    add(o, "row", "y = %d, z = %d of tool %u '%s'; %s", d->voxel[1], d->voxel[2], d->item, t->name,
        t->rule == OST_FILL_PARITY ? "parity" : "winding");
    mesh_operands(&t->cutting, t->rule, d->voxel, "cutting", o);
    if (t->noncutting.triangle_count)
        mesh_operands(&t->noncutting, t->rule, d->voxel, "not cutting", o);
}

/* ----------------------------------------------------------------- a tick */

/* The poses of a tick's event. They are determined by the same rules as in ost_world_step. */
typedef struct event_poses {
    bool removal;
    ost_pose from, to; /* first and last pose of the sweep; `from` is set only if count > 1 */
    int count;
    int64_t since; /* number of the tick whose pose is `from`, or -1 */
} event_poses;

static event_poses poses_at(const scene *s, size_t tick, ost_pm voxel)
{
    ost_pose last[SCENE_TOOLS_MAX];
    int64_t since[SCENE_TOOLS_MAX], removal_t = 0;
    int current_tool = -1;
    bool running = false;
    event_poses e = {.count = 0};
    for (size_t i = 0; i <= tick && i < s->path.count; i++) {
        const ost_tick *t = &s->path.ticks[i];
        const int64_t period = s->world.removal_period_ns;
        e = (event_poses){.count = 0, .since = -1};
        if (t->tool < 0 || t->tool >= s->tool_count)
            continue;
        const bool taken_up = t->tool != current_tool || t->lifted;
        if (t->rpm == 0) {
            last[t->tool] = t->pose;
            since[t->tool] = (int64_t)i;
        } else if (taken_up || !running || period == 0 ||
                   ost_floor_div(t->t_ns, period) != ost_floor_div(removal_t, period)) {
            ost_error refused = {0};
            e = (event_poses){true, t->pose, t->pose, 1, -1};
            if (!taken_up && !s->world.sweep_off) {
                e.from = last[t->tool];
                e.since = since[t->tool];
                if (ost_sweep_count(&e.from, &t->pose, &s->tools[t->tool].cutting.grid, voxel, &e.count, &refused) !=
                    OST_OK) {
                    e.removal = false;
                    continue; /* A refused tick has no effect on the world. */
                }
            }
            last[t->tool] = t->pose;
            since[t->tool] = (int64_t)i;
            removal_t = t->t_ns;
        }
        current_tool = t->tool;
        running = t->rpm != 0;
    }
    return e;
}

/* The tool coordinates of a bone voxel at one pose. */
typedef struct mapped {
    bool near;       /* true if the voxel's block is near (AR-MAP-5); if not, the voxel cannot be in the tool */
    int32_t u[3], at[3];
    int is;          /* class of the tool voxel there; -1 outside the tool's grid */
    /* Chebyshev distance, in 2^-20 voxels, to the nearest adjacent tool voxel that gives another result; -1 if there is
       none */
    int32_t gap;
} mapped;

static int class_of(const trace_block_view *tool, const int32_t at[3])
{
    if (at[0] < 0 || at[1] < 0 || at[2] < 0 || at[0] >= tool->dims.x || at[1] >= tool->dims.y || at[2] >= tool->dims.z)
        return -1;
    return grids_voxel(tool,
                       (size_t)at[0] + (size_t)tool->dims.x * ((size_t)at[1] + (size_t)tool->dims.y * (size_t)at[2]));
}

static mapped map_voxel(const ost_map *map, const trace_block_view *tool, const int32_t v[3])
{
    const ost_dims block = {v[0] / OST_MAP_BLOCK, v[1] / OST_MAP_BLOCK, v[2] / OST_MAP_BLOCK};
    mapped m = {.is = -1, .gap = -1};
    int32_t base[3];
    m.near = ost_map_block_base(map, block, base);
    if (!m.near)
        return m;
    for (int a = 0; a < 3; a++) {
        m.u[a] = base[a];
        for (int b = 0; b < 3; b++)
            m.u[a] += v[b] % OST_MAP_BLOCK * map->step[b][a];
        m.at[a] = m.u[a] >> OST_MAP_FRACTION;
    }
    m.is = class_of(tool, m.at);
    for (int n = 0; n < 27; n++) {
        const int by[3] = {n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1};
        int32_t neighbour[3], gap = 0;
        for (int a = 0; a < 3; a++) {
            const int32_t in = m.u[a] & ((1 << OST_MAP_FRACTION) - 1), way = by[a] < 0   ? in + 1
                                                                             : by[a] > 0 ? (1 << OST_MAP_FRACTION) - in
                                                                                         : 0;
            neighbour[a] = m.at[a] + by[a];
            gap = way > gap ? way : gap;
        }
        if ((class_of(tool, neighbour) == OST_TOOL_CUTTING) != (m.is == OST_TOOL_CUTTING) && (m.gap < 0 || gap < m.gap))
            m.gap = gap;
    }
    return m;
}

static void show_mapped(const mapped *m, int k, int n, operands *o)
{
    static const char *const is[] = {"outside the tool's grid", "void", "cutting", "solid, not cutting"};
    char name[OPERAND_NAME], gap[80] = "";
    snprintf(name, sizeof name, "pose %d of %d", k, n);
    if (!m->near) {
        add(o, name, "the voxel's block is far from the tool (AR-MAP-5)");
        return;
    }
    if (m->gap >= 0)
        snprintf(gap, sizeof gap, "; %d / 2^20 of a voxel from one that %s", m->gap,
                 m->is == OST_TOOL_CUTTING ? "does not cut" : "cuts");
    add(o, name, "point (%d, %d, %d) / 2^20 in tool coordinates: tool voxel (%d, %d, %d), %s%s", m->u[0], m->u[1],
        m->u[2], m->at[0], m->at[1], m->at[2], is[m->is + 1], gap);
}

static void tick_operands(const scene *s, const trace *ref, compare_range in_ref, const compare_difference *d,
                          const int16_t *before, operands *o)
{
    trace_block_view bone, tool;
    if (d->item >= s->path.count || !grids_block(ref, in_ref, TRACE_CHUNKS, 0, &bone))
        return;
    const ost_tick *tick = &s->path.ticks[d->item];
    const int32_t *v = d->voxel;
    if (tick->tool < 0 || tick->tool >= s->tool_count ||
        !grids_block(ref, in_ref, TRACE_TOOL, (uint32_t)tick->tool, &tool))
        return;
    const ost_geometry geometry = {bone.dims, {s->cubic, s->cubic, s->cubic}, resample_origin(&s->rect, s->cubic)};
    const event_poses e = poses_at(s, d->item, s->cubic);
    const ost_pose *p = &tick->pose;
    add(o, "tool", "%d '%s', %d x %d x %d voxels of %lld pm", tick->tool, s->tools[tick->tool].name, tool.dims.x,
        tool.dims.y, tool.dims.z, (long long)s->tools[tick->tool].cutting.grid.voxel);
    add(o, "pose", "t = (%lld, %lld, %lld) pm, q = (%d, %d, %d, %d) / 2^30", (long long)p->t.x, (long long)p->t.y,
        (long long)p->t.z, p->qw, p->qx, p->qy, p->qz);
    if (before)
        add(o, "density before", "%d", before[v[0] + (int64_t)bone.dims.x * (v[1] + (int64_t)bone.dims.y * v[2])]);
    if (!e.removal) {
        add(o, "event", "none: no removal is due, or the tick is refused");
        return;
    }
    if (e.since >= 0)
        add(o, "sweep", "%d pose%s since tick %lld", e.count, e.count == 1 ? "" : "s", (long long)e.since);
    else
        add(o, "sweep", "one pose: %s", s->world.sweep_off ? "the sweep is off" : "the tool is new at this tick");
    mapped best = {.gap = -1}, now = best;
    int best_k = 0;
    for (int k = 1; k <= e.count; k++) {
        const ost_pose pose = e.count == 1 ? e.to : ost_sweep_pose(&e.from, &e.to, k, e.count);
        ost_map map;
        ost_error none = {0};
        if (ost_map_make(&pose, &geometry, &s->tools[tick->tool].cutting.grid, &map, &none) != OST_OK)
            return;
        now = map_voxel(&map, &tool, v);
        if (now.is == OST_TOOL_CUTTING) {
            show_mapped(&now, k, e.count, o);
            add(o, "decided", "pose %d is the first that hits the voxel: it is removed if active", k);
            return;
        }
        if (best_k == 0 || (now.gap >= 0 && (best.gap < 0 || now.gap < best.gap))) {
            best = now;
            best_k = k;
        }
    }
    show_mapped(&best, best_k, e.count, o);
    if (best_k != e.count)
        show_mapped(&now, e.count, e.count, o);
    add(o, "decided", "no pose hits the voxel%s: it stays",
        e.count > 1 ? " (shown: the one that comes nearest, and the last)" : "");
}

void operands_of(const scene *s, const trace *ref, compare_range in_ref, const compare_difference *d,
                 const int16_t *before, operands *out)
{
    *out = (operands){.count = 0};
    if (d->kind != COMPARE_VOXEL)
        return;
    if (d->stage == TRACE_RECT)
        rect_operands(s, d, out);
    else if (d->stage == TRACE_CUBIC || d->stage == TRACE_RESAMPLE)
        cubic_operands(s, ref, in_ref, d, out);
    else if (d->stage == TRACE_CHUNKS)
        chunk_operands(s, ref, in_ref, d, out);
    else if (d->stage == TRACE_TOOL)
        tool_operands(s, d, out);
    else if (d->stage == TRACE_TICK)
        tick_operands(s, ref, in_ref, d, before, out);
}
