/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Embree finds which triangles a row may cross; whether and where it does is
 * decided by the same exact code as without it.  Nothing that Embree computes
 * reaches the grid.
 */
#ifndef OST_CPU_EMBREE_H
#define OST_CPU_EMBREE_H

#include "cpu/voxelize/voxelize.h"

/* OST_ERR_UNAVAILABLE when this was built without Embree; then nothing below is called but with NULL. */
ost_status ost_embree_available(ost_error *err);

/* A mesh that rays can be cast through; mesh must outlive it. NULL is allowed in free. */
typedef struct ost_embree ost_embree;
ost_status ost_embree_new(const ost_snapped_mesh *mesh, int threads, ost_embree **out, ost_error *err);
void ost_embree_free(ost_embree *embree);

/* What one thread needs to cast rays. NULL when there is no memory; NULL is allowed in free. */
typedef struct ost_embree_desk ost_embree_desk;
ost_embree_desk *ost_embree_desk_new(const ost_embree *embree);
void ost_embree_desk_free(ost_embree_desk *desk);

/* Marks all triangles in the rows of the tile, by one ray along x for each row. */
void ost_embree_mark(const ost_embree *embree, ost_embree_desk *desk, ost_vox_tile *tile, ost_vox_mark_fn *mark);

#endif
