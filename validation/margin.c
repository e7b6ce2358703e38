/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/margin.h"

#include <stdlib.h>
#include <string.h>

#include "core/integer.h"

/* Distances from a voxel's centre to a triangle; above this many the rest of a record's voxels is not measured. */
enum { TRIANGLE_TESTS = 200 * 1000 * 1000 };

const char *margin_unit(trace_stage stage)
{
    return stage == TRACE_RECT || stage == TRACE_CUBIC ? "CT voxel" : "tool voxel";
}

static void decided(margin_stage *m, uint64_t margin, uint32_t item, const int32_t at[3])
{
    int bin = 0;
    while (bin < MARGIN_BINS - 1 && margin >> bin)
        bin++;
    m->voxels++;
    m->bins[bin]++;
    if (margin > m->max || m->decided == 0) {
        m->max = margin;
        m->max_item = item;
        memcpy(m->max_voxel, at, sizeof m->max_voxel);
    }
    m->decided++;
}

static void other(margin_stage *m, uint64_t *why)
{
    m->voxels++;
    ++*why;
}

/* What the walk along a case keeps of both sides: views of the last whole grids, and the bones as they stand. */
typedef struct walk {
    const scene *s;
    bool apart;
    margins *out;
    trace_block_view rect[2], cubic[2], tool[2][SCENE_TOOLS_MAX];
    ost_dims dims;
    int16_t *bone[2];
    int64_t event_tick; /* the last tick that ran an event, -1: none */
} walk;

static size_t at_voxel(ost_dims d, int32_t x, int32_t y, int32_t z)
{
    return (size_t)x + (size_t)d.x * ((size_t)y + (size_t)d.y * (size_t)z);
}

static int32_t value16(const trace_block_view *b, size_t i)
{
    int16_t v;
    memcpy(&v, b->voxels + 2 * i, sizeof v);
    return v;
}

