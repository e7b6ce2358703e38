/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Common parts of the generated bones: the box that is scanned, and the makers.
 */
#ifndef OST_PHANTOM_SCAN_H
#define OST_PHANTOM_SCAN_H

#include <osteon/phantom.h>

#include "phantom/shape.h"

/*
 * The grid to fill.  The right side is always what is generated; the left
 * is its mirror image, row by row, when everything is done.
 */
typedef struct ost_scan {
    ost_volume *volume; /* its geometry is the right side's */
    ost_pm3 corner;     /* of the first voxel: origin - spacing / 2, doubled to stay whole */
    ost_pm3 whole;      /* likewise, of the grid that noise is counted from */
    double scale;       /* of the anatomy */
    uint64_t seed;
} ost_scan;

/* Twice the coordinate of voxel v's centre along an axis, pm: doubled corner + (2 v + 1) spacing. In mm: */
static inline double ost_scan_mm(ost_pm corner2, ost_pm spacing, int64_t v)
{
    return (double)(corner2 + (2 * v + 1) * spacing) / 2e9;
}

ost_status ost_scan_scapula(const ost_scan *scan, ost_error *err);
ost_status ost_scan_core(const ost_scan *scan, ost_phantom_kind kind, ost_error *err);

/* Calls block for boxes lo <= (i, j, k) < hi of about mm of the anatomy, which together are the grid, each voxel once. */
void ost_scan_blocks(const ost_scan *scan, double mm, void (*block)(void *user, const int lo[3], const int hi[3]), void *user);

/* Share of a voxel on the inner side of a surface at signed distance d, blurred over `width`: partial volume. */
static inline double ost_scan_cover(double d, double width)
{
    return ost_smooth(-0.75 * width, 0.75 * width, -d);
}

/* Rounds half up (the sum is exact: |v| < 2^15) into [lo, hi]. */
int16_t ost_hu(double v, int lo, int hi);

#endif
