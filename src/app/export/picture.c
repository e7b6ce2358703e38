/* SPDX-License-Identifier: Apache-2.0 */
#include "app/export/export.h"

#include <math.h>
#include <string.h>

#include "app/common/print.h"
#include "app/common/progress.h"
#include "app/common/result.h"
#include "app/film/frame_size.h"

/*
 * Computes the indices of the voxel that contains the position of --at. If --at is not given, each index is -1, which
 * means the middle.
 */
static ost_status voxel_at(const app_state *app, const export_args *args, const ost_geometry *g, int32_t at[3],
                           ost_error *err)
{
    at[0] = at[1] = at[2] = -1;
    if (!args->target.at_given)
        return OST_OK;
    const ost_pm p[3] = {args->target.at.x - g->origin.x, args->target.at.y - g->origin.y,
                         args->target.at.z - g->origin.z};
    const ost_pm s[3] = {g->spacing.x, g->spacing.y, g->spacing.z};
    const int32_t n[3] = {g->dims.x, g->dims.y, g->dims.z};
    for (int a = 0; a < 3; a++) {
        int64_t v = (int64_t)floor((double)p[a] / (double)s[a] + 0.5);
        if (v < 0 || v >= n[a]) {
            char text[FORMAT_TEXT];
            return usage_error(app, err, "--at %s lies outside the grid of %s", format_point(text, args->target.at),
                               args->bone);
        }
        at[a] = (int32_t)v;
    }
    return OST_OK;
}

static ost_status draw_view(const app_state *app, const export_args *args, loaded_volume *in, loaded_volume *before,
                            ost_picture *out, ost_error *err)
{
    ost_glenoid glenoid;
    ost_view_subject subject;
    ost_view_options options = {.width = 800,
                                .height = 800,
                                .threads = (int)app->threads,
                                .tool = in->kind == LOAD_TOOL,
                                .unoriented = !view_oriented(&in->volume.meta)};
    double right[3], back[3];
    ost_status status = args->view.size ? frame_size(app, args->view.size, &options.width, &options.height, err)
                                        : OST_OK;
    if (status == OST_OK)
        status = loaded_to_bone(app, args->bone, in, err);
    if (status == OST_OK && args->before)
        status = loaded_to_bone(app, args->before, before, err);
    if (status == OST_OK)
        status = view_subject(app, &args->view, &args->target, &in->volume.meta, &in->volume.geometry, args->bone,
                              &glenoid, &subject, err);
    if (status != OST_OK)
        return status;
    view_fit(&args->target, args->before ? &before->volume : &in->volume, in->threshold, &subject);
    const ost_orbit orbit = view_orbit(&args->view, &subject, NULL);
    ost_orbit_frame(&orbit, right, options.up, back);
    for (int a = 0; a < 3; a++)
        options.direction[a] = -back[a];
    memcpy(options.centre_mm, orbit.at, sizeof options.centre_mm);
    options.extent_mm = orbit.distance / OST_VIEW_FOCAL;
    options.threshold = in->threshold;
    return ost_picture_view(&in->volume, args->before ? &before->volume : NULL, &options, out, err);
}

static ost_status draw_slices(const app_state *app, const export_args *args, const loaded_volume *in,
                              const ost_volume *before, ost_picture *out, ost_error *err)
{
    ost_slices_options options = {.threshold = in->threshold,
                                  .unoriented = in->kind == LOAD_TOOL || !view_oriented(&in->volume.meta)};
    int height = 0;
    ost_status status = voxel_at(app, args, &in->volume.geometry, options.at, err);
    if (status == OST_OK && args->view.size)
        status = frame_size(app, args->view.size, &options.pixels, &height, err);
    if (status == OST_OK && height != options.pixels)
        return usage_error(app, err, "--size %s: expected one number for slices: the longest side in pixels",
                           args->view.size);
    if (in->kind == LOAD_TOOL) {
        options.level = 1;
        options.width = 3;
    }
    return status == OST_OK ? ost_picture_slices(&in->volume, before, &options, out, err) : status;
}

ost_status export_picture(const app_state *app, const export_args *args, loaded_volume *in, ost_error *err)
{
    loaded_volume before = {0};
    ost_picture picture = {0};
    ost_status status = OST_OK;
    if (args->before) {
        status = load_volume(app, args->before, &before, err);
        if (status == OST_OK && !ost_geometry_equal(&before.volume.geometry, &in->volume.geometry))
            status = ost_fail(err, OST_ERR_INPUT, "%s and %s differ in dims, spacing or origin", args->before,
                              args->bone);
    }
    progress_show(NULL, "drawing", 0);
    if (status == OST_OK && args->view.view_given)
        status = draw_view(app, args, in, &before, &picture, err);
    else if (status == OST_OK)
        status = draw_slices(app, args, in, args->before ? &before.volume : NULL, &picture, err);
    if (status == OST_OK)
        status = ost_picture_write_png(args->out, &picture, err);
    if (status == OST_OK) {
        put_integer(app->result, "width", picture.width);
        put_integer(app->result, "height", picture.height);
        print_line(app, "%s: a picture of %d x %d pixels", args->out, picture.width, picture.height);
    }
    ost_picture_free(&picture);
    ost_volume_free(&before.volume);
    return status;
}
