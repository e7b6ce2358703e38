/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The types and functions that several methods on the processor share. These methods store the complete
 * bone as one matrix of densities, and the tool's grid as bits.
 *
 *   matrix_bone   element i + nx (j + ny k) is the density of voxel (i, j, k) (Alg. 1.1)
 *   matrix_tool   bit i + nx (j + ny k) is 1 if tool voxel (i, j, k) is cutting; one bit per voxel uses the least cache
 *   matrix_map    the map of one pose: the steps, and the base of each block of 16^3 voxels (AR-MAP-4)
 */
#ifndef OST_REPRODUCTION_METHODS_MATRIX_H
#define OST_REPRODUCTION_METHODS_MATRIX_H

#include "reproduction/methods/method.h"

typedef struct matrix_bone {
    const methods_scene *scene;
    int16_t *voxels; /* owned */
    size_t count;
} matrix_bone;

ost_status matrix_bone_init(matrix_bone *bone, const methods_scene *scene, ost_error *err);
void matrix_bone_free(matrix_bone *bone);
/* Restores the bone's voxels in the scene's region, which also loads them into the caches. */
void matrix_bone_restore(matrix_bone *bone);
/* Adds to `set` the voxels that are active in the scene's bone but have been removed from this bone. */
void matrix_bone_result(const matrix_bone *bone, method_set *set);
int64_t matrix_bone_bytes(const matrix_bone *bone);

typedef struct matrix_tool {
    uint32_t *words; /* owned */
    size_t count;    /* words */
    int32_t dims[3];
} matrix_tool;

/* The tool has fewer than 2^31 voxels, because a tool for removal has at most 2^10 voxels per axis (AR-MAP-2). */
ost_status matrix_tool_init(matrix_tool *tool, const ost_tool_volume *volume, ost_error *err);
void matrix_tool_free(matrix_tool *tool);

/* Reads `bytes` bytes to load them into the caches. */
void matrix_touch(const void *data, size_t bytes);

/* The map's bases for the blocks of 16^3 voxels that overlap a box. */
typedef struct matrix_map {
    int32_t first[3], count[3]; /* the first block and the number of blocks along each axis */
    int32_t (*base)[3];         /* owned; x fastest; the base of a far block is MATRIX_FAR on each axis */
    size_t capacity;
    int32_t step[3][3];
} matrix_map;

/*
 * The base of a far block (AR-MAP-5). With this base, every coordinate of the block is negative: the sum of up to
 * 15 steps along each axis is less than 2^29 (AR-MAP-5), so all coordinates are in [-2^30 - 2^29, -2^29).
 */
#define MATRIX_FAR (-(1 << 30))

/* Computes the bases for a pose. The memory is reused by the next call. */
ost_status matrix_map_make(matrix_map *out, const ost_map *map, const ost_voxel_box *box, ost_error *err);
void matrix_map_free(matrix_map *map);

/*
 * Sets hit[i] to -1 if a cutting tool voxel covers voxel i of a row of 16 voxels of one block, and to 0 otherwise. `u`
 * is the tool coordinate of the first voxel. The number of iterations is constant and the loop has no branch, so the
 * compiler can use vector instructions.
 */
static inline void matrix_hits(int16_t hit[restrict OST_MAP_BLOCK], const int32_t u[3], const int32_t step[3],
                              const matrix_tool *tool)
{
    const int32_t nx = tool->dims[0], ny = tool->dims[1], nz = tool->dims[2];
    const int32_t ux = u[0], uy = u[1], uz = u[2], sx = step[0], sy = step[1], sz = step[2];
    const uint32_t *restrict words = tool->words;
    for (int32_t i = 0; i < OST_MAP_BLOCK; i++) {
        const uint32_t x = (uint32_t)((ux + i * sx) >> OST_MAP_FRACTION),
                       y = (uint32_t)((uy + i * sy) >> OST_MAP_FRACTION),
                       z = (uint32_t)((uz + i * sz) >> OST_MAP_FRACTION);
        const bool inside = (x < (uint32_t)nx) & (y < (uint32_t)ny) & (z < (uint32_t)nz);
        const uint32_t bit = inside ? x + (uint32_t)nx * (y + (uint32_t)ny * z) : 0;
        hit[i] = (int16_t)-(int32_t)((words[bit >> 5] >> (bit & 31)) & (uint32_t)inside);
    }
}

/* Removes the hit voxels of a box from a matrix of densities, row by row. The box must lie within the blocks of the
   map. */
void matrix_remove_box(int16_t *voxels, ost_dims bone, const ost_voxel_box *box, const matrix_map *map,
                      const matrix_tool *tool, int threads);

#endif
