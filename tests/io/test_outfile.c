/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests that an output file exists under its name either completely or not at all. The tests cover
 * names, links, permissions, full disks, limits, and kills at random moments.
 * Covers: REQ-PART-FILES
 */
#include "harness.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "io/outfile.h"
#include "io_scratch.h"

static void write_text(const char *path, const char *text)
{
    ost_error err = {0};
    ost_outfile *out;
    assert_ok(ost_outfile_open(path, &out, &err));
    assert_ok(ost_outfile_write(out, text, strlen(text), &err));
    assert_ok(ost_outfile_commit(out, &err));
}

static void assert_content(const char *path, const char *text)
{
    char *content = scratch_read(path, NULL);
    assert_string_equal(content, text);
    free(content);
}

/* Runs a check with each of the two ways in which temporary files are named. */
static void run_with_both_namings(void (*check)(const char *folder))
{
    for (int named = 0; named < 2; named++) {
        char *folder = scratch_folder();
        ost_outfile_named_only = named;
        check(folder);
        ost_outfile_named_only = false;
        scratch_remove(folder);
    }
}

static void appears_only_at_commit(const char *folder)
{
    ost_error err = {0};
    ost_outfile *out;
    char path[512];
    snprintf(path, sizeof path, "%s/a.txt", folder);
    assert_ok(ost_outfile_open(path, &out, &err));
    assert_ok(ost_outfile_write(out, "one ", 4, &err));
    assert_ok(ost_outfile_printf(out, &err, "%s %d", "two", 3));
    assert_int_equal(access(path, F_OK), -1);
    assert_ok(ost_outfile_commit(out, &err));
    assert_content(path, "one two 3");
    assert_int_equal(scratch_count(folder), 1);

    write_text(path, "replaced");
    assert_content(path, "replaced");
    assert_int_equal(scratch_count(folder), 1);

    assert_ok(ost_outfile_open(path, &out, &err));
    assert_ok(ost_outfile_write(out, "never", 5, &err));
    ost_outfile_discard(out);
    assert_content(path, "replaced");
    assert_int_equal(scratch_count(folder), 1);
}

static void test_appears_only_at_commit(void **state)
{
    (void)state;
    run_with_both_namings(appears_only_at_commit);
}

static void large_and_small_pieces(const char *folder)
{
    ost_error err = {0};
    ost_outfile *out;
    char path[512];
    size_t total = 0, size = 1 << 20;
    unsigned char *bytes = malloc(size);
    assert_non_null(bytes);
    for (size_t i = 0; i < size; i++)
        bytes[i] = (unsigned char)(i * 7 >> 3);
    snprintf(path, sizeof path, "%s/pieces", folder);
    assert_ok(ost_outfile_open(path, &out, &err));
    for (size_t piece = 1; total < size; piece = piece * 3 + 1) {
        size_t n = piece < size - total ? piece : size - total;
        assert_ok(ost_outfile_write(out, bytes + total, n, &err));
        total += n;
    }
    assert_ok(ost_outfile_commit(out, &err));
    size_t got;
    char *content = scratch_read(path, &got);
    assert_int_equal(got, size);
    assert_memory_equal(content, bytes, size);
    free(content);
    free(bytes);
}

static void test_large_and_small_pieces(void **state)
{
    (void)state;
    run_with_both_namings(large_and_small_pieces);
}

static void permissions_and_links(const char *folder)
{
    char path[512], link[512], dangling[512];
    struct stat st;
    snprintf(path, sizeof path, "%s/target", folder);
    snprintf(link, sizeof link, "%s/link", folder);
    snprintf(dangling, sizeof dangling, "%s/dangling", folder);
    mode_t old = umask(027);
    write_text(path, "x");
    umask(old);
    assert_int_equal(stat(path, &st), 0);
    assert_int_equal(st.st_mode & 0777, 0640);

    assert_int_equal(symlink("target", link), 0);
    write_text(link, "through the link");
    assert_int_equal(lstat(link, &st), 0);
    assert_true(S_ISLNK(st.st_mode));
    assert_content(path, "through the link");

    ost_error err = {0};
    ost_outfile *out;
    assert_int_equal(symlink("nowhere", dangling), 0);
    assert_int_equal(ost_outfile_open(dangling, &out, &err), OST_ERR_IO);
    assert_non_null(strstr(err.text, "dangling symbolic link"));
}

