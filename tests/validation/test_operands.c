/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the operands that are reported for a voxel: they must lead to the value of the voxel in the reference's grid,
 * and for a removed voxel they must show why it is removed.
 *
 * Covers: REQ-LOCATE
 */
#include "small_trace.h"

#include "validation/locate/finding.h"
#include "validation/locate/grids.h"

static const char *value_of(const operands *o, const char *name)
{
    const char *last = NULL;
    for (int i = 0; i < o->count; i++)
        if (strcmp(o->lines[i].name, name) == 0)
            last = o->lines[i].value;
    return last;
}

/* For randomly chosen voxels, the last operand must equal the value in the reference's grid. */
static void operands_give_voxel_value(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("operands_give_voxel_value");
    int solid = 0, removed = 0, kept = 0;
    for (int number = 0; number < SCENES; number++) {
        scene s;
        trace ref;
        traced_small(number, 11, &s, &ref);
        const compare_range all = compare_find(&ref, 0);
        for (size_t i = 0; i < all.count; i++) {
            const trace_record *r = &ref.records[all.first + i];
            size_t walk = 0;
            trace_block_view b;
            if (r->stage == TRACE_CASE || r->stage == TRACE_FINAL || r->stage == TRACE_UPLOAD ||
                r->stage == TRACE_RECT || !trace_next_block(r, &walk, &b))
                continue;
            for (int k = 0; k < 40; k++) {
                const size_t v = (size_t)(rng_next(&rng) % (uint64_t)ost_dims_count(b.dims)), wide = (size_t)b.dims.x,
                             high = (size_t)b.dims.y;
                int16_t is = b.voxels[v];
                if (b.voxel_bytes == 2)
                    memcpy(&is, b.voxels + 2 * v, 2);
                compare_difference d = {.kind = COMPARE_VOXEL, .stage = r->stage, .item = r->item};
                d.voxel[0] = b.lo[0] + (int32_t)(v % wide);
                d.voxel[1] = b.lo[1] + (int32_t)(v / wide % high);
                d.voxel[2] = b.lo[2] + (int32_t)(v / wide / high);
                operands o;
                operands_of(&s, &ref, all, &d, NULL, &o);
                assert_true(o.count > 0);
                const char *text;
                char expected[64];
                if (r->stage == TRACE_CUBIC || r->stage == TRACE_RESAMPLE) {
                    const bool mean = value_of(&o, "mean");
                    snprintf(expected, sizeof expected, mean ? ": %d" : ") has %d", is);
                    text = value_of(&o, mean ? "mean" : "source");
                    assert_non_null(text);
                    assert_string_equal(text + strlen(text) - strlen(expected), expected);
                } else if (r->stage == TRACE_CHUNKS) {
                    assert_non_null(strstr(value_of(&o, "threshold"), is ? "stored as it is" : "stored as 0"));
                } else if (r->stage == TRACE_TOOL) {
                    const char *cut = value_of(&o, "cutting"), *not = value_of(&o, "not cutting");
                    const bool cuts = strcmp(cut + strlen(cut) - 5, "solid") == 0,
                               touches = not &&strcmp(not +strlen(not ) - 5, "solid") == 0;
                    assert_int_equal(is, cuts ? OST_TOOL_CUTTING : touches ? OST_TOOL_NONCUTTING : OST_TOOL_VOID);
                    solid += is != 0;
                } else if (r->stage == TRACE_TICK && value_of(&o, "decided")) {
                    const bool hit = strstr(value_of(&o, "decided"), "removed");
                    if (hit)
                        assert_int_equal(is, 0);
                    removed += hit;
                    kept += !hit;
                }
            }
        }
        trace_free(&ref);
        scene_free(&s);
    }
    assert_true(solid > 10 && removed > 10 && kept > 10);
}

/* For every voxel that an event removes, the operands must show why it is removed. */
static void removal_operands(void **state)
{
    (void)state;
    const plan_case c = {.family = PLAN_SMALL, .number = 2, .seed = 5, .id = "small/2"};
    ost_backend *backend;
    ost_error err = {0};
    scene s;
    trace ref, got;
    grids g;
    int shown = 0;
    assert_ok(scene_make(&c, &s, &err));
    assert_ok(ost_backend_open("ref", &backend, &err));
    traced(backend, &s, "ref", &ref);
    assert_ok(ost_backend_open("ref", &backend, &err));
    traced(backend, &s, "got", &got);
    const compare_range all = compare_find(&ref, 0);
    for (size_t i = 0; i < all.count; i++) {
        if (ref.records[all.first + i].stage != TRACE_TICK)
            continue;
        assert_true(grids_at(&s, &ref, all, &got, all, i, &g));
        const int64_t n = ost_dims_count(g.dims);
        for (int64_t v = 0; v < n; v += 7) {
            if (g.before[v] == 0)
                continue;
            compare_difference d = {
                .kind = COMPARE_VOXEL, .stage = TRACE_TICK, .item = ref.records[all.first + i].item};
            d.voxel[0] = (int32_t)(v % g.dims.x);
            d.voxel[1] = (int32_t)(v / g.dims.x % g.dims.y);
            d.voxel[2] = (int32_t)(v / g.dims.x / g.dims.y);
            operands o;
            if (g.ref[v] != 0 && shown++ % 50)
                continue;
            operands_of(&s, &ref, all, &d, g.before, &o);
            const char *decided = value_of(&o, "decided");
            assert_int_equal(decided && strstr(decided, "it is removed"), g.ref[v] == 0);
        }
        grids_free(&g);
    }
    trace_free(&ref);
    trace_free(&got);
    scene_free(&s);
    assert_true(shown > 100);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(operands_give_voxel_value),
        cmocka_unit_test(removal_operands),
    };
    return cmocka_run_group_tests(tests, scratch_set_up, scratch_tear_down);
}
