/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the `udp` device and the bridge over loopback, on ports that the system selects: packets that are
 * accepted, packets that are dropped and counted, missing packets, poses that no hand can reach, and two
 * bridges at once. The tests wait for answers and do not depend on times.
 * Covers: REQ-LINK
 */
#include "harness.h"

#include <arpa/inet.h>
#include <errno.h>
#include <poll.h>
#include <pthread.h>
#include <stdatomic.h>
#include <sys/socket.h>

#include "haptics/bridge.h"
#include "haptics/driver.h"
#include "io/io_scratch.h"

#define MM OST_PM_PER_MM
enum { ANSWER_MS = 20000 };

static char *folder;
static char key_file[4200], other_file[4200];
static link_key *key, *other;

static int begin(void **state)
{
    (void)state;
    ost_error err = {0};
    uint8_t bytes[32];
    folder = scratch_folder();
    memset(bytes, 7, sizeof bytes);
    snprintf(key_file, sizeof key_file, "%s", scratch_write(folder, "k", bytes, sizeof bytes));
    assert_ok(ost_link_key_make(bytes, sizeof bytes, &key, &err));
    memset(bytes, 8, sizeof bytes);
    snprintf(other_file, sizeof other_file, "%s", scratch_write(folder, "o", bytes, sizeof bytes));
    assert_ok(ost_link_key_make(bytes, sizeof bytes, &other, &err));
    assert_int_equal(chmod(key_file, 0600), 0);
    assert_int_equal(chmod(other_file, 0600), 0);
    return 0;
}

static int end(void **state)
{
    (void)state;
    ost_link_key_free(key);
    ost_link_key_free(other);
    scratch_remove(folder);
    return 0;
}

static ost_haptic *listen_at(char where[64], const char *options)
{
    char spec[4400], text[OST_HAPTIC_TEXT];
    ost_error err = {0};
    ost_haptic *device;
    snprintf(spec, sizeof spec, "udp:port=0,key=%s%s", key_file, options);
    assert_ok(ost_haptic_open(spec, &(ost_haptic_setup){.start = {.t = {MM, 2 * MM, 3 * MM}, .qw = OST_Q30_ONE}},
                              &device, &err));
    assert_int_equal(strncmp(ost_haptic_about(device, text), "waits for a bridge at 127.0.0.1:", 32), 0);
    snprintf(where, 64, "%s", strrchr(text, ' ') + 1);
    return device;
}

static uint64_t counter_of(const ost_haptic *device, const char *name)
{
    ost_haptic_tally tally[OST_HAPTIC_COUNTS];
    const int count = ost_haptic_counts(device, tally);
    for (int i = 0; i < count; i++)
        if (strcmp(tally[i].name, name) == 0)
            return tally[i].value;
    fail_msg("the device has no counter '%s'", name);
    return 0;
}

/* Waits until the counter of this name has reached the value. */
static void await_count(const ost_haptic *device, const char *name, uint64_t value)
{
    const struct timespec pause = {.tv_nsec = 1000000};
    for (int i = 0; i < ANSWER_MS && counter_of(device, name) < value; i++)
        nanosleep(&pause, NULL);
    assert_int_equal(counter_of(device, name), value);
}

static int connect_to(const char *where)
{
    struct sockaddr_in to = {.sin_family = AF_INET,
                             .sin_port = htons((uint16_t)atoi(strrchr(where, ':') + 1)),
                             .sin_addr = {htonl(INADDR_LOOPBACK)}};
    const int s = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    assert_true(s >= 0);
    assert_int_equal(connect(s, (struct sockaddr *)&to, sizeof to), 0);
    return s;
}

static void send_sealed(int s, link_key *with, const link_packet *p)
{
    uint8_t bytes[LINK_STATE_BYTES];
    const size_t size = ost_link_seal(with, p, bytes);
    assert_int_equal(send(s, bytes, size, 0), size);
}

static link_packet answer(int s)
{
    uint8_t bytes[LINK_BUFFER_BYTES];
    link_packet p = {0};
    struct pollfd wait = {.fd = s, .events = POLLIN};
    assert_int_equal(poll(&wait, 1, ANSWER_MS), 1);
    const ssize_t size = recv(s, bytes, sizeof bytes, 0);
    assert_int_equal(ost_link_unseal(key, bytes, (size_t)size, &p), LINK_GOOD);
    assert_int_equal(p.type, LINK_STATE);
    return p;
}

/* A bridge, simulated by the test. */
typedef struct client {
    int socket;
    link_packet pose;
} client;

