/* SPDX-License-Identifier: Apache-2.0 */
#include "core/conditions.h"

#include "io/text/walk.h"

#include <assert.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "core/integer.h"
#include "io/text/lattice.h"

/*
 * Number of bytes that are read and then processed at a time. The number is small enough that the bytes are
 * still in the second-level cache when they are processed.
 */
enum { CHUNK = 1 << 17, BUFFER = CHUNK + 2 * (OST_TEXT_LINE_MAX + 64) + OST_TEXT_MARGIN };

bool ost_text_walker_open(ost_text_walker *walker, const ost_text_plan *plan, bool learning)
{
    *walker = (ost_text_walker){
        .plan = plan, .learning = learning, .parser = {.path = plan->path, .past_header = true}};
    walker->buffer = calloc(BUFFER, 1);
    if (learning)
        walker->row = malloc((size_t)plan->raster->count[0] * sizeof *walker->row);
    return walker->buffer && (walker->row || !learning);
}

void ost_text_walker_close(ost_text_walker *walker)
{
    free(walker->buffer);
    free(walker->row);
}

/* ------------------------------------------------------------- single lines */

bool ost_text_walk_parse(ost_text_parser *parser, const char *p, const char *newline, ost_text_row *row)
{
    ost_text_block block = {p, newline + 1};
    size_t count;
    return ost_text_parse(parser, &block, row, 1, &count, NULL) == OST_OK && count == 1 && row->rounded == 0;
}

ost_text_marks ost_text_mark(const char *p, const char *newline)
{
    ost_text_marks marks;
    for (int i = 0; i < 3; i++) {
        (void)ost_text_field_start(&p, newline, i);
        marks.end[i] = p = ost_text_field_end(p, newline);
    }
    (void)ost_text_field_start(&p, newline, 3);
    marks.density = p;
    return marks;
}

bool ost_text_column_set(ost_text_column *column, uint8_t *length, const char *p, const char *end)
{
    *length = 0;
    if (end - p > OST_TEXT_COLUMN_MAX)
        return false;
    *length = (uint8_t)(end - p);
    memcpy(column->text, p, *length);
    memset(column->mask, 0xff, *length);
    return true;
}

/* Appends bytes to `around`. Returns false if they do not fit. */
static bool around_add(ost_text_around *around, const void *p, size_t length)
{
    if (length > OST_TEXT_AROUND_MAX - around->length)
        return false;
    memcpy(around->text + around->length, p, length);
    memset(around->mask + around->length, 0xff, length);
    around->length += (uint32_t)length;
    return true;
}

/* Composes the pattern from the strings of the axes. Returns false if the pattern is too long. */
static bool compose(ost_text_walker *walker)
{
    int fastest = walker->plan->raster->axis[0];
    ost_text_around sides[2] = {{.length = 0}, {.length = 0}};
    bool good = true;
    for (int a = 0; a < 3; a++)
        if (a != fastest)
            good = good && around_add(&sides[a > fastest], walker->piece[a].text, walker->piece[a].length);
    good = good && around_add(&sides[1], walker->gap.text, walker->gap.length);
    walker->pattern = (ost_text_pattern){
        .before = sides[0],
        .after = sides[1],
        .shortest = walker->plan->shortest,
        .carriage = walker->plan->carriage,
    };
    return good;
}

/* Copies the strings of the axes from the given line, and composes the pattern of the line's row. */
static void learn_pattern(ost_text_walker *walker, const char *p, const char *newline)
{
    const ost_text_plan *plan = walker->plan;
    if (!plan->fast)
        return;
    ost_text_marks marks = ost_text_mark(p, newline);
    bool good = true;
    for (int a = 0; a < 3; a++) {
        const char *begin = a > 0 ? marks.end[a - 1] : p;
        walker->piece[a] = (ost_text_around){.length = 0};
        if (a != plan->raster->axis[0])
            good = good && around_add(&walker->piece[a], begin, (size_t)(marks.end[a] - begin));
    }
    walker->gap = (ost_text_around){.length = 0};
    good = good && around_add(&walker->gap, marks.end[2], (size_t)(marks.density - marks.end[2]));
    walker->known = good && compose(walker);
    if (walker->learning) {
        int middle = plan->raster->axis[1];
        const char *begin = middle > 0 ? marks.end[middle - 1] : p;
        (void)ost_text_column_set(&plan->middles[walker->at[1]], &plan->middle_lengths[walker->at[1]], begin,
                                  marks.end[middle]);
    }
}

/*
 * Derives the pattern of the next row of the slice from the strings of the first slice. Returns false if this is not
 * possible.
 */
static bool foresee_row(ost_text_walker *walker)
{
    const ost_text_plan *plan = walker->plan;
    int32_t next = walker->at[1] + 1;
    if (walker->learning || !walker->known || next >= plan->raster->count[1] || plan->middle_lengths[next] == 0)
        return false;
    ost_text_around *piece = &walker->piece[plan->raster->axis[1]];
    *piece = (ost_text_around){.length = 0};
    walker->known = around_add(piece, plan->middles[next].text, plan->middle_lengths[next]) && compose(walker);
    return walker->known;
}

