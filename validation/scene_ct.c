/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Makes random CTs as samples. The bone consists of solids, shells or speckle. Its densities include critical values:
 * the threshold and its neighbours, the borders of classes, and the ends of the range of int16. A sample lies up to an
 * eighth of a voxel away from its lattice point. Some voxels have two samples.
 */
#include "validation/scene_parts.h"

#include <stdlib.h>

static int16_t telling_density(draw *d, int32_t threshold)
{
    static const int16_t borders[] = {149, 150, 649, 650, 32767, -32768, 0, -1, -1024, 1};
    const int which = (int)draw_between(d, 0, 9);
    if (which < 3)
        return (int16_t)(threshold - which + 1 > 32767 ? 32767 : threshold - which + 1);
    if (which < 5)
        return borders[draw_between(d, 0, 9)];
    return (int16_t)draw_between(d, -1024, 3000);
}

/* Returns true if a voxel belongs to the bone. The parameter `kind` selects its shape: the complete CT, a ball, a
   shell, speckle or slabs. */
static bool in_bone(int kind, const int32_t at[3], const ost_dims dims, draw *d)
{
    const int64_t x = 2 * at[0] - dims.x + 1, y = 2 * at[1] - dims.y + 1, z = 2 * at[2] - dims.z + 1;
    const int64_t least = dims.x < dims.y ? (dims.x < dims.z ? dims.x : dims.z) : (dims.y < dims.z ? dims.y : dims.z);
    const int64_t square = x * x + y * y + z * z, outer = least * least, inner = outer / 2;
    switch (kind) {
    case 0: return true;
    case 1: return square <= outer;
    case 2: return square <= outer && square >= inner;
    case 3: return draw_one_in(d, 7);
    default: return (at[0] / 5 + at[2] / 3) % 2 == 0;
    }
}

/* Returns the position of a lattice point or, if `jitter` is true, a random position within an eighth of a voxel of
   it. */
static ost_pm near_lattice(draw *d, ost_pm origin, ost_pm spacing, int32_t index, bool jitter)
{
    const ost_pm off = jitter ? draw_between(d, -spacing / 8, spacing / 8) : 0;
    return origin + spacing * index + off;
}

ost_status scene_ct(scene *s, draw *d, ost_dims dims, ost_error *err)
{
    static const int sizes[] = {32, 16, 64};
    const bool jitter = draw_one_in(d, 2);
    const int kind = (int)draw_between(d, 0, 4);
    s->rect.dims = dims;
    s->chunk_size = sizes[draw_between(d, 0, 2)];
    if (s->threshold == 0)
        s->threshold = draw_one_in(d, 2) ? 120 : (int32_t)draw_between(d, 1, 700);
    s->batch = (size_t)draw_between(d, 1, 20000);
    const size_t voxels = (size_t)ost_dims_count(dims);
    s->samples = malloc((voxels + voxels / 8 + 1) * sizeof *s->samples);
    if (!s->samples)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %zu samples", voxels);
    size_t n = 0;
    for (int32_t k = 0; k < dims.z; k++)
        for (int32_t j = 0; j < dims.y; j++)
            for (int32_t i = 0; i < dims.x; i++) {
                const int32_t at[3] = {i, j, k};
                ost_sample one = {.line = 0};
                one.x = near_lattice(d, s->rect.origin.x, s->rect.spacing.x, i, jitter);
                one.y = near_lattice(d, s->rect.origin.y, s->rect.spacing.y, j, jitter);
                one.z = near_lattice(d, s->rect.origin.z, s->rect.spacing.z, k, jitter);
                one.density = in_bone(kind, at, dims, d) ? telling_density(d, s->threshold) : -1000;
                if (!draw_one_in(d, 40)) /* one voxel in 40 has no sample and keeps the density 0 */
                    s->samples[n++] = one;
                if (s->duplicates != OST_DUPLICATES_ERROR && draw_one_in(d, 12)) {
                    one.density = telling_density(d, s->threshold);
                    s->samples[n++] = one;
                }
            }
    /* Apart from the rule for duplicates, the result of a scatter does not depend on the order of the samples. The
       order may therefore be random. */
    if (draw_one_in(d, 2))
        for (size_t i = n; i > 1; i--) {
            const size_t other = (size_t)draw_between(d, 0, (int64_t)i - 1);
            const ost_sample swap = s->samples[i - 1];
            s->samples[i - 1] = s->samples[other];
            s->samples[other] = swap;
        }
    for (size_t i = 0; i < n; i++)
        s->samples[i].line = (uint32_t)(i % s->batch);
    s->sample_count = n;
    return OST_OK;
}

ost_status scene_ct_drifting(scene *s, draw *d, ost_dims dims, ost_error *err)
{
    const int64_t voxels = ost_dims_count(dims);
    const ost_geometry *g = &s->rect;
    s->rect.dims = dims;
    s->chunk_size = 32;
    s->threshold = 120;
    s->duplicates = OST_DUPLICATES_ERROR;
    s->batch = 5000;
    s->samples = malloc((size_t)voxels * sizeof *s->samples);
    if (!s->samples)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %lld samples", (long long)voxels);
    for (int32_t k = 0; k < dims.z; k++)
        for (int32_t j = 0; j < dims.y; j++)
            for (int32_t i = 0; i < dims.x; i++) {
                const int64_t n = (int64_t)s->sample_count++;
                s->samples[n] = (ost_sample){.x = g->origin.x + g->spacing.x * i + SCENE_DRIFT * (n + 1) / voxels,
                                             .y = g->origin.y + g->spacing.y * j,
                                             .z = g->origin.z + g->spacing.z * k,
                                             .density = telling_density(d, s->threshold),
                                             .line = (uint32_t)((size_t)n % s->batch)};
            }
    return OST_OK;
}

ost_status scene_ct_of_volume(scene *s, const ost_volume *volume, ost_error *err)
{
    const ost_geometry *g = &volume->geometry;
    const size_t voxels = (size_t)ost_dims_count(g->dims);
    s->rect = *g;
    s->batch = 1 << 16;
    s->samples = malloc((voxels + 1) * sizeof *s->samples);
    if (!s->samples)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %zu samples", voxels);
    size_t n = 0;
    for (int32_t k = 0; k < g->dims.z; k++)
        for (int32_t j = 0; j < g->dims.y; j++)
            for (int32_t i = 0; i < g->dims.x; i++, n++)
                s->samples[n] = (ost_sample){g->origin.x + g->spacing.x * i, g->origin.y + g->spacing.y * j,
                                             g->origin.z + g->spacing.z * k, volume->voxels[n],
                                             (uint32_t)(n % s->batch)};
    s->sample_count = n;
    return OST_OK;
}

ost_density_classes scene_classes(int count, int step)
{
    ost_density_classes classes = {.count = count};
    for (int i = 0; i < count; i++) {
        classes.border[i] = (int16_t)(1 + step * i);
        classes.name[i][0] = (char)('a' + i);
    }
    return classes;
}
