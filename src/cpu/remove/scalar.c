/* SPDX-License-Identifier: Apache-2.0 */
/* The scalar kernels of removal. The tests compare the variants for all instruction sets with these kernels. */
#include "core/conditions.h"
#include "cpu/kernels.h"

void ost_blocks_scalar(const ost_block_bases *bases, const ost_block_reach *reach, const int32_t first[3],
                       const int32_t from[3], const int32_t to[3], ost_cubes *blocks)
{
    size_t n = 0;
    for (int32_t z = from[2]; z < to[2]; z++)
        for (int32_t y = from[1]; y < to[1]; y++)
            for (int32_t x = from[0]; x < to[0]; x++) {
                int32_t base[3];
                const bool exists = ost_block_base(bases, (const int32_t[3]){x, y, z}, base);
                for (int a = 0; a < 3; a++)
                    blocks->u[a][n] = base[a];
                blocks->number[n] = x - first[0] + 2 * (y - first[1]) + 4 * (z - first[2]);
                n += exists && ost_block_in_reach(reach, base);
            }
    blocks->count = n;
}

static int32_t cell_of(const ost_cells *cells, int32_t u, int axis)
{
    const int32_t c = (u >> cells->shift) + cells->margin, last = cells->dims[axis] - 1;
    return c < 0 ? 0 : c > last ? last : c;
}

void ost_split_scalar(const ost_split *split, const ost_cells *cells, const ost_cubes *cubes, const uint64_t *occupancy,
                      ost_cubes *mixed, ost_numbers *inside)
{
    size_t m = mixed->count, n = inside->count;
    for (size_t i = 0; i < cubes->count; i++)
        for (int part = 0; part < 8; part++) {
            const int32_t number = cubes->number[i] * 8 + part;
            if (occupancy && !occupancy[number])
                continue;
            int32_t c[3];
            for (int a = 0; a < 3; a++)
                c[a] = cell_of(cells, cubes->u[a][i] + split->centre[a][part], a);
            const int32_t v = cells->value[c[0] + cells->dims[0] * (c[1] + (int64_t)cells->dims[1] * c[2])];
            for (int a = 0; a < 3; a++)
                mixed->u[a][m] = cubes->u[a][i] + split->first[a][part];
            mixed->number[m] = number;
            inside->number[n] = number;
            m += v > -split->least && v < split->least;
            n += v >= split->least;
        }
    mixed->count = m;
    inside->count = n;
}

/* Computes the hits of a brick by reading one bit of the tool for each voxel of the brick. */
static uint64_t match_voxels(const ost_match *match, const int32_t u[3])
{
    const ost_shape *s = match->shape;
    uint64_t hits = 0;
    for (int v = 0; v < 64; v++) {
        const int32_t x = (u[0] + match->offset[0][v]) >> OST_MAP_FRACTION,
                      y = (u[1] + match->offset[1][v]) >> OST_MAP_FRACTION,
                      z = (u[2] + match->offset[2][v]) >> OST_MAP_FRACTION;
        if (x >= 0 && x < s->dims[0] && y >= 0 && y < s->dims[1] && z >= 0 && z < s->dims[2])
            hits |= (s->bits[(size_t)x / 64 + s->words * ((size_t)y + (size_t)s->dims[1] * (size_t)z)] >> (x % 64) & 1)
                    << v;
    }
    return hits;
}

/*
 * Computes the hits of a brick from one window with `edge` tool voxels per side. All voxels of the brick lie in this
 * window (remove.h, "Match").
 */
static uint64_t match_window(const ost_match *match, const ost_windows *w, int32_t edge, int32_t margin,
                             const int32_t u[3])
{
    int32_t from[3], window[3];
    for (int a = 0; a < 3; a++) {
        const int32_t voxel = ((u[a] + match->lowest[a]) >> OST_MAP_FRACTION) + margin;
        window[a] = voxel / w->step;
        from[a] = u[a] - (window[a] * w->step - margin) * (1 << OST_MAP_FRACTION);
    }
    const uint8_t
        *byte = w->line[w->index[window[0] + w->dims[0] * (window[1] + (size_t)w->dims[1] * (size_t)window[2])]];
    uint64_t hits = 0;
    for (int v = 0; v < 64; v++) {
        const int32_t x = (from[0] + match->offset[0][v]) >> OST_MAP_FRACTION,
                      y = (from[1] + match->offset[1][v]) >> OST_MAP_FRACTION,
                      z = (from[2] + match->offset[2][v]) >> OST_MAP_FRACTION;
        hits |= (uint64_t)(byte[edge * (edge * (x >> 3) + y) + z] >> (x & 7) & 1) << v;
    }
    return hits;
}

void ost_match_scalar(const ost_match *match, const ost_cubes *bricks, uint64_t *hits)
{
    for (size_t i = 0; i < bricks->count; i++) {
        const int32_t u[3] = {bricks->u[0][i], bricks->u[1][i], bricks->u[2][i]};
        hits[i] = match->windows ? match_window(match, &match->shape->windows, 8, OST_WINDOW_MARGIN, u)
                  : match->wide  ? match_window(match, &match->shape->wide, 16, OST_WIDE_MARGIN, u)
                                 : match_voxels(match, u);
    }
}

void ost_take_scalar(const ost_take *take, int16_t *density, const int32_t *number, const uint64_t *hits, size_t count,
                     ost_tally *tally)
{
    for (size_t i = 0; i < count; i++) {
        int16_t *brick = density + (size_t)number[i] * 64;
        for (uint64_t left = hits[i]; left; left &= left - 1) {
            const int v = __builtin_ctzll(left);
            tally->voxels[0]++;
            tally->density[0] += (uint64_t)brick[v];
            for (int b = 0; b < take->borders; b++) {
                tally->voxels[b + 1] += brick[v] >= take->border[b];
                tally->density[b + 1] += brick[v] >= take->border[b] ? (uint64_t)brick[v] : 0;
            }
            if (take->apply)
                brick[v] = 0;
        }
    }
}
