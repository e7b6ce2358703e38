/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The objects of the dense backend, and its functions for integer division.
 *
 *   import.c   samples -> rect grid -> cubic grid     AR-CT-4..6, AR-CUB
 *   bone.c     bones                                  AR-CHK, AR-DIG-2
 *   tool.c     mesh -> tool grid                      AR-VOX
 *   map.c      bone voxel -> tool voxel               AR-MAP
 *   remove.c   events                                 AR-REM, AR-CLS
 *   thesis.c   the float arithmetic of the thesis
 *   dense.c    the function table
 *
 * Each stage is a function that takes a deviant or NULL. If the deviation can act in a stage, the stage
 * runs a second time with NULL, and the differences are recorded.
 */
#ifndef OST_VALIDATION_DENSE_PARTS_H
#define OST_VALIDATION_DENSE_PARTS_H

#include "core/backend.h"
#include "core/conditions.h"
#include "validation/dense/dense.h"
#include "validation/dense/deviant.h"

typedef struct dense_grid dense_grid;

typedef struct dense {
    ost_backend base;
    deviant *deviant; /* &own if a mistake is made, otherwise NULL */
    deviant own;
    dense_grid *unsettled; /* borrowed; the rect grid whose changes have not been recorded yet; NULL if there is none */
    ost_map last_map;      /* the map of the last pose of the most recent event */
    bool has_last_map;
} dense;

/* The voxels of a rect grid, and one flag per voxel, which is set if the voxel has a sample. */
typedef struct dense_scatter {
    int16_t *voxels;
    uint8_t *seen;
    ost_scatter_report report;
} dense_scatter;

struct dense_grid {
    ost_grid base;
    dense_scatter made;
    dense_scatter right; /* the same grid without the mistake; NULL arrays if no mistake is made */
    uint64_t call, samples, batches;
    bool scattered;
};

typedef struct dense_bone {
    ost_bone base;
    int16_t *density;
    uint8_t *active; /* for each voxel, 1 if it is active, otherwise 0 */
} dense_bone;

typedef struct dense_tool {
    ost_tool base;
    uint8_t *voxels;
} dense_tool;

static inline dense *dense_of(const ost_backend *backend)
{
    return (dense *)(uintptr_t)backend;
}

/* Returns the index of voxel (x, y, z) (AR-GRID-2). */
static inline int64_t dense_at(ost_dims d, int64_t x, int64_t y, int64_t z)
{
    return x + d.x * (y + d.y * z);
}

/* --------------------------------------------------------------- AR-INT */

__extension__ typedef __int128 int128;

/* Converts a 128-bit number of a map to the compiler's 128-bit type. */
static inline int128 dense_int128(ost_int128 v)
{
    return (int128)v.high * ((int128)1 << 64) + (int128)v.low;
}

/* Returns n / d rounded down, for d > 0. */
static inline int128 dense_floor(int128 n, int128 d)
{
    if (n >= 0)
        return n / d;
    return -((-n + d - 1) / d);
}

/* Returns the integer nearest to n / d; if two integers are equally near, returns the even one. The remainder
   times 2 is compared with d, which is below 2^98 in all uses. */
static inline int128 dense_nearest(int128 n, int128 d)
{
    const int128 below = dense_floor(n, d), twice = 2 * (n - below * d);
    if (twice < d)
        return below;
    if (twice > d)
        return below + 1;
    return below % 2 == 0 ? below : below + 1;
}

/* ------------------------------------------------ functions of the parts */

/* Called after the last batch of a rect grid. Records the changes that the mistake made in the grid. A repeated call
   for the same grid has no effect. */
void dense_grid_finish(dense_grid *grid);

ost_status dense_grid_create(ost_backend *backend, const ost_geometry *geometry, ost_grid **out, ost_error *err);
void dense_grid_free(ost_grid *grid);
ost_status dense_grid_upload(ost_grid *grid, int32_t z0, int32_t count, const int16_t *voxels, ost_error *err);
ost_status dense_grid_download(const ost_grid *grid, int32_t z0, int32_t count, int16_t *voxels, ost_error *err);
ost_status dense_ct_to_rect(ost_grid *rect, const ost_sample *samples, size_t count, int64_t first_line,
                            ost_duplicates duplicates, ost_scatter_report *report, ost_error *err);
ost_status dense_rect_to_cubic(const ost_grid *rect, const ost_geometry *geometry, ost_resample rule, ost_grid **out,
                               ost_error *err);

