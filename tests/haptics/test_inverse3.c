/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests Haply's Inverse3 with a stand-in for the vendor's service: a WebSocket on loopback that records
 * each message and answers it with a state. If a test requests a fault, the stand-in sends garbage, closes the
 * connection, ends the stream, sends nothing, or sends a frame without end. No test depends on time, because
 * timeouts are long.
 * Covers: REQ-DEVICES
 */
#include "harness.h"

#include <arpa/inet.h>
#include <dlfcn.h>
#include <math.h>
#include <openssl/evp.h>
#include <poll.h>
#include <pthread.h>
#include <semaphore.h>
#include <signal.h>
#include <stdatomic.h>
#include <sys/socket.h>
#include <unistd.h>

#include <osteon/haptics.h>

#define MM OST_PM_PER_MM
enum { ANSWER_MS = 20000, TEXT = 4096 };

typedef enum fault { NONE, GARBAGE, WRONG, CLOSE, END, SILENCE, HUGE_FRAME, LONG_MESSAGE, NO_UPGRADE } fault;

typedef struct service {
    int listening, port;
    pthread_t thread;
    fault fault;
    int fault_at;            /* number of the faulty answer, counted from 1 */
    bool wired;              /* true if the service offers a wired grip, whose rotation depends on x_um */
    _Atomic int x_um;        /* position of the cursor along x in micrometres */
    _Atomic bool stop;
    _Atomic int answers;
    pthread_mutex_t lock;    /* protects the members below */
    char first[TEXT], last[TEXT];
} service;

static bool read_all(service *s, int fd, void *bytes, size_t size)
{
    uint8_t *p = bytes;
    while (size > 0) {
        struct pollfd wait = {.fd = fd, .events = POLLIN};
        if (atomic_load(&s->stop))
            return false;
        if (poll(&wait, 1, 20) != 1)
            continue;
        const ssize_t n = read(fd, p, size);
        if (n <= 0)
            return false;
        p += n;
        size -= (size_t)n;
    }
    return true;
}

static bool answer_handshake(service *s, int fd)
{
    static const char magic[] = "258EAFA5-E914-47DA-95CA-C5AB0DC85B11"; /* RFC 6455 */
    char head[TEXT] = "", key[128], answer[256], accept[64];
    unsigned char digest[EVP_MAX_MD_SIZE];
    unsigned length = 0;
    for (size_t n = 0; n < sizeof head - 1 && !strstr(head, "\r\n\r\n"); n++)
        if (!read_all(s, fd, head + n, 1))
            return false;
    const char *found = strcasestr(head, "sec-websocket-key:");
    if (!found || s->fault == NO_UPGRADE)
        return write(fd, "HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\n\r\n", 45) < 0;
    found += 18 + strspn(found + 18, " ");
    snprintf(key, sizeof key, "%.*s%s", (int)strcspn(found, "\r"), found, magic);
    EVP_Digest(key, strlen(key), digest, &length, EVP_sha1(), NULL);
    EVP_EncodeBlock((unsigned char *)accept, digest, (int)length);
    snprintf(answer, sizeof answer,
             "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Accept: "
             "%s\r\n\r\n",
             accept);
    return write(fd, answer, strlen(answer)) == (ssize_t)strlen(answer);
}

/* Reads and unmasks a string from the client. Returns false after the end of the connection. */
static bool read_text(service *s, int fd, char text[TEXT])
{
    uint8_t head[2], more[2], mask[4];
    if (!read_all(s, fd, head, 2))
        return false;
    size_t length = head[1] & 0x7f;
    if (length == 126) {
        if (!read_all(s, fd, more, 2))
            return false;
        length = (size_t)more[0] << 8 | more[1];
    }
    if (length >= TEXT || !(head[1] & 0x80) || !read_all(s, fd, mask, 4) || !read_all(s, fd, text, length))
        return false;
    for (size_t i = 0; i < length; i++)
        text[i] ^= (char)mask[i % 4];
    text[length] = '\0';
    return (head[0] & 0x0f) == 1;
}

static void write_text(int fd, const char *text)
{
    /*
     * Sends the complete message in one call. If it were sent in two parts, the second part would be
     * delayed until the first part is acknowledged.
     */
    char frame[TEXT + 4];
    const size_t size = strlen(text), head = size < 126 ? 2 : 4;
    frame[0] = (char)0x81;
    frame[1] = size < 126 ? (char)size : 126;
    frame[2] = (char)(size >> 8);
    frame[3] = (char)size;
    memcpy(frame + head, text, size);
    if (write(fd, frame, head + size) < 0)
        return;
}

