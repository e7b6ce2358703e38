/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Implements `osteon export`: writes a bone for other programs or as a picture.
 *
 *   .nrrd .nii .nii.gz .mha .txt   the voxels, or a label map of the bone
 *   .stl .ply .obj                 the surface, closed
 *   .png                           slices, or a view of the surface
 *
 * The verb also writes a session as a table, .csv.
 */
#include <math.h>
#include <string.h>

#include "app/common/print.h"
#include "app/common/progress.h"
#include "app/common/result.h"
#include "app/film/frame_size.h"
#include "app/input/load.h"
#include "app/picture/view.h"
#include "app/replay/session_info.h"
#include "app/verbs/export_parts.h"
#include "io/mesh/write_any.h"
#include "mesh/surface.h"

typedef struct export_args {
    const char *bone, *out, *before;
    bool slices, compress, labels, omit_empty;
    view_options view;
    int64_t threshold, decimals;
    bool threshold_given;
    target_options target;
} export_args;

static ost_status export_surface(const app_state *app, const export_args *args, const loaded_volume *in, ost_error *err)
{
    ost_mesh mesh = {0};
    ost_pm3 lo, hi;
    /* A bone stores 0 for each density below its threshold, so its densities cannot be interpolated. */
    const bool densities = in->kind == LOAD_CT && !args->before;
    ost_surface_placement placement = densities ? OST_SURFACE_DENSITY : OST_SURFACE_SMOOTH;
    progress_show(NULL, "extracting the surface", 0);
    ost_status status = ost_surface_extract(&in->volume, in->threshold, placement, &mesh, err);
    if (status != OST_OK)
        ost_fail_context(err, "%s", args->bone);
    if (status == OST_OK)
        status = ost_mesh_bounds(&mesh, &lo, &hi, err);
    if (status == OST_OK)
        status = ost_mesh_write_any(args->out, &mesh, in->kind == LOAD_TOOL ? OST_MESH_OWN : OST_MESH_LPS, err);
    if (status == OST_OK) {
        char n[FORMAT_TEXT];
        double volume = ost_mesh_volume_mm3(&mesh);
        put_integer(app->result, "triangles", (int64_t)mesh.triangle_count);
        put_integer(app->result, "vertices", (int64_t)mesh.vertex_count);
        put_real(app->result, "volume_mm3", volume);
        put(app->result, "bounds_mm",
            json_pack("[[f,f,f],[f,f,f]]", ost_pm_to_mm(lo.x), ost_pm_to_mm(lo.y), ost_pm_to_mm(lo.z),
                      ost_pm_to_mm(hi.x), ost_pm_to_mm(hi.y), ost_pm_to_mm(hi.z)));
        print_line(app, "%s: a closed surface of %s triangles, %.4g mm3, millimetres", args->out,
                   format_count(n, (int64_t)mesh.triangle_count), volume);
    }
    ost_mesh_free(&mesh);
    return status;
}

/*
 * Computes the indices of the voxel that contains the position of --at. If --at is not given, each index is -1, which
 * means the middle.
 */
static ost_status voxel_at(const app_state *app, const export_args *args, const ost_geometry *g, int32_t at[3],
                           ost_error *err)
{
    at[0] = at[1] = at[2] = -1;
    if (!args->target.at_given)
        return OST_OK;
    const ost_pm p[3] = {args->target.at.x - g->origin.x, args->target.at.y - g->origin.y,
                         args->target.at.z - g->origin.z};
    const ost_pm s[3] = {g->spacing.x, g->spacing.y, g->spacing.z};
    const int32_t n[3] = {g->dims.x, g->dims.y, g->dims.z};
    for (int a = 0; a < 3; a++) {
        int64_t v = (int64_t)floor((double)p[a] / (double)s[a] + 0.5);
        if (v < 0 || v >= n[a]) {
            char text[FORMAT_TEXT];
            return usage_error(app, err, "--at %s lies outside the grid of %s", format_point(text, args->target.at),
                               args->bone);
        }
        at[a] = (int32_t)v;
    }
    return OST_OK;
}

