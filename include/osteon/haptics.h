/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Devices that move a tool, and the loop that serves them a thousand times a
 * second.
 *
 *   device --pose--> ost_servo --tick--> what the program does with it
 *      ^                                        |
 *      '---------------- wrench ----------------'
 *
 * A device gives a pose in the bone's frame, quantised once (pose.h), and
 * takes a wrench.  Some are asked by our loop; those with a clock of their own
 * call the tick from their thread.  osteon devices lists them all.
 *
 * Threads: a device is used by one thread at a time; ost_servo_run is that
 * thread while it runs.
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
    OST_HAPTIC_TOOL = 8,        /* says which tool is in the hand */
    OST_HAPTIC_OWN_CLOCK = 16,  /* its own thread calls the tick */
    OST_HAPTIC_LOGICAL = 32,    /* knows ticks and no time: the same however fast it is asked */
    OST_HAPTIC_SHOWN = 64       /* takes forces, which nobody feels, for people to see */
};

/*
 * What a button does.  Each device's buttons have actions of their own, which
 * osteon devices lists and osteon sim --buttons changes.
 */
typedef enum ost_action {
    OST_ACTION_NONE,
    OST_ACTION_MOTOR,        /* the motor is on while it is held */
    OST_ACTION_SWITCH,       /* the motor goes on, and at the next press off */
    OST_ACTION_TOOL,         /* the next tool, where the hand is */
    OST_ACTION_CLUTCH,       /* while it is held the tool stays, and the device moves freely */
    OST_ACTION_HOME,         /* the tool goes to where it began, clear of the bone; nothing is cut on the way */
    OST_ACTION_COUNT
} ost_action;
OST_API const char *ost_action_name(ost_action action); /* "none", "motor", "motor-switch", "next-tool", "clutch", "home" */

enum { OST_BUTTONS_MAX = 8 };
typedef struct ost_button {
    const char *name; /* "stylus1" */
    ost_action action;
} ost_button;

typedef struct ost_haptic_info {
    const char *name;        /* "sim" */
    const char *description; /* a sentence */
    uint32_t caps;
    bool available;
    char reason[256];        /* when not available: why, and what to do about it */
    double max_force_n;      /* 0 without force */
    double max_stiffness_n_m;
    int button_count;        /* button i is bit i of ost_haptic_state.buttons */
    ost_button buttons[OST_BUTTONS_MAX];
} ost_haptic_info;

/*
 * Fills out with the actions of a device's buttons: its own, or what text says,
 * "stylus1=next-tool,2=none", a button by its name or by its number from 1.
 * text may be NULL.  OST_ERR_USAGE naming a button or an action that is unknown.
 */
OST_API ost_status ost_buttons_parse(const ost_haptic_info *info, const char *text, ost_action out[OST_BUTTONS_MAX], ost_error *err);

/* All devices that this library knows, in a fixed order. */
OST_API int ost_haptic_count(void);
OST_API ost_status ost_haptic_describe(int index, ost_haptic_info *out, ost_error *err);

typedef struct ost_haptic ost_haptic;
typedef struct ost_hand ost_hand;

/* What a device may need; everything is borrowed until ost_haptic_open returns. */
typedef struct ost_haptic_setup {
    const ost_path *path; /* script: where the tool goes; sim: where the hand goes */
    const char *session;  /* replay: a session's file */
    ost_hand *hand;       /* mouse: where a window puts it; borrowed until ost_haptic_close */
    ost_pose start;       /* null: where the tool stays; motion: where it begins; real devices: where it is when the handle is at its centre */
    ost_path_options gaps; /* motion: of its file */
} ost_haptic_setup;

/*
 * "name" or "name:key=value,key=value".
 *
 *   null              stays where it is
 *   script            a path, a row a tick
 *   replay            the ticks of a session
 *   sim               a device of 60 g with friction and encoders in a hand that follows a path:
 *                     grip=light|normal|firm (normal), seed=N (1), tremor=UM (0), friction=MN (260)
 *   motion:FILE       a tracked hand (docs/haptics.md), plain or gzip: scale=PERCENT (5), gap=MS, jump=MM (both found from its rows)
 *   mouse             the mouse of a window, by setup.hand
 *   openhaptics       Touch, Touch X, Phantom Omni: name=TEXT, scale=PERCENT (100)
 *   dhd               Force Dimension, Falcon: scale=PERCENT (100)
 *   spnav             SpaceMouse: speed=MM/S (20), turn=DEGREES/S (30), hold=0|1 (0)
 *   inverse3          Haply's Inverse3 and VerseGrip: id=TEXT (the first), port=N (10001), scale=PERCENT (100)
 *   udp               a device on another machine, by osteon bridge: key=FILE, port=N (4707), bind=ADDRESS (127.0.0.1), lost=MS (5000)
 *
 * OST_ERR_USAGE on an unknown name, key or value, or when the setup lacks what it needs.
 */
