/* SPDX-License-Identifier: Apache-2.0 */
#include "app/debrief/debrief.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "app/common/result.h"
#include "app/common/print.h"
#include "app/debrief/verdict.h"

static ost_status take_bone(const ost_bone *bone, ost_volume *out, ost_error *err)
{
    ost_bone_info info;
    ost_status status = ost_bone_info_get(bone, &info, err);
    if (status == OST_OK)
        status = ost_volume_init(out, &info.geometry, err);
    return status == OST_OK ? ost_bone_download(bone, 0, info.geometry.dims.z, out->voxels, err) : status;
}

ost_status debrief_begin(const ost_bone *bone, const ost_metrics_plan *plan, ost_tool *const *tools, int count,
                         debrief *out, ost_error *err)
{
    ost_status status = OST_OK;
    out->plan = *plan;
    out->tool_count = count < OST_WORLD_TOOLS_MAX ? count : OST_WORLD_TOOLS_MAX;
    for (int i = 0; i < out->tool_count && status == OST_OK; i++)
        status = ost_metrics_tool_make(tools[i], &out->tools[i], err);
    return status == OST_OK ? take_bone(bone, &out->before, err) : status;
}

void debrief_free(debrief *d)
{
    ost_volume_free(&d->before);
    free(d->motion);
}

ost_status debrief_tick(debrief *d, const ost_session_tick *t, ost_error *err)
{
    if (d->count == d->capacity) {
        const size_t capacity = d->capacity ? 2 * d->capacity : 4096;
        ost_motion *grown = realloc(d->motion, capacity * sizeof *grown);
        if (!grown)
            return ost_fail(err, OST_ERR_MEMORY, "out of memory for the motion of %zu ticks", capacity);
        d->motion = grown;
        d->capacity = capacity;
    }
    static const ost_metrics_tool unknown = {.kind = OST_METRICS_OTHER};
    const bool known = t->tick.tool >= 0 && t->tick.tool < d->tool_count;
    const double n[3] = {t->force_un[0] * 1e-6, t->force_un[1] * 1e-6, t->force_un[2] * 1e-6};
    ost_motion *m = &d->motion[d->count++];
    *m = (ost_motion){
        .t_s = (double)t->tick.t_ns * 1e-9,
        .force_n = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]),
        .removed = t->removed,
        .touched = t->touched,
        .tool = t->tick.tool,
    };
    ost_metrics_tip(known ? &d->tools[t->tick.tool] : &unknown, &t->tick.pose, m->mm, m->axis);
    return OST_OK;
}

ost_status debrief_session(debrief *d, ost_session *session, uint64_t count, ost_error *err)
{
    bool more = true;
    ost_status status = OST_OK;
    ost_session_rewind(session);
    for (uint64_t i = 0; i < count && status == OST_OK;) {
        ost_record record;
        status = ost_session_next(session, &record, &more, err);
        if (status != OST_OK || !more)
            break;
        if (record.kind != OST_RECORD_TICK)
            continue;
        status = debrief_tick(d, &record.as.tick, err);
        i++;
    }
    return status;
}

static void put_technique(json_t *o, const ost_technique *t)
{
    json_t *p = json_object();
    put_real(p, "seconds", t->seconds);
    put_real(p, "path_mm", t->path_mm);
    put_integer(p, "contacts", t->contacts);
    put_real(p, "contact_s", t->contact_s);
    put_real(p, "contact_path_mm", t->contact_path_mm);
    put_integer(p, "passes", t->passes);
    put_real(p, "cutting_s", t->cutting_s);
    put_real(p, "tilt_mean_deg", t->tilt_mean_deg);
    put_real(p, "tilt_max_deg", t->tilt_max_deg);
    put_real(p, "inward_max_mm_s", t->inward_max_mm_s);
    put_integer(p, "plunges", t->plunges);
    put_real(p, "plunge_mm", t->plunge_mm);
    if (t->felt) {
        put_real(p, "force_mean_n", t->force_mean_n);
        put_real(p, "force_p95_n", t->force_p95_n);
        put_real(p, "force_max_n", t->force_max_n);
    }
    put(o, "technique", p);
}

static void put_rim(json_t *o, const ost_metrics *m)
{
    put_real(o, "rim_seen_percent", m->rim_seen_percent);
    if (m->rim_seen_percent > 0) {
        put_real(o, "rim_lowered_percent", m->rim_lowered_percent);
        put_real(o, "rim_lowered_mm", m->rim_lowered_mm);
    }
    if (!isnan(m->width_before_mm))
        put_real(o, "width_before_mm", m->width_before_mm);
    if (!isnan(m->width_after_mm))
        put_real(o, "width_after_mm", m->width_after_mm);
    if (!isnan(m->height_before_mm))
        put_real(o, "height_before_mm", m->height_before_mm);
    if (!isnan(m->height_after_mm))
        put_real(o, "height_after_mm", m->height_after_mm);
}

