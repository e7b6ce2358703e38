/* SPDX-License-Identifier: Apache-2.0 */
#include "app/input/load.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "app/common/all_cores.h"
#include "app/common/backend_choice.h"
#include "app/common/progress.h"
#include "app/common/print.h"
#include "io/outfile.h"
#include "app/input/mask_option.h"

enum { THRESHOLD = 120 }; /* the default of the thesis (AR-CHK-1) */

/* ------------------------------------------------------------------ names */

bool ends_with(const char *path, const char *end)
{
    size_t n = strlen(path), m = strlen(end);
    return n > m && path[n - m - 1] == '.' && strcmp(path + n - m, end) == 0;
}

static bool ends_with_one_of(const char *path, const char *ends)
{
    char end[16];
    for (;;) {
        size_t length = strcspn(ends, "|");
        snprintf(end, sizeof end, "%.*s", (int)length, ends);
        if (ends_with(path, end))
            return true;
        if (!ends[length])
            return false;
        ends += length + 1;
    }
}

ost_status out_check(app_state *app, const char *path, const char *ends, ost_error *err)
{
    struct stat st;
    if (strcmp(path, "-") == 0)
        return usage_error(app, err, "-: expected a format as well, such as -.%.*s for standard output",
                           (int)strcspn(ends, "|"), ends);
    if (ost_outfile_is_stdout(path) && app->json)
        return usage_error(app, err, "%s and --json both write standard output", path);
    if (ost_outfile_is_stdout(path) && isatty(STDOUT_FILENO))
        return usage_error(app, err, "%s: standard output is a terminal; expected a pipe or a file", path);
    if (ost_outfile_is_stdout(path) && app->to_stdout)
        return usage_error(app, err, "%s: another output already goes to standard output", path);
    app->to_stdout |= ost_outfile_is_stdout(path);
    const bool exists = stat(path, &st) == 0;
    /* A name that is too long is rejected here, because the error would otherwise occur after all work is done. */
    if (!exists && errno == ENAMETOOLONG)
        return ost_fail(err, OST_ERR_IO, "%s: cannot write: %s", path, strerror(errno));
    /* The name of a pipe or a device needs no extension if there is only one format. */
    const bool one_format = !strchr(ends, '|') || strcmp(ends, "html|htm") == 0;
    bool special = exists && !S_ISREG(st.st_mode) && !S_ISDIR(st.st_mode) && one_format;
    if (!special && !ends_with_one_of(path, ends)) {
        char spoken[OPTION_SPOKEN];
        return usage_error(app, err, "%s: the name must end in %s", path, spoken_list(spoken, ends, "."));
    }
    const char *slash = strrchr(path, '/');
    char folder[4096];
    snprintf(folder, sizeof folder, "%.*s", slash ? (int)(slash - path) + 1 : 1, slash ? path : ".");
    if (stat(folder, &st) != 0)
        return ost_fail(err, OST_ERR_IO, "%s: cannot write: %s", path, strerror(errno));
    return OST_OK;
}

const char *builtin_name(const char *name)
{
    return strncmp(name, "builtin:", 8) == 0 ? name + 8 : NULL;
}

const char *load_kind_name(ost_file_kind kind)
{
    switch (kind) {
    case OST_FILE_CT_TEXT: return "text";
    case OST_FILE_NRRD: return "NRRD";
    case OST_FILE_NIFTI: return "NIfTI";
    case OST_FILE_METAIMAGE: return "MetaImage";
    case OST_FILE_DICOM: return "DICOM";
    case OST_FILE_STACK: return "stack";
    case OST_FILE_MESH: return "mesh";
    case OST_FILE_PATH_CSV: return "path";
    case OST_FILE_SESSION: return "session";
    case OST_FILE_UNKNOWN: break;
    }
    return "built in";
}

/* ------------------------------------------------------------------ bones */

