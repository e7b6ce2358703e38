/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Places a corner of a visible face of a voxel. `corner` is a vertex as defined in core/face_mesh.h. The page of a quad
 * contains the position of the block's first voxel, and the difference between the index of the face's look and the
 * number of the quad.
 *
 * A corner's position is exact until the eye is subtracted. Faces that share a corner therefore draw it at the same
 * position and leave no gap. The depth of a corner is the depth of the voxel's centre, as for points (point.vert).
 */
uniform isamplerBuffer pages;
uniform usamplerBuffer shades;
in uint corner;

flat out uint tint;
flat out uint face;
flat out vec3 o; /* vector from the eye to the voxel's centre */

void main()
{
    int quad = gl_VertexID >> 2;
    ivec4 page = texelFetch(pages, quad >> PAGE_BITS);
    ivec3 at = ivec3(uvec3(corner, corner >> 6, corner >> 12) & 63u);
    uint axis = corner >> 19 & 3u, side = corner >> 18 & 1u;
    int along[3] = int[3](int(side), int(corner >> 21 & 1u), int(corner >> 22 & 1u));
    /* `at` is a corner of the face, and `voxel` is the voxel's corner nearest to (0, 0, 0) */
    ivec3 voxel = at - (axis == 0u ? ivec3(along[0], along[1], along[2])
                                   : axis == 1u ? ivec3(along[2], along[0], along[1])
                                                : ivec3(along[1], along[2], along[0]));
    face = axis << 1 | side;
    tint = tint_of(texelFetch(shades, quad + page.w).r);
    PRECISE vec3 base = vec3(page.xyz) - eye_at.xyz;
    PRECISE vec3 centre = base + vec3(voxel);
    o = centre;
    /* A face is placed where it is invisible if it is turned away from the eye or if the near plane cuts its voxel. */
    float toward = side == 1u ? -o[axis] : o[axis];
    gl_Position = vec4(0.0, 0.0, 1.0, 1.0);
    if (!(toward > 0.5) || !(dot3(eye_forward.xyz, o) - eye_forward.w > axis_2.w))
        return;
    vec3 p = (vec3(page.xyz + at) - 0.5) - eye_at.xyz;
    float x = dot3(eye_right.xyz, p), y = dot3(eye_up.xyz, p), z = dot3(eye_forward.xyz, p);
    PRECISE float depth = dot3(o, o) * frame.z + frame.w;
    gl_Position = vec4(x * eye_at.w / axis_0.w, -y * eye_at.w / axis_1.w, depth * z, z);
}