static ost_status draw_view(const app_state *app, const export_args *args, loaded_volume *in, loaded_volume *before,
                            ost_picture *out, ost_error *err)
{
    ost_glenoid glenoid;
    ost_view_subject subject;
    ost_view_options options = {.width = 800,
                                .height = 800,
                                .threads = (int)app->threads,
                                .tool = in->kind == LOAD_TOOL,
                                .unoriented = !view_oriented(&in->volume.meta)};
    double right[3], back[3];
    ost_status status = args->view.size ? frame_size(app, args->view.size, &options.width, &options.height, err)
                                        : OST_OK;
    if (status == OST_OK)
        status = loaded_to_bone(app, args->bone, in, err);
    if (status == OST_OK && args->before)
        status = loaded_to_bone(app, args->before, before, err);
    if (status == OST_OK)
        status = view_subject(app, &args->view, &args->target, &in->volume.meta, &in->volume.geometry, args->bone,
                              &glenoid, &subject, err);
    if (status != OST_OK)
        return status;
    view_fit(&args->target, args->before ? &before->volume : &in->volume, in->threshold, &subject);
    const ost_orbit orbit = view_orbit(&args->view, &subject, NULL);
    ost_orbit_frame(&orbit, right, options.up, back);
    for (int a = 0; a < 3; a++)
        options.direction[a] = -back[a];
    memcpy(options.centre_mm, orbit.at, sizeof options.centre_mm);
    options.extent_mm = orbit.distance / OST_VIEW_FOCAL;
    options.threshold = in->threshold;
    return ost_picture_view(&in->volume, args->before ? &before->volume : NULL, &options, out, err);
}

static ost_status draw_slices(const app_state *app, const export_args *args, const loaded_volume *in,
                              const ost_volume *before, ost_picture *out, ost_error *err)
{
    ost_slices_options options = {.threshold = in->threshold,
                                  .unoriented = in->kind == LOAD_TOOL || !view_oriented(&in->volume.meta)};
    int height = 0;
    ost_status status = voxel_at(app, args, &in->volume.geometry, options.at, err);
    if (status == OST_OK && args->view.size)
        status = frame_size(app, args->view.size, &options.pixels, &height, err);
    if (status == OST_OK && height != options.pixels)
        return usage_error(app, err, "--size %s: expected one number for slices: the longest side in pixels",
                           args->view.size);
    if (in->kind == LOAD_TOOL) {
        options.level = 1;
        options.width = 3;
    }
    return status == OST_OK ? ost_picture_slices(&in->volume, before, &options, out, err) : status;
}

static ost_status export_picture(const app_state *app, const export_args *args, loaded_volume *in, ost_error *err)
{
    loaded_volume before = {0};
    ost_picture picture = {0};
    ost_status status = OST_OK;
    if (args->before) {
        status = load_volume(app, args->before, &before, err);
        if (status == OST_OK && !ost_geometry_equal(&before.volume.geometry, &in->volume.geometry))
            status = ost_fail(err, OST_ERR_INPUT, "%s and %s differ in dims, spacing or origin", args->before,
                              args->bone);
    }
    progress_show(NULL, "drawing", 0);
    if (status == OST_OK && args->view.view_given)
        status = draw_view(app, args, in, &before, &picture, err);
    else if (status == OST_OK)
        status = draw_slices(app, args, in, args->before ? &before.volume : NULL, &picture, err);
    if (status == OST_OK)
        status = ost_picture_write_png(args->out, &picture, err);
    if (status == OST_OK) {
        put_integer(app->result, "width", picture.width);
        put_integer(app->result, "height", picture.height);
        print_line(app, "%s: a picture of %d x %d pixels", args->out, picture.width, picture.height);
    }
    ost_picture_free(&picture);
    ost_volume_free(&before.volume);
    return status;
}

