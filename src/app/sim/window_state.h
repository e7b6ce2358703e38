/* SPDX-License-Identifier: Apache-2.0 */
/* The state of the simulator's window, private to the files window.c and window_events.c. */
#ifndef OST_APP_SIM_WINDOW_STATE_H
#define OST_APP_SIM_WINDOW_STATE_H

#include "app/sim/camera.h"
#include "app/sim/facts.h"
#include "app/sim/handle.h"
#include "app/sim/layer.h"
#include "app/sim/window.h"
#include "core/clock.h"
#include "window/window.h"

enum { SIM_WINDOW_MESSAGE = 200 };

typedef struct rates {
    double since; /* start time of the measurement in s */
    uint64_t ticks, frames;
    double ticks_s, frames_s, takes_us, frame_ms;
} rates;

/* The inputs from which a frame is drawn. The frame is redrawn only if an input changes. */
typedef struct sight {
    ost_pose pose;
    ost_orbit orbit;
    uint64_t changed;
    int32_t tool;
    ost_style style;
    int width, height;
} sight;

struct sim_window {
    const app_state *app;
    const sim_args *args;
    ost_window *window;
    sim_hud *hud;
    uint32_t *blank;   /* owned; the empty picture that is shown before the first frame */
    ost_mouse_input *mouse; /* input of the device `mouse`; NULL with any other device */
    sim_handle now, home;
    sim_camera camera;
    bool lifted; /* true if the window has set a new pose of the hand that the device has not received yet */
    bool key_down[512]; /* for each key code, true while the key is down */
    bool button[3];
    unsigned mods;
    double x, y;       /* position of the pointer */
    bool help, quit, shoot, timings;
    char message[SIM_WINDOW_MESSAGE];
    double message_until;
    /* number of driver resets, and number of consecutive frames that could not be drawn from the camera's position */
    int resets, astray;
    uint64_t frames;
    rates rates;
    sim_hud_facts facts;
    double facts_s;
    sight seen;
    bool outdated;     /* true if the HUD must be drawn again */
    bool follows;      /* true if the previous frame was shown, so that only changes must be copied */
    ost_cells changed; /* owned; cells that differ between the last two frames */
    sim_layer layer;   /* owned; the HUD over frames that are drawn directly into the window */
    ost_orbit layer_orbit; /* camera for which the layer was drawn */
    bool layer_outdated;
    simulation *s;
    ost_status status; /* OST_OK if the user closed the window, otherwise the error that closed it */
    ost_error err;
};

/* Returns the time in seconds. */
static inline double sim_window_now(void)
{
    return (double)ost_clock_ns() * 1e-9;
}

/* Shows a message in the HUD for some seconds. */
void sim_window_message(sim_window *w, const char *text);

/* Processes the events that have arrived. `height` is the height of the picture in pixels. */
void sim_window_take_events(sim_window *w, int height);
/* Applies the keys that act as long as they are down. dt is the time since the last call in seconds. */
void sim_window_hold_keys(sim_window *w, double dt);
/*
 * Passes the pose of the hand to the device. After a drag in a window of a few pixels, the pose may be out of range or
 * far from the bone. The device then gets the previous pose, `before`.
 */
void sim_window_put_handle(sim_window *w, const sim_handle *before);
/* Moves the camera to a view. */
void sim_window_set_view(sim_window *w, ost_view_name view);

#endif
