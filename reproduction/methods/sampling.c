/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The holes that tool points leave in a bone. A bone voxel smaller than a tool voxel can lie between the centres of the
 * tool's voxels, and is then missed although its centre is in a cutting tool voxel.
 *
 *   pose 1 ... n   bone-to-tool: voxels whose centre is in a cutting tool voxel   --> osteon's set, the union
 *                  tool-to-bone: voxels that contain a tool point                 --> the points' set, the union
 *
 * The tool is in the middle of the bone, with the rotation of the static event. With several poses, it moves by half a
 * bone voxel per pose along its axis, which is the -z axis of the tool's frame. Halfway along this path, it is in the
 * middle of the bone.
 */
#include <stdlib.h>

#include "core/integer.h"
#include "core/rotation.h"
#include "reproduction/methods/points.h"

enum { POSES_MAX = 1000 };
static const double RATIO_MIN = 0.125, RATIO_MAX = 4;

/* One case: a scene and its two sets. */
typedef struct sampled {
    bench_scene scene;
    method_set own, points;
    int64_t point_count;
} sampled;

static void free_sampled(sampled *s)
{
    bench_scene_free(&s->scene);
    method_set_free(&s->own);
    method_set_free(&s->points);
}

/* Places the tool at pose number `n` of `poses`. The pose halfway along the path is `middle`. */
static ost_status place(bench_scene *scene, const ost_pose *middle, int n, int poses, ost_error *err)
{
    const ost_rotation r = ost_rotation_of(middle);
    ost_pose pose = *middle;
    ost_pm *const t[3] = {&pose.t.x, &pose.t.y, &pose.t.z};
    /* The displacement is (n - (poses - 1) / 2) / 2 bone voxels. It is counted in quarters of a voxel. */
    const int64_t quarters = 2 * n - (poses - 1);
    for (int a = 0; a < 3; a++)
        *t[a] -= (ost_pm)ost_rhe_div128((ost_i128)r.m[a][2] * quarters * scene->bone.spacing.x, (ost_i128)4 * r.n);
    return bench_scene_set_pose(scene, &pose, err);
}

/* Enlarges the event's box by one voxel on each side and limits it to the bone. Extends `box` to contain the result. */
static void include(ost_voxel_box *box, const bench_scene *scene)
{
    const int32_t dims[3] = {scene->bone.dims.x, scene->bone.dims.y, scene->bone.dims.z};
    for (int a = 0; a < 3; a++) {
        const int32_t lo = scene->box.lo[a] > 1 ? scene->box.lo[a] - 1 : 0;
        const int32_t hi = scene->box.hi[a] + 1 < dims[a] ? scene->box.hi[a] + 1 : dims[a];
        box->lo[a] = lo < box->lo[a] ? lo : box->lo[a];
        box->hi[a] = hi > box->hi[a] ? hi : box->hi[a];
    }
}

static ost_status add_pose(sampled *s, const method_points *points, ost_error *err)
{
    points_map map;
    ost_status status = points_map_make(&map, &s->scene.pose, &s->scene.bone, &s->scene.tool.geometry, err);
    if (status != OST_OK)
        return status;
    method_define_bone_to_tool(&s->own, &s->scene, NULL);
    method_define_tool_to_bone(&s->points, points, &map, s->scene.bone.dims, NULL);
    return OST_OK;
}

static ost_status sample(sampled *s, ost_tool_kind tool, methods_points which, int poses, double ratio,
                         ost_error *err)
{
    *s = (sampled){.point_count = 0};
    if (!(ratio >= RATIO_MIN && ratio <= RATIO_MAX) || poses < 1 || poses > POSES_MAX)
        return ost_fail(err, OST_ERR_RANGE, "a ratio of %g with %d poses; %g to %g, and 1 to %d", ratio, poses,
                        RATIO_MIN, RATIO_MAX, POSES_MAX);
    method_points points = {.count = 0};
    ost_voxel_box box = {.lo = {INT32_MAX, INT32_MAX, INT32_MAX}};
    ost_pose middle;
    ost_status status = methods_middle_event(&s->scene, tool, (ost_pm)(ratio * (double)SCENE_SPACING), err);
    middle = s->scene.pose;
    for (int n = 0; n < poses && status == OST_OK; n++) {
        status = place(&s->scene, &middle, n, poses, err);
        include(&box, &s->scene);
    }
    if (status == OST_OK)
        status = method_points_init(&points, &s->scene.tool, which, 0, err);
    if (status == OST_OK)
        status = method_set_init(&s->own, &box, err);
    if (status == OST_OK)
        status = method_set_init(&s->points, &box, err);
    for (int n = 0; n < poses && status == OST_OK; n++) {
        status = place(&s->scene, &middle, n, poses, err);
        if (status == OST_OK)
            status = add_pose(s, &points, err);
    }
    s->point_count = points.count;
    method_points_free(&points);
    return status;
}

