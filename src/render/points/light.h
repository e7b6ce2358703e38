/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Colours of voxels: a palette of all directions, made once a frame.
 *
 *   look --normal--> brightness, gloss        tint = bone * brightness * openness + gloss
 *
 * The key light comes from over the left shoulder of who looks, a weaker one
 * from the right.  All is rounded to integers in the palette, so a tint is a
 * few integer operations.
 */
#ifndef OST_RENDER_LIGHT_H
#define OST_RENDER_LIGHT_H

#include "render/points/camera.h"
#include "render/points/octahedral.h"

#define OST_BACKGROUND 0x1c1816u /* 0xBBGGRR */

typedef struct ost_light {
    uint16_t bright[OST_OCTAHEDRAL_COUNT]; /* in 256ths, at most 288 */
    uint8_t gloss[OST_OCTAHEDRAL_COUNT];   /* added to each channel */
    uint32_t face[8];                      /* of a face, in 256ths; 6 and 7 unused */
    ost_style style;
} ost_light;

void ost_light_make(ost_light *light, const ost_eye *eye, ost_style style);
void ost_light_tint(const ost_light *light, const uint32_t *look, uint32_t count, uint32_t *tint);

#endif
