/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Draws pictures of a difference: for each axis the slice with the most differences, and a view of
 * B's surface at the point where these slices meet. In the view, the bone that is in A but not in B
 * is coloured by its depth.
 *
 * Densities are drawn in dimmed grey. Removed voxels are red, added voxels blue and changed voxels
 * amber. Voxels that differ below the threshold are violet.
 */
#include "app/diff/compare.h"

#include <math.h>

#include "app/picture/view.h"
#include "render/slices.h"

enum { PIXELS = 420, VIEW_MM = 60 };

typedef struct pair {
    const loaded_volume *a, *b;
} pair;

static void colour_of(const void *user, size_t v, double rgb[3])
{
    static const double colour[DIFF_KIND_COUNT][3] = {{214, 60, 52}, {38, 120, 214}, {230, 160, 30}, {150, 90, 190}};
    const pair *p = user;
    const int16_t a = p->a->volume.voxels[v], b = p->b->volume.voxels[v];
    const double grey = p->a->kind == LOAD_TOOL ? a * 70.0 : (a + 500.0) / 1800 * 150,
                 dimmed = fmin(150, fmax(0, grey));
    const double *of = colour[diff_kind_of(a, b, p->a->threshold, p->b->threshold)];
    for (int c = 0; c < 3; c++)
        rgb[c] = a == b ? dimmed : of[c];
}

bool diff_unoriented(const loaded_volume *in)
{
    return in->kind == LOAD_TOOL || !view_oriented(&in->volume.meta);
}

ost_status diff_picture(const loaded_volume *a, const loaded_volume *b, const diff_result *result, ost_picture *out,
                        ost_error *err)
{
    const pair both = {a, b};
    const ost_slices_paint paint = {
        .colour = colour_of, .user = &both, .by_voxel = true, .unoriented = diff_unoriented(a)};
    return ost_slices_draw(&a->volume.geometry, result->busiest, PIXELS, &paint, out, err);
}

bool diff_has_view(const loaded_volume *a, const loaded_volume *b, const diff_result *result)
{
    const ost_pm3 s = a->volume.geometry.spacing;
    return ost_geometry_equal(&a->volume.geometry, &b->volume.geometry) && s.x == s.y && s.x == s.z &&
           a->threshold == b->threshold && a->kind == b->kind && a->kind != LOAD_TOOL &&
           result->count[DIFF_REMOVED] > 0;
}

ost_status diff_view(const loaded_volume *a, const loaded_volume *b, const diff_result *result, ost_picture *out,
                     ost_error *err)
{
    const ost_geometry *g = &a->volume.geometry;
    const ost_pm origin[3] = {g->origin.x, g->origin.y, g->origin.z};
    ost_view_options options = {.threshold = b->threshold, .width = 480, .height = 480, .extent_mm = VIEW_MM,
                                .unoriented = diff_unoriented(b)};
    double axis[3];
    bool known = false;
    int32_t lo[3], hi[3];
    ost_status status = ost_axis_from_meta(&b->volume.meta, axis, &known, err);
    ost_active_box(&a->volume, a->threshold, lo, hi);
    for (int i = 0; i < 3; i++) {
        options.centre_mm[i] = ost_pm_to_mm(origin[i] + result->busiest[i] * g->spacing.x);
        options.direction[i] = known ? axis[i] : 0.5 * (lo[i] + hi[i] - 1) - result->busiest[i];
    }
    return status == OST_OK ? ost_picture_view(&b->volume, &a->volume, &options, out, err) : status;
}
