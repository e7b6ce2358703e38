/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A small OpenXR runtime for tests: a headset with two eyes and a controller, whose poses the test sets. It implements
 * the functions that src/headset calls. The loader opens it as XR_RUNTIME_JSON says; the test finds its state as the
 * symbol fake_xr. It keeps the pictures that were shown, with row 0 at the bottom, as OpenGL has them.
 */
#ifndef OST_TESTS_HEADSET_RUNTIME_H
#define OST_TESTS_HEADSET_RUNTIME_H

#include <stdbool.h>
#include <stdint.h>

enum { FAKE_WIDTH = 160, FAKE_HEIGHT = 120, FAKE_PIXELS = FAKE_WIDTH * FAKE_HEIGHT };

typedef struct fake_xr_state {
    /* set by the test */
    float eye_x[2];          /* positions of the eyes on the x axis, m; they look along -z */
    float fov[2][4];         /* left, right, up, down */
    bool head_tracked, hand_tracked, hidden; /* hidden: the runtime requests that nothing is drawn */
    float hand[3];           /* position of the grip, m */
    uint32_t buttons;        /* in the order in which actions are made */
    bool waits;              /* a frame takes a period of the display */
    int skip;                /* periods of the display that pass in addition, once */
    int slow;                /* periods of the display in a period that the runtime states; 0: 1 */
    int lose_after;          /* frames after which the session is lost; 0: never */
    bool no_egl;             /* lacks XR_MNDX_egl_enable */
    bool no_headset;
    const char *fail;        /* name of a function that fails; NULL for none */
    /* set by the runtime */
    uint32_t picture[2][FAKE_PIXELS];
    float shown_fov[2][4];
    int frames, layers;      /* frames that ended; those with a picture */
    int instances, sessions; /* those that were not destroyed */
    bool wrong_order;        /* set if a call was made in a state that OpenXR does not allow */
} fake_xr_state;

#endif
