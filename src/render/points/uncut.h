/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The reference with which the current bone is compared: the uncut bone with the densities of the CT. Paint is computed
 * from it:
 *
 *   densities --class, density---------> paint of voxels exposed by a tool
 *   bits before --distance to outside--> paint of the same voxels, by depth
 *   densities --window-----------------> paint of voxels exposed by a clip plane
 *
 * A paint is a number that a palette maps to a colour (palette.h): 0 is the object's own colour, 1 .. 127 are lit like
 * the surface, and 128 .. 255 are shown without lighting.
 *
 * Depth is the distance from the voxel's centre to the nearest centre of a voxel outside the bone, minus half a voxel.
 * Depths are exact up to 32 voxels. A voxel is outside if it is not bone and a cube of 2^3 voxels can move through
 * empty space from the grid's border to within two voxels of this voxel. Pores in the bone are therefore not outside.
 * Voxels beyond the grid are unknown, so a cropped bone has no surface at the grid's border.
 */
#ifndef OST_RENDER_UNCUT_H
#define OST_RENDER_UNCUT_H

#include <osteon/event.h>

#include "render/points/palette.h"
#include "render/points/surface.h"

/* Maximum depth in voxels, and its square. */
enum { OST_DEPTH_REACH = 32, OST_DEPTH_FAR = OST_DEPTH_REACH * OST_DEPTH_REACH };

typedef struct ost_uncut {
    ost_volume volume;      /* owned */
    int32_t threshold;
    /* true if the uncut bone is unknown; the entire surface is then painted */
    bool uncut;
    int32_t classes, border[OST_CLASS_MAX];
    bool has_face;          /* true if `face` and `inward` are valid */
    /* face: centre of the glenoid's face, in voxels; inward: unit vector from there into the bone */
    double face[3], inward[3];
    double scale_mm;        /* depth of the last colour of the scale, in mm */
    uint8_t level[OST_DEPTH_FAR + 1]; /* paint for each squared depth */
    /* owned; for each cube of 2^3 voxels, whether it is outside the bone; NULL until a depth is needed */
    uint8_t *outside;
} ost_uncut;

/* Creates a reference from a volume with cubic voxels, and takes ownership of the volume. `at` is the position of
   the glenoid; NULL if unknown. */
ost_status ost_uncut_init(ost_uncut *reference, ost_volume *volume, int32_t threshold,
                          const ost_density_classes *classes, const ost_pm3 *at, const double *axis, ost_error *err);
/* Frees the reference's memory. Accepts a zero-initialized reference. */
void ost_uncut_free(ost_uncut *reference);

/* Returns the paint of a voxel exposed by a tool. `depth` is the voxel's element of block->depth. */
uint32_t ost_uncut_paint(const ost_uncut *reference, ost_colouring colouring, const int32_t at[3], uint32_t depth);
/* Returns the paint of a voxel exposed by a clip plane. `reference` may be NULL. */
uint32_t ost_uncut_cap(const ost_uncut *reference, ost_colouring colouring, const int32_t at[3]);
/* Allocates block->depth and computes the squared depth of each voxel, at most OST_DEPTH_FAR. */
ost_status ost_uncut_depth(ost_surface *surface, ost_surface_block *block, ost_error *err);

#endif
