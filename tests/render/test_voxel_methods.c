/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the measurements of bench/voxel_methods.h. Measured counts are compared with the voxels of the grids, and
 * measured values with each other. A measurement of removal must leave the model unchanged. The times themselves are
 * not tested.
 *
 * OST_TEST_LONG=1 prints the values of Tables 3.7 and 3.8 and Figures 3.13 to 3.15 for all models; OST_TEST_SCALE sets
 * the scale of the models (default: 1).
 * Covers: REQ-VOXEL-METHODS
 */
#include "bench/voxel_model.h"
#include "harness.h"

/* The models of the thesis (Fig. 1.4). */
static const ost_phantom_kind kinds[5] = {OST_PHANTOM_SCAPULA, OST_PHANTOM_GLENOID, OST_PHANTOM_TRABECULAR,
                                          OST_PHANTOM_TRABECULAR2, OST_PHANTOM_FOAM};

static const bench_options options = {.backend = "cpu", .threads = 2, .quick = true};

static bench_voxel_model *open_model(const bench_options *how, ost_phantom_kind kind, double scale)
{
    ost_error err = {0};
    bench_voxel_model *m;
    assert_ok(bench_voxel_open(how, kind, scale, &m, &err));
    return m;
}

static bool active(const ost_volume *v, int x, int y, int z)
{
    const ost_dims d = v->geometry.dims;
    return x >= 0 && y >= 0 && z >= 0 && x < d.x && y < d.y && z < d.z &&
           v->voxels[x + (size_t)d.x * ((size_t)y + (size_t)d.y * (size_t)z)] >= 120;
}

/* Counts the voxels, surface voxels, visible faces and chunks of a volume one by one, and compares the counts with
   those of the measured grid. */
static void check_counts(const ost_volume *v, const bench_voxel_grid *g)
{
    const ost_dims d = v->geometry.dims;
    int64_t voxels = 0, surface = 0, faces = 0, chunks = 0;
    for (int z = 0; z < d.z; z += 32)
        for (int y = 0; y < d.y; y += 32)
            for (int x = 0; x < d.x; x += 32) {
                bool any = false;
                for (int i = 0; i < 32 * 32 * 32; i++) {
                    const int at[3] = {x + i % 32, y + i / 32 % 32, z + i / 1024};
                    if (!active(v, at[0], at[1], at[2]))
                        continue;
                    const int visible = !active(v, at[0] - 1, at[1], at[2]) + !active(v, at[0] + 1, at[1], at[2]) +
                                        !active(v, at[0], at[1] - 1, at[2]) + !active(v, at[0], at[1] + 1, at[2]) +
                                        !active(v, at[0], at[1], at[2] - 1) + !active(v, at[0], at[1], at[2] + 1);
                    any = true;
                    voxels++;
                    surface += visible > 0;
                    faces += visible;
                }
                chunks += any;
            }
    assert_int_equal(g->voxels, (int64_t)d.x * d.y * d.z);
    assert_int_equal(g->chunks, (int64_t)((d.x + 31) / 32) * ((d.y + 31) / 32) * ((d.z + 31) / 32));
    assert_int_equal(g->active_voxels, voxels);
    assert_int_equal(g->surface_voxels, surface);
    assert_int_equal(g->faces, faces);
    assert_int_equal(g->active_chunks, chunks);
    assert_int_equal(g->voxel_bytes, 65536 * chunks);
    assert_int_equal(g->mesh_bytes, 16 * faces);
    assert_int_equal(g->look_bytes, 4 * faces);
    assert_int_equal(g->point_bytes, 8 * surface);
}

static void test_memory(void **state)
{
    (void)state;
    ost_error err = {0};
    bench_voxel_counts counts;
    for (int i = 0; i < 5; i++) {
        bench_voxel_model *m = open_model(&options, kinds[i], i > 2 ? 0.5 : 1);
        assert_ok(bench_voxel_memory(m, &counts, &err));
        check_counts(&m->cubic, &counts.cubic);
        check_counts(&m->rect, &counts.rect);
        assert_int_equal(bench_voxel_chunks(m), counts.cubic.active_chunks);
        bench_voxel_close(m);
    }
    bench_voxel_model *none;
    assert_int_equal(bench_voxel_open(&options, OST_PHANTOM_SCAPULA, 1.5, &none, &err), OST_ERR_USAGE);
    assert_null(none);
}

