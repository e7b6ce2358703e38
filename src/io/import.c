/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Imports a file as a bone, stage by stage:
 *
 *   text          --scan--> samples --scatter--> rect
 *   other formats --read, slice by slice------> rect (cropped)
 *   with a mask   --read--> volume --mask.c---> rect (cropped)
 *                                               rect --> cubic --> chunks
 *
 * The file has more than 500 lines because all stages share the struct `job`.
 *
 * Each stage is timed. If the options request digests, the digest of each stage's result is computed. Each grid is
 * freed as soon as the next one is complete.
 */
#include "core/conditions.h"

#include <osteon/io.h>

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/clock.h"
#include "io/import_digest.h"
#include "io/mask.h"
#include "io/text/raster.h"
#include "io/volume/memory.h"
#include "io/volume_read.h"

enum { THRESHOLD = 120, CHUNK = 32, BATCH_VOXELS = 1 << 22 };

/*
 * The grid of a text file with n samples may have at most max(2^24, 256 n) voxels. A line has at least 8 bytes and a
 * voxel has 2 bytes, so a grid needs at most 32 MiB or, if this is greater, 64 times the file's size. Real files need
 * far fewer voxels per sample: a bone without its surroundings fills 5 to 30 % of its bounding box, and a file that
 * contains only the shell of a bone is also far from the limit.
 */
static const uint64_t SPARSE_FLOOR = UINT64_C(1) << 24;
static const uint64_t SPARSE_RATIO = 256;

typedef struct job {
    ost_backend *backend;
    const char *path;
    const ost_import_options *options;
    ost_import_result *result;
    ost_grid *rect;
    ost_bone *bone;
    ost_dims file_dims;  /* dimensions of the file's volume before it is cropped */
    int16_t *batch;      /* owned; slices that are uploaded together */
    /* the batch: index of its first slice in the rect grid, number of slices, and maximum number of slices */
    int32_t batch_first, batch_count, batch_capacity;
    int64_t stage_start; /* start time of the current stage in ns */
} job;

/* --------------------------------------------------------------------- stages */

static ost_status progress(const job *j, const char *stage, double share, ost_error *err)
{
    if (j->options->progress && !j->options->progress(j->options->progress_user, stage, share))
        return ost_fail(err, OST_ERR_CANCELLED, "%s: the import was cancelled", j->path);
    return OST_OK;
}

static ost_status stage_begin(job *j, const char *name, ost_error *err)
{
    j->stage_start = ost_clock_ns();
    return progress(j, name, 0, err);
}

/* Ends a stage. Waits for the backend first, so that the stage's time includes all of its work. */
static ost_status stage_end(job *j, const char *name, ost_stage **stage, ost_error *err)
{
    ost_status status = ost_backend_finish(j->backend, err);
    *stage = &j->result->stages[j->result->stage_count++];
    **stage = (ost_stage){.time_ms = (double)(ost_clock_ns() - j->stage_start) * 1e-6,
                          .has_digest = j->options->digests};
    snprintf((*stage)->name, sizeof (*stage)->name, "%s", name);
    return status;
}

static ost_status stage_end_grid(job *j, const char *name, ost_grid_kind kind, const ost_grid *grid, ost_error *err)
{
    ost_stage *stage;
    ost_status status = stage_end(j, name, &stage, err);
    if (status == OST_OK && j->options->digests)
        status = ost_import_digest(j->path, kind, grid, &stage->digest, err);
    return status;
}

/* --------------------------------------------------------------------- checks */

static ost_status count_active(const job *j, int32_t threshold, int64_t *out, ost_error *err)
{
    const ost_dims dims = j->result->rect.dims;
    const size_t slice = (size_t)dims.x * (size_t)dims.y;
    int16_t *voxels = malloc(slice * sizeof *voxels);
    ost_status status = voxels ? OST_OK : ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for a slice of %zu voxels",
                                                   j->path, slice);
    *out = 0;
    for (int32_t z = 0; z < dims.z && status == OST_OK; z++) {
        status = ost_grid_download(j->rect, z, 1, voxels, err);
        for (size_t i = 0; i < slice && status == OST_OK; i++)
            *out += voxels[i] >= threshold;
    }
    free(voxels);
    return status;
}

