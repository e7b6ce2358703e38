/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A case is made from its name and the campaign's seed, and is the same on
 * every machine and with every compiler: what two sites compare is one input.
 * The digests here are what gcc 12 made on x86-64; that clang makes the same is
 * what this test is for (two draws in one list of arguments are made in an
 * order that is the compiler's).
 *
 * The operation's bone is made in floating point (phantom), so it is not held here.
 * Covers: REQ-EVIDENCE
 */
#include "harness.h"

#include "validation/perform.h"

/* SHA-256 over the digests of a family's cases, in hexadecimal. */
static void family_digest(plan_tier tier, const char *only, int most, char out[2 * sizeof(ost_digest) + 1])
{
    ost_error err = {0};
    ost_hasher *h;
    ost_digest all;
    plan p;
    assert_ok(plan_make(tier, 1, 1, 1, only, NULL, &p, &err));
    assert_ok(ost_hasher_open(&h, &err));
    for (int i = 0; i < p.count && i < most; i++) {
        scene s;
        ost_digest one;
        assert_ok(scene_make(&p.cases[i], &s, &err));
        assert_ok(scene_digest(&s, &one, &err));
        assert_ok(ost_hasher_add(h, one.bytes, sizeof one.bytes, &err));
        scene_free(&s);
    }
    assert_ok(ost_hasher_close(h, &all, &err));
    for (size_t i = 0; i < sizeof all.bytes; i++)
        snprintf(out + 2 * i, 3, "%02x", all.bytes[i]);
    plan_free(&p);
}

static void campaigns(void **state)
{
    static const struct {
        plan_tier tier;
        const char *only;
        int most;
        const char *digest;
    } rows[] = {
        {PLAN_SMOKE, "import", 99, "dded1abba364355f68f2db22bf03653548f83c25b0cc14e05a93bda32e61e713"},
        {PLAN_SMOKE, "mesh", 99, "3b78b9d28083f06f99a38d7ebdc6a9b39bbebac1925140e79dea977f3f3f7b34"},
        {PLAN_SMOKE, "poses", 99, "ddf3cd41562f8906f8ce3d939f0060679133a0196593240509f0f1434cea76fe"},
        {PLAN_SMOKE, "sweep", 99, "983c6bce735821b5ccef1411026f4d75eefe8fcf067def7638f18721e86eeef3"},
        {PLAN_SMOKE, "session", 99, "4983bed4604e04d051c4f2296cc4cc6a89223f895b7e2196435c58655f2beaa5"},
        {PLAN_SMOKE, "static/3", 99, "b23b89fd7d827d65c2ebafddffe752e866ab60b37cf80467abac828b5fd63b15"},
        {PLAN_STANDARD, "mesh", 24, "706360335702dcade442e2bd11e07748409c20ac9aab298b7589f7a5199128fa"},
        {PLAN_STANDARD, "poses/1", 2, "93d4f2e0812cd5954127a56ce60e3445f593eef11481c4944f6339f7244ed535"},
    };
    int wrong = 0;
    (void)state;
    for (size_t r = 0; r < sizeof rows / sizeof rows[0]; r++) {
        char got[2 * sizeof(ost_digest) + 1];
        family_digest(rows[r].tier, rows[r].only, rows[r].most, got);
        if (strcmp(got, rows[r].digest) != 0) {
            print_error("tier %s, %s: %s, not %s\n", plan_tier_name(rows[r].tier), rows[r].only, got, rows[r].digest);
            wrong++;
        }
    }
    assert_int_equal(wrong, 0);
}

/* The scenes of the sensitivity proof. */
static void small_scenes(void **state)
{
    static const char *const digests[] = {"b063efb4a0907301", "3d9f44be5f6d3036", "cc8505982f92a250", "9ac3110ddf336aa5",
                                        "5d83af023938c168", "509ab328e1bae95d"};
    int wrong = 0;
    (void)state;
    for (int number = 0; number < (int)(sizeof digests / sizeof digests[0]); number++) {
        const plan_case c = {.family = PLAN_SMALL, .number = number, .seed = 1, .id = {'s', 'm', 'a', 'l', 'l', '/', (char)('0' + number)}};
        ost_error err = {0};
        char got[17];
        ost_digest one;
        scene s;
        assert_ok(scene_make(&c, &s, &err));
        assert_ok(scene_digest(&s, &one, &err));
        for (size_t i = 0; i < 8; i++)
            snprintf(got + 2 * i, 3, "%02x", one.bytes[i]);
        if (strcmp(got, digests[number]) != 0) {
            print_error("%s: %s, not %s\n", c.id, got, digests[number]);
            wrong++;
        }
        scene_free(&s);
    }
    assert_int_equal(wrong, 0);
}

/* So that a change is located in its tick, however thin the voxels that were drawn. */
static void small_bones_are_fetched_whole(void **state)
{
    (void)state;
    for (int number = 170; number < 190; number++) { /* 182: voxels of 32 um in layers of 1 mm */
        plan_case c = {.family = PLAN_SMALL, .number = number, .seed = 1};
        ost_error err = {0};
        ost_map map;
        scene s;
        snprintf(c.id, sizeof c.id, "small/%d", number);
        assert_ok(scene_make(&c, &s, &err));
        const ost_geometry *g = &s.rect;
        const ost_pm n = s.cubic, x = (g->dims.x * g->spacing.x + n - 1) / n, y = (g->dims.y * g->spacing.y + n - 1) / n, z = (g->dims.z * g->spacing.z + n - 1) / n;
        const ost_geometry bone = {{(int32_t)x, (int32_t)y, (int32_t)z}, {n, n, n}, g->origin};
        assert_true(x * y * z <= PERFORM_WHOLE);
        for (size_t i = 0; i < s.path.count; i++) /* and no tick is refused for the tool's voxels */
            assert_ok(ost_map_make(&s.path.ticks[i].pose, &bone, &s.tools[s.path.ticks[i].tool].cutting.grid, &map, &err));
        scene_free(&s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(campaigns),
        cmocka_unit_test(small_scenes),
        cmocka_unit_test(small_bones_are_fetched_whole),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
