/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Stand-ins for the vendors' libraries. Each stand-in records the calls of its functions, and fails on
 * request. A test loads the same file and finds the record by its symbol name.
 */
#ifndef OST_TESTS_FAKE_H
#define OST_TESTS_FAKE_H

#include <stdatomic.h>

enum { FAKE_CALLS = 4096, FAKE_EVENTS = 64 };

/*
 * Settings and record of a stand-in library. The test writes the settings before it opens a
 * device. It may write the atomic members at any time.
 */
typedef struct fake_note {
    char calls[FAKE_CALLS]; /* one letter per call, in order, until the array is full */
    int count;
    double position[3];     /* position in the device's unit of length */
    double column[3][3];    /* axes of the handle in the device's frame */
    double force[3], torque[3]; /* values that were last written */
    double limit, continuous; /* force limits in N, as the library reports them */
    int type;               /* device type that the library reports */
    double most_force;      /* greatest force component written so far */
    int forces_on;
    int buttons;
    /* For each type of failure, the number of the frame at which the stand-in fails in this way; 0 means never. */
    _Atomic int fail_open, fail_read_at, fail_write_at, warm_at, hang_at, no_number_at;
    _Atomic int frames;
} fake_note;

/*
 * Events that a test provides to a stand-in. In the format of the library, an event consists of a type and
 * several numbers.
 */
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
