/* SPDX-License-Identifier: Apache-2.0 */
#include "app/picture/preview.h"

#include <math.h>
#include <osteon/sim.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app/common/print.h"
#include "core/printable.h"
#include "render/points/palette.h"
#include "render/slices.h"
#include "render/view.h"
#include "render/views.h"

enum { MARGIN = CHART_MARGIN, TOP = 56, PLANES_HIGH = 500, CAPTION = 26, TABLE_GAP = 28 };
#define MARKS 1.25 /* size of a unit of the marks in the surface view, in pixels (marks.h) */
enum { SURFACE_LEAST = 440, SURFACE_MOST = 640 };   /* limits of the width of the surface view, in pixels */
/* width in mm of the margin of CT that the planes show around the parts */
enum { AROUND_MM = 25 };
enum { THRESHOLD = 120 };                           /* in HU; default threshold of both verbs */
/* values for voxels that belong to no part; the labels of parts start at 1 */
enum { NO_PART = -1, LEFT_OUT = 0 };
/* maximum number of voxels, 128 MiB; a larger grid is drawn with larger voxels */
enum { SURFACE_VOXELS_MAX = 1 << 26 };

/* ------------------------------------------------------------------ extent */

/* The bounding box of the parts, and the voxel in which the three planes meet. */
typedef struct extent {
    int32_t lo[3], hi[3]; /* range of voxels that contains all parts, lo <= voxel < hi; empty without parts */
    int32_t at[3];
    bool glenoid;         /* true if the planes meet at the centre of the glenoid */
} extent;

static bool is_part(const preview_input *in, int16_t value)
{
    return value >= (in->labels ? 1 : in->threshold);
}

/*
 * Finds the bounds of the parts and, on each axis, the slice with the most voxels of the parts; in a tie, the slice
 * with the lowest index. If the input contains labels, only the largest part, label 1, is counted. The caller frees
 * *slices, an array of counts.
 */
static ost_status count_slices(const preview_input *in, extent *e, uint64_t **slices, ost_error *err)
{
    const ost_dims d = in->parts->geometry.dims;
    const int32_t n[3] = {d.x, d.y, d.z};
    uint64_t *count = calloc((size_t)d.x + (size_t)d.y + (size_t)d.z, sizeof *count);
    uint64_t *const of[3] = {count, count + d.x, count + d.x + d.y};
    *slices = count;
    if (!count)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a preview");
    ost_active_box(in->parts, in->labels ? 1 : in->threshold, e->lo, e->hi);
    for (int32_t z = e->lo[2]; z < e->hi[2]; z++)
        for (int32_t y = e->lo[1]; y < e->hi[1]; y++) {
            const int16_t *row = in->parts->voxels + (size_t)d.x * ((size_t)y + (size_t)d.y * (size_t)z);
            for (int32_t x = e->lo[0]; x < e->hi[0]; x++)
                if (is_part(in, row[x]) && (!in->labels || row[x] == 1))
                    of[0][x]++, of[1][y]++, of[2][z]++;
        }
    for (int a = 0; a < 3; a++) {
        int32_t most = 0;
        for (int32_t k = 1; k < n[a]; k++)
            most = of[a][k] > of[a][most] ? k : most;
        e->at[a] = of[a][most] > 0 ? most : n[a] / 2;
    }
    return OST_OK;
}

static ost_status find_extent(const preview_input *in, extent *e, ost_error *err)
{
    const ost_geometry *g = &in->parts->geometry;
    const ost_pm s[3] = {g->spacing.x, g->spacing.y, g->spacing.z}, o[3] = {g->origin.x, g->origin.y, g->origin.z};
    const int32_t n[3] = {g->dims.x, g->dims.y, g->dims.z};
    uint64_t *slices;
    ost_pm3 at = in->at;
    ost_status status = count_slices(in, e, &slices, err);
    free(slices);
    if (status == OST_OK)
        status = ost_point_from_meta(in->meta, OST_META_GLENOID_AT, &at, &e->glenoid, err);
    if (status != OST_OK || (!e->glenoid && !in->at_given))
        return status;
    const ost_pm p[3] = {at.x, at.y, at.z};
    for (int a = 0; a < 3; a++) {
        const double v = floor((double)(p[a] - o[a]) / (double)s[a] + 0.5);
        e->at[a] = v > 0 ? v < n[a] - 1 ? (int32_t)v : n[a] - 1 : 0;
    }
    return OST_OK;
}

/* ------------------------------------------------------------------ planes */

/* The section of the grid that the planes show: its first voxel and its size. */
typedef struct planes {
    const preview_input *in;
    int32_t lo[3];
    ost_dims shown;
} planes;

