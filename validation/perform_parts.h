/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The state of one case that runs on one backend. Each stage has a file. The
 * stages run in the order of this list.
 *
 *   perform_before.c   another CT and another bone, before those of the case
 *   perform_import.c   samples -> rect -> cubic -> chunks
 *   perform_sample.c   densities and occupancy of the bone; a second bone made from its slices
 *   perform_tool.c     snapped meshes -> the tools' voxels
 *   perform_tick.c     ticks -> poses and maps, reports, changed leaves
 *   perform_record.c   records that several stages write
 *   perform_apart.c    the reference's results in place of the backend's own
 */
#ifndef OST_VALIDATION_PERFORM_PARTS_H
#define OST_VALIDATION_PERFORM_PARTS_H

#include "core/backend.h"
#include "sim/world.h"
#include "validation/compare.h"
#include "validation/dense/steps.h"
#include "validation/perform.h"
#include "validation/steps_make.h"

typedef struct performer {
    ost_backend *backend;
    const scene *s;
    trace_writer *w;
    uint32_t case_index;
    ost_bone *bone;
    ost_tool *tools[SCENE_TOOLS_MAX];
    ost_tool_geometry grids[SCENE_TOOLS_MAX];
    ost_world *world;
    ost_geometry geometry; /* geometry of the bone, for the computation of maps */
    ost_dims dims;
    int16_t *was, *is;    /* `was` is the bone in its last record, and `is` is the bone as it was last downloaded */
    ost_removal_report collided, removed;
    bool second;          /* true if the second implementation computes the steps in place of a world */
    bool light;           /* true if only the steps of the ticks are computed; used only if `second` is true */
    ost_path path;        /* the ticks of the case; the performer frees them if own_path is true */
    bool own_path;
    steps_history history; /* state of the second implementation; used only if `second` is true */
    ost_pose *made_poses;  /* owned; poses for a backend that computes them itself, OST_SWEEP_MAX elements */
    ost_map *made_maps;
    ost_map *maps;         /* owned; maps of an event if `second` is true, OST_SWEEP_MAX elements */
    ost_voxel_box *boxes;
    /* the member boxes_meet, and the range of chunks that the event must cover; used only if `second` is true */
    ost_step_result range;
    perform_watch *watch;
    void *user;
    const trace *given; /* the reference's trace if stages are compared apart (perform_apart), otherwise NULL */
    compare_range in_given;
    /* true if a sample of the CT was rejected or in conflict; the case then ends after the scatter report */
    bool refused;
    int16_t *right;     /* the reference's bone, for perform_apart */
} performer;

/* Returns true if the case has ticks but no bone. For such a case, only the steps of the ticks are computed. */
static inline bool perform_is_of_steps(const scene *s)
{
    return !s->sample_count && s->path.count;
}

/* Returns the index of voxel (x, y, z), x fastest. */
static inline size_t perform_at(ost_dims d, int32_t x, int32_t y, int32_t z)
{
    return (size_t)x + (size_t)d.x * ((size_t)y + (size_t)d.y * (size_t)z);
}

/* ---- perform_record.c */

/* Ends the open record, and calls p->watch if it is not NULL. */
ost_status perform_end_record(performer *p, trace_stage stage, uint32_t item, ost_error *err);
/* Writes an empty record in place of a stage that this case does not run. */
ost_status perform_record_nothing(performer *p, trace_stage stage, uint32_t item, ost_error *err);
/* Writes the counts of active chunks and voxels to the open record. */
void perform_record_counts(performer *p, const ost_bone_info *info);
/* Writes the digest of a bone into the open record, where it is compared as a result. */
void perform_record_digest(performer *p, const ost_digest *root);
/* Writes a record of the complete bone and copies the bone to p->was. If p->second is true, the second implementation
   computes the digest. If it is false, the backend computes it. */
ost_status perform_record_bone(performer *p, trace_stage stage, ost_error *err);

/* perform_apart.c: these functions do nothing if p->given is NULL. */

/* Replaces the content of a grid with the reference's result of this stage. */
ost_status perform_give_grid(const performer *p, trace_stage stage, ost_grid *grid, ost_error *err);
/* Replaces the content of the bone with that of the reference's bone. */
ost_status perform_give_bone(performer *p, ost_error *err);
/* Replaces tool i with the reference's tool i. */
ost_status perform_give_tool(performer *p, int i, const ost_tool_geometry *geometry, ost_error *err);
/* Overwrites slices [z0, z1) of the bone after tick i with those of the reference's bone, so that a difference does
   not affect later ticks. */
ost_status perform_give_tick(performer *p, uint32_t i, int32_t z0, int32_t z1, ost_error *err);

/* ---- perform_before.c: these functions write no records. They are called only if p->watch is NULL, because a
   watch function counts the backend's calls. */

/* Scatters the case's first samples into a grid with another lattice, before the case runs. */
ost_status perform_other_lattice(performer *p, ost_error *err);
/* Converts a small grid to chunks of another size, before the case runs. */
ost_status perform_other_chunks(performer *p, ost_error *err);
/* Collides tool i with a bone whose voxel size differs from that of the case's bone. */
ost_status perform_other_bone(performer *p, int i, ost_error *err);

/* ---- the stages */

/* Imports the CT into p->bone. Sets p->refused if a sample was rejected or conflicts with another. */
ost_status perform_import(performer *p, ost_error *err);
/* Samples the bone. Writes items 0 and 1 if `time` is 0 (after the import), and items 2 and 3 if `time` is 1 (at
   the end of the case). */
ost_status perform_sample(performer *p, uint32_t time, ost_error *err);
/* Copies the bone to a second bone by uploading its slices in parts. */
ost_status perform_upload(performer *p, ost_error *err);
/* Snaps the meshes of tool i and voxelizes them. */
ost_status perform_tool(performer *p, int i, ost_error *err);
/* Creates the state for the ticks: a world, or the second implementation's history and memory for an event. */
ost_status perform_begin_ticks(performer *p, ost_error *err);
/* Runs tick i. Records the tick's steps, its event and the changed leaves of the bone. */
ost_status perform_tick(performer *p, size_t i, ost_error *err);
/* Computes only the steps of tick i. The sweep begins at the previous tick if that tick has the same tool. */
ost_status perform_steps(performer *p, size_t i, ost_error *err);
/* Collides the pose of tick i with the complete grid. No bounding box excludes voxels, and no voxel may change. */
ost_status perform_collide(performer *p, size_t i, ost_error *err);

#endif
