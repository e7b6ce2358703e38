/* SPDX-License-Identifier: Apache-2.0 */
/* The kernels of the voxelizer for AVX-512. They process eight triangles, 512 voxels or 64 classes at once. */
#include <immintrin.h>

#include "cpu/voxelize/voxelize.h"
#include "cpu/x86/voxelize_x86.h"

/* --------------------------------------------------- triangles in lanes */

#define LANES 8
typedef __m512d vd;
typedef __mmask8 vm;
typedef __m256i vi;

#define vd_set(x) _mm512_set1_pd(x)
#define vd_add _mm512_add_pd
#define vd_sub _mm512_sub_pd
#define vd_mul _mm512_mul_pd
#define vd_div _mm512_div_pd
#define vd_min _mm512_min_pd
#define vd_max _mm512_max_pd
#define vd_floor(a) _mm512_roundscale_pd(a, _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC)
#define vd_ceil(a) _mm512_roundscale_pd(a, _MM_FROUND_TO_POS_INF | _MM_FROUND_NO_EXC)
#define vd_sel(m, yes, no) _mm512_mask_blend_pd(m, no, yes)
#define vd_lt(a, b) _mm512_cmp_pd_mask(a, b, _CMP_LT_OQ)
#define vd_le(a, b) _mm512_cmp_pd_mask(a, b, _CMP_LE_OQ)
#define vd_eq(a, b) _mm512_cmp_pd_mask(a, b, _CMP_EQ_OQ)
#define vm_and(a, b) ((vm)((a) & (b)))
#define vm_or(a, b) ((vm)((a) | (b)))
#define vm_andnot(a, b) ((vm)((a) & ~(b)))
#define vm_bits(m) ((unsigned)(m))
#define vm_first(n) ((vm)((1u << (n)) - 1))
#define vi_load(p) _mm256_loadu_si256((const __m256i *)(p))
#define vi_store(p, v) _mm256_storeu_si256((__m256i *)(p), v)
#define vi_from_vd(a) _mm512_cvtpd_epi32(a)
#define vd_from_vi(a) _mm512_cvtepi32_pd(a)

/*
 * Loads one corner of each of four triangles. The caller permutes the coordinates, because gather
 * instructions take several times as long. The loads are masked, because nothing may be read after the last
 * vertex.
 */
static inline __m512i four_vertices(const ost_snapped_mesh *mesh, const uint32_t *const *v, int corner)
{
    const __m128i p0 = _mm_maskz_loadu_epi32(7, mesh->vertices[v[0][corner]]),
                  p1 = _mm_maskz_loadu_epi32(7, mesh->vertices[v[1][corner]]);
    const __m128i p2 = _mm_maskz_loadu_epi32(7, mesh->vertices[v[2][corner]]),
                  p3 = _mm_maskz_loadu_epi32(7, mesh->vertices[v[3][corner]]);
    const __m256i p01 = _mm256_inserti128_si256(_mm256_castsi128_si256(p0), p1, 1);
    const __m256i p23 = _mm256_inserti128_si256(_mm256_castsi128_si256(p2), p3, 1);
    return _mm512_inserti64x4(_mm512_castsi256_si512(p01), p23, 1);
}

static inline void vi_vertices(const ost_snapped_mesh *mesh, const uint32_t *const *v, int corner, vi *xyz)
{
    const __m512i low = four_vertices(mesh, v, corner), high = four_vertices(mesh, v + 4, corner);
    const __m512i xy = _mm512_permutex2var_epi32(
        low, _mm512_setr_epi32(0, 4, 8, 12, 16, 20, 24, 28, 1, 5, 9, 13, 17, 21, 25, 29), high);
    const __m512i z = _mm512_permutex2var_epi32(
        low, _mm512_setr_epi32(2, 6, 10, 14, 18, 22, 26, 30, 2, 6, 10, 14, 18, 22, 26, 30), high);
    xyz[0] = _mm512_castsi512_si256(xy);
    xyz[1] = _mm512_extracti64x4_epi64(xy, 1);
    xyz[2] = _mm512_castsi512_si256(z);
}

static inline size_t emit(uint32_t *out, vi v, vm m)
{
    _mm256_storeu_si256((__m256i *)out, _mm256_maskz_compress_epi32(m, v));
    return (size_t)_mm_popcnt_u32(m);
}

#define emit_bits(out, v, bits) emit(out, v, (vm)(bits))

/*
 * Returns one bit per triangle; it is set if the triangle's bounds contain the centre of
 * a row. The coordinates are compared as integers and are not transposed: a register
 * contains the corners, or the bounds, of four triangles as quarters (x, y, z, 0). Of
 * each comparison, only the bits for y and z are used.
 */
