/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A tool grid on the host, with one uint8 per voxel, x fastest.
 *
 *   0 empty  1 cutting   2 not cutting (touches, but removes nothing)
 *
 * Voxel (i, j, k) has its centre at corner + (i + 1/2, j + 1/2, k + 1/2) * voxel
 * in the tool's frame, which is the frame of the mesh file.
 *
 * Threads: the functions share no state; an object may be used by one thread at a time, or read by several.
 */
#ifndef OSTEON_TOOL_H
#define OSTEON_TOOL_H

#include <osteon/mesh.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { OST_TOOL_VOID = 0, OST_TOOL_CUTTING = 1, OST_TOOL_NONCUTTING = 2 };

/* A tool grid in host memory, one byte per voxel. */
typedef struct ost_tool_volume {
    ost_tool_geometry geometry;
    ost_meta meta;
    uint8_t *voxels; /* owned; ost_dims_count(geometry.dims) elements */
} ost_tool_volume;

/*
 * Allocates a tool grid filled with zeros, so that all voxels are empty. Returns OST_ERR_RANGE if geometry exceeds a
 * limit of AR-TOOL-1, and OST_ERR_MEMORY if memory is exhausted. After an error, *tool has no voxels but can still be
 * freed. The caller frees the voxels with ost_tool_volume_free.
 */
OST_API ost_status ost_tool_volume_init(ost_tool_volume *tool, const ost_tool_geometry *geometry, ost_error *err);
/* Frees the voxels of a tool volume, which is then empty. */
OST_API void ost_tool_volume_free(ost_tool_volume *tool);
/* Returns the number of voxels of a class. */
OST_API int64_t ost_tool_volume_count(const ost_tool_volume *tool, uint8_t tool_class);

#ifdef __cplusplus
}
#endif
#endif
