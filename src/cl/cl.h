/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The OpenCL backend's host side: the declarations that its files share.
 *
 *   choice.c, icd.c   which devices are present, may be used and are selected
 *   context.c         one opened device: context, queue, program, kernels, checks
 *   program.c         building; binaries are cached by cache.c under the key of key.c
 *   layout.c          check that structs have the same layout on the device
 *   fingerprint.c     check that the device's integers are right
 *   launch.c          buffers and launches, with errors that name the device
 *   spare.c           a pool of large buffers for reuse
 *   grid.c import.c bone.c voxelize.c tool.c remove.c    the slots of the function table
 *   cl.c              the function table
 *
 * All commands go through one in-order queue, so each call sees the results of
 * the calls before it.  Grids, bones and tools are buffers on the device.  Of a
 * bone the host stores only which chunk is in which slot and how many voxels are
 * active in each chunk.
 *
 * Failure.  A failure before a call has enqueued a change of an object leaves
 * the object unchanged.  After that the object's state on the device is unknown:
 * the object is lost, every later call on it returns OST_ERR_UNAVAILABLE, and it
 * can only be freed.
 */
#ifndef OST_CL_CL_H
#define OST_CL_CL_H

#include "cl/choice.h"
#include "cl/kernels/shared.h"
#include "core/backend.h"

/* X(kernel, sets): the kernel is created if the opened kernel set is one of sets (bits of OST_FOR,
   kernels/shared.h). */
/* clang-format off */
#define OST_CL_KERNELS(X) \
    X(ost_layout, 3) X(ost_fingerprint, 3) X(ost_fingerprint_atomics, 3) X(ost_fingerprint_turns, 3) \
    X(ost_ct_claim, 3) X(ost_ct_place, 3) X(ost_ct_check, 3) X(ost_ct_report_first_bad, 3) X(ost_ct_had, 3) \
    X(ost_cubic_sources, 3) X(ost_cubic_gather, 3) X(ost_cubic_linear, 3) \
    X(ost_chunk_scan, 1) X(ost_chunk_scan_layers, 2) X(ost_chunk_store, 1) X(ost_chunk_store_layers, 2) \
    X(ost_chunk_load, 1) X(ost_chunk_load_rows, 2) X(ost_chunk_count, 3) \
    X(ost_vox_steps, 1) X(ost_vox_fill, 1) X(ost_vox_count, 1) X(ost_vox_tiles, 2) X(ost_tool_reach, 3) \
    X(ost_tool_windows, 2) \
    X(ost_remove, 1) X(ost_remove_blocks, 2)
/* clang-format on */

enum { OST_CL_SPARES = 8 };

enum ost_cl_kernel {
#define OST_CL_KERNEL_ENUM(name, sets) OST_CL_KERNEL_##name,
    OST_CL_KERNELS(OST_CL_KERNEL_ENUM)
#undef OST_CL_KERNEL_ENUM
    OST_CL_KERNEL_COUNT
};

/* X(path, sets, name): the host's paths (core/paths.h), each counted where it is entered. */
/* clang-format off */
#define OST_CL_PATHS(X) \
    X(SAMPLES_IN_PARTS, 3, "scatter of a batch in several parts") \
    X(RESAMPLED_LATER, 3, "resampling along z alone, as a list of slices") \
    X(RESAMPLED_NOW, 3, "resampling along x or y") \
    X(GRID_OF_LIST, 3, "grid made from a list of slices") \
    X(GRID_COPIED, 3, "copy of a shared grid before a write") \
    X(CHUNKS_OF_LIST, 3, "chunks made from a list of slices") \
    X(SLICES_UP_IN_PARTS, 3, "upload of a bone in several parts") \
    X(SLICES_DOWN_IN_PARTS, 3, "download of a bone in several parts") \
    X(EMPTY_DOWN, 3, "download of a bone without chunks") \
    X(OCCUPANCY_DOWN, 3, "download of occupancy") \
    X(POOL_GROWN, 3, "growth of a pool that has chunks") \
    X(SLOT_REUSED, 3, "slot of a freed chunk used again") \
    X(BUFFER_REUSED, 3, "large buffer used again") \
    X(STEPS_IN_PARTS, 1, "voxelization in several parts") \
    X(LISTS_SHARED, 2, "voxelization with one list for several passes of tiles") \
    X(NO_NONCUTTING, 3, "voxelization of a cutting mesh alone") \
    X(WITH_NONCUTTING, 3, "voxelization of two meshes") \
    X(EVENT_IN_PARTS, 3, "event in several launches") \
    X(EVENT_REMOVES, 3, "event that removes") \
    X(EVENT_COLLIDES, 3, "event that collides")
