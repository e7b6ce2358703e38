/* SPDX-License-Identifier: Apache-2.0 */
/* From a block's bits, and those about it, to its surface points. */
#ifndef OST_RENDER_EXTRACT_H
#define OST_RENDER_EXTRACT_H

#include "render/points/rows.h"

/* NULL where there has never been anything, outside the grid too. */
ost_surface_block *ost_surface_block_at(const ost_surface *surface, int32_t x, int32_t y, int32_t z);

/* One of the sets of bits that a block has: NULL when it has none of it. */
typedef const uint32_t *ost_words_of(const ost_surface_block *block);

/* That set of the block and of what lies about it. False when there is none in them all; then the rest is not made. */
bool ost_surface_rim(const ost_surface *surface, const ost_surface_block *block, ost_words_of *which, ost_rim *out);
bool ost_surface_rows(const ost_surface *surface, const ost_surface_block *block, ost_words_of *which, const ost_row_kernels *kernels, ost_rows *out);

/*
 * Rows that lie up to reach voxels from a change, along each axis: bit y of
 * slice z, both from -OST_LOOK_REACH on, right for the block's own.  Of a row
 * it is not said where in it.  False when nothing about the block changed.
 */
bool ost_surface_changes(const ost_surface *surface, const ost_surface_block *block, int reach, uint64_t rows[OST_SEEN]);

#endif
