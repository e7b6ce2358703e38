/* SPDX-License-Identifier: Apache-2.0 */
#include "app/diff/compare.h"

#include <stdlib.h>
#include <string.h>

const char *diff_kind_name(diff_kind kind)
{
    static const char *const name[DIFF_KIND_COUNT] = {"removed", "added", "changed", "below"};
    return name[kind];
}

const char *diff_kind_text(diff_kind kind)
{
    static const char *const text[DIFF_KIND_COUNT] = {
        "solid in A only", "solid in B only", "solid in both, another value", "solid in neither, another value"};
    return text[kind];
}

diff_kind diff_kind_of(int16_t a, int16_t b, int32_t threshold_a, int32_t threshold_b)
{
    if (a >= threshold_a)
        return b >= threshold_b ? DIFF_CHANGED : DIFF_REMOVED;
    return b >= threshold_b ? DIFF_ADDED : DIFF_BELOW;
}

static void box_add(ost_voxel_box *box, const int32_t at[3], bool first)
{
    for (int axis = 0; axis < 3; axis++) {
        if (first || at[axis] < box->lo[axis])
            box->lo[axis] = at[axis];
        if (first || at[axis] >= box->hi[axis])
            box->hi[axis] = at[axis] + 1;
    }
}

static int64_t *axis_counts(const ost_dims dims, int64_t *counts[3])
{
    int64_t *all = calloc((size_t)dims.x + (size_t)dims.y + (size_t)dims.z, sizeof *all);
    if (all) {
        counts[0] = all;
        counts[1] = all + dims.x;
        counts[2] = all + dims.x + dims.y;
    }
    return all;
}

static int32_t most(const int64_t *count, int32_t n)
{
    int32_t best = 0;
    for (int32_t i = 1; i < n; i++)
        if (count[i] > count[best])
            best = i;
    return best;
}

/* Returns the number of values that are at least `threshold`. */
static int32_t count_solid(const int16_t *value, int32_t n, int32_t threshold)
{
    int32_t count = 0;
    for (int32_t i = 0; i < n; i++)
        count += value[i] >= threshold;
    return count;
}

/* Compares the part of a row that lies in one chunk. `at` is the position of the first of the n voxels. */
static void compare_part(const loaded_volume *a, const loaded_volume *b, const int16_t *pa, const int16_t *pb,
                         int32_t n, const int32_t at[3], size_t limit, diff_chunk *chunk, int64_t *axis[3],
                         diff_result *out)
{
    chunk->solid_a += count_solid(pa, n, a->threshold);
    chunk->solid_b += count_solid(pb, n, b->threshold);
    if (memcmp(pa, pb, (size_t)n * sizeof *pa) == 0)
        return;
    for (int32_t i = 0; i < n; i++) {
        if (pa[i] == pb[i])
            continue;
        const diff_kind kind = diff_kind_of(pa[i], pb[i], a->threshold, b->threshold);
        const diff_voxel voxel = {.at = {at[0] + i, at[1], at[2]}, .a = pa[i], .b = pb[i]};
        if (!chunk->different++)
            chunk->first = voxel;
        chunk->count[kind]++;
        out->count[kind]++;
        box_add(&out->box, voxel.at, out->different == 0);
        out->different++;
        for (int x = 0; x < 3; x++)
            axis[x][voxel.at[x]]++;
        if (out->first_count < limit)
            out->first[out->first_count++] = voxel;
    }
}

static void compare_voxels(const loaded_volume *a, const loaded_volume *b, size_t limit, diff_chunk *chunks,
                           int64_t *axis[3], diff_result *out)
{
    const ost_dims d = a->volume.geometry.dims, cd = out->chunk_dims;
    const int n = out->chunk_size;
    const int16_t *pa = a->volume.voxels, *pb = b->volume.voxels;
    for (int32_t k = 0; k < d.z; k++)
        for (int32_t j = 0; j < d.y; j++) {
            diff_chunk *row = chunks + (int64_t)cd.x * (j / n + (int64_t)cd.y * (k / n));
            for (int32_t i = 0; i < d.x; i += n) {
                const int32_t at[3] = {i, j, k}, part = n < d.x - i ? n : d.x - i;
                compare_part(a, b, pa + i, pb + i, part, at, limit, row + i / n, axis, out);
            }
            pa += d.x;
            pb += d.x;
        }
}

static ost_pm magnitude(ost_pm v)
{
    return v < 0 ? -v : v;
}

/*
 * Returns the largest absolute coordinate of a voxel centre on one axis. The first or the last centre has this
 * coordinate.
 */
static ost_pm farthest(ost_pm origin, ost_pm spacing, int32_t n)
{
    const ost_pm first = magnitude(origin), last = magnitude(origin + spacing * (n - 1));
    return first > last ? first : last;
}

