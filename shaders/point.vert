/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Draws a voxel as a point or, if the driver does not support points of this size, as a rectangle of two triangles
 * (QUADS).
 *
 *   EVERY_VOXEL   one density per vertex; the number of the vertex determines the voxel's position (thesis 2.6)
 *   else          a surface point of points/surface.h
 */
/* position of the block's first voxel, for each group of 2^PAGE_BITS vertices */
uniform isamplerBuffer pages;
#if QUADS
uniform usamplerBuffer list, points;
uniform int first;
#elif EVERY_VOXEL
in int density;
#else
in uvec2 point;
#endif

flat out uint tint;
flat out vec3 o;

/*
 * Places a vertex where it is invisible: outside the clip volume or, without TRUE_DEPTH, on the far plane, where it
 * fails every depth test. A vertex on the far plane need not be clipped; clipping is slow in software.
 */
void nowhere()
{
    gl_PointSize = 1.0;
#if TRUE_DEPTH
    gl_Position = vec4(-1.0);
#else
    gl_Position = vec4(0.0, 0.0, 1.0, 1.0);
#endif
}

void main()
{
#if QUADS
    uint at = texelFetch(list, first + gl_InstanceID).r;
    uvec2 point = texelFetch(points, int(at)).rg;
#else
    uint at = uint(gl_VertexID);
#endif
#if EVERY_VOXEL
    tint = tint_of(0u);
    o = place(at & 32767u, texelFetch(pages, int(at >> PAGE_BITS)));
    if (density < 120) {
        nowhere();
        return;
    }
#else
    tint = tint_of(point.y);
    o = place(point.x, texelFetch(pages, int(at >> PAGE_BITS)));
#endif
    PRECISE float depth = dot3(o, o) * frame.z + frame.w;
#if TIGHT
    vec4 r;
    if (!rectangle_of(o, 1.0, r)) {
        nowhere();
        return;
    }
#if QUADS
    vec2 corner = vec2((gl_VertexID & 1) == 0 ? r.x : r.y + 1.0, (gl_VertexID & 2) == 0 ? r.z : r.w + 1.0);
    gl_PointSize = 1.0;
    gl_Position = vec4(2.0 * corner / frame.xy - 1.0, depth, 1.0);
#else
    gl_PointSize = max(r.y - r.x, r.w - r.z) + 1.0;
    gl_Position = vec4((r.xz + r.yw + 1.0) / frame.xy - 1.0, depth, 1.0);
#endif
#else
    vec2 middle;
    float size;
    if (!square_of(o, middle, size)) {
        nowhere();
        return;
    }
    gl_PointSize = size;
    gl_Position = vec4(2.0 * middle / frame.xy - 1.0, depth, 1.0);
#endif
}
