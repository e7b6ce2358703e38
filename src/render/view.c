/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Draws a view of a volume as a picture: one frame of a viewer, with marks.
 *
 *   the volume, and the volume before the operation --> viewer: surface, uncut surface, colours of depth
 *   direction, extent, or the box of the active voxels --> camera
 *   frame of 2 x 2 samples for each pixel --means--> smooth edges; marks --> picture
 */
#include "render/view.h"

#include <math.h>
#include <string.h>

#include "core/vector.h"
#include "render/marks.h"
#include "render/viewer.h"
#include "render/views.h"

enum { THRESHOLD = 120, SIDE = 800 };
/* fraction of the picture's height or width that the box of the active voxels fills */
static const double FILLED = 0.94;

/* The camera's axes as unit vectors in the patient's frame, and the point that the camera looks at. */
typedef struct aim {
    double right[3], up[3], forward[3], at[3];
    double distance; /* mm */
} aim;

static ost_status find_axes(const ost_view_options *o, aim *a, ost_error *err)
{
    memcpy(a->forward, o->direction, sizeof a->forward);
    ost_vector_unit(a->forward, 1);
    double up[3] = {o->up[0], o->up[1], o->up[2]};
    if (ost_vector_dot(up, up) == 0)
        up[fabs(a->forward[2]) > 0.99 ? 1 : 2] = fabs(a->forward[2]) > 0.99 ? -1 : 1;
    ost_vector_unit(up, 2);
    ost_vector_cross(a->forward, up, a->right);
    if (!(ost_vector_dot(a->right, a->right) > 1e-8))
        return ost_fail(err, OST_ERR_USAGE, "the view's direction %g %g %g and its up %g %g %g are parallel",
                        o->direction[0], o->direction[1], o->direction[2], o->up[0], o->up[1], o->up[2]);
    ost_vector_unit(a->right, 0);
    ost_vector_cross(a->right, a->forward, a->up);
    return OST_OK;
}

/* Directs the camera at the middle of the active voxels' box. Sets the distance so that the picture contains the
   complete box. */
static void fit(const ost_volume *volume, int32_t threshold, double aspect, aim *a)
{
    const ost_geometry *g = &volume->geometry;
    const double mm = ost_pm_to_mm(g->spacing.x),
                 origin[3] = {ost_pm_to_mm(g->origin.x), ost_pm_to_mm(g->origin.y), ost_pm_to_mm(g->origin.z)};
    int32_t lo[3], hi[3];
    double half[3];
    ost_active_box(volume, threshold, lo, hi);
    a->distance = 2 * mm;
    for (int i = 0; i < 3; i++) {
        half[i] = 0.5 * mm * (hi[i] - lo[i]);
        a->at[i] = origin[i] + 0.5 * mm * (lo[i] + hi[i] - 1);
    }
    for (int corner = 0; corner < 8; corner++) {
        double c[3];
        for (int i = 0; i < 3; i++)
            c[i] = corner >> i & 1 ? half[i] : -half[i];
        const double high = fmax(fabs(ost_vector_dot(c, a->up)), fabs(ost_vector_dot(c, a->right)) / aspect);
        a->distance = fmax(a->distance, 2 * OST_VIEW_FOCAL * high / FILLED - ost_vector_dot(c, a->forward));
    }
}

/* Replaces each 2 x 2 pixels of the frame with their mean colour, in place: a mean overwrites only a pixel that has
   already been read. */
static void halve(ost_sheet *sheet)
{
    sheet->width /= 2;
    sheet->height /= 2;
    for (int y = 0; y < sheet->height; y++)
        for (int x = 0; x < sheet->width; x++) {
            const uint32_t *from = sheet->pixels + (size_t)(2 * y) * (size_t)sheet->stride + 2 * x;
            const uint32_t four[4] = {from[0], from[1], from[sheet->stride], from[sheet->stride + 1]};
            /* each channel starts at 2, half of the divisor, so that the mean is rounded */
            uint32_t odd = 0x020002, green = 0x0200;
            for (int i = 0; i < 4; i++) {
                odd += four[i] & 0xff00ff;
                green += four[i] & 0x00ff00;
            }
            sheet->pixels[(size_t)y * (size_t)sheet->stride + (size_t)x] = (odd >> 2 & 0xff00ff) |
                                                                           (green >> 2 & 0x00ff00);
        }
}

static ost_status mark(const ost_sheet *sheet, const ost_viewer *viewer, const aim *a, const ost_view_options *o,
                       double unit, bool depths, ost_error *err)
{
    ost_marks marks = {.mm_per_pixel = a->distance / (OST_VIEW_FOCAL * sheet->height)};
    ost_lettering *letters;
    ost_status status = ost_lettering_create(OST_MARKS_LETTER * unit, &letters, err);
    if (status != OST_OK)
        return status;
    if (!o->tool && !o->unoriented) {
        memcpy(marks.right, a->right, sizeof marks.right);
        memcpy(marks.up, a->up, sizeof marks.up);
    }
    if (depths)
        marks.legend = (ost_legend){.colouring = OST_COLOUR_DEPTH, .scale_mm = viewer->reference.scale_mm};
    ost_marks_draw(&marks, letters, sheet, unit);
    ost_lettering_free(letters);
    return OST_OK;
}

