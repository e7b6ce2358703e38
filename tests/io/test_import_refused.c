/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests files that the import refuses, and files that it accepts only with an option, such as texts that give a voxel
 * twice or contain positions off the lattice. Another test cancels an import.
 *
 * Covers: AR-CT-4, AR-CT-5, AR-CT-6, AR-CT-8
 */
#include "import_bone.h"

#include <fcntl.h>
#include <unistd.h>

/* ------------------------------------------------- duplicates, offsets, sparse texts */

static void duplicates_follow_the_option(void **state)
{
    (void)state;
    static const char text[] =
        "# osteon spacing_mm: 1 1 1\n0 0 0 200\n1 0 0 300\n0 0 0 200\n0 0 0 150\n0 0 0 900\n0 0 0 600\n";
    static const int expected[] = {0, 200, 600, 900};
    static const char *const names[] = {"", "first", "last", "max"};
    const char *path = scratch_write(folder, "double.txt", text, sizeof text - 1);
    for (int rule = OST_DUPLICATES_ERROR; rule <= OST_DUPLICATES_MAX; rule++) {
        ost_error err = {0};
        ost_bone *bone;
        ost_import_result result;
        ost_status status =
            ost_import(backend, path, &(ost_import_options){.duplicates = (ost_duplicates)rule}, &bone, &result, &err);
        if (rule == OST_DUPLICATES_ERROR) {
            assert_int_equal(status, OST_ERR_INPUT);
            assert_null(bone);
            assert_non_null(strstr(err.text,
                                   "double.txt:5: density 150 at (0, 0, 0), where an earlier line has 200; choose one "
                                   "with 'osteon import --duplicates first', 'last' or 'max'"));
            continue;
        }
        assert_int_equal(status, OST_OK);
        int16_t voxels[2];
        assert_ok(ost_bone_download(bone, 0, 1, voxels, &err));
        assert_int_equal(voxels[0], expected[rule]);
        assert_int_equal(voxels[1], 300);
        assert_int_equal(result.scatter.duplicates, 4);
        assert_string_equal(ost_meta_get(&result.meta, "duplicates"), names[rule]);
        ost_bone_free(bone);
    }
}

static void positions_off_the_lattice(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_import_result result;
    const ost_import_options options = {.spacing = {1000000000, 1000000000, 1000000000}};
    static const char warned[] = "0 0 0 1\n1.2 0 0 2\n2 0.13 0 3\n3 0 0 4\n";
    assert_ok(import(scratch_write(folder, "warned.txt", warned, sizeof warned - 1), &options, &result, &err));
    assert_int_equal(result.scatter.off_lattice, 2);
    assert_int_equal(result.scatter.worst_line, 2);
    assert_int_equal(result.scatter.worst_offset_ppm, 200000);
    static const char refused[] = "0 0 0 1\n1 0 0 2\n\n2 1.376 0 3\n3 0 0 4\n";
    assert_int_equal(import(scratch_write(folder, "refused.txt", refused, sizeof refused - 1), &options, &result, &err),
                     OST_ERR_INPUT);
    assert_non_null(
        strstr(err.text,
               "refused.txt:4: y = 1.376 lies 0.376 voxels off the lattice of 1 mm from 0 mm; expected at most 3/8"));
}

/* A text of a few samples that are far apart must be refused before memory for the grid between them is allocated. */
static void sparse_texts_are_refused(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_import_result result;
    const ost_import_options options = {.spacing = {1000000, 1000000, 1000000}};
    static const char sparse[] = "0 0 0 1\n1 1 1 2\n";
    static const char enormous[] = "0 0 0 1\n100 100 100 2\n";
    assert_int_equal(import(scratch_write(folder, "sparse.txt", sparse, sizeof sparse - 1), &options, &result, &err),
                     OST_ERR_INPUT);
    assert_non_null(
        strstr(err.text, "sparse.txt: 2 samples span 1001 x 1001 x 1001 voxels, of which all but one in 501501500"));
    assert_int_equal(import(scratch_write(folder, "big.txt", enormous, sizeof enormous - 1), &options, &result, &err),
                     OST_ERR_RANGE);
    assert_non_null(strstr(err.text, "big.txt"));
    assert_non_null(strstr(err.text, "100001 voxels along x"));
}

/* ------------------------------------------ progress, cancellation, changed files */

typedef struct watcher {
    const char *path;        /* file that is changed at the start of the second pass */
    const char *cancel;      /* stage at which the import is cancelled */
    double last_share;
    int calls;
} watcher;

static bool watch(void *user, const char *stage, double share)
{
    watcher *w = user;
    assert_true(share >= 0 && share <= 1);
    w->calls++;
    w->last_share = share;
    if (w->path && strcmp(stage, "rect") == 0) {
        int fd = open(w->path, O_WRONLY);
        assert_true(fd >= 0);
        assert_int_equal(pwrite(fd, "9", 1, 6), 1);
        close(fd);
        w->path = NULL;
    }
    return !w->cancel || strcmp(stage, w->cancel) != 0;
}

