/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Backends: who keeps the voxels and works on them.
 *
 * A backend is chosen by a string, "name" or "name:key=value,key=value":
 * "cpu" is the one for work: it finds the instruction set and the number of
 * threads by itself, or takes "cpu:isa=avx2,threads=2".  "ref" is the scalar
 * reference, the executable form of docs/arithmetic.md;
 * "cl:platform=Portable,device=0" an OpenCL device; "plugin:FILE.so" somebody
 * else's implementation (plugin.h).
 * Every backend gives the same grids to the bit, or it has a defect.
 *
 *   samples --ct_to_rect--> grid --rect_to_cubic--> grid --cubic_to_chunks--> bone
 *   snapped mesh --voxelize--> tool                      event --remove--> bone, report
 *
 * Lifetimes: grids, bones and tools belong to the caller and must be freed
 * before their backend is closed; the functions of one backend must not be
 * given another's objects (checked: OST_ERR_USAGE).
 * Threads: one backend and its objects are used by one thread at a time;
 * different backends are independent.  After fork() a child that did not exec
 * must not call osteon: threads of its parent's OpenMP runtime are missing there.
 * Errors: arguments are checked here, at the border; a failed call leaves its
 * in-out objects as they were unless it says otherwise.  One thing can prevent
 * that: a device that fails while it changes a grid or a bone.  Nobody knows
 * then what it has done, so that object is lost: every later call with it but
 * its free fails with OST_ERR_UNAVAILABLE and says so.  It is never something
 * in between.  It can be made again from what the caller has; ost_world_rescue
 * (sim.h) does that for a world, on another backend.
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
    const char *description; /* a sentence */
    bool available;
    char reason[256]; /* when not available: why, and what to install */
} ost_backend_info;

/* All backends that this library knows, in a fixed order. */
OST_API int ost_backend_count(void);
OST_API ost_status ost_backend_describe(int index, ost_backend_info *out, ost_error *err);

/* A device that a backend may be opened on, as `osteon devices` lists it. */
typedef struct ost_device_info {
    const char *spec;     /* what ost_backend_open takes for it: "cl:platform=0,device=1" */
    const char *platform; /* name and version */
    const char *name;     /* and version of its driver */
    bool available;
    const char *reason; /* when not available: why */
    const char *notes;  /* for the record, decides nothing: what its floating point does */
    const char *facts;  /* for the record: lines "CL_DEVICE_VENDOR=...", what the driver says; "" when it says nothing */
} ost_device_info;

/* The texts live until visit returns. */
typedef void ost_device_visit(const ost_device_info *device, void *user);

/* Tries every device of backend number index, in a fixed order; none where a backend has none to choose from. */
OST_API ost_status ost_backend_devices(int index, ost_device_visit *visit, void *user, ost_error *err);

/* OST_ERR_USAGE on an unknown name, key or value; OST_ERR_UNAVAILABLE with the reason when it cannot run here. */
OST_API ost_status ost_backend_open(const char *spec, ost_backend **out, ost_error *err);
OST_API void ost_backend_close(ost_backend *backend); /* NULL is allowed */
OST_API const char *ost_backend_name(const ost_backend *backend);

/* What an open backend works with, after its options, the environment and the machine had their say. */
typedef struct ost_backend_settings {
    const char *isa; /* the instruction set it chose, "avx2"; "" where there is no choice */
    int threads;     /* the most it uses, >= 1 */
    int platform, device; /* of the device that it is on, whose spec is "cl:platform=0,device=1"; -1: it has none to choose */
} ost_backend_settings;

OST_API ost_backend_settings ost_backend_settings_get(const ost_backend *backend);

/* ----------------------------------------------------------------- grids */

/* Zero-filled. */
OST_API ost_status ost_grid_create(ost_backend *backend, const ost_geometry *geometry, ost_grid **out, ost_error *err);
OST_API void ost_grid_free(ost_grid *grid); /* NULL is allowed */
OST_API const ost_geometry *ost_grid_geometry(const ost_grid *grid);
/* Slices z0 <= k < z0 + count, x fastest, to or from host memory of dims.x * dims.y * count elements. */
OST_API ost_status ost_grid_upload(ost_grid *grid, int32_t z0, int32_t count, const int16_t *voxels, ost_error *err);
OST_API ost_status ost_grid_download(const ost_grid *grid, int32_t z0, int32_t count, int16_t *voxels, ost_error *err);

