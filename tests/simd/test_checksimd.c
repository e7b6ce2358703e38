/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests that checksimd detects errors. Each kernel of the lists in wrong.h has one small error, which must be reported
 * with the right reason within the default number of cases. The seed is fixed, so that results do not vary between
 * runs.
 *
 * Covers: AR-LAW-1
 */
#include <stdio.h>

#include "simd/wrong.h"

int main(void)
{
    static const char *const results[] = {[CHECK_GOOD] = "not detected",
                                          [CHECK_DIFFERS] = "reported as a difference",
                                          [CHECK_BEYOND] = "reported as a write beyond the output",
                                          [CHECK_FAULT] = "reported as a fault",
                                          [CHECK_STATE] = "reported as a change of the processor's state"};
    static const wrong_list *const lists[] = {&wrong_grids, &wrong_remove, &wrong_voxelize, &wrong_text};
    const uint64_t seed = 20261121;
    int wrongs = 0, failed = 0;
    if (call_under_valgrind())
        return 77;
    call_watch(0.5);
    for (size_t n = 0; n < sizeof lists / sizeof lists[0]; n++)
        for (int i = 0; i < lists[n]->count; i++, wrongs++) {
            const wrong *w = &lists[n]->first[i];
            const check_result r = check_run(w->kernel, w->kernel->of(OST_ISA_SCALAR), w->fn, "wrong", seed, 0,
                                             w->kernel->cases, true);
            if (w->found_as & 1u << r)
                continue;
            printf("FAILED %s: %s in %d cases of %s\n", w->what, results[r], w->kernel->cases, w->kernel->name);
            failed++;
        }
    /* The correct kernels must not be reported. */
    for (int i = 0; i < check_kernel_count; i++) {
        check_fn *scalar = check_kernels[i]->of(OST_ISA_SCALAR);
        failed += check_run(check_kernels[i], scalar, scalar, "scalar", seed, 0, 50, false) != CHECK_GOOD;
    }
    printf("%d wrong kernels, %d failed\n", wrongs, failed);
    return failed > 0;
}