/* Returns the index of a value in a monotone array, or -1 if the value does not occur. */
static int32_t find(const ost_pm *at, int32_t count, ost_pm value)
{
    bool up = at[count - 1] >= at[0];
    int32_t lo = 0, hi = count - 1;
    while (lo < hi) {
        int32_t mid = lo + (hi - lo) / 2;
        if (up ? at[mid] < value : at[mid] > value)
            lo = mid + 1;
        else
            hi = mid;
    }
    return at[lo] == value ? lo : -1;
}

/*
 * Computes the index of a slice from its coordinate, which may be rounded. Assumes that the slices are evenly spaced.
 * If they are not, the computed indices are not consecutive, and the walk fails. |off| * 16383 < 2^58.
 */
static int32_t slice_of(const ost_text_plan *plan, ost_pm value)
{
    const ost_text_raster *raster = plan->raster;
    int32_t last = raster->count[2] - 1;
    int64_t span = plan->last_slow - raster->at[2][0], off = value - raster->at[2][0];
    if (last == 0 || span == 0)
        return off == 0 ? 0 : -1;
    if (span < 0) {
        span = -span;
        off = -off;
    }
    if (off < 0 || off > span)
        return -1;
    return (int32_t)ost_rhe_div(off * last, span);
}

static void enter_slice(ost_text_walker *walker, ost_pm slow)
{
    walker->slow = slow;
    if (walker->at[1] == 0 && walker->at[0] == 0 && !walker->learning)
        walker->plan->raster->at[2][walker->at[2]] = slow;
}

/* Determines the voxel of a piece's first line from the line's coordinates. */
static bool place_row(ost_text_walker *walker, const ost_pm by_rank[3])
{
    const ost_text_raster *raster = walker->plan->raster;
    int32_t i = find(raster->at[0], raster->count[0], by_rank[0]);
    int32_t j = walker->learning ? 0 : find(raster->at[1], raster->count[1], by_rank[1]);
    int32_t k = walker->learning ? 0 : slice_of(walker->plan, by_rank[2]);
    if (i < 0 || j < 0 || k < 0)
        return false;
    walker->placed = true;
    walker->at[0] = i;
    walker->at[1] = j;
    walker->at[2] = k;
    walker->middle = by_rank[1];
    walker->first_slow = by_rank[2];
    walker->first_slow_index = k;
    walker->first = walker->next = i + (int64_t)raster->count[0] * (j + (int64_t)raster->count[1] * k);
    if (walker->learning)
        raster->at[1][0] = by_rank[1];
    enter_slice(walker, by_rank[2]);
    return true;
}

/* Processes the first line of a row other than the first row. Called only if `learning` is true. */
static bool learn_row(ost_text_walker *walker, const ost_pm by_rank[3])
{
    ost_text_raster *raster = walker->plan->raster;
    if (by_rank[2] != walker->slow) {
        walker->done = true;
        walker->second_slow = by_rank[2];
        return by_rank[1] == raster->at[1][0];
    }
    int32_t j = ++walker->at[1];
    if (j == OST_DIM_MAX)
        return false;
    raster->at[1][j] = walker->middle = by_rank[1];
    raster->count[1] = j + 1;
    return raster->at[1][1] > raster->at[1][0] ? by_rank[1] > raster->at[1][j - 1] : by_rank[1] < raster->at[1][j - 1];
}

static bool next_row(ost_text_walker *walker, const ost_pm by_rank[3])
{
    const ost_text_raster *raster = walker->plan->raster;
    walker->at[0] = 0;
    walker->known = false;
    if (walker->learning)
        return learn_row(walker, by_rank);
    if (++walker->at[1] < raster->count[1]) {
        walker->middle = raster->at[1][walker->at[1]];
        return true;
    }
    walker->at[1] = 0;
    walker->middle = raster->at[1][0];
    if (++walker->at[2] == raster->count[2] || slice_of(walker->plan, by_rank[2]) != walker->at[2])
        return false;
    enter_slice(walker, by_rank[2]);
    return true;
}

static bool parse_line(ost_text_walker *walker, const char *p, const char *newline)
{
    const ost_text_raster *raster = walker->plan->raster;
    ost_text_row row;
    if (!ost_text_walk_parse(&walker->parser, p, newline, &row))
        return false;
    const ost_pm by_rank[3] = {row.position[raster->axis[0]], row.position[raster->axis[1]],
                               row.position[raster->axis[2]]};
    if (!walker->placed) {
        if (!place_row(walker, by_rank))
            return false;
    } else if (walker->at[0] == raster->count[0]) {
        if (!next_row(walker, by_rank))
            return false;
        if (walker->done)
            return true;
    }
    if (by_rank[0] != raster->at[0][walker->at[0]] || by_rank[1] != walker->middle || by_rank[2] != walker->slow)
        return false;
    for (int a = 0; a < 3; a++)
        walker->units[a] |= 1u << (row.places[a] + OST_LATTICE_UNIT_PLACES);
    (walker->learning ? walker->row + walker->at[0] : raster->voxels + walker->next)[0] = (int16_t)row.density;
    walker->at[0]++;
    walker->next++;
    learn_pattern(walker, p, newline);
    return true;
}

