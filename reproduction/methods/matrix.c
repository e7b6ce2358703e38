/* SPDX-License-Identifier: Apache-2.0 */
/* Implements matrix.h: the bone as one matrix of densities, the tool's grid as bits, and the loop that compares the
   bone voxels of a box with the tool's grid. */
#include "reproduction/methods/matrix.h"

#include <stdlib.h>
#include <string.h>

ost_status matrix_bone_init(matrix_bone *bone, const methods_scene *scene, ost_error *err)
{
    *bone = (matrix_bone){.scene = scene, .count = (size_t)ost_dims_count(scene->event.bone.dims)};
    bone->voxels = malloc(bone->count * sizeof *bone->voxels);
    if (!bone->voxels)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a bone of %zu voxels", bone->count);
    memcpy(bone->voxels, scene->voxels, bone->count * sizeof *bone->voxels);
    return OST_OK;
}

void matrix_bone_free(matrix_bone *bone)
{
    free(bone->voxels);
    *bone = (matrix_bone){0};
}

void matrix_bone_restore(matrix_bone *bone)
{
    const ost_voxel_box *r = &bone->scene->region;
    const ost_dims d = bone->scene->event.bone.dims;
    if (r->lo[0] >= r->hi[0])
        return;
    const size_t bytes = (size_t)(r->hi[0] - r->lo[0]) * sizeof *bone->voxels;
    for (int32_t k = r->lo[2]; k < r->hi[2]; k++)
        for (int32_t j = r->lo[1]; j < r->hi[1]; j++) {
            const size_t at = (size_t)r->lo[0] + (size_t)d.x * ((size_t)j + (size_t)d.y * (size_t)k);
            memcpy(bone->voxels + at, bone->scene->voxels + at, bytes);
        }
}

void matrix_bone_result(const matrix_bone *bone, method_set *set)
{
    const ost_voxel_box *r = &set->box;
    const ost_dims d = bone->scene->event.bone.dims;
    for (int32_t k = r->lo[2]; k < r->hi[2]; k++)
        for (int32_t j = r->lo[1]; j < r->hi[1]; j++) {
            const size_t row = (size_t)d.x * ((size_t)j + (size_t)d.y * (size_t)k), at = method_set_row(set, j, k);
            for (int32_t i = r->lo[0]; i < r->hi[0]; i++)
                if (bone->scene->voxels[row + (size_t)i] != 0 && bone->voxels[row + (size_t)i] == 0)
                    set->in[at + (size_t)(i - r->lo[0])] = 1;
        }
}

int64_t matrix_bone_bytes(const matrix_bone *bone)
{
    return (int64_t)(bone->count * sizeof *bone->voxels);
}

ost_status matrix_tool_init(matrix_tool *tool, const ost_tool_volume *volume, ost_error *err)
{
    const ost_dims d = volume->geometry.dims;
    const size_t voxels = (size_t)ost_dims_count(d);
    *tool = (matrix_tool){.dims = {d.x, d.y, d.z}, .count = voxels / 32 + 1};
    tool->words = calloc(tool->count, sizeof *tool->words);
    if (!tool->words)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a tool of %zu voxels", voxels);
    for (size_t v = 0; v < voxels; v++)
        if (volume->voxels[v] == OST_TOOL_CUTTING)
            tool->words[v / 32] |= UINT32_C(1) << v % 32;
    return OST_OK;
}

void matrix_tool_free(matrix_tool *tool)
{
    free(tool->words);
    *tool = (matrix_tool){0};
}

void matrix_touch(const void *data, size_t bytes)
{
    const volatile uint8_t *at = data;
    for (size_t i = 0; i < bytes; i += 64)
        (void)at[i];
}

ost_status matrix_map_make(matrix_map *out, const ost_map *map, const ost_voxel_box *box, ost_error *err)
{
    size_t count = 1;
    for (int a = 0; a < 3; a++) {
        const int32_t hi = box->hi[a] > box->lo[a] ? box->hi[a] : box->lo[a];
        out->first[a] = box->lo[a] / OST_MAP_BLOCK;
        out->count[a] = (hi + OST_MAP_BLOCK - 1) / OST_MAP_BLOCK - out->first[a];
        count *= (size_t)out->count[a];
    }
    if (count > out->capacity) {
        free(out->base);
        out->capacity = 0;
        out->base = malloc(count * sizeof *out->base);
        if (!out->base)
            return ost_fail(err, OST_ERR_MEMORY, "out of memory for the map of %zu blocks", count);
        out->capacity = count;
    }
    memcpy(out->step, map->step, sizeof out->step);
    int32_t(*base)[3] = out->base;
    for (int32_t z = 0; z < out->count[2]; z++)
        for (int32_t y = 0; y < out->count[1]; y++)
            for (int32_t x = 0; x < out->count[0]; x++, base++)
                if (!ost_map_block_base(map, (ost_dims){out->first[0] + x, out->first[1] + y, out->first[2] + z},
                                        *base))
                    (*base)[0] = (*base)[1] = (*base)[2] = MATRIX_FAR;
    return OST_OK;
}

void matrix_map_free(matrix_map *map)
{
    free(map->base);
    *map = (matrix_map){0};
}

/* Processes the voxels [i0, i1) of row (j, k), one block after the other. */
static void remove_row(int16_t *row, int32_t i0, int32_t i1, int32_t j, int32_t k, const matrix_map *map,
                       const matrix_tool *tool)
{
    const int32_t dj = j % OST_MAP_BLOCK, dk = k % OST_MAP_BLOCK;
    const int32_t by = j / OST_MAP_BLOCK - map->first[1], bz = k / OST_MAP_BLOCK - map->first[2];
    const int32_t(*base)[3] = (const int32_t(*)[3])map->base + map->count[0] * (by + (int64_t)map->count[1] * bz);
    for (int32_t bx = i0 / OST_MAP_BLOCK; bx * OST_MAP_BLOCK < i1; bx++) {
        const int32_t first = bx * OST_MAP_BLOCK;
        int16_t hit[OST_MAP_BLOCK];
        int32_t u[3];
        for (int a = 0; a < 3; a++)
            u[a] = base[bx - map->first[0]][a] + dj * map->step[1][a] + dk * map->step[2][a];
        matrix_hits(hit, u, map->step[0], tool);
        if (first >= i0 && first + OST_MAP_BLOCK <= i1) {
            for (int32_t i = 0; i < OST_MAP_BLOCK; i++)
                row[first + i] = (int16_t)(row[first + i] & ~hit[i]);
            continue;
        }
        for (int32_t i = first > i0 ? first : i0; i < first + OST_MAP_BLOCK && i < i1; i++)
            row[i] = (int16_t)(row[i] & ~hit[i - first]);
    }
}

void matrix_remove_box(int16_t *voxels, ost_dims bone, const ost_voxel_box *box, const matrix_map *map,
                      const matrix_tool *tool, int threads)
{
    (void)threads;
    const int32_t height = box->hi[1] - box->lo[1], rows = height * (box->hi[2] - box->lo[2]);
    if (height <= 0 || rows <= 0 || box->lo[0] >= box->hi[0])
        return;
#if defined _OPENMP
#pragma omp parallel for schedule(static) num_threads(threads) if (threads > 1)
#endif
    for (int32_t r = 0; r < rows; r++) {
        const int32_t j = box->lo[1] + r % height, k = box->lo[2] + r / height;
        remove_row(voxels + (size_t)bone.x * ((size_t)j + (size_t)bone.y * (size_t)k), box->lo[0], box->hi[0], j, k,
                   map, tool);
    }
}
