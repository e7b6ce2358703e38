/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Colours of voxels: a palette of all directions, made once a frame.
 *
 *   look --normal--> brightness, gloss        tint = paint * brightness * openness + gloss
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

/* What a thing is made of. */
typedef struct ost_paint {
    uint8_t red, green, blue;
    uint8_t gloss; /* added to each channel where the key light is mirrored */
} ost_paint;

#define OST_PAINT_BONE ((ost_paint){0xe3, 0xda, 0xc9, 26}) /* thesis 3.3.2 */
#define OST_PAINT_STEEL ((ost_paint){0xa4, 0xad, 0xb8, 110})

typedef struct ost_light {
    uint16_t bright[OST_OCTAHEDRAL_COUNT]; /* in 256ths, at most 288 */
    uint8_t gloss[OST_OCTAHEDRAL_COUNT];   /* added to each channel */
    uint32_t face[8];                      /* of a face, in 256ths; 6 and 7 unused */
    ost_style style;
    ost_paint paint;
} ost_light;

void ost_light_make(ost_light *light, const ost_eye *eye, ost_style style, ost_paint paint);
void ost_light_tint(const ost_light *light, const uint32_t *look, uint32_t count, uint32_t *tint);

#endif
