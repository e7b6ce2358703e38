/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Calls the intrinsics that immintrin.h supplies. This file is compiled twice: as portable C, with CASES set to
 * intrinsics_portable, and with the processor's instructions, with CASES set to intrinsics_native.
 */
#include "simd/portable/cases.h"

#include <immintrin.h>
#include <string.h>

#define A8 _mm512_load_si512((const void *)in->a)
#define B8 _mm512_load_si512((const void *)in->b)
#define A4 _mm256_load_si256((const __m256i *)(const void *)in->a)
#define B4 _mm256_load_si256((const __m256i *)(const void *)in->b)
#define A2 _mm_load_si128((const __m128i *)(const void *)in->a)
#define B2 _mm_load_si128((const __m128i *)(const void *)in->b)
#define F _mm512_load_ps(in->f)
#define G _mm512_load_ps(in->g)
#define D _mm512_load_pd(in->d)
#define M8 ((__mmask8)in->mask)
#define M16 ((__mmask16)in->mask)
#define M32 ((__mmask32)in->mask)
#define M64 ((__mmask64)in->mask)
#define WORD(i) (words(in)[i])
#define LOW6 _mm512_and_si512(B8, _mm512_set1_epi64(63))
#define FEW(count) _mm512_and_si512(B8, _mm512_set1_epi32(count))

static inline const uint64_t *words(const intrinsic_input *in)
{
    return (const uint64_t *)(const void *)in->a;
}