static void test_stages(void **state)
{
    (void)state;
    static const char *const specs[] = {"ref", "cpu:threads=2", "cl"};
    ost_error err = {0};
    bench_voxel_counts counts;
    bench_voxel_model *m = open_model(&options, OST_PHANTOM_SCAPULA, 1);
    assert_ok(bench_voxel_memory(m, &counts, &err));
    for (int i = 0; i < 6; i++) {
        bench_voxel_stages s;
        assert_ok(bench_voxel_mesh(m, specs[i / 2], i % 2, 3, &s, &err));
        if (*s.reason) {
            printf("# %s: %s\n", specs[i / 2], s.reason);
            assert_true(i / 2 == 2);
            continue;
        }
        double sum = 0;
        for (int k = 0; k < BENCH_VOXEL_STAGES; k++) {
            assert_int_equal(s.stage[k].count, 3);
            assert_true(s.stage[k].min >= 0 && s.stage[k].min <= s.stage[k].median &&
                        s.stage[k].median <= s.stage[k].max);
            sum += s.stage[k].min;
        }
        assert_true(s.total.min >= 0.999 * sum && s.total.min > 0 && s.elapsed.min > 0);
        assert_int_equal(s.at_a_time, i % 2 ? 1 : s.chunks);
        assert_true(s.faces_per_chunk * s.chunks == (double)counts.cubic.faces);
        assert_true(s.device[0]);
    }
    bench_voxel_stages s;
    assert_int_equal(bench_voxel_mesh(m, "no-such", false, 3, &s, &err), OST_ERR_USAGE);
    assert_int_equal(bench_voxel_mesh(m, "ref", false, 0, &s, &err), OST_ERR_USAGE);
    bench_voxel_close(m);
}

static void test_frames(void **state)
{
    (void)state;
    ost_error err = {0};
    bench_voxel_model *m = open_model(&options, OST_PHANTOM_SCAPULA, 1);
    const int32_t all = bench_voxel_chunks(m), counts[3] = {1, all / 2, all}, wrong[1] = {all + 1};
    for (int i = 0; i < BENCH_VOXEL_METHODS; i++) {
        bench_voxel_frames f;
        assert_ok(bench_voxel_idle(m, (bench_voxel_method)i, counts, 3, 2, &f, &err));
        if (*f.reason) {
            printf("# %s\n", f.reason);
            assert_int_equal(f.count, 0);
            continue;
        }
        assert_int_equal(f.count, 3);
        for (int k = 0; k < 3; k++) {
            assert_int_equal(f.frame[k].chunks, counts[k]);
            assert_int_equal(f.frame[k].ms.count, 2);
            assert_true(f.frame[k].ms.min > 0 && (k == 0 || f.frame[k].vertices > f.frame[k - 1].vertices));
        }
        if (i == BENCH_VOXEL_THESIS)
            assert_int_equal(f.frame[2].vertices, 32768 * (int64_t)all);
        bench_voxel_frames_free(&f);
        assert_int_equal(bench_voxel_idle(m, (bench_voxel_method)i, wrong, 1, 2, &f, &err), OST_ERR_USAGE);
        bench_voxel_frames_free(&f);
    }
    bench_voxel_close(m);
}

static void test_removal(void **state)
{
    (void)state;
    ost_error err = {0};
    bench_voxel_counts before, after;
    bench_voxel_model *m = open_model(&options, OST_PHANTOM_SCAPULA, 1);
    assert_ok(bench_voxel_memory(m, &before, &err));
    for (int i = 0; i < BENCH_VOXEL_METHODS; i++) {
        bench_voxel_cut c;
        assert_ok(bench_voxel_removal(m, (bench_voxel_method)i, "cpu", 6, &c, &err));
        assert_ok(bench_voxel_memory(m, &after, &err));
        assert_memory_equal(&before.cubic, &after.cubic, sizeof before.cubic);
        if (*c.reason) {
            printf("# %s\n", c.reason);
            continue;
        }
        assert_int_equal(c.ms.count, 6);
        assert_true(c.changed_chunks > 0);
        assert_true(i == BENCH_VOXEL_MESH ? c.meshed_chunks >= c.changed_chunks && c.mesh_ms > 0
                                          : c.meshed_chunks <= 0);
        assert_true(c.uploaded > 0);
    }
    bench_voxel_close(m);
}

