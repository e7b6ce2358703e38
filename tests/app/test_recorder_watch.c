/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the messages about a recorder that cannot write: one message when the problem begins, one when it
 * ends, and none while the disk works.
 * Covers: REQ-SESSION-FILE
 */
#include "harness.h"

#include "app/sim/recorder_watch.h"

enum { CAPACITY = 65536 };

typedef struct moment {
    double ms;
    uint64_t put, written, lost;
    bool failing;
    const char *expected; /* expected message; NULL if there must be none */
} moment;

static void assert_messages(const moment *moments, size_t count)
{
    recorder_watch watch = {0};
    char text[RECORDER_WATCH_TEXT];
    for (size_t i = 0; i < count; i++) {
        const moment *m = &moments[i];
        const ost_recorder_state state = {
            .put = m->put, .written = m->written, .lost = m->lost, .failing = m->failing, .reason = "the disk is full"};
        const char *line = recorder_watch_update(&watch, "a.session", &state, CAPACITY, m->ms, text);
        if (!m->expected)
            assert_null(line);
        else {
            assert_non_null(line);
            if (!strstr(line, m->expected))
                fail_msg("moment %zu: the message is '%s', expected '%s'", i, line, m->expected);
        }
    }
}
#define ASSERT_MESSAGES(m) assert_messages(m, sizeof(m) / sizeof(m)[0])

static void no_message_while_disk_works(void **state)
{
    (void)state;
    static const moment m[] = {{100, 0, 0, 0, false, NULL},
                               {200, 100, 75, 0, false, NULL},
                               {5000, 4900, 4875, 0, false, NULL},
                               /* The disk is blocked for a short time. Then nothing is written for a long time. */
                               {6900, 6800, 4875, 0, false, NULL},
                               {7000, 6900, 6900, 0, false, NULL},
                               {60000, 6900, 6900, 0, false, NULL}};
    ASSERT_MESSAGES(m);
}

static void reports_full_disk_and_recovery(void **state)
{
    (void)state;
    static const moment m[] = {
        {100, 100, 75, 0, false, NULL},
        {200, 200, 75, 0, true,
         "a.session: the disk is full; the operation goes on, and the recording waits: there is room for 65 s"},
        {300, 300, 75, 0, true, NULL},
        {9000, 9000, 75, 0, true, NULL},
        {9100, 9100, 9100, 0, false, "recording goes on; nothing was lost"},
        {9200, 9200, 9175, 0, false, NULL}};
    ASSERT_MESSAGES(m);
}

static void reports_lost_ticks_on_full_disk(void **state)
{
    (void)state;
    static const moment m[] = {{100, 100, 75, 0, true, "the disk is full"},
                               {66000, 65611, 75, 30, true, "there is no room left"},
                               {66100, 65611, 75, 130, true, NULL},
                               {66200, 65611, 65611, 130, false, "recording goes on; 130 ticks were lost"}};
    ASSERT_MESSAGES(m);
}

/* A writer that is blocked in a write call cannot report the problem itself. */
static void reports_blocked_writer(void **state)
{
    (void)state;
    static const moment m[] = {
        {100, 100, 75, 0, false, NULL},
        {2050, 2000, 75, 0, false, NULL},
        {2150, 2100, 75, 0, false, "nothing could be written for 2 s: the disk is slow, or the recorder was stopped"},
        {2250, 2200, 75, 0, false, NULL},
        {3000, 3000, 2900, 0, false, "recording goes on; nothing was lost"}};
    ASSERT_MESSAGES(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_message_while_disk_works),
        cmocka_unit_test(reports_full_disk_and_recovery),
        cmocka_unit_test(reports_lost_ticks_on_full_disk),
        cmocka_unit_test(reports_blocked_writer),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
