/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/locate/grids.h"

#include <stdlib.h>
#include <string.h>

#include "core/conditions.h"
#include "core/integer.h"
#include "validation/resample.h"

_Static_assert((int)PATTERN_WEIGHT_ONE == (int)RESAMPLE_ONE, "the view has the weights of AR-CUB");

int16_t grids_voxel(const trace_block_view *b, size_t i)
{
    int16_t wide;
    if (b->voxel_bytes == 1)
        return b->voxels[i];
    memcpy(&wide, b->voxels + 2 * i, 2); /* memcpy is used, because the voxels of a block need not be aligned */
    return wide;
}

static bool complete_block(const trace_record *r, trace_block_view *out)
{
    size_t walk = 0;
    return trace_next_block(r, &walk, out) && !out->lo[0] && !out->lo[1] && !out->lo[2];
}

bool grids_block(const trace *t, compare_range in, trace_stage stage, uint32_t item, trace_block_view *out)
{
    for (size_t i = 0; i < in.count; i++) {
        const trace_record *r = &t->records[in.first + i];
        if (r->stage == stage && r->item == item)
            return complete_block(r, out);
    }
    return false;
}

static int16_t *widened(const trace_block_view *b)
{
    const size_t n = (size_t)ost_dims_count(b->dims);
    int16_t *to = malloc(n * sizeof *to);
    for (size_t i = 0; to && i < n; i++)
        to[i] = grids_voxel(b, i);
    return to;
}

static int16_t *copied(const int16_t *from, ost_dims d)
{
    const size_t bytes = (size_t)ost_dims_count(d) * sizeof *from;
    int16_t *to = malloc(bytes);
    return to ? memcpy(to, from, bytes) : NULL;
}

