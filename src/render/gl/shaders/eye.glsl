/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What every stage knows of the camera; ost_gl_eye_block in eye.h is the
 * same.  All of it in voxels of what is drawn, from its grid's first voxel.
 *
 * PRECISE is `precise` where the language has it: products and sums are then
 * rounded one by one, as the processor's renderer rounds them.  Names and
 * orders of operations are those of points/splat_scalar.c.
 */
layout(std140) uniform Eye {
    vec4 eye_at;      /* w: focal length in pixels */
    vec4 eye_right;   /* w: half the width of a voxel along it; so the next two */
    vec4 eye_up;
    vec4 eye_forward;
    vec4 axis_0;      /* w: half the frame's width */
    vec4 axis_1;      /* w: half its height */
    vec4 axis_2;      /* w: nearest */
    vec4 frame;       /* width, height; a squared distance times z plus w is a depth */
    vec4 layer;       /* x: its voxels in voxels of the first thing; y: 1 with faces in one colour; z: half a voxel, widened */
    uvec4 light_0;    /* of faces 0 to 3, in 256ths */
    uvec4 light_4;    /* of faces 4 and 5; z: the background, 0xBBGGRR */
    uvec4 paint;      /* red, green, blue */
};

/* Depth along forward, in voxels of the first thing, to 0..1: no thing is farther than 2^16. */
const float DEPTH_SCALE = 1.0 / 65536.0;

float dot3(vec3 a, vec3 b)
{
    PRECISE float sum = (a.x * b.x + a.y * b.y) + a.z * b.z;
    return sum;
}

vec3 cross3(vec3 a, vec3 b)
{
    PRECISE vec3 c = a.yzx * b.zxy - a.zxy * b.yzx;
    return c;
}

/* From the eye to the centre of a voxel of a block; page: the block's first voxel. */
vec3 place(uint word, ivec4 page)
{
    PRECISE vec3 base = vec3(page.xyz) - eye_at.xyz;
    PRECISE vec3 o = base + vec3(float(word & 31u), float(word >> 5 & 31u), float(word >> 10 & 31u));
    return o;
}

/* Across the picture and down it from its middle; rows count from the top. */
vec2 slope(vec2 fragment)
{
    PRECISE vec2 s = fragment - vec2(axis_0.w, axis_1.w);
    return s;
}

vec3 ray(vec2 s)
{
    PRECISE vec3 row = axis_0.xyz - s.y * axis_2.xyz;
    PRECISE vec3 d = row + s.x * axis_1.xyz;
    return d;
}
