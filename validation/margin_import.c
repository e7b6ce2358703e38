/* SPDX-License-Identifier: Apache-2.0 */
/* Computes the margins of the import stages: the position of a sample, the choice of a layer, and the threshold. */
#include "validation/margin_parts.h"

#include <stdlib.h>

#include "core/integer.h"
#include "validation/resample.h"

/* ---------------------------------------------------------- the rect grid */

/* A differing voxel of the rect grid, and the distances by which samples would have to move so that the reference
   would compute the other backend's value. */
typedef struct moved {
    size_t voxel;
    int32_t got;
    /* least distance by which samples must move so that no sample with a value other than `got` remains in the voxel;
       -1 if it has no such sample */
    int64_t leave;
    /* least distance by which a sample with the value `got` must move to enter the voxel; -1 if there is no such
       sample */
    int64_t enter;
} moved;

static int compare_moved(const void *a, const void *b)
{
    const size_t x = ((const moved *)a)->voxel, y = ((const moved *)b)->voxel;
    return x < y ? -1 : x > y;
}

/* Returns floor(2^20 * n / d), where 0 <= n <= 2 * d and d < 2^37. */
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
            /* twice the distance from the sample to the border towards the neighbour d */
            const int64_t away = d[a] == 0 ? 0 : s[a] - 2 * off[a] * d[a];
            gap = away > 0 && share_of(away, 2 * s[a]) > gap ? share_of(away, 2 * s[a]) : gap;
            const int64_t out = share_of(s[a] - 2 * (off[a] < 0 ? -off[a] : off[a]), 2 * s[a]);
            leave = out < leave ? out : leave;
        }
        if (!inside)
            continue;
        const moved key = {.voxel = margin_at(g->dims, (int32_t)(index[0] + d[0]), (int32_t)(index[1] + d[1]),
                                              (int32_t)(index[2] + d[2]))};
        moved *m = bsearch(&key, list, count, sizeof *list, compare_moved);
        if (!m)
            continue;
        if (sample->density == m->got && (m->enter < 0 || gap < m->enter) && step != 13)
            m->enter = gap;
        if (step == 13 && sample->density != m->got && leave > m->leave)
            m->leave = leave;
    }
}

ost_status margin_rect(margin_walk *w, const trace_block_view *a, const trace_block_view *b, ost_error *err)
{
    margin_stage *m = &w->out->of[TRACE_RECT];
    const size_t all = (size_t)ost_dims_count(a->dims);
    size_t count = 0;
    for (size_t i = 0; i < all; i++)
        count += margin_value16(a, i) != margin_value16(b, i);
    if (!count)
        return OST_OK;
    moved *list = malloc(count * sizeof *list);
    if (!list)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %zu differing voxels", count);
    count = 0;
    for (size_t i = 0; i < all; i++)
        if (margin_value16(a, i) != margin_value16(b, i))
            list[count++] = (moved){i, margin_value16(b, i), -1, -1};
    for (size_t i = 0; i < w->s->sample_count; i++)
        meet_sample(&w->s->rect, &w->s->samples[i], list, count);
    for (size_t i = 0; i < count; i++) {
        int32_t at[3];
        margin_position(a->dims, list[i].voxel, at);
        /* The other backend's value differs either because a sample with this value entered the voxel, or because
           all samples left the voxel, which is then empty. */
        if (list[i].enter >= 0)
            margin_decided(m, (uint64_t)list[i].enter, 0, at);
        else if (list[i].got == 0 && list[i].leave >= 0)
            margin_decided(m, (uint64_t)list[i].leave, 0, at);
        else
            margin_other(m, &m->unexplained);
    }
    free(list);
    return OST_OK;
}

/* --------------------------------------------------------- the cubic grid */

/* The source voxel along one axis, and the distances of the quotient from the limits at which the voxel below
   (`down`) or above (`up`) would be the source. */
typedef struct source {
    resample_tap tap;
    int64_t down, up;
} source;

static source source_of(int64_t i, ost_pm cubic, ost_pm rect, int32_t n, ost_resample rule)
{
    source x = {.tap = resample_at(i, cubic, rect, n, rule)};
    const int64_t remainder = x.tap.top - ost_floor_div(x.tap.top, x.tap.bottom) * x.tap.bottom;
    x.down = (int64_t)((ost_i128)remainder * MARGIN_ONE / x.tap.bottom);
    x.up = (int64_t)((ost_i128)(x.tap.bottom - remainder) * MARGIN_ONE / x.tap.bottom);
    return x;
}

