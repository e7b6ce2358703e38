/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The parts of `osteon sim`.
 *
 *   cmd_sim.c  the options
 *   args.c     checks of the options
 *   operate.c  the parts below, in order
 *   load.c     bone, tools, world, device, force
 *   device.c   properties of the device that --device names
 *   force.c    the force model and its parameters
 *   resume.c   the ticks of a session that --resume continues
 *   film.c     pictures and a video of the operation
 *   run.c      the servo loop
 *   report.c   the report after the operation, and the output files
 */
#ifndef OST_APP_SIM_SIM_H
#define OST_APP_SIM_SIM_H

#include "app/picture/appearance.h"
#include "app/debrief/debrief.h"
#include "app/film/film.h"
#include "app/input/glenoid_plan.h"
#include "app/input/load.h"
#include "app/input/ream_path.h"
#include "app/session/record.h"
#include "app/input/start_check.h"

enum { SIM_RECORDER_CAPACITY = 65536 }; /* capacity of the recorder's queue in records; 65 s of ticks */

typedef struct sim_args {
    const char *device, *bone, *out, *record, *classes_text, *session, *resume, *debrief, *force_file;
    option_list tools, paths;
    ct_options ct;
    tool_options how;
    glenoid_plan_options plan;
    option_decimal rate, seconds;
    int64_t period_ns;
    uint64_t ticks;
    ost_density_classes classes;
    int64_t force; /* force law, an index in sim_force_names */
    const char *picture, *size, *max_gap;
    ost_path_options gaps; /* options for gaps, parsed from max_gap */
    int renderer; /* a sim_renderer */
    int view, style, width, height;
    int64_t fps, rehearse_us, rpm;
    const char *buttons_text;
    ost_action buttons[OST_BUTTONS_MAX]; /* actions assigned to the device's buttons */
    bool motor_waits;     /* true if the motor is off until the user switches it on */
    film_options video;
    bool hud, timings, stats;
    bool renderer_given, paths_given, rehearse_given;
    appearance_options look;
    bool contact;         /* true to highlight voxels that were just removed, even without a window */
    ost_force_params force_params;
    ost_safety_params safety;
    /* true if the file of --force-params sets the limit of the force or of the torque */
    bool max_force_given, max_torque_given;
    const char *max_force_from; /* source of the limit: "force-params", "device" or "default" */
    ost_haptic_limits limits;   /* valid if max_force_from is "device" */
    bool headset; /* true to use a headset; headless is then true as well */
    bool force_given, headless, no_clock, no_realtime, no_pin, print_force, strict, compress, sweep_off, bone_given,
        tools_given;
} sim_args;

/* Names of the values of args.force: "off", "energy", "instant". */
extern const char *const sim_force_names[];

typedef struct simulation {
    ost_backend *backend;
    ost_bone *bone;
    ost_import_result imported;
    ost_tool *tools[OPTION_LIST_MAX];
    ost_path path;
    ream_gaps gaps;
    ost_world *world;
    ost_recorder *recorder;
    ost_haptic *device;
    ost_force *force;   /* the force model, or NULL */
    ost_operation *operation;
    ost_servo_report *loop;
    ost_operation_report done;
    ost_metrics_plan plan;
    bool planned;         /* true if `plan` is valid */
    start_checked site;   /* result of sim_check_start; site.known is false if a session is resumed */
    debrief debrief;      /* the debrief; empty unless --debrief is given */
    ost_volume uncut;     /* the bone before the operation; sim_show takes ownership */
    ost_session *resumed; /* the session to continue (--resume), or NULL */
    ost_tick last;        /* last tick of the resumed session */
    ost_motor motor;      /* state of the motor at the end of the resumed session */
    ost_pose home; /* initial pose of the tool: first pose of the path or, without a path, a pose clear of the bone */
    uint64_t before;      /* number of ticks in the resumed session */
    struct sim_show *show; /* the renderer and its frames; NULL if nothing is drawn */
    struct sim_window *window; /* the window; NULL with --headless or --headset */
    bool window_can_be_drawn; /* true if the window has an OpenGL context in which frames can be drawn */
    struct sim_headset *headset; /* the headset; NULL unless --headset is given */
    film *film;           /* NULL if no picture or video is written during the operation */
    int core;             /* processor core reserved for the servo loop; -1 if there is none */
} simulation;