/* clang-format on */

enum ost_cl_path {
#define OST_CL_PATH_ENUM(path, sets, name) OST_CL_PATH_##path,
    OST_CL_PATHS(OST_CL_PATH_ENUM)
#undef OST_CL_PATH_ENUM
    OST_CL_PATH_COUNT
};

typedef struct cl_backend {
    ost_backend base;
    const ost_cl_api *cl;
    ost_cl_device device;
    bool cpu_set;     /* true: the kernel set for CPUs; false: for GPUs */
    size_t workgroup; /* work items per work group; 0: default */
    size_t staging;   /* as in ost_cl_options */
    unsigned order;   /* as in ost_cl_options */
    uint32_t turns;   /* loop turns of a work item before the device ends its loops; OST_CL_TURNS: no limit was found */
    int run;          /* voxels of a row that a work item of ost_cubic_gather or ost_cubic_linear makes (OST_RUN) */
    cl_context context;
    cl_command_queue queue;
    struct {
        cl_mem buffer;
        size_t bytes;
    } spare[OST_CL_SPARES]; /* owned; freed buffers kept for reuse at about the same size (spare.c); NULL: none */
    cl_program program;
    cl_kernel kernel[OST_CL_KERNEL_COUNT];
    size_t kernel_workgroup[OST_CL_KERNEL_COUNT]; /* largest work group of each kernel */
    bool from_cache;                              /* true if the program's binary was found in the cache */
    ost_digest empty_leaf;
    uint64_t launched[OST_CL_KERNEL_COUNT]; /* launches of each kernel, without those of an event that meets nothing */
    uint64_t entered[OST_CL_PATH_COUNT];
    struct ost_cl_event_scratch *event; /* owned; scratch of events, NULL before the first (remove.c) */
} cl_backend;

/* ------------------------------------------------------------- context.c */

/* Opens and checks one device. On failure *out is NULL and err has the reason. */
ost_status ost_cl_device_open(const ost_cl_api *cl, const ost_cl_device *device, const ost_cl_options *options,
                              cl_backend **out, ost_error *err);
void ost_cl_device_close(cl_backend *backend);
/* Returns the smaller of a stage's own limit in bytes and the option staging. */
static inline size_t ost_cl_staging(const cl_backend *b, size_t limit)
{
    return b->staging && b->staging < limit ? b->staging : limit;
}
/* The slot paths of the function table: visits the kernels of the opened set and OST_CL_PATHS, with their counts. */
void ost_cl_paths(const ost_backend *backend, ost_path_visit *visit, void *user);

/* The functions behind the slots of cl.c, with another table of OpenCL functions than the loader's. */
ost_status ost_cl_open_with(const ost_cl_api *cl, const char *options, ost_backend **out, ost_error *err);
bool ost_cl_available_with(const ost_cl_api *cl, char *reason, size_t size);
ost_status ost_cl_visit_with(const ost_cl_api *cl, ost_device_visit *visit, void *user, ost_error *err);

/* ------------------------------------------------------------- program.c */

/* Builds a program for the backend's device; *from_cache is true if the binary came from the cache. */
ost_status ost_cl_build(cl_backend *backend, const char *const *sources, size_t count, const char *options,
                        cl_program *out, bool *from_cache, ost_error *err);

