/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Backends store voxels and operate on them.
 *
 * A string selects a backend: "name" or "name:key=value,key=value".
 *
 *   cpu                              the default; selects the instruction set and the number of threads
 *                                    automatically, unless options set them: "cpu:isa=avx2,threads=2"
 *   ref                              the scalar reference, the executable form of docs/spec/arithmetic.md
 *   cl:platform=Portable,device=0    an OpenCL device
 *   plugin:FILE.so                   an implementation in a shared library (plugin.h)
 *
 * All backends produce bit-identical grids.
 *
 *   samples --ct_to_rect--> grid --rect_to_cubic--> grid --cubic_to_chunks--> bone
 *   snapped mesh --voxelize--> tool                      event --remove--> bone, report
 *
 * Lifetimes: grids, bones and tools are owned by the caller and must be freed before their backend is closed. All
 * objects of a call must belong to one backend; otherwise the call returns OST_ERR_USAGE.
 *
 * Threads: a backend and its objects may be used by one thread at a time; different backends may be used by different
 * threads at the same time. For `cl`, only one thread at a time may call ost_backend_open or ost_backend_devices,
 * because these functions save and restore the process's handler for SIGFPE. After fork(), the child must not call
 * osteon before exec, because the OpenMP runtime's threads do not exist in the child.
 *
 * Errors: these functions check their arguments. If a call fails, no object changes, unless the comment of the function
 * states otherwise. If a device fails while it changes a grid or a bone, however, the state of this object is unknown.
 * The object can then only be freed, and every other call that uses it returns OST_ERR_UNAVAILABLE. The caller can
 * create the object again; ost_world_failover (sim.h) does this for a world, on another backend.
 *
 * Backend errors: a function that creates or uses a grid, a bone or a tool can fail in the backend. It then returns
 * OST_ERR_MEMORY if memory of the host or of the device is exhausted, OST_ERR_UNAVAILABLE if the device or the plugin
 * fails or is lost, and OST_ERR_INTERNAL if the driver of a device rejects a call. A plugin can also return
 * OST_ERR_USAGE and OST_ERR_RANGE. The comments of the functions name all other errors.
 */
#ifndef OSTEON_BACKEND_H
#define OSTEON_BACKEND_H

#include <osteon/event.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct ost_backend ost_backend;
typedef struct ost_grid ost_grid; /* a dense int16 grid in the backend's memory */
typedef struct ost_bone ost_bone; /* a chunk grid in the backend's memory */
typedef struct ost_tool ost_tool; /* a tool grid in the backend's memory */

/* ---------------------------------------------------------------- choice */

typedef struct ost_backend_info {
    const char *name;        /* "ref" */
    const char *description; /* one sentence */
    bool available;
    char reason[256]; /* the reason why the backend is not available, and the package that must be installed */
} ost_backend_info;

/* Returns the number of backends. The backends are numbered from 0 in a fixed order. */
OST_API int ost_backend_count(void);
/*
 * Describes backend number `index`, and tests whether the backend could be opened on this machine. The backend is not
 * opened. Returns OST_ERR_USAGE if index is out of range. The strings are static.
 */
OST_API ost_status ost_backend_describe(int index, ost_backend_info *out, ost_error *err);

/* A device on which a backend can be opened, as listed by `osteon devices`. */
typedef struct ost_device_info {
    const char *spec;     /* string for ost_backend_open: "cl:platform=0,device=1" */
    const char *platform; /* name and version of the OpenCL platform */
    const char *name;     /* name of the device and version of its driver */
    bool available;
    const char *reason; /* the reason why the device is not available; "" if it is available */
    const char *notes;  /* floating-point properties of the device, for reports; they do not affect any voxel */
    const char *facts;  /* lines "CL_DEVICE_VENDOR=..." with the properties that the driver reports; may be "" */
} ost_device_info;

/* Receives one device. The strings are valid until the function returns. */
typedef void ost_device_visit(const ost_device_info *device, void *user);

