/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Why one pass is sufficient. The file is divided into pieces, and the lines of each piece are assigned to consecutive
 * voxels [first, next). These intervals must cover [0, N) in the order of the file, without gaps or overlaps. Line L is
 * then voxel L - first_line, and no line is missing. If a piece begins within a slice, the slice's coordinate is taken
 * from the first line of the piece, and must equal the coordinate in the first line of the slice. The coordinates along
 * each axis must strictly rise or fall. They are then distinct, and two passes would collect the same coordinates. If
 * coordinates are off their lattice, share a voxel, or do not form a grid, the text is read in two passes.
 *
 * Why there are two readers. Two passes can read any text. Most texts are raster scans, however, and one pass reads a
 * raster scan in a fifth of the processor time (docs/log/0.1.md, parse), because it compares lines instead of parsing
 * them.
 */
#include "core/conditions.h"

#include "io/text/raster.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>
#if defined _OPENMP
#include <omp.h>
#endif

#include "core/file.h"
#include "core/huge_pages.h"
#include "core/integer.h"
#include "io/text/lattice.h"
#include "io/text/walk.h"

/*
 * The header and the first row must lie within the first HEAD bytes. A line has at least LINE_MIN bytes: "0 0 0 0\n".
 */
enum { HEAD = 1 << 20, LINE_MIN = 8, PIECE_MIN = 1 << 18, PIECES_MAX = 1 << 14, PIECES_A_THREAD = 16 };

/* ------------------------------------------------------------------- learning */

typedef struct reading {
    const ost_text_raster_options *options;
    ost_text_plan plan;
    ost_text_summary *summary;
    ost_text_raster *raster;
    uint32_t units[3];
} reading;

/* Returns the set of the axes along which the two positions differ, as a bit mask. */
static unsigned difference(const ost_text_row *a, const ost_text_row *b)
{
    unsigned axes = 0;
    for (int i = 0; i < 3; i++)
        axes |= (unsigned)(a->position[i] != b->position[i]) << i;
    return axes;
}

static int only_axis(unsigned axes)
{
    return axes == 1 ? 0 : axes == 2 ? 1 : axes == 4 ? 2 : -1;
}

/*
 * Adds a sample of the first row as a column. Returns false if the coordinates are not strictly monotone or if there
 * are too many columns.
 */
static bool learn_column(reading *r, const char *p, const char *newline, const ost_text_row *row)
{
    ost_text_raster *raster = r->raster;
    int fastest = raster->axis[0];
    int32_t i = raster->count[0];
    if (i == OST_DIM_MAX)
        return false;
    ost_pm value = row->position[fastest], *at = raster->at[0];
    for (int a = 0; a < 3; a++)
        r->units[a] |= 1u << (row->places[a] + OST_LATTICE_UNIT_PLACES);
    at[i] = value;
    if (i > 0 && (at[1] > at[0] ? value <= at[i - 1] : value >= at[i - 1]))
        return false;
    ost_text_marks marks = ost_text_mark(p, newline);
    const char *begin = fastest > 0 ? marks.end[fastest - 1] : p;
    r->plan.fast = ost_text_column_set(&r->plan.columns[i], &r->plan.lengths[i], begin, marks.end[fastest]) &&
                   r->plan.fast;
    r->plan.shortest = r->plan.lengths[i] < r->plan.shortest ? r->plan.lengths[i] : r->plan.shortest;
    raster->count[0] = i + 1;
    return true;
}

/*
 * Reads the comments, the header and the first row. The row ends where the coordinate on a second axis changes. This
 * change also determines the order of the axes.
 */
static bool learn_row(reading *r, const char *text, size_t bytes)
{
    ost_text_raster *raster = r->raster;
    ost_text_facts facts = {r->summary, r->options->given};
    ost_text_parser parser = {.path = r->plan.path, .fact = ost_text_fact_take, .user = &facts};
    ost_text_row first, row;
    const char *first_text = NULL, *p = text, *newline;
    if (bytes >= 3 && memcmp(p, "\xef\xbb\xbf", 3) == 0)
        p += 3;
    for (; (newline = memchr(p, '\n', bytes - (size_t)(p - text))); p = newline + 1) {
        ost_text_block block = {p, newline + 1};
        size_t count;
        if (ost_text_parse(&parser, &block, &row, 1, &count, NULL) != OST_OK)
            return false;
        if (!first_text) {
            if (count == 0)
                continue;
            parser.fact = NULL;
            first = row;
            first_text = p;
            raster->first_line = row.line;
            r->plan.begin = p - text;
            r->plan.carriage = newline > p && newline[-1] == '\r';
            continue;
        }
        if (count == 0)
            return false;
        unsigned axes = difference(&first, &row);
        if (raster->count[0] == 0) {
            raster->axis[0] = only_axis(axes);
            if (raster->axis[0] < 0 || !learn_column(r, first_text, memchr(first_text, '\n', bytes), &first))
                return false;
        }
        if (axes & ~(1u << raster->axis[0])) {
            raster->axis[1] = only_axis(axes);
            raster->axis[2] = 3 - raster->axis[0] - raster->axis[1];
            return raster->axis[1] >= 0;
        }
        if (!learn_column(r, p, newline, &row))
            return false;
    }
    return false;
}

