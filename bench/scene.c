/* SPDX-License-Identifier: Apache-2.0 */
/* The static removal events: their tools, bones and poses, and the data of the same events for the
   thesis' kernel. */
#include "bench/scene.h"

#include <stdlib.h>
#include <string.h>

#include "bench/inputs.h"
#include "core/int128.h"
#include "sim/box.h"

/* The poses of the static events, found by random search (see scene.h). */
static const struct {
    ost_pose pose;
    bool by_range;
} static_events[OST_TOOL_KIND_COUNT] = {
    [OST_TOOL_REAMER] = {.pose = {.t = {INT64_C(43125000000), INT64_C(48105000000), INT64_C(41711000000)},
                                  .qw = 530420327, .qx = -283588849, .qy = 416957394, .qz = -785684210}},
    [OST_TOOL_PEG] = {.pose = {.t = {INT64_C(30607000000), INT64_C(38954000000), INT64_C(14925000000)},
                               .qw = 105468265, .qx = 288463883, .qy = -358551709, .qz = 964379184},
                      .by_range = true},
};

ost_status bench_scene_init(bench_scene *scene, ost_tool_kind kind, ost_pm tool_voxel, int32_t side, ost_error *err)
{
    return bench_scene_init_by(scene, "ref", kind, tool_voxel, side, err);
}

ost_status bench_scene_init_by(bench_scene *scene, const char *backend, ost_tool_kind kind, ost_pm tool_voxel,
                               int32_t side, ost_error *err)
{
    *scene = (bench_scene){
        .tool_name = ost_tool_kind_name(kind),
        .bone = {.dims = {side, side, side}, .spacing = {SCENE_SPACING, SCENE_SPACING, SCENE_SPACING}},
        .classes = ost_density_classes_default(),
        .by_range = static_events[kind].by_range,
    };
    ost_status status = bench_tool_volume(backend, kind, tool_voxel, &scene->tool, err);
    ost_pose pose = static_events[kind].pose;
    const ost_pm shift = (side - SCENE_SIDE) * SCENE_SPACING;
    pose.t.x += shift;
    pose.t.y += shift;
    pose.t.z += shift;
    return status == OST_OK ? bench_scene_set_pose(scene, &pose, err) : status;
}

ost_status bench_scene_set_pose(bench_scene *scene, const ost_pose *pose, ost_error *err)
{
    const ost_box box = ost_box_of_tool(&scene->tool.geometry);
    scene->pose = *pose;
    scene->box = ost_box_voxels(&scene->bone, &box, pose);
    scene->event = (ost_removal_event){
        .pose_count = 1, .maps = &scene->map, .boxes = &scene->box, .classes = &scene->classes};
    return ost_map_make(pose, &scene->bone, &scene->tool.geometry, &scene->map, err);
}

void bench_scene_free(bench_scene *scene)
{
    ost_tool_volume_free(&scene->tool);
}

/* Returns the density of a voxel of the bone. Every density class contains densities of the bone, and no
   density is below the threshold. */
static int16_t density_at(int32_t i, int32_t j, int32_t k)
{
    return (int16_t)(SCENE_THRESHOLD + ((i * 7 + j * 13 + k * 29) & 1023));
}

int16_t *bench_scene_slices(const bench_scene *scene, int32_t z0, int32_t count)
{
    const ost_dims d = scene->bone.dims;
    int16_t *voxels = malloc((size_t)d.x * (size_t)d.y * (size_t)count * sizeof *voxels);
    if (!voxels)
        return NULL;
    int16_t *at = voxels;
    for (int32_t k = z0; k < z0 + count; k++)
        for (int32_t j = 0; j < d.y; j++)
            for (int32_t i = 0; i < d.x; i++)
                *at++ = density_at(i, j, k);
    return voxels;
}

ost_status bench_scene_bone(const bench_scene *scene, ost_backend *backend, int chunk_size, ost_bone **out,
                            ost_error *err)
{
    enum { SLAB = 64 };
    ost_status status = ost_bone_create(backend, &scene->bone, chunk_size, SCENE_THRESHOLD, out, err);
    for (int32_t z = 0; z < scene->bone.dims.z && status == OST_OK; z += SLAB) {
        int32_t count = scene->bone.dims.z - z < SLAB ? scene->bone.dims.z - z : SLAB;
        int16_t *voxels = bench_scene_slices(scene, z, count);
        status = voxels ? ost_bone_upload(*out, z, count, voxels, err)
                        : ost_fail(err, OST_ERR_MEMORY, "out of memory for a bone's slices");
        free(voxels);
    }
    return status;
}

