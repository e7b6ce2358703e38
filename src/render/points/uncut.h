/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The uncut bone, with which the current bone is compared. It contains the CT's densities, from
 * which paint is computed.
 *
 *   densities --class, density---------> paint of voxels exposed by a tool
 *   bits before --distance to outside--> paint of the same voxels, by depth
 *   densities --window-----------------> paint of voxels exposed by a clip plane
 *
 * A paint is a number that a palette maps to a colour (palette.h): 0 is the object's own colour, 1
 * .. 127 are lit like the surface, and 128 .. 255 are shown without lighting.
 *
 * Depth is the distance from the voxel's centre to the nearest centre of a voxel outside the bone, minus half a voxel.
 * Depths are exact up to 32 voxels. A voxel counts as outside if it is not bone and a cube of 2^3 voxels can move from
 * the grid's border to within two voxels of it. Pores in the bone therefore do not count as outside. The voxels beyond
 * the grid are not known, so a bone that was cropped has no surface at the grid's border.
 */
#ifndef OST_RENDER_UNCUT_H
#define OST_RENDER_UNCUT_H

#include <osteon/event.h>

#include "render/points/palette.h"
#include "render/points/surface.h"

/* OST_DEPTH_REACH is the greatest depth in voxels, and OST_DEPTH_FAR is its square. */
enum { OST_DEPTH_REACH = 32, OST_DEPTH_FAR = OST_DEPTH_REACH * OST_DEPTH_REACH };

typedef struct ost_uncut {
    ost_volume volume;      /* owned */
    int32_t threshold;
    /* set if the bone before the operation is unavailable; the entire surface is then painted */
    bool uncut;
    int32_t classes, border[OST_CLASS_MAX];
    bool has_face;          /* true if `face` and `inward` are valid */
    /*
     * `face` is the middle of the glenoid's face in voxels, and `inward` the unit vector from this point into the bone
     */
    double face[3], inward[3];
    double scale_mm;        /* depth of the last colour of the scale, in mm */
    uint8_t level[OST_DEPTH_FAR + 1]; /* paint number for each squared distance */
    /* owned; one entry per cube of 2^3 voxels; NULL before a depth is needed for the first time */
    uint8_t *outside;
} ost_uncut;

/* Creates a reference. Takes ownership of the volume. The volume must have cubic voxels. The parameter `at` is the
   position of the glenoid, or NULL if the position is unknown. */
ost_status ost_uncut_init(ost_uncut *reference, ost_volume *volume, int32_t threshold,
                          const ost_density_classes *classes, const ost_pm3 *at, const double *axis, ost_error *err);
/* Frees the reference's memory. Accepts a zero-initialized reference. */
void ost_uncut_free(ost_uncut *reference);

/* Computes a block of the uncut bone, one bit per voxel. */
void ost_uncut_words(const ost_uncut *reference, const int32_t block[3], uint32_t words[OST_BLOCK_ROWS]);
/* Returns the paint of a voxel exposed by a tool. The parameter `depth` is the entry of block->depth for this voxel. */
uint32_t ost_uncut_paint(const ost_uncut *reference, ost_colouring colouring, const int32_t at[3], uint32_t depth);
/* Returns the paint of a voxel exposed by a clip plane. The reference may be NULL. */
uint32_t ost_uncut_cap(const ost_uncut *reference, ost_colouring colouring, const int32_t at[3]);
/* Allocates block->depth and computes the squared distance of every voxel. Distances are limited to OST_DEPTH_FAR. */
ost_status ost_uncut_depth(ost_surface *surface, ost_surface_block *block, ost_error *err);

#endif
