/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The peer of the voxelizer: Embree's own triangles, packets of sixteen rays
 * along x, one ray a row, a filter that notes every hit and lets none end the
 * ray, parity bits out.  From welded vertices in memory to bits, hierarchy
 * included.  Its hits are Embree's floats: counts may differ from ours by a
 * few voxels on the surface.
 */
#ifndef OST_BENCH_BASELINE_EMBREE_H
#define OST_BENCH_BASELINE_EMBREE_H

#include <stdbool.h>

#include <osteon/mesh.h>

typedef struct ost_baseline_embree_times {
    double build_ms; /* the hierarchy */
    double trace_ms; /* rays, and bits from hits */
} ost_baseline_embree_times;

/*
 * bits: (dims.x + 63) / 64 words a row, rows in the order (k, j).  low_quality
 * asks Embree for its fast build.  Returns the number of solid voxels, or -1 when
 * this was built without Embree or Embree failed.
 */
int64_t ost_baseline_embree(const ost_snapped_mesh *mesh, int threads, bool low_quality, uint64_t *bits,
                            ost_baseline_embree_times *times);

#endif
