/* SPDX-License-Identifier: Apache-2.0 */
#include "core/conditions.h"
#include "render/points/cell_loops.h"
#include "render/points/slopes.h"

#include <immintrin.h>

/* A line consists of one and a half registers of 32 words. */
enum { LINE = OST_FIELD_LINE, FIRST = 32 };

static inline __m512i load(const uint16_t *at)
{
    return _mm512_loadu_si512(at);
}

static inline __m256i load_half(const uint16_t *at)
{
    return _mm256_loadu_si256((const void *)at);
}

void ost_field_bits_avx512(const uint64_t *rows, int count, uint16_t (*out)[LINE])
{
    const __m512i all = _mm512_set1_epi16(OST_FIELD_ALL);
    for (int i = 0; i < count; i++) {
        const uint64_t row = rows[i] >> OST_LINE_SHIFT;
        _mm512_storeu_si512(out[i], _mm512_maskz_mov_epi16((__mmask32)row, all));
        _mm256_storeu_si256((void *)(out[i] + FIRST),
                            _mm256_maskz_mov_epi16((__mmask16)(row >> FIRST), _mm512_castsi512_si256(all)));
    }
}

void ost_field_densities_avx512(uint64_t row, uint64_t near, const int16_t density[LINE], uint16_t out[LINE])
{
    const __m512i all = _mm512_set1_epi16(OST_FIELD_ALL), least = _mm512_set1_epi16(OST_FIELD_LEAST),
                  dense = _mm512_set1_epi16(OST_FIELD_DENSE);
    for (int i = 0; i < LINE; i += FIRST) {
        const int bit = i + OST_LINE_SHIFT;
        const __mmask32 line = i ? 0xffff : 0xffffffff;
        const __m512i v = _mm512_maskz_loadu_epi16(line, density + i);
        const __m512i some = _mm512_add_epi16(_mm512_srli_epi16(_mm512_max_epi16(v, _mm512_setzero_si512()), 4), least);
        const __mmask32 full = _mm512_cmpge_epi16_mask(v, dense) | (__mmask32)(near >> bit);
        _mm512_mask_storeu_epi16(
            out + i, line, _mm512_maskz_mov_epi16((__mmask32)(row >> bit), _mm512_mask_mov_epi16(some, full, all)));
    }
}

/* Sums nine values with the weights 1 2 3 4 5 4 3 2 1, as (one + three + five) + 2 (two + three) + 4 (four + five),
   where `one` is the sum of the values with weight 1, and so on. */
#define SUM(TYPE, PREFIX, LOAD, AT)                                                                                    \
    const TYPE one = PREFIX##_add_epi16(LOAD(AT(0)), LOAD(AT(8))), two = PREFIX##_add_epi16(LOAD(AT(1)), LOAD(AT(7))); \
    const TYPE three = PREFIX##_add_epi16(LOAD(AT(2)), LOAD(AT(6))),                                                   \
               four = PREFIX##_add_epi16(LOAD(AT(3)), LOAD(AT(5)));                                                    \
    const TYPE five = LOAD(AT(4)), odd = PREFIX##_add_epi16(one, three), even = PREFIX##_add_epi16(two, three);        \
    const TYPE quads = PREFIX##_slli_epi16(PREFIX##_add_epi16(four, five), 2);                                         \
    const TYPE sum = PREFIX##_add_epi16(PREFIX##_add_epi16(odd, five),                                                 \
                                        PREFIX##_add_epi16(PREFIX##_add_epi16(even, even), quads))

static inline __m512i nine(const uint16_t *in, ptrdiff_t step)
{
#define AT(k) (in + (k) * step)
    SUM(__m512i, _mm512, load, AT);
    return sum;
}

static inline __m256i nine_half(const uint16_t *in, ptrdiff_t step)
{
    SUM(__m256i, _mm256, load_half, AT);
    return sum;
#undef AT
}

void ost_field_down_avx512(const uint16_t (*in)[LINE], uint16_t (*out)[LINE], int count)
{
    __m512i sum = nine(in[0], LINE), slope = _mm512_setzero_si512();
    __m256i sum_half = nine_half(in[0] + FIRST, LINE), slope_half = _mm256_setzero_si256();
    for (int k = 0; k < 5; k++) {
        slope = _mm512_add_epi16(slope, _mm512_sub_epi16(load(in[k + 5]), load(in[k])));
        slope_half = _mm256_add_epi16(slope_half,
                                      _mm256_sub_epi16(load_half(in[k + 5] + FIRST), load_half(in[k] + FIRST)));
    }
    for (int i = 0;; i++) {
        _mm512_storeu_si512(out[i], sum);
        _mm256_storeu_si256((void *)(out[i] + FIRST), sum_half);
        if (i == count - 1)
            return;
        sum = _mm512_add_epi16(sum, slope);
        sum_half = _mm256_add_epi16(sum_half, slope_half);
        const __m512i five = load(in[i + 5]);
        const __m256i five_half = load_half(in[i + 5] + FIRST);
        const __m512i ends = _mm512_add_epi16(load(in[i]), load(in[i + 10]));
        const __m256i ends_half = _mm256_add_epi16(load_half(in[i] + FIRST), load_half(in[i + 10] + FIRST));
        slope = _mm512_add_epi16(slope, _mm512_sub_epi16(ends, _mm512_add_epi16(five, five)));
        slope_half = _mm256_add_epi16(slope_half, _mm256_sub_epi16(ends_half, _mm256_add_epi16(five_half, five_half)));
    }
}

