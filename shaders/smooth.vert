/* SPDX-License-Identifier: Apache-2.0 */
/* Projects a corner of a smooth mesh. The normal is in the camera's frame: right, up, forward. */
in vec3 corner;
in vec3 out_of_it;
out vec3 normal;
out float along;

void main()
{
    vec3 o = corner - eye_at.xyz;
    float x = dot3(o, eye_right.xyz), y = dot3(o, eye_up.xyz), z = dot3(o, eye_forward.xyz);
    normal = vec3(dot3(out_of_it, eye_right.xyz), dot3(out_of_it, eye_up.xyz), dot3(out_of_it, eye_forward.xyz));
    along = z;
    /* y is reversed, because row 0 of the picture is the top row. */
    gl_Position = vec4(x * eye_at.w / axis_0.w, -y * eye_at.w / axis_1.w, z - 2.0 * axis_2.w, z);
}