static client greet(const char *where, uint64_t number)
{
    client c = {.socket = connect_to(where),
                .pose = {.type = LINK_POSE, .bridge = number, .tool = -1, .pose = {.qw = OST_Q30_ONE}}};
    send_sealed(c.socket, key, &(link_packet){.type = LINK_HELLO, .bridge = number, .sequence = 1, .tool = -1});
    const link_packet state = answer(c.socket);
    assert_int_equal(state.bridge, number);
    assert_true(state.simulation != 0);
    c.pose.simulation = state.simulation;
    c.pose.sequence = state.answers;
    c.pose.pose = state.pose;
    return c;
}

static link_packet send_pose_packet(client *c, ost_pm x, uint16_t flags)
{
    c->pose.sequence++;
    c->pose.pose.t.x = x;
    c->pose.flags = flags;
    send_sealed(c->socket, key, &c->pose);
    const link_packet state = answer(c->socket);
    assert_int_equal(state.answers, c->pose.sequence);
    return state;
}

static void poses_and_states(void **state)
{
    (void)state;
    char where[64];
    ost_haptic_state hand;
    ost_haptic *device = listen_at(where, "");
    /* While there is no bridge, tracking is lost. */
    for (int i = 0; i < 20; i++)
        assert_int_equal(ost_haptic_read(device, &hand), OST_HAPTIC_NOT_TRACKED);
    client c = greet(where, 77);
    assert_true(c.pose.pose.t.x == MM && c.pose.pose.t.z == 3 * MM); /* This is the start position of the tool. */
    send_pose_packet(&c, MM, 0);
    assert_int_equal(ost_haptic_read(device, &hand), OST_HAPTIC_NOT_TRACKED);
    c.pose.buttons = 6;
    c.pose.tool = 1;
    send_pose_packet(&c, MM + 1000, LINK_SEEN);
    assert_int_equal(ost_haptic_read(device, &hand), OST_HAPTIC_FRESH);
    assert_true(hand.pose.t.x == MM + 1000 && hand.pose.t.y == 2 * MM && hand.buttons == 6 && hand.tool == 1);
    ost_haptic_write(device, &(ost_wrench){{0, -1.25, 2e-6}, {0, 0, 0.5}});
    const link_packet s = send_pose_packet(&c, MM + 2000, LINK_SEEN);
    assert_true(s.pose.t.x == MM + 1000 && s.force_un[1] == -1250000 && s.force_un[2] == 2 &&
                s.torque_unm[2] == 500000);
    assert_true(s.stiffness == 300000 && s.damping == 500 && s.flags == 0);
    assert_int_equal(ost_haptic_read(device, &hand), OST_HAPTIC_FRESH);
    /* This is the last packet of the bridge. */
    send_pose_packet(&c, MM, LINK_ENDED);
    assert_int_equal(ost_haptic_read(device, &hand), OST_HAPTIC_ENDED);
    ost_haptic_close(device);
    assert_true(answer(c.socket).flags & LINK_ENDED); /* This is the last packet of the simulation. */
    close(c.socket);
}

