/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Functions shared by the NEON kernels, mainly the conversion of lanes to bits, for
 * which NEON has no instruction.  Each of eight bytes is masked to a different bit, and
 * three pairwise additions combine the eight bytes into one:
 *
 *   ff 00 ff 00 00 00 00 ff  &  01 02 04 08 10 20 40 80  =  01 00 04 00 00 00 00 80  ->  85
 *
 * The additions produce no carries, because each byte has a different bit.
 */
#ifndef OST_CORE_NEON_H
#define OST_CORE_NEON_H

#include <arm_neon.h>
#include <stdint.h>

static inline uint8x8_t ost_neon_own_bits(void)
{
    return vcreate_u8(UINT64_C(0x8040201008040201));
}

/* Returns a word whose bit i is set if byte i of the four registers is 0xff. Every byte must be 0 or 0xff. */
static inline uint64_t ost_neon_bits64(uint8x16_t a, uint8x16_t b, uint8x16_t c, uint8x16_t d)
{
    const uint8x16_t own = vcombine_u8(ost_neon_own_bits(), ost_neon_own_bits());
    const uint8x16_t ab = vpaddq_u8(vandq_u8(a, own), vandq_u8(b, own)),
                     cd = vpaddq_u8(vandq_u8(c, own), vandq_u8(d, own));
    const uint8x16_t abcd = vpaddq_u8(ab, cd);
    return vgetq_lane_u64(vreinterpretq_u64_u8(vpaddq_u8(abcd, abcd)), 0);
}

/* Returns a byte whose bit i is set if byte i of v is 0xff. Every byte must be 0 or 0xff. */
static inline unsigned ost_neon_bits8(uint8x8_t v)
{
    return vaddv_u8(vand_u8(v, ost_neon_own_bits()));
}

/* Returns 1 if v has at least one set bit, otherwise 0. */
static inline int ost_neon_any(uint8x16_t v)
{
    return vmaxvq_u32(vreinterpretq_u32_u8(v)) != 0;
}

/*
 * Returns byte indices for the instruction TBL. With these indices, TBL moves to the front those 32-bit lanes that a
 * 4-bit mask selects; the remaining lanes of the result repeat lane 0.
 */
static inline uint8x16_t ost_neon_together(unsigned mask)
{
#define WORD(i) 4 * (i), 4 * (i) + 1, 4 * (i) + 2, 4 * (i) + 3
#define NO WORD(0)
    static const uint8_t moves[16][16] = {
        {NO, NO, NO, NO},
        {WORD(0), NO, NO, NO},
        {WORD(1), NO, NO, NO},
        {WORD(0), WORD(1), NO, NO},
        {WORD(2), NO, NO, NO},
        {WORD(0), WORD(2), NO, NO},
        {WORD(1), WORD(2), NO, NO},
        {WORD(0), WORD(1), WORD(2), NO},
        {WORD(3), NO, NO, NO},
        {WORD(0), WORD(3), NO, NO},
        {WORD(1), WORD(3), NO, NO},
        {WORD(0), WORD(1), WORD(3), NO},
        {WORD(2), WORD(3), NO, NO},
        {WORD(0), WORD(2), WORD(3), NO},
        {WORD(1), WORD(2), WORD(3), NO},
        {WORD(0), WORD(1), WORD(2), WORD(3)},
    };
#undef NO
#undef WORD
    return vld1q_u8(moves[mask]);
}

#endif
