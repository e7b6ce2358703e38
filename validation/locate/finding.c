/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/locate/finding.h"

#include <stdio.h>
#include <stdlib.h>

#include "validation/locate/grids.h"

static int32_t ceiling(int32_t n, int32_t by)
{
    return (n + by - 1) / by;
}

static void find_chunk(const scene *s, const trace *ref, compare_range in_ref, const compare_difference *d,
                       finding *out)
{
    const bool bone = d->stage == TRACE_CHUNKS || d->stage == TRACE_TICK || d->stage == TRACE_COLLIDE ||
                      d->stage == TRACE_FINAL;
    const int size = bone && s->chunk_size ? s->chunk_size : OST_LEAF;
    trace_block_view first;
    if (d->kind == COMPARE_VOXEL) {
        for (int a = 0; a < 3; a++)
            out->chunk[a] = d->voxel[a] / size;
        out->chunk_size = size;
    } else if (d->kind == COMPARE_WORD && d->chunk >= 0 && bone && grids_block(ref, in_ref, TRACE_CHUNKS, 0, &first)) {
        const int32_t x = ceiling(first.dims.x, size), y = ceiling(first.dims.y, size);
        if (d->chunk >= (int64_t)x * y * ceiling(first.dims.z, size))
            return;
        out->chunk[0] = (int32_t)(d->chunk % x);
        out->chunk[1] = (int32_t)(d->chunk / x % y);
        out->chunk[2] = (int32_t)(d->chunk / x / y);
        out->chunk_size = size;
    }
}

/* For a difference in the report of a collision, finds the difference in the tick with the same number. A tick has
   voxels, which give a more precise position than a report. Returns false if d is a different kind of difference,
   or if the tick has no differing voxel. */
static bool tick_of_collide(const trace *ref, compare_range in_ref, const trace *got, compare_range in_got,
                            const compare_difference *d, compare_difference *out)
{
    if (d->kind != COMPARE_WORD || d->stage != TRACE_COLLIDE)
        return false;
    /* The record of the tick's steps has the index d->records. The tick's own record follows it. */
    compare_record_at(ref, in_ref, got, in_got, (size_t)d->records + 1, out);
    return out->kind == COMPARE_VOXEL && out->stage == TRACE_TICK && out->item == d->item;
}

void finding_make(const scene *s, const trace *ref, compare_range in_ref, const trace *got, compare_range in_got,
                  const compare_difference *d, finding *out)
{
    grids g;
    *out = (finding){.chunk_size = 0};
    find_chunk(s, ref, in_ref, d, out);
    compare_difference tick;
    const bool has_tick = tick_of_collide(ref, in_ref, got, in_got, d, &tick);
    if (has_tick)
        d = &tick;
    if (d->kind == COMPARE_WORD && (d->stage == TRACE_SNAP || d->stage == TRACE_STEPS)) {
        char name[TRACE_WORD];
        out->class = "steps";
        snprintf(out->text, sizeof out->text, "no voxel was made yet: the steps of the two differ in %s",
                 trace_word_name(d->stage, d->word, 0, name));
        return;
    }
    if (d->kind == COMPARE_WORD) {
        out->class = "report-only";
        snprintf(out->text, sizeof out->text, "no voxel differs in this record, only what was reported");
        return;
    }
    if (d->kind != COMPARE_VOXEL || d->records < 1 ||
        !grids_at(s, ref, in_ref, got, in_got, (size_t)d->records - 1, &g)) {
        operands_of(s, ref, in_ref, d, NULL, &out->operands);
        return;
    }
    const pattern_view view = grids_view(&g, s, d->words_too);
    pattern_list list;
    ost_pattern_find(&view, &list);
    out->class = ost_pattern_name(list.of_all);
    snprintf(out->text, sizeof out->text, "%s%s", has_tick ? "of the tick at the same pose: " : "",
             list.of_all == PATTERN_UNCLASSIFIED ? "none of the known shapes" : list.text[list.of_all]);
    operands_of(s, ref, in_ref, d, d->stage == TRACE_TICK ? g.before : NULL, &out->operands);
    grids_free(&g);
}

finding *finding_of_case(const plan_case *c, const trace *ref, compare_range in_ref, const trace *got,
                         compare_range in_got, const compare_difference *d)
{
    finding *out = malloc(sizeof *out);
    ost_error none = {0};
    scene s;
    if (out && scene_make(c, &s, &none) != OST_OK) {
        free(out);
        return NULL;
    }
    if (!out)
        return NULL;
    finding_make(&s, ref, in_ref, got, in_got, d, out);
    scene_free(&s);
    return out;
}
