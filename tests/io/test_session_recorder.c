/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the recorder of sessions: the recorder must never block its caller, and every record that is lost, because the
 * ring buffer or the disk is full, must be reported. The disk of most tests is in memory, and its writes block or fail
 * as a test requires.
 *
 * Covers: REQ-PART-FILES, REQ-RECORDER
 */
#include "session_bytes.h"

#include <errno.h>
#include <pthread.h>
#include <stdatomic.h>

/* A disk in memory. Writes block while `held` is locked, and fail with an errno while `fails` is set. */
typedef struct disk {
    bytes b;
    pthread_mutex_t held;
    _Atomic int fails;
    _Atomic bool half;  /* true if a failing write stores half of its bytes */
    size_t capacity;    /* in bytes; 0 means unlimited */
    _Atomic int appends;
} disk;

static int disk_append(void *user, const void *p, size_t size)
{
    disk *d = user;
    atomic_fetch_add(&d->appends, 1);
    pthread_mutex_lock(&d->held);
    const bool full = d->capacity && d->b.size + size > d->capacity;
    const int error = full ? ENOSPC : atomic_load(&d->fails);
    if (!error)
        bytes_append(&d->b, p, size);
    else if (atomic_load(&d->half))
        bytes_append(&d->b, p, size / 2);
    pthread_mutex_unlock(&d->held);
    return error;
}

static int disk_cut(void *user, uint64_t size)
{
    return bytes_cut(&((disk *)user)->b, size);
}

static ost_recorder *record_on(disk *d, uint32_t capacity)
{
    ost_error err = {0};
    ost_session_header *header = make_header();
    const session_sink sink = {.user = d, .append = disk_append, .cut = disk_cut, .sync = bytes_sync};
    ost_recorder *recorder;
    pthread_mutex_init(&d->held, NULL);
    d->b.size = 0;
    d->fails = 0;
    assert_ok(
        ost_recorder_open_sink("disk", &sink, header, &(ost_recorder_options){.capacity = capacity}, &recorder, &err));
    ost_session_header_free(header);
    return recorder;
}

static void put_ticks(ost_recorder *recorder, uint64_t from, uint64_t to, bool expected)
{
    for (uint64_t n = from; n < to; n++) {
        const ost_record record = tick_record(n);
        assert_int_equal(ost_recorder_put(recorder, &record), expected);
    }
}

static void wait_until_written(ost_recorder *recorder, uint64_t records)
{
    ost_recorder_state state;
    const struct timespec pause = {.tv_nsec = 1000000};
    do {
        nanosleep(&pause, NULL);
        ost_recorder_state_get(recorder, &state);
    } while (state.written < records);
}

/* A symbolic link with the name of the recording must be neither followed nor replaced, even if its target does not
   exist. */
static void recorder_does_not_follow_links(void **state)
{
    (void)state;
    ost_error err = {0};
    char victim[4200], link[4200];
    snprintf(victim, sizeof victim, "%s/victim", folder);
    snprintf(link, sizeof link, "%s/link.session", folder);
    ost_session_header *header = make_header();
    ost_recorder *recorder;
    assert_int_equal(symlink("victim", link), 0);
    for (int there = 0; there < 2; there++) {
        assert_int_equal(ost_recorder_open(link, header, NULL, &recorder, &err), OST_ERR_IO);
        assert_non_null(strstr(err.text, "link.session: is a symbolic link"));
        struct stat st;
        assert_int_equal(stat(victim, &st), there - 1);
        if (there)
            assert_int_equal(st.st_size, 4);
        FILE *out = fopen(victim, "w");
        assert_non_null(out);
        fputs("kept", out);
        fclose(out);
    }
    assert_int_equal(unlink(link) | unlink(victim), 0);
    ost_session_header_free(header);
}

