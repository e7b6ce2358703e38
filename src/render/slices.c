/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Three slices through one voxel, next to each other, in the radiological convention:
 *
 *     axial              coronal            sagittal
 *   R   A   L           R   S   L           A   S   P
 *     x ->                x ->                y ->
 *     y down              z up                z up
 *
 * All three have one scale and square pixels.  Densities are interpolated
 * between voxel centres.  The colour of removed bone is blended in the same way,
 * so a voxel at the border of a cut is visible as a voxel.
 */
#include <stdlib.h>
#include <string.h>

#include <osteon/picture.h>

#include "render/marks.h"
#include "render/points/frame.h"

typedef struct plane {
    int across, down, through; /* axes */
    bool down_is_minus;        /* rows go toward smaller coordinates */
} plane;

static const plane PLANES[3] = {{0, 1, 2, false}, {0, 2, 1, true}, {1, 2, 0, true}};

typedef struct source {
    const ost_volume *now, *before;
    int32_t threshold;
    int n[3];
    double spacing[3];
    double black, white; /* HU */
} source;

static size_t element(const source *s, const int v[3])
{
    return (size_t)v[0] + (size_t)s->n[0] * ((size_t)v[1] + (size_t)s->n[1] * (size_t)v[2]);
}

/*
 * Computes the grey in [0, 1] and the removed share at (a, b) voxels in the plane; returns false
 * outside the grid.
 */
static bool sample(const source *s, const plane *p, int through, double a, double b, double *grey, double *removed)
{
    int na = s->n[p->across], nb = s->n[p->down];
    if (a < -0.5 || b < -0.5 || a > na - 0.5 || b > nb - 0.5)
        return false;
    a = a < 0 ? 0 : a > na - 1 ? na - 1 : a;
    b = b < 0 ? 0 : b > nb - 1 ? nb - 1 : b;
    int i = (int)a, j = (int)b;
    double fa = a - i, fb = b - j;
    *grey = *removed = 0;
    for (int c = 0; c < 4; c++) {
        int v[3];
        v[p->across] = i + (c & 1) < na ? i + (c & 1) : na - 1;
        v[p->down] = j + (c >> 1) < nb ? j + (c >> 1) : nb - 1;
        v[p->through] = through;
        double weight = (c & 1 ? fa : 1 - fa) * (c >> 1 ? fb : 1 - fb);
        size_t at = element(s, v);
        double hu = s->now->voxels[at];
        bool gone = false;
        if (s->before && s->now->voxels[at] < s->threshold && s->before->voxels[at] >= s->threshold) {
            gone = true;
            hu = s->before->voxels[at]; /* the earlier density, visible through the colour */
        }
        double g = (hu - s->black) / (s->white - s->black);
        *grey += weight * (g < 0 ? 0 : g > 1 ? 1 : g);
        *removed += gone ? weight : 0;
    }
    return true;
}

/* Computes the middle of the grid, or of the voxels that were removed. */
static void middle(const source *s, int at[3])
{
    int lo[3] = {s->n[0], s->n[1], s->n[2]}, hi[3] = {-1, -1, -1};
    if (s->before)
        for (int k = 0; k < s->n[2]; k++)
            for (int j = 0; j < s->n[1]; j++)
                for (int i = 0; i < s->n[0]; i++) {
                    int v[3] = {i, j, k};
                    size_t e = element(s, v);
                    if (s->before->voxels[e] < s->threshold || s->now->voxels[e] >= s->threshold)
                        continue;
                    for (int a = 0; a < 3; a++) {
                        lo[a] = v[a] < lo[a] ? v[a] : lo[a];
                        hi[a] = v[a] > hi[a] ? v[a] : hi[a];
                    }
                }
    for (int a = 0; a < 3; a++)
        at[a] = hi[a] >= 0 ? (lo[a] + hi[a]) / 2 : s->n[a] / 2;
}

enum { GAP = 8, OVER = 2 }; /* pixels between panels; samples for each pixel and axis */
enum { LEAST_SIDE = 120 };  /* pixels of a panel's shorter side, below which there is no room for letters */
enum { BACK = 0x201a16, INK = 0xe0d4c9, TICK = 0x3cb4f0 }; /* 0xBBGGRR */

