/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Backends store voxels and operate on them.
 *
 * A backend is chosen by a string, "name" or "name:key=value,key=value":
 *
 *   cpu                              the default; selects the instruction set and the number of threads
 *                                    itself, or by options: "cpu:isa=avx2,threads=2"
 *   ref                              the scalar reference, the executable form of docs/spec/arithmetic.md
 *   cl:platform=Portable,device=0    an OpenCL device
 *   plugin:FILE.so                   an implementation in a shared library (plugin.h)
 *
 * All backends give bit-identical grids.
 *
 *   samples --ct_to_rect--> grid --rect_to_cubic--> grid --cubic_to_chunks--> bone
 *   snapped mesh --voxelize--> tool                      event --remove--> bone, report
 *
 * Lifetimes: grids, bones and tools are owned by the caller and must be freed
 * before their backend is closed.  All objects of a call must belong to one
 * backend; otherwise it returns OST_ERR_USAGE.
 * Threads: one backend and its objects are used by one thread at a time;
 * different backends are independent.  After fork() a child that did not exec
 * must not call osteon: the threads of its parent's OpenMP runtime are missing.
 * Errors: these functions check their arguments.  A failed call leaves its
 * in-out objects unchanged unless its comment says otherwise.  The exception is
 * a device that fails while it changes a grid or a bone: the state of that
 * object is unknown, and every later call with it, except its free, fails with
 * OST_ERR_UNAVAILABLE.  The caller can make the object again; ost_world_failover
 * (sim.h) does so for a world, on another backend.
 */
#ifndef OSTEON_BACKEND_H
#define OSTEON_BACKEND_H

#include <osteon/event.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct ost_backend ost_backend;
typedef struct ost_grid ost_grid; /* a dense int16 grid that lives on the backend */
typedef struct ost_bone ost_bone; /* a chunk grid that lives on the backend */
typedef struct ost_tool ost_tool; /* a tool grid that lives on the backend */

/* ---------------------------------------------------------------- choice */

typedef struct ost_backend_info {
    const char *name;        /* "ref" */
    const char *description; /* one sentence */
    bool available;
    char reason[256]; /* if not available: the reason and what to install */
} ost_backend_info;

/* Returns the number of backends; indices 0 to count - 1 are in a fixed order. */
OST_API int ost_backend_count(void);
/*
 * Describes the backend of an index. Tests whether it can be opened here, without opening it. Returns
 * OST_ERR_USAGE if the index is out of range. The texts are static.
 */
OST_API ost_status ost_backend_describe(int index, ost_backend_info *out, ost_error *err);

/* A device that a backend may be opened on, as `osteon devices` lists it. */
typedef struct ost_device_info {
    const char *spec;     /* string for ost_backend_open: "cl:platform=0,device=1" */
    const char *platform; /* name and version of the platform */
    const char *name;     /* name of the device and version of its driver */
    bool available;
    const char *reason; /* if not available: the reason */
    const char *notes;  /* properties of its floating point, for records; they decide no voxel */
    const char *facts;  /* lines "CL_DEVICE_VENDOR=..." as the driver reports them, for records; may be "" */
} ost_device_info;

/* Receives one device; the texts are valid until it returns. */
typedef void ost_device_visit(const ost_device_info *device, void *user);

/*
 * Tests every device of the backend of that index, in a fixed order, and calls visit for each; a backend may have
 * none.
 */
OST_API ost_status ost_backend_devices(int index, ost_device_visit *visit, void *user, ost_error *err);

/*
 * Opens a backend.  OST_ERR_USAGE for an unknown name, key or value; OST_ERR_UNAVAILABLE, with the reason in err, if it
 * cannot run on this machine.
 */
OST_API ost_status ost_backend_open(const char *spec, ost_backend **out, ost_error *err);
/* Closes a backend. All its grids, bones and tools must have been freed. NULL is allowed. */
OST_API void ost_backend_close(ost_backend *backend);
/* Returns the name without options, for example "cpu"; static. */
OST_API const char *ost_backend_name(const ost_backend *backend);

/* Settings of an open backend, as its options, the environment and the machine determine them. */
typedef struct ost_backend_settings {
    const char *isa; /* instruction set in use, for instance "avx2"; "" if the backend has no choice */
    int threads;     /* greatest number of threads, >= 1 */
    int platform, device; /* indices as in "cl:platform=0,device=1"; -1 if the backend has no devices */
} ost_backend_settings;

/* Returns the settings of an open backend. The texts are valid until it is closed. */
OST_API ost_backend_settings ost_backend_settings_get(const ost_backend *backend);

/* ----------------------------------------------------------------- grids */