/* ------------------------------------------------------------ the thesis' form */

/* Returns true if the voxel's centre is inside the tool's grid. The computation is exact, as in AR-MAP,
   except for the last rounding of the base. */
static bool enters(const bench_scene *scene, const int32_t base[3], int32_t i, int32_t j, int32_t k)
{
    const ost_dims d = scene->tool.geometry.dims;
    const int32_t dims[3] = {d.x, d.y, d.z};
    for (int a = 0; a < 3; a++) {
        int32_t u = base[a] + i * scene->map.step[0][a] + j * scene->map.step[1][a] + k * scene->map.step[2][a];
        if (u < 0 || u >> OST_MAP_FRACTION >= dims[a])
            return false;
    }
    return true;
}

static bool block_enters(const bench_scene *scene, const int32_t first[3])
{
    int32_t base[3];
    if (!ost_map_block_base(&scene->map,
                            (ost_dims){first[0] / OST_MAP_BLOCK, first[1] / OST_MAP_BLOCK, first[2] / OST_MAP_BLOCK},
                            base))
        return false;
    for (int32_t k = 0; k < OST_MAP_BLOCK; k++)
        for (int32_t j = 0; j < OST_MAP_BLOCK; j++)
            for (int32_t i = 0; i < OST_MAP_BLOCK; i++)
                if (enters(scene, base, i, j, k))
                    return true;
    return false;
}

static bool collides(const bench_scene *scene, const int32_t corner[3], int32_t n)
{
    for (int a = 0; a < 3; a++)
        if (corner[a] + n <= scene->box.lo[a] || corner[a] >= scene->box.hi[a])
            return false;
    if (scene->by_range)
        return true;
    for (int32_t z = 0; z < n; z += OST_MAP_BLOCK)
        for (int32_t y = 0; y < n; y += OST_MAP_BLOCK)
            for (int32_t x = 0; x < n; x += OST_MAP_BLOCK)
                if (block_enters(scene, (const int32_t[3]){corner[0] + x, corner[1] + y, corner[2] + z}))
                    return true;
    return false;
}

int bench_scene_chunks(const bench_scene *scene, int32_t n, int32_t (*corners)[3])
{
    int count = 0;
    for (int32_t z = scene->box.lo[2] / n * n; z < scene->box.hi[2]; z += n)
        for (int32_t y = scene->box.lo[1] / n * n; y < scene->box.hi[1]; y += n)
            for (int32_t x = scene->box.lo[0] / n * n; x < scene->box.hi[0]; x += n)
                if (collides(scene, (const int32_t[3]){x, y, z}, n)) {
                    if (corners)
                        memcpy(corners[count], (const int32_t[3]){x, y, z}, sizeof corners[count]);
                    count++;
                }
    return count;
}

/* Rounds the exact map to an affine matrix of floats, which maps bone voxels to tool voxels. The corner of the tool's
   grid is at 0. */
static void float_map(const ost_map *map, float out[3][4])
{
    const double scale = (double)ost_i128_of(map->divisor) * (1 << OST_MAP_FRACTION);
    for (int a = 0; a < 3; a++) {
        for (int b = 0; b < 3; b++)
            out[a][b] = (float)((double)ost_i128_of(map->column[b][a]) / scale);
        out[a][3] = (float)((double)ost_i128_of(map->origin[a]) / scale);
    }
}

