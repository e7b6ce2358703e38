/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests that only regular files and links to them can be opened for reading, and that opening never
 * blocks. The error for an absent file differs from the error for an unreadable one.
 * Covers: REQ-REGULAR-FILES
 */
#include "harness.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include "core/file.h"

static char folder[] = "/tmp/osteon-file-XXXXXX";

static const char *at(const char *name)
{
    static char path[2][256];
    static int turn;
    turn = !turn;
    snprintf(path[turn], sizeof path[turn], "%s/%s", folder, name);
    return path[turn];
}

static void put(const char *name, const char *text)
{
    FILE *f = fopen(at(name), "w");
    assert_non_null(f);
    assert_true(fputs(text, f) >= 0);
    assert_int_equal(fclose(f), 0);
}

static void refused(const char *name, bool absent, const char *words)
{
    ost_file file;
    ost_error err = {0};
    assert_int_equal(ost_file_open(at(name), &file, &err), OST_ERR_IO);
    assert_int_equal(file.fd, -1);
    assert_int_equal(file.absent, absent);
    assert_non_null(strstr(err.text, name));
    assert_non_null(strstr(err.text, words));
}

static void opens_only_regular_files(void **state)
{
    (void)state;
    ost_file file;
    put("plain", "four");
    assert_int_equal(symlink("plain", at("link")), 0);
    assert_int_equal(symlink("loop", at("loop")), 0);
    assert_int_equal(symlink("nowhere", at("dangling")), 0);
    assert_int_equal(symlink("/dev/zero", at("device")), 0);
    assert_int_equal(mkfifo(at("pipe"), 0600), 0);
    assert_int_equal(mkdir(at("inner"), 0700), 0);
    struct sockaddr_un name = {.sun_family = AF_UNIX};
    snprintf(name.sun_path, sizeof name.sun_path, "%s", at("socket"));
    const int listening = socket(AF_UNIX, SOCK_STREAM, 0);
    assert_int_equal(bind(listening, (struct sockaddr *)&name, sizeof name), 0);

    const char *const good[] = {"plain", "link"};
    for (int i = 0; i < 2; i++) {
        assert_int_equal(ost_file_open(at(good[i]), &file, NULL), OST_OK);
        assert_int_equal(file.size, 4);
        assert_int_equal(fcntl(file.fd, F_GETFL) & O_NONBLOCK, 0);
        assert_int_equal(fcntl(file.fd, F_GETFD) & FD_CLOEXEC, FD_CLOEXEC);
        close(file.fd);
    }
    refused("pipe", false, "is a pipe or a device");
    refused("device", false, "is a pipe or a device");
    refused("socket", false, "is a pipe or a device");
    refused("inner", false, "is a folder");
    refused("loop", false, strerror(ELOOP));
    refused("dangling", true, strerror(ENOENT));
    refused("absent", true, strerror(ENOENT));
    refused("plain/below", true, strerror(ENOTDIR));
    close(listening);
}

static void open_within_refuses_links(void **state)
{
    (void)state;
    ost_file file;
    const int inside = open(folder, O_RDONLY | O_DIRECTORY);
    assert_true(inside >= 0);
    assert_int_equal(ost_file_open_within(inside, "plain", &file, NULL), OST_OK);
    close(file.fd);
    assert_int_equal(ost_file_open_within(inside, "link", &file, NULL), OST_ERR_IO);
    assert_false(file.absent);
    assert_int_equal(ost_file_open_within(inside, "absent", &file, NULL), OST_ERR_IO);
    assert_true(file.absent);
    close(inside);
}

/* If no file descriptor is free, the file is reported as unreadable, not as absent. */
static void without_free_descriptors(void **state)
{
    (void)state;
    struct rlimit before, none;
    ost_file file;
    ost_error err = {0};
    assert_int_equal(getrlimit(RLIMIT_NOFILE, &before), 0);
    none = before;
    none.rlim_cur = 3;
    assert_int_equal(setrlimit(RLIMIT_NOFILE, &none), 0);
    const ost_status status = ost_file_open(at("plain"), &file, &err);
    assert_int_equal(setrlimit(RLIMIT_NOFILE, &before), 0);
    assert_int_equal(status, OST_ERR_IO);
    assert_false(file.absent);
    assert_non_null(strstr(err.text, strerror(EMFILE)));
}

static void read_completely(void **state)
{
    (void)state;
    char *bytes;
    size_t size;
    bool absent;
    ost_file file;
    ost_error err = {0};
    assert_int_equal(ost_file_read(at("plain"), 4, &bytes, &size, NULL, NULL), OST_OK);
    assert_int_equal(size, 4);
    assert_string_equal(bytes, "four");
    free(bytes);
    assert_int_equal(ost_file_read(at("plain"), 3, &bytes, &size, &absent, &err), OST_ERR_RANGE);
    assert_null(bytes);
    assert_int_equal(ost_file_read(at("absent"), 3, &bytes, &size, &absent, &err), OST_ERR_IO);
    assert_true(absent);
    put("empty", "");
    assert_int_equal(ost_file_read(at("empty"), 3, &bytes, &size, NULL, &err), OST_OK);
    assert_int_equal(size, 0);
    assert_string_equal(bytes, "");
    free(bytes);

    /* A file whose size changes between opening and reading is reported as an error. */
    char to[16];
    const char *const later[] = {"three or more", "no"};
    for (int i = 0; i < 2; i++) {
        put("plain", "four");
        assert_int_equal(ost_file_open(at("plain"), &file, NULL), OST_OK);
        put("plain", later[i]);
        assert_int_equal(ost_file_fill("plain", &file, to, &err), OST_ERR_IO);
        assert_non_null(strstr(err.text, "file changed while it was read"));
        close(file.fd);
    }
}

/* ost_file_spool copies the bytes of a pipe to a file, which can be read from the start and more than once. The
   number of bytes is limited. */
static void pipe_is_read_as_a_file(void **state)
{
    (void)state;
    int ends[2];
    ost_error err = {0};
    ost_file file;
    char bytes[8];
    char name[32];
    for (int64_t limit = 3; limit <= 4; limit++) {
        assert_int_equal(pipe(ends), 0);
        assert_int_equal(write(ends[1], "four", 4), 4);
        close(ends[1]);
        snprintf(name, sizeof name, "/dev/fd/%d", ends[0]);
        ost_file_spool_max = limit;
        assert_int_equal(ost_file_spool(name, &err), limit < 4 ? OST_ERR_RANGE : OST_OK);
        assert_int_equal(ost_file_is_stream(name), limit == 4);
        close(ends[0]);
    }
    for (int i = 0; i < 2; i++) {
        assert_ok(ost_file_open(name, &file, &err));
        assert_int_equal(file.size, 4);
        assert_ok(ost_file_fill(name, &file, bytes, &err));
        assert_memory_equal(bytes, "four", 4);
        close(file.fd);
    }
    /* ost_file_spool must do nothing if the path is that of a regular file. */
    put("plain", "four");
    assert_ok(ost_file_spool(at("plain"), &err));
    assert_false(ost_file_is_stream(at("plain")));
    assert_int_equal(ost_file_spool("/dev/fd/999", &err), OST_ERR_IO);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(opens_only_regular_files),
        cmocka_unit_test(open_within_refuses_links),
        cmocka_unit_test(without_free_descriptors),
        cmocka_unit_test(read_completely),
        cmocka_unit_test(pipe_is_read_as_a_file),
    };
    char command[128];
    if (!mkdtemp(folder))
        return 99;
    const int failed = cmocka_run_group_tests(tests, NULL, NULL);
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    return system(command) == 0 ? failed : 99;
}
