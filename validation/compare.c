/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/compare.h"

#include <string.h>

compare_range compare_next(const trace *t, size_t *at, uint32_t case_index)
{
    compare_range range = {0, 0};
    size_t i = *at;
    while (i < t->count && (t->records[i].case_index != case_index || t->records[i].stage == TRACE_END))
        i++;
    range.first = i;
    while (i < t->count && t->records[i].case_index == case_index && t->records[i].stage != TRACE_END)
        i++;
    range.count = i - range.first;
    if (!range.count)
        return (compare_range){0, 0};
    *at = i;
    return range;
}

compare_range compare_find(const trace *t, uint32_t case_index)
{
    size_t at = 0;
    return compare_next(t, &at, case_index);
}

static int32_t voxel_at(const trace_block_view *b, size_t i)
{
    if (b->voxel_bytes == 1)
        return b->voxels[i];
    int16_t v;
    memcpy(&v, b->voxels + 2 * i, 2);
    return v;
}

static bool same_location(const trace_block_view *a, const trace_block_view *b)
{
    return memcmp(a->lo, b->lo, sizeof a->lo) == 0 && memcmp(&a->dims, &b->dims, sizeof a->dims) == 0 &&
           a->voxel_bytes == b->voxel_bytes;
}

static bool before(const int32_t a[3], const int32_t b[3])
{
    return a[2] != b[2] ? a[2] < b[2] : a[1] != b[1] ? a[1] < b[1] : a[0] < b[0];
}

/* Counts the differing voxels of two blocks with equal position and size. Sets out->voxel to the first differing
   voxel of the record. */
static void compare_block(const trace_block_view *a, const trace_block_view *b, compare_difference *out)
{
    const size_t count = (size_t)ost_dims_count(a->dims), wide = (size_t)a->dims.x, high = (size_t)a->dims.y;
    bool first = true;
    if (memcmp(a->voxels, b->voxels, count * a->voxel_bytes) == 0)
        return;
    for (size_t i = 0; i < count; i++) {
        const int32_t ref = voxel_at(a, i), got = voxel_at(b, i);
        if (ref == got)
            continue;
        const int32_t at[3] = {a->lo[0] + (int32_t)(i % wide), a->lo[1] + (int32_t)(i / wide % high),
                               a->lo[2] + (int32_t)(i / wide / high)};
        if (first && (out->voxels == 0 || before(at, out->voxel))) {
            memcpy(out->voxel, at, sizeof at);
            out->voxel_ref = ref;
            out->voxel_got = got;
        }
        first = false;
        out->voxels++;
    }
}

/* Orders leaves x-fastest, as the blocks of a tick are ordered. */
static int order(const trace_block_view *a, const trace_block_view *b)
{
    for (int axis = 2; axis >= 0; axis--)
        if (a->lo[axis] != b->lo[axis])
            return a->lo[axis] < b->lo[axis] ? -1 : 1;
    return 0;
}

enum { LEAF_BYTES = 2 * OST_LEAF * OST_LEAF * OST_LEAF };

/* Copies the part of a complete grid's block that a leaf covers. Returns false if the leaf is not completely inside
   the grid. */
static bool cut_leaf(const trace_block_view *block, const trace_block_view *location, uint8_t leaf[LEAF_BYTES],
                     trace_block_view *out)
{
    *out = *location;
    out->voxels = leaf;
    if (block->voxel_bytes != 2 || block->lo[0] || block->lo[1] || block->lo[2] || location->dims.x > OST_LEAF ||
        location->dims.y > OST_LEAF || location->dims.z > OST_LEAF || location->lo[0] < 0 || location->lo[1] < 0 ||
        location->lo[2] < 0 || location->lo[0] + location->dims.x > block->dims.x ||
        location->lo[1] + location->dims.y > block->dims.y || location->lo[2] + location->dims.z > block->dims.z)
        return false;
    uint8_t *to = leaf;
    const size_t row = 2 * (size_t)location->dims.x;
    for (int32_t k = 0; k < location->dims.z; k++)
        for (int32_t j = 0; j < location->dims.y; j++, to += row)
            memcpy(to,
                   block->voxels +
                       2 * ((size_t)location->lo[0] +
                            (size_t)block->dims.x * ((size_t)(location->lo[1] + j) +
                                                     (size_t)block->dims.y * (size_t)(location->lo[2] + k))),
                   row);
    return true;
}

/* Finds the content of a leaf before record `at` of a case, in the latest earlier record that contains the leaf. */
static bool leaf_before(const trace *t, compare_range range, size_t at, const trace_block_view *location,
                        uint8_t leaf[LEAF_BYTES], trace_block_view *out)
{
    while (at-- > 0) {
        const trace_record *r = &t->records[range.first + at];
        size_t walk = 0;
        trace_block_view b;
        while ((r->stage == TRACE_TICK || r->stage == TRACE_CHUNKS) && trace_next_block(r, &walk, &b)) {
            if (r->stage == TRACE_CHUNKS)
                return cut_leaf(&b, location, leaf, out);
            if (same_location(&b, location)) {
                *out = b;
                return true;
            }
        }
    }
    return false;
}

/* Compares the blocks of two records. A block that only one record contains is compared with the latest earlier block
   at the same position in the other trace. Returns false if there is no such block. */
