/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Draws a brick of 4^3 voxels as one point. The words of `brick` contain the position of the brick in its block, the
 * set of its voxels with an exposed face (two words), and the index of the shade of the first of these voxels.
 */
uniform isamplerBuffer pages;
in uvec4 brick;
flat out uvec4 what;
flat out vec3 o;    /* vector from the eye to the centre of the brick */
flat out vec3 base; /* vector from the eye to the first voxel of the block */

void main()
{
    what = brick;
    base = place(0u, texelFetch(pages, gl_VertexID >> PAGE_BITS));
    o = base + 4.0 * vec3(float(brick.x & 7u), float(brick.x >> 3 & 7u), float(brick.x >> 6 & 7u)) + 1.5;
    PRECISE float depth = dot3(o, o) * frame.z + frame.w;
    vec4 r;
    gl_PointSize = 1.0;
    gl_Position = vec4(0.0, 0.0, 1.0, 1.0);
    if (!rectangle_of(o, 4.0, r))
        return;
    gl_PointSize = max(r.y - r.x, r.w - r.z) + 1.0;
    gl_Position = vec4((r.xz + r.yw + 1.0) / frame.xy - 1.0, depth, 1.0);
}
