/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Transforms a file's axes to LPS+ (x to the patient's Left, y Posterior, z Superior) by permutation and flips, never
 * by resampling.
 *
 *   An affine gives the position of the file's voxel (i, j, k):
 *
 *     p = origin + i * column[0] + j * column[1] + k * column[2]     (LPS, pm)
 *
 *   File axis a runs along the LPS axis to[a], backwards if flip[a].  The
 *   permutation `to` maximises the product over a of |column[a][to[a]]|; of several
 *   such permutations, the first in the order xyz xzy yxz yzx zxy zyx is used.  The
 *   choice depends only on integers.
 *
 *   A grid is straight if, on each axis, every voxel centre is within 1/8 of a voxel of its
 *   position in an axis-parallel grid.  Let off(a, w) be the component of column a along w
 *   that should be 0, and n_a the number of voxels along file axis a.  The condition for each
 *   axis w is:
 *
 *     sum over a of |off(a, w)| * max(n_a - 1, 64) <= spacing_w / 8
 *
 *   At least 64 steps are assumed, so that a real tilt is also found in a thin stack.  A grid
 *   that is not straight is oblique; its angle is reported to the user.
 */
#ifndef OST_IO_ORIENT_H
#define OST_IO_ORIENT_H

#include <osteon/grid.h>

typedef struct ost_affine {
    ost_pm column[3][3]; /* step from voxel to voxel along each file axis, in LPS: [file axis][L, P, S], in pm */
    ost_pm origin[3];    /* centre of the file's voxel (0, 0, 0) */
} ost_affine;

typedef struct ost_placement {
    int to[3];
    bool flip[3];
    bool reoriented;       /* true if the file's axes are permuted or flipped */
    bool oblique;          /* true if the grid is oblique; `geometry` is then not meaningful */
    double degrees;        /* maximum angle in degrees between a file axis and its LPS axis, for messages */
    char code[4];          /* directions of the file's axes, for example "LPS" or "RAS" */
    ost_geometry geometry; /* geometry of the grid in LPS+ order */
    int64_t base;          /* index of the file's voxel (0, 0, 0) in the result */
    int64_t stride[3];     /* for each file axis, the step in the result between neighbouring voxels */
} ost_placement;

/*
 * Converts an affine transform to LPS. `code` states the directions of its three coordinates. It consists of one letter
 * each from L or R, P or A, and S or I, in any order. For any other code, returns false and leaves the affine
 * unchanged.
 */
bool ost_affine_restate(ost_affine *affine, const char code[4]);

/*
 * Computes the placement. `sizes` are in the file's order. Returns OST_ERR_INPUT if the columns are linearly dependent.
 * Returns OST_ERR_RANGE if the grid is straight and ost_geometry_check returns this status for its geometry.
 */
ost_status ost_orient(const ost_affine *affine, const int32_t sizes[3], ost_placement *out, ost_error *err);

/* Returns the index that voxel (i, j, k) of the file has in the result. */
static inline int64_t ost_placement_element(const ost_placement *p, int32_t i, int32_t j, int32_t k)
{
    return p->base + i * p->stride[0] + j * p->stride[1] + k * p->stride[2];
}

#endif