static void put_state(const service *s, char text[TEXT])
{
    const double x = atomic_load(&s->x_um) * 1e-6;
    if (s->wired)
        snprintf(text, TEXT,
                 "{\"inverse3\":[{\"device_id\":\"other\"},{\"device_id\":\"A-1\",\"cursor_position\":{\"x\":%.6f,"
                 "\"y\":0,\"z\":0}}],"
                 "\"verse_grip\":[{\"orientation\":{\"w\":%.6f,\"x\":0,\"y\":0,\"z\":%.6f},\"button\":true}]}",
                 x, cos(x), sin(x));
    else
        snprintf(
            text, TEXT,
            "{\"inverse3\":[{\"device_id\":\"04EA\",\"config\":{},\"state\":{\"cursor_position\":{\"x\":%.6f,\"y\":%."
            "6f,\"z\":%.6f},"
            "\"cursor_velocity\":{\"x\":0,\"y\":0,\"z\":0}}}],\"wireless_verse_grip\":[{\"device_id\":\"615\","
            "\"state\":{"
            "\"orientation\":{\"w\":1,\"x\":0,\"y\":0,\"z\":0},\"buttons\":{\"a\":true,\"b\":false,\"c\":true}}}]}",
            x, 2 * x, 3 * x);
}

/* Answers one message. Returns false after the end of the connection. */
static bool answer(service *s, int fd)
{
    static const uint8_t endless[10] = {0x81, 127, 0, 0, 1, 0, 0, 0, 0, 0}, closing[4] = {0x88, 2, 0x03, 0xe8};
    char text[TEXT], long_text[2000];
    const int number = atomic_fetch_add(&s->answers, 1) + 1;
    put_state(s, text);
    if (s->fault == NONE || number < s->fault_at) {
        write_text(fd, text);
        return true;
    }
    switch (s->fault) {
    case GARBAGE: write_text(fd, number % 2 ? "{\"inverse3\":[{" : "\xff\xfe no json"); return true;
    case WRONG:
        write_text(fd, "{\"inverse3\":[{\"device_id\":\"04EA\",\"state\":{\"cursor_position\":{\"x\":\"0\",\"y\":1e400,"
                       "\"z\":null}}}]}");
        return true;
    case CLOSE: return write(fd, closing, sizeof closing) < 0;
    case SILENCE: return true;
    case HUGE_FRAME: return write(fd, endless, sizeof endless) > 0 && write(fd, text, strlen(text)) > 0;
    case LONG_MESSAGE: /* This case sends many fragments without a last one. */
        memset(long_text, ' ', sizeof long_text);
        for (int i = 0; i < 60; i++) {
            const uint8_t head[4] = {i ? 0x00 : 0x01, 126, sizeof long_text >> 8, sizeof long_text & 0xff};
            if (write(fd, head, 4) < 0 || write(fd, long_text, sizeof long_text) < 0)
                return false;
        }
        return true;
    case NONE:
    case END:
    case NO_UPGRADE: break;
    }
    return false;
}

static void *serve(void *user)
{
    service *s = user;
    char text[TEXT];
    struct pollfd wait = {.fd = s->listening, .events = POLLIN};
    while (!atomic_load(&s->stop)) {
        if (poll(&wait, 1, 20) != 1)
            continue;
        const int fd = accept(s->listening, NULL, NULL);
        bool more = fd >= 0 && answer_handshake(s, fd);
        while (more && read_text(s, fd, text)) {
            pthread_mutex_lock(&s->lock);
            memcpy(s->first[0] ? s->last : s->first, text, TEXT);
            pthread_mutex_unlock(&s->lock);
            more = answer(s, fd);
        }
        if (fd >= 0)
            close(fd);
    }
    return NULL;
}

