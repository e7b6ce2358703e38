/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The `inverse3` driver: Haply's Inverse3 with a VerseGrip, through the vendor's service on the
 * same machine.
 *
 *   service <--force-- thread <--newest-- write, in the tick      JSON over a WebSocket,
 *   service --state--> thread --newest--> read, in the tick       127.0.0.1, port 10001
 *
 * The service answers each force with a state and sends nothing else. After each state, the thread
 * sends the newest force, or zero if there is none, but no sooner than one millisecond after the
 * previous force. Units are metres and newtons; x points to the right, y away from the operator,
 * and z up. The tool's orientation is that of the grip; without a grip, it does not change.
 *
 * The device moves the tool relative to its start. If more than a few ticks pass without a state,
 * the motion afterwards continues from the tool's current position. After half a second without a
 * state, the device is considered lost.
 *
 * The file has more than 500 lines, because all parts of the protocol share one connection.
 */
#include "config.h"

#include <string.h>

#include "haptics/driver.h"

#ifdef HAVE_LIBWEBSOCKETS

#include <errno.h>
#include <jansson.h>
#include <libwebsockets.h>
#include <math.h>
#include <pthread.h>
#include <semaphore.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "core/clock.h"
#include "haptics/clutch.h"
#include "haptics/newest.h"
#include "io/thread.h"

enum {
    PORT = 10001,
    MESSAGE_MOST = 65536,  /* maximum size of a state in bytes; the service sends a few hundred bytes */
    OPEN_MS = 3000,        /* time limit in ms for the first state */
    CLOSE_MS = 500,        /* time limit in ms for the last force */
    PATIENT_TICKS = 4,
    LOST_TICKS = 500,
    GARBAGE_MOST = 100,    /* number of consecutive invalid messages after which the device fails */
    ID = 33
};
#define PACE_NS INT64_C(1000000)
#define FAR_M 10.0

typedef struct came {
    double at[3], q[4]; /* pose in a frame with y up and z toward the operator */
    uint32_t buttons;
} came;

struct haptic_instance {
    struct lws_context *context;
    pthread_t thread;
    /* each semaphore is posted once: `met` at the first state or on a failure, and `over` at the end of the thread */
    sem_t met, over;
    newest in, out;
    came came[NEWEST_SLOTS];
    double force[NEWEST_SLOTS][3]; /* force in N, in the same frame as the positions in `came` */
    _Atomic bool stop, lost;
    _Atomic uint64_t states, garbage;
    char wanted[ID];      /* value of the `id` option; "" selects the first device */
    /* The following fields are used only by the network thread. */
    struct lws *wsi;
    char id[ID];
    char message[MESSAGE_MOST];
    size_t size;
    char why[160];        /* reason for the failure */
    int bad;              /* number of consecutive invalid messages */
    bool has_met, has_greeted, has_ended;
    int64_t sent_ns, stop_ns;
    /* The following fields are used only in the tick. */
    haptic_clutch clutch;
    int ticks_without_sample;
    bool tracking_lost;
};

static void meet(haptic_instance *h)
{
    if (!h->has_met)
        sem_post(&h->met);
    h->has_met = true;
}

static void fail(haptic_instance *h, const char *why)
{
    if (!h->why[0])
        snprintf(h->why, sizeof h->why, "%s", why);
    atomic_store(&h->lost, true);
    meet(h);
}

/* --------------------------------------------------------------- messages */

/*
 * Reads the numbers with the given names from an object. Returns false if a number is missing, not finite, or exceeds
 * the limit `most` in absolute value.
 */
static bool numbers(const json_t *object, const char *const *names, int count, double most, double *out)
{
    for (int i = 0; i < count; i++) {
        const json_t *n = json_object_get(object, names[i]);
        if (!json_is_number(n))
            return false;
        out[i] = json_number_value(n);
        if (!(fabs(out[i]) <= most))
            return false;
    }
    return true;
}

