/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Computes the face through which a ray enters a voxel, and the light on this face, with the same operations as
 * `resolve` in points/splat_scalar.c.
 */
uint enter(vec3 o, vec3 d, out float t)
{
    d = mix(d, vec3(1e-20), equal(d, vec3(0.0)));
    PRECISE vec3 inverse = 1.0 / d;
    PRECISE vec3 near = o * inverse - 0.5 * abs(inverse);
    t = near.x;
    uint face = d.x < 0.0 ? 1u : 0u;
    if (near.y > t) {
        t = near.y;
        face = d.y < 0.0 ? 3u : 2u;
    }
    if (near.z > t) {
        t = near.z;
        face = d.z < 0.0 ? 5u : 4u;
    }
    return face;
}

vec3 channels(uint colour)
{
    return vec3(uvec3(colour, colour >> 8, colour >> 16) & 255u) / 255.0;
}

/* Returns the lit colour with the face in the alpha channel. */
vec4 lit(uint tint, uint face)
{
    uint light = face < 4u ? light_0[face] : light_4[face - 4u];
    uvec3 c = (uvec3(tint, tint >> 8, tint >> 16) & 255u) * light >> 8;
    return vec4(vec3(c), float(face)) / 255.0;
}

vec4 background()
{
    return vec4(channels(light_4.z), 6.0 / 255.0);
}
