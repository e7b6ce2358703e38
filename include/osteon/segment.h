/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Divides a CT into bones: connected components of dense voxels, as a label map.
 *
 *   CT --threshold, growth--> candidates --cuts--> components --> labels, a row for each
 *
 * Only integers decide a label (docs/spec/arithmetic.md, AR-SEG), so that the label map is
 * equal on every machine.  ost_import accepts such a label map, or any other one on the
 * CT's grid, as a mask (io.h).
 *
 * Threads: the functions have no state and may run on any thread; a volume that is passed
 * as const may be shared.
 */
#ifndef OSTEON_SEGMENT_H
#define OSTEON_SEGMENT_H

#include <osteon/event.h>
#include <osteon/grid.h>

#ifdef __cplusplus
extern "C" {
#endif

/*
 * A ball or a half space that separates two bones which touch: its voxels belong to no
 * component.  A half space is the side of a plane to which the normal points; the plane
 * itself belongs to it.  Only the direction of the normal matters, not its length.
 */
typedef struct ost_segment_cut {
    ost_pm3 at;     /* centre of the ball, or a point of the plane, LPS */
    ost_pm radius;  /* of the ball, at most 1 m; 0: a half space */
    ost_pm3 normal; /* of the plane, each component from -10^12 to 10^12, not 0 */
} ost_segment_cut;

enum { OST_SEGMENT_LABELS_MAX = 32767 };
/* Options of a segmentation; zero for the defaults. */
typedef struct ost_segment_options {
    int32_t threshold;     /* 1..32767; a component has at least one voxel of this density; 0 = 120 */
    int32_t growth;        /* its other voxels have at least this density; at most the threshold; 0 = the threshold */
    const ost_segment_cut *cuts;
    size_t cut_count;
    uint64_t min_voxels;   /* smaller components get no label */
    bool fill;             /* holes without air get the label of the bone around them */
    int32_t air;           /* a hole that has a voxel below this density is not filled */
} ost_segment_options;

/* A component; its label is its index + 1. */
typedef struct ost_segment {
    uint64_t voxels;       /* number of voxels, without those of filled holes */
    uint64_t filled;       /* number of voxels of its filled holes */
    ost_voxel_box box;     /* bounds of the component */
    int32_t first[3];      /* the first of its voxels, x fastest */
} ost_segment;

/*
 * Finds the components of a CT (AR-SEG-1 to AR-SEG-5).  *labels gets the CT's geometry and,
 * for each voxel, its label, or 0.  *out gets the components, the largest first; components
 * of equal size are in the order of their first voxels.  Returns OST_ERR_RANGE if an option
 * is out of its range or more than OST_SEGMENT_LABELS_MAX components are large enough,
 * OST_ERR_MEMORY if memory runs out.  The caller frees *labels by ost_volume_free and *out
 * by ost_segments_free.
 */
OST_API ost_status ost_segment_volume(const ost_volume *ct, const ost_segment_options *options, ost_volume *labels,
                                      ost_segment **out, size_t *count, ost_error *err);
/* Frees a list of components. */
OST_API void ost_segments_free(ost_segment *segments);

#ifdef __cplusplus
}
#endif
#endif
