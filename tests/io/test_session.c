/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests session files: records must be read back as written, and damaged bytes must be handled. Every byte of a session
 * is damaged in turn, and the file is truncated at every length. The positions of the blocks determine which records
 * must remain.
 *
 * Covers: REQ-SESSION-FILE
 */
#include "session_bytes.h"

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
    };
    return cmocka_run_group_tests(tests, scratch_set_up, scratch_tear_down);
}
