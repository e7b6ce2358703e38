/* SPDX-License-Identifier: Apache-2.0 */
/* Defines the grids, bones and tools on a device, and declares the slots that process them. */
#ifndef OST_CL_OBJECTS_H
#define OST_CL_OBJECTS_H

#include "cl/cl.h"

/* The voxels of one grid or of several grids. Voxels that several grids share are not written. */
typedef struct cl_store {
    cl_mem voxels;
    size_t reserved; /* capacity of the `voxels` buffer in bytes */
    int holders;
} cl_store;

/*
 * A dense grid of int16.  If a grid was resampled only along z, each of its slices is a
 * slice of the source grid, or the weighted mean of two such slices.  Until the grid is
 * written or downloaded, it shares the store of the source grid, and has lists of slices
 * and weights.  Chunks are computed directly from these lists.
 */
typedef struct cl_grid {
    ost_grid base;
    cl_store *store;       /* counted in store->holders */
    /* owned; arguments for resampling the voxels of the store; NULL if the store contains the grid's own voxels */
    cl_mem cubic, sources;
    /* true if ost_cubic_linear makes the voxels from the store; false if ost_cubic_gather does */
    bool linear;
    cl_mem seen, owner; /* arguments of the kernels that scatter samples; NULL before the first batch */
    bool lost;
} cl_grid;

/* a copy of a bone's voxels in host memory (mirror.h) */
typedef struct cl_mirror cl_mirror;

/*
 * A bone consists of a pool of slots on the device and a table of chunks on the host.
 *
 *   slot[chunk]    slot of the chunk, or OST_CL_NONE if the chunk has no memory
 *   active[chunk]  number of active voxels of the chunk; > 0 iff the chunk has a slot
 *   free[]         list of the slots below `used` that belong to no chunk; they contain zeros
 *
 * The slots from `used` to capacity - 1 were never assigned and contain zeros.
 */
typedef struct cl_bone {
    ost_bone base;
    ost_dims chunk_dims;
    size_t chunks;
    size_t chunk_voxels; /* n^3 */
    uint32_t *slot, *active; /* owned */
    uint32_t *free;          /* owned; `capacity` elements */
    size_t free_count, used, capacity;
    cl_mem shape; /* buffer with one ost_cl_bone */
    cl_mem density, words;
    size_t density_bytes_reserved; /* capacity of the `density` buffer in bytes */
    cl_mem slots;     /* slot[] on the device */
    bool slots_outdated; /* true if slot[] has changed since it was last copied to the device */
    cl_mirror *mirror; /* owned; NULL before the first call of bone_sample and after an upload */
    bool lost;
} cl_bone;

/* One uint8 per voxel. */
typedef struct cl_tool {
    ost_tool base;
    cl_mem classes;
    size_t reserved; /* capacity of the `classes` buffer in bytes */
    cl_mem cells;  /* classes with reach (kernels/shared.h) */
    /* windows of the tool (kernels/shared.h); NULL with the kernel set for GPUs */
    cl_mem windows;
    bool touches;   /* true if the tool may have non-cutting voxels (class 2) */
    bool made;     /* true if cells and windows have been computed */
} cl_tool;

/*
 * Returns OST_OK if `lost` is false. Returns OST_ERR_UNAVAILABLE if `lost` is true, that is, if an earlier failure has
 * left the object in an unknown state.
 */
ost_status ost_cl_alive(const ost_backend *backend, bool lost, const char *what, ost_error *err);

/* grid.c */
ost_status ost_cl_grid_create(ost_backend *backend, const ost_geometry *geometry, ost_grid **out, ost_error *err);
/* Creates a grid without initialising its voxels. If `store` is not NULL, the grid shares this store and becomes one of
   the store's holders. */
ost_status ost_cl_grid_create_raw(ost_backend *backend, const ost_geometry *geometry, cl_store *store, ost_grid **out,
                                  ost_error *err);
/* Ensures that the grid shares its store with no other grid, and that the store contains all voxels of the grid. */
ost_status ost_cl_grid_own(cl_grid *grid, ost_error *err);
/* Launches ost_cubic_gather or ost_cubic_linear, which resamples the voxels in the buffer `from` and writes the results
   to the buffer `to`. */
ost_status ost_cl_resample(cl_backend *backend, ost_dims dims, bool linear, cl_mem cubic, cl_mem sources, cl_mem from,
                           cl_mem to, ost_error *err);
