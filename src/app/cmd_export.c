/* SPDX-License-Identifier: Apache-2.0 */
/*
 * osteon export: writes a bone for other programs or as a picture.
 *
 *   .nrrd .nii .nii.gz .txt   the voxels
 *   .stl .ply                 the surface, closed
 *   .png                      slices, or a view of the surface
 *
 * It also writes a session as a table, .csv, as MCAP, .mcap, or as HDF5, .h5.
 */
#include <math.h>
#include <string.h>

#include "app/load.h"
#include "app/progress.h"
#include "app/ream_path.h"
#include "app/result.h"
#include "app/say.h"
#include "app/session_info.h"
#include "io/surface.h"

typedef struct export_args {
    const char *bone, *out, *before;
    bool slices, compress, voxels;
    int view; /* index in VIEWS */
    bool view_given;
    int64_t size, threshold, decimals;
    bool threshold_given;
    target_options target;
    ost_pm extent;
} export_args;

#define VIEWS "anterior|posterior|lateral|medial|superior|inferior|glenoid"
enum { VIEW_ANTERIOR, VIEW_POSTERIOR, VIEW_LATERAL, VIEW_MEDIAL, VIEW_SUPERIOR, VIEW_INFERIOR, VIEW_GLENOID };

static ost_status export_surface(const app_state *app, const export_args *args, const loaded_volume *in, ost_error *err)
{
    ost_mesh mesh = {0};
    ost_pm3 lo, hi;
    /* Below its threshold a bone holds zeros instead of densities, so there is nothing to interpolate. */
    ost_surface_place place = in->kind == LOAD_CT ? OST_SURFACE_DENSITY : OST_SURFACE_SMOOTH;
    ost_status status = ost_surface_extract(&in->volume, in->threshold, place, &mesh, err);
    if (status != OST_OK)
        ost_fail_context(err, "%s", args->bone);
    if (status == OST_OK)
        status = ost_mesh_bounds(&mesh, &lo, &hi, err);
    if (status == OST_OK)
        status = ends_with(args->out, "ply") ? ost_mesh_write_ply(args->out, &mesh, err) : ost_mesh_write_stl(args->out, &mesh, err);
    if (status == OST_OK) {
        char n[SAY_TEXT];
        double volume = ost_mesh_volume_mm3(&mesh);
        put_integer(app->result, "triangles", (int64_t)mesh.triangle_count);
        put_integer(app->result, "vertices", (int64_t)mesh.vertex_count);
        put_real(app->result, "volume_mm3", volume);
        put(app->result, "bounds_mm", json_pack("[[f,f,f],[f,f,f]]", ost_pm_to_mm(lo.x), ost_pm_to_mm(lo.y), ost_pm_to_mm(lo.z),
                                                ost_pm_to_mm(hi.x), ost_pm_to_mm(hi.y), ost_pm_to_mm(hi.z)));
        say(app, "%s: a closed surface of %s triangles, %.4g mm3, millimetres", args->out, say_count(n, (int64_t)mesh.triangle_count), volume);
    }
    ost_mesh_free(&mesh);
    return status;
}

/* Computes the indices of the voxel that contains --at; -1 on each axis (the middle) if --at is not given. */
static ost_status voxel_at(const app_state *app, const export_args *args, const ost_geometry *g, int32_t at[3], ost_error *err)
{
    at[0] = at[1] = at[2] = -1;
    if (!args->target.at_given)
        return OST_OK;
    const ost_pm p[3] = {args->target.at.x - g->origin.x, args->target.at.y - g->origin.y, args->target.at.z - g->origin.z};
    const ost_pm s[3] = {g->spacing.x, g->spacing.y, g->spacing.z};
    const int32_t n[3] = {g->dims.x, g->dims.y, g->dims.z};
    for (int a = 0; a < 3; a++) {
        int64_t v = (int64_t)floor((double)p[a] / (double)s[a] + 0.5);
        if (v < 0 || v >= n[a]) {
            char text[SAY_TEXT];
            return usage_error(app, err, "--at %s lies outside the grid of %s", say_point(text, args->target.at), args->bone);
        }
        at[a] = (int32_t)v;
    }
    return OST_OK;
}

