/* SPDX-License-Identifier: Apache-2.0 */
/* Grids, bones and tools on a device, and the slots of the function table that work on them. */
#ifndef OST_CL_OBJECTS_H
#define OST_CL_OBJECTS_H

#include "cl/cl.h"

/* Voxels that several grids may share. They are not written while they are shared. */
typedef struct cl_store {
    cl_mem voxels;
    size_t reserved; /* size of voxels in bytes */
    int holders;
} cl_store;

/*
 * Dense int16 grid.  A grid that was resampled along z alone repeats and omits
 * slices of another grid, or consists of weighted means of two of them.  Until
 * it is written or downloaded it shares that grid's store and has lists of
 * slices and weights.  Chunks are made directly from these lists.
 */
typedef struct cl_grid {
    ost_grid base;
    cl_store *store;       /* counted in store->holders */
    cl_mem cubic, sources; /* arguments of the kernel that makes the grid's own voxels; NULL: store has them */
    bool linear;           /* true: that kernel is ost_cubic_linear; false: ost_cubic_gather */
    cl_mem seen, owner; /* buffers of the scatter (kernels/shared.h); NULL before the first */
    bool lost;
} cl_grid;

/*
 * A pool of slots on the device, with the table of chunks on the host.
 *
 *   slot[chunk]    slot of the chunk, or OST_CL_NONE if the chunk has no memory
 *   active[chunk]  number of its active voxels; > 0 iff it has a slot
 *   free[]         slots < used that belong to no chunk; they contain zeros
 *
 * The slots from used up to capacity contain zeros too; they were never assigned.
 */
typedef struct cl_bone {
    ost_bone base;
    ost_dims chunk_dims;
    size_t chunks;
    size_t chunk_voxels; /* n^3 */
    uint32_t *slot, *active; /* owned */
    uint32_t *free;          /* owned; has capacity elements */
    size_t free_count, used, capacity;
    cl_mem shape; /* buffer with one ost_cl_bone */
    cl_mem density, words;
    size_t density_bytes_reserved; /* size of density in bytes */
    cl_mem slots;     /* slot[] on the device */
    bool slots_outdated; /* true if slot[] has changed since slots was written */
    bool lost;
} cl_bone;

/* One uint8 per voxel. */
typedef struct cl_tool {
    ost_tool base;
    cl_mem classes;
    size_t reserved; /* size of classes in bytes */
    cl_mem cells;  /* classes with reach (kernels/shared.h) */
    cl_mem windows; /* windows of the classes (kernels/shared.h) for the kernel set for CPUs, else NULL */
    bool touches;   /* true if a voxel may have class 2 */
    bool made;     /* true once the launches that make cells and windows have completed */
} cl_tool;

/* Returns OST_ERR_UNAVAILABLE if an earlier failure left the object in an unknown state. */
ost_status ost_cl_alive(const ost_backend *backend, bool lost, const char *what, ost_error *err);

/* grid.c */
ost_status ost_cl_grid_create(ost_backend *backend, const ost_geometry *geometry, ost_grid **out, ost_error *err);
/* The same without initialising the voxels. If store is not NULL the grid shares it and becomes one of its holders. */
ost_status ost_cl_grid_create_raw(ost_backend *backend, const ost_geometry *geometry, cl_store *store, ost_grid **out,
                                  ost_error *err);
/* Gives the grid a store of its own that has all its voxels, unless it has one already. */
ost_status ost_cl_grid_own(cl_grid *grid, ost_error *err);
/* Launches ost_cubic_gather or ost_cubic_linear, which resamples the voxels of from to to. */
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
/* Returns the chunk's slot to the pool. active[chunk] must be 0, and the slot contains zeros. */
void ost_cl_bone_release(cl_bone *bone, size_t chunk);

/* voxelize.c, tool.c */
ost_status ost_cl_voxelize(ost_backend *backend, const ost_snapped_mesh *cutting, const ost_snapped_mesh *noncutting,
                           ost_fill_rule rule, ost_voxelize_report *report, ost_tool **out, ost_error *err);
/* The same by tiles of rows, for CPUs. */
ost_status ost_cl_voxelize_tiles(ost_backend *backend, const ost_snapped_mesh *cutting,
                                 const ost_snapped_mesh *noncutting, ost_fill_rule rule, ost_voxelize_report *report,
                                 ost_tool **out, ost_error *err);
/* Creates a tool without initialising its classes. */
ost_status ost_cl_tool_create(ost_backend *backend, const ost_tool_geometry *geometry, cl_tool **out, ost_error *err);
ost_status ost_cl_tool_upload(ost_backend *backend, const ost_tool_volume *volume, ost_tool **out, ost_error *err);
ost_status ost_cl_tool_download(const ost_tool *tool, ost_tool_volume *volume, ost_error *err);
void ost_cl_tool_free(ost_tool *tool);
/* Launches the kernels that make the tool's cells and windows, unless they exist. */
ost_status ost_cl_tool_prepare(cl_tool *tool, ost_error *err);
/* Called after waiting for the queue; done is true if the launched work succeeded. If it did not, and no earlier
   call found the cells and windows finished, they are released. */
void ost_cl_tool_finish(cl_tool *tool, bool done);

/* remove.c */
ost_status ost_cl_remove(ost_bone *bone, const ost_tool *tool, const ost_removal_event *event,
                         ost_removal_report *report, ost_error *err);
ost_status ost_cl_collide(const ost_bone *bone, const ost_tool *tool, const ost_removal_event *event,
                          ost_removal_report *report, ost_error *err);
void ost_cl_event_free(cl_backend *backend);

#endif
