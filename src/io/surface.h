/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The surface of the solid voxels of a volume as a closed mesh, for printing
 * and for other programs.  It decides no voxel.
 *
 * Marching cubes whose loops are traced, not tabulated: every lattice edge
 * between a solid and a void voxel centre carries one vertex; on each face of
 * a cell the crossed edges are joined so that solid corners are kept apart;
 * the joints close into loops, and each loop is filled.  A joint is seen by the
 * two cells that share its face, once from either side, so every mesh edge
 * belongs to exactly two triangles: the surface is closed whatever the voxels,
 * and beyond the grid is void.
 *
 *     o---x---o     o solid, x vertex      two solid corners across a face:
 *     |  /    |     . void                 o--x--.
 *     x /     |                            | /   |   each solid corner
 *     | \     |                            x   / x   is cut off alone
 *     .  `x---.                            .--x--o
 *
 * A vertex never leaves its lattice edge, so it is at most half a voxel from
 * where the border between its two voxels is.
 */
#ifndef OST_IO_SURFACE_H
#define OST_IO_SURFACE_H

#include <osteon/grid.h>
#include <osteon/mesh.h>

typedef enum ost_surface_place {
    OST_SURFACE_DENSITY, /* where the densities cross the threshold: for a CT */
    OST_SURFACE_SMOOTH   /* between solid and void, evened out along the edges: for a bone or a tool, whose void is 0 */
} ost_surface_place;

/* Faces outward, vertices in the volume's frame. OST_ERR_INPUT when no voxel is solid; OST_ERR_RANGE beyond OST_MESH_TRIANGLES_MAX. */
ost_status ost_surface_extract(const ost_volume *volume, int32_t threshold, ost_surface_place place, ost_mesh *out, ost_error *err);

/* Binary little-endian PLY, vertices as float32 in millimetres. */
ost_status ost_mesh_write_ply(const char *path, const ost_mesh *mesh, ost_error *err);

#endif
