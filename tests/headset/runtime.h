/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A small OpenXR runtime for tests: a headset with two eyes, and a controller. The test sets their poses. The runtime
 * implements the functions that src/headset calls. The environment variable XR_RUNTIME_JSON makes the OpenXR loader
 * open this runtime, and the test accesses the runtime's state through the symbol fake_xr. The runtime keeps the
 * pictures that were shown. Row 0 is at the bottom, as in OpenGL.
 */
#ifndef OST_TESTS_HEADSET_RUNTIME_H
#define OST_TESTS_HEADSET_RUNTIME_H

#include <stdbool.h>
#include <stdint.h>

enum { FAKE_WIDTH = 160, FAKE_HEIGHT = 120, FAKE_PIXELS = FAKE_WIDTH * FAKE_HEIGHT };

typedef struct fake_xr_state {
    /* The test writes the following members. */
    float eye_x[2];          /* positions of the eyes on the x axis, in m; both eyes look along -z */
    float fov[2][4];         /* angles to the left, right, upper and lower edge of each eye's picture, in radians */
    bool head_tracked, hand_tracked, hidden; /* if hidden is true, the runtime requests that nothing is drawn */
    float hand[3];           /* position of the grip, in m */
    uint32_t buttons;        /* bit i is set while the button of the i-th boolean action is pressed */
    bool waits;              /* true if waiting for a frame takes one period of the display */
    int skip;                /* number of additional display periods by which the next frame is late */
    int slow;                /* frame period that the runtime announces, in display periods; 0 means 1 */
    int lose_after;          /* number of frames after which the session is lost; 0 means never */
    bool no_egl;             /* true if the runtime does not offer XR_MNDX_egl_enable */
    bool no_headset;
    const char *fail;        /* name of the function that fails, or NULL if no function fails */
    /* The runtime writes the following members. */
    uint32_t picture[2][FAKE_PIXELS];
    float shown_fov[2][4];
    int frames, layers;      /* number of completed frames, and how many of them had a picture */
    int instances, sessions; /* numbers of existing instances and sessions */
    bool wrong_order;        /* set if a call was made in a state that OpenXR does not allow */
} fake_xr_state;

#endif
