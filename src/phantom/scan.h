/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Declarations that all generated bones share: the grid to fill, and the functions that generate a bone.
 */
#ifndef OST_PHANTOM_SCAN_H
#define OST_PHANTOM_SCAN_H

#include <osteon/phantom.h>

#include "phantom/shape.h"

/*
 * The grid to fill. The right side is always generated. If the left side is requested, the right side is mirrored
 * at the end, row by row.
 */
typedef struct ost_scan {
    ost_volume *volume; /* volume with the geometry of the right side */
    ost_pm3 corner;     /* twice the corner of the first voxel: 2 origin - spacing, which is an integer */
    ost_pm3 extent;     /* twice the corner of the first voxel of the grid to which the noise is aligned */
    double scale;       /* factor by which the anatomy is enlarged */
    uint64_t seed;
    bool has_humerus;   /* true if a humerus touches the glenoid */
    const ost_phantom_options *options; /* options of the phantom, used for progress */
} ost_scan;

#define OST_SCAN_HEAD "phantom_head_mm" /* header fact: centre of the humeral head */

/*
 * Returns the coordinate, in mm, of the centre of voxel v along an axis. In picometres, twice the coordinate is
 * corner2 + (2 v + 1) spacing.
 */
static inline double ost_scan_mm(ost_pm corner2, ost_pm spacing, int64_t v)
{
    return (double)(corner2 + (2 * v + 1) * spacing) / 2e9;
}

ost_status ost_scan_scapula(const ost_scan *scan, ost_error *err);
ost_status ost_scan_core(const ost_scan *scan, ost_phantom_kind kind, ost_error *err);

/*
 * Calls the function `block` for boxes lo <= (i, j, k) < hi that partition the grid, on several threads at once. The
 * function may therefore write only the voxels of its box, and nothing else in *user. `mm` is the approximate width of
 * a box in millimetres before the anatomy is scaled. Returns OST_ERR_CANCELLED if the progress callback cancels the
 * computation. The callback is called on the calling thread.
 */
ost_status ost_scan_blocks(const ost_scan *scan, double mm,
                           void (*block)(void *user, const int lo[3], const int hi[3]), void *user, ost_error *err);

/*
 * Returns the partial volume, which is the part of a voxel inside a surface. d is the signed distance from the
 * surface, negative inside. From d = -0.75 width to d = 0.75 width, the result falls from 1 to 0.
 */
static inline double ost_scan_cover(double d, double width)
{
    return ost_smooth(-0.75 * width, 0.75 * width, -d);
}

/* Rounds v half up and clamps it to [lo, hi]. The sum v + 1/2 is exact, because |v| < 2^15. */
int16_t ost_hu(double v, int lo, int hi);

#endif
