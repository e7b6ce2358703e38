/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Follows a ray through the cells of a brick, one for each voxel, to the first voxel with an exposed face (Amanatides
 * and Woo 1987). In a regular grid, a ray from the eye meets bricks in ascending order of the distance from the eye to
 * the brick's centre. The same applies to voxels.
 *
 * point.frag draws each voxel slightly wider than a cell, so a ray that passes close to an edge of a cell can hit a
 * voxel whose cell it does not enter. For such a ray, the shader therefore tests every voxel of the brick as point.frag
 * does, and uses the nearest voxel that the ray hits.
 */
flat in uvec4 what;
flat in vec3 o;
flat in vec3 base;
uniform usamplerBuffer shades;
#if TARGET == FORWARD
out vec4 kept;
#else
out uvec2 kept; /* first word: colour | face << 24; second word: depth */
#endif

/* distance from an edge, in voxels, below which a ray counts as close; greater than the sum of a voxel's enlargement
 * and the rounding error */
const float CLOSE = 4e-4;

uint ones(uint v)
{
    v = v - (v >> 1 & 0x55555555u);
    v = (v & 0x33333333u) + (v >> 2 & 0x33333333u);
    return ((v + (v >> 4)) & 0x0f0f0f0fu) * 0x01010101u >> 24;
}

bool holds(uint bit)
{
    return ((bit < 32u ? what.y : what.z) >> (bit & 31u) & 1u) != 0u;
}

vec3 voxel(uint bit)
{
    uvec3 at = uvec3((what.x & 7u) << 2 | (bit & 3u), (what.x >> 3 & 7u) << 2 | (bit >> 2 & 3u),
                     (what.x >> 6 & 7u) << 2 | bit >> 4);
    PRECISE vec3 c = base + vec3(at);
    return c;
}

bool nearest_of_all(vec3 d, out uint best)
{
    vec3 m = abs(d);
    PRECISE vec3 reach = layer.z * (m.yzx + m.zxy);
    float least = 1e30;
    best = 0u;
    for (uint bit = 0u; bit < 64u; bit++) {
        vec3 c = voxel(bit);
        float distance = dot3(c, c);
        if (!holds(bit) || !(distance < least))
            continue;
        if (all(lessThanEqual(abs(cross3(c, d)), reach))) {
            least = distance;
            best = bit;
        }
    }
    return least < 1e30;
}

void main()
{
    vec3 ray_d = ray(slope(gl_FragCoord.xy)), d = mix(ray_d, vec3(1e-20), equal(ray_d, vec3(0.0)));
    vec3 inverse = 1.0 / d, width = abs(inverse), wide = (2.0 + CLOSE) * width;
    vec3 near = o * inverse - wide, far = o * inverse + wide;
    float t = max(max(near.x, near.y), near.z);
    if (t > min(min(far.x, far.y), far.z))
        discard;
    /* `at` is a position in the brick, whose cells are numbered from 0 to 3 on each axis. */
    vec3 at = d * t - o + 2.0;
    ivec3 direction = ivec3(sign(d));
    ivec3 cell = clamp(ivec3(floor(at)), ivec3(0), ivec3(3));
    vec3 next = (vec3(cell + max(direction, ivec3(0))) + o - 2.0) * inverse;
    vec3 off = abs(at - floor(at + 0.5));
    bvec3 along = lessThan(near, vec3(t));
    bool edge = any(lessThan(mix(vec3(1.0), off, along), vec3(2.0 * CLOSE)));
    uint bit = 0u;
    bool found = false;
    for (int i = 0; i < 10 && !edge; i++) {
        bit = uint(cell.x | cell.y << 2 | cell.z << 4);
        found = holds(bit);
        if (found)
            break;
        float first = min(min(next.x, next.y), next.z);
        bvec3 least = equal(next, vec3(first));
        /*
         * Tests whether the ray crosses the planes of two axes at almost the same distance. For each axis, `width` is
         * the length of the ray between adjacent planes. `apart` is the difference between the two distances, divided
         * by the greater of the two widths.
         */
        float slow = max(max(least.x ? width.x : 0.0, least.y ? width.y : 0.0), least.z ? width.z : 0.0);
        vec3 apart = (next - first) / max(width, vec3(slow));
        edge = any(lessThan(mix(apart, vec3(1.0), least), vec3(CLOSE))) ||
               (int(least.x) + int(least.y) + int(least.z) > 1);
        cell += direction * ivec3(least);
        if (any(lessThan(cell, ivec3(0))) || any(greaterThan(cell, ivec3(3))))
            break;
        next += width * vec3(least);
    }
    if (edge)
        found = nearest_of_all(ray_d, bit);
    if (!found)
        discard;
    uint below = bit < 32u ? ones(what.y & ((1u << bit) - 1u))
                           : ones(what.y) + ones(what.z & ((1u << (bit - 32u)) - 1u));
    uint tint = tint_of(texelFetch(shades, int(what.w + below)).r);
    float depth;
    uint face = enter(voxel(bit), ray_d, depth);
#if TARGET == FORWARD
    kept = lit(tint, face);
#else
    PRECISE float in_voxels = depth * eye_at.w;
    PRECISE float scaled = in_voxels * layer.x * DEPTH_SCALE;
    kept = uvec2(tint | face << 24, floatBitsToUint(scaled));
#endif
}
