/* SPDX-License-Identifier: Apache-2.0 */
#include "render/viewer.h"

#include "core/face_mesh.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

ost_status ost_viewer_init(ost_viewer *viewer, const ost_geometry *bone, ost_style style, const char *isa, int threads,
                           ost_error *err)
{
    memset(viewer, 0, sizeof *viewer);
    viewer->style = style;
    viewer->paint = OST_PAINT_BONE;
    viewer->threads = threads;
    ost_status status = ost_isa_choose(isa, &viewer->isa, err);
    ost_palette_make(OST_COLOUR_BONE, viewer->palette);
    return status == OST_OK ? ost_surface_init(&viewer->bone, bone, err) : status;
}

void ost_viewer_free(ost_viewer *viewer)
{
    ost_surface_free(&viewer->bone);
    ost_surface_free(&viewer->ghost);
    ost_uncut_free(&viewer->reference);
    for (int i = 0; i < viewer->tools; i++) {
        ost_surface_free(&viewer->tool[i]);
        ost_smooth_mesh_free(&viewer->tool_mesh[i]);
    }
    ost_frame_free(&viewer->frame);
    ost_gl_close(viewer->gl);
    memset(viewer, 0, sizeof *viewer);
}

ost_status ost_viewer_use_gl(ost_viewer *viewer, const ost_gl_variant *variant, ost_error *err)
{
    viewer->variant = variant;
    return viewer->gl ? OST_OK : ost_gl_open(NULL, &viewer->gl, err);
}

ost_status ost_viewer_use_current(ost_viewer *viewer, ost_error *err)
{
    const ost_gl_options options = {.hardware = true, .current = true};
    ost_status status = ost_gl_open(&options, &viewer->gl, err);
    viewer->gl_current = status == OST_OK;
    return status;
}

void ost_viewer_context_lost(ost_viewer *viewer, const char *reason)
{
    if (!viewer->gl || !viewer->gl_current)
        return;
    snprintf(viewer->lost, sizeof viewer->lost, "%s", reason);
    ost_gl_abandon(viewer->gl);
    viewer->gl = NULL;
}

void ost_viewer_use_card(ost_viewer *viewer)
{
    const ost_gl_options options = {.hardware = true};
    ost_error err = {0};
    viewer->variant = &ost_gl_ours;
    if (!viewer->gl && ost_gl_open(&options, &viewer->gl, &err) != OST_OK)
        snprintf(viewer->no_card, sizeof viewer->no_card, "%s", err.text);
}

ost_status ost_viewer_use_mesh(ost_viewer *viewer, ost_backend *mesher, ost_error *err)
{
    const ost_face_cluster nothing = {0};
    ost_face_mesh mesh = {0};
    ost_status status = ost_viewer_use_gl(viewer, &ost_gl_mesh, err);
    if (status == OST_OK)
        status = ost_backend_face_mesh(mesher, &nothing, 1, &mesh, err);
    ost_face_mesh_free(&mesh);
    if (status == OST_OK)
        ost_gl_set_mesher(viewer->gl, mesher);
    return status;
}

/*
 * Returns the tool's grid as a geometry like that of a bone: the origin is the centre of the first voxel, not the
 * corner of the grid. Half a voxel is rounded down to picometres; the error is invisible.
 */
static ost_geometry grid_of(const ost_tool_geometry *t)
{
    const ost_pm s = t->voxel, half = s / 2;
    return (ost_geometry){t->dims, {s, s, s}, {t->corner.x + half, t->corner.y + half, t->corner.z + half}};
}

/* Creates the surface of a tool. The surface is empty on failure. */
static ost_status surface_of(const ost_tool_volume *volume, ost_surface *surface, ost_error *err)
{
    const ost_geometry g = grid_of(&volume->geometry);
    ost_volume solid = {0};
    ost_status status = ost_surface_init(surface, &g, err);
    if (status == OST_OK)
        status = ost_volume_init(&solid, &g, err);
    for (int64_t i = 0; status == OST_OK && i < ost_dims_count(g.dims); i++)
        solid.voxels[i] = volume->voxels[i];
    if (status == OST_OK)
        status = ost_surface_set_volume(surface, &solid, 1, err);
    if (status == OST_OK)
        status = ost_surface_update(surface, err);
    ost_volume_free(&solid);
    if (status != OST_OK)
        ost_surface_free(surface);
    return status;
}

ost_status ost_viewer_add_tool(ost_viewer *viewer, const ost_tool_volume *volume, ost_error *err)
{
    if (viewer->tools == OST_VIEWER_TOOLS)
        return ost_fail(err, OST_ERR_USAGE, "too many tools; expected at most %d", OST_VIEWER_TOOLS);
    ost_status status = surface_of(volume, &viewer->tool[viewer->tools], err);
    if (status == OST_OK)
        viewer->tool_grid[viewer->tools++] = volume->geometry;
    return status;
}

