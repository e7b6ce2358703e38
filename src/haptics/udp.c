/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The `udp` driver: a device on another machine, where osteon bridge runs.
 *
 *   bridge --pose--> thread --newest--> read, in the tick
 *   bridge <--state- thread <--newest-- write, in the tick
 *
 * A separate thread owns the socket. It checks received packets and answers each valid packet with
 * the newest state, so the bridge's clock drives the link. The tick takes no lock, makes no system
 * call and allocates no memory.
 *
 * The bridge computes the force on the device from the contents of the newest state: a pose that the bridge sent
 * before, the force at that pose, and the stiffness along this force (bridge.c). Therefore no feedback loop includes
 * the delay of the link. This driver checks each pose. If a hand could not have moved that far since the last pose, the
 * driver rejects the pose, and the bridge must engage its clutch again.
 */
#include <arpa/inet.h>
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

#include <osteon/force.h>

#include "core/clock.h"
#include "haptics/clutch.h"
#include "haptics/driver.h"
#include "haptics/link.h"
#include "haptics/newest.h"
#include "io/thread.h"

enum {
    PORT = 4707,
    LOST_MS = 5000,
    OWNER_MS = 1000,     /* time without packets, in ms, after which another bridge may take over */
    PATIENT_TICKS = 4,   /* number of ticks without a packet during which the last pose is used */
    BRIDGED_TICKS = 50,  /* number of ticks without a packet after which the next pose is always rejected */
    DRAIN = 64,          /* maximum number of packets received before the thread checks again whether it must end */
    NAME = 512,
    FAREWELLS = 3
};
/* maximum motion per tick in m, below the jump that an operation treats as a fault */
#define FAR_M 0.004
#define FAR_RAD 0.7

enum { GOOD, MALFORMED, WRONG_KEY, REPLAYED, LATE, MISSING, OTHERS, AGAIN, COUNTS };
static const char *const count_names[COUNTS] = {"good", "malformed", "wrong_key",        "replayed",
                                                "late", "missing",   "of_other_bridges", "too_far"};

typedef struct came {
    ost_pose pose;
    uint32_t buttons;
    int32_t tool;
    uint16_t flags;
} came;

typedef struct goes {
    ost_pose pose;
    ost_wrench wrench;
    bool again;
} goes;

struct haptic_instance {
    int socket, stop;      /* `stop` is an eventfd that ends the thread */
    pthread_t thread;
    link_key *key;
    char where[OST_HAPTIC_TEXT];
    _Atomic uint64_t counts[COUNTS];
    newest in, out;
    came came[NEWEST_SLOTS];
    goes goes[NEWEST_SLOTS];
    uint32_t stiffness, damping;
    /* The following fields are used only by the network thread. */
    uint64_t simulation, owner, sequence;
    int64_t owner_ns;
    link_window window;
    struct sockaddr_storage peer;
    socklen_t peer_size;
    bool has_peer;
    goes answer;
    /* The following fields are used only in the tick. */
    ost_pose given;
    int64_t ticks_without_sample, lost_ticks;
    bool met, tracking_lost, again;
};

typedef struct choice {
    int64_t port, lost_ms;
    char bind[NAME], key[NAME];
} choice;

static void count(haptic_instance *u, int what, uint64_t n)
{
    atomic_fetch_add_explicit(&u->counts[what], n, memory_order_relaxed);
}

/* ------------------------------------------------------------- the thread */

static void answer(haptic_instance *u, const struct sockaddr_storage *to, socklen_t size, uint64_t bridge,
                   uint16_t flags)
{
    uint8_t bytes[LINK_STATE_BYTES];
    if (newest_take(&u->out))
        u->answer = u->goes[u->out.front];
    const goes *g = &u->answer;
    link_packet p = {.type = LINK_STATE,
                     .flags = (uint16_t)(flags | (g->again ? LINK_AGAIN : 0)),
                     .bridge = bridge,
                     .simulation = u->simulation,
                     .sequence = ++u->sequence,
                     .answers = u->window.last,
                     .pose = g->pose,
                     .stiffness = u->stiffness,
                     .damping = u->damping};
    for (int a = 0; a < 3; a++) {
        p.force_un[a] = (int32_t)rint(fmax(-1e9, fmin(1e9, g->wrench.force_n[a] * 1e6)));
        p.torque_unm[a] = (int32_t)rint(fmax(-1e9, fmin(1e9, g->wrench.torque_nm[a] * 1e6)));
    }
    const size_t length = ost_link_seal(u->key, &p, bytes);
    /* A state that cannot be sent now is dropped, because the next state will be newer. */
    if (length && sendto(u->socket, bytes, length, MSG_DONTWAIT | MSG_NOSIGNAL, (const struct sockaddr *)to, size) < 0)
        return;
}

