/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Compares pairs of hand-written traces. The result must contain the record with the difference, the first
 * word or voxel that differs, and the values of both traces.
 */
#include "harness.h"

#include <unistd.h>

#include "io/scratch_group.h"
#include "validation/compare.h"

enum { SIDE = 40, PATH = 4200 };

static const char *scratch_path(const char *name, char path[PATH])
{
    snprintf(path, PATH, "%s/%s", folder, name);
    return path;
}

typedef struct bone_trace {
    int16_t voxels[SIDE * SIDE * SIDE];
    trace_writer *w;
} bone_trace;

static void put_case(bone_trace *b)
{
    ost_error err = {0};
    trace_begin(b->w, TRACE_CASE, 0, 0);
    assert_ok(trace_end(b->w, &err));
    const int32_t lo[3] = {0, 0, 0};
    trace_begin(b->w, TRACE_CHUNKS, 0, 0);
    trace_word(b->w, 8);
    int16_t *voxels = trace_block(b->w, lo, (ost_dims){SIDE, SIDE, SIDE}, 2);
    assert_non_null(voxels);
    memcpy(voxels, b->voxels, sizeof b->voxels);
    assert_ok(trace_end(b->w, &err));
}

/* Adds a tick to the trace. Word 0 of the tick's report is `word`, and the leaf at lo is stored. */
static void put_tick(bone_trace *b, uint32_t item, uint64_t word, const int32_t lo[3])
{
    ost_error err = {0};
    trace_begin(b->w, TRACE_TICK, 0, item);
    trace_word(b->w, word);
    if (lo) {
        const ost_dims n = {SIDE - lo[0] < 32 ? SIDE - lo[0] : 32, SIDE - lo[1] < 32 ? SIDE - lo[1] : 32,
                            SIDE - lo[2] < 32 ? SIDE - lo[2] : 32};
        int16_t *to = trace_block(b->w, lo, n, 2);
        assert_non_null(to);
        for (int32_t k = 0; k < n.z; k++)
            for (int32_t j = 0; j < n.y; j++)
                memcpy(to + n.x * (j + n.y * k), b->voxels + lo[0] + SIDE * (lo[1] + j + SIDE * (lo[2] + k)),
                       2 * (size_t)n.x);
    }
    assert_ok(trace_end(b->w, &err));
}

static void put_end(bone_trace *b)
{
    ost_error err = {0};
    trace_begin(b->w, TRACE_END, 1, 0);
    assert_ok(trace_end(b->w, &err));
    assert_ok(trace_close(b->w, &err));
}

static int16_t *voxel(bone_trace *b, int x, int y, int z)
{
    return &b->voxels[x + SIDE * (y + SIDE * z)];
}

static void begin(bone_trace *b, const char *path)
{
    ost_error err = {0};
    for (int i = 0; i < SIDE * SIDE * SIDE; i++)
        b->voxels[i] = (int16_t)(i % 1000);
    assert_ok(trace_create(path, &b->w, &err));
    put_case(b);
}

static const int32_t first_leaf[3] = {0, 0, 0}, last_leaf[3] = {32, 32, 32};

static compare_difference compare_files(const char *a, const char *b)
{
    ost_error err = {0};
    trace ref, got;
    compare_difference d;
    assert_ok(trace_open(a, &ref, &err));
    assert_ok(trace_open(b, &got, &err));
    assert_true(ref.complete);
    compare_case(&ref, compare_find(&ref, 0), &got, compare_find(&got, 0), &d);
    trace_free(&ref);
    trace_free(&got);
    return d;
}

/* Writes the reference's trace, in which one voxel is removed at tick 0 and one at tick 1. */
static void write_reference(const char *path)
{
    static bone_trace b;
    begin(&b, path);
    *voxel(&b, 5, 6, 7) = 0;
    put_tick(&b, 0, 1, first_leaf);
    *voxel(&b, 34, 35, 36) = 0;
    put_tick(&b, 1, 1, last_leaf);
    put_end(&b);
}

