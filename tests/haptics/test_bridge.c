/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the bridge, which sends the poses of a device to a simulation on another machine. A thread of this test
 * replaces the simulation. The thread answers, is silent for a time, or ends. Times are taken from the packets, so that
 * the results do not depend on the load of the machine.
 *
 * Covers: REQ-LINK
 */
#include "link_keys.h"

#include <arpa/inet.h>
#include <poll.h>
#include <pthread.h>
#include <stdatomic.h>
#include <sys/socket.h>

#include "haptics/bridge.h"

/* A simulation whose answers to the bridge are configured by the test. */
typedef struct stand_in {
    int socket;
    pthread_t thread;
    char to[64];
    int unanswered_from, unanswered_to; /* range of the poses that are not answered; the next hello ends the range */
    int end_at;                 /* number of the pose at which the simulation reports its end */
    _Atomic bool stop;
    int poses, seen, not_held, jumps, hellos;
} stand_in;

static void *run_stand_in(void *user)
{
    stand_in *s = user;
    ost_pose tool = {.t = {0, 0, 10 * MM}, .qw = OST_Q30_ONE}, last = tool;
    int64_t last_ns = 0;
    uint64_t sequence = 40, answers = 0;
    bool tracked = false;
    while (!atomic_load(&s->stop)) {
        uint8_t bytes[LINK_BUFFER_BYTES];
        struct sockaddr_in from;
        socklen_t from_size = sizeof from;
        struct pollfd wait = {.fd = s->socket, .events = POLLIN};
        link_packet p;
        if (poll(&wait, 1, 20) != 1)
            continue;
        const ssize_t size = recvfrom(s->socket, bytes, sizeof bytes, 0, (struct sockaddr *)&from, &from_size);
        if (size < 0 || ost_link_unseal(key, bytes, (size_t)size, &p) != LINK_GOOD)
            continue;
        if (p.type == LINK_HELLO) {
            /*
             * A bridge that has received nothing for a second sends only hello packets. The number
             * of poses therefore does not increase until a hello is answered.
             */
            s->hellos++;
            if (s->poses >= s->unanswered_from)
                s->unanswered_to = s->poses;
        } else if (p.type == LINK_POSE) {
            s->poses++;
            answers = p.sequence;
            if (p.flags & LINK_SEEN) {
                const int64_t way = llabs(p.pose.t.z - last.t.z);
                /*
                 * While a hand holds the tool, the tool moves by at most 100 pm per ns. The limit is
                 * computed from the times in the packets, so it is valid even if this thread had to
                 * wait for a processor.
                 */
                s->jumps += way > 2 * MM + (tracked ? (p.t_ns - last_ns) * 100 : 0);
                last_ns = p.t_ns;
                s->seen++;
                tool = last = p.pose;
            } else {
                s->not_held++;
            }
            tracked = p.flags & LINK_SEEN;
        }
        if (s->unanswered_from && s->poses >= s->unanswered_from && s->poses < s->unanswered_to)
            continue;
        const bool over = s->end_at && s->poses >= s->end_at;
        link_packet state = {.type = LINK_STATE,
                             .flags = over ? LINK_ENDED : 0,
                             .bridge = p.bridge,
                             .simulation = 99,
                             .sequence = ++sequence,
                             .answers = answers,
                             .pose = tool,
                             .force_un = {0, 0, 1500000},
                             .stiffness = 300000,
                             .damping = 500};
        const size_t length = ost_link_seal(key, &state, bytes);
        if (sendto(s->socket, bytes, length, 0, (struct sockaddr *)&from, from_size) < 0)
            break;
    }
    return NULL;
}

static stand_in *make_stand_in(void)
{
    stand_in *s = calloc(1, sizeof *s);
    struct sockaddr_in own = {.sin_family = AF_INET, .sin_addr = {htonl(INADDR_LOOPBACK)}};
    socklen_t size = sizeof own;
    assert_non_null(s);
    s->socket = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    assert_int_equal(bind(s->socket, (struct sockaddr *)&own, sizeof own), 0);
    assert_int_equal(getsockname(s->socket, (struct sockaddr *)&own, &size), 0);
    snprintf(s->to, sizeof s->to, "127.0.0.1:%d", ntohs(own.sin_port));
    return s;
}

static void start_stand_in(stand_in *s)
{
    assert_int_equal(pthread_create(&s->thread, NULL, run_stand_in, s), 0);
}

static void free_stand_in(stand_in *s)
{
    atomic_store(&s->stop, true);
    pthread_join(s->thread, NULL);
    close(s->socket);
    free(s);
}

enum { PATH_TICKS = 100000 };

static ost_haptic *a_hand(ost_path *path)
{
    ost_error err = {0};
    ost_haptic *device;
    assert_ok(ost_path_init(path, PATH_TICKS, &err));
    for (size_t i = 0; i < path->count; i++) /* The hand begins far away and moves down at 0.1 m/s. */
        path->ticks[i] = (ost_tick){.t_ns = (int64_t)i * 1000000,
                                    .rpm = OST_RPM_ON,
                                    .pose = {.t = {500 * MM, 0, 500 * MM - (int64_t)i * MM / 10}, .qw = OST_Q30_ONE}};
    assert_ok(ost_haptic_open("sim", &(ost_haptic_setup){.path = path}, &device, &err));
    return device;
}

