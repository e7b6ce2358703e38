/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Haptic devices and the servo loop, which reads a device and writes its wrench
 * a thousand times a second.
 *
 *   device --pose--> ost_servo --tick--> the caller's function
 *      ^                                        |
 *      '---------------- wrench ----------------'
 *
 * A device returns a pose in the bone's frame, quantised once (pose.h), and
 * accepts a wrench.  The servo loop polls most devices; a device with a clock of
 * its own calls the tick on its own thread.  `osteon devices` lists all devices.
 *
 * Threads: a device is used by one thread at a time.  While ost_servo_run runs,
 * only its thread uses the device.
 */
#ifndef OSTEON_HAPTICS_H
#define OSTEON_HAPTICS_H

#include <osteon/path.h>

#ifdef __cplusplus
extern "C" {
#endif

/* --------------------------------------------------------------- devices */

enum {
    OST_HAPTIC_FORCE = 1,       /* renders forces */
    OST_HAPTIC_TORQUE = 2,      /* renders torques */
    OST_HAPTIC_ORIENTATION = 4, /* senses orientation, not only position */
    OST_HAPTIC_TOOL = 8,        /* reports which tool is in use */
    OST_HAPTIC_OWN_CLOCK = 16,  /* calls the tick on its own thread */
    OST_HAPTIC_LOGICAL = 32,    /* its poses depend on the number of the tick only, not on time */
    OST_HAPTIC_SHOWN = 64       /* accepts forces and displays them; it renders none */
};

/*
 * Action of a button.  Each device has default actions for its buttons, which `osteon devices` lists and
 * `osteon sim --buttons` changes.
 */
typedef enum ost_action {
    OST_ACTION_NONE,
    OST_ACTION_MOTOR,        /* the motor is on while the button is held */
    OST_ACTION_SWITCH,       /* each press switches the motor on or off */
    OST_ACTION_TOOL,         /* selects the next tool, at the device's pose */
    OST_ACTION_CLUTCH,       /* while the button is held, the tool does not move and the device moves freely */
    OST_ACTION_HOME,         /* moves the tool to its first pose, clear of the bone, without cutting on the way */
    OST_ACTION_COUNT
} ost_action;
/* Returns the name of an action, "none", "motor", "home" and so on; static. */
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
    char reason[256];        /* if not available: the reason and a remedy */
    double max_force_n;      /* 0 if the device renders no force */
    double max_stiffness_n_m;
    int button_count;        /* button i is bit i of ost_haptic_state.buttons */
    ost_button buttons[OST_BUTTONS_MAX];
} ost_haptic_info;

/*
 * Fills out with the actions of a device's buttons: the defaults, changed by text, for instance
 * "stylus1=next-tool,2=none".  A button is given by its name or by its number from 1.  text may be NULL.
 * Returns OST_ERR_USAGE, with the name in err, for an unknown button or action.
 */
OST_API ost_status ost_buttons_parse(const ost_haptic_info *info, const char *text, ost_action out[OST_BUTTONS_MAX],
                                     ost_error *err);

/* Returns the number of devices that this library supports; indices 0 to count - 1 are in a fixed order. */
OST_API int ost_haptic_count(void);
/* Describes a device. Returns OST_ERR_USAGE if the index is out of range. */
OST_API ost_status ost_haptic_describe(int index, ost_haptic_info *out, ost_error *err);

typedef struct ost_haptic ost_haptic;
typedef struct ost_mouse_input ost_mouse_input;

/* Inputs of a device. Pointers are borrowed until ost_haptic_open returns. */
typedef struct ost_haptic_setup {
    const ost_path *path; /* script: path of the tool; sim: path of the simulated hand */
    const char *session;  /* replay: file name of a session */
    ost_mouse_input *mouse; /* mouse: hand that a window moves; borrowed until ost_haptic_close */
    ost_pose start;       /* null: pose of the tool; motion: first pose; real devices: pose at the handle's centre */
    ost_path_options gaps; /* motion: gaps of its file */
} ost_haptic_setup;

