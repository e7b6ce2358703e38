/* SPDX-License-Identifier: Apache-2.0 */
/* Computes a block's surface points from its bits and those of its neighbours. */
#ifndef OST_RENDER_EXTRACT_H
#define OST_RENDER_EXTRACT_H

#include "render/points/rows.h"

/* Returns the block at a position given in units of blocks. Returns NULL if the position is outside the grid, or if the
   block has never contained an active voxel. */
ost_surface_block *ost_surface_block_at(const ost_surface *surface, int32_t x, int32_t y, int32_t z);

/* Returns one set of bits of a block; NULL if the block does not have this set. */
typedef const uint32_t *ost_words_of(const ost_surface_block *block);

/*
 * ost_surface_rim and ost_surface_rows collect one set of bits, selected by `which`, from a block and its neighbours.
 * If none of these blocks has the set, they return false and leave *out unchanged.
 */
bool ost_surface_rim(const ost_surface *surface, const ost_surface_block *block, ost_words_of *which, ost_rim *out);
bool ost_surface_rows(const ost_surface *surface, const ost_surface_block *block, ost_words_of *which,
                      const ost_row_kernels *kernels, ost_rows *out);

/*
 * Finds the rows that have a voxel at most `reach` voxels away, along each axis, from a changed voxel. Bit y of word z
 * represents row (y, z); y and z are counted from -OST_SHADING_REACH. The results are complete only for the block's own
 * rows. Returns false if nothing has changed in the block and its neighbours.
 */
bool ost_surface_changes(const ost_surface *surface, const ost_surface_block *block, int reach,
                         uint64_t rows[OST_SEEN]);

#endif