static bool same_dims(ost_dims a, ost_dims b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

static void place(ost_dims d, size_t i, int32_t at[3])
{
    at[0] = (int32_t)(i % (size_t)d.x);
    at[1] = (int32_t)(i / (size_t)d.x % (size_t)d.y);
    at[2] = (int32_t)(i / (size_t)d.x / (size_t)d.y);
}

static bool one_block(const trace_record *r, uint32_t voxel_bytes, trace_block_view *out)
{
    size_t at = 0;
    return trace_next_block(r, &at, out) && out->voxel_bytes == voxel_bytes;
}

/* ------------------------------------------------------------------- rect */

/* A differing voxel of the rect grid: the least move of samples that would give the other's value. */
typedef struct moved {
    size_t voxel;
    int32_t got;
    int64_t leave; /* the farthest of the samples in it that would have to leave; -1 none is in it */
    int64_t enter; /* the nearest that could come; -1 none */
} moved;

static int compare_moved(const void *a, const void *b)
{
    const size_t x = ((const moved *)a)->voxel, y = ((const moved *)b)->voxel;
    return x < y ? -1 : x > y;
}

/* 2^20 * n / d, floor; 0 <= n <= 2 d, d < 2^37 */
static int64_t share_of(int64_t n, int64_t d)
{
    return (int64_t)((ost_i128)n * MARGIN_ONE / d);
}

static void meet_sample(const ost_geometry *g, const ost_sample *sample, moved *list, size_t count)
{
    const ost_pm p[3] = {sample->x, sample->y, sample->z}, o[3] = {g->origin.x, g->origin.y, g->origin.z},
                 s[3] = {g->spacing.x, g->spacing.y, g->spacing.z};
    const int32_t n[3] = {g->dims.x, g->dims.y, g->dims.z};
    int64_t index[3], off[3];
    for (int a = 0; a < 3; a++) {
        if (p[a] < -OST_LENGTH_MAX || p[a] > OST_LENGTH_MAX)
            return;
        index[a] = ost_rhe_div(p[a] - o[a], s[a]);
        off[a] = p[a] - o[a] - index[a] * s[a];
        if (index[a] < -1 || index[a] > n[a])
            return;
    }
    for (int step = 0; step < 27; step++) {
        const int d[3] = {step % 3 - 1, step / 3 % 3 - 1, step / 9 - 1};
        int64_t gap = 0, leave = INT64_MAX;
        bool inside = true;
        for (int a = 0; a < 3; a++) {
            const int64_t there = index[a] + d[a];
            inside = inside && there >= 0 && there < n[a];
            const int64_t away = d[a] == 0 ? 0 : s[a] - 2 * off[a] * d[a]; /* twice the way to the border */
            gap = away > 0 && share_of(away, 2 * s[a]) > gap ? share_of(away, 2 * s[a]) : gap;
            const int64_t out = share_of(s[a] - 2 * (off[a] < 0 ? -off[a] : off[a]), 2 * s[a]);
            leave = out < leave ? out : leave;
        }
        if (!inside)
            continue;
        const moved key = {.voxel = at_voxel(g->dims, (int32_t)(index[0] + d[0]), (int32_t)(index[1] + d[1]), (int32_t)(index[2] + d[2]))};
        moved *m = bsearch(&key, list, count, sizeof *list, compare_moved);
        if (!m)
            continue;
        if (sample->density == m->got && (m->enter < 0 || gap < m->enter) && step != 13)
            m->enter = gap;
        if (step == 13 && sample->density != m->got && leave > m->leave)
            m->leave = leave;
    }
}

static ost_status rect_margins(walk *w, const trace_block_view *a, const trace_block_view *b, ost_error *err)
{
    margin_stage *m = &w->out->of[TRACE_RECT];
    const size_t all = (size_t)ost_dims_count(a->dims);
    size_t count = 0;
    for (size_t i = 0; i < all; i++)
        count += value16(a, i) != value16(b, i);
    if (!count)
        return OST_OK;
    moved *list = malloc(count * sizeof *list);
    if (!list)
        return ost_fail(err, OST_ERR_MEMORY, "no memory for %zu differing voxels", count);
    count = 0;
    for (size_t i = 0; i < all; i++)
        if (value16(a, i) != value16(b, i))
            list[count++] = (moved){i, value16(b, i), -1, -1};
    for (size_t i = 0; i < w->s->sample_count; i++)
        meet_sample(&w->s->rect, &w->s->samples[i], list, count);
    for (size_t i = 0; i < count; i++) {
        int32_t at[3];
        place(a->dims, list[i].voxel, at);
        /* The other's value came in; or nothing did, all that was in it went, and it is empty. */
        if (list[i].enter >= 0)
            decided(m, (uint64_t)list[i].enter, 0, at);
        else if (list[i].got == 0 && list[i].leave >= 0)
            decided(m, (uint64_t)list[i].leave, 0, at);
        else
            other(m, &m->unexplained);
    }
    free(list);
    return OST_OK;
}

/* ------------------------------------------------------------------ cubic */

/* Along one axis: the source, and how far i cubic / rect (or the middle's) lies from the sources on both sides. */
typedef struct source {
    int64_t index;
    int64_t down, up;
} source;

static source source_of(int64_t i, ost_pm cubic, ost_pm rect, int32_t n, ost_resample rule)
{
    const ost_i128 top = rule == OST_RESAMPLE_FLOOR ? (ost_i128)2 * i * cubic : (ost_i128)(2 * i + 1) * cubic, unit = (ost_i128)2 * rect;
    int64_t index = (int64_t)(top / unit);
    const int64_t rest = (int64_t)(top - index * unit);
    source x = {.index = index, .down = (int64_t)((ost_i128)rest * MARGIN_ONE / unit), .up = (int64_t)((unit - rest) * MARGIN_ONE / unit)};
    if (x.index > n - 1)
        x.index = n - 1;
    return x;
}

static void cubic_margins(walk *w, const trace_block_view *a, const trace_block_view *b)
{
    margin_stage *m = &w->out->of[TRACE_CUBIC];
    const ost_geometry *g = &w->s->rect;
    const trace_block_view *from = &w->rect[0], *given = &w->rect[w->apart ? 0 : 1];
    const size_t all = (size_t)ost_dims_count(a->dims);
    const ost_pm rect[3] = {g->spacing.x, g->spacing.y, g->spacing.z};
    const int32_t n[3] = {g->dims.x, g->dims.y, g->dims.z};
    for (size_t i = 0; i < all; i++) {
        const int32_t got = value16(b, i);
        int32_t at[3];
        if (value16(a, i) == got)
            continue;
        place(a->dims, i, at);
        source s[3];
        int64_t best = -1;
        for (int x = 0; x < 3; x++)
            s[x] = source_of(at[x], w->s->cubic, rect[x], n[x], w->s->resample);
        const size_t here = at_voxel(g->dims, (int32_t)s[0].index, (int32_t)s[1].index, (int32_t)s[2].index);
        if (value16(given, here) == got && value16(from, here) != got) {
            other(m, &m->inherited);
            continue;
        }
        /* The nearest neighbour that has the other's value. */
        for (int step = 0; step < 27; step++) {
            const int d[3] = {step % 3 - 1, step / 3 % 3 - 1, step / 9 - 1};
            int64_t gap = 0, v[3];
            bool inside = step != 13;
            for (int x = 0; x < 3; x++) {
                v[x] = s[x].index + d[x];
                inside = inside && v[x] >= 0 && v[x] < n[x];
                const int64_t away = d[x] < 0 ? s[x].down : d[x] > 0 ? s[x].up : 0;
                gap = away > gap ? away : gap;
            }
            if (inside && value16(given, at_voxel(g->dims, (int32_t)v[0], (int32_t)v[1], (int32_t)v[2])) == got && (best < 0 || gap < best))
                best = gap;
        }
        if (best >= 0)
            decided(m, (uint64_t)best, 0, at);
        else
            other(m, &m->unexplained);
    }
}

/* ----------------------------------------------------------------- chunks */

static void chunks_margins(walk *w, const trace_block_view *a, const trace_block_view *b)
{
    margin_stage *m = &w->out->of[TRACE_CHUNKS];
    const trace_block_view *given = &w->cubic[w->apart ? 0 : 1];
    const size_t all = (size_t)ost_dims_count(a->dims);
    for (size_t i = 0; i < all; i++) {
        const int32_t got = value16(b, i);
        if (value16(a, i) == got)
            continue;
        const int32_t density = given->voxels ? value16(given, i) : 0, right = density >= w->s->threshold ? density : 0;
        if (got == right)
            other(m, &m->inherited);
        else if (right == 0 && got == density)
            other(m, &m->below_threshold);
        else
            other(m, &m->unexplained);
    }
}

/* ------------------------------------------------------------------- tool */

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
 * Squared distances as fractions of 128-bit integers.  Coordinates are twice
 * the lattice's, so that centres are on it: |c| <= 2^21, differences 2^22,
 * crosses 2^45, squares of crosses 2^92; the plane's (n . p)^2 <= 2^136 would
 * not fit, so the squared distance to a plane is only asked for |n . p| < 2^63,
 * nearer than any triangle of that size needs to be told apart.
 */
typedef struct fraction {
    unsigned __int128 top, bottom;
} fraction;

static bool less(fraction a, fraction b)
{
    const unsigned __int128 p = a.top / a.bottom, q = b.top / b.bottom;
    if (p != q)
        return p < q;
    /* Whole parts are equal: compare the rests bit by bit. */
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
    const bool over = dot(cross(minus(b, a), minus(p, a)), n) >= 0 && dot(cross(minus(c, b), minus(p, b)), n) >= 0 && dot(cross(minus(a, c), minus(p, c)), n) >= 0;
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

/* floor(2^20 sqrt(f) / 2^bits): the quotient gets 2 (20 - bits) more bits, one by one. */
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
    return (vector){2 * (int64_t)mesh->vertices[v][0], 2 * (int64_t)mesh->vertices[v][1], 2 * (int64_t)mesh->vertices[v][2]};
}

/* At least this far, on some axis. */
static int64_t beyond(int64_t p, int64_t a, int64_t b, int64_t c)
{
    const int64_t lo = a < b ? (a < c ? a : c) : b < c ? b : c, hi = a > b ? (a > c ? a : c) : b > c ? b : c;
    return p < lo ? lo - p : p > hi ? p - hi : 0;
}

static bool nearest_surface(const ost_snapped_mesh *mesh, vector p, int64_t *tests, bool had, fraction *best)
{
    for (size_t t = 0; t < mesh->triangle_count; t++, --*tests) {
        const vector a = vertex_of(mesh, mesh->triangles[t][0]), b = vertex_of(mesh, mesh->triangles[t][1]), c = vertex_of(mesh, mesh->triangles[t][2]);
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

static void tool_margins(walk *w, uint32_t item, const trace_block_view *a, const trace_block_view *b)
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
            other(m, &m->unmeasured);
            continue;
        }
        place(a->dims, i, at);
        const int64_t one = INT64_C(1) << bits;
        const vector p = {(2 * (int64_t)at[0] + 1) * one, (2 * (int64_t)at[1] + 1) * one, (2 * (int64_t)at[2] + 1) * one};
        bool had = nearest_surface(&tool->cutting, p, &tests, false, &best);
        had = nearest_surface(&tool->noncutting, p, &tests, had, &best);
        if (had)
            decided(m, in_voxels(best, bits + 1), item, at);
        else
            other(m, &m->unexplained);
    }
}

