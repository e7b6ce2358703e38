/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The surface of a tool as triangles with a normal at each corner, which a renderer draws with smooth shading.
 *
 *   meshes of the tool's parts --faces at each vertex--> normals --tool's grid--> corners in voxels
 *
 * The normal at a triangle's corner is the area-weighted mean of the normals of the triangles that meet at this vertex.
 * Only normals within 40 degrees of the triangle's own normal count, so the rim of a cylinder remains sharp. Normals
 * are computed in doubles with only additions, multiplications, divisions and square roots, so they are bit-identical
 * on all machines.
 */
#ifndef OST_RENDER_SMOOTH_MESH_H
#define OST_RENDER_SMOOTH_MESH_H

#include <osteon/mesh.h>

/* maximum number of triangles; a tool with a larger mesh is drawn as voxels, because drawing the mesh would take too
   much of a frame's time */
enum { OST_SMOOTH_TRIANGLES_MAX = 1 << 17 };

typedef struct ost_smooth_corner {
    /* position in voxels of the tool's grid; voxel (i, j, k) is the cube of side 1 centred at (i, j, k) */
    float at[3];
    float normal[3]; /* unit vector */
} ost_smooth_corner;

typedef struct ost_smooth_triangle {
    ost_smooth_corner corner[3];
} ost_smooth_triangle;
_Static_assert(sizeof(ost_smooth_triangle) == 72, "18 floats without padding");

typedef struct ost_smooth_mesh {
    ost_smooth_triangle *triangle; /* owned */
    size_t count;
    /* position: distinct positions of the corners, so that each position is projected only once; place: for each
       triangle, the indices of its three positions. Both are owned */
    float (*position)[3];
    size_t positions;
    uint32_t (*place)[3];
    bool closed; /* true if an eye outside the mesh cannot see the back of any triangle */
    uint64_t hash; /* hash of the triangles; identifies a mesh that a renderer has already uploaded */
} ost_smooth_mesh;

/*
 * Makes the surface from the meshes of a tool's parts, in the frame of `grid`. Zero-area triangles are omitted. If the
 * parts have more than OST_SMOOTH_TRIANGLES_MAX triangles together, *out is empty. Returns OST_ERR_USAGE if a vertex
 * index is out of range, and OST_ERR_MEMORY if memory is exhausted. The caller frees *out with ost_smooth_mesh_free.
 */
ost_status ost_smooth_mesh_make(const ost_mesh *parts, int count, const ost_tool_geometry *grid, ost_smooth_mesh *out,
                                ost_error *err);
void ost_smooth_mesh_free(ost_smooth_mesh *mesh); /* accepts a zero-initialized mesh */

#endif