ost_status dense_cubic_to_chunks(const ost_grid *cubic, int chunk_size, int32_t threshold, ost_bone **out,
                                 ost_error *err);
ost_status dense_bone_create(ost_backend *backend, const ost_geometry *geometry, int chunk_size, int32_t threshold,
                             ost_bone **out, ost_error *err);
void dense_bone_free(ost_bone *bone);
ost_status dense_bone_stats(const ost_bone *bone, ost_bone_info *info, ost_error *err);
ost_status dense_bone_upload(ost_bone *bone, int32_t z0, int32_t count, const int16_t *voxels, ost_error *err);
ost_status dense_bone_download(const ost_bone *bone, int32_t z0, int32_t count, int16_t *voxels, ost_error *err);
ost_status dense_bone_leaves(const ost_bone *bone, ost_digest *leaves, ost_error *err);

ost_status dense_voxelize(ost_backend *backend, const ost_snapped_mesh *cutting, const ost_snapped_mesh *noncutting,
                          ost_fill_rule rule, ost_voxelize_report *report, ost_tool **out, ost_error *err);
ost_status dense_tool_upload(ost_backend *backend, const ost_tool_volume *volume, ost_tool **out, ost_error *err);
ost_status dense_tool_download(const ost_tool *tool, ost_tool_volume *volume, ost_error *err);
void dense_tool_free(ost_tool *tool);

ost_status dense_remove(ost_bone *bone, const ost_tool *tool, const ost_removal_event *event,
                        ost_removal_report *report, ost_error *err);
ost_status dense_collide(const ost_bone *bone, const ost_tool *tool, const ost_removal_event *event,
                         ost_removal_report *report, ost_error *err);

/* ------------------------------------------------- the marks of an event's voxels */

/* For each voxel of the bone, `cut` counts the poses at which the voxel lies in a cutting tool voxel, and `touch`
   counts the poses at which it lies in a tool voxel that does not cut. */
typedef struct dense_marks {
    uint16_t *cut, *touch;
    uint8_t *met; /* for each chunk, 1 if it contains a marked voxel, otherwise 0 */
} dense_marks;

/* Marks bone voxel v, which lies in a tool voxel of class `found`. */
static inline void dense_mark(const dense_bone *bone, dense_marks marks, const int32_t v[3], uint8_t found)
{
    const ost_dims d = bone->base.geometry.dims;
    const int32_t n = bone->base.chunk_size;
    const int64_t at = dense_at(d, v[0], v[1], v[2]);
    if (found == OST_TOOL_VOID)
        return;
    marks.met[dense_at((ost_dims){(d.x + n - 1) / n, (d.y + n - 1) / n, 1}, v[0] / n, v[1] / n, v[2] / n)] = 1;
    if (found == OST_TOOL_CUTTING)
        marks.cut[at]++;
    else
        marks.touch[at]++;
}

/* Adds the marks of one pose. `number` is the index of the pose in the event. */
void dense_map_pose(deviant *m, const dense_bone *bone, const dense_tool *tool, const ost_map *map,
                    const ost_voxel_box *box, int number, dense_marks marks);

/* ----------------------------------------- the arithmetic of the thesis */

/* Computes a sample's position by Alg. 2.4 on the grid of Alg. 2.3. Returns false if the sample lies beyond the end
   of the array. */
bool dense_thesis_rect(const ost_geometry *g, const ost_sample *sample, int64_t at[3]);
/* Returns the source layer of cubic layer z, by Alg. 2.5 of the thesis. */
int64_t dense_thesis_layer(int32_t z, ost_pm cubic, ost_pm rect, bool fused);
/* Computes MinVoxelCoords (Alg. 2.1 of the thesis) of both meshes together, in millimetres. */
void dense_thesis_bounds(const ost_snapped_mesh *cutting, const ost_snapped_mesh *noncutting, bool fused,
                         float minimum[3]);
/* Computes the counts of one row as tool.c does, but with float edge functions instead of integers. */
void dense_thesis_row(const ost_snapped_mesh *mesh, const float minimum[3], int32_t j, int32_t k, bool fused,
                      int32_t *count, uint32_t *times, int64_t *total, uint64_t *owners);
/* Adds the marks of the voxels that a tool hits at one pose, as computed by Algs. 2.8 to 2.10. */
void dense_thesis_pose(const dense_bone *bone, const dense_tool *tool, const ost_map *map, bool fused,
                       dense_marks marks);

#endif
