/* SPDX-License-Identifier: Apache-2.0 */
#include "core/conditions.h"

#include <osteon/segment.h>

#include <stdlib.h>
#include <string.h>

#include "core/integer.h"
#include "segment/cut.h"
#include "segment/distance.h"
#include "segment/holes.h"
#include "segment/runs.h"
#include "segment/watershed.h"

enum { THRESHOLD = 120 };

typedef struct job {
    const ost_volume *ct;
    ost_segment_options options; /* the caller's options; zeros are replaced with defaults */
    ost_volume *labels;
    ost_segment *segments;       /* all components; after rank(), only those with a label */
    size_t count;
} job;

static const int16_t *row_of(const ost_volume *v, int32_t y, int32_t z)
{
    const ost_dims d = v->geometry.dims;
    return v->voxels + (size_t)d.x * ((size_t)y + (size_t)d.y * (size_t)z);
}

/* ------------------------------------------------------------- components */

static void is_candidate(void *user, int32_t y, int32_t z, bool *in)
{
    const job *j = user;
    const int16_t *row = row_of(j->ct, y, z);
    const int32_t nx = j->ct->geometry.dims.x;
    for (int32_t x = 0; x < nx; x++)
        in[x] = row[x] >= j->options.growth;
    for (size_t i = 0; i < j->options.cut_count; i++)
        ost_segment_cut_row(&j->options.cuts[i], &j->ct->geometry, y, z, in);
}

/*
 * Extends the bounding box of a segment by the voxels [begin, end) of row (y, z). Rows must be visited in
 * ascending order.
 */
static void extend(ost_segment *s, int32_t begin, int32_t end, int32_t y, int32_t z)
{
    const int32_t lo[3] = {begin, y, z}, hi[3] = {end, y + 1, z + 1};
    const bool is_first = s->box.hi[0] == 0;
    for (int a = 0; a < 3; a++) {
        s->first[a] = is_first ? lo[a] : s->first[a];
        s->box.lo[a] = is_first || lo[a] < s->box.lo[a] ? lo[a] : s->box.lo[a];
        s->box.hi[a] = hi[a] > s->box.hi[a] ? hi[a] : s->box.hi[a];
    }
}

/* Counts the voxels of each component. The count of a component is 0 if none of its voxels reaches the threshold. */
static ost_status measure(job *j, const segment_runs *runs, ost_error *err)
{
    const ost_dims d = j->ct->geometry.dims;
    bool *dense = calloc(runs->components + 1, sizeof *dense);
    j->segments = calloc(runs->components + 1, sizeof *j->segments);
    if (!dense || !j->segments) {
        free(dense);
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %u components", (unsigned)runs->components);
    }
    j->count = runs->components;
    for (size_t i = 0; i < (size_t)d.y * (size_t)d.z; i++) {
        const int32_t y = (int32_t)(i % (size_t)d.y), z = (int32_t)(i / (size_t)d.y);
        const int16_t *row = row_of(j->ct, y, z);
        for (size_t r = runs->rows[i]; r < runs->rows[i + 1]; r++) {
            const segment_run *run = &runs->items[r];
            extend(&j->segments[run->component], run->begin, run->end, y, z);
            j->segments[run->component].voxels += (uint64_t)(run->end - run->begin);
            for (int32_t x = run->begin; x < run->end && !dense[run->component]; x++)
                dense[run->component] = row[x] >= j->options.threshold;
        }
    }
    for (size_t c = 0; c < runs->components; c++)
        j->segments[c].voxels = dense[c] ? j->segments[c].voxels : 0;
    free(dense);
    return OST_OK;
}

typedef struct ranked {
    uint64_t voxels, first; /* number of voxels of the component, and index of its first voxel in the grid */
    uint32_t component;
} ranked;

static int by_size(const void *a, const void *b)
{
    const ranked *p = a, *q = b;
    if (p->voxels != q->voxels)
        return p->voxels > q->voxels ? -1 : 1;
    return p->first < q->first ? -1 : p->first > q->first;
}

/*
 * Assigns the labels 1, 2, ... to the components that are large enough, in descending order of size, and stores the
 * labels in label[c]. Small components keep the label 0.
 */