OST_API ost_status ost_haptic_open(const char *spec, const ost_haptic_setup *setup, ost_haptic **out, ost_error *err);
OST_API void ost_haptic_close(ost_haptic *device); /* NULL is allowed */
OST_API const char *ost_haptic_name(const ost_haptic *device);

/* What there is to say of an open device, as where it listens: a few words, or "". Returns text. */
enum { OST_HAPTIC_TEXT = 160 };
OST_API const char *ost_haptic_about(const ost_haptic *device, char text[OST_HAPTIC_TEXT]);
/*
 * What an open device reports of its own forces, and where that is from:
 * "HD_NOMINAL_MAX_FORCE", "an omega".  A limit is its share below the device's.
 */
#define OST_HAPTIC_LIMIT_SHARE 0.9
typedef struct ost_haptic_limits {
    double force_n;                 /* the most that it gives for a moment, as reported: may be no number */
    double continuous_n, torque_nm; /* what it gives for long, and its torque; 0: not reported */
    char from[48];
} ost_haptic_limits;
/* Returns false when the device reports nothing of them. */
OST_API bool ost_haptic_limits_get(const ost_haptic *device, ost_haptic_limits *out);
/* Returns true for a force of 0.1 to 100 N and a torque of 0 or 0.001 to 10 N m. */
OST_API bool ost_haptic_limits_usable(const ost_haptic_limits *limits);
/* What a device has counted since it was opened. Returns how many there are; from any thread. */
enum { OST_HAPTIC_COUNTS = 12 };
typedef struct ost_haptic_tally {
    const char *name; /* "wrong_key" */
    uint64_t value;
} ost_haptic_tally;
OST_API int ost_haptic_counts(const ost_haptic *device, ost_haptic_tally out[OST_HAPTIC_COUNTS]);

typedef enum ost_haptic_answer {
    OST_HAPTIC_FRESH, /* a new pose */
    OST_HAPTIC_STALE, /* none this time; the state is as it was */
    OST_HAPTIC_UNSEEN, /* it works and says that it does not see the hand; later it goes on from where it was */
    OST_HAPTIC_ENDED, /* there will be none any more, as planned */
    OST_HAPTIC_LOST   /* there will be none any more: unplugged, failed */
} ost_haptic_answer;

typedef struct ost_haptic_state {
    ost_pose pose;
    int32_t tool; /* -1: it does not say */
    uint32_t buttons;
    bool lifted;  /* the tool was lifted before this pose (path.h) */
    bool turned;  /* replay: the pose has the tool's turn already, by a motor of rpm (motor.h) */
    int32_t rpm;
} ost_haptic_state;

/* On the hand, in the bone's frame; the torque about the tool's origin. */
typedef struct ost_wrench {
    double force_n[3], torque_nm[3];
} ost_wrench;

/* For devices without a clock of their own, once a tick each. */
OST_API ost_haptic_answer ost_haptic_read(ost_haptic *device, ost_haptic_state *state);
OST_API void ost_haptic_write(ost_haptic *device, const ost_wrench *wrench);

/*
 * The hand of the device mouse: a window's thread puts it somewhere, and the
 * device's thread follows, smoothly and no faster than the operation allows.
 * Wait-free on both sides; put is for one thread.
 */
enum { OST_HAND_PEDAL = 1 }; /* the button of device mouse */
OST_API ost_status ost_hand_create(const ost_haptic_state *start, ost_hand **out, ost_error *err);
OST_API void ost_hand_free(ost_hand *hand); /* NULL is allowed */
/* With state->lifted the device is there at once, and says that it was lifted. */
OST_API void ost_hand_put(ost_hand *hand, const ost_haptic_state *state);

/* ------------------------------------------------------------- histograms */

/* Times in bins of a microsecond up to 4096 us, and what is beyond in milliseconds up to 4096. */
enum { OST_TIMES_BINS = 4096 };
typedef struct ost_times {
    uint64_t count, max_ns;
    uint64_t us[OST_TIMES_BINS], ms[OST_TIMES_BINS];
} ost_times;

OST_API void ost_times_add(ost_times *times, uint64_t ns);
/* The upper end of the bin in which share (0 to 1) of all are reached, in us, but never above the greatest; 0 when empty. */
OST_API double ost_times_share_us(const ost_times *times, double share);

/* ------------------------------------------------------------------ servo */

/*
 * The loop on a core of its own, everybody else on the others: a renderer that
 * may use all of two cores costs the loop deadlines, one that leaves it a core
 * does not.  The last core that the calling thread may use, or -1 when there
 * is but one or the system does not say.  To be asked before a thread leaves it.
 */
OST_API int ost_servo_core(void);
/* The calling thread, and those that it makes from then on, leave the core to the loop; false when that cannot be. */
OST_API bool ost_servo_core_leave(int core);

/* What the system allowed, for the record. */
typedef struct ost_realtime {
    char scheduling[120]; /* "SCHED_FIFO 80", or the next best, and why */
    char memory[120];     /* "locked", or why not */
    char core[120];       /* "core 1 alone", or why not */
} ost_realtime;

