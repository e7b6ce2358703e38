/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The input of the `openxr` device. A headset's thread sets the controller's pose in the bone's frame, once per frame;
 * the device reads the newest pose in each tick. Both sides are wait-free.
 */
#ifndef OST_HAPTICS_HAND_H
#define OST_HAPTICS_HAND_H

#include <osteon/haptics.h>

typedef struct ost_hand_sample {
    bool tracked;     /* if false, the other fields are ignored */
    ost_pose pose;    /* pose of the tool in the bone's frame */
    uint32_t buttons; /* pressed buttons (OST_HAND_*); bit i is button i of the `openxr` device */
} ost_hand_sample;

enum { OST_HAND_TRIGGER = 1, OST_HAND_MENU = 2, OST_HAND_SQUEEZE = 4 };

/* Creates an input whose hand is initially not tracked. The caller frees the input after closing the device. */
ost_status ost_hand_input_create(ost_hand_input **out, ost_error *err);
void ost_hand_input_free(ost_hand_input *input); /* NULL is allowed */
/* Sets the newest sample. Only one thread may call this function. */
void ost_hand_input_put(ost_hand_input *input, const ost_hand_sample *sample);
/* Returns true if the headset must track the left hand's controller. The device sets this value when it is opened. */
bool ost_hand_input_is_left(const ost_hand_input *input);

#endif
