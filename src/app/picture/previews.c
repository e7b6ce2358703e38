/* SPDX-License-Identifier: Apache-2.0 */
#include "app/picture/previews.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app/common/print.h"
#include "app/common/progress.h"
#include "app/picture/view.h"
#include "render/points/palette.h"

ost_status preview_check(app_state *app, const char *path, ost_error *err)
{
    if (!path)
        return OST_OK;
    app->warnings = json_array();
    ost_picture pixel;
    uint8_t *bytes = NULL;
    size_t size;
    ost_status status = out_check(app, path, "png", err);
    if (status == OST_OK)
        status = ost_picture_init(&pixel, 1, 1, err);
    if (status != OST_OK)
        return status;
    status = ost_picture_encode_png(&pixel, &bytes, &size, err); /* encoding fails if osteon was built without libpng */
    free(bytes);
    ost_picture_free(&pixel);
    return status;
}

static double cm3(const ost_geometry *g, uint64_t voxels)
{
    return (double)voxels * 1e-3 * ost_pm_to_mm(g->spacing.x) * ost_pm_to_mm(g->spacing.y) *
           ost_pm_to_mm(g->spacing.z);
}

/* -------------------------------------------------------------------- rows */

/* Adds rows that describe a DICOM series. No row identifies the patient. */
static void add_series(chart_table *t, const ost_dicom_report *d)
{
    char n[FORMAT_TEXT], m[OST_PM_TEXT], k[OST_PM_TEXT];
    chart_add(t, "series", "%s slices%s%s, thickness %s%s; greatest distance %s mm%s%s", format_count(n, d->images),
              d->modality[0] ? " of " : "", d->modality, d->thickness ? ost_pm_format(d->thickness, m) : "not stated",
              d->thickness ? " mm" : "", ost_pm_format(d->largest_gap, k), d->lossy ? "; compressed with loss" : "",
              d->no_rescale ? "; no rescale stated" : "");
    if (d->other_files || d->localizers || d->doubled)
        chart_add(t, "ignored", "%lld other files, %lld localizers, %lld doubled slices", (long long)d->other_files,
                  (long long)d->localizers, (long long)d->doubled);
    if (d->interpolated || d->sheared)
        chart_add(t, "changed", "%lld slices interpolated; slices sheared back by %s mm", (long long)d->interpolated,
                  ost_pm_format(d->sheared, m));
    if (d->padded)
        chart_add(t, "padding", "%s pixels, which became air", format_count(n, (int64_t)d->padded));
}

/* Appends a description of how a file was read: its type, its orientation, and the changes that the reader made. */
static void add_reading(chart_table *t, ost_file_kind kind, const ost_volume_report *r, const ost_meta *meta)
{
    char n[FORMAT_TEXT];
    const char *stated = ost_meta_get(meta, OST_META_ORIENTATION);
    chart_add(t, "file", "%s, %s, %s%s", load_kind_name(kind), r->type, r->encoding, r->labels ? ", a label map" : "");
    if (r->assumed && (!stated || strcmp(stated, "assumed LPS") == 0))
        chart_add(t, "orientation", "not stated in the file, LPS assumed: left may be right, and front may be back")
            ->warning = true;
    else
        chart_add(t, "orientation", "%s%s", r->orientation[0] ? r->orientation : stated ? stated : "LPS",
                 r->reoriented ? ", axes turned to LPS" : "");
    if (r->dicom.images)
        add_series(t, &r->dicom);
    if (r->resampled)
        chart_add(t, "resampled", "the grid is tilted; each voxel has the value of the nearest one on straight axes");
    if (r->rounded_values)
        chart_add(t, "rounded", "%s densities that were not whole numbers",
                 format_count(n, (int64_t)r->rounded_values));
    if (r->clamped_values)
        chart_add(t, "clamped", "%s densities beyond -32768 to 32767 HU",
                 format_count(n, (int64_t)r->clamped_values));
}

static void add_text_reading(chart_table *t, const ost_import_result *r)
{
    char n[FORMAT_TEXT], m[FORMAT_TEXT];
    const bool found = r->spacing_inferred[0] || r->spacing_inferred[1] || r->spacing_inferred[2];
    chart_add(t, "file", "text, %s samples%s", format_count(n, (int64_t)r->scatter.samples),
             found ? ", spacing found from their positions" : "");
    chart_add(t, "orientation", "as in the text: x to the left, y to the back, z to the head");
    if (r->scatter.duplicates || r->scatter.off_lattice)
        chart_add(t, "samples", "%s voxels given more than once, %s positions off the lattice",
                 format_count(n, (int64_t)r->scatter.duplicates), format_count(m, (int64_t)r->scatter.off_lattice));
    if (r->rounded_positions)
        chart_add(t, "rounded", "%s positions", format_count(n, (int64_t)r->rounded_positions));
}

