/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Converts the crossings of a row to solid bits, and solid bits to classes.
 *
 * Let P and M be a row's bits in plus and minus as binary numbers, and W(i) the
 * winding number at centre i.  If crossings enter and leave alternately,
 *
 *       i   0 1 2 3 4 5 6 7
 *       P   . 1 . . . 1 . .        2^leave - 2^enter = 2^enter + ... + 2^(leave - 1),
 *       M   . . . 1 . . . 1
 *   M - P   . 1 1 . . 1 1 .        so M - P has the solid centres' bits.
 *
 * The result Q = M - P shows whether the crossings alternate. Let L = 2 Q, which has the bit of the previous centre at
 * each centre, and X = P xor M. If
 *
 *   X = Q xor L                    Q changes where there is a crossing, and only there
 *   X and (Q xor P) = 0            Q becomes 1 where a crossing enters, 0 where a crossing leaves
 *   the last bit of Q is 0
 *
 * then W = Q, by induction: W(-1) = Q(-1) = 0, and at each centre, W and Q change by the same
 * amount: 0 if X(i) = 0 (no crossing, or one of each sign), +1 at an entering crossing, and -1 at a
 * leaving crossing.  The row is then proven, and does not leak.  The parity rule gives the same
 * solid bits.
 *
 * Word by word, the bit before a word is the borrow from the previous word: in a proven
 * word, q + b = m - p + b' 2^64, where b is the bit before the word and b' is the last bit
 * of the word, so that b' is the borrow of m - p - b.
 *
 * In a mesh that is inside out, the first crossing leaves: Q = P - M, with P and M exchanged in the conditions, and W =
 * -Q. A kernel first tests the order that was valid for the previous row, and then the opposite order. A row that
 * satisfies the conditions in neither order is marked OST_VOX_UNPROVEN and is summed crossing by crossing.
 */
#include <string.h>

#include "core/conditions.h"
#include "cpu/voxelize/voxelize.h"

static int count_bits(uint64_t v)
{
    /* Most words are 0. For these, the test of v avoids the builtin, which is a loop without POPCNT. */
    return v ? __builtin_popcountll(v) : 0;
}

/* Computes the solid bits of one row. Returns false if the row is not proven. Otherwise adds the number of set bits to
   *count. */
static bool fill_row(const uint64_t *enter, const uint64_t *leave, size_t words, uint64_t *bits, uint64_t *count)
{
    uint64_t wrong = 0, inside = 0, n = 0; /* `inside` is the last solid bit of the previous word */
    for (size_t w = 0; w < words; w++) {
        const uint64_t x = enter[w] ^ leave[w], q = leave[w] - enter[w] - inside;
        wrong |= (x ^ q ^ (q << 1 | inside)) | (x & (q ^ enter[w]));
        inside = leave[w] < enter[w] || (x == 0 && inside);
        bits[w] = q;
        n += (uint64_t)count_bits(q);
    }
    if (wrong || inside)
        return false;
    *count += n;
    return true;
}

uint64_t ost_vox_fill_scalar(ost_vox_tile *tile, size_t first_row, size_t rows, uint64_t *bits)
{
    const size_t words = tile->row_bits / 64;
    uint64_t *plus = tile->planes + first_row * words, *minus = plus + tile->minus / 64;
    const bool keep = tile->any_unproven;
    bool inside_out = false;
    uint64_t count = 0;
    for (size_t r = first_row; r < first_row + rows; r++, plus += words, minus += words, bits += words) {
        bool proven = fill_row(inside_out ? minus : plus, inside_out ? plus : minus, words, bits, &count);
        if (!proven) {
            inside_out = !inside_out;
            proven = fill_row(inside_out ? minus : plus, inside_out ? plus : minus, words, bits, &count);
        }
        if (!proven) {
            tile->row_state[r] |= OST_VOX_UNPROVEN;
            tile->any_unproven = true;
        } else if (!keep) {
            memset(plus, 0, words * sizeof *plus);
            memset(minus, 0, words * sizeof *minus);
        }
    }
    return count;
}

/* Computes the solid bits of one row by adding its crossings one by one. Returns false if the row leaks. */
static bool sum_bits(const uint64_t *plus, const uint64_t *minus, int words, int32_t mask, uint64_t *bits)
{
    int32_t winding = 0;
    for (int w = 0; w < words; w++) {
        uint64_t x = plus[w] ^ minus[w], solid = winding & mask ? UINT64_MAX : 0;
        for (; x; x &= x - 1) {
            const uint64_t from = -(x & -x); /* mask of the lowest set bit of x and all bits above it */
            winding += plus[w] & x & -x ? 1 : -1;
            solid = winding & mask ? solid | from : solid & ~from;
        }
        bits[w] = solid;
    }
    return !(winding & mask);
}

static bool sum_steps(const uint64_t *plus, const uint64_t *minus, const int32_t *steps, int32_t n, int32_t mask,
                      uint64_t *bits)
{
    int32_t winding = 0;
    for (int32_t i = 0; i < n; i++) {
        winding += steps[i] + (int32_t)(plus[i / 64] >> (i % 64) & 1) - (int32_t)(minus[i / 64] >> (i % 64) & 1);
        bits[i / 64] |= (uint64_t)((winding & mask) != 0) << (i % 64);
    }
    return !((winding + steps[n]) & mask);
}

int64_t ost_vox_fill_unproven(const ost_vox_tile *tile, size_t first_row, size_t rows, ost_fill_rule rule,
                              uint64_t *bits, uint64_t *leaking_rows)
{
    const size_t words = tile->row_bits / 64;
    const uint64_t *plus = tile->planes, *minus = tile->planes + tile->minus / 64;
    const int32_t mask = rule == OST_FILL_PARITY ? 1 : -1;
    int64_t more = 0;
    for (size_t r = first_row; r < first_row + rows; r++) {
        if (!tile->row_state[r])
            continue;
        uint64_t *row = bits + (r - first_row) * words;
        for (size_t w = 0; w < words; w++) {
            more -= tile->row_state[r] & OST_VOX_UNPROVEN ? 0 : count_bits(row[w]);
            row[w] = 0;
        }
        const bool sound = tile->row_state[r] & OST_VOX_SPILLED
                               ? sum_steps(plus + r * words, minus + r * words,
                                           tile->spill + r * ((size_t)tile->nx + 1), tile->nx, mask, row)
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

/*
 * Returns eight bytes; the lowest bit of byte b is bit b of the parameter, and the other bits are 0. The
 * parameter is copied to all eight bytes, and byte b is masked to its bit b. If this bit is set, adding
 * 0x7f sets the top bit of byte b.
 */
static uint64_t spread(uint64_t byte)
{
    const uint64_t ones = UINT64_C(0x0101010101010101);
    return ((byte * ones & UINT64_C(0x8040201008040201)) + 0x7f * ones) >> 7 & ones;
}

void ost_vox_expand_scalar(const uint64_t *cutting, const uint64_t *noncutting, size_t rows, int words, int32_t nx,
                           bool stream, uint8_t *voxels)
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
