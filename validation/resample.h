/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Computes rule AR-CUB (resampling) along one axis, to explain differences. The results are the rect voxels
 * from which a cubic voxel is computed, and the division that selects them. For cubic voxel i, cubic
 * spacing c and rect spacing s:
 *
 *   linear    t = ((2i + 1) c - s) / (2s), clamped; voxel floor(t), and the next with weight RHE(2^15 (t - floor(t)))
 *   nearest   floor((2i + 1) c / (2s)), limited to the last voxel
 *   thesis    floor(i c / s)
 */
#ifndef OST_VALIDATION_RESAMPLE_H
#define OST_VALIDATION_RESAMPLE_H

#include <osteon/backend.h>

#include "core/integer.h"

enum { RESAMPLE_ONE = 1 << 15 };

typedef struct resample_tap {
    int64_t top, bottom; /* numerator and denominator of the source position, before clamping; bottom > 0 */
    int64_t index;
    /* weight of voxel index + 1 in units of 1 / RESAMPLE_ONE; if the weight is 0, voxel index + 1 is not read */
    int64_t weight;
} resample_tap;

/* Returns the source of cubic voxel i in a row of n rect voxels. i is below 2^14 and the spacings cubic and rect are
   below 2^37, so top is below 2^52. */
static inline resample_tap resample_at(int64_t i, ost_pm cubic, ost_pm rect, int32_t n, ost_resample rule)
{
    resample_tap tap = {.top = (2 * i + 1) * cubic, .bottom = 2 * rect};
    if (rule == OST_RESAMPLE_THESIS)
        tap.top = 2 * i * cubic;
    else if (rule == OST_RESAMPLE_LINEAR)
        tap.top -= rect;
    tap.index = ost_floor_div(tap.top, tap.bottom);
    if (tap.index < 0) {
        tap.index = 0;
    } else if (tap.index >= n - 1) {
        tap.index = n - 1;
    } else if (rule == OST_RESAMPLE_LINEAR) {
        tap.weight = ost_rhe_div((tap.top - tap.index * tap.bottom) * RESAMPLE_ONE, tap.bottom);
    }
    return tap;
}

/* Returns the origin of the cubic grid (AR-CUB-1). */
static inline ost_pm3 resample_origin(const ost_geometry *rect, ost_pm cubic)
{
    return (ost_pm3){rect->origin.x + ost_rhe_div(cubic - rect->spacing.x, 2),
                     rect->origin.y + ost_rhe_div(cubic - rect->spacing.y, 2),
                     rect->origin.z + ost_rhe_div(cubic - rect->spacing.z, 2)};
}

/* Returns the spacing of a campaign's second resampling (TRACE_RESAMPLE). */
static inline ost_pm resample_again(ost_pm cubic)
{
    return cubic * 7 / 5;
}

/* Finds one of the eight rect voxels around a cubic voxel's centre. Along axis a, the rect voxel's index is
   tap[a].index or, if bit a of `corner` is set, the next index. Returns the voxel's weight in units of 2^-45. */
static inline int64_t resample_corner(const resample_tap tap[3], int corner, int64_t at[3])
{
    int64_t weight = 1;
    for (int a = 0; a < 3; a++) {
        const int next = corner >> a & 1;
        at[a] = tap[a].index + next;
        weight *= next ? tap[a].weight : RESAMPLE_ONE - tap[a].weight;
    }
    return weight;
}

#endif
