/* SPDX-License-Identifier: Apache-2.0 */
/*
 * GLFW's callbacks, which queue the user's input and cache the window's state. Querying GLFW for the state in every
 * frame would cost a round trip to the X server.
 */
#include "core/clock.h"
#include "window/glfw_window.h"

static const int64_t POLL_NS = 250000000;

static void add(ost_window *w, ost_window_event event)
{
    /* Merges consecutive pointer motions into one event. */
    if (event.kind == OST_WINDOW_MOVE && w->count) {
        ost_window_event *last = &w->event[(w->first + w->count - 1) % OST_WINDOW_EVENTS];
        if (last->kind == OST_WINDOW_MOVE) {
            *last = event;
            return;
        }
    }
    if (w->count < OST_WINDOW_EVENTS)
        w->event[(w->first + w->count++) % OST_WINDOW_EVENTS] = event;
    else
        w->spilt = true;
}

static unsigned mods_of(int mods)
{
    return (mods & GLFW_MOD_SHIFT ? OST_WINDOW_SHIFT : 0u) | (mods & GLFW_MOD_CONTROL ? OST_WINDOW_CONTROL : 0u) |
           (mods & GLFW_MOD_ALT ? OST_WINDOW_ALT : 0u);
}

static int key_of(int key)
{
    if (key >= GLFW_KEY_F1 && key <= GLFW_KEY_F12)
        return OST_KEY_F1 + key - GLFW_KEY_F1;
    if (key >= GLFW_KEY_KP_0 && key <= GLFW_KEY_KP_9)
        return '0' + key - GLFW_KEY_KP_0;
    switch (key) {
    case GLFW_KEY_ESCAPE: return OST_KEY_ESCAPE;
    case GLFW_KEY_ENTER: case GLFW_KEY_KP_ENTER: return OST_KEY_ENTER;
    case GLFW_KEY_TAB: return OST_KEY_TAB;
    case GLFW_KEY_LEFT: return OST_KEY_LEFT;
    case GLFW_KEY_RIGHT: return OST_KEY_RIGHT;
    case GLFW_KEY_UP: return OST_KEY_UP;
    case GLFW_KEY_DOWN: return OST_KEY_DOWN;
    case GLFW_KEY_HOME: return OST_KEY_HOME;
    case GLFW_KEY_PAGE_UP: return OST_KEY_PAGE_UP;
    case GLFW_KEY_PAGE_DOWN: return OST_KEY_PAGE_DOWN;
    case GLFW_KEY_EQUAL: case GLFW_KEY_KP_ADD: return OST_KEY_PLUS;
    case GLFW_KEY_MINUS: case GLFW_KEY_KP_SUBTRACT: return OST_KEY_MINUS;
    default: return key > 0 && key < 256 ? key : 0;
    }
}

static void on_key(GLFWwindow *handle, int key, int scancode, int action, int mods)
{
    ost_window *w = glfwGetWindowUserPointer(handle);
    (void)scancode;
    w->mods = mods_of(mods);
    /* For a modifier key, GLFW reports the modifiers that were active before the key was pressed or released. */
    if (key == GLFW_KEY_LEFT_SHIFT || key == GLFW_KEY_RIGHT_SHIFT)
        w->mods = action == GLFW_RELEASE ? w->mods & ~(unsigned)OST_WINDOW_SHIFT : w->mods | OST_WINDOW_SHIFT;
    if (key == GLFW_KEY_LEFT_CONTROL || key == GLFW_KEY_RIGHT_CONTROL)
        w->mods = action == GLFW_RELEASE ? w->mods & ~(unsigned)OST_WINDOW_CONTROL : w->mods | OST_WINDOW_CONTROL;
    if (action != GLFW_REPEAT)
        add(w, (ost_window_event){
                   .kind = OST_WINDOW_KEY, .key = key_of(key), .pressed = action == GLFW_PRESS, .mods = w->mods});
}

static void on_button(GLFWwindow *handle, int button, int action, int mods)
{
    ost_window *w = glfwGetWindowUserPointer(handle);
    w->mods = mods_of(mods);
    add(w, (ost_window_event){
               .kind = OST_WINDOW_BUTTON, .button = button, .pressed = action == GLFW_PRESS, .mods = w->mods});
}

/* Limits the picture's sides to the maximum that OpenGL and the renderer support. Preserves the aspect ratio. */
static void picture_size(const ost_window *w, int *width, int *height)
{
    const int most = w->side < OST_WINDOW_SIDE ? w->side : OST_WINDOW_SIDE;
    const int longer = w->frame_width > w->frame_height ? w->frame_width : w->frame_height;
    *width = w->frame_width;
    *height = w->frame_height;
    if (longer <= most)
        return;
    *width = (int)((int64_t)w->frame_width * most / longer);
    *height = (int)((int64_t)w->frame_height * most / longer);
    *width = *width > 0 ? *width : 1;
    *height = *height > 0 ? *height : 1;
}

