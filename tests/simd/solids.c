/* SPDX-License-Identifier: Apache-2.0 */
#include "simd/solids.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef enum form { BALL, HALF_SHELL, PLATE_X, PLATE_Z, NOISE, FULL, EMPTY, ONE, FORMS } form;

static const char *const form_names[] = {"ball",  "half shell", "plate across x", "plate across z",
                                         "noise", "full",       "empty",          "one voxel"};

/* Returns the square of twice the distance of the voxel `at` from the centre of the grid. */
static int64_t distance(const int32_t d[3], const int32_t at[3])
{
    int64_t sum = 0;
    for (int a = 0; a < 3; a++) {
        const int64_t c = 2 * at[a] + 1 - d[a];
        sum += c * c;
    }
    return sum;
}

static bool is_solid(form f, test_rng *rng, const int32_t d[3], const int32_t at[3])
{
    const int64_t least = d[0] < d[1] ? d[0] : d[1];
    switch (f) {
    case BALL:
        return distance(d, at) <= least * least;
    case HALF_SHELL:
        return 2 * at[2] < d[2] && distance(d, at) <= least * least && distance(d, at) > (least - 4) * (least - 4);
    case PLATE_X:
        return at[0] == d[0] / 2;
    case PLATE_Z:
        return at[2] == d[2] / 2;
    case NOISE:
        return rng_range(rng, 0, 1) == 0;
    case ONE:
        return at[0] == d[0] - 1 && at[1] == d[1] / 2 && at[2] == d[2] - 1;
    case FULL:
        return true;
    case EMPTY:
    case FORMS:
        break;
    }
    return false;
}

/* Sizes of bone voxels in units of 2^-20 tool voxels. They cover all steps of windows and all sizes of granules
   (shape.h). */
static const int32_t ratios[] = {65536,   300000,  493000,  524288,  524289,  985000,  986000,   1000000,
                                 1048576, 1048577, 1113000, 1209000, 1211000, 1300000, 1412000,  1413000,
                                 1600000, 1971323, 2017000, 2019000, 2097152, 2097153, 2228224,  2623000,
                                 2624000, 2825000, 2826000, 3026000, 3028000, 4194304, 5000000,  8388608,
                                 8388609, 12345678, 16777216};

/*
 * Sets `step` to the columns of a rotation matrix, multiplied by `ratio` and rounded. The rotation is arbitrary
 * or composed of quarter turns.
 */
static void make_steps(test_rng *rng, int32_t ratio, int32_t step[3][3])
{
    double q[4], n = 0;
    static const double quarters[][4] = {{1, 0, 0, 0}, {1, 1, 0, 0}, {1, 0, -1, 0}, {0, 0, 0, 1}, {1, 1, 1, 1}};
    const bool any = rng_range(rng, 0, 2) > 0;
    const int quarter = (int)rng_range(rng, 0, 4);
    for (int i = 0; i < 4; i++) {
        q[i] = any ? (double)rng_range(rng, -1000000, 1000000) : quarters[quarter][i];
        n += q[i] * q[i];
    }
    if (n == 0)
        q[0] = n = 1;
    const double w = q[0], x = q[1], y = q[2], z = q[3];
    const double turn[3][3] = {{w * w + x * x - y * y - z * z, 2 * (x * y + w * z), 2 * (x * z - w * y)},
                               {2 * (x * y - w * z), w * w - x * x + y * y - z * z, 2 * (y * z + w * x)},
                               {2 * (x * z + w * y), 2 * (y * z - w * x), w * w - x * x - y * y + z * z}};
    for (int i = 0; i < 3; i++)
        for (int a = 0; a < 3; a++) {
            const double v = turn[i][a] / n * (double)ratio;
            step[i][a] = (int32_t)(v < 0 ? v - 0.5 : v + 0.5);
        }
}

/* The last shape that was made. It is reused because making a shape takes much longer than a case. */
static struct kept {
    uint64_t key;
    bool made;
    ost_shape shape;
    uint64_t *bits;
    int32_t ratio;
    form form;
} kept;