/* ------------------------------------------------------------------- tick */

static bool is_cutting(const trace_block_view *tool, const int64_t c[3])
{
    const ost_dims d = tool->dims;
    if (c[0] < 0 || c[1] < 0 || c[2] < 0 || c[0] >= d.x || c[1] >= d.y || c[2] >= d.z)
        return false;
    return tool->voxels[at_voxel(d, (int32_t)c[0], (int32_t)c[1], (int32_t)c[2])] == OST_TOOL_CUTTING;
}

static void cell_of(const int64_t u[3], int64_t c[3])
{
    for (int a = 0; a < 3; a++)
        c[a] = ost_floor_div(u[a], MARGIN_ONE);
}

static int64_t gap_to(int64_t u, int64_t cell, int64_t step)
{
    return step > 0 ? (cell + step) * MARGIN_ONE - u : step < 0 ? u - (cell + step + 1) * MARGIN_ONE : 0;
}

/*
 * Chebyshev distance from u to the nearest voxel that is cutting, or is not.
 * Rings of voxels about u's own: whatever is found in ring r is at most r away,
 * and what is in ring r + 1 at least r, so the first ring with a find has it.
 */
static int64_t nearest(const trace_block_view *tool, const int64_t u[3], bool cutting)
{
    const int64_t dims[3] = {tool->dims.x, tool->dims.y, tool->dims.z};
    int64_t cell[3], first = 0, last = 0;
    cell_of(u, cell);
    for (int a = 0; a < 3; a++) { /* rings before `first` have nothing of the grid, those after `last` neither */
        const int64_t before = -cell[a], after = cell[a] - (dims[a] - 1);
        const int64_t near = before > after ? before : after, far = cell[a] > dims[a] - 1 - cell[a] ? cell[a] : dims[a] - 1 - cell[a];
        first = near > first ? near : first;
        last = far > last ? far : last;
    }
    if (!cutting)
        first = 0;
    for (int64_t r = first; r <= last + 1; r++) {
        int64_t best = -1, lo[3], hi[3];
        for (int a = 0; a < 3; a++) { /* void begins one voxel outside the grid */
            lo[a] = -r < -cell[a] - 1 ? -cell[a] - 1 : -r;
            hi[a] = r > dims[a] - cell[a] ? dims[a] - cell[a] : r;
        }
        for (int64_t z = lo[2]; z <= hi[2]; z++)
            for (int64_t y = lo[1]; y <= hi[1]; y++) {
                const bool side = z == -r || z == r || y == -r || y == r;
                for (int64_t x = side ? lo[0] : -r; x <= hi[0]; x += side ? 1 : 2 * r) {
                    const int64_t c[3] = {cell[0] + x, cell[1] + y, cell[2] + z};
                    if (x < lo[0] || is_cutting(tool, c) != cutting)
                        continue;
                    int64_t gap = gap_to(u[0], cell[0], x);
                    gap = gap_to(u[1], cell[1], y) > gap ? gap_to(u[1], cell[1], y) : gap;
                    gap = gap_to(u[2], cell[2], z) > gap ? gap_to(u[2], cell[2], z) : gap;
                    best = best < 0 || gap < best ? gap : best;
                }
            }
        if (best >= 0)
            return best;
    }
    return -1;
}

