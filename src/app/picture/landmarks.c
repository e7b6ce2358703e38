/* SPDX-License-Identifier: Apache-2.0 */
#include "app/picture/landmarks.h"

#include <string.h>

#include <osteon/anatomy.h>
#include <osteon/sim.h>

static void to_mm(ost_pm3 p, double out[3])
{
    out[0] = ost_pm_to_mm(p.x);
    out[1] = ost_pm_to_mm(p.y);
    out[2] = ost_pm_to_mm(p.z);
}

ost_status landmarks_subject(const ost_meta *meta, ost_view_subject *subject, ost_error *err)
{
    ost_pm3 trigonum, inferior;
    bool has_trigonum = false, has_inferior = false;
    ost_status status = ost_point_from_meta(meta, OST_META_TRIGONUM, &trigonum, &has_trigonum, err);
    if (status == OST_OK)
        status = ost_point_from_meta(meta, OST_META_INFERIOR_ANGLE, &inferior, &has_inferior, err);
    if (status != OST_OK || !has_trigonum || !has_inferior)
        return status;
    subject->has_landmarks = true;
    to_mm(trigonum, subject->trigonum);
    to_mm(inferior, subject->inferior);
    return OST_OK;
}

ost_status landmarks_show(const ost_view_subject *subject, ost_viewer *viewer, ost_error *err)
{
    ost_overlay_scene *scene = &viewer->scene;
    if (!subject->has_face || !subject->has_landmarks)
        return ost_fail(err, OST_ERR_USAGE,
                        "--overlay landmarks needs a bone with landmarks, and is drawn by osteon render only: "
                        "import the bone with --landmarks auto or --landmarks FILE");
    memcpy(scene->trigonum_mm, subject->trigonum, sizeof scene->trigonum_mm);
    memcpy(scene->inferior_mm, subject->inferior, sizeof scene->inferior_mm);
    scene->rim_count = 0;
    if (!viewer->reference.volume.voxels)
        return OST_OK;
    ost_pm3 rim[OST_RIM_MAX];
    ost_error ignored = {OST_OK, ""};
    const int32_t threshold = viewer->reference.threshold;
    const ost_anatomy_bone bone = {&viewer->reference.volume, threshold > 0 ? threshold : 1, INT16_MAX};
    if (ost_glenoid_rim_find(&bone, subject->face, subject->inward, rim, &scene->rim_count, &ignored) != OST_OK)
        scene->rim_count = 0;
    for (int i = 0; i < scene->rim_count; i++)
        to_mm(rim[i], scene->rim_mm[i]);
    return OST_OK;
}
