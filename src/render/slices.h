/* SPDX-License-Identifier: Apache-2.0 */
/* Draws three slices with a scale bar and the directions of the axes. A callback provides the colours.
   ost_picture_slices and the pictures of differences use this code. */
#ifndef OST_RENDER_SLICES_H
#define OST_RENDER_SLICES_H

#include <osteon/picture.h>

/* Computes the colour of voxel number `voxel` of the volume: red, green and blue, each from 0 to 255. */
typedef void ost_slices_colour(const void *user, size_t voxel, double rgb[3]);
/*
 * Returns the colour 0xBBGGRR of the region that contains voxel number `voxel`, or OST_NO_REGION if no region contains
 * it.
 */
typedef uint32_t ost_slices_region(const void *user, size_t voxel);
enum { OST_NO_REGION = 0x7fffffff };

typedef struct ost_slices_paint {
    ost_slices_colour *colour;
    /* callback that returns the region of a voxel; each region is outlined along its inner side; NULL for no regions */
    ost_slices_region *region;
    const void *user;
    /* true to give each pixel the colour of one voxel; false to interpolate colours between voxel centres */
    bool by_voxel;
    bool unoriented; /* true if the directions of the axes are unknown and are therefore not drawn */
} ost_slices_paint;

enum { OST_SLICES_GAP = 8 };                           /* distance between two slices in pixels */
/* default centre and width, in HU, of the grey window for bone */
enum { OST_SLICES_LEVEL = 400, OST_SLICES_WIDTH = 1800 };
/* Draws the slices through the voxel at[]. The longest side of a slice has `pixels` pixels; 0 means the default,
   480. Returns OST_ERR_RANGE if the voxel is outside the grid. */
ost_status ost_slices_draw(const ost_geometry *geometry, const int32_t at[3], int pixels, const ost_slices_paint *paint,
                           ost_picture *out, ost_error *err);

#endif
