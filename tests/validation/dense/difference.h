/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Finds the first difference between two outcomes of a scene: the stage, the call, and the lowest voxel, leaf
 * and chunk. The difference follows from the outcomes alone, not from the record of the injected mistake.
 */
#ifndef OST_TESTS_VALIDATION_DIFFERENCE_H
#define OST_TESTS_VALIDATION_DIFFERENCE_H

#include "validation/dense/dense.h"
#include "validation/dense/scene.h"

typedef struct difference {
    bool any, voxels, report;
    deviation_stage stage;
    uint64_t call;
    int32_t voxel[3];
    int64_t leaf, chunk;
} difference;

static inline int64_t cube_number(ost_dims d, int32_t n, const int32_t v[3])
{
    return v[0] / n + (int64_t)((d.x + n - 1) / n) * (v[1] / n + (int64_t)((d.y + n - 1) / n) * (v[2] / n));
}

static inline void lower_to(int64_t *least, int64_t value)
{
    if (*least < 0 || value < *least)
        *least = value;
}

/* Compares two grids of `size` (1 or 2) bytes per voxel. If chunk_size is 0, the grids have no chunks. */
static inline void differ_voxels(difference *f, const void *a, const void *b, size_t size, ost_dims d, int chunk_size)
{
    const unsigned char *p = a, *q = b;
    for (int64_t v = 0; v < ost_dims_count(d); v++) {
        if (memcmp(p + (size_t)v * size, q + (size_t)v * size, size) == 0)
            continue;
        const int32_t at[3] = {(int32_t)(v % d.x), (int32_t)(v / d.x % d.y), (int32_t)(v / d.x / d.y)};
        if (!f->voxels)
            memcpy(f->voxel, at, sizeof at);
        f->voxels = true;
        lower_to(&f->leaf, cube_number(d, 32, at));
        if (chunk_size)
            lower_to(&f->chunk, cube_number(d, chunk_size, at));
    }
}

static inline bool same_scatter(const ost_scatter_report *a, const ost_scatter_report *b)
{
    return a->samples == b->samples && a->duplicates == b->duplicates && a->off_lattice == b->off_lattice &&
           a->worst_offset_ppm == b->worst_offset_ppm && a->worst_line == b->worst_line &&
           a->rejected_line == b->rejected_line && a->conflict_line == b->conflict_line &&
           a->conflict_had == b->conflict_had && a->conflict_has == b->conflict_has;
}

static inline void differ_reports(difference *f, const ost_removal_report *a, const ost_removal_report *b)
{
    for (size_t i = 0; i < a->count || i < b->count; i++) {
        const ost_chunk_report *p = i < a->count ? &a->chunks[i] : NULL, *q = i < b->count ? &b->chunks[i] : NULL;
        if (p && q && p->chunk == q->chunk && memcmp(p->voxels, q->voxels, sizeof p->voxels) == 0 &&
            memcmp(p->density, q->density, sizeof p->density) == 0)
            continue;
        f->report = true;
        lower_to(&f->chunk, !p ? q->chunk : !q ? p->chunk : p->chunk < q->chunk ? p->chunk : q->chunk);
        break;
    }
    if (a->touched_voxels != b->touched_voxels || a->total_voxels != b->total_voxels)
        f->report = true;
}

/* Stores the stage and the call. Returns true if a difference has been found. */
static inline bool is_here(difference *f, deviation_stage stage, uint64_t call)
{
    f->stage = stage;
    f->call = call;
    return f->any = f->voxels || f->report;
}

static inline difference first_difference(const scene *s, const outcome *a, const outcome *b)
{
    difference f = {.voxel = {-1, -1, -1}, .leaf = -1, .chunk = -1};
    const ost_dims cubic = cubic_of(s).dims;
    differ_voxels(&f, a->rect, b->rect, 2, s->rect.dims, 0);
    f.report = !same_scatter(&a->scatter, &b->scatter);
    if (is_here(&f, DEVIATION_RECT, 0))
        return f;
    differ_voxels(&f, a->cubic, b->cubic, 2, cubic, 0);
    if (is_here(&f, DEVIATION_CUBIC, 0))
        return f;
    differ_voxels(&f, a->chunks, b->chunks, 2, cubic, s->chunk_size);
    if (is_here(&f, DEVIATION_CHUNKS, 0))
        return f;
    differ_voxels(&f, a->tool.voxels, b->tool.voxels, 1, s->cutting.grid.dims, 0);
    f.report = a->voxelize.solid_voxels != b->voxelize.solid_voxels ||
               a->voxelize.cutting_voxels != b->voxelize.cutting_voxels ||
               a->voxelize.leaking_rows != b->voxelize.leaking_rows;
    if (is_here(&f, DEVIATION_TOOL, 0))
        return f;
    for (int e = 0; e < EVENTS; e++) {
        differ_voxels(&f, a->after[e], b->after[e], 2, cubic, s->chunk_size);
        differ_reports(&f, &a->reports[e], &b->reports[e]);
        if (is_here(&f, DEVIATION_REMOVE, (uint64_t)e))
            return f;
    }
    /* The comparison above finds differences of densities and reports. If only the occupancy differs, the numbers of
       active voxels after the last event differ. */
    f.report = a->info[1].active_voxels != b->info[1].active_voxels;
    is_here(&f, DEVIATION_REMOVE, EVENTS - 1);
    return f;
}

#endif