/*
 * Draws a view for ost_picture_view and ost_view_draw. `before` is the uncut bone or NULL. `labels` and `unit` have the
 * same meaning as for ost_view_draw.
 */
static ost_status draw(const ost_volume *volume, const ost_volume *before, bool labels, double unit,
                       const ost_view_options *options, ost_picture *out, ost_error *err)
{
    static const ost_view_options defaults;
    const ost_view_options *o = options ? options : &defaults;
    const int32_t threshold = o->threshold > 0 ? o->threshold : THRESHOLD;
    const ost_density_classes classes = ost_density_classes_default();
    *out = (ost_picture){0};
    if (!volume->voxels)
        return ost_fail(err, OST_ERR_USAGE, "a view needs a volume with voxels");
    if (before && (!before->voxels || !ost_geometry_equal(&volume->geometry, &before->geometry)))
        return ost_fail(err, OST_ERR_USAGE, "both volumes must have the same dims, spacing and origin");

    ost_viewer viewer;
    aim a = {0};
    const int width = o->width > 0 ? o->width : SIDE, height = o->height > 0 ? o->height : SIDE;
    /* samples per pixel on each axis */
    const int samples = width <= OST_FRAME_MAX / 2 && height <= OST_FRAME_MAX / 2 ? 2 : 1;
    ost_camera camera = {.width = samples * width, .height = samples * height};
    ost_volume uncut = before ? *before : *volume; /* shares the caller's voxels, so the viewer must not free them */
    camera.focal_milli = (int32_t)(OST_VIEW_FOCAL * 1000 * camera.height);
    ost_status status = ost_viewer_init(&viewer, &volume->geometry, OST_STYLE_SMOOTH, NULL, o->threads, err);
    if (status == OST_OK && o->tool)
        viewer.paint = OST_PAINT_STEEL;
    else if (status == OST_OK)
        status = ost_viewer_set_uncut(&viewer, &uncut, threshold, &classes, NULL, NULL, err);
    viewer.reference.uncut = labels;
    if (status == OST_OK && (before || labels))
        ost_viewer_set_colouring(&viewer, before ? OST_COLOUR_DEPTH : OST_COLOUR_LABEL);
    /* Fits the picture to the uncut bone, so that pictures before and after a removal show the same region. */
    if (status == OST_OK)
        status = find_axes(o, &a, err);
    if (o->extent_mm > 0) {
        a.distance = OST_VIEW_FOCAL * o->extent_mm;
        memcpy(a.at, o->centre_mm, sizeof a.at);
    } else if (status == OST_OK) {
        fit(before ? before : volume, threshold, (double)width / height, &a);
    }
    if (status == OST_OK)
        status = ost_surface_set_volume(&viewer.bone, volume, threshold, err);
    if (status == OST_OK)
        status = ost_surface_update(&viewer.bone, err);
    if (status == OST_OK) {
        double eye[3];
        for (int i = 0; i < 3; i++)
            eye[i] = a.at[i] - a.distance * a.forward[i];
        status = ost_camera_look_at(eye, a.at, a.up, &camera, err);
    }
    if (status == OST_OK)
        status = ost_camera_check(&camera, err);
    if (status == OST_OK)
        status = ost_viewer_draw(&viewer, &camera, err);
    if (status == OST_OK)
        status = ost_picture_init(out, width, height, err);
    if (status == OST_OK) {
        ost_sheet sheet = ost_frame_sheet(&viewer.frame);
        sheet.written = NULL; /* no cells need to be recorded, because no further frame is drawn */
        if (samples == 2)
            halve(&sheet);
        if (!o->no_legend)
            status = mark(&sheet, &viewer, &a, o, unit > 0 ? unit : ost_marks_unit(height), before != NULL, err);
        ost_colours_copy(sheet.pixels, sheet.stride, out);
    }
    if (status != OST_OK)
        ost_picture_free(out);
    viewer.reference.volume = (ost_volume){.voxels = NULL};
    ost_viewer_free(&viewer);
    return status;
}

ost_status ost_picture_view(const ost_volume *volume, const ost_volume *before, const ost_view_options *options,
                            ost_picture *out, ost_error *err)
{
    return draw(volume, before, false, 0, options, out, err);
}

ost_status ost_view_draw(const ost_volume *volume, bool labels, double unit, const ost_view_options *options,
                         ost_picture *out, ost_error *err)
{
    return draw(volume, NULL, labels, unit, options, out, err);
}
