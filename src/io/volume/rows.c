/* SPDX-License-Identifier: Apache-2.0 */
#include "io/volume/rows.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/volume/resample.h"

ost_status ost_rows_sizes(const char *path, const int64_t sizes[3], int32_t out[3], ost_error *err)
{
    int64_t count = 1;
    for (int a = 0; a < 3; a++) {
        if (sizes[a] < 1)
            return ost_fail(err, OST_ERR_INPUT, "%s: size %lld along axis %d; expected at least 1", path,
                            (long long)sizes[a], a + 1);
        if (sizes[a] > OST_DIM_MAX)
            return ost_fail(err, OST_ERR_RANGE, "%s: size %lld along axis %d; expected at most %d", path,
                            (long long)sizes[a], a + 1, OST_DIM_MAX);
        out[a] = (int32_t)sizes[a];
        count *= sizes[a];
    }
    if (count > INT64_C(1) << 36)
        return ost_fail(err, OST_ERR_RANGE, "%s: %d x %d x %d voxels; expected at most 2^36 in all", path, out[0],
                        out[1], out[2]);
    return OST_OK;
}

ost_status ost_volume_orientation(const char *path, const ost_volume_options *options, ost_affine *affine,
                                  bool *oriented, ost_meta *meta, ost_volume_report *report, ost_error *err)
{
    static const char assumed[] = "assumed LPS";
    const char *code = options ? options->orientation : "";
    const char *recorded = ost_meta_get(meta, OST_META_ORIENTATION);
    char stated[12];
    if (*oriented) {
        report->assumed = recorded && strcmp(recorded, assumed) == 0;
        if (!code[0])
            return OST_OK;
        if (report->assumed)
            return ost_fail(err, OST_ERR_USAGE,
                            "%s: its orientation was assumed when the CT was imported; import the CT itself with "
                            "--orientation %s",
                            path, code);
        return ost_fail(err, OST_ERR_USAGE, "%s: its header states where its axes point; omit --orientation %s", path,
                        code);
    }
    if (code[0] && !ost_affine_restate(affine, code))
        return ost_fail(
            err, OST_ERR_USAGE,
            "--orientation %s: expected three letters, one of L R, one of P A, one of S I, such as LPS or RAS", code);
    *oriented = code[0] != 0;
    report->assumed = !*oriented;
    snprintf(stated, sizeof stated, "stated %s", code);
    ost_status status = ost_meta_set(meta, OST_META_ORIENTATION, report->assumed ? assumed : stated, err);
    if (status != OST_OK)
        ost_fail_context(err, "%s", path);
    return status;
}

ost_status ost_volume_resolve(const char *path, const ost_affine *affine, const int32_t sizes[3],
                              const ost_volume_options *options, bool oriented, ost_placement *placement,
                              ost_geometry *geometry, ost_volume_report *report, ost_error *err)
{
    ost_status status = ost_orient(affine, sizes, placement, err);
    if (status == OST_OK && placement->oblique && !(options && options->resample_oblique))
        return ost_fail(err, OST_ERR_INPUT,
                        "%s: the grid is oblique: an axis is %.2f degrees off the patient's axes; "
                        "'osteon import --resample-oblique' takes the nearest voxels", path, placement->degrees);
    if (status == OST_OK) {
        *geometry = placement->geometry;
        if (placement->oblique)
            status = ost_resample_geometry(affine, sizes, placement, geometry, err);
    }
    if (status != OST_OK) {
        ost_fail_context(err, "%s", path);
        return status;
    }
    report->resampled = placement->oblique;
    report->reoriented = placement->reoriented;
    if (oriented)
        memcpy(report->orientation, placement->code, sizeof placement->code);
    return OST_OK;
}

/* ------------------------------------------------------------------- rows */

ost_status ost_rows_bad(const ost_rows *rows, int64_t number, const char *file, const char *location,
                        const ost_bad *bad, ost_error *err)
{
    int64_t i = number % rows->sizes[0];
    int64_t j = number / rows->sizes[0] % rows->sizes[1];
    int64_t k = number / rows->sizes[0] / rows->sizes[1];
    const char *wrong = bad->kind == OST_BAD_NAN ? "is not a density; 'osteon import --nan-as-air' converts it to -1024"
                                                 : "is not a density; expected a finite number";
    if (bad->kind == OST_BAD_RANGE)
        wrong = rows->converter.scaled
                    ? "is outside -32768 to 32767 after slope and intercept; 'osteon import --clamp' limits it"
                    : "is outside -32768 to 32767; 'osteon import --clamp' limits it";
    return ost_fail(err, OST_ERR_INPUT, "%s: voxel (%lld, %lld, %lld) at %s: %s %s", file, (long long)i, (long long)j,
                    (long long)k, location, bad->value, wrong);
}

ost_status ost_rows_next_binary(ost_rows *rows, int64_t first, int16_t *out, ost_error *err)
{
    size_t count = (size_t)rows->sizes[0];
    size_t size = ost_element_bytes(rows->converter.element);
    ost_status status = ost_parts_read(rows->parts, rows->scratch, count * size, err);
    if (status != OST_OK)
        return status;
    ost_bad bad;
    size_t done = ost_element_table_convert(rows->table, &rows->converter, rows->scratch, count, out, &bad);
    if (done == count)
        return OST_OK;
    /* A row never extends over two parts, so its bytes are the last bytes that were read from the open part. */
    char location[OST_LOCATION_TEXT];
    ost_input_location(rows->parts->input, (count - done) * size, location);
    return ost_rows_bad(rows, first + (int64_t)done, ost_input_path(rows->parts->input), location, &bad, err);
}

