/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Libraries that stand in for the vendors': each notes what it is asked, and
 * fails as it is told.  A test loads the same file and finds the note by name.
 */
#ifndef OST_TESTS_FAKE_H
#define OST_TESTS_FAKE_H

#include <stdatomic.h>

enum { FAKE_CALLS = 4096, FAKE_EVENTS = 64 };

/* Written before a device is opened, but for what is atomic. */
typedef struct fake_note {
    char calls[FAKE_CALLS]; /* a letter a call, in order, as far as there is room */
    int count;
    double position[3];     /* in the device's own unit */
    double column[3][3];    /* of the handle's frame in the device's */
    double force[3], torque[3]; /* as given last */
    double limit, continuous; /* N, as the library reports them */
    int type;               /* of device, likewise */
    double most_force;      /* the greatest component ever given */
    int forces_on;
    int buttons;
    _Atomic int fail_open, fail_read_at, fail_write_at, warm_at, hang_at, no_number_at; /* 0: never; else the number of the frame */
    _Atomic int frames;
} fake_note;

/* Events that a test gives, as the library has them: type, then its numbers. */
typedef struct fake_feed {
    int event[FAKE_EVENTS][8];
    int count, taken;
} fake_feed;

static inline void fake_call(fake_note *note, char letter)
{
    if (note->count < FAKE_CALLS - 1)
        note->calls[note->count++] = letter;
}

#endif
