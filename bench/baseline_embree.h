/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The baseline of the voxelizer. It uses Embree's own triangles, packets of sixteen rays along x
 * with one ray per row, and a filter that records every hit and ends no ray. The result is parity
 * bits. The time covers everything from welded vertices in memory to bits, including building the
 * hierarchy. The hits are Embree's floats, so counts may differ from ours by a few voxels on the
 * surface.
 */
#ifndef OST_BENCH_BASELINE_EMBREE_H
#define OST_BENCH_BASELINE_EMBREE_H

#include <stdbool.h>

#include <osteon/mesh.h>

typedef struct ost_baseline_embree_times {
    double build_ms; /* time to build the hierarchy */
    double trace_ms; /* time to trace the rays and make bits from hits */
} ost_baseline_embree_times;

/*
 * Voxelizes a mesh. bits: (dims.x + 63) / 64 words per row, rows in the order (k, j). low_quality
 * selects Embree's fast build. Returns the number of solid voxels, or -1 if this was built without
 * Embree or Embree failed.
 */
int64_t ost_baseline_embree(const ost_snapped_mesh *mesh, int threads, bool low_quality, uint64_t *bits,
                            ost_baseline_embree_times *times);

#endif
