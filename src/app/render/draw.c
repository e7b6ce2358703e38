/* SPDX-License-Identifier: Apache-2.0 */
#include "app/render/render.h"

#include "app/common/backend_choice.h"
#include "app/common/progress.h"
#include "app/input/ream_path.h"
#include "app/picture/tool.h"
#include "core/clock.h"

/* Adds the tool to the picture. If --pose is not given, the pose is the first pose of the built-in reaming path. */
static ost_status add_tool(const render_args *args, render_drawing *d, const ost_glenoid *glenoid, bool known,
                           ost_error *err)
{
    ost_path path = {0};
    ost_pose pose = args->pose;
    ost_status status = ost_tool_download(d->tool, &d->tool_volume, err);
    if (status == OST_OK)
        status = picture_add_tool(&d->viewer, d->tool, args->tool, &args->how, err);
    if (status == OST_OK && !args->pose_text && !known)
        status = ost_fail(err, OST_ERR_USAGE,
                          "%s: the glenoid's position is not set: pass --pose X,Y,Z,QW,QX,QY,QZ, or --at and --axis",
                          args->bone);
    if (status == OST_OK && !args->pose_text) {
        status = ost_builtin_path(OST_BUILTIN_GLENOID_REAM, glenoid, ost_tool_geometry_get(d->tool), 0, &path, err);
        if (status == OST_OK)
            pose = path.ticks[0].pose;
    }
    if (status == OST_OK) {
        d->viewer.has_state = true;
        d->viewer.state = (ost_live_state){.ticks = 1, .pose = pose};
    }
    ost_path_free(&path);
    return status;
}

/* Sets the uncut surface from the bone of --before or, if --before is not given, from the bone itself. */
static ost_status add_uncut(const app_state *app, const render_args *args, render_drawing *d,
                            const ost_glenoid *glenoid, bool known, ost_error *err)
{
    const ost_density_classes classes = ost_density_classes_default();
    ost_bone_info info;
    ost_bone *bone = NULL;
    ost_import_result imported;
    ost_status status = args->before ? load_bone(app, d->backend, args->before, &args->ct, false, &bone, &imported, err)
                                     : OST_OK;
    if (status == OST_OK)
        status = ost_bone_info_get(args->before ? bone : d->bone, &info, err);
    if (status == OST_OK && !ost_geometry_equal(&info.geometry, &d->viewer.bone.geometry))
        status = ost_fail(err, OST_ERR_INPUT, "%s and %s differ in dims, spacing or origin", args->before, args->bone);
    if (status == OST_OK)
        status = bone_to_volume(args->before ? bone : d->bone, NULL, &d->before, err);
    if (status == OST_OK)
        status = ost_viewer_set_uncut(&d->viewer, &d->before, info.threshold, &classes, known ? &glenoid->at : NULL,
                                      known ? glenoid->axis : NULL, err);
    d->viewer.reference.uncut = !args->before;
    ost_bone_free(bone);
    return status;
}

/* Makes the viewer of the bone, with the tool and the uncut surface. */
static ost_status make_viewer(const app_state *app, const render_args *args, render_drawing *d, ost_error *err)
{
    ost_glenoid glenoid;
    ost_status status = ost_live_create(d->bone, &d->live, err);
    if (status != OST_OK)
        return status;
    const ost_geometry *g = ost_live_geometry(d->live);
    status = view_subject(app, &args->view, &args->target, &d->imported.meta, g, args->bone, &glenoid, &d->subject,
                          err);
    const bool known = d->subject.has_face;
    if (status == OST_OK)
        status = ost_viewer_init(&d->viewer, g, args->style ? OST_STYLE_FACES : OST_STYLE_SMOOTH, NULL,
                                 (int)app->threads, err);
    if (status != OST_OK)
        return status;
    if (args->renderer == RENDERER_MESH)
        status = ost_viewer_use_mesh(&d->viewer, d->backend, err);
    else if (args->renderer == RENDERER_AUTO)
        ost_viewer_use_card(&d->viewer);
    else if (args->renderer != RENDERER_POINTS)
        status = ost_viewer_use_gl(&d->viewer, args->renderer == RENDERER_GL ? &ost_gl_ours : &ost_gl_thesis, err);
    ost_viewer_follow(&d->viewer, d->live);
    if (status == OST_OK)
        status = add_uncut(app, args, d, &glenoid, known, err);
    if (status == OST_OK && d->tool)
        status = add_tool(args, d, &glenoid, known, err);
    return status;
}

/* Draws a frame of the viewer with its legend, and writes the frame as a file. */
static ost_status draw_picture(const render_args *args, render_drawing *d, ost_error *err)
{
    ost_camera camera;
    view_fit(&args->target, &d->viewer.reference.volume, d->viewer.reference.threshold, &d->subject);
    const ost_orbit orbit = view_orbit(&args->view, &d->subject, d->tool ? &d->viewer.state.pose : NULL);
    double eye[3], q[4];
    ost_status status = ost_orbit_camera(&orbit, args->width, args->height, &camera, err);
    if (status != OST_OK)
        return status;
    ost_pose_to_doubles(&camera.pose, eye, q);
    const ost_live_state state = d->viewer.state;
    const bool has_state = d->viewer.has_state;
    status = appearance_begin(&d->look, &d->viewer, &d->subject, args->depth_mm, d->tool ? &d->tool_volume : NULL,
                              &args->look, eye, err);
    if (status == OST_OK)
        status = ost_viewer_update(&d->viewer, err);
    d->viewer.state = state;
    d->viewer.has_state = has_state;
    d->viewer.scene.changed = 0;
    const int64_t begin = ost_clock_ns();
    if (status == OST_OK)
        status = ost_viewer_draw(&d->viewer, &camera, err);
    d->draw_ms = (double)(ost_clock_ns() - begin) * 1e-6;
    if (status == OST_OK && !args->look.no_legend)
        status = appearance_marks(&d->look, &orbit, view_oriented(&d->imported.meta), err);
    if (status == OST_OK)
        status = ost_picture_init(&d->picture, args->width, args->height, err);
    if (status != OST_OK)
        return status;
    ost_frame_copy(&d->viewer.frame, &d->picture);
    return ost_picture_write_png(args->out, &d->picture, err);
}

ost_status render_draw(const app_state *app, const render_args *args, render_drawing *d, ost_error *err)
{
    ost_status status = backend_choose(app, &d->backend, err);
    if (status == OST_OK && args->tool)
        status = load_tool(app, d->backend, args->tool, NULL, &args->how, &d->tool, NULL, err);
    if (status == OST_OK)
        status = load_bone(app, d->backend, args->bone, &args->ct, false, &d->bone, &d->imported, err);
    if (status != OST_OK)
        return status;
    progress_show(NULL, "drawing", 0);
    status = make_viewer(app, args, d, err);
    return status == OST_OK ? draw_picture(args, d, err) : status;
}

void render_free(render_drawing *d)
{
    ost_picture_free(&d->picture);
    appearance_free(&d->look);
    ost_volume_free(&d->before);
    ost_tool_volume_free(&d->tool_volume);
    ost_viewer_free(&d->viewer);
    ost_live_free(d->live);
    ost_tool_free(d->tool);
    ost_bone_free(d->bone);
    ost_backend_close(d->backend);
}