/* X(name, recorded hash, type of the result, call) */
#define VALUES(X)                                                                                                      \
    X(_mm_popcnt_u32, 0x0287f5f550005d20, int32_t, _mm_popcnt_u32((uint32_t)WORD(0)))                                  \
    X(_mm_popcnt_u64, 0xddf30f24267e5119, int64_t, _mm_popcnt_u64(WORD(0)))                                            \
    X(_tzcnt_u32, 0x1ebc8907d116c115, uint32_t, _tzcnt_u32((uint32_t)(WORD(0) << (WORD(1) % 33))))                     \
    X(_tzcnt_u64, 0x66b50a7b1889784e, uint64_t, _tzcnt_u64(WORD(1) % 9 ? WORD(0) << (WORD(1) % 64) : 0))               \
    X(_bzhi_u32, 0xe934cf388bd5437d, uint32_t, _bzhi_u32((uint32_t)WORD(0), (uint32_t)WORD(1) % 300))                  \
    X(_pext_u32, 0x06c1433d9debc615, uint32_t, _pext_u32((uint32_t)WORD(0), (uint32_t)WORD(1)))                        \
    X(_pext_u64, 0xffcbe42c69e0999b, uint64_t, _pext_u64(WORD(0), WORD(1)))                                            \
    X(_pdep_u64, 0x2e70c6a51c011968, uint64_t, _pdep_u64(WORD(0), WORD(1)))                                            \
    X(_cvtu64_mask64, 0x5ec69b38de455557, __mmask64, _cvtu64_mask64(WORD(0)))                                          \
    X(_mm_cmpeq_epi8_mask, 0x1f72c804e5db2463, __mmask16, _mm_cmpeq_epi8_mask(A2, B2))                                 \
    X(_mm_cmple_epi8_mask, 0x11afb2aa15dc392d, __mmask16, _mm_cmple_epi8_mask(A2, B2))                                 \
    X(_mm_test_epi8_mask, 0x1dfb7fa264b72d36, __mmask16, _mm_test_epi8_mask(A2, B2))                                   \
    X(_mm_testz_si128, 0x43e8efb44ee46f25, int32_t, _mm_testz_si128(A2, _mm_and_si128(B2, _mm_cmpeq_epi8(A2, B2))))    \
    X(_mm256_testz_si256, 0xf77e7786a73aed25, int32_t,                                                                 \
      _mm256_testz_si256(A4, _mm256_and_si256(B4, _mm256_cmpeq_epi8(A4, B4))))                                         \
    X(_mm256_cmpgt_epi32_mask, 0xf40d4c2a3cf38514, __mmask8, _mm256_cmpgt_epi32_mask(A4, B4))                          \
    X(_mm256_mask_cmplt_epu32_mask, 0xeb1eb25ffdecd0ca, __mmask8, _mm256_mask_cmplt_epu32_mask(M8, A4, B4))            \
    X(_mm512_cmplt_epi32_mask, 0xbf57e90d2f2e0943, __mmask16, _mm512_cmplt_epi32_mask(A8, B8))                         \
    X(_mm512_cmplt_epu32_mask, 0xc5fe48c4c3d69189, __mmask16, _mm512_cmplt_epu32_mask(A8, B8))                         \
    X(_mm512_cmplt_epu64_mask, 0x538ada0670b9f658, __mmask8, _mm512_cmplt_epu64_mask(A8, B8))                          \
    X(_mm512_cmpneq_epi32_mask, 0x16f0c1984307b0dd, __mmask16, _mm512_cmpneq_epi32_mask(A8, B8))                       \
    X(_mm512_mask_cmplt_epi32_mask, 0x9af18fbef77acbe9, __mmask16, _mm512_mask_cmplt_epi32_mask(M16, A8, B8))          \
    X(_mm512_mask_cmplt_epu32_mask, 0x1bd460a827e533b2, __mmask16, _mm512_mask_cmplt_epu32_mask(M16, A8, B8))          \
    X(_mm512_mask_cmplt_epu64_mask, 0x9eccb85d0cbf4cd8, __mmask8, _mm512_mask_cmplt_epu64_mask(M8, A8, B8))            \
    X(_mm512_mask_cmpge_epi16_mask, 0x7b59f96032270ce5, __mmask32, _mm512_mask_cmpge_epi16_mask(M32, A8, B8))          \
    X(_mm512_mask_cmpge_epi32_mask, 0x1b4c1826bbb03301, __mmask16, _mm512_mask_cmpge_epi32_mask(M16, A8, B8))          \
    X(_mm512_mask_cmple_epi32_mask, 0x9af18fbef77acbe9, __mmask16, _mm512_mask_cmple_epi32_mask(M16, A8, B8))          \
    X(_mm_mask_cmpge_epi8_mask, 0x57cd0397306b4245, __mmask16, _mm_mask_cmpge_epi8_mask(M16, A2, B2))                  \
    X(_mm512_mask_cmp_ps_mask, 0x3ec8a8fc625cd826, __mmask16, _mm512_mask_cmp_ps_mask(M16, F, G, _CMP_GT_OQ))          \
    X(_mm_maskload_epi32, 0xaf1356813dbc97d7, __m128i, _mm_maskload_epi32((const int *)(const void *)in->a, B2))       \
    X(_mm256_maskload_epi64, 0x055ab80e532c004c, __m256i,                                                              \
      _mm256_maskload_epi64((const long long *)(const void *)in->a, B4))                                               \
    X(_mm_maskz_loadu_epi32, 0x3713f2e175625b54, __m128i, _mm_maskz_loadu_epi32(M8, in->a + 1))                        \
    X(_mm512_maskz_loadu_epi16, 0xf6e05f8c8a4d92d7, __m512i, _mm512_maskz_loadu_epi16(M32, in->a + 1))                 \
    X(_mm512_maskz_loadu_epi32, 0x2914e7dab5a25aac, __m512i, _mm512_maskz_loadu_epi32(M16, in->a + 1))                 \
    X(_mm512_maskz_loadu_epi64, 0x30b1e2bc7db8261a, __m512i, _mm512_maskz_loadu_epi64(M8, in->a + 1))                  \
    X(_mm512_i32gather_epi32, 0x2386125f173b606b, __m512i, _mm512_i32gather_epi32(FEW(15), in->a, 4))                  \
    X(_mm512_mask_i32gather_epi32, 0x8a3af632734ca1f4, __m512i,                                                        \
      _mm512_mask_i32gather_epi32(B8, M16, FEW(31), in->a, 2))                                                         \
    X(_mm512_mask_i64gather_epi32, 0x3d36cb7aa2d70cfb, __m256i, _mm512_mask_i64gather_epi32(A4, M8, LOW6, in->a, 1))   \
    X(_mm512_mask_i64gather_epi64, 0x4947795067c869e0, __m512i, _mm512_mask_i64gather_epi64(A8, M8, LOW6, in->a, 1))   \
    X(_mm512_srai_epi32, 0xaa4a2e73ab8ff655, __m512i, _mm512_srai_epi32(A8, 11))                                       \
    X(_mm512_srai_epi64, 0x1491fbf7a9ab2cb9, __m512i, _mm512_srai_epi64(A8, 40))                                       \
    X(_mm512_sra_epi32, 0x20dfdc109d1367d1, __m512i, _mm512_sra_epi32(A8, _mm_srli_epi64(B2, 58)))                     \
    X(_mm512_srav_epi32, 0xbeb6b99998f467a2, __m512i, _mm512_srav_epi32(A8, B8))                                       \
    X(_mm512_madd_epi16, 0xe8917c86da451ec2, __m512i, _mm512_madd_epi16(A8, B8))                                       \
    X(_mm512_mask_sub_epi16, 0xe3dee8a43a5173dc, __m512i, _mm512_mask_sub_epi16(A8, M32, B8, A8))                      \
    X(_mm512_shuffle_i64x2, 0x67a3db3c8574eef6, __m512i, _mm512_shuffle_i64x2(A8, B8, 0x6c))                           \
    X(_cvtmask64_u64, 0xc8ceede4839549fd, uint64_t, _cvtmask64_u64(M64))                                               \
    X(_mm512_mulhi_epu16, 0xfb436309bf9f52e0, __m512i, _mm512_mulhi_epu16(A8, B8))                                     \
    X(_mm512_alignr_epi32, 0x01a2cd89fe47d41b, __m512i, _mm512_alignr_epi32(A8, B8, 5))                                \
    X(_mm512_mask_loadu_epi8, 0xeb7496ac4c5f5a6b, __m512i, _mm512_mask_loadu_epi8(B8, M64, in->a + 1))                 \
    X(_mm512_lzcnt_epi64, 0x345ae32975ecd7b9, __m512i, _mm512_lzcnt_epi64(_mm512_srlv_epi64(A8, B8)))                  \
    X(_mm512_cvtepu8_epi32, 0xbd33def8e3f4a985, __m512i, _mm512_cvtepu8_epi32(A2))                                     \
    X(_mm512_cvtepi32_epi8, 0x7be4fde3269e20f7, __m128i, _mm512_cvtepi32_epi8(A8))                                     \
    X(_mm512_cvtepi32_epi16, 0x5adf223b39c0aa2d, __m256i, _mm512_cvtepi32_epi16(A8))                                   \
    X(_mm512_cvtepi32_epi64, 0x728a9ae2a711ad67, __m512i, _mm512_cvtepi32_epi64(A4))                                   \
    X(_mm512_cvtepi64_epi16, 0x0e0eb2fb2fb58ae7, __m128i, _mm512_cvtepi64_epi16(A8))                                   \
    X(_mm512_cvtepi32_ps, 0x845d65d74d6fe095, __m512, _mm512_cvtepi32_ps(A8))                                          \
    X(_mm512_cvtepi32_pd, 0x82c4454a78e284b3, __m512d, _mm512_cvtepi32_pd(A4))                                         \
    X(_mm512_cvttps_epi32, 0x98dff5e62a05349f, __m512i, _mm512_cvttps_epi32(F))                                        \
    X(_mm512_cvtpd_epi32, 0xdcff65d591827dbe, __m256i, _mm512_cvtpd_epi32(D))                                          \
    X(_mm512_cvtsi512_si32, 0xebb542ebe43cb7f3, int32_t, _mm512_cvtsi512_si32(A8))                                     \
    X(floor_pd, 0x38707ba93b9e7b29, __m512d, _mm512_roundscale_pd(D, _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC))       \
    X(ceil_pd, 0x17970ee3f49dc5a3, __m512d, _mm512_roundscale_pd(D, _MM_FROUND_TO_POS_INF | _MM_FROUND_NO_EXC))        \
    X(floor_ps, 0xce95d9db515d43a4, __m512, _mm512_roundscale_ps(F, _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC))        \
    X(ceil_ps, 0x4077ba615da242f4, __m512, _mm512_roundscale_ps(F, _MM_FROUND_TO_POS_INF | _MM_FROUND_NO_EXC))         \
    X(_mm512_reduce_add_epi32, 0xc9eae7a8e5c48fb3, int32_t, (int32_t)_mm512_reduce_add_epi32(A8))                      \
    X(_mm512_reduce_add_epi64, 0xeba9137ec6ab7cb3, int64_t, (int64_t)_mm512_reduce_add_epi64(A8))                      \
    X(_mm512_reduce_max_epu64, 0x1ecb794f142731a6, uint64_t, _mm512_reduce_max_epu64(A8))                              \
    X(_mm512_mask_reduce_min_epi32, 0xdc18a047ee8d6dae, int32_t, _mm512_mask_reduce_min_epi32(M16, A8))                \
    X(_mm512_mask_reduce_max_epi32, 0x89a08f863aa4b9da, int32_t, _mm512_mask_reduce_max_epi32(M16, A8))

