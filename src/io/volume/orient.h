/* SPDX-License-Identifier: Apache-2.0 */
/*
 * From a file's axes to LPS+ (x to the patient's Left, y Posterior, z
 * Superior): permuted and flipped, never resampled.
 *
 *   An affine says where the file's voxel (i, j, k) lies:
 *
 *     p = origin + i * column[0] + j * column[1] + k * column[2]     (LPS, pm)
 *
 *   File axis a runs along the LPS axis to[a], backwards when flip[a].  The
 *   permutation is the one whose product |column[a][to[a]]| is greatest (the
 *   first in the order xyz xzy yxz yzx zxy zyx among equals), so it depends on
 *   integers only.
 *
 *   A grid is straight when no voxel centre lies more than 1/8 of a voxel from
 *   the straight grid's along any axis: with off(a, w) the component of column
 *   a that should be 0, sum over a of |off(a, w)| * max(n_a - 1, 64) <=
 *   spacing_w / 8.  (At least 64 steps count, so that a thin stack cannot hide
 *   a real tilt.)  Whatever is beyond is oblique, with its angle for people.
 */
#ifndef OST_IO_ORIENT_H
#define OST_IO_ORIENT_H

#include <osteon/grid.h>

typedef struct ost_affine {
    ost_pm column[3][3]; /* [file axis][L, P, S] */
    ost_pm origin[3];    /* centre of the file's voxel (0, 0, 0) */
} ost_affine;

typedef struct ost_placement {
    int to[3];
    bool flip[3];
    bool reoriented;       /* anything but the identity */
    bool oblique;          /* then geometry is not meaningful */
    double degrees;        /* greatest angle between a file axis and its LPS axis; for people */
    char code[4];          /* where the file's axes point, "LPS", "RAS", ... */
    ost_geometry geometry; /* of the grid in LPS+ order */
    int64_t base;          /* element of the result that the file's voxel (0, 0, 0) becomes */
    int64_t stride[3];     /* and how it moves along the file's axes */
} ost_placement;

/*
 * Takes an affine whose three coordinates point to the letters of code, one of
 * L R, one of P A and one of S I in any order, to LPS. Returns false, with
 * the affine unchanged, if code is anything else.
 */
bool ost_affine_restate(ost_affine *affine, const char code[4]);

/* sizes as in the file. OST_ERR_INPUT when the columns do not span space; OST_ERR_RANGE by ost_geometry_check when straight. */
ost_status ost_orient(const ost_affine *affine, const int32_t sizes[3], ost_placement *out, ost_error *err);

/* Result element of the file's voxel (i, j, k). */
static inline int64_t ost_placement_element(const ost_placement *p, int32_t i, int32_t j, int32_t k)
{
    return p->base + i * p->stride[0] + j * p->stride[1] + k * p->stride[2];
}

#endif