ost_status ost_viewer_smooth_tool(ost_viewer *viewer, const ost_mesh *parts, int count, ost_error *err)
{
    const int tool = viewer->tools - 1;
    return ost_smooth_mesh_make(parts, count, &viewer->tool_grid[tool], &viewer->tool_mesh[tool], err);
}

ost_status ost_viewer_set_uncut(ost_viewer *viewer, ost_volume *before, int32_t threshold,
                                const ost_density_classes *classes, const ost_pm3 *at, const double *axis,
                                ost_error *err)
{
    ost_surface_set_uncut(&viewer->bone, NULL, NULL);
    ost_uncut_free(&viewer->reference);
    ost_status status = ost_uncut_init(&viewer->reference, before, threshold, classes, at, axis, err);
    viewer->has_uncut = status == OST_OK;
    return status == OST_OK ? ost_surface_set_uncut(&viewer->bone, &viewer->reference, err) : status;
}

void ost_viewer_set_colouring(ost_viewer *viewer, ost_colouring colouring)
{
    ost_surface_set_colouring(&viewer->bone, colouring);
    ost_palette_make(colouring, viewer->palette);
}

void ost_viewer_set_clip(ost_viewer *viewer, const ost_clip *clip)
{
    ost_surface_clip(&viewer->bone, clip);
}

ost_status ost_viewer_set_ghost(ost_viewer *viewer, const ost_tool_volume *volume, const ost_pose *pose, ost_error *err)
{
    ost_surface_free(&viewer->ghost);
    ost_status status = surface_of(volume, &viewer->ghost, err);
    viewer->has_ghost = viewer->show_ghost = status == OST_OK;
    viewer->ghost_pose = *pose;
    return status;
}

void ost_viewer_set_contact(ost_viewer *viewer, bool shown)
{
    viewer->bone.shows_contact = shown;
    if (!shown) {
        ost_surface_age(&viewer->bone);
        ost_surface_age(&viewer->bone);
    }
}

void ost_viewer_follow(ost_viewer *viewer, ost_live_channel *live)
{
    viewer->live = live;
}

static ost_status take(void *user, const int32_t at[3], const uint32_t *words, ost_error *err)
{
    ost_viewer *viewer = user;
    viewer->changed++;
    if (viewer->scene.changed < OST_OVERLAY_CHANGED)
        memcpy(viewer->scene.changed_at[viewer->scene.changed++], at, sizeof(int32_t[3]));
    return ost_surface_set_chunk(&viewer->bone, at, ost_live_chunk_size(viewer->live), words, err);
}

ost_status ost_viewer_update(ost_viewer *viewer, ost_error *err)
{
    ost_status status = OST_OK;
    if (viewer->live) {
        viewer->scene.changed = 0;
        viewer->has_state = ost_live_state_get(viewer->live, &viewer->state);
        const int64_t now = viewer->has_state ? viewer->state.t_ns : 0;
        if (now < viewer->aged_ns || now - viewer->aged_ns >= OST_VIEWER_FRESH_NS) {
            ost_surface_age(&viewer->bone);
            viewer->aged_ns = now;
        }
        status = ost_live_take(viewer->live, take, viewer, err);
    }
    return status == OST_OK ? ost_surface_update(&viewer->bone, err) : status;
}

/*
 * Closes OpenGL if `status` is a failure of OpenGL, so that the CPU draws from now on. OST_ERR_RANGE is not a failure
 * of OpenGL: the camera is out of range, which the CPU renderer would report too.
 */
static void check_gl(ost_viewer *viewer, ost_status status, const ost_error *why)
{
    if (status == OST_OK || status == OST_ERR_RANGE)
        return;
    memcpy(viewer->lost, why->text, sizeof viewer->lost);
    ost_gl_close(viewer->gl);
    viewer->gl = NULL;
}

/* Draws with OpenGL. Returns false if the CPU must draw the frame instead. */
static bool draw_gl(ost_viewer *viewer, const ost_frame_thing *things, int count)
{
    ost_error why = {0};
    if (!viewer->gl)
        return false;
    ost_status status = ost_gl_draw(viewer->gl, viewer->variant, things, count, viewer->style, &why);
    if (status == OST_OK)
        status = ost_gl_read(viewer->gl, &viewer->frame, true, &why);
    check_gl(viewer, status, &why);
    return status == OST_OK;
}

/* Returns the smooth mesh to draw for a tool, or NULL to draw its voxels. With flat faces, as in the thesis, tools
   are always drawn as voxels. */