static void recorded_file_is_a_session(void **state)
{
    (void)state;
    ost_error err = {0};
    char path[4200];
    snprintf(path, sizeof path, "%s/r.session", folder);
    ost_session_header *header = make_header();
    ost_recorder *recorder;
    assert_ok(ost_recorder_open(path, header, NULL, &recorder, &err));
    ost_recorder *second;
    assert_int_equal(ost_recorder_open(path, header, NULL, &second, &err), OST_ERR_IO);
    assert_non_null(strstr(err.text, "another recording"));
    put_ticks(recorder, 0, 100, true);
    wait_until_written(recorder, 100);
    /* The file must be readable while it is written. */
    ost_session *session;
    assert_ok(ost_session_open(path, &session, &err));
    assert_int_equal(check_ticks(session), 100);
    assert_false(ost_session_summary_of(session)->ended);
    ost_session_close(session);
    put_ticks(recorder, 100, 10000, true);
    assert_ok(ost_recorder_close(recorder, &(ost_session_end){.ticks = 10000}, &err));
    assert_ok(ost_session_open(path, &session, &err));
    assert_int_equal(check_ticks(session), 10000);
    assert_true(ost_session_summary_of(session)->ended);
    assert_int_equal(ost_session_summary_of(session)->complete_ticks, 10000);
    ost_session_close(session);
    /* An existing file must be replaced completely, even if the new recording is shorter. */
    assert_ok(ost_recorder_open(path, header, NULL, &recorder, &err));
    assert_ok(ost_recorder_close(recorder, NULL, &err));
    assert_ok(ost_session_open(path, &session, &err));
    assert_int_equal(ost_session_summary_of(session)->records, 0);
    ost_session_close(session);
    ost_session_header_free(header);
}

/*
 * The disk does not respond. Records are accepted until the ring buffer is full. After that,
 * ost_recorder_put must fail at once, and every interface must report that records were lost.
 */
static void full_ring_buffer_is_reported(void **state)
{
    (void)state;
    ost_error err = {0};
    static disk d;
    ost_recorder *recorder = record_on(&d, 64);
    pthread_mutex_lock(&d.held);
    const int appends = atomic_load(&d.appends);
    put_ticks(recorder, 0, 1, true);
    /* Waits until the writer thread has removed the first block from the buffer and is blocked in writing it. */
    while (atomic_load(&d.appends) == appends) {
        const struct timespec pause = {.tv_nsec = 1000000};
        nanosleep(&pause, NULL);
    }
    put_ticks(recorder, 1, 65, true);
    put_ticks(recorder, 65, 75, false);
    ost_recorder_state now;
    ost_recorder_state_get(recorder, &now);
    assert_int_equal(now.lost, 10);
    assert_int_equal(now.put, 65);
    pthread_mutex_unlock(&d.held);
    wait_until_written(recorder, 65);
    put_ticks(recorder, 75, 80, true);
    assert_int_equal(ost_recorder_close(recorder, &(ost_session_end){.ticks = 80}, &err), OST_ERR_IO);
    assert_non_null(strstr(err.text, "10 of 81 records were lost"));
    ost_session *session;
    assert_ok(open_bytes(d.b.data, d.b.size, &session, &err));
    const ost_session_summary *sum = ost_session_summary_of(session);
    assert_int_equal(sum->ticks, 70);
    assert_int_equal(sum->complete_ticks, 65);
    assert_int_equal(sum->lost_records, 10);
    assert_int_equal(sum->missing_records, 0);
    assert_true(sum->ended);
    char text[OST_SESSION_MISSING];
    ost_session_missing(session, text);
    assert_non_null(strstr(text, "10 records were lost"));
    assert_non_null(strstr(text, "only the first 65 of the 70 ticks in the file"));
    ost_session_close(session);
}

