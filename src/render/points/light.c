/* SPDX-License-Identifier: Apache-2.0 */
#include "config.h"

#include "core/conditions.h"
#include "render/points/light.h"

#include "render/points/surface.h"

/*
 * Computes the unit vector in the direction r * right + u * up + f * forward, where right, up and forward are the eye's
 * axes.
 */
static void toward(const ost_eye *eye, float r, float u, float f, float out[3])
{
    float square = 0;
    for (int a = 0; a < 3; a++)
        out[a] = (r * eye->right[a] + u * eye->up[a]) + f * eye->forward[a];
    square = ost_eye_dot(out, out);
    for (int a = 0; a < 3; a++)
        out[a] /= sqrtf(square);
}

static float positive(float v)
{
    return v > 0 ? v : 0;
}

static uint32_t rounded(float v, uint32_t most)
{
    const uint32_t n = (uint32_t)(positive(v) + 0.5f);
    return n < most ? n : most;
}

static inline float along(const ost_directions *d, int i, const float v[3])
{
    return (d->x[i] * v[0] + d->y[i] * v[1]) + d->z[i] * v[2];
}

static void shade_all(uint16_t *restrict shade, const ost_directions *restrict d, const ost_lamps *restrict l,
                      float gloss)
{
    for (int i = 0; i < OST_OCTAHEDRAL_COUNT; i++) {
        const float sky = 0.5f + 0.5f * along(d, i, l->up), key = positive(along(d, i, l->key)),
                    fill = positive(along(d, i, l->fill));
        const float back = positive(along(d, i, l->back));
        float mirror = positive(along(d, i, l->half));
        mirror *= mirror;
        mirror *= mirror;
        mirror *= mirror;
        mirror *= mirror; /* the last squaring yields the 16th power */
        const float bright = ((OST_LIGHT_AMBIENT + OST_LIGHT_SKY * sky) +
                              (OST_LIGHT_KEY * key + OST_LIGHT_FILL * fill)) + OST_LIGHT_BACK * back;
        const int scaled_bright = (int)(256.0f * bright + 0.5f), added = (int)(gloss * mirror + 0.5f);
        shade[i] = (uint16_t)((scaled_bright < OST_LIGHT_MOST ? scaled_bright : OST_LIGHT_MOST) |
                              added << OST_BRIGHT_BITS);
    }
}

void ost_directions_make(ost_directions *d)
{
    for (uint32_t cell = 0; cell < OST_OCTAHEDRAL_COUNT; cell++) {
        float n[3];
        ost_octahedral_vector(cell, n);
        d->x[cell] = n[0];
        d->y[cell] = n[1];
        d->z[cell] = n[2];
    }
    d->shade = shade_all;
}

ost_lamps ost_lamps_make(const ost_eye *eye)
{
    ost_lamps l;
    toward(eye, -0.40f, 0.55f, -0.73f, l.key);
    toward(eye, 0.85f, -0.10f, -0.50f, l.fill);
    toward(eye, 0.10f, -0.60f, 0.55f, l.back);
    toward(eye, -0.40f, 0.55f, -1.73f, l.half);
    for (int a = 0; a < 3; a++)
        l.up[a] = eye->up[a];
    return l;
}

static void copy3(float to[3], const float from[3])
{
    for (int a = 0; a < 3; a++)
        to[a] = from[a];
}

static bool is_made(const ost_light *light, const ost_eye *eye, uint8_t gloss)
{
    bool same = light->made && light->gloss == gloss;
    for (int a = 0; a < 3; a++)
        same &= light->right[a] == eye->right[a] && light->up[a] == eye->up[a] && light->forward[a] == eye->forward[a];
    return same;
}

void ost_light_make(ost_light *light, const ost_directions *directions, const ost_eye *eye, ost_style style,
                    ost_paint paint, const uint32_t *palette)
{
    const ost_lamps l = ost_lamps_make(eye);
    if (!is_made(light, eye, paint.gloss)) {
        directions->shade(light->shade, directions, &l, (float)paint.gloss);
        copy3(light->right, eye->right);
        copy3(light->up, eye->up);
        copy3(light->forward, eye->forward);
        light->gloss = paint.gloss;
        light->made = true;
    }
    light->style = style;
    light->colour[0] = paint.red | (uint32_t)paint.green << 8 | (uint32_t)paint.blue << 16;
    for (int i = 1; i < OST_PAINTS; i++)
        light->colour[i] = palette ? palette[i] : light->colour[0];
    for (int face = 0; face < 8; face++) {
        const float cosine = face < 6 ? positive(face % 2 ? l.key[face / 2] : -l.key[face / 2]) : 0;
        light->face[face] = style == OST_STYLE_FACES ? rounded(256.0f * (0.32f + 0.68f * cosine), 256) : 256;
    }
}

static uint32_t channel(uint32_t full, uint32_t bright, uint32_t gloss)
{
    const uint32_t v = (full * bright >> 8) + gloss;
    return v < 255 ? v : 255;
}

/* Mixes two colours: 3/8 of a and 5/8 of b. */
static uint32_t mixed(uint32_t a, uint32_t b)
{
    return (((a & 0xff00ff) * 3 + (b & 0xff00ff) * 5) >> 3 & 0xff00ff) |
           (((a & 0xff00) * 3 + (b & 0xff00) * 5) >> 3 & 0xff00);
}

void ost_light_tint(const ost_light *light, const uint32_t *shades, uint32_t count, uint32_t *tint)
{
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t paint = shades[i] >> OST_PAINT_SHIFT & (OST_PAINTS - 1);
        uint32_t c = light->colour[paint];
        if (shades[i] & OST_SHADE_CONTACT)
            c = mixed(c, OST_CONTACT);
        if (light->style == OST_STYLE_FACES || paint >= OST_PAINT_FLAT) {
            tint[i] = c;
            continue;
        }
        const uint32_t shade = light->shade[shades[i] % OST_OCTAHEDRAL_COUNT],
                       open = (shades[i] >> OST_OPEN_SHIFT & 255) + 1;
        const uint32_t bright = (shade & ((1u << OST_BRIGHT_BITS) - 1)) * open >> 8,
                       gloss = (shade >> OST_BRIGHT_BITS) * open >> 8;
        tint[i] = channel(c & 255, bright, gloss) | channel(c >> 8 & 255, bright, gloss) << 8 |
                  channel(c >> 16, bright, gloss) << 16;
    }
}

ost_light_tint_of *ost_light_tint_for(ost_isa isa)
{
#if HAVE_AVX512_BUILD
    if (ost_isa_includes(isa, OST_ISA_AVX512))
        return ost_light_tint_avx512;
#endif
    (void)isa;
    return ost_light_tint;
}

ost_light_shade_of *ost_light_shade_for(ost_isa isa)
{
#if HAVE_AVX512_BUILD
    if (ost_isa_includes(isa, OST_ISA_AVX512))
        return ost_light_shade_avx512;
#endif
    (void)isa;
    return shade_all;
}
