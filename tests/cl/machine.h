/* SPDX-License-Identifier: Apache-2.0 */
/*
 * An interface for running the kernels of src/cl/kernels, either compiled as C or on an OpenCL
 * device. Every launch copies all buffers to the machine and back, which is slow but sufficient
 * for comparisons.
 */
#ifndef OST_TESTS_CL_MACHINE_H
#define OST_TESTS_CL_MACHINE_H

#include "harness.h"

#include <stdbool.h>

#include "cl/kernels/shared.h"

#define TEST_KERNELS(X)      \
    X(ost_ct_claim)          \
    X(ost_ct_place)          \
    X(ost_ct_check)          \
    X(ost_ct_report_first_bad) \
    X(ost_ct_had)            \
    X(ost_cubic_sources)     \
    X(ost_cubic_gather)      \
    X(ost_cubic_linear)      \
    X(ost_chunk_scan)        \
    X(ost_chunk_scan_layers) \
    X(ost_chunk_store)       \
    X(ost_chunk_store_layers) \
    X(ost_chunk_load)        \
    X(ost_chunk_load_rows)   \
    X(ost_chunk_count)       \
    X(ost_vox_steps)         \
    X(ost_vox_fill)          \
    X(ost_vox_count)         \
    X(ost_vox_tiles)         \
    X(ost_tool_reach)        \
    X(ost_tool_windows)      \
    X(ost_remove)            \
    X(ost_remove_blocks)     \
    X(ost_fingerprint)       \
    X(ost_fingerprint_atomics) \
    X(ost_fingerprint_turns)

enum test_kernel {
#define TEST_KERNEL_ENUM(name) K_##name,
    TEST_KERNELS(TEST_KERNEL_ENUM)
#undef TEST_KERNEL_ENUM
    K_COUNT
};

/* An argument of a kernel. It is a buffer if bytes > 0; otherwise, it is a 32-bit number. */
typedef struct kernel_arg {
    void *data;
    size_t bytes;
    uint32_t number;
} kernel_arg;

static inline kernel_arg buffer_arg(const void *data, size_t bytes)
{
    return (kernel_arg){.data = (void *)(uintptr_t)data, .bytes = bytes};
}

static inline kernel_arg number_arg(int64_t number)
{
    return (kernel_arg){.number = (uint32_t)number};
}

/* BUFFER makes an argument from an array of `count` elements, and ONE makes an argument from one struct. */
#define BUFFER(p, count) buffer_arg(p, sizeof *(p) * (size_t)(count))
#define ONE(p) BUFFER(p, 1)

typedef struct machine machine;
struct machine {
    char name[200];
    int rows;   /* value of OST_ROWS; 256 selects ost_remove_blocks */
    bool small; /* true if scenes must be small, because a simulator is slow */
    /* true if the device ends long loops early; the tests then use only the kernel set for GPUs (cl/fingerprint.c) */
    bool brief;
    void (*launch)(machine *m, enum test_kernel kernel, const kernel_arg *args, unsigned count, const size_t range[3]);
};

#define LAUNCH(m, kernel, x, y, z, ...)                                                               \
    (m)->launch(m, K_##kernel, (const kernel_arg[]){__VA_ARGS__},                                     \
                sizeof((const kernel_arg[]){__VA_ARGS__}) / sizeof(kernel_arg),                       \
                (const size_t[3]){(size_t)(x), (size_t)(y), (size_t)(z)})

/* Makes a machine that runs the kernels compiled as C, with this value of OST_ROWS. The seed determines the order of
   the items and the number of additional items beyond the range. */
machine *machine_as_c(uint64_t seed, int rows);

/* Returns the number of iterations, at most OST_CL_TURNS, that a loop in one work item can execute on this machine.
   Fails the test if the loop's result is wrong. */
uint32_t machine_turns(machine *m);

/* Each of these functions generates `rounds` scenes from rng and compares the machine with the reference. Reports of
   failures contain the machine's name. */
void compare_scatter(machine *m, test_rng *rng, int rounds);
void compare_cubic(machine *m, test_rng *rng, int rounds);
void compare_chunks(machine *m, test_rng *rng, int rounds);
void compare_voxelizer(machine *m, test_rng *rng, int rounds);
void compare_reach(machine *m, test_rng *rng, int rounds);
void compare_removal(machine *m, test_rng *rng, int rounds);
void compare_fingerprint(machine *m, test_rng *rng, int rounds);

#endif
