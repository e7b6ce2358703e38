/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Triangle meshes, and the integer mesh that is the input of voxelization.
 *
 *   file -> ost_mesh (picometres) -> ost_snapped_mesh (lattice) -> backend
 *
 * The snapped mesh is computed once, on the host, and its digest is recorded.  All backends start from this
 * mesh and must produce equal results (docs/spec/arithmetic.md, AR-MESH).
 *
 * Threads: the functions share no state; an object may be used by one thread at a time, or read by several.
 */
#ifndef OSTEON_MESH_H
#define OSTEON_MESH_H

#include <osteon/digest.h>
#include <osteon/grid.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Vertices in picometres, in the frame of the mesh file; triangles are counter-clockwise as seen from outside. */
typedef struct ost_mesh {
    size_t vertex_count;
    ost_pm3 *vertices; /* owned */
    size_t triangle_count;
    uint32_t (*triangles)[3]; /* owned; vertex indices of each triangle, below vertex_count */
} ost_mesh;

enum { OST_MESH_TRIANGLES_MAX = 1 << 26 };

/*
 * Allocates the arrays of a mesh without initialising their elements. Returns OST_ERR_RANGE if triangle_count exceeds
 * OST_MESH_TRIANGLES_MAX or vertex_count exceeds three times this maximum, and OST_ERR_MEMORY if memory is exhausted.
 * After an error, the mesh is empty. The caller frees the arrays with ost_mesh_free.
 */
OST_API ost_status ost_mesh_init(ost_mesh *mesh, size_t vertex_count, size_t triangle_count, ost_error *err);
/* Frees the arrays of a mesh, which is then empty. */
OST_API void ost_mesh_free(ost_mesh *mesh);
/*
 * Computes the bounds of all vertices that triangles use. Returns OST_ERR_INPUT if there is no triangle, and
 * OST_ERR_USAGE if a vertex index is out of range.
 */
OST_API ost_status ost_mesh_bounds(const ost_mesh *mesh, ost_pm3 *min, ost_pm3 *max, ost_error *err);
/* Returns the signed volume in mm^3, which is positive for outward faces. Used only for reports. */
OST_API double ost_mesh_volume_mm3(const ost_mesh *mesh);
/*
 * Counts the open edges. An edge is open unless exactly two triangles share it and have opposite directions along
 * it. Vertices with equal positions count as one vertex. Returns OST_ERR_USAGE if a vertex index is out of range, and
 * OST_ERR_MEMORY if memory is exhausted.
 */
OST_API ost_status ost_mesh_open_edges(const ost_mesh *mesh, size_t *open_edges, ost_error *err);

/* Limits of a tool grid (AR-TOOL-1). */
enum { OST_TOOL_DIM_MAX = 4096, OST_TOOL_DIM_REMOVE_MAX = 1024 };
#define OST_TOOL_VOXEL_MIN (OST_PM_PER_MM / 1000)
#define OST_TOOL_VOXELS_MAX (INT64_C(1) << 33)

/*
 * The grid of a tool: dims, voxel size and corner. The corner is MinVoxelCoords of the thesis (Alg. 2.1), which is not
 * the centre of a voxel.
 */
typedef struct ost_tool_geometry {
    ost_dims dims;
    ost_pm voxel;
    ost_pm3 corner;
} ost_tool_geometry;

/* Returns OST_ERR_RANGE, with the limit in the message, if a limit of AR-TOOL-1 is exceeded. */
OST_API ost_status ost_tool_geometry_check(const ost_tool_geometry *geometry, ost_error *err);

/*
 * Computes the grid of a tool from the bounds [min, max] of its mesh, by Alg. 2.1 with rounding half to even.
 * Returns OST_ERR_RANGE if the bounds or the grid exceed a limit of AR-TOOL-1, such as OST_TOOL_DIM_MAX voxels along an
 * axis or 2^33 voxels, and OST_ERR_USAGE if a coordinate of min exceeds that of max.
 */
OST_API ost_status ost_tool_geometry_from_bounds(ost_pm3 min, ost_pm3 max, ost_pm voxel, ost_tool_geometry *out,
                                                 ost_error *err);

/*
 * A mesh whose vertices are integers. The unit is voxel / 2^fraction_bits, and the origin is the corner of the
 * grid: 0 <= coordinate <= dims << fraction_bits <= 2^20. Triangles whose snapped cross product is zero are dropped
 * and counted.
 */
typedef struct ost_snapped_mesh {
    ost_tool_geometry grid;
    int fraction_bits;
    size_t vertex_count;
    int32_t (*vertices)[3]; /* owned */
    size_t triangle_count;
    uint32_t (*triangles)[3]; /* owned */
    size_t dropped_triangles;
} ost_snapped_mesh;

/*
 * Snaps a mesh to the lattice of a tool grid (AR-MESH-3, AR-MESH-4). Returns OST_ERR_RANGE if a vertex
 * is outside the lattice, or if the grid or the number of triangles exceeds its limit. Returns OST_ERR_USAGE if a
 * vertex index is out of range, and OST_ERR_MEMORY if memory is exhausted. The caller frees *out with
 * ost_snapped_mesh_free.
 */
OST_API ost_status ost_mesh_snap(const ost_mesh *mesh, const ost_tool_geometry *grid, ost_snapped_mesh *out,
                                 ost_error *err);
/* Frees the arrays of a snapped mesh, which is then empty. */
OST_API void ost_snapped_mesh_free(ost_snapped_mesh *mesh);
/* Computes the digest of a snapped mesh (AR-DIG-7). The only error is OST_ERR_MEMORY, as in digest.h. */
OST_API ost_status ost_snapped_mesh_digest(const ost_snapped_mesh *mesh, ost_digest *out, ost_error *err);

#ifdef __cplusplus
}
#endif
#endif