static bridge_report report;

static ost_status run_bridge(const char *to, const char *with, uint64_t ticks, ost_error *err)
{
    ost_path path;
    ost_haptic *device = a_hand(&path);
    const bridge_options options = {
        .to = to, .key = with, .ticks = ticks, .patience_ms = with == key_file ? 0 : 300, .no_realtime = true};
    const ost_status status = ost_bridge_run(device, &options, &report, err);
    ost_haptic_close(device);
    ost_path_free(&path);
    return status;
}

static void bridge_moves_the_tool_and_outputs_forces(void **state)
{
    (void)state;
    ost_error err = {0};
    stand_in *s = make_stand_in();
    start_stand_in(s);
    /*
     * The safety layer lets the force rise slowly after each gap in the states. On a busy machine gaps are frequent, so
     * one run of 1 s may be too short for the force to rise.
     */
    for (int runs = 0; runs < 20; runs++) {
        assert_ok(run_bridge(s->to, key_file, 1000, &err));
        assert_true(report.met && !report.ended);
        assert_int_equal(report.loop.ticks, 1000);
        assert_int_equal(report.loop.end, OST_SERVO_TICKS);
        assert_string_equal(report.to, s->to);
        assert_true(report.states > 0 && report.round_trip.count > 0);
        assert_int_equal(report.bad, 0);
        assert_true(report.peak_n <= 3);
        if (report.peak_n > 0.5)
            break;
    }
    assert_true(report.peak_n > 0.5);
    free_stand_in(s);
}

static void missing_states_release_the_tool(void **state)
{
    (void)state;
    ost_error err = {0};
    stand_in *s = make_stand_in();
    s->unanswered_from = 200;
    s->unanswered_to = 600;
    s->end_at = 1000;
    start_stand_in(s);
    assert_ok(run_bridge(s->to, key_file, PATH_TICKS, &err));
    assert_true(report.ended);
    assert_int_equal(report.loop.end, OST_SERVO_STOPPED);
    assert_true(report.limps >= 1);
    assert_true(report.limp_ticks >= 100);
    /*
     * While the bridge receives no states, it reports that the tool is not held. Afterwards the tool
     * continues from its position, although the device has moved 40 mm.
     */
    assert_true(s->not_held >= 100);
    assert_int_equal(s->jumps, 0);
    free_stand_in(s);
}

static void bridge_sends_hello_after_a_second_without_states(void **state)
{
    (void)state;
    ost_error err = {0};
    stand_in *s = make_stand_in();
    s->unanswered_from = 200;
    s->unanswered_to = PATH_TICKS;
    s->end_at = 2000;
    start_stand_in(s);
    assert_ok(run_bridge(s->to, key_file, PATH_TICKS, &err));
    assert_true(report.ended);
    assert_int_equal(report.loop.end, OST_SERVO_STOPPED);
    assert_true(s->hellos >= 2); /* One hello is sent at the start, and one while poses are not answered. */
    assert_true(report.limps >= 1);
    assert_int_equal(s->jumps, 0);
    free_stand_in(s);
}

static void missing_simulation_is_reported(void **state)
{
    (void)state;
    ost_error err = {0};
    stand_in *s = make_stand_in();
    start_stand_in(s);
    /* The stand-in drops packets that were signed with another key. */
    assert_int_equal(run_bridge(s->to, other_file, 0, &err), OST_ERR_UNAVAILABLE);
    assert_non_null(strstr(err.text, "no simulation answers at 127.0.0.1"));
    assert_int_equal(run_bridge("nowhere", key_file, 10, &err), OST_ERR_USAGE);
    assert_int_equal(run_bridge("127.0.0.1:", key_file, 10, &err), OST_ERR_USAGE);
    static const char *const ports[] = {
        "0", "00", "65536", "99999", "4294967297", "18446744073709551617", "-1", "+9", "abc", "9x"};
    for (size_t i = 0; i < sizeof ports / sizeof ports[0]; i++) {
        char to[64];
        snprintf(to, sizeof to, "127.0.0.1:%s", ports[i]);
        assert_int_equal(run_bridge(to, key_file, 10, &err), OST_ERR_USAGE);
        assert_non_null(strstr(err.text, "port must be from 1 to 65535"));
    }
    /* The highest port is valid, also with leading zeros. */
    assert_int_equal(run_bridge("127.0.0.1:65535", other_file, 10, &err), OST_ERR_UNAVAILABLE);
    assert_int_equal(run_bridge("127.0.0.1:00065535", other_file, 10, &err), OST_ERR_UNAVAILABLE);
    free_stand_in(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bridge_moves_the_tool_and_outputs_forces),
        cmocka_unit_test(missing_states_release_the_tool),
        cmocka_unit_test(bridge_sends_hello_after_a_second_without_states),
        cmocka_unit_test(missing_simulation_is_reported),
    };
    return cmocka_run_group_tests(tests, begin, end);
}
