/* SPDX-License-Identifier: Apache-2.0 */
/*
 * osteon sim in pieces.
 *
 *   sim_args.c     what was asked for
 *   sim_load.c     bone, tools, world, device, force
 *   sim_force.c    which force, with which parameters
 *   sim_resume.c   the ticks of a session that is gone on with
 *   sim_film.c     pictures and a video of it
 *   sim_run.c      the loop
 *   sim_report.c   what is said afterwards, and what is written
 */
#ifndef OST_APP_SIM_H
#define OST_APP_SIM_H

#include "app/appearance.h"
#include "app/debrief.h"
#include "app/film.h"
#include "app/glenoid_plan.h"
#include "app/load.h"
#include "app/ream_path.h"
#include "app/session_record.h"
#include "app/start_check.h"

enum { SIM_ROOM = 65536 }; /* records that wait for the disk: 65 s */

typedef struct sim_args {
    const char *device, *bone, *out, *record, *classes_text, *session, *resume, *debrief, *force_file;
    option_list tools, paths;
    ct_options ct;
    tool_options how;
    glenoid_plan_options plan;
    option_decimal rate, seconds, idle;
    int64_t period_ns;
    uint64_t ticks, idle_ticks;
    ost_density_classes classes;
    int64_t force; /* of sim_force_names */
    const char *picture, *size, *max_gap;
    ost_path_options gaps; /* from max_gap */
    int renderer; /* a sim_renderer */
    int view, style, width, height;
    int64_t fps, rehearse_us, rpm;
    const char *buttons_text;
    ost_action buttons[OST_BUTTONS_MAX]; /* of the device */
    bool motor_waits;     /* one of them, or a key, switches the motor on */
    film_options video;
    bool hud, timings;
    bool renderer_given, paths_given, rehearse_given;
    appearance_options look;
    bool contact;         /* what went just now is shown, without a window too */
    ost_force_params force_params;
    ost_safety_params safety;
    bool max_force_given, max_torque_given; /* by the file of --force-params */
    const char *max_force_from; /* "force-params", "device" or "default" */
    ost_haptic_limits limits;   /* with "device" */
    bool force_given, headless, no_clock, no_realtime, no_pin, print_force, strict, compress, sweep_off, bone_given, tools_given;
} sim_args;

/* By args.force: "off", "energy", "instant". */
extern const char *const sim_force_names[];

typedef struct simulation {
    ost_backend *backend;
    ost_bone *bone;
    ost_import_result imported;
    ost_tool *tools[OPTION_LIST_MAX];
    ost_path path;
    ream_gaps gaps;       /* of path */
    ost_world *world;
    ost_recorder *recorder;
    ost_haptic *device;
    ost_force *force;   /* NULL: none is given */
    ost_operation *operation;
    ost_servo_report *loop;
    ost_operation_report done;
    ost_metrics_plan plan;
    bool planned;         /* it is known */
    start_checked site;   /* with nothing known when a session is gone on with */
    debrief debrief;      /* empty without --debrief */
    ost_volume uncut;     /* owned until its show has it: the bone before anything was cut */
    ost_session *resumed; /* NULL: it begins */
    ost_tick last;        /* of it */
    ost_motor motor;      /* after it */
    ost_pose home;        /* where the tool begins, clear of the bone, unless a path says where */
    uint64_t before;      /* its ticks */
    struct sim_show *show; /* NULL: nobody looks on */
    struct sim_window *window; /* NULL: --headless */
    film *film;           /* NULL: no picture is to be written meanwhile */
    int core;             /* that the loop has to itself; -1: none */
} simulation;

void simulation_free(simulation *s);

bool sim_device_is(const sim_args *args, const char *name);
/* Returns true for a device that goes where a path goes; all others have a hand. */
bool sim_follows_path(const sim_args *args);
/* Finds what the library says of the device; false when there is none of that name. */
bool sim_device_info(const sim_args *args, ost_haptic_info *out);
/* All that can be said before anything is read. */
ost_status sim_args_check(app_state *app, sim_args *args, ost_error *err);

ost_status sim_load(const app_state *app, const sim_args *args, simulation *s, ost_error *err);
/* The defaults, and what --force-params says; the limits of the open device, in sim_force_make, go before defaults. */
ost_status sim_force_params(const app_state *app, sim_args *args, ost_error *err);
void sim_force_print(const app_state *app, const sim_args *args);
enum { SIM_FORCE_KEYS = 32, SIM_LIMIT_TEXT = 160 };
/* Says where the limit of the force is from: "default", or "device: a sigma.7 gives 12 N, 0.2 N m". */
void sim_force_limit_text(const sim_args *args, char text[SIM_LIMIT_TEXT]);
/* A device that renders forces gets one unless --force off; one that does not has none to be asked for. */
ost_status sim_force_make(const app_state *app, sim_args *args, simulation *s, ost_error *err);
/* A core for the loop: from here on this thread, and those it makes, keep off it. First of all, since OpenGL's drivers and
   devices make threads as well. */
void sim_pin(const sim_args *args, simulation *s);
typedef struct sim_force_texts {
    char key[SIM_FORCE_KEYS][40], value[SIM_FORCE_KEYS][OST_FORCE_VALUE], from[SIM_LIMIT_TEXT];
} sim_force_texts;
/* The parameters, and where the limit is from, as keys of a session, up to one that is NULL: at most SIM_FORCE_KEYS + 2. */
void sim_force_session(const sim_args *args, sim_force_texts *texts, session_key *keys);
/* Looks at the site before the first tick (start_check.h). */
ost_status sim_check_start(const app_state *app, const sim_args *args, simulation *s, ost_error *err);
/* With --record. */
ost_status sim_record_begin(const sim_args *args, simulation *s, ost_error *err);

/* What the session says of bone, tools and world goes before what is usual; files may have been moved. */
ost_status sim_resume_open(const app_state *app, sim_args *args, simulation *s, ost_error *err);
/* Its ticks, each as recorded, into the world and into the new recording. */
ost_status sim_resume_run(const sim_args *args, simulation *s, ost_error *err);

/* Who writes pictures and a video: in a window, or with a video. */
ost_status sim_film_begin(const sim_args *args, simulation *s, ost_error *err);
/* The video is whole; and what is said of it. */
ost_status sim_film_end(const app_state *app, const sim_args *args, simulation *s, ost_error *err);

/* Whether the frames are compared too, with what the machine makes of them. */
bool sim_rests(const sim_args *args);
ost_status sim_run(const app_state *app, const sim_args *args, simulation *s, ost_error *err);

void sim_report_loop(const app_state *app, const sim_args *args, const simulation *s);
/* The bone and the session, to the disk; and what it has come to. */
ost_status sim_finish(const app_state *app, const sim_args *args, simulation *s, ost_error *err);
/* Fails with OST_ERR_UNAVAILABLE, and lets the result be printed, if the loop ended because the device was lost. */
ost_status sim_device_end(app_state *app, const sim_args *args, const simulation *s, ost_error *err);

#endif
