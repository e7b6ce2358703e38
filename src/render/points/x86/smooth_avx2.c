/* SPDX-License-Identifier: Apache-2.0 */
#include "core/conditions.h"
#include "render/points/cell_loops.h"
#include "render/points/slopes.h"

#include <immintrin.h>

/* A line consists of three registers of sixteen words. */
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

/* Expands each bit of a row to a lane of all ones or all zeros. */
static inline __m256i lanes_of(uint64_t row)
{
    const __m256i bit = _mm256_setr_epi16(1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096, 8192, 16384,
                                          INT16_MIN);
    return _mm256_cmpeq_epi16(_mm256_and_si256(_mm256_set1_epi16((short)row), bit), bit);
}

void ost_field_bits_avx2(const uint64_t *rows, int count, uint16_t (*out)[LINE])
{
    for (int row = 0; row < count; row++)
        for (int i = 0; i < LINE; i += SIXTEEN)
            store(out[row] + i,
                  _mm256_and_si256(lanes_of(rows[row] >> (i + OST_LINE_SHIFT)), _mm256_set1_epi16(OST_FIELD_ALL)));
}

void ost_field_densities_avx2(uint64_t row, uint64_t near, const int16_t density[LINE], uint16_t out[LINE])
{
    const __m256i all = _mm256_set1_epi16(OST_FIELD_ALL), least = _mm256_set1_epi16(OST_FIELD_LEAST),
                  below = _mm256_set1_epi16(OST_FIELD_DENSE - 1);
    for (int i = 0; i < LINE; i += SIXTEEN) {
        const int bit = i + OST_LINE_SHIFT;
        const __m256i v = _mm256_loadu_si256((const void *)(density + i));
        const __m256i some = plus(_mm256_srli_epi16(_mm256_max_epi16(v, _mm256_setzero_si256()), 4), least);
        const __m256i full = _mm256_or_si256(_mm256_cmpgt_epi16(v, below), lanes_of(near >> bit));
        store(out + i, _mm256_and_si256(lanes_of(row >> bit), _mm256_blendv_epi8(some, all, full)));
    }
}

/*
 * Sums nine values with the weights 1 2 3 4 5 4 3 2 1, as (one + three + five) + 2 (two + three) + 4 (four + five),
 * where `one` is the sum of the values with weight 1, and so on.
 */
#define SUM(AT)                                                                                                        \
    const __m256i one = plus(load(AT(0)), load(AT(8))), two = plus(load(AT(1)), load(AT(7)));                          \
    const __m256i three = plus(load(AT(2)), load(AT(6))), four = plus(load(AT(3)), load(AT(5)));                       \
    const __m256i five = load(AT(4)), odd = plus(one, three), even = plus(two, three),                                 \
                  quads = _mm256_slli_epi16(plus(four, five), 2);                                                      \
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

OST_CELLS_DEFINE(avx2)

/* Returns 3/4 a + 1/4 b, for words less than 2^14. */
static inline __m256i between(__m256i a, __m256i b)
{
    return _mm256_srli_epi16(plus(plus(plus(a, a), plus(a, b)), _mm256_set1_epi16(2)), 2);
}

static inline __m256i quarter_of(const uint16_t *at)
{
    return _mm256_srli_epi16(plus(load(at), _mm256_set1_epi16(2)), 2);
}