static inline __m512i along_z(const ost_field_slice *const y[9], int row)
{
#define AT(k) ((*y[k])[row])
    SUM(__m512i, _mm512, load, AT);
#undef AT
    return _mm512_srli_epi16(_mm512_add_epi16(sum, _mm512_set1_epi16(8)), 4);
}

static inline __m256i along_z_half(const ost_field_slice *const y[9], int row)
{
#define AT(k) ((*y[k])[row] + FIRST)
    SUM(__m256i, _mm256, load_half, AT);
#undef AT
    return _mm256_srli_epi16(_mm256_add_epi16(sum, _mm256_set1_epi16(8)), 4);
}

void ost_field_slice_avx512(const ost_field_slice *const y[9], uint64_t rows, ost_field_slice *out)
{
    uint16_t z[OST_FIELD_ROWS + 1][LINE] __attribute__((aligned(64)));
    for (uint64_t left = rows; left; left &= left - 1) {
        const int row = __builtin_ctzll(left);
        _mm512_storeu_si512(z[row], along_z(y, row));
        _mm256_storeu_si256((void *)(z[row] + FIRST), along_z_half(y, row));
    }
    for (uint64_t left = rows; left; left &= left - 1) {
        const int row = __builtin_ctzll(left);
        const uint16_t *in = z[row] + OST_LINE_SKIP;
        _mm512_storeu_si512((*out)[row], nine(in, 1));
        _mm256_storeu_si256((void *)((*out)[row] + FIRST), nine_half(in + FIRST, 1));
    }
}

OST_CELLS_DEFINE(avx512)

static inline __m512i load_all(const int32_t *at)
{
    return _mm512_loadu_si512(at);
}

static inline __m512 one(float v)
{
    return _mm512_set1_ps(v);
}

static inline __m512 with_faces(const ost_slopes *s, __m512i faces, int axis)
{
    const __m512i by = _mm512_set1_epi32(OST_FIELD_BY_FACES), v = load_all(s->fine[axis]);
    const __mmask16 before = _mm512_test_epi32_mask(faces, _mm512_set1_epi32(1 << (2 * axis)));
    const __mmask16 behind = _mm512_test_epi32_mask(faces, _mm512_set1_epi32(2 << (2 * axis)));
    const __m512i more = _mm512_mask_add_epi32(v, behind, v, by);
    return _mm512_cvtepi32_ps(_mm512_mask_sub_epi32(more, before, more, by));
}

static inline __m512 dot(const __m512 a[3], const __m512 b[3])
{
    return _mm512_add_ps(_mm512_add_ps(_mm512_mul_ps(a[0], b[0]), _mm512_mul_ps(a[1], b[1])),
                         _mm512_mul_ps(a[2], b[2]));
}

static inline __m512 share(const __m512 fine[3], const __m512 wide[3], __m512 fine_size, __m512 wide_size)
{
    const __m512 both = _mm512_max_ps(_mm512_mul_ps(fine_size, wide_size), one(1));
    const __m512 t = _mm512_mul_ps(_mm512_sub_ps(_mm512_div_ps(dot(fine, wide), both), one(OST_AGREE_LEAST)),
                                   one(OST_AGREE_STEEP));
    const __mmask16 says = _mm512_cmp_ps_mask(wide_size, one(OST_WIDE_LEAST), _CMP_GE_OQ);
    return _mm512_maskz_min_ps(says, _mm512_max_ps(t, one(0)), one(1));
}

/* Returns 1 - |aside|, with the sign of the second argument, which must not be -0. */
static inline __m512 folded(__m512 aside, __m512 sign)
{
    const __m512 away = _mm512_sub_ps(one(1), _mm512_abs_ps(aside));
    return _mm512_mask_sub_ps(away, _mm512_cmp_ps_mask(sign, one(0), _CMP_LT_OQ), _mm512_abs_ps(aside), one(1));
}

static inline __m512i cell(__m512 p)
{
    const __m512 scaled = _mm512_mul_ps(_mm512_add_ps(p, one(1)), one(OST_OCTAHEDRAL_SIDE / 2));
    const __m512i c = _mm512_max_epi32(_mm512_cvttps_epi32(scaled), _mm512_setzero_si512());
    return _mm512_min_epi32(c, _mm512_set1_epi32(OST_OCTAHEDRAL_SIDE - 1));
}

/*
 * Returns the octahedral cell of each direction v, a weighted sum of the fine and the wide slope. The components of v
 * are never -0, and the sum of their magnitudes is 0 or at least 1.
 */
