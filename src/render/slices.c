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
#include <string.h>

#include "render/canvas.h"

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

static void panel(const source *s, const plane *p, int through, double mm_per_pixel, int x0, int width, int height, ost_picture *out)
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
            uint8_t *rgb = out->rgb + 3 * ((size_t)y * (size_t)out->width + (size_t)(x0 + x));
            for (int c = 0; c < 3; c++)
                rgb[c] = (uint8_t)(sum[c] / (OVER * OVER) + 0.5);
        }
}

static void annotate(const plane *p, const char *title, int x0, int width, int height, int scale, ost_picture *out)
{
    static const ost_rgb ink = {0xc9, 0xd4, 0xe0};
    int margin = 3 * scale;
    ost_canvas_text(out, x0 + width - margin - ost_canvas_text_width(title, scale), height - margin - OST_GLYPH_HEIGHT * scale, scale, ink,
                    title);
    for (int side = 0; side < 4; side++) {
        double direction[3] = {0, 0, 0};
        direction[side < 2 ? p->across : p->down] = (side % 2 ? -1.0 : 1.0) * (side >= 2 && p->down_is_minus ? -1.0 : 1.0);
        char letters[4];
        ost_orientation_letters(direction, letters);
        int wide = ost_canvas_text_width(letters, scale), high = OST_GLYPH_HEIGHT * scale;
        int x = side == 0 ? width - margin - wide : side == 1 ? margin : (width - wide) / 2;
        int y = side < 2 ? (height - high) / 2 : side == 2 ? height - margin - high : margin;
        ost_canvas_text(out, x0 + x, y, scale, ink, letters);
    }
}

/* Draws short ticks at the panel's edges where the other two planes cut it. */
static void ticks(const source *s, const plane *p, const int at[3], double mm_per_pixel, int x0, int width, int height, ost_picture *out)
{
    static const ost_rgb ink = {0xf0, 0xb4, 0x3c};
    int a = (int)((at[p->across] + 0.5) * s->spacing[p->across] / mm_per_pixel);
    double b = (at[p->down] + 0.5) * s->spacing[p->down];
    int down = (int)((p->down_is_minus ? s->n[p->down] * s->spacing[p->down] - b : b) / mm_per_pixel);
    int length = width / 24 + 4;
    ost_canvas_rect(out, x0 + a, 0, 1, length, ink, 0.9);
    ost_canvas_rect(out, x0 + a, height - length, 1, length, ink, 0.9);
    ost_canvas_rect(out, x0, down, length, 1, ink, 0.9);
    ost_canvas_rect(out, x0 + width - length, down, length, 1, ink, 0.9);
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
    ost_status status = ost_picture_init(out, total, tallest, err);
    if (status != OST_OK)
        return status;
    ost_canvas_rect(out, 0, 0, total, tallest, (ost_rgb){0x16, 0x1a, 0x20}, 1);
    static const char *const titles[3] = {"AXIAL", "CORONAL", "SAGITTAL"};
    int scale = tallest >= 900 ? 3 : tallest >= 300 ? 2 : 1;
    for (int i = 0, x0 = 0; i < 3; x0 += width[i] + GAP, i++) {
        panel(&s, &PLANES[i], at[PLANES[i].through], mm_per_pixel, x0, width[i], height[i], out);
        ticks(&s, &PLANES[i], at, mm_per_pixel, x0, width[i], height[i], out);
        annotate(&PLANES[i], titles[i], x0, width[i], height[i], scale, out);
    }
    ost_canvas_scale_bar(out, 3 * scale, height[0] - 3 * scale, width[0] / 3, mm_per_pixel, scale, (ost_rgb){0xc9, 0xd4, 0xe0});
    return OST_OK;
}
