/* SPDX-License-Identifier: Apache-2.0 */
#include "app/input/segment_options.h"

#include <math.h>
#include <osteon/anatomy.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app/common/print.h"
#include "app/common/result.h"

enum { SHOWN = 10, HEADS = 8 };
/*
 * The radius of the ball of --cut-head exceeds that of the humeral head by this length. The ball therefore also covers
 * the head's cartilage and the voxels that only partly belong to the head.
 */
#define HEAD_MARGIN (OST_PM_PER_MM)
/*
 * Maximum distance from a position given by --bone to a voxel of the bone. The limit is greater than 0, because the
 * position may be a landmark, which lies on the surface of the bone and is seldom exact.
 */
#define BONE_REACH (10 * OST_PM_PER_MM)
/* maximum distance between the position of --cut-head and the centre of the head */
#define HEAD_REACH (30 * OST_PM_PER_MM)

/* ---------------------------------------------------------------- parsing */

/* Parses a list "a,b,..." of `count` decimals in millimetres. */
static bool parse_lengths(const char *text, int count, ost_pm *out)
{
    char copy[256], *at = copy;
    if ((size_t)snprintf(copy, sizeof copy, "%s", text) >= sizeof copy)
        return false;
    for (int i = 0; i < count; i++) {
        char *comma = strchr(at, ',');
        if ((comma != NULL) != (i + 1 < count))
            return false;
        if (comma)
            *comma = '\0';
        if (ost_pm_parse(at, &out[i], NULL) != OST_OK)
            return false;
        at = comma ? comma + 1 : at;
    }
    return true;
}

static ost_status parse_cuts(segment_job *job, ost_error *err)
{
    const option_list *balls = &job->options->balls, *planes = &job->options->planes;
    for (int i = 0; i < balls->count; i++) {
        ost_pm v[4];
        if (!parse_lengths(balls->value[i], 4, v) || v[3] <= 0)
            return usage_error(job->app, err,
                               "--cut-ball '%.80s': expected X,Y,Z,RADIUS in millimetres, such as -120,190,-160,24",
                               balls->value[i]);
        job->cuts[job->cut_count++] = (ost_segment_cut){.at = {v[0], v[1], v[2]}, .radius = v[3]};
    }
    for (int i = 0; i < planes->count; i++) {
        ost_pm v[6];
        if (!parse_lengths(planes->value[i], 6, v) || (!v[3] && !v[4] && !v[5]))
            return usage_error(job->app, err,
                               "--cut-plane '%.80s': expected X,Y,Z,NX,NY,NZ, a point in millimetres and a direction",
                               planes->value[i]);
        job->cuts[job->cut_count++] = (ost_segment_cut){.at = {v[0], v[1], v[2]}, .normal = {v[3], v[4], v[5]}};
    }
    return OST_OK;
}

static bool is_word(const char *value)
{
    return strcmp(value, "largest") == 0 || strcmp(value, "all") == 0;
}

bool segment_is_given(const segment_options *o)
{
    return o->bones.count || o->balls.count || o->planes.count || o->growth || o->min_volume.text || o->fill ||
           o->separate_given || o->air_given || o->head;
}

ost_status segment_job_init(segment_job *job, const app_state *app, const segment_options *o, ost_error *err)
{
    *job = (segment_job){.app = app, .options = o, .min_um3 = INT64_C(100000000000)};
    if (o->min_volume.text &&
        (o->min_volume.value.negative || !ost_decimal_scale(&o->min_volume.value, 1000000000, &job->min_um3, NULL)))
        return usage_error(app, err, "--min-volume '%.40s': expected a volume from 0 to 9e9 mm3", o->min_volume.text);
    if (o->separate_given && (o->separate < OST_PM_PER_MM / 1000 || o->separate > OST_SEGMENT_SEPARATE_MAX))
        return usage_error(app, err, "--separate %.9g: expected a depth from 0.001 to %.9g mm, such as 4",
                           ost_pm_to_mm(o->separate), ost_pm_to_mm(OST_SEGMENT_SEPARATE_MAX));
    ost_pm at[3];
    if (o->head && strcmp(o->head, "auto") != 0 && !parse_lengths(o->head, 3, at))
        return usage_error(app, err, "--cut-head '%.80s': expected auto or a position X,Y,Z in millimetres, such as "
                           "-142,196,-159", o->head);
    for (int i = 0; i < o->bones.count; i++) {
        ost_pm v[3];
        if (!is_word(o->bones.value[i]) && !parse_lengths(o->bones.value[i], 3, v))
            return usage_error(app, err,
                               "--bone '%.80s': expected largest, all or a position X,Y,Z in millimetres, such as "
                               "-95,196,-159", o->bones.value[i]);
    }
    return parse_cuts(job, err);
}

