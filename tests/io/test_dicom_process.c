/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests that the library handles any behaviour of the program osteon-dicom. The program is replaced by
 * shell scripts that crash, hang, send too much, close their output, or send messages that the test has
 * written. After each failure there must be one message with the file's name, and neither a process nor a
 * descriptor may remain.
 *
 * Covers: REQ-DICOM-CHILD
 */
#include "harness.h"

#include <dirent.h>
#include <signal.h>
#include <sys/wait.h>

#include "dicom_records.h"
#include "io/dicom/images.h"
#include "io/dicom/scan.h"
#include "io/dicom/stack.h"
#include "io_scratch.h"

static char *folder, *program;
static ost_error err;

static int begin(void **state)
{
    (void)state;
    folder = scratch_folder();
    program = malloc(4096);
    assert_non_null(program);
    snprintf(program, 4096, "%s/program", folder);
    return 0;
}

static int end(void **state)
{
    (void)state;
    scratch_remove(folder);
    free(program);
    return 0;
}

static void set_program(const char *script)
{
    char text[4096];
    snprintf(text, sizeof text, "#!/bin/sh\n%s\n", script);
    scratch_write(folder, "program", text, strlen(text));
    assert_int_equal(chmod(program, 0700), 0);
}

static int descriptors(void)
{
    int count = 0;
    DIR *dir = opendir("/proc/self/fd");
    assert_non_null(dir);
    while (readdir(dir))
        count++;
    closedir(dir);
    return count;
}

/* Scans the folder with a script in place of osteon-dicom. Fails if a process or a descriptor remains. */
static ost_status scan_with(const char *script, ost_dicom_scan *scan)
{
    const ost_dicom_launch launch = {.program = program, .seconds = 1};
    set_program(script);
    const int before = descriptors();
    err = (ost_error){0};
    const ost_status status = ost_dicom_scan_path(folder, &launch, scan, &err);
    assert_int_equal(descriptors(), before);
    assert_int_equal(waitpid(-1, NULL, WNOHANG), -1);
    return status;
}

static void refused(const char *script, const char *text)
{
    ost_dicom_scan scan;
    const ost_status status = scan_with(script, &scan);
    ost_dicom_scan_free(&scan);
    if (status == OST_OK || !strstr(err.text, text) || !strstr(err.text, folder))
        fail_msg("'%s': expected '%s', got status %d: %s", script, text, (int)status, err.text);
}

static void parser_failures_are_reported(void **state)
{
    (void)state;
    refused("kill -SEGV $$", "the DICOM parser failed on this file (signal 11)");
    refused("exit 0", "the DICOM parser ended early (exit status 0)");
    refused("exit 7", "the DICOM parser ended early (exit status 7)");
    refused("exec sleep 100", "the DICOM parser made no progress for 1 s");
    refused("exec >&-; exec sleep 100", "the DICOM parser closed its output early");
    refused("trap '' TERM INT HUP; while :; do :; done", "the DICOM parser made no progress for 1 s");
    refused("printf 'abc'; exec sleep 100", "the DICOM parser made no progress for 1 s");
    refused("while printf 'nonsense, nonsense, '; do :; done", "invalid message (unknown type)");
    refused("echo secret >&2; ulimit -a >&2; exit 1", "the DICOM parser ended early (exit status 1)");
}

/* Each script checks a limit that the library sets for the process, and ends with SIGUSR1 (signal 10) if the limit
   applies. */
static void process_limits_apply(void **state)
{
    (void)state;
    const char *preload = getenv("LD_PRELOAD");
    if (!preload || !strstr(preload, "vgpreload")) /* the library does not lower the descriptor limit under valgrind */
        refused("[ \"$(ulimit -n)\" = 64 ] && kill -USR1 $$", "signal 10");
    refused("[ \"$(ulimit -f)\" = 0 ] && [ \"$(ulimit -c)\" = 0 ] && kill -USR1 $$", "signal 10");
    /* The limit of CPU time is 3 s: 1 s for the scan and 2 s for the only file. */
    refused("[ \"$(ulimit -t)\" = 3 ] && kill -USR1 $$", "signal 10");
    refused("( : >\"$0.written\" && echo x >\"$0.written\" ) 2>&-; [ -s \"$0.written\" ] || kill -USR1 $$",
            "signal 10");
    refused("[ \"$(ls /proc/self/fd | wc -l)\" -le 4 ] && kill -USR1 $$", "signal 10");
}

