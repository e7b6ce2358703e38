/* SPDX-License-Identifier: Apache-2.0 */
#include "haptics/bridge.h"

#include <errno.h>
#include <math.h>
#include <netdb.h>
#include <poll.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "core/clock.h"
#include "core/vector.h"
#include "haptics/clutch.h"
#include "haptics/driver.h"
#include "haptics/newest.h"
#include "io/thread.h"

enum { HELLO_MS = 100, FORGET_MS = 1000, FLIGHTS = 1024, FAREWELLS = 3, DRAIN = 64 };
#define MS INT64_C(1000000)
#define PERIOD_S 1e-3
#define SPEED_SHARE 0.27 /* weight of a new speed in the moving average, for a bandwidth of 50 Hz */

typedef struct heard {
    link_packet state;
    int64_t at_ns;
} heard;

typedef struct bridge_signals {
    ost_pose pose;
    uint32_t buttons;
    int32_t tool;
    uint16_t flags;
} bridge_signals;

typedef struct bridge {
    const bridge_options *options;
    bridge_report *report;
    /* `wake` is an eventfd that is signalled for each new pose and at the end of the run */
    int socket, wake;
    pthread_t thread;
    link_key *key;
    newest in, out;
    heard heard[NEWEST_SLOTS];
    bridge_signals bridge_signals[NEWEST_SLOTS];
    _Atomic bool stop, met, busy, ended;
    /* The following fields are used only by the network thread. */
    uint64_t number, simulation, sequence;
    link_window window;
    int64_t heard_ns, hello_ns, sent_ns[FLIGHTS];
    /* The following fields are used only in the tick. */
    haptic_clutch clutch;
    ost_safety safety;
    double most_n, most_stiffness;
    /* newest state that has arrived, and the time of its arrival */
    heard last;
    bool has_state, limp, engaged_once;
    int64_t begin_ns, patience_ns;
    ost_pose given;          /* latest pose of the tool */
    double at[3], speed[3];  /* position (in `given`) and speed of the tool */
    bool has_at;
} bridge;

/* ------------------------------------------------------------- the thread */

static void send_packet(bridge *b, const link_packet *p)
{
    uint8_t bytes[LINK_STATE_BYTES];
    const size_t size = ost_link_seal(b->key, p, bytes);
    /* If no simulation listens, send() fails at once. A simulation that starts later receives a later packet. */
    if (size && send(b->socket, bytes, size, MSG_DONTWAIT | MSG_NOSIGNAL) == (ssize_t)size)
        b->report->sent++;
}

static void send_pose(bridge *b, const bridge_signals *s, uint16_t flags)
{
    const int64_t now = ost_clock_ns();
    const link_packet p = {.type = LINK_POSE,
                           .flags = (uint16_t)(s->flags | flags),
                           .bridge = b->number,
                           .simulation = b->simulation,
                           .sequence = ++b->sequence,
                           .t_ns = now,
                           .pose = s->pose,
                           .buttons = s->buttons,
                           .tool = s->tool};
    b->sent_ns[p.sequence % FLIGHTS] = now;
    send_packet(b, &p);
}

static void hello(bridge *b)
{
    const int64_t now = ost_clock_ns();
    if (now - b->hello_ns < HELLO_MS * MS)
        return;
    b->hello_ns = now;
    const link_packet p = {.type = LINK_HELLO, .bridge = b->number, .sequence = 1, .t_ns = now, .tool = -1};
    send_packet(b, &p);
}

static void take_state(bridge *b, const link_packet *p)
{
    uint64_t missing;
    const int64_t now = ost_clock_ns();
    if (p->type != LINK_STATE || p->bridge != b->number || (b->simulation && p->simulation != b->simulation)) {
        b->report->bad++;
        return;
    }
    if (p->flags & LINK_BUSY) {
        atomic_store(&b->busy, true);
        return;
    }
    if (!b->simulation) {
        /* The window of received sequence numbers begins at this packet. A packet that was sent before this run has a
           smaller number and is dropped. */
        b->simulation = p->simulation;
        b->sequence = p->answers;
        b->window = (link_window){.last = p->sequence - 1};
    }
    switch (ost_link_window_add(&b->window, p->sequence, &missing)) {
    case LINK_NEW: break;
    case LINK_LATE: b->report->late++; return;
    case LINK_REPLAYED: b->report->replayed++; return;
    }
    b->report->states++;
    b->heard_ns = now;
    const int64_t sent = b->sent_ns[p->answers % FLIGHTS];
    if (sent && p->answers <= b->sequence && b->sequence - p->answers < FLIGHTS) {
        ost_times_add(&b->report->round_trip, (uint64_t)(now - sent));
        b->sent_ns[p->answers % FLIGHTS] = 0;
    }
    if (p->flags & LINK_ENDED)
        atomic_store(&b->ended, true);
    atomic_store(&b->met, true);
    b->heard[b->in.back] = (heard){*p, now};
    newest_put(&b->in);
}