/*
 * Opens a device by a specification, "name" or "name:key=value,key=value":
 *
 *   null              does not move
 *   script            follows a path, one row a tick
 *   replay            repeats the ticks of a session
 *   sim               simulates a device of 60 g with friction and encoders in a hand that follows a path:
 *                     grip=light|normal|firm (normal), seed=N (1), tremor=UM (0), friction=MN (260)
 *   motion:FILE       recorded motion of a tracked hand (docs/reference/devices.md), plain or gzip: scale=PERCENT (5),
 *                     gap=MS, jump=MM (both are derived from its rows by default)
 *   mouse             the mouse of a window, through setup.mouse
 *   openhaptics       Touch, Touch X, Phantom Omni: name=TEXT, scale=PERCENT (100)
 *   dhd               Force Dimension, Falcon: scale=PERCENT (100)
 *   spnav             SpaceMouse: speed=MM/S (20), turn=DEGREES/S (30), hold=0|1 (0)
 *   inverse3          Haply's Inverse3 and VerseGrip: id=TEXT (the first), port=N (10001), scale=PERCENT (100)
 *   udp               a device on another machine that runs osteon bridge: key=FILE, port=N (4707),
 *                     bind=ADDRESS (127.0.0.1), lost=MS (5000)
 *
 * Returns OST_ERR_USAGE for an unknown name, key or value, or if the setup lacks an input that the device needs.
 * The caller owns *out and closes it by ost_haptic_close.
 */
OST_API ost_status ost_haptic_open(const char *spec, const ost_haptic_setup *setup, ost_haptic **out, ost_error *err);
/* Closes a device; its force is 0 afterwards. NULL is allowed. */
OST_API void ost_haptic_close(ost_haptic *device);
/* Returns the name of an open device without options; valid until it is closed. */
OST_API const char *ost_haptic_name(const ost_haptic *device);

enum { OST_HAPTIC_TEXT = 160 };
/* Writes a few words about an open device into text, for instance the address it listens on, or "". Returns text. */
OST_API const char *ost_haptic_about(const ost_haptic *device, char text[OST_HAPTIC_TEXT]);
/*
 * Force limits that an open device reports, and their source: "HD_NOMINAL_MAX_FORCE", "an omega".
 * The safety layer's limit is OST_HAPTIC_LIMIT_SHARE of the reported one.
 */
#define OST_HAPTIC_LIMIT_SHARE 0.9
typedef struct ost_haptic_limits {
    double force_n;                 /* peak force as reported by the device; may be NAN */
    double continuous_n, torque_nm; /* continuous force and torque; 0: not reported */
    char from[48];
} ost_haptic_limits;
/* Returns false if the device reports no limits. */
OST_API bool ost_haptic_limits_get(const ost_haptic *device, ost_haptic_limits *out);
/* Returns true if the force is 0.1 to 100 N and the torque is 0 or 0.001 to 10 N m. */
OST_API bool ost_haptic_limits_usable(const ost_haptic_limits *limits);
/* A counter of a device: its name and its value. */
enum { OST_HAPTIC_COUNTS = 12 };
typedef struct ost_haptic_tally {
    const char *name; /* "wrong_key" */
    uint64_t value;
} ost_haptic_tally;
/* Reads the counters of a device since it was opened. Returns their number. May be called on any thread. */
OST_API int ost_haptic_counts(const ost_haptic *device, ost_haptic_tally out[OST_HAPTIC_COUNTS]);

typedef enum ost_haptic_answer {
    OST_HAPTIC_FRESH, /* a new pose */
    OST_HAPTIC_NO_SAMPLE, /* no new sample; the state is unchanged */
    OST_HAPTIC_NOT_TRACKED, /* tracking is lost; when it returns, the device continues from the tool's last pose */
    OST_HAPTIC_ENDED, /* no more poses will follow, as planned: the end of a path */
    OST_HAPTIC_LOST   /* no more poses will follow: the device failed or was unplugged */
} ost_haptic_answer;