static ost_status view_options(const app_state *app, const export_args *args, const loaded_volume *in, ost_view_options *out, ost_error *err)
{
    /* Directions into the scene, in LPS, for a right shoulder: its lateral side is the patient's
       right, -x. */
    static const double direction[][3] = {{0, 1, 0}, {0, -1, 0}, {1, 0, 0}, {-1, 0, 0}, {0, 0, -1}, {0, 0, 1}};
    ost_side side;
    double axis[3];
    bool has_axis, left = false;
    ost_status status = target_side(&args->target, &in->volume.meta, args->bone, &side, err);
    if (status == OST_OK)
        status = ost_axis_from_meta(&in->volume.meta, axis, &has_axis, err);
    if (status == OST_OK && (args->view == VIEW_LATERAL || args->view == VIEW_MEDIAL)) {
        if (has_axis)
            status = ost_glenoid_side(axis, side, &left, err);
        else if (side == OST_SIDE_UNKNOWN)
            return usage_error(app, err, "%s: the side is not set: pass --side left or --side right", args->bone);
        else
            left = side == OST_SIDE_LEFT;
    }
    if (status != OST_OK)
        return status;
    int pixels = args->size ? (int)args->size : 800;
    *out = (ost_view_options){.threshold = in->threshold, .width = pixels, .height = pixels};
    out->up[2] = 1;
    if (args->view != VIEW_GLENOID) {
        memcpy(out->direction, direction[args->view], sizeof out->direction);
        if (left)
            out->direction[0] = -out->direction[0];
        if (args->view == VIEW_SUPERIOR || args->view == VIEW_INFERIOR) {
            out->up[1] = -1;
            out->up[2] = 0;
        }
        if (args->target.at_given) {
            out->centre_mm[0] = ost_pm_to_mm(args->target.at.x);
            out->centre_mm[1] = ost_pm_to_mm(args->target.at.y);
            out->centre_mm[2] = ost_pm_to_mm(args->target.at.z);
            out->extent_mm = args->extent ? ost_pm_to_mm(args->extent) : 60;
        }
        return OST_OK;
    }
    ost_glenoid glenoid;
    status = target_find(app, &args->target, &in->volume.meta, args->bone, &glenoid, err);
    if (status != OST_OK)
        return status;
    memcpy(out->direction, glenoid.axis, sizeof out->direction);
    out->centre_mm[0] = ost_pm_to_mm(glenoid.at.x);
    out->centre_mm[1] = ost_pm_to_mm(glenoid.at.y);
    out->centre_mm[2] = ost_pm_to_mm(glenoid.at.z);
    out->extent_mm = args->extent ? ost_pm_to_mm(args->extent) : 60;
    return OST_OK;
}

static ost_status export_picture(const app_state *app, const export_args *args, const loaded_volume *in, ost_error *err)
{
    loaded_volume before = {0};
    ost_picture picture = {0};
    ost_status status = OST_OK;
    if (args->before) {
        status = load_volume(app, args->before, &before, err);
        if (status == OST_OK && !ost_geometry_equal(&before.volume.geometry, &in->volume.geometry))
            status = ost_fail(err, OST_ERR_INPUT, "%s and %s have other dims, spacing or origin", args->before, args->bone);
    }
    const ost_volume *old = args->before ? &before.volume : NULL;
    if (status == OST_OK && args->view_given) {
        ost_view_options options;
        status = view_options(app, args, in, &options, err);
        if (status == OST_OK)
            status = ost_picture_view(&in->volume, old, &options, &picture, err);
    } else if (status == OST_OK) {
        ost_slices_options options = {.threshold = in->threshold, .pixels = (int)args->size};
        if (in->kind == LOAD_TOOL) {
            options.level = 1;
            options.width = 3;
        }
        status = voxel_at(app, args, &in->volume.geometry, options.at, err);
        if (status == OST_OK)
            status = ost_picture_slices(&in->volume, old, &options, &picture, err);
    }
    if (status == OST_OK)
        status = ost_picture_write_png(args->out, &picture, err);
    if (status == OST_OK) {
        put_integer(app->result, "width", picture.width);
        put_integer(app->result, "height", picture.height);
        say(app, "%s: a picture of %d x %d pixels", args->out, picture.width, picture.height);
    }
    ost_picture_free(&picture);
    ost_volume_free(&before.volume);
    return status;
}

static ost_status export_volume(const app_state *app, const export_args *args, const loaded_volume *in, ost_error *err)
{
    if (in->kind == LOAD_TOOL)
        return usage_error(app, err, "%s is a tool: it can be exported as .stl, .ply or .png", args->bone);
    const ost_write_options write = {.compress = args->compress, .text_decimals = (int)args->decimals};
    ost_status status = ost_volume_write(args->out, &in->volume, &write, err);
    if (status == OST_OK) {
        char d[SAY_TEXT], s[SAY_TEXT];
        say(app, "%s: %s voxels of %s", args->out, say_dims(d, in->volume.geometry.dims), say_spacing(s, in->volume.geometry.spacing));
    }
    return status;
}

