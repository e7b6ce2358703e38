/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A driver consists of a constant table in its own file and a line in table.c. The table has these functions:
 *
 *   usable   returns true if the device can be opened on this machine; otherwise writes the reason
 *   answers  opens the device to check that it responds; called only when devices are listed
 *   open     receives the part of the spec after the colon, "" if there is none
 *   read     returns the pose for this tick; takes no lock, allocates no memory and does not wait; after
 *            OST_HAPTIC_NOT_TRACKED the tool continues from its last position (clutch.h), unless the first
 *            new pose is lifted, as in the openxr driver
 *   write    sends the wrench of this tick, under the same rules
 *   run      for devices with their own clock: calls `beat` on the device's
 *            thread until `beat` returns false, and then returns; read and
 *            write are called from within `beat`
 */
#ifndef OST_HAPTICS_DRIVER_H
#define OST_HAPTICS_DRIVER_H

#include <osteon/haptics.h>

typedef struct haptic_instance haptic_instance; /* state of an open device; each driver defines this struct */
typedef bool haptic_beat(void *user);

typedef struct haptic_driver {
    const char *name, *description;
    uint32_t caps;
    double max_force_n, max_stiffness_n_m;
    /* buttons[i] describes bit i of the buttons' state; the list ends before the first entry without a name */
    ost_button buttons[OST_BUTTONS_MAX];
    bool (*usable)(char reason[256]); /* returns true if the device can be used; NULL if the device is always usable */
    /* returns true if the device responds; NULL if the device is assumed to respond */
    bool (*answers)(char reason[256]);
    ost_status (*open)(const char *options, const ost_haptic_setup *setup, haptic_instance **out, ost_error *err);
    void (*close)(haptic_instance *instance);
    ost_haptic_answer (*read)(haptic_instance *instance, ost_haptic_state *state);
    /* NULL if the device does not have the flag OST_HAPTIC_FORCE */
    void (*write)(haptic_instance *instance, const ost_wrench *wrench);
    /* writes a description of the device; NULL if there is none */
    void (*about)(haptic_instance *instance, char text[OST_HAPTIC_TEXT]);
    /* Writes the limits of the device to *out, which is zero before the call. NULL if the device reports no limits. */
    void (*limits)(haptic_instance *instance, ost_haptic_limits *out);
    /* returns the driver's counters; NULL if the driver has no counters */
    int (*counts)(haptic_instance *instance, ost_haptic_tally out[OST_HAPTIC_COUNTS]);
    /* NULL unless the driver has the flag OST_HAPTIC_OWN_CLOCK */
    ost_status (*run)(haptic_instance *instance, haptic_beat *beat, void *user, ost_error *err);
} haptic_driver;

struct ost_haptic {
    const haptic_driver *driver;
    haptic_instance *instance;
};

/* Opens a device as ost_haptic_open does, but with the given driver. Tests pass their own drivers. */
ost_status ost_haptic_open_driver(const haptic_driver *driver, const char *options, const ost_haptic_setup *setup,
                                  ost_haptic **out, ost_error *err);

/* ---------------------------------------------------------------- options.c */

/* Handles one key=value of the options. Returns OST_ERR_USAGE if the driver does not support the key. */
typedef ost_status haptic_option(void *user, const char *key, const char *value, ost_error *err);
ost_status ost_haptic_options(const char *device, const char *options, haptic_option *take, void *user, ost_error *err);
/*
 * Parses a number in the range lo <= number <= hi. For any other text, returns OST_ERR_USAGE with a
 * message that names the device and the key.
 */
ost_status ost_haptic_number(const char *device, const char *key, const char *value, double lo, double hi, double *out,
                             ost_error *err);
/*
 * Parses an integer in the range lo <= number <= hi. For any other text, returns the same error as
 * ost_haptic_number.
 */
ost_status ost_haptic_integer(const char *device, const char *key, const char *value, int64_t lo, int64_t hi,
                              int64_t *out, ost_error *err);

extern const haptic_driver ost_haptic_null, ost_haptic_script, ost_haptic_replay, ost_haptic_sim, ost_haptic_motion,
    ost_haptic_mouse, ost_haptic_openhaptics, ost_haptic_dhd, ost_haptic_spnav, ost_haptic_inverse3, ost_haptic_udp,
    ost_haptic_openxr;

#endif
