/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Compares the reader that reads a scan in one pass with the reader that reads any text in two passes.
 * Random changes are made to the texts. Summary, digest, geometry, grid, report and every error must be
 * equal.
 *
 * The file has more than 500 lines, because every test generates its texts and compares the readers with the same
 * functions.
 *
 * Covers: AR-CT-1, AR-CT-2, AR-CT-3, AR-CT-4, AR-CT-5, AR-CT-6, AR-DIG-6
 */
#include "backends.h"

#include "io/text/match.h"
#include "io/text/raster.h"
#include "io_scratch.h"

static char *folder;

static int make_folder(void **state)
{
    (void)state;
    folder = scratch_folder();
    return 0;
}

static int remove_folder(void **state)
{
    (void)state;
    unsetenv("OSTEON_ISA");
    scratch_remove(folder);
    return 0;
}

/* ------------------------------------------------------------- generated texts */

typedef struct text {
    char *bytes;
    size_t size, capacity;
    size_t *line; /* offset of each sample's line, in file order */
    int lines;
} text;

OST_PRINTF(2, 3)
static void put(text *t, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    int n = vsnprintf(t->bytes + t->size, t->capacity - t->size, format, args);
    va_end(args);
    assert_true(n >= 0 && (size_t)n < t->capacity - t->size);
    t->size += (size_t)n;
}

typedef struct recipe {
    int dims[3];
    int order[3];       /* axes from the fastest to the slowest one */
    int step[3];        /* step along each axis in 10^-places mm; negative if positions descend */
    /* number of thirds of 10^-places mm that are added to step; positions are rounded when they are written */
    int thirds[3];
    int64_t start[3];
    int places;
    const char *separator, *ending, *head;
    bool widths;        /* true if densities and positions are padded to a fixed width */
    bool trimmed;       /* true if positions have no trailing zeros, so that their lengths and columns differ */
    bool last_newline;
} recipe;

static void put_position(text *t, int64_t units, int places, const recipe *r)
{
    int64_t one = 1, magnitude = units < 0 ? -units : units;
    for (int i = 0; i < places; i++)
        one *= 10;
    char number[64];
    int n = snprintf(number, sizeof number, "%s%lld%s", units < 0 ? "-" : "", (long long)(magnitude / one),
                     places > 0 ? "." : "");
    for (int i = 0; i < places; i++) {
        magnitude %= one;
        one /= 10;
        number[n++] = (char)('0' + magnitude / one);
    }
    while (r->trimmed && n > 0 && number[n - 1] == '0')
        n--;
    if (r->trimmed && n > 0 && number[n - 1] == '.')
        n--;
    number[n] = 0;
    put(t, r->widths ? "%12s" : "%s", number);
}

static text make(const recipe *r, test_rng *rng)
{
    int count = r->dims[0] * r->dims[1] * r->dims[2];
    text t = {.capacity = (size_t)count * 80 + 4096, .lines = 0};
    t.bytes = malloc(t.capacity);
    t.line = malloc((size_t)count * sizeof *t.line);
    assert_non_null(t.bytes);
    assert_non_null(t.line);
    put(&t, "%s", r->head);
    int at[3];
    for (at[2] = 0; at[2] < r->dims[r->order[2]]; at[2]++)
        for (at[1] = 0; at[1] < r->dims[r->order[1]]; at[1]++)
            for (at[0] = 0; at[0] < r->dims[r->order[0]]; at[0]++) {
                t.line[t.lines++] = t.size;
                int64_t value[3];
                for (int rank = 0; rank < 3; rank++) {
                    int a = r->order[rank];
                    value[a] = r->start[a] + (int64_t)at[rank] * r->step[a] + (at[rank] * r->thirds[a] + 1) / 3;
                }
                for (int a = 0; a < 3; a++) {
                    put_position(&t, value[a], r->places, r);
                    put(&t, "%s", r->separator);
                }
                int density = (int)(rng_range(rng, 0, 30) == 0 ? rng_range(rng, INT16_MIN, INT16_MAX)
                                                               : rng_range(rng, -1024, 3071));
                put(&t, r->widths ? "%6d" : "%d", density);
                put(&t, "%s", r->ending);
            }
    if (!r->last_newline)
        t.size -= strlen(r->ending);
    return t;
}

