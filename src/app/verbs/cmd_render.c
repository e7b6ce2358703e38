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

#include "app/picture/appearance.h"
#include "app/picture/tool.h"
#include "app/common/backend_choice.h"
#include "app/film/frame_size.h"
#include "app/film/frame_times.h"
#include "app/input/load.h"
#include "app/common/progress.h"
#include "app/input/ream_path.h"
#include "app/common/result.h"
#include "app/common/print.h"
#include "app/picture/view.h"
#include "core/clock.h"
#include "render/viewer.h"

enum { PLANNED_UM = 3000, PLANNED_UM_MAX = 20000 };

typedef struct render_args {
    const char *bone, *before, *tool, *pose_text, *out;
    int style, renderer, width, height;
    view_options view;
    double depth_mm;
    option_decimal depth;
    appearance_options look;
    ost_pose pose;
    ct_options ct;
    tool_options how;
    target_options target;
} render_args;

enum { RENDERER_POINTS, RENDERER_AUTO, RENDERER_GL, RENDERER_MESH, RENDERER_THESIS };
static const char *const renderer_names[] = {"points", "auto", "gl", "mesh", "thesis"};

typedef struct drawing {
    ost_backend *backend;
    ost_bone *bone;
    ost_tool *tool;
    ost_import_result imported;
    ost_live_channel *live;
    ost_viewer viewer;
    ost_view_subject subject;
    ost_volume before;
    ost_tool_volume tool_volume;
    appearance look;
    ost_picture picture;
    double draw_ms;
} drawing;

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

/* Adds the tool to the picture. If --pose is not given, the pose is the first pose of the built-in reaming path. */
static ost_status add_tool(const render_args *args, drawing *d, const ost_glenoid *glenoid, bool known, ost_error *err)
{
    ost_path path = {0};
    ost_pose pose = args->pose;
    ost_status status = ost_tool_download(d->tool, &d->tool_volume, err);
    if (status == OST_OK)
        status = picture_add_tool(&d->viewer, d->tool, args->tool, &args->how, err);
    if (status == OST_OK && !args->pose_text && !known)
        status = ost_fail(err, OST_ERR_USAGE,
                          "%s: the glenoid's position is not set: pass --pose X,Y,Z,QW,QX,QY,QZ, or --at and --axis",
                          args->bone);
    if (status == OST_OK && !args->pose_text) {
        status = ost_builtin_path(OST_BUILTIN_GLENOID_REAM, glenoid, ost_tool_geometry_get(d->tool), 0, &path, err);
        if (status == OST_OK)
            pose = path.ticks[0].pose;
    }
    if (status == OST_OK) {
        d->viewer.has_state = true;
        d->viewer.state = (ost_live_state){.ticks = 1, .pose = pose};
    }
    ost_path_free(&path);
    return status;
}

/* Sets the uncut surface from the bone of --before or, if --before is not given, from the bone itself. */
static ost_status add_uncut(const app_state *app, const render_args *args, drawing *d, const ost_glenoid *glenoid,
                            bool known, ost_error *err)
{
    const ost_density_classes classes = ost_density_classes_default();
    ost_bone_info info;
    ost_bone *bone = NULL;
    ost_import_result imported;
    ost_status status = args->before ? load_bone(app, d->backend, args->before, &args->ct, false, &bone, &imported, err)
                                     : OST_OK;
    if (status == OST_OK)
        status = ost_bone_info_get(args->before ? bone : d->bone, &info, err);
    if (status == OST_OK && !ost_geometry_equal(&info.geometry, &d->viewer.bone.geometry))
        status = ost_fail(err, OST_ERR_INPUT, "%s and %s differ in dims, spacing or origin", args->before, args->bone);
    if (status == OST_OK)
        status = bone_to_volume(args->before ? bone : d->bone, NULL, &d->before, err);
    if (status == OST_OK)
        status = ost_viewer_set_uncut(&d->viewer, &d->before, info.threshold, &classes, known ? &glenoid->at : NULL,
                                      known ? glenoid->axis : NULL, err);
    d->viewer.reference.uncut = !args->before;
    ost_bone_free(bone);
    return status;
}

