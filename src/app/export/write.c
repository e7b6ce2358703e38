/* SPDX-License-Identifier: Apache-2.0 */
#include "app/export/export.h"

#include "app/common/print.h"
#include "app/common/progress.h"
#include "app/common/result.h"
#include "app/export/parts.h"
#include "app/replay/session_info.h"

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

static ost_status export_loaded(const app_state *app, const export_args *args, ost_error *err)
{
    loaded_volume in;
    ost_status status = load_volume(app, args->bone, &in, err);
    if (status == OST_OK) {
        if (args->threshold_given)
            in.threshold = (int32_t)args->threshold;
        put_text(app->result, "in", args->bone);
        put_text(app->result, "out", args->out);
        put_dims(app->result, "dims", in.volume.geometry.dims);
        put_mm3(app->result, "spacing_mm", in.volume.geometry.spacing);
        if (args->before && !ends_with(args->out, "png"))
            status = take_removed(app, args, &in, err);
        if (status == OST_OK && args->labels)
            status = export_labels(args->bone, &in, err);
        if (status == OST_OK)
            status = write_out(app, args, &in, err);
    }
    ost_volume_free(&in.volume);
    return status;
}

ost_status export_file(const app_state *app, const export_args *args, ost_error *err)
{
    ost_digest file;
    ost_status status = ends_with(args->out, "csv") ? export_session(app, args->bone, args->out, err)
                                                    : export_loaded(app, args, err);
    if (status == OST_OK && (status = file_digest(args->out, &file, err)) == OST_OK)
        put_digest(app->result, "file_sha256", &file);
    return status;
}