/* A sample of a device. */
typedef struct ost_haptic_state {
    ost_pose pose;
    int32_t tool; /* index of the tool; -1: the device does not report it */
    uint32_t buttons; /* bit i: button i is held */
    bool lifted;  /* the tool was lifted before this pose (path.h) */
    bool turned;  /* replay: the pose already contains the turn of a motor of speed rpm (motor.h) */
    int32_t rpm;  /* turns a minute; valid if turned */
} ost_haptic_state;

/* Force and torque on the hand, in the bone's frame; the torque is about the tool's origin. */
typedef struct ost_wrench {
    double force_n[3], torque_nm[3];
} ost_wrench;

/*
 * Reads a device; called once a tick.  Does not block.  A device with a clock of its own may be read only on the
 * device's thread within a tick, as ost_servo_run does.
 */
OST_API ost_haptic_answer ost_haptic_read(ost_haptic *device, ost_haptic_state *state);
/*
 * Writes a wrench; called once a tick.  Does not block.  A device with a clock of its own may be written only on the
 * device's thread within a tick, or when no ticks run.  Has no effect on a device that renders no force.
 */
OST_API void ost_haptic_write(ost_haptic *device, const ost_wrench *wrench);

/*
 * The hand of the device `mouse`.  A window's thread sets its pose, and the device follows it smoothly and no faster
 * than an operation accepts.  Both sides are wait-free; only one thread may call ost_mouse_input_put.
 */
enum { OST_MOUSE_PEDAL = 1 }; /* bit of the only button of the device `mouse` */
/* Creates the hand with its first state. The caller frees it after the device has been closed. */
OST_API ost_status ost_mouse_input_create(const ost_haptic_state *start, ost_mouse_input **out, ost_error *err);
/* Frees the hand of the device `mouse`. NULL is allowed. */
OST_API void ost_mouse_input_free(ost_mouse_input *mouse);
/* Sets the pose. With state->lifted the device moves there in one tick and reports that the tool was lifted. */
OST_API void ost_mouse_input_put(ost_mouse_input *mouse, const ost_haptic_state *state);

/* ------------------------------------------------------------- histograms */

/* A histogram of times: bins of 1 us below 4096 us, and bins of 1 ms up to 4096 ms for longer times. */
enum { OST_TIMES_BINS = 4096 };
/* A histogram; zero-initialise it before use. */
typedef struct ost_times {
    uint64_t count, max_ns;
    uint64_t us[OST_TIMES_BINS], ms[OST_TIMES_BINS];
} ost_times;

/* Adds a time in nanoseconds to a histogram. Allocates no memory. */
OST_API void ost_times_add(ost_times *times, uint64_t ns);
/*
 * Returns the quantile of share (0 to 1) in us: the upper end of its bin, but at most the greatest time.
 * Returns 0 for an empty histogram.
 */
OST_API double ost_times_share_us(const ost_times *times, double share);

/* ------------------------------------------------------------------ servo */

/*
 * Returns the core to reserve for the servo loop: the last one that the calling thread may use, or -1 if there is only
 * one or the system does not report it.  Call it before ost_servo_core_leave.  With a core of its own the loop misses
 * no deadlines to a renderer that uses all other cores.
 */
OST_API int ost_servo_core(void);
/* Removes a core from the affinity of the calling thread and of threads it creates later. Returns false on failure. */
OST_API bool ost_servo_core_leave(int core);

/* The real-time properties that the system granted, as text for reports. */
typedef struct ost_realtime {
    char scheduling[120]; /* "SCHED_FIFO 80", or the class in use and the reason */
    char memory[120];     /* "locked", or the reason why it is not */
    char core[120];       /* "core 1 alone", or the reason why there is none */
} ost_realtime;

typedef struct ost_servo_sample {
    uint64_t number;      /* number of the tick, from 0 */
    int64_t t_ns;         /* time of the world: number times the period */
    ost_haptic_state state;
    bool declared;        /* there is no new pose; state is the last one */
    bool tracking_lost;   /* tracking is lost; state is the last one, or has a zero quaternion if there was none */
    uint32_t wake_ns;     /* delay of the tick after its due time */
    uint32_t missed;      /* number of ticks skipped before this one */
} ost_servo_sample;