ost_status bench_thesis_init(bench_thesis *thesis, const bench_scene *scene, int chunk_size, ost_error *err)
{
    const size_t n = (size_t)chunk_size, voxels = n * n * n,
                 tool_voxels = (size_t)ost_dims_count(scene->tool.geometry.dims);
    const ost_dims d = scene->tool.geometry.dims;
    const int count = bench_scene_chunks(scene, chunk_size, NULL);
    *thesis = (bench_thesis){.bytes = (size_t)count * voxels * sizeof(int16_t)};
    thesis->tool = malloc(tool_voxels * sizeof *thesis->tool);
    thesis->full = aligned_alloc(64, thesis->bytes);
    thesis->live = aligned_alloc(64, thesis->bytes);
    thesis->chunks = malloc((size_t)count * sizeof *thesis->chunks);
    thesis->corners = malloc((size_t)count * sizeof *thesis->corners);
    if (count == 0 || !thesis->tool || !thesis->full || !thesis->live || !thesis->chunks || !thesis->corners) {
        bench_thesis_free(thesis);
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for the thesis' event of %d chunks", count);
    }
    bench_scene_chunks(scene, chunk_size, thesis->corners);
    for (size_t i = 0; i < tool_voxels; i++)
        thesis->tool[i] = scene->tool.voxels[i] == OST_TOOL_CUTTING;
    int16_t *at = thesis->full;
    for (int c = 0; c < count; c++) {
        thesis->chunks[c] = thesis->live + (size_t)c * voxels;
        for (int32_t k = 0; k < chunk_size; k++)
            for (int32_t j = 0; j < chunk_size; j++)
                for (int32_t i = 0; i < chunk_size; i++)
                    *at++ = density_at(thesis->corners[c][0] + i, thesis->corners[c][1] + j, thesis->corners[c][2] + k);
    }
    thesis->event = (bench_thesis_event){
        .chunk_count = count,
        .chunk_size = chunk_size,
        .chunks = thesis->chunks,
        .corners = (const int32_t(*)[3])thesis->corners,
        .dims = {d.x, d.y, d.z},
        .tool = thesis->tool,
    };
    float_map(&scene->map, thesis->event.map);
    bench_thesis_restore(thesis);
    return OST_OK;
}

void bench_thesis_restore(bench_thesis *thesis)
{
    memcpy(thesis->live, thesis->full, thesis->bytes);
}

void bench_thesis_free(bench_thesis *thesis)
{
    free(thesis->tool);
    free(thesis->full);
    free(thesis->live);
    free(thesis->chunks);
    free(thesis->corners);
    *thesis = (bench_thesis){0};
}

int64_t bench_thesis_differs(const bench_thesis *thesis, const bench_scene *scene, const int16_t *voxels)
{
    const ost_dims d = scene->bone.dims;
    const int32_t n = thesis->event.chunk_size;
    int64_t differs = 0;
    for (int c = 0; c < thesis->event.chunk_count; c++)
        for (int32_t k = 0; k < n; k++)
            for (int32_t j = 0; j < n; j++)
                for (int32_t i = 0; i < n; i++) {
                    const int32_t *at = thesis->corners[c];
                    differs += thesis->chunks[c][i + n * (j + n * k)] !=
                               voxels[at[0] + i + (int64_t)d.x * (at[1] + j + (int64_t)d.y * (at[2] + k))];
                }
    return differs;
}

/* Counts the voxels that the event removed from the 4^3 brick at (x, y, z). These are the voxels with
   density 0, because no voxel had the density 0 before the event. */
static int removed_of_brick(const int16_t *chunk, int32_t n, int32_t x, int32_t y, int32_t z)
{
    int removed = 0;
    for (int32_t k = z; k < z + 4; k++)
        for (int32_t j = y; j < y + 4; j++)
            for (int32_t i = x; i < x + 4; i++)
                removed += chunk[i + n * (j + n * k)] == 0;
    return removed;
}

static void count_bricks(bench_work *work, const int16_t *chunk, int32_t n)
{
    for (int32_t z = 0; z < n; z += 4)
        for (int32_t y = 0; y < n; y += 4)
            for (int32_t x = 0; x < n; x += 4) {
                const int removed = removed_of_brick(chunk, n, x, y, z);
                work->complete_bricks += removed == 64;
                work->mixed_bricks += removed > 0 && removed < 64;
            }
}

ost_status bench_work_count(bench_work *work, const bench_thesis *thesis, ost_error *err)
{
    enum { ROW = 32 };
    const size_t rows = thesis->bytes / sizeof(int16_t) / ROW;
    *work = (bench_work){0};
    for (int c = 0; c < thesis->event.chunk_count; c++)
        count_bricks(work, thesis->chunks[c], thesis->event.chunk_size);
    if (thesis->event.chunk_size != ROW)
        return OST_OK;
    work->rows = malloc(rows * sizeof *work->rows);
    if (!work->rows)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %zu rows", rows);
    for (size_t r = 0; r < rows; r++) {
        bench_row_store store = {.row = thesis->live + r * ROW};
        for (int i = 0; i < ROW; i++)
            store.hit |= (uint32_t)(store.row[i] == 0) << i;
        if (store.hit)
            work->rows[work->changed_rows++] = store;
    }
    return OST_OK;
}
