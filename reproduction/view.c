/* SPDX-License-Identifier: Apache-2.0 */
#include "reproduction/view.h"

#include <string.h>

#include "reproduction/models.h"
#include "render/marks.h"
#include "render/viewer.h"

static ost_view_subject subject_of(const view_scene *s)
{
    ost_view_subject subject =
        ost_view_subject_make(&s->bone->geometry, s->glenoid ? &s->glenoid->at : NULL,
                              s->glenoid ? s->glenoid->axis : NULL, s->glenoid && s->glenoid->left);
    ost_view_subject_fit(&subject, s->bone, MODEL_THRESHOLD);
    return subject;
}

/* Draws the scale bar, the letters of the directions and the legend over the frame. */
static ost_status draw_marks(const view_scene *s, const ost_viewer *viewer, const ost_orbit *orbit, ost_error *err)
{
    const ost_sheet sheet = ost_frame_sheet(&viewer->frame);
    const double unit = ost_marks_unit(sheet.height);
    ost_lettering *letters = NULL;
    ost_marks marks = {.mm_per_pixel = orbit->distance / (OST_VIEW_FOCAL * sheet.height)};
    double back[3];
    if (!s->unoriented)
        ost_orbit_frame(orbit, marks.right, marks.up, back);
    if (s->before)
        marks.legend = (ost_legend){.colouring = OST_COLOUR_DEPTH, .scale_mm = viewer->reference.scale_mm};
    ost_status status = ost_lettering_create(OST_MARKS_LETTER * unit, &letters, err);
    if (status == OST_OK)
        ost_marks_draw(&marks, letters, &sheet, unit);
    ost_lettering_free(letters);
    return status;
}

static ost_status set_before(const view_scene *s, ost_viewer *viewer, ost_error *err)
{
    const ost_density_classes classes = ost_density_classes_default();
    ost_volume copy = {.voxels = NULL};
    ost_status status = ost_volume_init(&copy, &s->before->geometry, err);
    if (status != OST_OK)
        return status;
    memcpy(copy.voxels, s->before->voxels, (size_t)ost_dims_count(copy.geometry.dims) * sizeof *copy.voxels);
    status = ost_viewer_set_uncut(viewer, &copy, MODEL_THRESHOLD, &classes, s->glenoid ? &s->glenoid->at : NULL,
                                  s->glenoid ? s->glenoid->axis : NULL, err);
    if (status == OST_OK)
        ost_viewer_set_colouring(viewer, OST_COLOUR_DEPTH);
    ost_volume_free(&copy);
    return status;
}

static ost_status set_scene(const view_scene *s, ost_viewer *viewer, ost_error *err)
{
    ost_status status = ost_viewer_init(viewer, &s->bone->geometry, s->style, NULL, s->threads, err);
    if (status == OST_OK && s->before)
        status = set_before(s, viewer, err);
    if (status == OST_OK)
        status = ost_surface_set_volume(&viewer->bone, s->bone, MODEL_THRESHOLD, err);
    if (status == OST_OK && s->tool)
        status = ost_viewer_add_tool(viewer, s->tool, err);
    if (status == OST_OK)
        status = ost_viewer_update(viewer, err);
    viewer->overlays = s->overlays;
    viewer->has_state = s->tool != NULL;
    viewer->state = (ost_live_state){.ticks = 1, .pose = s->pose};
    return status;
}

ost_status view_draw(const view_scene *s, uint8_t **png, size_t *size, ost_error *err)
{
    ost_viewer viewer;
    ost_camera camera;
    ost_picture picture = {.rgb = NULL};
    const ost_view_subject subject = subject_of(s);
    ost_orbit orbit = ost_view_orbit(s->view, &subject, s->tool ? &s->pose : NULL);
    orbit.azimuth += s->turn;
    orbit.elevation += s->lift;
    if (s->extent_mm > 0)
        orbit.distance = OST_VIEW_FOCAL * s->extent_mm;
    *png = NULL;
    ost_status status = set_scene(s, &viewer, err);
    if (status == OST_OK)
        status = ost_orbit_camera(&orbit, VIEW_WIDTH, VIEW_HEIGHT, &camera, err);
    if (status == OST_OK)
        status = ost_camera_check(&camera, err);
    if (status == OST_OK)
        status = ost_viewer_draw(&viewer, &camera, err);
    if (status == OST_OK)
        status = draw_marks(s, &viewer, &orbit, err);
    if (status == OST_OK)
        status = ost_picture_init(&picture, VIEW_WIDTH, VIEW_HEIGHT, err);
    if (status == OST_OK) {
        ost_frame_copy(&viewer.frame, &picture);
        status = ost_picture_encode_png(&picture, png, size, err);
    }
    ost_picture_free(&picture);
    ost_viewer_free(&viewer);
    return status;
}

ost_status view_deepest(ost_builtin path, const ost_glenoid *glenoid, const ost_tool_geometry *tool, ost_pose *out,
                        ost_error *err)
{
    ost_path ticks = {.ticks = NULL};
    ost_status status = ost_builtin_path(path, glenoid, tool, 0, &ticks, err);
    double most = 0;
    for (size_t i = 0; i < ticks.count && status == OST_OK; i++) {
        const ost_pm3 t = ticks.ticks[i].pose.t;
        const double depth =
            (double)t.x * glenoid->axis[0] + (double)t.y * glenoid->axis[1] + (double)t.z * glenoid->axis[2];
        if (i > 0 && depth <= most)
            continue;
        most = depth;
        *out = ticks.ticks[i].pose;
    }
    ost_path_free(&ticks);
    return status;
}