static void unmake(text *t)
{
    free(t->bytes);
    free(t->line);
}

/* Replaces the bytes [at, at + length) by `with`. */
static void replace(text *t, size_t at, size_t length, const char *with)
{
    size_t n = strlen(with);
    assert_true(at + length <= t->size && t->size + n < t->capacity);
    memmove(t->bytes + at + n, t->bytes + at + length, t->size - at - length);
    memcpy(t->bytes + at, with, n);
    t->size += n - length;
}

/* --------------------------------------------------- reading in two passes and in one */

typedef struct outcome {
    ost_status status;
    ost_error err;
    ost_text_summary summary;
    ost_digest digest;
    ost_geometry full, rect;
    bool inferred[3];
    ost_scatter_report report;
    int16_t *voxels;
} outcome;

static void outcome_free(outcome *o)
{
    ost_text_summary_free(&o->summary);
    free(o->voxels);
}

static void finish(outcome *o, ost_grid *rect)
{
    if (o->status == OST_OK) {
        o->voxels = malloc((size_t)ost_dims_count(o->rect.dims) * sizeof *o->voxels);
        assert_non_null(o->voxels);
        o->status = ost_grid_download(rect, 0, o->rect.dims.z, o->voxels, &o->err);
    }
    ost_grid_free(rect);
}

static void crop_to(outcome *o, const ost_voxel_box *crop)
{
    o->rect = o->full;
    if (!crop)
        return;
    o->rect.origin.x += crop->lo[0] * o->full.spacing.x;
    o->rect.origin.y += crop->lo[1] * o->full.spacing.y;
    o->rect.origin.z += crop->lo[2] * o->full.spacing.z;
    o->rect.dims = (ost_dims){crop->hi[0] - crop->lo[0], crop->hi[1] - crop->lo[1], crop->hi[2] - crop->lo[2]};
}

/* Imports the text in two passes. If crop->lo[0] < 0, the complete grid is read. If not, `crop` is the part of the grid
   to read. */
static outcome two_passes(ost_backend *backend, const char *path, ost_pm3 given, const ost_voxel_box *crop)
{
    outcome o = {.status = OST_OK};
    ost_text_source source;
    ost_grid *rect = NULL;
    ost_hasher *hasher;
    assert_int_equal(ost_hasher_open(&hasher, NULL), OST_OK);
    o.status = ost_text_source_open(&source, path, &o.err);
    if (o.status == OST_OK)
        o.status = ost_text_scan(&source, given, hasher, NULL, NULL, &o.summary, &o.err);
    assert_int_equal(ost_hasher_close(hasher, &o.digest, NULL), OST_OK);
    if (o.status == OST_OK)
        o.status = ost_text_geometry(path, &o.summary, &o.full, o.inferred, &o.err);
    if (o.status == OST_OK) {
        crop_to(&o, crop);
        o.status = ost_grid_create(backend, &o.rect, &rect, &o.err);
    }
    if (o.status == OST_OK) {
        const ost_text_rect_options options = {.full = &o.full, .crop = crop, .expected = o.summary.fingerprint};
        o.status = ost_text_to_rect(&source, &options, rect, &o.report, &o.err);
    }
    finish(&o, rect);
    ost_text_source_close(&source);
    return o;
}

