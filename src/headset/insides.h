/* SPDX-License-Identifier: Apache-2.0 */
/* The state of a headset, private to the files of this folder. */
#ifndef OST_HEADSET_INSIDES_H
#define OST_HEADSET_INSIDES_H

#define XR_USE_GRAPHICS_API_OPENGL
#define XR_USE_PLATFORM_EGL
#include <epoxy/egl.h>
#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

#include "headset/headset.h"

enum { EYES = 2, IMAGES_MAX = 8, HAND_BUTTONS = 3 };

typedef struct headset_swapchain {
    XrSwapchain swapchain;
    uint32_t count, image;          /* number of images, and index of the image that is being drawn */
    uint32_t texture[IMAGES_MAX];   /* OpenGL names of the images */
} headset_swapchain;

typedef struct headset_actions {
    XrActionSet set;
    XrAction grip, button[HAND_BUTTONS]; /* elements of `button` are in the order of the bits OST_HEADSET_* */
    XrSpace space;
} headset_actions;

struct ost_headset {
    XrInstance instance;
    XrSystemId system;
    XrSession session;
    XrSpace room;
    ost_gl *gl;                     /* renderer; borrowed during a session */
    headset_swapchain eye[EYES];
    headset_actions actions;
    int width_max, height_max;
    bool running, ended;
    XrDuration period;              /* shortest display period reported so far; 0 before the first frame */
    XrTime last;                    /* display time of the previous frame; 0 if there is none */
    ost_headset_info info;
    ost_headset_counts counts;
};

/* Returns OST_OK if the result is a success, otherwise an error that names the failed action and the runtime's
   result. */
ost_status headset_check(const ost_headset *h, XrResult result, const char *doing, ost_error *err);
/* Processes the runtime's events. Begins and ends the session when the runtime requests it. */
ost_status headset_poll(ost_headset *h, ost_error *err);

/* ---------------------------------------------------------------- hand.c */
ost_status headset_hand_begin(ost_headset *h, bool left, ost_error *err);
/*
 * Reads the controller's state at a display time. `tracked` is false if the controller is not tracked or the runtime
 * fails.
 */
ost_headset_hand headset_hand_read(ost_headset *h, XrTime time);

#endif
