/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The camera of an object, for all shader stages. The layout must match the struct ost_gl_eye_block in eye.h. All
 * positions are in voxels of the object, relative to the first voxel of its grid.
 *
 * PRECISE is `precise` if the language version has this keyword. Products and sums are then rounded one by one, as in
 * the CPU renderer. Names and the order of operations are as in points/splat_scalar.c.
 */
layout(std140) uniform Eye {
    vec4 eye_at;      /* w is the focal length in pixels */
    /* in the following three vectors, w is half the width of a voxel along the vector */
    vec4 eye_right;
    vec4 eye_up;
    vec4 eye_forward;
    vec4 axis_0;      /* w is the distance of the forward axis from the picture's left edge, in pixels */
    vec4 axis_1;      /* w is the distance of the forward axis from the picture's top edge, in pixels */
    vec4 axis_2;      /* w is the distance of the near plane along the forward axis, in voxels */
    /* x and y are the size of the picture in pixels; z and w map a squared distance to a depth: distance^2 * z + w */
    vec4 frame;
    /*
     * x: edge length of a voxel, in voxels of the first object; y: 1 if each face has one colour; z: half of a voxel's
     * edge length, slightly enlarged
     */
    vec4 layer;
    uvec4 light_0;    /* light on the faces 0 to 3, in 256ths */
    /* x and y: light on the faces 4 and 5, in 256ths; z: background colour, 0xBBGGRR */
    uvec4 light_4;
    uvec4 paint;      /* red, green, blue, gloss */
};

/* Factor that maps a depth along the view direction to the range 0 to 1. The greatest depth is 2^16 voxels of the first
   object. */
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
 * Returns the vector from the eye to the centre of a voxel. `word` is the voxel's position in its block, and `page` is
 * the position of the block's first voxel.
 */
vec3 place(uint word, ivec4 page)
{
    PRECISE vec3 base = vec3(page.xyz) - eye_at.xyz;
    PRECISE vec3 o = base + vec3(float(word & 31u), float(word >> 5 & 31u), float(word >> 10 & 31u));
    return o;
}

/*
 * Returns the offset of a fragment from the forward axis in the picture, to the right and down. Row 0 is the top row.
 */
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
