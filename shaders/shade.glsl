/* SPDX-License-Identifier: Apache-2.0 */
/* Computes the colour of a fully lit voxel, 0xBBGGRR, with the same integer operations as points/light.c. */
/* Entries 0 to 16383 contain brightness in 256ths | gloss << 9, one for each octahedral cell of normals. The other
   entries contain the colours of the paints. */
uniform usamplerBuffer palette;

uint tint_of(uint shade)
{
    uint number = shade >> 22 & 255u, bgr = texelFetch(palette, 16384 + int(number)).r;
    uvec3 c = uvec3(bgr, bgr >> 8, bgr >> 16) & 255u;
    if ((shade >> 30 & 1u) != 0u)
        c = c * 3u + uvec3(255u, 160u, 48u) * 5u >> 3;
    if (layer.y < 0.5 && number < 128u) {
        uint entry = texelFetch(palette, int(shade & 16383u)).r, open = (shade >> 14 & 255u) + 1u;
        uint bright = (entry & 511u) * open >> 8, gloss = (entry >> 9) * open >> 8;
        c = min((c * bright >> 8) + gloss, uvec3(255u));
    }
    return c.x | c.y << 8 | c.z << 16;
}
