/* SPDX-License-Identifier: Apache-2.0 */
#include "window/changed.h"

#include <string.h>

#include "core/bits_run.h"

/* SLACK: two boxes are joined if the joined box has at most this number of additional pixels. */
enum { BAND = OST_WINDOW_CELL_HEIGHT, RUN = OST_WINDOW_CELL_WIDTH, SLACK = 8192 };

typedef uint32_t four __attribute__((vector_size(16)));

typedef struct range {
    int begin, end; /* half-open range; empty unless begin < end */
} range;

static uint32_t turned(uint32_t v)
{
    return (v & 0xff00) | (v >> 16 & 0xff) | (v & 0xff) << 16;
}

/*
 * Copies the pixels of the columns [begin, end) and extends *r to include those that differ. `begin` is a multiple of
 * RUN. The function writes all pixels and does not branch on comparisons, so that memory latency does not stall the
 * loop.
 */
static void copy_row(const uint32_t *from, uint32_t *to, int begin, int end, int ahead_from, int ahead_to, range *r)
{
    int i = begin, first = r->begin, last = r->end;
    for (; i + RUN <= end; i += RUN) {
        four v[RUN / 4], was[RUN / 4], differs = {0};
        memcpy(v, from + i, sizeof v);
        memcpy(was, to + i, sizeof was);
        for (int k = 0; k < RUN / 4; k++) {
            v[k] = (v[k] & 0xff00) | (v[k] >> 16 & 0xff) | (v[k] & 0xff) << 16;
            differs |= v[k] ^ was[k];
        }
        memcpy(to + i, v, sizeof v);
        __builtin_prefetch(from + i + ahead_from);
        __builtin_prefetch(to + i + ahead_to, 1);
        const bool any = (differs[0] | differs[1] | differs[2] | differs[3]) != 0;
        first = (any & (i < first)) ? i : first;
        last = (any & (i + RUN > last)) ? i + RUN : last;
    }
    for (; i < end; i++) {
        const uint32_t v = turned(from[i]);
        const bool any = v != to[i];
        to[i] = v;
        first = (any & (i < first)) ? i : first;
        last = (any & (i + 1 > last)) ? i + 1 : last;
    }
    *r = (range){first, last};
}

static range copy_band(const ost_window_picture *p, bool everything, int y, int rows, uint32_t *shared)
{
    const int cells = (p->width + RUN - 1) / RUN;
    const uint64_t *word = everything || !p->changed ? NULL
                                                     : p->changed + (size_t)(y / BAND) * (size_t)p->changed_words;
    range r = {p->width, 0};
    int begin = 0, end = word ? 0 : cells;
    while (!word || ost_bits_run(word, p->changed_words, &begin, &end)) {
        const int right = end * RUN < p->width ? end * RUN : p->width;
        for (int k = y; k < y + rows; k++)
            copy_row(p->pixels + (size_t)k * (size_t)p->stride, shared + (size_t)k * (size_t)p->width, begin * RUN,
                     right, k + 1 < y + rows ? p->stride : 0, k + 1 < y + rows ? p->width : 0, &r);
        if (!word)
            break;
    }
    return r;
}

static int64_t area(const ost_changed_box *b)
{
    return (int64_t)b->width * b->height;
}

static ost_changed_box both(const ost_changed_box *a, const ost_changed_box *b)
{
    const int x = a->x < b->x ? a->x : b->x,
              right = a->x + a->width > b->x + b->width ? a->x + a->width : b->x + b->width;
    return (ost_changed_box){x, a->y, right - x, b->y + b->height - a->y};
}

int ost_changed_copy(const ost_window_picture *picture, bool everything, uint32_t *shared,
                     ost_changed_box box[OST_CHANGED_BOXES])
{
    const int width = picture->width, height = picture->height;
    int count = 0;
    for (int y = 0; y < height; y += BAND) {
        const int rows = height - y < BAND ? height - y : BAND;
        const range r = copy_band(picture, everything, y, rows, shared);
        if (r.begin >= r.end)
            continue;
        const ost_changed_box next = {r.begin, y, r.end - r.begin, rows};
        ost_changed_box *last = count ? &box[count - 1] : NULL;
        const ost_changed_box joined = last ? both(last, &next) : next;
        if (last && (count == OST_CHANGED_BOXES || area(&joined) <= area(last) + area(&next) + SLACK))
            *last = joined;
        else
            box[count++] = next;
    }
    if (!everything)
        return count;
    box[0] = (ost_changed_box){0, 0, width, height};
    return 1;
}
