/* SPDX-License-Identifier: Apache-2.0 */
/* Makes the scenes of the measurements: the static event of bench/scene.h at any resolution, and a tool in the middle
   of a bone in which only some chunks have active voxels. */
#include <stdlib.h>
#include <string.h>

#include "core/integer.h"
#include "core/rotation.h"
#include "reproduction/methods/method.h"

/* The edge length of the bone's box, 128 voxels of 0.47 mm. */
#define BONE_EDGE (SCENE_SIDE * SCENE_SPACING)

void methods_scene_free(methods_scene *scene)
{
    bench_scene_free(&scene->event);
    free(scene->voxels);
    scene->voxels = NULL;
}

void methods_scene_set_region(methods_scene *scene)
{
    const ost_dims d = scene->event.bone.dims;
    const int32_t dims[3] = {d.x, d.y, d.z};
    for (int a = 0; a < 3; a++) {
        const int32_t lo = scene->event.box.lo[a] - 1, hi = scene->event.box.hi[a] + 1;
        scene->region.lo[a] = lo < 0 ? 0 : lo;
        scene->region.hi[a] = hi > dims[a] ? dims[a] : hi;
    }
}

/* Makes the tool, and the geometry of a bone of side^3 voxels that fills the box of the static event. The caller must
   set the pose afterwards. */
static ost_status make_event(bench_scene *event, ost_tool_kind tool, ost_pm tool_voxel, int32_t side, ost_error *err)
{
    const ost_pm s = side < 1 ? 0 : BONE_EDGE / side, origin = (s - SCENE_SPACING) / 2;
    if (s < OST_SPACING_MIN) {
        *event = (bench_scene){.tool_name = ost_tool_kind_name(tool)};
        return ost_fail(err, OST_ERR_RANGE, "a bone of %d^3 voxels; its voxels would be smaller than 0.001 mm", side);
    }
    ost_status status = bench_scene_init_by(event, "cpu", tool, tool_voxel, SCENE_SIDE, err);
    event->bone = (ost_geometry){.dims = {side, side, side}, .spacing = {s, s, s}, .origin = {origin, origin, origin}};
    return status;
}

/* Makes the event and the bone's voxels, which are all active. */
static ost_status make(methods_scene *scene, ost_tool_kind tool, ost_pm tool_voxel, int32_t side, ost_error *err)
{
    *scene = (methods_scene){.voxels = NULL};
    ost_status status = make_event(&scene->event, tool, tool_voxel, side, err);
    if (status != OST_OK)
        return status;
    scene->voxels = bench_scene_slices(&scene->event, 0, side);
    return scene->voxels ? OST_OK : ost_fail(err, OST_ERR_MEMORY, "out of memory for a bone of %d^3 voxels", side);
}

ost_status methods_scene_static(methods_scene *scene, ost_tool_kind tool, ost_pm tool_voxel, int32_t bone_side,
                                ost_error *err)
{
    ost_status status = make(scene, tool, tool_voxel, bone_side, err);
    const ost_pose pose = scene->event.pose;
    if (status == OST_OK)
        status = bench_scene_set_pose(&scene->event, &pose, err);
    if (status == OST_OK)
        methods_scene_set_region(scene);
    else
        methods_scene_free(scene);
    return status;
}

/* Lists the chunks of the event. Returns NULL if memory is exhausted. The caller frees the list. */
static int32_t (*chunks_of(const methods_scene *scene, int chunk_size, int *count))[3]
{
    *count = bench_scene_chunks(&scene->event, chunk_size, NULL);
    int32_t(*corners)[3] = malloc(((size_t)*count + 1) * sizeof *corners);
    if (corners)
        bench_scene_chunks(&scene->event, chunk_size, corners);
    return corners;
}

static bool is_active(const methods_scene *scene, const int32_t corner[3], int32_t n)
{
    const ost_dims d = scene->event.bone.dims;
    for (int32_t k = corner[2]; k < corner[2] + n && k < d.z; k++)
        for (int32_t j = corner[1]; j < corner[1] + n && j < d.y; j++)
            for (int32_t i = corner[0]; i < corner[0] + n && i < d.x; i++)
                if (scene->voxels[i + d.x * (j + (int64_t)d.y * k)] != 0)
                    return true;
    return false;
}

int methods_scene_active_chunks(const methods_scene *scene, int chunk_size)
{
    int count, active = 0;
    int32_t(*corners)[3] = chunks_of(scene, chunk_size, &count);
    for (int c = 0; c < count && corners; c++)
        active += is_active(scene, corners[c], chunk_size);
    free(corners);
    return active;
}

void methods_scene_chunk_memory(const methods_scene *scene, int chunk_size, int64_t *voxels, int64_t *table)
{
    const ost_dims d = scene->event.bone.dims;
    const int32_t n = chunk_size;
    *voxels = *table = 0;
    if (n == 0)
        return;
    for (int32_t z = 0; z < d.z; z += n)
        for (int32_t y = 0; y < d.y; y += n)
            for (int32_t x = 0; x < d.x; x += n) {
                *table += (int64_t)sizeof(int16_t *);
                if (is_active(scene, (const int32_t[3]){x, y, z}, n))
                    *voxels += (int64_t)n * n * n * (int64_t)sizeof(int16_t);
            }
}