/* Where AR-MAP has the voxel; beyond the blocks that can meet the tool, by the exact map. */
static void mapped(const ost_map *map, const int32_t at[3], int64_t u[3])
{
    int32_t base[3];
    const bool near = ost_map_block_base(map, (ost_dims){at[0] / OST_MAP_BLOCK, at[1] / OST_MAP_BLOCK, at[2] / OST_MAP_BLOCK}, base);
    for (int a = 0; a < 3; a++) {
        if (near)
            u[a] = base[a] + (int64_t)(at[0] % OST_MAP_BLOCK) * map->step[0][a] + (int64_t)(at[1] % OST_MAP_BLOCK) * map->step[1][a] +
                   (int64_t)(at[2] % OST_MAP_BLOCK) * map->step[2][a];
        else
            u[a] = (int64_t)ost_rhe_div128(map->origin[a] + at[0] * map->column[0][a] + at[1] * map->column[1][a] + at[2] * map->column[2][a], map->divisor);
    }
}

/* The maps of the event of this tick, `poses` of them; NULL when it ran none or there is no memory. */
static ost_map *maps_of(const walk *w, size_t tick, uint64_t poses)
{
    const ost_tick *now = &w->s->path.ticks[tick];
    const ost_geometry bone = {w->dims, {w->s->cubic, w->s->cubic, w->s->cubic}, w->s->rect.origin};
    if (poses < 1 || poses > OST_SWEEP_MAX)
        return NULL;
    ost_map *maps = malloc((size_t)poses * sizeof *maps);
    for (uint64_t k = 1; k <= poses && maps; k++) {
        const ost_pose pose = poses == 1 || w->event_tick < 0 ? now->pose : ost_sweep_pose(&w->s->path.ticks[w->event_tick].pose, &now->pose, (int)k, (int)poses);
        if (ost_map_make(&pose, &bone, &w->s->tools[now->tool].cutting.grid, &maps[k - 1], NULL) != OST_OK) {
            free(maps);
            maps = NULL;
        }
    }
    return maps;
}

