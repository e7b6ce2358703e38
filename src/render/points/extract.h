/* SPDX-License-Identifier: Apache-2.0 */
/* Computes a block's surface points from its bits and those of its neighbours. */
#ifndef OST_RENDER_EXTRACT_H
#define OST_RENDER_EXTRACT_H

#include "render/points/rows.h"

/* Returns the block at the given position, in units of blocks. If the position is outside the grid or the block never
   contained an active voxel, returns NULL. */
ost_surface_block *ost_surface_block_at(const ost_surface *surface, int32_t x, int32_t y, int32_t z);

/* Returns one set of bits of a block, or NULL if the block does not have this set. */
typedef const uint32_t *ost_words_of(const ost_surface_block *block);

/*
 * ost_surface_rim and ost_surface_rows collect one set of bits from the block and its neighbours. The function `which`
 * returns this set for a given block. If no block has the set, both functions return false and do not write *out.
 */
bool ost_surface_rim(const ost_surface *surface, const ost_surface_block *block, ost_words_of *which, ost_rim *out);
bool ost_surface_rows(const ost_surface *surface, const ost_surface_block *block, ost_words_of *which,
                      const ost_row_kernels *kernels, ost_rows *out);

/*
 * Finds the rows whose distance to a changed voxel is at most `reach` voxels along each axis. Bit y of word z
 * represents row (y, z), counted from -OST_SHADING_REACH on both axes. Only the results for the block's own rows are
 * complete. Returns false if nothing has changed in the block and its neighbours.
 */
bool ost_surface_changes(const ost_surface *surface, const ost_surface_block *block, int reach,
                         uint64_t rows[OST_SEEN]);

#endif
