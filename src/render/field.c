/* SPDX-License-Identifier: Apache-2.0 */
/* The smooth field that the shaded view draws (field.h). */
#include <stdlib.h>
#include <string.h>

#include "render/field.h"

enum { MARGIN = 3 };
#define FIELD_SAMPLES_MAX (INT64_C(1) << 28) /* beyond it, only every second, third, ... voxel is sampled */

bool ost_field_bounds(const ost_volume *volume, int32_t threshold, int lo[3], int hi[3])
{
    ost_dims d = volume->geometry.dims;
    lo[0] = d.x, lo[1] = d.y, lo[2] = d.z;
    hi[0] = hi[1] = hi[2] = 0;
    const int16_t *row = volume->voxels;
    for (int k = 0; k < d.z; k++)
        for (int j = 0; j < d.y; j++, row += d.x) {
            int first = 0, last = d.x - 1;
            while (first < d.x && row[first] < threshold)
                first++;
            if (first == d.x)
                continue;
            while (row[last] < threshold)
                last--;
            lo[0] = first < lo[0] ? first : lo[0];
            hi[0] = last + 1 > hi[0] ? last + 1 : hi[0];
            lo[1] = j < lo[1] ? j : lo[1];
            hi[1] = j + 1 > hi[1] ? j + 1 : hi[1];
            lo[2] = k < lo[2] ? k : lo[2];
            hi[2] = k + 1;
        }
    return hi[2] > 0;
}

/*
 * Blurs one line of n samples, `stride` apart, with the binomial weights 1 4 6 4 1, or 1 2 1
 * where samples are far apart.
 */
static void blur_line(uint8_t *v, int n, size_t stride, bool wide, uint8_t *line)
{
    for (int i = 0; i < n; i++)
        line[i + 2] = v[(size_t)i * stride];
    line[0] = line[1] = line[n + 2] = line[n + 3] = 0;
    for (int i = 0; i < n; i++) {
        const uint8_t *c = line + i;
        unsigned sum = wide ? c[0] + 4u * c[1] + 6u * c[2] + 4u * c[3] + c[4] : 4u * (c[1] + 2u * c[2] + c[3]);
        v[(size_t)i * stride] = (uint8_t)((sum + 8) >> 4);
    }
}

static ost_status blur(ost_field_level *level, const double step_mm[3], ost_error *err)
{
    const int *n = level->n;
    int longest = n[0] > n[1] ? n[0] : n[1];
    longest = n[2] > longest ? n[2] : longest;
    uint8_t *line = malloc((size_t)longest + 4);
    if (!line)
        return ost_fail(err, OST_ERR_MEMORY, "no memory for a line of %d samples", longest);
    double least = step_mm[0] < step_mm[1] ? step_mm[0] : step_mm[1];
    least = step_mm[2] < least ? step_mm[2] : least;
    size_t sx = 1, sy = (size_t)n[0], sz = sy * (size_t)n[1];
    for (int k = 0; k < n[2]; k++)
        for (int j = 0; j < n[1]; j++)
            blur_line(level->v + (size_t)j * sy + (size_t)k * sz, n[0], sx, step_mm[0] < 2.5 * least, line);
    for (int k = 0; k < n[2]; k++)
        for (int i = 0; i < n[0]; i++)
            blur_line(level->v + (size_t)i + (size_t)k * sz, n[1], sy, step_mm[1] < 2.5 * least, line);
    for (int j = 0; j < n[1]; j++)
        for (int i = 0; i < n[0]; i++)
            blur_line(level->v + (size_t)i + (size_t)j * sy, n[2], sz, step_mm[2] < 2.5 * least, line);
    free(line);
    return OST_OK;
}

static ost_status halve(const ost_field_level *fine, ost_field_level *coarse, ost_error *err)
{
    size_t count = 1;
    for (int a = 0; a < 3; a++) {
        coarse->n[a] = (fine->n[a] + 1) / 2;
        count *= (size_t)coarse->n[a];
    }
    coarse->v = malloc(count);
    if (!coarse->v)
        return ost_fail(err, OST_ERR_MEMORY, "no memory for %zu samples", count);
    uint8_t *out = coarse->v;
    for (int k = 0; k < coarse->n[2]; k++)
        for (int j = 0; j < coarse->n[1]; j++)
            for (int i = 0; i < coarse->n[0]; i++) {
                unsigned sum = 0;
                for (int c = 0; c < 8; c++) {
                    int x = 2 * i + (c & 1), y = 2 * j + (c >> 1 & 1), z = 2 * k + (c >> 2);
                    if (x < fine->n[0] && y < fine->n[1] && z < fine->n[2])
                        sum += fine->v[(size_t)x + (size_t)fine->n[0] * ((size_t)y + (size_t)fine->n[1] * (size_t)z)];
                }
                *out++ = (uint8_t)((sum + 4) >> 3);
            }
    return OST_OK;
}

static ost_status find_bricks(ost_field *field, ost_error *err)
{
    const ost_field_level *l = &field->level[0];
    size_t count = 1;
    for (int a = 0; a < 3; a++) {
        field->bricks[a] = (l->n[a] + OST_FIELD_BRICK - 1) / OST_FIELD_BRICK;
        count *= (size_t)field->bricks[a];
    }
    field->brick_max = malloc(count);
    if (!field->brick_max)
        return ost_fail(err, OST_ERR_MEMORY, "no memory for %zu bricks", count);
    uint8_t *out = field->brick_max;
    for (int bz = 0; bz < field->bricks[2]; bz++)
        for (int by = 0; by < field->bricks[1]; by++)
            for (int bx = 0; bx < field->bricks[0]; bx++) {
                int b[3] = {bx, by, bz}, lo[3], hi[3];
                for (int a = 0; a < 3; a++) {
                    lo[a] = b[a] * OST_FIELD_BRICK - 1;
                    hi[a] = lo[a] + OST_FIELD_BRICK + 2;
                    lo[a] = lo[a] < 0 ? 0 : lo[a];
                    hi[a] = hi[a] > l->n[a] ? l->n[a] : hi[a];
                }
                uint8_t max = 0;
                for (int z = lo[2]; z < hi[2]; z++)
                    for (int y = lo[1]; y < hi[1]; y++) {
                        const uint8_t *row = l->v + (size_t)l->n[0] * ((size_t)y + (size_t)l->n[1] * (size_t)z);
                        for (int x = lo[0]; x < hi[0]; x++)
                            max = row[x] > max ? row[x] : max;
                    }
                *out++ = max;
            }
    return OST_OK;
}

