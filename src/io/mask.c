/* SPDX-License-Identifier: Apache-2.0 */
#include "core/conditions.h"

#include "io/mask.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/integer.h"
#include "io/label_names.h"

enum { VALUES = 65536, NAMED = 12 };

/* The position of a label map in the grid of a CT: voxel v of the CT is voxel v - `at` of the label map. */
typedef struct placed {
    int64_t at[3];
    bool is_equal; /* true if both grids have the same origin and size */
} placed;

static bool differ(ost_pm a, ost_pm b, ost_pm spacing)
{
    const ost_pm d = a > b ? a - b : b - a;
    return d > spacing / 10;
}

/*
 * Finds the position of the label map in the grid of the CT. On each axis, the first and the last voxel of the label
 * map must be within a tenth of a voxel of the CT's lattice. One of the two grids must contain the other.
 */
static ost_status place(const char *path, const char *mask, const ost_geometry *g, const ost_geometry *m, placed *out,
                        ost_error *err)
{
    const ost_pm s[3] = {g->spacing.x, g->spacing.y, g->spacing.z}, t[3] = {m->spacing.x, m->spacing.y, m->spacing.z},
                 o[3] = {g->origin.x, g->origin.y, g->origin.z}, p[3] = {m->origin.x, m->origin.y, m->origin.z};
    const int32_t n[3] = {g->dims.x, g->dims.y, g->dims.z}, k[3] = {m->dims.x, m->dims.y, m->dims.z};
    bool inside = true, around = true;
    for (int a = 0; a < 3; a++) {
        const int64_t at = ost_rhe_div(p[a] - o[a], s[a]);
        if (differ(o[a] + at * s[a], p[a], s[a]) ||
            differ(o[a] + (at + k[a] - 1) * s[a], p[a] + (k[a] - 1) * t[a], s[a]))
            return ost_fail(
                err, OST_ERR_INPUT,
                "%s: its grid does not align with %s: along %c its voxels are %.9g mm apart from %.9g mm on; expected "
                "%.9g mm apart from %.9g mm on, or a part of that grid", mask, path, "xyz"[a], ost_pm_to_mm(t[a]),
                ost_pm_to_mm(p[a]), ost_pm_to_mm(s[a]), ost_pm_to_mm(o[a]));
        out->at[a] = at;
        inside = inside && at >= 0 && at + k[a] <= n[a];
        around = around && at <= 0 && at + k[a] >= n[a];
    }
    out->is_equal = inside && around;
    if (inside || around)
        return OST_OK;
    return ost_fail(err, OST_ERR_INPUT, "%s: %d x %d x %d voxels that are neither a part of the %d x %d x %d voxels of "
                    "%s nor contain them", mask, (int)k[0], (int)k[1], (int)k[2], (int)n[0], (int)n[1], (int)n[2],
                    path);
}

/* Extends or crops the label map to the grid of the CT. Voxels outside the original label map get the label 0. */
static ost_status move(const char *mask, const ost_geometry *g, const placed *where, ost_volume *labels, ost_error *err)
{
    const ost_dims n = g->dims, k = labels->geometry.dims;
    const int64_t *at = where->at, from = at[0] > 0 ? at[0] : 0, to = at[0] + k.x < n.x ? at[0] + k.x : n.x;
    ost_volume out;
    const ost_status status = ost_volume_init(&out, g, err);
    if (status != OST_OK)
        return ost_fail_context(err, "%s", mask);
    for (int64_t z = 0; z < n.z; z++)
        for (int64_t y = 0; y < n.y; y++)
            if (z >= at[2] && z < at[2] + k.z && y >= at[1] && y < at[1] + k.y)
                memcpy(out.voxels + from + n.x * (y + n.y * z),
                       labels->voxels + (from - at[0]) + k.x * (y - at[1] + k.y * (z - at[2])),
                       (size_t)(to - from) * sizeof *out.voxels);
    ost_volume_free(labels);
    *labels = out;
    return OST_OK;
}