/* Returns a property of an object. The service stores it in the object's member "state" or in the object itself. */
static const json_t *member(const json_t *thing, const char *name)
{
    const json_t *within = json_object_get(json_object_get(thing, "state"), name);
    return within ? within : json_object_get(thing, name);
}

static bool is_id(const char *text)
{
    const size_t length = strlen(text);
    return length > 0 && length < ID &&
           strspn(text, "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz_-") == length;
}

static const json_t *device_of(const haptic_instance *h, const json_t *list, const char **id)
{
    for (size_t i = 0; i < json_array_size(list); i++) {
        const json_t *device = json_array_get(list, i);
        *id = json_string_value(json_object_get(device, "device_id"));
        if (*id && is_id(*id) && (!h->wanted[0] || strcmp(*id, h->wanted) == 0))
            return device;
    }
    return NULL;
}

static bool take_grip(const json_t *root, came *c)
{
    static const char *const kinds[] = {"wireless_verse_grip", "verse_grip"}, *const wxyz[] = {"w", "x", "y", "z"};
    static const char *const letters[] = {"a", "b", "c", "d"};
    for (int k = 0; k < 2; k++) {
        const json_t *grip = json_array_get(json_object_get(root, kinds[k]), 0), *turned = member(grip, "orientation");
        double q[4], length = 0;
        if (!turned)
            continue;
        if (!numbers(turned, wxyz, 4, 1.1, q))
            return false;
        for (int i = 0; i < 4; i++)
            length += q[i] * q[i];
        if (!(fabs(length - 1) <= 0.05))
            return false;
        const double to_ours[4] = {q[0], q[1], q[3], -q[2]};
        for (int i = 0; i < 4; i++)
            c->q[i] = to_ours[i] / sqrt(length);
        c->buttons = json_is_true(member(grip, "button"));
        for (int b = 0; b < 4; b++)
            c->buttons |= json_is_true(json_object_get(member(grip, "buttons"), letters[b])) ? 1u << b : 0;
        return true;
    }
    return true;
}

static bool take_state(haptic_instance *h, const json_t *root)
{
    static const char *const xyz[] = {"x", "y", "z"};
    const char *id = NULL;
    const json_t *device = device_of(h, json_object_get(root, "inverse3"), &id);
    double at[3];
    came c = {.q = {1, 0, 0, 0}};
    if (!device || !numbers(member(device, "cursor_position"), xyz, 3, FAR_M, at) || !take_grip(root, &c))
        return false;
    strcpy(h->id, id);
    memcpy(c.at, (double[3]){at[0], at[2], -at[1]}, sizeof c.at);
    h->came[h->in.back] = c;
    newest_put(&h->in);
    return true;
}

static void take_message(haptic_instance *h)
{
    json_t *root = json_loadb(h->message, h->size, 0, NULL);
    const bool good = root && take_state(h, root);
    json_decref(root);
    atomic_fetch_add(good ? &h->states : &h->garbage, 1);
    h->bad = good ? 0 : h->bad + 1;
    if (good)
        meet(h);
    if (h->bad == GARBAGE_MOST)
        fail(h, "the service reports no Inverse3");
}

/* Writes a command. Each number is written as an integer with an exponent, so that the text does
   not depend on the locale. */
static int write_command(haptic_instance *h, bool nothing, char *text, size_t capacity)
{
    long long f[3];
    if (newest_take(&h->out)) {
        /* If no new force was written, the slot still contains the previous force. */
    }
    const double *force = h->force[h->out.front];
    for (int a = 0; a < 3; a++)
        f[a] = nothing ? 0 : llrint(force[a] * 1e6);
    /* The first message selects the form of the answers. It is sent again until the device's id is known, because a
       force cannot be sent without the id. */
    if (!h->has_greeted || !h->id[0])
        return snprintf(text, capacity, "{\"session\":{\"force_render_full_state\":{}}}");
    return snprintf(text, capacity,
                    "{\"inverse3\":[{\"device_id\":\"%s\",\"commands\":{\"set_cursor_force\":{\"values\":{\"x\":%llde-"
                    "6,\"y\":%llde-6,\"z\":%llde-6}}}}]}",
                    h->id, f[0], -f[2], f[1]);
}

