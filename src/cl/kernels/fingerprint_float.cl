/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Computes results of the floating-point arithmetic of a device.  The results are recorded, and show why no voxel may
 * depend on floating-point arithmetic.  This is a separate program, built without options.  The results are not
 * checked.  The inputs and outputs are bit patterns.
 */
__kernel void ost_fingerprint_float(uint count, __global const uint *in, __global uint *out)
{
    const size_t item = get_global_id(0);
    if (item >= count)
        return;
    const float a = as_float(in[3 * item]), b = as_float(in[3 * item + 1]), c = as_float(in[3 * item + 2]);
    __global uint *to = out + item * OST_CL_FLOATS;
    to[0] = as_uint(a * b + c); /* shows whether the compiler fuses the product with the sum */
    to[1] = as_uint(mad(a, b, c));
    to[2] = as_uint(fma(a, b, c));
    to[3] = as_uint(a / b);
    to[4] = as_uint(1.0f / b);
    to[5] = as_uint(sqrt(a));
    to[6] = as_uint(rsqrt(a));
    to[7] = as_uint(a * 1.17549435e-38f); /* denormal or 0 */
    to[8] = as_uint((a + b) - b);
    to[9] = as_uint(a * b - a * b); /* not 0 if the compiler fuses one of the two products with the difference */
    to[10] = as_uint(sin(a));
    to[11] = as_uint(exp(b));
    to[12] = as_uint(convert_int_sat(a));
    to[13] = as_uint(convert_int_rte(a));
    to[14] = as_uint(native_recip(b));
    to[15] = as_uint(dot((float4)(a, b, c, 1.0f), (float4)(b, c, a, 1.0f)));
}
