/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Sessions in memory: a sink that appends to a buffer, ticks in which every field is set, a session of several blocks
 * with the offsets of its blocks, and a check of the ticks that are read back.
 */
#ifndef OST_TESTS_SESSION_BYTES_H
#define OST_TESTS_SESSION_BYTES_H

#include "harness.h"

#include <sys/mman.h>

#include "io/scratch_group.h"
#include "io/session/reader.h"
#include "io/session/recorder.h"

typedef struct bytes {
    unsigned char data[1 << 16];
    size_t size;
} bytes;

static inline int bytes_append(void *user, const void *p, size_t size)
{
    bytes *b = user;
    assert_true(b->size + size <= sizeof b->data);
    memcpy(b->data + b->size, p, size);
    b->size += size;
    return 0;
}

static inline int bytes_cut(void *user, uint64_t size)
{
    ((bytes *)user)->size = size;
    return 0;
}

static inline int bytes_sync(void *user)
{
    (void)user;
    return 0;
}

/* Returns a tick in which every field is set. Some of the values depend on the number of the tick. */
static inline ost_record tick_record(uint64_t number)
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

static inline ost_session_header *make_header(void)
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
static inline void make_sample(sample *s)
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

static inline ost_status open_bytes(const unsigned char *data, size_t size, ost_session **out, ost_error *err)
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
static inline uint64_t check_ticks(ost_session *session)
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

#endif