/*
 * Refuses a bone that is too large for the memory, because its import could run for hours before the system kills the
 * process. The estimate contains only the active voxels of the bone, because the cpu backend stores nothing else. Their
 * number is scaled from the rect grid to the cubic grid. A backend that needs more memory, for example for the cubic
 * grid, fails later with its own message.
 */
static ost_status check_bone_memory(const job *j, ost_pm cubic, int32_t threshold, ost_error *err)
{
    const ost_geometry *g = &j->result->rect;
    const double c = (double)cubic, all = ost_machine_memory();
    const double along[3] = {(double)g->spacing.x / c, (double)g->spacing.y / c, (double)g->spacing.z / c};
    /* bytes in the cubic grid for each voxel of the rect grid */
    const double each = 2 * along[0] * along[1] * along[2];
    if (g->dims.x * along[0] > OST_DIM_MAX || g->dims.y * along[1] > OST_DIM_MAX ||
        g->dims.z * along[2] > OST_DIM_MAX || (double)ost_dims_count(g->dims) * each <= all)
        return OST_OK;
    int64_t active;
    ost_status status = count_active(j, threshold, &active, err);
    if (status != OST_OK || (double)active * each <= all)
        return status;
    char text[OST_PM_TEXT];
    return ost_fail(err, OST_ERR_MEMORY,
                    "%s: with cubic voxels of %s mm the bone takes %.3g GB; this machine has %.3g GB", j->path,
                    ost_pm_format(cubic, text), (double)active * each * 1e-9, all * 1e-9);
}

/* Crops a geometry to the voxels whose index is in [box->lo, box->hi). */
static ost_status crop_geometry(const char *path, const ost_voxel_box *box, ost_geometry *g, ost_error *err)
{
    int32_t *const dims[3] = {&g->dims.x, &g->dims.y, &g->dims.z};
    ost_pm *const origin[3] = {&g->origin.x, &g->origin.y, &g->origin.z};
    const ost_pm spacing[3] = {g->spacing.x, g->spacing.y, g->spacing.z};
    for (int a = 0; a < 3; a++) {
        if (box->lo[a] < 0 || box->lo[a] >= box->hi[a] || box->hi[a] > *dims[a])
            return ost_fail(err, OST_ERR_USAGE,
                            "%s: a crop of voxels %" PRId32 " to %" PRId32 " along %c; expected 0 <= from < to <= %d",
                            path, box->lo[a], box->hi[a], "xyz"[a], *dims[a]);
        *origin[a] += box->lo[a] * spacing[a];
        *dims[a] = box->hi[a] - box->lo[a];
    }
    return OST_OK;
}

/* ----------------------------------------------------------------------- text */

/* The state of the import of a text file: the summary of its lines and, if the lines form a raster, its voxels. */
typedef struct text_job {
    ost_text_source source;
    ost_text_summary summary;
    ost_text_raster raster;
    bool is_raster;
} text_job;

static ost_status read_samples(job *j, text_job *text, ost_hasher *hasher, ost_error *err)
{
    const ost_import_options *options = j->options;
    const ost_text_raster_options raster = {
        .given = options->spacing,
        .threads = options->threads,
        .progress = options->progress,
        .user = options->progress_user,
    };
    ost_status status = ost_text_raster_read(j->path, &raster, &text->summary, &text->raster, &text->is_raster, err);
    if (status != OST_OK)
        return status;
    if (text->is_raster)
        return hasher ? ost_text_raster_hash(&text->raster, hasher, err) : OST_OK;
    return ost_text_scan(&text->source, options->spacing, hasher, options->progress, options->progress_user,
                         &text->summary, err);
}

static ost_status scan_text(job *j, text_job *text, ost_error *err)
{
    ost_hasher *hasher = NULL;
    ost_stage *stage;
    ost_status status = stage_begin(j, "samples", err);
    if (status == OST_OK && j->options->digests)
        status = ost_hasher_open(&hasher, err);
    if (status == OST_OK)
        status = read_samples(j, text, hasher, err);
    if (status == OST_OK)
        status = stage_end(j, "samples", &stage, err);
    if (hasher) {
        ost_status closed = ost_hasher_close(hasher, status == OST_OK ? &stage->digest : NULL,
                                             status == OST_OK ? err : NULL);
        status = status == OST_OK ? closed : status;
    }
    return status;
}

