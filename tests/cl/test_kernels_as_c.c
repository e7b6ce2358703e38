/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Compares the kernels of src/cl, compiled as C, with the reference; the results must be bit-identical. No device is
 * needed. In a build with sanitizers, the sanitizers check every line of the kernels.
 * Covers: AR-INT-1, AR-INT-2, AR-CT-4, AR-CT-5, AR-CT-6, AR-CT-9, AR-CUB-2, AR-CUB-3, AR-CHK-1, AR-CHK-2, AR-CHK-4,
 * AR-VOX-1..7, AR-MAP-4, AR-REM-1, AR-REM-2, AR-REM-3, AR-REM-5, AR-REM-6, AR-CLS-1
 */
#include "cl/machine.h"

static void with_machine(const char *what, void (*compare)(machine *, test_rng *, int), int rounds)
{
    test_rng rng = rng_seeded(what);
    static const int rows[] = {1, 4, 16, 256};
    for (int i = 0; i < 4; i++) {
        machine *m = machine_as_c(rng_next(&rng), rows[i]);
        compare(m, &rng, rounds);
        free(m);
    }
}

static void samples(void **state) { (void)state; with_machine("samples to rect grid", compare_scatter, 300); }
static void cubic(void **state) { (void)state; with_machine("rect grid to cubic", compare_cubic, 60); }
static void chunks(void **state) { (void)state; with_machine("chunks", compare_chunks, 10); }
static void voxelizer(void **state) { (void)state; with_machine("voxelizer", compare_voxelizer, 100); }
static void reach(void **state) { (void)state; with_machine("reach of cells", compare_reach, 9); }
static void removal(void **state) { (void)state; with_machine("removal", compare_removal, 40); }
static void fingerprint(void **state) { (void)state; with_machine("fingerprint", compare_fingerprint, 2); }

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(samples),     cmocka_unit_test(cubic), cmocka_unit_test(chunks),
        cmocka_unit_test(voxelizer),   cmocka_unit_test(reach), cmocka_unit_test(removal),
        cmocka_unit_test(fingerprint),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
