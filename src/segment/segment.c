/* SPDX-License-Identifier: Apache-2.0 */
#include "core/conditions.h"

#include <osteon/segment.h>

#include <stdlib.h>
#include <string.h>

#include "segment/cut.h"
#include "segment/runs.h"

enum { THRESHOLD = 120 };

typedef struct job {
    const ost_volume *ct;
    ost_segment_options options; /* options with the defaults filled in */
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
        segment_cut_row(&j->options.cuts[i], &j->ct->geometry, y, z, in);
}

/* Measures each component. A component without a voxel at or above the threshold is given 0 voxels. */
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
            ost_segment *s = &j->segments[run->component];
            const int32_t lo[3] = {run->begin, y, z}, hi[3] = {run->end, y + 1, z + 1};
            for (int a = 0; a < 3; a++) {
                s->first[a] = s->voxels ? s->first[a] : lo[a];
                s->box.lo[a] = !s->voxels || lo[a] < s->box.lo[a] ? lo[a] : s->box.lo[a];
                s->box.hi[a] = !s->voxels || hi[a] > s->box.hi[a] ? hi[a] : s->box.hi[a];
            }
            s->voxels += (uint64_t)(run->end - run->begin);
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
    uint64_t voxels;
    uint32_t component;
} ranked;

static int by_size(const void *a, const void *b)
{
    const ranked *p = a, *q = b;
    if (p->voxels != q->voxels)
        return p->voxels > q->voxels ? -1 : 1;
    /* Components are numbered in the order of their first voxels. */
    return p->component < q->component ? -1 : p->component > q->component;
}

/* Numbers the components that are large enough, from 1 in descending order of size, and stores the number of component
   c in label[c]. The label of all other components remains 0. */
static ost_status rank(job *j, int16_t *label, ost_error *err)
{
    const uint64_t least = j->options.min_voxels ? j->options.min_voxels : 1;
    size_t large = 0;
    ranked *list = malloc((j->count + 1) * sizeof *list);
    ost_segment *sorted = NULL;
    for (size_t c = 0; c < j->count && list; c++)
        if (j->segments[c].voxels >= least)
            list[large++] = (ranked){j->segments[c].voxels, (uint32_t)c};
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
    ost_status status = segment_runs_make(d, is_candidate, j, &runs, err);
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
    segment_runs_free(&runs);
    return status;
}

/* ------------------------------------------------------------------ holes */

static void has_no_label(void *user, int32_t y, int32_t z, bool *in)
{
    const job *j = user;
    const int16_t *row = row_of(j->labels, y, z);
    for (int32_t x = 0; x < j->labels->geometry.dims.x; x++)
        in[x] = row[x] == 0;
}

/*
 * Fills the holes.  A hole is a component of voxels without a label that does not touch the
 * border of the grid and contains no air.  The voxel before the first voxel of a hole, along
 * x, has a label, because a hole contains all connected voxels without a label and does not
 * begin at the border.
 */
static ost_status fill_holes(job *j, ost_error *err)
{
    const ost_dims d = j->ct->geometry.dims;
    segment_runs runs = {.items = NULL};
    int16_t *label = NULL;
    bool *open = NULL;
    ost_status status = segment_runs_make(d, has_no_label, j, &runs, err);
    if (status == OST_OK) {
        label = calloc(runs.components + 1, sizeof *label);
        open = calloc(runs.components + 1, sizeof *open);
        if (!label || !open)
            status = ost_fail(err, OST_ERR_MEMORY, "out of memory for %u holes", (unsigned)runs.components);
    }
    for (size_t i = 0; i < (size_t)d.y * (size_t)d.z && status == OST_OK; i++) {
        const int32_t y = (int32_t)(i % (size_t)d.y), z = (int32_t)(i / (size_t)d.y);
        const int16_t *row = row_of(j->ct, y, z);
        for (size_t r = runs.rows[i]; r < runs.rows[i + 1]; r++) {
            const segment_run *run = &runs.items[r];
            bool *const out = &open[run->component];
            *out = *out || run->begin == 0 || run->end == d.x || y == 0 || y == d.y - 1 || z == 0 || z == d.z - 1;
            for (int32_t x = run->begin; x < run->end && !*out; x++)
                *out = row[x] < j->options.air;
            if (!*out && !label[run->component])
                label[run->component] = row_of(j->labels, y, z)[run->begin - 1];
        }
    }
    for (size_t i = 0; i < (size_t)d.y * (size_t)d.z && status == OST_OK; i++)
        for (size_t r = runs.rows[i]; r < runs.rows[i + 1]; r++) {
            const segment_run *run = &runs.items[r];
            if (open[run->component])
                continue;
            j->segments[label[run->component] - 1].filled += (uint64_t)(run->end - run->begin);
            for (int32_t x = run->begin; x < run->end; x++)
                j->labels->voxels[(size_t)d.x * i + (size_t)x] = label[run->component];
        }
    free(open);
    free(label);
    segment_runs_free(&runs);
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
    for (size_t i = 0; i < o->cut_count; i++) {
        const ost_status status = segment_cut_check(&o->cuts[i], err);
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
        status = fill_holes(&j, err);
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