/* Appends one row with all facts whose keys begin with `prefix`. Returns true if there is such a fact. */
static bool add_facts(chart_table *t, const char *row, const ost_meta *meta, const char *prefix)
{
    char text[CHART_TEXT] = "";
    size_t length = 0;
    for (int i = 0; i < meta->count; i++) {
        const char *key = meta->entry[i].key;
        if (strncmp(key, prefix, strlen(prefix)) != 0)
            continue;
        const int n = snprintf(text + length, sizeof text - length, "%s%s %s", length ? "; " : "",
                               key + strlen(prefix), meta->entry[i].value);
        length += n > 0 ? (size_t)n : 0;
        if (length >= sizeof text)
            break;
    }
    for (char *c = text; *c; c++)
        *c = *c == '_' ? ' ' : *c;
    if (text[0])
        chart_add(t, row, "%s", text);
    return text[0] != '\0';
}

static void add_patient(chart_table *t, const ost_meta *meta)
{
    const char *at = ost_meta_get(meta, OST_META_GLENOID_AT), *axis = ost_meta_get(meta, OST_META_GLENOID_AXIS),
               *side = ost_meta_get(meta, OST_META_SIDE);
    if (!at && !axis && !side) {
        chart_add(t, "glenoid", "not set; osteon import --landmarks or --at sets it");
        return;
    }
    chart_add(t, "glenoid", "%s%s%s%s%s%s", side ? side : "side not set", at ? ", centre " : "", at ? at : "",
             at ? " mm" : "", axis ? ", axis " : "", axis ? axis : "");
}

/* ------------------------------------------------------------------ import */

static void add_mask(chart_table *t, const char *key, const ost_mask_report *m)
{
    char a[FORMAT_TEXT], b[FORMAT_TEXT], c[FORMAT_TEXT];
    if (m->selected)
        chart_add(t, key, "%s voxels selected, %s dense voxels elsewhere removed, %s raised to the threshold",
                  format_count(a, (int64_t)m->selected), format_count(b, (int64_t)m->removed),
                  format_count(c, (int64_t)m->filled));
}

/* Appends the rows of an import. Returns true if only a part of the dense voxels was selected. */
static bool add_import(chart_table *t, const ost_import_result *r, const ost_bone_info *info)
{
    char a[FORMAT_TEXT];
    if (r->kind == OST_FILE_CT_TEXT)
        add_text_reading(t, r);
    else if (r->kind == OST_FILE_UNKNOWN)
        chart_add(t, "file", "%s", load_kind_name(r->kind));
    else
        add_reading(t, r->kind, &r->volume, &r->meta);
    preview_add_grid(t, "CT", &r->rect);
    preview_add_grid(t, "bone", &r->cubic);
    chart_add(t, "resampling", "%s", ost_resample_name(r->resample));
    chart_add(t, "threshold", "%d HU", info->threshold);
    add_mask(t, "mask", &r->mask);
    add_mask(t, "selection", &r->labels);
    bool selected = add_facts(t, "mask", &r->meta, "mask_");
    selected |= add_facts(t, "segmentation", &r->meta, "segment_");
    chart_add(t, "", "bone: %s voxels, %.2f cm\302\263", format_count(a, info->active_voxels),
              cm3(&r->cubic, (uint64_t)info->active_voxels))
        ->colour = ost_label_colour(1);
    if (selected)
        chart_add(t, "", "%d HU or more, but not selected", info->threshold)->colour = ost_label_colour(0);
    add_patient(t, &r->meta);
    return selected;
}

/* Reads the CT again for its picture. If the CT is a text file, *out has no voxels. */
static ost_status read_ct(const app_state *app, const char *name, const ct_options *ct, const ost_import_result *r,
                          ost_volume *out, ost_error *err)
{
    ost_import_options options;
    loaded_volume loaded;
    ost_status status = OST_OK;
    if (builtin_name(name)) {
        status = load_volume(app, name, &loaded, err);
        *out = loaded.volume;
    } else if (r->kind != OST_FILE_CT_TEXT) {
        status = load_import_options(app, ct, false, &options, err);
        options.volume.progress = progress_show;
        if (status == OST_OK)
            status = ost_volume_read(name, &options.volume, out, NULL, err);
        /* --spacing overrides the spacing in the file */
        out->geometry.spacing = status == OST_OK ? r->rect.spacing : out->geometry.spacing;
    }
    return status;
}

