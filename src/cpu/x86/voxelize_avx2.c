/* SPDX-License-Identifier: Apache-2.0 */
/* The kernels of the voxelizer for AVX2. They process four triangles, 256 voxels or 32 classes at once. */
#include <immintrin.h>

#include "cpu/voxelize/voxelize.h"
#include "cpu/x86/voxelize_x86.h"

/* --------------------------------------------------- triangles in lanes */

#define LANES 4
typedef __m256d vd;
typedef __m256d vm;
typedef __m128i vi;

#define vd_set(x) _mm256_set1_pd(x)
#define vd_add _mm256_add_pd
#define vd_sub _mm256_sub_pd
#define vd_mul _mm256_mul_pd
#define vd_div _mm256_div_pd
#define vd_min _mm256_min_pd
#define vd_max _mm256_max_pd
#define vd_floor(a) _mm256_round_pd(a, _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC)
#define vd_ceil(a) _mm256_round_pd(a, _MM_FROUND_TO_POS_INF | _MM_FROUND_NO_EXC)
#define vd_sel(m, yes, no) _mm256_blendv_pd(no, yes, m)
#define vd_lt(a, b) _mm256_cmp_pd(a, b, _CMP_LT_OQ)
#define vd_le(a, b) _mm256_cmp_pd(a, b, _CMP_LE_OQ)
#define vd_eq(a, b) _mm256_cmp_pd(a, b, _CMP_EQ_OQ)
#define vm_and(a, b) _mm256_and_pd(a, b)
#define vm_or(a, b) _mm256_or_pd(a, b)
#define vm_andnot(a, b) _mm256_andnot_pd(b, a)
#define vm_bits(m) ((unsigned)_mm256_movemask_pd(m))
#define vm_first(n) vd_lt(_mm256_setr_pd(0, 1, 2, 3), vd_set(n))
#define vi_load(p) _mm_loadu_si128((const __m128i *)(p))
#define vi_store(p, v) _mm_storeu_si128((__m128i *)(p), v)
#define vi_from_vd(a) _mm256_cvtpd_epi32(a)
#define vd_from_vi(a) _mm256_cvtepi32_pd(a)

/*
 * Loads one corner of each triangle and transposes the corners, because gather instructions take several
 * times as long. The loads are masked, because nothing may be read after the last vertex.
 */
static inline void vi_vertices(const ost_snapped_mesh *mesh, const uint32_t *const *v, int corner, vi *xyz)
{
    const __m128i three = _mm_setr_epi32(-1, -1, -1, 0);
    const __m128i p0 = _mm_maskload_epi32(mesh->vertices[v[0][corner]], three);
    const __m128i p1 = _mm_maskload_epi32(mesh->vertices[v[1][corner]], three);
    const __m128i p2 = _mm_maskload_epi32(mesh->vertices[v[2][corner]], three);
    const __m128i p3 = _mm_maskload_epi32(mesh->vertices[v[3][corner]], three);
    const __m128i xy01 = _mm_unpacklo_epi32(p0, p1), xy23 = _mm_unpacklo_epi32(p2, p3);
    xyz[0] = _mm_unpacklo_epi64(xy01, xy23);
    xyz[1] = _mm_unpackhi_epi64(xy01, xy23);
    xyz[2] = _mm_unpacklo_epi64(_mm_unpackhi_epi32(p0, p1), _mm_unpackhi_epi32(p2, p3));
}