static void receive(bridge *b)
{
    for (int i = 0; i < DRAIN; i++) {
        uint8_t bytes[LINK_BUFFER_BYTES];
        link_packet p;
        const ssize_t size = recv(b->socket, bytes, sizeof bytes, MSG_DONTWAIT | MSG_TRUNC);
        if (size < 0 && errno != ECONNREFUSED)
            return;
        if (size < 0)
            continue;
        if ((size_t)size > sizeof bytes || ost_link_unseal(b->key, bytes, (size_t)size, &p) != LINK_GOOD)
            b->report->bad++;
        else
            take_state(b, &p);
    }
}

static void *run_network(void *user)
{
    bridge *b = user;
    struct pollfd wait[2] = {{.fd = b->socket, .events = POLLIN}, {.fd = b->wake, .events = POLLIN}};
    bridge_signals signals = {.tool = -1};
    while (!atomic_load(&b->stop)) {
        if (poll(wait, 2, HELLO_MS) < 0 && errno != EINTR)
            break;
        receive(b);
        uint64_t ignored;
        if (read(b->wake, &ignored, sizeof ignored) < 0 && errno != EAGAIN)
            break;
        /*
         * A restarted simulation has a new random number. Therefore, after a time without packets, the bridge sends a
         * hello packet again.
         */
        if (b->simulation && ost_clock_ns() - b->heard_ns > FORGET_MS * MS)
            b->simulation = 0;
        const bool fresh = newest_take(&b->out);
        if (fresh)
            signals = b->bridge_signals[b->out.front];
        if (!b->simulation)
            hello(b);
        else if (fresh)
            send_pose(b, &signals, 0);
    }
    signals.flags = 0;
    for (int i = 0; i < FAREWELLS && b->simulation; i++)
        send_pose(b, &signals, LINK_ENDED);
    return NULL;
}

/* --------------------------------------------------------------- the tick */

/* Updates the tool's speed from its current position and its position at the previous tick. */
static void follow_speed(bridge *b, const ost_pose *tool)
{
    const double at[3] = {(double)tool->t.x * 1e-12, (double)tool->t.y * 1e-12, (double)tool->t.z * 1e-12};
    for (int a = 0; a < 3; a++) {
        const double speed = b->has_at ? (at[a] - b->at[a]) / PERIOD_S : 0;
        b->speed[a] += SPEED_SHARE * (speed - b->speed[a]);
        b->at[a] = at[a];
    }
    b->has_at = true;
}

void ost_bridge_press(const link_packet *s, const double hand[3], const double speed[3], double most_stiffness,
                      double force[3])
{
    const double f[3] = {s->force_un[0] * 1e-6, s->force_un[1] * 1e-6, s->force_un[2] * 1e-6};
    const double size = ost_vector_length(f);
    const double at[3] = {(double)s->pose.t.x * 1e-12, (double)s->pose.t.y * 1e-12, (double)s->pose.t.z * 1e-12};
    memset(force, 0, 3 * sizeof *force);
    if (!(size > 1e-6))
        return;
    const double stiffness = fmin(s->stiffness * 1e-3, most_stiffness), damping = s->damping * 1e-3;
    double pushed = size;
    for (int a = 0; a < 3; a++)
        pushed += (stiffness * (at[a] - hand[a]) - damping * speed[a]) * f[a] / size;
    for (int a = 0; a < 3 && pushed > 0; a++)
        force[a] = pushed * f[a] / size;
}