static int send_command(haptic_instance *h, struct lws *wsi)
{
    unsigned char capacity[LWS_PRE + 512];
    const bool last = atomic_load(&h->stop);
    const int64_t wait_ns = h->sent_ns + PACE_NS - ost_clock_ns();
    if (wait_ns > 0 && wait_ns <= PACE_NS)
        nanosleep(&(struct timespec){.tv_nsec = wait_ns}, NULL);
    const int length = write_command(h, last, (char *)capacity + LWS_PRE, 512);
    h->has_greeted = true;
    h->sent_ns = ost_clock_ns();
    const int written = lws_write(wsi, capacity + LWS_PRE, (size_t)length, LWS_WRITE_TEXT);
    h->has_ended = last;
    return last || written < length ? -1 : 0; /* the return value -1 closes the connection */
}

static int receive(haptic_instance *h, struct lws *wsi, const void *bytes, size_t size)
{
    if (lws_is_first_fragment(wsi))
        h->size = 0;
    if (size > MESSAGE_MOST - h->size || lws_remaining_packet_payload(wsi) > MESSAGE_MOST) {
        fail(h, "the service's message is too long");
        return -1;
    }
    memcpy(h->message + h->size, bytes, size);
    h->size += size;
    if (!lws_is_final_fragment(wsi) || lws_remaining_packet_payload(wsi))
        return 0;
    take_message(h);
    if (atomic_load(&h->lost))
        return -1;
    lws_callback_on_writable(wsi);
    return 0;
}

static int on_event(struct lws *wsi, enum lws_callback_reasons reason, void *user, void *bytes, size_t size)
{
    (void)user;
    haptic_instance *h = lws_context_user(lws_get_context(wsi));
    switch ((int)reason) {
    case LWS_CALLBACK_CLIENT_ESTABLISHED:
        lws_callback_on_writable(wsi);
        break;
    case LWS_CALLBACK_CLIENT_RECEIVE:
        return receive(h, wsi, bytes, size);
    case LWS_CALLBACK_CLIENT_WRITEABLE:
        return send_command(h, wsi);
    case LWS_CALLBACK_CLIENT_CONNECTION_ERROR:
        h->wsi = NULL;
        fail(h, bytes ? bytes : "it does not answer");
        break;
    case LWS_CALLBACK_CLIENT_CLOSED:
        h->wsi = NULL;
        fail(h, "the service closed the connection");
        break;
    case LWS_CALLBACK_EVENT_WAIT_CANCELLED:
        if (h->wsi && atomic_load(&h->stop) && h->has_greeted && !h->has_ended)
            lws_callback_on_writable(h->wsi);
        break;
    default:
        break;
    }
    return 0;
}

static const struct lws_protocols protocols[] = {{"haply", on_event, 0, 4096, 0, NULL, 0},
                                                 {NULL, NULL, 0, 0, 0, NULL, 0}};

static void *run_connection(void *user)
{
    haptic_instance *h = user;
    for (;;) {
        if (lws_service(h->context, 0) < 0) {
            fail(h, "libwebsockets failed");
            break;
        }
        if (!atomic_load(&h->stop))
            continue;
        h->stop_ns = h->stop_ns ? h->stop_ns : ost_clock_ns();
        if (!h->wsi || h->has_ended || !h->has_greeted || ost_clock_ns() - h->stop_ns > CLOSE_MS * INT64_C(1000000))
            break;
    }
    sem_post(&h->over);
    return NULL;
}

/* ---------------------------------------------------------------- opening */

typedef struct choice {
    int64_t port;
    double percent;
    char id[ID];
} choice;