static ost_status check_sparse(const job *j, uint64_t samples, ost_dims dims, ost_error *err)
{
    uint64_t voxels = (uint64_t)ost_dims_count(dims), most = SPARSE_RATIO * samples;
    most = most > SPARSE_FLOOR ? most : SPARSE_FLOOR;
    if (voxels <= most)
        return OST_OK;
    return ost_fail(err, OST_ERR_INPUT,
                    "%s: %" PRIu64 " samples span %d x %d x %d voxels, of which all but one in %" PRIu64
                    " would be empty; check the positions and the spacing", j->path, samples, dims.x, dims.y, dims.z,
                    voxels / samples);
}

static ost_status rect_from_text(job *j, ost_error *err)
{
    ost_import_result *result = j->result;
    text_job text = {.is_raster = false};
    const ost_text_summary *summary = &text.summary;
    ost_geometry full;
    const ost_volume_options *volume = &j->options->volume;
    if (volume->orientation[0] || volume->form != OST_FORM_AUTO)
        return ost_fail(err, OST_ERR_USAGE, "%s: --orientation and --form need another format; the positions "
                        "in a text CT are always LPS", j->path);
    if (volume->series || volume->even_slices || volume->untilt)
        return ost_fail(err, OST_ERR_USAGE, "%s: is not DICOM; omit --series, --even-slices and --untilt", j->path);
    ost_status status = ost_text_source_open(&text.source, j->path, err);
    if (status != OST_OK)
        return status;
    status = scan_text(j, &text, err);
    if (status == OST_OK)
        status = ost_text_geometry(j->path, summary, &full, result->spacing_inferred, err);
    if (status == OST_OK) {
        result->rect = full;
        result->meta = summary->meta;
        result->rounded_positions = summary->rounded_positions;
        snprintf(result->volume.type, sizeof result->volume.type, "int16");
        snprintf(result->volume.encoding, sizeof result->volume.encoding, "text");
        status = j->options->crop ? crop_geometry(j->path, &j->options->crop_box, &result->rect, err) : OST_OK;
    }
    if (status == OST_OK)
        status = check_sparse(j, summary->fingerprint.rows, result->rect.dims, err);
    if (status == OST_OK)
        status = ost_memory_check(j->path, "rect grid", result->rect.dims, err);
    if (status == OST_OK)
        status = stage_begin(j, "rect", err);
    if (status == OST_OK)
        status = ost_grid_create(j->backend, &result->rect, &j->rect, err);
    if (status == OST_OK) {
        const ost_text_rect_options options = {
            .duplicates = j->options->duplicates,
            .full = &full,
            .crop = j->options->crop ? &j->options->crop_box : NULL,
            .expected = summary->fingerprint,
            .dims_line = summary->own_dims.line,
            .progress = j->options->progress,
            .user = j->options->progress_user,
        };
        status = text.is_raster
                     ? ost_text_raster_to_rect(j->path, &text.raster, &options, j->rect, &result->scatter, err)
                     : ost_text_to_rect(&text.source, &options, j->rect, &result->scatter, err);
    }
    ost_text_raster_free(&text.raster);
    ost_text_summary_free(&text.summary);
    ost_text_source_close(&text.source);
    return status == OST_OK ? stage_end_grid(j, "rect", OST_GRID_RECT, j->rect, err) : status;
}

/* --------------------------------------------------------------- other formats */

/* Sets the rect grid to the grid of the file. A spacing in the options overrides the spacing in the file. */
static ost_status set_rect(job *j, const ost_geometry *geometry, ost_error *err)
{
    static const ost_pm3 none;
    /* For a stack of slices, the reader has already applied the spacing from the options, which refers to columns,
     * rows and slices. */
    const ost_pm3 stated = j->result->kind == OST_FILE_STACK ? none : j->options->spacing;
    ost_geometry *rect = &j->result->rect;
    *rect = *geometry;
    rect->spacing.x = stated.x ? stated.x : rect->spacing.x;
    rect->spacing.y = stated.y ? stated.y : rect->spacing.y;
    rect->spacing.z = stated.z ? stated.z : rect->spacing.z;
    return ost_geometry_check(rect, j->path, err);
}

