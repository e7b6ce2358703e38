/* SPDX-License-Identifier: Apache-2.0 */
/* Draws three slices, coloured by a callback, with a scale bar and directions. Used by ost_picture_slices and for
   pictures of differences. */
#ifndef OST_RENDER_SLICES_H
#define OST_RENDER_SLICES_H

#include <osteon/picture.h>

/* Computes the colour of the voxel with the given index in the volume, as red, green and blue values from 0 to 255. */
typedef void ost_slices_colour(const void *user, size_t voxel, double rgb[3]);
/* Returns the colour, 0xBBGGRR, of the region that contains the voxel with this index, or OST_NO_REGION. */
typedef uint32_t ost_slices_region(const void *user, size_t voxel);
enum { OST_NO_REGION = 0x7fffffff };

typedef struct ost_slices_paint {
    ost_slices_colour *colour;
    /*
     * the function that returns the region of a voxel; NULL if there are no regions; each region is outlined along its
     * inner side
     */
    ost_slices_region *region;
    const void *user;
    /* true if each pixel has the colour of one voxel; if false, colours are interpolated between voxel centres */
    bool by_voxel;
    bool unoriented; /* true if the directions of the axes are unknown; no directions are then drawn */
} ost_slices_paint;

enum { OST_SLICES_GAP = 8 };                           /* distance between two slices in pixels */
enum { OST_SLICES_LEVEL = 400, OST_SLICES_WIDTH = 1800 }; /* default window for densities of bone, in HU */
/* Draws the slices through the voxel at[]. The longest side of a slice has `pixels` pixels; 0 means 480. Returns
   OST_ERR_RANGE if the voxel is outside the grid. */
ost_status ost_slices_draw(const ost_geometry *geometry, const int32_t at[3], int pixels, const ost_slices_paint *paint,
                           ost_picture *out, ost_error *err);

#endif