static ost_status rank(job *j, int16_t *label, ost_error *err)
{
    const uint64_t least = j->options.min_voxels ? j->options.min_voxels : 1;
    const ost_dims d = j->ct->geometry.dims;
    size_t large = 0;
    ranked *list = malloc((j->count + 1) * sizeof *list);
    ost_segment *sorted = NULL;
    for (size_t c = 0; c < j->count && list; c++) {
        const ost_segment *s = &j->segments[c];
        const uint64_t row = (uint64_t)s->first[1] + (uint64_t)d.y * (uint64_t)s->first[2];
        if (s->voxels >= least)
            list[large++] = (ranked){s->voxels, (uint64_t)s->first[0] + (uint64_t)d.x * row, (uint32_t)c};
    }
    if (large > OST_SEGMENT_LABELS_MAX) {
        free(list);
        return ost_fail(err, OST_ERR_RANGE, "%zu components; at most %d can have a label: exclude the smaller ones",
                        large, OST_SEGMENT_LABELS_MAX);
    }
    sorted = list ? malloc((large + 1) * sizeof *sorted) : NULL;
    if (!sorted) {
        free(list);
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %zu components", j->count);
    }
    qsort(list, large, sizeof *list, by_size);
    for (size_t k = 0; k < large; k++) {
        sorted[k] = j->segments[list[k].component];
        label[list[k].component] = (int16_t)(k + 1);
    }
    free(list);
    free(j->segments);
    j->segments = sorted;
    j->count = large;
    return OST_OK;
}

static ost_status label_components(job *j, ost_error *err)
{
    const ost_dims d = j->ct->geometry.dims;
    segment_runs runs = {.items = NULL};
    int16_t *label = NULL;
    ost_status status = ost_segment_runs_make(d, is_candidate, j, &runs, err);
    if (status == OST_OK)
        status = measure(j, &runs, err);
    if (status == OST_OK) {
        label = calloc(runs.components + 1, sizeof *label);
        status = label ? rank(j, label, err)
                       : ost_fail(err, OST_ERR_MEMORY, "out of memory for %u labels", (unsigned)runs.components);
    }
    for (size_t i = 0; i < (size_t)d.y * (size_t)d.z && status == OST_OK; i++)
        for (size_t r = runs.rows[i]; r < runs.rows[i + 1]; r++)
            for (int32_t x = runs.items[r].begin; x < runs.items[r].end; x++)
                j->labels->voxels[(size_t)d.x * i + (size_t)x] = label[runs.items[r].component];
    free(label);
    ost_segment_runs_free(&runs);
    return status;
}

/* ------------------------------------------------------------- separation */

/*
 * Measures the pieces. Voxel i belongs to piece number piece[i]. Voxels with a negative label are not counted, because
 * they were labelled only to close holes of slices. Of the other voxels, those that are not candidates are counted as
 * filled.
 */
static ost_status measure_pieces(job *j, const segment_sparse *sparse, const uint32_t *piece, uint32_t pieces,
                                 ost_error *err)
{
    const ost_dims d = sparse->dims;
    bool *in = malloc((size_t)d.x * sizeof *in);
    free(j->segments);
    j->count = pieces;
    j->segments = calloc((size_t)pieces + 1, sizeof *j->segments);
    if (!in || !j->segments) {
        free(in);
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %lu pieces", (unsigned long)pieces);
    }
    for (size_t i = 0; i < (size_t)d.y * (size_t)d.z; i++) {
        const int32_t y = (int32_t)(i % (size_t)d.y), z = (int32_t)(i / (size_t)d.y);
        const int16_t *labels = row_of(j->labels, y, z);
        if (sparse->rows[i] < sparse->rows[i + 1])
            is_candidate(j, y, z, in);
        for (uint32_t r = sparse->rows[i]; r < sparse->rows[i + 1]; r++)
            for (int32_t x = sparse->runs[r].begin; x < sparse->runs[r].end; x++) {
                ost_segment *s = &j->segments[piece[sparse->runs[r].first + (uint32_t)(x - sparse->runs[r].begin)]];
                if (labels[x] < 0)
                    continue;
                if (in[x]) {
                    extend(s, x, x + 1, y, z);
                    s->voxels++;
                } else {
                    s->filled++;
                }
            }
    }
    free(in);
    return OST_OK;
}

