/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Plugins: external implementations of the stages, loaded at run time.
 *
 *   osteon ... --backend plugin:./mine.so,KEY=VALUE
 *
 *   host                                             mine.so
 *   load the file, find ost_plugin_entry  ------->   its table, checked slot by slot
 *   open(options, host)                   ------->   an instance
 *   grids, bones, tools, events           ------->   one slot per stage, as in backend.h
 *   reports, error messages               <-------
 *
 * This header is the only file of osteon that a plugin needs: a plugin is not
 * linked to the library, and all types here are plain C.  docs/spec/arithmetic.md
 * defines the results of the stages; the names of its rules begin with AR-.
 * examples/plugin contains a complete plugin, in C and in OpenCL.
 *
 * Binary interface. OST_PLUGIN_ABI is the version number of the interface; the host rejects a table
 * with a different number. Every struct begins with its size in bytes. This is the size in the
 * version of this header with which the writer of the struct was compiled. Later versions only add
 * members at the end. Code that reads a struct accesses a member only if the struct's `size`
 * includes the member. All integers are little-endian and naturally aligned (LP64). Consecutive
 * structs in an array are `stride` bytes apart.
 *
 * Threads.  The host makes one call at a time to an instance and its objects, but
 * not always on the same thread.  A plugin may create threads; they must not call
 * the host after a slot has returned.  The file remains loaded until the process
 * ends.
 *
 * Lifetimes. The arguments of a slot are valid until the slot returns; the plugin must
 * copy any data that it uses later. The host owns the objects that slots create, and
 * frees each object with the matching free slot before it calls close.
 *
 * Errors. A slot returns an ost_plugin_status and, unless this is OST_PLUGIN_OK, writes
 * one line of text for the user to error->text. A slot that fails must leave all
 * objects unchanged. If it may have changed an object, it returns OST_PLUGIN_LOST, and
 * the host does not use the object again. No exception and no longjmp may leave a slot.
 * The host checks the statuses, objects, chunk numbers and reports that it receives,
 * and treats invalid ones as errors. A plugin that writes beyond the bounds of its
 * arguments can crash the process, so `osteon validate` runs each backend in a process
 * of its own.
 */
#ifndef OSTEON_PLUGIN_H
#define OSTEON_PLUGIN_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined __GNUC__
#define OST_PLUGIN_EXPORT __attribute__((visibility("default")))
#else
#define OST_PLUGIN_EXPORT
#endif

#define OST_PLUGIN_ABI 2

/* The status that a slot returns. Every slot that can fail returns a status as int32_t. */
typedef enum ost_plugin_status {
    OST_PLUGIN_OK = 0,
    OST_PLUGIN_USAGE = 1,       /* options or arguments are wrong */
    OST_PLUGIN_RANGE = 2,       /* a value is beyond the limits of this plugin */
    OST_PLUGIN_MEMORY = 3,
    /* The device does not exist, or the plugin was built without support for it. The error text states what must be
     * installed. */
    OST_PLUGIN_UNAVAILABLE = 4,
    OST_PLUGIN_FAILED = 5,      /* any other failure; no object has changed */
    OST_PLUGIN_LOST = 6         /* the content of the object is unknown from this time on */
} ost_plugin_status;

/* Memory for the text of an error, provided by the host. */
typedef struct ost_plugin_error {
    uint32_t size;
    uint32_t text_size; /* size of `text` in bytes, including the NUL */
    char *text;         /* one line of text; empty before the call */
} ost_plugin_error;

/*
 * A dense grid. Lengths are exact, in picometres (10^-9 mm).
 * Voxel (i, j, k) is element i + dims[0] * (j + dims[1] * k).
 */
typedef struct ost_plugin_geometry {
    uint32_t size;
    int32_t dims[3];
    int64_t spacing_pm[3];
    int64_t origin_pm[3]; /* centre of voxel (0, 0, 0) */
} ost_plugin_geometry;

/* The grid of a tool. The centre of voxel (i, j, k) is corner + (i + 1/2, j + 1/2, k + 1/2) * voxel (AR-TOOL). */
typedef struct ost_plugin_tool_geometry {
    uint32_t size;
    int32_t dims[3];
    int64_t voxel_pm;
    int64_t corner_pm[3];
} ost_plugin_tool_geometry;

/* ---------------------------------------------------------------- import */

/* A sample of a CT. */
typedef struct ost_plugin_sample { /* the layout of this struct and its size of 32 bytes never change */
    int64_t x_pm, y_pm, z_pm;
    int32_t density;
    uint32_t line; /* line number of the sample minus first_line of the batch */
} ost_plugin_sample;

/* A batch of samples. */
typedef struct ost_plugin_samples {
    uint32_t size;
    int32_t duplicates; /* rule for voxels with several samples: 0 error, 1 first, 2 last, 3 max (AR-CT-6) */
    uint64_t count;
    int64_t first_line;
    const ost_plugin_sample *sample;
} ost_plugin_samples;

