/* SPDX-License-Identifier: Apache-2.0 */
#include "core/conditions.h"
#include "render/points/slopes.h"

#include <immintrin.h>

/* A line is three registers of sixteen words. */
enum { LINE = OST_FIELD_LINE, SIXTEEN = 16 };

static inline __m256i load(const uint16_t *at)
{
    return _mm256_loadu_si256((const void *)at);
}

static inline void store(uint16_t *at, __m256i v)
{
    _mm256_storeu_si256((void *)at, v);
}

static inline __m256i plus(__m256i a, __m256i b)
{
    return _mm256_add_epi16(a, b);
}

/* All ones in lanes whose bit is set. */
static inline __m256i lanes_of(uint64_t row)
{
    const __m256i bit = _mm256_setr_epi16(1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096, 8192, 16384, INT16_MIN);
    return _mm256_cmpeq_epi16(_mm256_and_si256(_mm256_set1_epi16((short)row), bit), bit);
}

void ost_field_bits_avx2(const uint64_t *rows, int count, uint16_t (*out)[LINE])
{
    for (int row = 0; row < count; row++)
        for (int i = 0; i < LINE; i += SIXTEEN)
            store(out[row] + i, _mm256_and_si256(lanes_of(rows[row] >> (i + OST_LINE_SHIFT)), _mm256_set1_epi16(OST_FIELD_ALL)));
}

void ost_field_densities_avx2(uint64_t row, uint64_t near, const int16_t density[LINE], uint16_t out[LINE])
{
    const __m256i all = _mm256_set1_epi16(OST_FIELD_ALL), least = _mm256_set1_epi16(OST_FIELD_LEAST), below = _mm256_set1_epi16(OST_FIELD_DENSE - 1);
    for (int i = 0; i < LINE; i += SIXTEEN) {
        const int bit = i + OST_LINE_SHIFT;
        const __m256i v = _mm256_loadu_si256((const void *)(density + i));
        const __m256i some = plus(_mm256_srli_epi16(_mm256_max_epi16(v, _mm256_setzero_si256()), 4), least);
        const __m256i full = _mm256_or_si256(_mm256_cmpgt_epi16(v, below), lanes_of(near >> bit));
        store(out + i, _mm256_and_si256(lanes_of(row >> bit), _mm256_blendv_epi8(some, all, full)));
    }
}

/* one + three + five, 2 (two + three), 4 (four + five): weights 1 2 3 4 5 from the ends to the middle. */
#define SUM(AT)                                                                                                                     \
    const __m256i one = plus(load(AT(0)), load(AT(8))), two = plus(load(AT(1)), load(AT(7)));                                       \
    const __m256i three = plus(load(AT(2)), load(AT(6))), four = plus(load(AT(3)), load(AT(5)));                                    \
    const __m256i five = load(AT(4)), odd = plus(one, three), even = plus(two, three), quads = _mm256_slli_epi16(plus(four, five), 2); \
    const __m256i sum = plus(plus(odd, five), plus(plus(even, even), quads))

static inline __m256i nine(const uint16_t *in, ptrdiff_t step)
{
#define AT(k) (in + (k) * step)
    SUM(AT);
#undef AT
    return sum;
}

void ost_field_down_avx2(const uint16_t (*in)[LINE], uint16_t (*out)[LINE], int count)
{
    for (int x = 0; x < LINE; x += SIXTEEN) {
        __m256i sum = nine(in[0] + x, LINE), slope = _mm256_setzero_si256();
        for (int k = 0; k < 5; k++)
            slope = plus(slope, _mm256_sub_epi16(load(in[k + 5] + x), load(in[k] + x)));
        for (int i = 0;; i++) {
            store(out[i] + x, sum);
            if (i == count - 1)
                break;
            sum = plus(sum, slope);
            const __m256i middle = load(in[i + 5] + x), ends = plus(load(in[i] + x), load(in[i + 10] + x));
            slope = plus(slope, _mm256_sub_epi16(ends, plus(middle, middle)));
        }
    }
}

static inline __m256i along_z(const ost_field_slice *const y[9], int row, int x)
{
#define AT(k) ((*y[k])[row] + x)
    SUM(AT);
#undef AT
    return _mm256_srli_epi16(plus(sum, _mm256_set1_epi16(8)), 4);
}

void ost_field_slice_avx2(const ost_field_slice *const y[9], uint64_t rows, ost_field_slice *out)
{
    uint16_t z[OST_FIELD_ROWS + 1][LINE] __attribute__((aligned(64)));
    for (uint64_t left = rows; left; left &= left - 1) {
        const int row = __builtin_ctzll(left);
        for (int x = 0; x < LINE; x += SIXTEEN)
            store(z[row] + x, along_z(y, row, x));
    }
    for (uint64_t left = rows; left; left &= left - 1) {
        const int row = __builtin_ctzll(left);
        for (int x = 0; x < LINE; x += SIXTEEN)
            store((*out)[row] + x, nine(z[row] + OST_LINE_SKIP + x, 1));
    }
}

