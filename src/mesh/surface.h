/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Computes the surface of the solid voxels of a volume as a closed mesh, for 3D printing and for other programs.
 *
 * The method is marching cubes, with loops that are traced instead of tabulated. Each lattice edge between a solid and
 * an empty voxel centre has one vertex. On each face of a cell, segments connect the vertices so that diagonally
 * opposite solid corners remain separate. The segments form closed loops, and each loop is filled with triangles. The
 * two cells that share a face contain the same segments, in opposite directions. Each mesh edge therefore belongs to
 * exactly two triangles, and the surface is closed for every set of voxels. Space outside the grid is empty.
 *
 *     o---x---o     o solid, x vertex      two solid corners across a face:
 *     |  /    |     . empty                o--x--.
 *     x /     |                            | /   |   each solid corner
 *     | \     |                            x   / x   is separated
 *     .  `x---.                            .--x--o
 *
 * A vertex always lies on its lattice edge, so its distance from the border between the two voxels is at most half a
 * voxel.
 */
#ifndef OST_MESH_SURFACE_H
#define OST_MESH_SURFACE_H

#include <osteon/grid.h>
#include <osteon/mesh.h>

typedef enum ost_surface_placement {
    OST_SURFACE_DENSITY, /* places vertices where the density crosses the threshold, as needed for a CT */
    OST_SURFACE_SMOOTH   /* smooths the border between solid and empty voxels; intended for a bone or a tool, whose
                          * empty voxels are 0 */
} ost_surface_placement;

/*
 * Extracts the surface of the voxels whose density is at least the threshold. Faces point outward; vertices are in the
 * frame of the volume. Returns OST_ERR_INPUT if no voxel is solid, and OST_ERR_RANGE if the surface has more than
 * OST_MESH_TRIANGLES_MAX triangles.
 */
ost_status ost_surface_extract(const ost_volume *volume, int32_t threshold, ost_surface_placement position,
                               ost_mesh *out, ost_error *err);

#endif