/* Creates the rect grid for a volume with the given geometry. Implements ost_target.begin. */
static ost_status begin_rect(void *user, const ost_geometry *geometry, ost_error *err)
{
    job *j = user;
    const ost_import_options *options = j->options;
    ost_geometry *rect = &j->result->rect;
    j->file_dims = geometry->dims;
    ost_status status = set_rect(j, geometry, err);
    if (status == OST_OK && options->crop)
        status = crop_geometry(j->path, &options->crop_box, rect, err);
    if (status != OST_OK)
        return status;
    const int64_t slice = (int64_t)rect->dims.x * rect->dims.y, fitting = BATCH_VOXELS / slice;
    j->batch_capacity = fitting < 1 ? 1 : fitting < rect->dims.z ? (int32_t)fitting : rect->dims.z;
    j->batch = malloc((size_t)slice * (size_t)j->batch_capacity * sizeof *j->batch);
    if (!j->batch)
        return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for %d slices of %d x %d voxels", j->path,
                        (int)j->batch_capacity, (int)rect->dims.x, (int)rect->dims.y);
    return ost_grid_create(j->backend, rect, &j->rect, err);
}

static ost_status upload_batch(job *j, ost_error *err)
{
    const int32_t count = j->batch_count;
    j->batch_count = 0;
    return count ? ost_grid_upload(j->rect, j->batch_first, count, j->batch, err) : OST_OK;
}

/*
 * Implements ost_target.slice. Adds the part of a slice that lies in the rect grid to the batch. Slices are uploaded in
 * batches because, after each upload, the threads of a backend spin for some milliseconds and take processor time from
 * the processes that read the file.
 */
static ost_status add_slice(void *user, int32_t z, const int16_t *voxels, ost_error *err)
{
    job *j = user;
    static const ost_voxel_box complete;
    const ost_voxel_box *box = j->options->crop ? &j->options->crop_box : &complete;
    const ost_dims to = j->result->rect.dims;
    const size_t width = (size_t)to.x;
    ost_status status = progress(j, "rect", (double)z / j->file_dims.z, err);
    const int32_t at = z - box->lo[2];
    if (status != OST_OK || at < 0 || at >= to.z)
        return status;
    if (j->batch_count == j->batch_capacity || at != j->batch_first + j->batch_count)
        status = upload_batch(j, err);
    if (j->batch_count == 0)
        j->batch_first = at;
    int16_t *slot = j->batch + width * (size_t)to.y * (size_t)j->batch_count++;
    for (int32_t y = 0; y < to.y; y++)
        memcpy(slot + width * (size_t)y, voxels + (size_t)j->file_dims.x * (size_t)(box->lo[1] + y) + box->lo[0],
               width * sizeof *slot);
    return status;
}

/*
 * Determines the threshold: the threshold in the options if set, otherwise the one stored in the file if the file is a
 * bone, otherwise the default. A bone file contains only voxels at or above its stored threshold, so a lower threshold
 * is an error.
 */
static ost_status find_threshold(const job *j, int32_t *out, ost_error *err)
{
    const int32_t requested = j->options->threshold;
    *out = requested ? requested : THRESHOLD;
    const char *kind = ost_meta_get(&j->result->meta, OST_META_KIND),
               *text = ost_meta_get(&j->result->meta, OST_META_THRESHOLD);
    if (!kind || strcmp(kind, "bone") != 0 || !text)
        return OST_OK;
    const char *end = text + strlen(text);
    ost_decimal value;
    int64_t threshold;
    bool exact;
    if (ost_decimal_read(text, end, &value) != end || !ost_decimal_scale(&value, 1, &threshold, &exact) || !exact ||
        threshold < 1 || threshold > INT16_MAX)
        return ost_fail(err, OST_ERR_INPUT,
                        "%s: threshold '%.40s' in the header; expected a whole number from 1 to %d", j->path, text,
                        INT16_MAX);
    if (requested && requested < threshold)
        return ost_fail(err, OST_ERR_INPUT, "%s: is a bone that was cut at %" PRId64 " HU: values below it are not "
                        "stored, so a threshold of %d is impossible; import the CT again with --threshold %d", j->path,
                        threshold, requested, requested);
    *out = requested ? requested : (int32_t)threshold;
    return OST_OK;
}

/*
 * Reads a volume, applies the mask and the labels, and uploads the result. The complete volume is read into memory
 * first, because the mask and the labels require it.
 */