/*
 * Stores the last line's coordinate on the slow axis in plan.last_slow. Sets *terminated to true if the last line ends
 * with a newline.
 */
static bool learn_last(reading *r, bool *terminated)
{
    char text[2 * OST_TEXT_LINE_MAX];
    ost_text_parser parser = {.path = r->plan.path, .past_header = true};
    int64_t size = r->plan.end, from = size > (int64_t)sizeof text - 1 ? size - ((int64_t)sizeof text - 1) : 0;
    ssize_t bytes = size - from;
    if (pread(r->plan.fd, text, (size_t)bytes, from) != bytes)
        return false;
    *terminated = text[bytes - 1] == '\n';
    if (!*terminated)
        text[bytes++] = '\n';
    char *before = memrchr(text, '\n', (size_t)bytes - 1);
    ost_text_row row;
    if (!before || !ost_text_walk_parse(&parser, before + 1, text + bytes - 1, &row))
        return false;
    r->plan.last_slow = row.position[r->raster->axis[2]];
    return true;
}

/*
 * Finds the coordinates of the middle axis by reading the first slice. Computes the number of slices from the
 * coordinates of the first, the second and the last slice on the slow axis.
 */
static bool learn_slice(reading *r)
{
    ost_text_raster *raster = r->raster;
    ost_text_walker walker;
    raster->count[1] = raster->count[2] = 1;
    bool good = ost_text_walker_open(&walker, &r->plan, true) &&
                ost_text_walk(&walker, r->plan.begin, r->plan.end, false);
    if (good && !walker.done)
        good = walker.at[0] == raster->count[0]; /* the text has only one slice */
    raster->at[2][0] = walker.slow;
    int64_t all = r->plan.last_slow - walker.slow;
    if (good && walker.done && all != 0) {
        int64_t step = walker.second_slow - walker.slow;
        int64_t steps = (all < 0) == (step < 0) && step != 0
                            ? ost_rhe_div(all < 0 ? -all : all, step < 0 ? -step : step)
                            : 0;
        good = steps >= 1 && steps < OST_DIM_MAX;
        raster->count[2] = good ? (int32_t)steps + 1 : 1;
    } else if (good) {
        good = !walker.done;
    }
    for (int a = 0; a < 3; a++)
        r->units[a] |= walker.units[a];
    ost_text_walker_close(&walker);
    return good;
}

static bool learn(reading *r, bool *terminated)
{
    char *head = malloc(HEAD);
    r->plan.columns = calloc(OST_DIM_MAX, sizeof *r->plan.columns);
    r->plan.lengths = calloc(OST_DIM_MAX, 1);
    r->plan.middles = calloc(OST_DIM_MAX, sizeof *r->plan.middles);
    r->plan.middle_lengths = calloc(OST_DIM_MAX, 1);
    bool good = head && r->plan.columns && r->plan.lengths && r->plan.middles && r->plan.middle_lengths;
    for (int i = 0; i < 3; i++) {
        r->raster->at[i] = calloc(OST_DIM_MAX, sizeof *r->raster->at[i]);
        good = good && r->raster->at[i];
    }
    r->plan.fast = true;
    r->plan.shortest = OST_TEXT_COLUMN_MAX;
    ssize_t bytes = good ? pread(r->plan.fd, head, HEAD, 0) : 0;
    good = bytes > 0 && learn_row(r, head, (size_t)bytes) && learn_last(r, terminated) && learn_slice(r);
    free(head);
    return good;
}

/* -------------------------------------------------------------------- walking */

