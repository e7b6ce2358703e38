/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests session files: records must be read back as written, damaged bytes must be handled,
 * and the recorder must never block its caller.
 *
 * Every byte of a session is damaged in turn, and the file is truncated at every length. The
 * positions of the blocks determine which records must remain.
 * Covers: REQ-PART-FILES, REQ-SESSION-FILE, REQ-RECORDER
 */
#include "harness.h"

#include <errno.h>
#include <pthread.h>
#include <stdatomic.h>
#include <sys/mman.h>

#include "io/scratch_group.h"
#include "io/session/recorder.h"
#include "io/session/reader.h"

/* ------------------------------------------------------- sessions in memory */

typedef struct bytes {
    unsigned char data[1 << 16];
    size_t size;
} bytes;

static int bytes_append(void *user, const void *p, size_t size)
{
    bytes *b = user;
    assert_true(b->size + size <= sizeof b->data);
    memcpy(b->data + b->size, p, size);
    b->size += size;
    return 0;
}

static int bytes_cut(void *user, uint64_t size)
{
    ((bytes *)user)->size = size;
    return 0;
}

static int bytes_sync(void *user)
{
    (void)user;
    return 0;
}

/* Returns a tick in which every field is set. Some of the values depend on the number of the tick. */
static ost_record tick_record(uint64_t number)
{
    const int n = (int)number;
    return (ost_record){
        .kind = OST_RECORD_TICK,
        .as.tick = {.number = number,
                    .tick = {.t_ns = -5 + (int64_t)number * 1000000,
                             .tool = n % 3,
                             .rpm = n - 1,
                             .pose = {.t = {-1 - n, INT64_C(7999999999999), n},
                                      .qw = OST_Q30_ONE,
                                      .qx = -n,
                                      .qy = n + 1,
                                      .qz = INT32_MIN + n},
                             .lifted = n % 2 == 0},
                    .flags = OST_TICK_REMOVAL | OST_TICK_DECLARED,
                    .buttons = 0x80000001u,
                    .digest = UINT64_C(0xfedcba9876543210) + number,
                    .removed = 4000000000u,
                    .touched = 7,
                    .poses = 4096,
                    .fault = 3,
                    .force_un = {INT32_MIN, 0, INT32_MAX},
                    .torque_unm = {1, -2, 3},
                    .wake_ns = 11,
                    .exec_ns = 12,
                    .missed = 13},
    };
}

enum { BLOCKS = 4 };
static const uint32_t block_records[BLOCKS] = {3, 1, 5, 2};

/* The bytes of a session and the offsets of its blocks: two blocks of the header, BLOCKS blocks of records, and the
   end. */
typedef struct sample {
    bytes b;
    size_t begin[BLOCKS + 3];
    uint64_t first[BLOCKS + 1]; /* first tick of each block of records */
} sample;

static ost_session_header *make_header(void)
{
    ost_error err = {0};
    ost_session_header *header;
    assert_ok(ost_session_header_create(&header, &err));
    assert_ok(ost_session_header_set(header, "bone", "a\\b\nc\x7f\xc3\xa9.nrrd", &err));
    assert_ok(ost_session_header_set(header, "config.sweep", "off", &err));
    assert_ok(ost_session_header_set(header, "config.sweep", "on", &err));
    assert_ok(ost_session_header_set(header, "empty", "", &err));
    return header;
}

/* Makes a session in memory. The last record of its last block is the end record. */
static void make_sample(sample *s)
{
    ost_error err = {0};
    ost_session_header *header = make_header();
    unsigned char *payload;
    uint32_t size;
    assert_ok(ost_session_header_encode(header, &payload, &size, &err));
    ost_session_header_free(header);
    s->b.size = 0;
    session_writer writer = {.sink = {.user = &s->b, .append = bytes_append, .cut = bytes_cut, .sync = bytes_sync}};
    assert_int_equal(ost_session_write_header(&writer, payload, size), 0);
    free(payload);
    s->begin[0] = 0;
    s->begin[1] = s->b.size / 2;
    uint64_t number = 0;
    for (int i = 0; i < BLOCKS; i++) {
        unsigned char block[SESSION_BLOCK + 8 * SESSION_RECORD];
        s->begin[2 + i] = s->b.size;
        s->first[i] = number;
        for (uint32_t k = 0; k < block_records[i]; k++) {
            const ost_record end = {
                .kind = OST_RECORD_END,
                .as.end = {.ticks = number, .removals = 2, .removed_voxels = 3, .has_root = true, .root = {{9}}}};
            const ost_record tick = tick_record(number);
            const bool last = i == BLOCKS - 1 && k == block_records[i] - 1;
            ost_session_record_encode(last ? &end : &tick, block + SESSION_BLOCK + k * SESSION_RECORD);
            number += !last;
        }
        assert_int_equal(ost_session_write_records(&writer, block + SESSION_BLOCK, block_records[i], 0), 0);
    }
    s->begin[2 + BLOCKS] = s->b.size;
    s->first[BLOCKS] = number;
}

