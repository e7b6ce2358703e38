/* SPDX-License-Identifier: Apache-2.0 */
/* Updates a block of a surface after a change: its list of points, and the shades that may have changed. */
#ifndef OST_RENDER_RENEW_H
#define OST_RENDER_RENEW_H

#include "core/isa.h"
#include "render/points/surface.h"

/* Selects the loops for an instruction set. By default, the best instruction set that OSTEON_ISA allows is used. */
ost_status ost_surface_use(ost_surface *surface, ost_isa isa, ost_error *err);

/* Recomputes the cells of all blocks in which cells may have changed. Must be called before the first call of
   ost_surface_renew, because updating a block reads the cells of the block's neighbours. */
ost_status ost_surface_measure_all(ost_surface *surface, ost_error *err);

/* Updates a block that is marked as dirty. Does not clear the block's record of changes, because the block's neighbours
   read it. */
ost_status ost_surface_renew(ost_surface *surface, int32_t slot, ost_error *err);

#endif
