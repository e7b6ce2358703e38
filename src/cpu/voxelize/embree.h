/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Embree finds the triangles that may cross a row of voxels.  The crossings themselves
 * are computed by the same exact code as without Embree.  Therefore no number that
 * Embree computes affects the grid.
 */
#ifndef OST_CPU_EMBREE_H
#define OST_CPU_EMBREE_H

#include "cpu/voxelize/voxelize.h"

/*
 * Returns OST_ERR_UNAVAILABLE if osteon was built without Embree. In this case, the caller may call only
 * ost_embree_free and ost_embree_scratch_free, and only with NULL.
 */
ost_status ost_embree_available(ost_error *err);

/* A search structure for casting rays at a mesh. The mesh must outlive the structure. ost_embree_free accepts NULL. */
typedef struct ost_embree ost_embree;
ost_status ost_embree_new(const ost_snapped_mesh *mesh, int threads, ost_embree **out, ost_error *err);
void ost_embree_free(ost_embree *embree);

/* The scratch memory of one thread for casting rays. ost_embree_scratch_new returns NULL if memory is exhausted;
   ost_embree_scratch_free accepts NULL. */
typedef struct ost_embree_scratch ost_embree_scratch;
ost_embree_scratch *ost_embree_scratch_new(const ost_embree *embree);
void ost_embree_scratch_free(ost_embree_scratch *scratch);

/* Marks the crossings of all triangles with the rows of the tile. Casts one ray along x for each row. */
void ost_embree_mark(const ost_embree *embree, ost_embree_scratch *scratch, ost_vox_tile *tile, ost_vox_mark_fn *mark);

#endif