static void panel(const source *s, const plane *p, int through, double mm_per_pixel, int x0, int width, int height, const ost_sheet *sheet)
{
    static const double tint[3] = {0xe8, 0x4a, 0x27};
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            double sum[3] = {0, 0, 0};
            for (int k = 0; k < OVER * OVER; k++) {
                double across = (x + (k % OVER + 0.5) / OVER) * mm_per_pixel, down = (y + (k / OVER + 0.5) / OVER) * mm_per_pixel;
                double a = across / s->spacing[p->across] - 0.5, b = down / s->spacing[p->down] - 0.5;
                if (p->down_is_minus)
                    b = s->n[p->down] - 1 - b;
                double grey = 0, removed = 0;
                sample(s, p, through, a, b, &grey, &removed);
                for (int c = 0; c < 3; c++)
                    sum[c] += 255 * grey + removed * (0.35 * 255 * grey + 0.65 * tint[c] - 255 * grey);
            }
            uint32_t colour = 0;
            for (int c = 0; c < 3; c++)
                colour |= (uint32_t)(sum[c] / (OVER * OVER) + 0.5) << (8 * c);
            sheet->pixels[(size_t)y * (size_t)sheet->stride + (size_t)(x0 + x)] = colour;
        }
}

/* Draws a word on a darker ground, so that it is legible on bone. y: baseline. */
static void word(const ost_sheet *sheet, const ost_lettering *letters, int x, int y, double unit, const char *text)
{
    const int edge = (int)(3 * unit + 0.5), high = (int)(OST_MARKS_LETTER * unit);
    ost_sheet_box(sheet, x - edge, y - high - edge, ost_lettering_width(letters, text) + edge, high + 2 * edge, BACK, 190);
    ost_lettering_draw(letters, sheet, x, y, text, INK);
}

static void annotate(const plane *p, const ost_lettering *letters, const char *title, int x0, int width, int height, double unit,
                     const ost_sheet *sheet)
{
    double right[3] = {0, 0, 0}, up[3] = {0, 0, 0};
    const int margin = (int)(6 * unit), high = (int)(OST_MARKS_LETTER * unit);
    right[p->across] = 1;
    up[p->down] = p->down_is_minus ? 1 : -1;
    word(sheet, letters, x0 + width - margin - ost_lettering_width(letters, title), height - margin, unit, title);
    for (int edge = 0; edge < 4; edge++) {
        char text[4];
        ost_edge_letters(right, up, edge, text);
        const int wide = ost_lettering_width(letters, text);
        const int x = edge == 0 ? margin : edge == 1 ? width - margin - wide : (width - wide) / 2;
        const int y = edge == 2 ? margin + high : edge == 3 ? height - margin : (height + high) / 2;
        word(sheet, letters, x0 + x, y, unit, text);
    }
}

/* Draws short ticks at the panel's edges where the other two planes cut it. */
static void ticks(const source *s, const plane *p, const int at[3], double mm_per_pixel, int x0, int width, int height, const ost_sheet *sheet)
{
    int a = (int)((at[p->across] + 0.5) * s->spacing[p->across] / mm_per_pixel);
    double b = (at[p->down] + 0.5) * s->spacing[p->down];
    int down = (int)((p->down_is_minus ? s->n[p->down] * s->spacing[p->down] - b : b) / mm_per_pixel);
    int length = width / 24 + 4;
    ost_sheet_box(sheet, x0 + a, 0, 1, length, TICK, 230);
    ost_sheet_box(sheet, x0 + a, height - length, 1, length, TICK, 230);
    ost_sheet_box(sheet, x0, down, length, 1, TICK, 230);
    ost_sheet_box(sheet, x0 + width - length, down, length, 1, TICK, 230);
}

