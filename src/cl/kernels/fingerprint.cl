/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Integer operations that a device must compute correctly before it may compute any voxel.  OpenCL
 * C defines all of these results, but some drivers have computed them wrongly: the square of a
 * masked number shifted right by 32 was compiled to 0 (ROCm issue 1764), 64-bit products (ROCm
 * 1383) and (long)int * 100 (Aparapi 38) were wrong, and mul_hi was off by one (Oclgrind 16).
 * fingerprint_expect.h computes the same list of results on the host by different methods.
 * shared.h describes the buffers.
 */
__kernel void ost_fingerprint(uint count, __global const ulong *in, __global ulong *out)
{
    const size_t item = get_global_id(0);
    if (item >= count)
        return;
    const ulong a = in[2 * item], b = in[2 * item + 1];
    const uint a32 = (uint)a, b32 = (uint)b, by = b32 & 63u, by32 = b32 & 31u;
    const long sa = as_long(a), sb = as_long(b);
    const int sa32 = as_int(a32), sb32 = as_int(b32);
    const ulong d = b | 1ul;                    /* the divisor; it is odd, so never 0 */
    const long sd = as_long(b >> 1 | 1ul);      /* positive */
    const int sd32 = as_int(b32 >> 1 | 1u);     /* positive */
    __global ulong *to = out + item * OST_CL_FINGERPRINT;

    /* Products */
    to[0] = a * b;
    to[1] = mul_hi(a, b);
    to[2] = as_ulong(mul_hi(sa, sb));
    to[3] = (ulong)a32 * (ulong)b32;
    to[4] = as_ulong((long)sa32 * (long)sb32);
    to[5] = (ulong)(a32 & 0xffffffu) * (ulong)(a32 & 0xffffffu) >> 32;
    to[6] = as_ulong((long)sa32 * 100);
    to[7] = mul_hi(a32, b32);
    to[8] = as_uint(mul_hi(sa32, sb32));
    to[9] = a32 * b32;
    to[10] = mul_hi(a, b) << 44 | a * b >> 20;
    /* Carries */
    to[11] = a + b;
    to[12] = a + b < a ? 1ul : 0ul;
    to[13] = a - b;
    to[14] = a < b ? 1ul : 0ul;
    to[15] = (ulong)(a32 + b32) << 1 | (a32 + b32 < a32 ? 1ul : 0ul);
    /* Shifts */
    to[16] = a << by;
    to[17] = a >> by;
    to[18] = rotate(a, (ulong)by);
    to[19] = (ulong)(a32 << by32) << 32 | (ulong)(a32 >> by32);
    /* Quotients */
    to[20] = a / d;
    to[21] = a % d;
    to[22] = as_ulong(sa / sd);
    to[23] = as_ulong(sa % sd);
    to[24] = (ulong)(a32 / (uint)d) << 32 | (ulong)(a32 % (uint)d);
    to[25] = (ulong)as_uint(sa32 / sd32) << 32 | (ulong)as_uint(sa32 % sd32);
    to[26] = as_ulong(ost_rhe_div(as_long(a >> 2) - as_long(b >> 2), sd));
    /* Bits, order, width */
    to[27] = (ulong)clz(a) << 24 | (ulong)clz(a32) << 16 | (ulong)popcount(a) << 8 | (ulong)popcount(b32);
    to[28] = (sa < sb ? 1ul : 0ul) | (sa32 < sb32 ? 2ul : 0ul) | (a32 < b32 ? 4ul : 0ul) |
             (as_ulong(min(sa, sb)) ^ max(a, b)) << 3;
    to[29] = as_ulong((long)as_short((ushort)a) + (long)as_char((uchar)b));
    to[30] = (ulong)(ushort)a32 << 32 | (ulong)(uchar)b32;
    to[31] = ost_mix(a ^ b);
}

/*
 * Measures how many iterations (turns) the loops of a work item may have. The end of the loop depends on the computed
 * value, so a compiler can neither derive the number of turns nor unroll the loop without a test in each turn. Mesa's
 * llvmpipe allows 65,535 turns in total for all loops of an item, or of all items that share a vector. After that, it
 * ends every loop after one turn and reports no error.
 */
__kernel void ost_fingerprint_turns(uint end, __global uint *turns)
{
    if (get_global_id(0) > 0)
        return;
    uint x = 0, n = 0;
    while (x != end && n < OST_CL_TURNS) {
        x = OST_CL_NEXT_TURN(x);
        n++;
    }
    turns[0] = n;
    turns[1] = x;
}

/*
 * All items apply one commuting operation to each counter, with x = (uint)in[i]:
 * counter 0 add x, 1 sub x, 2 inc, 3 dec, 4 max, 5 min, 6 or, 7 and, 8 xor, 9 a signed
 * min, 10 a signed max, and 11 + x % 5 inc.  The counters 5 and 7 start as 0xffffffff,
 * all other counters start as 0.
 */
__kernel void ost_fingerprint_atomics(uint count, __global const ulong *in, volatile __global uint *counters)
{
    const size_t item = get_global_id(0);
    if (item >= count)
        return;
    const uint x = (uint)in[item];
    atomic_add(&counters[0], x);
    atomic_sub(&counters[1], x);
    atomic_inc(&counters[2]);
    atomic_dec(&counters[3]);
    atomic_max(&counters[4], x);
    atomic_min(&counters[5], x);
    atomic_or(&counters[6], x);
    atomic_and(&counters[7], x);
    atomic_xor(&counters[8], x);
    atomic_min((volatile __global int *)&counters[9], as_int(x));
    atomic_max((volatile __global int *)&counters[10], as_int(x));
    atomic_inc(&counters[11 + x % 5]);
}