static service *begin_service(fault what, int at, bool wired)
{
    service *s = calloc(1, sizeof *s);
    struct sockaddr_in own = {.sin_family = AF_INET, .sin_addr = {htonl(INADDR_LOOPBACK)}};
    socklen_t size = sizeof own;
    assert_non_null(s);
    *s = (service){.fault = what, .fault_at = at, .wired = wired};
    pthread_mutex_init(&s->lock, NULL);
    s->listening = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    assert_int_equal(bind(s->listening, (struct sockaddr *)&own, sizeof own), 0);
    assert_int_equal(getsockname(s->listening, (struct sockaddr *)&own, &size), 0);
    assert_int_equal(listen(s->listening, 1), 0);
    s->port = ntohs(own.sin_port);
    assert_int_equal(pthread_create(&s->thread, NULL, serve, s), 0);
    return s;
}

static void end_service(service *s)
{
    atomic_store(&s->stop, true);
    pthread_join(s->thread, NULL);
    pthread_mutex_destroy(&s->lock);
    close(s->listening);
    free(s);
}

static ost_status open_at(const service *s, const char *more, ost_haptic **device, ost_error *err)
{
    char spec[200];
    snprintf(spec, sizeof spec, "inverse3:port=%d%s", s->port, more);
    return ost_haptic_open(spec, &(ost_haptic_setup){.start = {.t = {10 * MM, 20 * MM, 30 * MM}, .qw = OST_Q30_ONE}},
                           device, err);
}

/* Skips the test if the driver was built without libwebsockets. */
static void skip_without_driver(void)
{
    ost_haptic_info info;
    for (int i = 0; i < ost_haptic_count(); i++)
        if (ost_haptic_describe(i, &info, NULL) == OST_OK && strcmp(info.name, "inverse3") == 0 && !info.available) {
            printf("# %s\n", info.reason);
            skip();
        }
}

/*
 * Reads the device every millisecond until the answer is `wanted`. If `wanted` is OST_HAPTIC_FRESH, also
 * waits until the tool is at x.
 */
static void await(ost_haptic *device, ost_haptic_answer wanted, ost_pm x, ost_haptic_state *state)
{
    const struct timespec pause = {.tv_nsec = 1000000};
    ost_haptic_answer got = OST_HAPTIC_NO_SAMPLE;
    for (int i = 0; i < ANSWER_MS; i++) {
        got = ost_haptic_read(device, state);
        if (got == wanted && (wanted != OST_HAPTIC_FRESH || llabs(state->pose.t.x - x) < 1000))
            return;
        if (got == OST_HAPTIC_LOST)
            break;
        nanosleep(&pause, NULL);
    }
    fail_msg("the device did not answer %d at x = %lld; the last answer is %d at x = %lld", wanted, (long long)x, got,
             (long long)state->pose.t.x);
}

/*
 * Moves the cursor and reads the tool's pose before and after. Returns false if tracking was
 * lost in between because the machine was too slow.
 */
static bool try_move(service *s, ost_haptic *device, int from_um, int to_um, ost_pose *from, ost_pose *to)
{
    const struct timespec pause = {.tv_nsec = 500000};
    const int um[2] = {from_um, to_um};
    ost_pose *const pose[2] = {from, to};
    bool seen = true;
    for (int i = 0; i < 2; i++) {
        atomic_store(&s->x_um, um[i]);
        const int begun = atomic_load(&s->answers);
        ost_haptic_state hand = {0};
        /*
         * The second answer after this point contains the new position. The service sends the third answer
         * only after the driver has received the second answer.
         */
        for (int k = 0; k < ANSWER_MS && (atomic_load(&s->answers) < begun + 3 || hand.pose.qw == 0); k++) {
            const ost_haptic_answer got = ost_haptic_read(device, &hand);
            assert_int_not_equal(got, OST_HAPTIC_LOST);
            seen = seen && (got != OST_HAPTIC_NOT_TRACKED || i == 0);
            nanosleep(&pause, NULL);
        }
        while (ost_haptic_read(device, &hand) == OST_HAPTIC_FRESH)
            nanosleep(&(struct timespec){.tv_nsec = 100000}, NULL);
        *pose[i] = hand.pose;
    }
    return seen;
}

static void move(service *s, ost_haptic *device, int from_um, int to_um, ost_pose *from, ost_pose *to)
{
    for (int tries = 0; tries < 100; tries++)
        if (try_move(s, device, from_um, to_um, from, to))
            return;
    fail_msg("the machine is too slow for a service that answers every millisecond");
}

