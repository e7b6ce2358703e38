/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The function table of backends.  A backend is a const instance of
 * ost_backend_ops, listed in src/core/backend.c.  Everything above the core
 * accesses voxels through include/osteon/backend.h, whose functions check their
 * arguments and then call through this table.
 *
 * Rules for implementers
 *   - Only the last three slots may be NULL. If the backend does not support the operation of any
 *     other slot, the slot returns OST_ERR_UNAVAILABLE. (A backend that can never be opened in this
 *     build sets only the slots from the first one to `open`.)
 *   - Objects embed the structs below as their first member; the backend fills them,
 *     except ost_backend.ops, which ost_backend_open sets.
 *   - Arguments have been checked; a slot may assert, but does not check again.
 *   - Only one thread at a time calls the slots of a backend.
 *   - If a slot fails, the object is either unchanged or lost.  All calls with a lost object,
 *     except `free` and `geometry`, return OST_ERR_UNAVAILABLE.
 *   - If a slot's comment says "bit-exact", the slot's results are exactly those that
 *     docs/spec/arithmetic.md defines.
 */
#ifndef OST_CORE_BACKEND_H
#define OST_CORE_BACKEND_H

#include <osteon/backend.h>

#include "core/face_mesh.h"
#include "core/paths.h"

typedef struct ost_backend_ops ost_backend_ops;

struct ost_backend {
    const ost_backend_ops *ops;
};

struct ost_grid {
    ost_backend *backend;
    ost_geometry geometry;
};

struct ost_bone {
    ost_backend *backend;
    ost_geometry geometry;
    int chunk_size;
    int32_t threshold;
};

struct ost_tool {
    ost_backend *backend;
    ost_tool_geometry geometry;
};

struct ost_backend_ops {
    const char *name;
    const char *description;

    /*
     * Performs a quick check. Returns true if `open` can succeed on this machine; otherwise writes the reason to
     * `reason`, which has `size` bytes and is never NULL.
     */
    bool (*available)(char *reason, size_t size);
    /*
     * Calls `visit` for every device; for an unusable device, `visit` receives the reason. If there are no devices
     * to choose from, `visit` is not called. The slot is slow, because it tests the devices.
     */
    ost_status (*devices)(ost_device_visit *visit, void *user, ost_error *err);
    /* Opens a backend. `options` is the text after "name:", or "". Sets *out but not (*out)->ops, which the caller
       sets. */
    ost_status (*open)(const char *options, ost_backend **out, ost_error *err);
    void (*close)(ost_backend *backend);
    ost_backend_settings (*settings)(const ost_backend *backend);
    ost_status (*finish)(ost_backend *backend, ost_error *err);
    /*
     * Calls `visit` for each code path of the backend that computes voxels, with the number of times it was entered
     * (paths.h).
     */
    void (*paths)(const ost_backend *backend, ost_path_visit *visit, void *user);

    /*
     * grid_create creates a zero-filled grid, and grid_free frees a grid. grid_upload copies slices to a grid, and
     * grid_download copies slices from a grid.
     */
    ost_status (*grid_create)(ost_backend *backend, const ost_geometry *geometry, ost_grid **out, ost_error *err);
    void (*grid_free)(ost_grid *grid);
    ost_status (*grid_upload)(ost_grid *grid, int32_t z0, int32_t count, const int16_t *voxels, ost_error *err);
    ost_status (*grid_download)(const ost_grid *grid, int32_t z0, int32_t count, int16_t *voxels, ost_error *err);

    /* Scatters samples into a rect grid (AR-CT-4 to 6). The grid and the report are bit-identical on all backends. */
    ost_status (*ct_to_rect)(ost_grid *rect, const ost_sample *samples, size_t count, int64_t first_line,
                             ost_duplicates duplicates, ost_scatter_report *report, ost_error *err);
    /*
     * Creates a cubic grid with the given geometry, and resamples rect to it (AR-CUB). The grid is bit-identical on all
     * backends.
     */
    ost_status (*rect_to_cubic)(const ost_grid *rect, const ost_geometry *geometry, ost_resample rule, ost_grid **out,
                                ost_error *err);
    /* Creates a bone from a cubic grid (AR-CHK). The bone is bit-identical on all backends. */
    ost_status (*cubic_to_chunks)(const ost_grid *cubic, int chunk_size, int32_t threshold, ost_bone **out,
                                  ost_error *err);