static ost_status open_bytes(const unsigned char *data, size_t size, ost_session **out, ost_error *err)
{
    /* The file is in memory, because some file systems take milliseconds to rewrite a file. */
    static int fd = -1;
    char path[40];
    if (fd < 0)
        fd = memfd_create("session", MFD_CLOEXEC);
    assert_true(fd >= 0);
    assert_int_equal(ftruncate(fd, 0), 0);
    assert_int_equal(pwrite(fd, data, size, 0), (ssize_t)size);
    snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
    return ost_session_open(path, out, err);
}

/* Checks that all ticks of the session are unchanged. Returns their number. */
static uint64_t check_ticks(ost_session *session)
{
    ost_error err = {0};
    ost_record record;
    bool more;
    uint64_t count = 0;
    ost_session_rewind(session);
    for (;;) {
        assert_ok(ost_session_next(session, &record, &more, &err));
        if (!more)
            return count;
        if (record.kind != OST_RECORD_TICK)
            continue;
        const ost_record expected = tick_record(record.as.tick.number);
        unsigned char a[SESSION_RECORD], b[SESSION_RECORD];
        ost_session_record_encode(&record, a);
        ost_session_record_encode(&expected, b);
        assert_memory_equal(a, b, SESSION_RECORD);
        count++;
    }
}

static void written_records_are_read(void **state)
{
    (void)state;
    ost_error err = {0};
    static sample s;
    make_sample(&s);
    ost_session *session;
    assert_ok(open_bytes(s.b.data, s.b.size, &session, &err));
    const ost_session_header *header = ost_session_header_of(session);
    assert_string_equal(ost_session_header_get(header, "bone"), "a\\b\nc\x7f\xc3\xa9.nrrd");
    assert_string_equal(ost_session_header_get(header, "config.sweep"), "on");
    assert_string_equal(ost_session_header_get(header, "empty"), "");
    assert_null(ost_session_header_get(header, "bon"));
    assert_int_equal(ost_session_header_count(header), 3);
    assert_int_equal(check_ticks(session), 10);
    const ost_session_summary *sum = ost_session_summary_of(session);
    assert_true(sum->ended && !sum->header_damaged);
    assert_int_equal(sum->ticks, 10);
    assert_int_equal(sum->complete_ticks, 10);
    assert_int_equal(sum->records, 11);
    assert_int_equal(sum->first_t_ns, -5);
    assert_int_equal(sum->last_t_ns, 8999995);
    char text[OST_SESSION_MISSING];
    assert_string_equal(ost_session_missing(session, text), "");
    ost_path path;
    assert_ok(ost_session_path(session, &path, &err));
    assert_int_equal(path.count, 10);
    assert_int_equal(path.ticks[9].pose.qx, -9);
    assert_true(path.ticks[8].lifted && !path.ticks[9].lifted);
    assert_int_equal(path.ticks[0].rpm, OST_RPM_ON);
    assert_int_equal(path.ticks[1].rpm, 0);
    assert_int_equal(path.ticks[9].rpm, 8);
    ost_path_free(&path);
    ost_session_close(session);
}

