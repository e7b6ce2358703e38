/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How a surface voxel looks: which way its surface faces, how open it lies,
 * what it is painted with.
 *
 *   bits, densities within five voxels --smoothed by 9^3--> field --its gradient--> normal
 *                                                              '---its value-----> openness
 *   bits now, bits before, densities (ground.h) ------------------------------------> paint
 *
 * The weights of the smoothing are 1 2 3 4 5 4 3 2 1 along each axis: on a
 * plane through a voxel's upper side the field there is 0.6 of all.  Integers
 * all the way, but for the last step to an octahedral cell.
 */
#ifndef OST_RENDER_DRESS_H
#define OST_RENDER_DRESS_H

#include "render/points/surface.h"

/* The looks of a block's points, which were listed. The surface has its scratch. */
ost_status ost_surface_dress(ost_surface *surface, ost_surface_block *block, ost_error *err);

/* Of a field value, 0 to about OST_FIELD_FULL. */
enum { OST_FIELD_FULL = 61525 };
uint32_t ost_openness(int field);

#endif