ost_status ost_field_init(ost_field *field, const ost_volume *volume, const int lo[3], const int hi[3], ost_field_pick *pick,
                          const void *user, int levels, ost_error *err)
{
    memset(field, 0, sizeof *field);
    const ost_geometry *g = &volume->geometry;
    int64_t stride = 1, count = 1;
    for (;; stride++) {
        count = 1;
        for (int a = 0; a < 3; a++)
            count *= (hi[a] - lo[a] + stride - 1) / stride + 2 * MARGIN;
        if (count <= FIELD_SAMPLES_MAX)
            break;
    }
    double spacing[3] = {ost_pm_to_mm(g->spacing.x), ost_pm_to_mm(g->spacing.y), ost_pm_to_mm(g->spacing.z)};
    double origin[3] = {ost_pm_to_mm(g->origin.x), ost_pm_to_mm(g->origin.y), ost_pm_to_mm(g->origin.z)};
    ost_field_level *l = &field->level[0];
    for (int a = 0; a < 3; a++) {
        l->n[a] = (int)((hi[a] - lo[a] + stride - 1) / stride) + 2 * MARGIN;
        field->step_mm[a] = spacing[a] * (double)stride;
        field->origin_mm[a] = origin[a] + spacing[a] * lo[a] - field->step_mm[a] * MARGIN;
    }
    l->v = calloc((size_t)count, 1);
    if (!l->v)
        return ost_fail(err, OST_ERR_MEMORY, "no memory for %lld samples", (long long)count);
    for (int k = MARGIN; k < l->n[2] - MARGIN; k++)
        for (int j = MARGIN; j < l->n[1] - MARGIN; j++) {
            uint8_t *row = l->v + (size_t)l->n[0] * ((size_t)j + (size_t)l->n[1] * (size_t)k);
            int64_t y = lo[1] + (j - MARGIN) * stride, z = lo[2] + (k - MARGIN) * stride;
            size_t at = (size_t)(lo[0] + g->dims.x * (y + g->dims.y * z));
            for (int i = MARGIN; i < l->n[0] - MARGIN; i++, at += (size_t)stride)
                pick(user, at, &row[i]);
        }
    ost_status status = blur(l, field->step_mm, err);
    field->levels = 1;
    while (status == OST_OK && field->levels < levels && field->levels < OST_FIELD_LEVELS) {
        status = halve(&field->level[field->levels - 1], &field->level[field->levels], err);
        field->levels++;
    }
    if (status == OST_OK)
        status = find_bricks(field, err);
    if (status != OST_OK)
        ost_field_free(field);
    return status;
}

void ost_field_free(ost_field *field)
{
    for (int i = 0; i < OST_FIELD_LEVELS; i++)
        free(field->level[i].v);
    free(field->brick_max);
    memset(field, 0, sizeof *field);
}

/*
 * Sample i of level k is the mean of samples 2^k i .. 2^k (i + 1) - 1: its centre is at 2^k (i +
 * 1/2) - 1/2.
 */
float ost_field_at(const ost_field *field, int level, const float p[3])
{
    static const float shrink[OST_FIELD_LEVELS] = {1.0f, 0.5f, 0.25f, 0.125f, 0.0625f, 0.03125f, 0.015625f};
    const ost_field_level *l = &field->level[level];
    float f[3];
    int i[3];
    for (int a = 0; a < 3; a++) {
        float c = (p[a] + 0.5f) * shrink[level] - 0.5f;
        if (!(c > -1.0f && c < (float)l->n[a]))
            return 0.0f;
        i[a] = c < 0.0f ? 0 : (int)c;
        if (i[a] > l->n[a] - 2)
            i[a] = l->n[a] > 1 ? l->n[a] - 2 : 0;
        f[a] = c - (float)i[a];
        /* beyond the border: the outermost samples, which the margin leaves empty */
        f[a] = f[a] < 0.0f ? 0.0f : f[a] > 1.0f ? 1.0f : f[a];
    }
    size_t sy = (size_t)l->n[0], sz = sy * (size_t)l->n[1];
    const uint8_t *v = l->v + (size_t)i[0] + sy * (size_t)i[1] + sz * (size_t)i[2];
    size_t sx = l->n[0] > 1;
    sy = l->n[1] > 1 ? sy : 0;
    const uint8_t *w = l->n[2] > 1 ? v + sz : v;
    float x00 = (float)v[0] + f[0] * (float)(v[sx] - v[0]), x10 = (float)v[sy] + f[0] * (float)(v[sy + sx] - v[sy]);
    float x01 = (float)w[0] + f[0] * (float)(w[sx] - w[0]), x11 = (float)w[sy] + f[0] * (float)(w[sy + sx] - w[sy]);
    float y0 = x00 + f[1] * (x10 - x00), y1 = x01 + f[1] * (x11 - x01);
    return (y0 + f[2] * (y1 - y0)) * (1.0f / 255.0f);
}