/* In version 1, every block contains the version number 1, and in every tick the two bytes for the motor are 0. */
static void version_1_is_read(void **state)
{
    (void)state;
    ost_error err = {0};
    static sample s;
    make_sample(&s);
    for (int b = 0; b < 2 + BLOCKS; b++) {
        unsigned char *own = s.b.data + s.begin[b];
        const uint32_t size = get32(own + 12);
        for (uint32_t at = 0; b >= 2 && at < size; at += SESSION_RECORD)
            if (get16(own + SESSION_BLOCK + at) == OST_RECORD_TICK)
                put16(own + SESSION_BLOCK + at + 90, 0);
        put32(own + 36, ost_session_crc(own + SESSION_BLOCK, size));
        put32(own + 44, 1);
        put32(own + 60, ost_session_crc(own, 60));
    }
    ost_session *session;
    ost_path path;
    assert_ok(open_bytes(s.b.data, s.b.size, &session, &err));
    assert_string_equal(ost_session_missing(session, (char[OST_SESSION_MISSING]){0}), "");
    assert_ok(ost_session_path(session, &path, &err));
    assert_int_equal(path.count, 10);
    for (size_t i = 0; i < path.count; i++)
        assert_int_equal(path.ticks[i].rpm, OST_RPM_ON);
    ost_path_free(&path);
    ost_session_close(session);
}

/* The expected bytes of a tick were written by hand from docs/spec/session.md. The layout must not change. */
static void bytes_are_as_documented(void **state)
{
    (void)state;
    const ost_record record = tick_record(258);
    unsigned char r[SESSION_RECORD];
    ost_session_record_encode(&record, r);
    static const unsigned char first[24] = {1, 0, 3, 0, 25,   0,    0,    0,    2, 1, 0, 0,
                                            0, 0, 0, 0, 0x7b, 0xc4, 0x60, 0x0f, 0, 0, 0, 0};
    assert_memory_equal(r, first, sizeof first);
    /* 7,999,999,999,999 is 0x746a5287fff */
    static const unsigned char pose_y[8] = {0xff, 0x7f, 0x28, 0xa5, 0x46, 0x07, 0, 0};
    assert_memory_equal(r + 32, pose_y, 8);
    assert_int_equal(r[51], 0x40);  /* qw = 2^30 */
    assert_int_equal(r[63], 0x80);  /* qz */
    assert_int_equal(r[71], 0x80);  /* buttons */
    assert_int_equal(r[89], 0x10);  /* poses = 4096 */
    assert_int_equal(r[95], 0x80);  /* force x */
    assert_int_equal(r[124], 13);
    static sample s;
    make_sample(&s);
    assert_memory_equal(s.b.data, "\x89OSTSES\n\1\0\0\0", 12);
    /* CRC-32 of "123456789" must be 0xcbf43926, the standard check value. */
    assert_int_equal(ost_session_crc("123456789", 9), 0xcbf43926);
}

static void damaged_byte_loses_one_block(void **state)
{
    (void)state;
    ost_error err = {0};
    static sample s;
    make_sample(&s);
    for (size_t at = 0; at < s.b.size; at++)
        for (int bit = 0; bit < 8; bit += 7) {
            s.b.data[at] ^= (unsigned char)(1 << bit);
            int hit = 0;
            while (at >= s.begin[hit + 1])
                hit++;
            ost_session *session;
            assert_ok(open_bytes(s.b.data, s.b.size, &session, &err));
            const ost_session_summary *sum = ost_session_summary_of(session);
            const uint64_t all = s.first[BLOCKS];
            assert_int_equal(sum->header_damaged, hit < 2);
            if (hit < 2) {
                assert_int_equal(sum->ticks, all);
                assert_int_equal(sum->complete_ticks, all);
            } else {
                const int block = hit - 2;
                assert_int_equal(sum->ticks, all - (s.first[block + 1] - s.first[block]));
                assert_int_equal(sum->complete_ticks, s.first[block]);
                assert_int_equal(sum->ended, block != BLOCKS - 1);
                assert_int_equal(sum->missing_records, block == BLOCKS - 1 ? 0 : block_records[block]);
            }
            assert_int_equal(sum->damaged_bytes + sum->cut_bytes, s.begin[hit + 1] - s.begin[hit]);
            assert_int_equal(check_ticks(session), sum->ticks);
            char text[OST_SESSION_MISSING];
            assert_true(strlen(ost_session_missing(session, text)) > 0);
            ost_session_close(session);
            s.b.data[at] ^= (unsigned char)(1 << bit);
        }
}