static void progress_function_can_cancel(void **state)
{
    (void)state;
    static const char text[] = "0 0 0 1\n1 1 1 2\n";
    static const char *const stages[] = {"samples", "rect", "cubic", "chunks"};
    const char *path = scratch_write(folder, "watched.txt", text, sizeof text - 1);
    for (int s = 0; s < 5; s++) {
        ost_error err = {0};
        ost_import_result result;
        watcher w = {.cancel = s < 4 ? stages[s] : NULL};
        ost_status status = import(path, &(ost_import_options){.progress = watch, .progress_user = &w}, &result, &err);
        assert_int_equal(status, s < 4 ? OST_ERR_CANCELLED : OST_OK);
        assert_true(w.calls > 0);
        if (s == 4)
            assert_true(w.last_share == 1);
    }
}

static void change_between_the_passes_is_detected(void **state)
{
    (void)state;
    static const char text[] = "0 0 0 1\n1 1 1 2\n";
    ost_error err = {0};
    ost_import_result result;
    watcher w = {.path = scratch_write(folder, "change.txt", text, sizeof text - 1)};
    ost_status status = import(w.path, &(ost_import_options){.progress = watch, .progress_user = &w}, &result, &err);
    assert_int_equal(status, OST_ERR_INPUT);
    assert_non_null(strstr(err.text, "file changed while it was read"));
}

/* -------------------------------------------------------- files that are refused */

static void other_files_are_refused(void **state)
{
    (void)state;
    static const struct {
        const char *name, *content, *message;
        ost_status status;
    } cases[] = {
        {"mesh.stl", "solid x\nfacet normal 0 0 1\nendsolid\n", "is a mesh, not a CT", OST_ERR_INPUT},
        {"path.csv", "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n0,0,0,0,1,0,0,0\n", "is a tool's path, not a CT", OST_ERR_INPUT},
        {"what.bin", "\x01\x02\x03", "not a CT", OST_ERR_INPUT},
        {"page.html", "<html>\n", "not a CT", OST_ERR_INPUT},
        {"tool.txt", "# osteon kind: tool\n0 0 0 1\n1 1 1 1\n", "is a tool grid; expected a bone or a CT",
         OST_ERR_INPUT},
        {"bone.txt", "# osteon kind: bone\n# osteon threshold: 0\n0 0 0 1\n1 1 1 1\n", "threshold '0'", OST_ERR_INPUT},
        {"layer.txt", "0 0 5 1\n1 1 5 2\n", "all samples lie in one layer, z = 5", OST_ERR_INPUT},
        {"twice.txt", "# osteon dims: 2 1 1\n# osteon spacing_mm: 1 1 1\n0 0 0 7\n0 0 0 7\n# osteon dims: 2 1 1\n",
         "the declared dims are 2 voxels along x, but its positions make 1", OST_ERR_INPUT},
        {"twice.txt", "# osteon dims: 2 2 1\n# osteon spacing_mm: 1 1 1\n0 0 0 7\n1 1 0 7\n1 0 0 7\n1 0 0 7\n",
         "twice.txt:1: this line declares one sample per voxel, but 1 samples repeat a voxel", OST_ERR_INPUT},
        {"dims.txt", "# osteon dims: 1 2 1\n0 0 0 1\n1 1 1 2\n", "the declared dims are 1 voxels along x",
         OST_ERR_INPUT},
        {"origin.txt", "# osteon origin_mm: 0.5 0 0\n0 0 0 1\n1 1 1 2\n",
         "origin.txt:1: the declared origin is x = 0.5", OST_ERR_INPUT},
    };
    ost_error err = {0};
    ost_import_result result;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const char *path = scratch_write(folder, cases[i].name, cases[i].content, strlen(cases[i].content));
        ost_status status = import(path, NULL, &result, &err);
        if (status != cases[i].status || !strstr(err.text, cases[i].message) || !strstr(err.text, cases[i].name))
            fail_msg("%s: %s '%s', expected '%s'", cases[i].name, ost_status_name(status), err.text, cases[i].message);
    }
    /* makes osteon search for osteon-dicom in a folder that lacks it */
    assert_int_equal(setenv("OSTEON_LIBEXECDIR", folder, 1), 0);
    assert_int_equal(import(folder, NULL, &result, &err), OST_ERR_UNAVAILABLE);
    assert_non_null(strstr(err.text, "reading DICOM needs the program osteon-dicom"));
    assert_int_equal(unsetenv("OSTEON_LIBEXECDIR"), 0);
    assert_int_equal(import(in_folder("absent.txt"), NULL, &result, &err), OST_ERR_IO);
    assert_non_null(strstr(err.text, "absent.txt: cannot open: No such file"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(duplicates_follow_the_option),
        cmocka_unit_test(positions_off_the_lattice),
        cmocka_unit_test(sparse_texts_are_refused),
        cmocka_unit_test(progress_function_can_cancel),
        cmocka_unit_test(change_between_the_passes_is_detected),
        cmocka_unit_test(other_files_are_refused),
    };
    return run_on_backends(tests, set_up, tear_down);
}