/*
 * Tests every device of backend number `index`, in a fixed order, and calls visit for each device.  A backend may have
 * no devices. Returns OST_ERR_USAGE if index is out of range or visit is NULL, and OST_ERR_MEMORY if memory is
 * exhausted. A device that cannot be used is no error; its `reason` contains the message.
 */
OST_API ost_status ost_backend_devices(int index, ost_device_visit *visit, void *user, ost_error *err);

/*
 * Opens a backend.  Returns OST_ERR_USAGE for an unknown name, key or value, and OST_ERR_UNAVAILABLE, with the reason
 * in err, if the backend cannot run on this machine. Returns OST_ERR_IO or OST_ERR_INPUT if the file of a plugin cannot
 * be opened or loaded. The other errors are backend errors. The caller closes *out with ost_backend_close.
 */
OST_API ost_status ost_backend_open(const char *spec, ost_backend **out, ost_error *err);
/* Closes a backend. All its grids, bones and tools must have been freed. NULL is allowed. */
OST_API void ost_backend_close(ost_backend *backend);
/* Returns the name of a backend without options, for example "cpu". The string is static. */
OST_API const char *ost_backend_name(const ost_backend *backend);

/* Settings of an open backend, which are determined by its options, the environment and the machine. */
typedef struct ost_backend_settings {
    /* instruction set in use, for example "avx2"; "" if the backend has no choice of instruction sets */
    const char *isa;
    int threads;     /* maximum number of threads, >= 1 */
    /* Indices of the platform and of the device, as in "cl:platform=0,device=1"; -1 if the backend has no devices. */
    int platform, device;
} ost_backend_settings;

/* Returns the settings of an open backend. The strings are valid until the backend is closed. */
OST_API ost_backend_settings ost_backend_settings_get(const ost_backend *backend);

/* ----------------------------------------------------------------- grids */

/* Creates a grid filled with 0. Returns OST_ERR_RANGE if geometry is outside the ranges of AR-GRID. The caller frees
 * *out with ost_grid_free. */
OST_API ost_status ost_grid_create(ost_backend *backend, const ost_geometry *geometry, ost_grid **out, ost_error *err);
/* Frees a grid. NULL is allowed. */
OST_API void ost_grid_free(ost_grid *grid);
/* Returns the geometry of a grid. The pointer is valid until the grid is freed. */
OST_API const ost_geometry *ost_grid_geometry(const ost_grid *grid);
/* Copies dims.x * dims.y * count elements, x fastest, from host memory to slices z0 <= k < z0 + count of a grid.
 * Returns OST_ERR_USAGE if the grid does not contain these slices. */
OST_API ost_status ost_grid_upload(ost_grid *grid, int32_t z0, int32_t count, const int16_t *voxels, ost_error *err);
/* Copies slices from a grid to host memory. The layout and the errors are the same as for ost_grid_upload. */
OST_API ost_status ost_grid_download(const ost_grid *grid, int32_t z0, int32_t count, int16_t *voxels, ost_error *err);

/* ---------------------------------------------------------------- import */

/* One line of a CT in text form (thesis, Alg. 2.2). */
typedef struct ost_sample {
    int64_t x, y, z; /* centre of the voxel in picometres */
    /* Density, which must fit in an int16. Otherwise, ost_ct_to_rect returns OST_ERR_RANGE and scatters no sample. */
    int32_t density;
    uint32_t line;   /* line number in its batch, counted from 0; therefore 32 bits suffice for a file of any length */
} ost_sample;

/* The rule that determines the density of a voxel with several samples (AR-CT-6). */
typedef enum ost_duplicates {
    OST_DUPLICATES_ERROR, /* samples with different densities for one voxel are an error */
    OST_DUPLICATES_FIRST, /* the first density in file order is used */
    OST_DUPLICATES_LAST,
    OST_DUPLICATES_MAX
} ost_duplicates;

/*
 * The results of scattering samples into a grid, summed over all batches. Line numbers are counted from the start of
 * the file; 0 means that there is no such line.
 */