static void truncated_session_keeps_complete_blocks(void **state)
{
    (void)state;
    static sample s;
    make_sample(&s);
    for (size_t size = 0; size <= s.b.size; size++) {
        ost_error err = {0};
        ost_session *session;
        const ost_status status = open_bytes(s.b.data, size, &session, &err);
        if (size < s.begin[1]) {
            assert_int_equal(status, OST_ERR_INPUT);
            assert_null(session);
            continue;
        }
        assert_int_equal(status, OST_OK);
        int complete = 0;
        while (complete + 1 < BLOCKS + 3 && size >= s.begin[complete + 1])
            complete++;
        const ost_session_summary *sum = ost_session_summary_of(session);
        assert_int_equal(sum->cut_bytes, size - s.begin[complete]);
        assert_int_equal(sum->damaged_bytes, 0);
        assert_int_equal(sum->ticks, complete < 2 ? 0 : s.first[complete - 2]);
        assert_int_equal(sum->complete_ticks, sum->ticks);
        assert_int_equal(sum->ended, size == s.b.size);
        assert_int_equal(sum->header_damaged, complete < 2);
        assert_int_equal(check_ticks(session), sum->ticks);
        ost_session_close(session);
    }
}

/*
 * The test inserts, removes or repeats bytes, exchanges blocks, and appends blocks of another session. The
 * reader must never return more records than were written, and must not change their order.
 */
static void random_changes_add_no_records(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("random_changes_add_no_records");
    static sample s;
    static unsigned char data[1 << 17];
    make_sample(&s);
    for (int round = 0; round < 3000; round++) {
        size_t size = s.b.size;
        memcpy(data, s.b.data, size);
        for (int64_t k = rng_range(&rng, 0, 3); k >= 0; k--) {
            const size_t at = (size_t)rng_range(&rng, 0, (int64_t)size - 1), n = 1 + (size_t)rng_range(&rng, 0, 399);
            const size_t take = n < size - at ? n : size - at;
            switch (rng_range(&rng, 0, 3)) {
            case 0: /* remove bytes */
                memmove(data + at, data + at + take, size - at - take);
                size -= take;
                break;
            case 1: /* insert bytes */
                memmove(data + at + n, data + at, size - at);
                size += n;
                break;
            case 2: /* overwrite bytes with random bytes */
                for (size_t i = at; i < at + take; i++)
                    data[i] = (unsigned char)rng_next(&rng);
                break;
            default: /* repeat some bytes at the end of the file */
                memcpy(data + size, data + at, take);
                size += take;
                break;
            }
            if (size == 0)
                break;
        }
        ost_error err = {0};
        ost_session *session;
        if (open_bytes(data, size, &session, &err) != OST_OK) {
            assert_true(err.text[0]);
            continue;
        }
        const ost_session_summary *sum = ost_session_summary_of(session);
        assert_int_equal(check_ticks(session), sum->ticks);
        assert_true(sum->ticks <= s.first[BLOCKS] && sum->complete_ticks <= sum->ticks);
        ost_session_close(session);
    }
}

static void repair_keeps_complete_blocks(void **state)
{
    (void)state;
    ost_error err = {0};
    static sample s;
    make_sample(&s);
    s.b.data[s.begin[4] + 70] ^= 4; /* this byte is in the third block of records, with ticks 4 to 8 */
    ost_session *session;
    assert_ok(open_bytes(s.b.data, s.b.size - 1, &session, &err));
    char out[4200], before[OST_SESSION_MISSING], after[OST_SESSION_MISSING];
    snprintf(out, sizeof out, "%s/fixed.session", folder);
    assert_ok(ost_session_repair(session, out, &err));
    ost_session *fixed;
    assert_ok(ost_session_open(out, &fixed, &err));
    assert_int_equal(ost_session_summary_of(session)->ticks, 4);
    const ost_session_summary *sum = ost_session_summary_of(fixed);
    assert_int_equal(sum->ticks, 4);
    assert_int_equal(sum->damaged_bytes + sum->cut_bytes, 0);
    assert_false(sum->header_damaged || sum->ended);
    assert_int_equal(check_ticks(fixed), 4);
    assert_string_equal(ost_session_header_get(ost_session_header_of(fixed), "bone"),
                        ost_session_header_get(ost_session_header_of(session), "bone"));
    assert_string_not_equal(ost_session_missing(session, before), ost_session_missing(fixed, after));
    assert_string_equal(after, "the recording is incomplete: it was cut off after tick 3, counted from 0");
    ost_session_close(fixed);
    ost_session_close(session);

    /* The repaired file must still record the gap. */
    make_sample(&s);
    s.b.data[s.begin[2] + 5] ^= 1;
    assert_ok(open_bytes(s.b.data, s.b.size, &session, &err));
    assert_ok(ost_session_repair(session, out, &err));
    assert_ok(ost_session_open(out, &fixed, &err));
    assert_int_equal(ost_session_summary_of(fixed)->missing_records, 3);
    assert_int_equal(ost_session_summary_of(fixed)->complete_ticks, 0);
    assert_true(ost_session_summary_of(fixed)->ended);
    ost_session_close(fixed);
    ost_session_close(session);
}