static void let_go(bridge *b)
{
    b->report->limps += !b->limp && b->engaged_once;
    b->limp = true;
    b->has_at = false;
    memset(b->speed, 0, sizeof b->speed);
    ost_haptic_clutch_release(&b->clutch);
    ost_safety_stop(&b->safety);
}

static void speak(bridge *b, const ost_servo_sample *sample, uint16_t flags)
{
    const uint64_t one = 1;
    b->bridge_signals[b->out.back] = (bridge_signals){b->given, sample->state.buttons, sample->state.tool, flags};
    newest_put(&b->out);
    /* The write fails only if the eventfd's counter would exceed 2^64 - 2, its maximum. */
    if (write(b->wake, &one, sizeof one) < 0)
        return;
}

/* Fetches the newest state. Returns true if the state is recent and allows the device to hold the tool. */
static bool is_live(bridge *b)
{
    if (newest_take(&b->in)) {
        b->last = b->heard[b->in.front];
        b->has_state = true;
    }
    return b->has_state && !(b->last.state.flags & (LINK_AGAIN | LINK_ENDED)) &&
           ost_clock_ns() - b->last.at_ns < BRIDGE_LIMP_MS * MS;
}

static void hold(bridge *b, const ost_servo_sample *sample, ost_wrench *wrench)
{
    double at[3], q[4], force[3], torque[3] = {0};
    if (b->limp) {
        ost_haptic_clutch_engage_at(&b->clutch, &b->last.state.pose);
        b->limp = false;
        b->engaged_once = true;
    }
    ost_haptic_pose_to_metres(&sample->state.pose, at, q);
    b->given = ost_haptic_clutch_pose(&b->clutch, at, q);
    follow_speed(b, &b->given);
    speak(b, sample, LINK_SEEN);
    ost_bridge_press(&b->last.state, b->at, b->speed, b->most_stiffness, force);
    ost_haptic_clutch_vector(&b->clutch, force, wrench->force_n);
    ost_safety_step(&b->safety, &sample->state.pose, !sample->declared, sample->state.buttons, PERIOD_S,
                    wrench->force_n, torque);
    b->report->peak_n = fmax(b->report->peak_n, ost_vector_length(wrench->force_n));
}

static bool tick(void *user, const ost_servo_sample *sample, ost_wrench *wrench)
{
    bridge *b = user;
    bridge_report *r = b->report;
    if ((b->options->stop_requested && b->options->stop_requested()) || atomic_load(&b->ended))
        return false;
    if (!atomic_load(&b->met) && (ost_clock_ns() - b->begin_ns > b->patience_ns || atomic_load(&b->busy)))
        return false;
    const bool posed = !sample->tracking_lost && ost_pose_check(&sample->state.pose, NULL) == OST_OK;
    const bool live = is_live(b);
    r->fault_ticks += !sample->tracking_lost && !posed;
    if (posed && live) {
        hold(b, sample, wrench);
        return true;
    }
    let_go(b);
    r->limp_ticks += b->engaged_once;
    speak(b, sample, 0);
    return true;
}

/* ---------------------------------------------------------------- running */

/* Returns true if the text is a decimal number from 1 to 65535. getaddrinfo would reduce a port modulo 65536. */
static bool is_port(const char *text)
{
    const long port = strtol(text, NULL, 10); /* LONG_MAX if there are too many digits */
    return !text[strspn(text, "0123456789")] && port >= 1 && port <= 65535;
}