static void dropped_packets_are_counted(void **state)
{
    (void)state;
    char where[64];
    ost_haptic_state hand;
    test_rng rng = rng_seeded("garbage");
    ost_haptic *device = listen_at(where, "");
    client c = greet(where, 5);
    send_pose_packet(&c, MM, LINK_SEEN);
    assert_int_equal(ost_haptic_read(device, &hand), OST_HAPTIC_FRESH);
    const uint64_t good = counter_of(device, "good");
    assert_int_equal(good, 2);
    link_packet p = c.pose;
    /* Sends a packet that is signed with a wrong key. */
    p.sequence = 100;
    send_sealed(c.socket, other, &p);
    await_count(device, "wrong_key", 1);
    /* Sends a repeated packet, and then a packet for another run of the simulation. Both must count as replayed. */
    send_sealed(c.socket, key, &c.pose);
    await_count(device, "replayed", 1);
    p.simulation++;
    send_sealed(c.socket, key, &p);
    await_count(device, "replayed", 2);
    /* Two packets arrive in the wrong order, and the packet before them is missing. The newer packet is used. */
    p = c.pose;
    p.sequence = c.pose.sequence + 3;
    p.pose.t.x = MM + 300;
    send_sealed(c.socket, key, &p);
    answer(c.socket);
    p.sequence = c.pose.sequence + 2;
    p.pose.t.x = MM + 200;
    send_sealed(c.socket, key, &p);
    await_count(device, "late", 1);
    assert_int_equal(counter_of(device, "missing"), 2);
    assert_int_equal(ost_haptic_read(device, &hand), OST_HAPTIC_FRESH);
    assert_true(hand.pose.t.x == MM + 300);
    /*
     * Sends truncated packets, an empty packet, a state packet and a packet that is too long. Then sends
     * random bytes and valid packets alternately. The valid packets must be accepted.
     */
    uint8_t bytes[2000];
    const size_t size = ost_link_seal(key, &p, bytes);
    uint64_t malformed = 0;
    for (size_t n = 0; n < size; n += 13, malformed++)
        assert_int_equal(send(c.socket, bytes, n, 0), n);
    send_sealed(c.socket, key, &(link_packet){.type = LINK_STATE, .bridge = 5, .sequence = 900, .pose = p.pose});
    malformed++;
    memset(bytes, 'O', sizeof bytes);
    assert_int_equal(send(c.socket, bytes, sizeof bytes, 0), sizeof bytes);
    malformed++;
    await_count(device, "malformed", malformed);
    for (int i = 0; i < 2000; i++) {
        const size_t n = rng_next(&rng) % 300;
        for (size_t b = 0; b < n; b++)
            bytes[b] = (uint8_t)rng_next(&rng);
        if (i % 3 == 0)
            ost_link_encode(&p, bytes);
        if (send(c.socket, bytes, n, 0) < 0)
            assert_int_equal(errno, ENOBUFS);
        if (i % 50 == 0) { /* The device is read often enough for all packets to fit in the socket's buffer. */
            c.pose.sequence = 1000 + (uint64_t)i;
            send_pose_packet(&c, MM + i, LINK_SEEN);
            assert_int_equal(ost_haptic_read(device, &hand), OST_HAPTIC_FRESH);
            assert_true(hand.pose.t.x == MM + i);
        }
    }
    ost_haptic_close(device);
    close(c.socket);
}

static void missing_packets_lose_the_device(void **state)
{
    (void)state;
    char where[64];
    ost_haptic_state hand;
    ost_haptic *device = listen_at(where, ",lost=100");
    client c = greet(where, 5);
    send_pose_packet(&c, MM, LINK_SEEN);
    assert_int_equal(ost_haptic_read(device, &hand), OST_HAPTIC_FRESH);
    for (int i = 0; i < 4; i++)
        assert_int_equal(ost_haptic_read(device, &hand), OST_HAPTIC_NO_SAMPLE);
    for (int i = 0; i < 16; i++)
        assert_int_equal(ost_haptic_read(device, &hand), OST_HAPTIC_NOT_TRACKED);
    /*
     * After 20 ticks without a packet, the hand is 20 mm farther away. A hand can move this far in this
     * time, so the tool follows the hand in steps that are too small to be jumps.
     */
    send_pose_packet(&c, MM + 20 * MM, LINK_SEEN);
    assert_int_equal(ost_haptic_read(device, &hand), OST_HAPTIC_FRESH);
    assert_true(llabs(hand.pose.t.x - (MM + 4 * MM)) < 1000);
    send_pose_packet(&c, MM + 6 * MM, LINK_SEEN);
    assert_int_equal(ost_haptic_read(device, &hand), OST_HAPTIC_FRESH);
    assert_true(hand.pose.t.x == MM + 6 * MM);
    for (int i = 0; i < 100; i++)
        assert_int_equal(ost_haptic_read(device, &hand), i < 4 ? OST_HAPTIC_NO_SAMPLE : OST_HAPTIC_NOT_TRACKED);
    assert_int_equal(ost_haptic_read(device, &hand), OST_HAPTIC_LOST);
    ost_haptic_close(device);
    close(c.socket);
}

static void unreachable_pose_releases_the_tool(void **state)
{
    (void)state;
    char where[64];
    ost_haptic_state hand;
    ost_haptic *device = listen_at(where, "");
    client c = greet(where, 5);
    send_pose_packet(&c, MM, LINK_SEEN);
    assert_int_equal(ost_haptic_read(device, &hand), OST_HAPTIC_FRESH);
    send_pose_packet(&c, 50 * MM, LINK_SEEN);
    assert_int_equal(ost_haptic_read(device, &hand), OST_HAPTIC_NOT_TRACKED);
    ost_haptic_write(device, &(ost_wrench){{0}, {0}});
    /* Until the bridge releases the tool, all poses from the bridge are rejected, even poses near the tool. */
    link_packet s = send_pose_packet(&c, MM, LINK_SEEN);
    assert_true((s.flags & LINK_AGAIN) && s.pose.t.x == MM);
    assert_int_equal(ost_haptic_read(device, &hand), OST_HAPTIC_NOT_TRACKED);
    send_pose_packet(&c, 50 * MM, 0);
    assert_int_equal(ost_haptic_read(device, &hand), OST_HAPTIC_NOT_TRACKED);
    ost_haptic_write(device, &(ost_wrench){{0}, {0}});
    s = send_pose_packet(&c, MM + 5, LINK_SEEN);
    assert_int_equal(s.flags, 0);
    assert_int_equal(ost_haptic_read(device, &hand), OST_HAPTIC_FRESH);
    /* A rotation that is impossible for a hand is also rejected. */
    c.pose.pose.qw = 0;
    c.pose.pose.qx = OST_Q30_ONE;
    send_pose_packet(&c, MM + 5, LINK_SEEN);
    assert_int_equal(ost_haptic_read(device, &hand), OST_HAPTIC_NOT_TRACKED);
    assert_int_equal(counter_of(device, "too_far"), 2);
    ost_haptic_close(device);
    close(c.socket);
}

