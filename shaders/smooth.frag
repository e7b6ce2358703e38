/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Lights a smooth mesh by the formulas of points/light.c. The directions of the lights are constant in the camera's
 * frame.
 */
in vec3 normal;
in float along;
out vec4 colour;

const vec3 key = vec3(-0.40, 0.55, -0.73), fill = vec3(0.85, -0.10, -0.50), back = vec3(0.10, -0.60, 0.55),
           halfway = vec3(-0.40, 0.55, -1.73);

float lamp(vec3 n, vec3 direction)
{
    return max(dot(n, normalize(direction)), 0.0);
}

void main()
{
    /* Because y is reversed, the corners of a triangle run clockwise when seen from outside. Therefore gl_FrontFacing
       is false on the outer side. */
    vec3 n = normalize(normal) * (gl_FrontFacing ? -1.0 : 1.0);
    float sky = 0.5 + 0.5 * n.y;
    float bright = 0.20 + 0.17 * sky + 0.74 * lamp(n, key) + 0.20 * lamp(n, fill) + 0.10 * lamp(n, back);
    uint scaled = min(uint(256.0 * bright + 0.5), 320u);
    uint gloss = uint(float(paint.w) * pow(lamp(n, halfway), 16.0) + 0.5);
    colour = vec4(min((paint.xyz * scaled >> 8) + gloss, uvec3(255u)), 0.0) / 255.0;
    gl_FragDepth = along * layer.x * DEPTH_SCALE;
}
