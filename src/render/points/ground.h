/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the CT knew of the bone before anything was cut, and the paint that
 * follows from it.
 *
 *   densities --class, density---------> paint of what a tool has bared
 *   bits before --distance to outside--> the same, by depth
 *   densities --window-----------------> paint of what a clip plane bares
 *
 * A paint is a number: 0 is the thing's own, 1 .. 127 are lit as the surface
 * is, 128 .. 255 are shown as they are, whatever the light.  What colour it is
 * says a palette (palette.h).
 *
 * Depth is the distance from the voxel's centre to the nearest centre that was
 * outside the bone, less half a voxel; exact up to 32 voxels.  Outside is what
 * is not bone and can be reached from the grid's border by a cube of 2^3
 * voxels, to within two voxels: pores in the bone are not outside.  Beyond the
 * grid nothing is known: a bone that was cropped has no surface there.
 */
#ifndef OST_RENDER_GROUND_H
#define OST_RENDER_GROUND_H

#include <osteon/event.h>

#include "render/points/palette.h"
#include "render/points/surface.h"

enum { OST_DEPTH_REACH = 32, OST_DEPTH_FAR = OST_DEPTH_REACH * OST_DEPTH_REACH }; /* voxels; squared */

typedef struct ost_ground {
    ost_volume volume;      /* owned */
    int32_t threshold;
    bool uncut;             /* what was before is not known: all of the surface is painted */
    int32_t classes, border[OST_CLASS_MAX];
    bool has_face;          /* the next two are known */
    double face[3], inward[3]; /* in voxels: the middle of the glenoid's face; a unit vector into the bone */
    double scale_mm;        /* the depth that the last colour of the scale stands for */
    uint8_t level[OST_DEPTH_FAR + 1]; /* paint of a squared distance */
    uint8_t *outside;       /* owned; cells of 2^3 voxels; NULL until a depth is asked for */
} ost_ground;

/* Takes the volume, which must be of cubes; at NULL: no glenoid is known. */
ost_status ost_ground_init(ost_ground *ground, ost_volume *volume, int32_t threshold, const ost_density_classes *classes, const ost_pm3 *at,
                           const double *axis, ost_error *err);
void ost_ground_free(ost_ground *ground); /* also of a zeroed one */

/* A block's bits, as they were. */
void ost_ground_words(const ost_ground *ground, const int32_t block[3], uint32_t words[OST_BLOCK_ROWS]);
/* Of bone that was bared at a voxel; depth as the block has it. */
uint32_t ost_ground_paint(const ost_ground *ground, ost_colouring colouring, const int32_t at[3], uint32_t depth);
/* Of what a clip plane shows there; ground may be NULL. */
uint32_t ost_ground_cap(const ost_ground *ground, ost_colouring colouring, const int32_t at[3]);
/* Makes block->depth: of every voxel the squared distance, at most OST_DEPTH_FAR. */
ost_status ost_ground_depth(ost_surface *surface, ost_surface_block *block, ost_error *err);

#endif