static ost_status take(void *user, const char *key, const char *value, ost_error *err)
{
    choice *c = user;
    if (strcmp(key, "port") == 0)
        return ost_haptic_integer("inverse3", key, value, 1, 65535, &c->port, err);
    if (strcmp(key, "scale") == 0)
        return ost_haptic_number("inverse3", key, value, 1, 1000, &c->percent, err);
    if (strcmp(key, "id") != 0)
        return ost_fail(err, OST_ERR_USAGE, "device inverse3: unknown option '%s'; expected id, port or scale", key);
    if (!is_id(value))
        return ost_fail(err, OST_ERR_USAGE,
                        "device inverse3: id=%.40s; expected letters, digits, '-' and '_', %d at most", value,
                        ID - 1);
    strcpy(c->id, value);
    return OST_OK;
}

static bool wait_for(sem_t *sem, int ms)
{
    struct timespec until;
    clock_gettime(CLOCK_REALTIME, &until);
    until.tv_sec += ms / 1000;
    until.tv_nsec += ms % 1000 * 1000000L;
    until.tv_sec += until.tv_nsec / 1000000000L;
    until.tv_nsec %= 1000000000L;
    int waited;
    do
        waited = sem_timedwait(sem, &until);
    while (waited != 0 && errno == EINTR);
    return waited == 0;
}

static void stop_thread(haptic_instance *h)
{
    atomic_store(&h->stop, true);
    do
        lws_cancel_service(h->context);
    while (!wait_for(&h->over, 20));
    pthread_join(h->thread, NULL);
}

static void forget(haptic_instance *h)
{
    if (h->context)
        lws_context_destroy(h->context);
    sem_destroy(&h->met);
    sem_destroy(&h->over);
    free(h);
}

static ost_status connect_to(haptic_instance *h, const choice *c, ost_error *err)
{
    const struct lws_context_creation_info info = {.port = CONTEXT_PORT_NO_LISTEN,
                                                   .protocols = protocols,
                                                   .gid = (gid_t)-1,
                                                   .uid = (uid_t)-1,
                                                   .fd_limit_per_thread = 16,
                                                   .user = h};
    lws_set_log_level(0, NULL);
    h->context = lws_create_context(&info);
    if (!h->context)
        return ost_fail(err, OST_ERR_UNAVAILABLE, "device inverse3: libwebsockets cannot create a context");
    const struct lws_client_connect_info to = {.context = h->context,
                                               .address = "127.0.0.1",
                                               .port = (int)c->port,
                                               .path = "/",
                                               .host = "localhost",
                                               .origin = "localhost",
                                               .local_protocol_name = protocols[0].name,
                                               .pwsi = &h->wsi};
    if (!lws_client_connect_via_info(&to))
        return ost_fail(err, OST_ERR_UNAVAILABLE, "device inverse3: Haply's service does not answer at 127.0.0.1:%d",
                        (int)c->port);
    const int error = ost_thread_begin(&h->thread, run_connection, h);
    if (error)
        return ost_fail(err, OST_ERR_UNAVAILABLE, "device inverse3: cannot create a thread for its connection: %s",
                        strerror(error));
    /* If the service fails after it has sent its first state, opening still succeeds. The next read then reports
       that the device is lost. */
    if (wait_for(&h->met, OPEN_MS) && atomic_load(&h->states) > 0)
        return OST_OK;
    stop_thread(h);
    return ost_fail(err, OST_ERR_UNAVAILABLE,
                    h->wanted[0] ? "device inverse3: Haply's service at 127.0.0.1:%d has no device of that id: %s"
                                 : "device inverse3: no device found through Haply's service at 127.0.0.1:%d: %s",
                    (int)c->port, h->why[0] ? h->why : "no answer");
}

