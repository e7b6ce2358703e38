/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The OpenCL backend's host side: what its files share.
 *
 *   choice.c, icd.c   which devices there are, which may be used, which is meant
 *   context.c         one device opened: context, queue, program, kernels, checks
 *   program.c         building, from cache.c when it has the binary, by the key of key.c
 *   layout.c          structs are laid out there as here
 *   fingerprint.c     its integers are right
 *   launch.c          buffers and launches, with errors that name the device
 *   room.c            large buffers, used again
 *   grid.c import.c bone.c voxelize.c tool.c remove.c    the table's slots
 *   share.c           words in a buffer of OpenGL
 *   cl.c              the table
 *
 * All of it is one in-order queue, so a call sees what the calls before it
 * did.  Grids, bones and tools are buffers on the device; the host holds of a
 * bone only which chunk is in which slot and how many voxels are active there.
 *
 * Failure.  Until a call has enqueued what changes an object, a failure leaves
 * the object as it was.  After that nobody knows what the device has done: the
 * object is lost, says so in every later call (OST_ERR_UNAVAILABLE) and can
 * only be freed.
 */
#ifndef OST_CL_CL_H
#define OST_CL_CL_H

#include "cl/choice.h"
#include "cl/kernels/shared.h"
#include "core/backend.h"

/* X(kernel, sets): created when a set of these is opened: OST_FOR of kernels/shared.h. */
/* clang-format off */
#define OST_CL_KERNELS(X) \
    X(ost_layout, 3) X(ost_fingerprint, 3) X(ost_fingerprint_atomics, 3) X(ost_fingerprint_turns, 3) \
    X(ost_ct_claim, 3) X(ost_ct_place, 3) X(ost_ct_check, 3) X(ost_ct_blame, 3) X(ost_ct_had, 3) \
    X(ost_cubic_sources, 3) X(ost_cubic_gather, 3) X(ost_cubic_linear, 3) \
    X(ost_chunk_scan, 1) X(ost_chunk_scan_layers, 2) X(ost_chunk_store, 1) X(ost_chunk_store_layers, 2) \
    X(ost_chunk_load, 1) X(ost_chunk_load_rows, 2) X(ost_chunk_count, 3) \
    X(ost_vox_steps, 1) X(ost_vox_fill, 1) X(ost_vox_count, 1) X(ost_vox_tiles, 2) X(ost_tool_reach, 3) X(ost_tool_windows, 2) \
    X(ost_remove, 1) X(ost_remove_blocks, 2)
/* clang-format on */

enum { OST_CL_SPARES = 8 };

enum ost_cl_kernel {
#define OST_CL_KERNEL_ENUM(name, sets) OST_CL_KERNEL_##name,
    OST_CL_KERNELS(OST_CL_KERNEL_ENUM)
#undef OST_CL_KERNEL_ENUM
    OST_CL_KERNEL_COUNT
};

/* X(path, sets, name): what the host does in one of several ways; counted where it is done, for core/paths.h. */
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
    bool gl;          /* shares with a context of OpenGL */
    bool cpu_set;     /* the kernels are those for CPUs, else those for GPUs */
    size_t workgroup; /* work items of a group, 0: default */
    size_t staging;   /* as in ost_cl_options */
    unsigned order;   /* likewise */
    uint32_t turns;   /* of a work item's loops; OST_CL_TURNS: no end was seen */
    int run;          /* voxels of a row that a work item of ost_cubic_gather copies */
    cl_context context;
    cl_command_queue queue;
    struct {
        cl_mem buffer;
        size_t bytes;
    } spare[OST_CL_SPARES]; /* owned; freed, and kept for the next that is about as large (room.c); NULL: none */
    cl_program program;
    cl_kernel kernel[OST_CL_KERNEL_COUNT];
    size_t kernel_workgroup[OST_CL_KERNEL_COUNT]; /* what each can have at most */
    bool from_cache;                              /* whether the program's binary was found */
    ost_digest empty_leaf;
    uint64_t launched[OST_CL_KERNEL_COUNT]; /* how often each was, but for an event that meets nothing */
    uint64_t entered[OST_CL_PATH_COUNT];
    struct ost_cl_event_scratch *event; /* owned; what events reuse, NULL before the first (remove.c) */
} cl_backend;

/* ------------------------------------------------------------- context.c */

/* Opens and checks one device; *out is NULL on failure, with the reason in err. gl: to share with (share.h), or NULL. */
struct ost_cl_gl;
ost_status ost_cl_device_open(const ost_cl_api *cl, const ost_cl_device *device, const struct ost_cl_gl *gl, const ost_cl_options *options,
                              cl_backend **out, ost_error *err);