static ost_status open_socket(bridge *b, ost_error *err)
{
    const char *to = b->options->to, *colon = strrchr(to, ':');
    const struct addrinfo hints = {.ai_socktype = SOCK_DGRAM};
    struct addrinfo *found = NULL;
    char host[256], number[64] = "", port[16] = "";
    const bool bracketed = to[0] == '[' && colon && colon > to && colon[-1] == ']';
    const char *name = to + bracketed;
    const size_t length = colon ? (size_t)(colon - to) - 2 * bracketed : 0;
    if (!colon || length == 0 || length >= sizeof host || !colon[1])
        return ost_fail(err, OST_ERR_USAGE, "--to %.100s: expected HOST:PORT", to);
    if (!is_port(colon + 1))
        return ost_fail(err, OST_ERR_USAGE, "--to %.100s: port must be from 1 to 65535", to);
    memcpy(host, name, length);
    host[length] = '\0';
    const int error = getaddrinfo(host, colon + 1, &hints, &found);
    if (error)
        return ost_fail(err, OST_ERR_UNAVAILABLE, "%.100s: %s", to, gai_strerror(error));
    ost_status status = OST_OK;
    b->socket = socket(found->ai_family, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (b->socket < 0 || connect(b->socket, found->ai_addr, found->ai_addrlen) != 0)
        status = ost_fail(err, OST_ERR_UNAVAILABLE, "%.100s: cannot connect: %s", to, strerror(errno));
    else if (getnameinfo(found->ai_addr, found->ai_addrlen, number, sizeof number, port, sizeof port,
                         NI_NUMERICHOST | NI_NUMERICSERV) == 0)
        snprintf(b->report->to, BRIDGE_ADDRESS, strchr(number, ':') ? "[%s]:%s" : "%s:%s", number, port);
    freeaddrinfo(found);
    return status;
}

static ost_status run_thread(bridge *b, ost_haptic *device, ost_error *err)
{
    const uint64_t one = 1;
    const int error = ost_thread_begin(&b->thread, run_network, b);
    if (error)
        return ost_fail(err, OST_ERR_UNAVAILABLE, "cannot create a thread for the link: %s", strerror(error));
    const ost_servo_options how = {.ticks = b->options->ticks, .no_realtime = b->options->no_realtime};
    b->begin_ns = ost_clock_ns();
    ost_status status = ost_servo_run(device, &how, tick, NULL, b, &b->report->loop, err);
    atomic_store(&b->stop, true);
    if (write(b->wake, &one, sizeof one) < 0) {
        /* A failed write has no effect, because the thread wakes at least every HELLO_MS. */
    }
    pthread_join(b->thread, NULL);
    b->report->met = atomic_load(&b->met);
    b->report->busy = atomic_load(&b->busy);
    b->report->ended = atomic_load(&b->ended);
    return status;
}

ost_status ost_bridge_run(ost_haptic *device, const bridge_options *options, bridge_report *report, ost_error *err)
{
    memset(report, 0, sizeof *report);
    bridge *b = calloc(1, sizeof *b);
    if (!b)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a bridge");
    const ost_pose nowhere = ost_pose_identity();
    b->options = options;
    b->report = report;
    b->patience_ns = (options->patience_ms ? options->patience_ms : BRIDGE_PATIENCE_MS) * MS;
    b->socket = -1;
    b->limp = true;
    b->given = nowhere;
    b->clutch = ost_haptic_clutch_make(&nowhere, 1);
    b->most_stiffness = device->driver->max_stiffness_n_m;
    ost_safety_params safety = ost_safety_defaults();
    ost_haptic_limits own;
    if (ost_haptic_limits_get(device, &own) && ost_haptic_limits_usable(&own))
        safety.max_force_n = fmin(safety.max_force_n, OST_HAPTIC_LIMIT_SHARE * own.force_n);
    else if (device->driver->max_force_n > 0)
        safety.max_force_n = fmin(safety.max_force_n, device->driver->max_force_n);
    ost_safety_begin(&b->safety, &safety);
    newest_begin(&b->in);
    newest_begin(&b->out);
    b->wake = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    ost_status status = OST_OK;
    if (b->wake < 0 || !ost_link_random(&b->number))
        status = ost_fail(err, OST_ERR_UNAVAILABLE, "cannot create an eventfd or read a random number: %s",
                          strerror(errno));
    if (status == OST_OK)
        status = ost_link_key_read(options->key, &b->key, err);
    if (status == OST_OK)
        status = open_socket(b, err);
    if (status == OST_OK)
        status = run_thread(b, device, err);
    if (status == OST_OK && !report->met && report->busy)
        status = ost_fail(err, OST_ERR_UNAVAILABLE, "the simulation at %s has another bridge", report->to);
    else if (status == OST_OK && !report->met && !(options->stop_requested && options->stop_requested()))
        status = ost_fail(err, OST_ERR_UNAVAILABLE,
                          "no simulation answers at %s: none is running, or it has another key", report->to);
    if (b->socket >= 0)
        close(b->socket);
    if (b->wake >= 0)
        close(b->wake);
    ost_link_key_free(b->key);
    free(b);
    return status;
}