/* ---------------------------------------------------------------- import */

/*
 * One line of a CT text (thesis, Alg. 2.2).  line is relative to the batch's
 * first line, so that batches of any file fit.
 */
typedef struct ost_sample {
    int64_t x, y, z; /* picometres: the voxel's centre */
    int32_t density; /* within int16: OST_ERR_RANGE otherwise, and nothing is scattered */
    uint32_t line;
} ost_sample;

typedef enum ost_duplicates { /* the same voxel twice with different densities */
    OST_DUPLICATES_ERROR,
    OST_DUPLICATES_FIRST, /* in the order of the file */
    OST_DUPLICATES_LAST,
    OST_DUPLICATES_MAX
} ost_duplicates;

/* What a scatter met, summed over its batches; lines are absolute, 0 when none. The lowest line wins. */
typedef struct ost_scatter_report {
    uint64_t samples;
    uint64_t duplicates;         /* voxels met again, whatever the density */
    uint64_t off_lattice;        /* more than 1/8 of a voxel off */
    uint64_t worst_offset_ppm;   /* the greatest offset, in millionths of a voxel, floor */
    int64_t worst_line;          /* of it (the first such) */
    int64_t rejected_line;       /* first sample more than 3/8 of a voxel off, or outside the grid */
    int64_t conflict_line;       /* first sample with another density than its voxel has (OST_DUPLICATES_ERROR) */
    int16_t conflict_had, conflict_has;
} ost_scatter_report;

/*
 * Scatters a batch into a rect grid that was created for it (AR-CT-4: index =
 * RHE((p - origin) / spacing)).  Batches come in the file's order and add to
 * report; `seen` in the grid remembers which voxels are set.  With a rejected
 * or conflicting sample the report says so and the grid's content is of no use.
 */
OST_API ost_status ost_ct_to_rect(ost_grid *rect, const ost_sample *samples, size_t count, int64_t first_line,
                                  ost_duplicates duplicates, ost_scatter_report *report, ost_error *err);

/*
 * AR-CUB: what a cubic voxel takes from the rect grid, with t = ((2i + 1) c - s) / (2s) its centre in rect voxels.
 * LINEAR weights the eight voxels around t, NEAREST takes the voxel that holds t, THESIS is Alg. 2.5's floor(i c / s).
 */
typedef enum ost_resample { OST_RESAMPLE_LINEAR, OST_RESAMPLE_NEAREST, OST_RESAMPLE_THESIS } ost_resample;

/* "linear", "nearest", "thesis"; NULL for another number. */
OST_API const char *ost_resample_name(ost_resample rule);

/*
 * Resamples rect to cubes of `cubic`. Both grids cover the same physical box:
 * dims = ceil(dims * s / c), origin = rect origin + RHE((c - s) / 2) on each axis (AR-CUB-1).
 */
OST_API ost_status ost_rect_to_cubic(const ost_grid *rect, ost_pm cubic, ost_resample rule, ost_grid **out, ost_error *err);

/* AR-CHK: density >= threshold is active, everything else is stored as 0. chunk_size 16, 32 or 64; 1 <= threshold <= 32767. */
OST_API ost_status ost_cubic_to_chunks(const ost_grid *cubic, int chunk_size, int32_t threshold, ost_bone **out, ost_error *err);

/* ----------------------------------------------------------------- bones */

typedef struct ost_bone_info {
    ost_geometry geometry; /* equal spacing on all axes */
    int chunk_size;
    int32_t threshold;
    ost_dims chunk_dims;
    int64_t chunks;
    int64_t active_chunks; /* chunks that hold memory: at least one active voxel */
    int64_t active_voxels;
    int64_t chunk_bytes; /* densities and occupancy of active chunks */
    int64_t resident_bytes; /* all memory that the bone holds: chunk_bytes, tables and slack; each backend has its own */
} ost_bone_info;

/* A bone with no active voxel. */
OST_API ost_status ost_bone_create(ost_backend *backend, const ost_geometry *geometry, int chunk_size, int32_t threshold,
                                   ost_bone **out, ost_error *err);
