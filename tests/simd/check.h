/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A check of one slot of a table of kernels (tests/simd).
 *
 *   test    one case: inputs from the case's own generator, then the scalar
 *           kernel and the other one on equal memory, then comparisons
 *   bench   one or more workloads, timed
 *
 * A slot gets its check by one check_kernel in check_FAMILY.c and one line in
 * run.c; nothing is to be added for another instruction set.
 *
 *   static void test_thing(check *c)
 *   {
 *       ...                                     c->rng, c->number, check_input, check_outputs
 *       check_note(c, "count %d", count);       shown if it fails
 *       if (!check_both(c, call_thing, &a, &b))
 *           return;
 *       check_same(c, "to", CHECK_I16, a.to, b.to, count);
 *   }
 */
#ifndef OST_TESTS_SIMD_CHECK_H
#define OST_TESTS_SIMD_CHECK_H

#include "core/isa.h"
#include "rng.h"
#include "simd/call.h"
#include "simd/guard.h"

typedef enum check_result {
    CHECK_GOOD,
    CHECK_DIFFERS, /* from the scalar kernel, or from what the contract says of its own results */
    CHECK_BEYOND,  /* wrote outside its output */
    CHECK_FAULT,   /* or does not end */
    CHECK_STATE,   /* of the processor */
} check_result;

typedef struct check {
    test_rng rng;
    int number;    /* of the case, from 0: the first ones may be gone through in order */
    uint64_t seed; /* of the run */
    check_fn *scalar, *other;
    /* run.c's */
    check_result result;
    const char *name, *isa;
    bool quiet;
    char note[200];
} check;

typedef struct check_bench check_bench;

typedef struct check_kernel {
    const char *name;
    check_fn *(*of)(ost_isa isa); /* out of its table */
    void (*test)(check *c);
    void (*bench)(check_bench *b); /* may be NULL */
    int cases;                     /* usual number */
} check_kernel;

/* The slot of ost_cpu_kernels of that name, as check_kernel.of. */
#define CHECK_CPU_SLOT(slot)                     \
    static check_fn *slot##_of(ost_isa isa)      \
    {                                            \
        ost_cpu_kernels kernels;                 \
        ost_cpu_kernels_fill(&kernels, isa);     \
        return (check_fn *)kernels.slot;         \
    }

/* Every slot of every table. */
extern const check_kernel *const check_kernels[];
extern const int check_kernel_count;

/* ------------------------------------------------------- within a case */

static inline int64_t check_range(check *c, int64_t lo, int64_t hi)
{
    return rng_range(&c->rng, lo, hi);
}

static inline bool check_chance(check *c, int one_in)
{
    return rng_range(&c->rng, 1, one_in) == 1;
}

/* count elements of size bytes, at either edge of their pages, to be filled; read-only once a kernel runs. */
void *check_input(check *c, const char *name, size_t count, size_t size, size_t align);
/* Two alike, for the scalar kernel and the other one: both poison, both at the same edge. */
void check_outputs(check *c, const char *name, size_t count, size_t size, size_t align, void *both[2]);
/* What the case is, for who reads its failure. */
void check_note(check *c, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Calls the scalar kernel with a, the other with b; false when one of them failed. */
bool check_both(check *c, check_call_fn *call, void *a, void *b);

typedef enum check_type { CHECK_I8, CHECK_U8, CHECK_I16, CHECK_I32, CHECK_U32, CHECK_U64, CHECK_BITS } check_type;
/* Whether count elements are equal; else a table of the first that are not. */
bool check_same(check *c, const char *what, check_type type, const void *expected, const void *got, size_t count);
/* Whether it holds; else the sentence. */
bool check_that(check *c, bool holds, const char *format, ...) __attribute__((format(printf, 3, 4)));

/* ------------------------------------------------------------- running */

/* Cases first to first + count - 1, up to the first that fails. */
check_result check_run(const check_kernel *kernel, check_fn *scalar, check_fn *other, const char *isa, uint64_t seed, int first, int count,
                       bool quiet);

/* --------------------------------------------------------------- times */

/*
 * Times one workload with every instruction set by turns and prints a line.
 * prepare, when not NULL, runs before each call and is not timed.  items is
 * what a call works on, for the time of one; what names them.
 */
void bench_time(check_bench *b, const char *work, check_call_fn *call, void (*prepare)(void *arguments), void *arguments, double items,
                const char *what);
/* All workloads of a kernel, with the instruction sets of this machine up to `only` (or all: OST_ISA_COUNT). */
void bench_run(const check_kernel *kernel, ost_isa only);
void bench_heading(ost_isa only);

#endif
