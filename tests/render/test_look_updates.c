/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests a surface that changes. New parts of the surface must be highlighted for a time. With every instruction set, an
 * updated block must equal a block that is computed from scratch.
 *
 * Covers: REQ-LOOK
 */
#include "look_bone.h"

static void count_contact(void *user, const int v[3], uint32_t point, uint32_t shade, const ost_surface_block *block)
{
    check *c = user;
    (void)point;
    (void)block;
    const bool hot = shade & OST_SHADE_CONTACT;
    if (c->before)
        assert_int_equal(hot, borders_on_removed_voxel(c, v));
    c->painted += hot;
}

static void new_surface_is_highlighted(void **state)
{
    (void)state;
    ost_error err = {0};
    test_rng rng = rng_seeded("contact");
    ost_volume before, after;
    ost_viewer v;
    make_bone(&rng, &before, &after);
    set_bone(&v, &before, &before);
    ost_viewer_set_contact(&v, true);
    assert_ok(ost_surface_set_volume(&v.bone, &after, 120, &err));
    for (int aged = 0; aged < 3; aged++) {
        assert_ok(ost_surface_update(&v.bone, &err));
        check c = {aged < 2 ? &before : NULL, &after, NULL, 0, 0};
        for_points(&v.bone, count_contact, &c);
        assert_true(aged < 2 ? c.painted > 400 : c.painted == 0);
        ost_surface_age(&v.bone);
        /* While voxels remain highlighted, the lists of their blocks must not be made again. */
        for (int32_t b = 0; b < v.bone.used && aged == 0; b++)
            assert_false(v.bone.slot[b]->dirty);
    }
    ost_viewer_free(&v);
    ost_volume_free(&before);
    ost_volume_free(&after);
}

/* ----------------------------------------------------------- recomputation */

/* Removes a ball of bone, or restores the complete bone. */
static void remove_or_restore_ball(test_rng *rng, const ost_volume *before, ost_volume *now)
{
    const int c[3] = {(int)rng_range(rng, -2, NX), (int)rng_range(rng, -2, NY), (int)rng_range(rng, -2, NZ)},
              r = (int)rng_range(rng, 0, 6);
    const bool back = rng_range(rng, 0, 7) == 0;
    for (int k = c[2] - r; k <= c[2] + r; k++)
        for (int j = c[1] - r; j <= c[1] + r; j++)
            for (int i = c[0] - r; i <= c[0] + r; i++) {
                const int a[3] = {i - c[0], j - c[1], k - c[2]};
                if (i >= 0 && j >= 0 && k >= 0 && i < NX && j < NY && k < NZ &&
                    a[0] * a[0] + a[1] * a[1] + a[2] * a[2] <= r * r)
                    now->voxels[index_of(i, j, k)] = back ? before->voxels[index_of(i, j, k)] : 0;
            }
}

/* With every instruction set, an updated block must equal a block computed from scratch. */
static void updated_blocks_equal_new_blocks(void **state)
{
    (void)state;
    enum { ROUNDS = 40, SLOTS = 64 };
    ost_error err = {0};
    test_rng rng = rng_seeded("updates");
    ost_volume before, now;
    make_bone(&rng, &before, &now);
    for (int isa = 0; isa < OST_ISA_COUNT; isa++) {
        if (!ost_isa_available((ost_isa)isa))
            continue;
        for (int known = 0; known < 2; known++) {
            ost_viewer v[2];
            int looked_at = 0, made = 0, kept = 0;
            memcpy(now.voxels, before.voxels, COUNT * sizeof *now.voxels);
            for (int i = 0; i < 2; i++) {
                set_bone(&v[i], &before, &before);
                if (!known)
                    assert_ok(ost_surface_set_uncut(&v[i].bone, NULL, &err));
                assert_ok(ost_surface_use(&v[i].bone, i ? OST_ISA_SCALAR : (ost_isa)isa, &err));
                ost_viewer_set_contact(&v[i], true);
            }
            for (int round = 0; round < ROUNDS; round++) {
                const int32_t n = (int32_t)rng_range(&rng, -9000, 9000);
                const ost_clip plane = {{n, 8192, 4096},
                                        n * (NX / 2) + 8192 * (NY / 2 + rng_range(&rng, -6, 12)) + 4096 * (NZ / 2)};
                const int what = (int)rng_range(&rng, 0, 11), colour = (int)rng_range(&rng, 0, OST_COLOUR_COUNT - 1);
                uint64_t version[SLOTS] = {0};
                for (int more = (int)rng_range(&rng, 1, 3); more > 0 && what > 1; more--)
                    remove_or_restore_ball(&rng, &before, &now);
                for (int32_t b = 0; b < v[0].bone.used; b++)
                    version[b] = v[0].bone.slot[b]->version;
                for (int i = 0; i < 2; i++) {
                    ost_surface *s = &v[i].bone;
                    if (what == 0)
                        ost_viewer_set_colouring(&v[i], (ost_colouring)colour);
                    else if (what == 1)
                        ost_viewer_set_clip(&v[i], colour ? &plane : NULL);
                    else if (what < 5)
                        ost_surface_age(s);
                    assert_ok(ost_surface_set_volume(s, &now, 120, &err));
                    for (int32_t b = 0; b < s->used; b++)
                        if (i)
                            s->slot[b]->dirty = s->slot[b]->remade = s->slot[b]->unlisted = s->slot[b]
                                                                                                ->unmeasured = true;
                        else
                            looked_at += s->slot[b]->dirty;
                    assert_ok(ost_surface_update(s, &err));
                }
                assert_same_shades(&v[0].bone, &v[1].bone);
                /* `renewed` must contain exactly the blocks whose lists changed. */
                int named = 0;
                for (int32_t b = 0; b < v[0].bone.used; b++)
                    named += v[0].bone.slot[b]->version != version[b];
                assert_int_equal(named, v[0].bone.renewals);
                for (int32_t b = 0; b < v[0].bone.renewals; b++)
                    assert_true(v[0].bone.slot[v[0].bone.renewed[b]]->version != version[v[0].bone.renewed[b]]);
                made += named;
                kept += v[0].bone.used - named;
            }
            assert_true(made > ROUNDS / 2 && kept > ROUNDS / 2 && looked_at >= made);
            /* The result must not depend on how the bone was changed before. */
            ost_viewer fresh;
            set_bone(&fresh, &before, &now);
            if (!known)
                assert_ok(ost_surface_set_uncut(&fresh.bone, NULL, &err));
            ost_viewer_set_colouring(&fresh, (ost_colouring)v[0].bone.colouring);
            ost_viewer_set_clip(&v[0], NULL);
            ost_viewer_set_contact(&v[0], false);
            assert_ok(ost_surface_update(&v[0].bone, &err));
            assert_ok(ost_surface_update(&fresh.bone, &err));
            assert_same_shades(&v[0].bone, &fresh.bone);
            ost_viewer_free(&fresh);
            ost_viewer_free(&v[0]);
            ost_viewer_free(&v[1]);
        }
    }
    ost_volume_free(&before);
    ost_volume_free(&now);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(new_surface_is_highlighted),
        cmocka_unit_test(updated_blocks_equal_new_blocks),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
