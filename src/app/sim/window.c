/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Implements the simulator's window: the facts of the HUD, frames, and the loop that draws frames while the servo
 * thread runs. window_events.c processes events.
 */
#include "app/sim/window_state.h"

#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "app/common/interrupt.h"
#include "app/common/print.h"
#include "app/sim/appearance.h"
#include "io/thread.h"

enum { ASTRAY_MAX = 100, MESSAGE = SIM_WINDOW_MESSAGE };
/*
 * FACTS_S is the interval between updates of the numbers. HIDDEN_S is the interval between checks of a hidden window.
 */
static const double FACTS_S = 0.1, HIDDEN_S = 0.1;

/* ------------------------------------------------------------- open, close */

static ost_status hud_for(sim_window *w, int width, int height, double scale, ost_error *err)
{
    if (sim_hud_suits(w->hud, width, height, scale))
        return OST_OK;
    sim_hud_free(w->hud);
    return sim_hud_create(width, height, scale, &w->hud, err);
}

static ost_status draw_loading(sim_window *w, ost_error *err)
{
    int width, height;
    double scale;
    ost_window_poll(w->window, 0);
    ost_window_size(w->window, &width, &height, &scale);
    if (width == 0 || height == 0)
        return OST_OK;
    ost_status status = hud_for(w, width, height, scale, err);
    if (status != OST_OK)
        return status;
    w->blank = calloc((size_t)width * (size_t)height, sizeof *w->blank);
    if (!w->blank)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a frame of %d x %d pixels", width, height);
    const ost_sheet sheet = {.pixels = w->blank, .stride = width, .width = width, .height = height};
    char text[MESSAGE];
    snprintf(text, sizeof text, "%.100s: a moment", w->args->bone);
    sim_hud_draw_message(w->hud, &sheet, text);
    status = ost_window_present(
        w->window, &(ost_window_picture){.pixels = w->blank, .stride = width, .width = width, .height = height}, false,
        err);
    ost_window_poll(w->window, 0);
    free(w->blank);
    w->blank = NULL;
    return status;
}

ost_status sim_window_open(const app_state *app, const sim_args *args, simulation *s, ost_error *err)
{
    sim_window *w = calloc(1, sizeof *w);
    if (!w)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a window");
    s->window = w;
    w->app = app;
    w->args = args;
    w->s = s;
    char title[MESSAGE];
    snprintf(title, sizeof title, "osteon sim: %.100s", args->bone);
    /* Without this setting, Mesa's software renderer creates one thread for every processor. These threads would
     * disturb the servo loop. */
    setenv("LP_NUM_THREADS", "0", 0);
    ost_status status = ost_window_open(title, args->width, args->height, &w->window, err);
    if (status != OST_OK)
        return status;
    const ost_window_info info = ost_window_info_get(w->window);
    s->window_can_be_drawn = !info.software;
    if (info.software && (args->renderer == SIM_RENDERER_POINTS || args->renderer == SIM_RENDERER_AUTO)) {
        char text[MESSAGE];
        snprintf(text, sizeof text, "OpenGL here is software (%.60s): the processor draws", info.renderer);
        sim_window_message(w, text);
        if (args->renderer == SIM_RENDERER_POINTS)
            print_line(app, "%s", text);
    }
    return draw_loading(w, err);
}

void sim_window_close(sim_window *window)
{
    if (!window)
        return;
    ost_window_close(window->window);
    sim_hud_free(window->hud);
    ost_mouse_input_free(window->mouse);
    free(window->blank);
    ost_cells_free(&window->changed);
    sim_layer_free(&window->layer);
    free(window);
}

ost_status sim_window_mouse_create(simulation *s, const ost_pose *start, ost_error *err)
{
    sim_window *w = s->window;
    ost_haptic_state state = {.pose = *start};
    w->now = w->home = sim_handle_at(start, 0);
    return ost_mouse_input_create(&state, &w->mouse, err);
}

ost_mouse_input *sim_window_mouse(const simulation *s)
{
    return s->window ? s->window->mouse : NULL;
}