static outcome one_pass(ost_backend *backend, const char *path, ost_pm3 given, const ost_voxel_box *crop, int threads,
                        bool *found)
{
    outcome o = {.status = OST_OK};
    ost_text_raster raster;
    ost_hasher *hasher;
    const ost_text_raster_options options = {.given = given, .threads = threads};
    assert_int_equal(ost_text_raster_read(path, &options, &o.summary, &raster, found, &o.err), OST_OK);
    if (!*found)
        return o;
    assert_int_equal(ost_hasher_open(&hasher, NULL), OST_OK);
    assert_int_equal(ost_text_raster_hash(&raster, hasher, NULL), OST_OK);
    assert_int_equal(ost_hasher_close(hasher, &o.digest, NULL), OST_OK);
    ost_grid *rect = NULL;
    o.status = ost_text_geometry(path, &o.summary, &o.full, o.inferred, &o.err);
    crop_to(&o, crop);
    if (o.status == OST_OK)
        o.status = ost_grid_create(backend, &o.rect, &rect, &o.err);
    if (o.status == OST_OK) {
        const ost_text_rect_options rect_options = {.full = &o.full, .crop = crop};
        o.status = ost_text_raster_to_rect(path, &raster, &rect_options, rect, &o.report, &o.err);
    }
    finish(&o, rect);
    ost_text_raster_free(&raster);
    return o;
}

static void assert_same(const outcome *a, const outcome *b)
{
    assert_int_equal(a->status, OST_OK);
    assert_int_equal(b->status, OST_OK);
    for (int i = 0; i < 3; i++) {
        const ost_text_axis *x = &a->summary.axis[i], *y = &b->summary.axis[i];
        assert_true(x->min == y->min && x->max == y->max && x->given == y->given);
        assert_int_equal(x->units, y->units);
        assert_int_equal(x->rounded, y->rounded);
        assert_int_equal(x->distinct, y->distinct);
        for (size_t k = 0; k < x->distinct; k++)
            assert_true(x->set[k].value == y->set[k].value && x->set[k].line == y->set[k].line);
        assert_int_equal(a->inferred[i], b->inferred[i]);
    }
    assert_int_equal(a->summary.fingerprint.rows, b->summary.fingerprint.rows);
    assert_int_equal(a->summary.rounded_positions, b->summary.rounded_positions);
    assert_int_equal(a->summary.meta.count, b->summary.meta.count);
    assert_memory_equal(&a->digest, &b->digest, sizeof a->digest);
    assert_true(ost_geometry_equal(&a->full, &b->full));
    assert_int_equal(a->report.samples, b->report.samples);
    assert_int_equal(a->report.duplicates, b->report.duplicates);
    assert_int_equal(a->report.off_lattice, b->report.off_lattice);
    assert_int_equal(a->report.worst_offset_ppm, b->report.worst_offset_ppm);
    assert_int_equal(a->report.worst_line, b->report.worst_line);
    assert_int_equal(a->report.rejected_line, b->report.rejected_line);
    assert_int_equal(a->report.conflict_line, b->report.conflict_line);
    assert_memory_equal(a->voxels, b->voxels, (size_t)ost_dims_count(a->rect.dims) * sizeof *a->voxels);
}

static unsigned turn;

/* Advances to the next combination of instruction set and number of threads. Sets OSTEON_ISA to the instruction set and
   returns the number of threads. */
static int next_turn(void)
{
    static const int threads[] = {1, 2, 3, 7};
    ost_isa isa;
    do
        isa = (ost_isa)(turn / 4 % OST_ISA_COUNT);
    while (!ost_isa_available(isa) && (turn += 4));
    setenv("OSTEON_ISA", ost_isa_name(isa), 1);
    return threads[turn++ % 4];
}

/*
 * Reads the text in one pass and in two passes, compares the results, and imports the text. If reading in
 * two passes fails, the import must return the same error. Returns true if the text was accepted as a scan.
 */