void ost_cl_grid_free(ost_grid *grid);
ost_status ost_cl_grid_upload(ost_grid *grid, int32_t z0, int32_t count, const int16_t *voxels, ost_error *err);
ost_status ost_cl_grid_download(const ost_grid *grid, int32_t z0, int32_t count, int16_t *voxels, ost_error *err);

/* import.c */
ost_status ost_cl_ct_to_rect(ost_grid *rect, const ost_sample *samples, size_t count, int64_t first_line,
                             ost_duplicates duplicates, ost_scatter_report *report, ost_error *err);
ost_status ost_cl_rect_to_cubic(const ost_grid *rect, const ost_geometry *geometry, ost_resample rule, ost_grid **out,
                                ost_error *err);

/* bone.c */
ost_status ost_cl_cubic_to_chunks(const ost_grid *cubic, int chunk_size, int32_t threshold, ost_bone **out,
                                  ost_error *err);
ost_status ost_cl_bone_create(ost_backend *backend, const ost_geometry *geometry, int chunk_size, int32_t threshold,
                              ost_bone **out, ost_error *err);
void ost_cl_bone_free(ost_bone *bone);
ost_status ost_cl_bone_stats(const ost_bone *bone, ost_bone_info *info, ost_error *err);
ost_status ost_cl_bone_upload(ost_bone *bone, int32_t z0, int32_t count, const int16_t *voxels, ost_error *err);
ost_status ost_cl_bone_download(const ost_bone *bone, int32_t z0, int32_t count, int16_t *voxels, ost_error *err);
ost_status ost_cl_bone_occupancy(const ost_bone *bone, size_t count, const int32_t *chunks, uint32_t *words,
                                 ost_error *err);
ost_status ost_cl_bone_leaves(const ost_bone *bone, ost_digest *leaves, ost_error *err);
/* Puts the slot of a chunk back into the pool. active[chunk] must be 0, and the slot must contain only zeros. */
void ost_cl_bone_release(cl_bone *bone, size_t chunk);

/* sample.c */
ost_status ost_cl_bone_sample(const ost_bone *bone, size_t count, const int32_t *const at[3], int16_t *densities,
                              ost_error *err);

/* voxelize.c, tool.c */
ost_status ost_cl_voxelize(ost_backend *backend, const ost_snapped_mesh *cutting, const ost_snapped_mesh *noncutting,
                           ost_fill_rule rule, ost_voxelize_report *report, ost_tool **out, ost_error *err);
/* Voxelizes tile by tile, for CPUs. Computes the same results as ost_cl_voxelize. */
ost_status ost_cl_voxelize_tiles(ost_backend *backend, const ost_snapped_mesh *cutting,
                                 const ost_snapped_mesh *noncutting, ost_fill_rule rule, ost_voxelize_report *report,
                                 ost_tool **out, ost_error *err);
/* Creates a tool whose voxels are not initialised. */
ost_status ost_cl_tool_create(ost_backend *backend, const ost_tool_geometry *geometry, cl_tool **out, ost_error *err);
ost_status ost_cl_tool_upload(ost_backend *backend, const ost_tool_volume *volume, ost_tool **out, ost_error *err);
ost_status ost_cl_tool_download(const ost_tool *tool, ost_tool_volume *volume, ost_error *err);
void ost_cl_tool_free(ost_tool *tool);
/* Launches the kernels that compute the cells and windows of the tool, unless the tool already has them. */
ost_status ost_cl_tool_prepare(cl_tool *tool, ost_error *err);
/*
 * Ends the work that ost_cl_tool_prepare has launched. Must be called after the host has waited for the queue. If
 * `done` is true, the work has succeeded, and tool->made becomes true. If `done` and tool->made are both false, the
 * cells and windows may be incomplete and are released.
 */
void ost_cl_tool_finish(cl_tool *tool, bool done);

/* remove.c */
ost_status ost_cl_remove(ost_bone *bone, const ost_tool *tool, const ost_removal_event *event,
                         ost_removal_report *report, ost_error *err);
ost_status ost_cl_collide(const ost_bone *bone, const ost_tool *tool, const ost_removal_event *event,
                          ost_removal_report *report, ost_error *err);
void ost_cl_event_free(cl_backend *backend);

#endif