static ost_status export_volume(const app_state *app, const export_args *args, const loaded_volume *in, ost_error *err)
{
    if (in->kind == LOAD_TOOL)
        return usage_error(app, err, "%s is a tool: it can be exported as .stl, .ply, .obj or .png", args->bone);
    const ost_write_options write = {.compress = args->compress, .text_decimals = (int)args->decimals,
                                     .omit_empty = args->omit_empty, .progress = progress_show};
    ost_status status = ost_volume_write(args->out, &in->volume, &write, err);
    if (status == OST_OK) {
        char d[FORMAT_TEXT], s[FORMAT_TEXT];
        print_line(app, "%s: %s voxels of %s", args->out, format_dims(d, in->volume.geometry.dims),
                   format_spacing(s, in->volume.geometry.spacing));
    }
    return status;
}

static ost_status take_removed(const app_state *app, const export_args *args, loaded_volume *in, ost_error *err)
{
    int64_t removed;
    char n[FORMAT_TEXT];
    const ost_status status = export_removed(app, args->before, args->bone, in, &removed, err);
    if (status != OST_OK)
        return status;
    put_integer(app->result, "removed_voxels", removed);
    print_line(app, "%s: %s voxels of %s were removed", args->bone, format_count(n, removed), args->before);
    return OST_OK;
}

static ost_status write_out(const app_state *app, const export_args *args, loaded_volume *in, ost_error *err)
{
    if (ends_with(args->out, "stl") || ends_with(args->out, "ply") || ends_with(args->out, "obj"))
        return export_surface(app, args, in, err);
    return ends_with(args->out, "png") ? export_picture(app, args, in, err) : export_volume(app, args, in, err);
}

static ost_status check_args(app_state *app, const export_args *args, ost_error *err)
{
    bool png = ends_with(args->out, "png");
    if (!png && (args->slices || args->view.view_given || args->view.size || args->target.at_given))
        return usage_error(app, err, "--slices, --view, --at and --size need a .png file, not %s", args->out);
    if (args->slices && args->view.view_given)
        return usage_error(app, err, "--slices and --view cannot be combined");
    if (args->decimals && !ends_with(args->out, "txt"))
        return usage_error(app, err, "--decimals needs a .txt file, not %s", args->out);
    if (args->omit_empty && !ends_with(args->out, "txt"))
        return usage_error(app, err, "--omit-empty needs a .txt file, not %s", args->out);
    if (args->labels && !(ends_with(args->out, "nrrd") || ends_with(args->out, "nii") ||
                          ends_with(args->out, "nii.gz") || ends_with(args->out, "mha")))
        return usage_error(app, err, "--labels needs a .nrrd, .nii, .nii.gz or .mha file, not %s", args->out);
    if (ends_with(args->out, "mcap") || ends_with(args->out, "h5") || ends_with(args->out, "hdf5"))
        return usage_error(app, err,
                           "%s: this command does not write the format: export the session to a table, --out "
                           "FILE.csv, or use the Python package (docs/guide/python.md)",
                           args->out);
    return out_check(app, args->out, "nrrd|nii|nii.gz|mha|txt|stl|ply|obj|png|csv", err);
}

