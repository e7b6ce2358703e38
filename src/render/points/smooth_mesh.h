/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The surface of a tool as triangles with a normal at each corner, which a renderer draws with smooth shading.
 *
 *   meshes of the tool's parts --faces at each vertex--> normals --tool's grid--> corners in voxels
 *
 * The normal of a triangle's corner is the mean of the normals of the triangles that meet at this vertex, weighted by
 * area. Only triangles whose normals are within 40 degrees of the normal of the corner's own triangle count, so the rim
 * of a cylinder remains sharp. Normals are computed in doubles, only by additions, multiplications, divisions and
 * square roots. They are therefore bit-identical on all machines.
 */
#ifndef OST_RENDER_SMOOTH_MESH_H
#define OST_RENDER_SMOOTH_MESH_H

#include <osteon/mesh.h>

/* maximum number of triangles; for a larger mesh, drawing would take too much of a frame's time, so the tool's voxels
   are drawn instead */
enum { OST_SMOOTH_TRIANGLES_MAX = 1 << 17 };

typedef struct ost_smooth_corner {
    float at[3];     /* in voxels of the tool's grid: voxel (i, j, k) is the cube of side 1 about (i, j, k) */
    float normal[3]; /* unit vector */
} ost_smooth_corner;

typedef struct ost_smooth_triangle {
    ost_smooth_corner corner[3];
} ost_smooth_triangle;
_Static_assert(sizeof(ost_smooth_triangle) == 72, "18 floats without padding");

typedef struct ost_smooth_mesh {
    ost_smooth_triangle *triangle; /* owned */
    size_t count;
    /* owned; the distinct positions of the corners, and the indices of the three positions of each triangle; a position
       is projected only once for all triangles that meet there */
    float (*position)[3];
    size_t positions;
    uint32_t (*place)[3];
    bool closed; /* true if no triangle can be seen from behind by an eye outside the mesh */
    uint64_t hash; /* hash of the triangles, with which a renderer recognizes a mesh that it has already uploaded */
} ost_smooth_mesh;

/*
 * Makes the surface from the meshes of a tool's parts, in the frame of `grid`. Triangles without area are omitted. If
 * the parts have more than OST_SMOOTH_TRIANGLES_MAX triangles together, *out is empty. Returns OST_ERR_USAGE if a
 * vertex index is out of range, and OST_ERR_MEMORY. The caller frees *out with ost_smooth_mesh_free.
 */
ost_status ost_smooth_mesh_make(const ost_mesh *parts, int count, const ost_tool_geometry *grid, ost_smooth_mesh *out,
                                ost_error *err);
void ost_smooth_mesh_free(ost_smooth_mesh *mesh); /* accepts a zero-initialized mesh */

#endif