typedef struct ost_servo_sample {
    uint64_t number;      /* of the tick, from 0 */
    int64_t t_ns;         /* number times the period: what the world's clock says */
    ost_haptic_state state;
    bool declared;        /* no new pose: the last one */
    bool unseen;          /* the device says that it does not see the hand: the state is the last one, or none (a zero quaternion) */
    uint32_t wake_ns;     /* how late the tick began */
    uint32_t missed;      /* ticks that were skipped before this one */
} ost_servo_sample;

/* False ends the loop. wrench is zero before and goes to the device after. Nothing here may wait. */
typedef bool ost_servo_tick(void *user, const ost_servo_sample *sample, ost_wrench *wrench);
/* After the wrench was given: what the tick took in all, for whoever keeps a record. May be NULL. */
typedef void ost_servo_done(void *user, uint64_t number, uint32_t exec_ns);

/* Before a tick is due, when nothing of it is known yet. May take a while; must not wait. */
typedef void ost_servo_rehearse(void *user);

/* What the loop is at: the ticks, or a loop that they are compared with. */
typedef enum ost_servo_stage {
    OST_SERVO_TICKING,
    OST_SERVO_BUSY,       /* a loop that only spends time, as much as the ticks did */
    OST_SERVO_QUIET,      /* one that does nothing */
    OST_SERVO_RESTED      /* the busy one again, while whoever works beside the loop rests */
} ost_servo_stage;
/* When a stage begins, and before each turn of a loop for comparison: false ends that loop. Nothing here may wait. */
typedef bool ost_servo_beside(void *user, ost_servo_stage stage);

typedef struct ost_servo_options {
    int64_t period_ns;    /* 0: 1,000,000 */
    uint64_t ticks;       /* 0: until the device ends or tick returns false */
    uint64_t idle_ticks;  /* of a loop that does nothing, half of them before and half after; and as many of one that only spends time */
    uint64_t rest_ticks;  /* of OST_SERVO_RESTED; with any, the quiet loop is all after: what works beside it has by then seen the ticks */
    bool no_clock;        /* one tick after the other, as fast as they go: for devices that know no time */
    bool no_realtime;     /* ask the system for no priority and no locked memory */
    bool pinned;          /* the loop keeps to core; back to where it was afterwards */
    int core;
    /*
     * So long before each tick is due the loop is awake, rehearses, and then waits without sleep: the tick finds its core
     * awake and its memory near.  0 to half a period; 0, NULL, or a device with a clock of its own: none of it.
     */
    int64_t lead_ns;
    ost_servo_rehearse *rehearse;
    ost_servo_beside *beside; /* NULL: nobody asks */
    void *beside_user;
} ost_servo_options;

typedef enum ost_servo_end { OST_SERVO_TICKS, OST_SERVO_ASKED, OST_SERVO_DEVICE_ENDED, OST_SERVO_DEVICE_LOST, OST_SERVO_WATCHDOG } ost_servo_end;

/* A loop without a device, for comparison: what the machine alone misses. */
typedef struct ost_servo_control {
    uint64_t ticks, missed;
} ost_servo_control;

typedef struct ost_servo_report {
    ost_servo_end end;
    uint64_t ticks;
    uint64_t missed;           /* deadlines: ticks that ended after the next one was due, and those skipped for it */
    /*
     * Why: a tick's own work took more than half a period; else the loop was woken a period late or more, as one that does
     * nothing would have been; else its core was taken away.  Together they are missed.
     */
    uint64_t missed_by_work, missed_woken_late, missed_taken;
    int64_t lead_ns;           /* of the rehearsals; 0: there were none */
    uint64_t longest_miss;     /* the most ticks skipped at once */
    uint64_t stale;            /* ticks without a new pose */
    uint64_t unseen;           /* ticks in which the device did not see the hand */
    ost_servo_control idle;    /* a loop that does nothing, half before and half after */
    ost_servo_control busy;    /* afterwards, one that spends busy_ns of each period and nothing else: lead and median tick */
    int64_t busy_ns;
    ost_servo_control rested;  /* the busy one, with rest_ticks */
    int64_t stolen_ms;         /* by the hypervisor, of all cores together, while the loops ran; -1: unknown */
    ost_times wake, exec, completion, idle_wake, busy_wake, rested_wake;
    ost_times own;             /* of exec, what the tick did itself: without what other threads or a hypervisor took */
    ost_realtime realtime;
} ost_servo_report;

/*
 * Five ticks without a new pose end the loop: a device that is silent gets no force (facts: a watchdog of 5 ms).
 * One that says that it does not see the hand is not silent.
 */
enum { OST_SERVO_WATCHDOG_TICKS = 5 };

/*
 * Serves the device by this thread until an end.  Ticks are due at absolute
 * times; one that is late is done at once, those that went by are skipped and
 * counted, never caught up on.  report is filled in any case.
 */
OST_API ost_status ost_servo_run(ost_haptic *device, const ost_servo_options *options, ost_servo_tick *tick, ost_servo_done *done, void *user,
                                 ost_servo_report *report, ost_error *err);

#ifdef __cplusplus
}
#endif
#endif
