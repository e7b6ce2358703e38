/* SPDX-License-Identifier: Apache-2.0 */
/* Tool grids of one bit per voxel, as the voxelizer of the cpu backend writes them, and their comparison with bytes. */
#ifndef OST_BENCH_TOOL_BITS_H
#define OST_BENCH_TOOL_BITS_H

#include <osteon/mesh.h>

#include "core/backend.h"

/* Allocates the bits of a grid, aligned to 64 bytes and written once, so that no page is touched for the first time
   during a measurement. The caller frees them. Returns NULL and sets err if memory is exhausted. */
uint64_t *bench_tool_bits(ost_dims dims, ost_error *err);

/* Voxelizes a mesh by the winding rule and copies the voxels, one byte each, to the host. */
ost_status bench_tool_voxels(ost_backend *backend, const ost_snapped_mesh *mesh, ost_tool_volume *out,
                             ost_voxelize_report *report, ost_error *err);

/* Returns true if the bits (ost_vox_words words per row) are those of the voxels, whose classes are 0 and 1. */
bool bench_tool_bits_are(const uint64_t *bits, ost_dims dims, const uint8_t *voxels);

#endif