/*
 * The results of ct_to_rect; see ost_scatter_report in backend.h. On entry, the struct contains the results of the
 * previous batches. On return, it also includes this batch.
 */
typedef struct ost_plugin_scatter_report {
    uint32_t size;
    int16_t conflict_had, conflict_has;
    uint64_t samples, duplicates, off_lattice, worst_offset_ppm;
    int64_t worst_line, rejected_line, conflict_line; /* line numbers; 0 means that there is no such line */
} ost_plugin_scatter_report;

/* ----------------------------------------------------------------- tools */

/*
 * A mesh with integer vertices. The unit is voxel / 2^fraction_bits, and the origin is the corner of the tool's
 * grid (AR-MESH).
 */
typedef struct ost_plugin_mesh {
    uint32_t size;
    int32_t fraction_bits;
    uint64_t vertex_count, triangle_count;
    const int32_t *vertices;   /* x, y, z of each vertex */
    const uint32_t *triangles; /* three vertices of each triangle, counter-clockwise as seen from outside */
} ost_plugin_mesh;

/* The counts of a voxelization; see ost_voxelize_report in backend.h. */
typedef struct ost_plugin_voxelize_report {
    uint32_t size;
    uint32_t reserved;
    uint64_t solid_voxels, cutting_voxels, leaking_rows;
} ost_plugin_voxelize_report;

/* ---------------------------------------------------------------- events */

/* A 128-bit integer in two's complement: high * 2^64 + low. */
typedef struct ost_plugin_int128 {
    uint64_t low;
    int64_t high;
} ost_plugin_int128;

/*
 * The map from bone voxel (i, j, k) to tool coordinate a at one pose (AR-MAP), in three forms:
 *
 *   exact     (origin[a] + i column[0][a] + j column[1][a] + k column[2][a]) / divisor
 *             in units of 2^-20 tool voxel
 *   integer   base, which the host's block_base computes, and step; these integers define
 *             the result
 *   affine    affine[a][0] i + affine[a][1] j + affine[a][2] k + affine[a][3] in tool
 *             voxels; the doubles nearest to the exact map, for plugins that compute
 *             in floating point
 */
typedef struct ost_plugin_map {
    uint32_t size;
    int32_t step[3][3]; /* [bone axis][tool axis] */
    ost_plugin_int128 origin[3], column[3][3], divisor;
    double affine[3][4];
    int32_t box_lo[3], box_hi[3]; /* no bone voxel outside [box_lo, box_hi) is inside the tool's grid at this pose */
} ost_plugin_map;

/* An event: the maps of its poses and the density classes (AR-REM). */
typedef struct ost_plugin_event {
    uint32_t size;
    int32_t map_count; /* number of poses of the sweep, >= 1 */
    uint64_t stride;   /* bytes from one map to the next */
    const ost_plugin_map *maps;
    int32_t class_count;      /* 1 to 8 */
    /*
     * Borders of the classes. A voxel belongs to the last class whose border is at most the voxel's density. If
     * there is no such class, it belongs to class 0.
     */
    const int16_t *class_from;
} ost_plugin_event;

/*
 * A mesh as read from a file. It is the input of the `snap` slot. This struct and the three following structs are
 * inputs and results of the steps that precede the work on voxels. They are used only by plugins that execute these
 * steps themselves, in the slots `snap` and `steps`.
 */
typedef struct ost_plugin_raw_mesh {
    uint32_t size;
    uint32_t reserved;
    uint64_t vertex_count, triangle_count;
    const int64_t *vertices_pm; /* x, y, z of each vertex */
    const uint32_t *triangles;  /* three vertices of each triangle */
} ost_plugin_raw_mesh;

/* A snapped mesh (AR-MESH-3), in memory provided by the host. */
typedef struct ost_plugin_snapped {
    uint32_t size;
    int32_t fraction_bits;
    uint64_t triangle_count; /* number of triangles that were not dropped */
    int32_t *vertices;       /* zero-filled memory for all vertices */
    uint32_t *triangles;     /* memory for all triangles */
} ost_plugin_snapped;

/* A pose: quaternion and translation (AR-POSE). */
typedef struct ost_plugin_pose {
    uint32_t size;
    int32_t q[4]; /* w, x, y, z in units of 2^-30 */
    int64_t t_pm[3];
} ost_plugin_pose;

/*
 * The input of the `steps` slot. In the maps that the slot passes to the function `add`, only the members `divisor`,
 * `origin`, `column` and `step` must be set. From these members, the host's function block_base computes the base of a
 * block.
 */
