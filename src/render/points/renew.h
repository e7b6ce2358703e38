/* SPDX-License-Identifier: Apache-2.0 */
/* A block of a surface after a change: its list, and those looks that may be others now. */
#ifndef OST_RENDER_RENEW_H
#define OST_RENDER_RENEW_H

#include "core/isa.h"
#include "render/points/surface.h"

/* By these loops from now on; without it, by those that OSTEON_ISA allows. */
ost_status ost_surface_use(ost_surface *surface, ost_isa isa, ost_error *err);

/* Cells of every block that needs it: before one is made anew, since they look beyond their borders. */
ost_status ost_surface_measure_all(ost_surface *surface, ost_error *err);

/* Of a dirty block. What neighbours need of it stays. */
ost_status ost_surface_renew(ost_surface *surface, int32_t slot, ost_error *err);

#endif
