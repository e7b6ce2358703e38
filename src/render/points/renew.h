/* SPDX-License-Identifier: Apache-2.0 */
/* Updates a block of a surface after a change: its list of points, and the shades that may have changed. */
#ifndef OST_RENDER_RENEW_H
#define OST_RENDER_RENEW_H

#include "core/isa.h"
#include "render/points/surface.h"

/* Selects the loops for an instruction set. Defaults to the best one that OSTEON_ISA allows. */
ost_status ost_surface_use(ost_surface *surface, ost_isa isa, ost_error *err);

/* Recomputes all cells that may have changed, in all blocks. Must be called before ost_surface_renew,
   which reads the cells of neighbouring blocks. */
ost_status ost_surface_measure_all(ost_surface *surface, ost_error *err);

/* Updates a block that is marked as dirty. The block's record of changes is kept, because the updates of neighbouring
   blocks read it. */
ost_status ost_surface_renew(ost_surface *surface, int32_t slot, ost_error *err);

#endif
