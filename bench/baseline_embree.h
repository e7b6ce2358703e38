/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The baseline of the voxelizer. It uses Embree's own triangles and packets of sixteen rays along x,
 * with one ray per row. A filter records every hit and lets the ray continue. The result is one
 * parity bit per voxel. When the time measurement begins, the welded vertices are in memory. The
 * measurement includes building the hierarchy and ends when the bits are written. Embree computes
 * the hits in floats, so the number of solid voxels may differ from osteon's by a few voxels on the
 * surface.
 */
#ifndef OST_BENCH_BASELINE_EMBREE_H
#define OST_BENCH_BASELINE_EMBREE_H

#include <stdbool.h>

#include <osteon/mesh.h>

typedef struct ost_baseline_embree_times {
    double build_ms; /* time to build the hierarchy */
    double trace_ms; /* time to trace the rays and to convert the hits to bits */
} ost_baseline_embree_times;

/*
 * Voxelizes a mesh. `bits` has (dims.x + 63) / 64 words per row; the rows are ordered by (k, j).
 * `low_quality` selects Embree's fast build of the hierarchy. Returns the number of solid voxels, or
 * -1 if this program was built without Embree or if Embree failed.
 */
int64_t ost_baseline_embree(const ost_snapped_mesh *mesh, int threads, bool low_quality, uint64_t *bits,
                            ost_baseline_embree_times *times);

#endif