/* Parses the value of --crop, for example "0:128,0:128,20:60". */
static ost_status parse_crop(const app_state *app, const char *text, ost_voxel_box *out, ost_error *err)
{
    const char *p = text;
    for (int a = 0; a < 3; a++) {
        int32_t end[2];
        for (int e = 0; e < 2; e++) {
            int64_t value = 0;
            int digits = 0;
            for (; *p >= '0' && *p <= '9' && digits < 6; p++, digits++)
                value = value * 10 + (*p - '0');
            char after = e == 0 ? ':' : a < 2 ? ',' : '\0';
            if (!digits || *p != after)
                return usage_error(app, err, "--crop '%s': expected from:to,from:to,from:to in voxels", text);
            p += after != '\0';
            end[e] = (int32_t)value;
        }
        if (end[0] >= end[1])
            return usage_error(app, err, "--crop '%s': the range from %d to %d is empty", text, end[0], end[1]);
        out->lo[a] = end[0];
        out->hi[a] = end[1];
    }
    return OST_OK;
}

ost_status load_import_options(const app_state *app, const ct_options *ct, bool digests, ost_import_options *out,
                               ost_error *err)
{
    *out = (ost_import_options){
        .spacing = ct->spacing,
        .cubic = ct->cubic,
        .threshold = (int32_t)ct->threshold, /* 0 selects the threshold in the bone's file or, for a CT, 120 */
        .chunk_size = 16 << ct->chunk,
        .has_resample = ct->resample >= 0,
        .resample = ct->resample >= 0 ? (ost_resample)ct->resample : OST_RESAMPLE_LINEAR,
        .duplicates = (ost_duplicates)ct->duplicates,
        .volume = {.clamp = ct->clamp, .nan_as_air = ct->nan_as_air, .resample_oblique = ct->resample_oblique,
                   .stack_spacing = ct->spacing},
        .digests = digests,
        .progress = progress_show,
        .labels = ct->labels,
        .labels_user = ct->labels_user,
    };
    out->volume.form = (ost_nifti_form)ct->form;
    load_dicom_options(&ct->dicom, &out->volume);
    if (ct->orientation && strlen(ct->orientation) != 3)
        return usage_error(app, err, "--orientation '%s': expected three letters, such as LPS or RAS", ct->orientation);
    if (ct->orientation)
        memcpy(out->volume.orientation, ct->orientation, sizeof out->volume.orientation);
    if (ct->mask_fill && !ct->mask)
        return usage_error(app, err, "--mask-fill needs --mask");
    if (ct->mask_names && !ct->mask)
        return usage_error(app, err, "--mask-names needs --mask");
    if (ct->mask) {
        ost_status status = mask_option_parse(app, ct->mask, out, err);
        if (status != OST_OK)
            return status;
        out->mask_fill = ct->mask_fill;
        out->mask_names_file = ct->mask_names;
    }
    if (ct->crop) {
        out->crop = true;
        ost_status status = parse_crop(app, ct->crop, &out->crop_box, err);
        if (status != OST_OK)
            return status;
    }
    return OST_OK;
}

typedef struct generation {
    ost_phantom_kind kind;
    ost_volume *out;
    ost_status status;
    ost_error *err;
} generation;

static void generate(void *user)
{
    generation *g = user;
    g->status = ost_phantom_make(g->kind, &(ost_phantom_options){.progress = progress_show}, g->out, g->err);
}

static ost_status phantom_volume(const char *kind_name, ost_volume *out, ost_error *err)
{
    for (int k = 0; k < OST_PHANTOM_COUNT; k++)
        if (strcmp(kind_name, ost_phantom_name((ost_phantom_kind)k)) == 0) {
            generation g = {.kind = (ost_phantom_kind)k, .out = out, .err = err};
            all_cores_do(generate, &g);
            return g.status;
        }
    return ost_fail(err, OST_ERR_USAGE, "builtin:%s: unknown bone; see osteon phantom --help", kind_name);
}