/* ------------------------------------------------------------------- frames */

static void count_rates(sim_window *w, double now)
{
    rates *r = &w->rates;
    const ost_live_state *state = &w->s->show->viewer.state;
    r->takes_us += ((double)state->exec_ns * 1e-3 - r->takes_us) * 0.05;
    if (now - r->since < 0.5)
        return;
    r->ticks_s = r->since > 0 ? (double)(state->ticks - r->ticks) / (now - r->since) : 0;
    r->frames_s = r->since > 0 ? (double)(w->frames - r->frames) / (now - r->since) : 0;
    r->since = now;
    r->ticks = state->ticks;
    r->frames = w->frames;
}

/* Updates the facts of the HUD at most ten times per second, because numbers that change faster are unreadable. */
static void take_facts(sim_window *w, int height, double now)
{
    const ost_viewer *viewer = &w->s->show->viewer;
    double back[3];
    count_rates(w, now);
    if (now - w->facts_s >= FACTS_S || w->outdated) {
        const sim_hud_facts before = w->facts;
        w->facts = sim_facts_make(&w->s->show->scene, &viewer->state, viewer->has_state);
        w->facts.rates = true;
        w->facts.ticks_s = w->rates.ticks_s;
        w->facts.frames_s = w->rates.frames_s;
        w->facts.takes_us = w->rates.takes_us;
        w->facts.frame_ms = w->rates.frame_ms;
        w->facts.filming = w->args->video.target || w->args->video.pipe;
        w->facts.dropped = film_dropped(w->s->film);
        w->facts.message = before.message;
        w->facts_s = now;
        w->outdated = true;
    }
    sim_hud_facts *f = &w->facts;
    f->help = w->help;
    f->timings = w->timings;
    if (!w->args->look.no_legend)
        f->legend = appearance_legend_of(&w->s->show->look);
    f->pedal = viewer->has_state && viewer->state.rpm != 0;
    w->outdated = w->outdated || (f->message && now >= w->message_until);
    f->message = now < w->message_until ? w->message : NULL;
    f->mm_per_pixel = w->camera.orbit.distance / (OST_VIEW_FOCAL * height);
    ost_orbit_frame(&w->camera.orbit, f->right, f->up, back);
}

static bool same_sight(const sight *a, const sight *b)
{
    return memcmp(&a->pose, &b->pose, sizeof a->pose) == 0 && memcmp(&a->orbit, &b->orbit, sizeof a->orbit) == 0 &&
           a->changed == b->changed && a->tool == b->tool && a->style == b->style && a->width == b->width &&
           a->height == b->height;
}

static sight sight_of(const sim_window *w, int width, int height)
{
    const ost_viewer *v = &w->s->show->viewer;
    return (sight){.pose = v->state.pose,
                   .orbit = w->camera.orbit,
                   .changed = v->changed,
                   .tool = v->has_state ? v->state.tool : -1,
                   .style = v->style,
                   .width = width,
                   .height = height};
}

/*
 * Returns the set of cells in which the frame may differ from the previous frame. Returns NULL if all cells may
 * differ.
 */
static const ost_cells *changed_of(sim_window *w)
{
    const ost_frame *f = &w->s->show->viewer.frame;
    ost_cells *c = &w->changed;
    if (c->width != f->width || c->height != f->height) {
        ost_cells_free(c);
        if (!ost_cells_init(c, f->width, f->height))
            ost_cells_free(c);
    }
    if (!c->bit)
        return NULL;
    ost_cells_clear(c);
    ost_frame_changed(f, c);
    return c;
}

/* Presents a frame from memory. `follows` is true if the previous frame was also presented from memory. */
static ost_status present(sim_window *w, const ost_sheet *sheet, bool follows, ost_error *err)
{
    ost_window_picture picture = {
        .pixels = sheet->pixels, .stride = sheet->stride, .width = sheet->width, .height = sheet->height};
    const ost_cells *changed = follows ? changed_of(w) : NULL;
    if (changed) {
        picture.changed = changed->bit;
        picture.changed_words = changed->words;
    }
    ost_status status = ost_window_present(w->window, &picture, w->args->fps > 0, err);
    w->follows = status == OST_OK;
    return status;
}