static inline __m512i octahedral(const __m512 v[3])
{
    const __m512 sum = _mm512_add_ps(_mm512_add_ps(_mm512_abs_ps(v[0]), _mm512_abs_ps(v[1])), _mm512_abs_ps(v[2])),
                 by = _mm512_max_ps(sum, one(1));
    const __m512 p = _mm512_div_ps(v[0], by), q = _mm512_div_ps(v[1], by);
    const __mmask16 below = _mm512_cmp_ps_mask(v[2], one(0), _CMP_LT_OQ);
    const __m512i u = cell(_mm512_mask_mov_ps(p, below, folded(q, v[0]))),
                  w = cell(_mm512_mask_mov_ps(q, below, folded(p, v[1])));
    return _mm512_add_epi32(u, _mm512_mullo_epi32(w, _mm512_set1_epi32(OST_OCTAHEDRAL_SIDE)));
}

/*
 * Divides numbers of magnitude below 2^26 by OST_FIELD_FULL, rounding toward zero as in C. The error of the float
 * quotient is below 1, and is corrected with the remainder.
 */
static inline __m512i by_full(__m512i v)
{
    const __m512i full = _mm512_set1_epi32(OST_FIELD_FULL), size = _mm512_abs_epi32(v), step = _mm512_set1_epi32(1);
    const __m512i q = _mm512_cvttps_epi32(_mm512_div_ps(_mm512_cvtepi32_ps(size), one(OST_FIELD_FULL)));
    const __m512i remainder = _mm512_sub_epi32(size, _mm512_mullo_epi32(q, full));
    const __m512i less = _mm512_mask_sub_epi32(q, _mm512_cmplt_epi32_mask(remainder, _mm512_setzero_si512()), q, step);
    const __m512i right = _mm512_mask_add_epi32(less, _mm512_cmpge_epi32_mask(remainder, full), less, step);
    return _mm512_mask_sub_epi32(right, _mm512_cmplt_epi32_mask(v, _mm512_setzero_si512()), _mm512_setzero_si512(),
                                 right);
}

static inline __m512i openness(__m512i field)
{
    const __m512i beyond = _mm512_sub_epi32(field, _mm512_set1_epi32(OST_FIELD_FLAT));
    const __m512i by = _mm512_mask_mov_epi32(_mm512_set1_epi32(OST_OPEN_EDGE),
                                             _mm512_cmpgt_epi32_mask(beyond, _mm512_setzero_si512()),
                                             _mm512_set1_epi32(OST_OPEN_PIT));
    const __m512i open = _mm512_sub_epi32(_mm512_set1_epi32(OST_OPEN_PLANE), by_full(_mm512_mullo_epi32(beyond, by)));
    return _mm512_min_epi32(_mm512_max_epi32(open, _mm512_set1_epi32(OST_OPEN_LEAST)), _mm512_set1_epi32(255));
}

static inline __m512i mixed_openness(__m512i fine, __m512i wide, __m512 t)
{
    const __m512i twice = _mm512_mullo_epi32(wide, _mm512_set1_epi32(2 * OST_WIDE_PART));
    const __m512i open = openness(fine),
                  both = openness(_mm512_add_epi32(_mm512_sub_epi32(twice, fine), _mm512_set1_epi32(OST_WIDE_PLANE)));
    const __m512 mixed = _mm512_add_ps(_mm512_cvtepi32_ps(open),
                                       _mm512_mul_ps(_mm512_cvtepi32_ps(_mm512_sub_epi32(both, open)), t));
    return _mm512_cvttps_epi32(_mm512_add_ps(mixed, one(0.5f)));
}

void ost_field_shades_avx512(const uint32_t *points, int count, const ost_field_slice *const fine[3],
                             const ost_field_slice *const wide[3], uint32_t *shades)
{
    ost_slopes s = {.faces = {0}};
    for (int first = 0; first < count; first += OST_SLOPES) {
        ost_slopes_at(points + first, count - first, fine, wide, &s);
        const __m512i faces = load_all(s.faces);
        __m512 f[3], w[3], out[3];
        for (int a = 0; a < 3; a++) {
            f[a] = with_faces(&s, faces, a);
            w[a] = _mm512_cvtepi32_ps(load_all(s.wide[a]));
        }
        const __m512 fine_size = _mm512_sqrt_ps(dot(f, f)), wide_size = _mm512_sqrt_ps(dot(w, w)),
                     t = share(f, w, fine_size, wide_size);
        const __mmask16 some = _mm512_cmp_ps_mask(t, one(0), _CMP_GT_OQ);
        const __m512 of_fine = _mm512_mask_mul_ps(one(1), some, _mm512_sub_ps(one(1), t), wide_size),
                     of_wide = _mm512_mul_ps(t, fine_size);
        for (int a = 0; a < 3; a++)
            out[a] = _mm512_add_ps(_mm512_mul_ps(f[a], of_fine), _mm512_mul_ps(w[a], of_wide));
        const __m512i open = mixed_openness(load_all(s.value[0]), load_all(s.value[1]), t);
        _mm512_storeu_si512(shades + first, _mm512_or_si512(octahedral(out), _mm512_slli_epi32(open, OST_OPEN_SHIFT)));
    }
}