static void await_message(service *s, const char *text)
{
    const struct timespec pause = {.tv_nsec = 1000000};
    bool found = false;
    for (int i = 0; i < ANSWER_MS && !found; i++) {
        pthread_mutex_lock(&s->lock);
        found = strstr(s->last, text) != NULL;
        pthread_mutex_unlock(&s->lock);
        nanosleep(&pause, NULL);
    }
    if (!found)
        fail_msg("the service did not receive '%s'; the last message is '%s'", text, s->last);
}

static void poses_and_forces(void **state)
{
    (void)state;
    skip_without_driver();
    ost_error err = {0};
    ost_haptic *device;
    ost_haptic_state hand = {0};
    service *s = begin_service(NONE, 0, false);
    atomic_store(&s->x_um, 1000);
    assert_ok(open_at(s, ",scale=200", &device, &err));
    assert_string_equal(s->first, "{\"session\":{\"force_render_full_state\":{}}}");
    /* When the device is first tracked, the tool is at its start pose. */
    await(device, OST_HAPTIC_FRESH, 10 * MM, &hand);
    assert_true(hand.pose.t.y == 20 * MM && hand.pose.t.z == 30 * MM && hand.pose.qw == OST_Q30_ONE);
    assert_int_equal(hand.tool, -1);
    assert_int_equal(hand.buttons, 1 | 1 << 2);
    /* The cursor moves 1 mm to the right, 2 mm away and 3 mm up. At scale 2, the tool moves by twice these distances
       along its x, -z and y axes. */
    ost_pose from, to;
    move(s, device, 1000, 2000, &from, &to);
    assert_true(llabs(to.t.x - from.t.x - 2 * MM) < 1000 && llabs(to.t.z - from.t.z + 4 * MM) < 1000 &&
                llabs(to.t.y - from.t.y - 6 * MM) < 1000);
    /* Forces are mapped to the device by the inverse rotation. */
    ost_haptic_write(device, &(ost_wrench){{1.5, 0.25, -2}, {0}});
    await_message(s, "\"device_id\":\"04EA\",\"commands\":{\"set_cursor_force\":{\"values\":{\"x\":1500000e-6,"
                     "\"y\":2000000e-6,\"z\":250000e-6}}}");
    ost_haptic_tally tally[OST_HAPTIC_COUNTS];
    assert_int_equal(ost_haptic_counts(device, tally), 2);
    assert_true(tally[0].value >= 3 && tally[1].value == 0);
    ost_haptic_close(device);
    /* The last force sent is zero. */
    await_message(s, "\"x\":0e-6,\"y\":0e-6,\"z\":0e-6");
    end_service(s);
}

static void grip_rotates_the_tool(void **state)
{
    (void)state;
    skip_without_driver();
    ost_error err = {0};
    ost_haptic *device;
    ost_haptic_state hand = {0};
    /*
     * Selects the second device. When the grip is first tracked, it is already rotated about the service's
     * z axis, which points up. Later rotations of the tool are relative to this orientation.
     */
    service *s = begin_service(NONE, 0, true);
    assert_int_equal(open_at(s, ",id=A-2", &device, &err), OST_ERR_UNAVAILABLE);
    assert_non_null(strstr(err.text, "has no device of that id"));
    end_service(s);
    s = begin_service(NONE, 0, true);
    atomic_store(&s->x_um, 200000);
    assert_ok(open_at(s, ",id=A-1", &device, &err));
    await(device, OST_HAPTIC_FRESH, 10 * MM, &hand);
    assert_true(hand.pose.qw == OST_Q30_ONE && hand.buttons == 1);
    /* The grip rotates by another 0.2 rad about the up axis, which is the tool's y. */
    ost_pose from, to;
    move(s, device, 200000, 300000, &from, &to);
    const double turned = 2 * (asin((double)to.qy / OST_Q30_ONE) - asin((double)from.qy / OST_Q30_ONE));
    assert_true(fabs(turned - 0.2) < 1e-4 && llabs(to.t.x - from.t.x - 100 * MM) < 1000);
    assert_true(abs(to.qx) < 2000 && abs(to.qz) < 2000);
    ost_haptic_close(device);
    end_service(s);
}

/*
 * Replaces sem_timedwait of the C library. If wake_late is set, a waiting thread continues 100 ms
 * after it is woken.
 */
static bool wake_late;