/* Processes a pose of the bridge. Returns true if the pose must be answered. */
static bool take_pose(haptic_instance *u, const link_packet *p)
{
    uint64_t missing;
    if (p->simulation != u->simulation) {
        count(u, REPLAYED, 1); /* this packet belongs to a different run of the simulation */
        return false;
    }
    const int64_t now = ost_clock_ns();
    if (u->owner && u->owner != p->bridge && now - u->owner_ns < OWNER_MS * INT64_C(1000000)) {
        count(u, OTHERS, 1);
        return false;
    }
    switch (ost_link_window_add(&u->window, p->sequence, &missing)) {
    case LINK_NEW: break;
    case LINK_LATE: count(u, LATE, 1); return false;
    case LINK_REPLAYED: count(u, REPLAYED, 1); return false;
    }
    count(u, GOOD, 1);
    count(u, MISSING, u->owner ? missing : 0);
    u->owner = p->bridge;
    u->owner_ns = now;
    u->came[u->in.back] = (came){p->pose, p->buttons, p->tool, p->flags};
    newest_put(&u->in);
    return true;
}

static void take_packet(haptic_instance *u, const uint8_t *bytes, size_t size, const struct sockaddr_storage *from,
                        socklen_t from_size)
{
    link_packet p;
    const link_verdict verdict = ost_link_unseal(u->key, bytes, size, &p);
    if (verdict != LINK_GOOD || p.type == LINK_STATE) {
        count(u, verdict == LINK_WRONG_KEY ? WRONG_KEY : MALFORMED, 1);
        return;
    }
    if (p.type == LINK_HELLO) {
        const bool busy = u->owner && u->owner != p.bridge &&
                          ost_clock_ns() - u->owner_ns < OWNER_MS * INT64_C(1000000);
        count(u, busy ? OTHERS : GOOD, 1);
        answer(u, from, from_size, p.bridge, busy ? LINK_BUSY : 0);
    } else if (take_pose(u, &p)) {
        u->peer = *from;
        u->peer_size = from_size;
        u->has_peer = true;
        answer(u, from, from_size, p.bridge, 0);
    }
}

static void *run_network(void *user)
{
    haptic_instance *u = user;
    struct pollfd wait[2] = {{.fd = u->socket, .events = POLLIN}, {.fd = u->stop, .events = POLLIN}};
    while (!(wait[1].revents & POLLIN)) {
        if (poll(wait, 2, -1) < 0 && errno != EINTR)
            break;
        for (int i = 0; i < DRAIN; i++) {
            uint8_t bytes[LINK_BUFFER_BYTES];
            struct sockaddr_storage from;
            socklen_t from_size = sizeof from;
            /* With MSG_TRUNC, recvfrom returns the packet's full length, so that packets that are too long are
               rejected. */
            const ssize_t size = recvfrom(u->socket, bytes, sizeof bytes, MSG_DONTWAIT | MSG_TRUNC,
                                          (struct sockaddr *)&from, &from_size);
            if (size < 0)
                break;
            if ((size_t)size > sizeof bytes)
                count(u, MALFORMED, 1);
            else
                take_packet(u, bytes, (size_t)size, &from, from_size);
        }
    }
    for (int i = 0; i < FAREWELLS && u->has_peer; i++)
        answer(u, &u->peer, u->peer_size, u->owner, LINK_ENDED);
    return NULL;
}

/* ---------------------------------------------------------------- opening */

static ost_status take(void *user, const char *key, const char *value, ost_error *err)
{
    choice *c = user;
    if (strcmp(key, "port") == 0)
        return ost_haptic_integer("udp", key, value, 0, 65535, &c->port, err);
    if (strcmp(key, "lost") == 0)
        return ost_haptic_integer("udp", key, value, 100, 3600000, &c->lost_ms, err);
    char *text = strcmp(key, "bind") == 0 ? c->bind : strcmp(key, "key") == 0 ? c->key : NULL;
    if (!text)
        return ost_fail(err, OST_ERR_USAGE, "device udp: unknown option '%s'; expected key, port, bind or lost", key);
    if (strlen(value) >= NAME)
        return ost_fail(err, OST_ERR_USAGE, "device udp: %s=%.60s...: longer than %d bytes", key, value, NAME - 1);
    strcpy(text, value);
    return OST_OK;
}