static ost_status check_args(app_state *app, const export_args *args, ost_error *err)
{
    bool png = ends_with(args->out, "png");
    if (!png && (args->slices || args->view_given || args->before || args->size || args->target.at_given))
        return usage_error(app, err, "--slices, --view, --before, --at and --size are for .png, not for %s", args->out);
    if (args->slices && args->view_given)
        return usage_error(app, err, "--slices or --view, not both");
    if (args->decimals && !ends_with(args->out, "txt"))
        return usage_error(app, err, "--decimals is for .txt, not for %s", args->out);
    if (args->voxels && !ends_with(args->out, "h5") && !ends_with(args->out, "hdf5"))
        return usage_error(app, err, "--voxels is for .h5, not for %s", args->out);
    return out_check(app, args->out, "nrrd|nii|nii.gz|txt|stl|ply|png|csv|mcap|h5|hdf5", err);
}

ost_status cmd_export(app_state *app, int argc, char **argv, ost_error *err)
{
    export_args args = {0};
    target_options *t = &args.target;
    const operand operands[] = {{"BONE", &args.bone, "which bone?"}, {0}};
    const option options[] = {
        {.name = "out", .kind = OPTION_TEXT, .out = &args.out, .value = "FILE", .required = true,
         .help = "voxels: .nrrd, .nii, .nii.gz, .txt; surface: .stl, .ply;\npicture: .png; a session: .csv, .mcap, .h5"},
        {.name = "threshold", .kind = OPTION_INTEGER, .out = &args.threshold, .given = &args.threshold_given, .value = "HU", .min = 1, .max = 32767,
         .help = "bone at this density or more (default: the bone's own, else 120)"},
        {.name = "slices", .kind = OPTION_FLAG, .out = &args.slices, .help = ".png: axial, coronal and sagittal slice (default)"},
        {.name = "view", .kind = OPTION_CHOICE, .out = &args.view, .given = &args.view_given, .value = VIEWS, .help = ".png: the surface from there"},
        {.name = "before", .kind = OPTION_TEXT, .out = &args.before, .value = "BONE", .help = ".png: colour what was removed since this bone"},
        {.name = "at", .kind = OPTION_POINT, .out = &t->at, .given = &t->at_given, .value = "X,Y,Z", .help = ".png: slices through, or view around, this point"},
        {.name = "axis", .kind = OPTION_VECTOR, .out = t->axis, .given = &t->axis_given, .value = "X,Y,Z",
         .help = "of --view glenoid: the direction into the bone"},
        {.name = "side", .kind = OPTION_CHOICE, .out = &t->side, .given = &t->side_given, .value = "left|right",
         .help = "of the body (default: the file's, else the axis determines it)"},
        {.name = "extent", .kind = OPTION_LENGTH, .out = &args.extent, .value = "MM", .help = "height of a view around a point (default: 60)"},
        {.name = "size", .kind = OPTION_INTEGER, .out = &args.size, .value = "PIXELS", .min = 16, .max = 8192,
         .help = ".png: side of a view (default: 800) or of a slice (default: 480)"},
        {.name = "decimals", .kind = OPTION_INTEGER, .out = &args.decimals, .value = "N", .min = 1, .max = 9,
         .help = "digits after the point in a .txt (default: as many as it takes)"},
        {.name = "voxels", .kind = OPTION_FLAG, .out = &args.voxels,
         .help = "a session to .h5: also which voxels went, by doing it again"},
        {.name = "compress", .kind = OPTION_FLAG, .out = &args.compress, .help = "gzip a .nrrd"},
        {.name = NULL}};
    const usage_text usage = {
        .synopsis = "BONE --out FILE [options]",
        .about = "Writes a bone for other programs or for the eye: its voxels, its surface or a\n"
                 "picture, by the name of FILE. BONE may be a CT or a tool grid as well; a session\n"
                 "becomes a table, or messages and arrays for other programs.",
        .operands = operands,
        .options = options,
        .notes = "Lengths are in millimetres, in the bone's frame (LPS). A surface is closed. A text is\n"
                 "taken as the bone that osteon import makes of it.",
        .example = "  osteon export reamed.nrrd --out reamed.stl\n"
                   "  osteon export reamed.nrrd --before scapula.nrrd --view glenoid --out reamed.png\n"
                   "  osteon export today.session --out today.mcap",
    };
    ost_status status;
    if (!options_parse(app, &usage, argc, argv, &status, err) || (status = check_args(app, &args, err)) != OST_OK)
        return status;
    ost_digest file;
    if (ends_with(args.out, "csv") || ends_with(args.out, "mcap") || ends_with(args.out, "h5") || ends_with(args.out, "hdf5")) {
        status = export_session(app, args.bone, args.out, args.voxels, err);
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
        if (ends_with(args.out, "stl") || ends_with(args.out, "ply"))
            status = export_surface(app, &args, &in, err);
        else if (ends_with(args.out, "png"))
            status = export_picture(app, &args, &in, err);
        else
            status = export_volume(app, &args, &in, err);
    }
    if (status == OST_OK && (status = file_digest(args.out, &file, err)) == OST_OK)
        put_digest(app->result, "file_sha256", &file);
    ost_volume_free(&in.volume);
    return status;
}
