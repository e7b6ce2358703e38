/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Implements `osteon phantom`: writes a generated CT.
 */
#include <string.h>

#include "app/input/load.h"
#include "app/common/progress.h"
#include "app/common/result.h"
#include "app/common/print.h"

static ost_status find_kind(const app_state *app, const char *name, ost_phantom_kind *out, ost_error *err)
{
    const char *names[OST_PHANTOM_COUNT];
    for (int k = 0; k < OST_PHANTOM_COUNT; k++) {
        names[k] = ost_phantom_name((ost_phantom_kind)k);
        if (strcmp(name, names[k]) == 0) {
            *out = (ost_phantom_kind)k;
            return OST_OK;
        }
    }
    const char *near = nearest_name(name, names, OST_PHANTOM_COUNT);
    if (near)
        return usage_error(app, err, "'%s' is not a phantom; did you mean %s?", name, near);
    return usage_error(app, err, "'%s' is not a phantom; expected scapula, glenoid, shoulder, trabecular, "
                       "trabecular2 or foam", name);
}

/* Reads the value of --scale. The factor is a parameter of the shape and may have up to nine decimal places. */
static ost_status take_scale(const app_state *app, const option_decimal *given, double *out, ost_error *err)
{
    int64_t billionths;
    if (!given->text)
        return OST_OK;
    if (!ost_decimal_scale(&given->value, 1000000000, &billionths, NULL) || billionths < 125000000 ||
        billionths > 8000000000)
        return usage_error(app, err, "--scale %s: must be from 0.125 to 8", given->text);
    *out = (double)billionths / 1e9;
    return OST_OK;
}

static void put_glenoid(const app_state *app, const ost_meta *meta)
{
    ost_glenoid glenoid;
    if (ost_glenoid_from_meta(meta, &glenoid, NULL) != OST_OK)
        return;
    char text[FORMAT_TEXT];
    put_mm3(app->result, "glenoid_at_mm", glenoid.at);
    put(app->result, "glenoid_axis", json_pack("[f,f,f]", glenoid.axis[0], glenoid.axis[1], glenoid.axis[2]));
    put_text(app->result, "side", glenoid.left ? "left" : "right");
    print_line(app, "  glenoid at %s, inward (%.3g, %.3g, %.3g), %s side", format_point(text, glenoid.at),
               glenoid.axis[0], glenoid.axis[1], glenoid.axis[2], glenoid.left ? "left" : "right");
}

ost_status cmd_phantom(app_state *app, int argc, char **argv, ost_error *err)
{
    const char *kind_name = NULL, *out = NULL;
    int64_t seed = 1, decimals = 0;
    ost_phantom_options make = {.progress = progress_show};
    option_decimal scale = {0};
    int side = 1;
    bool compress = false;
    const operand operands[] = {
        {"KIND", &kind_name, "no phantom named; expected scapula, glenoid, shoulder, trabecular, trabecular2 or foam"},
        {0}};
    const option options[] = {
        {.name = "out", .kind = OPTION_OUTPUT, .out = &out, .value = "FILE", .required = true,
         .help = "the CT: .txt, .nrrd, .nii or .nii.gz"},
        {.name = "seed", .kind = OPTION_INTEGER, .out = &seed, .value = "N", .min = 1, .max = INT64_MAX,
         .help = "seed of the generated bone (default: 1)"},
        {.name = "spacing", .kind = OPTION_LENGTHS, .out = &make.spacing, .value = "MM[,MM,MM]",
         .help = "voxel spacing (default: as in the thesis); the size of the bone does not change"},
        {.name = "scale", .kind = OPTION_DECIMAL, .out = &scale, .value = "FACTOR",
         .help = "factor of the bone's size, from 0.125 to 8 (default: 1)"},
        {.name = "side", .kind = OPTION_CHOICE, .out = &side, .value = "left|right",
         .help = "side of the body (default: right)"},
        {.name = "decimals", .kind = OPTION_INTEGER, .out = &decimals, .value = "N", .min = 1, .max = 9,
         .help = "digits after the decimal point in a .txt (default: as many as needed)"},
        COMPRESS_OPTION(compress),
        {.name = NULL}};
    const usage_text usage = {
        .synopsis = "KIND --out FILE [options]",
        .about = "Generates a CT of an artificial bone, for every command that needs a CT.\n\n"
                 "kinds, with the dimensions of the thesis\n"
                 "  scapula      256 x 234 x 201 at 0.47 x 0.47 x 1 mm, with a glenoid\n"
                 "  glenoid      49 x 81 x 41 at 0.47 x 0.47 x 1 mm\n"
                 "  shoulder     336 x 234 x 201 at 0.47 x 0.47 x 1 mm, a scapula and a humerus\n"
                 "               whose head touches the glenoid\n"
                 "  trabecular   156 x 156 x 313 at 0.032 mm\n"
                 "  trabecular2  314 x 316 x 360 at 0.032 mm\n"
                 "  foam         314 x 320 x 604 at 0.032 mm",
        .operands = operands,
        .options = options,
        .notes = "Lengths are in millimetres, densities in HU. The same seed gives the\n"
                 "same grid on every machine. The file contains the position of the glenoid, which\n"
                 "osteon ream uses.",
        .example = "  osteon phantom scapula --out scapula.nrrd",
    };
    ost_status status;
    if (!options_parse(app, &usage, argc, argv, &status, err))
        return status;
    ost_phantom_kind kind = OST_PHANTOM_SCAPULA;
    if ((status = find_kind(app, kind_name, &kind, err)) != OST_OK ||
        (status = take_scale(app, &scale, &make.scale, err)) != OST_OK ||
        (status = out_check(app, out, "txt|nrrd|nii|nii.gz", err)) != OST_OK)
        return status;
    if (decimals && !ends_with(out, "txt"))
        return usage_error(app, err, "--decimals needs a .txt file, not %s", out);
    make.seed = (uint64_t)seed;
    make.left = side == 0;

    ost_volume volume = {0};
    ost_digest digest;
    double start = now_ms();
    status = ost_phantom_make(kind, &make, &volume, err);
    double made_ms = now_ms() - start;
    const ost_write_options write = {.compress = compress, .text_decimals = (int)decimals,
                                     .progress = progress_show};
    if (status == OST_OK)
        status = ost_volume_write(out, &volume, &write, err);
    if (status == OST_OK)
        status = ost_digest_volume(OST_GRID_RECT, &volume, &digest, err);
    if (status == OST_OK) {
        char dims[FORMAT_TEXT], spacing[FORMAT_TEXT], time[FORMAT_TEXT];
        put_text(app->result, "kind", ost_phantom_name(kind));
        put_text(app->result, "out", out);
        put_dims(app->result, "dims", volume.geometry.dims);
        put_mm3(app->result, "spacing_mm", volume.geometry.spacing);
        put_mm3(app->result, "origin_mm", volume.geometry.origin);
        put_integer(app->result, "seed", seed);
        put_digest(app->result, "sha256", &digest);
        put_real(app->result, "time_ms", made_ms);
        print_line(app, "%s: a %s of %s voxels at %s, seed %lld, made in %s", out, ost_phantom_name(kind),
                   format_dims(dims, volume.geometry.dims), format_spacing(spacing, volume.geometry.spacing),
                   (long long)seed, format_time(time, made_ms));
        put_glenoid(app, &volume.meta);
    }
    ost_volume_free(&volume);
    return status;
}