typedef struct ost_plugin_steps {
    uint32_t size;
    uint32_t reserved;
    const ost_plugin_geometry *bone;
    const ost_plugin_tool_geometry *tool;
    const ost_plugin_pose *from; /* start of the sweep; NULL if `to` is the only pose of the event */
    const ost_plugin_pose *to;
    void *sink;
    /*
     * Receives a pose and its map. If the function does not return OST_PLUGIN_OK, the slot stops and returns the
     * function's value.
     */
    int32_t (*add)(void *sink, const ost_plugin_pose *pose, const ost_plugin_map *map);
} ost_plugin_steps;

/*
 * The report of an event.  The slot calls `add` once for each chunk with a removed voxel, in ascending order of chunk
 * numbers, and then sets `touched_voxels`.
 */
typedef struct ost_plugin_report {
    uint32_t size;
    uint32_t reserved;
    void *sink;
    /*
     * Receives the counts of one chunk. `voxels` contains class_count counts, and `density` contains class_count
     * sums. If the function does not return OST_PLUGIN_OK, the slot stops and returns the function's value.
     */
    int32_t (*add)(void *sink, int32_t chunk, const uint32_t *voxels, const int64_t *density);
    uint64_t touched_voxels; /* number of active voxels covered by non-cutting tool voxels only */
} ost_plugin_report;

/* The counts of a bone; see ost_bone_info in backend.h. */
typedef struct ost_plugin_bone_stats {
    uint32_t size;
    uint32_t reserved;
    int64_t active_chunks, active_voxels, chunk_bytes, resident_bytes;
} ost_plugin_bone_stats;

/*
 * The rule for resampling the rect grid to the cubic grid (AR-CUB-2 to 4). The enumeration was added in version 2
 * of the interface.
 */
typedef enum ost_plugin_resample {
    OST_PLUGIN_LINEAR = 0,
    OST_PLUGIN_NEAREST = 1,
    OST_PLUGIN_THESIS = 2
} ost_plugin_resample;

/* ------------------------------------------------------------------ host */

/* Functions and values that the host provides. They are valid until the plugin is closed. */
typedef struct ost_plugin_host {
    uint32_t size;
    uint32_t abi;
    int32_t arithmetic;  /* version of docs/spec/arithmetic.md that the host implements */
    uint32_t reserved;
    const char *version; /* version of osteon */
    /*
     * Computes the base of a block of 16^3 voxels (AR-MAP-5). The first voxel of the block has the indices 16
     * block[0], 16 block[1] and 16 block[2]. Returns 0 without setting `base` if no voxel of the block can be
     * inside the tool's grid.
     */
    int32_t (*block_base)(const ost_plugin_map *map, const int32_t block[3], int32_t base[3]);
} ost_plugin_host;

/* ----------------------------------------------------------------- table */

typedef struct ost_plugin_instance ost_plugin_instance;
typedef struct ost_plugin_grid ost_plugin_grid; /* a dense int16 grid */
typedef struct ost_plugin_bone ost_plugin_bone; /* a chunk grid */
typedef struct ost_plugin_tool ost_plugin_tool; /* a tool grid: 0 empty, 1 cutting, 2 not cutting */

/*
 * The table of a plugin. Only the last two slots may be NULL. Before a call, the host checks that
 * the arguments are within the ranges of backend.h and grid.h.
 */