static void position(const planes *p, size_t index, int32_t v[3])
{
    const size_t nx = (size_t)p->shown.x, ny = (size_t)p->shown.y;
    v[0] = p->lo[0] + (int32_t)(index % nx);
    v[1] = p->lo[1] + (int32_t)(index / nx % ny);
    v[2] = p->lo[2] + (int32_t)(index / nx / ny);
}

static int16_t voxel_of(const ost_volume *volume, const int32_t v[3])
{
    const ost_dims d = volume->geometry.dims;
    return volume->voxels[(size_t)v[0] + (size_t)d.x * ((size_t)v[1] + (size_t)d.y * (size_t)v[2])];
}

/*
 * Returns the CT's density at the centre of a voxel of the parts, or the density of air if the centre is outside the
 * CT.
 */
static double density_at(const preview_input *in, const int32_t v[3])
{
    if (!in->ct)
        return voxel_of(in->parts, v);
    const ost_geometry *g = &in->parts->geometry, *c = &in->ct->geometry;
    const ost_pm from[3] = {g->origin.x - c->origin.x, g->origin.y - c->origin.y, g->origin.z - c->origin.z};
    const ost_pm step[3] = {g->spacing.x, g->spacing.y, g->spacing.z};
    const ost_pm s[3] = {c->spacing.x, c->spacing.y, c->spacing.z};
    const int32_t n[3] = {c->dims.x, c->dims.y, c->dims.z};
    int32_t low[3];
    double part[3], sum = 0;
    for (int a = 0; a < 3; a++) {
        double f = (double)(from[a] + v[a] * step[a]) / (double)s[a];
        if (f < -0.5 || f > n[a] - 0.5)
            return -1000;
        if (in->nearest)
            f = floor(f + 0.5);
        f = fmin(n[a] - 1, fmax(0, f));
        low[a] = (int32_t)f;
        part[a] = f - low[a];
    }
    for (int corner = 0; corner < 8; corner++) {
        double weight = 1;
        int32_t at[3];
        for (int a = 0; a < 3; a++) {
            weight *= corner >> a & 1 ? part[a] : 1 - part[a];
            at[a] = low[a] + (corner >> a & 1);
        }
        if (weight > 0)
            sum += weight * voxel_of(in->ct, at);
    }
    return sum;
}

static int part_at(const preview_input *in, const int32_t v[3])
{
    const int16_t value = voxel_of(in->parts, v);
    if (is_part(in, value))
        return in->labels ? value : 1;
    return in->left_out && density_at(in, v) >= in->threshold ? LEFT_OUT : NO_PART;
}

/*
 * Returns the level of the grey-scale window. The level follows the threshold, because a threshold far from the
 * default indicates densities on another scale.
 */
static int level_of(const preview_input *in)
{
    return OST_SLICES_LEVEL + in->threshold - THRESHOLD;
}

static void colour_of(const void *user, size_t index, double rgb[3])
{
    /* strengths of the tint: for dense voxels outside all parts, and for voxels of parts */
    static const double strength[2] = {0.55, 0.25};
    const planes *p = user;
    int32_t v[3];
    position(p, index, v);
    const double black = level_of(p->in) - 0.5 * OST_SLICES_WIDTH,
                 grey = 255 * fmin(1, fmax(0, (density_at(p->in, v) - black) / OST_SLICES_WIDTH));
    const int part = part_at(p->in, v);
    const uint32_t colour = part == NO_PART ? 0 : ost_label_colour(part);
    const double tint = part == NO_PART || (part != LEFT_OUT && !p->in->labels) ? 0 : strength[part != LEFT_OUT];
    for (int c = 0; c < 3; c++)
        rgb[c] = (1 - tint) * grey + tint * (colour >> (8 * c) & 255);
}

static uint32_t region_of(const void *user, size_t index)
{
    const planes *p = user;
    int32_t v[3];
    position(p, index, v);
    const int part = part_at(p->in, v);
    return part == NO_PART ? OST_NO_REGION : ost_label_colour(part);
}