static void make_shape(uint64_t key, test_rng *rng)
{
    if (kept.made) {
        ost_shape_free(&kept.shape);
        free(kept.bits);
    }
    kept = (struct kept){.key = key, .made = true, .form = (form)rng_range(rng, 0, FORMS - 1)};
    kept.ratio = ratios[rng_range(rng, 0, sizeof ratios / sizeof ratios[0] - 1)];
    const int32_t most = kept.ratio > 4000000 ? 64 : 24;
    int32_t d[3];
    for (int a = 0; a < 3; a++)
        d[a] = rng_range(rng, 0, 4) == 0 ? (int32_t)rng_range(rng, 1, 4) : (int32_t)rng_range(rng, 1, most);
    const size_t words = (size_t)(d[0] + 63) / 64 + (size_t)rng_range(rng, 0, 1);
    kept.bits = calloc(words * (size_t)d[1] * (size_t)d[2], sizeof *kept.bits);
    if (!kept.bits)
        exit(99);
    uint64_t *row = kept.bits;
    for (int32_t z = 0; z < d[2]; z++)
        for (int32_t y = 0; y < d[1]; y++, row += words)
            for (int32_t x = 0; x < d[0]; x++)
                row[x / 64] |= (uint64_t)is_solid(kept.form, rng, d, (int32_t[3]){x, y, z}) << (x % 64);
    ost_error err = {0};
    if (ost_shape_make(kept.bits, words, (ost_dims){d[0], d[1], d[2]}, kept.ratio, &kept.shape, &err) != OST_OK) {
        fprintf(stderr, "checksimd: %s\n", err.text);
        exit(99);
    }
}

static size_t product(const int32_t d[3])
{
    return (size_t)d[0] * (size_t)d[1] * (size_t)d[2];
}

static void *copy(check *c, const char *name, const void *from, size_t count, size_t size, size_t align)
{
    void *to = check_input(c, name, count, size, align);
    memcpy(to, from, count * size);
    return to;
}

static void copy_windows(check *c, ost_windows *w, size_t lines_each)
{
    if (w->step == 0)
        return;
    const size_t windows = product(w->dims);
    size_t lines = 0;
    for (size_t i = 0; i < windows; i++)
        lines = w->index[i] + lines_each > lines ? w->index[i] + lines_each : lines;
    w->index = copy(c, "windows.index", w->index, windows, sizeof *w->index, 4);
    w->line = (const uint8_t(*)[64])copy(c, "windows.line", w->line, lines, 64, 64);
}

void solid_make(check *c, solid *out)
{
    test_rng rng = {c->seed + (uint64_t)(c->number / 8)};
    if (!kept.made || kept.key != rng.state)
        make_shape(rng.state, &rng);
    ost_shape *s = &out->shape;
    *s = kept.shape;
    memset(s->memory, 0, sizeof s->memory); /* kept.shape owns the memory */
    s->bits = copy(c, "shape->bits", kept.bits, s->words * (size_t)s->dims[1] * (size_t)s->dims[2], 8, 8);
    s->cells.value = (const int8_t *)copy(c, "cells->value", s->cells.value - 64, product(s->cells.dims) + 128, 1, 1) +
                     64;
    copy_windows(c, &s->windows, 1);
    copy_windows(c, &s->wide, OST_WIDE_LINES);
    make_steps(&c->rng, kept.ratio, out->step);
    snprintf(out->text, sizeof out->text, "%s of %d x %d x %d, ratio %d", form_names[kept.form], s->dims[0], s->dims[1],
             s->dims[2], kept.ratio);
}

void solid_cells(check *c, ost_cells *out)
{
    *out = (ost_cells){.margin = (int32_t)check_range(c, 0, 16), .shift = (int32_t)check_range(c, 20, 25)};
    out->unit = 1 << check_range(c, 17, 21);
    for (int a = 0; a < 3; a++)
        out->dims[a] = (int32_t)check_range(c, 1, 14);
    const size_t count = product(out->dims);
    int8_t *value = check_input(c, "cells->value", count + 128, 1, 1);
    const int64_t widest = check_chance(c, 2) ? 64 : check_range(c, 0, 64);
    for (size_t i = 0; i < count; i++)
        value[64 + i] = (int8_t)(check_chance(c, 4) ? (check_chance(c, 2) ? widest : -widest)
                                                    : check_range(c, -widest, widest));
    out->value = value + 64;
}
