/* SPDX-License-Identifier: Apache-2.0 */
/* From a block's bits, and those about it, to its surface points. */
#ifndef OST_RENDER_EXTRACT_H
#define OST_RENDER_EXTRACT_H

#include "render/points/surface.h"

/* NULL where there has never been anything, outside the grid too. */
ost_surface_block *ost_surface_block_at(const ost_surface *surface, int32_t x, int32_t y, int32_t z);

/* Makes the block's list anew; its looks are to be made after it. */
ost_status ost_surface_list(const ost_surface *surface, ost_surface_block *block, ost_error *err);

#endif