void segment_job_free(segment_job *job)
{
    ost_segments_free(job->segments);
    job->segments = NULL;
}

/* ------------------------------------------------------------------- head */

static void format_ball(char text[SEGMENT_BALL_TEXT], ost_pm3 c, ost_pm radius)
{
    char x[OST_PM_TEXT], y[OST_PM_TEXT], z[OST_PM_TEXT], r[OST_PM_TEXT];
    snprintf(text, SEGMENT_BALL_TEXT, "%s,%s,%s,%s", ost_pm_format(c.x, x), ost_pm_format(c.y, y),
             ost_pm_format(c.z, z), ost_pm_format(radius, r));
}

/*
 * Returns true if sphere `b` could be the head of another joint, that is, if `b` is nearly as complete as `a` and far
 * from `a`.
 */
static bool is_another_head(const ost_sphere *a, const ost_sphere *b)
{
    const double d[3] = {ost_pm_to_mm(a->centre.x - b->centre.x), ost_pm_to_mm(a->centre.y - b->centre.y),
                         ost_pm_to_mm(a->centre.z - b->centre.z)},
                 apart = ost_pm_to_mm(a->radius + b->radius);
    return b->coverage >= 0.75 * a->coverage && d[0] * d[0] + d[1] * d[1] + d[2] * d[2] > apart * apart;
}

/* Finds the humeral head for --cut-head. Adds a ball that contains the head to the cuts. */
static ost_status cut_head(segment_job *job, const ost_volume *ct, int32_t threshold, ost_error *err)
{
    const ost_anatomy_bone bone = {.volume = ct, .low = threshold, .high = INT16_MAX};
    ost_sphere_options options = {.concave = false};
    ost_sphere found[HEADS];
    ost_pm at[3];
    int count;
    if (parse_lengths(job->options->head, 3, at)) {
        options.has_near = true;
        options.near = (ost_pm3){at[0], at[1], at[2]};
        options.reach = HEAD_REACH;
    }
    ost_status status = ost_spheres_find(&bone, &options, found, HEADS, &count, err);
    if (status != OST_OK)
        return ost_fail_context(err, "--cut-head");
    for (int i = 1; i < count && !options.has_near; i++)
        if (is_another_head(&found[0], &found[i])) {
            char a[SEGMENT_BALL_TEXT], b[SEGMENT_BALL_TEXT];
            return ost_fail(err, OST_ERR_INPUT, "--cut-head auto: two balls could be the head: at %s (%.0f %% on bone) "
                            "and at %s (%.0f %%); select one with --cut-head X,Y,Z",
                            format_point(a, found[0].centre), 100 * found[0].coverage,
                            format_point(b, found[i].centre), 100 * found[i].coverage);
        }
    job->head = found[0];
    const ost_pm radius = found[0].radius + HEAD_MARGIN;
    job->cuts[job->cut_count++] = (ost_segment_cut){.at = found[0].centre, .radius = radius};
    format_ball(job->head_ball, found[0].centre, radius);
    return OST_OK;
}

/* -------------------------------------------------------------- selection */

static double voxel_mm3(const ost_geometry *g)
{
    return ost_pm_to_mm(g->spacing.x) * ost_pm_to_mm(g->spacing.y) * ost_pm_to_mm(g->spacing.z);
}

/* Finds the bone at a position, for --bone X,Y,Z. */
static ost_status find_bone(const char *text, ost_pm3 at, const ost_volume *labels, int *label, ost_error *err)
{
    ost_pm3 near = {0, 0, 0};
    *label = ost_segment_label_near(labels, at, &near);
    const double d[3] = {ost_pm_to_mm(near.x - at.x), ost_pm_to_mm(near.y - at.y), ost_pm_to_mm(near.z - at.z)},
                 distance = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    char where[FORMAT_TEXT];
    if (*label && distance <= ost_pm_to_mm(BONE_REACH))
        return OST_OK;
    return ost_fail(err, OST_ERR_INPUT, "--bone %.80s: no bone within %.9g mm; the nearest one is %.1f mm away, at %s",
                    text, ost_pm_to_mm(BONE_REACH), distance, format_point(where, near));
}

