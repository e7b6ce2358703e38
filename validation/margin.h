/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How near a decision was, for every voxel that another program decided
 * otherwise than the reference: 'only rounding at borders' as a figure.
 *
 *        void | solid        u   where the reference has the point, in units of
 *         u   |              2^-20 of a voxel, integers
 *         .-->|              margin: how far it lies from the nearest border behind
 *          m  |              which the other's answer would be right, on the axis
 *                            on which it is farthest (Chebyshev distance)
 *
 *   stage   the point, and its border                              unit
 *   rect    a sample on the lattice; half-way to the next voxel    2^-20 voxel of the CT
 *   cubic   i cubic / rect; the next layer with the other's value  2^-20 voxel of the CT
 *   chunks  a density; the threshold, where the two are equal      on the border
 *   tool    a voxel's centre; the mesh                             2^-20 voxel of the tool
 *   tick    a bone voxel's centre by AR-MAP; the nearest tool voxel of the other kind,
 *           over the poses of the event                            2^-20 voxel of the tool
 *
 * A voxel counts where it first differs.  One that differs because what the
 * stage was given differs already (the rect grid, the tool) is inherited.  A
 * density below the threshold that was kept has no border.  What no border
 * explains is counted as such: it is refuted that rounding did it.
 */
#ifndef OST_VALIDATION_MARGIN_H
#define OST_VALIDATION_MARGIN_H

#include <jansson.h>

#include "validation/compare.h"
#include "validation/scene.h"

enum {
    MARGIN_ONE = 1 << 20, /* a voxel */
    MARGIN_BINS = 22      /* 0: on the border; b: 2^(b-1) <= m < 2^b; the last: a voxel and more */
};

typedef struct margin_stage {
    uint64_t records; /* compared */
    uint64_t reports; /* of them, those whose report differs */
    uint64_t voxels;  /* that differ: the sum of the five below */
    uint64_t decided; /* with a margin */
    uint64_t inherited, below_threshold, unexplained, unmeasured;
    uint64_t bins[MARGIN_BINS];
    uint64_t max; /* of decided */
    uint32_t max_item;
    int32_t max_voxel[3];
} margin_stage;

typedef struct margins {
    margin_stage of[TRACE_STAGES];
} margins;

/* Both traces of one case. apart: the other was given the reference's input at every stage (perform_apart), so nothing is inherited. */
ost_status margins_of(const scene *s, const trace *ref, compare_range in_ref, const trace *got, compare_range in_got, bool apart, margins *out,
                      ost_error *err);

/* Adds b's figures to a's. */
void margins_add(margins *a, const margins *b);

/* [{"stage", "voxels", ..., "max", "bins"}], stages without a difference left out. */
json_t *margins_json(const margins *m);

/* "0.000123 of a tool voxel" */
const char *margin_unit(trace_stage stage);

#endif
