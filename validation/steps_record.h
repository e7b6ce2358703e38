/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Trace records of the steps: the computations that precede the voxels. Steps are computed by src/core, by
 * its second implementation (dense/steps.h), or by a plugin.
 *
 *   snap   one tool: for each of its two meshes 15 words (the grid, the number of
 *          fraction bits, the counts of vertices and triangles, and the digest of
 *          AR-DIG-7); then the cutting mesh's vertices, one per word
 *   steps  one tick: 11 words (whether it is refused or an event, the number of
 *          poses, time, speed, and the pose after the motor's rotation); then 61
 *          words for each pose of the event: the pose, the map's integers
 *          (AR-MAP), the bases of three blocks, and the box of the broad phase
 */
#ifndef OST_VALIDATION_STEPS_RECORD_H
#define OST_VALIDATION_STEPS_RECORD_H

#include <osteon/event.h>
#include <osteon/path.h>

#include "validation/trace.h"

/* A pose of an event, with the values that are computed from it. */
typedef struct steps_pose {
    ost_pose pose;
    ost_map map;
    bool near[3];        /* for each of the blocks of steps_blocks, true if it is near (AR-MAP-5) */
    int32_t base[3][3];  /* bases of the blocks; 0 for blocks that are not near */
    bool reaches;        /* true if a voxel of a block may lie inside the tool's grid */
    ost_voxel_box box;   /* bounding box of the voxels that can be inside the tool's grid; empty if there are none */
} steps_pose;

/*
 * Three blocks have recorded bases: the first, the middle and the last block of the grid. Returns the first voxel of
 * each of these blocks.
 */
void steps_blocks(ost_dims bone, int32_t first[3][3]);

/* Computes the digest of a mesh (AR-DIG-7) with code of its own, for comparison with src/core. */
ost_status steps_mesh_digest(const ost_snapped_mesh *mesh, ost_digest *out, ost_error *err);

/* Computes the digest of a bone by AR-DIG-2 to AR-DIG-5 without the functions of src/core. `g` is the bone's grid;
   `voxels` are its densities, x fastest. */
ost_status steps_bone_digest(const ost_geometry *g, int32_t threshold, const int16_t *voxels, ost_digest *out,
                             ost_error *err);

/* Adds the words of a snap record. If `second` is true, steps_mesh_digest computes the digest. parts[1] has no
   triangles if there is no second mesh. `parts` is NULL if the meshes before snapping are not available. */
ost_status steps_put_snap(trace_writer *w, bool second, const ost_snapped_mesh *parts, ost_error *err);
void steps_put_tick(trace_writer *w, bool refused, bool removal, int count, const ost_tick *tick);
void steps_put_pose(trace_writer *w, const steps_pose *p);

void steps_word_name(trace_stage stage, size_t word, char text[TRACE_WORD]);
/* Returns true if the word with this index is a bound. The bounds are the member `reaches` and the box of each pose. */
bool steps_word_is_bound(size_t word);
bool steps_word_holds(size_t word, const uint8_t *is, const uint8_t *least);

#endif
