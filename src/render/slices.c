/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Draws three slices through one voxel, next to each other, in the radiological convention:
 *
 *     axial              coronal            sagittal
 *   R   A   L           R   S   L           A   S   P
 *     x ->                x ->                y ->
 *     y down              z up                z up
 *
 * All three slices have the same scale and square pixels. Colours rather than densities are interpolated between voxel
 * centres, so that individual voxels remain recognizable at the border of a cut.
 */
#include "render/slices.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "render/marks.h"
#include "render/points/frame.h"

typedef struct plane {
    int across, down, through; /* axes of the grid */
    bool down_is_minus;        /* true if the coordinate on the axis `down` decreases from row to row */
} plane;

static const plane PLANES[3] = {{0, 1, 2, false}, {0, 2, 1, true}, {1, 2, 0, true}};

typedef struct source {
    const ost_slices_paint *paint;
    int n[3];
    double spacing[3];
} source;

/* OVER is the number of samples per pixel on each axis. */
enum { GAP = OST_SLICES_GAP, OVER = 2 };
enum { OUTLINE = 2 };        /* width of an outline in pixels */
enum { LEAST_SIDE = 120 };  /* minimum length, in pixels, of a panel's shorter side for letters to fit */
enum { BACK = 0x201a16, INK = 0xe0d4c9, TICK = 0x3cb4f0 }; /* 0xBBGGRR */

/* A cache of colours, three values per voxel, for the two rows of voxels between which a line of samples lies. `row`
   contains the indices of the two rows; -1 marks a row that has not been computed yet. Without the cache, the callback
   would be called for each sample, which would dominate the drawing time. */
typedef struct row_pair {
    double *rgb[2];
    int row[2];
} row_pair;

/* Returns the index in the volume of the voxel (i, j) of the plane. */
static size_t index_of(const source *s, const plane *p, int through, int i, int j)
{
    int v[3];
    v[p->across] = i;
    v[p->down] = j;
    v[p->through] = through;
    return (size_t)v[0] + (size_t)s->n[0] * ((size_t)v[1] + (size_t)s->n[1] * (size_t)v[2]);
}

/*
 * Clamps a coordinate of a sample, in voxels, to the range of the voxel centres. If colours are not interpolated, the
 * coordinate is first rounded to a voxel centre.
 */
static double at_centres(const source *s, double a, int n)
{
    if (s->paint->by_voxel)
        a = floor(a + 0.5);
    return a < 0 ? 0 : a > n - 1 ? n - 1 : a;
}

/* Computes the colours of the row at position b. If b lies between two rows, computes the colours of both. */
static void find_rows(const source *s, const plane *p, int through, double b, row_pair *rows)
{
    const int j = (int)b;
    for (int k = 0; k < (b > j ? 2 : 1); k++)
        if (rows->row[k] != j + k) {
            rows->row[k] = j + k;
            for (int i = 0; i < s->n[p->across]; i++)
                s->paint->colour(s->paint->user, index_of(s, p, through, i, j + k), rows->rgb[k] + 3 * (size_t)i);
        }
}

/* Adds the interpolated colour at position (a, b) of the plane, in voxels, to sum[]. */
static void add_sample(double a, double b, const row_pair *rows, double sum[3])
{
    const int i = (int)a, j = (int)b;
    for (int corner = 0; corner < 4; corner++) {
        const double weight = (corner & 1 ? a - i : 1 - (a - i)) * (corner >> 1 ? b - j : 1 - (b - j));
        if (!(weight > 0))
            continue;
        const double *rgb = rows->rgb[corner >> 1] + 3 * (size_t)(i + (corner & 1));
        for (int c = 0; c < 3; c++)
            sum[c] += weight * rgb[c];
    }
}

