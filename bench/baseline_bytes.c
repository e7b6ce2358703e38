/* SPDX-License-Identifier: Apache-2.0 */
/* Copies or reads as many bytes as the measured operation does, but computes nothing. The time is a lower bound on the
   operation's time. */
#include "bench/baseline.h"

#include <string.h>
#if defined __SSE2__
#include <immintrin.h>
#endif

/* Copies by stores that bypass the caches. `bytes` must be a multiple of 64, and both buffers must be
   64-byte aligned. */
static void copy_stream(uint8_t *out, const uint8_t *in, size_t bytes)
{
#if defined __AVX512F__
    for (size_t i = 0; i < bytes; i += 64)
        _mm512_stream_si512((__m512i *)(void *)(out + i), _mm512_load_si512(in + i));
    _mm_sfence();
#elif defined __AVX__
    for (size_t i = 0; i < bytes; i += 32)
        _mm256_stream_si256((__m256i *)(void *)(out + i), _mm256_load_si256((const __m256i *)(const void *)(in + i)));
    _mm_sfence();
#elif defined __SSE2__
    for (size_t i = 0; i < bytes; i += 16)
        _mm_stream_si128((__m128i *)(void *)(out + i), _mm_load_si128((const __m128i *)(const void *)(in + i)));
    _mm_sfence();
#else
    memcpy(out, in, bytes);
#endif
}

static uint64_t sum_words(const uint8_t *in, size_t bytes)
{
    uint64_t sum[8] = {0};
    size_t i = 0;
    for (; i + 64 <= bytes; i += 64) {
        uint64_t word[8];
        memcpy(word, in + i, sizeof word);
        for (int k = 0; k < 8; k++)
            sum[k] += word[k];
    }
    for (; i < bytes; i++)
        sum[0] += in[i];
    for (int k = 1; k < 8; k++)
        sum[0] += sum[k];
    return sum[0];
}

/* Computes the part of [0, bytes) that one of several threads processes. Each part begins at a
   multiple of 4096. */
static void share_of(size_t bytes, int part, int parts, size_t *begin, size_t *end)
{
    const size_t page = 4096, pages = (bytes + page - 1) / page;
    *begin = pages * (size_t)part / (size_t)parts * page;
    *end = pages * (size_t)(part + 1) / (size_t)parts * page;
    *end = *end < bytes ? *end : bytes;
    *begin = *begin < *end ? *begin : *end;
}

static void copy_share(bench_copy how, uint8_t *out, size_t begin, size_t end, const uint8_t *in, size_t in_bytes)
{
    const size_t aligned_bytes = in_bytes / 64 * 64;
    for (size_t at = begin; at < end;) {
        size_t from = at % aligned_bytes, run = aligned_bytes - from < end - at ? aligned_bytes - from : end - at,
               lines = run / 64 * 64;
        if (how == BENCH_COPY_STREAM && lines)
            copy_stream(out + at, in + from, lines);
        else
            lines = 0;
        memcpy(out + at + lines, in + from + lines, run - lines);
        at += run;
    }
}

uint64_t bench_copy_bytes(bench_copy how, uint8_t *out, size_t bytes, const uint8_t *in, size_t in_bytes, int threads)
{
    uint64_t sum = 0;
#if defined _OPENMP
#pragma omp parallel for schedule(static) num_threads(threads) if (threads > 1) reduction(+ : sum)
#endif
    for (int part = 0; part < threads; part++) {
        size_t begin, end;
        share_of(bytes, part, threads, &begin, &end);
        copy_share(how, out, begin, end, in, in_bytes);
        if (in_bytes > bytes) {
            share_of(in_bytes - bytes, part, threads, &begin, &end);
            sum += sum_words(in + bytes + begin, end - begin);
        }
    }
    return sum;
}

uint64_t bench_read_bytes(const uint8_t *in, size_t bytes, int threads)
{
    uint64_t sum = 0;
#if defined _OPENMP
#pragma omp parallel for schedule(static) num_threads(threads) if (threads > 1) reduction(+ : sum)
#endif
    for (int part = 0; part < threads; part++) {
        size_t begin, end;
        share_of(bytes, part, threads, &begin, &end);
        sum += sum_words(in + begin, end - begin);
    }
    return sum;
}
