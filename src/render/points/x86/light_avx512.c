/* SPDX-License-Identifier: Apache-2.0 */
/* Implements the functions of light.c with AVX-512, for sixteen voxels at a time. */
#include "core/conditions.h"
#include "render/points/light.h"
#include "render/points/surface.h"

#include <immintrin.h>

enum { LANES = 16 };

_Static_assert((OST_OCTAHEDRAL_COUNT & (OST_OCTAHEDRAL_COUNT - 1)) == 0, "a cell is the low bits of a look");

static inline __m512i all(uint32_t v)
{
    return _mm512_set1_epi32((int)v);
}

/* Multiplies numbers that are less than 2^15. */
static inline __m512i times(__m512i a, __m512i b)
{
    return _mm512_madd_epi16(a, b);
}

static inline __m512i channel(__m512i full, __m512i bright, __m512i gloss)
{
    return _mm512_min_epi32(_mm512_add_epi32(_mm512_srli_epi32(times(full, bright), 8), gloss), all(255));
}

/* Mixes 3/8 of `colour` and 5/8 of `other` in the channels that `mask` selects. */
static inline __m512i mixed_part(__m512i colour, uint32_t other, uint32_t mask)
{
    const __m512i c = _mm512_and_si512(colour, all(mask)), three = _mm512_add_epi32(_mm512_add_epi32(c, c), c);
    return _mm512_and_si512(_mm512_srli_epi32(_mm512_add_epi32(three, all((other & mask) * 5)), 3), all(mask));
}

void ost_light_tint_avx512(const ost_light *light, const uint32_t *shades, uint32_t count, uint32_t *tint)
{
    const bool faces = light->style == OST_STYLE_FACES;
    for (uint32_t i = 0; i < count; i += LANES) {
        const __m512i l = _mm512_loadu_si512(shades + i),
                      paint = _mm512_and_si512(_mm512_srli_epi32(l, OST_PAINT_SHIFT), all(OST_PAINTS - 1));
        const __mmask16 painted = _mm512_test_epi32_mask(paint, paint),
                        contact = _mm512_test_epi32_mask(l, all(OST_SHADE_CONTACT));
        __m512i c = all(light->colour[0]);
        if (painted)
            c = _mm512_mask_i32gather_epi32(c, painted, paint, light->colour, 4);
        if (contact)
            c = _mm512_mask_or_epi32(c, contact, mixed_part(c, OST_CONTACT, 0xff00ff),
                                     mixed_part(c, OST_CONTACT, 0xff00));
        const __mmask16 flat = faces ? (__mmask16)0xffff : _mm512_cmpge_epi32_mask(paint, all(OST_PAINT_FLAT));
        if (flat == 0xffff) {
            _mm512_storeu_si512(tint + i, c);
            continue;
        }
        /* The gather loads four bytes for each entry of two bytes. The two bytes after the last entry belong to the
           same struct. */
        const __m512i cell = _mm512_and_si512(l, all(OST_OCTAHEDRAL_COUNT - 1));
        const __m512i shade = _mm512_and_si512(_mm512_i32gather_epi32(cell, light->shade, 2), all(0xffff));
        const __m512i open = _mm512_add_epi32(_mm512_and_si512(_mm512_srli_epi32(l, OST_OPEN_SHIFT), all(255)), all(1));
        const __m512i bright = _mm512_srli_epi32(times(_mm512_and_si512(shade, all((1u << OST_BRIGHT_BITS) - 1)), open),
                                                 8);
        const __m512i gloss = _mm512_srli_epi32(times(_mm512_srli_epi32(shade, OST_BRIGHT_BITS), open), 8);
        const __m512i red = channel(_mm512_and_si512(c, all(255)), bright, gloss);
        const __m512i green = channel(_mm512_and_si512(_mm512_srli_epi32(c, 8), all(255)), bright, gloss);
        const __m512i blue = channel(_mm512_srli_epi32(c, 16), bright, gloss);
        const __m512i lit = _mm512_or_si512(_mm512_or_si512(red, _mm512_slli_epi32(green, 8)),
                                            _mm512_slli_epi32(blue, 16));
        _mm512_storeu_si512(tint + i, _mm512_mask_mov_epi32(lit, flat, c));
    }
}

static inline __m512 along(__m512 x, __m512 y, __m512 z, const float v[3])
{
    const __m512 xy = _mm512_add_ps(_mm512_mul_ps(x, _mm512_set1_ps(v[0])), _mm512_mul_ps(y, _mm512_set1_ps(v[1])));
    return _mm512_add_ps(xy, _mm512_mul_ps(z, _mm512_set1_ps(v[2])));
}

static inline __m512 positive(__m512 v)
{
    return _mm512_max_ps(v, _mm512_setzero_ps());
}

static inline __m512 scaled(float by, __m512 v)
{
    return _mm512_mul_ps(_mm512_set1_ps(by), v);
}

static inline __m512i rounded(__m512 v)
{
    return _mm512_cvttps_epi32(_mm512_add_ps(v, _mm512_set1_ps(0.5f)));
}

void ost_light_shade_avx512(uint16_t *shade, const ost_directions *d, const ost_lamps *l, float gloss)
{
    for (int i = 0; i < OST_OCTAHEDRAL_COUNT; i += LANES) {
        const __m512 x = _mm512_loadu_ps(d->x + i), y = _mm512_loadu_ps(d->y + i), z = _mm512_loadu_ps(d->z + i);
        const __m512 sky = _mm512_add_ps(_mm512_set1_ps(0.5f), scaled(0.5f, along(x, y, z, l->up)));
        const __m512 key = positive(along(x, y, z, l->key)), fill = positive(along(x, y, z, l->fill)),
                     back = positive(along(x, y, z, l->back));
        __m512 mirror = positive(along(x, y, z, l->half));
        for (int k = 0; k < 4; k++)
            mirror = _mm512_mul_ps(mirror, mirror);
        const __m512 ambient = _mm512_add_ps(_mm512_set1_ps(0.20f), scaled(0.17f, sky));
        const __m512 lamps = _mm512_add_ps(ambient, _mm512_add_ps(scaled(0.74f, key), scaled(0.20f, fill)));
        const __m512i scaled_bright = rounded(scaled(256.0f, _mm512_add_ps(lamps, scaled(0.10f, back)))),
                      added = rounded(scaled(gloss, mirror));
        const __m512i word = _mm512_or_si512(_mm512_min_epi32(scaled_bright, all(320)),
                                             _mm512_slli_epi32(added, OST_BRIGHT_BITS));
        _mm256_storeu_si256((void *)(shade + i), _mm512_cvtepi32_epi16(word));
    }
}
