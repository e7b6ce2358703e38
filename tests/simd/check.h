/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A check of one slot of a table of kernels (tests/simd).
 *
 *   test    one case: inputs from the case's own generator, then the scalar
 *           kernel and the other one on equal memory, then comparisons
 *   bench   one or more workloads, timed
 *
 * A slot gets its check by one check_kernel in check_FAMILY.c and one line in
 * run.c; nothing needs to be added for another instruction set.
 *
 *   static void test_thing(check *c)
 *   {
 *       ...                                     c->rng, c->number, check_input, check_outputs
 *       check_note(c, "count %d", count);       printed if the case fails
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
    CHECK_DIFFERS, /* from the scalar kernel, or its results violate the contract */
    CHECK_BEYOND,  /* wrote outside its output */
    CHECK_FAULT,   /* or the call does not end */
    CHECK_STATE,   /* the processor's state was changed */
} check_result;

typedef struct check {
    test_rng rng;
    int number;    /* number of the case, from 0; a test may use the first numbers to go through values in order */
    uint64_t seed; /* seed of the run */
    check_fn *scalar, *other;
    /* used by run.c */
    check_result result;
    const char *name, *isa;
    bool quiet;
    char note[200];
} check;

typedef struct check_bench check_bench;

typedef struct check_kernel {
    const char *name;
    check_fn *(*of)(ost_isa isa); /* gets the slot from its table */
    void (*test)(check *c);
    void (*bench)(check_bench *b); /* may be NULL */
    int cases;                     /* usual number */
} check_kernel;

/* Defines check_kernel.of for the slot of ost_cpu_kernels with that name. */
#define CHECK_CPU_SLOT(slot)                     \
    static check_fn *slot##_of(ost_isa isa)      \
    {                                            \
        ost_cpu_kernels kernels;                 \
        ost_cpu_kernels_fill(&kernels, isa);     \
        return (check_fn *)kernels.slot;         \
    }

/* The checks of every slot of every table. */
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

/* Returns count elements of size bytes, at either edge of their pages, for the caller to fill; read-only once a
   kernel runs. */
void *check_input(check *c, const char *name, size_t count, size_t size, size_t align);
/* Returns two equal buffers, for the scalar kernel and the other one: both contain poison, both lie at the same
   edge. */
void check_outputs(check *c, const char *name, size_t count, size_t size, size_t align, void *both[2]);
/* Sets the description of the case that a failure prints. */
void check_note(check *c, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Calls the scalar kernel with a, the other with b. Returns false if one of them failed. */
bool check_both(check *c, check_call_fn *call, void *a, void *b);

typedef enum check_type { CHECK_I8, CHECK_U8, CHECK_I16, CHECK_I32, CHECK_U32, CHECK_U64, CHECK_BITS } check_type;
/* Returns true if count elements are equal; otherwise the case fails and a table of the first differences is
   printed. */
bool check_same(check *c, const char *what, check_type type, const void *expected, const void *got, size_t count);
/* Returns holds, and false after an earlier failure. If holds is false the case fails with the sentence. */
bool check_that(check *c, bool holds, const char *format, ...) __attribute__((format(printf, 3, 4)));

/* ------------------------------------------------------------- running */

/* Runs cases first to first + count - 1, up to the first that fails. */
check_result check_run(const check_kernel *kernel, check_fn *scalar, check_fn *other, const char *isa, uint64_t seed,
                       int first, int count, bool quiet);

/* --------------------------------------------------------------- times */

/*
 * Times one workload with every instruction set in turn and prints a line.
 * prepare, if not NULL, runs before each call and is not timed.  items is the
 * number of items that a call processes, for the time per item; what is the
 * item's name.
 */
void bench_time(check_bench *b, const char *work, check_call_fn *call, void (*prepare)(void *arguments),
                void *arguments, double items, const char *what);
/* Times all workloads of a kernel with the scalar kernel and the instruction set `only`, or with all
   (OST_ISA_COUNT). */
void bench_run(const check_kernel *kernel, ost_isa only);
void bench_heading(ost_isa only);

#endif
