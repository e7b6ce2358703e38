/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Declarations shared by the files of the OpenCL backend's host code.
 *
 *   choice.c, icd.c   lists the devices, determines which may be used, and selects one
 *   context.c         one opened device: context, queue, program, kernels, checks
 *   program.c         builds programs; cache.c caches binaries under the key of key.c
 *   layout.c          checks that structs have the same layout on the device
 *   fingerprint.c     checks that the device's integer operations are correct
 *   buffer.c          buffers, and a pool of large buffers for reuse
 *   launch.c          transfers and launches, with errors that name the device
 *   face_mesh.c       meshes of visible faces, which a separate program computes
 *   grid.c import.c bone.c voxelize.c tool.c remove.c    the slots of the function table
 *   cl.c              the function table
 *
 * All commands are enqueued in one in-order queue, so the results of a call are visible
 * to all later calls.  Grids, bones and tools are buffers on the device.  For a bone,
 * the host stores only the slot of each chunk and the number of active voxels in each
 * chunk.
 *
 * Failure.  If a call fails before it has enqueued a change of an object, the object is
 * unchanged.  If a call fails later, the object's state on the device is unknown, and
 * the object is lost: every later call on it returns OST_ERR_UNAVAILABLE, and it can
 * only be freed.
 */
#ifndef OST_CL_CL_H
#define OST_CL_CL_H

#include "cl/choice.h"
#include "cl/kernels/shared.h"
#include "core/backend.h"

/* The list of kernels, as X(kernel, sets). `sets` is a bit mask of the kernel sets that contain the kernel (OST_FOR,
   kernels/shared.h). Only the kernels of the backend's kernel set are created. */
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

/* The list of the host's code paths (core/paths.h), as X(path, sets, name). A counter counts how often each path is
   entered; `sets` has the same meaning as in OST_CL_KERNELS. */
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
    X(MIRROR_MADE, 3, "copy of a bone on the host, for reading single voxels") \
    X(MIRROR_UPDATED, 3, "update of this copy after a removal") \
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
    bool cpu_set;     /* true if the kernel set for CPUs is used; false if the set for GPUs is used */
    size_t workgroup; /* number of work items per work group; 0 selects the default */
    size_t staging;   /* value of the option `staging` (ost_cl_options) */
    unsigned order;   /* value of the option `order` (ost_cl_options) */
    /* number of iterations after which the device ends a loop; OST_CL_TURNS if the test found no limit */
    uint32_t turns;
    /* number of voxels that a work item of ost_cubic_gather or ost_cubic_linear computes (OST_RUN) */
    int run;
    cl_context context;
    cl_command_queue queue;
    struct {
        cl_mem buffer;
        size_t bytes;
    /* owned buffers that were freed and can be reused for buffers of about the same size (buffer.c) */
    } spare[OST_CL_SPARES];
    cl_program program;
    cl_kernel kernel[OST_CL_KERNEL_COUNT];
    size_t kernel_workgroup[OST_CL_KERNEL_COUNT]; /* maximum work-group size of each kernel on this device */
    bool from_cache;                              /* true if the program's binary was loaded from the cache */
    ost_digest empty_leaf;
    /* for each kernel, the number of launches that computed at least one voxel */
    uint64_t launched[OST_CL_KERNEL_COUNT];
    uint64_t entered[OST_CL_PATH_COUNT];
    struct ost_cl_face_program *faces;  /* owned; the kernels and buffers for face meshes; NULL before the first mesh */
    /* owned; the scratch memory for events (remove.c); NULL before the first event */
    struct ost_cl_event_scratch *event;
} cl_backend;

/* ------------------------------------------------------------- context.c */

/* Opens one device and checks it. On failure, *out is NULL and err contains the reason. */
ost_status ost_cl_device_open(const ost_cl_api *cl, const ost_cl_device *device, const ost_cl_options *options,
                              cl_backend **out, ost_error *err);
void ost_cl_device_close(cl_backend *backend);
/* Returns the limit in bytes for a stage: the smaller of the stage's own limit and the value of the `staging`
   option. */
static inline size_t ost_cl_staging(const cl_backend *b, size_t limit)
{
    return b->staging && b->staging < limit ? b->staging : limit;
}
/* Implements the `paths` slot of the function table. Calls `visit` with the count of each kernel of the backend's
   kernel set, and with the count of each path of OST_CL_PATHS. */
void ost_cl_paths(const ost_backend *backend, ost_path_visit *visit, void *user);

/* These functions implement three slots of the function table. Their first parameter is the table of OpenCL functions,
   which a test can replace. */
ost_status ost_cl_open_with(const ost_cl_api *cl, const char *options, ost_backend **out, ost_error *err);
bool ost_cl_available_with(const ost_cl_api *cl, char *reason, size_t size);
ost_status ost_cl_visit_with(const ost_cl_api *cl, ost_device_visit *visit, void *user, ost_error *err);

/* ------------------------------------------------------------- program.c */

/* Builds a program for the device of the backend. Sets *from_cache to true if the binary was in the cache. */
ost_status ost_cl_build(cl_backend *backend, const char *const *sources, size_t count, const char *options,
                        cl_program *out, bool *from_cache, ost_error *err);