/* One voxel, equal before this tick and not after it. */
static void judge_voxel(walk *w, uint32_t tick, const ost_map *maps, uint64_t poses, const int32_t at[3], bool ref_removed, bool got_removed)
{
    margin_stage *m = &w->out->of[TRACE_TICK];
    const int tool_index = w->s->path.ticks[tick].tool;
    const trace_block_view *tool = &w->tool[0][tool_index], *theirs = &w->tool[w->apart ? 0 : 1][tool_index];
    int64_t margin = -1;
    bool their_answer = false;
    if (!maps || ref_removed == got_removed) {
        other(m, &m->unexplained);
        return;
    }
    for (uint64_t k = 0; k < poses; k++) {
        int64_t u[3], c[3];
        mapped(&maps[k], at, u);
        cell_of(u, c);
        their_answer = their_answer || is_cutting(theirs, c);
        /* All that cut would have to miss; or the nearest that missed to cut. */
        if (ref_removed && is_cutting(tool, c)) {
            const int64_t out = nearest(tool, u, false);
            margin = out > margin ? out : margin;
        } else if (!ref_removed) {
            const int64_t in = nearest(tool, u, true);
            margin = in >= 0 && (margin < 0 || in < margin) ? in : margin;
        }
    }
    if (theirs->voxels != tool->voxels && their_answer == got_removed)
        other(m, &m->inherited);
    else if (margin >= 0)
        decided(m, (uint64_t)margin, tick, at);
    else
        other(m, &m->unexplained);
}

static uint64_t word_of(const trace_record *r, uint64_t index)
{
    uint64_t count;
    const uint8_t *words;
    return trace_words(r, &count, &words) && index < count ? trace_word_at(words, index) : 0;
}

static bool fits(const trace_block_view *b, ost_dims d)
{
    return b->voxel_bytes == 2 && b->lo[0] >= 0 && b->lo[1] >= 0 && b->lo[2] >= 0 && b->lo[0] + b->dims.x <= d.x && b->lo[1] + b->dims.y <= d.y &&
           b->lo[2] + b->dims.z <= d.z;
}

