/* SPDX-License-Identifier: Apache-2.0 */
#include "app/film/frame_size.h"
#include "app/sim/show.h"

#include <string.h>

#include "app/common/result.h"
#include "app/common/print.h"

const char *const sim_renderer_names[] = {"none", "auto", "points", "gl", "mesh", "thesis"};

enum { PRESS_TICKS_MAX = 600000 }; /* after ten minutes, the simulated operator keeps still */

/*
 * Checks the options for the motor and the buttons. If a button can switch the motor on, the motor is initially off.
 * Otherwise, the motor is on from the first tick.
 */
static ost_status check_motor(const app_state *app, sim_args *args, ost_error *err)
{
    ost_haptic_info info;
    if (args->period_ns > OST_MOTOR_TURN / 4 / (args->rpm ? args->rpm : 1) && args->rpm && !args->sweep_off)
        return usage_error(app, err,
                           "--rate %s: at %lld rpm, the motor turns by more than 90 degrees between two "
                           "removals; at least %.3g Hz",
                           args->rate.text, (long long)args->rpm, (double)args->rpm / 15);
    if (!sim_device_info(args, &info))
        return OST_OK; /* the name of the device is checked when the device is opened */
    ost_status status = ost_buttons_parse(&info, args->buttons_text, args->buttons, err);
    for (int i = 0; i < OST_BUTTONS_MAX; i++)
        args->motor_waits = args->motor_waits || args->buttons[i] == OST_ACTION_MOTOR ||
                            args->buttons[i] == OST_ACTION_SWITCH;
    if (status == OST_ERR_USAGE)
        ost_fail_context(err, "--buttons");
    return status;
}

/* Converts seconds to ticks of one millisecond. */
static ost_status ticks_of(const app_state *app, const char *name, const option_decimal *seconds, uint64_t *ticks,
                           ost_error *err)
{
    int64_t ms;
    if (!ost_decimal_scale(&seconds->value, 1000, &ms, NULL) || ms < 0 || ms > INT64_C(86400000))
        return usage_error(app, err, "--%s %s: must be from 0 to 86400", name, seconds->text);
    *ticks = (uint64_t)ms;
    return OST_OK;
}

/* Checks that the other options are compatible with --headset, and sets the options that --headset implies. */
static ost_status check_headset(const app_state *app, sim_args *args, ost_error *err)
{
    if (args->no_clock)
        return usage_error(app, err, "--no-clock: a headset needs the clock; omit --headset");
    if (args->hud || args->video.target || args->video.pipe)
        return usage_error(app, err, "%s: a headset's frames are not written; use --record, and osteon replay",
                           args->hud ? "--hud" : "--video");
    if (args->renderer_given && args->renderer != SIM_RENDERER_AUTO && args->renderer != SIM_RENDERER_GL)
        return usage_error(app, err, "--renderer %s: a headset needs gl", sim_renderer_names[args->renderer]);
    args->renderer = SIM_RENDERER_GL;
    args->renderer_given = args->headless = args->contact = true;
    return OST_OK;
}

static ost_status check_show(const app_state *app, sim_args *args, ost_error *err)
{
    ost_status status = frame_size(app, args->size, &args->width, &args->height, err);
    if (status == OST_OK && (args->picture || args->video.target || args->video.pipe || !args->headless) &&
        !args->renderer_given)
        args->renderer = args->headless ? SIM_RENDERER_POINTS : SIM_RENDERER_AUTO;
    if (status == OST_OK && !args->headless && args->renderer < SIM_RENDERER_AUTO)
        return usage_error(app, err,
                           "--renderer %s: a window needs auto, points, gl, mesh or thesis; otherwise pass --headless",
                           sim_renderer_names[args->renderer]);
    if (status == OST_OK && !args->headless && args->no_clock)
        return usage_error(app, err, "--no-clock: a window needs the clock; pass --headless");
    if (status == OST_OK && (args->hud || args->video.target || args->video.pipe) &&
        args->renderer < SIM_RENDERER_AUTO)
        return usage_error(app, err, "%s: needs --renderer auto, points, gl, mesh or thesis",
                           args->hud ? "--hud" : "--video");
    if (status == OST_OK)
        status = film_check(app, &args->video, err);
    if (status == OST_OK && args->picture && args->renderer < SIM_RENDERER_AUTO)
        return usage_error(app, err, "--picture %s: needs --renderer auto, points, gl, mesh or thesis", args->picture);
    return status == OST_OK ? appearance_check(app, &args->look, err) : status;
}