/* Draws one slice plane into a panel of the sheet. Samples outside the grid are black. */
static void panel(const source *s, const plane *p, int through, double mm_per_pixel, int x0, int width, int height,
                  row_pair rows[OVER], const ost_sheet *sheet)
{
    const int na = s->n[p->across], nb = s->n[p->down];
    for (int line = 0; line < OVER; line++)
        rows[line].row[0] = rows[line].row[1] = -1;
    for (int y = 0; y < height; y++) {
        double b[OVER];
        bool inside[OVER];
        for (int line = 0; line < OVER; line++) {
            const double down = (y + (line + 0.5) / OVER) * mm_per_pixel / s->spacing[p->down] - 0.5,
                         at = p->down_is_minus ? nb - 1 - down : down;
            inside[line] = at >= -0.5 && at <= nb - 0.5;
            b[line] = at_centres(s, at, nb);
            if (inside[line])
                find_rows(s, p, through, b[line], &rows[line]);
        }
        for (int x = 0; x < width; x++) {
            double sum[3] = {0, 0, 0};
            for (int k = 0; k < OVER * OVER; k++) {
                const double a = (x + (k % OVER + 0.5) / OVER) * mm_per_pixel / s->spacing[p->across] - 0.5;
                if (inside[k / OVER] && a >= -0.5 && a <= na - 0.5)
                    add_sample(at_centres(s, a, na), b[k / OVER], &rows[k / OVER], sum);
            }
            uint32_t colour = 0;
            for (int c = 0; c < 3; c++)
                colour |= (uint32_t)(sum[c] / (OVER * OVER) + 0.5) << (8 * c);
            sheet->pixels[(size_t)y * (size_t)sheet->stride + (size_t)(x0 + x)] = colour;
        }
    }
}

/* Returns the index, along one axis, of the voxel that contains the centre of pixel x. */
static int voxel_at(int x, double mm_per_pixel, double spacing, int n)
{
    const double at = (x + 0.5) * mm_per_pixel / spacing;
    return at < n - 1 ? (int)at : n - 1;
}

/* Determines, for each pixel of a panel, the region of the voxel that contains the pixel's centre. */
static void find_regions(const source *s, const plane *p, int through, double mm_per_pixel, int width, int height,
                         uint32_t *regions)
{
    const int nb = s->n[p->down];
    int last_j = -1;
    for (int y = 0; y < height; y++) {
        uint32_t *line = regions + (size_t)y * (size_t)width;
        const int k = voxel_at(y, mm_per_pixel, s->spacing[p->down], nb), j = p->down_is_minus ? nb - 1 - k : k;
        if (j == last_j) {
            memcpy(line, line - width, (size_t)width * sizeof *line);
            continue;
        }
        last_j = j;
        for (int x = 0, last_i = -1; x < width; x++) {
            const int i = voxel_at(x, mm_per_pixel, s->spacing[p->across], s->n[p->across]);
            line[x] = i == last_i ? line[x - 1]
                                  : s->paint->region(s->paint->user, index_of(s, p, through, i, j));
            last_i = i;
        }
    }
}

/* Draws the outlines of the regions in a panel. `regions` has one element per pixel. */
static void outline(const source *s, const plane *p, int through, double mm_per_pixel, int x0, int width, int height,
                    uint32_t *regions, const ost_sheet *sheet)
{
    find_regions(s, p, through, mm_per_pixel, width, height, regions);
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            const uint32_t own = regions[(size_t)y * (size_t)width + (size_t)x];
            bool border = false;
            for (int far = 1; far <= OUTLINE && own != OST_NO_REGION; far++)
                for (int side = 0; side < 4; side++) {
                    const int nx = x + (side == 0 ? -far : side == 1 ? far : 0),
                              ny = y + (side == 2 ? -far : side == 3 ? far : 0);
                    border |= nx >= 0 && ny >= 0 && nx < width && ny < height &&
                              regions[(size_t)ny * (size_t)width + (size_t)nx] != own;
                }
            if (border)
                sheet->pixels[(size_t)y * (size_t)sheet->stride + (size_t)(x0 + x)] = own;
        }
}

/* Draws a word on a darker background, so that it is legible on bone. The baseline is at y. */
static void word(const ost_sheet *sheet, const ost_lettering *letters, int x, int y, double unit, const char *text)
{
    const int edge = (int)(3 * unit + 0.5), high = (int)(OST_MARKS_LETTER * unit);
    ost_sheet_box(sheet, x - edge, y - high - edge, ost_lettering_width(letters, text) + edge, high + 2 * edge, BACK,
                  190);
    ost_lettering_draw(letters, sheet, x, y, text, INK);
}

