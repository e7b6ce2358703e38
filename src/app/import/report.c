/* SPDX-License-Identifier: Apache-2.0 */
#include "app/import/import.h"

#include "app/common/print.h"
#include "app/common/result.h"

void import_warn_size(const app_state *app, const char *name, const ost_import_result *r)
{
    const ost_geometry *g = &r->rect;
    const double size[3] = {g->dims.x * ost_pm_to_mm(g->spacing.x), g->dims.y * ost_pm_to_mm(g->spacing.y),
                            g->dims.z * ost_pm_to_mm(g->spacing.z)};
    double largest = size[0] > size[1] ? size[0] : size[1];
    char text[LOAD_UNITS_TEXT];
    largest = largest > size[2] ? largest : size[2];
    if ((largest >= 20 && largest <= 3000) || ost_meta_get(&r->meta, "phantom"))
        return;
    warn(app, "%s: the CT is %.3g mm across, too %s for a patient's bone%s", name, largest,
         largest < 20 ? "small" : "large", load_other_units(text, largest));
}

void import_put_result(const app_state *app, const ost_import_result *r, const ost_bone_info *info)
{
    json_t *o = app->result;
    put_text(o, "format", load_kind_name(r->kind));
    put_dims(o, "rect_dims", r->rect.dims);
    put_mm3(o, "rect_spacing_mm", r->rect.spacing);
    put(o, "spacing_inferred",
        json_pack("[b,b,b]", r->spacing_inferred[0], r->spacing_inferred[1], r->spacing_inferred[2]));
    put_dims(o, "cubic_dims", r->cubic.dims);
    put_mm(o, "cubic_spacing_mm", r->cubic.spacing.x);
    put_mm3(o, "origin_mm", r->cubic.origin);
    put_text(o, "resample", ost_resample_name(r->resample));
    put_integer(o, "threshold", info->threshold);
    put_integer(o, "chunk", info->chunk_size);
    put_dims(o, "chunk_dims", info->chunk_dims);
    put_integer(o, "chunks", info->chunks);
    put_integer(o, "active_chunks", info->active_chunks);
    put_integer(o, "active_voxels", info->active_voxels);
    put_integer(o, "chunk_bytes", info->chunk_bytes);
    if (r->kind == OST_FILE_CT_TEXT) {
        put_integer(o, "samples", (int64_t)r->scatter.samples);
        put_integer(o, "duplicates", (int64_t)r->scatter.duplicates);
        put_integer(o, "off_lattice", (int64_t)r->scatter.off_lattice);
        put_real(o, "worst_offset_voxels", (double)r->scatter.worst_offset_ppm * 1e-6);
        put_integer(o, "rounded_positions", (int64_t)r->rounded_positions);
    } else {
        put_text(o, "element_type", r->volume.type);
        put_text(o, "encoding", r->volume.encoding);
        put_text(o, "orientation", r->volume.orientation);
        put_bool(o, "orientation_assumed", r->volume.assumed);
        put_bool(o, "reoriented", r->volume.reoriented);
        put_bool(o, "resampled", r->volume.resampled);
        put_bool(o, "labels", r->volume.labels);
        put_integer(o, "rounded_values", (int64_t)r->volume.rounded_values);
        put_integer(o, "clamped_values", (int64_t)r->volume.clamped_values);
        put_integer(o, "nan_values", (int64_t)r->volume.nan_values);
        if (r->kind == OST_FILE_STACK)
            put(o, "pixel_mm", json_pack("[f,f]", r->volume.pixel_mm[0], r->volume.pixel_mm[1]));
    }
    if (r->kind == OST_FILE_DICOM)
        put_dicom_report(o, &r->volume.dicom);
    if (r->mask.selected) {
        put_integer(o, "mask_voxels", (int64_t)r->mask.selected);
        put_integer(o, "mask_removed", (int64_t)r->mask.removed);
        put_integer(o, "mask_filled", (int64_t)r->mask.filled);
    }
    if (r->labels.selected) {
        put_integer(o, "bone_voxels", (int64_t)r->labels.selected);
        put_integer(o, "bone_removed", (int64_t)r->labels.removed);
        put_integer(o, "bone_filled", (int64_t)r->labels.filled);
    }
    json_t *stages = json_array();
    for (int i = 0; i < r->stage_count; i++) {
        json_t *stage = json_object();
        put_text(stage, "name", r->stages[i].name);
        put_real(stage, "time_ms", r->stages[i].time_ms);
        if (r->stages[i].has_digest)
            put_digest(stage, "sha256", &r->stages[i].digest);
        append(stages, stage);
    }
    put(o, "stages", stages);
    put_meta(o, "meta", &r->meta);
}

void import_print_result(const app_state *app, const char *ct, const char *out, const ost_import_result *r,
                         const ost_bone_info *info)
{
    char a[FORMAT_TEXT], b[FORMAT_TEXT], c[FORMAT_TEXT], d[FORMAT_TEXT];
    bool found = r->spacing_inferred[0] || r->spacing_inferred[1] || r->spacing_inferred[2];
    print_line(app, "%s: %s, %s voxels at %s%s%s", ct, load_kind_name(r->kind), format_dims(a, r->rect.dims),
               format_spacing(b, r->rect.spacing), found ? " (spacing found from the positions)" : "",
               r->volume.reoriented ? " (axes turned to LPS)" : "");
    if (r->volume.pixel_mm[0] > 0 && r->volume.pixel_mm[1] > 0)
        print_line(app, "  its first slice states %.6g x %.6g mm per pixel, which is not used", r->volume.pixel_mm[0],
                   r->volume.pixel_mm[1]);
    const ost_dicom_report *dicom = &r->volume.dicom;
    const bool thick = dicom->thickness && dicom->thickness != r->rect.spacing.z;
    if (dicom->images)
        print_line(app, "  %s slices, %s%s", format_count(a, dicom->images), r->volume.encoding,
                   thick ? ", thickness differs from distance" : "");
    if (r->mask.selected)
        print_line(app, "  mask: %s voxels selected, %s dense voxels elsewhere removed, %s filled",
                   format_count(a, (int64_t)r->mask.selected), format_count(b, (int64_t)r->mask.removed),
                   format_count(c, (int64_t)r->mask.filled));
    if (r->labels.selected)
        print_line(app, "  bone: %s voxels selected, %s dense voxels elsewhere removed, %s filled",
                   format_count(a, (int64_t)r->labels.selected), format_count(b, (int64_t)r->labels.removed),
                   format_count(c, (int64_t)r->labels.filled));
    print_line(app, "%s: %s cubic voxels of %s, %s of them bone (%d HU or more)", out, format_dims(a, r->cubic.dims),
               format_spacing(b, r->cubic.spacing), format_count(c, info->active_voxels), info->threshold);
    print_line(app, "  %s chunks of %d^3, %s of %s in use, %s", format_dims(a, info->chunk_dims), info->chunk_size,
               format_count(b, info->active_chunks), format_count(c, info->chunks), format_bytes(d, info->chunk_bytes));
    for (int i = 0; i < r->stage_count; i++)
        print_line(app, "  %-8s %9s", r->stages[i].name, format_time(a, r->stages[i].time_ms));
}