OST_API void ost_bone_free(ost_bone *bone); /* NULL is allowed */
OST_API ost_status ost_bone_info_get(const ost_bone *bone, ost_bone_info *out, ost_error *err);
/* Densities in slices z0 <= k < z0 + count of the grid without its padding. Upload applies the threshold. */
OST_API ost_status ost_bone_upload(ost_bone *bone, int32_t z0, int32_t count, const int16_t *voxels, ost_error *err);
OST_API ost_status ost_bone_download(const ost_bone *bone, int32_t z0, int32_t count, int16_t *voxels, ost_error *err);
/*
 * Densities of count single voxels, x, y and z in at[0], [1] and [2], 0 for those that are not active or beyond the grid: what a force is made of.  Fit for
 * a tick: no memory is asked for.  OST_ERR_UNAVAILABLE on a backend whose voxels are not in the host's memory.
 */
OST_API ost_status ost_bone_sample(const ost_bone *bone, size_t count, const int32_t *const at[3], int16_t *densities, ost_error *err);
/*
 * Which voxels of count chunks are active, as bits: voxel (x, y, z) of a chunk of n^3 is number v = x + n (y + n z), bit v % 32
 * of word v / 32; words has room for n^3 / 32 of them a chunk.  Chunk (cx, cy, cz) is number cx + chunk_dims.x * (cy +
 * chunk_dims.y * cz).  Fit for a tick, as sampling is; a device is read and waited for.  OST_ERR_UNAVAILABLE on a backend that
 * gives slices alone (plugin).
 */
OST_API ost_status ost_bone_occupancy(const ost_bone *bone, size_t count, const int32_t *chunks, uint32_t *words, ost_error *err);
/* Leaves in x-fastest order (leaves may be NULL, else room for all of ost_leaf_dims), and the grid's digest. */
OST_API ost_status ost_bone_digest(const ost_bone *bone, ost_digest *leaves, ost_digest *root, ost_error *err);

/* ----------------------------------------------------------------- tools */

typedef enum ost_fill_rule { OST_FILL_WINDING, OST_FILL_PARITY } ost_fill_rule;

typedef struct ost_voxelize_report {
    uint64_t solid_voxels; /* cutting and not cutting */
    uint64_t cutting_voxels;
    uint64_t leaking_rows; /* rows whose count does not return to zero; they are void */
} ost_voxelize_report;

/* Both meshes on one grid; noncutting may be NULL; where both are solid the voxel cuts (AR-VOX). */
OST_API ost_status ost_voxelize(ost_backend *backend, const ost_snapped_mesh *cutting, const ost_snapped_mesh *noncutting,
                                ost_fill_rule rule, ost_voxelize_report *report, ost_tool **out, ost_error *err);
OST_API ost_status ost_tool_upload(ost_backend *backend, const ost_tool_volume *volume, ost_tool **out, ost_error *err);
/* *out is initialised here; meta stays empty. */
OST_API ost_status ost_tool_download(const ost_tool *tool, ost_tool_volume *out, ost_error *err);
OST_API void ost_tool_free(ost_tool *tool); /* NULL is allowed */
OST_API const ost_tool_geometry *ost_tool_geometry_get(const ost_tool *tool);
OST_API ost_status ost_tool_digest(const ost_tool *tool, ost_digest *root, ost_error *err);

/* ---------------------------------------------------------------- events */

/*
 * Removes every active bone voxel that a cutting tool voxel covers at one of
 * the event's poses (AR-REM); density 0, occupancy cleared.  collide reports
 * the same set and changes nothing.  report is cleared first, and of no use
 * after an error.  tool must have
 * dims <= OST_TOOL_DIM_REMOVE_MAX, maps made for this bone and tool.
 */
OST_API ost_status ost_bone_remove(ost_bone *bone, const ost_tool *tool, const ost_event *event, ost_report *report, ost_error *err);
OST_API ost_status ost_bone_collide(const ost_bone *bone, const ost_tool *tool, const ost_event *event, ost_report *report,
                                    ost_error *err);

/* Waits until everything asked for has happened and reports a late failure. */
OST_API ost_status ost_backend_finish(ost_backend *backend, ost_error *err);

#ifdef __cplusplus
}
#endif
#endif