static bool same_dims(ost_dims a, ost_dims b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

/* Copies a tick's leaves into a bone. Returns false if a leaf is not completely inside the bone. */
static bool lay(const trace_record *r, ost_dims d, int16_t *to)
{
    size_t walk = 0;
    trace_block_view b;
    while (trace_next_block(r, &walk, &b)) {
        if (b.lo[0] < 0 || b.lo[1] < 0 || b.lo[2] < 0 || b.lo[0] > d.x - b.dims.x || b.lo[1] > d.y - b.dims.y ||
            b.lo[2] > d.z - b.dims.z)
            return false;
        size_t i = 0;
        for (int32_t z = 0; z < b.dims.z; z++)
            for (int32_t y = 0; y < b.dims.y; y++)
                for (int32_t x = 0; x < b.dims.x; x++)
                    to[b.lo[0] + x + (int64_t)d.x * (b.lo[1] + y + (int64_t)d.y * (b.lo[2] + z))] = grids_voxel(&b,
                                                                                                                i++);
    }
    return true;
}

static bool tick_grids(const trace *ref, compare_range in_ref, const trace_record *got, size_t at, grids *out)
{
    trace_block_view first;
    if (!grids_block(ref, in_ref, TRACE_CHUNKS, 0, &first))
        return false;
    out->dims = out->before_dims = first.dims;
    out->before = widened(&first);
    bool fits = out->before;
    for (size_t i = 0; i < at && fits; i++)
        if (ref->records[in_ref.first + i].stage == TRACE_TICK)
            fits = lay(&ref->records[in_ref.first + i], out->dims, out->before);
    if (!fits)
        return false;
    out->ref = copied(out->before, out->dims);
    out->got = copied(out->before, out->dims);
    return out->ref && out->got && lay(&ref->records[in_ref.first + at], out->dims, out->ref) &&
           lay(got, out->dims, out->got);
}

/* For each cubic voxel along an axis, finds the source rect voxel and the weight of the rect voxel after it
   (AR-CUB). */
static bool find_sources(int32_t n, ost_pm cubic, ost_pm rect, int32_t rect_n, ost_resample rule, int32_t **source,
                         int32_t **weight)
{
    *source = malloc((size_t)n * sizeof **source);
    *weight = malloc((size_t)n * sizeof **weight);
    for (int32_t i = 0; *source && *weight && i < n; i++) {
        const resample_tap tap = resample_at(i, cubic, rect, rect_n, rule);
        (*source)[i] = (int32_t)tap.index;
        (*weight)[i] = (int32_t)tap.weight;
    }
    return *source && *weight;
}

/* Returns an array with a number for each voxel: how many samples of the same batch follow the last sample of the
   voxel, or -1 if the voxel has no sample. */
static int32_t *samples_behind(const scene *s)
{
    const ost_geometry *g = &s->rect;
    const size_t n = (size_t)ost_dims_count(g->dims);
    int32_t *to = malloc(n * sizeof *to);
    if (!to)
        return NULL;
    for (size_t i = 0; i < n; i++)
        to[i] = -1;
    for (size_t i = 0; i < s->sample_count; i++) {
        const ost_sample *one = &s->samples[i];
        const size_t end = (i / s->batch + 1) * s->batch, last = end < s->sample_count ? end : s->sample_count;
        const int64_t x = ost_rhe_div(one->x - g->origin.x, g->spacing.x),
                      y = ost_rhe_div(one->y - g->origin.y, g->spacing.y),
                      z = ost_rhe_div(one->z - g->origin.z, g->spacing.z);
        if (x >= 0 && y >= 0 && z >= 0 && x < g->dims.x && y < g->dims.y && z < g->dims.z)
            to[x + g->dims.x * (y + g->dims.y * z)] = (int32_t)(last - 1 - i);
    }
    return to;
}

static bool with_input(const scene *s, const trace *ref, compare_range in_ref, grids *out)
{
    trace_block_view in;
    if (out->stage == TRACE_RECT && s->sample_count) {
        out->behind = samples_behind(s);
        return out->behind;
    }
    const bool again = out->stage == TRACE_RESAMPLE;
    if (again ? grids_block(ref, in_ref, TRACE_CUBIC, 0, &in)
              : out->stage == TRACE_CUBIC && grids_block(ref, in_ref, TRACE_RECT, 0, &in) &&
                    same_dims(in.dims, s->rect.dims)) {
        const ost_pm to = again ? resample_again(s->cubic) : s->cubic,
                     spacing[3] = {again ? s->cubic : s->rect.spacing.x, again ? s->cubic : s->rect.spacing.y,
                                   again ? s->cubic : s->rect.spacing.z};
        const int32_t n[3] = {out->dims.x, out->dims.y, out->dims.z}, m[3] = {in.dims.x, in.dims.y, in.dims.z};
        out->before = widened(&in);
        out->before_dims = in.dims;
        bool found = out->before;
        for (int a = 0; a < 3; a++)
            found = find_sources(n[a], to, spacing[a], m[a], s->resample, &out->source[a], &out->weight[a]) &&
                    found;
        return found;
    }
    if (out->stage == TRACE_CHUNKS && grids_block(ref, in_ref, TRACE_CUBIC, 0, &in) && same_dims(in.dims, out->dims)) {
        out->before = widened(&in);
        out->before_dims = in.dims;
        return out->before;
    }
    return true;
}

bool grids_at(const scene *s, const trace *ref, compare_range in_ref, const trace *got, compare_range in_got, size_t at,
              grids *out)
{
    trace_block_view one, two;
    *out = (grids){.ref = NULL};
    if (at >= in_ref.count || at >= in_got.count)
        return false;
    const trace_record *a = &ref->records[in_ref.first + at], *b = &got->records[in_got.first + at];
    bool there = a->stage == b->stage && a->item == b->item;
    out->stage = a->stage;
    out->item = a->item;
    if (there && a->stage == TRACE_TICK)
        there = tick_grids(ref, in_ref, b, at, out);
    else if (there) {
        there = complete_block(a, &one) && complete_block(b, &two) && same_dims(one.dims, two.dims);
        if (there) {
            out->dims = one.dims;
            out->ref = widened(&one);
            out->got = widened(&two);
            there = out->ref && out->got && with_input(s, ref, in_ref, out);
        }
    }
    if (!there)
        grids_free(out);
    return there;
}

void grids_free(grids *g)
{
    free(g->ref);
    free(g->got);
    free(g->before);
    free(g->behind);
    for (int a = 0; a < 3; a++) {
        free(g->source[a]);
        free(g->weight[a]);
    }
    *g = (grids){.ref = NULL};
}

pattern_view grids_view(const grids *g, const scene *s, bool reported_too)
{
    const bool tool = g->stage == TRACE_TOOL;
    pattern_view v = {.a = g->ref,
                      .b = g->got,
                      .dims = g->dims,
                      .dims_b = g->dims,
                      .tool = tool,
                      .reported_too = reported_too,
                      .behind = g->behind};
    v.solid_a = v.solid_b = tool ? 1 : s->threshold;
    v.chunk = tool || !s->chunk_size ? OST_LEAF : s->chunk_size;
    if (g->before) {
        v.input = g->stage == TRACE_CUBIC || g->stage == TRACE_RESAMPLE ? PATTERN_SOURCE
                  : g->stage == TRACE_CHUNKS                              ? PATTERN_THRESHOLDED
                                                                          : PATTERN_BEFORE;
        v.in = g->before;
        v.in_dims = g->before_dims;
        for (int a = 0; a < 3; a++) {
            v.source[a] = g->source[a];
            v.weight[a] = g->weight[a];
        }
    }
    return v;
}
