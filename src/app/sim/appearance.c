/* SPDX-License-Identifier: Apache-2.0 */
#include "app/sim/appearance.h"

enum { PLANNED_MM = 3 };

ost_status sim_appearance_store_uncut(const sim_args *args, simulation *s, ost_error *err)
{
    return args->renderer < SIM_RENDERER_AUTO ? OST_OK : bone_to_volume(s->bone, NULL, &s->uncut, err);
}

void sim_appearance_eye(const sim_show *show, double eye_mm[3])
{
    double right[3], up[3], back[3];
    ost_orbit_frame(&show->orbit, right, up, back);
    for (int a = 0; a < 3; a++)
        eye_mm[a] = show->orbit.at[a] + show->orbit.distance * back[a];
}

ost_status sim_appearance_make(const sim_args *args, simulation *s, const ost_glenoid *glenoid, ost_error *err)
{
    sim_show *show = s->show;
    ost_bone_info info;
    double eye[3];
    const ost_density_classes *classes = ost_world_classes(s->world);
    if (args->renderer < SIM_RENDERER_AUTO)
        return OST_OK;
    ost_status status = ost_bone_info_get(s->bone, &info, err);
    if (status == OST_OK)
        status = ost_viewer_set_uncut(&show->viewer, &s->uncut, info.threshold, classes, glenoid ? &glenoid->at : NULL,
                                      glenoid ? glenoid->axis : NULL, err);
    if (status == OST_OK)
        status = ost_tool_download(s->tools[0], &show->ghost_tool, err);
    if (status != OST_OK)
        return status;
    ost_viewer_set_contact(&show->viewer, args->contact || !args->headless);
    sim_appearance_eye(show, eye);
    return appearance_begin(&show->look, &show->viewer, &show->subject, s->planned ? s->plan.depth_mm : PLANNED_MM,
                            &show->ghost_tool, &args->look, eye, err);
}

void sim_appearance_free(sim_show *show)
{
    appearance_free(&show->look);
    ost_tool_volume_free(&show->ghost_tool);
}