/* ----------------------------------------------------------------- key.c */

struct ost_cl_cache;
ost_status ost_cl_key(const ost_cl_device *device, const char *const *sources, size_t count, const char *options,
                      struct ost_cl_cache *cache, ost_error *err);

/* --------------------------------------------------- layout.c, fingerprint.c */

ost_status ost_cl_layout_check(cl_backend *backend, ost_error *err);

/* Returns OST_ERR_UNAVAILABLE, naming the device and the error, if the device's integers differ from the host's or
   its loops end too early. Sets backend->turns. */
ost_status ost_cl_fingerprint_check(cl_backend *backend, ost_error *err);
/* Describes the device's floating point in one line, for the record. */
void ost_cl_fingerprint_floats(cl_backend *backend, char *notes, size_t size);

/* -------------------------------------------------------------- launch.c */

/* Creates a buffer. It is uninitialised if data is NULL, else a copy of data made before the call returns. For 0
   bytes the buffer has 1 byte. */
ost_status ost_cl_buffer(cl_backend *backend, size_t bytes, const void *data, const char *what, cl_mem *out,
                         ost_error *err);
/* Creates a buffer of zeros. */
ost_status ost_cl_buffer_zero(cl_backend *backend, size_t bytes, const char *what, cl_mem *out, ost_error *err);
void ost_cl_buffer_free(cl_backend *backend, cl_mem *buffer); /* sets *buffer to NULL; *buffer may be NULL */
ost_status ost_cl_zero(cl_backend *backend, cl_mem buffer, size_t offset, size_t bytes, ost_error *err);
/* The caller may reuse data when these return. */
ost_status ost_cl_write(cl_backend *backend, cl_mem buffer, size_t offset, size_t bytes, const void *data,
                        ost_error *err);
ost_status ost_cl_read(cl_backend *backend, cl_mem buffer, size_t offset, size_t bytes, void *data, ost_error *err);
/* data must remain unchanged until the next call that waits for the queue. */
ost_status ost_cl_write_later(cl_backend *backend, cl_mem buffer, size_t bytes, const void *data, ost_error *err);
ost_status ost_cl_copy(cl_backend *backend, cl_mem from, cl_mem to, size_t bytes, ost_error *err);
/* Waits for all commands of the queue. */
ost_status ost_cl_finish(cl_backend *backend, ost_error *err);

/* ---------------------------------------------------------------- spare.c */

/* Returns a buffer of at least this size; *reserved is its actual size. Its content is undefined. Large buffers are
   reused. */
ost_status ost_cl_spare_take(cl_backend *backend, size_t bytes, const char *what, cl_mem *out, size_t *reserved,
                             ost_error *err);
/* sets *buffer to NULL; *buffer may be NULL */
void ost_cl_spare_return(cl_backend *backend, cl_mem *buffer, size_t reserved);
/* Releases all buffers that wait for reuse. Returns true if there were any. */
bool ost_cl_spare_clear(cl_backend *backend);

/* One argument of a kernel. */
typedef struct ost_cl_arg {
    size_t size;
    const void *value;
} ost_cl_arg;
#define OST_CL_ARG(value) ((ost_cl_arg){sizeof(value), &(value)})

/* Launches a kernel over x * y * z work items; x is rounded up to a multiple of the work group. Does nothing if one
   of them is 0. */
ost_status ost_cl_launch(cl_backend *backend, enum ost_cl_kernel kernel, size_t x, size_t y, size_t z,
                         const ost_cl_arg *args, unsigned count, ost_error *err);
#define OST_CL_LAUNCH(backend, kernel, x, y, z, err, ...)                                                   \
    ost_cl_launch(backend, OST_CL_KERNEL_##kernel, x, y, z, (const ost_cl_arg[]){__VA_ARGS__},              \
                  sizeof((const ost_cl_arg[]){__VA_ARGS__}) / sizeof(ost_cl_arg), err)

#endif