static void one_bridge_at_a_time(void **state)
{
    (void)state;
    char where[64];
    ost_haptic_state hand;
    ost_haptic *device = listen_at(where, "");
    client a = greet(where, 1);
    send_pose_packet(&a, MM, LINK_SEEN);
    /*
     * For one second after the first bridge's last packet, another bridge is refused. On a slow machine this time may
     * have passed. The other bridge is then accepted.
     */
    const int s = connect_to(where);
    send_sealed(s, key, &(link_packet){.type = LINK_HELLO, .bridge = 2, .sequence = 1, .tool = -1});
    const link_packet reply = answer(s);
    if (reply.flags & LINK_BUSY) {
        link_packet p = a.pose;
        p.bridge = 2;
        p.sequence++;
        send_sealed(s, key, &p);
        const struct timespec pause = {.tv_nsec = 1000000};
        for (int i = 0; i < ANSWER_MS && counter_of(device, "of_other_bridges") + counter_of(device, "good") < 4; i++)
            nanosleep(&pause, NULL);
        assert_true(counter_of(device, "of_other_bridges") >= 1);
    }
    assert_int_equal(ost_haptic_read(device, &hand), OST_HAPTIC_FRESH);
    ost_haptic_close(device);
    close(s);
    close(a.socket);
}

static void invalid_specs_are_refused(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_haptic *device;
    char spec[4400];
    static const struct {
        const char *options, *message;
        ost_status status;
    } cases[] = {
        {"udp", "missing option key=FILE", OST_ERR_USAGE},
        {"udp:key=/nowhere/k", "/nowhere/k: cannot open", OST_ERR_IO},
        {"udp:port=70000,key=x", "port=70000; expected a whole number from 0 to 65535", OST_ERR_USAGE},
        {"udp:size=3", "unknown option 'size'; expected key, port, bind or lost", OST_ERR_USAGE},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        assert_int_equal(ost_haptic_open(cases[i].options, NULL, &device, &err), cases[i].status);
        assert_null(device);
        if (!strstr(err.text, cases[i].message))
            fail_msg("%s: the error '%s' does not contain '%s'", cases[i].options, err.text, cases[i].message);
    }
    snprintf(spec, sizeof spec, "udp:bind=somewhere,key=%s", key_file);
    assert_int_equal(ost_haptic_open(spec, NULL, &device, &err), OST_ERR_USAGE);
    assert_non_null(strstr(err.text, "expected a numeric address"));
    char where[64];
    ost_haptic *first = listen_at(where, "");
    snprintf(spec, sizeof spec, "udp:port=%s,key=%s", strrchr(where, ':') + 1, key_file);
    assert_int_equal(ost_haptic_open(spec, NULL, &device, &err), OST_ERR_UNAVAILABLE);
    assert_non_null(strstr(err.text, "cannot listen at 127.0.0.1"));
    ost_haptic_close(first);
}

/* --------------------------------------------------------------- the bridge */

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
        cmocka_unit_test(poses_and_states),
        cmocka_unit_test(dropped_packets_are_counted),
        cmocka_unit_test(missing_packets_lose_the_device),
        cmocka_unit_test(unreachable_pose_releases_the_tool),
        cmocka_unit_test(one_bridge_at_a_time),
        cmocka_unit_test(invalid_specs_are_refused),
        cmocka_unit_test(bridge_moves_the_tool_and_outputs_forces),
        cmocka_unit_test(missing_states_release_the_tool),
        cmocka_unit_test(bridge_sends_hello_after_a_second_without_states),
        cmocka_unit_test(missing_simulation_is_reported),
    };
    return cmocka_run_group_tests(tests, begin, end);
}