/* Creates a grid filled with 0. */
OST_API ost_status ost_grid_create(ost_backend *backend, const ost_geometry *geometry, ost_grid **out, ost_error *err);
/* Frees a grid. NULL is allowed. */
OST_API void ost_grid_free(ost_grid *grid);
/* Returns the geometry of a grid; valid until the grid is freed. */
OST_API const ost_geometry *ost_grid_geometry(const ost_grid *grid);
/* Copies slices z0 <= k < z0 + count, x fastest, from host memory of dims.x * dims.y * count elements to a grid. */
OST_API ost_status ost_grid_upload(ost_grid *grid, int32_t z0, int32_t count, const int16_t *voxels, ost_error *err);
/* Copies slices from a grid, as ost_grid_upload copies them to it. */
OST_API ost_status ost_grid_download(const ost_grid *grid, int32_t z0, int32_t count, int16_t *voxels, ost_error *err);

/* ---------------------------------------------------------------- import */

/*
 * One line of a CT text (thesis, Alg. 2.2).  line is relative to the batch's
 * first line, so that batches of any file fit.
 */
typedef struct ost_sample {
    int64_t x, y, z; /* picometres: the voxel's centre */
    int32_t density; /* within int16; otherwise OST_ERR_RANGE, and no sample is scattered */
    uint32_t line;   /* line number less the batch's first line */
} ost_sample;

/* The density of a voxel that has several samples (AR-CT-6). */
typedef enum ost_duplicates {
    OST_DUPLICATES_ERROR, /* it is an error */
    OST_DUPLICATES_FIRST, /* in the order of the file */
    OST_DUPLICATES_LAST,
    OST_DUPLICATES_MAX
} ost_duplicates;

/*
 * Counts of a scatter, summed over its batches; lines are absolute, 0 if there is none, and the lowest line is
 * reported.
 */
typedef struct ost_scatter_report {
    uint64_t samples;
    uint64_t duplicates;         /* samples whose voxel already had a density, equal or not */
    uint64_t off_lattice;        /* samples more than 1/8 of a voxel off the lattice */
    uint64_t worst_offset_ppm;   /* greatest offset, floor, in millionths of a voxel */
    int64_t worst_line;          /* first sample with that offset */
    int64_t rejected_line;       /* first sample more than 3/8 of a voxel off, or outside the grid */
    int64_t conflict_line;       /* first sample whose voxel already has another density (OST_DUPLICATES_ERROR) */
    int16_t conflict_had, conflict_has; /* the voxel's density and that sample's */
} ost_scatter_report;

/*
 * Scatters a batch of samples into a rect grid (AR-CT-4: index = RHE((p - origin) / spacing)).  Batches must come in
 * the file's order; each adds to *report.  The grid records which voxels have a density.  If a sample is rejected or
 * in conflict, the report has its line and the grid's content is undefined.
 */
OST_API ost_status ost_ct_to_rect(ost_grid *rect, const ost_sample *samples, size_t count, int64_t first_line,
                                  ost_duplicates duplicates, ost_scatter_report *report, ost_error *err);

/*
 * Rule of resampling (AR-CUB), with t = ((2i + 1) c - s) / (2s) the centre of a cubic voxel in rect voxels.  LINEAR
 * weights the eight voxels around t, NEAREST takes the voxel that contains t, THESIS takes floor(i c / s) (Alg. 2.5).
 */
typedef enum ost_resample { OST_RESAMPLE_LINEAR, OST_RESAMPLE_NEAREST, OST_RESAMPLE_THESIS } ost_resample;

/* Returns "linear", "nearest" or "thesis"; NULL for any other value. */
OST_API const char *ost_resample_name(ost_resample rule);

/*
 * Resamples rect to cubes of `cubic`. Both grids cover the same physical box:
 * dims = ceil(dims * s / c), origin = rect origin + RHE((c - s) / 2) on each axis (AR-CUB-1).
 */
OST_API ost_status ost_rect_to_cubic(const ost_grid *rect, ost_pm cubic, ost_resample rule, ost_grid **out,
                                     ost_error *err);

/*
 * Makes a bone from a cubic grid (AR-CHK): voxels of density >= threshold are active, all others are stored as 0.
 * chunk_size is 16, 32 or 64; 1 <= threshold <= 32767.
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
    int64_t active_chunks; /* chunks with memory, that is, with at least one active voxel */
    int64_t active_voxels;
    int64_t chunk_bytes; /* densities and occupancy of active chunks */
    int64_t resident_bytes; /* all memory of the bone, with tables and unused capacity; differs between backends */
} ost_bone_info;

/* Creates a bone without an active voxel. */
OST_API ost_status ost_bone_create(ost_backend *backend, const ost_geometry *geometry, int chunk_size,
                                   int32_t threshold, ost_bone **out, ost_error *err);
/* Frees a bone. NULL is allowed. */
OST_API void ost_bone_free(ost_bone *bone);
/* Fills *out with the properties of a bone and its counts. With a device, blocks until they are known. */
OST_API ost_status ost_bone_info_get(const ost_bone *bone, ost_bone_info *out, ost_error *err);
/*
 * Copies densities of slices z0 <= k < z0 + count to a bone, x fastest, without the padding of chunks: dims.x *
 * dims.y * count elements.  Densities below the threshold are stored as 0.
 */