static ost_status draw(const app_state *app, const render_args *args, drawing *d, ost_error *err)
{
    ost_glenoid glenoid;
    ost_camera camera;
    progress_show(NULL, "drawing", 0);
    ost_status status = ost_live_create(d->bone, &d->live, err);
    if (status != OST_OK)
        return status;
    const ost_geometry *g = ost_live_geometry(d->live);
    status = view_subject(app, &args->view, &args->target, &d->imported.meta, g, args->bone, &glenoid, &d->subject,
                          err);
    const bool known = d->subject.has_face;
    if (status == OST_OK)
        status = ost_viewer_init(&d->viewer, g, args->style ? OST_STYLE_FACES : OST_STYLE_SMOOTH, NULL,
                                 (int)app->threads, err);
    if (status != OST_OK)
        return status;
    if (args->renderer == RENDERER_MESH)
        status = ost_viewer_use_mesh(&d->viewer, d->backend, err);
    else if (args->renderer == RENDERER_AUTO)
        ost_viewer_use_card(&d->viewer);
    else if (args->renderer != RENDERER_POINTS)
        status = ost_viewer_use_gl(&d->viewer, args->renderer == RENDERER_GL ? &ost_gl_ours : &ost_gl_thesis, err);
    ost_viewer_follow(&d->viewer, d->live);
    if (status == OST_OK)
        status = add_uncut(app, args, d, &glenoid, known, err);
    if (status == OST_OK && d->tool)
        status = add_tool(args, d, &glenoid, known, err);
    if (status != OST_OK)
        return status;
    view_fit(&args->target, &d->viewer.reference.volume, d->viewer.reference.threshold, &d->subject);
    const ost_orbit orbit = view_orbit(&args->view, &d->subject, d->tool ? &d->viewer.state.pose : NULL);
    double eye[3], q[4];
    status = ost_orbit_camera(&orbit, args->width, args->height, &camera, err);
    if (status != OST_OK)
        return status;
    ost_pose_to_doubles(&camera.pose, eye, q);
    const ost_live_state state = d->viewer.state;
    const bool has_state = d->viewer.has_state;
    status = appearance_begin(&d->look, &d->viewer, &d->subject, args->depth_mm, d->tool ? &d->tool_volume : NULL,
                              &args->look, eye, err);
    if (status == OST_OK)
        status = ost_viewer_update(&d->viewer, err);
    d->viewer.state = state;
    d->viewer.has_state = has_state;
    d->viewer.scene.changed = 0;
    const int64_t begin = ost_clock_ns();
    if (status == OST_OK)
        status = ost_viewer_draw(&d->viewer, &camera, err);
    d->draw_ms = (double)(ost_clock_ns() - begin) * 1e-6;
    if (status == OST_OK && !args->look.no_legend)
        status = appearance_marks(&d->look, &orbit, view_oriented(&d->imported.meta), err);
    if (status == OST_OK)
        status = ost_picture_init(&d->picture, args->width, args->height, err);
    if (status != OST_OK)
        return status;
    ost_frame_copy(&d->viewer.frame, &d->picture);
    return ost_picture_write_png(args->out, &d->picture, err);
}

static void free_drawing(drawing *d)
{
    ost_picture_free(&d->picture);
    appearance_free(&d->look);
    ost_volume_free(&d->before);
    ost_tool_volume_free(&d->tool_volume);
    ost_viewer_free(&d->viewer);
    ost_live_free(d->live);
    ost_tool_free(d->tool);
    ost_bone_free(d->bone);
    ost_backend_close(d->backend);
}

/* Reports the mesh of the picture: its size, and the time in which the backend made it. */
static void print_mesh(const app_state *app, const ost_gl *gl)
{
    const ost_gl_counts c = ost_gl_counts_get(gl);
    json_t *o = json_object();
    char chunks[FORMAT_TEXT], quads[FORMAT_TEXT], a[FORMAT_TEXT];
    put_integer(o, "chunks", (int64_t)c.meshed);
    put_integer(o, "drawn_faces", (int64_t)c.quads);
    put_integer(o, "bytes", (int64_t)c.uploaded);
    put_real(o, "mesh_ms", (double)c.mesh_ns * 1e-6);
    put_real(o, "copy_ms", (double)c.copy_ns * 1e-6);
    put(app->result, "mesh", o);
    print_line(app, "  %s chunks meshed in %s, %s faces drawn", format_count(chunks, (int64_t)c.meshed),
               format_time(a, (double)c.mesh_ns * 1e-6), format_count(quads, (int64_t)c.quads));
}

static void print_gl(const app_state *app, const ost_gl *gl)
{
    const ost_gl_info info = ost_gl_info_get(gl);
    json_t *o = json_object();
    put_text(o, "version", info.version);
    put_text(o, "driver", info.driver);
    put_text(o, "way", info.way);
    put_bool(o, "software", info.software);
    put(app->result, "opengl", o);
    print_line(app, "  by OpenGL %s, %s, %s", info.version, info.driver, info.way);
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
    char a[FORMAT_TEXT], n[FORMAT_TEXT];
    ost_digest file;
    if (!options_parse(app, &usage, argc, argv, &status, err) || (status = check_args(app, &args, err)) != OST_OK)
        return status;
    drawing d = {0};
    status = backend_choose(app, &d.backend, err);
    if (status == OST_OK && args.tool)
        status = load_tool(app, d.backend, args.tool, NULL, &args.how, &d.tool, NULL, err);
    if (status == OST_OK)
        status = load_bone(app, d.backend, args.bone, &args.ct, false, &d.bone, &d.imported, err);
    if (status == OST_OK)
        status = draw(app, &args, &d, err);
    if (status == OST_OK)
        status = file_digest(args.out, &file, err);
    if (status == OST_OK) {
        put_text(app->result, "out", args.out);
        put_digest(app->result, "file_sha256", &file);
        put_text(app->result, "renderer",
                 renderer_names[args.renderer != RENDERER_AUTO ? args.renderer
                                : d.viewer.gl                  ? RENDERER_GL
                                                               : RENDERER_POINTS]);
        put_integer(app->result, "width", args.width);
        put_integer(app->result, "height", args.height);
        put_integer(app->result, "surface_voxels", (int64_t)d.viewer.bone.points);
        put_real(app->result, "time_ms", d.draw_ms);
        print_line(app, "%s: %d x %d pixels of %s surface voxels, drawn in %s", args.out, args.width, args.height,
                   format_count(n, (int64_t)d.viewer.bone.points), format_time(a, d.draw_ms));
        if (d.viewer.gl)
            print_gl(app, d.viewer.gl);
        if (*d.viewer.no_card) {
            put_text(app->result, "no_card", d.viewer.no_card);
            print_line(app, "  by the processor: %s", d.viewer.no_card);
        }
        if (d.viewer.gl && args.renderer == RENDERER_MESH)
            print_mesh(app, d.viewer.gl);
    }
    free_drawing(&d);
    return status;
}