static void equal_and_different_traces(void **state)
{
    (void)state;
    static bone_trace b;
    char ref[PATH], got[PATH];
    scratch_path("ref", ref);
    scratch_path("got", got);
    write_reference(ref);
    write_reference(got);
    assert_int_equal(compare_files(ref, got).kind, COMPARE_EQUAL);

    /*
     * The trace `got` has two wrong voxels. The comparison must return the voxel with the lowest number in
     * the complete grid, not the first voxel in its leaf.
     */
    begin(&b, got);
    *voxel(&b, 5, 6, 7) = 0;
    *voxel(&b, 9, 9, 9) = -3;
    *voxel(&b, 8, 10, 9) = 4;
    put_tick(&b, 0, 1, first_leaf);
    put_end(&b);
    compare_difference d = compare_files(ref, got);
    assert_int_equal(d.kind, COMPARE_VOXEL);
    assert_int_equal(d.stage, TRACE_TICK);
    assert_int_equal(d.item, 0);
    assert_int_equal(d.voxels, 2);
    assert_int_equal(d.voxel[0], 9);
    assert_int_equal(d.voxel[1], 9);
    assert_int_equal(d.voxel[2], 9);
    assert_int_equal(d.voxel_ref, (9 + SIDE * (9 + SIDE * 9)) % 1000);
    assert_int_equal(d.voxel_got, -3);

    /* In this trace only the report differs. */
    begin(&b, got);
    *voxel(&b, 5, 6, 7) = 0;
    put_tick(&b, 0, 2, first_leaf);
    put_end(&b);
    d = compare_files(ref, got);
    assert_int_equal(d.kind, COMPARE_WORD);
    assert_int_equal(d.word, 0);
    assert_int_equal(d.word_ref, 1);
    assert_int_equal(d.word_got, 2);
}

/*
 * If only one of two traces contains a leaf at a tick, the leaf must be compared with its previous state in
 * the other trace.
 */
static void leaves_in_one_trace_only(void **state)
{
    (void)state;
    static bone_trace b;
    char ref[PATH], got[PATH];
    scratch_path("ref", ref);
    scratch_path("got", got);
    write_reference(ref);

    begin(&b, got); /* in this trace, tick 1 changes no leaf */
    *voxel(&b, 5, 6, 7) = 0;
    put_tick(&b, 0, 1, first_leaf);
    put_tick(&b, 1, 1, NULL);
    put_end(&b);
    compare_difference d = compare_files(ref, got);
    assert_int_equal(d.kind, COMPARE_VOXEL);
    assert_int_equal(d.item, 1);
    assert_int_equal(d.voxels, 1);
    assert_int_equal(d.voxel[0], 34);
    assert_int_equal(d.voxel[1], 35);
    assert_int_equal(d.voxel[2], 36);
    assert_int_equal(d.voxel_ref, 0);
    assert_int_equal(d.voxel_got, (34 + SIDE * (35 + SIDE * 36)) % 1000);

    /*
     * In tick 0, both traces remove a voxel of the first leaf. In tick 1, `got` stores this leaf
     * again, with the value 9 in the removed voxel.
     */
    begin(&b, got);
    *voxel(&b, 5, 6, 7) = 0;
    put_tick(&b, 0, 1, first_leaf);
    *voxel(&b, 5, 6, 7) = 9;
    *voxel(&b, 34, 35, 36) = 0;
    ost_error err = {0};
    trace_begin(b.w, TRACE_TICK, 0, 1);
    trace_word(b.w, 1);
    int16_t *to = trace_block(b.w, first_leaf, (ost_dims){32, 32, 32}, 2);
    for (int k = 0; k < 32; k++)
        for (int j = 0; j < 32; j++)
            memcpy(to + 32 * (j + 32 * k), voxel(&b, 0, j, k), 64);
    to = trace_block(b.w, last_leaf, (ost_dims){8, 8, 8}, 2);
    for (int k = 0; k < 8; k++)
        for (int j = 0; j < 8; j++)
            memcpy(to + 8 * (j + 8 * k), voxel(&b, 32, 32 + j, 32 + k), 16);
    assert_ok(trace_end(b.w, &err));
    put_end(&b);
    d = compare_files(ref, got);
    assert_int_equal(d.kind, COMPARE_VOXEL);
    assert_int_equal(d.voxels, 1);
    assert_int_equal(d.voxel[0], 5);
    assert_int_equal(d.voxel_ref, 0);
    assert_int_equal(d.voxel_got, 9);
}

/*
 * Writes the report of a tick with two chunks of three classes each. The second chunk has
 * `voxels` voxels of class 2.
 */
