/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A GLFW and an OpenGL that do as a test tells them, in place of the real
 * ones: drivers that are too old or reset, screens that are not there.
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
    /* What there is: */
    bool no_init, no_compile, no_texture_memory, no_monitor, khr, arb;
    const char *why;             /* of what fails */
    int version;                 /* 33: the newest context of the core profile that can be had */
    int plain_version;           /* of one that nothing is asked of; 0: none */
    bool no_next;                /* no window any more */
    int texture_side;
    GLenum reset;                /* what the driver says of itself, until a new context */
    bool reset_stays, reset_in_upload;
    float scale;
    int frame_of_window;         /* pixels of the frame to one of the window */
    int64_t clock_ns;
    GLFWvidmode mode[FAKE_MONITORS];
    int monitor_x[FAKE_MONITORS];
    /* What was done: */
    int inits, windows, contexts, frames, uploads, objects, swap_interval;
    int asked_major, asked_minor, asked_robustness, viewport[2], polls;
    bool waited;
    char title[64];
} fake;

extern fake the_fake;

void fake_begin(void); /* everything there, OpenGL 4.5 */
/* What the system does to the window. */
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