static ost_status none_selected(const char *mask, const bool *present, ost_error *err)
{
    char list[160];
    size_t used = 0;
    int named = 0;
    list[0] = 0;
    for (int v = 0; v < VALUES; v++) {
        if (!present[v] || v == -INT16_MIN)
            continue;
        if (named++ < NAMED)
            used += (size_t)snprintf(list + used, sizeof list - used, "%s%d", named > 1 ? ", " : "", v + INT16_MIN);
    }
    return named ? ost_fail(err, OST_ERR_INPUT, "%s: no voxel has a selected label; its labels are %s%s", mask, list,
                            named > NAMED ? ", ..." : "")
                 : ost_fail(err, OST_ERR_INPUT, "%s: every voxel has label 0, so that no bone is selected", mask);
}

/* The selected labels. An empty selection selects all labels except 0. */
typedef struct selection {
    const int16_t *labels;
    int count;
    bool fill;
} selection;

static ost_status apply(const char *mask, const selection *chosen, const int16_t *labels, int32_t threshold,
                        ost_volume *volume, ost_mask_report *report, ost_error *err)
{
    const size_t count = (size_t)ost_dims_count(volume->geometry.dims);
    bool *selected = calloc(2 * VALUES, sizeof *selected), *present = selected ? selected + VALUES : NULL;
    ost_status status = OST_OK;
    if (!selected)
        return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for a table of labels", mask);
    for (int v = 0; v < VALUES && !chosen->count; v++)
        selected[v] = v != -INT16_MIN;
    for (int i = 0; i < chosen->count; i++)
        selected[chosen->labels[i] - INT16_MIN] = true;
    for (size_t i = 0; i < count; i++) {
        const int label = labels[i] - INT16_MIN;
        present[label] = true;
        report->selected += selected[label];
    }
    if (!report->selected)
        status = none_selected(mask, present, err);
    for (size_t i = 0; i < count && status == OST_OK; i++) {
        const bool in = selected[labels[i] - INT16_MIN], bone = volume->voxels[i] >= threshold;
        if (!in && bone) {
            volume->voxels[i] = 0;
            report->removed++;
        } else if (in && !bone && chosen->fill) {
            volume->voxels[i] = (int16_t)threshold;
            report->filled++;
        }
    }
    free(selected);
    return status;
}

/* Looks up the names in options->mask_names, and stores their label values in `out`. */
static ost_status find_names(const ost_import_options *options, int16_t *out, ost_error *err)
{
    ost_label_names names = {.count = 0};
    ost_status status = OST_OK;
    if (!options->mask_name_count)
        return OST_OK;
    if (options->mask_names_file)
        status = ost_label_names_add_file(&names, options->mask_names_file, err);
    else
        status = ost_label_names_read(options->mask, options->volume.form, &names, err);
    for (int i = 0; i < options->mask_name_count && status == OST_OK; i++)
        status = ost_label_names_find(&names, options->mask, options->mask_names[i], &out[i], err);
    ost_label_names_free(&names);
    return status;
}

static ost_status set_facts(const ost_import_options *options, const selection *chosen, ost_meta *meta, ost_error *err)
{
    char text[OST_META_VALUE] = "all";
    size_t used = 0;
    for (int i = 0; i < chosen->count && used < sizeof text; i++)
        used += (size_t)snprintf(text + used, sizeof text - used, "%s%d", i ? "," : "", chosen->labels[i]);
    ost_status status = ost_meta_set(meta, "mask_labels", text, err);
    used = 0;
    for (int i = 0; i < options->mask_name_count && used < sizeof text; i++)
        used += (size_t)snprintf(text + used, sizeof text - used, "%s%s", i ? "," : "", options->mask_names[i]);
    if (status == OST_OK && options->mask_name_count)
        status = ost_meta_set(meta, "mask_names", text, err);
    return status == OST_OK && options->mask_fill ? ost_meta_set(meta, "mask_fill", "true", err) : status;
}

