/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A check belongs to one slot of a table of kernels. It consists of two functions:
 *
 *   test    runs one case: makes inputs with the random generator of the case, calls the scalar kernel
 *           and the other kernel with equal inputs, and compares their outputs
 *   bench   times one or more workloads
 *
 * A new slot needs one check_kernel in check_FAMILY.c and one line in run.c. A new instruction set needs no
 * change. Example:
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
    CHECK_DIFFERS, /* results differ from those of the scalar kernel or violate the contract */
    CHECK_BEYOND,  /* the kernel wrote outside its output */
    CHECK_FAULT,   /* a fault occurred, or the call did not end */
    CHECK_STATE,   /* the processor's state was changed */
} check_result;

typedef struct check {
    test_rng rng;
    int number;    /* number of the case, counted from 0; a test may use special values in the first cases */
    uint64_t seed; /* seed of the run */
    check_fn *scalar, *other;
    /* The following members are used only by run.c. */
    check_result result;
    const char *name, *isa;
    bool quiet;
    char note[200];
} check;

typedef struct check_bench check_bench;

typedef struct check_kernel {
    const char *name;
    check_fn *(*of)(ost_isa isa); /* returns the slot's function in the table of an instruction set */
    void (*test)(check *c);
    void (*bench)(check_bench *b); /* may be NULL */
    int cases;                     /* number of cases that run by default */
} check_kernel;

/* Defines check_kernel.of for the slot of ost_cpu_kernels with this name. */
#define CHECK_CPU_SLOT(slot)                     \
    static check_fn *slot##_of(ost_isa isa)      \
    {                                            \
        ost_cpu_kernels kernels;                 \
        ost_cpu_kernels_fill(&kernels, isa);     \
        return (check_fn *)kernels.slot;         \
    }

/* The checks of all slots in all tables. */
extern const check_kernel *const check_kernels[];
extern const int check_kernel_count;

/* ------------------------------------------------ functions for a test */

static inline int64_t check_range(check *c, int64_t lo, int64_t hi)
{
    return rng_range(&c->rng, lo, hi);
}

static inline bool check_chance(check *c, int one_in)
{
    return rng_range(&c->rng, 1, one_in) == 1;
}

/*
 * Returns an array of `count` elements of `size` bytes for the caller to fill. The array lies at the
 * beginning or at the end of its pages, and is read-only while a kernel runs.
 */
void *check_input(check *c, const char *name, size_t count, size_t size, size_t align);
/*
 * Returns two buffers with equal content (poison), one for the scalar kernel and one for the other kernel.
 * Both lie at the same edge of their pages.
 */
void check_outputs(check *c, const char *name, size_t count, size_t size, size_t align, void *both[2]);
/* Sets a description of the case, which is printed if the case fails. */
void check_note(check *c, const char *format, ...) __attribute__((format(printf, 2, 3)));

/*
 * Calls the scalar kernel with the arguments `a` and the other kernel with the arguments `b`. Returns false if a call
 * failed.
 */
bool check_both(check *c, check_call_fn *call, void *a, void *b);

typedef enum check_type { CHECK_I8, CHECK_U8, CHECK_I16, CHECK_I32, CHECK_U32, CHECK_U64, CHECK_BITS } check_type;
/*
 * Returns true if the `count` elements of `expected` and `got` are equal. If they differ, the case fails, and a table
 * of the first differences is printed.
 */
bool check_same(check *c, const char *what, check_type type, const void *expected, const void *got, size_t count);
/*
 * If `holds` is false, the case fails with the formatted sentence. Returns false if this check or an earlier
 * check of the case failed.
 */
bool check_that(check *c, bool holds, const char *format, ...) __attribute__((format(printf, 3, 4)));

/* ------------------------------------------------------- running cases */

/* Runs `count` cases, beginning with number `first`, and stops at the first case that fails. */
check_result check_run(const check_kernel *kernel, check_fn *scalar, check_fn *other, const char *isa, uint64_t seed,
                       int first, int count, bool quiet);

/* -------------------------------------------------------------- timing */

/*
 * Times one workload with each instruction set and prints a line. If `prepare` is not NULL, it runs before
 * each call and is not timed. `items` is the number of items that a call processes, and `what` is the name of
 * an item. The line contains the time per item.
 */
void bench_time(check_bench *b, const char *work, check_call_fn *call, void (*prepare)(void *arguments),
                void *arguments, double items, const char *what);
/*
 * Times all workloads of a kernel. Times the scalar variant and the variant for the instruction set
 * `only` or, if `only` is OST_ISA_COUNT, the variants for all instruction sets.
 */
void bench_run(const check_kernel *kernel, ost_isa only);
void bench_heading(ost_isa only);

#endif
