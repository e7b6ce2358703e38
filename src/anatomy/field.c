/* SPDX-License-Identifier: Apache-2.0 */
#include "core/conditions.h"

#include "anatomy/field.h"

#include <stdlib.h>
#include <string.h>

enum { CELLS_MAX = 1 << 24 };

static bool is_bone(const ost_anatomy_bone *bone, int16_t value)
{
    return value >= bone->low && value <= bone->high;
}

/*
 * Computes the share of bone voxels in each block of by[0] x by[1] x by[2] voxels. The first block begins at voxel
 * first[].
 */
static void count_blocks(const ost_anatomy_bone *bone, const int32_t first[3], const int32_t last[3],
                         const int32_t by[3], anatomy_field *f)
{
    const ost_dims d = bone->volume->geometry.dims;
    for (int32_t z = first[2]; z < last[2]; z++)
        for (int32_t y = first[1]; y < last[1]; y++) {
            const int16_t *row = bone->volume->voxels + (size_t)d.x * ((size_t)y + (size_t)d.y * (size_t)z);
            float *cells = f->share + anatomy_field_index(f, 0, (y - first[1]) / by[1], (z - first[2]) / by[2]);
            for (int32_t x = first[0], cell = 0, left = by[0]; x < last[0]; x++) {
                cells[cell] += is_bone(bone, row[x]) ? 1.0f : 0.0f;
                if (--left == 0) {
                    cell++;
                    left = by[0];
                }
            }
        }
    /* The last block along each axis may contain fewer voxels. */
    int32_t c[3];
    for (c[2] = 0; c[2] < f->n[2]; c[2]++)
        for (c[1] = 0; c[1] < f->n[1]; c[1]++)
            for (c[0] = 0; c[0] < f->n[0]; c[0]++) {
                int64_t voxels = 1;
                for (int a = 0; a < 3; a++) {
                    const int32_t begin = first[a] + c[a] * by[a], end = begin + by[a];
                    voxels *= (end < last[a] ? end : last[a]) - begin;
                }
                f->share[anatomy_field_index(f, c[0], c[1], c[2])] /= (float)voxels;
            }
}

ost_status ost_anatomy_field_make(const ost_anatomy_bone *bone, const anatomy_box *box, double step, anatomy_field *out,
                                  ost_error *err)
{
    const ost_geometry *g = &bone->volume->geometry;
    const double spacing[3] = {ost_pm_to_mm(g->spacing.x), ost_pm_to_mm(g->spacing.y), ost_pm_to_mm(g->spacing.z)};
    const double origin[3] = {ost_pm_to_mm(g->origin.x), ost_pm_to_mm(g->origin.y), ost_pm_to_mm(g->origin.z)};
    const int32_t dims[3] = {g->dims.x, g->dims.y, g->dims.z};
    int32_t first[3], last[3], by[3];
    int64_t cells;
    *out = (anatomy_field){.share = NULL};
    for (int a = 0; a < 3; a++) {
        first[a] = 0;
        last[a] = dims[a];
        if (!box)
            continue;
        const double lo = (box->lo[a] - origin[a]) / spacing[a], hi = (box->hi[a] - origin[a]) / spacing[a] + 1;
        first[a] = lo <= 0 ? 0 : lo >= dims[a] ? dims[a] : (int32_t)anatomy_floor(lo);
        last[a] = hi <= 0 ? 0 : hi >= dims[a] ? dims[a] : (int32_t)anatomy_floor(hi) + 1;
        last[a] = last[a] < dims[a] ? last[a] : dims[a];
        if (first[a] >= last[a])
            return ost_fail(err, OST_ERR_INPUT, "the volume ends before the region in which the bone is searched");
    }
    for (;; step *= 1.25) {
        cells = 1;
        for (int a = 0; a < 3; a++) {
            by[a] = step <= spacing[a] ? 1 : (int32_t)anatomy_floor(step / spacing[a] + 0.5);
            out->n[a] = (last[a] - first[a] + by[a] - 1) / by[a];
            out->step[a] = by[a] * spacing[a];
            out->origin[a] = origin[a] + spacing[a] * (first[a] + 0.5 * (by[a] - 1));
            cells *= out->n[a];
        }
        if (cells <= CELLS_MAX)
            break;
    }
    out->share = calloc((size_t)cells, sizeof *out->share);
    if (!out->share)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %lld cells", (long long)cells);
    count_blocks(bone, first, last, by, out);
    return OST_OK;
}

void ost_anatomy_field_free(anatomy_field *field)
{
    free(field->share);
    field->share = NULL;
}

/* ------------------------------------------------------------------- fill */