/*
 * Compares spacings and origins. Some file formats store lengths as decimal numbers, others as float32. A conversion
 * between the two changes a length by at most 2^-24 of the length. Two spacings are therefore considered equal if they
 * differ by at most 2^-23 of the greater spacing. Two origins are considered equal if they differ by at most 2^-23 of
 * the coordinate of the farthest centre. If spacings and origins are equal in this sense, the positions of a voxel in
 * the two grids differ by much less than the size of the voxel.
 */
static void compare_geometry(const ost_geometry *a, const ost_geometry *b, diff_result *out)
{
    const ost_pm spacing[2][3] = {{a->spacing.x, a->spacing.y, a->spacing.z},
                                  {b->spacing.x, b->spacing.y, b->spacing.z}};
    const ost_pm origin[2][3] = {{a->origin.x, a->origin.y, a->origin.z}, {b->origin.x, b->origin.y, b->origin.z}};
    const int32_t dims[3] = {a->dims.x, a->dims.y, a->dims.z};
    out->same_spacing = out->same_origin = true;
    bool exact = true;
    for (int x = 0; x < 3; x++) {
        const ost_pm apart = magnitude(spacing[0][x] - spacing[1][x]), moved = magnitude(origin[0][x] - origin[1][x]);
        const ost_pm greater = spacing[0][x] > spacing[1][x] ? spacing[0][x] : spacing[1][x];
        const ost_pm far = farthest(origin[0][x], greater, dims[x]);
        out->same_spacing = out->same_spacing && apart <= greater >> 23;
        out->same_origin = out->same_origin && moved <= far >> 23;
        exact = exact && apart == 0 && moved == 0;
    }
    out->rounded_geometry = !exact && out->same_spacing && out->same_origin;
}

ost_status diff_compare(const loaded_volume *a, const loaded_volume *b, int chunk_size, size_t limit, diff_result *out,
                        ost_error *err)
{
    const ost_geometry *ga = &a->volume.geometry, *gb = &b->volume.geometry;
    out->chunk_size = chunk_size;
    out->same_dims = ga->dims.x == gb->dims.x && ga->dims.y == gb->dims.y && ga->dims.z == gb->dims.z;
    compare_geometry(ga, gb, out);
    /* A tool's corner is exact, but its origin is rounded if the voxel size is an odd number of picometres. Therefore
       the corners of tools are compared. Only osteon's own files contain tools, so no tolerance is needed. */
    if (a->kind == LOAD_TOOL) {
        out->same_spacing = a->tool.voxel == b->tool.voxel;
        out->same_origin = memcmp(&a->tool.corner, &b->tool.corner, sizeof a->tool.corner) == 0;
        out->rounded_geometry = false;
    }
    if (!out->same_dims) {
        diff_patterns(a, b, out);
        return OST_OK;
    }
    out->chunk_dims = (ost_dims){(ga->dims.x + chunk_size - 1) / chunk_size, (ga->dims.y + chunk_size - 1) / chunk_size,
                                 (ga->dims.z + chunk_size - 1) / chunk_size};
    size_t chunk_count = (size_t)ost_dims_count(out->chunk_dims);
    int64_t *axis[3];
    int64_t *axes = axis_counts(ga->dims, axis);
    diff_chunk *chunks = calloc(chunk_count, sizeof *chunks);
    out->first = calloc(limit ? limit : 1, sizeof *out->first);
    if (!axes || !chunks || !out->first) {
        free(axes);
        free(chunks);
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for the comparison of %zu chunks", chunk_count);
    }
    compare_voxels(a, b, limit, chunks, axis, out);
    out->busiest[0] = most(axis[0], ga->dims.x);
    out->busiest[1] = most(axis[1], ga->dims.y);
    out->busiest[2] = most(axis[2], ga->dims.z);
    free(axes);

    for (size_t c = 0; c < chunk_count; c++)
        if (chunks[c].different) {
            diff_chunk *entry = &chunks[out->chunk_count++];
            *entry = chunks[c];
            entry->at[0] = (int32_t)(c % (size_t)out->chunk_dims.x);
            entry->at[1] = (int32_t)(c / (size_t)out->chunk_dims.x % (size_t)out->chunk_dims.y);
            entry->at[2] = (int32_t)(c / (size_t)out->chunk_dims.x / (size_t)out->chunk_dims.y);
        }
    out->chunks = chunks;
    out->equal = out->same_spacing && out->same_origin && out->different == 0;
    if (!out->equal)
        diff_patterns(a, b, out);
    return OST_OK;
}

void diff_free(diff_result *result)
{
    free(result->chunks);
    free(result->first);
    *result = (diff_result){0};
}
