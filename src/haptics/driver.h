/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A driver is a const table, a file each, and a line in table.c.
 *
 *   usable   may it be opened here?  else reason says why
 *   answers  asked by who lists devices alone: what only an attempt to open it tells
 *   open     with the part of the spec behind the colon, "" without one
 *   read     polled devices: the pose of this tick; no lock, no allocation, no waiting;
 *            one that says UNSEEN goes on afterwards from where it was (clutch.h)
 *   write    the wrench of this tick, likewise
 *   run      devices with a clock of their own: calls tick from their thread
 *            until it returns false, and then returns; read and write serve
 *            from within tick
 */
#ifndef OST_HAPTICS_DRIVER_H
#define OST_HAPTICS_DRIVER_H

#include <osteon/haptics.h>

typedef struct haptic_instance haptic_instance; /* each driver's own */
typedef bool haptic_beat(void *user);

typedef struct haptic_driver {
    const char *name, *description;
    uint32_t caps;
    double max_force_n, max_stiffness_n_m;
    ost_button buttons[OST_BUTTONS_MAX]; /* bit by bit; up to the first without a name */
    bool (*usable)(char reason[256]); /* NULL: always */
    bool (*answers)(char reason[256]); /* NULL: it does */
    ost_status (*open)(const char *options, const ost_haptic_setup *setup, haptic_instance **out, ost_error *err);
    void (*close)(haptic_instance *instance);
    ost_haptic_answer (*read)(haptic_instance *instance, ost_haptic_state *state);
    void (*write)(haptic_instance *instance, const ost_wrench *wrench); /* NULL without OST_HAPTIC_FORCE */
    void (*about)(haptic_instance *instance, char text[OST_HAPTIC_TEXT]);          /* NULL: nothing to say */
    void (*limits)(haptic_instance *instance, ost_haptic_limits *out); /* NULL: it reports none; out is zero before */
    int (*counts)(haptic_instance *instance, ost_haptic_tally out[OST_HAPTIC_COUNTS]); /* NULL: nothing counted */
    ost_status (*run)(haptic_instance *instance, haptic_beat *beat, void *user, ost_error *err); /* with OST_HAPTIC_OWN_CLOCK alone */
} haptic_driver;

struct ost_haptic {
    const haptic_driver *driver;
    haptic_instance *instance;
};

/* As ost_haptic_open does; tests give drivers of their own. */
ost_status ost_haptic_open_driver(const haptic_driver *driver, const char *options, const ost_haptic_setup *setup, ost_haptic **out,
                                  ost_error *err);

/* ---------------------------------------------------------------- options.c */

/* Called for each key=value of options; OST_ERR_USAGE of its own for what it does not know. */
typedef ost_status haptic_option(void *user, const char *key, const char *value, ost_error *err);
ost_status haptic_options(const char *device, const char *options, haptic_option *take, void *user, ost_error *err);
/* lo <= number <= hi, likewise. */
ost_status haptic_number(const char *device, const char *key, const char *value, double lo, double hi, double *out, ost_error *err);
/* lo <= whole number <= hi, or OST_ERR_USAGE that names device and key. */
ost_status haptic_integer(const char *device, const char *key, const char *value, int64_t lo, int64_t hi, int64_t *out, ost_error *err);

extern const haptic_driver haptic_null, haptic_script, haptic_replay, haptic_sim, haptic_motion, haptic_mouse,
    haptic_openhaptics, haptic_dhd, haptic_spnav, haptic_inverse3, haptic_udp;

#endif
