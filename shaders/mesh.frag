/* SPDX-License-Identifier: Apache-2.0 */
in vec3 normal;
in float along;
out vec4 kept, kept_1;

void main()
{
    gl_FragDepth = along * layer.x * DEPTH_SCALE;
#if TARGET == SMALL
    kept = vec4(0.5 + 0.5 * normalize(normal), 1.0);
#else
    kept = vec4(normalize(normal), 1.0);
#endif
    kept_1 = vec4(vec3(paint.xyz), 0.0) / 255.0;
}