static ost_status label_pieces(job *j, const segment_sparse *sparse, const uint32_t *piece, uint32_t pieces,
                               ost_error *err)
{
    int16_t *label = calloc((size_t)pieces + 1, sizeof *label);
    ost_status status = label ? measure_pieces(j, sparse, piece, pieces, err)
                              : ost_fail(err, OST_ERR_MEMORY, "out of memory for %lu labels", (unsigned long)pieces);
    if (status == OST_OK)
        status = rank(j, label, err);
    for (size_t i = 0; i < (size_t)sparse->dims.y * (size_t)sparse->dims.z && status == OST_OK; i++)
        for (uint32_t r = sparse->rows[i]; r < sparse->rows[i + 1]; r++) {
            const segment_sparse_run *run = &sparse->runs[r];
            int16_t *row = j->labels->voxels + (size_t)sparse->dims.x * i;
            for (int32_t x = run->begin; x < run->end; x++)
                row[x] = row[x] > 0 ? label[piece[run->first + (uint32_t)(x - run->begin)]] : 0;
        }
    free(label);
    return status;
}

static ost_status separate(job *j, ost_error *err)
{
    const uint32_t depth = (uint32_t)ost_rhe_div(j->options.separate, 1000000);
    segment_sparse sparse = {.count = 0};
    uint32_t *height = NULL, *piece = NULL, pieces = 0;
    ost_status status = ost_segment_fill_slices(j->ct, j->options.air, j->labels, err);
    if (status == OST_OK)
        status = ost_segment_sparse_make(j->labels, &sparse, err);
    if (status == OST_OK) {
        height = malloc(((size_t)sparse.count + 1) * sizeof *height);
        piece = malloc(((size_t)sparse.count + 1) * sizeof *piece);
        if (!height || !piece)
            status = ost_fail(err, OST_ERR_MEMORY, "out of memory for the separation of %lu voxels",
                              (unsigned long)sparse.count);
    }
    if (status == OST_OK)
        status = ost_segment_distance(&sparse, j->labels->geometry.spacing, height, err);
    if (status == OST_OK)
        status = ost_segment_watershed(&sparse, height, depth, piece, &pieces, err);
    free(height);
    if (status == OST_OK)
        status = label_pieces(j, &sparse, piece, pieces, err);
    free(piece);
    ost_segment_sparse_free(&sparse);
    return status;
}

/* ----------------------------------------------------------------- public */

static ost_status check(const ost_volume *ct, const ost_segment_options *o, ost_error *err)
{
    if (!ct || !ct->voxels)
        return ost_fail(err, OST_ERR_USAGE, "a volume with voxels is needed");
    if (o->threshold < 1 || o->threshold > INT16_MAX)
        return ost_fail(err, OST_ERR_RANGE, "a threshold of %d HU; expected 1 to %d", (int)o->threshold, INT16_MAX);
    if (o->growth < 1 || o->growth > o->threshold)
        return ost_fail(err, OST_ERR_RANGE, "growth from %d HU on; expected 1 to the threshold, %d", (int)o->growth,
                        (int)o->threshold);
    if (o->separate && (o->separate < OST_PM_PER_MM / 1000 || o->separate > OST_SEGMENT_SEPARATE_MAX))
        return ost_fail(err, OST_ERR_RANGE, "a separation by %.9g mm; expected 0.001 to %.9g mm",
                        ost_pm_to_mm(o->separate), ost_pm_to_mm(OST_SEGMENT_SEPARATE_MAX));
    for (size_t i = 0; i < o->cut_count; i++) {
        const ost_status status = ost_segment_cut_check(&o->cuts[i], err);
        if (status != OST_OK)
            return status;
    }
    return ost_geometry_check(&ct->geometry, "the volume", err);
}

ost_status ost_segment_volume(const ost_volume *ct, const ost_segment_options *options, ost_volume *labels,
                              ost_segment **out, size_t *count, ost_error *err)
{
    job j = {.ct = ct, .options = options ? *options : (ost_segment_options){.threshold = 0}, .labels = labels};
    *labels = (ost_volume){.voxels = NULL};
    *out = NULL;
    *count = 0;
    j.options.threshold = j.options.threshold ? j.options.threshold : THRESHOLD;
    j.options.growth = j.options.growth ? j.options.growth : j.options.threshold;
    ost_status status = check(ct, &j.options, err);
    if (status == OST_OK)
        status = ost_volume_init(labels, &ct->geometry, err);
    if (status == OST_OK)
        status = label_components(&j, err);
    if (status == OST_OK && j.options.fill && j.count)
        status = ost_segment_fill_holes(ct, j.options.air, labels, j.segments, err);
    if (status == OST_OK && j.options.separate && j.count)
        status = separate(&j, err);
    if (status != OST_OK) {
        free(j.segments);
        ost_volume_free(labels);
        return status;
    }
    *out = j.segments;
    *count = j.count;
    return OST_OK;
}

void ost_segments_free(ost_segment *segments)
{
    free(segments);
}
