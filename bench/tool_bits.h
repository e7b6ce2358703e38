/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Allocates tool grids with one bit per voxel, the format of the cpu backend's voxelizer, and compares them with tool
 * grids that have one byte per voxel.
 */
#ifndef OST_BENCH_TOOL_BITS_H
#define OST_BENCH_TOOL_BITS_H

#include <osteon/mesh.h>

#include "core/backend.h"

/* Allocates the bits of a grid, aligned to 64 bytes. All pages are written once, so that no page is accessed for the
   first time during the measurement. The caller frees the bits. Returns NULL and sets err if memory is exhausted. */
uint64_t *bench_tool_bits(ost_dims dims, ost_error *err);

/* Voxelizes a mesh by the winding rule and copies the voxels to the host, with one byte per voxel. */
ost_status bench_tool_voxels(ost_backend *backend, const ost_snapped_mesh *mesh, ost_tool_volume *out,
                             ost_voxelize_report *report, ost_error *err);

/* Returns true if each bit equals the class of its voxel, which must be 0 or 1. A row has ost_vox_words words. */
bool bench_tool_bits_are(const uint64_t *bits, ost_dims dims, const uint8_t *voxels);

#endif