OST_API ost_status ost_bone_upload(ost_bone *bone, int32_t z0, int32_t count, const int16_t *voxels, ost_error *err);
/* Copies slices from a bone, as ost_bone_upload copies them to it; voxels that are not active are 0. */
OST_API ost_status ost_bone_download(const ost_bone *bone, int32_t z0, int32_t count, int16_t *voxels, ost_error *err);
/*
 * Reads the densities of count single voxels with indices at[0][i], at[1][i], at[2][i] along x, y and z; 0 for voxels
 * that are not active or beyond the grid.  Suitable for a tick: it allocates no memory.  OST_ERR_UNAVAILABLE on a
 * backend whose voxels are not in host memory.
 */
OST_API ost_status ost_bone_sample(const ost_bone *bone, size_t count, const int32_t *const at[3], int16_t *densities,
                                   ost_error *err);
/*
 * Reads the occupancy of count chunks: voxel (x, y, z) of a chunk of n^3 is number v = x + n (y + n z), bit v % 32 of
 * word v / 32.  words has n^3 / 32 elements for each chunk.  chunks has the numbers cx + chunk_dims.x * (cy +
 * chunk_dims.y * cz).  Suitable for a tick: it allocates no memory; with a device it blocks until the device answers.
 * OST_ERR_UNAVAILABLE on a backend that delivers slices only (plugin).
 */
OST_API ost_status ost_bone_occupancy(const ost_bone *bone, size_t count, const int32_t *chunks, uint32_t *words,
                                      ost_error *err);
/* Computes the leaves in x-fastest order, as many as ost_leaf_dims says (leaves may be NULL), and the grid's digest. */
OST_API ost_status ost_bone_digest(const ost_bone *bone, ost_digest *leaves, ost_digest *root, ost_error *err);

/* ----------------------------------------------------------------- tools */

/* The rule for the inside of a mesh: the winding number is not zero, or the number of crossings is odd (AR-VOX-4). */
typedef enum ost_fill_rule { OST_FILL_WINDING, OST_FILL_PARITY } ost_fill_rule;

typedef struct ost_voxelize_report {
    uint64_t solid_voxels; /* cutting and not cutting */
    uint64_t cutting_voxels;
    uint64_t leaking_rows; /* rows whose crossings do not cancel (AR-VOX-6); they are void */
} ost_voxelize_report;

/*
 * Voxelizes two meshes that are snapped to one grid (AR-VOX).  noncutting may be NULL.  A voxel that is solid in both
 * meshes cuts.  report may be NULL.
 */
OST_API ost_status ost_voxelize(ost_backend *backend, const ost_snapped_mesh *cutting,
                                const ost_snapped_mesh *noncutting, ost_fill_rule rule, ost_voxelize_report *report,
                                ost_tool **out, ost_error *err);
/*
 * Makes a tool from voxels in host memory, which are copied (classes 0, 1 and 2; AR-TOOL-4). The
 * caller frees *out.
 */
OST_API ost_status ost_tool_upload(ost_backend *backend, const ost_tool_volume *volume, ost_tool **out, ost_error *err);
/* Copies a tool to host memory. *out need not be initialised; its meta is empty. The caller frees it. */
OST_API ost_status ost_tool_download(const ost_tool *tool, ost_tool_volume *out, ost_error *err);
/* Frees a tool. NULL is allowed. */
OST_API void ost_tool_free(ost_tool *tool);
/* Returns the geometry of a tool's grid; valid until the tool is freed. */
OST_API const ost_tool_geometry *ost_tool_geometry_get(const ost_tool *tool);
/* Computes the digest of a tool (AR-DIG). */
OST_API ost_status ost_tool_digest(const ost_tool *tool, ost_digest *root, ost_error *err);

/* ---------------------------------------------------------------- events */

/*
 * Removes every active bone voxel that a cutting tool voxel covers at one of the event's poses (AR-REM): its density
 * becomes 0 and its occupancy bit is cleared.  ost_bone_collide reports the same set without a change.  *report is
 * cleared first and undefined after an error.  The tool's dims must be <= OST_TOOL_DIM_REMOVE_MAX, and the event's
 * maps must have been made for this bone and tool.
 */
OST_API ost_status ost_bone_remove(ost_bone *bone, const ost_tool *tool, const ost_removal_event *event,
                                   ost_removal_report *report, ost_error *err);
/* Reports the hits and touched voxels of an event as ost_bone_remove does, without changing the bone. */
OST_API ost_status ost_bone_collide(const ost_bone *bone, const ost_tool *tool, const ost_removal_event *event,
                                    ost_removal_report *report, ost_error *err);

/* Blocks until all previous calls are complete and returns the status of one that failed late. */
OST_API ost_status ost_backend_finish(ost_backend *backend, ost_error *err);

#ifdef __cplusplus
}
#endif
#endif
