/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The compositing pass of the thesis: lights each pixel from one direction, using its depth, normal and colour.
 */
uniform sampler2D normals, colours, depths;
out vec4 colour;

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    float depth = texelFetch(depths, at, 0).r;
    gl_FragDepth = depth;
    if (depth == 1.0) {
        colour = background();
        return;
    }
    vec3 normal = texelFetch(normals, at, 0).xyz;
#if TARGET == SMALL
    normal = normalize(2.0 * normal - 1.0);
#endif
    vec4 c = texelFetch(colours, at, 0);
    /* direction of the light: over the viewer's left shoulder, as in points/light.c */
    float light = 0.32 + 0.68 * max(dot(normal, normalize(vec3(-0.40, 0.55, 0.73))), 0.0);
    light = layer.y > 0.5 ? light : 1.0;
    colour = vec4(floor(c.rgb * 255.0 + 0.5) * floor(min(256.0 * light + 0.5, 256.0)) / 256.0 / 255.0, c.a);
    colour.rgb = floor(colour.rgb * 255.0) / 255.0;
}
