/* SPDX-License-Identifier: Apache-2.0 */
/* The events of the simulator's window: keys, buttons, the pointer, and the hand that they move. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "app/sim/appearance.h"
#include "app/sim/window_state.h"

enum { DISTANCE_KEY_MM_S = 12 };
static const double MESSAGE_S = 6, WHEEL_MM = 0.5, FINE = 0.2, TWIST_KEY = 1.2;

void sim_window_message(sim_window *w, const char *text)
{
    snprintf(w->message, sizeof w->message, "%.*s", (int)sizeof w->message - 1, text);
    w->message_until = sim_window_now() + MESSAGE_S;
    w->outdated = true;
}

/* Changes the tool. The tip of the new tool is placed at the position of the previous tool's tip. */
static void take_tool(sim_window *w, int number)
{
    if (number < 0 || number >= w->args->tools.count || !w->mouse || number == w->now.tool)
        return;
    const ost_metrics_tool *shapes = w->s->show->scene.shapes;
    sim_handle_push(&w->now, shapes[number].tip_mm[2] - shapes[w->now.tool].tip_mm[2]);
    w->now.tool = number;
}

void sim_window_set_view(sim_window *w, ost_view_name view)
{
    const ost_viewer *viewer = &w->s->show->viewer;
    sim_camera_fly(&w->camera, view, viewer->has_state ? &viewer->state.pose : NULL, sim_window_now());
}

static void on_key(sim_window *w, int key)
{
    static const ost_view_name views[] = {OST_VIEW_OPERATOR, OST_VIEW_EN_FACE, OST_VIEW_LATERAL, OST_VIEW_ANTERIOR,
                                          OST_VIEW_POSTERIOR, OST_VIEW_SUPERIOR, OST_VIEW_TOOL, OST_VIEW_OVERVIEW};
    const int tools = w->args->tools.count;
    if (key == OST_KEY_F1)
        w->help = !w->help;
    else if (key >= '1' && key <= '8')
        sim_window_set_view(w, views[key - '1']);
    else if (key >= OST_KEY_F1 + 1 && key <= OST_KEY_F1 + 8)
        sim_window_set_view(w, views[key - OST_KEY_F1 - 1]);
    else if (key == '0')
        sim_window_set_view(w, w->camera.home);
    else if (key == 'L')
        w->timings = !w->timings;
    else if (key == OST_KEY_F1 + 9)
        w->s->show->viewer.style = w->s->show->viewer.style == OST_STYLE_SMOOTH ? OST_STYLE_FACES : OST_STYLE_SMOOTH;
    else if (key == OST_KEY_F1 + 10)
        ost_window_full_screen(w->window, !ost_window_is_full_screen(w->window));
    else if (key == OST_KEY_F1 + 11)
        w->shoot = true;
    else if (key == OST_KEY_ESCAPE)
        w->help = false;
    else if (key == 'Q' && (w->mods & OST_WINDOW_CONTROL))
        w->quit = true;
    else if (key == OST_KEY_TAB)
        take_tool(w, (w->now.tool + (w->mods & OST_WINDOW_SHIFT ? tools - 1 : 1)) % tools);
    else if (key == OST_KEY_HOME) {
        const int32_t tool = w->now.tool;
        w->now = w->home;
        w->now.tool = tool;
        w->lifted = true;
    } else {
        char text[160];
        double eye[3];
        sim_appearance_eye(w->s->show, eye);
        if (appearance_key(&w->s->show->look, key, w->mods & OST_WINDOW_SHIFT, eye, text) && text[0])
            sim_window_message(w, text);
    }
}