/* Returns true if the next frame can be drawn directly into the window: no picture or video needs it in memory. */
static bool draws_directly(const sim_window *w, int width, int height)
{
    return !w->shoot && !w->facts.filming && ost_viewer_can_show(&w->s->show->viewer) &&
           ost_window_can_be_drawn(w->window, width, height);
}

/* Draws the HUD's layer if its facts, the camera or the size have changed. */
static ost_status renew_layer(sim_window *w, int width, int height, ost_error *err)
{
    const ost_orbit *orbit = &w->camera.orbit;
    if (!w->layer_outdated && memcmp(orbit, &w->layer_orbit, sizeof *orbit) == 0 &&
        sim_layer_fits(&w->layer, width, height))
        return OST_OK;
    ost_status status = sim_layer_draw(&w->layer, width, height, w->hud, &w->facts, err);
    w->layer_outdated = status != OST_OK;
    w->layer_orbit = *orbit;
    return status;
}

/* Draws a frame with the HUD, into the window or into memory. */
static ost_status draw(sim_window *w, int width, int height, ost_error *err)
{
    sim_show *show = w->s->show;
    const bool directly = draws_directly(w, width, height);
    w->layer_outdated = w->layer_outdated || w->outdated;
    ost_status status = directly ? renew_layer(w, width, height, err) : OST_OK;
    if (status != OST_OK)
        return status;
    const ost_gl_sheet layer = sim_layer_sheet(&w->layer);
    status = sim_show_frame(show, width, height, directly ? &layer : NULL, err);
    if (status != OST_OK)
        return status;
    if (show->on_screen) {
        sim_layer_shown(&w->layer);
        return OST_OK;
    }
    const ost_sheet sheet = ost_frame_sheet(&show->viewer.frame);
    sim_hud_draw(w->hud, &sheet, &w->facts);
    if (w->shoot)
        film_still(w->s->film, sheet.pixels, sheet.stride, width, height);
    film_frame(w->s->film, ost_clock_ns(), sheet.pixels, sheet.stride, width, height);
    return OST_OK;
}

/* Shows the frame that was drawn last. `follows` is true if the previous frame was presented from memory. */
static ost_status show_frame(sim_window *w, bool follows, ost_error *err)
{
    sim_show *show = w->s->show;
    const ost_sheet sheet = ost_frame_sheet(&show->viewer.frame);
    ost_status status = show->on_screen ? ost_window_show_drawn(w->window, w->args->fps > 0, err)
                                        : present(w, &sheet, follows, err);
    const int resets = ost_window_info_get(w->window).resets;
    if (status == OST_OK && resets > w->resets) {
        ost_viewer_context_lost(&show->viewer, "the graphics driver was reset");
        w->resets = resets;
        sim_window_message(w, "the graphics driver was reset, and the window started anew; the operation went on");
    }
    return status;
}

/* Processes events and draws a frame if one is needed. Sets *drawn to true if a frame was drawn. */
static ost_status frame(sim_window *w, double dt, bool *drawn, ost_error *err)
{
    int width, height;
    double scale;
    sim_show *show = w->s->show;
    *drawn = false;
    ost_window_size(w->window, &width, &height, &scale);
    const sim_handle before = w->now;
    sim_window_take_events(w, height);
    sim_window_hold_keys(w, dt);
    sim_window_put_handle(w, &before);
    const double now = sim_window_now();
    sim_camera_step(&w->camera, now);
    show->orbit = w->camera.orbit;
    ost_status status = sim_show_update(show, err);
    if (status != OST_OK || width == 0 || height == 0)
        return status; /* the window is minimized */
    char message[FILM_TEXT];
    if (film_message(w->s->film, message))
        sim_window_message(w, message);
    take_facts(w, height, now);
    const sight seen = sight_of(w, width, height);
    if (w->args->fps > 0 && !w->outdated && !w->shoot && !ost_window_damaged(w->window) &&
        same_sight(&seen, &w->seen)) {
        show->last_ns = 0;
        return OST_OK;
    }
    const int64_t begin = ost_clock_ns();
    const bool follows = w->follows;
    w->follows = false;
    status = hud_for(w, width, height, scale, err);
    if (status == OST_OK)
        status = draw(w, width, height, err);
    if (status == OST_ERR_RANGE && w->astray++ < ASTRAY_MAX) {
        sim_window_message(w, "that was too far away to be drawn: back to where it began");
        sim_window_set_view(w, w->camera.home);
        return OST_OK;
    }
    if (status != OST_OK)
        return status;
    w->astray = 0;
    w->shoot = w->outdated = false;
    w->seen = seen;
    w->rates.frame_ms += ((double)(ost_clock_ns() - begin) * 1e-6 - w->rates.frame_ms) * 0.1;
    w->frames++;
    *drawn = true;
    status = show_frame(w, follows, err);
    sim_show_done(show);
    return status;
}