/* ----------------------------------------------------------------- key.c */

struct ost_cl_cache;
ost_status ost_cl_key(const ost_cl_device *device, const char *const *sources, size_t count, const char *options,
                      struct ost_cl_cache *cache, ost_error *err);

/* --------------------------------------------------- layout.c, fingerprint.c */

ost_status ost_cl_layout_check(cl_backend *backend, ost_error *err);

/* Checks the device. Returns OST_ERR_UNAVAILABLE, with a message that names the device and the error, if the device's
   integer operations differ from the host's or if the device ends loops too early. Sets backend->turns. */
ost_status ost_cl_fingerprint_check(cl_backend *backend, ost_error *err);
/* Describes the floating-point arithmetic of the device in one line, for information only. */
void ost_cl_fingerprint_floats(cl_backend *backend, char *notes, size_t size);

/* -------------------------------------------------------------- buffer.c */

/* Creates a buffer on the device. If `data` is NULL, the buffer is uninitialised. Otherwise `data` is copied to the
   buffer before the function returns. If `bytes` is 0, the buffer has 1 byte. */
ost_status ost_cl_buffer(cl_backend *backend, size_t bytes, const void *data, const char *what, cl_mem *out,
                         ost_error *err);
/* Releases a buffer and sets *buffer to NULL. A NULL buffer is ignored. */
void ost_cl_buffer_free(cl_backend *backend, cl_mem *buffer);
/*
 * Sets *out to a buffer of at least `bytes` bytes with undefined content, and *reserved to the buffer's size. Large
 * buffers are reused.
 */
ost_status ost_cl_spare_take(cl_backend *backend, size_t bytes, const char *what, cl_mem *out, size_t *reserved,
                             ost_error *err);
/* Releases a buffer or stores it for reuse, and sets *buffer to NULL. *buffer may be NULL before the call. */
void ost_cl_spare_return(cl_backend *backend, cl_mem *buffer, size_t reserved);
/* Releases all buffers that are stored for reuse. Returns true if at least one buffer was released. */
bool ost_cl_spare_clear(cl_backend *backend);

/* -------------------------------------------------------------- launch.c */

/* Creates a buffer on the device that is filled with zeros. */
ost_status ost_cl_buffer_zero(cl_backend *backend, size_t bytes, const char *what, cl_mem *out, ost_error *err);
ost_status ost_cl_zero(cl_backend *backend, cl_mem buffer, size_t offset, size_t bytes, ost_error *err);
/* ost_cl_write and ost_cl_read block until the transfer has ended. */
ost_status ost_cl_write(cl_backend *backend, cl_mem buffer, size_t offset, size_t bytes, const void *data,
                        ost_error *err);
ost_status ost_cl_read(cl_backend *backend, cl_mem buffer, size_t offset, size_t bytes, void *data, ost_error *err);
/*
 * Enqueues a transfer from `data` to the buffer. The caller must not change `data` until the next call that waits for
 * the queue.
 */
ost_status ost_cl_write_later(cl_backend *backend, cl_mem buffer, size_t bytes, const void *data, ost_error *err);
/* Enqueues a transfer from the buffer. `data` is valid only after the next call that waits for the queue. */
ost_status ost_cl_read_later(cl_backend *backend, cl_mem buffer, size_t offset, size_t bytes, void *data,
                             ost_error *err);
ost_status ost_cl_copy(cl_backend *backend, cl_mem from, cl_mem to, size_t bytes, ost_error *err);
/* Blocks until all enqueued commands have ended. Returns the first error of these commands. */
ost_status ost_cl_finish(cl_backend *backend, ost_error *err);

/* ------------------------------------------------------------ face_mesh.c */

ost_status ost_cl_face_mesh(ost_backend *backend, const ost_face_cluster *clusters, size_t count, ost_face_mesh *mesh,
                            ost_error *err);
/* Releases the kernels and buffers of meshes. Must be called before the context is released. */
void ost_cl_face_free(cl_backend *backend);

/* --------------------------------------------------------------- launches */

/* An argument of a kernel: pointer to its value, and size of the value in bytes. */
typedef struct ost_cl_arg {
    size_t size;
    const void *value;
} ost_cl_arg;
#define OST_CL_ARG(value) ((ost_cl_arg){sizeof(value), &(value)})

/* Launches a kernel with x * y * z work items. x is rounded up to a multiple of the size of a work group. Does nothing
   if x, y or z is 0. */
ost_status ost_cl_launch(cl_backend *backend, enum ost_cl_kernel kernel, size_t x, size_t y, size_t z,
                         const ost_cl_arg *args, unsigned count, ost_error *err);
#define OST_CL_LAUNCH(backend, kernel, x, y, z, err, ...)                                                   \
    ost_cl_launch(backend, OST_CL_KERNEL_##kernel, x, y, z, (const ost_cl_arg[]){__VA_ARGS__},              \
                  sizeof((const ost_cl_arg[]){__VA_ARGS__}) / sizeof(ost_cl_arg), err)

#endif
