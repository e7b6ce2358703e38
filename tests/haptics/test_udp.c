/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the `udp` device over loopback, on ports that the system selects: packets that are accepted, packets that are
 * dropped and counted, missing packets, poses that no hand can reach, and two bridges at once. The tests wait for
 * answers and do not depend on times.
 *
 * Covers: REQ-LINK
 */
#include "link_keys.h"

#include <arpa/inet.h>
#include <errno.h>
#include <poll.h>
#include <sys/socket.h>

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
     * During 20 ticks without a packet, the hand moves by 20 mm, which is possible for a hand. The pose is therefore
     * accepted, and the tool follows in steps of 4 mm, which do not count as jumps.
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
     * For one second after the first bridge's last packet, another bridge is refused. On a slow machine, this time may
     * have passed, so that the other bridge is accepted.
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(poses_and_states),
        cmocka_unit_test(dropped_packets_are_counted),
        cmocka_unit_test(missing_packets_lose_the_device),
        cmocka_unit_test(unreachable_pose_releases_the_tool),
        cmocka_unit_test(one_bridge_at_a_time),
        cmocka_unit_test(invalid_specs_are_refused),
    };
    return cmocka_run_group_tests(tests, begin, end);
}