/* ----------------------------------------------------------------- the loop */

typedef struct server {
    simulation *s;
    const ost_servo_options *how;
    ost_servo_tick *tick;
    ost_status status;
    ost_error err;
    _Atomic bool done;
} server;

static void *run_servo(void *user)
{
    server *v = user;
    v->status = ost_servo_run(v->s->device, v->how, v->tick, ost_operation_done, v->s->operation, v->s->loop, &v->err);
    atomic_store(&v->done, true);
    return NULL;
}

static void wait_until(int64_t due)
{
    const struct timespec t = {.tv_sec = due / 1000000000, .tv_nsec = due % 1000000000};
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, NULL);
}

/* Draws frames at the requested rate while anything changes. Otherwise waits for events. */
static ost_status show_frames(sim_window *w, server *v, ost_error *err)
{
    const int64_t period = w->args->fps > 0 ? INT64_C(1000000000) / w->args->fps : 0;
    int64_t due = ost_clock_ns(), last = due;
    double wait = 0;
    ost_status status = OST_OK;
    while (status == OST_OK && !atomic_load(&v->done)) {
        int width, height;
        double scale;
        bool drawn = false;
        ost_window_poll(w->window, wait);
        if (w->quit || interrupt_requested())
            break;
        const int64_t begin = ost_clock_ns();
        status = frame(w, fmin(0.1, (double)(begin - last) * 1e-9), &drawn, err);
        if (status == OST_OK && ost_window_closing(w->window)) {
            status = ost_window_check(w->window, err);
            break;
        }
        last = begin;
        const int64_t now = ost_clock_ns();
        due = due + period > now ? due + period : now;
        ost_window_size(w->window, &width, &height, &scale);
        wait = width == 0 ? HIDDEN_S : drawn ? 0 : (double)period * 1e-9;
        if (drawn && due > now)
            wait_until(due);
    }
    return status;
}

ost_status sim_window_run(simulation *s, const ost_servo_options *how, ost_servo_tick *tick, ost_error *err)
{
    sim_window *w = s->window;
    server v = {.s = s, .how = how, .tick = tick};
    pthread_t thread;
    w->camera = sim_camera_at((ost_view_name)w->args->view, &s->show->subject,
                              1e-9 * (double)ost_live_geometry(s->show->live)->spacing.x);
    const int error = ost_thread_begin(&thread, run_servo, &v);
    if (error)
        return ost_fail(err, OST_ERR_UNAVAILABLE, "cannot create a thread for the loop: %s", strerror(error));
    w->status = show_frames(w, &v, &w->err);
    if (ost_window_check(w->window, NULL) != OST_OK)
        /* the report at the end of the operation states that the window was lost */
        ost_viewer_context_lost(&s->show->viewer, "");
    interrupt_request();
    pthread_join(thread, NULL);
    if (v.status != OST_OK)
        *err = v.err;
    return v.status;
}

ost_status sim_window_end(const simulation *s, ost_error *err)
{
    if (!s->window || s->window->status == OST_OK)
        return OST_OK;
    *err = s->window->err;
    return s->window->status;
}