static void test_permissions_and_links(void **state)
{
    (void)state;
    run_with_both_namings(permissions_and_links);
}

static void folders_are_refused(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_outfile *out;
    char *folder = scratch_folder(), path[512];
    assert_int_equal(ost_outfile_open(folder, &out, &err), OST_ERR_IO);
    assert_null(out);
    assert_non_null(strstr(err.text, "is a folder"));
    snprintf(path, sizeof path, "%s/new/", folder);
    assert_int_equal(ost_outfile_open(path, &out, &err), OST_ERR_IO);
    snprintf(path, sizeof path, "%s/absent/x", folder);
    assert_int_equal(ost_outfile_open(path, &out, &err), OST_ERR_IO);
    assert_non_null(strstr(err.text, "cannot open the folder"));
    assert_int_equal(ost_outfile_open("", &out, &err), OST_ERR_USAGE);
    scratch_remove(folder);
}

static void devices_are_written_in_place(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_outfile *out;
    write_text("/dev/null", "gone");
    assert_int_equal(access("/dev/null", F_OK), 0);

    struct stat st;
    assert_int_equal(stat("/dev/null", &st), 0);
    assert_true(S_ISCHR(st.st_mode));

    if (access("/dev/full", W_OK) == 0) {
        char bytes[100000] = {0};
        assert_ok(ost_outfile_open("/dev/full", &out, &err));
        assert_int_equal(ost_outfile_write(out, bytes, sizeof bytes, &err), OST_ERR_IO);
        assert_string_equal(err.text, "/dev/full: write failed after 0 bytes: the disk is full");
        assert_int_equal(ost_outfile_commit(out, &err), OST_ERR_IO);
        assert_non_null(strstr(err.text, "the disk is full"));
    }
}

/* A limit on the file size simulates a full disk: a write fails after a part of the data. */
static void file_size_limit_leaves_no_file(const char *folder)
{
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        ost_error err = {0};
        ost_outfile *out;
        char path[512], bytes[50000] = {0};
        snprintf(path, sizeof path, "%s/limited", folder);
        signal(SIGXFSZ, SIG_IGN);
        setrlimit(RLIMIT_FSIZE, &(struct rlimit){120000, 120000});
        if (ost_outfile_open(path, &out, &err) != OST_OK)
            _exit(1);
        ost_status status = OST_OK;
        for (int i = 0; i < 10 && status == OST_OK; i++)
            status = ost_outfile_write(out, bytes, sizeof bytes, &err);
        if (status != OST_ERR_IO || !strstr(err.text, "after 120000 bytes: the limit of a file's size"))
            _exit(2);
        if (ost_outfile_commit(out, &err) != OST_ERR_IO)
            _exit(3);
        _exit(0);
    }
    int ended;
    assert_int_equal(waitpid(child, &ended, 0), child);
    assert_int_equal(ended, 0);
    assert_int_equal(scratch_count(folder), 0);
}

static void test_file_size_limit_leaves_no_file(void **state)
{
    (void)state;
    run_with_both_namings(file_size_limit_leaves_no_file);
}

static void new_file_does_not_replace_a_file(const char *folder)
{
    ost_error err = {0};
    char path[512], link[512];
    bool taken = true;
    snprintf(path, sizeof path, "%s/new", folder);
    snprintf(link, sizeof link, "%s/link", folder);
    assert_ok(ost_outfile_put_new(path, "one", 3, &taken, &err));
    assert_false(taken);
    assert_content(path, "one");
    assert_int_equal(ost_outfile_put_new(path, "two", 3, &taken, &err), OST_ERR_IO);
    assert_true(taken);
    assert_content(path, "one");
    /* A symbolic link occupies the name even if the link's target does not exist. */
    assert_int_equal(symlink("nowhere", link), 0);
    assert_int_equal(ost_outfile_put_new(link, "two", 3, &taken, &err), OST_ERR_IO);
    assert_true(taken);
    assert_int_equal(scratch_count(folder), 2);
    assert_int_equal(unlink(link), 0);
    snprintf(link, sizeof link, "%s/absent/new", folder);
    assert_int_equal(ost_outfile_put_new(link, "two", 3, &taken, &err), OST_ERR_IO);
    assert_false(taken);
}