ost_status ost_mask_refuse_text(const char *path, ost_error *err)
{
    return ost_fail(err, OST_ERR_USAGE, "%s: is a text; a mask needs a CT as NRRD, NIfTI or MetaImage, and so does the "
                    "selection of a bone", path);
}

static ost_status apply_mask(const char *path, const ost_import_options *options, int32_t threshold,
                             ost_volume *volume, ost_import_result *result, ost_error *err)
{
    const int numbers = options->mask_label_count, names = options->mask_name_count;
    int16_t list[2 * OST_MASK_LABELS_MAX];
    ost_volume labels = {0};
    ost_volume_report read;
    if (numbers < 0 || numbers > OST_MASK_LABELS_MAX || names < 0 || names > OST_MASK_LABELS_MAX)
        return ost_fail(err, OST_ERR_RANGE, "%s: %d labels and %d names of a mask; at most %d of each", path, numbers,
                        names, OST_MASK_LABELS_MAX);
    memcpy(list, options->mask_labels, (size_t)numbers * sizeof *list);
    const selection chosen = {list, numbers + names, options->mask_fill};
    ost_volume_options how = options->volume;
    how.series = NULL; /* `series`, `even_slices` and `untilt` apply only to the images of the CT */
    how.even_slices = how.untilt = false;
    ost_status status = find_names(options, list + numbers, err);
    if (status == OST_OK)
        status = ost_volume_read(options->mask, &how, &labels, &read, err);
    if (status == OST_OK && (read.rounded_values || read.nan_values))
        status = ost_fail(err, OST_ERR_INPUT, "%s: is not a label map: %llu values are not integers", options->mask,
                          (unsigned long long)(read.rounded_values + read.nan_values));
    placed where = {.is_equal = true};
    if (status == OST_OK)
        status = place(path, options->mask, &volume->geometry, &labels.geometry, &where, err);
    if (status == OST_OK && !where.is_equal)
        status = move(options->mask, &volume->geometry, &where, &labels, err);
    if (status == OST_OK)
        status = apply(options->mask, &chosen, labels.voxels, threshold, volume, &result->mask, err);
    if (status == OST_OK)
        status = set_facts(options, &chosen, &result->meta, err);
    ost_volume_free(&labels);
    return status;
}

static ost_status apply_labels(const char *path, const ost_import_options *options, int32_t threshold,
                               ost_volume *volume, ost_import_result *result, ost_error *err)
{
    const ost_volume ct = {.geometry = result->rect, .meta = result->meta, .voxels = volume->voxels};
    const ost_dims d = ct.geometry.dims;
    const selection all = {.fill = true};
    ost_volume labels = {0};
    ost_status status = options->labels(options->labels_user, &ct, threshold, &labels, err);
    if (status == OST_OK && (!labels.voxels || labels.geometry.dims.x != d.x || labels.geometry.dims.y != d.y ||
                             labels.geometry.dims.z != d.z))
        status = ost_fail(err, OST_ERR_USAGE, "the function `labels` made no label map on the grid of the CT");
    if (status == OST_OK)
        status = apply("the label map", &all, labels.voxels, threshold, volume, &result->labels, err);
    for (int i = 0; i < labels.meta.count && status == OST_OK; i++)
        status = ost_meta_set(&result->meta, labels.meta.entry[i].key, labels.meta.entry[i].value, err);
    if (status != OST_OK)
        (void)ost_fail_context(err, "%s", path);
    ost_volume_free(&labels);
    return status;
}

ost_status ost_mask_apply(const char *path, const ost_import_options *options, int32_t threshold, ost_volume *volume,
                          ost_import_result *result, ost_error *err)
{
    ost_status status = OST_OK;
    if (options->mask)
        status = apply_mask(path, options, threshold, volume, result, err);
    if (status == OST_OK && options->labels)
        status = apply_labels(path, options, threshold, volume, result, err);
    return status;
}
