/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The interface that each method implements, and the declarations that the methods share.
 *
 *   methods_scene --open--> state: the method's own bone and tool
 *                            |  restore   the bone's voxels of the region; loads the event's data into the caches
 *                            |  remove    the event; this call alone is timed
 *                            |  result    the set of removed voxels
 *                            v  close
 *
 * The event of a scene can change only voxels in the scene's region, so restore and result process only these voxels. A
 * method stores its bone in one buffer, in a list or in a tree, as described in its publication.
 *
 * The files of the methods on the processor are compiled for the machine that builds them
 * (BENCH_CFLAGS); method_open refuses them on a processor that lacks an instruction set.
 */
#ifndef OST_REPRODUCTION_METHODS_METHOD_H
#define OST_REPRODUCTION_METHODS_METHOD_H

#include "bench/scene.h"
#include "reproduction/methods/methods.h"

/* -------------------------------------------------------------------- scene */

/* A bone, a tool and a pose. A scene must not be moved in memory after its initialization. */
typedef struct methods_scene {
    bench_scene event;    /* tool, geometry of the bone, pose, map, box of voxels */
    int16_t *voxels;      /* owned; the bone's densities, x fastest; 0 or at least SCENE_THRESHOLD */
    ost_voxel_box region; /* the event's box, enlarged by one voxel on each side and limited to the bone */
} methods_scene;

/*
 * Makes the static event of a tool (bench/scene.h). The bone's box has the edge length of 128 voxels of 0.47 mm
 * and is divided into bone_side^3 voxels. The box and the tool's position in the box are the same for every bone_side.
 */
ost_status methods_scene_static(methods_scene *scene, ost_tool_kind tool, ost_pm tool_voxel, int32_t bone_side,
                                ost_error *err);
/*
 * Makes a scene with the tool in the middle of a bone of bone_side^3 voxels. If chunk_count is not 0, only chunk_count
 * chunks of chunk_size^3 voxels have active voxels. They are the chunks closest to the middle of the event's box, and
 * only they belong to the event. Returns OST_ERR_RANGE if the tool's oriented box enters fewer chunks.
 */
ost_status methods_scene_middle(methods_scene *scene, ost_tool_kind tool, ost_pm tool_voxel, int32_t bone_side,
                                int chunk_size, int chunk_count, ost_error *err);
/* Makes only the event of methods_scene_middle, without a bone's voxels. The bone has 128^3 voxels of 0.47 mm. */
ost_status methods_middle_event(bench_scene *event, ost_tool_kind tool, ost_pm tool_voxel, ost_error *err);
/* Computes scene->region. The caller has already set the event and the voxels. */
void methods_scene_set_region(methods_scene *scene);
/* Frees the tool and the voxels. A zero-initialized scene may be freed. */
void methods_scene_free(methods_scene *scene);
/* Counts the chunks of the event that contain an active voxel. */
int methods_scene_active_chunks(const methods_scene *scene, int chunk_size);
/* Computes two sizes in bytes: *voxels for the densities of all chunks that contain an active voxel, and *table for a
   table with one pointer per chunk of the bone. */
void methods_scene_chunk_memory(const methods_scene *scene, int chunk_size, int64_t *voxels, int64_t *table);

/* --------------------------------------------------------------------- sets */

/* A set of bone voxels in a box, one byte per voxel, x fastest. */
typedef struct method_set {
    ost_voxel_box box;
    uint8_t *in; /* owned */
} method_set;

/* Makes an empty set. */
ost_status method_set_init(method_set *set, const ost_voxel_box *box, ost_error *err);
void method_set_free(method_set *set);
/* Returns the number of voxels of a box. */
size_t method_box_count(const ost_voxel_box *box);
/* Returns the index in the set of the first voxel of row (j, k). j and k are bone coordinates. */
size_t method_set_row(const method_set *set, int32_t j, int32_t k);

/* The differences between a set and the expected set. Both sets have the same box. */
typedef struct method_difference {
    int64_t expected, removed, missed, missed_inside, extra;
} method_difference;

void method_set_compare(const method_set *expected, const method_set *set, method_difference *out);
/* Adds the removed voxels to the set. They are active in the scene, but have the density 0 in `voxels`. This array
   contains the densities of the scene's region, which must be the set's box. */
void method_set_add_removed(method_set *set, const methods_scene *scene, const int16_t *voxels);
/* Returns true if the voxel at this index and its six neighbours all belong to the set. */
bool method_set_inside(const method_set *set, size_t index);

/* -------------------------------------------------------------- definitions */

struct method_points;
struct points_map;

/*
 * Each function adds to *set the voxels in the set's box that the method's definition requires. The functions are
 * simple, use one thread, and share no code with the methods. `voxels` contains the densities of the complete bone. If
 * it is NULL, all voxels are active.
 */
void method_define_bone_to_tool(method_set *set, const bench_scene *event, const int16_t *voxels);
void method_define_tool_to_bone(method_set *set, const struct method_points *points, const struct points_map *map,
                                ost_dims bone, const int16_t *voxels);
/*
 * Counts the differences between `set` and `expected`, the set of method_define_bone_to_tool. Ignores voxels whose
 * position in the tool's grid is close to a border of tool voxels, because rounding to floats explains the difference.
 */
int64_t method_beyond_floats(const method_set *expected, const method_set *set, const bench_scene *event);

/* --------------------------------------------------------------- the method */

struct method_device; /* device.h */

typedef struct method_setup {
    int chunk_size;
    int threads;
    methods_points points;
    const char *backend;          /* osteon's backend, without the number of threads */
    struct method_device *device; /* open device for the OpenCL methods; NULL if none */
} method_setup;

typedef struct method_work {
    int64_t visited;
    int64_t bone_bytes, index_bytes, tool_bytes;
} method_work;

typedef struct method {
    methods_info info;
    bool native; /* true if the code is compiled for the processor of the build machine */
    /* upper limit of the memory per voxel of the bone and per voxel of the tool, in bytes */
    double per_bone_voxel, per_tool_voxel;
    /* Copies the scene's bone and tool. The scene must outlive the state. */
    ost_status (*open)(const methods_scene *scene, const method_setup *setup, void **state, ost_error *err);
    void (*close)(void *state);
    ost_status (*restore)(void *state, ost_error *err);
    ost_status (*remove)(void *state, ost_error *err);
    /* Adds the removed voxels to *set, whose box is the scene's region. */
    ost_status (*result)(void *state, method_set *set, ost_error *err);
    /* Returns the work of the last event, and the method's memory. */
    void (*work)(void *state, method_work *work);
} method;

extern const method method_osteon, method_osteon_cl, method_thesis_chunks, method_thesis_chunks_cl, method_yau,
    method_yau_cl, method_zheng, method_zheng_cl, method_reza, method_reza_cl, method_dense_pair,
    method_single_buffer, method_sparse_buffer, method_octree, method_texture_cl;

/* Returns the method that methods_info_get(index) describes. */
const method *method_get(int index);
/* Returns the greatest number of bytes of memory that a method needs for a scene. */
double method_needs(const method *method, const methods_scene *scene);
/* Opens a method. Returns OST_ERR_UNAVAILABLE with the reason if this machine cannot run the method, and OST_ERR_MEMORY
   if the method needs more memory than is free. */
ost_status method_open(const method *method, const methods_scene *scene, const method_setup *setup, void **state,
                       ost_error *err);

#endif
