/* SPDX-License-Identifier: Apache-2.0 */
/*
 * osteon sim: a device moves the tool, a thousand times a second.
 *
 *   bone, tools --> world --> operation <--ticks-- ost_servo_run <--poses-- device
 *                                 '--> session
 *
 * With --resume the ticks of a session run first and the operation continues from there; a new
 * recording holds both.
 *
 * By default it opens a window, whose mouse is the device if no other is given; --headless runs
 * without one.
 */
#include "app/common/progress.h"
#include "app/common/print.h"
#include "app/sim/appearance.h"
#include "app/sim/window.h"

ost_status cmd_sim(app_state *app, int argc, char **argv, ost_error *err)
{
    sim_args args = {.bone = "builtin:scapula", .fps = 60, .video.fps = 30, .ct = CT_OPTIONS_DEFAULT, .how = TOOL_OPTIONS_DEFAULT, .rpm = OST_RPM_REAMER};
    target_options *t = &args.plan.target;
    const option options[] = {
        {.name = "device", .kind = OPTION_TEXT, .out = &args.device, .value = "NAME",
         .help = "mouse (default in a window), sim (default without one), null,\nscript, replay, motion, openhaptics, dhd, spnav, inverse3\nor udp, with options as in\nsim:grip=light,seed=2,tremor=200 (micrometres) or\nmotion:hand.csv.gz,scale=5 (per cent)"},
        {.name = "headless", .kind = OPTION_FLAG, .out = &args.headless, .help = "without a window"},
        {.name = "renderer", .kind = OPTION_CHOICE, .out = &args.renderer, .given = &args.renderer_given, .value = "none|null|points|gl|thesis",
         .help = "who draws meanwhile: points, the bone's surface by the processor; gl,\nthe same by OpenGL; thesis, OpenGL as the thesis uses it, every\nvoxel a point; null, follows the bone and draws nothing\n(default: points in a window, else none)"},
        {.name = "view", .kind = OPTION_CHOICE, .out = &args.view, .value = OST_VIEW_NAMES,
         .help = "where it looks from (default: operator)"},
        {.name = "size", .kind = OPTION_TEXT, .out = &args.size, .value = "WxH", .help = "of the window or the frames, in pixels (default: 1280x720)"},
        {.name = "fps", .kind = OPTION_INTEGER, .out = &args.fps, .min = 0, .max = 1000, .value = "N",
         .help = "frames a second at most (default: 60; 0: as many as there can be)"},
        {.name = "style", .kind = OPTION_CHOICE, .out = &args.style, .value = "smooth|faces", .help = "lit by the surface's normals (default), or the thesis' flat faces"},
        {.name = "picture", .kind = OPTION_TEXT, .out = &args.picture, .value = "FILE.png", .help = "the last frame, with --renderer points, gl or thesis"},
        {.name = "timings", .kind = OPTION_FLAG, .out = &args.timings, .help = "show in the HUD how punctual the loop and the frames are (key L)"},
        {.name = "hud", .kind = OPTION_FLAG, .out = &args.hud, .help = "write over frames without a window what a window has over them"},
        VIDEO_OPTIONS(args.video),
        APPEARANCE_OPTIONS(args.look),
        {.name = "contact", .kind = OPTION_FLAG, .out = &args.contact, .help = "show where bone went just now (in a window it is shown)"},
        {.name = "seconds", .kind = OPTION_DECIMAL, .out = &args.seconds, .value = "N", .help = "how long (default: until the window is closed; 10 without one)"},
        {.name = "resume", .kind = OPTION_TEXT, .out = &args.resume, .value = "SESSION",
         .help = "go on with the operation of a session: its bone, tools, options"},
        {.name = "bone", .kind = OPTION_TEXT, .out = &args.bone, .given = &args.bone_given, .value = "BONE", .help = "a bone, a CT, or a built-in one (default: builtin:scapula)"},
        {.name = "tool", .kind = OPTION_LIST, .out = &args.tools, .value = "TOOL", .help = "a tool; may repeat, in the order of next-tool (default: builtin:peg,\nbuiltin:reamer and builtin:burr; builtin:reamer for a device whose\nbuttons switch no motor)"},
        {.name = "rpm", .kind = OPTION_INTEGER, .out = &args.rpm, .min = 0, .max = OST_RPM_MAX, .value = "N",
         .help = "turns a minute of the tool's motor, clockwise from behind; 0: off, and\nnothing is removed (default: 200)"},
        {.name = "buttons", .kind = OPTION_TEXT, .out = &args.buttons_text, .value = "BUTTON=ACTION,...",
         .help = "what the device's buttons do, as in stylus1=motor,stylus2=next-tool:\nmotor (on while held), motor-switch, next-tool, clutch, home, none;\nosteon devices lists the buttons and what they do by default. A motor\nthat a button switches is off until then, any other on from the start"},
        {.name = "path", .kind = OPTION_LIST, .out = &args.paths, .value = "PATH",
         .help = "where the tool or the simulated hand goes, or the mouse's begins:\nas for osteon ream\n(default: builtin:glenoid-press with --device sim and a force,\nfor as long as --seconds says, else builtin:glenoid-slow);\nof --device replay a session"},
        {.name = "out", .kind = OPTION_TEXT, .out = &args.out, .value = "FILE", .help = "the bone afterwards: .nrrd, or .nii, .nii.gz, .txt"},
        {.name = "record", .kind = OPTION_TEXT, .out = &args.record, .value = "SESSION", .help = "write down every tick; the name ends in .session"},
        {.name = "at", .kind = OPTION_POINT, .out = &t->at, .given = &t->at_given, .value = "X,Y,Z",
         .help = "centre of the glenoid's face, for the built-in paths\n(default: what the bone's file says)"},
        {.name = "axis", .kind = OPTION_VECTOR, .out = t->axis, .given = &t->axis_given, .value = "X,Y,Z",
         .help = "direction into the bone there (default: the file's)"},
        {.name = "side", .kind = OPTION_CHOICE, .out = &t->side, .given = &t->side_given, .value = "left|right",
         .help = "of the body (default: the file's, else the axis determines it)"},
        {.name = "debrief", .kind = OPTION_TEXT, .out = &args.debrief, .value = "FILE.html",
         .help = "with --record: what it has come to, against the plan; a page with\npictures, as of osteon replay"},
        GLENOID_PLAN_OPTIONS(args.plan),
        {.name = "force", .kind = OPTION_CHOICE, .out = &args.force, .given = &args.force_given, .value = "off|energy|instant",
         .help = "what the hand feels: energy, bone gives way as it is cut;\ninstant, it is gone at once (default: energy if the device\nrenders forces)"},
        {.name = "force-params", .kind = OPTION_TEXT, .out = &args.force_file, .value = "FILE",
         .help = "parameters of the force and of what stands before the hand:\nlines of key: number (docs/force.md); the limit of the force is else\nthe device's own, or 3 N"},
        {.name = "print-force-params", .kind = OPTION_FLAG, .out = &args.print_force,
         .help = "print those parameters with their units and sources, and end"},
        {.name = "rate", .kind = OPTION_DECIMAL, .out = &args.rate, .value = "HZ", .help = "remove so many times a second (default: every tick)"},
        MAX_GAP_OPTION(args.max_gap),
        {.name = "classes", .kind = OPTION_TEXT, .out = &args.classes_text, .value = "NAME:HU,...", .help = "density classes to count by, each from its HU up"},
        STRICT_OPTION(args.strict),
        {.name = "stats", .kind = OPTION_FLAG, .out = &args.stats, .help = "print the times of ticks and frames, forces and the device's counters"},
        {.name = "no-clock", .kind = OPTION_FLAG, .out = &args.no_clock, .help = "one tick after the other, as fast as they go: the same operation"},
        {.name = "no-realtime", .kind = OPTION_FLAG, .out = &args.no_realtime, .help = "ask the system for no priority and no locked memory"},
        {.name = "no-pin", .kind = OPTION_FLAG, .out = &args.no_pin, .help = "let the loop share its core; of two or more it has one to itself else"},
        {.name = "rehearse", .kind = OPTION_INTEGER, .out = &args.rehearse_us, .given = &args.rehearse_given, .value = "US", .min = 0, .max = 500,
         .help = "so long before each tick look at what it will need\n(default: 250 on a core of its own with backend cpu; 0: never)"},
        TOOL_OPTIONS(args.how),
        CT_OPTIONS(args.ct),
        {.name = "compress", .kind = OPTION_FLAG, .out = &args.compress, .help = "gzip a .nrrd"},
        {.name = NULL}};
    const usage_text usage = {
        .synopsis = "[--headless] [--device NAME] [--seconds N] [options]",
        .about = "The simulator: a device moves the tool a thousand times a second, and each tick removes\n"
                 "bone. It reports the deadlines missed, the bone removed, and with --stats all times.",
        .options = options,
        .notes = "Tool and bone as for osteon ream. The loop asks for SCHED_FIFO and locked memory and says\n"
                 "what it got; of two or more cores it has one to itself. One thread works unless --threads\n"
                 "says otherwise. Status 3 when the device is lost: outputs and session are complete up\n"
                 "to then.",
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
    simulation s = {0};
    progress_begin(app);
    sim_pin(&args, &s);
    if (!args.headless)
        status = sim_window_open(app, &args, &s, err);
    if (status == OST_OK && args.resume)
        status = sim_resume_open(app, &args, &s, err);
    if (status == OST_OK)
        status = sim_load(app, &args, &s, err);
    if (status == OST_OK)
        status = sim_force_make(app, &args, &s, err);
    if (status == OST_OK)
        status = sim_check_start(app, &args, &s, err);
    if (status == OST_OK)
        status = sim_record_begin(&args, &s, err);
    if (status == OST_OK)
        status = sim_appearance_store_uncut(&args, &s, err);
    if (status == OST_OK && s.resumed)
        status = sim_resume_run(&args, &s, err);
    if (status == OST_OK)
        status = sim_show_make(app, &args, &s, err);
    if (status == OST_OK)
        status = sim_film_begin(&args, &s, err);
    if (status == OST_OK)
        status = sim_run(app, &args, &s, err);
    if (status == OST_OK) {
        sim_report_loop(app, &args, &s);
        if (s.show)
            sim_show_report(app, s.show);
        status = sim_finish(app, &args, &s, err);
    }
    /* The outputs are saved; failures in other parts are reported now. */
    if (status == OST_OK)
        status = sim_film_end(app, &args, &s, err);
    if (status == OST_OK)
        status = sim_window_end(&s, err);
    if (status == OST_OK)
        status = sim_device_end(app, &args, &s, err);
    simulation_free(&s);
    return status;
}