static ost_status inverse3_open(const char *options, const ost_haptic_setup *setup, haptic_instance **out,
                                ost_error *err)
{
    choice c = {.port = PORT, .percent = 100};
    ost_status status = ost_haptic_options("inverse3", options, take, &c, err);
    if (status == OST_OK)
        status = ost_pose_check(&setup->start, err);
    if (status != OST_OK)
        return status;
    haptic_instance *h = calloc(1, sizeof *h);
    if (!h)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for device inverse3");
    memcpy(h->wanted, c.id, ID);
    h->clutch = ost_haptic_clutch_make(&setup->start, c.percent / 100);
    ost_haptic_clutch_lay(&h->clutch);
    h->tracking_lost = true;
    newest_begin(&h->in);
    newest_begin(&h->out);
    sem_init(&h->met, 0, 0);
    sem_init(&h->over, 0, 0);
    status = connect_to(h, &c, err);
    if (status != OST_OK)
        forget(h);
    else
        *out = h;
    return status;
}

static void inverse3_close(haptic_instance *h)
{
    stop_thread(h);
    forget(h);
}

/* --------------------------------------------------------------- the tick */

static ost_haptic_answer inverse3_read(haptic_instance *h, ost_haptic_state *state)
{
    if (!newest_take(&h->in)) {
        if (atomic_load(&h->lost) || ++h->ticks_without_sample > LOST_TICKS)
            return OST_HAPTIC_LOST;
        if (!h->tracking_lost && h->ticks_without_sample <= PATIENT_TICKS)
            return OST_HAPTIC_NO_SAMPLE;
        h->tracking_lost = true;
        ost_haptic_clutch_release(&h->clutch);
        return OST_HAPTIC_NOT_TRACKED;
    }
    const came *c = &h->came[h->in.front];
    h->ticks_without_sample = 0;
    h->tracking_lost = false;
    *state = (ost_haptic_state){
        .pose = ost_haptic_clutch_pose(&h->clutch, c->at, c->q), .tool = -1, .buttons = c->buttons};
    return OST_HAPTIC_FRESH;
}

static void inverse3_write(haptic_instance *h, const ost_wrench *wrench)
{
    ost_haptic_clutch_vector(&h->clutch, wrench->force_n, h->force[h->out.back]);
    newest_put(&h->out);
}

static int inverse3_counts(haptic_instance *h, ost_haptic_tally out[OST_HAPTIC_COUNTS])
{
    out[0] = (ost_haptic_tally){"states", atomic_load(&h->states)};
    out[1] = (ost_haptic_tally){"garbage", atomic_load(&h->garbage)};
    return 2;
}

#define USABLE NULL
#define COUNTS inverse3_counts
#else

static bool inverse3_usable(char reason[256])
{
    strcpy(reason, "built without libwebsockets; install libwebsockets-dev and build again");
    return false;
}

static ost_status inverse3_open(const char *options, const ost_haptic_setup *setup, haptic_instance **out,
                                ost_error *err)
{
    (void)options;
    (void)setup;
    *out = NULL;
    return ost_fail(err, OST_ERR_UNAVAILABLE, "device inverse3: built without libwebsockets");
}

static void inverse3_close(haptic_instance *instance)
{
    (void)instance;
}

static ost_haptic_answer inverse3_read(haptic_instance *instance, ost_haptic_state *state)
{
    (void)instance;
    (void)state;
    return OST_HAPTIC_LOST;
}

static void inverse3_write(haptic_instance *instance, const ost_wrench *wrench)
{
    (void)instance;
    (void)wrench;
}

#define USABLE inverse3_usable
#define COUNTS NULL
#endif

const haptic_driver ost_haptic_inverse3 = {
    .name = "inverse3",
    .description = "Haply's Inverse3 with a VerseGrip, by the vendor's service",
    .caps = OST_HAPTIC_FORCE | OST_HAPTIC_ORIENTATION,
    .max_force_n = 3.3, /* maximum force in N that the driver sends to the device */
    .max_stiffness_n_m = 300,
    .buttons = {{"a", OST_ACTION_MOTOR}, {"b", OST_ACTION_TOOL}, {"c", OST_ACTION_CLUTCH}, {"d", OST_ACTION_HOME}},
    .usable = USABLE,
    .open = inverse3_open,
    .close = inverse3_close,
    .read = inverse3_read,
    .write = inverse3_write,
    .counts = COUNTS,
};
