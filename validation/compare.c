/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/compare.h"

#include <string.h>

compare_range compare_find(const trace *t, uint32_t case_index)
{
    compare_range range = {0, 0};
    for (size_t i = 0; i < t->count; i++)
        if (t->records[i].case_index == case_index && t->records[i].stage != TRACE_END) {
            if (!range.count)
                range.first = i;
            range.count = i + 1 - range.first;
        } else if (range.count)
            break;
    return range;
}

static int32_t voxel_at(const trace_block_view *b, size_t i)
{
    if (b->voxel_bytes == 1)
        return b->voxels[i];
    int16_t v;
    memcpy(&v, b->voxels + 2 * i, 2);
    return v;
}

static bool same_place(const trace_block_view *a, const trace_block_view *b)
{
    return memcmp(a->lo, b->lo, sizeof a->lo) == 0 && memcmp(&a->dims, &b->dims, sizeof a->dims) == 0 && a->voxel_bytes == b->voxel_bytes;
}

/* Counts differing voxels of two blocks of one place; the first of the record is kept. */
static void compare_block(const trace_block_view *a, const trace_block_view *b, compare_difference *out)
{
    const size_t count = (size_t)ost_dims_count(a->dims);
    if (memcmp(a->voxels, b->voxels, count * a->voxel_bytes) == 0)
        return;
    for (size_t i = 0; i < count; i++) {
        const int32_t ref = voxel_at(a, i), got = voxel_at(b, i);
        if (ref == got)
            continue;
        if (out->voxels++ == 0) {
            const size_t wide = (size_t)a->dims.x, high = (size_t)a->dims.y;
            out->voxel[0] = a->lo[0] + (int32_t)(i % wide);
            out->voxel[1] = a->lo[1] + (int32_t)(i / wide % high);
            out->voxel[2] = a->lo[2] + (int32_t)(i / wide / high);
            out->voxel_ref = ref;
            out->voxel_got = got;
        }
    }
}

/* x-fastest order of leaves, which is that of a tick's blocks. */
static int order(const trace_block_view *a, const trace_block_view *b)
{
    for (int axis = 2; axis >= 0; axis--)
        if (a->lo[axis] != b->lo[axis])
            return a->lo[axis] < b->lo[axis] ? -1 : 1;
    return 0;
}

/*
 * Blocks of one side alone are leaves that only one backend changed; what they
 * were before is not in the record, so their place is what is said.
 */
static bool compare_blocks(const trace_record *ref, const trace_record *got, compare_difference *out)
{
    size_t at_ref = 0, at_got = 0;
    trace_block_view a = {0}, b = {0};
    bool has_a = trace_next_block(ref, &at_ref, &a), has_b = trace_next_block(got, &at_got, &b), lone = false;
    while (has_a || has_b) {
        const int which = !has_a ? 1 : !has_b ? -1 : order(&a, &b);
        if (which != 0 || !same_place(&a, &b)) {
            const trace_block_view *only = which > 0 ? &b : &a;
            if (!lone && out->voxels == 0)
                memcpy(out->voxel, only->lo, sizeof out->voxel);
            lone = true;
        } else
            compare_block(&a, &b, out);
        if (which <= 0)
            has_a = trace_next_block(ref, &at_ref, &a);
        if (which >= 0)
            has_b = trace_next_block(got, &at_got, &b);
    }
    return lone;
}

static bool compare_words(const trace_record *ref, const trace_record *got, compare_difference *out)
{
    uint64_t n = 0, m = 0;
    const uint8_t *a = NULL, *b = NULL;
    if (!trace_words(ref, &n, &a) || !trace_words(got, &m, &b))
        return true;
    for (uint64_t i = 0; i < n && i < m; i++)
        if (trace_word_at(a, i) != trace_word_at(b, i)) {
            out->word = (size_t)i;
            out->word_ref = trace_word_at(a, i);
            out->word_got = trace_word_at(b, i);
            return true;
        }
    out->word = (size_t)(n < m ? n : m);
    return n != m;
}

static void compare_record(const trace_record *ref, const trace_record *got, compare_difference *out)
{
    if (ref->stage != got->stage || ref->item != got->item) {
        out->kind = got->stage == TRACE_FAILED ? COMPARE_MISSING : COMPARE_SHAPE;
        return;
    }
    if (ref->body_bytes == got->body_bytes && memcmp(ref->body, got->body, ref->body_bytes) == 0)
        return;
    const bool words = compare_words(ref, got, out), lone = compare_blocks(ref, got, out);
    out->words_too = words;
    out->kind = out->voxels || lone ? (out->voxels ? COMPARE_VOXEL : COMPARE_SHAPE) : words ? COMPARE_WORD : COMPARE_SHAPE;
}

void compare_case(const trace *ref, compare_range in_ref, const trace *got, compare_range in_got, compare_difference *out)
{
    *out = (compare_difference){.kind = COMPARE_EQUAL};
    for (size_t i = 0; i < in_ref.count || i < in_got.count; i++) {
        out->records = i + 1;
        if (i >= in_got.count || i >= in_ref.count) {
            const trace_record *there = i < in_ref.count ? &ref->records[in_ref.first + i] : &got->records[in_got.first + i];
            out->kind = i < in_ref.count ? COMPARE_MISSING : COMPARE_SHAPE;
            out->stage = there->stage;
            out->item = there->item;
            return;
        }
        const trace_record *a = &ref->records[in_ref.first + i], *b = &got->records[in_got.first + i];
        compare_record(a, b, out);
        if (out->kind != COMPARE_EQUAL) {
            out->stage = a->stage;
            out->item = a->item;
            return;
        }
    }
}