static void temporarily_full_disk_loses_no_records(void **state)
{
    (void)state;
    ost_error err = {0};
    static disk d;
    ost_recorder *recorder = record_on(&d, 1024);
    put_ticks(recorder, 0, 10, true);
    wait_until_written(recorder, 10);
    atomic_store(&d.half, true);
    atomic_store(&d.fails, ENOSPC);
    put_ticks(recorder, 10, 20, true);
    ost_recorder_state now;
    do {
        const struct timespec pause = {.tv_nsec = 1000000};
        nanosleep(&pause, NULL);
        ost_recorder_state_get(recorder, &now);
    } while (!now.failing);
    assert_string_equal(now.reason, "the disk is full");
    assert_int_equal(now.written, 10);
    put_ticks(recorder, 20, 30, true);
    atomic_store(&d.fails, 0);
    wait_until_written(recorder, 30);
    assert_ok(ost_recorder_close(recorder, &(ost_session_end){.ticks = 30}, &err));
    ost_session *session;
    assert_ok(open_bytes(d.b.data, d.b.size, &session, &err));
    assert_int_equal(check_ticks(session), 30);
    char text[OST_SESSION_MISSING];
    assert_string_equal(ost_session_missing(session, text), "");
    ost_session_close(session);
}

/* The disk has too little space for the waiting records. The recorder must write as many of them as possible, beginning
   with the first record. */
static void nearly_full_disk_stores_the_first_records(void **state)
{
    (void)state;
    ost_error err = {0};
    static disk d;
    ost_recorder *recorder = record_on(&d, 1024);
    pthread_mutex_lock(&d.held);
    put_ticks(recorder, 0, 400, true);
    d.capacity = d.b.size + 20 * 64 + 200 * 128;
    pthread_mutex_unlock(&d.held);
    assert_int_equal(ost_recorder_close(recorder, NULL, &err), OST_ERR_IO);
    assert_non_null(strstr(err.text, "the disk is full"));
    ost_session *session;
    assert_ok(open_bytes(d.b.data, d.b.size, &session, &err));
    const ost_session_summary *sum = ost_session_summary_of(session);
    assert_in_range(sum->complete_ticks, 190, 210);
    ost_session_close(session);
}

static void permanently_full_disk_is_an_error_on_close(void **state)
{
    (void)state;
    ost_error err = {0};
    static disk d;
    ost_recorder *recorder = record_on(&d, 64);
    put_ticks(recorder, 0, 10, true);
    wait_until_written(recorder, 10);
    atomic_store(&d.fails, ENOSPC);
    put_ticks(recorder, 10, 20, true);
    assert_int_equal(ost_recorder_close(recorder, NULL, &err), OST_ERR_IO);
    assert_non_null(strstr(err.text, "the disk is full; 10 records are in the file, 10 are not"));
    ost_session *session;
    assert_ok(open_bytes(d.b.data, d.b.size, &session, &err));
    assert_int_equal(ost_session_summary_of(session)->complete_ticks, 10);
    ost_session_close(session);

    ost_session_header *header = make_header();
    if (access("/dev/full", W_OK) == 0) {
        assert_int_equal(ost_recorder_open("/dev/full", header, NULL, &recorder, &err), OST_ERR_IO);
        assert_non_null(strstr(err.text, "/dev/full: cannot start the recording: the disk is full"));
    }
    assert_int_equal(ost_recorder_open("/nowhere/x.session", header, NULL, &recorder, &err), OST_ERR_IO);
    assert_int_equal(ost_recorder_open("x", header, &(ost_recorder_options){.capacity = 3}, &recorder, &err),
                     OST_ERR_USAGE);
    ost_session_header_free(header);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(recorder_does_not_follow_links),
        cmocka_unit_test(recorded_file_is_a_session),
        cmocka_unit_test(full_ring_buffer_is_reported),
        cmocka_unit_test(temporarily_full_disk_loses_no_records),
        cmocka_unit_test(nearly_full_disk_stores_the_first_records),
        cmocka_unit_test(permanently_full_disk_is_an_error_on_close),
    };
    return cmocka_run_group_tests(tests, scratch_set_up, scratch_tear_down);
}