static ost_status keep_selected(segment_job *job, ost_volume *labels, ost_error *err)
{
    const option_list *bones = &job->options->bones;
    bool *keep = calloc(job->count + 1, sizeof *keep);
    ost_status status = keep ? OST_OK : ost_fail(err, OST_ERR_MEMORY, "out of memory for %zu bones", job->count);
    for (int i = 0; i < bones->count && status == OST_OK; i++) {
        ost_pm v[3];
        if (strcmp(bones->value[i], "largest") == 0) {
            keep[0] = true;
        } else if (strcmp(bones->value[i], "all") == 0) {
            for (size_t k = 0; k < job->count; k++)
                keep[k] = true;
        } else if (parse_lengths(bones->value[i], 3, v)) {
            const ost_pm3 at = {v[0], v[1], v[2]};
            int label;
            status = find_bone(bones->value[i], at, labels, &label, err);
            if (status == OST_OK)
                keep[label - 1] = true;
        }
    }
    if (status == OST_OK)
        status = ost_segments_keep(labels, job->segments, &job->count, keep, err);
    free(keep);
    return status;
}

/* ------------------------------------------------------------------ facts */

static ost_status set_number(ost_meta *meta, const char *key, int64_t value, ost_error *err)
{
    char text[24];
    snprintf(text, sizeof text, "%lld", (long long)value);
    return ost_meta_set(meta, key, text, err);
}

static ost_status set_list(ost_meta *meta, const char *name, const option_list *list, ost_error *err)
{
    ost_status status = OST_OK;
    for (int i = 0; i < list->count && status == OST_OK; i++) {
        char key[OST_META_KEY];
        snprintf(key, sizeof key, "segment_%s_%d", name, i + 1);
        status = ost_meta_set(meta, key, list->value[i], err);
    }
    return status;
}

/* Stores the options in the header of the label map, as facts. */
static ost_status set_facts(const segment_job *job, int32_t threshold, ost_meta *meta, ost_error *err)
{
    const segment_options *o = job->options;
    char text[OST_PM_TEXT];
    *meta = (ost_meta){0};
    ost_status status = set_number(meta, "segment_threshold", threshold, err);
    if (status == OST_OK)
        status = set_number(meta, "segment_growth", o->growth ? o->growth : threshold, err);
    if (status == OST_OK)
        status = set_number(meta, "segment_min_voxels", (int64_t)job->min_voxels, err);
    if (status == OST_OK && o->fill)
        status = set_number(meta, "segment_fill_air", o->air, err);
    if (status == OST_OK && o->separate_given)
        status = ost_meta_set(meta, "segment_separate_mm", ost_pm_format(o->separate, text), err);
    if (status == OST_OK && o->head)
        status = ost_meta_set(meta, "segment_head_ball", job->head_ball, err);
    if (status == OST_OK)
        status = set_list(meta, "ball", &o->balls, err);
    if (status == OST_OK)
        status = set_list(meta, "plane", &o->planes, err);
    return status == OST_OK ? set_list(meta, "bone", &o->bones, err) : status;
}

ost_status segment_job_run(segment_job *job, const ost_volume *ct, int32_t threshold, ost_volume *labels,
                           ost_error *err)
{
    const segment_options *o = job->options;
    const double least = (double)job->min_um3 * 1e-9 / voxel_mm3(&ct->geometry);
    if (o->head) {
        const ost_status found = cut_head(job, ct, threshold, err);
        if (found != OST_OK)
            return found;
    }
    job->geometry = ct->geometry;
    job->min_voxels = least > 1 ? (uint64_t)ceil(least) : 1;
    const ost_segment_options options = {.threshold = threshold,
                                         .growth = (int32_t)o->growth,
                                         .cuts = job->cuts,
                                         .cut_count = job->cut_count,
                                         .min_voxels = job->min_voxels,
                                         .fill = o->fill,
                                         .air = (int32_t)o->air,
                                         .separate = o->separate};
    ost_status status = ost_segment_volume(ct, &options, labels, &job->segments, &job->count, err);
    job->found = job->count;
    if (status == OST_OK && o->bones.count && job->count)
        status = keep_selected(job, labels, err);
    if (status == OST_OK)
        status = set_facts(job, threshold, &labels->meta, err);
    if (status != OST_OK)
        ost_volume_free(labels);
    return status;
}