typedef struct ost_scatter_report {
    uint64_t samples;
    uint64_t duplicates;         /* number of samples whose voxel already had a density */
    uint64_t off_lattice;        /* number of samples that are more than 1/8 of a voxel off the lattice */
    /* maximum distance of a sample from the lattice, in millionths of a voxel, rounded down */
    uint64_t worst_offset_ppm;
    int64_t worst_line;          /* line of the first sample with the maximum distance */
    /* Line of the first sample that is more than 3/8 of a voxel off the lattice, or outside the grid. */
    int64_t rejected_line;
    /* line of the first sample whose voxel already has a different density (only with OST_DUPLICATES_ERROR) */
    int64_t conflict_line;
    /* density that the voxel already had, and density of the sample on conflict_line */
    int16_t conflict_had, conflict_has;
} ost_scatter_report;

/*
 * Scatters a batch of samples into a rect grid (AR-CT-4). A sample at p belongs to the voxel with the index (p -
 * origin) / spacing, rounded half to even. Batches must be passed in file order. The counts of each batch are added to
 * *report. The grid records which voxels have a density. If a sample is rejected or contradicts an earlier sample, the
 * function nevertheless returns OST_OK; the report then contains the line of the sample, and the content of the grid is
 * undefined. Returns OST_ERR_RANGE if a density does not fit in an int16, and OST_ERR_USAGE if samples or report is
 * NULL or the rule `duplicates` is unknown.
 */
OST_API ost_status ost_ct_to_rect(ost_grid *rect, const ost_sample *samples, size_t count, int64_t first_line,
                                  ost_duplicates duplicates, ost_scatter_report *report, ost_error *err);

/*
 * The resampling rule (AR-CUB). On each axis, let s be the spacing of the rect grid and c the edge length of a
 * cubic voxel. The centre of cubic voxel i, in units of rect voxels, is t = ((2i + 1) c - s) / (2s). LINEAR
 * interpolates between the eight voxels around t, NEAREST uses the voxel that contains t, and THESIS uses the voxel
 * floor(i c / s) (Alg. 2.5).
 */
typedef enum ost_resample { OST_RESAMPLE_LINEAR, OST_RESAMPLE_NEAREST, OST_RESAMPLE_THESIS } ost_resample;

/* Returns "linear", "nearest" or "thesis"; NULL for any other value. */
OST_API const char *ost_resample_name(ost_resample rule);

/*
 * Resamples the grid `rect` to cubic voxels with edges of length `cubic`. Both grids cover the same physical box. On
 * each axis, let c be the edge length; let n, s and p be the number of voxels, the spacing and the origin of `rect`.
 * The cubic grid then has ceil(n * s / c) voxels, and its origin is p + (c - s) / 2, rounded half to even (AR-CUB-1).
 * Returns OST_ERR_RANGE if `cubic` is not within 0.001 to 100 mm or if the cubic grid is outside the ranges of AR-GRID,
 * and OST_ERR_USAGE if the rule is unknown. The caller frees *out with ost_grid_free.
 */
OST_API ost_status ost_rect_to_cubic(const ost_grid *rect, ost_pm cubic, ost_resample rule, ost_grid **out,
                                     ost_error *err);

/*
 * Creates a bone from a cubic grid (AR-CHK). Voxels whose density is at least threshold are active; all other
 * voxels are stored as 0. Returns OST_ERR_USAGE if the voxels are not cubes or chunk_size is not 16, 32 or 64, and
 * OST_ERR_RANGE if threshold is not within 1 to 32767. The caller frees *out with ost_bone_free.
 */
OST_API ost_status ost_cubic_to_chunks(const ost_grid *cubic, int chunk_size, int32_t threshold, ost_bone **out,
                                       ost_error *err);

/* ----------------------------------------------------------------- bones */

