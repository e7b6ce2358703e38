/* SPDX-License-Identifier: Apache-2.0 */
/* Converts a block of a volume to words of 32 voxels. */
#ifndef OST_RENDER_BLOCK_WORDS_H
#define OST_RENDER_BLOCK_WORDS_H

#include "render/points/surface.h"

/*
 * Sets bit x of words[y + 32 z] if voxel (x, y, z) of the block has at least the density `threshold`, which must fit in
 * an int16. Clears the bits of voxels outside the volume.
 */
void ost_block_words(const ost_volume *volume, const int32_t block[3], int32_t threshold,
                     uint32_t words[OST_BLOCK_ROWS]);

#endif