static bool map_voxels(ost_text_raster *raster, int64_t count)
{
    raster->voxel_bytes = (size_t)count * sizeof *raster->voxels;
    void *map = mmap(NULL, raster->voxel_bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (map == MAP_FAILED)
        return false;
    ost_request_huge_pages(map, raster->voxel_bytes);
    raster->voxels = map;
    return true;
}

/* The result of processing a piece. `placed` is false if no line begins in the piece. */
typedef struct piece {
    int64_t first, next;
    int32_t slice;
    ost_pm slow;
    bool placed;
} piece;

/*
 * Returns true if the lines of all pieces together contain every voxel exactly once and in order, and the coordinates
 * are strictly monotone.
 */
static bool is_tiled(const ost_text_raster *raster, const piece *pieces, int count, int64_t voxels)
{
    int64_t next = 0;
    for (int i = 0; i < count; i++) {
        if (!pieces[i].placed)
            continue;
        if (pieces[i].first != next || pieces[i].slow != raster->at[2][pieces[i].slice])
            return false;
        next = pieces[i].next;
    }
    const ost_pm *at = raster->at[2];
    for (int32_t k = 1; k < raster->count[2]; k++)
        if (at[1] > at[0] ? at[k] <= at[k - 1] : at[k] >= at[k - 1])
            return false;
    return next == voxels;
}

typedef struct shared {
    atomic_bool stop;
    atomic_llong walked; /* number of bytes processed so far */
    bool cancelled;      /* set by thread 0 */
} shared;

static void walk_piece(reading *r, ost_text_walker *walker, int64_t begin, int64_t end, shared *s, piece *out)
{
    walker->placed = walker->known = false;
    walker->first = walker->next = 0;
    walker->at[0] = walker->at[1] = walker->at[2] = 0;
    if (!ost_text_walk(walker, begin, end, begin != r->plan.begin))
        atomic_store_explicit(&s->stop, true, memory_order_relaxed);
    *out = (piece){walker->first, walker->next, walker->first_slow_index, walker->first_slow, walker->placed};
    atomic_fetch_add_explicit(&s->walked, end - begin, memory_order_relaxed);
}

/* Reports progress. Called only on thread 0, which is the caller's own thread. */
static void report_progress(const reading *r, shared *s)
{
#if defined _OPENMP
    if (omp_get_thread_num() != 0)
        return;
#endif
    double share = (double)atomic_load(&s->walked) / (double)(r->plan.end - r->plan.begin);
    if (r->options->progress && !s->cancelled &&
        !r->options->progress(r->options->user, "samples", share < 1 ? share : 1)) {
        s->cancelled = true;
        atomic_store(&s->stop, true);
    }
}

static int thread_count(int requested)
{
#if defined _OPENMP
    return requested > 0 ? requested : omp_get_max_threads();
#else
    (void)requested;
    return 1;
#endif
}

/* Processes the complete file with all threads. Returns true if the file is a raster scan. */
static bool walk_all(reading *r, int64_t voxels, bool *cancelled)
{
    const int64_t bytes = r->plan.end - r->plan.begin;
    int threads = thread_count(r->options->threads);
    int64_t each = bytes / (threads * PIECES_A_THREAD) + 1;
    each = each < PIECE_MIN ? PIECE_MIN : each;
    each = bytes / each >= PIECES_MAX ? bytes / PIECES_MAX + 1 : each;
    int count = (int)((bytes + each - 1) / each);
    threads = threads < count ? threads : count;
    piece *pieces = calloc((size_t)count, sizeof *pieces);
    shared s = {.stop = pieces == NULL};
#pragma omp parallel num_threads(threads)
    {
        ost_text_walker walker;
        bool open = ost_text_walker_open(&walker, &r->plan, false);
        if (!open)
            atomic_store(&s.stop, true);
#pragma omp for schedule(dynamic, 1) nowait
        for (int i = 0; i < count; i++) {
            if (atomic_load_explicit(&s.stop, memory_order_relaxed) || !open)
                continue;
            int64_t begin = r->plan.begin + i * each, end = begin + each < r->plan.end ? begin + each : r->plan.end;
            walk_piece(r, &walker, begin, end, &s, &pieces[i]);
            report_progress(r, &s);
        }
#pragma omp critical
        for (int a = 0; a < 3; a++)
            r->units[a] |= walker.units[a];
        ost_text_walker_close(&walker);
    }
    *cancelled = s.cancelled;
    bool good = !atomic_load(&s.stop) && is_tiled(r->raster, pieces, count, voxels);
    free(pieces);
    return good;
}

/* -------------------------------------------------------------------- summary */

/*
 * Fills the summary with the values that the first of two passes would find: the extent, the units, and the distinct
 * coordinates in ascending order, each with the line in which it occurs first.
 */
static bool summarise(reading *r, int64_t voxels)
{
    const ost_text_raster *raster = r->raster;
    for (int rank = 0; rank < 3; rank++) {
        ost_text_axis *axis = &r->summary->axis[raster->axis[rank]];
        size_t count = (size_t)raster->count[rank];
        const ost_pm *at = raster->at[rank];
        bool down = at[count - 1] < at[0];
        axis->min = down ? at[count - 1] : at[0];
        axis->max = down ? at[0] : at[count - 1];
        axis->units = r->units[raster->axis[rank]];
        axis->set = calloc(count, sizeof *axis->set);
        if (!axis->set)
            return false;
        if (axis->given != 0)
            continue;
        axis->distinct = count;
        for (size_t i = 0; i < count; i++) {
            size_t from = down ? count - 1 - i : i;
            axis->set[i] = (ost_text_coordinate){at[from], raster->first_line +
                                                               (int64_t)from * ost_text_raster_stride(raster, rank)};
        }
    }
    r->summary->fingerprint.rows = (uint64_t)voxels;
    return true;
}

/* ----------------------------------------------------------------- the reader */

void ost_text_raster_free(ost_text_raster *raster)
{
    for (int i = 0; i < 3; i++)
        free(raster->at[i]);
    if (raster->voxels)
        munmap(raster->voxels, raster->voxel_bytes);
    *raster = (ost_text_raster){0};
}

/*
 * Returns false if the text states its dims and is incomplete. A complete text has one sample per voxel, and its last
 * line ends with a newline.
 */
static bool is_complete(const ost_text_summary *summary, int64_t voxels, bool terminated)
{
    const ost_text_own *dims = &summary->own_dims;
    return dims->line == 0 || (terminated && dims->value[0] * dims->value[1] * dims->value[2] == voxels);
}

/*
 * Returns true if reading in two passes would succeed, that is, if the geometry is valid and every sample has a voxel
 * of its own.
 */
static bool is_sound(const reading *r)
{
    ost_geometry full;
    bool inferred[3];
    if (ost_text_geometry(r->plan.path, r->summary, &full, inferred, NULL) != OST_OK)
        return false;
    return ost_text_raster_fits(r->raster, &full);
}

ost_status ost_text_raster_read(const char *path, const ost_text_raster_options *options, ost_text_summary *summary,
                                ost_text_raster *raster, bool *found, ost_error *err)
{
    ost_file file;
    bool terminated = false, cancelled = false;
    ost_isa isa;
    *found = false;
    *raster = (ost_text_raster){0};
    ost_text_summary_begin(summary, options->given);
    reading r = {.options = options, .plan = {.path = path, .raster = raster}, .summary = summary, .raster = raster};
    if (ost_isa_choose(NULL, &isa, NULL) != OST_OK)
        isa = OST_ISA_SCALAR;
    r.plan.match = ost_text_match_for(isa);
    ost_status status = ost_file_open(path, &file, err);
    if (status != OST_OK)
        return status;
    r.plan.fd = file.fd;
    r.plan.end = file.size;
    bool good = file.size > 0 && learn(&r, &terminated);
    if (good) {
        int64_t voxels = (int64_t)raster->count[0] * raster->count[1] * raster->count[2];
        good = voxels <= (r.plan.end - r.plan.begin + 1) / LINE_MIN && is_complete(summary, voxels, terminated) &&
               map_voxels(raster, voxels) && walk_all(&r, voxels, &cancelled) && summarise(&r, voxels) && is_sound(&r);
    }
    close(r.plan.fd);
    free(r.plan.columns);
    free(r.plan.lengths);
    free(r.plan.middles);
    free(r.plan.middle_lengths);
    if (good) {
        *found = true;
        return OST_OK;
    }
    ost_text_summary_free(summary);
    ost_text_raster_free(raster);
    return cancelled ? ost_fail(err, OST_ERR_CANCELLED, "%s: reading was cancelled", path) : OST_OK;
}

ost_status ost_text_raster_hash(const ost_text_raster *raster, ost_hasher *hasher, ost_error *err)
{
    enum { BATCH = 2048 };
    struct {
        int64_t position[3];
        int32_t density;
        uint32_t zero;
    } records[BATCH] = {0};
    _Static_assert(sizeof records == BATCH * 32, "a record has 32 bytes");
    const int16_t *density = raster->voxels;
    size_t filled = 0;
    ost_status status = OST_OK;
    for (int32_t k = 0; k < raster->count[2]; k++)
        for (int32_t j = 0; j < raster->count[1]; j++)
            for (int32_t i = 0; i < raster->count[0] && status == OST_OK; i++) {
                records[filled].position[raster->axis[0]] = raster->at[0][i];
                records[filled].position[raster->axis[1]] = raster->at[1][j];
                records[filled].position[raster->axis[2]] = raster->at[2][k];
                records[filled++].density = *density++;
                if (filled == BATCH) {
                    status = ost_hasher_add(hasher, records, sizeof records, err);
                    filled = 0;
                }
            }
    return status == OST_OK ? ost_hasher_add(hasher, records, filled * sizeof records[0], err) : status;
}