void ost_field_finer_avx2(const ost_field_slice *const cells[2], bool odd, uint64_t rows, ost_field_slice *out)
{
    enum { LANES = 32, LAST = 32 };
    const ost_field_slice *near = cells[odd], *far = cells[!odd];
    uint16_t z[OST_FIELD_ROWS / 2 + 1][LANES], y[OST_FIELD_ROWS][LANES];
    for (int row = __builtin_ctzll(rows) / 2, last = (63 - __builtin_clzll(rows)) / 2 + 1; row <= last; row++)
        for (int i = 0; i < LANES; i += SIXTEEN)
            store(z[row] + i, between(quarter_of((*near)[row] + i), quarter_of((*far)[row] + i)));
    for (uint64_t left = rows; left; left &= left - 1) {
        const int row = __builtin_ctzll(left);
        for (int i = 0; i < LANES; i += SIXTEEN)
            store(y[row] + i, between(load(z[row / 2 + row % 2] + i), load(z[row / 2 + !(row % 2)] + i)));
    }
    for (uint64_t left = rows; left; left &= left - 1) {
        const int row = __builtin_ctzll(left);
        const __m256i a = load(y[row]), b = load(y[row] + 1), first = between(a, b), second = between(b, a);
        const __m256i low = _mm256_unpacklo_epi16(first, second), high = _mm256_unpackhi_epi16(first, second);
        store((*out)[row], _mm256_permute2x128_si256(low, high, 0x20));
        store((*out)[row] + SIXTEEN, _mm256_permute2x128_si256(low, high, 0x31));
        const int c = y[row][LAST / 2], d = y[row][LAST / 2 + 1];
        (*out)[row][LAST] = (uint16_t)((3 * c + d + 2) >> 2);
        (*out)[row][LAST + 1] = (uint16_t)((3 * d + c + 2) >> 2);
    }
}

/* x86/smooth_avx512.c explains the methods that the following functions use. */
enum { EIGHT = 8 };

static inline __m256i all(int v)
{
    return _mm256_set1_epi32(v);
}

static inline __m256 one(float v)
{
    return _mm256_set1_ps(v);
}

static inline __m256 abs_of(__m256 v)
{
    return _mm256_andnot_ps(one(-0.0f), v);
}

static inline __m256i load_eight(const int32_t *at)
{
    return _mm256_loadu_si256((const void *)at);
}

static inline __m256 with_faces(const ost_slopes *s, int i, int axis)
{
    const __m256i faces = load_eight(s->faces + i);
    const __m256i before = _mm256_and_si256(_mm256_srli_epi32(faces, 2 * axis), all(1)),
                  behind = _mm256_and_si256(_mm256_srli_epi32(faces, 2 * axis + 1), all(1));
    const __m256i more = _mm256_mullo_epi32(_mm256_sub_epi32(behind, before), all(OST_FIELD_BY_FACES));
    return _mm256_cvtepi32_ps(_mm256_add_epi32(load_eight(s->fine[axis] + i), more));
}

static inline __m256 dot(const __m256 a[3], const __m256 b[3])
{
    return _mm256_add_ps(_mm256_add_ps(_mm256_mul_ps(a[0], b[0]), _mm256_mul_ps(a[1], b[1])),
                         _mm256_mul_ps(a[2], b[2]));
}

static inline __m256 share(const __m256 fine[3], const __m256 wide[3], __m256 fine_size, __m256 wide_size)
{
    const __m256 both = _mm256_max_ps(_mm256_mul_ps(fine_size, wide_size), one(1));
    const __m256 t = _mm256_mul_ps(_mm256_sub_ps(_mm256_div_ps(dot(fine, wide), both), one(OST_AGREE_LEAST)),
                                   one(OST_AGREE_STEEP));
    const __m256 says = _mm256_cmp_ps(wide_size, one(OST_WIDE_LEAST), _CMP_GE_OQ);
    return _mm256_and_ps(says, _mm256_min_ps(_mm256_max_ps(t, one(0)), one(1)));
}

static inline __m256 folded(__m256 away, __m256 sign)
{
    return _mm256_or_ps(_mm256_sub_ps(one(1), abs_of(away)), _mm256_and_ps(one(-0.0f), sign));
}

static inline __m256i cell(__m256 p)
{
    const __m256 scaled = _mm256_mul_ps(_mm256_add_ps(p, one(1)), one(OST_OCTAHEDRAL_SIDE / 2));
    return _mm256_min_epi32(_mm256_max_epi32(_mm256_cvttps_epi32(scaled), _mm256_setzero_si256()),
                            all(OST_OCTAHEDRAL_SIDE - 1));
}

/* blendv selects by the sign bit of v[2], which is correct because v[2] is never -0. */
static inline __m256i octahedral(const __m256 v[3])
{
    const __m256 sum = _mm256_add_ps(_mm256_add_ps(abs_of(v[0]), abs_of(v[1])), abs_of(v[2])),
                 by = _mm256_max_ps(sum, one(1));
    const __m256 p = _mm256_div_ps(v[0], by), q = _mm256_div_ps(v[1], by);
    const __m256i u = cell(_mm256_blendv_ps(p, folded(q, v[0]), v[2])),
                  w = cell(_mm256_blendv_ps(q, folded(p, v[1]), v[2]));
    return _mm256_add_epi32(u, _mm256_mullo_epi32(w, all(OST_OCTAHEDRAL_SIDE)));
}