/* Converts the pointer's position from window coordinates to picture pixels. On some systems their units differ. */
static void on_move(GLFWwindow *handle, double x, double y)
{
    ost_window *w = glfwGetWindowUserPointer(handle);
    int width, height;
    picture_size(w, &width, &height);
    const double sx = w->width > 0 ? (double)width / w->width : 1, sy = w->height > 0 ? (double)height / w->height : 1;
    add(w, (ost_window_event){.kind = OST_WINDOW_MOVE, .x = x * sx, .y = y * sy, .mods = w->mods});
}

static void on_wheel(GLFWwindow *handle, double x, double y)
{
    ost_window *w = glfwGetWindowUserPointer(handle);
    /* Some systems report the wheel as horizontal while Shift is pressed. */
    add(w, (ost_window_event){.kind = OST_WINDOW_WHEEL, .y = y != 0 ? y : x, .mods = w->mods});
}

static void on_size(GLFWwindow *handle, int width, int height)
{
    ost_window *w = glfwGetWindowUserPointer(handle);
    w->width = width;
    w->height = height;
}

static void on_frame_size(GLFWwindow *handle, int width, int height)
{
    ost_window *w = glfwGetWindowUserPointer(handle);
    w->frame_width = width;
    w->frame_height = height;
    w->damaged = true;
}

static double sane_scale(float scale)
{
    return scale >= 0.5f && scale <= 8 ? (double)scale : 1;
}

static void on_scale(GLFWwindow *handle, float x, float y)
{
    ost_window *w = glfwGetWindowUserPointer(handle);
    (void)x;
    w->scale = sane_scale(y);
    w->damaged = true;
}

static void on_minimised(GLFWwindow *handle, int minimised)
{
    ost_window *w = glfwGetWindowUserPointer(handle);
    w->minimised = minimised != 0;
    w->damaged = true;
}

static void on_damage(GLFWwindow *handle)
{
    ost_window *w = glfwGetWindowUserPointer(handle);
    w->damaged = true;
    w->hidden = false;
}

/* Queries whether the window is hidden, because some systems do not report it. */
static void check_display(ost_window *w)
{
    const int64_t now = ost_clock_ns();
    if (now - w->looked_ns < POLL_NS)
        return;
    w->looked_ns = now;
    const bool hidden = !glfwGetWindowAttrib(w->handle, GLFW_VISIBLE);
    w->damaged = w->damaged || (w->hidden && !hidden);
    w->hidden = hidden;
}

void ost_window_listen(ost_window *w)
{
    float x = 1, y = 1;
    glfwSetWindowUserPointer(w->handle, w);
    glfwSetKeyCallback(w->handle, on_key);
    glfwSetMouseButtonCallback(w->handle, on_button);
    glfwSetCursorPosCallback(w->handle, on_move);
    glfwSetScrollCallback(w->handle, on_wheel);
    glfwSetWindowSizeCallback(w->handle, on_size);
    glfwSetFramebufferSizeCallback(w->handle, on_frame_size);
    glfwSetWindowContentScaleCallback(w->handle, on_scale);
    glfwSetWindowIconifyCallback(w->handle, on_minimised);
    glfwSetWindowRefreshCallback(w->handle, on_damage);
    glfwGetWindowSize(w->handle, &w->width, &w->height);
    glfwGetFramebufferSize(w->handle, &w->frame_width, &w->frame_height);
    glfwGetWindowContentScale(w->handle, &x, &y);
    w->scale = sane_scale(y);
    w->minimised = glfwGetWindowAttrib(w->handle, GLFW_ICONIFIED) != 0;
    w->hidden = false;
    w->damaged = true;
    w->looked_ns = ost_clock_ns();
}

void ost_window_poll(ost_window *window, double timeout_s)
{
    if (!ost_window_lives(window))
        return;
    if (timeout_s > 0)
        glfwWaitEventsTimeout(timeout_s);
    else
        glfwPollEvents();
    if (ost_window_lives(window))
        check_display(window);
}

bool ost_window_next(ost_window *window, ost_window_event *out)
{
    if (!window->count) {
        const bool spilt = window->spilt;
        window->spilt = false;
        *out = (ost_window_event){.kind = OST_WINDOW_RELEASE, .mods = window->mods};
        return spilt;
    }
    *out = window->event[window->first];
    window->first = (window->first + 1) % OST_WINDOW_EVENTS;
    window->count--;
    return true;
}

void ost_window_size(const ost_window *window, int *width, int *height, double *scale)
{
    *scale = window->scale;
    if (window->minimised || window->hidden || window->frame_width < 1 || window->frame_height < 1)
        *width = *height = 0;
    else
        picture_size(window, width, height);
}

bool ost_window_damaged(const ost_window *window)
{
    return window->damaged;
}
