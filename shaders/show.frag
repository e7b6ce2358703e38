/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Copies a picture to a framebuffer, in which row 0 is the bottom row, and blends a sheet (a layer of letters and
 * boxes) over the picture.
 *
 * If ANTIALIASED is 1, edges are smoothed by the method of src/render/points/antialias.c. Functions that have the same
 * name in both files compute the same integers, so the colours are bit-identical. antialias.h defines the terms side
 * and run. Sides are computed from the pixels when needed instead of being stored.
 */
uniform sampler2D picture;
uniform sampler2D sheet;
out vec4 colour;

ivec4 texel(sampler2D from, ivec2 p)
{
    return ivec4(255.0 * texelFetch(from, p, 0) + 0.5);
}

ivec3 pixel(ivec2 p)
{
    return texel(picture, p).rgb;
}

#if ANTIALIASED
const ivec2 DOWN = ivec2(0, 1), RIGHT = ivec2(1, 0);

/* Returns 1 if there is an edge between the pixels `p` and `p + to`, and 0 otherwise. Pixels outside the picture form
   no edges. */
int side(ivec2 p, ivec2 to)
{
    if (any(lessThan(p, ivec2(0))) || any(greaterThanEqual(p + to, textureSize(picture, 0))))
        return 0;
    return any(greaterThanEqual(abs(pixel(p) - pixel(p + to)), ivec3(LEAST))) ? 1 : 0;
}

/* Returns the number of sides, at most RUN + 1, by which the run extends in the direction `along` beyond the side
 * between `p` and `p + across`. */
int run_of(ivec2 p, ivec2 across, ivec2 along)
{
    int n = 0;
    while (n <= RUN && side(p + (n + 1) * along, across) == 1)
        n++;
    return n;
}

int share_of(int before, int after)
{
    int k = min(before, after), total = before + after + 1;
    return before == after ? (64 + total) / (2 * total) : (2 * 128 * (total - 2 * k - 1) + total) / (2 * total);
}

/*
 * Computes a weight for the side between the pixels `p` and `p + across`. If `sign` is 1, this is the weight with which
 * the second pixel is mixed into the first. If `sign` is -1, it is the weight with which the first pixel is mixed into
 * the second.
 */
int share(ivec2 p, ivec2 across, int sign)
{
    ivec2 along = ivec2(1) - across, end;
    if (side(p, across) == 0)
        return 0;
    int before = run_of(p, across, -along), after = run_of(p, across, along);
    int bend_before = 0, bend_after = 0;
    if (before <= RUN) {
        end = p - (before + 1) * along;
        bend_before = side(end, along) - side(end + across, along);
    }
    if (after <= RUN) {
        end = p + after * along;
        bend_after = side(end, along) - side(end + across, along);
    }
    before = min(before, RUN);
    after = min(after, RUN);
    int one = share_of(before, after);
    return (before <= after && bend_before == sign ? one : 0) + (after <= before && bend_after == sign ? one : 0);
}

ivec3 mixed(ivec2 p, ivec2 across, int share_1, int share_2)
{
    ivec3 sum = pixel(p) * (256 - share_1 - share_2);
    if (share_1 != 0)
        sum += pixel(p - across) * share_1;
    if (share_2 != 0)
        sum += pixel(p + across) * share_2;
    return (sum + 128) >> 8;
}

ivec3 smoothed(ivec2 p)
{
    int above = share(p - DOWN, DOWN, -1), under = share(p, DOWN, 1);
    int left = share(p - RIGHT, RIGHT, -1), right = share(p, RIGHT, 1);
    if ((above | under | left | right) == 0)
        return pixel(p);
    return max(above, under) >= max(left, right) ? mixed(p, DOWN, above, under) : mixed(p, RIGHT, left, right);
}
#else
ivec3 smoothed(ivec2 p)
{
    return pixel(p);
}
#endif

void main()
{
    ivec2 p = ivec2(gl_FragCoord.x, float(textureSize(picture, 0).y) - gl_FragCoord.y);
    ivec4 over = texel(sheet, p);
    colour = vec4(vec3(over.rgb + (smoothed(p) * (255 - over.a) + 127) / 255) / 255.0, 1.0);
}