ost_status cmd_export(app_state *app, int argc, char **argv, ost_error *err)
{
    export_args args = {0};
    target_options *t = &args.target;
    const operand operands[] = {{"BONE", &args.bone, "no bone given"}, {0}};
    const option options[] = {
        {.name = "out",
         .kind = OPTION_OUTPUT,
         .out = &args.out,
         .value = "FILE",
         .required = true,
         .help = "volume: .nrrd, .nii, .nii.gz, .mha or .txt; surface: .stl, .ply or .obj; picture: .png; "
                 "session: .csv"},
        {.name = "threshold",
         .kind = OPTION_INTEGER,
         .out = &args.threshold,
         .given = &args.threshold_given,
         .value = "HU",
         .min = 1,
         .max = 32767,
         .help = "lowest density of bone (default: as in the bone's file, else 120)"},
        {.name = "slices",
         .kind = OPTION_FLAG,
         .out = &args.slices,
         .help = ".png: an axial, a coronal and a sagittal slice (default)"},
        VIEW_OPTION(args.view, ".png: the surface as osteon render draws it, in this direction"),
        VIEW_EXTENT_OPTION(args.view),
        {.name = "before",
         .kind = OPTION_TEXT,
         .out = &args.before,
         .value = "BONE",
         .help = "the bone before removal: a .png colours the bone removed since; any other file contains only the "
                 "bone removed since"},
        {.name = "labels",
         .kind = OPTION_FLAG,
         .out = &args.labels,
         .help = "write a label map for 3D Slicer: 1 for bone, 0 elsewhere"},
        TARGET_OPTIONS(*t, ".png: point through which the slices pass (default: the middle), or at which the view is "
                           "directed (default: the glenoid's centre in the file)"),
        {.name = "size",
         .kind = OPTION_TEXT,
         .out = &args.view.size,
         .value = "WxH",
         .help = ".png: size of a view in pixels (default: 800x800), or one number, the longest side of a slice "
                 "(default: 480)"},
        {.name = "decimals",
         .kind = OPTION_INTEGER,
         .out = &args.decimals,
         .value = "N",
         .min = 1,
         .max = 9,
         .help = "digits after the decimal point in a .txt (default: as many as needed)"},
        {.name = "omit-empty",
         .kind = OPTION_FLAG,
         .out = &args.omit_empty,
         .help = ".txt: omit the lines of voxels of density 0; the file is then read as the box of the other voxels"},
        COMPRESS_OPTION(args.compress),
        {.name = NULL}};
    const usage_text usage = {
        .synopsis = "BONE --out FILE [options]",
        .about = "Writes a bone in the format of FILE: its voxels, its surface or a picture. BONE may\n"
                 "also be a CT or a tool grid. A session is written as a table with a row for each\n"
                 "tick.",
        .operands = operands,
        .streams = true,
        .options = options,
        .notes = "Lengths are in millimetres, in the bone's frame (LPS). A surface is closed, and its\n"
                 "file states the frame in the form that 3D Slicer reads (SPACE=LPS). A text file is\n"
                 "first converted into a bone, as by osteon import.",
        .example = "  osteon export reamed.nrrd --out reamed.stl\n"
                   "  osteon export reamed.nrrd --before scapula.nrrd --view en-face --out reamed.png\n"
                   "  osteon export reamed.nrrd --before scapula.nrrd --out removed.stl\n"
                   "  osteon export today.session --out today.csv",
    };
    ost_status status;
    if (!options_parse(app, &usage, argc, argv, &status, err) || (status = check_args(app, &args, err)) != OST_OK)
        return status;
    ost_digest file;
    if (ends_with(args.out, "csv")) {
        status = export_session(app, args.bone, args.out, err);
        if (status == OST_OK && (status = file_digest(args.out, &file, err)) == OST_OK)
            put_digest(app->result, "file_sha256", &file);
        return status;
    }
    loaded_volume in;
    status = load_volume(app, args.bone, &in, err);
    if (status == OST_OK) {
        if (args.threshold_given)
            in.threshold = (int32_t)args.threshold;
        put_text(app->result, "in", args.bone);
        put_text(app->result, "out", args.out);
        put_dims(app->result, "dims", in.volume.geometry.dims);
        put_mm3(app->result, "spacing_mm", in.volume.geometry.spacing);
        if (args.before && !ends_with(args.out, "png"))
            status = take_removed(app, &args, &in, err);
        if (status == OST_OK && args.labels)
            status = export_labels(args.bone, &in, err);
        if (status == OST_OK)
            status = write_out(app, &args, &in, err);
    }
    if (status == OST_OK && (status = file_digest(args.out, &file, err)) == OST_OK)
        put_digest(app->result, "file_sha256", &file);
    ost_volume_free(&in.volume);
    return status;
}