double segment_job_min_mm3(const segment_job *job)
{
    return (double)job->min_voxels * voxel_mm3(&job->geometry);
}

ost_status segment_job_labels(void *user, const ost_volume *ct, int32_t threshold, ost_volume *labels, ost_error *err)
{
    segment_job *job = user;
    const ost_status status = segment_job_run(job, ct, threshold, labels, err);
    if (status != OST_OK || job->count)
        return status;
    ost_volume_free(labels);
    return ost_fail(err, OST_ERR_INPUT, "no bone of %g mm3 or more reaches %d HU; pass a lower --threshold or "
                    "--min-volume", segment_job_min_mm3(job), (int)threshold);
}

/* ----------------------------------------------------------------- report */

static void put_segments(const segment_job *job)
{
    json_t *list = json_array();
    for (size_t k = 0; k < job->count; k++) {
        const ost_segment *s = &job->segments[k];
        json_t *o = json_object();
        put_integer(o, "label", (int64_t)k + 1);
        put_integer(o, "voxels", (int64_t)s->voxels);
        put_integer(o, "filled", (int64_t)s->filled);
        put_real(o, "volume_mm3", (double)(s->voxels + s->filled) * voxel_mm3(&job->geometry));
        put(o, "box_lo", json_pack("[i,i,i]", s->box.lo[0], s->box.lo[1], s->box.lo[2]));
        put(o, "box_hi", json_pack("[i,i,i]", s->box.hi[0], s->box.hi[1], s->box.hi[2]));
        append(list, o);
    }
    put_integer(job->app->result, "components", (int64_t)job->count);
    put_integer(job->app->result, "components_found", (int64_t)job->found);
    put(job->app->result, "segments", list);
}

void segment_job_report(const segment_job *job, const char *what)
{
    const ost_geometry *g = &job->geometry;
    const double mm[3] = {ost_pm_to_mm(g->spacing.x), ost_pm_to_mm(g->spacing.y), ost_pm_to_mm(g->spacing.z)},
                 origin[3] = {ost_pm_to_mm(g->origin.x), ost_pm_to_mm(g->origin.y), ost_pm_to_mm(g->origin.z)};
    char selected[FORMAT_TEXT] = "", at[FORMAT_TEXT];
    put_segments(job);
    if (job->options->head) {
        put_mm3(job->app->result, "head_at_mm", job->head.centre);
        put_mm(job->app->result, "head_radius_mm", job->head.radius);
        put_real(job->app->result, "head_residual_mm", job->head.residual_mm);
        put_real(job->app->result, "head_coverage", job->head.coverage);
        put_text(job->app->result, "head_ball", job->head_ball);
        print_line(job->app,
                   "humeral head: %s, radius %.9g mm (%.0f %% of the sphere lie on bone, RMS distance %.2f mm)",
                   format_point(at, job->head.centre), ost_pm_to_mm(job->head.radius), 100 * job->head.coverage,
                   job->head.residual_mm);
        print_line(job->app, "  cut with a margin of %.9g mm, as by --cut-ball %s", ost_pm_to_mm(HEAD_MARGIN),
                   job->head_ball);
    }
    if (job->count < job->found)
        snprintf(selected, sizeof selected, ", %zu of them selected", job->count);
    print_line(job->app, "%s: %zu bone%s of %g mm3 or more%s", what, job->found, job->found == 1 ? "" : "s",
               (double)job->min_voxels * voxel_mm3(g), selected);
    if (job->count)
        print_line(job->app, "  label   volume mm3   from mm (L, P, S)            to mm");
    for (size_t k = 0; k < job->count && k < SHOWN; k++) {
        const ost_segment *s = &job->segments[k];
        double lo[3], hi[3];
        for (int a = 0; a < 3; a++) {
            lo[a] = origin[a] + (s->box.lo[a] - 0.5) * mm[a];
            hi[a] = origin[a] + (s->box.hi[a] - 0.5) * mm[a];
        }
        print_line(job->app, "  %5zu %12.0f   %8.1f %8.1f %8.1f   %8.1f %8.1f %8.1f", k + 1,
                   (double)(s->voxels + s->filled) * voxel_mm3(g), lo[0], lo[1], lo[2], hi[0], hi[1], hi[2]);
    }
    if (job->count > SHOWN)
        print_line(job->app, "  ... and %zu smaller ones", job->count - SHOWN);
}