static inline unsigned bounds_meet_rows(const ost_vox_tile *tile, const uint32_t *t)
{
    const __m512i h = _mm512_set1_epi32(1 << (tile->f - 1)), h1 = _mm512_set1_epi32((1 << (tile->f - 1)) - 1);
    const __m128i f = _mm_cvtsi32_si128(tile->f);
    const uint32_t *v[LANES];
    unsigned without = 0;
    for (int i = 0; i < LANES; i++)
        v[i] = tile->mesh->triangles[t[i]];
    for (int i = 0; i < LANES; i += 4) {
        const __m512i a = four_vertices(tile->mesh, v + i, 0), b = four_vertices(tile->mesh, v + i, 1),
                      c = four_vertices(tile->mesh, v + i, 2);
        const __m512i lo = _mm512_min_epi32(_mm512_min_epi32(a, b), c),
                      hi = _mm512_max_epi32(_mm512_max_epi32(a, b), c);
        const __mmask16 none = _mm512_cmpgt_epi32_mask(_mm512_sra_epi32(_mm512_add_epi32(lo, h1), f),
                                                       _mm512_sra_epi32(_mm512_sub_epi32(hi, h), f));
        without |= _pext_u32(((unsigned)none >> 1 | (unsigned)none >> 2), 0x1111) << i;
    }
    return ~without & ((1u << LANES) - 1);
}

static inline vi least(vi a, vi b, vi c)
{
    return _mm256_min_epi32(_mm256_min_epi32(a, b), c);
}

static inline vi greatest(vi a, vi b, vi c)
{
    return _mm256_max_epi32(_mm256_max_epi32(a, b), c);
}

static inline vi keys_lanes(const ost_vox_plan *plan, vi ay, vi by, vi cy, vi az, vi bz, vi cz)
{
    const vi h = _mm256_set1_epi32(1 << (plan->f - 1)), h1 = _mm256_set1_epi32((1 << (plan->f - 1)) - 1);
    const __m128i f = _mm_cvtsi32_si128(plan->f), sy = _mm_cvtsi32_si128(plan->shift_y),
                  sz = _mm_cvtsi32_si128(plan->shift_z);
    const vi j0 = _mm256_sra_epi32(_mm256_add_epi32(least(ay, by, cy), h1), f);
    const vi k0 = _mm256_sra_epi32(_mm256_add_epi32(least(az, bz, cz), h1), f);
    const vi j1 = _mm256_sra_epi32(_mm256_sub_epi32(greatest(ay, by, cy), h), f);
    const vi k1 = _mm256_sra_epi32(_mm256_sub_epi32(greatest(az, bz, cz), h), f);
    const vi ty = _mm256_sra_epi32(j0, sy), tz = _mm256_sra_epi32(k0, sz);
    const vm none = _mm256_cmpgt_epi32_mask(j0, j1) | _mm256_cmpgt_epi32_mask(k0, k1);
    const vm many = _mm256_cmpneq_epi32_mask(ty, _mm256_sra_epi32(j1, sy)) |
                    _mm256_cmpneq_epi32_mask(tz, _mm256_sra_epi32(k1, sz));
    vi key = _mm256_add_epi32(ty, _mm256_mullo_epi32(tz, _mm256_set1_epi32(plan->tiles_y)));
    key = _mm256_mask_mov_epi32(key, many, _mm256_set1_epi32((int)OST_VOX_KEY_MANY));
    return _mm256_mask_mov_epi32(key, none, _mm256_set1_epi32((int)OST_VOX_KEY_NONE));
}

#include "cpu/voxelize/lanes.h"

void ost_vox_mark_avx512(ost_vox_tile *tile, const uint32_t *list, size_t count)
{
    mark(tile, list, count);
}

void ost_vox_keys_avx512(const ost_vox_plan *plan, const ost_snapped_mesh *mesh, size_t first, size_t count,
                         uint32_t *keys)
{
    keys_of(plan, mesh, first, count, keys);
}

/* ------------------------------------------------------------- solid bits */

/* Returns the number of set bits in each byte of v. */
static inline __m512i count_bytes(__m512i v)
{
    const __m512i table = _mm512_broadcast_i32x4(_mm_setr_epi8(0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4));
    const __m512i low = _mm512_set1_epi8(15);
    return _mm512_add_epi8(_mm512_shuffle_epi8(table, _mm512_and_si512(v, low)),
                           _mm512_shuffle_epi8(table, _mm512_and_si512(_mm512_srli_epi16(v, 4), low)));
}

/*
 * Computes the solid bits of one row of complete blocks, or of one block of complete rows.  Returns
 * false if the rows are not proven (fill.c).  Bit i of `ends` is set if word i of the last block is
 * the first word of a row; bit 8 is for the word after the block.  A row is not proven if its last
 * word ends inside the mesh.
 */
