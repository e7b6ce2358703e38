/* SPDX-License-Identifier: Apache-2.0 */
/* The state of a GLFW window, private to this folder. */
#ifndef OST_WINDOW_GLFW_WINDOW_H
#define OST_WINDOW_GLFW_WINDOW_H

#include "window/shm.h"
#include "window/shown.h"
#include "window/window.h"
#include "window/x11.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

enum { OST_WINDOW_EVENTS = 256, OST_WINDOW_TITLE = 160, OST_WINDOW_RESETS = 3 };

struct ost_window {
    GLFWwindow *handle;
    ost_shown shown;
    ost_shm *shm; /* shared memory with the X server; owned; NULL if OpenGL presents the picture */
    bool synced, sync_set;
    ost_window_event event[OST_WINDOW_EVENTS]; /* ring buffer */
    int first, count;
    bool spilt; /* true if the ring buffer `event` has overflowed */
    unsigned mods;
    int normal[4]; /* position and size of the window before full screen */
    /* Values that the callbacks last reported: */
    int width, height, frame_width, frame_height;
    double scale;
    bool minimised, hidden, damaged;
    int64_t looked_ns;
    /* Properties of the OpenGL context: */
    int side; /* maximum side length of a texture in pixels */
    /* name of the extension that reports driver resets */
    enum { NO_NOTIFICATION, BY_KHR, BY_ARB } reset_notification;
    int64_t reset_ns[OST_WINDOW_RESETS];
    int resets;
    char title[OST_WINDOW_TITLE], renderer[128], version[64];
};

/* Returns true if the window and its display exist. Otherwise, no GLFW function may be called. */
static inline bool ost_window_lives(const ost_window *window)
{
    return window->handle && ost_x11_state_get() == OST_X11_FINE;
}
/* Registers the callbacks, and reads the current state of the window, because callbacks report only changes. */
void ost_window_listen(ost_window *window);

#endif
