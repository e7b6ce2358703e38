/* SPDX-License-Identifier: Apache-2.0 */
/*
 * From crossings to solid bits to classes.
 *
 * Let P and M be a row's bits in plus and minus, d(i) = P(i) - M(i), and
 * W(i) = d(0) + ... + d(i) the winding number at centre i.  X = P xor M is d
 * modulo 2, so the running parity Q(i) = X(0) xor ... xor X(i) is W(i) modulo
 * 2.  Where every crossing that changes Q changes it the right way,
 *
 *   X(i) = 1 and P(i) = 1  =>  Q(i) = 1     (it enters: 0 -> 1)
 *   X(i) = 1 and P(i) = 0  =>  Q(i) = 0     (it leaves: 1 -> 0)
 *
 * that is, X and (Q xor P) have no bit in common, W = Q: by induction, since
 * W(-1) = Q(-1) = 0, and W(i) - W(i-1) = Q(i) - Q(i-1) in each of the cases
 * X(i) = 0 (both 0), entering (both +1) and leaving (both -1).  Then W is 0 or
 * 1 everywhere, solid is Q, and the row leaks iff its last Q is 1.  A row that
 * fails, or leaks, is UNPROVEN and summed crossing by crossing.  By parity, Q is
 * what is asked for and only leaks are odd.
 */
#include <string.h>

#include "core/conditions.h"
#include "cpu/voxelize/voxelize.h"

static int count_bits(uint64_t v)
{
    return __builtin_popcountll(v);
}

/* X(0) xor ... xor X(i) in every bit i. */
static uint64_t running_parity(uint64_t x)
{
    x ^= x << 1;
    x ^= x << 2;
    x ^= x << 4;
    x ^= x << 8;
    x ^= x << 16;
    return x ^ x << 32;
}

uint64_t ost_vox_fill_scalar(ost_vox_tile *tile, size_t first_row, size_t rows, bool parity, bool stream, uint64_t *bits)
{
    (void)stream;
    const size_t words = tile->row_bits / 64;
    uint64_t *plus = tile->planes + first_row * words, *minus = plus + tile->minus / 64;
    const bool keep = tile->any_odd;
    uint64_t count = 0;
    for (size_t r = first_row; r < first_row + rows; r++) {
        uint64_t carry = 0, unproven = 0;
        for (size_t w = 0; w < words; w++, plus++, minus++) {
            const uint64_t x = *plus ^ *minus, q = x ? running_parity(x) ^ carry : carry;
            unproven |= x & (q ^ *plus);
            carry = -(q >> 63);
            *bits++ = q;
            count += q ? (uint64_t)count_bits(q) : 0;
        }
        if (carry || (!parity && unproven)) {
            tile->odd[r] |= OST_VOX_UNPROVEN;
            tile->any_odd = true;
        } else if (!keep) {
            memset(plus - words, 0, words * sizeof *plus);
            memset(minus - words, 0, words * sizeof *minus);
        }
    }
    return count;
}

/* One row crossing by crossing, its bits cleared before; false when it leaks. */
static bool sum_bits(const uint64_t *plus, const uint64_t *minus, int words, int32_t mask, uint64_t *bits)
{
    int32_t winding = 0;
    for (int w = 0; w < words; w++) {
        uint64_t x = plus[w] ^ minus[w], solid = winding & mask ? UINT64_MAX : 0;
        for (; x; x &= x - 1) {
            const uint64_t from = -(x & -x); /* this bit and all above */
            winding += plus[w] & x & -x ? 1 : -1;
            solid = winding & mask ? solid | from : solid & ~from;
        }
        bits[w] = solid;
    }
    return !(winding & mask);
}

static bool sum_steps(const uint64_t *plus, const uint64_t *minus, const int32_t *steps, int32_t n, int32_t mask, uint64_t *bits)
{
    int32_t winding = 0;
    for (int32_t i = 0; i < n; i++) {
        winding += steps[i] + (int32_t)(plus[i / 64] >> (i % 64) & 1) - (int32_t)(minus[i / 64] >> (i % 64) & 1);
        bits[i / 64] |= (uint64_t)((winding & mask) != 0) << (i % 64);
    }
    return !((winding + steps[n]) & mask);
}

int64_t ost_vox_fill_odd(const ost_vox_tile *tile, size_t first_row, size_t rows, ost_fill_rule rule, uint64_t *bits,
                         uint64_t *leaking_rows)
{
    const size_t words = tile->row_bits / 64;
    const uint64_t *plus = tile->planes, *minus = tile->planes + tile->minus / 64;
    const int32_t mask = rule == OST_FILL_PARITY ? 1 : -1;
    int64_t more = 0;
    for (size_t r = first_row; r < first_row + rows; r++) {
        if (!tile->odd[r])
            continue;
        uint64_t *row = bits + (r - first_row) * words;
        for (size_t w = 0; w < words; w++) {
            more -= count_bits(row[w]);
            row[w] = 0;
        }
        const bool sound = tile->odd[r] & OST_VOX_SPILLED
                               ? sum_steps(plus + r * words, minus + r * words, tile->spill + r * ((size_t)tile->nx + 1), tile->nx,
                                           mask, row)
                               : sum_bits(plus + r * words, minus + r * words, (int)words, mask, row);
        if (!sound) {
            memset(row, 0, words * sizeof *row);
            ++*leaking_rows;
        }
        for (size_t w = 0; w < words; w++)
            more += count_bits(row[w]);
    }
    return more;
}

/* Eight bits to the low bits of eight bytes: copied to all, byte b keeps bit b, and a kept bit carries into the top. */
static uint64_t spread(uint64_t byte)
{
    const uint64_t ones = UINT64_C(0x0101010101010101);
    return ((byte * ones & UINT64_C(0x8040201008040201)) + 0x7f * ones) >> 7 & ones;
}

void ost_vox_expand_scalar(const uint64_t *cutting, const uint64_t *noncutting, size_t rows, int words, int32_t nx, bool stream,
                           uint8_t *voxels)
{
    (void)stream;
    for (size_t r = 0; r < rows; r++, voxels += nx) {
        for (int32_t i = 0; i < nx; i += 8) {
            const size_t word = r * (size_t)words + (size_t)(i / 64);
            uint64_t classes = OST_TOOL_CUTTING * spread(cutting[word] >> (i % 64) & 0xff);
            if (noncutting)
                classes |= OST_TOOL_NONCUTTING * spread(noncutting[word] >> (i % 64) & 0xff);
            memcpy(voxels + i, &classes, (size_t)(nx - i < 8 ? nx - i : 8));
        }
    }
}