static inline bool fill_blocks(const uint64_t *enter, const uint64_t *leave, size_t words, unsigned ends,
                               uint64_t *bits, bool *marked, __m512i *counts)
{
    const __m512i zero = _mm512_setzero_si512(), ones = _mm512_set1_epi64(-1);
    __m512i wrong = zero, n = *counts;
    unsigned before = 0; /* bit i is set if word i begins inside the mesh; bit 8 is for the next block */
    for (size_t w = 0; w < words; w += OST_VOX_BLOCK) {
        const __m512i p = _mm512_load_si512(enter + w), m = _mm512_load_si512(leave + w),
                      either = _mm512_or_si512(p, m);
        const unsigned inside = before >> OST_VOX_BLOCK;
        __m512i q = inside ? ones : zero;
        if (_mm512_test_epi64_mask(either, either)) {
            /* The carries of this addition are the borrows that pass through words in which p and m are equal. */
            const unsigned less = _mm512_cmplt_epu64_mask(m, p), same = _mm512_cmpeq_epi64_mask(m, p);
            before = (2 * less + inside + same) ^ same;
            const __m512i x = _mm512_xor_si512(p, m), difference = _mm512_sub_epi64(m, p);
            q = _mm512_mask_add_epi64(difference, (__mmask8)before, difference, ones);
            __m512i last = _mm512_add_epi64(q, q);
            last = _mm512_mask_sub_epi64(last, (__mmask8)before, last, ones);
            /* wrong = wrong | (x ^ q ^ last) | (x & (q ^ p)) */
            wrong = _mm512_ternarylogic_epi64(wrong, _mm512_ternarylogic_epi64(x, q, last, 0x96),
                                              _mm512_ternarylogic_epi64(x, q, p, 0x60), 0xfe);
            *marked = true;
        }
        _mm512_store_si512(bits + w, q);
        n = _mm512_add_epi64(n, _mm512_sad_epu8(count_bytes(q), zero));
    }
    if (_mm512_test_epi64_mask(wrong, wrong) || before & ends)
        return false;
    *counts = n;
    return true;
}

uint64_t ost_vox_fill_avx512(ost_vox_tile *tile, size_t first_row, size_t rows, uint64_t *bits)
{
    const size_t words = tile->row_bits / 64, total = rows * words,
                 step = words < OST_VOX_BLOCK ? OST_VOX_BLOCK : words;
    const size_t rows_in_step = step / words;
    const unsigned ends = words >= 8 ? 0x100 : words == 4 ? 0x110 : words == 2 ? 0x154 : 0x1fe;
    uint64_t *enter = tile->planes + first_row * words, *leave = enter + tile->minus / 64;
    __m512i counts = _mm512_setzero_si512();
    const bool keep = tile->any_unproven;
    for (size_t w = 0; w < total; w += step) {
        bool marked = false, proven = fill_blocks(enter + w, leave + w, step, ends, bits + w, &marked, &counts);
        if (__builtin_expect(!proven, 0)) {
            uint64_t *const other = enter;
            enter = leave;
            leave = other;
            proven = fill_blocks(enter + w, leave + w, step, ends, bits + w, &marked, &counts);
        }
        if (__builtin_expect(!proven, 0)) {
            for (size_t r = w / words; r < w / words + rows_in_step && r < rows; r++)
                tile->row_state[first_row + r] |= OST_VOX_UNPROVEN;
            tile->any_unproven = true;
        } else if (marked && !keep) {
            for (size_t b = w; b < w + step; b += OST_VOX_BLOCK) {
                _mm512_store_si512(enter + b, _mm512_setzero_si512());
                _mm512_store_si512(leave + b, _mm512_setzero_si512());
            }
        }
    }
    return (uint64_t)_mm512_reduce_add_epi64(counts);
}

/* ---------------------------------------------------------------- classes */

static inline __m512i classes_of(const uint64_t *cutting, const uint64_t *noncutting, size_t word)
{
    __m512i v = _mm512_maskz_set1_epi8(_cvtu64_mask64(cutting[word]), OST_TOOL_CUTTING);
    if (noncutting)
        v = _mm512_mask_set1_epi8(v, _cvtu64_mask64(noncutting[word]), OST_TOOL_NONCUTTING);
    return v;
}

void ost_vox_expand_avx512(const uint64_t *cutting, const uint64_t *noncutting, size_t rows, int words, int32_t nx,
                           bool stream, uint8_t *voxels)
{
    const size_t full = (size_t)nx / 64, remainder = (size_t)nx % 64;
    const __mmask64 last = (UINT64_C(1) << remainder) - 1;
    const bool past = stream && remainder == 0 && (uintptr_t)voxels % 64 == 0;
    for (size_t r = 0; r < rows; r++, voxels += nx) {
        const size_t first = r * (size_t)words;
        if (past) {
            for (size_t w = 0; w < full; w++)
                _mm512_stream_si512((__m512i *)(voxels + 64 * w), classes_of(cutting, noncutting, first + w));
            continue;
        }
        for (size_t w = 0; w < full; w++)
            _mm512_storeu_si512(voxels + 64 * w, classes_of(cutting, noncutting, first + w));
        if (remainder)
            _mm512_mask_storeu_epi8(voxels + 64 * full, last, classes_of(cutting, noncutting, first + full));
    }
    if (past)
        _mm_sfence();
}
