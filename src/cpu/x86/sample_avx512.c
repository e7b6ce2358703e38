/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads the densities of sixteen voxels at once.  The kernel first gathers the table entries of the
 * chunks, then the occupancy words of voxels in chunks with memory, and then the densities of active
 * voxels.  The mask of each gather is computed from the result of the previous one, so that nothing
 * else is read.
 */
#include "core/conditions.h"
#include "cpu/bone/bone.h"
#include "cpu/kernels.h"

#include <immintrin.h>
#include <stddef.h>

_Static_assert(sizeof(cpu_chunk) == 32 && offsetof(cpu_chunk, density) == 0 && offsetof(cpu_chunk, occupancy) == 8,
               "four words a chunk");

typedef struct halves {
    __m512i low, high; /* 64-bit lanes of voxels 0 to 7 (low) and 8 to 15 (high) */
} halves;

static inline halves wide(__m512i v)
{
    return (halves){_mm512_cvtepi32_epi64(_mm512_castsi512_si256(v)),
                    _mm512_cvtepi32_epi64(_mm512_extracti64x4_epi64(v, 1))};
}

/* Reads 64 bits at the address in each lane that is set in mask. The other lanes of the result are 0. */
static inline __m512i fetch(__mmask8 mask, __m512i address)
{
    return _mm512_mask_i64gather_epi64(_mm512_setzero_si512(), mask, address, (const void *)0, 1);
}

static inline __m512i sum(__m512i a, __m512i b)
{
    return _mm512_add_epi64(a, b);
}

/* Returns the densities of eight voxels in the low halves of 32-bit lanes. A lane is 0 if its voxel is not active or if
   the lane is not set in mask. */
static inline __m256i densities_of(const cpu_bone *bone, __mmask8 mask, __m512i chunk, __m512i brick, __m512i in)
{
    const __m512i entry = sum(_mm512_set1_epi64((long long)(uintptr_t)bone->chunks), _mm512_slli_epi64(chunk, 5));
    const __m512i occupancy = fetch(mask, sum(entry, _mm512_set1_epi64(8)));
    mask = _mm512_mask_test_epi64_mask(mask, occupancy, occupancy);
    const __m512i word = fetch(mask, sum(occupancy, _mm512_slli_epi64(brick, 3)));
    mask = _mm512_mask_test_epi64_mask(mask, _mm512_srlv_epi64(word, in), _mm512_set1_epi64(1));
    const __m512i at = sum(fetch(mask, entry), _mm512_slli_epi64(sum(_mm512_slli_epi64(brick, 6), in), 1));
    return _mm512_mask_i64gather_epi32(_mm256_setzero_si256(), mask, at, (const void *)0, 1);
}

void ost_sample_avx512(const cpu_bone *bone, size_t count, const int32_t *const at[3], int16_t *densities)
{
    const ost_dims dims = bone->base.geometry.dims;
    const int n = bone->base.chunk_size, shift = n == 16 ? 4 : n == 32 ? 5 : 6;
    const __m128i down = _mm_cvtsi32_si128(shift);
    const __m512i spread = _mm512_setr_epi32(0, 1, 8, 9, 64, 65, 72, 73, 512, 513, 520, 521, 576, 577, 584, 585);
    const __m512i low = _mm512_set1_epi32(n - 1), three = _mm512_set1_epi32(3);
    for (size_t i = 0; i < count; i += 16) {
        const __mmask16 some = count - i < 16 ? (__mmask16)((1u << (count - i)) - 1) : (__mmask16)0xffff;
        const __m512i x = _mm512_maskz_loadu_epi32(some, at[0] + i), y = _mm512_maskz_loadu_epi32(some, at[1] + i),
                      z = _mm512_maskz_loadu_epi32(some, at[2] + i);
        /* Compared as unsigned numbers, negative coordinates are above every dimension. */
        __mmask16 mask = _mm512_mask_cmplt_epu32_mask(some, x, _mm512_set1_epi32(dims.x));
        mask = _mm512_mask_cmplt_epu32_mask(mask, y, _mm512_set1_epi32(dims.y));
        mask = _mm512_mask_cmplt_epu32_mask(mask, z, _mm512_set1_epi32(dims.z));
        /* In lanes that are set in mask, the chunk's index is below 2^31. The other lanes are not used. */
        __m512i chunk = _mm512_mullo_epi32(_mm512_sra_epi32(z, down), _mm512_set1_epi32(bone->chunk_dims.y));
        chunk = _mm512_mullo_epi32(_mm512_add_epi32(chunk, _mm512_sra_epi32(y, down)),
                                   _mm512_set1_epi32(bone->chunk_dims.x));
        chunk = _mm512_add_epi32(chunk, _mm512_sra_epi32(x, down));
        const __m512i a = _mm512_and_epi32(x, low), b = _mm512_and_epi32(y, low), c = _mm512_and_epi32(z, low);
        __m512i brick = _mm512_permutexvar_epi32(_mm512_srli_epi32(a, 2), spread);
        brick = _mm512_or_epi32(brick, _mm512_slli_epi32(_mm512_permutexvar_epi32(_mm512_srli_epi32(b, 2), spread), 1));
        brick = _mm512_or_epi32(brick, _mm512_slli_epi32(_mm512_permutexvar_epi32(_mm512_srli_epi32(c, 2), spread), 2));
        __m512i in = _mm512_and_epi32(a, three);
        in = _mm512_or_epi32(in, _mm512_slli_epi32(_mm512_and_epi32(b, three), 2));
        in = _mm512_or_epi32(in, _mm512_slli_epi32(_mm512_and_epi32(c, three), 4));
        const halves chunks = wide(chunk), bricks = wide(brick), ins = wide(in);
        const __m256i first = densities_of(bone, (__mmask8)mask, chunks.low, bricks.low, ins.low);
        const __m256i second = densities_of(bone, (__mmask8)(mask >> 8), chunks.high, bricks.high, ins.high);
        /* The low half of each lane is a density; the high half contains the two bytes after the density. */
        const __m512i both = _mm512_inserti64x4(_mm512_castsi256_si512(first), second, 1);
        _mm512_mask_cvtepi32_storeu_epi16(densities + i, some, both);
    }
}
