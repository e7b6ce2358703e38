/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Implements `osteon render`: draws a picture of a bone and a tool, without a display.
 *
 *   bone --ost_live_channel--> surface voxels --.
 *   bone before (--before) -> colours --+
 *   tool, --pose ---------------------- +--camera--> frame --> legend --> .png
 *   clip plane, ghost, lines -----------'
 *
 * The verb uses the simulator's renderer. On every machine, the picture consists of the same bytes.
 */
#include <string.h>

#include "app/common/result.h"
#include "app/film/frame_size.h"
#include "app/render/render.h"

enum { PLANNED_UM = 3000, PLANNED_UM_MAX = 20000 };

/* Parses "x,y,z,qw,qx,qy,qz", the format of the pose in a line of a path. */
static ost_status parse_pose(const app_state *app, render_args *args, ost_error *err)
{
    ost_decimal number[7];
    const char *p = args->pose_text, *end = p + strlen(p);
    for (int i = 0; i < 7; i++) {
        const char *after = ost_decimal_read(p, end, &number[i]);
        if (!after || after == p || (i < 6 ? after == end || *after != ',' : after != end))
            return usage_error(app, err, "--pose %s: expected x,y,z,qw,qx,qy,qz in millimetres", args->pose_text);
        p = after + 1;
    }
    ost_status status = ost_pose_from_decimals(number, number + 3, &args->pose, err);
    return status == OST_OK ? status : ost_fail_context(err, "--pose %s", args->pose_text);
}

static ost_status check_args(app_state *app, render_args *args, ost_error *err)
{
    ost_status status = frame_size(app, args->view.size, &args->width, &args->height, err);
    if (status == OST_OK && args->pose_text && !args->tool)
        return usage_error(app, err, "--pose %s: needs --tool TOOL", args->pose_text);
    if (status == OST_OK && args->pose_text)
        status = parse_pose(app, args, err);
    if (status == OST_OK)
        status = appearance_check(app, &args->look, err);
    if (args->before && !args->look.colour_given)
        args->look.colour = OST_COLOUR_DEPTH;
    if (status == OST_OK && args->look.colour == OST_COLOUR_DEPTH && !args->before)
        return usage_error(app, err, "--colour depth needs the uncut bone: pass --before BONE");
    int64_t um = PLANNED_UM;
    if (args->depth.text && (!ost_decimal_scale(&args->depth.value, 1000, &um, NULL) || um < 0 || um > PLANNED_UM_MAX))
        return usage_error(app, err, "--planned %s: must be from 0 to %d", args->depth.text, PLANNED_UM_MAX / 1000);
    args->depth_mm = (double)um * 1e-3;
    return status == OST_OK ? out_check(app, args->out, "png", err) : status;
}

ost_status cmd_render(app_state *app, int argc, char **argv, ost_error *err)
{
    render_args args = {.ct = CT_OPTIONS_DEFAULT, .how = TOOL_OPTIONS_DEFAULT};
    target_options *t = &args.target;
    const option options[] = {
        {.name = "out", .kind = OPTION_OUTPUT, .out = &args.out, .value = "FILE.png", .required = true,
         .help = "the picture"},
        VIEW_OPTION(args.view, "direction of view (default: operator)"),
        VIEW_EXTENT_OPTION(args.view),
        {.name = "size", .kind = OPTION_TEXT, .out = &args.view.size, .value = "WxH",
         .help = "size of the picture in pixels (default: 1280x720)"},
        {.name = "before", .kind = OPTION_TEXT, .out = &args.before, .value = "BONE",
         .help = "the bone before removal: the surface that was exposed since is coloured by depth or as --colour "
                 "states (default: none, and --colour applies to the entire surface)"},
        {.name = "tool", .kind = OPTION_TEXT, .out = &args.tool, .value = "TOOL",
         .help = "a tool to draw: a mesh, a tool grid or builtin:reamer"},
        {.name = "pose", .kind = OPTION_TEXT, .out = &args.pose_text, .value = "X,Y,Z,QW,QX,QY,QZ",
         .help = "pose of the tool, as in a path (default: start of the built-in reaming)"},
        {.name = "renderer", .kind = OPTION_CHOICE, .out = &args.renderer, .value = "points|auto|gl|mesh|thesis",
         .help = "the processor (default), OpenGL if a graphics card executes it and otherwise the processor, OpenGL, "
                 "OpenGL with a triangle mesh of the visible faces, or OpenGL with "
                 "every voxel a point as in the thesis (docs/design/rendering.md)"},
        HEADING("appearance"),
        {.name = "style", .kind = OPTION_CHOICE, .out = &args.style, .value = "smooth|faces",
         .help = "shade by the surface's normals and smooth the edges (default), or draw flat faces as in the thesis"},
        APPEARANCE_OPTIONS(args.look),
        HEADING("glenoid and plan"),
        TARGET_OPTIONS(*t, "centre of the glenoid's face (default: as in the bone's file)"),
        {.name = "planned", .kind = OPTION_DECIMAL, .out = &args.depth, .value = "MM",
         .help = "planned reaming depth at the glenoid's centre (default: 3)"},
        HEADING("reading a CT"),
        CT_OPTIONS(args.ct),
        HEADING("reading a mesh"),
        TOOL_OPTIONS(args.how),
        {.name = NULL}};
    const operand operands[] = {{"BONE", &args.bone, "no bone given"}, {NULL, NULL, NULL}};
    const usage_text usage = {
        .synopsis = "BONE --out FILE.png [options]",
        .about = "Draws a bone, and a tool at its pose, without a display by the simulator's\n"
                 "renderer. The picture of the default renderer is bit-identical on every machine;\n"
                 "that of OpenGL differs in a few pixels.",
        .operands = operands,
        .streams = true,
        .options = options,
        .notes = "Bones and tools are read as by osteon ream.",
        .example = "  osteon render builtin:scapula --view en-face --out face.png\n"
                   "  osteon render cut.nrrd --before bone.nrrd --colour class --clip plan --out cut.png\n"
                   "  osteon render reamed.nrrd --tool builtin:reamer --size 1920x1080 --out reamer.png",
    };
    ost_status status;
    ost_digest file;
    if (!options_parse(app, &usage, argc, argv, &status, err) || (status = check_args(app, &args, err)) != OST_OK)
        return status;
    render_drawing d = {0};
    status = render_draw(app, &args, &d, err);
    if (status == OST_OK)
        status = file_digest(args.out, &file, err);
    if (status == OST_OK)
        render_report(app, &args, &d, &file);
    render_free(&d);
    return status;
}
