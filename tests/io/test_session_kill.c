/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Kills a process at random moments. The process records a tick every millisecond. After each kill it must be possible
 * to open the session. Its ticks must be complete and without a gap, and their number must be at least the number that
 * the recorder had reported as written before the kill.
 *
 *   child:  makes a tick, records it, stores in shared memory how many ticks the recorder has written
 *   parent: sleeps, sends SIGKILL, reads the session
 *
 * The number of milliseconds that each kill lost is printed but not tested, because it depends on
 * timing. The test makes 12 kills, or 200 with OST_TEST_LONG=1.
 * Covers: REQ-SESSION-FILE
 */
#include "harness.h"

#include <signal.h>
#include <stdatomic.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <time.h>

#include <osteon/session.h>

#include "io/scratch_group.h"

typedef struct shared {
    _Atomic uint64_t put, written;
    _Atomic int ready;
} shared;

static int64_t now_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec * INT64_C(1000000000) + t.tv_nsec;
}

/* Returns a tick. All fields except the time are functions of the tick's number. */
static ost_record record_of(uint64_t number)
{
    return (ost_record){.kind = OST_RECORD_TICK,
                        .as.tick = {.number = number,
                                    .tick = {.pose = {.t = {(int64_t)number, 2, 3}, .qw = OST_Q30_ONE}},
                                    .digest = number * UINT64_C(0x9e3779b97f4a7c15)}};
}

static void record_until_killed(const char *path, shared *s)
{
    ost_session_header *header;
    ost_recorder *recorder;
    if (ost_session_header_create(&header, NULL) != OST_OK ||
        ost_recorder_open(path, header, NULL, &recorder, NULL) != OST_OK)
        _exit(1);
    atomic_store(&s->ready, 1);
    struct timespec next;
    clock_gettime(CLOCK_MONOTONIC, &next);
    for (uint64_t number = 0;; number++) {
        ost_record record = record_of(number);
        record.as.tick.tick.t_ns = now_ns();
        if (!ost_recorder_put(recorder, &record))
            _exit(2);
        ost_recorder_state state;
        ost_recorder_state_get(recorder, &state);
        atomic_store(&s->put, number + 1);
        atomic_store(&s->written, state.written);
        next.tv_nsec += 1000000;
        next.tv_sec += next.tv_nsec / 1000000000;
        next.tv_nsec %= 1000000000;
        clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &next, NULL);
    }
}

static int64_t kill_once(const char *path, shared *s, int64_t after_us)
{
    ost_error err = {0};
    *s = (shared){0};
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0)
        record_until_killed(path, s);
    const struct timespec moment = {.tv_nsec = 200000}, pause = {after_us / 1000000, after_us % 1000000 * 1000};
    int status;
    while (!atomic_load(&s->ready)) {
        nanosleep(&moment, NULL);
        assert_int_equal(waitpid(child, &status, WNOHANG), 0);
    }
    nanosleep(&pause, NULL);
    const uint64_t written = atomic_load(&s->written);
    const int64_t killed = now_ns();
    assert_int_equal(kill(child, SIGKILL), 0);
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFSIGNALED(status));

    ost_session *session;
    assert_ok(ost_session_open(path, &session, &err));
    const ost_session_summary *sum = ost_session_summary_of(session);
    assert_true(sum->ticks >= written);
    assert_true(sum->ticks <= atomic_load(&s->put) + 1);
    assert_int_equal(sum->complete_ticks, sum->ticks);
    assert_false(sum->ended);
    assert_int_equal(sum->damaged_bytes + sum->lost_records + sum->missing_records, 0);
    uint64_t number = 0;
    for (bool more = true;;) {
        ost_record record;
        assert_ok(ost_session_next(session, &record, &more, &err));
        if (!more)
            break;
        const ost_record expected = record_of(number++);
        assert_int_equal(record.as.tick.number, expected.as.tick.number);
        assert_int_equal(record.as.tick.tick.pose.t.x, expected.as.tick.tick.pose.t.x);
        assert_true(record.as.tick.digest == expected.as.tick.digest);
    }
    assert_int_equal(number, sum->ticks);
    const int64_t lost = killed - sum->last_t_ns;
    const bool any = sum->ticks > 0;
    ost_session_close(session);
    return any ? lost : 0;
}

static void killed_at_random_moments(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("killed_at_random_moments");
    const char *lengthy = getenv("OST_TEST_LONG");
    const int kills = lengthy && strcmp(lengthy, "1") == 0 ? 200 : 12;
    char path[4200];
    snprintf(path, sizeof path, "%s/killed.session", folder);
    shared *s = mmap(NULL, sizeof *s, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    assert_true(s != MAP_FAILED);
    int64_t worst = 0;
    for (int i = 0; i < kills; i++) {
        const int64_t lost = kill_once(path, s, rng_range(&rng, 0, 250000));
        worst = lost > worst ? lost : worst;
    }
    printf("# %d kills; a kill lost at most the last %.1f ms\n", kills, (double)worst * 1e-6);
    munmap(s, sizeof *s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(killed_at_random_moments)};
    return cmocka_run_group_tests(tests, scratch_set_up, scratch_tear_down);
}
