/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the selection of an instruction set level on simulated processors. The numbers of the CPUID bits were taken
 * from Intel's and AMD's manuals.
 */
#include "harness.h"

#include "core/isa.h"

#define BIT(n) (UINT32_C(1) << (n))
enum { XMM = 1 << 1, YMM = 1 << 2, OPMASK = 1 << 5, ZMM_HIGH = 1 << 6, HIGH_ZMM = 1 << 7 };

static const struct machine {
    const char *name;
    ost_isa level;
    ost_isa_cpuid cpuid;
} machines[] = {
    {"nothing at all", OST_ISA_SCALAR, {0}},
    /* has SSE4.2 and POPCNT, but not XSAVE */
    {"Nehalem", OST_ISA_SCALAR, {.leaf1_c = BIT(19) | BIT(20) | BIT(23)}},
    /* has AVX, XSAVE and OSXSAVE, but no leaf 7 */
    {"Sandy Bridge", OST_ISA_SCALAR, {.leaf1_c = BIT(23) | BIT(26) | BIT(27) | BIT(28), .xcr0 = 1 | XMM | YMM}},
    /* has FMA (bit 12) and MOVBE (22) in leaf 1, and BMI1 (3), AVX2 (5) and BMI2 (8) in leaf 7 */
    {"Haswell",
     OST_ISA_AVX2,
     {BIT(12) | BIT(22) | BIT(23) | BIT(26) | BIT(27) | BIT(28), BIT(3) | BIT(5) | BIT(8), 0, BIT(5), 1 | XMM | YMM}},
    /* has the AVX-512 extensions F (16), PF (26), ER (27) and CD (28), but not DQ, BW or VL */
    {"Knights Landing",
     OST_ISA_AVX2,
     {BIT(23) | BIT(27) | BIT(28), BIT(3) | BIT(5) | BIT(8) | BIT(16) | BIT(26) | BIT(27) | BIT(28), 0, BIT(5),
      1 | XMM | YMM | OPMASK | ZMM_HIGH | HIGH_ZMM}},
    /* has the AVX-512 extensions F (16), DQ (17), CD (28), BW (30) and VL (31) */
    {"Skylake server",
     OST_ISA_AVX512,
     {BIT(23) | BIT(27) | BIT(28), BIT(3) | BIT(5) | BIT(8) | BIT(16) | BIT(17) | BIT(28) | BIT(30) | BIT(31), BIT(11),
      BIT(5), 1 | XMM | YMM | OPMASK | ZMM_HIGH | HIGH_ZMM}},
    {"Ice Lake",
     OST_ISA_AVX512VBMI,
     {BIT(23) | BIT(27) | BIT(28), BIT(3) | BIT(5) | BIT(8) | BIT(16) | BIT(17) | BIT(28) | BIT(30) | BIT(31),
      BIT(1) | BIT(11), BIT(5), 1 | XMM | YMM | OPMASK | ZMM_HIGH | HIGH_ZMM}},
};
enum { MACHINES = sizeof machines / sizeof *machines };

static void levels_of_known_processors(void **state)
{
    (void)state;
    for (int i = 0; i < MACHINES; i++)
        if (ost_isa_decide(&machines[i].cpuid) != machines[i].level)
            fail_msg("%s: the level is %s, expected %s", machines[i].name,
                     ost_isa_name(ost_isa_decide(&machines[i].cpuid)), ost_isa_name(machines[i].level));
}

/*
 * If the system does not save the registers of a level, the level must not be selected, even on a processor that
 * supports it.
 */
static void unsaved_registers(void **state)
{
    (void)state;
    static const struct {
        uint32_t unsaved;
        ost_isa level;
    } systems[] = {
        {0, OST_ISA_AVX512VBMI},     {XMM, OST_ISA_SCALAR},
        {YMM, OST_ISA_SCALAR},       {OPMASK, OST_ISA_AVX2},
        {ZMM_HIGH, OST_ISA_AVX2},    {HIGH_ZMM, OST_ISA_AVX2},
        {YMM | OPMASK, OST_ISA_SCALAR}, {OPMASK | ZMM_HIGH | HIGH_ZMM, OST_ISA_AVX2},
        {UINT32_MAX, OST_ISA_SCALAR},
    };
    for (size_t i = 0; i < sizeof systems / sizeof *systems; i++) {
        ost_isa_cpuid cpuid = machines[MACHINES - 1].cpuid;
        cpuid.xcr0 &= ~systems[i].unsaved;
        assert_int_equal(ost_isa_decide(&cpuid), systems[i].level);
    }
    ost_isa_cpuid no_xsave = machines[MACHINES - 1].cpuid; /* without XSAVE, XCR0 cannot be read */
    no_xsave.leaf1_c &= ~BIT(27);
    assert_int_equal(ost_isa_decide(&no_xsave), OST_ISA_SCALAR);
}

