/* SPDX-License-Identifier: Apache-2.0 */
/*
 * For every voxel in which another program differs from the reference, computes how near the reference was
 * to the other result. This quantifies the statement "only rounding at borders".
 *
 *       empty | solid        u   position of the point as the reference computes
 *         u   |              it, an integer in units of 2^-20 of a voxel
 *         .-->|              margin: distance to the nearest border beyond which
 *          m  |              the other result would be right, measured along the
 *                            axis on which it is largest (Chebyshev distance)
 *
 *   stage   point                         border                                       unit of the margin
 *   rect    a sample on the lattice       the point half-way to the next voxel         2^-20 voxel of the CT
 *   cubic   the source position           the next layer with the other backend's      2^-20 voxel of the CT
 *           i cubic / rect                value
 *   chunks  a density                     the threshold, if the density equals it      none; the margin is 0
 *   tool    a voxel's centre              the mesh                                     2^-20 voxel of the tool
 *   tick    a bone voxel's centre by      the nearest tool voxel that gives the        2^-20 voxel of the tool
 *           AR-MAP                        other result, over the poses of the event
 *
 * A voxel is counted at the stage at which it first differs. It is counted as
 * inherited if the stage's input (the rect grid, the tool) already differs. A
 * density below the threshold that was not set to 0 has no border. A difference for
 * which there is no border is counted as unexplained: rounding cannot be its cause.
 */
#ifndef OST_VALIDATION_MARGIN_H
#define OST_VALIDATION_MARGIN_H

#include <jansson.h>

#include "validation/compare.h"
#include "validation/scene.h"

enum {
    MARGIN_ONE = 1 << 20, /* length of one voxel in the unit of margins */
    /*
     * The number of bins of a histogram. Bin 0 contains margins of 0, bin b contains margins with 2^(b-1) <= margin <
     * 2^b, and the last bin contains margins of one voxel or more.
     */
    MARGIN_BINS = 22
};

typedef struct margin_stage {
    uint64_t records; /* number of records compared */
    uint64_t reports; /* number of compared records whose reports differ */
    uint64_t voxels;  /* number of voxels that differ, the sum of the next five members */
    uint64_t decided; /* number of differing voxels for which a margin was computed */
    uint64_t inherited, below_threshold, unexplained, unmeasured;
    uint64_t bins[MARGIN_BINS];
    /* greatest margin, and the record and the voxel that have it */
    uint64_t max;
    uint32_t max_item;
    int32_t max_voxel[3];
} margin_stage;

typedef struct margins {
    margin_stage of[TRACE_STAGES];
} margins;

/* Computes the margins of one case from its two traces. If `apart` is true, the other backend got the reference's input
   at every stage (perform_apart), so no difference is inherited. */
ost_status margins_of(const scene *s, const trace *ref, compare_range in_ref, const trace *got, compare_range in_got,
                      bool apart, margins *out, ost_error *err);

/* Adds the counts of b to those of a. Sets the maximum of a to the greater of the two maxima. */
void margins_add(margins *a, const margins *b);

/* Returns [{"stage", "voxels", ..., "max", "bins"}], without the stages in which neither a voxel nor a report differs.
   The caller owns the array. */
json_t *margins_json(const margins *m);

/* Returns the unit in which a stage's margins are given, such as "tool voxel". */
const char *margin_unit(trace_stage stage);

#endif
