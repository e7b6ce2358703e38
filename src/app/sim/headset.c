/* SPDX-License-Identifier: Apache-2.0 */
#include "app/sim/headset.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "app/common/interrupt.h"
#include "app/common/print.h"
#include "app/common/result.h"
#include "core/clock.h"
#include "headset/headset.h"
#include "headset/room.h"
#include "io/thread.h"

struct sim_headset {
    const sim_args *args;
    ost_headset *headset;   /* owned */
    ost_hand_input *hand;   /* owned; read by the device */
    sim_show *show;         /* borrowed */
    ost_room room;
    pthread_t thread;
    _Atomic bool stop;
    int eyes;               /* eyes drawn in this frame */
    int64_t first_ns, last_ns; /* times at which the first and the last frame were shown */
    ost_status status;      /* status of the thread */
    ost_error err;
};

ost_status sim_headset_open(const sim_args *args, simulation *s, ost_error *err)
{
    sim_headset *h = calloc(1, sizeof *h);
    if (!h)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a headset");
    s->headset = h;
    h->args = args;
    ost_status status = ost_headset_open(&h->headset, err);
    if (status != OST_OK)
        ost_fail_context(err, "--headset");
    return status == OST_OK ? ost_hand_input_create(&h->hand, err) : status;
}

void sim_headset_close(sim_headset *h)
{
    if (!h)
        return;
    ost_headset_close(h->headset);
    ost_hand_input_free(h->hand);
    free(h);
}

ost_hand_input *sim_headset_hand(const simulation *s)
{
    return s->headset ? s->headset->hand : NULL;
}

/* ------------------------------------------------------------------- frames */

static ost_status draw(void *user, const ost_headset_view *view, ost_error *err)
{
    sim_headset *h = user;
    ost_camera camera = {
        .focal_milli = view->projection.focal_milli, .width = view->width, .height = view->height};
    ost_status status = h->eyes++ == 0 ? sim_show_update(h->show, err) : OST_OK;
    if (status == OST_OK)
        status = ost_room_pose(&h->room, view->at, view->q, &camera.pose, err);
    return status == OST_OK ? ost_viewer_draw_gl(&h->show->viewer, &camera, view->projection.middle, err) : status;
}

static void take_hand(void *user, const ost_headset_hand *hand)
{
    _Static_assert((int)OST_HEADSET_TRIGGER == (int)OST_HAND_TRIGGER && (int)OST_HEADSET_MENU == (int)OST_HAND_MENU &&
                       (int)OST_HEADSET_SQUEEZE == (int)OST_HAND_SQUEEZE,
                   "the buttons have the same bits");
    sim_headset *h = user;
    ost_hand_sample sample = {.tracked = hand->tracked, .buttons = hand->buttons};
    /* A controller that is too far from the bone is treated as not tracked. */
    sample.tracked = hand->tracked && ost_room_pose(&h->room, hand->at, hand->q, &sample.pose, NULL) == OST_OK;
    ost_hand_input_put(h->hand, &sample);
    h->eyes = 0;
}

static void *work(void *user)
{
    sim_headset *h = user;
    const ost_headset_calls calls = {.draw = draw, .hand = take_hand, .user = h};
    bool ended = false;
    uint64_t drawn = 0;
    while (!atomic_load(&h->stop) && !ended && h->status == OST_OK) {
        h->status = ost_headset_frame(h->headset, &calls, &ended, &h->err);
        if (ost_headset_counts_get(h->headset).drawn == drawn)
            continue;
        drawn++;
        /* The drawing time is measured from the update for the first eye. It therefore excludes the runtime's wait for
         * the frame. */
        const int64_t now = ost_clock_ns();
        frame_times_add(&h->show->drawn, now - h->show->updated_ns);
        if (h->last_ns)
            frame_times_add(&h->show->apart, now - h->last_ns);
        h->first_ns = h->first_ns ? h->first_ns : now;
        h->last_ns = now;
    }
    if (!atomic_load(&h->stop))
        interrupt_request();
    return NULL;
}

ost_status sim_headset_start(simulation *s, ost_error *err)
{
    sim_headset *h = s->headset;
    double right[3], up[3], back[3];
    h->show = s->show;
    ost_orbit_frame(&s->show->orbit, right, up, back);
    h->room = ost_room_make(s->show->orbit.at, right, up, back);
    ost_status status = ost_headset_begin(h->headset, s->show->viewer.gl, h->args->size ? h->args->width : 0,
                                          h->args->height, ost_hand_input_is_left(h->hand), err);
    const int error = status == OST_OK ? ost_thread_begin(&h->thread, work, h) : 0;
    if (error)
        status = ost_fail(err, OST_ERR_UNAVAILABLE, "cannot create a thread for the headset: %s", strerror(error));
    if (status != OST_OK)
        ost_headset_end(h->headset);
    return status;
}

void sim_headset_stop(simulation *s)
{
    atomic_store(&s->headset->stop, true);
    pthread_join(s->headset->thread, NULL);
    ost_headset_end(s->headset->headset);
}

ost_status sim_headset_end(const simulation *s, ost_error *err)
{
    if (!s->headset || s->headset->status == OST_OK)
        return OST_OK;
    *err = s->headset->err;
    return s->headset->status;
}

void sim_headset_report(const app_state *app, const simulation *s)
{
    const sim_headset *h = s->headset;
    const ost_headset_info info = ost_headset_info_get(h->headset);
    const ost_headset_counts counts = ost_headset_counts_get(h->headset);
    const double seconds = (double)(h->last_ns - h->first_ns) * 1e-9;
    const double fps = seconds > 0 ? (double)(counts.drawn - 1) / seconds : 0;
    char a[FORMAT_TEXT], b[FORMAT_TEXT];
    json_t *o = json_object();
    put_text(o, "runtime", info.runtime);
    put_text(o, "system", info.system);
    put_integer(o, "width", info.width);
    put_integer(o, "height", info.height);
    put_real(o, "display_hz", counts.display_hz);
    put_real(o, "fps", fps);
    put_integer(o, "frames", (int64_t)counts.drawn);
    put_integer(o, "missed", (int64_t)counts.missed);
    put_integer(o, "frames_without_pose", (int64_t)counts.untracked);
    put(app->result, "headset", o);
    print_line(app, "headset: %s, by %s; 2 x %d x %d pixels", info.system, info.runtime, info.width, info.height);
    print_line(app, "  %s frames, %.1f per second of the display's %.1f; the display had no new frame %s times",
               format_count(a, (int64_t)counts.drawn), fps, counts.display_hz, format_count(b, (int64_t)counts.missed));
    if (counts.untracked)
        print_line(app, "  the head was not tracked in %s frames", format_count(a, (int64_t)counts.untracked));
}
