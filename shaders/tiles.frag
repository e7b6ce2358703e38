/* SPDX-License-Identifier: Apache-2.0 */
/* Computes the maximum depth in each tile of 8 x 8 pixels, for hide.c. */
uniform sampler2D depths;
out float farthest;

void main()
{
    ivec2 from = 8 * ivec2(gl_FragCoord.xy), to = min(from + 8, ivec2(frame.xy));
    float most = 0.0;
    for (int y = from.y; y < to.y; y++)
        for (int x = from.x; x < to.x; x++)
            most = max(most, texelFetch(depths, ivec2(x, y), 0).r);
    farthest = most;
}