/* Draws the planes as large as the page allows. */
static ost_status draw_planes(const preview_input *in, const extent *e, ost_picture *out, ost_error *err)
{
    const ost_geometry *g = &in->parts->geometry;
    const double mm[3] = {ost_pm_to_mm(g->spacing.x), ost_pm_to_mm(g->spacing.y), ost_pm_to_mm(g->spacing.z)};
    const int32_t n[3] = {g->dims.x, g->dims.y, g->dims.z};
    const bool none = e->hi[2] <= e->lo[2];
    planes p = {.in = in};
    int32_t shown[3], at[3];
    double side[3];
    for (int a = 0; a < 3; a++) {
        const int32_t around = mm[a] < AROUND_MM ? (int32_t)(AROUND_MM / mm[a]) : 1;
        int32_t lo = none ? 0 : e->lo[a] - around, hi = none ? n[a] : e->hi[a] + around;
        lo = lo > e->at[a] ? e->at[a] : lo;
        hi = hi <= e->at[a] ? e->at[a] + 1 : hi;
        p.lo[a] = lo > 0 ? lo : 0;
        shown[a] = (hi < n[a] ? hi : n[a]) - p.lo[a];
        at[a] = e->at[a] - p.lo[a];
        side[a] = shown[a] * mm[a];
    }
    const double wide = 2 * side[0] + side[1], high = fmax(side[1], side[2]), longest = fmax(side[0], high);
    const double scale = fmin((PREVIEW_WIDTH - 2 * MARGIN - 2 * OST_SLICES_GAP - 3) / wide, PLANES_HIGH / high);
    p.shown = (ost_dims){shown[0], shown[1], shown[2]};
    const ost_geometry cropped = {p.shown, g->spacing, {0, 0, 0}};
    const ost_slices_paint paint = {
        .colour = colour_of, .region = region_of, .user = &p, .unoriented = in->unoriented};
    const int pixels = (int)(scale * longest + 1e-6);
    return ost_slices_draw(&cropped, at, pixels > 1 ? pixels : 1, &paint, out, err);
}

/* ----------------------------------------------------------------- surface */

/*
 * Makes the volume that ost_view_draw draws. Each of its voxels is a cube with the label of the nearest voxel of the
 * input. A cube is as wide as an input voxel along x, or wider if there would otherwise be too many cubes.
 */
static ost_status make_surface(const preview_input *in, const extent *e, ost_volume *out, ost_error *err)
{
    const ost_geometry *g = &in->parts->geometry;
    const ost_pm s[3] = {g->spacing.x, g->spacing.y, g->spacing.z}, o[3] = {g->origin.x, g->origin.y, g->origin.z};
    ost_pm cube = g->spacing.x;
    int64_t n[3];
    for (;; cube += cube / 2 + 1) {
        double count = 1;
        for (int a = 0; a < 3; a++) {
            n[a] = ((e->hi[a] - e->lo[a]) * s[a] + cube - 1) / cube;
            n[a] = n[a] > 0 ? n[a] : 1;
            count *= (double)n[a];
        }
        if (count <= SURFACE_VOXELS_MAX)
            break;
    }
    const ost_geometry cubes = {{(int32_t)n[0], (int32_t)n[1], (int32_t)n[2]},
                                {cube, cube, cube},
                                {o[0] + e->lo[0] * s[0], o[1] + e->lo[1] * s[1], o[2] + e->lo[2] * s[2]}};
    ost_status status = ost_volume_init(out, &cubes, err);
    if (status != OST_OK)
        return status;
    int16_t *to = out->voxels;
    for (int32_t z = 0; z < n[2]; z++)
        for (int32_t y = 0; y < n[1]; y++)
            for (int32_t x = 0; x < n[0]; x++, to++) {
                const int32_t i[3] = {x, y, z};
                int32_t v[3];
                for (int a = 0; a < 3; a++) {
                    const int64_t near = e->lo[a] + (i[a] * cube + s[a] / 2) / s[a];
                    v[a] = near < e->hi[a] ? (int32_t)near : e->hi[a] > e->lo[a] ? e->hi[a] - 1 : e->lo[a];
                }
                const int part = part_at(in, v);
                if (part != NO_PART)
                    *to = (int16_t)(OST_LABEL_DENSITY + (part < OST_LABELS ? part : OST_LABELS - 1));
            }
    return OST_OK;
}

/*
 * Draws the surface in a view onto the glenoid's face. If the glenoid is not known, draws views from the front and
 * from the side.
 */
static ost_status draw_surface(const preview_input *in, const extent *e, int width, int height, ost_picture *out,
                               ost_error *err)
{
    ost_view_options options = {.threshold = in->labels ? OST_LABEL_DENSITY : in->threshold, .width = width,
                                .height = height, .unoriented = in->unoriented, .threads = in->threads};
    double axis[3];
    bool known = false;
    ost_side side = OST_SIDE_UNKNOWN;
    ost_status status = ost_axis_from_meta(in->meta, axis, &known, err);
    if (status == OST_OK)
        status = ost_side_from_meta(in->meta, &side, err);
    options.direction[0] = known ? axis[0] : side == OST_SIDE_LEFT ? -0.6 : 0.6;
    options.direction[1] = known ? axis[1] : 1;
    options.direction[2] = known ? axis[2] : -0.2;
    if (status != OST_OK || !in->labels)
        return status == OST_OK ? ost_view_draw(in->parts, false, MARKS, &options, out, err) : status;
    ost_volume cubes = {0};
    status = make_surface(in, e, &cubes, err);
    if (status == OST_OK)
        status = ost_view_draw(&cubes, true, MARKS, &options, out, err);
    ost_volume_free(&cubes);
    return status;
}