/* ----------------------------------------------------------------- messages */

/* Messages for a script. The function send_of writes them to the file .answer, and the script sends this file. */
typedef struct answer {
    unsigned char bytes[1 << 14];
    size_t size;
} answer;

static void put(answer *a, uint32_t type, uint32_t index, uint32_t size, const void *payload)
{
    const ost_dicom_message message = {type, index, size};
    memcpy(a->bytes + a->size, &message, sizeof message);
    a->size += sizeof message;
    if (payload)
        memcpy(a->bytes + a->size, payload, size);
    a->size += payload ? size : 0;
}

static const char *send_of(const answer *a)
{
    (void)scratch_write(folder, ".answer", a->bytes, a->size);
    return "cat \"$(dirname \"$0\")/.answer\"; exec sleep 100";
}

/* The folder has two files, .answer and program, so two results are expected. */
static void refuses_invalid_messages(void **state)
{
    (void)state;
    ost_dicom_scan scan;
    const ost_dicom_record record = record_at("1");
    const uint32_t ok = OST_DICOM_RESULT_OK, foreign = OST_DICOM_RESULT_NOT_DICOM, damaged = OST_DICOM_RESULT_DAMAGED,
                   none = OST_DICOM_RESULT_COUNT;
    answer a = {.size = 0};
    put(&a, OST_DICOM_FRAME, 0, sizeof record, &record);
    put(&a, OST_DICOM_FILE, 0, sizeof ok, &ok);
    put(&a, OST_DICOM_FILE, 1, sizeof foreign, &foreign);
    assert_ok(scan_with(send_of(&a), &scan));
    assert_int_equal(scan.frame_count, 1);
    assert_int_equal(scan.not_dicom, 1);
    assert_int_equal(scan.frames[0].position[2], OST_PM_PER_MM);
    ost_dicom_scan_free(&scan);

    a.size = 0;
    put(&a, OST_DICOM_FILE, 1, sizeof ok, &ok);
    refused(send_of(&a), ".answer: the DICOM parser sent an invalid message (out of order)");
    a.size = 0;
    put(&a, OST_DICOM_FRAME, 0, sizeof record - 1, &record);
    refused(send_of(&a), "invalid message (wrong size)");
    a.size = 0;
    put(&a, OST_DICOM_FRAME, 0, UINT32_MAX, NULL);
    refused(send_of(&a), "invalid message (wrong size)");
    a.size = 0;
    put(&a, OST_DICOM_TYPE_COUNT, 0, 0, NULL);
    refused(send_of(&a), "invalid message (unknown type)");
    a.size = 0;
    put(&a, OST_DICOM_END, 0, 0, NULL);
    refused(send_of(&a), "invalid message (out of order)");
    a.size = 0;
    put(&a, OST_DICOM_PIXELS, 0, 0, NULL);
    refused(send_of(&a), "invalid message (out of order)");
    a.size = 0;
    put(&a, OST_DICOM_FILE, 0, sizeof none, &none);
    refused(send_of(&a), "invalid message (unknown result)");
    a.size = 0;
    put(&a, OST_DICOM_FILE, 0, sizeof damaged, &damaged);
    refused(send_of(&a), ".answer: is a truncated or damaged DICOM file");
    /* The first file has an answer, so the process failed at the second file. */
    a.size = 0;
    put(&a, OST_DICOM_FILE, 0, sizeof ok, &ok);
    refused(send_of(&a), "program: the DICOM parser made no progress for 1 s");
}

/* If the program sends an endless sequence of valid messages, the library must stop at the maximum number of images. */
static void refuses_endless_messages(void **state)
{
    (void)state;
    const ost_dicom_record record = record_at("1");
    answer a = {.size = 0};
    for (int i = 0; i < 8; i++)
        put(&a, OST_DICOM_FRAME, 0, sizeof record, &record);
    (void)send_of(&a);
    refused("f=$(dirname \"$0\")/.answer; while cat $f $f $f $f $f $f $f $f $f $f $f $f $f $f $f $f; do :; done",
            "has image 65537 of the folder; at most 65536 are supported");
}

/* ------------------------------------------------------------------- pixels */

