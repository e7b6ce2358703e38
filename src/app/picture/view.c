/* SPDX-License-Identifier: Apache-2.0 */
#include "app/picture/view.h"

#include <string.h>

#include "app/picture/landmarks.h"

ost_status view_subject(const app_state *app, const view_options *options, const target_options *target,
                        const ost_meta *meta, const ost_geometry *geometry, const char *bone, ost_glenoid *glenoid,
                        ost_view_subject *out, ost_error *err)
{
    ost_side side = OST_SIDE_UNKNOWN;
    ost_status status = target_find(app, target, meta, bone, glenoid, err);
    const bool known = status == OST_OK;
    if (!known) {
        if (status != OST_ERR_USAGE)
            return status;
        *err = (ost_error){0};
        status = target_side(target, meta, bone, &side, err);
        if (status != OST_OK)
            return status;
        if (side == OST_SIDE_UNKNOWN && (options->view == OST_VIEW_LATERAL || options->view == OST_VIEW_MEDIAL))
            return usage_error(app, err, "%s: the side is not set: pass --side left or --side right", bone);
    }
    *out = ost_view_subject_make(geometry, &glenoid->at, known ? glenoid->axis : NULL,
                                 known ? glenoid->left : side == OST_SIDE_LEFT);
    if (!known && target->at_given) {
        out->middle[0] = ost_pm_to_mm(target->at.x);
        out->middle[1] = ost_pm_to_mm(target->at.y);
        out->middle[2] = ost_pm_to_mm(target->at.z);
    }
    return landmarks_subject(meta, out, err);
}

void view_fit(const target_options *target, const ost_volume *volume, int32_t threshold, ost_view_subject *subject)
{
    if (subject->has_face || !target->at_given)
        ost_view_subject_fit(subject, volume, threshold);
}

ost_orbit view_orbit(const view_options *options, const ost_view_subject *subject, const ost_pose *tool)
{
    ost_orbit orbit = ost_view_orbit((ost_view_name)options->view, subject, tool);
    if (options->extent)
        orbit.distance = OST_VIEW_FOCAL * ost_pm_to_mm(options->extent);
    return orbit;
}

bool view_oriented(const ost_meta *meta)
{
    const char *fact = ost_meta_get(meta, OST_META_ORIENTATION);
    return !fact || strcmp(fact, "assumed LPS") != 0;
}