/* ------------------------------------------------------------------ figures */

static void print_model(ost_phantom_kind kind, double scale)
{
    enum { POINTS = 4, REPEAT = 5, FRAMES = 20 };
    static const char *const specs[] = {"ref", "cpu:threads=1", "cpu", "cl"};
    bench_options full = options;
    ost_error err = {0};
    bench_voxel_counts c;
    full.quick = false;
    bench_voxel_model *m = open_model(&full, kind, scale);
    assert_ok(bench_voxel_memory(m, &c, &err));
    for (int i = 0; i < 2; i++) {
        const bench_voxel_grid *g = i ? &c.cubic : &c.rect;
        printf("# %s %s: %lld of %lld chunks active, %.2f MB of voxels, %.2f MB of vertices, %.2f MB of looks, %.2f MB "
               "of points, active:inactive %.3f, %lld faces\n",
               ost_phantom_name(kind), i ? "cubic" : "rect", (long long)g->active_chunks, (long long)g->chunks,
               (double)g->voxel_bytes / 1e6, (double)g->mesh_bytes / 1e6, (double)g->look_bytes / 1e6,
               (double)g->point_bytes / 1e6,
               (double)g->active_voxels / (double)(g->active_chunks * 32768 - g->active_voxels), (long long)g->faces);
    }
    for (int i = 0; i < 8; i++) {
        bench_voxel_stages s;
        assert_ok(bench_voxel_mesh(m, specs[i / 2], i % 2, REPEAT, &s, &err));
        if (*s.reason)
            continue;
        printf("# %s %-13s %4d at a time, least us per chunk:", ost_phantom_name(kind), specs[i / 2], (int)s.at_a_time);
        for (int k = 0; k < BENCH_VOXEL_STAGES; k++)
            printf(" %s %.2f,", bench_voxel_stage_name((bench_voxel_stage)k), s.stage[k].min);
        printf(" sum %.2f, elapsed %.2f; %.0f faces\n", s.total.min, s.elapsed.min, s.faces_per_chunk);
        fflush(stdout);
    }
    static const char *const methods[BENCH_VOXEL_METHODS] = {"mesh", "thesis", "gl"};
    const int32_t all = bench_voxel_chunks(m), counts[POINTS] = {1, (all + 3) / 4, (all + 1) / 2, all};
    for (int i = 0; i < BENCH_VOXEL_METHODS; i++) {
        bench_voxel_frames f;
        bench_voxel_cut cut;
        assert_ok(bench_voxel_idle(m, (bench_voxel_method)i, counts, POINTS, REPEAT, &f, &err));
        printf("# %s %s, idle, chunks: least ms:", ost_phantom_name(kind), methods[i]);
        for (int k = 0; k < f.count; k++)
            printf(" %d: %.2f", (int)f.frame[k].chunks, f.frame[k].ms.min);
        assert_ok(bench_voxel_removal(m, (bench_voxel_method)i, "cpu", FRAMES, &cut, &err));
        printf("; removal: least frame %.2f ms, idle %.2f ms, %.1f chunks changed, %.1f meshed in %.3f ms, copied in "
               "%.3f ms, lists %.2f ms%s\n",
               cut.ms.min, cut.idle_ms.min, cut.changed_chunks, cut.meshed_chunks, cut.mesh_ms, cut.copy_ms,
               cut.update_ms, cut.reason);
        fflush(stdout);
        bench_voxel_frames_free(&f);
    }
    bench_voxel_close(m);
}

static void test_figures(void **state)
{
    (void)state;
    const char *scale = getenv("OST_TEST_SCALE"), *only = getenv("OST_TEST_ONLY");
    if (!getenv("OST_TEST_LONG"))
        skip();
    for (int i = 0; i < 5; i++)
        if (!only || strcmp(only, ost_phantom_name(kinds[i])) == 0)
            print_model(kinds[i], scale ? strtod(scale, NULL) : 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_memory), cmocka_unit_test(test_stages),
                                       cmocka_unit_test(test_frames), cmocka_unit_test(test_removal),
                                       cmocka_unit_test(test_figures)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
