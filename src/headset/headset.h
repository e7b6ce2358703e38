/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Accesses a headset through OpenXR: shows frames to both eyes, and reads the pose and the buttons of a controller.
 *
 *   runtime --views--> draw (called once per eye) --ost_gl_copy--> swapchain --> runtime --> display
 *      '------controller--> hand (called once per frame)
 *
 * The runtime uses the renderer's OpenGL context, which requires the extensions XR_KHR_opengl_enable and
 * XR_MNDX_egl_enable; Monado supports both. All poses are in the room's frame (room.h). The functions must not be
 * called by several threads at once.
 */
#ifndef OST_HEADSET_H
#define OST_HEADSET_H

#include "headset/projection.h"
#include "render/gl/gl.h"

typedef struct ost_headset ost_headset;

typedef struct ost_headset_info {
    char runtime[160]; /* name and version of the runtime, for example "Monado(XRT) by Collabora et al 25.0.0" */
    char system[256];  /* name of the headset */
    int width, height; /* size of an eye's picture in pixels */
} ost_headset_info;

typedef struct ost_headset_view {
    double at[3], q[4]; /* pose of the eye: position in metres, and unit quaternion w x y z */
    ost_headset_projection projection;
    int width, height;  /* pixels */
} ost_headset_view;

enum { OST_HEADSET_TRIGGER = 1, OST_HEADSET_MENU = 2, OST_HEADSET_SQUEEZE = 4 };
typedef struct ost_headset_hand {
    bool tracked;       /* true if the controller is tracked; if false, all other fields are 0 */
    double at[3], q[4]; /* pose of the grip: position in metres, and unit quaternion w x y z */
    uint32_t buttons;   /* bit mask of the pressed buttons (OST_HEADSET_*) */
} ost_headset_hand;

typedef struct ost_headset_calls {
    /* Draws an eye into the renderer's picture. If this function returns OST_ERR_RANGE, the frame is not shown. */
    ost_status (*draw)(void *user, const ost_headset_view *view, ost_error *err);
    void (*hand)(void *user, const ost_headset_hand *hand);
    void *user;
} ost_headset_calls;

typedef struct ost_headset_counts {
    uint64_t frames;      /* number of frames requested by the runtime */
    uint64_t drawn;       /* number of frames in which both eyes were drawn and shown */
    uint64_t missed;      /* number of display periods without a new frame */
    uint64_t untracked;   /* number of frames without a pose of the head */
    double display_hz;    /* maximum display rate, in Hz, reported by the runtime; 0 before the first frame */
} ost_headset_counts;

/*
 * Finds the runtime and the headset, without starting a session. Returns OST_ERR_UNAVAILABLE if a component is missing;
 * the message names the component and the package to install.
 */
ost_status ost_headset_open(ost_headset **out, ost_error *err);
/*
 * Begins a session, which shows the renderer's pictures. The picture of an eye has width x height pixels; width 0 means
 * the size recommended by the runtime. `left` selects the controller of the left hand. `gl` is borrowed until
 * ost_headset_end.
 */
ost_status ost_headset_begin(ost_headset *headset, ost_gl *gl, int width, int height, bool left, ost_error *err);
ost_headset_info ost_headset_info_get(const ost_headset *headset);
/*
 * Runs one frame at the runtime's pace, or waits 10 ms if the runtime requests no frames. Sets *ended when the runtime
 * ends the session. Returns OST_ERR_UNAVAILABLE if the runtime fails.
 */
ost_status ost_headset_frame(ost_headset *headset, const ost_headset_calls *calls, bool *ended, ost_error *err);
ost_headset_counts ost_headset_counts_get(const ost_headset *headset);
/* Ends the session. Waits up to one second for the runtime. */
void ost_headset_end(ost_headset *headset);
void ost_headset_close(ost_headset *headset); /* ends the session if there is one; NULL is allowed */

#endif