int sem_timedwait(sem_t *sem, const struct timespec *until)
{
    int (*next)(sem_t *, const struct timespec *);
    *(void **)&next = dlsym(RTLD_NEXT, "sem_timedwait");
    const int waited = next(sem, until);
    if (wake_late && waited == 0)
        nanosleep(&(struct timespec){.tv_nsec = 100000000}, NULL);
    return waited;
}

static void failing_service_is_reported(void **state)
{
    (void)state;
    skip_without_driver();
    static const struct {
        fault what;
        const char *message; /* expected message if the fault occurs before the first state */
    } cases[] = {
        {CLOSE, "closed the connection"}, {END, "closed the connection"},   {HUGE_FRAME, "no device found"},
        {LONG_MESSAGE, "too long"},       {GARBAGE, "reports no Inverse3"}, {WRONG, "reports no Inverse3"},
    };
    ost_error err = {0};
    ost_haptic *device;
    ost_haptic_state hand = {0};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        /* If the first answer is faulty, the device cannot be opened, and the error line states the reason. */
        service *s = begin_service(cases[i].what, 1, false);
        assert_int_equal(open_at(s, "", &device, &err), OST_ERR_UNAVAILABLE);
        assert_null(device);
        if (!strstr(err.text, cases[i].message))
            fail_msg("fault %d: the error '%s' does not contain '%s'", cases[i].what, err.text, cases[i].message);
        end_service(s);
        /* If a later answer is faulty, the device is lost. */
        s = begin_service(cases[i].what, 5, false);
        assert_ok(open_at(s, "", &device, &err));
        await(device, OST_HAPTIC_LOST, 0, &hand);
        ost_haptic_close(device);
        end_service(s);
    }
    /*
     * If the fault occurs after the first state and before ost_haptic_open continues, the device is opened
     * and then lost.
     */
    service *s = begin_service(CLOSE, 2, false);
    wake_late = true;
    const ost_status opened = open_at(s, "", &device, &err);
    wake_late = false;
    assert_int_equal(opened, OST_OK);
    await(device, OST_HAPTIC_LOST, 0, &hand);
    ost_haptic_close(device);
    end_service(s);
    s = begin_service(NO_UPGRADE, 1, false);
    assert_int_equal(open_at(s, "", &device, &err), OST_ERR_UNAVAILABLE);
    end_service(s);
}

static void missing_answers_lose_the_device(void **state)
{
    (void)state;
    skip_without_driver();
    ost_error err = {0};
    ost_haptic *device;
    ost_haptic_state hand = {0};
    service *s = begin_service(SILENCE, 5, false);
    assert_ok(open_at(s, "", &device, &err));
    await(device, OST_HAPTIC_FRESH, 10 * MM, &hand);
    /* The last pose is used for four ticks. Then tracking is lost, and after half a second the device is lost. */
    int without = 0, tracking_lost = 0;
    ost_haptic_answer got;
    while ((got = ost_haptic_read(device, &hand)) != OST_HAPTIC_LOST) {
        if (got == OST_HAPTIC_FRESH)
            without = tracking_lost = 0;
        without += got == OST_HAPTIC_NO_SAMPLE;
        tracking_lost += got == OST_HAPTIC_NOT_TRACKED;
        if (atomic_load(&s->answers) < 5)
            nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
    }
    assert_true(without == 4 && tracking_lost == 496);
    ost_haptic_close(device);
    end_service(s);
    /* No service listens on this port any more. */
    char spec[64];
    s = begin_service(NONE, 0, false);
    const int port = s->port;
    end_service(s);
    snprintf(spec, sizeof spec, "inverse3:port=%d", port);
    assert_int_equal(ost_haptic_open(spec, &(ost_haptic_setup){.start = {.qw = OST_Q30_ONE}}, &device, &err),
                     OST_ERR_UNAVAILABLE);
    assert_int_equal(ost_haptic_open("inverse3:port=0", NULL, &device, &err), OST_ERR_USAGE);
    assert_int_equal(ost_haptic_open("inverse3:id=a\"b", NULL, &device, &err), OST_ERR_USAGE);
    assert_int_equal(ost_haptic_open("inverse3:size=3", NULL, &device, &err), OST_ERR_USAGE);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(poses_and_forces),
        cmocka_unit_test(grip_rotates_the_tool),
        cmocka_unit_test(failing_service_is_reported),
        cmocka_unit_test(missing_answers_lose_the_device),
    };
    signal(SIGPIPE, SIG_IGN);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