static void write_report(const char *path, uint64_t voxels)
{
    static bone_trace b;
    ost_error err = {0};
    const uint64_t lines[2][7] = {{4, 1, 130, 0, 0, 2, 1400}, {9, 0, 0, voxels, 900, 0, 0}};
    begin(&b, path);
    trace_begin(b.w, TRACE_TICK, 0, 0);
    for (size_t i = 0; i + 1 < trace_report_head(TRACE_TICK); i++)
        trace_word(b.w, i);
    trace_word(b.w, 2);
    for (int l = 0; l < 2; l++)
        for (int i = 0; i < 7; i++)
            trace_word(b.w, lines[l][i]);
    assert_ok(trace_end(b.w, &err));
    put_end(&b);
}

/* A differing number of a report must be described in words, with the number of its chunk. */
static void differing_numbers_of_reports(void **state)
{
    char ref[PATH], got[PATH], name[TRACE_WORD];
    (void)state;
    write_report(scratch_path("ref", ref), 3);
    write_report(scratch_path("got", got), 4);
    const compare_difference d = compare_files(ref, got);
    assert_int_equal(d.kind, COMPARE_WORD);
    assert_int_equal(d.chunk, 9);
    assert_int_equal(d.word_ref, 3);
    assert_int_equal(d.word_got, 4);
    assert_int_equal(d.line_words, 7);
    assert_string_equal(trace_word_name(d.stage, d.word, d.line_words, name), "voxels of class 2 in a chunk");
    assert_string_equal(trace_word_name(d.stage, d.word + 1, d.line_words, name),
                        "sum of densities of class 2 in a chunk");
    assert_string_equal(trace_word_name(d.stage, d.word - 3, d.line_words, name), "number of a chunk");
    assert_string_equal(trace_word_name(d.stage, 1, d.line_words, name), "removal");
    assert_string_equal(trace_word_name(TRACE_RECT, 20, 0, name), "report word 20");
}


/* Truncated traces and files that are not traces must be refused. */
static void broken_traces_are_refused(void **state)
{
    (void)state;
    char ref[PATH], got[PATH];
    scratch_path("ref", ref);
    scratch_path("got", got);
    write_reference(ref);
    write_reference(got);
    trace complete;
    ost_error err = {0};
    assert_ok(trace_open(ref, &complete, &err));
    const size_t size = complete.size, records = complete.count;
    trace_free(&complete);
    for (size_t cut = size - 1; cut > size - 400; cut -= 13) {
        trace t;
        assert_int_equal(truncate(got, (off_t)cut), 0);
        assert_ok(trace_open(got, &t, &err));
        assert_false(t.complete);
        assert_true(t.count < records);
        trace_free(&t);
    }
    compare_difference d = compare_files(ref, got);
    assert_int_equal(d.kind, COMPARE_MISSING);
    assert_int_equal(d.stage, TRACE_TICK);
    assert_int_equal(d.item, 1);

    /* A change of any byte of a header must not cause a crash: the file is refused, or fewer records are read. */
    write_reference(got);
    for (int at = 0; at < 32; at++) {
        FILE *file = fopen(got, "r+b");
        assert_non_null(file);
        assert_int_equal(fseek(file, at, SEEK_SET), 0);
        const int was = fgetc(file);
        assert_int_equal(fseek(file, at, SEEK_SET), 0);
        fputc(was ^ 0x80, file);
        fclose(file);
        trace t;
        err = (ost_error){0};
        if (trace_open(got, &t, &err) == OST_OK) {
            for (size_t i = 0; i < t.count; i++) {
                size_t walk = 0;
                trace_block_view block;
                while (trace_next_block(&t.records[i], &walk, &block))
                    assert_true(block.voxels + block.voxel_bytes <= t.bytes + t.size);
            }
            trace_free(&t);
        } else
            assert_int_equal(err.status, OST_ERR_INPUT);
        file = fopen(got, "r+b");
        assert_non_null(file);
        assert_int_equal(fseek(file, at, SEEK_SET), 0);
        fputc(was, file);
        fclose(file);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(equal_and_different_traces),
        cmocka_unit_test(leaves_in_one_trace_only),
        cmocka_unit_test(differing_numbers_of_reports),
        cmocka_unit_test(broken_traces_are_refused),
    };
    return cmocka_run_group_tests(tests, scratch_set_up, scratch_tear_down);
}