/* Walks a record's voxels: differences that were none before are judged; done in two passes, so that `before` is of both sides. */
static ost_status tick_margins(walk *w, const trace_record *a, const trace_record *b, ost_error *err)
{
    const uint32_t tick = a->item;
    const uint64_t poses = word_of(a, 3);
    const trace_record *sides[2] = {a, b};
    if (tick >= w->s->path.count || !w->bone[0])
        return ost_fail(err, OST_ERR_INPUT, "a trace has tick %u, the case has %zu", (unsigned)tick, w->s->path.count);
    ost_map *maps = NULL;
    bool made = false;
    /* New values wait beside the old ones until both sides are known. */
    typedef struct change {
        size_t at;
        int16_t value[2];
    } change;
    change *changes = NULL;
    size_t count = 0, room = 0;
    for (int side = 0; side < 2; side++) {
        size_t walk_at = 0;
        trace_block_view block;
        while (trace_next_block(sides[side], &walk_at, &block)) {
            if (!fits(&block, w->dims))
                continue;
            const size_t n = (size_t)ost_dims_count(block.dims);
            for (size_t i = 0; i < n; i++) {
                int32_t in[3];
                place(block.dims, i, in);
                const size_t at = at_voxel(w->dims, block.lo[0] + in[0], block.lo[1] + in[1], block.lo[2] + in[2]);
                const int16_t value = (int16_t)value16(&block, i);
                if (value == w->bone[side][at])
                    continue;
                if (count == room) {
                    room = room ? 2 * room : 256;
                    change *grown = realloc(changes, room * sizeof *grown);
                    if (!grown) {
                        free(changes);
                        return ost_fail(err, OST_ERR_MEMORY, "no memory for a tick's changes");
                    }
                    changes = grown;
                }
                changes[count++] = (change){at, {w->bone[0][at], w->bone[1][at]}};
                w->bone[side][at] = value;
            }
        }
    }
    for (size_t i = 0; i < count; i++) {
        const size_t at = changes[i].at;
        const int16_t *was = changes[i].value;
        /* Both sides may have changed it; the first note has what both had, the second is the first side's new value. */
        if (was[0] != was[1] || w->bone[0][at] == w->bone[1][at])
            continue;
        int32_t place_at[3];
        place(w->dims, at, place_at);
        if (!made) {
            maps = maps_of(w, tick, poses);
            made = true;
        }
        judge_voxel(w, tick, maps, poses, place_at, w->bone[0][at] == 0 && was[0] != 0, w->bone[1][at] == 0 && was[1] != 0);
    }
    for (size_t i = 0; i < count && w->apart; i++) /* the next tick begins with the reference's bone */
        w->bone[1][changes[i].at] = w->bone[0][changes[i].at];
    free(changes);
    free(maps);
    if (word_of(a, 1))
        w->event_tick = tick;
    return OST_OK;
}

/* ------------------------------------------------------------------- walk */

static bool words_differ(const trace_record *a, const trace_record *b)
{
    uint64_t n, m;
    const uint8_t *x, *y;
    return !trace_words(a, &n, &x) || !trace_words(b, &m, &y) || n != m || memcmp(x, y, 8 * (size_t)n) != 0;
}

static ost_status keep_bones(walk *w, const trace_block_view *a, const trace_block_view *b, ost_error *err)
{
    const size_t bytes = (size_t)ost_dims_count(a->dims) * 2;
    const trace_block_view *views[2] = {a, b};
    w->dims = a->dims;
    for (int side = 0; side < 2; side++) {
        free(w->bone[side]);
        w->bone[side] = malloc(bytes);
        if (!w->bone[side])
            return ost_fail(err, OST_ERR_MEMORY, "no memory for a bone of %zu bytes", bytes);
        memcpy(w->bone[side], views[side]->voxels, bytes);
    }
    return OST_OK;
}

