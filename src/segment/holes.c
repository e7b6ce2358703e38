/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A hole is a connected component of voxels without a label that does not touch the border of the grid and contains no
 * air. A hole consists of runs along x. The voxel before a run exists, because a hole does not touch the border. This
 * voxel has a label; otherwise, it would belong to the hole.
 */
#include "core/conditions.h"

#include "segment/holes.h"

#include <stdlib.h>

#include "segment/runs.h"

/* A block of consecutive slices in which holes are filled. */
typedef struct block {
    const ost_volume *ct;
    ost_volume *labels;
    int32_t air, z, count; /* slices [z, z + count); a voxel below the density `air` is air */
    /* true if the block is one slice; its holes are two-dimensional, so its borders in z are ignored */
    bool is_slice;
    ost_segment *segments; /* if NULL, the voxels of a hole receive the negative of the surrounding label */
} block;

static int16_t *row_of(const block *b, const ost_volume *v, int32_t y, int32_t z)
{
    const ost_dims d = b->ct->geometry.dims;
    return v->voxels + (size_t)d.x * ((size_t)y + (size_t)d.y * (size_t)(b->z + z));
}

static void has_no_label(void *user, int32_t y, int32_t z, bool *in)
{
    const block *b = user;
    const int16_t *row = row_of(b, b->labels, y, z);
    for (int32_t x = 0; x < b->ct->geometry.dims.x; x++)
        in[x] = row[x] == 0;
}

/* Stores the surrounding label in label[c] for each component c that is a hole, and sets open[c] to true for all other
   components. */
static void find_holes(const block *b, const segment_runs *runs, int16_t *label, bool *open)
{
    const ost_dims d = b->ct->geometry.dims;
    for (size_t i = 0; i < runs->rows_count; i++) {
        const int32_t y = (int32_t)(i % (size_t)d.y), z = (int32_t)(i / (size_t)d.y);
        const int16_t *row = row_of(b, b->ct, y, z);
        for (size_t r = runs->rows[i]; r < runs->rows[i + 1]; r++) {
            const segment_run *run = &runs->items[r];
            bool *const out = &open[run->component];
            *out = *out || run->begin == 0 || run->end == d.x || y == 0 || y == d.y - 1 ||
                   (!b->is_slice && (z == 0 || z == b->count - 1));
            for (int32_t x = run->begin; x < run->end && !*out; x++)
                *out = row[x] < b->air;
            if (!*out && !label[run->component])
                label[run->component] = row_of(b, b->labels, y, z)[run->begin - 1];
        }
    }
}

static ost_status fill(block *b, ost_error *err)
{
    const ost_dims d = b->ct->geometry.dims;
    segment_runs runs = {.items = NULL};
    int16_t *label = NULL;
    bool *open = NULL;
    ost_status status = ost_segment_runs_make((ost_dims){d.x, d.y, b->count}, has_no_label, b, &runs, err);
    if (status == OST_OK) {
        label = calloc(runs.components + 1, sizeof *label);
        open = calloc(runs.components + 1, sizeof *open);
        if (!label || !open)
            status = ost_fail(err, OST_ERR_MEMORY, "out of memory for %u holes", (unsigned)runs.components);
    }
    if (status == OST_OK)
        find_holes(b, &runs, label, open);
    for (size_t i = 0; i < runs.rows_count && status == OST_OK; i++)
        for (size_t r = runs.rows[i]; r < runs.rows[i + 1]; r++) {
            const segment_run *run = &runs.items[r];
            int16_t *row = row_of(b, b->labels, (int32_t)(i % (size_t)d.y), (int32_t)(i / (size_t)d.y));
            if (open[run->component])
                continue;
            const int16_t around = label[run->component];
            if (b->segments)
                b->segments[around - 1].filled += (uint64_t)(run->end - run->begin);
            for (int32_t x = run->begin; x < run->end; x++)
                row[x] = b->segments ? around : (int16_t)-around;
        }
    free(open);
    free(label);
    ost_segment_runs_free(&runs);
    return status;
}

ost_status ost_segment_fill_holes(const ost_volume *ct, int32_t air, ost_volume *labels, ost_segment *segments,
                                  ost_error *err)
{
    block b = {.ct = ct, .labels = labels, .air = air, .count = ct->geometry.dims.z, .segments = segments};
    return fill(&b, err);
}

ost_status ost_segment_fill_slices(const ost_volume *ct, int32_t air, ost_volume *labels, ost_error *err)
{
    ost_status status = OST_OK;
    for (int32_t z = 0; z < ct->geometry.dims.z && status == OST_OK; z++) {
        block b = {.ct = ct, .labels = labels, .air = air, .z = z, .count = 1, .is_slice = true};
        status = fill(&b, err);
    }
    return status;
}
