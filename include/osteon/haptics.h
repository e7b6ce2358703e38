/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Haptic devices, and the servo loop, which reads the pose of a device and writes a
 * wrench to the device a thousand times a second.
 *
 *   device --pose--> ost_servo --tick--> the caller's function
 *      ^                                        |
 *      '---------------- wrench ----------------'
 *
 * A device returns a pose in the bone's frame and accepts a wrench. The pose is quantised once
 * (pose.h). The servo loop polls most devices; a device with a clock of its own calls the tick
 * function on its own thread. `osteon devices` lists all devices.
 *
 * Threads: a device may be used by one thread at a time.  While ost_servo_run is
 * running, only the servo thread may use the device.  The comments of ost_haptic_counts,
 * ost_haptic_write and ost_mouse_input_put state exceptions.  ost_haptic_describe,
 * ost_haptic_open and ost_haptic_close may be called by only one thread at a time, because
 * the libraries of some devices have global state.  The other functions share no state; an
 * object may be used by one thread at a time.
 */
#ifndef OSTEON_HAPTICS_H
#define OSTEON_HAPTICS_H

#include <osteon/path.h>

#ifdef __cplusplus
extern "C" {
#endif

/* --------------------------------------------------------------- devices */

enum {
    OST_HAPTIC_FORCE = 1,       /* the device renders forces */
    OST_HAPTIC_TORQUE = 2,      /* the device renders torques */
    OST_HAPTIC_ORIENTATION = 4, /* the device measures orientation in addition to position */
    OST_HAPTIC_TOOL = 8,        /* the device reports which tool is in use */
    OST_HAPTIC_OWN_CLOCK = 16,  /* the device calls the tick function on its own thread */
    OST_HAPTIC_LOGICAL = 32,    /* the device's poses depend only on the tick number, not on time */
    OST_HAPTIC_SHOWN = 64       /* the force is displayed by viewers but is not rendered by the device */
};

/*
 * The action of a button. Each device has default actions for its buttons. `osteon devices` lists these actions, and
 * the option --buttons of `osteon sim` changes them.
 */
typedef enum ost_action {
    OST_ACTION_NONE,
    OST_ACTION_MOTOR,        /* the motor is on while the button is held */
    OST_ACTION_SWITCH,       /* each press switches the motor on or off */
    OST_ACTION_TOOL,         /* each press selects the next tool, which starts at the device's pose */
    OST_ACTION_CLUTCH,       /* while the button is held, the tool does not move and the device moves freely */
    OST_ACTION_HOME,         /* returns the tool, without cutting, to its first pose, which is clear of the bone */
    OST_ACTION_COUNT
} ost_action;
/* Returns the name of an action, for example "none", "motor" or "home"; static. */
OST_API const char *ost_action_name(ost_action action);

enum { OST_BUTTONS_MAX = 8 };
typedef struct ost_button {
    const char *name; /* "stylus1" */
    ost_action action;
} ost_button;

typedef struct ost_haptic_info {
    const char *name;        /* "sim" */
    const char *description; /* one sentence */
    uint32_t caps;           /* OST_HAPTIC_* bits */
    bool available;
    char reason[256];        /* the reason why the device is not available, and how to make it available */
    double max_force_n;      /* maximum force, N; 0 if the device renders no force */
    double max_stiffness_n_m; /* maximum coupling stiffness that the device can render, N/m */
    int button_count;        /* number of buttons; button i is bit i of ost_haptic_state.buttons */
    ost_button buttons[OST_BUTTONS_MAX];
} ost_haptic_info;

/*
 * Writes the action of each button of a device to out. A button has its default action unless `text` assigns a
 * different one, as in "stylus1=next-tool,2=none". `text` identifies a button by its name or by its number, counted
 * from 1, and may be NULL. Returns OST_ERR_USAGE, with the unknown name in err, for an unknown button or action.
 */
OST_API ost_status ost_buttons_parse(const ost_haptic_info *info, const char *text, ost_action out[OST_BUTTONS_MAX],
                                     ost_error *err);

/* Returns the number of devices that this library supports. The devices are numbered from 0 in a fixed order. */
OST_API int ost_haptic_count(void);
/* Describes device number `index`. Returns OST_ERR_USAGE if index is out of range. */
OST_API ost_status ost_haptic_describe(int index, ost_haptic_info *out, ost_error *err);

typedef struct ost_haptic ost_haptic;
typedef struct ost_mouse_input ost_mouse_input;
/* The input of the `openxr` device. The osteon command creates it; other programs pass NULL. */
typedef struct ost_hand_input ost_hand_input;

/* The data that is needed to open a device. The pointers are borrowed until ost_haptic_open returns. */
typedef struct ost_haptic_setup {
    const ost_path *path; /* path of the tool for the `script` device, or of the simulated hand for the `sim` device */
    const char *session;  /* file name of the session that the `replay` device repeats */
    ost_mouse_input *mouse; /* input of the `mouse` device, set by a window; borrowed until ost_haptic_close */
    ost_hand_input *hand;   /* input of the `openxr` device, set by a headset; borrowed until ost_haptic_close */
    /*
     * First pose of the tool. The `null` device keeps this pose, and the `motion` device begins at it. For a real
     * device, it is the pose of the tool when the handle is in its central position.
     */
    ost_pose start;
    ost_path_options gaps; /* rules by which the `motion` device finds gaps in the file */
} ost_haptic_setup;

/*
 * Opens a device by a specification, "name" or "name:key=value,key=value".  Defaults are in parentheses:
 *
 *   null              does not move
 *   script            follows a path, one row per tick
 *   replay            repeats the ticks of a session
 *   sim               simulates a device of 60 g with friction and encoders, held by a hand that follows a path:
 *                     grip=light|normal|firm (normal), seed=N (1), tremor=UM (0), friction=MN (260)
 *   motion:FILE       recorded motion of a tracked hand (docs/reference/devices.md), plain or gzip: scale=PERCENT (5),
 *                     gap=MS, jump=MM (both are derived from the rows of the file by default)
 *   mouse             the mouse of a window, through setup.mouse
 *   openxr            a tracked controller of a headset, through setup.hand: hand=left|right (right)
 *   openhaptics       Touch, Touch X, Phantom Omni: name=TEXT, scale=PERCENT (100)
 *   dhd               Force Dimension, Falcon: scale=PERCENT (100)
 *   spnav             SpaceMouse: speed=MM/S (20), turn=DEGREES/S (30), hold=0|1 (0)
 *   inverse3          Haply's Inverse3 and VerseGrip: id=TEXT (the first), port=N (10001), scale=PERCENT (100)
 *   udp               a device on another machine, where osteon bridge runs: key=FILE, port=N (4707),
 *                     bind=ADDRESS (127.0.0.1), lost=MS (5000)
 *
 * Returns OST_ERR_USAGE for an unknown name, key or value, or if the setup lacks an input that the device needs.
 * Returns OST_ERR_UNAVAILABLE if the device, its library or its driver is missing, does not answer or is in use, and
 * OST_ERR_MEMORY if memory is exhausted. If the device reads a file, the errors of the function that reads this file
 * are also returned. The caller owns *out and closes it with ost_haptic_close.
 */
OST_API ost_status ost_haptic_open(const char *spec, const ost_haptic_setup *setup, ost_haptic **out, ost_error *err);
/* Sets the device's force to 0, and closes and frees the device. NULL is allowed. */
OST_API void ost_haptic_close(ost_haptic *device);
/* Returns the name of an open device without its options. The string is valid until the device is closed. */
OST_API const char *ost_haptic_name(const ost_haptic *device);

enum { OST_HAPTIC_TEXT = 160 };
/*
 * Writes a short description of an open device to text, for example the address on which the device listens. The
 * description may be "". Returns text.
 */
OST_API const char *ost_haptic_about(const ost_haptic *device, char text[OST_HAPTIC_TEXT]);
/* The force limit of the safety layer, as a share of the force limit that the device reports. */
#define OST_HAPTIC_LIMIT_SHARE 0.9
/* The force limits that an open device reports, and their source, for example "HD_NOMINAL_MAX_FORCE" or "an omega". */
typedef struct ost_haptic_limits {
    double force_n;                 /* peak force that the device reports, N; may be NAN */
    /* Continuous force in N and continuous torque in N m; 0 if the device does not report the value. */
    double continuous_n, torque_nm;
    char from[48];
} ost_haptic_limits;
/* Writes the force limits of a device to *out. Returns false if the device reports no limits. */
OST_API bool ost_haptic_limits_get(const ost_haptic *device, ost_haptic_limits *out);
/* Returns true if the limits are plausible: a force of 0.1 to 100 N, and a torque of 0 or of 0.001 to 10 N m. */
OST_API bool ost_haptic_limits_usable(const ost_haptic_limits *limits);
/* The maximum number of counters of a device. */
enum { OST_HAPTIC_COUNTS = 12 };
/* A counter of a device. */
typedef struct ost_haptic_tally {
    const char *name; /* "wrong_key" */
    uint64_t value;
} ost_haptic_tally;
/*
 * Writes the counters of a device to out and returns the number of counters. All counters are 0 when the device is
 * opened. May be called on any thread.
 */
OST_API int ost_haptic_counts(const ost_haptic *device, ost_haptic_tally out[OST_HAPTIC_COUNTS]);

typedef enum ost_haptic_answer {
    OST_HAPTIC_FRESH, /* a new pose */
    OST_HAPTIC_NO_SAMPLE, /* no new sample; the state is unchanged */
    /* tracking is lost; when it resumes, the tool continues from its last pose, unless the first new pose is lifted */
    OST_HAPTIC_NOT_TRACKED,
    OST_HAPTIC_ENDED, /* the input, for example a path, has ended; no more poses will follow */
    OST_HAPTIC_LOST   /* the device failed or was unplugged; no more poses will follow */
} ost_haptic_answer;

/* A sample that was read from a device. */
typedef struct ost_haptic_state {
    ost_pose pose;
    int32_t tool; /* index of the tool in use; -1 if the device does not report it */
    uint32_t buttons; /* bit i is set while button i is held */
    bool lifted;  /* true if the tool was lifted before this pose (path.h) */
    /* True if the pose already includes the rotation of the motor at `rpm` (motor.h). Set by the `replay` device. */
    bool turned;
    int32_t rpm;  /* motor speed in revolutions per minute; valid if `turned` is true */
} ost_haptic_state;

/* Force and torque on the hand, in the bone's frame. The torque is about the tool's origin. */
typedef struct ost_wrench {
    double force_n[3], torque_nm[3];
} ost_wrench;

/*
 * Reads a device.  Called once per tick.  Does not block.  If the device has a clock of its own, only the device's
 * thread may call this function, and only within a tick. ost_servo_run observes this rule.
 */
OST_API ost_haptic_answer ost_haptic_read(ost_haptic *device, ost_haptic_state *state);
/*
 * Writes a wrench to a device.  Called once per tick.  Does not block.  If the device has a clock of its own, only the
 * device's thread may call this function within a tick; any thread may call it while no ticks run. If the device
 * renders no force, the call has no effect.
 */
OST_API void ost_haptic_write(ost_haptic *device, const ost_wrench *wrench);

/*
 * The input of the `mouse` device.  A window's thread sets a pose. The device follows this pose smoothly, at a speed
 * that an operation accepts.  Setting and reading the pose are wait-free.  Only one thread may call
 * ost_mouse_input_put.
 */
enum { OST_MOUSE_PEDAL = 1 }; /* bit of the only button of the `mouse` device */
/* Creates the input of the `mouse` device, with the first state *start. Returns OST_ERR_RANGE if the pose of this state
 * is invalid, and OST_ERR_MEMORY if memory is exhausted. The caller frees *out with ost_mouse_input_free after closing
 * the device. */
OST_API ost_status ost_mouse_input_create(const ost_haptic_state *start, ost_mouse_input **out, ost_error *err);
/* Frees the input of the `mouse` device. NULL is allowed. */
OST_API void ost_mouse_input_free(ost_mouse_input *mouse);
/*
 * Sets the pose that the `mouse` device follows. If state->lifted is true, the device moves to this pose in one tick
 * and reports that the tool was lifted.
 */
OST_API void ost_mouse_input_put(ost_mouse_input *mouse, const ost_haptic_state *state);

/* ------------------------------------------------------------- histograms */

/*
 * Number of bins in each of the two parts of a histogram. The bins of the first part are 1 us wide, for times below
 * 4096 us. The bins of the second part are 1 ms wide, for longer times up to 4096 ms.
 */
enum { OST_TIMES_BINS = 4096 };
/* A histogram of times. Zero-initialise it before use. */
typedef struct ost_times {
    uint64_t count, max_ns;
    uint64_t us[OST_TIMES_BINS], ms[OST_TIMES_BINS];
} ost_times;

/* Adds a time in nanoseconds to a histogram. Allocates no memory. */
OST_API void ost_times_add(ost_times *times, uint64_t ns);
/*
 * Returns the quantile `share` (0 to 1) in us.  The result is the upper end of the bin that contains the quantile,
 * limited to the maximum time that was added. Returns 0 for an empty histogram.
 */
OST_API double ost_times_share_us(const ost_times *times, double share);

/* ------------------------------------------------------------------ servo */

/*
 * Returns the core to reserve for the servo loop. This is the last core in the calling thread's affinity mask, or
 * -1 if the mask has only one core or is unknown. Must be called before ost_servo_core_leave. With a reserved core, the
 * loop meets its deadlines even if a renderer uses all other cores.
 */
OST_API int ost_servo_core(void);
/*
 * Removes a core from the affinity mask of the calling thread, and thus of all threads that it creates later.
 * Returns false on failure.
 */
OST_API bool ost_servo_core_leave(int core);

/* The real-time properties that the system granted, as text for reports. */
typedef struct ost_realtime {
    char scheduling[120]; /* "SCHED_FIFO 80", or the scheduling in use and the reason for it */
    char memory[120];     /* "locked", or the reason why memory is not locked */
    char core[120];       /* "core 1 alone", or the reason why no core is reserved */
} ost_realtime;

typedef struct ost_servo_sample {
    uint64_t number;      /* number of the tick, counted from 0 */
    int64_t t_ns;         /* time of the world: number * period */
    ost_haptic_state state;
    bool declared;        /* true if there is no new pose; `state` is then the last state */
    /* True if tracking is lost. `state` is then the last state; its quaternion is zero if tracking was lost from
     * the start. */
    bool tracking_lost;
    uint32_t wake_ns;     /* delay from the due time of the tick to its start */
    uint32_t missed;      /* number of ticks skipped before this tick */
} ost_servo_sample;

/*
 * Called on the servo thread for each tick. *wrench is zero on entry; after the return, it is written to the
 * device. Returns false to stop the loop. Must not block.
 */
typedef bool ost_servo_tick(void *user, const ost_servo_sample *sample, ost_wrench *wrench);
/* Called on the servo thread after the wrench has been written. exec_ns is the duration of the tick. */
typedef void ost_servo_done(void *user, uint64_t number, uint32_t exec_ns);

/*
 * Called on the servo thread before a tick is due, when the pose of the tick is not yet available. Must not block.
 * See lead_ns.
 */
typedef void ost_servo_rehearse(void *user);

/* Options of the servo loop. A zero-initialised struct selects the defaults. */
typedef struct ost_servo_options {
    int64_t period_ns;    /* period of the ticks in ns; 0 selects 1,000,000 */
    /* number of ticks; 0 means that the loop runs until the device ends or the tick function returns false */
    uint64_t ticks;
    bool no_clock;        /* true to run ticks without waiting; for devices whose poses do not depend on time */
    bool no_realtime;     /* true to request neither real-time priority nor locked memory */
    bool pinned;          /* true to run the loop only on `core`; the affinity mask is restored afterwards */
    int core;
    /*
     * The loop wakes lead_ns nanoseconds before a tick is due, calls rehearse, and then spins until the tick is due.
     * When the tick starts, the core is therefore awake and its caches contain the tick's data. The range is 0 to half
     * a period. There is no rehearsal if lead_ns is 0, rehearse is NULL, no_clock is set, or the device has a clock of
     * its own.
     */
    int64_t lead_ns;
    ost_servo_rehearse *rehearse;
} ost_servo_options;

/* The reason why the servo loop ended. */
typedef enum ost_servo_end {
    OST_SERVO_TICKS,
    OST_SERVO_STOPPED,
    OST_SERVO_DEVICE_ENDED,
    OST_SERVO_DEVICE_LOST,
    OST_SERVO_WATCHDOG
} ost_servo_end;

/*
 * The results of the servo loop. The struct has a size of about 260 kB, because it contains histograms. It should
 * not be placed on the stack.
 */
typedef struct ost_servo_report {
    ost_servo_end end;
    uint64_t ticks;
    /*
     * Number of missed deadlines: ticks that ended after the next tick was due, and ticks that were skipped for this
     * reason.
     */
    uint64_t missed;
    /*
     * Missed deadlines by cause; their sum is `missed`. missed_by_work counts ticks that used more than half a
     * period of thread CPU time. Of the other ticks, missed_woken_late counts those for which the loop woke at least
     * one period late. missed_preempted counts all remaining ticks, during which the servo thread was preempted.
     */
    uint64_t missed_by_work, missed_woken_late, missed_preempted;
    int64_t lead_ns;           /* time by which a rehearsal precedes its tick; 0 if there were no rehearsals */
    uint64_t longest_miss;     /* maximum number of consecutive skipped ticks */
    uint64_t without_sample;   /* number of ticks without a new pose */
    uint64_t tracking_lost;    /* number of ticks during which tracking was lost */
    /* Time in ms that the hypervisor stole during the run, summed over all cores; -1 if unknown. */
    int64_t stolen_ms;
    ost_times wake, exec, completion;
    /* Thread CPU time of the ticks, which is their duration without preemption. */
    ost_times own;
    ost_realtime realtime;
} ost_servo_report;

/*
 * The watchdog ends the loop after this number of consecutive ticks without a new sample. At 1 kHz, this is 5 ms. A
 * report that tracking is lost counts as a sample.
 */
enum { OST_SERVO_WATCHDOG_TICKS = 5 };

/*
 * Runs the servo loop on the calling thread until one of the events listed in ost_servo_end occurs.  Ticks are due at
 * absolute times.  A late tick runs at once; ticks whose time has passed are skipped and counted.  No tick runs before
 * the device's first pose, unless the device reports that tracking is lost.  When the loop ends, a zero wrench is
 * written to the device.  A device with a clock of its own calls tick on its own thread.
 *
 * `options` may be NULL, which selects the defaults. `done` may be NULL. *report is always written; its size is about
 * 260 kB, so it should not be placed on the stack. Returns OST_ERR_USAGE if the period is not within 10,000 ns to 1 s,
 * if lead_ns is not within 0 to half a period, or if no_clock is set for a device without OST_HAPTIC_LOGICAL. In these
 * cases, no tick is run, and *report contains zeros. Returns OST_ERR_UNAVAILABLE if a device with a clock of its own
 * does not call the tick function.
 */
OST_API ost_status ost_servo_run(ost_haptic *device, const ost_servo_options *options, ost_servo_tick *tick,
                                 ost_servo_done *done, void *user, ost_servo_report *report, ost_error *err);

#ifdef __cplusplus
}
#endif
#endif
