/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A simulated GLFW and OpenGL that a test controls. They simulate old drivers, driver resets, and missing
 * screens.
 */
#ifndef OST_TESTS_WINDOW_FAKE_H
#define OST_TESTS_WINDOW_FAKE_H

#include <stdbool.h>
#include <stdint.h>

#include <epoxy/gl.h>
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

enum { FAKE_MONITORS = 2 };

typedef struct fake {
    /* A test sets these members, which determine the behaviour of the simulated system. */
    bool no_init, no_compile, no_texture_memory, no_monitor, khr, arb;
    const char *why;             /* text of the error that GLFW reports */
    const char *renderer;        /* name of the renderer */
    int version;                 /* newest version of a core profile context, such as 33 for 3.3 */
    /* version of a context that is requested without a version; 0 if there is no such context */
    int plain_version;
    bool no_next;                /* true if no further windows can be opened */
    int texture_side;
    GLenum reset;                /* reset status that the driver reports until a new context is made */
    bool reset_stays, reset_in_upload;
    float scale;
    int frame_of_window;         /* number of frame pixels per unit of the window */
    int64_t clock_ns;
    GLFWvidmode mode[FAKE_MONITORS];
    int monitor_x[FAKE_MONITORS];
    /* A test reads these members: numbers of calls, and the arguments of the last call. */
    int inits, windows, contexts, frames, uploads, objects, swap_interval;
    int requested_major, requested_minor, requested_robustness, viewport[2], polls;
    bool waited;
    char title[64];
} fake;

extern fake the_fake;

void fake_begin(void); /* makes all features available, with OpenGL 4.5 */
/* These functions simulate the system's events for the window. */
void fake_size(int width, int height);
void fake_minimise(bool on);
void fake_hide(bool on);
void fake_damage(void);
void fake_rescale(float scale);
void fake_close(void);
void fake_key(int key, int action, int mods);
void fake_button(int button, int action, int mods);
void fake_move(double x, double y);
void fake_wheel(double x, double y);
void fake_place(int x, int y);
void fake_unplug_monitor(void);

#endif