/*
 * Called on the servo thread for each tick.  wrench is zero on entry and is written to the device on return.  Returns
 * false to stop the loop.  Must not block.
 */
typedef bool ost_servo_tick(void *user, const ost_servo_sample *sample, ost_wrench *wrench);
/* Called on the servo thread after the wrench was written, with the duration of the tick. */
typedef void ost_servo_done(void *user, uint64_t number, uint32_t exec_ns);

/* Called on the servo thread before a tick is due, without its pose. Must not block; see lead_ns. */
typedef void ost_servo_rehearse(void *user);

/* Options of the servo loop; zero for the defaults. */
typedef struct ost_servo_options {
    int64_t period_ns;    /* 0: 1,000,000 */
    uint64_t ticks;       /* number of ticks; 0: until the device ends or tick returns false */
    bool no_clock;        /* run ticks without waiting, for devices whose poses do not depend on time */
    bool no_realtime;     /* request neither real-time priority nor locked memory */
    bool pinned;          /* run on `core` only; the affinity is restored afterwards */
    int core;
    /*
     * Time before a tick is due at which the loop wakes, calls rehearse, and then spins until the tick is due, so that
     * the core is awake and the data is in its caches.  0 to half a period.  Not used if it is 0, if rehearse is NULL,
     * or with a device that has a clock of its own.
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
 * The results of the servo loop. It has about 460 kB, because of its histograms: allocate it, do not
 * put it on the stack.
 */
typedef struct ost_servo_report {
    ost_servo_end end;
    uint64_t ticks;
    uint64_t missed;           /* deadlines: ticks that ended after the next one was due, and ticks skipped for them */
    /*
     * Causes, whose sum is `missed`.  missed_by_work: the tick used more than half a period of thread CPU time.
     * Otherwise missed_woken_late: the loop woke a period late or more.  Otherwise missed_preempted: it was preempted.
     */
    uint64_t missed_by_work, missed_woken_late, missed_preempted;
    int64_t lead_ns;           /* lead of the rehearsals; 0: there were none */
    uint64_t longest_miss;     /* greatest number of consecutive ticks skipped */
    uint64_t without_sample;   /* ticks without a new pose */
    uint64_t tracking_lost;    /* ticks without tracking */
    int64_t stolen_ms;         /* time that the hypervisor took from all cores during the run; -1: unknown */
    ost_times wake, exec, completion;
    ost_times own;             /* thread CPU time of the ticks: exec without preemption */
    ost_realtime realtime;
} ost_servo_report;

/*
 * The watchdog: this number of consecutive ticks without a new sample ends the loop, 5 ms at 1 kHz.
 * A device that reports lost tracking does deliver samples.
 */
enum { OST_SERVO_WATCHDOG_TICKS = 5 };

/*
 * Runs the servo loop on the calling thread until one of ost_servo_end.  Ticks are due at absolute times.  A late tick
 * runs at once; ticks that are already past are skipped and counted.  No tick runs before the device's first pose,
 * unless it reports that tracking is lost.  When the loop has ended, a wrench of 0 is written to the device.  A device
 * with a clock of its own calls tick on its own thread.
 *
 * options may be NULL (the defaults), done may be NULL.  report, about 260 kB, is filled in every case; allocate it on
 * the heap or statically.  Returns OST_ERR_USAGE, with a report of zeros and without a tick, if the period is not from
 * 10,000 ns to 1 s, if lead_ns is not from 0 to half a period, or if no_clock is set for a device without
 * OST_HAPTIC_LOGICAL.  Returns the error of a device with a clock of its own that cannot run.
 */
OST_API ost_status ost_servo_run(ost_haptic *device, const ost_servo_options *options, ost_servo_tick *tick,
                                 ost_servo_done *done, void *user, ost_servo_report *report, ost_error *err);

#ifdef __cplusplus
}
#endif
#endif