static bool compare_blocks(const trace *ref, compare_range in_ref, const trace *got, compare_range in_got, size_t at,
                           compare_difference *out)
{
    const trace_record *r = &ref->records[in_ref.first + at], *g = &got->records[in_got.first + at];
    static _Thread_local uint8_t leaf[LEAF_BYTES];
    size_t at_ref = 0, at_got = 0;
    trace_block_view a = {0}, b = {0}, other;
    bool has_a = trace_next_block(r, &at_ref, &a), has_b = trace_next_block(g, &at_got, &b), paired = true;
    while (has_a || has_b) {
        const int which = !has_a ? 1 : !has_b ? -1 : order(&a, &b);
        if (which == 0 && same_location(&a, &b))
            compare_block(&a, &b, out);
        else if (which < 0 && r->stage == TRACE_TICK && leaf_before(got, in_got, at, &a, leaf, &other))
            compare_block(&a, &other, out);
        else if (which > 0 && r->stage == TRACE_TICK && leaf_before(ref, in_ref, at, &b, leaf, &other))
            compare_block(&other, &b, out);
        else
            paired = false;
        if (which <= 0)
            has_a = trace_next_block(r, &at_ref, &a);
        if (which >= 0)
            has_b = trace_next_block(g, &at_got, &b);
    }
    return paired;
}

/* Returns the number of words in a chunk's line of a report: the chunk's number and two words per class. Returns 0 if
   the report has no lines. */
static uint64_t words_of_line(const trace_record *r, const uint8_t *words, uint64_t count)
{
    const uint64_t head = trace_report_head(r->stage),
                   lines = head && count > head ? trace_word_at(words, head - 1) : 0;
    return lines && (count - head) % lines == 0 ? (count - head) / lines : 0;
}

static int64_t chunk_of_word(const trace_record *r, const uint8_t *words, uint64_t count, uint64_t word)
{
    const uint64_t head = trace_report_head(r->stage), stride = words_of_line(r, words, count);
    return stride && word >= head && word < count
               ? (int64_t)trace_word_at(words, head + (word - head) / stride * stride)
               : -1;
}

static bool compare_words(const trace_record *ref, const trace_record *got, compare_difference *out)
{
    uint64_t n = 0, m = 0, i = 0;
    const uint8_t *a = NULL, *b = NULL;
    bool differ = false;
    if (!trace_words(ref, &n, &a) || !trace_words(got, &m, &b))
        return true;
    out->line_words = words_of_line(ref, a, n);
    /* out->word is the first differing word of the report. out->chunk is the chunk of the first differing word
       that belongs to a line of a chunk. */
    for (; i < n && i < m; i++) {
        if (trace_word_at(a, i) == trace_word_at(b, i) ||
            (got->flags & TRACE_BOUNDS && trace_word_holds(ref->stage, (size_t)i, a, b)))
            continue;
        if (!differ) {
            out->word = (size_t)i;
            out->word_ref = trace_word_at(a, i);
            out->word_got = trace_word_at(b, i);
        }
        differ = true;
        const int64_t in_ref = chunk_of_word(ref, a, n, i), in_got = chunk_of_word(got, b, m, i);
        if (in_ref >= 0 || in_got >= 0) {
            out->chunk = in_ref < 0 ? in_got : in_got < 0 || in_ref < in_got ? in_ref : in_got;
            return true;
        }
    }
    if (n == m)
        return differ;
    if (!differ)
        out->word = (size_t)i;
    out->chunk = n > m ? chunk_of_word(ref, a, n, i) : chunk_of_word(got, b, m, i);
    return true;
}

static void compare_record(const trace *ref, compare_range in_ref, const trace *got, compare_range in_got, size_t at,
                           compare_difference *out)
{
    const trace_record *a = &ref->records[in_ref.first + at], *b = &got->records[in_got.first + at];
    if (a->stage != b->stage || a->item != b->item) {
        out->kind = b->stage == TRACE_FAILED ? COMPARE_MISSING : COMPARE_SHAPE;
        return;
    }
    if (b->flags & TRACE_STAND_IN || (a->body_bytes == b->body_bytes && memcmp(a->body, b->body, a->body_bytes) == 0))
        return;
    if (a->stage == TRACE_FAILED) {
        out->kind = compare_words(a, b, out) ? COMPARE_WORD : COMPARE_EQUAL;
        return;
    }
    const bool words = compare_words(a, b, out), paired = compare_blocks(ref, in_ref, got, in_got, at, out);
    out->words_too = words;
    /* Only bounds differ, and backends may report different bounds. */
    if (!words && paired && !out->voxels && b->flags & TRACE_BOUNDS)
        return;
    out->kind = out->voxels ? COMPARE_VOXEL : words && paired ? COMPARE_WORD : COMPARE_SHAPE;
}

void compare_record_at(const trace *ref, compare_range in_ref, const trace *got, compare_range in_got, size_t at,
                       compare_difference *out)
{
    *out = (compare_difference){.kind = COMPARE_EQUAL, .chunk = -1, .records = at + 1};
    if (at >= in_ref.count || at >= in_got.count)
        return;
    compare_record(ref, in_ref, got, in_got, at, out);
    out->stage = ref->records[in_ref.first + at].stage;
    out->item = ref->records[in_ref.first + at].item;
}

void compare_case(const trace *ref, compare_range in_ref, const trace *got, compare_range in_got,
                  compare_difference *out)
{
    *out = (compare_difference){.kind = COMPARE_EQUAL, .chunk = -1};
    for (size_t i = 0; i < in_ref.count || i < in_got.count; i++) {
        out->records = i + 1;
        if (i >= in_got.count || i >= in_ref.count) {
            const trace_record *there = i < in_ref.count ? &ref->records[in_ref.first + i]
                                                         : &got->records[in_got.first + i];
            out->kind = i < in_ref.count ? COMPARE_MISSING : COMPARE_SHAPE;
            out->stage = there->stage;
            out->item = there->item;
            return;
        }
        compare_record(ref, in_ref, got, in_got, i, out);
        if (out->kind != COMPARE_EQUAL) {
            out->stage = ref->records[in_ref.first + i].stage;
            out->item = ref->records[in_ref.first + i].item;
            return;
        }
    }
}
