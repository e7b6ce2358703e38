/* SPDX-License-Identifier: Apache-2.0 */
/* Implements the rules of pattern.h for chunks and for lost tails. */
#include "difference/pattern_parts.h"

#include <string.h>

/*
 * The number of work-items in a work-group, which is the maximum number of samples that can be lost at the end of a
 * batch.
 */
enum { GROUP = 256 };

typedef struct chunk_counts {
    /* `as_before` is true if all voxels of B equal those of `in`; `hit` is true if at least one voxel of A differs from
       the same voxel of `in` */
    bool differs, as_before, hit;
    bool solid_a, solid_b; /* valid only if `differs` is true */
} chunk_counts;

static int32_t end_of(int32_t begin, int32_t length, int32_t n)
{
    return begin + length < n ? begin + length : n;
}

/* Returns true if two grids differ in the chunk that begins at (x, y, z). */
static bool chunks_differ(const pattern_view *v, const int16_t *p, const int16_t *q, int32_t x, int32_t y, int32_t z)
{
    const size_t row = (size_t)(end_of(x, v->chunk, v->dims.x) - x) * sizeof *p;
    for (int32_t k = z; k < end_of(z, v->chunk, v->dims.z); k++)
        for (int32_t j = y; j < end_of(y, v->chunk, v->dims.y); j++) {
            const int64_t w = pattern_at(v->dims, x, j, k);
            if (memcmp(p + w, q + w, row) != 0)
                return true;
        }
    return false;
}

/* Sets solid_a if grid A has a solid voxel in the chunk that begins at (x, y, z), and solid_b if grid B has one. */
static void find_solid(const pattern_view *v, int32_t x, int32_t y, int32_t z, chunk_counts *l)
{
    for (int32_t k = z; k < end_of(z, v->chunk, v->dims.z); k++)
        for (int32_t j = y; j < end_of(y, v->chunk, v->dims.y); j++)
            for (int32_t i = x; i < end_of(x, v->chunk, v->dims.x); i++) {
                const int64_t w = pattern_at(v->dims, i, j, k);
                l->solid_a |= v->a[w] >= v->solid_a;
                l->solid_b |= v->b[w] >= v->solid_b;
            }
}

static chunk_counts count_chunk(const pattern_view *v, int32_t x, int32_t y, int32_t z)
{
    chunk_counts l = {.differs = chunks_differ(v, v->a, v->b, x, y, z)};
    if (v->input == PATTERN_BEFORE) {
        l.as_before = !chunks_differ(v, v->b, v->in, x, y, z);
        l.hit = chunks_differ(v, v->a, v->in, x, y, z);
    }
    if (l.differs)
        find_solid(v, x, y, z, &l);
    return l;
}

typedef struct chunk_sums {
    /* `differ` counts all chunks that differ, `undone` those in which B equals `in`, and `one_sided` those that are
       solid in only one grid */
    int64_t differ, undone, one_sided;
    /* `hit` counts the chunks with a hit, and `hit_after` those of them that do not differ but follow one that does */
    int64_t hit, hit_after;
} chunk_sums;

static chunk_sums sum_chunks(const pattern_view *v)
{
    chunk_sums n = {0};
    for (int32_t z = 0; z < v->dims.z; z += v->chunk)
        for (int32_t y = 0; y < v->dims.y; y += v->chunk)
            for (int32_t x = 0; x < v->dims.x; x += v->chunk) {
                const chunk_counts l = count_chunk(v, x, y, z);
                n.hit += l.hit;
                n.hit_after += n.differ && l.hit && !l.differs;
                n.differ += l.differs;
                n.undone += l.differs && l.as_before;
                n.one_sided += l.differs && l.solid_a != l.solid_b;
            }
    return n;
}

bool ost_pattern_stale_chunk(const pattern_scan *s, char *text)
{
    if (s->v->input != PATTERN_BEFORE || s->v->reported_too)
        return false;
    const chunk_sums n = sum_chunks(s->v);
    return n.undone == n.differ &&
           ost_pattern_describe(text, "%lld chunk%s as before the event, though the report counts what was cut there",
                                (long long)n.differ, n.differ == 1 ? " is" : "s are");
}

bool ost_pattern_lost_chunk(const pattern_scan *s, char *text)
{
    if (s->v->tool || s->count < PATTERN_TELLING)
        return false;
    const chunk_sums n = sum_chunks(s->v);
    const char *every = n.differ == 1 ? " " : "s ";
    if (n.undone == n.differ && s->v->input == PATTERN_BEFORE && s->v->reported_too)
        return ost_pattern_describe(text, "%lld whole chunk%sleft out: neither cut nor reported", (long long)n.differ,
                                    every);
    return n.one_sided == n.differ && ost_pattern_describe(text, "%lld whole chunk%ssolid on one side only",
                                                           (long long)n.differ, n.differ == 1 ? " is " : "s are ");
}

/* Checks the lost-tail rule for samples: only the last samples of batches are missing. */
static bool lost_samples(const pattern_scan *s, char *text)
{
    int32_t most = 0;
    PATTERN_EACH(s, p, i) {
        const int32_t behind = s->v->behind[i];
        if (behind < 0 || behind >= GROUP)
            return false;
        most = behind > most ? behind : most;
    }
    return s->count > 1 &&
           ost_pattern_describe(text, "every voxel that differs has its last sample among the last %d of a batch",
                                most + 1);
}

bool ost_pattern_lost_tail(const pattern_scan *s, char *text)
{
    const pattern_view *v = s->v;
    if (v->tool)
        return false;
    if (v->input == PATTERN_BEFORE) {
        const chunk_sums n = sum_chunks(v);
        return v->reported_too && n.undone == n.differ && n.hit > n.differ && n.hit_after == 0 &&
               ost_pattern_describe(text, "the last %lld of %lld chunks that are hit: neither cut nor reported",
                                    (long long)n.differ, (long long)n.hit);
    }
    if (v->behind && lost_samples(s, text))
        return true;
    const int64_t all = ost_dims_count(v->dims);
    bool head = false, last_layer = s->lo[2] == v->dims.z - 1 && v->dims.z > 1;
    if (s->count < PATTERN_TELLING)
        return false;
    PATTERN_EACH(s, p, i)
        last_layer &= v->b[i] == 0;
    if (last_layer)
        return ost_pattern_describe(text, "all that differs lies in the last layer, z = %d, and is 0", s->lo[2]);
    for (int64_t i = s->first; i < all; i++)
        if (v->a[i] != 0 && v->b[i] != 0)
            return false;
    for (int64_t i = 0; i < s->first && !head; i++)
        head = v->a[i] != 0;
    return head && ost_pattern_describe(text, "nothing is there from voxel %lld of %lld on, in the order of memory",
                                        (long long)s->first, (long long)all);
}

