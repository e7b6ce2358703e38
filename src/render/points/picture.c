/* SPDX-License-Identifier: Apache-2.0 */
/* Draws one frame of a volume as a picture. */
#include "render/points/frame.h"

enum { THRESHOLD = 120 };

ost_status ost_picture_points(const ost_volume *volume, const ost_camera *camera, const ost_points_options *options,
                              ost_picture *out, ost_error *err)
{
    const ost_points_options o = options ? *options : (ost_points_options){0};
    ost_surface surface = {0};
    ost_frame frame = {0};
    ost_isa isa;
    *out = (ost_picture){0};
    ost_status status = ost_camera_check(camera, err);
    if (status == OST_OK)
        status = ost_isa_choose(o.isa, &isa, err);
    if (status == OST_OK)
        status = ost_surface_init(&surface, &volume->geometry, err);
    if (status == OST_OK)
        status = ost_surface_set_volume(&surface, volume, o.threshold ? o.threshold : THRESHOLD, err);
    if (status == OST_OK)
        status = ost_surface_update(&surface, err);
    if (status == OST_OK)
        status = ost_frame_init(&frame, camera->width, camera->height, o.style, isa, o.threads, err);
    if (status == OST_OK) {
        const ost_eye eye = ost_eye_make(camera, &volume->geometry);
        status = ost_frame_draw(&frame, &surface, &eye, err);
    }
    if (status == OST_OK)
        status = ost_picture_init(out, camera->width, camera->height, err);
    if (status == OST_OK)
        ost_frame_copy(&frame, out);
    ost_frame_free(&frame);
    ost_surface_free(&surface);
    return status;
}