static ost_status rect_from_masked(job *j, ost_error *err)
{
    ost_import_result *result = j->result;
    ost_volume volume = {0};
    int32_t threshold;
    ost_status status = ost_volume_read(j->path, &j->options->volume, &volume, &result->volume, err);
    if (status != OST_OK)
        return status;
    result->meta = volume.meta;
    const ost_dims dims = volume.geometry.dims;
    status = set_rect(j, &volume.geometry, err);
    if (status == OST_OK)
        status = find_threshold(j, &threshold, err);
    if (status == OST_OK)
        status = ost_mask_apply(j->path, j->options, threshold, &volume, result, err);
    if (status == OST_OK)
        status = begin_rect(j, &volume.geometry, err);
    for (int32_t z = 0; z < dims.z && status == OST_OK; z++)
        status = add_slice(j, z, volume.voxels + (size_t)dims.x * (size_t)dims.y * (size_t)z, err);
    ost_volume_free(&volume);
    return status;
}

static ost_status rect_from_volume(job *j, ost_error *err)
{
    const ost_target target = {.begin = begin_rect, .slice = add_slice, .user = j};
    ost_import_result *result = j->result;
    ost_geometry geometry;
    ost_element element;
    ost_status status = stage_begin(j, "rect", err);
    if (status == OST_OK)
        status = j->options->mask || j->options->labels
                     ? rect_from_masked(j, err)
                     : ost_volume_read_any(j->path, &j->options->volume, &target, &geometry, &result->meta,
                                           &result->volume, &element, err);
    if (status == OST_OK)
        status = upload_batch(j, err);
    free(j->batch);
    j->batch = NULL;
    return status == OST_OK ? stage_end_grid(j, "rect", OST_GRID_RECT, j->rect, err) : status;
}

/* ------------------------------------------------------------------ rect to bone */

/*
 * Returns true if the file is a bone whose voxels are not resampled. The header facts about its CT then remain valid.
 */
static bool is_same_lattice(const job *j, ost_pm cubic)
{
    const ost_pm3 s = j->result->rect.spacing;
    const char *kind = ost_meta_get(&j->result->meta, OST_META_KIND);
    return kind && strcmp(kind, "bone") == 0 && s.x == cubic && s.y == cubic && s.z == cubic;
}

static ost_status set_meta(const job *j, ost_pm cubic, int32_t threshold, ost_error *err)
{
    ost_meta *meta = &j->result->meta;
    char text[16];
    snprintf(text, sizeof text, "%" PRId32, threshold);
    const bool same_lattice = is_same_lattice(j, cubic);
    ost_status status = ost_meta_set(meta, OST_META_KIND, "bone", err);
    if (status == OST_OK)
        status = ost_meta_set(meta, OST_META_THRESHOLD, text, err);
    if (status == OST_OK && !same_lattice)
        status = ost_meta_set(meta, OST_META_RESAMPLE, ost_resample_name(j->result->resample), err);
    if (status == OST_OK && j->result->kind == OST_FILE_CT_TEXT && j->options->duplicates != OST_DUPLICATES_ERROR) {
        static const char *const names[] = {"error", "first", "last", "max"};
        status = ost_meta_set(meta, "duplicates", names[j->options->duplicates], err);
    }
    if (status != OST_OK)
        (void)ost_fail_context(err, "%s", j->path);
    return status;
}

static ost_status bone_from_rect(job *j, ost_error *err)
{
    const ost_import_options *options = j->options;
    ost_import_result *result = j->result;
    ost_grid *cubic = NULL;
    ost_stage *stage;
    int32_t threshold;
    const ost_pm spacing = options->cubic ? options->cubic : result->rect.spacing.x;
    result->resample = options->has_resample   ? options->resample
                       : result->volume.labels ? OST_RESAMPLE_NEAREST
                                               : OST_RESAMPLE_LINEAR;
    ost_status status = find_threshold(j, &threshold, err);
    if (status == OST_OK)
        status = check_bone_memory(j, spacing, threshold, err);
    if (status == OST_OK)
        status = set_meta(j, spacing, threshold, err);
    if (status == OST_OK)
        status = stage_begin(j, "cubic", err);
    if (status == OST_OK)
        status = ost_rect_to_cubic(j->rect, spacing, result->resample, &cubic, err);
    if (status == OST_OK)
        status = stage_end_grid(j, "cubic", OST_GRID_CUBIC, cubic, err);
    ost_grid_free(j->rect);
    j->rect = NULL;
    if (status == OST_OK) {
        result->cubic = *ost_grid_geometry(cubic);
        status = stage_begin(j, "chunks", err);
    }
    if (status == OST_OK)
        status = ost_cubic_to_chunks(cubic, options->chunk_size ? options->chunk_size : CHUNK, threshold, &j->bone,
                                     err);
    if (status == OST_OK)
        status = stage_end(j, "chunks", &stage, err);
    ost_grid_free(cubic);
    if (status == OST_OK && options->digests)
        status = ost_bone_digest(j->bone, NULL, &stage->digest, err);
    return status == OST_OK ? progress(j, "chunks", 1, err) : status;
}