/* X(name, recorded hash, call); the call stores its result to the memory at `to` */
#define STORES(X)                                                                                                      \
    X(_mm_mask_storeu_epi8, 0x43d5c1a8077d1bb2, _mm_mask_storeu_epi8(to, M16, A2))                                     \
    X(_mm_mask_storeu_epi16, 0x05887fc3c7e5038d, _mm_mask_storeu_epi16(to, M8, A2))                                    \
    X(_mm512_mask_storeu_epi8, 0x10594f8725b8be4b, _mm512_mask_storeu_epi8(to, M64, A8))                               \
    X(_mm512_mask_storeu_epi16, 0x31c98a27959e1c9e, _mm512_mask_storeu_epi16(to, M32, A8))                             \
    X(_mm512_mask_storeu_epi64, 0xc24797ff87cc9739, _mm512_mask_storeu_epi64(to, M8, A8))                              \
    X(_mm512_mask_store_epi32, 0x10bf9efedeeadf57, _mm512_mask_store_epi32(to, M16, A8))                               \
    X(_mm512_mask_store_ps, 0x4578597de726523c, _mm512_mask_store_ps(to, M16, F))                                      \
    X(_mm512_mask_cvtepi32_storeu_epi16, 0xcdd6e8e6b99ef30e, _mm512_mask_cvtepi32_storeu_epi16(to, M16, A8))           \
    X(_mm512_stream_si512, 0xd9b4598e63facd12, _mm512_stream_si512(to, A8))                                            \
    X(_store_mask32, 0x23700275373040a4, _store_mask32((__mmask32 *)to, M32))

/* The function that calls the intrinsic NAME is named run_NAME, because NAME itself is a macro in portable C. */
#define VALUE_FUNCTION(name, recorded, type, call)                              \
    static void run_##name(const intrinsic_input *in, uint8_t *out)             \
    {                                                                           \
        const type result = call;                                               \
        memcpy(out, &result, sizeof result);                                    \
    }
#define STORE_FUNCTION(name, recorded, call)                                    \
    static void run_##name(const intrinsic_input *in, uint8_t *out)             \
    {                                                                           \
        void *const to = out;                                                   \
        call;                                                                   \
    }
VALUES(VALUE_FUNCTION)
STORES(STORE_FUNCTION)

#define VALUE_ROW(name, recorded, type, call) {#name, recorded, run_##name},
#define STORE_ROW(name, recorded, call) {#name, recorded, run_##name},
const intrinsic_case CASES[] = {VALUES(VALUE_ROW) STORES(STORE_ROW){NULL, 0, NULL}};