/* --------------------------------------------------------------- many lines */

/*
 * Matches lines from *text on, up to the end of the row, and advances *text and the walker. Returns the number of
 * matched lines.
 */
static size_t match_lines(ost_text_walker *walker, const char **text, const char *end)
{
    const ost_text_plan *plan = walker->plan;
    int32_t at = walker->at[0];
    int16_t *to = walker->learning ? walker->row + at : plan->raster->voxels + walker->next;
    size_t matched = plan->match(&walker->pattern, plan->columns + at, plan->lengths + at, *text, end,
                                 (size_t)(plan->raster->count[0] - at), to, text);
    walker->at[0] += (int32_t)matched;
    walker->next += (int64_t)matched;
    return matched;
}

/*
 * Starts the next row and compares its lines with the expected text. No line is parsed. If the first line differs,
 * clears walker->known and returns false.
 */
static bool match_next_row(ost_text_walker *walker, const char **text, const char *end)
{
    if (!foresee_row(walker))
        return false;
    walker->at[0] = 0;
    if (match_lines(walker, text, end) > 0) {
        walker->middle = walker->plan->raster->at[1][++walker->at[1]];
        return true;
    }
    walker->at[0] = walker->plan->raster->count[0];
    walker->known = false;
    return false;
}

/* Processes complete lines, each of which ends with a newline. */
static bool walk_lines(ost_text_walker *walker, const char *text, const char *end)
{
    const int32_t row = walker->plan->raster->count[0];
    while (text < end && !walker->done) {
        if (walker->known && walker->at[0] < row) {
            (void)match_lines(walker, &text, end);
            if (walker->at[0] == row || text == end)
                continue;
        }
        if (walker->placed && walker->at[0] == row && match_next_row(walker, &text, end))
            continue;
        const char *newline = memchr(text, '\n', (size_t)(end - text));
        if (!newline || !parse_line(walker, text, newline))
            return false;
        text = newline + 1;
    }
    return true;
}

/* ---------------------------------------------------------------- the file */

/*
 * Reads up to `bytes` bytes at offset `at`. Fewer bytes are read only at the end of the file. Returns false on a read
 * error.
 */
static bool read_at(int fd, char *to, size_t bytes, int64_t at, size_t *got)
{
    *got = 0;
    while (*got < bytes) {
        ssize_t n = pread(fd, to + *got, bytes - *got, at + (int64_t)*got);
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0)
            return false;
        if (n == 0)
            break;
        *got += (size_t)n;
    }
    return true;
}

/*
 * Completes the last line in the buffer: appends the bytes at file offset `at`, up to the next newline. At the end of
 * the file, appends a newline.
 */
static bool complete(int fd, char *text, size_t *filled, int64_t at)
{
    size_t got;
    if (!read_at(fd, text + *filled, OST_TEXT_LINE_MAX + 2, at, &got))
        return false;
    char *newline = memchr(text + *filled, '\n', got);
    if (newline)
        *filled = (size_t)(newline + 1 - text);
    else if (got == OST_TEXT_LINE_MAX + 2)
        return false;
    if (!newline) {
        text[*filled + got] = '\n';
        *filled += got + 1;
    }
    return true;
}

bool ost_text_walk(ost_text_walker *walker, int64_t begin, int64_t end, bool inside)
{
    const ost_text_plan *plan = walker->plan;
    char *text = walker->buffer;
    size_t filled = 0;
    int64_t at = inside ? begin - 1 : begin;
    bool more = true;
    while (more && !walker->done) {
        size_t wanted = end - at < CHUNK ? (size_t)(end - at) : CHUNK, got;
        if (!read_at(plan->fd, text + filled, wanted, at, &got) || got < wanted)
            return false;
        at += (int64_t)got;
        filled += got;
        more = at < end;
        if (inside) {
            const char *newline = memchr(text, '\n', filled);
            if (!newline)
                return !more; /* all bytes belong to a line that begins before the piece */
            inside = false;
            filled -= (size_t)(newline + 1 - text);
            memmove(text, newline + 1, filled);
        }
        if (!more && filled > 0 && text[filled - 1] != '\n' && !complete(plan->fd, text, &filled, at))
            return false;
        const char *last = memrchr(text, '\n', filled);
        size_t used = last ? (size_t)(last + 1 - text) : 0;
        if (!walk_lines(walker, text, text + used))
            return false;
        filled -= used;
        if (filled > OST_TEXT_LINE_MAX)
            return false;
        memmove(text, text + used, filled);
    }
    return true;
}
