/* SPDX-License-Identifier: Apache-2.0 */
/* Draws the triangles of a tool into the G-buffer of the thesis. */
in vec3 corner;
in vec3 out_of_it;
out vec3 normal;
out float along;

void main()
{
    vec3 o = corner - eye_at.xyz;
    float x = dot(o, eye_right.xyz), y = dot(o, eye_up.xyz), z = dot(o, eye_forward.xyz);
    normal = vec3(dot(out_of_it, eye_right.xyz), dot(out_of_it, eye_up.xyz), -dot(out_of_it, eye_forward.xyz));
    along = z;
    gl_Position = vec4(x * eye_at.w / axis_0.w, -y * eye_at.w / axis_1.w, z - 2.0 * axis_2.w, z);
}