/* The properties of a bone and the counts of its voxels and bytes. */
typedef struct ost_bone_info {
    ost_geometry geometry; /* equal spacing on all axes */
    int chunk_size;
    int32_t threshold;
    ost_dims chunk_dims;
    int64_t chunks;
    /* number of chunks for which memory is allocated, that is, chunks with at least one active voxel */
    int64_t active_chunks;
    int64_t active_voxels;
    int64_t chunk_bytes; /* size in bytes of the densities and the occupancy of all active chunks */
    /* Total memory of the bone in bytes, including tables and unused capacity. The value depends on the backend. */
    int64_t resident_bytes;
} ost_bone_info;

/* Creates a bone without active voxels. The errors are those of ost_grid_create and ost_cubic_to_chunks. The caller
 * frees *out with ost_bone_free. */
OST_API ost_status ost_bone_create(ost_backend *backend, const ost_geometry *geometry, int chunk_size,
                                   int32_t threshold, ost_bone **out, ost_error *err);
/* Frees a bone. NULL is allowed. */
OST_API void ost_bone_free(ost_bone *bone);
/*
 * Writes the properties and counts of a bone to *out. If the bone is on a device, the call blocks until the counts are
 * available. Returns backend errors only.
 */
OST_API ost_status ost_bone_info_get(const ost_bone *bone, ost_bone_info *out, ost_error *err);
/*
 * Copies densities from host memory to slices z0 <= k < z0 + count of a bone.  `voxels` has dims.x * dims.y * count
 * elements, x fastest, without the padding of chunks. Densities below the threshold are stored as 0. Returns
 * OST_ERR_USAGE if the bone does not contain these slices.
 */
OST_API ost_status ost_bone_upload(ost_bone *bone, int32_t z0, int32_t count, const int16_t *voxels, ost_error *err);
/*
 * Copies slices from a bone to host memory. The layout and the errors are the same as for ost_bone_upload. Voxels that
 * are not active are 0.
 */
OST_API ost_status ost_bone_download(const ost_bone *bone, int32_t z0, int32_t count, int16_t *voxels, ost_error *err);
/*
 * Reads the densities of `count` single voxels. Voxel i has the indices at[0][i], at[1][i] and at[2][i] along x, y
 * and z. If a voxel is not active or is outside the grid, its density is 0. The function allocates no memory and does
 * not block, so it may be called in a tick. There are two exceptions for a bone on a device. The first call after the
 * bone was made or uploaded allocates host memory and copies all voxels to it. The first call after a removal blocks
 * until the occupancy of the changed chunks has arrived. Returns OST_ERR_UNAVAILABLE if the backend can read only
 * slices, as the backend `plugin` does, and OST_ERR_USAGE if bone is NULL, or if an array is NULL and count is not 0.
 */
OST_API ost_status ost_bone_sample(const ost_bone *bone, size_t count, const int32_t *const at[3], int16_t *densities,
                                   ost_error *err);
/*
 * Reads the occupancy of `count` chunks. `chunks` contains the chunk numbers cx + chunk_dims.x * (cy + chunk_dims.y *
 * cz). `words` has n^3 / 32 elements for each chunk of n^3 voxels. Voxel (x, y, z) of a chunk has the number v = x + n
 * (y + n z); its bit is bit v % 32 of element v / 32 of the chunk. The function allocates no memory, so it may be
 * called in a tick. If the bone is on a device, the function blocks until the data has arrived. Returns OST_ERR_USAGE
 * if a chunk number is out of range, and OST_ERR_UNAVAILABLE if the backend can read only slices, as the backend
 * `plugin` does.
 */
OST_API ost_status ost_bone_occupancy(const ost_bone *bone, size_t count, const int32_t *chunks, uint32_t *words,
                                      ost_error *err);
/*
 * Computes the digest of a bone. If `leaves` is not NULL, also stores the digests of the leaves, in x-fastest order.
 * ost_leaf_dims returns the number of leaves along each axis. Returns OST_ERR_MEMORY if memory for the leaves is
 * exhausted, and backend errors.
 */
OST_API ost_status ost_bone_digest(const ost_bone *bone, ost_digest *leaves, ost_digest *root, ost_error *err);

/* ----------------------------------------------------------------- tools */

