/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/margin_parts.h"

#include <stdlib.h>
#include <string.h>

const char *margin_unit(trace_stage stage)
{
    return stage == TRACE_RECT || stage == TRACE_CUBIC ? "CT voxel" : stage == TRACE_CHUNKS ? "density" : "tool voxel";
}

static bool same_dims(ost_dims a, ost_dims b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

static bool one_block(const trace_record *r, uint32_t voxel_bytes, trace_block_view *out)
{
    size_t at = 0;
    return trace_next_block(r, &at, out) && out->voxel_bytes == voxel_bytes;
}

static bool words_differ(const trace_record *a, const trace_record *b)
{
    uint64_t n, m;
    const uint8_t *x, *y;
    return !trace_words(a, &n, &x) || !trace_words(b, &m, &y) || n != m || memcmp(x, y, 8 * (size_t)n) != 0;
}

static ost_status store_bones(margin_walk *w, const trace_block_view *a, const trace_block_view *b, ost_error *err)
{
    const size_t bytes = (size_t)ost_dims_count(a->dims) * 2;
    const trace_block_view *views[2] = {a, b};
    w->dims = a->dims;
    for (int side = 0; side < 2; side++) {
        free(w->bone[side]);
        w->bone[side] = malloc(bytes);
        if (!w->bone[side])
            return ost_fail(err, OST_ERR_MEMORY, "out of memory for a bone of %zu bytes", bytes);
        memcpy(w->bone[side], views[side]->voxels, bytes);
    }
    return OST_OK;
}

static ost_status one_record(margin_walk *w, const trace_record *a, const trace_record *b, ost_error *err)
{
    trace_block_view x, y;
    margin_stage *m = &w->out->of[a->stage];
    const bool tool = a->stage == TRACE_TOOL,
               grid = tool || a->stage == TRACE_RECT || a->stage == TRACE_CUBIC || a->stage == TRACE_CHUNKS;
    if (!(b->flags & TRACE_STAND_IN)) {
        m->records++;
        m->reports += !(b->flags & (TRACE_NO_WORDS | TRACE_BOUNDS)) && words_differ(a, b);
    }
    if (a->stage == TRACE_TICK)
        return margin_tick(w, a, b, err);
    if (!grid)
        return OST_OK;
    if (!one_block(a, tool ? 1 : 2, &x) || !one_block(b, tool ? 1 : 2, &y) || !same_dims(x.dims, y.dims) ||
        (tool && a->item >= (uint32_t)w->s->tool_count))
        return ost_fail(err, OST_ERR_INPUT, "stage %s: the grids have not the same size", trace_stage_name(a->stage));
    if (a->stage == TRACE_RECT) {
        w->rect[0] = x;
        w->rect[1] = y;
        return margin_rect(w, &x, &y, err);
    }
    if (a->stage == TRACE_CUBIC) {
        w->cubic[0] = x;
        w->cubic[1] = y;
        margin_cubic(w, &x, &y);
        return OST_OK;
    }
    if (a->stage == TRACE_CHUNKS) {
        margin_chunks(w, &x, &y);
        return store_bones(w, &x, &y, err);
    }
    w->tool[0][a->item] = x;
    w->tool[1][a->item] = y;
    margin_tool(w, a->item, &x, &y);
    return OST_OK;
}

ost_status margins_of(const scene *s, const trace *ref, compare_range in_ref, const trace *got, compare_range in_got,
                      bool apart, margins *out, ost_error *err)
{
    margin_walk w = {.s = s, .apart = apart, .out = out, .event_tick = -1};
    ost_status status = OST_OK;
    *out = (margins){0};
    for (size_t i = 0; i < in_ref.count && i < in_got.count && status == OST_OK; i++) {
        const trace_record *a = &ref->records[in_ref.first + i], *b = &got->records[in_got.first + i];
        if (a->stage != b->stage || a->item != b->item)
            break; /* From here on, only one backend has records, because the other one failed. */
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
        json_t *o = json_pack("{s:s,s:I,s:I,s:I,s:I,s:I,s:I,s:I,s:I,s:o,s:s}", "stage",
                              trace_stage_name((trace_stage)i), "records", (json_int_t)x->records, "reports",
                              (json_int_t)x->reports, "voxels", (json_int_t)x->voxels, "decided",
                              (json_int_t)x->decided, "inherited", (json_int_t)x->inherited, "below_threshold",
                              (json_int_t)x->below_threshold, "unexplained", (json_int_t)x->unexplained, "unmeasured",
                              (json_int_t)x->unmeasured, "bins", bins, "unit", margin_unit((trace_stage)i));
        if (x->decided) {
            json_object_set_new(o, "max_2_20", json_integer((json_int_t)x->max));
            json_object_set_new(o, "max_item", json_integer(x->max_item));
            json_object_set_new(o, "max_voxel",
                                json_pack("[i,i,i]", x->max_voxel[0], x->max_voxel[1], x->max_voxel[2]));
        }
        json_array_append_new(list, o);
    }
    return list;
}