/* Returns the sum that the `linear` rule rounds, in units of 2^-45 of a density; |sum| <= 2^60. */
static int64_t weighted_sum(const trace_block_view *rect, const source s[3])
{
    const resample_tap tap[3] = {s[0].tap, s[1].tap, s[2].tap};
    int64_t sum = 0;
    for (int corner = 0; corner < 8; corner++) {
        int64_t at[3];
        const int64_t weight = resample_corner(tap, corner, at);
        if (weight > 0)
            sum += weight * margin_value16(rect, margin_at(rect->dims, (int32_t)at[0], (int32_t)at[1], (int32_t)at[2]));
    }
    return sum;
}

/* Returns the distance of the mean from the interval of values that round to `got`, in units of 1 / MARGIN_ONE of a
   density. The difference |sum - got 2^45| is below 2^61. */
static int64_t rounding_gap(int64_t sum, int32_t got)
{
    const int64_t one = INT64_C(1) << 45, off = sum > got * one ? sum - got * one : got * one - sum;
    return off > one / 2 ? (off - one / 2) / (one / MARGIN_ONE) : 0;
}

void margin_cubic(margin_walk *w, const trace_block_view *a, const trace_block_view *b)
{
    margin_stage *m = &w->out->of[TRACE_CUBIC];
    const ost_geometry *g = &w->s->rect;
    const trace_block_view *from = &w->rect[0], *given = &w->rect[w->apart ? 0 : 1];
    const size_t all = (size_t)ost_dims_count(a->dims);
    const ost_pm rect[3] = {g->spacing.x, g->spacing.y, g->spacing.z};
    const int32_t n[3] = {g->dims.x, g->dims.y, g->dims.z};
    const int64_t one = INT64_C(1) << 45;
    for (size_t i = 0; i < all; i++) {
        const int32_t got = margin_value16(b, i);
        int32_t at[3];
        if (margin_value16(a, i) == got)
            continue;
        margin_position(a->dims, i, at);
        source s[3];
        int64_t best = -1;
        for (int x = 0; x < 3; x++)
            s[x] = source_of(at[x], w->s->cubic, rect[x], n[x], w->s->resample);
        const int64_t right = weighted_sum(from, s), theirs = weighted_sum(given, s);
        if (ost_rhe_div(theirs, one) == got && ost_rhe_div(right, one) != got) {
            margin_other(m, &m->inherited);
            continue;
        }
        if (s[0].tap.weight || s[1].tap.weight || s[2].tap.weight) { /* the voxel is interpolated */
            margin_decided(m, (uint64_t)rounding_gap(theirs, got), 0, at);
            continue;
        }
        /* Finds the nearest neighbouring voxel that has the value of the other backend. */
        for (int step = 0; step < 27; step++) {
            const int d[3] = {step % 3 - 1, step / 3 % 3 - 1, step / 9 - 1};
            int64_t gap = 0, v[3];
            bool inside = step != 13;
            for (int x = 0; x < 3; x++) {
                v[x] = s[x].tap.index + d[x];
                inside = inside && v[x] >= 0 && v[x] < n[x];
                const int64_t away = d[x] < 0 ? s[x].down : d[x] > 0 ? s[x].up : 0;
                gap = away > gap ? away : gap;
            }
            if (inside &&
                margin_value16(given, margin_at(g->dims, (int32_t)v[0], (int32_t)v[1], (int32_t)v[2])) == got &&
                (best < 0 || gap < best))
                best = gap;
        }
        if (best >= 0)
            margin_decided(m, (uint64_t)best, 0, at);
        else
            margin_other(m, &m->unexplained);
    }
}

/* ------------------------------------------------------------- the chunks */

void margin_chunks(margin_walk *w, const trace_block_view *a, const trace_block_view *b)
{
    margin_stage *m = &w->out->of[TRACE_CHUNKS];
    const ost_dims d = a->dims;
    const trace_block_view *given = &w->cubic[w->apart ? 0 : 1];
    const size_t all = (size_t)ost_dims_count(a->dims);
    for (size_t i = 0; i < all; i++) {
        const int32_t got = margin_value16(b, i);
        if (margin_value16(a, i) == got)
            continue;
        const int32_t density = given->voxels ? margin_value16(given, i) : 0,
                      right = density >= w->s->threshold ? density : 0;
        if (got == right)
            margin_other(m, &m->inherited);
        else if (right == 0 && got == density)
            margin_other(m, &m->below_threshold);
        /* the other backend may have compared with > instead of >= */
        else if (density == w->s->threshold && got == 0) {
            const int32_t at[3] = {(int32_t)(i % (size_t)d.x), (int32_t)(i / (size_t)d.x % (size_t)d.y),
                                   (int32_t)(i / ((size_t)d.x * (size_t)d.y))};
            margin_decided(m, 0, 0, at);
        } else
            margin_other(m, &m->unexplained);
    }
}