static void annotate(const plane *p, const ost_lettering *letters, const char *title, bool oriented, int x0, int width,
                     int height, double unit, const ost_sheet *sheet)
{
    double right[3] = {0, 0, 0}, up[3] = {0, 0, 0};
    const int margin = (int)(6 * unit), high = (int)(OST_MARKS_LETTER * unit);
    right[p->across] = 1;
    up[p->down] = p->down_is_minus ? 1 : -1;
    word(sheet, letters, x0 + width - margin - ost_lettering_width(letters, title), height - margin, unit, title);
    for (int edge = 0; edge < 4 && oriented; edge++) {
        char text[4];
        ost_edge_letters(right, up, edge, text);
        const int wide = ost_lettering_width(letters, text);
        const int x = edge == 0 ? margin : edge == 1 ? width - margin - wide : (width - wide) / 2;
        const int y = edge == 2 ? margin + high : edge == 3 ? height - margin : (height + high) / 2;
        word(sheet, letters, x0 + x, y, unit, text);
    }
}

/* Draws short ticks at the edges of the panel where the other two planes intersect it. */
static void ticks(const source *s, const plane *p, const int at[3], double mm_per_pixel, int x0, int width, int height,
                  const ost_sheet *sheet)
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

ost_status ost_slices_draw(const ost_geometry *g, const int32_t at[3], int pixels, const ost_slices_paint *paint,
                           ost_picture *out, ost_error *err)
{
    static const char *const titles[3] = {"AXIAL", "CORONAL", "SAGITTAL"};
    const source s = {paint,
                      {g->dims.x, g->dims.y, g->dims.z},
                      {ost_pm_to_mm(g->spacing.x), ost_pm_to_mm(g->spacing.y), ost_pm_to_mm(g->spacing.z)}};
    double longest = 0;
    for (int a = 0; a < 3; a++) {
        if (at[a] < 0 || at[a] >= s.n[a])
            return ost_fail(err, OST_ERR_RANGE, "slice %d along %c: the volume has voxels 0 to %d", at[a], "xyz"[a],
                            s.n[a] - 1);
        longest = fmax(longest, s.n[a] * s.spacing[a]);
    }
    const double mm_per_pixel = longest / (pixels > 0 ? pixels : 480);
    int width[3], height[3], total = 2 * GAP, tallest = 1;
    const size_t row = 3 * (size_t)(s.n[0] > s.n[1] ? s.n[0] : s.n[1]);
    for (int i = 0; i < 3; i++) {
        const plane *p = &PLANES[i];
        width[i] = (int)fmax(1, s.n[p->across] * s.spacing[p->across] / mm_per_pixel + 0.5);
        height[i] = (int)fmax(1, s.n[p->down] * s.spacing[p->down] / mm_per_pixel + 0.5);
        total += width[i];
        tallest = height[i] > tallest ? height[i] : tallest;
    }
    const double unit = ost_marks_unit((int)(2.2 * tallest));
    ost_lettering *letters = NULL;
    uint32_t *regions = NULL;
    double *colours = NULL;
    row_pair rows[OVER];
    ost_sheet sheet = {.stride = total, .width = total, .height = tallest};
    ost_status status = ost_picture_init(out, total, tallest, err);
    if (status == OST_OK)
        status = ost_lettering_create(OST_MARKS_LETTER * unit, &letters, err);
    if (status == OST_OK && (!(sheet.pixels = calloc((size_t)total * (size_t)tallest, sizeof *sheet.pixels)) ||
                             !(colours = malloc(2 * OVER * row * sizeof *colours)) ||
                             (paint->region &&
                              !(regions = malloc((size_t)total * (size_t)tallest * sizeof *regions)))))
        status = ost_fail(err, OST_ERR_MEMORY, "out of memory for a picture of %d x %d pixels", total, tallest);
    if (status == OST_OK) {
        for (int k = 0; k < 2 * OVER; k++)
            rows[k / 2].rgb[k % 2] = colours + (size_t)k * row;
        ost_sheet_box(&sheet, 0, 0, total, tallest, BACK, 256);
        for (int i = 0, x0 = 0; i < 3; x0 += width[i] + GAP, i++) {
            const bool roomy = width[i] >= LEAST_SIDE && height[i] >= LEAST_SIDE;
            const int through = at[PLANES[i].through];
            panel(&s, &PLANES[i], through, mm_per_pixel, x0, width[i], height[i], rows, &sheet);
            if (regions)
                outline(&s, &PLANES[i], through, mm_per_pixel, x0, width[i], height[i], regions, &sheet);
            ticks(&s, &PLANES[i], at, mm_per_pixel, x0, width[i], height[i], &sheet);
            if (roomy)
                annotate(&PLANES[i], letters, titles[i], !paint->unoriented, x0, width[i], height[i], unit, &sheet);
            if (roomy && i == 0) {
                const int margin = (int)(6 * unit), high = (int)(26 * unit);
                ost_sheet_box(&sheet, margin / 2, height[0] - margin / 2 - high, width[0] / 3 + margin, high, BACK,
                              190);
                ost_scale_bar(letters, &sheet, margin, height[0] - margin, true, width[0] / 3, mm_per_pixel, unit, INK);
            }
        }
        ost_colours_copy(sheet.pixels, sheet.stride, out);
    } else {
        ost_picture_free(out);
    }
    free(regions);
    free(colours);
    free(sheet.pixels);
    ost_lettering_free(letters);
    return status;
}

