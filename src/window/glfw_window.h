/* SPDX-License-Identifier: Apache-2.0 */
/* GLFW's window, within this folder. */
#ifndef OST_WINDOW_GLFW_WINDOW_H
#define OST_WINDOW_GLFW_WINDOW_H

#include "window/shm.h"
#include "window/shown.h"
#include "window/window.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

enum { OST_WINDOW_EVENTS = 256, OST_WINDOW_TITLE = 160, OST_WINDOW_RESETS = 3 };

struct ost_window {
    GLFWwindow *handle;
    ost_shown shown;
    ost_shm *shm; /* NULL: OpenGL shows */
    bool synced, sync_set;
    ost_window_event event[OST_WINDOW_EVENTS]; /* a ring */
    int first, count;
    bool spilt; /* there were more than it holds */
    unsigned mods;
    int normal[4]; /* place and size before full screen */
    /* As the callbacks said last: */
    int width, height, frame_width, frame_height;
    double scale;
    bool minimised, unseen, damaged;
    int64_t looked_ns;
    /* OpenGL: */
    int side; /* of the greatest texture */
    enum { MUTE, BY_KHR, BY_ARB } tells_reset; /* mute: the driver does not say */
    int64_t reset_ns[OST_WINDOW_RESETS];
    int resets;
    char title[OST_WINDOW_TITLE], renderer[128], version[64];
};

/* There is a window, and a display that it is on: else GLFW is to be called no more. */
bool ost_window_lives(const ost_window *window);
/* Callbacks, and what they have not said yet. */
void ost_window_listen(ost_window *window);

#endif
