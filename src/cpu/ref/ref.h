/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The reference: a scalar and serial implementation of docs/spec/arithmetic.md.  Each
 * file names the rules of that document that it implements.  The code is deliberately
 * simple and not optimised.
 *
 *   import.c    samples -> rect grid -> cubic grid      AR-CT-4..6, AR-CUB
 *   bone.c      cubic grid -> chunks, slices, leaves    AR-CHK, AR-DIG-2
 *   tool.c      tool grids
 *   voxelize.c  snapped mesh -> tool grid               AR-VOX
 *   remove.c    removal and collision                   AR-MAP, AR-REM
 *   face_mesh.c visible faces as quads; no voxel depends on them
 *   ref.c       the table
 */
#ifndef OST_CPU_REF_H
#define OST_CPU_REF_H

#include "core/backend.h"
#include "core/chunk_grid.h"

typedef struct ref_backend {
    ost_backend base;
    ost_digest empty_leaf; /* digest of a leaf of 32^3 zeros, computed once when the backend is opened */
} ref_backend;

typedef struct ref_grid {
    ost_grid base;
    int16_t *voxels; /* owned */
    uint8_t *seen;   /* owned; one bit per voxel, 1 if the voxel has a sample; NULL before the first batch */
} ref_grid;

typedef struct ref_bone {
    ost_bone base;
    ost_chunk_grid chunks;
} ref_bone;

typedef struct ref_tool {
    ost_tool base;
    uint8_t *voxels; /* owned */
} ref_tool;

ost_status ost_ref_grid_create(ost_backend *backend, const ost_geometry *geometry, ost_grid **out, ost_error *err);
void ost_ref_grid_free(ost_grid *grid);
ost_status ost_ref_grid_upload(ost_grid *grid, int32_t z0, int32_t count, const int16_t *voxels, ost_error *err);
ost_status ost_ref_grid_download(const ost_grid *grid, int32_t z0, int32_t count, int16_t *voxels, ost_error *err);
ost_status ost_ref_ct_to_rect(ost_grid *rect, const ost_sample *samples, size_t count, int64_t first_line,
                              ost_duplicates duplicates, ost_scatter_report *report, ost_error *err);
ost_status ost_ref_rect_to_cubic(const ost_grid *rect, const ost_geometry *geometry, ost_resample rule, ost_grid **out,
                                 ost_error *err);

ost_status ost_ref_cubic_to_chunks(const ost_grid *cubic, int chunk_size, int32_t threshold, ost_bone **out,
                                   ost_error *err);
ost_status ost_ref_bone_create(ost_backend *backend, const ost_geometry *geometry, int chunk_size, int32_t threshold,
                               ost_bone **out, ost_error *err);
void ost_ref_bone_free(ost_bone *bone);
ost_status ost_ref_bone_stats(const ost_bone *bone, ost_bone_info *info, ost_error *err);
ost_status ost_ref_bone_upload(ost_bone *bone, int32_t z0, int32_t count, const int16_t *voxels, ost_error *err);
ost_status ost_ref_bone_download(const ost_bone *bone, int32_t z0, int32_t count, int16_t *voxels, ost_error *err);
ost_status ost_ref_bone_sample(const ost_bone *bone, size_t count, const int32_t *const at[3], int16_t *densities,
                               ost_error *err);
ost_status ost_ref_bone_occupancy(const ost_bone *bone, size_t count, const int32_t *chunks, uint32_t *words,
                                  ost_error *err);
ost_status ost_ref_bone_leaves(const ost_bone *bone, ost_digest *leaves, ost_error *err);

ost_status ost_ref_tool_upload(ost_backend *backend, const ost_tool_volume *volume, ost_tool **out, ost_error *err);
ost_status ost_ref_tool_download(const ost_tool *tool, ost_tool_volume *volume, ost_error *err);
void ost_ref_tool_free(ost_tool *tool);

ost_status ost_ref_voxelize_tool(ost_backend *backend, const ost_snapped_mesh *cutting,
                                 const ost_snapped_mesh *noncutting, ost_fill_rule rule, ost_voxelize_report *report,
                                 ost_tool **out, ost_error *err);

ost_status ost_ref_remove(ost_bone *bone, const ost_tool *tool, const ost_removal_event *event,
                          ost_removal_report *report, ost_error *err);
ost_status ost_ref_collide(const ost_bone *bone, const ost_tool *tool, const ost_removal_event *event,
                           ost_removal_report *report, ost_error *err);

ost_status ost_ref_face_mesh(ost_backend *backend, const ost_face_cluster *clusters, size_t count, ost_face_mesh *mesh,
                             ost_error *err);

#endif
