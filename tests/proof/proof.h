/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Definitions for the proofs of ranges (AR-INT-3). Only cbmc reads these files; no compiler builds them. A harness
 * includes a source file of src, calls one of its functions with any input within the documented range, and asserts the
 * bound that docs/spec/arithmetic.md states. cbmc adds the checks for overflow and conversion. If a called function has
 * a proof of its own, a contract may replace the function. The contract asserts the function's range of inputs and
 * returns any result within the function's bound.
 *
 * If WIDE is defined, the range of inputs is wider by one or more bits, and the proof must fail.
 */
#ifndef OST_TESTS_PROOF_H
#define OST_TESTS_PROOF_H

#include <stdint.h>

#include "core/integer.h"
#include <osteon/length.h>
#include <osteon/status.h>

#ifdef WIDE
enum { WIDER = 1 };
#else
enum { WIDER = 0 };
#endif

int32_t nondet_int32(void);
int64_t nondet_int64(void);
uint64_t nondet_uint64(void);
ost_i128 nondet_int128(void);

#define ASSUME(what) __CPROVER_assume(what)
#define ASSERT(what) __CPROVER_assert(what, #what)
#define WITHIN(value, limit) ASSUME((value) >= -(limit) && (value) <= (limit))
#define BOUNDED(value, limit) ASSERT((value) >= -(limit) && (value) <= (limit))

/* 8 m in picometres, and the limit of |q| for a pose that ost_rotation_fits accepts. */
#define LENGTH (INT64_C(8000000000000) << WIDER)
#define QUATERNION (((INT64_C(1) << 30) + (1 << 21)) << WIDER)

static inline int64_t any64(int64_t limit)
{
    int64_t value = nondet_int64();
    WITHIN(value, limit);
    return value;
}

static inline int32_t any32(int32_t low, int32_t high)
{
    int32_t value = nondet_int32();
    ASSUME(value >= low && value <= high);
    return value;
}

/* The text of the error is omitted, because it does not affect any result. */
ost_status ost_fail(ost_error *err, ost_status status, const char *format, ...)
{
    (void)err, (void)format;
    return status;
}

char *ost_pm_format(ost_pm value, char text[OST_PM_TEXT])
{
    (void)value;
    return text;
}

double ost_pm_to_mm(ost_pm value)
{
    return (double)value;
}

#endif