/* A table that contains, for each mask of lanes, the byte shuffle that moves the set lanes to the front. */
#define WORD(i) 4 * (i), 4 * (i) + 1, 4 * (i) + 2, 4 * (i) + 3
#define NO WORD(0)
static const int8_t together[16][16] = {
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

static inline size_t emit_bits(uint32_t *out, vi v, unsigned lanes)
{
    _mm_storeu_si128((__m128i *)out, _mm_shuffle_epi8(v, _mm_loadu_si128((const __m128i *)together[lanes])));
    return (size_t)_mm_popcnt_u32(lanes);
}

#define emit(out, v, m) emit_bits(out, v, vm_bits(m))

static inline __m256i two_vertices(const ost_snapped_mesh *mesh, const uint32_t *const *v, int corner)
{
    const __m128i three = _mm_setr_epi32(-1, -1, -1, 0);
    const __m128i p0 = _mm_maskload_epi32(mesh->vertices[v[0][corner]], three),
                  p1 = _mm_maskload_epi32(mesh->vertices[v[1][corner]], three);
    return _mm256_inserti128_si256(_mm256_castsi128_si256(p0), p1, 1);
}

/* Computes the same result as bounds_meet_rows in voxelize_avx512.c, two triangles at a time. */
static inline unsigned bounds_meet_rows(const ost_vox_tile *tile, const uint32_t *t)
{
    const __m256i h = _mm256_set1_epi32(1 << (tile->f - 1)), h1 = _mm256_set1_epi32((1 << (tile->f - 1)) - 1);
    const __m128i f = _mm_cvtsi32_si128(tile->f);
    const uint32_t *v[LANES];
    unsigned without = 0;
    for (int i = 0; i < LANES; i++)
        v[i] = tile->mesh->triangles[t[i]];
    for (int i = 0; i < LANES; i += 2) {
        const __m256i a = two_vertices(tile->mesh, v + i, 0), b = two_vertices(tile->mesh, v + i, 1),
                      c = two_vertices(tile->mesh, v + i, 2);
        const __m256i lo = _mm256_min_epi32(_mm256_min_epi32(a, b), c),
                      hi = _mm256_max_epi32(_mm256_max_epi32(a, b), c);
        const __m256i none = _mm256_cmpgt_epi32(_mm256_sra_epi32(_mm256_add_epi32(lo, h1), f),
                                                _mm256_sra_epi32(_mm256_sub_epi32(hi, h), f));
        const unsigned bits = (unsigned)_mm256_movemask_ps(_mm256_castsi256_ps(none));
        without |= _pext_u32(bits >> 1 | bits >> 2, 0x11) << i;
    }
    return ~without & ((1u << LANES) - 1);
}

static inline vi least(vi a, vi b, vi c)
{
    return _mm_min_epi32(_mm_min_epi32(a, b), c);
}

static inline vi greatest(vi a, vi b, vi c)
{
    return _mm_max_epi32(_mm_max_epi32(a, b), c);
}

static inline vi keys_lanes(const ost_vox_plan *plan, vi ay, vi by, vi cy, vi az, vi bz, vi cz)
{
    const vi h = _mm_set1_epi32(1 << (plan->f - 1)), h1 = _mm_set1_epi32((1 << (plan->f - 1)) - 1);
    const __m128i f = _mm_cvtsi32_si128(plan->f), sy = _mm_cvtsi32_si128(plan->shift_y),
                  sz = _mm_cvtsi32_si128(plan->shift_z);
    const vi j0 = _mm_sra_epi32(_mm_add_epi32(least(ay, by, cy), h1), f);
    const vi k0 = _mm_sra_epi32(_mm_add_epi32(least(az, bz, cz), h1), f);
    const vi j1 = _mm_sra_epi32(_mm_sub_epi32(greatest(ay, by, cy), h), f);
    const vi k1 = _mm_sra_epi32(_mm_sub_epi32(greatest(az, bz, cz), h), f);
    const vi ty = _mm_sra_epi32(j0, sy), tz = _mm_sra_epi32(k0, sz);
    const vi none = _mm_or_si128(_mm_cmpgt_epi32(j0, j1), _mm_cmpgt_epi32(k0, k1));
    const vi one = _mm_and_si128(_mm_cmpeq_epi32(ty, _mm_sra_epi32(j1, sy)),
                                 _mm_cmpeq_epi32(tz, _mm_sra_epi32(k1, sz)));
    vi key = _mm_add_epi32(ty, _mm_mullo_epi32(tz, _mm_set1_epi32(plan->tiles_y)));
    key = _mm_blendv_epi8(_mm_set1_epi32((int)OST_VOX_KEY_MANY), key, one);
    return _mm_blendv_epi8(key, _mm_set1_epi32((int)OST_VOX_KEY_NONE), none);
}

#include "cpu/voxelize/lanes.h"

void ost_vox_mark_avx2(ost_vox_tile *tile, const uint32_t *list, size_t count)
{
    mark(tile, list, count);
}

void ost_vox_keys_avx2(const ost_vox_plan *plan, const ost_snapped_mesh *mesh, size_t first, size_t count,
                       uint32_t *keys)
{
    keys_of(plan, mesh, first, count, keys);
}

/* ------------------------------------------------------------- solid bits */

static inline __m256i count_bytes(__m256i v)
{
    const __m256i table = _mm256_broadcastsi128_si256(_mm_setr_epi8(0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4));
    const __m256i low = _mm256_set1_epi8(15);
    return _mm256_add_epi8(_mm256_shuffle_epi8(table, _mm256_and_si256(v, low)),
                           _mm256_shuffle_epi8(table, _mm256_and_si256(_mm256_srli_epi16(v, 4), low)));
}

enum { WORDS = 4 }; /* words per vector */

/* Computes the same result as fill_blocks in voxelize_avx512.c, four words at a time. */
static inline bool fill_vectors(const uint64_t *enter, const uint64_t *leave, size_t words, unsigned ends,
                                uint64_t *bits, bool *marked, __m256i *counts)
{
    const __m256i zero = _mm256_setzero_si256(), bit = _mm256_setr_epi64x(1, 2, 4, 8);
    __m256i wrong = zero, n = *counts;
    unsigned before = 0; /* bit i is set if word i begins inside the mesh; bit 4 is for the next vector */
    for (size_t w = 0; w < words; w += WORDS) {
        const __m256i p = _mm256_load_si256((const __m256i *)(enter + w)),
                      m = _mm256_load_si256((const __m256i *)(leave + w));
        const __m256i either = _mm256_or_si256(p, m);
        const unsigned inside = before >> WORDS;
        __m256i q = _mm256_set1_epi64x(-(long long)inside);
        if (!_mm256_testz_si256(either, either)) {
            const __m256i x = _mm256_xor_si256(p, m), difference = _mm256_sub_epi64(m, p);
            /* The top bit of each lane of `borrow` is the borrow of the subtraction m - p. */
            const __m256i borrow = _mm256_or_si256(_mm256_andnot_si256(m, p), _mm256_andnot_si256(x, difference));
            const unsigned less = (unsigned)_mm256_movemask_pd(_mm256_castsi256_pd(borrow));
            const unsigned same = (unsigned)_mm256_movemask_pd(_mm256_castsi256_pd(_mm256_cmpeq_epi64(m, p)));
            before = (2 * less + inside + same) ^ same;
            const __m256i minus_one = _mm256_cmpeq_epi64(_mm256_and_si256(_mm256_set1_epi64x(before), bit), bit);
            q = _mm256_add_epi64(difference, minus_one);
            const __m256i last = _mm256_sub_epi64(_mm256_add_epi64(q, q), minus_one);
            wrong = _mm256_or_si256(wrong, _mm256_or_si256(_mm256_xor_si256(_mm256_xor_si256(x, q), last),
                                                           _mm256_and_si256(x, _mm256_xor_si256(q, p))));
            *marked = true;
        }
        _mm256_store_si256((__m256i *)(bits + w), q);
        n = _mm256_add_epi64(n, _mm256_sad_epu8(count_bytes(q), zero));
    }
    if (!_mm256_testz_si256(wrong, wrong) || before & ends)
        return false;
    *counts = n;
    return true;
}

uint64_t ost_vox_fill_avx2(ost_vox_tile *tile, size_t first_row, size_t rows, uint64_t *bits)
{
    const size_t words = tile->row_bits / 64, total = rows * words, step = words < WORDS ? WORDS : words;
    const size_t rows_in_step = step / words;
    const unsigned ends = words >= 4 ? 0x10 : words == 2 ? 0x14 : 0x1e;
    uint64_t *enter = tile->planes + first_row * words, *leave = enter + tile->minus / 64;
    __m256i counts = _mm256_setzero_si256();
    const bool keep = tile->any_unproven;
    for (size_t w = 0; w < total; w += step) {
        bool marked = false, proven = fill_vectors(enter + w, leave + w, step, ends, bits + w, &marked, &counts);
        if (__builtin_expect(!proven, 0)) {
            uint64_t *const other = enter;
            enter = leave;
            leave = other;
            proven = fill_vectors(enter + w, leave + w, step, ends, bits + w, &marked, &counts);
        }
        if (__builtin_expect(!proven, 0)) {
            for (size_t r = w / words; r < w / words + rows_in_step && r < rows; r++)
                tile->row_state[first_row + r] |= OST_VOX_UNPROVEN;
            tile->any_unproven = true;
        } else if (marked && !keep) {
            for (size_t b = w; b < w + step; b += WORDS) {
                _mm256_store_si256((__m256i *)(enter + b), _mm256_setzero_si256());
                _mm256_store_si256((__m256i *)(leave + b), _mm256_setzero_si256());
            }
        }
    }
    uint64_t sums[WORDS], count = 0;
    _mm256_storeu_si256((__m256i *)sums, counts);
    for (int i = 0; i < WORDS; i++)
        count += sums[i];
    return count;
}

/* ---------------------------------------------------------------- classes */

/*
 * Returns 32 bytes; byte i is -1 if bit i of the parameter is set, and 0 otherwise. Each byte receives a copy of the
 * byte that contains its bit, is masked to this bit, and is compared with it.
 */
static inline __m256i spread(uint32_t bits)
{
    const __m256i from = _mm256_setr_epi8(0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1, 2, 2, 2, 2, 2, 2, 2, 2, 3, 3,
                                          3, 3, 3, 3, 3, 3);
    const __m256i own = _mm256_set1_epi64x((long long)UINT64_C(0x8040201008040201));
    const __m256i v = _mm256_shuffle_epi8(_mm256_set1_epi32((int)bits), from);
    return _mm256_cmpeq_epi8(_mm256_and_si256(v, own), own);
}

static inline __m256i classes_of(const uint64_t *cutting, const uint64_t *noncutting, size_t word, unsigned shift)
{
    __m256i v = _mm256_and_si256(spread((uint32_t)(cutting[word] >> shift)), _mm256_set1_epi8(OST_TOOL_CUTTING));
    if (noncutting)
        v = _mm256_or_si256(
            v, _mm256_and_si256(spread((uint32_t)(noncutting[word] >> shift)), _mm256_set1_epi8(OST_TOOL_NONCUTTING)));
    return v;
}

void ost_vox_expand_avx2(const uint64_t *cutting, const uint64_t *noncutting, size_t rows, int words, int32_t nx,
                         bool stream, uint8_t *voxels)
{
    const size_t full = (size_t)nx / 32, remainder = (size_t)nx % 32;
    const bool past = stream && remainder == 0 && (uintptr_t)voxels % 32 == 0;
    for (size_t r = 0; r < rows; r++, voxels += nx) {
        const size_t first = r * (size_t)words;
        for (size_t h = 0; h < full; h++) {
            const __m256i v = classes_of(cutting, noncutting, first + h / 2, 32 * (h % 2));
            if (past)
                _mm256_stream_si256((__m256i *)(voxels + 32 * h), v);
            else
                _mm256_storeu_si256((__m256i *)(voxels + 32 * h), v);
        }
        if (remainder) {
            uint8_t last[32];
            _mm256_storeu_si256((__m256i *)last, classes_of(cutting, noncutting, first + full / 2, 32 * (full % 2)));
            memcpy(voxels + 32 * full, last, remainder);
        }
    }
    if (past)
        _mm_sfence();
}