static inline __m256i by_full(__m256i v)
{
    const __m256i full = all(OST_FIELD_FULL), size = _mm256_abs_epi32(v);
    const __m256i q = _mm256_cvttps_epi32(_mm256_div_ps(_mm256_cvtepi32_ps(size), one(OST_FIELD_FULL)));
    const __m256i remainder = _mm256_sub_epi32(size, _mm256_mullo_epi32(q, full));
    const __m256i less = _mm256_add_epi32(q, _mm256_cmpgt_epi32(_mm256_setzero_si256(), remainder));
    return _mm256_sign_epi32(_mm256_sub_epi32(less, _mm256_cmpgt_epi32(remainder, all(OST_FIELD_FULL - 1))), v);
}

static inline __m256i openness(__m256i field)
{
    const __m256i beyond = _mm256_sub_epi32(field, all(OST_FIELD_FLAT));
    const __m256i by = _mm256_blendv_epi8(all(OST_OPEN_EDGE), all(OST_OPEN_PIT),
                                          _mm256_cmpgt_epi32(beyond, _mm256_setzero_si256()));
    const __m256i open = _mm256_sub_epi32(all(OST_OPEN_PLANE), by_full(_mm256_mullo_epi32(beyond, by)));
    return _mm256_min_epi32(_mm256_max_epi32(open, all(OST_OPEN_LEAST)), all(255));
}

static inline __m256i mixed_openness(__m256i fine, __m256i wide, __m256 t)
{
    const __m256i twice = _mm256_mullo_epi32(wide, all(2 * OST_WIDE_PART));
    const __m256i open = openness(fine),
                  both = openness(_mm256_add_epi32(_mm256_sub_epi32(twice, fine), all(OST_WIDE_PLANE)));
    const __m256 mixed = _mm256_add_ps(_mm256_cvtepi32_ps(open),
                                       _mm256_mul_ps(_mm256_cvtepi32_ps(_mm256_sub_epi32(both, open)), t));
    return _mm256_cvttps_epi32(_mm256_add_ps(mixed, one(0.5f)));
}

static inline __m256i shade_word(const ost_slopes *s, int i)
{
    __m256 f[3], w[3], out[3];
    for (int a = 0; a < 3; a++) {
        f[a] = with_faces(s, i, a);
        w[a] = _mm256_cvtepi32_ps(load_eight(s->wide[a] + i));
    }
    const __m256 fine_size = _mm256_sqrt_ps(dot(f, f)), wide_size = _mm256_sqrt_ps(dot(w, w)),
                 t = share(f, w, fine_size, wide_size);
    const __m256 some = _mm256_cmp_ps(t, one(0), _CMP_GT_OQ);
    const __m256 of_fine = _mm256_blendv_ps(one(1), _mm256_mul_ps(_mm256_sub_ps(one(1), t), wide_size), some),
                 of_wide = _mm256_mul_ps(t, fine_size);
    for (int a = 0; a < 3; a++)
        out[a] = _mm256_add_ps(_mm256_mul_ps(f[a], of_fine), _mm256_mul_ps(w[a], of_wide));
    const __m256i open = mixed_openness(load_eight(s->value[0] + i), load_eight(s->value[1] + i), t);
    return _mm256_or_si256(octahedral(out), _mm256_slli_epi32(open, OST_OPEN_SHIFT));
}

void ost_field_shades_avx2(const uint32_t *points, int count, const ost_field_slice *const fine[3],
                           const ost_field_slice *const wide[3], uint32_t *shades)
{
    ost_slopes s = {.faces = {0}};
    for (int first = 0; first < count; first += OST_SLOPES) {
        ost_slopes_at(points + first, count - first, fine, wide, &s);
        for (int i = 0; i < OST_SLOPES; i += EIGHT)
            _mm256_storeu_si256((void *)(shades + first + i), shade_word(&s, i));
    }
}