static void header_refuses_invalid_keys_and_values(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_session_header *header;
    assert_ok(ost_session_header_create(&header, &err));
    assert_int_equal(ost_session_header_set(header, "", "x", &err), OST_ERR_RANGE);
    assert_int_equal(ost_session_header_set(header, "a b", "x", &err), OST_ERR_RANGE);
    assert_int_equal(ost_session_header_set(header, "a:", "x", &err), OST_ERR_RANGE);
    char *value = malloc(OST_SESSION_VALUE + 2), key[20];
    memset(value, '\x01', OST_SESSION_VALUE + 1);
    value[OST_SESSION_VALUE + 1] = '\0';
    assert_int_equal(ost_session_header_set(header, "long", value, &err), OST_ERR_RANGE);
    value[OST_SESSION_VALUE] = '\0';
    for (int i = 0; i < OST_SESSION_KEYS_MAX; i++) {
        snprintf(key, sizeof key, "key%d", i);
        assert_ok(ost_session_header_set(header, key, i < 20 ? value : "x", &err));
    }
    assert_int_equal(ost_session_header_set(header, "one.more", "x", &err), OST_ERR_RANGE);
    unsigned char *payload;
    uint32_t size;
    assert_ok(ost_session_header_encode(header, &payload, &size, &err));
    assert_int_equal(size % SESSION_ALIGN, 0);
    ost_session_header *again;
    assert_ok(ost_session_header_decode(payload, size, &again, &err));
    assert_int_equal(ost_session_header_count(again), OST_SESSION_KEYS_MAX);
    assert_string_equal(ost_session_header_get(again, "key19"), value);
    ost_session_header_free(again);
    ost_session_header_free(header);
    free(payload);
    free(value);
}

static void exports_a_csv_table(void **state)
{
    (void)state;
    ost_error err = {0};
    static sample s;
    make_sample(&s);
    ost_session *session;
    assert_ok(open_bytes(s.b.data, s.b.size, &session, &err));
    char out[4200];
    snprintf(out, sizeof out, "%s/s.csv", folder);
    assert_ok(ost_session_write_csv(session, out, &err));
    ost_session_close(session);
    char *text = scratch_read(out, NULL);
    char *second = strchr(text, '\n') + 1;
    *strchr(second, '\n') = '\0';
    assert_string_equal(
        second,
        "-0.000000005,-0.000000001,7999.999999999,0,1,0,0.0000000009,-2,0,0,1,0,4096,4000000000,7,fedcba9876543210,"
        "0,1,2147483649,3,-2147483648,0,2147483647,1,-2,3,11,12,13,1,-1");
    free(text);
}

/* -------------------------------------------------------------- recording */

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
        cmocka_unit_test(written_records_are_read),
        cmocka_unit_test(version_1_is_read),
        cmocka_unit_test(bytes_are_as_documented),
        cmocka_unit_test(damaged_byte_loses_one_block),
        cmocka_unit_test(truncated_session_keeps_complete_blocks),
        cmocka_unit_test(random_changes_add_no_records),
        cmocka_unit_test(repair_keeps_complete_blocks),
        cmocka_unit_test(header_refuses_invalid_keys_and_values),
        cmocka_unit_test(exports_a_csv_table),
        cmocka_unit_test(recorder_does_not_follow_links),
        cmocka_unit_test(recorded_file_is_a_session),
        cmocka_unit_test(full_ring_buffer_is_reported),
        cmocka_unit_test(temporarily_full_disk_loses_no_records),
        cmocka_unit_test(nearly_full_disk_stores_the_first_records),
        cmocka_unit_test(permanently_full_disk_is_an_error_on_close),
    };
    return cmocka_run_group_tests(tests, scratch_set_up, scratch_tear_down);
}
