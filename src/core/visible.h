/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The faces of a voxel, and the bit operations that find the visible ones in a row of 32 voxels.
 *
 *   bit x of `own`       voxel x of the row is active
 *   bit x of `behind`    the neighbour of voxel x at one face is active
 *   own & ~behind        the active voxels whose face is visible
 *
 * The lists of surface voxels (render/points/rows.h) and the face meshes (face_mesh.h) use these operations.
 */
#ifndef OST_CORE_VISIBLE_H
#define OST_CORE_VISIBLE_H

#include <stdint.h>

/* The six faces of a voxel, in the order of all lists, bit masks and meshes. */
typedef enum ost_face {
    OST_FACE_X0, /* the face toward -x */
    OST_FACE_X1, /* the face toward +x */
    OST_FACE_Y0,
    OST_FACE_Y1,
    OST_FACE_Z0,
    OST_FACE_Z1
} ost_face;

/*
 * Computes, for each face, the voxels of the row `own` whose neighbour at this face is active. x0 and x1 are the rows
 * before and after `own` along x; y0, y1, z0 and z1 are the adjacent rows along y and z.
 */
static inline void ost_visible_behind(uint32_t own, uint32_t x0, uint32_t x1, uint32_t y0, uint32_t y1, uint32_t z0,
                                      uint32_t z1, uint32_t behind[6])
{
    behind[OST_FACE_X0] = own << 1 | x0 >> 31;
    behind[OST_FACE_X1] = own >> 1 | x1 << 31;
    behind[OST_FACE_Y0] = y0;
    behind[OST_FACE_Y1] = y1;
    behind[OST_FACE_Z0] = z0;
    behind[OST_FACE_Z1] = z1;
}

#endif
