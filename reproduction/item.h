/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The tables and figures of the thesis that `osteon reproduce` reproduces. An item is a function that measures, counts
 * or draws, and fills a result:
 *
 *   items[] --run(setting)--> result --write.h--> files
 *                 |
 *                 '-- models (models.h), events (bench/scene.h), views (render/)
 *
 * Tables and figures that are not reproduced are listed in reproduction_missing, each with the reason.
 */
#ifndef OST_REPRODUCTION_ITEM_H
#define OST_REPRODUCTION_ITEM_H

#include "bench/bench.h"
#include "bench/voxel_methods.h"
#include "reproduction/methods/methods.h"
#include "reproduction/models.h"
#include "reproduction/result.h"

enum { REPRODUCTION_MODELS = 5 }; /* number of models whose frames are timed */

/* The settings of a run and the measurements that its items share. */
typedef struct reproduction {
    bench_options bench;    /* only the members backend, threads and quick are used; show and filter are ignored */
    result_machine machine;
    model_store models;
    char cl[64];            /* device for backend cl, such as "cl:platform=0,device=0"; "" for other backends */
    /* measurements shared by several items; filled by the first item that needs them */
    methods_table by_chunks, by_resolution;
    bench_voxel_frames frames[REPRODUCTION_MODELS][BENCH_VOXEL_METHODS];
    bool frames_measured[REPRODUCTION_MODELS];
    ost_progress *progress; /* progress callback; may be NULL */
    void *progress_user;
} reproduction;

typedef enum reproduction_kind {
    REPRODUCTION_TIMES,   /* times, which differ from machine to machine */
    REPRODUCTION_COUNTS,  /* counts and lengths, which are equal on every machine */
    REPRODUCTION_PICTURES /* pictures, which are equal on every machine */
} reproduction_kind;
extern const char *const reproduction_kind_names[3];

typedef struct reproduction_item {
    const char *id;    /* "table-3.3" */
    const char *title; /* caption; worded differently from the thesis */
    reproduction_kind kind;
    ost_status (*run)(reproduction *r, result *out, ost_error *err);
} reproduction_item;

/* The items in the order of the thesis; the last element has the id NULL. */
extern const reproduction_item reproduction_items[];

typedef struct reproduction_absent {
    const char *id, *title, *reason;
} reproduction_absent;
/* The tables and figures of the thesis that are not reproduced; the last element has the id NULL. */
extern const reproduction_absent reproduction_missing[];

/* Returns the item with a name such as "table-3.3", "Table 3.3" or "fig-3.10", or with a number such as "3.10". Returns
   NULL if no item has this name or number, or if more than one item has this number. */
const reproduction_item *reproduction_find(const char *name);

/* Reads the user's CTs, and describes this machine and the settings in r->machine. Returns an error if a CT cannot be
   read or the backend cannot be opened. */
ost_status reproduction_begin(reproduction *r, ost_error *err);
void reproduction_end(reproduction *r);

/* Calls the progress callback of r, if there is one. `share` is the fraction of the work that is completed. */
void reproduction_show(const reproduction *r, const char *stage, double share);

/* The functions of the items. Each file in items/ defines one or several of them. */
ost_status item_model_grids(reproduction *r, result *out, ost_error *err);
ost_status item_model_chunks(reproduction *r, result *out, ost_error *err);
ost_status item_model_memory(reproduction *r, result *out, ost_error *err);
ost_status item_active_ratio(reproduction *r, result *out, ost_error *err);
ost_status item_voxelize(reproduction *r, result *out, ost_error *err);
ost_status item_import(reproduction *r, result *out, ost_error *err);
ost_status item_event_reamer(reproduction *r, result *out, ost_error *err);
ost_status item_event_peg(reproduction *r, result *out, ost_error *err);
ost_status item_tool_voxels(reproduction *r, result *out, ost_error *err);
ost_status item_machines(reproduction *r, result *out, ost_error *err);
ost_status item_static_reamer(reproduction *r, result *out, ost_error *err);
ost_status item_static_peg(reproduction *r, result *out, ost_error *err);
ost_status item_accuracy(reproduction *r, result *out, ost_error *err);
ost_status item_chunk_counts(reproduction *r, result *out, ost_error *err);
ost_status item_voxel_counts(reproduction *r, result *out, ost_error *err);
ost_status item_reza(reproduction *r, result *out, ost_error *err);
ost_status item_zheng(reproduction *r, result *out, ost_error *err);
ost_status item_yau(reproduction *r, result *out, ost_error *err);
ost_status item_holes(reproduction *r, result *out, ost_error *err);
ost_status item_render_memory(reproduction *r, result *out, ost_error *err);
ost_status item_mesh_stages(reproduction *r, result *out, ost_error *err);
ost_status item_mesh_frames(reproduction *r, result *out, ost_error *err);
ost_status item_point_frames(reproduction *r, result *out, ost_error *err);
ost_status item_foam_frames(reproduction *r, result *out, ost_error *err);
ost_status item_removal_frames(reproduction *r, result *out, ost_error *err);
ost_status item_scapula(reproduction *r, result *out, ost_error *err);
ost_status item_samples(reproduction *r, result *out, ost_error *err);
ost_status item_partition(reproduction *r, result *out, ost_error *err);
ost_status item_cubic(reproduction *r, result *out, ost_error *err);
ost_status item_boxes(reproduction *r, result *out, ost_error *err);
ost_status item_active_chunks(reproduction *r, result *out, ost_error *err);
ost_status item_bone_to_tool(reproduction *r, result *out, ost_error *err);
ost_status item_tool_to_bone(reproduction *r, result *out, ost_error *err);
ost_status item_removal(reproduction *r, result *out, ost_error *err);

#endif
