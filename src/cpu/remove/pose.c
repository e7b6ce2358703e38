/* SPDX-License-Identifier: Apache-2.0 */
/* Computes the kernels' constants of a pose from the steps of the pose's map. remove.h proves the formulas. */
#include <string.h>

#include "core/conditions.h"
#include "cpu/kernels.h"

/*
 * Returns (2 R)^2, where R is half the longest diagonal of a bone cube with `edge` voxels per side, in tool coordinates
 * (remove.h, "Split"). With |step| <= 2^24 + 1 (AR-MAP-3) and edge <= 8, the result is below 3 * (7 * 3 * 2^24 + 63)^2
 * < 2^59.
 */
static int64_t diameter_squared(const int32_t step[3][3], int32_t edge)
{
    int64_t greatest = 0;
    for (int signs = 0; signs < 4; signs++) {
        int64_t squared = 0;
        for (int a = 0; a < 3; a++) {
            const int64_t d = (int64_t)(edge - 1) * (step[0][a] + (signs & 1 ? -(int64_t)step[1][a] : step[1][a]) +
                                                     (signs & 2 ? -(int64_t)step[2][a] : step[2][a]));
            squared += d * d;
        }
        greatest = squared > greatest ? squared : greatest;
    }
    return greatest;
}

/*
 * Returns the smallest v in 1..127 with v * unit > R + 2, that is, 2 v unit - 4 > 2 R. `squared` is (2 R)^2. Returns
 * 128 if there is no such v. unit <= 2^21, so the squares are below 2^60.
 */
static int32_t least_for(int64_t squared, int32_t unit)
{
    int32_t lo = 1, hi = 128;
    while (lo < hi) {
        const int32_t v = (lo + hi) / 2;
        const int64_t reach = 2 * (int64_t)v * unit - 4;
        if (reach > 0 && reach * reach > squared)
            hi = v;
        else
            lo = v + 1;
    }
    return lo;
}

void ost_split_make(const int32_t step[3][3], int32_t edge, const ost_cells *cells, ost_split *out)
{
    const int32_t half = edge / 2;
    for (int a = 0; a < 3; a++) {
        /* |sum of the steps| < 2^25 and half - 1 < 8, so the product fits in int32. The shift rounds down. */
        const int32_t centre = ((half - 1) * (step[0][a] + step[1][a] + step[2][a])) >> 1;
        for (int part = 0; part < 8; part++) {
            out->first[a][part] = half * ((part & 1 ? step[0][a] : 0) + (part & 2 ? step[1][a] : 0) +
                                          (part & 4 ? step[2][a] : 0));
            out->centre[a][part] = out->first[a][part] + centre;
        }
    }
    out->least = least_for(diameter_squared(step, half), cells->unit);
}

static int32_t below_zero(int32_t x)
{
    return x < 0 ? x : 0;
}

static int32_t magnitude(int32_t x)
{
    return x < 0 ? -x : x;
}

/* Returns true if the tool has windows of this edge and the steps satisfy the conditions of "Match" in remove.h. If the
   tool has such windows, the steps of a map (ost_map) always satisfy the conditions; other steps may not. */
static bool windows_hold(const int32_t step[3][3], const ost_windows *windows, int32_t edge)
{
    const int64_t radius_twice = (edge == 8 ? INT64_C(72) : INT64_C(150)) * (1 << OST_MAP_FRACTION) / 10;
    if (windows->step == 0 || diameter_squared(step, 4) > radius_twice * radius_twice)
        return false;
    for (int a = 0; a < 3; a++)
        if (3 * ((int64_t)magnitude(step[0][a]) + magnitude(step[1][a]) + magnitude(step[2][a])) >=
            (int64_t)(edge - windows->step) << OST_MAP_FRACTION)
            return false;
    return true;
}

void ost_match_make(const int32_t step[3][3], const ost_shape *shape, ost_match *out)
{
    out->shape = shape;
    out->windows = windows_hold(step, &shape->windows, 8);
    out->wide = windows_hold(step, &shape->wide, 16);
    for (int a = 0; a < 3; a++) {
        out->lowest[a] = 3 * (below_zero(step[0][a]) + below_zero(step[1][a]) + below_zero(step[2][a]));
        for (int row = 0; row < 16; row++) {
            const int32_t first = (row & 3) * step[1][a] + (row >> 2) * step[2][a];
            for (int x = 0; x < 4; x++)
                out->offset[a][4 * row + x] = first + x * step[0][a];
        }
    }
}

void ost_match_ties(ost_match *match)
{
    enum { LOW = OST_MAP_FRACTION - OST_TIE_BITS, TIES = 1 << OST_TIE_BITS };
    if (!match->windows)
        return;
    memset(match->tie, 0, sizeof match->tie);
    memset(match->near_tie, 0, sizeof match->near_tie);
    for (int a = 0; a < 3; a++) {
        for (int v = 0; v < 64; v++) {
            const uint32_t offset = (uint32_t)(match->offset[a][v] - match->lowest[a]);
            match->high[a][v] = (uint16_t)(offset >> LOW);
            match->low[a][v] = (uint16_t)(offset & ((1 << LOW) - 1));
        }
        for (int v = 0; v < 64; v++) {
            const uint32_t tie = (TIES - 1 - match->high[a][v]) & (TIES - 1);
            match->tie[tie] |= (uint8_t)(1 << a);
            match->near_tie[a][tie * OST_NEAR_TIES / TIES / 32] |= UINT32_C(1) << (tie * OST_NEAR_TIES / TIES % 32);
        }
    }
}