/* -------------------------------------------------------------------- the import */

static ost_status check_options(const ost_import_options *options, const char *path, ost_error *err)
{
    const ost_pm lengths[4] = {options->spacing.x, options->spacing.y, options->spacing.z, options->cubic};
    for (int i = 0; i < 4; i++)
        if (lengths[i] != 0 && (lengths[i] < OST_SPACING_MIN || lengths[i] > OST_SPACING_MAX))
            return ost_fail(err, OST_ERR_RANGE, "%s: %s of %.9g mm; expected 0.001 to 100 mm", path,
                            i < 3 ? "a spacing" : "a cubic voxel", ost_pm_to_mm(lengths[i]));
    if (options->threshold < 0 || options->threshold > INT16_MAX)
        return ost_fail(err, OST_ERR_RANGE, "%s: a threshold of %d; expected 1 to %d", path,
                        options->threshold, INT16_MAX);
    if (options->has_resample && !ost_resample_name(options->resample))
        return ost_fail(err, OST_ERR_USAGE, "%s: unknown rule %d for resampling", path, (int)options->resample);
    return OST_OK;
}

static ost_status rect_from_file(job *j, ost_error *err)
{
    ost_status status = ost_file_kind_find(j->path, &j->result->kind, err);
    if (status != OST_OK)
        return status;
    switch (j->result->kind) {
    case OST_FILE_CT_TEXT:
        return j->options->mask || j->options->labels ? ost_mask_refuse_text(j->path, err) : rect_from_text(j, err);
    case OST_FILE_NRRD:
    case OST_FILE_NIFTI:
    case OST_FILE_METAIMAGE:
    case OST_FILE_DICOM:
    case OST_FILE_STACK:
        return rect_from_volume(j, err);
    case OST_FILE_MESH:
        return ost_fail(err, OST_ERR_INPUT, "%s: is a mesh, not a CT; 'osteon voxelize' reads meshes", j->path);
    case OST_FILE_PATH_CSV:
        return ost_fail(err, OST_ERR_INPUT, "%s: is a tool's path, not a CT; expected lines of x y z density", j->path);
    case OST_FILE_SESSION:
        return ost_fail(err, OST_ERR_INPUT, "%s: is a session, not a CT; run 'osteon replay' to compute its bone",
                        j->path);
    case OST_FILE_UNKNOWN: break;
    }
    return ost_fail(err, OST_ERR_INPUT, "%s: not a CT; expected text (x y z density), NRRD, NIfTI, MetaImage, DICOM, "
                    "TIFF or PNG slices", j->path);
}

ost_status ost_import(ost_backend *backend, const char *path, const ost_import_options *options, ost_bone **out,
                      ost_import_result *result, ost_error *err)
{
    static const ost_import_options plain;
    ost_import_result *own = NULL;
    *out = NULL;
    if (!backend || !path)
        return ost_fail(err, OST_ERR_USAGE, "a backend and a file are needed");
    if (!result) {
        own = malloc(sizeof *own);
        if (!own)
            return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for a report", path);
        result = own;
    }
    *result = (ost_import_result){0};
    job j = {.backend = backend, .path = path, .options = options ? options : &plain, .result = result};
    ost_status status = check_options(j.options, path, err);
    if (status == OST_OK)
        status = rect_from_file(&j, err);
    const char *kind = status == OST_OK ? ost_meta_get(&result->meta, OST_META_KIND) : NULL;
    if (kind && strcmp(kind, "tool") == 0)
        status = ost_fail(err, OST_ERR_INPUT, "%s: is a tool grid; expected a bone or a CT", path);
    if (status == OST_OK)
        status = bone_from_rect(&j, err);
    ost_grid_free(j.rect);
    if (status == OST_OK)
        *out = j.bone;
    else
        ost_bone_free(j.bone);
    free(own);
    return status;
}