static bool compare(ost_backend *backend, const text *t, ost_pm3 given, test_rng *rng)
{
    const char *path = scratch_write(folder, "ct.txt", t->bytes, t->size);
    outcome slow = two_passes(backend, path, given, NULL);
    bool found;
    int threads = next_turn();
    outcome fast = one_pass(backend, path, given, NULL, threads, &found);
    if (found)
        assert_same(&slow, &fast);
    outcome_free(&fast);
    if (found && rng) {
        const int32_t dims[3] = {slow.full.dims.x, slow.full.dims.y, slow.full.dims.z};
        ost_voxel_box crop;
        for (int a = 0; a < 3; a++) {
            crop.lo[a] = (int32_t)rng_range(rng, 0, dims[a] - 1);
            crop.hi[a] = (int32_t)rng_range(rng, crop.lo[a] + 1, dims[a]);
        }
        outcome part = two_passes(backend, path, given, &crop);
        fast = one_pass(backend, path, given, &crop, threads, &found);
        assert_true(found);
        assert_same(&part, &fast);
        outcome_free(&part);
        outcome_free(&fast);
    }
    ost_import_options options = {.spacing = given, .threads = threads};
    ost_bone *bone = NULL;
    ost_error err = {0};
    ost_status status = ost_import(backend, path, &options, &bone, NULL, &err);
    if (slow.status != OST_OK && (status != slow.status || strcmp(err.text, slow.err.text) != 0))
        fail_msg("reading in two passes reports '%s'; the import reports '%s'", slow.err.text, err.text);
    ost_bone_free(bone);
    outcome_free(&slow);
    return found;
}

/* ---------------------------------------------------------------------- tests */

static recipe random_recipe(test_rng *rng, bool large)
{
    static const int orders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    static const char *const separators[] = {" ", " ", "\t", ",", " ; ", "  "};
    static const char *const heads[] = {"", "", "x y z density\n", "# made by a test\n\n# osteon side: left\n",
                                        "\xef\xbb\xbf# first\r\nX,Y,Z,HU\r\n"};
    recipe r = {
        .places = (int)rng_range(rng, 1, 4), /* the smallest step is 4 um */
        .separator = separators[rng_range(rng, 0, 5)],
        .ending = rng_range(rng, 0, 3) ? "\n" : "\r\n",
        .head = heads[rng_range(rng, 0, 4)],
        .widths = rng_range(rng, 0, 7) == 0,
        .trimmed = rng_range(rng, 0, 3) == 0,
        .last_newline = rng_range(rng, 0, 3) != 0,
    };
    memcpy(r.order, orders[rng_range(rng, 0, 1) ? 0 : rng_range(rng, 0, 5)], sizeof r.order);
    for (int a = 0; a < 3; a++) {
        r.dims[a] = (int)rng_range(rng, 2, large ? 50 : 12);
        r.step[a] = (int)rng_range(rng, 40, 60) * (rng_range(rng, 0, 3) ? 1 : -1);
        r.thirds[a] = rng_range(rng, 0, 2) ? 0 : 1;
        r.start[a] = rng_range(rng, -5000, 5000);
    }
    return r;
}

static void scans_are_read_in_one_pass(void **state)
{
    test_rng rng = rng_seeded("scans");
    int found = 0, plain = 0;
    for (int round = 0; round < test_rounds(120); round++) {
        recipe r = random_recipe(&rng, round % 12 == 0);
        if (round % 4 == 0)
            memset(r.thirds, 0, sizeof r.thirds);
        text t = make(&r, &rng);
        const ost_pm mm = OST_PM_PER_MM;
        ost_pm unit = mm;
        for (int i = 0; i < r.places; i++)
            unit /= 10;
        bool given = round % 3 == 0;
        ost_pm3 spacing = {0, 0, 0};
        if (given)
            spacing = (ost_pm3){(r.step[0] < 0 ? -r.step[0] : r.step[0]) * unit, 0, 0};
        bool is = compare(*state, &t, spacing, &rng);
        found += is;
        /* A text in which every step is an integer must always be accepted as a scan. */
        if (!r.thirds[0] && !r.thirds[1] && !r.thirds[2]) {
            plain++;
            if (!is)
                fail_msg("round %d: the text is a scan but was not accepted as one", round);
        }
        unmake(&t);
    }
    assert_true(plain >= 10 && found >= plain / 2);
}