void simulation_free(simulation *s);

bool sim_device_is(const sim_args *args, const char *name);
/* Returns true if the device follows a path; false if an operator moves it. */
bool sim_follows_path(const sim_args *args);
/* Finds the library's description of the device. Returns false if there is no device with this name. */
bool sim_device_info(const sim_args *args, ost_haptic_info *out);
/* Checks the options as far as possible before any file is read. */
ost_status sim_args_check(app_state *app, sim_args *args, ost_error *err);

ost_status sim_load(const app_state *app, const sim_args *args, simulation *s, ost_error *err);
/*
 * Sets the default parameters and the parameters from --force-params. Later, sim_force_make replaces defaults with the
 * limits of the open device.
 */
ost_status sim_force_params(const app_state *app, sim_args *args, ost_error *err);
void sim_force_print(const app_state *app, const sim_args *args);
enum { SIM_FORCE_KEYS = 32, SIM_LIMIT_TEXT = 160 };
/* Describes the source of the force limit: "default" or, for example, "device: a sigma.7 gives 12 N, 0.2 N m". */
void sim_force_limit_text(const sim_args *args, char text[SIM_LIMIT_TEXT]);
/*
 * Makes the force model. If --force is off, there is no model. If the device cannot render forces, --force is off by
 * default, and another value is an error.
 */
ost_status sim_force_make(const app_state *app, sim_args *args, simulation *s, ost_error *err);
/*
 * Reserves a core for the servo loop: the calling thread and all threads that it creates no longer run on this core.
 * Must be called first, because OpenGL drivers and devices also create threads.
 */
void sim_pin(const sim_args *args, simulation *s);
typedef struct sim_force_texts {
    char key[SIM_FORCE_KEYS][40], value[SIM_FORCE_KEYS][OST_FORCE_VALUE], from[SIM_LIMIT_TEXT];
} sim_force_texts;
/*
 * Writes the parameters and the source of the limit as keys of a session. `keys` needs SIM_FORCE_KEYS + 2 elements;
 * the name of the last key is NULL.
 */
void sim_force_session(const sim_args *args, sim_force_texts *texts, session_key *keys);
/* Checks before the first tick where the tools start (start_check.h). */
ost_status sim_check_start(const app_state *app, const sim_args *args, simulation *s, ost_error *err);
/* Begins the recording if --record is given. */
ost_status sim_record_begin(const sim_args *args, simulation *s, ost_error *err);

/*
 * Opens the session that --resume names. Its bone, tools and world replace the defaults. Other options can specify new
 * names for files that were moved.
 */
ost_status sim_resume_open(const app_state *app, sim_args *args, simulation *s, ost_error *err);
/*
 * Replays the session's ticks into the world and into the new recording. Returns an error if the result of a tick
 * differs from the recorded result.
 */
ost_status sim_resume_run(const sim_args *args, simulation *s, ost_error *err);

/* Begins the film if there is a window or a video is requested. */
ost_status sim_film_begin(const sim_args *args, simulation *s, ost_error *err);
/* Completes the video and prints its report. */
ost_status sim_film_end(const app_state *app, const sim_args *args, simulation *s, ost_error *err);

/* Runs an operation from the opening of its devices to the end of its recording, and reports it. */
ost_status sim_operate(app_state *app, sim_args *args, ost_error *err);

ost_status sim_run(const app_state *app, const sim_args *args, simulation *s, ost_error *err);

void sim_report_loop(const app_state *app, const sim_args *args, const simulation *s);
/* Writes the bone, completes the session and reports the result. */
ost_status sim_finish(const app_state *app, const sim_args *args, simulation *s, ost_error *err);
/* If the device was lost or delivered no sample for too long, sets app->answered and returns OST_ERR_UNAVAILABLE. */
ost_status sim_device_end(app_state *app, const sim_args *args, const simulation *s, ost_error *err);

#endif
