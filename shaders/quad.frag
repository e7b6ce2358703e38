/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writes a pixel of a visible face. As in face.glsl, the depth is that of the point at which the ray crosses the plane
 * of the face.
 */
flat in uint tint; /* 0xBBGGRR */
flat in uint face;
flat in vec3 o;
out uvec2 kept; /* first word: colour | face << 24; second word: depth */

void main()
{
    vec3 d = ray(slope(gl_FragCoord.xy));
    d = mix(d, vec3(1e-20), equal(d, vec3(0.0)));
    PRECISE vec3 inverse = 1.0 / d;
    PRECISE vec3 near = o * inverse - 0.5 * abs(inverse);
    PRECISE float depth = near[face >> 1] * eye_at.w;
    PRECISE float scaled = depth * layer.x * DEPTH_SCALE;
    kept = uvec2(tint | face << 24, floatBitsToUint(scaled));
}