static ost_status one_record(walk *w, const trace_record *a, const trace_record *b, ost_error *err)
{
    trace_block_view x, y;
    margin_stage *m = &w->out->of[a->stage];
    const bool tool = a->stage == TRACE_TOOL, whole = tool || a->stage == TRACE_RECT || a->stage == TRACE_CUBIC || a->stage == TRACE_CHUNKS;
    if (!(b->flags & TRACE_STANDS_IN)) {
        m->records++;
        m->reports += !(b->flags & TRACE_NO_WORDS) && words_differ(a, b);
    }
    if (a->stage == TRACE_TICK)
        return tick_margins(w, a, b, err);
    if (!whole)
        return OST_OK;
    if (!one_block(a, tool ? 1 : 2, &x) || !one_block(b, tool ? 1 : 2, &y) || !same_dims(x.dims, y.dims) || (tool && a->item >= (uint32_t)w->s->tool_count))
        return ost_fail(err, OST_ERR_INPUT, "stage %s: the grids have not the same size", trace_stage_name(a->stage));
    if (a->stage == TRACE_RECT) {
        w->rect[0] = x;
        w->rect[1] = y;
        return rect_margins(w, &x, &y, err);
    }
    if (a->stage == TRACE_CUBIC) {
        w->cubic[0] = x;
        w->cubic[1] = y;
        cubic_margins(w, &x, &y);
        return OST_OK;
    }
    if (a->stage == TRACE_CHUNKS) {
        chunks_margins(w, &x, &y);
        return keep_bones(w, &x, &y, err);
    }
    w->tool[0][a->item] = x;
    w->tool[1][a->item] = y;
    tool_margins(w, a->item, &x, &y);
    return OST_OK;
}

ost_status margins_of(const scene *s, const trace *ref, compare_range in_ref, const trace *got, compare_range in_got, bool apart, margins *out, ost_error *err)
{
    walk w = {.s = s, .apart = apart, .out = out, .event_tick = -1};
    ost_status status = OST_OK;
    *out = (margins){0};
    for (size_t i = 0; i < in_ref.count && i < in_got.count && status == OST_OK; i++) {
        const trace_record *a = &ref->records[in_ref.first + i], *b = &got->records[in_got.first + i];
        if (a->stage != b->stage || a->item != b->item)
            break; /* one of them failed there: nothing after it can be laid side by side */
        if (a->stage != TRACE_CASE)
            status = one_record(&w, a, b, err);
    }
    free(w.bone[0]);
    free(w.bone[1]);
    return status;
}

void margins_add(margins *a, const margins *b)
{
    for (int i = 0; i < TRACE_STAGES; i++) {
        margin_stage *x = &a->of[i];
        const margin_stage *y = &b->of[i];
        if (y->decided && (y->max > x->max || !x->decided)) {
            x->max = y->max;
            x->max_item = y->max_item;
            memcpy(x->max_voxel, y->max_voxel, sizeof x->max_voxel);
        }
        x->records += y->records;
        x->reports += y->reports;
        x->voxels += y->voxels;
        x->decided += y->decided;
        x->inherited += y->inherited;
        x->below_threshold += y->below_threshold;
        x->unexplained += y->unexplained;
        x->unmeasured += y->unmeasured;
        for (int k = 0; k < MARGIN_BINS; k++)
            x->bins[k] += y->bins[k];
    }
}

json_t *margins_json(const margins *m)
{
    json_t *list = json_array();
    for (int i = 0; i < TRACE_STAGES; i++) {
        const margin_stage *x = &m->of[i];
        if (!x->voxels && !x->reports)
            continue;
        json_t *bins = json_array();
        for (int k = 0; k < MARGIN_BINS; k++)
            json_array_append_new(bins, json_integer((json_int_t)x->bins[k]));
        json_t *o = json_pack("{s:s,s:I,s:I,s:I,s:I,s:I,s:I,s:I,s:I,s:o,s:s}", "stage", trace_stage_name((trace_stage)i), "records", (json_int_t)x->records,
                              "reports", (json_int_t)x->reports, "voxels", (json_int_t)x->voxels, "decided", (json_int_t)x->decided, "inherited",
                              (json_int_t)x->inherited, "below_threshold", (json_int_t)x->below_threshold, "unexplained", (json_int_t)x->unexplained,
                              "unmeasured", (json_int_t)x->unmeasured, "bins", bins, "unit", margin_unit((trace_stage)i));
        if (x->decided) {
            json_object_set_new(o, "max_2_20", json_integer((json_int_t)x->max));
            json_object_set_new(o, "max_item", json_integer(x->max_item));
            json_object_set_new(o, "max_voxel", json_pack("[i,i,i]", x->max_voxel[0], x->max_voxel[1], x->max_voxel[2]));
        }
        json_array_append_new(list, o);
    }
    return list;
}
