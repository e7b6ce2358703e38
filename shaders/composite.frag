/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Lights the face at each pixel. The first layer fills the frame; a later layer replaces a pixel only if the layer is
 * nearer at this pixel.
 */
uniform usampler2D seen;
out vec4 colour;

void main()
{
    uvec2 s = texelFetch(seen, ivec2(gl_FragCoord.xy), 0).rg;
    uint face = s.x >> 24;
#if FIRST
    colour = face == 6u ? background() : lit(s.x, face);
#else
    if (face == 6u)
        discard;
    colour = lit(s.x, face);
#endif
    gl_FragDepth = uintBitsToFloat(s.y);
}