static void changed_scans_equal_two_pass_reading(void **state)
{
    test_rng rng = rng_seeded("broken scans");
    static const char *const densities[] = {"32768", "-32769", "+5",     "7.0", "7.5",      "1e2", "",         "-",
                                            "--3",   "12a",    "000012", "-0",  "99999999", "1 2", "5 # five", " 5"};
    for (int round = 0; round < test_rounds(260); round++) {
        recipe r = random_recipe(&rng, round % 40 == 0);
        r.widths = false;
        text t = make(&r, &rng);
        int n = (int)rng_range(&rng, 0, t.lines - 1);
        size_t at = t.line[n], end = n + 1 < t.lines ? t.line[n + 1] : t.size, length = end - at;
        char line[128] = "";
        memcpy(line, t.bytes + at, length < sizeof line - 1 ? length : sizeof line - 1);
        switch (round % 13) {
        case 0: /* remove a line */
            replace(&t, at, length, "");
            break;
        case 1: /* duplicate a line */
            replace(&t, at, 0, n + 1 < t.lines ? line : "1 2 3 4\n");
            break;
        case 2: /* change the density */
        case 3: {
            size_t sign = strlen(r.separator), begin = end - strlen(r.ending) * (n + 1 < t.lines || r.last_newline);
            size_t last = begin;
            while (begin > at && memcmp(t.bytes + begin - sign, r.separator, sign) != 0)
                begin--;
            replace(&t, begin, last - begin, densities[rng_range(&rng, 0, 15)]);
            break;
        }
        case 4: /* change one byte of the line */
            t.bytes[at + (size_t)rng_range(&rng, 0, (int64_t)length - 1)] =
                "0123456789.-+ ,e#x\n"[rng_range(&rng, 0, 18)];
            break;
        case 5: /* insert a comment, a fact or an empty line */
            replace(&t, at, 0,
                    round / 13 % 3 == 0   ? "# here\n"
                    : round / 13 % 3 == 1 ? "# osteon spacing_mm: 1 1 1\n"
                                          : "\n");
            break;
        case 6: /* truncate the text at any position */
            t.size = at + (size_t)rng_range(&rng, 0, (int64_t)length - 1);
            break;
        case 7: /* write the number in a different but equivalent form */
            replace(&t, at, 0, "+");
            if (t.bytes[at + 1] == '-')
                replace(&t, at, 2, "-0");
            break;
        case 8: /* insert a space before or after the line */
            replace(&t, rng_range(&rng, 0, 1) ? at : end - strlen(r.ending) * (n + 1 < t.lines || r.last_newline), 0,
                    " ");
            break;
        case 9: { /* exchange two neighbouring lines */
            if (n + 2 < t.lines) {
                size_t second = t.line[n + 2] - t.line[n + 1];
                char both[256];
                memcpy(both, t.bytes + t.line[n + 1], second);
                memcpy(both + second, t.bytes + at, length);
                memcpy(t.bytes + at, both, length + second);
            }
            break;
        }
        case 10: /* insert a fact with the number of voxels, right or wrong */
        {
            char fact[128];
            snprintf(fact, sizeof fact, "# osteon dims: %d %d %d\n", r.dims[0], r.dims[1],
                     r.dims[2] + (int)rng_range(&rng, 0, 1));
            replace(&t, 0, 0, fact);
            break;
        }
        case 11: /* append text */
            if (r.last_newline)
                replace(&t, t.size, 0, round / 13 % 2 ? "\n" : "# the end");
            break;
        default: /* insert a zero byte */
            t.bytes[at + (size_t)rng_range(&rng, 0, (int64_t)length - 1)] = 0;
            break;
        }
        (void)compare(*state, &t, (ost_pm3){0, 0, 0}, NULL);
        unmake(&t);
    }
}