/* Makes a stack of two slices from the files of the folder. */
static void make_stack(ost_dicom_scan *scan, ost_dicom_stack *stack)
{
    ost_dicom_report report;
    const uint32_t ok = OST_DICOM_RESULT_OK;
    answer a = {.size = 0};
    const ost_dicom_record first = record_at("1"), second = record_at("2");
    put(&a, OST_DICOM_FRAME, 0, sizeof first, &first);
    put(&a, OST_DICOM_FILE, 0, sizeof ok, &ok);
    put(&a, OST_DICOM_FRAME, 1, sizeof second, &second);
    put(&a, OST_DICOM_FILE, 1, sizeof ok, &ok);
    assert_ok(scan_with(send_of(&a), scan));
    assert_ok(ost_dicom_stack_make(scan, 0, NULL, stack, &report, &err));
}

/* Reads the pixels of the first slice, which the script sends. */
static ost_status read_with(const ost_dicom_stack *stack, const char *script, uint16_t cells[12])
{
    const ost_dicom_launch launch = {.program = program, .seconds = 1};
    ost_dicom_images images;
    const ost_dicom_frame *frame;
    set_program(script);
    err = (ost_error){0};
    ost_status status = ost_dicom_images_open(stack, &launch, &images, &err);
    if (status == OST_OK)
        status = ost_dicom_images_next(&images, &frame, &err);
    if (status == OST_OK)
        memcpy(cells, images.cells, 12 * sizeof *cells);
    ost_dicom_images_close(&images);
    assert_int_equal(waitpid(-1, NULL, WNOHANG), -1);
    return status;
}

static void reads_pixels(void **state)
{
    (void)state;
    ost_dicom_scan scan;
    ost_dicom_stack stack;
    uint16_t sent[12], got[12];
    const uint32_t damaged = OST_DICOM_RESULT_UNDECODABLE;
    for (uint16_t i = 0; i < 12; i++)
        sent[i] = (uint16_t)(i * 1000);
    make_stack(&scan, &stack);
    answer a = {.size = 0};
    put(&a, OST_DICOM_PIXELS, 0, sizeof sent, sent);
    assert_ok(read_with(&stack, send_of(&a), got));
    assert_memory_equal(got, sent, sizeof sent);
    static const struct {
        uint32_t type, index, size;
        const char *text;
    } cases[] = {
        {OST_DICOM_PIXELS, 1, sizeof sent, "out of order"},
        {OST_DICOM_PIXELS, 0, sizeof sent + 2, "wrong size"},
        {OST_DICOM_PIXELS, 0, sizeof sent - 2, "wrong size"},
        {OST_DICOM_END, 0, 0, "out of order"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        a.size = 0;
        put(&a, cases[i].type, cases[i].index, cases[i].size, NULL);
        assert_int_equal(read_with(&stack, send_of(&a), got), OST_ERR_INPUT);
        if (!strstr(err.text, cases[i].text))
            fail_msg("case %zu: the error '%s' does not contain '%s'", i, err.text, cases[i].text);
    }
    a.size = 0;
    put(&a, OST_DICOM_FILE, 0, sizeof damaged, &damaged);
    assert_int_equal(read_with(&stack, send_of(&a), got), OST_ERR_INPUT);
    assert_non_null(strstr(err.text, "its compressed pixels are damaged"));
    ost_dicom_stack_free(&stack);
    ost_dicom_scan_free(&scan);
}

static void missing_program_is_reported(void **state)
{
    (void)state;
    char path[OST_DICOM_PATH_MAX];
    assert_int_equal(setenv("OSTEON_LIBEXECDIR", folder, 1), 0);
    assert_int_equal(ost_dicom_program("scan", path, &err), OST_ERR_UNAVAILABLE);
    assert_non_null(strstr(err.text, "scan: reading DICOM needs the program osteon-dicom"));
    scratch_write(folder, "osteon-dicom", "#!/bin/sh\n", 10);
    assert_int_equal(ost_dicom_program("scan", path, &err), OST_ERR_UNAVAILABLE); /* the file is not executable */
    snprintf(program, 4096, "%s/osteon-dicom", folder);
    assert_int_equal(chmod(program, 0700), 0);
    assert_ok(ost_dicom_program("scan", path, &err));
    assert_string_equal(path, program);
    assert_int_equal(unsetenv("OSTEON_LIBEXECDIR"), 0);
}

#define TEST(function) cmocka_unit_test_setup_teardown(function, begin, end)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(parser_failures_are_reported),
        TEST(process_limits_apply),
        TEST(refuses_invalid_messages),
        TEST(refuses_endless_messages),
        TEST(reads_pixels),
        TEST(missing_program_is_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