static ost_status volume_to_bone(ost_backend *backend, const ost_volume *volume, const ost_import_options *options,
                                 ost_bone **out, ost_import_result *result, ost_error *err)
{
    ost_grid *rect = NULL, *cubic = NULL;
    const int32_t threshold = options->threshold ? options->threshold : THRESHOLD;
    ost_status status = ost_grid_create(backend, &volume->geometry, &rect, err);
    if (status == OST_OK)
        status = ost_grid_upload(rect, 0, volume->geometry.dims.z, volume->voxels, err);
    if (status == OST_OK)
        status = ost_rect_to_cubic(rect, options->cubic ? options->cubic : volume->geometry.spacing.x,
                                   options->resample, &cubic, err);
    if (status == OST_OK)
        status = ost_cubic_to_chunks(cubic, options->chunk_size, threshold, out, err);
    if (status == OST_OK) {
        *result = (ost_import_result){.kind = OST_FILE_UNKNOWN,
                                      .rect = volume->geometry,
                                      .cubic = *ost_grid_geometry(cubic),
                                      .meta = volume->meta,
                                      .resample = options->resample};
        char text[16];
        snprintf(text, sizeof text, "%d", threshold);
        status = ost_meta_set(&result->meta, OST_META_THRESHOLD, text, err);
        if (status == OST_OK)
            status = ost_meta_set(&result->meta, OST_META_RESAMPLE, ost_resample_name(options->resample), err);
    }
    ost_grid_free(cubic);
    ost_grid_free(rect);
    return status;
}

void load_warn_orientation(const app_state *app, const char *name, const ost_meta *meta)
{
    const char *fact = ost_meta_get(meta, OST_META_ORIENTATION);
    if (fact && strcmp(fact, "assumed LPS") == 0)
        warn(app,
             "%s: its orientation is assumed to be LPS: the CT does not state where its axes point, so left may be "
             "right and front may be "
             "back; import the CT with --orientation XYZ, such as LPS or RAS",
             name);
}

void load_dicom_options(const dicom_options *options, ost_volume_options *out)
{
    out->series = options->series;
    out->even_slices = options->even_slices;
    out->untilt = options->untilt;
}

void load_warn_dicom(const app_state *app, const char *name, const ost_dicom_report *r)
{
    char a[FORMAT_TEXT], b[FORMAT_TEXT], mm[OST_PM_TEXT];
    if (r->images == 0)
        return;
    if (r->modality[0] && strcmp(r->modality, "CT") != 0)
        warn(app, "%s: the modality is %s; densities are not in HU", name, r->modality);
    if (r->no_rescale)
        warn(app, "%s: states no RescaleSlope and RescaleIntercept; the stored values are used as densities", name);
    if (r->lossy)
        warn(app, "%s: the pixels were compressed with loss", name);
    if (r->localizers)
        warn(app, "%s: %s localizer image%s of the series %s ignored", name, format_count(a, r->localizers),
             r->localizers == 1 ? "" : "s", r->localizers == 1 ? "was" : "were");
    if (r->doubled)
        warn(app, "%s: %s doubled slice%s ignored", name, format_count(a, r->doubled),
             r->doubled == 1 ? " was" : "s were");
    if (r->interpolated)
        warn(app, "%s: slices were uneven: %s slice%s interpolated from %s; the largest gap is %s mm", name,
             format_count(a, r->interpolated), r->interpolated == 1 ? " was" : "s were", format_count(b, r->images),
             ost_pm_format(r->largest_gap, mm));
    if (r->sheared)
        warn(app, "%s: slices were sheared back by %s mm in all", name, ost_pm_format(r->sheared, mm));
}