typedef struct ost_plugin {
    uint32_t size;
    uint32_t abi;            /* OST_PLUGIN_ABI */
    int32_t arithmetic; /* version of docs/spec/arithmetic.md that the plugin implements; 0 if it implements none */
    uint32_t reserved;
    const char *name;        /* one line, for example "mine 1.2" */
    const char *description; /* one sentence */

    /* Creates an instance. `options` is the text after the file name and the comma; it may be "". */
    int32_t (*open)(const char *options, const ost_plugin_host *host, ost_plugin_instance **out,
                    ost_plugin_error *error);
    void (*close)(ost_plugin_instance *self);
    /*
     * Waits until the work of all previous calls is complete. Returns the error of work that failed after its slot had
     * returned.
     */
    int32_t (*finish)(ost_plugin_instance *self, ost_plugin_error *error);

    /* A new grid is filled with 0. An upload or download copies the slices z0 <= k < z0 + count. */
    int32_t (*grid_create)(ost_plugin_instance *self, const ost_plugin_geometry *geometry, ost_plugin_grid **out,
                           ost_plugin_error *error);
    void (*grid_free)(ost_plugin_grid *grid);
    int32_t (*grid_upload)(ost_plugin_grid *grid, int32_t z0, int32_t count, const int16_t *voxels,
                           ost_plugin_error *error);
    int32_t (*grid_download)(const ost_plugin_grid *grid, int32_t z0, int32_t count, int16_t *voxels,
                             ost_plugin_error *error);

    /* Scatters samples into a rect grid (AR-CT-4 to 6; thesis, Alg. 2.4). */
    int32_t (*ct_to_rect)(ost_plugin_grid *rect, const ost_plugin_samples *samples, ost_plugin_scatter_report *report,
                          ost_plugin_error *error);
    /* Resamples a rect grid to a new grid with the given geometry (AR-CUB; Alg. 2.5). `rule` is an
     * ost_plugin_resample. */
    int32_t (*rect_to_cubic)(const ost_plugin_grid *rect, const ost_plugin_geometry *cubic, int32_t rule,
                             ost_plugin_grid **out, ost_plugin_error *error);
    /* Creates a bone from a cubic grid (AR-CHK; Alg. 2.6). */
    int32_t (*cubic_to_chunks)(const ost_plugin_grid *cubic, int32_t chunk_size, int32_t threshold,
                               ost_plugin_bone **out, ost_plugin_error *error);

    /*
     * A new bone has no active voxels. If a bone is uploaded, densities below the threshold become 0. The slices
     * have no padding.
     */
    int32_t (*bone_create)(ost_plugin_instance *self, const ost_plugin_geometry *geometry, int32_t chunk_size,
                           int32_t threshold, ost_plugin_bone **out, ost_plugin_error *error);
    void (*bone_free)(ost_plugin_bone *bone);
    int32_t (*bone_stats)(const ost_plugin_bone *bone, ost_plugin_bone_stats *stats, ost_plugin_error *error);
    int32_t (*bone_upload)(ost_plugin_bone *bone, int32_t z0, int32_t count, const int16_t *voxels,
                           ost_plugin_error *error);
    int32_t (*bone_download)(const ost_plugin_bone *bone, int32_t z0, int32_t count, int16_t *voxels,
                             ost_plugin_error *error);

    /*
     * Voxelizes a tool (AR-VOX; Alg. 2.1 and section 2.3). noncutting may be NULL. `parity` selects the fill rule:
     * 0 is winding, 1 is parity.
     */
    int32_t (*voxelize)(ost_plugin_instance *self, const ost_plugin_tool_geometry *geometry,
                        const ost_plugin_mesh *cutting, const ost_plugin_mesh *noncutting, int32_t parity,
                        ost_plugin_voxelize_report *report, ost_plugin_tool **out, ost_plugin_error *error);
    int32_t (*tool_upload)(ost_plugin_instance *self, const ost_plugin_tool_geometry *geometry, const uint8_t *voxels,
                           ost_plugin_tool **out, ost_plugin_error *error);
    int32_t (*tool_download)(const ost_plugin_tool *tool, uint8_t *voxels, ost_plugin_error *error);
    void (*tool_free)(ost_plugin_tool *tool);

    /*
     * Executes an event (AR-REM; Algs. 2.8 to 2.10). `collide` produces the same report as `remove` but does not change
     * the bone.
     */
    int32_t (*remove)(ost_plugin_bone *bone, const ost_plugin_tool *tool, const ost_plugin_event *event,
                      ost_plugin_report *report, ost_plugin_error *error);
    int32_t (*collide)(const ost_plugin_bone *bone, const ost_plugin_tool *tool, const ost_plugin_event *event,
                       ost_plugin_report *report, ost_plugin_error *error);

    /*
     * The two slots below execute the steps that precede the work on voxels. A plugin that executes these steps
     * itself sets the two slots. If a slot is NULL or beyond the size of the table, the host executes the step and
     * passes the results to the plugin. `osteon validate` calls these slots in every case and compares their
     * results bit by bit with the results of the host (stages `snap` and `steps`). The verdict of `osteon validate`
     * states which of these two steps the plugin executed itself.
     */
    /*
     * Snaps a mesh (AR-MESH-3, AR-MESH-4) and writes the result to *made. Triangles that are not dropped keep their
     * order.
     */
    int32_t (*snap)(ost_plugin_instance *self, const ost_plugin_tool_geometry *geometry,
                    const ost_plugin_raw_mesh *mesh, ost_plugin_snapped *made, ost_plugin_error *error);
    /*
     * Computes the poses and maps of an event (AR-SWEEP-1 to 4, AR-MAP-1 to 3). Calls in->add once for each pose,
     * in order. An error that the slot itself detects must be returned before the first call of in->add.
     */
    int32_t (*steps)(ost_plugin_instance *self, const ost_plugin_steps *in, ost_plugin_error *error);
} ost_plugin;

/*
 * The type of the symbol that the host loads. host_abi is the OST_PLUGIN_ABI of the host. Returns the table, or
 * NULL if the plugin does not support this version of the interface.
 */
typedef const ost_plugin *ost_plugin_entry_function(uint32_t host_abi);
#define OST_PLUGIN_ENTRY "ost_plugin_entry"

#ifdef __cplusplus
}
#endif
#endif