enum { EIGHT = 8 };

static inline __m256i all(int v)
{
    return _mm256_set1_epi32(v);
}

static inline __m256 size_of(__m256 v)
{
    return _mm256_andnot_ps(_mm256_set1_ps(-0.0f), v);
}

static inline __m256i load_eight(const int32_t *at)
{
    return _mm256_loadu_si256((const void *)at);
}

static inline __m256 slope(const ost_slopes *s, int i, int axis)
{
    const __m256i faces = load_eight(s->faces + i), one = all(1);
    const __m256i before = _mm256_and_si256(_mm256_srli_epi32(faces, 2 * axis), one), behind = _mm256_and_si256(_mm256_srli_epi32(faces, 2 * axis + 1), one);
    const __m256i more = _mm256_mullo_epi32(_mm256_sub_epi32(behind, before), all(OST_FIELD_BY_FACES));
    return _mm256_cvtepi32_ps(_mm256_add_epi32(load_eight(s->out[axis] + i), more));
}

/* 1 - |beside|, with the sign of a number that is not -0. */
static inline __m256 folded(__m256 beside, __m256 sign)
{
    return _mm256_or_ps(_mm256_sub_ps(_mm256_set1_ps(1), size_of(beside)), _mm256_and_ps(_mm256_set1_ps(-0.0f), sign));
}

static inline __m256i cell(__m256 p)
{
    const __m256 scaled = _mm256_mul_ps(_mm256_add_ps(p, _mm256_set1_ps(1)), _mm256_set1_ps(OST_OCTAHEDRAL_SIDE / 2));
    return _mm256_min_epi32(_mm256_max_epi32(_mm256_cvttps_epi32(scaled), _mm256_setzero_si256()), all(OST_OCTAHEDRAL_SIDE - 1));
}

/* As x86/smooth_avx512.c has it. */
static inline __m256i by_full(__m256i v)
{
    const __m256i full = all(OST_FIELD_FULL), size = _mm256_abs_epi32(v);
    const __m256i q = _mm256_cvttps_epi32(_mm256_div_ps(_mm256_cvtepi32_ps(size), _mm256_set1_ps(OST_FIELD_FULL)));
    const __m256i rest = _mm256_sub_epi32(size, _mm256_mullo_epi32(q, full));
    const __m256i less = _mm256_add_epi32(q, _mm256_cmpgt_epi32(_mm256_setzero_si256(), rest));
    return _mm256_sign_epi32(_mm256_sub_epi32(less, _mm256_cmpgt_epi32(rest, all(OST_FIELD_FULL - 1))), v);
}

static inline __m256i openness(__m256i field)
{
    const __m256i beyond = _mm256_sub_epi32(field, all(OST_FIELD_FLAT));
    const __m256i by = _mm256_blendv_epi8(all(OST_OPEN_EDGE), all(OST_OPEN_PIT), _mm256_cmpgt_epi32(beyond, _mm256_setzero_si256()));
    const __m256i open = _mm256_sub_epi32(all(OST_OPEN_PLANE), by_full(_mm256_mullo_epi32(beyond, by)));
    return _mm256_min_epi32(_mm256_max_epi32(open, all(OST_OPEN_LEAST)), all(255));
}

static inline __m256i look(const ost_slopes *s, int i)
{
    const __m256 a = slope(s, i, 0), b = slope(s, i, 1), c = slope(s, i, 2);
    const __m256 sum = _mm256_add_ps(_mm256_add_ps(size_of(a), size_of(b)), size_of(c)), by = _mm256_max_ps(sum, _mm256_set1_ps(1)); /* 0, or 1 and more */
    const __m256 p = _mm256_div_ps(a, by), q = _mm256_div_ps(b, by); /* blendv looks at the sign of c, which is not -0 */
    const __m256i u = cell(_mm256_blendv_ps(p, folded(q, a), c)), v = cell(_mm256_blendv_ps(q, folded(p, b), c));
    const __m256i normal = _mm256_add_epi32(u, _mm256_mullo_epi32(v, all(OST_OCTAHEDRAL_SIDE)));
    return _mm256_or_si256(normal, _mm256_slli_epi32(openness(load_eight(s->field + i)), OST_OPEN_SHIFT));
}

void ost_field_looks_avx2(const uint32_t *points, int count, const ost_field_slice *const slice[3], uint32_t *looks)
{
    ost_slopes s = {.faces = {0}};
    for (int first = 0; first < count; first += OST_SLOPES) {
        ost_slopes_at(points + first, count - first, slice, &s);
        for (int i = 0; i < OST_SLOPES; i += EIGHT)
            _mm256_storeu_si256((void *)(looks + first + i), look(&s, i));
    }
}