static void on_move(sim_window *w, double dx, double dy, int height)
{
    if (w->button[0] && w->mouse && (w->mods & OST_WINDOW_SHIFT))
        sim_handle_turn(&w->now, &w->camera.orbit, dx, dy);
    else if (w->button[0] && w->mouse)
        sim_handle_drag(&w->now, &w->camera.orbit, dx, dy, height);
    else if (w->button[2] || ((w->button[1] || w->button[0]) && (w->mods & OST_WINDOW_SHIFT)))
        sim_camera_shift(&w->camera, dx, dy, height);
    else if (w->button[1] || w->button[0])
        sim_camera_turn(&w->camera, dx, dy, height);
}

static void on_wheel(sim_window *w, double steps)
{
    if ((w->mods & OST_WINDOW_ALT) && appearance_wheel(&w->s->show->look, steps, w->mods & OST_WINDOW_SHIFT))
        return;
    if ((w->mods & OST_WINDOW_CONTROL) || !w->mouse)
        sim_camera_near(&w->camera, steps);
    else
        sim_handle_push(&w->now, steps * WHEEL_MM * (w->mods & OST_WINDOW_SHIFT ? FINE : 1));
}

void sim_window_take_events(sim_window *w, int height)
{
    ost_window_event e;
    while (ost_window_next(w->window, &e)) {
        w->mods = e.mods;
        w->outdated = w->outdated || e.kind != OST_WINDOW_MOVE;
        switch (e.kind) {
        case OST_WINDOW_KEY:
            if (e.key > 0 && e.key < (int)sizeof w->key_down)
                w->key_down[e.key] = e.pressed;
            if (e.pressed)
                on_key(w, e.key);
            break;
        case OST_WINDOW_BUTTON:
            if (e.button >= 0 && e.button < 3)
                w->button[e.button] = e.pressed;
            break;
        case OST_WINDOW_MOVE:
            on_move(w, e.x - w->x, e.y - w->y, height > 0 ? height : 1);
            w->x = e.x;
            w->y = e.y;
            break;
        case OST_WINDOW_WHEEL:
            on_wheel(w, e.y);
            break;
        case OST_WINDOW_RELEASE:
            memset(w->key_down, 0, sizeof w->key_down);
            memset(w->button, 0, sizeof w->button);
            break;
        }
    }
}

void sim_window_hold_keys(sim_window *w, double dt)
{
    const bool *k = w->key_down;
    sim_camera_hold(&w->camera, k[OST_KEY_RIGHT] - k[OST_KEY_LEFT], k[OST_KEY_UP] - k[OST_KEY_DOWN],
                    k[OST_KEY_PLUS] - k[OST_KEY_MINUS], w->mods & OST_WINDOW_SHIFT, dt);
    /* The keys have the same effect as the buttons of a device. If the device is `mouse`, the keys act on the simulated
     * hand instead. */
    ost_operation_keys(w->s->operation, w->mouse ? 0
                                                 : (uint32_t)k[' '] << OST_ACTION_MOTOR |
                                                       (uint32_t)k[OST_KEY_TAB] << OST_ACTION_TOOL |
                                                       (uint32_t)k[OST_KEY_HOME] << OST_ACTION_HOME);
    if (!w->mouse)
        return;
    if (!(w->mods & OST_WINDOW_CONTROL))
        sim_handle_twist(&w->now, TWIST_KEY * dt * (k['Q'] - k['E']));
    sim_handle_push(&w->now, DISTANCE_KEY_MM_S * (w->mods & OST_WINDOW_SHIFT ? FINE : 1) * dt * (k['W'] - k['S']));
    w->now.pedal = k[' '];
}

void sim_window_put_handle(sim_window *w, const sim_handle *before)
{
    ost_haptic_state state;
    const ost_view_subject *subject = &w->camera.subject;
    double away = 0;
    if (!w->mouse)
        return;
    for (int a = 0; a < 3; a++)
        away = fmax(away, fabs(w->now.at[a] - subject->middle[a]));
    if (away > fmax(subject->size, 500) || !sim_handle_state(&w->now, &state)) {
        w->now = *before;
        return;
    }
    state.lifted = w->lifted;
    w->lifted = false;
    ost_mouse_input_put(w->mouse, &state);
}