static ost_status open_socket(haptic_instance *u, const choice *c, ost_error *err)
{
    const struct addrinfo hints = {.ai_flags = AI_PASSIVE | AI_NUMERICHOST | AI_NUMERICSERV, .ai_socktype = SOCK_DGRAM};
    struct addrinfo *found = NULL;
    struct sockaddr_storage own = {0};
    socklen_t size = sizeof own;
    char port[8], host[64] = "";
    snprintf(port, sizeof port, "%d", (int)c->port);
    if (getaddrinfo(c->bind, port, &hints, &found) != 0)
        return ost_fail(err, OST_ERR_USAGE,
                        "device udp: bind=%.60s; expected a numeric address such as 127.0.0.1 or ::1", c->bind);
    ost_status status = OST_OK;
    u->socket = socket(found->ai_family, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (u->socket < 0 || bind(u->socket, found->ai_addr, found->ai_addrlen) != 0 ||
        getsockname(u->socket, (struct sockaddr *)&own, &size) != 0 ||
        getnameinfo((struct sockaddr *)&own, size, host, sizeof host, port, sizeof port,
                    NI_NUMERICHOST | NI_NUMERICSERV) != 0)
        status = ost_fail(err, OST_ERR_UNAVAILABLE, "device udp: cannot listen at %.60s port %s: %s", c->bind, port,
                          strerror(errno));
    freeaddrinfo(found);
    if (status == OST_OK)
        snprintf(u->where, sizeof u->where,
                 strchr(host, ':') ? "waits for a bridge at [%s]:%s" : "waits for a bridge at %s:%s", host, port);
    return status;
}

static ost_status start_thread(haptic_instance *u, ost_error *err)
{
    const int error = ost_thread_begin(&u->thread, run_network, u);
    return error ? ost_fail(err, OST_ERR_UNAVAILABLE, "device udp: cannot create a thread for its socket: %s",
                            strerror(error)) : OST_OK;
}

static void forget(haptic_instance *u)
{
    if (u->socket >= 0)
        close(u->socket);
    if (u->stop >= 0)
        close(u->stop);
    ost_link_key_free(u->key);
    free(u);
}

static ost_status udp_open(const char *options, const ost_haptic_setup *setup, haptic_instance **out, ost_error *err)
{
    choice c = {.port = PORT, .lost_ms = LOST_MS, .bind = "127.0.0.1"};
    ost_status status = ost_haptic_options("udp", options, take, &c, err);
    if (status == OST_OK && !c.key[0])
        status = ost_fail(err, OST_ERR_USAGE, "device udp: missing option key=FILE, the key of the bridge; to create "
                          "one: (umask 077; head -c 32 /dev/urandom >FILE)");
    if (status == OST_OK)
        status = ost_pose_check(&setup->start, err);
    if (status != OST_OK)
        return status;
    haptic_instance *u = calloc(1, sizeof *u);
    if (!u)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for device udp");
    const ost_force_params force = ost_force_defaults();
    u->socket = -1;
    u->stiffness = (uint32_t)(force.stiffness * 1e3);
    u->damping = (uint32_t)(force.damping * 1e3);
    u->lost_ticks = c.lost_ms;
    u->given = u->answer.pose = setup->start;
    u->tracking_lost = true;
    newest_begin(&u->in);
    newest_begin(&u->out);
    u->stop = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    if (u->stop < 0 || !ost_link_random(&u->simulation))
        status = ost_fail(err, OST_ERR_UNAVAILABLE, "device udp: cannot create an eventfd or read a random number: %s",
                          strerror(errno));
    if (status == OST_OK)
        status = ost_link_key_read(c.key, &u->key, err);
    if (status == OST_OK)
        status = open_socket(u, &c, err);
    if (status == OST_OK)
        status = start_thread(u, err);
    if (status != OST_OK) {
        forget(u);
        return status;
    }
    *out = u;
    return OST_OK;
}

static void udp_close(haptic_instance *u)
{
    const uint64_t one = 1;
    /* The write cannot fail, because the eventfd's counter is 0. */
    if (write(u->stop, &one, sizeof one) == (ssize_t)sizeof one)
        pthread_join(u->thread, NULL);
    forget(u);
}

/* --------------------------------------------------------------- the tick */

/*
 * Moves u->given toward *to, by at most the distance and angle allowed in one tick. Returns false
 * if no hand could have reached *to in the time since the last packet.
 */
static bool follow(haptic_instance *u, const ost_pose *to)
{
    double a[3], b[3], p[4], q[4], square = 0, dot = 0;
    ost_pose_to_doubles(&u->given, a, p);
    ost_pose_to_doubles(to, b, q);
    for (int i = 0; i < 3; i++)
        square += (b[i] - a[i]) * (b[i] - a[i]) * 1e-6;
    for (int i = 0; i < 4; i++)
        dot += p[i] * q[i];
    const double way = sqrt(square), angle = 2 * acos(fmin(1, fabs(dot))), ticks = (double)u->ticks_without_sample + 1;
    if (u->ticks_without_sample > BRIDGED_TICKS || way > FAR_M * ticks || angle > FAR_RAD * fmin(ticks, 4))
        return false;
    if (way <= FAR_M && angle <= FAR_RAD) {
        u->given = *to;
        return true;
    }
    const double share = fmin(way > FAR_M ? FAR_M / way : 1, angle > FAR_RAD ? FAR_RAD / angle : 1),
                 side = dot < 0 ? -1 : 1;
    double at[3], turned[4], length = 0;
    for (int i = 0; i < 3; i++)
        at[i] = (a[i] + share * (b[i] - a[i])) * 1e-3;
    for (int i = 0; i < 4; i++) {
        turned[i] = (1 - share) * p[i] + share * side * q[i];
        length += turned[i] * turned[i];
    }
    for (int i = 0; i < 4; i++)
        turned[i] /= sqrt(length);
    u->given = ost_haptic_pose_quantise(at, turned);
    return true;
}

static ost_haptic_answer tracking_lost(haptic_instance *u)
{
    u->tracking_lost = true;
    return OST_HAPTIC_NOT_TRACKED;
}

static ost_haptic_answer silence(haptic_instance *u)
{
    if (!u->met)
        return OST_HAPTIC_NOT_TRACKED;
    u->ticks_without_sample++;
    if (u->ticks_without_sample > u->lost_ticks)
        return OST_HAPTIC_LOST;
    return u->tracking_lost || u->ticks_without_sample > PATIENT_TICKS ? tracking_lost(u) : OST_HAPTIC_NO_SAMPLE;
}

static ost_haptic_answer udp_read(haptic_instance *u, ost_haptic_state *state)
{
    if (!newest_take(&u->in))
        return silence(u);
    const came *c = &u->came[u->in.front];
    u->met = true;
    if (c->flags & LINK_ENDED)
        return OST_HAPTIC_ENDED;
    if (!(c->flags & LINK_SEEN)) {
        /* The bridge has released the tool. When a pose with LINK_SEEN arrives, the tool follows
           the device again from the tool's current position. */
        u->again = false;
        u->ticks_without_sample = 0;
        return tracking_lost(u);
    }
    if (u->again || !follow(u, &c->pose)) {
        if (!u->again)
            count(u, AGAIN, 1);
        u->again = true;
        u->ticks_without_sample = 0;
        return tracking_lost(u);
    }
    u->ticks_without_sample = 0;
    u->tracking_lost = false;
    *state = (ost_haptic_state){.pose = u->given, .tool = c->tool, .buttons = c->buttons};
    return OST_HAPTIC_FRESH;
}

static void udp_write(haptic_instance *u, const ost_wrench *wrench)
{
    u->goes[u->out.back] = (goes){u->given, *wrench, u->again};
    newest_put(&u->out);
}

static void udp_about(haptic_instance *u, char text[OST_HAPTIC_TEXT])
{
    memcpy(text, u->where, OST_HAPTIC_TEXT);
}

static int udp_counts(haptic_instance *u, ost_haptic_tally out[OST_HAPTIC_COUNTS])
{
    for (int i = 0; i < COUNTS; i++)
        out[i] = (ost_haptic_tally){count_names[i], atomic_load_explicit(&u->counts[i], memory_order_relaxed)};
    return COUNTS;
}

const haptic_driver ost_haptic_udp = {
    .name = "udp",
    .description = "a device on another machine, by osteon bridge there: udp:key=FILE",
    .caps = OST_HAPTIC_FORCE | OST_HAPTIC_ORIENTATION | OST_HAPTIC_TOOL,
    .max_force_n = 3.3,
    .max_stiffness_n_m = 300,
    .buttons = {{"button1", OST_ACTION_MOTOR},
                {"button2", OST_ACTION_TOOL},
                {"button3", OST_ACTION_CLUTCH},
                {"button4", OST_ACTION_HOME}},
    .open = udp_open,
    .close = udp_close,
    .read = udp_read,
    .write = udp_write,
    .about = udp_about,
    .counts = udp_counts,
};
