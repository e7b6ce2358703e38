/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the intrinsics that immintrin.h supplies. On every machine, hashes of their results are compared with hashes
 * that were recorded on a processor with the instructions. If this machine's processor has the instructions, the
 * results of the instructions are tested in the same way.
 *
 * To add an intrinsic, run the test on a processor with AVX-512. The test fails and prints the hash to record in
 * cases.c.
 */
#include <inttypes.h>
#include <stddef.h>
#include <string.h>

#include "config.h"

#include "harness.h"

#include "core/isa.h"
#include "rng.h"
#include "simd/portable/cases.h"

enum { ROUNDS = 500 };

/* Replaces some lanes with values for which the definitions of the intrinsics have special cases. */
static void set_input(test_rng *rng, intrinsic_input *in)
{
    static const float floats[] = {0.0f, -0.0f, 0.5f, -0.5f, 1.5f, 2147483520.0f, 2147483648.0f, -2147483648.0f, 3e9f};
    static const double doubles[] = {0.0, -0.0, 0.5, -1.5, 2.5, 2147483647.5, 2147483647.25, -2147483648.5, 1e10};
    uint32_t a[16], b[16];
    for (int i = 0; i < 16; i++) {
        a[i] = (uint32_t)rng_next(rng);
        b[i] = (uint32_t)rng_next(rng);
        const int64_t kind = rng_range(rng, 0, 7);
        if (kind == 0)
            b[i] = a[i];
        if (kind <= 2)
            b[i] = (uint32_t)rng_range(rng, 0, 70);
        if (kind == 3)
            a[i] &= UINT32_C(0x01000100);
        in->f[i] = (float)rng_range(rng, -4000, 4000) / 8;
        in->g[i] = rng_range(rng, 0, 3) ? (float)rng_range(rng, -4000, 4000) / 8 : in->f[i];
        if (rng_range(rng, 0, 3) == 0)
            in->f[i] = floats[rng_range(rng, 0, 8)];
    }
    for (int i = 0; i < 8; i++)
        in->d[i] = rng_range(rng, 0, 2) ? (double)rng_range(rng, -400000, 400000) / 4 : doubles[rng_range(rng, 0, 8)];
    memcpy(in->a, a, sizeof in->a);
    memcpy(in->b, b, sizeof in->b);
    in->mask = rng_next(rng);
}

/* Returns the FNV-1a hash of the results of all rounds. */
static uint64_t hash_of(const intrinsic_case *c)
{
    test_rng rng = {1}; /* The seed is constant, because the hashes are recorded. */
    uint64_t hash = UINT64_C(0xcbf29ce484222325);
    for (int round = 0; round < ROUNDS; round++) {
        intrinsic_input in = {.mask = 0};
        _Alignas(64) uint8_t out[64] = {0};
        set_input(&rng, &in);
        c->run(&in, out);
        for (size_t i = 0; i < sizeof out; i++)
            hash = (hash ^ out[i]) * UINT64_C(0x100000001b3);
    }
    return hash;
}

static void portable_results_equal_recorded_results(void **state)
{
    (void)state;
    int wrong = 0;
    for (const intrinsic_case *c = intrinsics_portable; c->name; c++)
        if (hash_of(c) != c->recorded && ++wrong)
            printf("%s: portable %#" PRIx64 ", recorded %#" PRIx64 "\n", c->name, hash_of(c), c->recorded);
    assert_int_equal(wrong, 0);
}

static void native_results_equal_recorded_results(void **state)
{
    (void)state;
#if HAVE_AVX512_BUILD
    if (!ost_isa_available(OST_ISA_AVX512)) {
        puts("this processor has no AVX-512: compared with recorded results only");
        return;
    }
    int wrong = 0;
    for (const intrinsic_case *c = intrinsics_native; c->name; c++)
        if (hash_of(c) != c->recorded && ++wrong)
            printf("%s: processor %#" PRIx64 ", recorded %#" PRIx64 "\n", c->name, hash_of(c), c->recorded);
    assert_int_equal(wrong, 0);
#endif
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(portable_results_equal_recorded_results),
        cmocka_unit_test(native_results_equal_recorded_results),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