/* Tests texts of one row, one column, one slice, a few lines, and no line. */
static void small_texts(void **state)
{
    static const char *const texts[] = {
        "", "\n", "0 0 0 1", "0 0 0 1\n", "0 0 0 1\n1 0 0 2\n", "0 0 0 1\n1 0 0 2\n0 1 0 3\n1 1 0 4\n",
        "0 0 0 1\n1 0 0 2\n0 1 0 3\n1 1 0 4\n0 0 1 5\n1 0 1 6\n0 1 1 7\n1 1 1 8\n", "0 0 0 1\n1 1 0 2\n",
        "0 0 0 1\n1 0 0 2\n0 0 1 3\n1 0 1 4\n", "0 0 0 1\n1 0 0 2\n0 1 1 3\n1 1 1 4\n", "0 0 0 1\n0 0 0 1\n",
        "0 0 0 1\n1 0 0 2\n0 1 0 3\n1 1 0 4\n0 0 1 5\n1 0 1 6\n0 1 1 7\n1 1 1", "# only a comment\n", "x y z d\n",
        "0 0 0 1\n1 0 0 2\n0 1 0 3\n1 1 0 4\n0 0 1 5\n1 0 1 6\n0 1 1 7\n1 1 1 8\n0 0 3 1\n1 0 3 2\n0 1 3 3\n1 1 3 4\n",
    };
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++)
        for (int spaced = 0; spaced < 2; spaced++)
            for (int turns = 0; turns < 4; turns++) {
                text t = {.bytes = strdup(texts[i]), .size = strlen(texts[i])};
                ost_pm mm = spaced ? OST_PM_PER_MM : 0;
                bool found = compare(*state, &t, (ost_pm3){mm, mm, mm}, NULL);
                if (i == 6)
                    assert_true(found);
                free(t.bytes);
            }
}

static bool cancel(void *user, const char *stage, double share)
{
    (void)stage;
    (void)share;
    ++*(int *)user;
    return false;
}

static void reading_can_be_cancelled(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("cancelled");
    recipe r = {.dims = {60, 60, 20},
                .order = {0, 1, 2},
                .step = {50, 50, 50},
                .places = 2,
                .separator = " ",
                .ending = "\n",
                .head = "",
                .last_newline = true};
    text t = make(&r, &rng);
    const char *path = scratch_write(folder, "ct.txt", t.bytes, t.size);
    for (int threads = 1; threads < 4; threads++) {
        ost_error err = {0};
        ost_text_summary summary;
        ost_text_raster raster;
        bool found;
        int calls = 0;
        const ost_text_raster_options options = {.threads = threads, .progress = cancel, .user = &calls};
        ost_status status = ost_text_raster_read(path, &options, &summary, &raster, &found, &err);
        /* A thread without a part of the text does not call the progress function. */
        if (calls > 0) {
            assert_int_equal(calls, 1);
            assert_int_equal(status, OST_ERR_CANCELLED);
            assert_non_null(strstr(err.text, "reading was cancelled"));
        } else {
            ost_text_summary_free(&summary);
            ost_text_raster_free(&raster);
        }
    }
    unmake(&t);
}

