/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests every kind of deviation in random scenes, at random positions and rates. The test checks that
 *   - a result differs from the reference if and only if the deviation's record contains a changed result,
 *   - the first difference is at the position that the record states,
 *   - the mistake took effect in the stage of its kind, no later than in the call with the first difference,
 *   - the mistake changes a result of at least one scene. A kind that "never" survives according to the table
 *     must change a result of every scene in which it takes effect.
 * OST_TEST_LONG=1 tests each kind more often; OST_TEST_DEVIATION=name tests only one kind.
 */
#include "validation/dense/difference.h"

static bool never_survives(deviation_kind kind)
{
    return strncmp(deviation_describe(kind)->survives, "never", 5) == 0;
}

static void table_is_complete(void **state)
{
    (void)state;
    assert_true(DEVIATION_KINDS - 1 >= 30);
    for (int k = DEVIATION_NONE + 1; k < DEVIATION_KINDS; k++) {
        const deviation_about *about = deviation_describe((deviation_kind)k);
        for (int other = DEVIATION_NONE + 1; other < k; other++)
            assert_string_not_equal(deviation_describe((deviation_kind)other)->name, about->name);
        assert_true(strlen(about->unit) > 0 && strlen(about->what) > 0 && strlen(about->survives) > 0);
        assert_true(strchr("FTP", about->cause[0]) && strlen(about->cause) > 3);
        assert_string_not_equal(deviation_stage_name(about->stage), "");
    }
    ost_error err = {0};
    ost_backend *backend;
    assert_int_equal(dense_open(&(deviation){.kind = DEVIATION_KINDS}, &backend, &err), OST_ERR_USAGE);
    assert_null(backend);
}

/* The numbers of scenes with each outcome for one kind of mistake. */
typedef struct tally {
    int quiet, survived, changed;
    int harmless; /* scenes in which the mistake was made wherever possible and nothing differed */
} tally;

static void check_position(deviation_kind kind, const deviation_record *r, const difference *f, uint64_t seed)
{
    const deviation_about *about = deviation_describe(kind);
    const deviation_position *p = &r->first_changed, *q = &r->first_acted;
    if (p->stage != f->stage || p->call != f->call || p->leaf != f->leaf || p->chunk != f->chunk ||
        memcmp(p->voxel, f->voxel, sizeof p->voxel) != 0 || r->voxels != f->voxels || r->report != f->report)
        fail_msg("%s, seed %llu: the record states stage %s, call %llu, voxel (%d, %d, %d), leaf %lld, chunk %lld%s%s; "
                 "the first difference is in stage %s, call %llu, voxel (%d, %d, %d), leaf %lld, chunk %lld%s%s",
                 about->name, (unsigned long long)seed, deviation_stage_name(p->stage), (unsigned long long)p->call,
                 p->voxel[0], p->voxel[1], p->voxel[2], (long long)p->leaf, (long long)p->chunk,
                 r->voxels ? " voxels" : "", r->report ? " report" : "", deviation_stage_name(f->stage),
                 (unsigned long long)f->call, f->voxel[0], f->voxel[1], f->voxel[2], (long long)f->leaf,
                 (long long)f->chunk, f->voxels ? " voxels" : "", f->report ? " report" : "");
    assert_true(about->stage == DEVIATION_EVERY || (p->stage == about->stage && q->stage == about->stage));
    assert_true(q->stage < p->stage || (q->stage == p->stage && q->call <= p->call));
}

/* Runs one scene. If `everywhere` is true, the scene has varied densities and the mistake is made wherever possible. */
static void try_once(deviation_kind kind, uint64_t seed, bool everywhere, ost_backend *ref, tally *t)
{
    static const uint32_t rates[] = {1, 1, 1, 2, 20, 4000};
    test_rng rng = {seed};
    ost_error err = {0};
    ost_backend *dense;
    const deviation how = {
        .kind = kind, .seed = rng_next(&rng), .one_in = everywhere ? 1 : rates[rng_range(&rng, 0, 5)]};
    const flavour flavours[] = {VARIED, VARIED, VARIED, UNIFORM, EMPTY};
    scene *s = make_scene(&rng, flavours[everywhere ? 0 : rng_range(&rng, 0, 4)]);
    assert_ok(dense_open(&how, &dense, &err));
    outcome *a = run_scene(s, ref, 0), *b = run_scene(s, dense, 0);
    const difference f = first_difference(s, a, b);
    const deviation_record r = dense_record(dense);
    if (f.any != (r.changed > 0))
        fail_msg("%s, seed %llu, rate one in %u: the record states %llu changed results, but the results %s",
                 deviation_describe(kind)->name, (unsigned long long)seed, how.one_in, (unsigned long long)r.changed,
                 f.any ? "differ" : "are equal");
    if (f.any) {
        assert_true(r.acted > 0);
        check_position(kind, &r, &f, seed);
        t->changed++;
    } else if (r.acted > 0) {
        if (never_survives(kind))
            fail_msg("%s, seed %llu, rate one in %u: the mistake was made but changed no result",
                     deviation_describe(kind)->name, (unsigned long long)seed, how.one_in);
        t->survived++;
    } else {
        t->quiet++;
    }
    t->harmless += !f.any && how.one_in == 1;
    free_outcome(a);
    free_outcome(b);
    free_scene(s);
    ost_backend_close(dense);
}

static void difference_is_at_recorded_position(void **state)
{
    (void)state;
    const char *lengthy = getenv("OST_TEST_LONG"), *only = getenv("OST_TEST_DEVIATION");
    const int rounds = lengthy && strcmp(lengthy, "1") == 0 ? 50 : 1;
    test_rng rng = rng_seeded("deviations");
    ost_error err = {0};
    ost_backend *ref;
    assert_ok(ost_backend_open("ref", &ref, &err));
    for (int k = DEVIATION_NONE + 1; k < DEVIATION_KINDS; k++) {
        tally t = {0};
        if (only && strcmp(only, deviation_describe((deviation_kind)k)->name) != 0)
            continue;
        for (int round = 0; round < rounds || (t.changed == 0 && round < 1000); round++)
            try_once((deviation_kind)k, rng_next(&rng), round >= 8 && t.changed == 0, ref, &t);
        print_message("# %-24s scenes: %3d with changed results, %3d without, %3d in which the mistake was not made; "
                      "%3d without changed results although the mistake was made everywhere\n",
                      deviation_describe((deviation_kind)k)->name, t.changed, t.survived, t.quiet, t.harmless);
        if (t.changed == 0)
            fail_msg("%s changed no result in 1000 scenes", deviation_describe((deviation_kind)k)->name);
    }
    ost_backend_close(ref);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(table_is_complete),
        cmocka_unit_test(difference_is_at_recorded_position),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
