/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The one function table.  A backend is a const instance of ost_backend_ops,
 * listed in src/core/backend.c; everything above the core reaches voxels
 * through include/osteon/backend.h, whose functions check their arguments and
 * then call through here.
 *
 * Rules for implementers
 *   - No slot is NULL but the last two; what a backend cannot do returns OST_ERR_UNAVAILABLE.
    (One that can never be opened here has those of the choice only.)
 *   - Objects embed the structs below as their first member; the caller of
 *     the table has filled nothing in them: the backend does.
 *   - Arguments were checked: assert, do not check again.
 *   - One thread at a time per backend.
 *   - A slot that fails has changed nothing, or the object is lost: all its
 *     slots but free and geometry return OST_ERR_UNAVAILABLE from then on.
 *   - Results are bit-exact as docs/arithmetic.md says, per slot below.
 */
#ifndef OST_CORE_BACKEND_H
#define OST_CORE_BACKEND_H

#include <osteon/backend.h>

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

    /* Whether open can work here, cheaply; fills reason (never NULL, size bytes) when not. */
    bool (*available)(char *reason, size_t size);
    /* Shows every device with its reason; a backend without devices to choose from shows none. Slow: devices are tried. */
    ost_status (*devices)(ost_device_visit *visit, void *user, ost_error *err);
    /* options is the text after "name:", or "". Sets *out; out->ops need not be set. */
    ost_status (*open)(const char *options, ost_backend **out, ost_error *err);
    void (*close)(ost_backend *backend);
    ost_backend_settings (*settings)(const ost_backend *backend);
    ost_status (*finish)(ost_backend *backend, ost_error *err);
    /* Visits the paths that decide voxels, with their counts (paths.h). */
    void (*paths)(const ost_backend *backend, ost_path_visit *visit, void *user);

    /* Zero-filled grid; slices up and down. No arithmetic. */
    ost_status (*grid_create)(ost_backend *backend, const ost_geometry *geometry, ost_grid **out, ost_error *err);
    void (*grid_free)(ost_grid *grid);
    ost_status (*grid_upload)(ost_grid *grid, int32_t z0, int32_t count, const int16_t *voxels, ost_error *err);
    ost_status (*grid_download)(const ost_grid *grid, int32_t z0, int32_t count, int16_t *voxels, ost_error *err);

    /* AR-CT-4..6, bit-exact including the report. */
    ost_status (*ct_to_rect)(ost_grid *rect, const ost_sample *samples, size_t count, int64_t first_line,
                             ost_duplicates duplicates, ost_scatter_report *report, ost_error *err);
    /* AR-CUB, bit-exact. geometry is the cubic grid's, already computed. */
    ost_status (*rect_to_cubic)(const ost_grid *rect, const ost_geometry *geometry, ost_resample rule, ost_grid **out, ost_error *err);
    /* AR-CHK, bit-exact. */
    ost_status (*cubic_to_chunks)(const ost_grid *cubic, int chunk_size, int32_t threshold, ost_bone **out, ost_error *err);

    ost_status (*bone_create)(ost_backend *backend, const ost_geometry *geometry, int chunk_size, int32_t threshold, ost_bone **out,
                              ost_error *err);
    void (*bone_free)(ost_bone *bone);
    /* Fills active_chunks, active_voxels, chunk_bytes, resident_bytes; the rest is filled by the caller. */
    ost_status (*bone_stats)(const ost_bone *bone, ost_bone_info *info, ost_error *err);
    ost_status (*bone_upload)(ost_bone *bone, int32_t z0, int32_t count, const int16_t *voxels, ost_error *err);
    ost_status (*bone_download)(const ost_bone *bone, int32_t z0, int32_t count, int16_t *voxels, ost_error *err);
    /* Densities of single voxels, 0 beyond the grid. For ticks: asks for no memory. UNAVAILABLE where voxels are far from the host. */
    ost_status (*bone_sample)(const ost_bone *bone, size_t count, const int32_t *const at[3], int16_t *densities, ost_error *err);
    /*
     * Occupancy of whole chunks, n^3/32 words each, as chunk_grid.h has them. For ticks: asks for no memory and waits for no
     * other thread; where voxels are on a device it waits for that. UNAVAILABLE where they cannot be had but slice by slice.
     */
    ost_status (*bone_occupancy)(const ost_bone *bone, size_t count, const int32_t *chunks, uint32_t *words, ost_error *err);
    /* AR-DIG-2 leaves of 32^3, whatever the chunk size; leaves has room for all. */
    ost_status (*bone_leaves)(const ost_bone *bone, ost_digest *leaves, ost_error *err);

    /* AR-VOX, bit-exact including the report. noncutting may be NULL; same grid as cutting. */
    ost_status (*voxelize)(ost_backend *backend, const ost_snapped_mesh *cutting, const ost_snapped_mesh *noncutting,
                           ost_fill_rule rule, ost_voxelize_report *report, ost_tool **out, ost_error *err);
    ost_status (*tool_upload)(ost_backend *backend, const ost_tool_volume *volume, ost_tool **out, ost_error *err);
    /* volume is initialised; fills its voxels. */
    ost_status (*tool_download)(const ost_tool *tool, ost_tool_volume *volume, ost_error *err);
    void (*tool_free)(ost_tool *tool);

    /* AR-REM, bit-exact including the report (cleared by the caller). */
    ost_status (*remove)(ost_bone *bone, const ost_tool *tool, const ost_event *event, ost_report *report, ost_error *err);
    ost_status (*collide)(const ost_bone *bone, const ost_tool *tool, const ost_event *event, ost_report *report, ost_error *err);

    /*
     * The steps before the voxels, for a backend that makes them itself: validation compares them, and nothing else calls them.
     * Both slots are NULL where what src/core made is taken as it is; OST_ERR_UNAVAILABLE says the same of an opened backend.
     */
    /* AR-MESH-3, AR-MESH-4. out is freed by ost_snapped_mesh_free. */
    ost_status (*snap)(ost_backend *backend, const ost_mesh *mesh, const ost_tool_geometry *grid, ost_snapped_mesh *out, ost_error *err);
    /* AR-SWEEP-1 to 4, AR-MAP-1 to 3. from is NULL where the event begins anew; poses and maps have room for OST_SWEEP_MAX; a count of 0 refuses. */
    ost_status (*steps)(ost_backend *backend, const ost_geometry *bone, const ost_tool_geometry *tool, const ost_pose *from, const ost_pose *to,
                        int *count, ost_pose *poses, ost_map *maps, ost_error *err);
};

extern const ost_backend_ops ost_backend_ref;
extern const ost_backend_ops ost_backend_cpu;
extern const ost_backend_ops ost_backend_cl;
extern const ost_backend_ops ost_backend_plugin;

/* The slot devices of a backend that has none to choose from. */
ost_status ost_no_devices(ost_device_visit *visit, void *user, ost_error *err);
/* The slot bone_sample of a backend whose voxels are far from the host. */
ost_status ost_no_sample(const ost_bone *bone, size_t count, const int32_t *const at[3], int16_t *densities, ost_error *err);
/* The slot bone_occupancy of a backend that gives slices alone. */
ost_status ost_no_occupancy(const ost_bone *bone, size_t count, const int32_t *chunks, uint32_t *words, ost_error *err);

#endif
