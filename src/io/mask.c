/* SPDX-License-Identifier: Apache-2.0 */
#include "core/conditions.h"

#include "io/mask.h"

#include <stdio.h>
#include <stdlib.h>

enum { VALUES = 65536, NAMED = 12 };

static bool differ(ost_pm a, ost_pm b, ost_pm spacing)
{
    const ost_pm d = a > b ? a - b : b - a;
    return d > spacing / 10;
}

/* Checks that the first and the last voxels of both grids are at the same positions, to a tenth of a voxel. */
static ost_status check_grid(const char *path, const char *mask, const ost_geometry *g, const ost_geometry *m,
                             ost_error *err)
{
    if (g->dims.x != m->dims.x || g->dims.y != m->dims.y || g->dims.z != m->dims.z)
        return ost_fail(
            err, OST_ERR_INPUT, "%s: %d x %d x %d voxels; %s has %d x %d x %d, and a mask needs the CT's grid", mask,
            (int)m->dims.x, (int)m->dims.y, (int)m->dims.z, path, (int)g->dims.x, (int)g->dims.y, (int)g->dims.z);
    const ost_pm s[3] = {g->spacing.x, g->spacing.y, g->spacing.z}, t[3] = {m->spacing.x, m->spacing.y, m->spacing.z},
                 o[3] = {g->origin.x, g->origin.y, g->origin.z}, p[3] = {m->origin.x, m->origin.y, m->origin.z};
    const int32_t last[3] = {g->dims.x - 1, g->dims.y - 1, g->dims.z - 1};
    for (int a = 0; a < 3; a++)
        if (differ(o[a], p[a], s[a]) || differ(o[a] + last[a] * s[a], p[a] + last[a] * t[a], s[a]))
            return ost_fail(
                err, OST_ERR_INPUT,
                "%s: its voxels from %.9g mm on, %.9g mm apart along %c, are not those of %s (%.9g mm, %.9g mm)", mask,
                ost_pm_to_mm(p[a]), ost_pm_to_mm(t[a]), "xyz"[a], path, ost_pm_to_mm(o[a]), ost_pm_to_mm(s[a]));
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
    return named ? ost_fail(err, OST_ERR_INPUT, "%s: no voxel has such a label; its labels are %s%s", mask, list,
                            named > NAMED ? ", ..." : "")
                 : ost_fail(err, OST_ERR_INPUT, "%s: every voxel has label 0, so that no bone is selected", mask);
}

/* The labels that are selected; none selects all but 0. */
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

static ost_status set_facts(const ost_import_options *options, ost_meta *meta, ost_error *err)
{
    char text[OST_META_VALUE] = "all";
    size_t used = 0;
    for (int i = 0; i < options->mask_label_count && used < sizeof text; i++)
        used += (size_t)snprintf(text + used, sizeof text - used, "%s%d", i ? "," : "", options->mask_labels[i]);
    const ost_status status = ost_meta_set(meta, "mask_labels", text, err);
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
    const selection chosen = {options->mask_labels, options->mask_label_count, options->mask_fill};
    ost_volume labels = {0};
    ost_volume_report read;
    if (chosen.count < 0 || chosen.count > OST_MASK_LABELS_MAX)
        return ost_fail(err, OST_ERR_RANGE, "%s: %d labels of a mask; at most %d", path, chosen.count,
                        OST_MASK_LABELS_MAX);
    ost_volume_options how = options->volume;
    how.series = NULL; /* these options select images of the CT */
    how.even_slices = how.untilt = false;
    ost_status status = ost_volume_read(options->mask, &how, &labels, &read, err);
    if (status == OST_OK && read.rounded_values)
        status = ost_fail(err, OST_ERR_INPUT, "%s: is no label map: %llu values are no integers", options->mask,
                          (unsigned long long)read.rounded_values);
    if (status == OST_OK)
        status = check_grid(path, options->mask, &volume->geometry, &labels.geometry, err);
    if (status == OST_OK)
        status = apply(options->mask, &chosen, labels.voxels, threshold, volume, &result->mask, err);
    if (status == OST_OK)
        status = set_facts(options, &result->meta, err);
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
