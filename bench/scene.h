/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The thesis' static events (Figs. 3.6 and 3.7). The tools are placed so that they collide with as many
 * chunks of 16^3, 32^3 and 64^3 voxels as in Tables 3.3 and 3.4.
 *
 *   bone      128^3 voxels of 0.47 mm, all of them active
 *   reamer    the parametric head, in a corner of the bone; the oriented box of
 *             its grid enters 84, 18 and 5 chunks
 *   peg       the parametric cylinder, tilted inside the bone; its intersection box
 *             (Alg. 2.9) has 80 = 5*4*4, 18 = 3*3*2 and 8 = 2*2*2 chunks
 *
 * The thesis gives no poses. The poses in scene.c were found by random search. The number of chunks in
 * an intersection box is a product of three numbers, one per axis. No intersection box of the reamer's
 * size consists of exactly 84 or 5 chunks. For the reamer, therefore, only the chunks that its oriented
 * box enters are counted.
 * The counts are computed again in every run and reported with the row.
 */
#ifndef OST_BENCH_SCENE_H
#define OST_BENCH_SCENE_H

#include "bench/baseline.h"
#include "bench/bench.h"

#include <osteon/phantom.h>
#include <osteon/sim.h>

enum { SCENE_THRESHOLD = 120, SCENE_SIDE = 128 };
#define SCENE_SPACING (47 * OST_PM_PER_MM / 100)

typedef struct bench_scene {
    const char *tool_name;
    ost_tool_volume tool; /* owned */
    ost_geometry bone;
    ost_density_classes classes;
    ost_pose pose;
    /* true if the event processes all chunks of the intersection box; false if it processes only the chunks that the
       tool's oriented box enters */
    bool by_range;
    ost_map map;
    ost_voxel_box box;
    /* contains pointers to `map` and `box`, so the scene must not move in memory */
    ost_removal_event event;
} bench_scene;

/* Creates a scene. The bone has `side` voxels along each axis. The position of the event relative to the bone's far
   corner is the same for every `side`. */
ost_status bench_scene_init(bench_scene *scene, ost_tool_kind kind, ost_pm tool_voxel, int32_t side, ost_error *err);
/* Creates the same scene as bench_scene_init, but voxelizes the tool on the backend that the string `backend` selects.
   All backends compute the same tool. The reference is slow for tools of many voxels. */
ost_status bench_scene_init_by(bench_scene *scene, const char *backend, ost_tool_kind kind, ost_pm tool_voxel,
                               int32_t side, ost_error *err);
/* Moves the tool to a pose. */
ost_status bench_scene_set_pose(bench_scene *scene, const ost_pose *pose, ost_error *err);
void bench_scene_free(bench_scene *scene);

/* Returns the slices z0 <= z < z0 + count of the full bone. Returns NULL if memory is exhausted. The caller frees the
   slices with free. */
int16_t *bench_scene_slices(const bench_scene *scene, int32_t z0, int32_t count);

/* Creates the full bone on a backend. */
ost_status bench_scene_bone(const bench_scene *scene, ost_backend *backend, int chunk_size, ost_bone **out,
                            ost_error *err);

/* Lists the first voxels of the chunks that the event processes, and returns the number of these chunks.
   `corners` may be NULL. A chunk has chunk_size^3 voxels. */
int bench_scene_chunks(const bench_scene *scene, int32_t chunk_size, int32_t (*corners)[3]);

/* A removal event for the thesis' kernel, on separate copies of the chunks. */
typedef struct bench_thesis {
    bench_thesis_event event;
    int16_t *tool;        /* owned, like the pointers below */
    /* densities of all chunks: `full` contains those before the event; `live` is a copy that the event modifies */
    int16_t *full, *live;
    int16_t **chunks;
    int32_t (*corners)[3];
    size_t bytes;
} bench_thesis;

/* Selects the chunks of the event, copies them from the full bone, and converts the map to floats. */
ost_status bench_thesis_init(bench_thesis *thesis, const bench_scene *scene, int chunk_size, ost_error *err);
void bench_thesis_restore(bench_thesis *thesis);
void bench_thesis_free(bench_thesis *thesis);
/* Compares the event's chunks with `voxels`, the voxels of a complete bone. Returns the number of
   voxels whose densities differ. */
int64_t bench_thesis_differs(const bench_thesis *thesis, const bench_scene *scene, const int16_t *voxels);


/* Counts of the rows and bricks that every method must write in an event, and a list of these rows. They are found in
   the chunks that the thesis' kernel has modified. */
typedef struct bench_work {
    /* number of changed rows of 32 densities (one cache line); 0 unless chunks have 32^3 voxels */
    int64_t changed_rows;
    /* number of bricks in which all 4^3 voxels were removed, and number of bricks in which only some were removed */
    int64_t complete_bricks, mixed_bricks;
    bench_row_store *rows;               /* owned */
} bench_work;

ost_status bench_work_count(bench_work *work, const bench_thesis *thesis, ost_error *err);

#endif
