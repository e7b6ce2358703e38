/* SPDX-License-Identifier: Apache-2.0 */
/* Grids, bones and tools on a device, and the slots of the table that work on them. */
#ifndef OST_CL_OBJECTS_H
#define OST_CL_OBJECTS_H

#include "cl/cl.h"

/* Voxels that several grids may hold; then nobody writes to them. */
typedef struct cl_store {
    cl_mem voxels;
    size_t room; /* its bytes */
    int holders;
} cl_store;

/*
 * Dense int16 grid.  One that was resampled along z alone repeats and leaves
 * out slices of another, or consists of weighted means of two of them.  It shares
 * that grid's store and has lists of slices and weights, until it is written to
 * or downloaded.  Chunks are made from the lists.
 */
typedef struct cl_grid {
    ost_grid base;
    cl_store *store;       /* held */
    cl_mem cubic, sources; /* of ost_cubic_gather or ost_cubic_linear, which makes it whole; NULL: the store is as it is */
    bool linear;           /* which of the two */
    cl_mem seen, owner; /* of the scatter (kernels/shared.h); NULL before the first */
    bool lost;
} cl_grid;

/*
 * A pool of slots on the device, and here which chunk has which.
 *
 *   slot[chunk]    its slot, or OST_CL_NONE when the chunk holds no memory
 *   active[chunk]  its active voxels; > 0 iff it has a slot
 *   free[]         slots < used that no chunk has; they hold zeros
 *
 * Slots from used up to capacity hold zeros too, and were never given out.
 */
typedef struct cl_bone {
    ost_bone base;
    ost_dims chunk_dims;
    size_t chunks;
    size_t chunk_voxels; /* n^3 */
    uint32_t *slot, *active; /* owned */
    uint32_t *free;          /* owned; room for capacity */
    size_t free_count, used, capacity;
    cl_mem shape; /* ost_cl_bone */
    cl_mem density, words;
    size_t density_room; /* bytes of density */
    bool words_shared; /* words is a buffer of OpenGL's (share.c) */
    cl_mem slots;     /* slot[] there */
    bool slots_stale; /* whether slot[] has changed since */
    bool lost;
} cl_bone;

/* One uint8 a voxel. */
typedef struct cl_tool {
    ost_tool base;
    cl_mem classes;
    size_t room;   /* its bytes */
    cl_mem cells;  /* classes and reach */
    cl_mem windows; /* classes as windows; for backends that remove by blocks, else NULL */
    bool touches;   /* whether a voxel may have class 2 */
    bool made;     /* whether the device has been waited for since the cells were asked for */
} cl_tool;

/* OST_ERR_UNAVAILABLE when an earlier failure left the object in an unknown state. */
ost_status ost_cl_alive(const ost_backend *backend, bool lost, const char *what, ost_error *err);

/* grid.c */
ost_status ost_cl_grid_create(ost_backend *backend, const ost_geometry *geometry, ost_grid **out, ost_error *err);
/* The same with whatever the memory holds; with a store that somebody has, held by it too, if one is given. */
ost_status ost_cl_grid_create_raw(ost_backend *backend, const ost_geometry *geometry, cl_store *store, ost_grid **out, ost_error *err);
/* Makes it whole, in a store that it alone holds. */
ost_status ost_cl_grid_own(cl_grid *grid, ost_error *err);
/* Launches ost_cubic_gather or ost_cubic_linear from one store to another. */
ost_status ost_cl_resample(cl_backend *backend, ost_dims dims, bool linear, cl_mem cubic, cl_mem sources, cl_mem from, cl_mem to, ost_error *err);
void ost_cl_grid_free(ost_grid *grid);
ost_status ost_cl_grid_upload(ost_grid *grid, int32_t z0, int32_t count, const int16_t *voxels, ost_error *err);
ost_status ost_cl_grid_download(const ost_grid *grid, int32_t z0, int32_t count, int16_t *voxels, ost_error *err);

/* import.c */
ost_status ost_cl_ct_to_rect(ost_grid *rect, const ost_sample *samples, size_t count, int64_t first_line, ost_duplicates duplicates,
                             ost_scatter_report *report, ost_error *err);
ost_status ost_cl_rect_to_cubic(const ost_grid *rect, const ost_geometry *geometry, ost_resample rule, ost_grid **out, ost_error *err);

/* bone.c */
ost_status ost_cl_cubic_to_chunks(const ost_grid *cubic, int chunk_size, int32_t threshold, ost_bone **out, ost_error *err);
ost_status ost_cl_bone_create(ost_backend *backend, const ost_geometry *geometry, int chunk_size, int32_t threshold, ost_bone **out,
                              ost_error *err);
void ost_cl_bone_free(ost_bone *bone);
ost_status ost_cl_bone_stats(const ost_bone *bone, ost_bone_info *info, ost_error *err);
ost_status ost_cl_bone_upload(ost_bone *bone, int32_t z0, int32_t count, const int16_t *voxels, ost_error *err);
ost_status ost_cl_bone_download(const ost_bone *bone, int32_t z0, int32_t count, int16_t *voxels, ost_error *err);
ost_status ost_cl_bone_occupancy(const ost_bone *bone, size_t count, const int32_t *chunks, uint32_t *words, ost_error *err);
ost_status ost_cl_bone_leaves(const ost_bone *bone, ost_digest *leaves, ost_error *err);
/* Its slot back into the pool; active[chunk] is 0 and the slot holds zeros. */
void ost_cl_bone_release(cl_bone *bone, size_t chunk);

/* voxelize.c, tool.c */
ost_status ost_cl_voxelize(ost_backend *backend, const ost_snapped_mesh *cutting, const ost_snapped_mesh *noncutting,
                           ost_fill_rule rule, ost_voxelize_report *report, ost_tool **out, ost_error *err);
/* By tiles of rows, for CPUs. */
ost_status ost_cl_voxelize_tiles(ost_backend *backend, const ost_snapped_mesh *cutting, const ost_snapped_mesh *noncutting,
                                 ost_fill_rule rule, ost_voxelize_report *report, ost_tool **out, ost_error *err);
/* With whatever the memory holds. */
ost_status ost_cl_tool_create(ost_backend *backend, const ost_tool_geometry *geometry, cl_tool **out, ost_error *err);
ost_status ost_cl_tool_upload(ost_backend *backend, const ost_tool_volume *volume, ost_tool **out, ost_error *err);
ost_status ost_cl_tool_download(const ost_tool *tool, ost_tool_volume *volume, ost_error *err);
void ost_cl_tool_free(ost_tool *tool);
/* Asks for its cells unless they are there. */
ost_status ost_cl_tool_prepare(cl_tool *tool, ost_error *err);
/* The queue was waited for, and what was asked for has been done, or has not: then cells that nobody has seen are dropped. */
void ost_cl_tool_settle(cl_tool *tool, bool done);

/* remove.c */
ost_status ost_cl_remove(ost_bone *bone, const ost_tool *tool, const ost_event *event, ost_report *report, ost_error *err);
ost_status ost_cl_collide(const ost_bone *bone, const ost_tool *tool, const ost_event *event, ost_report *report, ost_error *err);
void ost_cl_event_free(cl_backend *backend);

#endif