void load_warn_import(const app_state *app, const char *name, const ost_import_result *r)
{
    char text[FORMAT_TEXT];
    const ost_scatter_report *s = &r->scatter;
    load_warn_orientation(app, name, &r->meta);
    if (s->off_lattice)
        warn(app,
             "%s: %s positions lie more than 1/8 of a voxel off the lattice; the worst, %.3f of a voxel, in line %lld",
             name, format_count(text, (int64_t)s->off_lattice), (double)s->worst_offset_ppm * 1e-6,
             (long long)s->worst_line);
    if (r->rounded_positions)
        warn(app, "%s: %s positions have more than nine decimals and were rounded to a picometre", name,
             format_count(text, (int64_t)r->rounded_positions));
    if (s->duplicates)
        warn(app, "%s: %s voxels are given more than once", name, format_count(text, (int64_t)s->duplicates));
    load_warn_dicom(app, name, &r->volume.dicom);
    if (r->volume.resampled)
        warn(app, "%s: the volume is tilted and was resampled onto straight axes (nearest voxel)", name);
    if (r->volume.rounded_values)
        warn(app, "%s: %s densities were not whole numbers and were rounded", name,
             format_count(text, (int64_t)r->volume.rounded_values));
    if (r->volume.nan_values)
        warn(app, "%s: %s voxel%s no value (NaN) and %s set to -1024 HU", name,
             format_count(text, (int64_t)r->volume.nan_values), r->volume.nan_values == 1 ? " had" : "s had",
             r->volume.nan_values == 1 ? "was" : "were");
    if (r->volume.clamped_values)
        warn(app, "%s: %s densit%s outside -32768 to 32767 and %s clamped", name,
             format_count(text, (int64_t)r->volume.clamped_values),
             r->volume.clamped_values == 1 ? "y was" : "ies were", r->volume.clamped_values == 1 ? "was" : "were");
}

ost_status load_bone(const app_state *app, ost_backend *backend, const char *name, const ct_options *ct, bool digests,
                     ost_bone **out, ost_import_result *result, ost_error *err)
{
    ost_import_options options;
    ost_status status = load_import_options(app, ct, digests, &options, err);
    if (status != OST_OK)
        return status;
    const char *kind = builtin_name(name);
    if (kind) {
        const dicom_options *d = &ct->dicom;
        if (ct->crop || ct->spacing.x || ct->orientation || ct->form || ct->mask || ct->labels || d->series ||
            d->even_slices || d->untilt)
            return usage_error(app, err, "--crop, --spacing, --orientation, --form, the options for DICOM, --mask and "
                               "options that select a bone need a file; write %s with osteon phantom first", name);
        ost_volume volume = {0};
        status = phantom_volume(kind, &volume, err);
        if (status == OST_OK)
            status = volume_to_bone(backend, &volume, &options, out, result, err);
        ost_volume_free(&volume);
    } else {
        status = ost_import(backend, name, &options, out, result, err);
    }
    progress_end();
    if (status == OST_OK)
        load_warn_import(app, name, result);
    return status;
}

ost_status bone_to_volume(const ost_bone *bone, const ost_meta *meta, ost_volume *out, ost_error *err)
{
    ost_bone_info info;
    ost_status status = ost_bone_info_get(bone, &info, err);
    if (status == OST_OK)
        status = ost_volume_init(out, &info.geometry, err);
    if (status != OST_OK)
        return status;
    if (meta)
        out->meta = *meta;
    status = ost_bone_download(bone, 0, info.geometry.dims.z, out->voxels, err);
    if (status != OST_OK)
        ost_volume_free(out);
    return status;
}

/* ---------------------------------------------------------------- volumes */

static ost_status load_tool_volume(const char *name, loaded_volume *out, ost_error *err)
{
    ost_tool_volume tool = {0};
    ost_status status = ost_tool_volume_read(name, &tool, err);
    if (status != OST_OK)
        return status;
    ost_pm s = tool.geometry.voxel;
    ost_geometry geometry = {
        .dims = tool.geometry.dims,
        .spacing = {s, s, s},
        .origin = {tool.geometry.corner.x + s / 2, tool.geometry.corner.y + s / 2, tool.geometry.corner.z + s / 2},
    };
    status = ost_volume_init(&out->volume, &geometry, err);
    if (status == OST_OK) {
        int64_t count = ost_dims_count(geometry.dims);
        for (int64_t v = 0; v < count; v++)
            out->volume.voxels[v] = tool.voxels[v];
        out->volume.meta = tool.meta;
        out->tool = tool.geometry;
        out->kind = LOAD_TOOL;
        out->threshold = 1;
    }
    ost_tool_volume_free(&tool);
    return status;
}

/* Returns the threshold that import stored in a bone's header, or the default if the value is
   missing or invalid. */
