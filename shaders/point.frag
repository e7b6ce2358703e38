/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests whether a pixel's ray meets the voxel, and writes the fragment.
 *
 *   LINES   The line along d meets the cube with the centre o if |(o x d)_i| <= 1/2 (|d_j| + |d_k|)
 *           for each axis i, where j and k are the other two axes. This test is linear in the
 *           pixel's position and needs no division.
 *   else    On each axis, the ray is intersected with the plane of the face that is
 *           turned to the eye. The ray hits the voxel if one of these intersections is within
 *           the voxel on the other two axes (Majercik et al. 2018).
 */
flat in uint tint; /* 0xBBGGRR */
flat in vec3 o;

#if TARGET == COMPACT
out uvec2 kept; /* first word: colour | face << 24; second word: depth */
#elif TARGET == FORWARD
out vec4 kept;
#else
out vec4 kept;   /* normal in the camera's frame */
out vec4 kept_1; /* colour */
#endif

bool slabs(vec3 d, out uint face, out float t)
{
    vec3 s = -sign(d), near = (0.5 * s + o) / d;
    vec3 p = abs(d.yzx * near - o.yzx), q = abs(d.zxy * near - o.zxy);
    bvec3 hit = bvec3(p.x <= layer.z && q.x <= layer.z, p.y <= layer.z && q.y <= layer.z,
                      p.z <= layer.z && q.z <= layer.z);
    /*
     * For a ray parallel to a plane, `near` is the result of a division by zero, which is harmless: the ray can still
     * hit the planes of the other two axes.
     */
    t = hit.x ? near.x : hit.y ? near.y : near.z;
    face = hit.x ? (s.x > 0.0 ? 1u : 0u) : hit.y ? (s.y > 0.0 ? 3u : 2u) : s.z > 0.0 ? 5u : 4u;
    return hit.x || hit.y || hit.z;
}

void main()
{
    vec3 d = ray(slope(gl_FragCoord.xy));
    float t;
    uint face;
#if LINES
    vec3 m = abs(d);
    PRECISE vec3 reach = layer.z * (m.yzx + m.zxy);
    if (any(greaterThan(abs(cross3(o, d)), reach)))
        discard;
    face = enter(o, d, t);
#else
    if (!slabs(d, face, t))
        discard;
#endif
    PRECISE float depth = t * eye_at.w;
    PRECISE float scaled = depth * layer.x * DEPTH_SCALE;
#if TRUE_DEPTH
    gl_FragDepth = scaled;
#endif
#if TARGET == COMPACT
    kept = uvec2(tint | face << 24, floatBitsToUint(scaled));
#elif TARGET == FORWARD
    kept = lit(tint, face);
#else
    vec3 normal = vec3(0.0);
    normal[face >> 1] = (face & 1u) == 1u ? 1.0 : -1.0;
    normal = vec3(dot(normal, eye_right.xyz), dot(normal, eye_up.xyz), -dot(normal, eye_forward.xyz));
#if TARGET == SMALL
    normal = 0.5 + 0.5 * normal;
#endif
    kept = vec4(normal, 1.0);
    kept_1 = vec4(channels(tint), float(face) / 255.0);
#endif
}
