/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The camera's values for all shader stages. The struct ost_gl_eye_block in eye.h has the same layout. All positions
 * are in voxels of the object that is drawn, relative to the first voxel of its grid.
 *
 * PRECISE is `precise` if the language version supports this keyword.  Products and sums are
 * then rounded one by one, as in the processor's renderer.  The names and the order of
 * operations are those of points/splat_scalar.c.
 */
layout(std140) uniform Eye {
    vec4 eye_at;      /* w is the focal length in pixels */
    /* w is half the width of a voxel along the vector. The same applies to eye_up and eye_forward. */
    vec4 eye_right;
    vec4 eye_up;
    vec4 eye_forward;
    vec4 axis_0;      /* w is half the width of the frame */
    vec4 axis_1;      /* w is half the height of the frame */
    vec4 axis_2;      /* w is the distance of the near plane */
    /* x and y are the width and height in pixels; depth = (squared distance) * z + w */
    vec4 frame;
    /*
     * x is the size of a voxel in voxels of the first object. y is 1 if each face has one colour. z is half of a
     * voxel's side, slightly enlarged.
     */
    vec4 layer;
    uvec4 light_0;    /* light intensities of faces 0 to 3, in 256ths */
    /* x and y are the light intensities of faces 4 and 5, in 256ths; z is the background colour as 0xBBGGRR */
    uvec4 light_4;
    uvec4 paint;      /* red, green, blue, gloss */
};

/*
 * Converts a depth along the view direction, in voxels of the first object, to the range 0 to 1.
 * The depth is at most 2^16 voxels.
 */
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

/*
 * Returns the vector from the eye to the centre of a voxel. The parameter `word` is the voxel's position in its block,
 * and `page` the position of the block's first voxel.
 */
vec3 place(uint word, ivec4 page)
{
    PRECISE vec3 base = vec3(page.xyz) - eye_at.xyz;
    PRECISE vec3 o = base + vec3(float(word & 31u), float(word >> 5 & 31u), float(word >> 10 & 31u));
    return o;
}

/* Returns the offset of a fragment from the middle of the picture, to the right and down. The top row is row 0. */
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