/* Compares every SIMD variant of the kernel with the scalar variant. Lines, densities and end must be equal. */
static void variants_equal_the_scalar_kernel(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("text kernels");
    enum { LINES = 40, CAPACITY = 8192 };
    ost_text_match *scalar = ost_text_match_for(OST_ISA_SCALAR);
    char *bytes = malloc(CAPACITY + OST_TEXT_MARGIN);
    assert_non_null(bytes);
    for (int round = 0; round < test_rounds(6000); round++) {
        ost_text_pattern pattern = {.carriage = rng_range(&rng, 0, 1), .shortest = OST_TEXT_COLUMN_MAX};
        ost_text_column columns[LINES] = {{{0}, {0}}};
        uint8_t lengths[LINES];
        ost_text_around *around[2] = {&pattern.before, &pattern.after};
        for (int i = 0; i < 2; i++) {
            around[i]->length = (uint32_t)(i == 0 && rng_range(&rng, 0, 1) ? 0
                                                                           : rng_range(&rng, 1, OST_TEXT_AROUND_MAX));
            for (uint32_t k = 0; k < around[i]->length; k++) {
                around[i]->text[k] = (unsigned char)"0123456789.- "[rng_range(&rng, 0, 12)];
                around[i]->mask[k] = 0xff;
            }
        }
        size_t size = 0, begins[LINES];
        char *text_at = bytes;
        /* The bytes after the end are newlines or digits. A kernel could mistake them for a part of the text. */
        memset(bytes, rng_range(&rng, 0, 1) ? '\n' : '7', CAPACITY + OST_TEXT_MARGIN);
        for (int i = 0; i < LINES; i++) {
            lengths[i] = (uint8_t)rng_range(&rng, 1, OST_TEXT_COLUMN_MAX);
            pattern.shortest = lengths[i] < pattern.shortest ? lengths[i] : pattern.shortest;
            for (int k = 0; k < lengths[i]; k++) {
                columns[i].text[k] = (unsigned char)"0123456789.-"[rng_range(&rng, 0, 11)];
                columns[i].mask[k] = 0xff;
            }
            char density[32];
            snprintf(density, sizeof density, rng_range(&rng, 0, 20) ? "%lld" : "%05lld",
                     (long long)(rng_range(&rng, 0, 9) ? rng_range(&rng, INT16_MIN, INT16_MAX)
                                                       : rng_range(&rng, -200000, 200000)));
            size_t begin = begins[i] = size;
            size += (size_t)snprintf(text_at + size, CAPACITY - size, "%.*s%.*s%.*s%s%s", (int)pattern.before.length,
                                     pattern.before.text, (int)lengths[i], columns[i].text, (int)pattern.after.length,
                                     pattern.after.text, density, pattern.carriage ? "\r" : "");
            if (rng_range(&rng, 0, 15) == 0) /* replaces a byte with a random byte, which may be the same */
                text_at[begin + (size_t)rng_range(&rng, 0, (int64_t)(size - begin) - 1)] =
                    "0159.- /:\r"[rng_range(&rng, 0, 9)];
            if (rng_range(&rng, 0, 30) == 0) /* shortens a line, possibly to length 0 */
                size = begin + (size_t)rng_range(&rng, 0, (int64_t)(size - begin));
            text_at[size++] = '\n';
        }
        /* in some rounds, the text that the kernels receive ends before the last line */
        size_t behind = rng_range(&rng, 0, 3) ? size : begins[rng_range(&rng, 1, LINES - 1)];
        for (int isa = 0; isa < OST_ISA_COUNT; isa++) {
            if (!ost_isa_available((ost_isa)isa))
                continue;
            for (int from = 0; from < LINES; from++) {
                if (begins[from] > behind)
                    break;
                /* The last byte that a kernel may read is the last byte of the allocation. */
                char *copy = malloc(behind + OST_TEXT_MARGIN);
                assert_non_null(copy);
                memcpy(copy, bytes, behind + OST_TEXT_MARGIN);
                int16_t want[LINES + 1], have[LINES + 1];
                size_t most = (size_t)rng_range(&rng, 0, LINES - from);
                const char *want_next, *have_next;
                for (size_t i = 0; i <= most; i++)
                    want[i] = have[i] = 12345;
                size_t good = scalar(&pattern, columns + from, lengths + from, copy + begins[from], copy + behind, most,
                                     want, &want_next);
                assert_int_equal(ost_text_match_for((ost_isa)isa)(&pattern, columns + from, lengths + from,
                                                                  copy + begins[from], copy + behind, most, have,
                                                                  &have_next),
                                 good);
                assert_memory_equal(want, have, (most + 1) * sizeof *want);
                /* elements beyond the densities that a kernel found may belong to another thread, so the kernel must
                   not write to them */
                for (size_t i = good; i <= most; i++)
                    assert_int_equal(have[i], 12345);
                assert_ptr_equal(have_next, want_next);
                assert_true(want_next <= copy + behind && (want_next == copy || want_next[-1] == '\n'));
                free(copy);
            }
        }
    }
    free(bytes);
}

static int open_backend(void **state)
{
    return make_folder(state) || open_test_backend(state);
}

static int close_backend(void **state)
{
    ost_backend_close(*state);
    return remove_folder(state);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(scans_are_read_in_one_pass),
        cmocka_unit_test(changed_scans_equal_two_pass_reading),
        cmocka_unit_test(small_texts),
        cmocka_unit_test(reading_can_be_cancelled),
        cmocka_unit_test(variants_equal_the_scalar_kernel),
    };
    return run_on_backends(tests, open_backend, close_backend);
}
