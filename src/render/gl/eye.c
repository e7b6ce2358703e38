/* SPDX-License-Identifier: Apache-2.0 */
#include "core/conditions.h"
#include "render/gl/eye.h"

#include <math.h>
#include <string.h>

static void copy3(float to[4], const float from[3], float w)
{
    memcpy(to, from, 3 * sizeof *to);
    to[3] = w;
}

/* Returns an upper bound on the squared distance from the eye to any voxel that the layer draws. */
static float farthest(const ost_gl *gl, const ost_gl_layer *l)
{
    float most = 1;
    for (int32_t i = 0; i < l->blocks; i++) {
        const float *base = gl->bases + 4 * gl->blocks[i].slot;
        float square = 0;
        for (int a = 0; a < 3; a++) {
            const float far = fmaxf(fabsf(base[a] - 1), fabsf(base[a] + (float)OST_BLOCK));
            square += far * far;
        }
        most = fmaxf(most, square);
    }
    return most;
}

void ost_gl_put_eye(ost_gl *gl, int number, ost_style style)
{
    ost_gl_layer *l = &gl->layer[number];
    const ost_eye *e = &l->thing->eye;
    const ost_paint *p = &l->thing->paint;
    const ost_pm s = l->thing->surface->geometry.spacing.x, first = gl->layer[0].thing->surface->geometry.spacing.x;
    ost_gl_eye_block b = {
        .frame = {(float)e->width, (float)e->height, 0x1p-32f, 0},
        .layer = {(float)((double)s / (double)first), style == OST_STYLE_FACES, OST_HALF_WIDE, 0},
        .paint = {p->red, p->green, p->blue, p->gloss},
    };
    int exponent;
    frexpf(farthest(gl, l), &exponent);
    l->depth_scale = b.frame[2];
    l->depth_slack = 0;
    if (!gl->context.zero_to_one) {
        b.frame[2] = ldexpf(1, 1 - exponent);
        b.frame[3] = -1;
        l->depth_scale = ldexpf(1, -exponent);
        l->depth_slack = 0x1p-22f;
    }
    copy3(b.at, e->at, e->focal);
    copy3(b.right, e->right, l->eye.reach[0]);
    copy3(b.up, e->up, l->eye.reach[1]);
    copy3(b.forward, e->forward, l->eye.reach[2]);
    copy3(b.axis[0], l->eye.axis[0], e->half_w);
    copy3(b.axis[1], l->eye.axis[1], e->half_h);
    copy3(b.axis[2], l->eye.axis[2], e->near);
    ost_light_make(&gl->light, &gl->directions, e, style, *p, l->thing->palette);
    memcpy(b.light_0, gl->light.face, sizeof b.light_0);
    memcpy(b.light_4, gl->light.face + 4, 2 * sizeof *b.light_4);
    b.light_4[2] = OST_BACKGROUND;
    for (int i = 0; i < OST_OCTAHEDRAL_COUNT; i++)
        gl->palette[i] = gl->light.shade[i];
    memcpy(gl->palette + OST_OCTAHEDRAL_COUNT, gl->light.colour, sizeof gl->light.colour);
    glBindBuffer(GL_UNIFORM_BUFFER, gl->eyes);
    glBufferSubData(GL_UNIFORM_BUFFER, (GLintptr)number * gl->eye_stride, sizeof b, &b);
    glBindBuffer(GL_TEXTURE_BUFFER, l->palette);
    glBufferSubData(GL_TEXTURE_BUFFER, 0, sizeof gl->palette, gl->palette);
}