static int32_t threshold_of(const ost_meta *meta)
{
    const char *text = ost_meta_get(meta, OST_META_THRESHOLD);
    ost_decimal d;
    int64_t value;
    bool exact;
    if (text && ost_decimal_read(text, text + strlen(text), &d) == text + strlen(text) &&
        ost_decimal_scale(&d, 1, &value, &exact) && exact && value >= 1 && value <= 32767)
        return (int32_t)value;
    return THRESHOLD;
}

/* Loads a CT given as text. The CT is imported as a bone, because only ost_import reads this format. */
static ost_status load_text_volume(const app_state *app, const char *name, loaded_volume *out, ost_error *err)
{
    ost_backend *backend = NULL;
    ost_bone *bone = NULL;
    ost_import_result result;
    const ct_options ct = CT_OPTIONS_DEFAULT;
    ost_status status = backend_choose(app, &backend, err);
    if (status == OST_OK)
        status = load_bone(app, backend, name, &ct, false, &bone, &result, err);
    if (status == OST_OK)
        status = bone_to_volume(bone, &result.meta, &out->volume, err);
    ost_bone_free(bone);
    ost_backend_close(backend);
    out->kind = LOAD_BONE;
    out->threshold = THRESHOLD;
    return status;
}

ost_status loaded_to_bone(const app_state *app, const char *name, loaded_volume *v, ost_error *err)
{
    const ost_geometry *g = &v->volume.geometry;
    const ct_options ct = {.chunk = 1, .resample = -1, .threshold = v->threshold};
    ost_backend *backend = NULL;
    ost_bone *bone = NULL;
    ost_import_result result;
    ost_volume voxels = {0};
    if (v->kind != LOAD_CT || (g->spacing.x == g->spacing.y && g->spacing.x == g->spacing.z))
        return OST_OK;
    ost_status status = backend_choose(app, &backend, err);
    if (status == OST_OK)
        status = load_bone(app, backend, name, &ct, false, &bone, &result, err);
    if (status == OST_OK)
        status = bone_to_volume(bone, &result.meta, &voxels, err);
    if (status == OST_OK) {
        ost_volume_free(&v->volume);
        v->volume = voxels;
    }
    ost_bone_free(bone);
    ost_backend_close(backend);
    return status;
}

ost_status load_volume(const app_state *app, const char *name, loaded_volume *out, ost_error *err)
{
    *out = (loaded_volume){.kind = LOAD_CT, .threshold = THRESHOLD};
    const char *phantom = builtin_name(name);
    if (phantom)
        return phantom_volume(phantom, &out->volume, err);
    ost_file_kind kind;
    ost_status status = ost_file_kind_find(name, &kind, err);
    if (status != OST_OK)
        return status;
    if (kind == OST_FILE_CT_TEXT)
        return load_text_volume(app, name, out, err);
    if (kind != OST_FILE_NRRD && kind != OST_FILE_NIFTI && kind != OST_FILE_METAIMAGE && kind != OST_FILE_DICOM &&
        kind != OST_FILE_STACK)
        return ost_fail(err, OST_ERR_INPUT, "%s: no voxels; expected a CT, a bone or a tool grid", name);
    ost_meta meta = {0};
    ost_volume_report report = {0};
    if (kind != OST_FILE_DICOM)
        status = ost_volume_read_header(name, NULL, &meta, NULL, err);
    if (status != OST_OK)
        return status;
    const char *what = ost_meta_get(&meta, OST_META_KIND);
    if (what && strcmp(what, "tool") == 0)
        return load_tool_volume(name, out, err);
    status = ost_volume_read(name, &(ost_volume_options){.progress = progress_show}, &out->volume, &report, err);
    if (status == OST_OK) {
        load_warn_orientation(app, name, &out->volume.meta);
        load_warn_dicom(app, name, &report.dicom);
    }
    if (status == OST_OK && what && strcmp(what, "bone") == 0) {
        out->kind = LOAD_BONE;
        out->threshold = threshold_of(&out->volume.meta);
    }
    return status;
}