ost_status methods_sampling(ost_tool_kind tool, methods_points which, int poses, const double *ratios, int count,
                            methods_sample *samples, ost_error *err)
{
    ost_status status = OST_OK;
    for (int r = 0; r < count && status == OST_OK; r++) {
        sampled s;
        method_difference d;
        status = sample(&s, tool, which, poses, ratios[r], err);
        if (status == OST_OK) {
            method_set_compare(&s.own, &s.points, &d);
            const double all = d.expected > 0 ? (double)d.expected : 1;
            samples[r] = (methods_sample){
                .tool = ost_tool_kind_name(tool),
                .points = which,
                .ratio = ratios[r],
                .tool_voxel = s.scene.tool.geometry.voxel,
                .bone_voxel = s.scene.bone.spacing.x,
                .poses = poses,
                .tool_points = s.point_count,
                .expected = d.expected,
                .found = d.expected - d.missed,
                .missed = d.missed,
                .extra = d.extra,
                .missed_inside = d.missed_inside,
                .missed_share = (double)d.missed / all,
                .missed_inside_share = (double)d.missed_inside / all,
            };
        }
        free_sampled(&s);
    }
    return status;
}

/*
 * Returns the middle one of the slices that contain a voxel of the set. If the set is empty, returns the first slice of
 * its box.
 */
static int32_t middle_slice(const method_set *set)
{
    const size_t slice = method_set_row(set, set->box.lo[1], set->box.lo[2] + 1);
    int32_t first = set->box.hi[2], last = set->box.lo[2];
    for (int32_t k = set->box.lo[2]; k < set->box.hi[2]; k++)
        for (size_t v = 0; v < slice; v++)
            if (set->in[(size_t)(k - set->box.lo[2]) * slice + v]) {
                first = k < first ? k : first;
                last = k;
                break;
            }
    return first <= last ? first + (last - first) / 2 : set->box.lo[2];
}

ost_status methods_sampling_slice(ost_tool_kind tool, methods_points which, int poses, double ratio,
                                  methods_slice *slice, ost_error *err)
{
    sampled s;
    *slice = (methods_slice){.values = NULL};
    ost_status status = sample(&s, tool, which, poses, ratio, err);
    const ost_voxel_box *b = &s.own.box;
    if (status == OST_OK) {
        *slice = (methods_slice){.width = b->hi[0] - b->lo[0], .height = b->hi[1] - b->lo[1], .x0 = b->lo[0],
                                 .y0 = b->lo[1], .z = middle_slice(&s.own)};
        slice->values = malloc((size_t)slice->width * (size_t)slice->height);
        if (!slice->values)
            status = ost_fail(err, OST_ERR_MEMORY, "out of memory for a slice of %d x %d voxels", slice->width,
                              slice->height);
    }
    for (int32_t v = 0; status == OST_OK && v < slice->width * slice->height; v++) {
        const size_t at = method_set_row(&s.own, b->lo[1], slice->z) + (size_t)v;
        const bool own = s.own.in[at], points = s.points.in[at];
        slice->values[v] = own && points                      ? METHODS_SLICE_BOTH
                           : points                           ? METHODS_SLICE_EXTRA
                           : !own                             ? METHODS_SLICE_NONE
                           : method_set_inside(&s.own, at) ? METHODS_SLICE_MISSED_INSIDE
                                                              : METHODS_SLICE_MISSED;
    }
    free_sampled(&s);
    return status;
}

void methods_slice_free(methods_slice *slice)
{
    free(slice->values);
    *slice = (methods_slice){.values = NULL};
}