/* -------------------------------------------------------------------- page */

static void put_captions(chart *page, const preview_input *in, const extent *e, int y)
{
    const ost_geometry *g = &in->parts->geometry;
    const ost_pm3 at = {g->origin.x + e->at[0] * g->spacing.x, g->origin.y + e->at[1] * g->spacing.y,
                        g->origin.z + e->at[2] * g->spacing.z};
    char text[256];
    snprintf(text, sizeof text,
             "Planes through %s, L %.1f, P %.1f, S %.1f mm%s. Greys from %d (black) to %d HU (white): level %d, "
             "width %d HU.",
             e->glenoid     ? "the glenoid's centre"
             : in->at_given ? "the given position"
             : in->labels   ? "the largest cross-sections of label 1"
                            : "the bone's largest cross-sections",
             ost_pm_to_mm(at.x), ost_pm_to_mm(at.y), ost_pm_to_mm(at.z),
             in->unoriented ? " (directions assumed)" : "", level_of(in) - OST_SLICES_WIDTH / 2,
             level_of(in) + OST_SLICES_WIDTH / 2, level_of(in), OST_SLICES_WIDTH);
    chart_text(page, MARGIN, y, text);
}

ost_status preview_draw(const preview_input *in, ost_picture *out, ost_error *err)
{
    extent e = {.glenoid = false};
    ost_picture slices = {0}, surface = {0};
    chart page = {.text = NULL};
    const char *slash = strrchr(in->out, '/');
    char title[256];
    *out = (ost_picture){0};
    snprintf(title, sizeof title, "%s: %s", slash ? slash + 1 : in->out, in->labels ? "labels" : "bone");
    ost_make_printable(title);
    ost_status status = find_extent(in, &e, err);
    if (status == OST_OK)
        status = draw_planes(in, &e, &slices, err);
    const int below = TOP + slices.height + CAPTION + MARGIN, high = PREVIEW_HEIGHT - MARGIN - below;
    int wide = high * 4 / 3;
    wide = wide < SURFACE_LEAST ? SURFACE_LEAST : wide > SURFACE_MOST ? SURFACE_MOST : wide;
    if (status == OST_OK)
        status = draw_surface(in, &e, wide, high, &surface, err);
    if (status == OST_OK)
        status = chart_begin(&page, PREVIEW_WIDTH, PREVIEW_HEIGHT, err);
    if (status == OST_OK) {
        const int x = MARGIN + wide + TABLE_GAP;
        chart_title(&page, title);
        chart_put(&page, &slices, (PREVIEW_WIDTH - slices.width) / 2, TOP);
        put_captions(&page, in, &e, TOP + slices.height + CAPTION);
        chart_put(&page, &surface, MARGIN, below);
        chart_put_table(&page, in->table, x, below, PREVIEW_WIDTH - MARGIN - x, high);
        status = chart_end(&page, out, err);
    }
    chart_free(&page);
    ost_picture_free(&surface);
    ost_picture_free(&slices);
    return status;
}

ost_status preview_write(const preview_input *in, const char *path, ost_error *err)
{
    ost_picture picture;
    ost_status status = preview_draw(in, &picture, err);
    if (status == OST_OK)
        status = ost_picture_write_png(path, &picture, err);
    ost_picture_free(&picture);
    return status;
}

/* ------------------------------------------------------------------- table */

void preview_add_warnings(const app_state *app, const char *name, chart_table *table)
{
    const size_t length = strlen(name);
    size_t i;
    json_t *text;
    json_array_foreach(app->warnings, i, text) {
        const char *at = json_string_value(text);
        if (strncmp(at, name, length) == 0 && strncmp(at + length, ": ", 2) == 0)
            at += length + 2;
        chart_add(table, "warning", "%s", at)->warning = true;
    }
}

void preview_add_grid(chart_table *table, const char *key, const ost_geometry *g)
{
    char dims[FORMAT_TEXT], spacing[FORMAT_TEXT];
    chart_add(table, key, "%s voxels of %s: %.0f x %.0f x %.0f mm", format_dims(dims, g->dims),
             format_spacing(spacing, g->spacing), g->dims.x * ost_pm_to_mm(g->spacing.x),
             g->dims.y * ost_pm_to_mm(g->spacing.y), g->dims.z * ost_pm_to_mm(g->spacing.z));
}