/* Returns the squared distance of a chunk's middle from the middle of the event's box, in voxels. */
static double distance_of(const methods_scene *scene, const int32_t corner[3], int32_t n)
{
    double sum = 0;
    for (int a = 0; a < 3; a++) {
        const double apart = corner[a] + n / 2.0 - (scene->event.box.lo[a] + scene->event.box.hi[a]) / 2.0;
        sum += apart * apart;
    }
    return sum;
}

/* Moves the `keep` chunks that are closest to the middle of the event's box to the beginning of the list. If distances
   are equal, the chunk that comes first in the list is preferred. */
static void sort_nearest(const methods_scene *scene, int32_t (*corners)[3], int count, int32_t n, int keep)
{
    for (int c = 0; c < keep; c++) {
        int nearest = c;
        int32_t found[3];
        for (int other = c + 1; other < count; other++)
            if (distance_of(scene, corners[other], n) < distance_of(scene, corners[nearest], n))
                nearest = other;
        memcpy(found, corners[nearest], sizeof found);
        memmove(corners[c + 1], corners[c], (size_t)(nearest - c) * sizeof corners[c]);
        memcpy(corners[c], found, sizeof found);
    }
}

/* Sets all voxels to 0, except those of the first `keep` chunks of the list. */
static ost_status clear_others(methods_scene *scene, int32_t (*corners)[3], int32_t n, int keep, ost_error *err)
{
    const ost_dims d = scene->event.bone.dims;
    const size_t count = (size_t)ost_dims_count(d);
    int16_t *voxels = calloc(count, sizeof *voxels);
    if (!voxels)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a bone of %zu voxels", count);
    for (int c = 0; c < keep; c++) {
        const int32_t x = corners[c][0], width = x + n < d.x ? n : d.x - x;
        for (int32_t k = corners[c][2]; k < corners[c][2] + n && k < d.z; k++)
            for (int32_t j = corners[c][1]; j < corners[c][1] + n && j < d.y; j++) {
                const size_t row = (size_t)x + (size_t)d.x * ((size_t)j + (size_t)d.y * (size_t)k);
                memcpy(voxels + row, scene->voxels + row, (size_t)width * sizeof *voxels);
            }
    }
    free(scene->voxels);
    scene->voxels = voxels;
    return OST_OK;
}

/* Moves the tool so that the centre of its grid, R c + t, is at the middle of the bone's box. */
static ost_status move_to_middle(bench_scene *event, ost_error *err)
{
    const ost_tool_geometry *tool = &event->tool.geometry;
    const ost_pm twice_centre[3] = {2 * tool->corner.x + tool->dims.x * tool->voxel,
                                    2 * tool->corner.y + tool->dims.y * tool->voxel,
                                    2 * tool->corner.z + tool->dims.z * tool->voxel};
    const ost_rotation r = ost_rotation_of(&event->pose);
    ost_pose pose = event->pose;
    ost_pm *const t[3] = {&pose.t.x, &pose.t.y, &pose.t.z};
    for (int b = 0; b < 3; b++) {
        ost_i128 n = 0;
        for (int a = 0; a < 3; a++)
            n += (ost_i128)r.m[b][a] * twice_centre[a];
        *t[b] = (BONE_EDGE - SCENE_SPACING) / 2 - (ost_pm)ost_rhe_div128(n, (ost_i128)2 * r.n);
    }
    return bench_scene_set_pose(event, &pose, err);
}

ost_status methods_middle_event(bench_scene *event, ost_tool_kind tool, ost_pm tool_voxel, ost_error *err)
{
    ost_status status = make_event(event, tool, tool_voxel, SCENE_SIDE, err);
    return status == OST_OK ? move_to_middle(event, err) : status;
}

/* Selects the chunks of the event for methods_scene_middle. */
static ost_status keep_chunks(methods_scene *scene, int chunk_size, int keep, ost_error *err)
{
    int count;
    int32_t(*corners)[3] = chunks_of(scene, chunk_size, &count);
    ost_status status = OST_OK;
    if (!corners)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a list of chunks");
    if (count < keep) {
        status = ost_fail(err, OST_ERR_RANGE, "the tool enters only %d chunks of %d^3 voxels of this bone", count,
                          chunk_size);
    } else {
        sort_nearest(scene, corners, count, chunk_size, keep);
        status = clear_others(scene, corners, chunk_size, keep, err);
    }
    free(corners);
    return status;
}

ost_status methods_scene_middle(methods_scene *scene, ost_tool_kind tool, ost_pm tool_voxel, int32_t bone_side,
                                int chunk_size, int chunk_count, ost_error *err)
{
    ost_status status = make(scene, tool, tool_voxel, bone_side, err);
    if (status == OST_OK)
        status = move_to_middle(&scene->event, err);
    scene->event.by_range = false;
    if (status == OST_OK && chunk_count)
        status = keep_chunks(scene, chunk_size, chunk_count, err);
    if (status == OST_OK)
        methods_scene_set_region(scene);
    else
        methods_scene_free(scene);
    return status;
}