void ost_cl_device_close(cl_backend *backend);
/* The smaller of a stage's own limit of bytes and the option staging. */
size_t ost_cl_staging(const cl_backend *backend, size_t limit);
/* The slot paths: the kernels of the opened set, and OST_CL_PATHS. */
void ost_cl_paths(const ost_backend *backend, ost_path_visit *visit, void *user);

/* What cl.c's slots do, with another table than the loader's. */
ost_status ost_cl_open_with(const ost_cl_api *cl, const char *options, ost_backend **out, ost_error *err);
bool ost_cl_available_with(const ost_cl_api *cl, char *reason, size_t size);
ost_status ost_cl_visit_with(const ost_cl_api *cl, ost_device_visit *visit, void *user, ost_error *err);

/* ------------------------------------------------------------- program.c */

/* Builds for the backend's device; *from_cache says whether the cache had it. */
ost_status ost_cl_build(cl_backend *backend, const char *const *sources, size_t count, const char *options, cl_program *out,
                        bool *from_cache, ost_error *err);

/* ----------------------------------------------------------------- key.c */

struct ost_cl_cache;
ost_status ost_cl_key(const ost_cl_device *device, const char *const *sources, size_t count, const char *options,
                      struct ost_cl_cache *cache, ost_error *err);

/* --------------------------------------------------- layout.c, fingerprint.c */

ost_status ost_cl_layout_check(cl_backend *backend, ost_error *err);

/* OST_ERR_UNAVAILABLE, naming the device and what is wrong, when its integers are not the host's or its loops end too early. Sets
   backend->turns. */
ost_status ost_cl_fingerprint_check(cl_backend *backend, ost_error *err);
/* For the record: what its floating point does; one line. */
void ost_cl_fingerprint_floats(cl_backend *backend, char *notes, size_t size);

/* -------------------------------------------------------------- launch.c */

/* Uninitialised when data is NULL, else a copy of it, made before this returns; bytes 0 gives a buffer of 1. */
ost_status ost_cl_buffer(cl_backend *backend, size_t bytes, const void *data, const char *what, cl_mem *out, ost_error *err);
/* Filled with zeros. */
ost_status ost_cl_buffer_zero(cl_backend *backend, size_t bytes, const char *what, cl_mem *out, ost_error *err);
void ost_cl_buffer_free(cl_backend *backend, cl_mem *buffer); /* sets it to NULL; NULL is allowed */
ost_status ost_cl_zero(cl_backend *backend, cl_mem buffer, size_t offset, size_t bytes, ost_error *err);
/* The data may be used again when these return. */
ost_status ost_cl_write(cl_backend *backend, cl_mem buffer, size_t offset, size_t bytes, const void *data, ost_error *err);
ost_status ost_cl_read(cl_backend *backend, cl_mem buffer, size_t offset, size_t bytes, void *data, ost_error *err);
/* Here not before the next call that waits. */
ost_status ost_cl_write_later(cl_backend *backend, cl_mem buffer, size_t bytes, const void *data, ost_error *err);
ost_status ost_cl_copy(cl_backend *backend, cl_mem from, cl_mem to, size_t bytes, ost_error *err);
/* Waits for all of the queue. */
ost_status ost_cl_finish(cl_backend *backend, ost_error *err);

/* ---------------------------------------------------------------- room.c */

/* A buffer of at least that size, *room in truth, with whatever is in it; large ones are used again. */
ost_status ost_cl_room_take(cl_backend *backend, size_t bytes, const char *what, cl_mem *out, size_t *room, ost_error *err);
void ost_cl_room_give(cl_backend *backend, cl_mem *buffer, size_t room); /* sets it to NULL; NULL is allowed */
/* Gives all of it back to the driver; whether there was any. */
bool ost_cl_room_clear(cl_backend *backend);

/* One argument of a kernel. */
typedef struct ost_cl_arg {
    size_t size;
    const void *value;
} ost_cl_arg;
#define OST_CL_ARG(value) ((ost_cl_arg){sizeof(value), &(value)})

/* Range x * y * z, rounded up along x to whole work groups; nothing happens when one is 0. */
ost_status ost_cl_launch(cl_backend *backend, enum ost_cl_kernel kernel, size_t x, size_t y, size_t z, const ost_cl_arg *args,
                         unsigned count, ost_error *err);
#define OST_CL_LAUNCH(backend, kernel, x, y, z, err, ...)                                                   \
    ost_cl_launch(backend, OST_CL_KERNEL_##kernel, x, y, z, (const ost_cl_arg[]){__VA_ARGS__},              \
                  sizeof((const ost_cl_arg[]){__VA_ARGS__}) / sizeof(ost_cl_arg), err)

#endif