ost_status ost_picture_slices(const ost_volume *volume, const ost_volume *before, const ost_slices_options *options, ost_picture *out,
                              ost_error *err)
{
    static const ost_slices_options defaults = {.at = {-1, -1, -1}};
    const ost_slices_options *o = options ? options : &defaults;
    memset(out, 0, sizeof *out);
    if (!volume->voxels)
        return ost_fail(err, OST_ERR_USAGE, "slices need a volume with voxels");
    if (before && (!before->voxels || !ost_geometry_equal(&volume->geometry, &before->geometry)))
        return ost_fail(err, OST_ERR_USAGE, "the volume before and the one after must have the same dims, spacing and origin");
    const ost_geometry *g = &volume->geometry;
    int level = o->level, window = o->width;
    if (level == 0 && window == 0)
        level = 400, window = 1800;
    if (window < 1)
        return ost_fail(err, OST_ERR_USAGE, "a window of %d HU: expected at least 1", window);

    source s = {volume, before, o->threshold > 0 ? o->threshold : 120, {g->dims.x, g->dims.y, g->dims.z},
                {ost_pm_to_mm(g->spacing.x), ost_pm_to_mm(g->spacing.y), ost_pm_to_mm(g->spacing.z)},
                level - 0.5 * window, level + 0.5 * window};
    int at[3];
    middle(&s, at);
    double longest = 0;
    for (int a = 0; a < 3; a++) {
        if (o->at[a] >= s.n[a])
            return ost_fail(err, OST_ERR_RANGE, "slice %d along %c: the volume has voxels 0 to %d", o->at[a], "xyz"[a], s.n[a] - 1);
        if (o->at[a] >= 0)
            at[a] = o->at[a];
        longest = s.n[a] * s.spacing[a] > longest ? s.n[a] * s.spacing[a] : longest;
    }
    double mm_per_pixel = longest / (o->pixels > 0 ? o->pixels : 480);
    int width[3], height[3], total = 2 * GAP, tallest = 1;
    for (int i = 0; i < 3; i++) {
        const plane *p = &PLANES[i];
        width[i] = (int)(s.n[p->across] * s.spacing[p->across] / mm_per_pixel + 0.5);
        height[i] = (int)(s.n[p->down] * s.spacing[p->down] / mm_per_pixel + 0.5);
        width[i] = width[i] < 1 ? 1 : width[i];
        height[i] = height[i] < 1 ? 1 : height[i];
        total += width[i];
        tallest = height[i] > tallest ? height[i] : tallest;
    }
    static const char *const titles[3] = {"AXIAL", "CORONAL", "SAGITTAL"};
    const double unit = ost_marks_unit((int)(2.2 * tallest));
    ost_lettering *letters = NULL;
    ost_sheet sheet = {.stride = total, .width = total, .height = tallest};
    ost_status status = ost_picture_init(out, total, tallest, err);
    if (status == OST_OK)
        status = ost_lettering_create(OST_MARKS_LETTER * unit, &letters, err);
    if (status == OST_OK && !(sheet.pixels = malloc((size_t)total * (size_t)tallest * sizeof *sheet.pixels)))
        status = ost_fail(err, OST_ERR_MEMORY, "no memory for a picture of %d x %d pixels", total, tallest);
    if (status == OST_OK) {
        ost_sheet_box(&sheet, 0, 0, total, tallest, BACK, 256);
        for (int i = 0, x0 = 0; i < 3; x0 += width[i] + GAP, i++) {
            const bool roomy = width[i] >= LEAST_SIDE && height[i] >= LEAST_SIDE;
            panel(&s, &PLANES[i], at[PLANES[i].through], mm_per_pixel, x0, width[i], height[i], &sheet);
            ticks(&s, &PLANES[i], at, mm_per_pixel, x0, width[i], height[i], &sheet);
            if (roomy)
                annotate(&PLANES[i], letters, titles[i], x0, width[i], height[i], unit, &sheet);
            if (roomy && i == 0) {
                const int margin = (int)(6 * unit), high = (int)(26 * unit);
                ost_sheet_box(&sheet, margin / 2, height[0] - margin / 2 - high, width[0] / 3 + margin, high, BACK, 190);
                ost_scale_bar(letters, &sheet, margin, height[0] - margin, true, width[0] / 3, mm_per_pixel, unit, INK);
            }
        }
        ost_colours_copy(sheet.pixels, sheet.stride, out);
    } else {
        ost_picture_free(out);
    }
    free(sheet.pixels);
    ost_lettering_free(letters);
    return status;
}
