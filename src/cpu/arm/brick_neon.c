/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Converts rows of voxels into bricks, two bricks at a time.  A row contains four voxels of one
 * brick and the next four voxels of the other.  Two rows therefore contain an eighth
 * of each brick.
 *
 * The parameter `stream` is ignored, because the intrinsics have no stores that bypass the caches. Therefore the kernel
 * `drain` needs no NEON variant.
 */
#include "core/conditions.h"
#include "core/neon.h"
#include "cpu/bone/bone.h"
#include "cpu/kernels.h"

enum { LANES = 8, EIGHTHS = 8 };

typedef struct two_bricks {
    int16x8_t v[2];
} two_bricks;

/* Computes one eighth (number p, 0 to 7) of brick x and of brick x + 1. */
static inline two_bricks eighths(const int16_t *const rows[16], size_t x, int p)
{
    const int64x2_t low = vreinterpretq_s64_s16(vld1q_s16(rows[2 * p] + 4 * x));
    const int64x2_t high = vreinterpretq_s64_s16(vld1q_s16(rows[2 * p + 1] + 4 * x));
    return (two_bricks){{vreinterpretq_s16_s64(vzip1q_s64(low, high)), vreinterpretq_s16_s64(vzip2q_s64(low, high))}};
}

/* Narrows two registers of 16-bit lanes, each 0 or -1, to one register of bytes. */
static inline uint8x16_t narrow(uint16x8_t a, uint16x8_t b)
{
    return vuzp1q_u8(vreinterpretq_u8_u16(a), vreinterpretq_u8_u16(b));
}

ost_brick_sums ost_brick_row_neon(const int16_t *const rows[16], size_t bricks, int16_t threshold, bool stream,
                                  int16_t *density, uint64_t *occupancy)
{
    (void)stream;
    const int16x8_t least = vdupq_n_s16(threshold);
    int16x8_t highest = vdupq_n_s16(0);
    int32_t active = 0;
    for (size_t x = 0; x < bricks; x += 2) {
        two_bricks part[EIGHTHS];
        for (int p = 0; p < EIGHTHS; p++)
            part[p] = eighths(rows, x, p);
        for (size_t i = 0; i < 2; i++) {
            const size_t at = (size_t)ost_brick_spread((int32_t)(x + i));
            uint16x8_t on[EIGHTHS];
            for (int p = 0; p < EIGHTHS; p++) {
                on[p] = vcgeq_s16(part[p].v[i], least);
                const int16x8_t v = vandq_s16(part[p].v[i], vreinterpretq_s16_u16(on[p]));
                vst1q_s16(density + at * OST_BRICK_VOXELS + p * LANES, v);
                highest = vmaxq_s16(highest, v);
            }
            const uint64_t word = ost_neon_bits64(narrow(on[0], on[1]), narrow(on[2], on[3]), narrow(on[4], on[5]),
                                                  narrow(on[6], on[7]));
            occupancy[at] = word;
            active += __builtin_popcountll(word);
        }
    }
    return (ost_brick_sums){active, vmaxvq_s16(highest)};
}

bool ost_any_active_neon(const int16_t *base, const size_t *row, int count, int width, int16_t threshold)
{
    if (width < LANES)
        return ost_any_active_scalar(base, row, count, width, threshold);
    int16x8_t most = vdupq_n_s16(0); /* starts at 0, because no threshold is below 1 */
    for (int r = 0; r < count; r++) {
        const int16_t *const from = base + row[r];
        for (int x = 0; x + LANES <= width; x += LANES)
            most = vmaxq_s16(most, vld1q_s16(from + x));
        /* loads the last eight voxels of the row; some of them were already included */
        most = vmaxq_s16(most, vld1q_s16(from + width - LANES));
    }
    return vmaxvq_s16(most) >= threshold;
}
