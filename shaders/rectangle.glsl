/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Computes the pixels that a cube may cover.
 *
 * rectangle_of computes the bounding rectangle of the cube in whole pixels, clipped to the frame, from the slopes of
 * the cube's corners (derived in splat_scalar.c). The point is placed at the centre of the clipped rectangle, because
 * OpenGL drops points whose centre is outside the frame.
 *
 * square_of computes the square around the cube's bounding sphere, as in the thesis (Sigg et al. 2006). The sphere has
 * the radius R and the centre c; m_x, m_y, m_w are the right, up and forward vectors. Let t_i = (R m_i, m_i . c), and
 * let <a, b> = a.xyz . b.xyz - a.w b.w. The plane through the eye with the slope X touches the sphere if
 * <t_x - X t_w, t_x - X t_w> = 0. This is a quadratic equation in X. The mean of its two solutions is
 * <t_x, t_w> / <t_w, t_w>.
 */
float spread(vec3 axis, float t)
{
    vec3 m = abs(axis - t * eye_forward.xyz);
    return 0.5 * ((m.x + m.y) + m.z);
}

/*
 * Computes the first and last column and the first and last row of the pixels that a cube covers. `side` is the edge
 * length of the cube in voxels. Returns false if the cube covers no pixel.
 */
bool rectangle_of(vec3 o, float side, out vec4 r)
{
    float x = dot3(eye_right.xyz, o), y = dot3(eye_up.xyz, o), z = dot3(eye_forward.xyz, o);
    float nearest = z - side * eye_forward.w;
    r = vec4(0.0);
    if (!(nearest > axis_2.w))
        return false;
    float focal = eye_at.w, inverse = 1.0 / z, tx = x * inverse, ty = y * inverse, k = side * focal / nearest;
    float hx = spread(eye_right.xyz, tx) * k + 0.01, hy = spread(eye_up.xyz, ty) * k + 0.01;
    float px = tx * focal + (axis_0.w - 0.5), py = (axis_1.w - 0.5) - ty * focal;
    r = vec4(clamp(ceil(px - hx), 0.0, frame.x), clamp(floor(px + hx), -1.0, frame.x - 1.0),
             clamp(ceil(py - hy), 0.0, frame.y),
             clamp(floor(py + hy), -1.0, frame.y - 1.0));
    return r.x <= r.y && r.z <= r.w;
}

float sphere(vec4 a, vec4 b)
{
    return dot(a.xyz, b.xyz) - a.w * b.w;
}

/*
 * Computes the centre and the size of the square in pixels. Returns false unless the sphere is completely in front of
 * the eye.
 */
bool square_of(vec3 o, out vec2 middle, out float size)
{
    const float R = 0.8660254; /* half the diagonal of a voxel, the radius of its bounding sphere */
    vec4 tx = vec4(R * eye_right.xyz, dot(eye_right.xyz, o)), ty = vec4(R * eye_up.xyz, dot(eye_up.xyz, o));
    vec4 tw = vec4(R * eye_forward.xyz, dot(eye_forward.xyz, o));
    float q = sphere(tw, tw);
    middle = vec2(0.0);
    size = 0.0;
    if (!(q < 0.0 && tw.w > R))
        return false;
    vec2 c = vec2(sphere(tx, tw), sphere(ty, tw)) / q;
    vec2 h = sqrt(max(c * c - vec2(sphere(tx, tx), sphere(ty, ty)) / q, 0.0));
    middle = vec2(axis_0.w + c.x * eye_at.w, axis_1.w - c.y * eye_at.w);
    size = 2.0 * eye_at.w * max(h.x, h.y);
    return true;
}
