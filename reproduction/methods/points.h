/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tool points are the sparse buffer of tool voxels that the tool-to-bone methods process (thesis, section 3.2.3 and
 * Fig. 3.4). These methods map each point to the bone voxel that contains it.
 *
 *   point    e = 2 (i, j, k) + 1 - dims for a cutting tool voxel (i, j, k); e is the position of the voxel's centre
 *            relative to the centre of the tool's grid, in half tool voxels; on each axis, all e are odd or all are
 *            even
 *   map      u_b = base_b + sum_a e_a step[a][b]        in units of 2^-f of a bone voxel
 *   voxel    anchor_b + floor(u_b / 2^f) on axis b; if this voxel is not in the bone's grid, the point is outside
 *
 * Let the pose have the rotation R = M / N and the translation t (AR-POSE-4). Let c be the centre and s_t the voxel
 * size of the tool's grid, and o the origin and s the voxel size of the bone. In bone voxels, counted from the lower
 * corner of bone voxel (0, 0, 0), the centre of the tool's grid is at V_b = ((R c + t - o)_b + s / 2) / s. RHE rounds
 * half to even. Then
 *
 *   anchor_b  = floor(V_b)
 *   base_b    = RHE(2^f (V_b - anchor_b))
 *   step[a][b] = RHE(2^f M[b][a] s_t / (2 N s))
 *   f         = the greatest number <= 20 with 2^f + sum_a dims_a |step[a][b]| < 2^30 on every axis b
 *
 * The publications use floats. Here the map is in fixed-point numbers, so the set of hit voxels is the same on every
 * processor and device. The numbers of multiplications and memory accesses are the same as with floats.
 *
 * Error: |u_b - exact| <= 1/2 + sum_a dims_a / 2. With f = 20, this is at most 1,537 * 2^-20 = 0.0015 of a bone voxel
 * for a tool of 1024^3 voxels, and 0.0001 of a bone voxel for 64^3 voxels.
 * Ranges: |M| <= N < 2^61 and all lengths < 2^44 pm, so the products with three terms are below 2^110. The remainder
 * of the division for anchor_b is less than 2 N s < 2^99, and less than 2^119 after its multiplication by 2^f.
 */
#ifndef OST_REPRODUCTION_METHODS_POINTS_H
#define OST_REPRODUCTION_METHODS_POINTS_H

#include "reproduction/methods/matrix.h"

/* A block of points that are consecutive in the list. [lo, hi] is the range of their coordinates e. */
typedef struct points_block {
    int32_t first, count;
    int16_t lo[3], hi[3]; /* inclusive */
} points_block;

typedef struct method_points {
    ost_dims dims;  /* dimensions of the tool's grid */
    int32_t count;
    int16_t *e[3];  /* owned; one list per axis; the points are in the order of the tool's grid, or grouped by block */
    int32_t block_count; /* 0 if the points are not grouped */
    points_block *blocks; /* owned */
} method_points;

/* The map from points to bone voxels for a pose. */
typedef struct points_map {
    int32_t fraction; /* f */
    int32_t anchor[3], base[3], step[3][3]; /* step[tool axis][bone axis] */
} points_map;

/*
 * Lists the points of a tool. If `block` is not 0, the points are grouped in blocks of block^3 tool voxels. Returns
 * OST_ERR_RANGE if there are 2^31 points or more.
 */
ost_status method_points_init(method_points *points, const ost_tool_volume *tool, methods_points which, int block,
                              ost_error *err);
void method_points_free(method_points *points);

/*
 * Computes the map for a pose. Returns OST_ERR_RANGE if the pose, the bone or the tool exceeds the limits of AR-MAP-2.
 */
ost_status points_map_make(points_map *out, const ost_pose *pose, const ost_geometry *bone,
                           const ost_tool_geometry *tool, ost_error *err);

/*
 * Removes the bone voxels that contain one of the points [first, first + count). The box must lie within the bone's
 * grid. Points outside the box are skipped. If `inside` is true, all points must be in the box, and this is not
 * checked. The bone must have fewer than 2^32 - 1 voxels.
 */
void points_remove(int16_t *voxels, ost_dims bone, const ost_voxel_box *box, const method_points *points,
                   const points_map *map, int32_t first, int32_t count, bool inside);

/* ------------------------------------------------- the state of yau.c, zheng.c, reza.c */

/* The sparse buffer of a tool, and one buffer of bone voxels. */
typedef struct points_state {
    matrix_bone bone;
    method_points points;
    int threads;
    int64_t visited; /* number of points that were mapped in the last event */
} points_state;

ost_status points_state_open(const methods_scene *scene, const method_setup *setup, int block, points_state **out,
                             ost_error *err);
void points_state_close(void *state);
ost_status points_state_restore(void *state, ost_error *err);
ost_status points_state_result(void *state, method_set *set, ost_error *err);
void points_state_work(void *state, method_work *out);

/* Removes the voxels that contain the points [first, first + count), with the state's number of threads. */
void points_remove_range(points_state *s, const ost_voxel_box *box, const points_map *map, int32_t first,
                         int32_t count);

/* Returns the box of all voxels of a bone. */
ost_voxel_box points_whole_bone(ost_dims bone);
/* Computes the ranges lo <= e <= hi of the tool's points that may lie in a box of bone voxels. The box's eight corners
   are mapped to the tool's grid, and the range of the mapped corners is extended by one tool voxel on each side. */
void points_ranges_of_box(const ost_map *map, const ost_voxel_box *box, ost_dims tool, int32_t lo[3], int32_t hi[3]);
/* Returns the index of the first point with e[2] >= z. The points must be in the order of the tool's grid. */
int32_t points_first_from(const method_points *points, int32_t z);

#endif