ost_status preview_import(const app_state *app, const char *path, const char *name, const char *out,
                          const ct_options *ct, const ost_bone *bone, const ost_import_result *result,
                          ost_error *err)
{
    ost_volume densities = {0}, parts = {0};
    ost_bone_info info;
    chart_table table = {.count = 0};
    ost_status status = ost_bone_info_get(bone, &info, err);
    if (status == OST_OK)
        status = read_ct(app, name, ct, result, &densities, err);
    if (status == OST_OK)
        status = bone_to_volume(bone, &result->meta, &parts, err);
    if (status == OST_OK) {
        progress_show(NULL, "drawing", 0);
        const bool selected = add_import(&table, result, &info);
        preview_add_warnings(app, name, &table);
        const preview_input p = {.out = out,
                           .ct = densities.voxels ? &densities : NULL,
                           .parts = &parts,
                           .threshold = info.threshold,
                           .nearest = result->resample == OST_RESAMPLE_NEAREST,
                           /* The resampling rule of the thesis displaces the bone relative to the CT. Voxels at the
                              bone's border would then be coloured although they belong to the bone. */
                           .left_out = selected && result->resample != OST_RESAMPLE_THESIS,
                           .unoriented = !view_oriented(&result->meta),
                           .meta = &result->meta,
                           .threads = (int)app->threads,
                           .table = &table};
        status = preview_write(&p, path, err);
    }
    ost_volume_free(&parts);
    ost_volume_free(&densities);
    return status;
}

/* ----------------------------------------------------------------- segment */

static uint64_t count_left_out(const preview_labels *in)
{
    uint64_t n = 0;
    for (int64_t i = 0; i < ost_dims_count(in->ct->geometry.dims); i++)
        n += in->labels->voxels[i] == 0 && in->ct->voxels[i] >= in->threshold;
    return n;
}

/* Appends one row for each label that has its own colour, and one row for all other labels. */
static void add_labels(chart_table *t, const preview_labels *in)
{
    const ost_geometry *g = &in->labels->geometry;
    uint64_t others = 0;
    for (size_t k = 0; k < in->count; k++) {
        const ost_segment *s = &in->segments[k];
        if (k + 1 >= OST_LABELS - 1) {
            others += s->voxels + s->filled;
            continue;
        }
        char filled[FORMAT_TEXT] = "";
        if (s->filled)
            snprintf(filled, sizeof filled, ", of which %.2f cm\302\263 are filled holes", cm3(g, s->filled));
        chart_add(t, "", "label %zu: %.2f cm\302\263%s", k + 1, cm3(g, s->voxels + s->filled), filled)->colour =
            ost_label_colour((int)k + 1);
    }
    if (others)
        chart_add(t, "", "labels %d to %zu: %.2f cm\302\263", OST_LABELS - 1, in->count, cm3(g, others))->colour =
            ost_label_colour(OST_LABELS - 1);
    chart_add(t, "", "no label: %.2f cm\302\263 of %d HU or more, cut away, not selected or too small",
             cm3(g, count_left_out(in)), in->threshold)
        ->colour = ost_label_colour(0);
}

ost_status preview_segment(const app_state *app, const char *path, const preview_labels *in, ost_error *err)
{
    progress_show(NULL, "drawing", 0);
    chart_table table = {.count = 0};
    ost_file_kind kind;
    ost_status status = ost_file_kind_find(in->name, &kind, err);
    if (status != OST_OK)
        return status;
    add_reading(&table, kind, in->report, &in->ct->meta);
    preview_add_grid(&table, "CT", &in->ct->geometry);
    add_facts(&table, "segmentation", &in->labels->meta, "segment_");
    add_labels(&table, in);
    add_patient(&table, &in->labels->meta);
    preview_add_warnings(app, in->name, &table);
    const preview_input p = {.out = in->out,
                       .ct = in->ct,
                       .parts = in->labels,
                       .labels = true,
                       .threshold = in->threshold,
                       .left_out = true,
                       .unoriented = !view_oriented(&in->ct->meta),
                       .meta = &in->labels->meta,
                       .at_given = in->at_given,
                       .at = in->at,
                       .threads = (int)app->threads,
                       .table = &table};
    return preview_write(&p, path, err);
}