/* Every bit that a level requires is necessary: if it is missing, a lower level is selected. */
static void each_bit_is_required(void **state)
{
    (void)state;
    static const struct {
        size_t offset;
        int bit;
        ost_isa without;
    } needed[] = {
#define NEEDS(field, bit, without) {offsetof(ost_isa_cpuid, field), bit, without}
        NEEDS(leaf1_c, 23, OST_ISA_SCALAR),    NEEDS(leaf1_c, 27, OST_ISA_SCALAR), NEEDS(leaf1_c, 28, OST_ISA_SCALAR),
        NEEDS(extended1_c, 5, OST_ISA_SCALAR), NEEDS(leaf7_b, 3, OST_ISA_SCALAR),  NEEDS(leaf7_b, 5, OST_ISA_SCALAR),
        NEEDS(leaf7_b, 8, OST_ISA_SCALAR),     NEEDS(leaf7_b, 16, OST_ISA_AVX2),   NEEDS(leaf7_b, 17, OST_ISA_AVX2),
        NEEDS(leaf7_b, 28, OST_ISA_AVX2),      NEEDS(leaf7_b, 30, OST_ISA_AVX2),   NEEDS(leaf7_b, 31, OST_ISA_AVX2),
        NEEDS(leaf7_c, 1, OST_ISA_AVX512),
#undef NEEDS
    };
    for (size_t i = 0; i < sizeof needed / sizeof *needed; i++) {
        ost_isa_cpuid cpuid = machines[MACHINES - 1].cpuid;
        *(uint32_t *)(void *)((char *)&cpuid + needed[i].offset) &= ~BIT(needed[i].bit);
        assert_int_equal(ost_isa_decide(&cpuid), needed[i].without);
    }
}

/*
 * The best level and all lower levels of the same architecture are available. Valid names
 * select a level; invalid names return an error status.
 */
static void levels_of_this_machine(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_isa isa;
    unsetenv("OSTEON_ISA");
    printf("# chosen here: %s\n", ost_isa_name(ost_isa_best())); /* .ci/oldcpu reads this line. */
    assert_true(ost_isa_available(OST_ISA_SCALAR));
    assert_true(ost_isa_available(ost_isa_best()));
    assert_false(ost_isa_available(OST_ISA_COUNT));
    assert_false(ost_isa_available(OST_ISA_AVX2) && ost_isa_available(OST_ISA_NEON));
    for (int i = 0; i < OST_ISA_COUNT; i++) {
        const ost_status status = ost_isa_choose(ost_isa_name((ost_isa)i), &isa, &err);
        assert_int_equal(status, ost_isa_available((ost_isa)i) ? OST_OK : OST_ERR_UNAVAILABLE);
        if (status == OST_OK)
            assert_int_equal(isa, i);
    }
    assert_int_equal(ost_isa_choose("avx3", &isa, &err), OST_ERR_USAGE);
    setenv("OSTEON_ISA", "scalar", 1);
    assert_ok(ost_isa_choose(NULL, &isa, &err));
    assert_int_equal(isa, OST_ISA_SCALAR);
    /* An explicit argument takes precedence over the environment. */
    assert_ok(ost_isa_choose(ost_isa_name(ost_isa_best()), &isa, &err));
    assert_int_equal(isa, ost_isa_best());
    setenv("OSTEON_ISA", "avx3", 1);
    assert_int_equal(ost_isa_choose("auto", &isa, &err), OST_ERR_USAGE);
    unsetenv("OSTEON_ISA");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(levels_of_known_processors),
        cmocka_unit_test(unsaved_registers),
        cmocka_unit_test(each_bit_is_required),
        cmocka_unit_test(levels_of_this_machine),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