static void put_json(const app_state *app, const debrief *d, const ost_metrics *m, const verdict *v,
                     const ost_density_classes *classes)
{
    json_t *o = json_object(), *by_class = json_object();
    put_text(o, "verdict", v->line);
    put_text(o, "grade", verdict_grades[v->grade]);
    put_real(o, "times_aim", v->times);
    put_real(o, "planned_mm", d->plan.depth_mm);
    put_real(o, "removed_mm3", m->removed_mm3);
    for (int c = 0; c < classes->count; c++)
        put_real(by_class, classes->name[c], m->removed_by_class_mm3[c]);
    put(o, "removed_by_class_mm3", by_class);
    put_real(o, "floor_mm2", m->floor_mm2);
    put_real(o, "depth_mean_mm", m->depth_mean_mm);
    put_real(o, "depth_p95_mm", m->depth_p95_mm);
    put_real(o, "depth_max_mm", m->depth_max_mm);
    put_real(o, "over_mm3", m->over_mm3);
    put_real(o, "over_percent", m->over_percent);
    put_real(o, "over_max_mm", m->over_max_mm);
    put_real(o, "plate_kept_percent", m->plate_kept_percent);
    put_rim(o, m);
    put_bool(o, "scapular", m->scapular);
    put_real(o, "version_planned_deg", m->version_planned_deg);
    put_real(o, "inclination_planned_deg", m->inclination_planned_deg);
    put_bool(o, "reamed", m->reamed);
    if (m->reamed) {
        put_real(o, "reach_mm", m->reach_mm);
        put_real(o, "depth_error_mm", m->reach_mm - d->plan.depth_mm);
        put_real(o, "tilt_deg", m->tilt_deg);
        put_real(o, "entry_mm", m->entry_mm);
        put_real(o, "version_deg", m->version_deg);
        put_real(o, "inclination_deg", m->inclination_deg);
        put_real(o, "version_error_deg", m->version_error_deg);
        put_real(o, "inclination_error_deg", m->inclination_error_deg);
    }
    if (d->count)
        put_technique(o, &d->technique);
    if (m->sphere) {
        put_real(o, "centre_depth_mm", m->centre_depth_mm);
        put_real(o, "sphere_mm", m->sphere_mm);
        put_real(o, "fit_rms_mm", m->fit_rms_mm);
        put_real(o, "contact_percent", m->contact_percent);
        put_real(o, "gap_max_mm", m->gap_max_mm);
    }
    put_bool(o, "hole", m->hole);
    if (m->hole) {
        put_real(o, "hole_depth_mm", m->hole_depth_mm);
        if (!isnan(m->hole_diameter_mm))
            put_real(o, "hole_diameter_mm", m->hole_diameter_mm);
        put_real(o, "hole_angle_deg", m->hole_angle_deg);
        put_real(o, "hole_entry_mm", m->hole_entry_mm);
        put_real(o, "hole_wall_mm", m->hole_wall_mm);
        put_bool(o, "hole_breach", m->hole_breach);
    }
    put(app->result, "metrics", o);
}

static void print_all(const app_state *app, const debrief *d, const ost_metrics *m, const verdict *v)
{
    print_line(app, "  %s", v->line);
    if (m->floor_mm2 > 0)
        print_line(app,
                   "  floor: %.0f mm2, %.1f mm deep on average, %.1f at most; over-reaming %.0f mm3, deeper than %.1f "
                   "mm and a margin of 1",
                   m->floor_mm2, m->depth_mean_mm, m->depth_max_mm, m->over_mm3, d->plan.depth_mm);
    if (m->reamed)
        print_line(app,
                   "  version %+.1f degrees, planned %+.1f; inclination %+.1f, planned %+.1f (retroversion and "
                   "superior are positive%s)",
                   m->version_deg, m->version_planned_deg, m->inclination_deg, m->inclination_planned_deg,
                   m->scapular ? "" : "; in the CT's planes");
    if (m->sphere)
        print_line(app, "  backing contact %.0f %%, gap up to %.1f mm", m->contact_percent, m->gap_max_mm);
    if (m->rim_seen_percent > 0)
        print_line(app, "  rim: lowered by more than 1 mm on %.0f %% of its measured part", m->rim_lowered_percent);
    if (m->hole)
        print_line(app, "  peg hole: %.1f mm deep, axis tilt %.1f degrees, entry %.1f mm off; %s", m->hole_depth_mm,
                   m->hole_angle_deg, m->hole_entry_mm,
                   m->hole_breach          ? "IT IS OPEN TO THE OUTSIDE"
                   : m->hole_wall_mm < 5.9 ? "wall not perforated"
                                           : "6 mm of bone or more around it");
}

ost_status debrief_end(const app_state *app, debrief *d, const ost_bone *bone, const ost_density_classes *classes,
                       const char *name, const char *file, ost_error *err)
{
    ost_bone_info info;
    ost_volume after = {0};
    ost_metrics *m = malloc(sizeof *m);
    ost_status status = m ? ost_bone_info_get(bone, &info, err)
                          : ost_fail(err, OST_ERR_MEMORY, "out of memory for metrics");
    if (status == OST_OK)
        status = take_bone(bone, &after, err);
    if (status == OST_OK)
        status = ost_metrics_make(&d->before, &after, info.threshold, classes, &d->plan,
                                  &(ost_metrics_motion){d->tools, d->tool_count, d->motion, d->count}, m, err);
    if (status == OST_OK)
        status = ost_technique_make(d->motion, d->count, &d->plan, &d->technique, err);
    if (status == OST_OK) {
        verdict v;
        verdict_make(d, m, &v);
        put_json(app, d, m, &v, classes);
        print_all(app, d, m, &v);
        status = debrief_page(file, name, d, &after, classes, info.threshold, m, &v, err);
    }
    if (status == OST_OK) {
        put_text(app->result, "debrief", file);
        print_line(app, "  debrief in %s", file);
    }
    ost_volume_free(&after);
    free(m);
    return status;
}
