/* SPDX-License-Identifier: Apache-2.0 */
#include "app/debrief.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "app/result.h"
#include "app/say.h"

static ost_status take_bone(const ost_bone *bone, ost_volume *out, ost_error *err)
{
    ost_bone_info info;
    ost_status status = ost_bone_info_get(bone, &info, err);
    if (status == OST_OK)
        status = ost_volume_init(out, &info.geometry, err);
    return status == OST_OK ? ost_bone_download(bone, 0, info.geometry.dims.z, out->voxels, err) : status;
}

ost_status debrief_begin(const ost_bone *bone, const ost_metrics_plan *plan, debrief *out, ost_error *err)
{
    out->plan = *plan;
    return take_bone(bone, &out->before, err);
}

void debrief_free(debrief *d)
{
    ost_volume_free(&d->before);
    free(d->force_n);
    free(d->t_s);
}

static ost_status add_force(debrief *d, double t_s, double n, ost_error *err)
{
    if (d->count == d->room) {
        const size_t room = d->room ? 2 * d->room : 4096;
        double *force = realloc(d->force_n, room * sizeof *force), *t = NULL;
        d->force_n = force ? force : d->force_n;
        t = realloc(d->t_s, room * sizeof *t);
        d->t_s = t ? t : d->t_s;
        if (!force || !t)
            return ost_fail(err, OST_ERR_MEMORY, "no memory for the forces of %zu ticks", room);
        d->room = room;
    }
    d->force_n[d->count] = n;
    d->t_s[d->count++] = t_s;
    return OST_OK;
}

ost_status debrief_session(debrief *d, ost_session *session, uint64_t count, ost_error *err)
{
    bool more = true, felt = false;
    ost_status status = OST_OK;
    ost_session_rewind(session);
    for (uint64_t i = 0; i < count && status == OST_OK;) {
        ost_record record;
        status = ost_session_next(session, &record, &more, err);
        if (status != OST_OK || !more)
            break;
        if (record.kind != OST_RECORD_TICK)
            continue;
        const int32_t *f = record.as.tick.force_un;
        const double n[3] = {f[0] * 1e-6, f[1] * 1e-6, f[2] * 1e-6}, size = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        status = add_force(d, (double)record.as.tick.tick.t_ns * 1e-9, size, err);
        felt |= size > 0;
        i++;
    }
    if (!felt)
        d->count = 0;
    return status;
}

static void put_json(const app_state *app, const ost_metrics_plan *plan, const ost_metrics *m, const ost_density_classes *classes)
{
    json_t *o = json_object(), *by_class = json_object();
    put_real(o, "planned_mm", plan->depth_mm);
    put_real(o, "removed_mm3", m->removed_mm3);
    for (int c = 0; c < classes->count; c++)
        put_real(by_class, classes->name[c], m->removed_by_class_mm3[c]);
    put(o, "removed_by_class_mm3", by_class);
    put_real(o, "floor_mm2", m->floor_mm2);
    put_real(o, "depth_mean_mm", m->depth_mean_mm);
    put_real(o, "depth_p95_mm", m->depth_p95_mm);
    put_real(o, "depth_max_mm", m->depth_max_mm);
    put_real(o, "over_mm3", m->over_mm3);
    put_real(o, "plate_kept_percent", m->plate_kept_percent);
    if (m->sphere) {
        put_real(o, "centre_depth_mm", m->centre_depth_mm);
        put_real(o, "sphere_mm", m->sphere_mm);
        put_real(o, "fit_rms_mm", m->fit_rms_mm);
        put_real(o, "angle_deg", m->angle_deg);
        put_real(o, "retroversion_deg", m->retroversion_deg);
        put_real(o, "superior_deg", m->superior_deg);
        put_real(o, "contact_percent", m->contact_percent);
        put_real(o, "gap_max_mm", m->gap_max_mm);
    }
    put_bool(o, "hole", m->hole);
    if (m->hole) {
        put_real(o, "hole_depth_mm", m->hole_depth_mm);
        put_real(o, "hole_diameter_mm", m->hole_diameter_mm);
        put_real(o, "hole_angle_deg", m->hole_angle_deg);
        put_real(o, "hole_entry_mm", m->hole_entry_mm);
        put_real(o, "hole_wall_mm", m->hole_wall_mm);
        put_bool(o, "hole_breach", m->hole_breach);
    }
    put(app->result, "metrics", o);
}

static void say_all(const app_state *app, const debrief *d, const ost_metrics *m)
{
    if (m->floor_mm2 > 0)
        say(app, "  floor: %.0f mm2, %.1f mm deep on average, %.1f at most; %.0f mm3 deeper than planned (%.1f mm and a margin of 1)", m->floor_mm2,
            m->depth_mean_mm, m->depth_max_mm, m->over_mm3, d->plan.depth_mm);
    if (m->sphere)
        say(app, "  direction: %.1f degrees off the plan (retroversion %+.1f, superior %+.1f); seat: %.0f %% contact, gap up to %.1f mm", m->angle_deg,
            m->retroversion_deg, m->superior_deg, m->contact_percent, m->gap_max_mm);
    if (m->plate_mm3 > 0)
        say(app, "  hard bone under the floor: %.0f %% kept", m->plate_kept_percent);
    if (m->hole)
        say(app, "  hole: %.1f mm deep, %.1f mm wide, %.1f degrees and %.1f mm off the plan; %s", m->hole_depth_mm, m->hole_diameter_mm,
            m->hole_angle_deg, m->hole_entry_mm, m->hole_breach ? "IT IS OPEN TO THE OUTSIDE" : m->hole_wall_mm < 5.9 ? "its wall holds" : "6 mm of bone around it, or more");
}

ost_status debrief_end(const app_state *app, const debrief *d, const ost_bone *bone, const ost_density_classes *classes, const char *name,
                       const char *file, ost_error *err)
{
    ost_bone_info info;
    ost_volume after = {0};
    ost_metrics *m = malloc(sizeof *m);
    ost_status status = m ? ost_bone_info_get(bone, &info, err) : ost_fail(err, OST_ERR_MEMORY, "no memory for metrics");
    if (status == OST_OK)
        status = take_bone(bone, &after, err);
    if (status == OST_OK)
        status = ost_metrics_make(&d->before, &after, info.threshold, classes, &d->plan, m, err);
    if (status == OST_OK) {
        put_json(app, &d->plan, m, classes);
        say_all(app, d, m);
        status = debrief_page(file, name, d, &after, classes, info.threshold, m, err);
    }
    if (status == OST_OK) {
        put_text(app->result, "debrief", file);
        say(app, "  debrief in %s", file);
    }
    ost_volume_free(&after);
    free(m);
    return status;
}