/* ------------------------------------------------------------- densities */

typedef struct densities {
    const ost_volume *now, *before;
    int32_t threshold;
    double black, white; /* HU */
} densities;

static bool is_removed(const densities *d, size_t v)
{
    return d->before && d->now->voxels[v] < d->threshold && d->before->voxels[v] >= d->threshold;
}

/* Computes the grey value of a density. A removed voxel is tinted, but its density before the removal remains
   visible. */
static void colour_of(const void *user, size_t voxel, double rgb[3])
{
    static const double tint[3] = {0xe8, 0x4a, 0x27};
    const densities *d = user;
    const bool removed = is_removed(d, voxel);
    const double hu = removed ? d->before->voxels[voxel] : d->now->voxels[voxel];
    const double grey = 255 * fmin(1, fmax(0, (hu - d->black) / (d->white - d->black)));
    for (int c = 0; c < 3; c++)
        rgb[c] = removed ? 0.35 * grey + 0.65 * tint[c] : grey;
}

/*
 * Computes the middle of the bounding box of the removed voxels. If no voxel was removed, uses the middle of the grid.
 */
static void middle(const densities *d, int32_t at[3])
{
    const ost_dims n = d->now->geometry.dims;
    const int32_t size[3] = {n.x, n.y, n.z};
    int32_t lo[3] = {n.x, n.y, n.z}, hi[3] = {-1, -1, -1};
    for (int64_t e = 0; d->before && e < ost_dims_count(n); e++)
        if (is_removed(d, (size_t)e)) {
            const int32_t v[3] = {(int32_t)(e % n.x), (int32_t)(e / n.x % n.y), (int32_t)(e / n.x / n.y)};
            for (int a = 0; a < 3; a++) {
                lo[a] = v[a] < lo[a] ? v[a] : lo[a];
                hi[a] = v[a] > hi[a] ? v[a] : hi[a];
            }
        }
    for (int a = 0; a < 3; a++)
        at[a] = hi[a] >= 0 ? (lo[a] + hi[a]) / 2 : size[a] / 2;
}

ost_status ost_picture_slices(const ost_volume *volume, const ost_volume *before, const ost_slices_options *options,
                              ost_picture *out, ost_error *err)
{
    static const ost_slices_options defaults = {.at = {-1, -1, -1}};
    const ost_slices_options *o = options ? options : &defaults;
    const bool usual = o->level == 0 && o->width == 0;
    const int level = usual ? OST_SLICES_LEVEL : o->level, window = usual ? OST_SLICES_WIDTH : o->width;
    const densities d = {volume, before, o->threshold > 0 ? o->threshold : 120, level - 0.5 * window,
                         level + 0.5 * window};
    const ost_slices_paint paint = {.colour = colour_of, .user = &d, .unoriented = o->unoriented};
    int32_t at[3];
    *out = (ost_picture){0};
    if (!volume->voxels)
        return ost_fail(err, OST_ERR_USAGE, "slices need a volume with voxels");
    if (before && (!before->voxels || !ost_geometry_equal(&volume->geometry, &before->geometry)))
        return ost_fail(err, OST_ERR_USAGE, "both volumes must have the same dims, spacing and origin");
    if (window < 1)
        return ost_fail(err, OST_ERR_USAGE, "a window of %d HU: expected at least 1", window);
    middle(&d, at);
    for (int a = 0; a < 3; a++)
        at[a] = o->at[a] >= 0 ? o->at[a] : at[a];
    return ost_slices_draw(&volume->geometry, at, o->pixels, &paint, out, err);
}
