/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A coarse grid that stores the share of bone in each cell, from 0 to 1.
 *
 *   voxels --blocks of about step mm--> shares --fill, smooth--> field --trilinear--> share at a point
 *
 * The functions of this folder compute with doubles and use only additions, multiplications, divisions and square
 * roots, in a fixed order. Therefore the results are the same on every machine. Lengths are in mm, in the frame of the
 * volume (LPS).
 */
#ifndef OST_ANATOMY_FIELD_H
#define OST_ANATOMY_FIELD_H

#include <osteon/anatomy.h>

typedef struct anatomy_field {
    int32_t n[3];            /* number of cells along each axis */
    double origin[3], step[3]; /* centre of cell (0, 0, 0), and size of a cell */
    float *share;            /* owned; share of bone in each cell, x fastest */
} anatomy_field;

typedef struct anatomy_box {
    double lo[3], hi[3];
} anatomy_box;

/*
 * Computes the field for the part of a bone within a box, or for the complete bone if box is NULL. A cell is a block of
 * complete voxels about `step` mm wide. The cells are made wider if there would otherwise be more than 2^24 cells.
 * Returns OST_ERR_INPUT if the box contains no voxel.
 */
ost_status ost_anatomy_field_make(const ost_anatomy_bone *bone, const anatomy_box *box, double step, anatomy_field *out,
                                  ost_error *err);
void ost_anatomy_field_free(anatomy_field *field);

/*
 * Fills the cavities of the bone. A cavity is a connected set of cells with shares below 0.5 that does not reach the
 * border of the field. Sets the share of each cell of a cavity to 1.
 */
ost_status ost_anatomy_field_fill(anatomy_field *field, ost_error *err);
/*
 * Smooths the field along each axis with the weights 1/4, 1/2, 1/4. Axes whose cells are more than 1.5 times as wide
 * as the narrowest cells are skipped.
 */
ost_status ost_anatomy_field_smooth(anatomy_field *field, ost_error *err);

static inline size_t anatomy_field_index(const anatomy_field *f, int32_t x, int32_t y, int32_t z)
{
    return (size_t)x + (size_t)f->n[0] * ((size_t)y + (size_t)f->n[1] * (size_t)z);
}

/* Returns the share at a point by trilinear interpolation. Outside the field, the share is 0. */
double ost_anatomy_field_at(const anatomy_field *field, const double at[3]);
/* Computes the gradient at a point, per mm, by central differences over one cell on each side. */
void ost_anatomy_field_gradient(const anatomy_field *field, const double at[3], double out[3]);

/* Returns floor(v), for |v| < 2^53. */
static inline int64_t anatomy_floor(double v)
{
    const int64_t n = (int64_t)v;
    return n - ((double)n > v);
}

/* Rounds a length in mm to 0.01 mm. */
static inline ost_pm anatomy_round(double mm)
{
    return anatomy_floor(mm * 100 + 0.5) * (OST_PM_PER_MM / 100);
}

#endif