/*
 * The rule that determines whether a point is inside a mesh (AR-VOX-4). WINDING: the point is inside if its winding
 * number is not zero. PARITY: the point is inside if the number of crossings is odd.
 */
typedef enum ost_fill_rule { OST_FILL_WINDING, OST_FILL_PARITY } ost_fill_rule;

typedef struct ost_voxelize_report {
    uint64_t solid_voxels; /* number of cutting and non-cutting voxels */
    uint64_t cutting_voxels;
    uint64_t leaking_rows; /* number of rows in which the mesh is not closed (AR-VOX-6); these rows remain empty */
} ost_voxelize_report;

/*
 * Voxelizes one or two meshes that are snapped to the same grid (AR-VOX). A voxel that is solid in both meshes is
 * cutting. noncutting and report may be NULL. Returns OST_ERR_USAGE if the meshes are snapped to different grids or the
 * rule is unknown, and OST_ERR_RANGE if the grid exceeds a limit of AR-TOOL-1. The caller frees *out with
 * ost_tool_free.
 */
OST_API ost_status ost_voxelize(ost_backend *backend, const ost_snapped_mesh *cutting,
                                const ost_snapped_mesh *noncutting, ost_fill_rule rule, ost_voxelize_report *report,
                                ost_tool **out, ost_error *err);
/*
 * Creates a tool by copying voxels from host memory (AR-TOOL-4). Returns OST_ERR_INPUT if a voxel has a class other
 * than 0, 1 and 2, and OST_ERR_RANGE if the grid exceeds a limit of AR-TOOL-1. The caller frees *out with
 * ost_tool_free.
 */
OST_API ost_status ost_tool_upload(ost_backend *backend, const ost_tool_volume *volume, ost_tool **out, ost_error *err);
/*
 * Copies a tool to host memory. *out need not be initialised. out->meta is empty afterwards. Returns OST_ERR_MEMORY if
 * memory is exhausted, and backend errors. After an error, *out has no voxels. The caller frees *out with
 * ost_tool_volume_free.
 */
OST_API ost_status ost_tool_download(const ost_tool *tool, ost_tool_volume *out, ost_error *err);
/* Frees a tool. NULL is allowed. */
OST_API void ost_tool_free(ost_tool *tool);
/* Returns the geometry of a tool's grid. The pointer is valid until the tool is freed. */
OST_API const ost_tool_geometry *ost_tool_geometry_get(const ost_tool *tool);
/* Computes the digest of a tool (AR-DIG). The errors are those of ost_tool_download. */
OST_API ost_status ost_tool_digest(const ost_tool *tool, ost_digest *root, ost_error *err);

/* ---------------------------------------------------------------- events */

/*
 * Removes every active bone voxel that a cutting tool voxel covers at one of the event's poses (AR-REM). To remove a
 * voxel, sets its density to 0 and clears its occupancy bit. *report is cleared first, and is undefined after an error.
 * The event's maps must have been computed for this bone and this tool. Returns OST_ERR_RANGE if the tool has more than
 * OST_TOOL_DIM_REMOVE_MAX voxels along an axis. Returns OST_ERR_USAGE if the event has no maps, boxes or classes, if
 * its number of poses is not within 1 to OST_SWEEP_MAX, or if ost_density_classes_check rejects its classes.
 */
OST_API ost_status ost_bone_remove(ost_bone *bone, const ost_tool *tool, const ost_removal_event *event,
                                   ost_removal_report *report, ost_error *err);
/* Writes the same report and returns the same errors as ost_bone_remove, but does not change the bone. */
OST_API ost_status ost_bone_collide(const ost_bone *bone, const ost_tool *tool, const ost_removal_event *event,
                                    ost_removal_report *report, ost_error *err);

/*
 * Blocks until the work of all previous calls is complete. Returns the backend error of work that failed after its call
 * had returned, and OST_ERR_USAGE if backend is NULL.
 */
OST_API ost_status ost_backend_finish(ost_backend *backend, ost_error *err);

#ifdef __cplusplus
}
#endif
#endif
