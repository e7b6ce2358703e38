/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The baselines of the benchmarks. They are plain C, compiled at -O3 for the machine that builds them. With configure
 * --disable-native-bench, they are compiled for any machine. They form a separate library, which only the command
 * links.
 *
 * The baselines may contain instructions that the executing machine lacks, so bench_baseline_runs() must be called
 * first. It reads the list of the instruction sets that the baselines need. The list is in a file without code
 * (baseline_needs.c), so every machine can read it.
 */
#ifndef OST_BENCH_BASELINE_H
#define OST_BENCH_BASELINE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Returns false, with the reason, if this processor lacks an instruction set that the baselines
   were built for. */
bool bench_baseline_runs(char *reason, size_t size);
/* instruction sets that the baselines need, one bit each, in the order of BENCH_NATIVE_LIST */
extern const uint32_t bench_native_needs;

#define BENCH_NATIVE_LIST(X)                                                                                           \
    X(SSE3, "sse3")                                                                                                    \
    X(SSSE3, "ssse3") X(SSE4_1, "sse4.1") X(SSE4_2, "sse4.2") X(POPCNT, "popcnt") X(AVX, "avx") X(FMA, "fma")          \
        X(BMI, "bmi") X(BMI2, "bmi2") X(AVX2, "avx2") X(AVX512F, "avx512f") X(AVX512CD, "avx512cd")                    \
            X(AVX512BW, "avx512bw") X(AVX512DQ, "avx512dq") X(AVX512VL, "avx512vl") X(AVX512IFMA, "avx512ifma")        \
                X(AVX512VBMI, "avx512vbmi") X(AVX512VBMI2, "avx512vbmi2") X(AVX512VNNI, "avx512vnni")                  \
                    X(AVX512BITALG, "avx512bitalg") X(AVX512VPOPCNTDQ, "avx512vpopcntdq") X(GFNI, "gfni")

/* ------------------------------------------------------------------ removal */

/* The thesis' removal event (section 2.5): one kernel per chunk, which processes all voxels of the chunk. */
typedef struct bench_thesis_event {
    int chunk_count, chunk_size;
    int16_t *const *chunks;       /* per chunk: chunk_size^3 densities, x fastest */
    /* per chunk: position of its first voxel in the bone's grid */
    const int32_t (*corners)[3];
    float map[3][4];              /* affine matrix from bone voxels to tool voxels, in row-major order */
    int32_t dims[3];              /* dimensions of the tool's grid */
    const int16_t *tool;          /* 0 or 1 per voxel; x fastest */
} bench_thesis_event;

void bench_thesis_remove(const bench_thesis_event *event, int threads);

/* A 64-byte aligned row of 32 densities. Bit i of `hit` is set if the store clears density i. */
typedef struct bench_row_store {
    int16_t *row;
    uint32_t hit;
} bench_row_store;

/* Executes only the stores of a removal event on an unmodified bone. Their time is a lower bound on the event's time.
   On a machine without masked stores, the function reads each row, clears the densities that are hit, and writes the
   row. */
void bench_store_rows(const bench_row_store *rows, size_t count);

/* --------------------------------------------------------------------- bytes */

/* The method by which bytes are copied: memcpy of the C library, or stores that bypass the caches. */
typedef enum bench_copy { BENCH_COPY_MEMCPY, BENCH_COPY_STREAM, BENCH_COPY_COUNT } bench_copy;

/* Copies `in` to `out`, repeatedly if `in` is shorter, until `bytes` bytes are written. If `in` is longer than `out`,
   also reads the remaining bytes of `in` and returns a sum over them. */
uint64_t bench_copy_bytes(bench_copy how, uint8_t *out, size_t bytes, const uint8_t *in, size_t in_bytes, int threads);

/* Reads all bytes, 64 at a time, and returns a sum over them. */
uint64_t bench_read_bytes(const uint8_t *in, size_t bytes, int threads);

/* ---------------------------------------------------------------------- text */

/* Skips the lines at the beginning of the file that start with '#'. Then reads lines of the form "x y z density" with
   fscanf into arrays of `capacity` elements. Returns the number of lines read. */
size_t bench_fscanf_lines(const char *path, float *positions, int16_t *densities, size_t capacity);

#endif