static void test_new_file_does_not_replace_a_file(void **state)
{
    (void)state;
    run_with_both_namings(new_file_does_not_replace_a_file);
}

/*
 * The test makes symbolic links under all temporary names that can be derived from a process id and a number. These
 * links must have no effect.
 */
static void temporary_names_cannot_be_guessed(void **state)
{
    (void)state;
    enum { LINKS = 1200 };
    char *folder = scratch_folder(), path[512];
    for (int i = 0; i < LINKS; i++) {
        snprintf(path, sizeof path, "%s/.osteon-%ld-%d.part", folder, (long)getpid(), i);
        assert_int_equal(symlink("victim", path), 0);
    }
    snprintf(path, sizeof path, "%s/out", folder);
    ost_outfile_named_only = true;
    write_text(path, "written");
    ost_outfile_named_only = false;
    assert_content(path, "written");
    assert_int_equal(scratch_count(folder), LINKS + 1);
    scratch_remove(folder);
}

static void on_term(int number)
{
    ost_outfile_unlink_pending();
    _exit(128 + number);
}

static void write_forever(const char *path)
{
    char bytes[4096];
    memset(bytes, 'x', sizeof bytes);
    for (;;) {
        ost_error err = {0};
        ost_outfile *out;
        if (ost_outfile_open(path, &out, &err) != OST_OK)
            _exit(1);
        for (int i = 0; i < 64; i++)
            if (ost_outfile_write(out, bytes, sizeof bytes, &err) != OST_OK)
                _exit(2);
        if (ost_outfile_commit(out, &err) != OST_OK)
            _exit(3);
    }
}

/* A child process writes a file of the same name repeatedly. At any moment the file must be absent or complete. */
static void killed_writer_leaves_no_partial_file(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("killed_writer_leaves_no_partial_file");
    static const int signals[] = {SIGKILL, SIGTERM};
    for (int round = 0; round < 40; round++) {
        /* the pointer is static, so that the memory is reachable in a killed child and valgrind reports no leak */
        static char *folder;
        char path[512];
        folder = scratch_folder();
        bool named = round & 1;
        int number = signals[round >> 1 & 1];
        snprintf(path, sizeof path, "%s/out", folder);
        pid_t child = fork();
        assert_true(child >= 0);
        if (child == 0) {
            ost_outfile_named_only = named;
            signal(SIGTERM, on_term);
            write_forever(path);
        }
        usleep((useconds_t)rng_range(&rng, 0, 20000));
        assert_int_equal(kill(child, number), 0);
        int ended;
        assert_int_equal(waitpid(child, &ended, 0), child);
        if (number == SIGKILL || WIFSIGNALED(ended))
            assert_true(WIFSIGNALED(ended) && WTERMSIG(ended) == number);
        else
            assert_true(WIFEXITED(ended) && WEXITSTATUS(ended) == 128 + SIGTERM);
        struct stat st;
        bool there = stat(path, &st) == 0;
        if (there)
            assert_int_equal(st.st_size, 64 * 4096);
        /*
         * After SIGTERM no hidden file may remain. If the signal arrives before its handler is
         * installed, no file exists yet.
         */
        if (number == SIGTERM)
            assert_int_equal(scratch_count(folder), there);
        scratch_remove(folder);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_appears_only_at_commit),
        cmocka_unit_test(test_large_and_small_pieces),
        cmocka_unit_test(test_permissions_and_links),
        cmocka_unit_test(folders_are_refused),
        cmocka_unit_test(devices_are_written_in_place),
        cmocka_unit_test(test_file_size_limit_leaves_no_file),
        cmocka_unit_test(test_new_file_does_not_replace_a_file),
        cmocka_unit_test(temporary_names_cannot_be_guessed),
        cmocka_unit_test(killed_writer_leaves_no_partial_file),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
