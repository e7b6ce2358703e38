/* SPDX-License-Identifier: Apache-2.0 */
/* Checks that this processor has the instruction sets that the baselines were built for. Unlike the
   baselines, this file is compiled for any processor. */
#include "bench/baseline.h"

#include <stdio.h>

bool bench_baseline_runs(char *reason, size_t size)
{
    snprintf(reason, size, "%s", "");
#if defined __x86_64__
    uint32_t needs = bench_native_needs;
    int bit = 0;
    __builtin_cpu_init();
#define CHECK(id, name)                                                                                                \
    if (needs >> bit++ & 1 && !__builtin_cpu_supports(name)) {                                                         \
        snprintf(reason, size,                                                                                         \
                 "the baselines were built with -march=native on a processor with " name ", which this one lacks");    \
        return false;                                                                                                  \
    }
    BENCH_NATIVE_LIST(CHECK)
#undef CHECK
#endif
    return true;
}
