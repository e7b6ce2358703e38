/* SPDX-License-Identifier: Apache-2.0 */
/* Draws a triangle that covers the window. Row 0 of the texture is the top row. */
out vec2 at;

void main()
{
    vec2 p = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
    at = vec2(0.5 + 0.5 * p.x, 0.5 - 0.5 * p.y);
    gl_Position = vec4(p, 0.0, 1.0);
}
