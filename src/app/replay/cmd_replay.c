/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Implements `osteon replay`: replays a recorded session on any backend.
 *
 * The digest of every tick is compared with the recorded digest. At the end, the counts and the bone's digest are
 * compared as well. With --verify, a difference is also located: the same ticks are run on a second backend, the
 * reference, up to the first tick that differs. A comparison of the two bones then yields the chunk and the voxel. The
 * result, recorded or replayed, that agrees with the reference is the correct one.
 */
#include "app/replay/run.h"

ost_status cmd_replay(app_state *app, int argc, char **argv, ost_error *err)
{
    replay_args args = {.film.video.fps = 30};
    target_options *t = &args.plan.target;
    const operand operands[] = {{"SESSION", &args.session, "no session given"}, {0}};
    const option options[] = {
        {.name = "verify",
         .kind = OPTION_FLAG,
         .out = &args.verify,
         .help = "compare up to the end of the recording; if something differs, find the tick, chunk and voxel "
                 "with a second backend"},
        {.name = "out",
         .kind = OPTION_OUTPUT,
         .out = &args.out,
         .value = "FILE",
         .help = "the bone after the last tick: .nrrd, .nii, .nii.gz or .txt"},
        {.name = "ticks",
         .kind = OPTION_INTEGER,
         .out = &args.ticks,
         .given = &args.ticks_given,
         .value = "N",
         .min = 1,
         .max = INT64_MAX,
         .help = "repeat only the first N ticks"},
        {.name = "bone",
         .kind = OPTION_TEXT,
         .out = &args.bone,
         .value = "BONE",
         .help = "where the bone is now (default: where it was recorded)"},
        {.name = "tool",
         .kind = OPTION_LIST,
         .out = &args.tools,
         .value = "TOOL",
         .help = "where the tools are now, in order; may repeat (default: where they were recorded)"},
        {.name = "debrief",
         .kind = OPTION_OUTPUT,
         .out = &args.debrief,
         .value = "FILE.html",
         .help = "page that compares the result with the plan: angles, depths, hole, seat, force, pictures"},
        COMPRESS_OPTION(args.compress),
        HEADING("glenoid and plan, for --debrief"),
        TARGET_OPTIONS(*t, "centre of the glenoid's face (default: as in the session, else as in the bone's file)"),
        GLENOID_PLAN_OPTIONS(args.plan),
        HEADING("video and its appearance"),
        REPLAY_FILM_OPTIONS(args.film),
        {.name = NULL}};
    const usage_text usage = {
        .synopsis = "SESSION [--verify] [--out FILE] [options]",
        .about = "Repeats a recorded session tick by tick on any backend and compares the result\n"
                 "of each tick with the recording. Exit status 1 if something differs; with\n"
                 "--verify, exit status 2 if everything in the file is equal but ticks or the end\n"
                 "are missing.",
        .operands = operands,
        .options = options,
        .notes = "A session that was cut off or damaged is repeated up to the first missing tick.",
        .example = "  osteon ream --bone builtin:glenoid --tool builtin:reamer --path builtin:glenoid-ream \\\n"
                   "    --out reamed.nrrd --record today.session\n"
                   "  osteon replay today.session --verify --backend ref\n"
                   "  osteon replay today.session --ticks 2000 --out halfway.nrrd\n"
                   "  osteon replay today.session --video today.mp4",
    };
    ost_status status;
    if (!options_parse(app, &usage, argc, argv, &status, err))
        return status;
    if (args.out && (status = out_check(app, args.out, "nrrd|nii|nii.gz|txt", err)) != OST_OK)
        return status;
    if (args.debrief && (status = out_check(app, args.debrief, "html", err)) != OST_OK)
        return status;
    if ((status = replay_film_check(app, &args.film, err)) != OST_OK)
        return status;
    return replay_session(app, &args, err);
}