ost_status sim_args_check(app_state *app, sim_args *args, ost_error *err)
{
    ost_status status = ream_period(app, &args->rate, &args->period_ns, err);
    if (status == OST_OK)
        status = ream_max_gap(app, args->max_gap, &args->gaps, err);
    if (status == OST_OK && args->headset)
        status = check_headset(app, args, err);
    if (!args->device)
        args->device = args->headset ? "openxr" : args->headless ? "sim" : "mouse";
    if (args->print_force)
        return sim_force_params(app, args, err);
    if (status == OST_OK && args->classes_text &&
        (status = ost_density_classes_parse(args->classes_text, &args->classes, err)) != OST_OK)
        ost_fail_context(err, "--classes");
    args->ticks = args->headless && !args->headset ? 10000 : 0;
    if (status == OST_OK && args->seconds.text)
        status = ticks_of(app, "seconds", &args->seconds, &args->ticks, err);
    if (status != OST_OK)
        return status;
    if ((status = check_motor(app, args, err)) != OST_OK || (status = sim_force_params(app, args, err)) != OST_OK)
        return status;
    if ((status = check_show(app, args, err)) != OST_OK)
        return status;
    if (args->picture && (status = out_check(app, args->picture, "png", err)) != OST_OK)
        return status;
    if (args->ticks == 0 && args->seconds.text)
        return usage_error(app, err, "--seconds 0: must be greater than 0");
    ost_haptic_info info;
    if (args->no_clock && sim_device_info(args, &info) && !(info.caps & OST_HAPTIC_LOGICAL))
        return usage_error(app, err, "--no-clock: cannot be combined with --device %s, which runs in real time",
                           info.name);
    if (sim_device_is(args, "replay")) {
        if (args->paths.count != 1)
            return usage_error(app, err, "--device replay needs one --path SESSION");
        args->session = args->paths.value[0];
    }
    /* The defaults are set here, so that a session contains the values that a replay needs. */
    args->tools_given = args->tools.count > 0;
    if (!args->tools.count && !args->resume)
        args->tools = args->motor_waits ? (option_list){3, {"builtin:peg", "builtin:reamer", "builtin:burr"}}
                                        : (option_list){1, {"builtin:reamer"}};
    args->paths_given = args->paths.count > 0;
    /* With force feedback, the simulated operator presses on the bone. Without force feedback, the tool would move
     * straight into the bone, so another path is the default. */
    const bool pressing = sim_device_is(args, "sim") && !(args->force_given && !args->force);
    if (!args->paths.count)
        args->paths = (option_list){1, {pressing ? "builtin:glenoid-press" : "builtin:glenoid-slow"}};
    args->plan.target.press_ticks = args->ticks && args->ticks < PRESS_TICKS_MAX ? (size_t)args->ticks
                                                                                 : PRESS_TICKS_MAX;
    if (!args->resume && args->tools.count > 1 && args->paths.count > args->tools.count)
        return usage_error(app, err,
                           "%d paths and %d tools; pass one tool for all paths, or one per path in the same order",
                           args->paths.count, args->tools.count);
    /* The backend uses one thread by default, so that the other cores are available for recording and rendering. */
    if (!app->threads && strcmp(app->backend, "cpu") == 0)
        app->threads = 1;
    if (args->debrief && !args->record)
        return usage_error(app, err, "--debrief needs --record SESSION, which stores the motion and the forces");
    if (args->debrief && (status = out_check(app, args->debrief, "html", err)) != OST_OK)
        return status;
    if (args->record && (status = out_check(app, args->record, "session", err)) != OST_OK)
        return status;
    return args->out ? out_check(app, args->out, "nrrd|nii|nii.gz|txt", err) : OST_OK;
}