    ost_status (*bone_create)(ost_backend *backend, const ost_geometry *geometry, int chunk_size, int32_t threshold,
                              ost_bone **out, ost_error *err);
    void (*bone_free)(ost_bone *bone);
    /*
     * Fills the fields active_chunks, active_voxels, chunk_bytes and resident_bytes of *info; the caller fills the
     * other fields.
     */
    ost_status (*bone_stats)(const ost_bone *bone, ost_bone_info *info, ost_error *err);
    ost_status (*bone_upload)(ost_bone *bone, int32_t z0, int32_t count, const int16_t *voxels, ost_error *err);
    ost_status (*bone_download)(const ost_bone *bone, int32_t z0, int32_t count, int16_t *voxels, ost_error *err);
    /*
     * Reads the densities of single voxels. The density is 0 outside the grid. The slot is called in ticks and
     * therefore allocates no memory, except in the first call after the bone was made or uploaded. Returns
     * OST_ERR_UNAVAILABLE if the backend can read only slices.
     */
    ost_status (*bone_sample)(const ost_bone *bone, size_t count, const int32_t *const at[3], int16_t *densities,
                              ost_error *err);
    /*
     * Reads the occupancy of complete chunks, n^3/32 words per chunk, in the layout of chunk_grid.h. The slot is called
     * in ticks; therefore it allocates no memory and waits for no other thread. If the voxels are on a device, the slot
     * waits for the device. Returns OST_ERR_UNAVAILABLE if the backend can read only slices.
     */
    ost_status (*bone_occupancy)(const ost_bone *bone, size_t count, const int32_t *chunks, uint32_t *words,
                                 ost_error *err);
    /*
     * Computes the digests of the leaves of 32^3 voxels (AR-DIG-2), for any chunk size. The array `leaves` has space
     * for the digests of all leaves.
     */
    ost_status (*bone_leaves)(const ost_bone *bone, ost_digest *leaves, ost_error *err);

    /*
     * Voxelizes one or two meshes (AR-VOX). The result is bit-exact, including the report. The mesh `noncutting` is
     * NULL or has the same grid as the mesh `cutting`.
     */
    ost_status (*voxelize)(ost_backend *backend, const ost_snapped_mesh *cutting, const ost_snapped_mesh *noncutting,
                           ost_fill_rule rule, ost_voxelize_report *report, ost_tool **out, ost_error *err);
    ost_status (*tool_upload)(ost_backend *backend, const ost_tool_volume *volume, ost_tool **out, ost_error *err);
    /* Writes the voxels of a tool to *volume. The caller has initialised *volume with the tool's geometry. */
    ost_status (*tool_download)(const ost_tool *tool, ost_tool_volume *volume, ost_error *err);
    void (*tool_free)(ost_tool *tool);

    /*
     * Removes the voxels that an event hits (AR-REM). The caller clears the report before the call. The voxels and the
     * report are bit-exact.
     */
    ost_status (*remove)(ost_bone *bone, const ost_tool *tool, const ost_removal_event *event,
                         ost_removal_report *report, ost_error *err);
    ost_status (*collide)(const ost_bone *bone, const ost_tool *tool, const ost_removal_event *event,
                          ost_removal_report *report, ost_error *err);

    /*
     * The slots `snap` and `steps` compute the steps that precede the work on voxels. They exist for backends that do
     * not use the functions of src/core for these steps. Only validation calls the two slots, to compare the results.
     * In a backend that uses the functions of src/core, both slots are NULL or return OST_ERR_UNAVAILABLE.
     */
    /*
     * Snaps a mesh to the lattice of a tool grid (AR-MESH-3, AR-MESH-4). The caller frees *out with
     * ost_snapped_mesh_free.
     */
    ost_status (*snap)(ost_backend *backend, const ost_mesh *mesh, const ost_tool_geometry *grid, ost_snapped_mesh *out,
                       ost_error *err);
    /*
     * Computes the poses and maps of an event (AR-SWEEP-1 to 4, AR-MAP-1 to 3). The pose `from` is NULL for an event
     * without a sweep from a previous pose. The arrays `poses` and `maps` have space for OST_SWEEP_MAX elements. *count
     * is 0 if the event is rejected.
     */
    ost_status (*steps)(ost_backend *backend, const ost_geometry *bone, const ost_tool_geometry *tool,
                        const ost_pose *from, const ost_pose *to, int *count, ost_pose *poses, ost_map *maps,
                        ost_error *err);

    /*
     * Meshes chunks whose occupancy is in host memory (face_mesh.h). The caller has set mesh->count and cleared
     * mesh->stage_ns; the slot fills first[1 .. count], the vertices and, if mesh->timed, the times. The result is
     * bit-identical on all backends. The slot is NULL if the backend cannot make face meshes.
     */
    ost_status (*face_mesh)(ost_backend *backend, const ost_face_cluster *clusters, size_t count, ost_face_mesh *mesh,
                            ost_error *err);
};

extern const ost_backend_ops ost_backend_ref;
extern const ost_backend_ops ost_backend_cpu;
extern const ost_backend_ops ost_backend_cl;
extern const ost_backend_ops ost_backend_plugin;

/* Implements the `devices` slot for a backend without devices to choose from. */
ost_status ost_no_devices(ost_device_visit *visit, void *user, ost_error *err);
/* Implements the `bone_sample` slot for a backend that can read only slices. */
ost_status ost_no_sample(const ost_bone *bone, size_t count, const int32_t *const at[3], int16_t *densities,
                         ost_error *err);
/* Implements the `bone_occupancy` slot for a backend that can read only slices. */
ost_status ost_no_occupancy(const ost_bone *bone, size_t count, const int32_t *chunks, uint32_t *words, ost_error *err);

#endif
