/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Divides a CT into bones. The bones are connected components of dense voxels, stored as a label map.
 *
 *   CT --threshold, growth--> candidates --cuts--> components --fill, separate--> label map, list of components
 *
 * Labels are computed with integers only (docs/spec/arithmetic.md, AR-SEG), so the label map
 * is the same on every machine.  ost_import accepts such a label map, or any other label map
 * on the grid of the CT, as a mask (io.h).
 *
 * Threads: the functions have no state and may run on any thread; several threads may read the same
 * volume.
 */
#ifndef OSTEON_SEGMENT_H
#define OSTEON_SEGMENT_H

#include <osteon/event.h>
#include <osteon/grid.h>

#ifdef __cplusplus
extern "C" {
#endif

/*
 * A cut separates two bones that touch. It is a ball or a half space; the voxels in the cut belong to no component.
 * A half space is the side of a plane to which the normal points, including the plane. The length of the normal has
 * no effect.
 */
typedef struct ost_segment_cut {
    ost_pm3 at;     /* centre of the ball, or a point on the plane, in LPS */
    ost_pm radius;  /* radius of the ball, at most 1 m; 0 for a half space */
    ost_pm3 normal; /* normal of the plane, not zero; each component is from -10^12 to 10^12 */
} ost_segment_cut;

enum { OST_SEGMENT_LABELS_MAX = 32767 };
#define OST_SEGMENT_SEPARATE_MAX (65 * OST_PM_PER_MM)
/* Options of a segmentation. A zero-initialised struct selects the defaults. */
typedef struct ost_segment_options {
    int32_t threshold;     /* every component contains a voxel with at least this density, 1 to 32767; 0 selects 120 */
    /* Lowest density of the voxels of a component, at most the threshold; 0 selects the threshold. */
    int32_t growth;
    const ost_segment_cut *cuts;
    size_t cut_count;
    uint64_t min_voxels;   /* components with fewer voxels get no label */
    bool fill;             /* true to give holes that contain no air the label of the surrounding bone */
    int32_t air;           /* a hole that contains a voxel below this density is not filled */
    /*
     * Depth of a neck, 1 um to OST_SEGMENT_SEPARATE_MAX, or 0 to divide no components. A component is divided at a neck
     * if, on both sides of the neck, the radius of the bone exceeds the radius of the neck by at least this depth.
     */
    ost_pm separate;
} ost_segment_options;

/* A component. The label of a component is its index + 1. */
typedef struct ost_segment {
    uint64_t voxels;       /* number of voxels, excluding filled holes */
    uint64_t filled;       /* number of voxels in filled holes */
    ost_voxel_box box;     /* bounds of the component */
    int32_t first[3];      /* first voxel of the component in the order of the grid, x fastest */
} ost_segment;

/*
 * Finds the components of a CT (AR-SEG-1 to AR-SEG-5). If the option `separate` is set, the components are divided at
 * necks (AR-SEG-7 to AR-SEG-9). *labels is a volume with the geometry of the CT; each of its voxels contains a label,
 * or 0. *out is an array of the components in descending order of size; components of equal size are in order of their
 * first voxels. Returns OST_ERR_USAGE if the CT has no voxels. Returns OST_ERR_RANGE if an option is out of range or
 * more than OST_SEGMENT_LABELS_MAX components have at least min_voxels, and OST_ERR_MEMORY if memory is exhausted. The
 * caller frees *labels with ost_volume_free and *out with ost_segments_free.
 */
OST_API ost_status ost_segment_volume(const ost_volume *ct, const ost_segment_options *options, ost_volume *labels,
                                      ost_segment **out, size_t *count, ost_error *err);
/* Returns the label of the voxel that contains a position. Returns -1 if the position is outside the grid. */
OST_API int ost_segment_label_at(const ost_volume *labels, ost_pm3 at);
/*
 * Finds the voxel nearest to a position among all voxels with a label (AR-SEG-10). Returns its label, and stores
 * its centre in *found. Returns 0 if no voxel has a label. `at` must be within OST_LENGTH_MAX.
 */
OST_API int ost_segment_label_near(const ost_volume *labels, ost_pm3 at, ost_pm3 *found);
/*
 * Removes each component k for which keep[k] is false. Numbers the labels of the remaining components from 1, in
 * unchanged order (AR-SEG-10). labels, segments and *count are results of ost_segment_volume. The only error is
 * OST_ERR_MEMORY; nothing is then changed.
 */
OST_API ost_status ost_segments_keep(ost_volume *labels, ost_segment *segments, size_t *count, const bool *keep,
                                     ost_error *err);
/* Frees a list of components. */
OST_API void ost_segments_free(ost_segment *segments);

#ifdef __cplusplus
}
#endif
#endif
