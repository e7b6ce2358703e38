/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Computes the colours of voxels from a table, which contains the brightness for each surface normal and is computed
 * once per frame.
 *
 *   look --normal--> brightness, gloss        tint = paint * brightness * openness + gloss
 *        --paint---> colour; for flat paints this is the tint
 *
 * The key light is over the viewer's left shoulder, and a weaker fill light is on the right. The table contains
 * integers, so a tint takes only a few integer operations.
 */
#ifndef OST_RENDER_LIGHT_H
#define OST_RENDER_LIGHT_H

#include "core/isa.h"
#include "render/points/camera.h"
#include "render/points/octahedral.h"
#include "render/points/palette.h"

#define OST_CONTACT 0x30a0ffu /* colour, 0xBBGGRR, blended in where bone was just removed */
#define OST_BACKGROUND 0x1c1816u /* 0xBBGGRR */

/* The paint of an object: its colour and gloss. */
typedef struct ost_paint {
    uint8_t red, green, blue;
    /* value added to each channel where the key light is mirrored toward the eye; at most 127 */
    uint8_t gloss;
} ost_paint;

#define OST_PAINT_BONE ((ost_paint){0xe3, 0xda, 0xc9, 26}) /* thesis 3.3.2 */
#define OST_PAINT_GHOST ((ost_paint){0x58, 0xd8, 0xc8, 40})
#define OST_PAINT_STEEL ((ost_paint){0xa4, 0xad, 0xb8, 110})

enum { OST_BRIGHT_BITS = 9 };

typedef struct ost_light {
    /* for each octahedral cell: bits 0 to OST_BRIGHT_BITS - 1 are the brightness in 256ths, at most 320, and the
       higher bits are the gloss to add to each channel */
    uint16_t shade[OST_OCTAHEDRAL_COUNT];
    uint32_t face[8];                     /* light on each face in 256ths; entries 6 and 7 are unused */
    uint32_t colour[OST_PAINTS];          /* colour of each paint, 0xBBGGRR */
    ost_style style;
    /* The inputs from which `shade` was computed. If they are unchanged, `shade` is reused. */
    float right[3], up[3], forward[3];
    uint8_t gloss;
    bool made;
} ost_light;

/* Unit vectors toward the lights. The vector `half` points halfway between the key light and the eye. */
typedef struct ost_lamps {
    float key[3], fill[3], half[3], back[3], up[3];
} ost_lamps;

/* Contributions of the lights to the brightness of a surface. OST_LIGHT_MOST is the maximum brightness in 256ths. */
#define OST_LIGHT_AMBIENT 0.20f
#define OST_LIGHT_SKY 0.17f
#define OST_LIGHT_KEY 0.74f
#define OST_LIGHT_FILL 0.20f
#define OST_LIGHT_BACK 0.10f
enum { OST_LIGHT_MOST = 320 };

/* Returns the directions toward the lights in the frame of the eye. */
ost_lamps ost_lamps_make(const ost_eye *eye);

struct ost_directions;
typedef void ost_light_shade_of(uint16_t *shade, const struct ost_directions *directions, const ost_lamps *lamps,
                                float gloss);

/*
 * The unit vectors of all octahedral cells, and the function that computes the shades of all cells. ost_directions_make
 * sets the portable function; a caller can replace it with the result of ost_light_shade_for.
 */
typedef struct ost_directions {
    float x[OST_OCTAHEDRAL_COUNT], y[OST_OCTAHEDRAL_COUNT], z[OST_OCTAHEDRAL_COUNT];
    ost_light_shade_of *shade;
} ost_directions;
void ost_directions_make(ost_directions *directions);
ost_light_shade_of *ost_light_shade_for(ost_isa isa);

/*
 * Computes the light of a frame. `palette` is the result of ost_palette_make, or NULL if all paint numbers mean the
 * object's own paint. The light must be zero-initialized before its first use.
 */
void ost_light_make(ost_light *light, const ost_directions *directions, const ost_eye *eye, ost_style style,
                    ost_paint paint, const uint32_t *palette);
/*
 * Computes the colours of fully lit faces. Both arrays must have a capacity of `count` rounded up to a multiple of 16.
 */
void ost_light_tint(const ost_light *light, const uint32_t *shades, uint32_t count, uint32_t *tint);
typedef void ost_light_tint_of(const ost_light *light, const uint32_t *shades, uint32_t count, uint32_t *tint);
ost_light_tint_of *ost_light_tint_for(ost_isa isa);

/* The bit-identical variants for AVX-512. */
void ost_light_shade_avx512(uint16_t *shade, const ost_directions *directions, const ost_lamps *lamps, float gloss);
void ost_light_tint_avx512(const ost_light *light, const uint32_t *shades, uint32_t count, uint32_t *tint);
#endif