/* Reads slice k of the file into `voxels`, at the indices given by the placement. `row` is scratch for one row. */
static ost_status fill_slice(ost_rows *rows, const ost_placement *placement, int32_t k, int16_t *row, int16_t *voxels,
                             ost_error *err)
{
    const int32_t n = rows->sizes[0];
    const int64_t step = placement->stride[0];
    int64_t first = (int64_t)k * n * rows->sizes[1];
    ost_status status = OST_OK;
    for (int32_t j = 0; status == OST_OK && j < rows->sizes[1]; j++, first += n) {
        int16_t *to = voxels + ost_placement_element(placement, 0, j, k);
        if (step == 1) {
            status = rows->next(rows, first, to, err);
            continue;
        }
        status = rows->next(rows, first, row, err);
        for (int32_t i = 0; status == OST_OK && i < n; i++)
            to[i * step] = row[i];
    }
    return status;
}

/* Reads all slices into `voxels`. If `voxels` is NULL, reads slice by slice and passes each slice to the target. */
static ost_status fill_slices(ost_rows *rows, const ost_placement *placement, int16_t *voxels,
                              const ost_target *target, ost_error *err)
{
    const int32_t n = rows->sizes[0], slices = rows->sizes[2];
    const int64_t count = (int64_t)n * rows->sizes[1];
    int16_t *row = malloc((size_t)n * sizeof *row), *slice = voxels ? NULL : malloc((size_t)count * sizeof *slice);
    rows->scratch = malloc((size_t)n * 8);
    rows->table = ost_element_table_make(&rows->converter, count * slices);
    ost_status status = OST_OK;
    if (!row || !rows->scratch || (!voxels && !slice))
        status = ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for a %s of %lld voxels", rows->path,
                          voxels ? "row" : "slice", (long long)(voxels ? n : count));
    ost_placement own = *placement;
    if (!voxels) {
        /* with this placement, every slice of the file is stored at the start of the buffer */
        own.base -= placement->flip[2] ? count * (slices - 1) : 0;
        own.stride[2] = 0;
    }
    const ost_volume_options *o = rows->options;
    for (int32_t k = 0; status == OST_OK && k < slices; k++) {
        if (o && o->progress && !o->progress(o->progress_user, "reading", (double)k / slices))
            status = ost_fail(err, OST_ERR_CANCELLED, "%s: reading was cancelled", rows->path);
        if (status == OST_OK)
            status = fill_slice(rows, &own, k, row, voxels ? voxels : slice, err);
        if (status == OST_OK && !voxels)
            status = target->slice(target->user, placement->flip[2] ? slices - 1 - k : k, slice, err);
    }
    free(row);
    free(slice);
    free(rows->scratch);
    free(rows->table);
    rows->scratch = NULL;
    rows->table = NULL;
    return status;
}

/* Passes a complete volume to the functions of the target. */
static ost_status send_volume(const ost_volume *volume, const ost_target *target, ost_error *err)
{
    const ost_dims dims = volume->geometry.dims;
    const size_t slice = (size_t)dims.x * (size_t)dims.y;
    ost_status status = target->begin(target->user, &volume->geometry, err);
    for (int32_t z = 0; z < dims.z && status == OST_OK; z++)
        status = target->slice(target->user, z, volume->voxels + slice * (size_t)z, err);
    return status;
}

ost_status ost_volume_fill(ost_rows *rows, const ost_affine *affine, const ost_placement *placement,
                           const ost_geometry *geometry, const ost_target *target, ost_error *err)
{
    static const ost_placement as_in_file = {.to = {0, 1, 2}};
    ost_placement own = as_in_file;
    ost_volume result = {0}, in_file = {0}, *filled = &result;
    ost_status status = rows->parts ? ost_parts_check(rows->parts, err) : OST_OK;
    if (status != OST_OK)
        return status;
    ost_geometry first = *geometry;
    if (placement->oblique) {
        /* Resampling uses only the dims of this geometry; positions follow from the affine transform. */
        first.dims = (ost_dims){rows->sizes[0], rows->sizes[1], rows->sizes[2]};
        first.origin = (ost_pm3){0, 0, 0};
        first.spacing = (ost_pm3){OST_SPACING_MIN, OST_SPACING_MIN, OST_SPACING_MIN};
        own.stride[0] = 1;
        own.stride[1] = rows->sizes[0];
        own.stride[2] = (int64_t)rows->sizes[0] * rows->sizes[1];
        filled = &in_file;
    }
    const bool streamed = !target->volume && !placement->oblique && placement->to[2] == 2;
    status = streamed ? target->begin(target->user, geometry, err) : ost_volume_init(filled, &first, err);
    if (status == OST_OK)
        status = fill_slices(rows, placement->oblique ? &own : placement, filled->voxels, target, err);
    if (status == OST_OK && rows->parts)
        status = ost_parts_end(rows->parts, err);
    if (status == OST_OK && placement->oblique) {
        status = ost_volume_init(&result, geometry, err);
        if (status == OST_OK)
            ost_resample_nearest(affine, rows->sizes, in_file.voxels, &result);
    }
    ost_volume_free(&in_file);
    if (status == OST_OK && !target->volume && !streamed)
        status = send_volume(&result, target, err);
    if (status == OST_OK && target->volume)
        *target->volume = result;
    else
        ost_volume_free(&result);
    return status;
}