static const ost_smooth_mesh *mesh_of(const ost_viewer *viewer, int tool)
{
    const ost_smooth_mesh *mesh = &viewer->tool_mesh[tool];
    return viewer->style == OST_STYLE_SMOOTH && mesh->count ? mesh : NULL;
}

/* Lists the objects to draw: the bone, and the tool at its pose. Returns their number. */
static int things_of(ost_viewer *viewer, const ost_camera *camera, ost_frame_thing things[2])
{
    const ost_live_state *s = &viewer->state;
    ost_overlay_scene *scene = &viewer->scene;
    int count = 1;
    things[0] = (ost_frame_thing){.surface = &viewer->bone,
                                  .eye = ost_eye_make(camera, &viewer->bone.geometry),
                                  .paint = viewer->paint,
                                  .palette = viewer->palette};
    scene->bone = &viewer->bone;
    scene->tool = NULL;
    scene->chunk = viewer->live ? ost_live_chunk_size(viewer->live) : OST_BLOCK;
    if (viewer->has_state && s->ticks > 0 && s->tool >= 0 && s->tool < viewer->tools) {
        scene->tool = &viewer->tool[s->tool];
        scene->tool_grid = viewer->tool_grid[s->tool];
        scene->pose = s->pose;
        things[count++] = (ost_frame_thing){.surface = scene->tool,
                                            .eye = ost_eye_make_from(camera, &scene->tool->geometry, &s->pose),
                                            .paint = OST_PAINT_STEEL,
                                            .mesh = mesh_of(viewer, s->tool)};
    }
    return count;
}

ost_status ost_viewer_draw_gl(ost_viewer *viewer, const ost_camera *camera, const double middle[2], ost_error *err)
{
    ost_frame_thing things[2];
    const int count = things_of(viewer, camera, things);
    if (!viewer->gl)
        return ost_fail(err, OST_ERR_UNAVAILABLE, "only OpenGL can draw this picture");
    for (int i = 0; middle && i < count; i++) {
        things[i].eye.half_w = (float)middle[0];
        things[i].eye.half_h = (float)middle[1];
    }
    return ost_gl_draw(viewer->gl, viewer->variant, things, count, viewer->style, err);
}

bool ost_viewer_can_show(const ost_viewer *viewer)
{
    return viewer->gl && viewer->gl_current && !(viewer->has_ghost && viewer->show_ghost) && !viewer->overlays;
}

ost_status ost_viewer_show(ost_viewer *viewer, const ost_camera *camera, const ost_gl_sheet *sheet, ost_error *err)
{
    ost_error why = {0};
    const bool smooth = viewer->antialiased && viewer->style == OST_STYLE_SMOOTH && viewer->variant != &ost_gl_thesis;
    ost_status status = ost_viewer_draw_gl(viewer, camera, NULL, &why);
    if (status == OST_OK)
        status = ost_gl_show(viewer->gl, 0, smooth, sheet, &why);
    if (status != OST_OK && err)
        *err = why;
    check_gl(viewer, status, &why);
    return status;
}

ost_status ost_viewer_draw(ost_viewer *viewer, const ost_camera *camera, ost_error *err)
{
    ost_status status = OST_OK;
    if (viewer->frame.width != camera->width || viewer->frame.height != camera->height) {
        ost_frame_free(&viewer->frame);
        status = ost_frame_init(&viewer->frame, camera->width, camera->height, viewer->style, viewer->isa,
                                viewer->threads, err);
        if (status == OST_OK)
            status = ost_frame_store(&viewer->frame, err);
        if (status == OST_OK && viewer->antialiased && viewer->variant != &ost_gl_thesis)
            status = ost_frame_antialias(&viewer->frame, viewer->isa, err);
    }
    if (status != OST_OK)
        return status;
    viewer->frame.style = viewer->style;
    ost_frame_thing things[2];
    const int count = things_of(viewer, camera, things);
    const ost_eye eye = things[0].eye;
    if (draw_gl(viewer, things, count))
        ost_frame_overwritten(&viewer->frame);
    else
        status = ost_frame_draw_things(&viewer->frame, things, count, err);
    if (status == OST_OK && viewer->has_ghost && viewer->show_ghost) {
        const ost_frame_thing ghost = {.surface = &viewer->ghost,
                                       .eye = ost_eye_make_from(camera, &viewer->ghost.geometry, &viewer->ghost_pose),
                                       .paint = OST_PAINT_GHOST};
        status = ost_frame_draw_ghost(&viewer->frame, &ghost, OST_GHOST, viewer->bone.geometry.spacing.x, err);
    }
    if (status == OST_OK && viewer->overlays)
        ost_overlay_draw(&viewer->frame, &eye, viewer->overlays, &viewer->scene);
    return status;
}
