/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Implements `osteon sim`: a device moves the tool, a thousand times per second.
 *
 *   bone, tools --> world --> operation <--ticks-- ost_servo_run <--poses-- device
 *                                 '--> session
 *
 * With --resume, the ticks of a session are run first, and the operation continues after the last of them. A new
 * recording then contains the ticks of the session and the new ticks.
 *
 * By default, the command opens a window. Unless another device is given, the mouse in this window is the device.
 * With --headless, there is no window.
 */
#include "app/input/removal_options.h"
#include "app/sim/sim.h"

ost_status cmd_sim(app_state *app, int argc, char **argv, ost_error *err)
{
    sim_args args = {.bone = "builtin:scapula",
                     .fps = 60,
                     .video.fps = 30,
                     .ct = CT_OPTIONS_DEFAULT,
                     .how = TOOL_OPTIONS_DEFAULT,
                     .rpm = OST_RPM_REAMER};
    target_options *t = &args.plan.target;
    const option options[] = {
        {.name = "bone",
         .kind = OPTION_TEXT,
         .out = &args.bone,
         .given = &args.bone_given,
         .value = "BONE",
         .help = "a bone, a CT or a built-in bone (default: builtin:scapula)"},
        {.name = "tool",
         .kind = OPTION_LIST,
         .out = &args.tools,
         .value = "TOOL",
         .help = "a tool; may repeat, in the order of the action next-tool (default: builtin:peg, builtin:reamer "
                 "and builtin:burr; builtin:reamer alone if no button of the device switches the motor)"},
        {.name = "path",
         .kind = OPTION_LIST,
         .out = &args.paths,
         .value = "PATH",
         .help = "path of the tool or of the simulated hand, or where the mouse starts, as for osteon ream; with "
                 "--device replay a session (default: builtin:glenoid-press, for the duration of --seconds, with "
                 "--device sim and force feedback, else builtin:glenoid-slow)"},
        {.name = "device",
         .kind = OPTION_TEXT,
         .out = &args.device,
         .value = "NAME",
         .help = "device that moves the tool: mouse (default in a window), openxr (the controller of a "
                 "headset, default with --headset), sim (default otherwise), null, script, replay, motion, "
                 "openhaptics, dhd, spnav, inverse3 or udp, with options as in "
                 "sim:grip=light,seed=2,tremor=200 (micrometres) or motion:hand.csv.gz,scale=5 (per cent)"},
        {.name = "seconds",
         .kind = OPTION_DECIMAL,
         .out = &args.seconds,
         .value = "N",
         .help = "duration (default: until the window is closed or the headset ends; 10 without either)"},
        {.name = "headless", .kind = OPTION_FLAG, .out = &args.headless, .help = "open no window"},
        {.name = "headset",
         .kind = OPTION_FLAG,
         .out = &args.headset,
         .help = "show the operation in a headset, through OpenXR, and open no window; OpenGL draws. What --view looks "
                 "at is 0.5 m in front of the eyes' first position, in its true size and as --view shows it; --size "
                 "sets the pixels of an eye (default: as the headset recommends)"},
        {.name = "out",
         .kind = OPTION_OUTPUT,
         .out = &args.out,
         .value = "FILE",
         .help = "the remaining bone: .nrrd, .nii, .nii.gz or .txt"},
        {.name = "record",
         .kind = OPTION_OUTPUT,
         .out = &args.record,
         .value = "SESSION",
         .help = "record every tick; the name ends in .session"},
        {.name = "debrief",
         .kind = OPTION_OUTPUT,
         .out = &args.debrief,
         .value = "FILE.html",
         .help = "with --record: page that compares the result with the plan, as by osteon replay"},
        {.name = "resume",
         .kind = OPTION_TEXT,
         .out = &args.resume,
         .value = "SESSION",
         .help = "continue the operation of a session with its bone, tools and options"},
        HEADING("glenoid and plan"),
        TARGET_OPTIONS(*t, "centre of the glenoid's face, for the built-in paths (default: as in the bone's file)"),
        GLENOID_PLAN_OPTIONS(args.plan),
        HEADING("motor, buttons and removal"),
        RPM_OPTION(args.rpm, NULL),
        {.name = "buttons",
         .kind = OPTION_TEXT,
         .out = &args.buttons_text,
         .value = "BUTTON=ACTION,...",
         .help = "actions of the device's buttons, as in stylus1=motor,stylus2=next-tool: motor (on while "
                 "pressed), motor-switch, next-tool, clutch, home or none; osteon devices lists the buttons and "
                 "their defaults. A motor that a button switches is off at first, any other is on"},
        RATE_OPTION(args.rate),
        MAX_GAP_OPTION(args.max_gap),
        CLASSES_OPTION(args.classes_text),
        STRICT_OPTION(args.strict),
        HEADING("force feedback"),
        {.name = "force",
         .kind = OPTION_CHOICE,
         .out = &args.force,
         .given = &args.force_given,
         .value = "off|energy|instant",
         .help = "force feedback: off; energy: bone yields gradually as it is cut; instant: it yields at once "
                 "(default: energy if the device renders forces)"},
        {.name = "force-params",
         .kind = OPTION_TEXT,
         .out = &args.force_file,
         .value = "FILE",
         .help = "parameters of the force and of its safety layer, lines of key: number (docs/reference/force.md); the "
                 "default limit of the force is the device's own, or 3 N"},
        {.name = "print-force-params",
         .kind = OPTION_FLAG,
         .out = &args.print_force,
         .help = "print these parameters with their units and sources, and exit"},
        HEADING("window and pictures"),
        {.name = "renderer",
         .kind = OPTION_CHOICE,
         .out = &args.renderer,
         .given = &args.renderer_given,
         .value = "none|auto|points|gl|mesh|thesis",
         .help = "auto: gl if a graphics card executes OpenGL, otherwise points; points: the bone's surface, by the "
                 "processor; gl: the same by OpenGL; mesh: a triangle mesh of the visible faces, by OpenGL; thesis: "
                 "every voxel a point, by OpenGL (default: auto in a window, else none)"},
        {.name = "view",
         .kind = OPTION_CHOICE,
         .out = &args.view,
         .value = OST_VIEW_NAMES,
         .help = "direction of view (default: operator)"},
        {.name = "size",
         .kind = OPTION_TEXT,
         .out = &args.size,
         .value = "WxH",
         .help = "size of the window or of the frames in pixels (default: 1280x720)"},
        {.name = "fps",
         .kind = OPTION_INTEGER,
         .out = &args.fps,
         .min = 0,
         .max = 1000,
         .value = "N",
         .help = "maximum of frames per second (default: 60; 0: no maximum)"},
        {.name = "picture",
         .kind = OPTION_OUTPUT,
         .out = &args.picture,
         .value = "FILE.png",
         .help = "write the last frame, with --renderer points, gl, mesh or thesis"},
        {.name = "hud",
         .kind = OPTION_FLAG,
         .out = &args.hud,
         .help = "draw the window's HUD over frames without a window"},
        {.name = "timings",
         .kind = OPTION_FLAG,
         .out = &args.timings,
         .help = "show the times of ticks and frames in the HUD (key L)"},
        HEADING("appearance"),
        {.name = "style",
         .kind = OPTION_CHOICE,
         .out = &args.style,
         .value = "smooth|faces",
         .help = "shade by the surface's normals and smooth the edges (default), or draw flat faces as in the thesis"},
        {.name = "contact",
         .kind = OPTION_FLAG,
         .out = &args.contact,
         .help = "highlight bone that was just removed (always on in a window)"},
        APPEARANCE_OPTIONS(args.look),
        HEADING("video"),
        VIDEO_OPTIONS(args.video),
        HEADING("real time"),
        {.name = "stats",
         .kind = OPTION_FLAG,
         .out = &args.stats,
         .help = "print the times of ticks and frames, the forces and the device's counters"},
        {.name = "no-clock",
         .kind = OPTION_FLAG,
         .out = &args.no_clock,
         .help = "run the ticks as fast as possible instead of in real time; the result is the same"},
        {.name = "no-realtime",
         .kind = OPTION_FLAG,
         .out = &args.no_realtime,
         .help = "request neither real-time priority nor locked memory"},
        {.name = "no-pin",
         .kind = OPTION_FLAG,
         .out = &args.no_pin,
         .help = "reserve no core for the servo loop (default: reserve one of two or more)"},
        {.name = "rehearse",
         .kind = OPTION_INTEGER,
         .out = &args.rehearse_us,
         .given = &args.rehearse_given,
         .value = "US",
         .min = 0,
         .max = 500,
         .help = "load the data that a tick needs this long before it (default: 250 if a core is reserved and the "
                 "backend is cpu; 0: never)"},
        HEADING("reading a CT"),
        CT_OPTIONS(args.ct),
        HEADING("reading a mesh"),
        TOOL_OPTIONS(args.how),
        HEADING("writing"),
        COMPRESS_OPTION(args.compress),
        {.name = NULL}};
    const usage_text usage = {
        .synopsis = "[--headless|--headset] [--device NAME] [--seconds N] [options]",
        .about = "Simulates an operation: a device moves the tool, and each tick of 1 ms removes\n"
                 "bone. Prints the missed deadlines and the bone removed; --stats adds all times.",
        .options = options,
        .notes = "Bones and tools are read as by osteon ream. The servo loop requests SCHED_FIFO\n"
                 "and locked memory and prints what it obtained. The backend uses one thread\n"
                 "unless --threads is given.\n"
                 "Exit status 3 if the device is lost: outputs and session are complete up to that\n"
                 "tick.",
        .example = "  osteon sim\n"
                   "  osteon sim --headless --device sim --seconds 60 --record today.session \\\n"
                   "    --debrief today.html\n"
                   "  osteon replay today.session --verify --backend ref\n"
                   "  osteon sim --headless --resume today.session --record tomorrow.session",
    };
    ost_status status;
    if (!options_parse(app, &usage, argc, argv, &status, err) || (status = sim_args_check(app, &args, err)) != OST_OK)
        return status;
    if (args.print_force) {
        sim_force_print(app, &args);
        return OST_OK;
    }
    return sim_operate(app, &args, err);
}