ost_status ost_anatomy_field_fill(anatomy_field *f, ost_error *err)
{
    const size_t cells = (size_t)f->n[0] * (size_t)f->n[1] * (size_t)f->n[2];
    bool *outside = calloc(cells, sizeof *outside);
    uint32_t *stack = malloc(cells * sizeof *stack);
    size_t depth = 0;
    if (!outside || !stack) {
        free(outside);
        free(stack);
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %zu cells", cells);
    }
    int32_t c[3];
    size_t i = 0;
    for (c[2] = 0; c[2] < f->n[2]; c[2]++)
        for (c[1] = 0; c[1] < f->n[1]; c[1]++)
            for (c[0] = 0; c[0] < f->n[0]; c[0]++, i++) {
                bool border = false;
                for (int a = 0; a < 3; a++)
                    border = border || c[a] == 0 || c[a] == f->n[a] - 1;
                if (border && f->share[i] < 0.5f) {
                    outside[i] = true;
                    stack[depth++] = (uint32_t)i;
                }
            }
    const size_t stride[3] = {1, (size_t)f->n[0], (size_t)f->n[0] * (size_t)f->n[1]};
    while (depth) {
        const size_t at = stack[--depth];
        for (int a = 0; a < 3; a++) {
            const int32_t k = (int32_t)(at / stride[a] % (size_t)f->n[a]);
            for (int side = 0; side < 2; side++) {
                const size_t next = side ? at + stride[a] : at - stride[a];
                if ((side ? k + 1 == f->n[a] : k == 0) || outside[next] || !(f->share[next] < 0.5f))
                    continue;
                outside[next] = true;
                stack[depth++] = (uint32_t)next;
            }
        }
    }
    /* Cells with a share of at least 0.5 keep their share, so the surface does not move. */
    for (i = 0; i < cells; i++)
        if (!outside[i] && f->share[i] < 0.5f)
            f->share[i] = 1;
    free(outside);
    free(stack);
    return OST_OK;
}

/* ----------------------------------------------------------------- smooth */

ost_status ost_anatomy_field_smooth(anatomy_field *f, ost_error *err)
{
    const size_t cells = (size_t)f->n[0] * (size_t)f->n[1] * (size_t)f->n[2];
    const size_t stride[3] = {1, (size_t)f->n[0], (size_t)f->n[0] * (size_t)f->n[1]};
    double narrowest = f->step[0];
    for (int a = 1; a < 3; a++)
        narrowest = f->step[a] < narrowest ? f->step[a] : narrowest;
    float *copy = malloc(cells * sizeof *copy);
    if (!copy)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %zu cells", cells);
    for (int a = 0; a < 3; a++) {
        if (f->step[a] > 1.5 * narrowest)
            continue;
        memcpy(copy, f->share, cells * sizeof *copy);
        for (size_t i = 0; i < cells; i++) {
            const size_t k = i / stride[a] % (size_t)f->n[a];
            const float before = k ? copy[i - stride[a]] : copy[i],
                        after = k + 1 < (size_t)f->n[a] ? copy[i + stride[a]] : copy[i];
            f->share[i] = (before + 2 * copy[i] + after) * 0.25f;
        }
    }
    free(copy);
    return OST_OK;
}

/* ---------------------------------------------------------------- samples */

double ost_anatomy_field_at(const anatomy_field *f, const double at[3])
{
    int32_t cell[3];
    double t[3], sum = 0;
    for (int a = 0; a < 3; a++) {
        const double v = (at[a] - f->origin[a]) / f->step[a];
        if (!(v > -1 && v < f->n[a]))
            return 0;
        cell[a] = (int32_t)anatomy_floor(v);
        t[a] = v - cell[a];
    }
    for (int corner = 0; corner < 8; corner++) {
        double weight = 1;
        int32_t c[3];
        bool inside = true;
        for (int a = 0; a < 3; a++) {
            const int up = corner >> a & 1;
            c[a] = cell[a] + up;
            weight *= up ? t[a] : 1 - t[a];
            inside = inside && c[a] >= 0 && c[a] < f->n[a];
        }
        if (inside)
            sum += weight * (double)f->share[anatomy_field_index(f, c[0], c[1], c[2])];
    }
    return sum;
}

void ost_anatomy_field_gradient(const anatomy_field *f, const double at[3], double out[3])
{
    for (int a = 0; a < 3; a++) {
        double before[3] = {at[0], at[1], at[2]}, after[3] = {at[0], at[1], at[2]};
        before[a] -= f->step[a];
        after[a] += f->step[a];
        out[a] = (ost_anatomy_field_at(f, after) - ost_anatomy_field_at(f, before)) / (2 * f->step[a]);
    }
}
