/* SPDX-License-Identifier: Apache-2.0 */
#include "core/conditions.h"
#include "render/points/light.h"

#include "render/points/surface.h"

/* Unit; r, u and f along the picture's right, up and into it. */
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

void ost_light_make(ost_light *light, const ost_eye *eye, ost_style style, ost_paint paint)
{
    float key[3], fill[3], half[3], n[3];
    toward(eye, -0.40f, 0.55f, -0.73f, key);
    toward(eye, 0.85f, -0.10f, -0.50f, fill);
    toward(eye, -0.40f, 0.55f, -1.73f, half); /* half-way between the key light and the eye */
    light->style = style;
    light->paint = paint;
    for (uint32_t cell = 0; cell < OST_OCTAHEDRAL_COUNT; cell++) {
        ost_octahedral_vector(cell, n);
        const float sky = 0.5f + 0.5f * ost_eye_dot(n, eye->up);
        const float bright = ((0.20f + 0.10f * sky) + 0.68f * positive(ost_eye_dot(n, key))) + 0.16f * positive(ost_eye_dot(n, fill));
        float gloss = positive(ost_eye_dot(n, half));
        for (int i = 0; i < 5; i++)
            gloss *= gloss; /* to the 32nd power */
        light->bright[cell] = (uint16_t)rounded(256.0f * bright, 288);
        light->gloss[cell] = (uint8_t)rounded((float)paint.gloss * gloss, 255);
    }
    for (int face = 0; face < 8; face++) {
        const float cosine = face < 6 ? positive(face % 2 ? key[face / 2] : -key[face / 2]) : 0;
        light->face[face] = style == OST_STYLE_FACES ? rounded(256.0f * (0.32f + 0.68f * cosine), 256) : rounded(236.0f + 20.0f * cosine, 256);
    }
}

static uint32_t channel(uint32_t full, uint32_t bright, uint32_t gloss)
{
    const uint32_t v = (full * bright >> 8) + gloss;
    return v < 255 ? v : 255;
}

void ost_light_tint(const ost_light *light, const uint32_t *look, uint32_t count, uint32_t *tint)
{
    const ost_paint p = light->paint;
    if (light->style == OST_STYLE_FACES) {
        for (uint32_t i = 0; i < count; i++)
            tint[i] = p.red | (uint32_t)p.green << 8 | (uint32_t)p.blue << 16;
        return;
    }
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t cell = look[i] % OST_OCTAHEDRAL_COUNT, open = (look[i] >> OST_OPEN_SHIFT & 255) + 1;
        const uint32_t bright = light->bright[cell] * open >> 8, gloss = light->gloss[cell] * open >> 8;
        tint[i] = channel(p.red, bright, gloss) | channel(p.green, bright, gloss) << 8 | channel(p.blue, bright, gloss) << 16;
    }
}
