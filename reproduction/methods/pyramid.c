/* SPDX-License-Identifier: Apache-2.0 */
/* Computes the levels of a pyramid from the tool's voxels upwards, and determines the content of a box. */
#include "reproduction/methods/pyramid.h"

#include <stdlib.h>

enum { CELL_ANY = 1, CELL_ALL = 2 };

void pyramid_free(pyramid *p)
{
    for (int l = 0; l < p->levels; l++)
        free(p->flags[l]);
    *p = (pyramid){0};
}

/*
 * Returns the flags of a cell of the next lower level or, at the lowest level, of a tool voxel. Outside the tool's grid
 * no flag is set.
 */
static uint8_t flags_below(const pyramid *p, int level, const ost_tool_volume *tool, int32_t x, int32_t y, int32_t z)
{
    if (level > 0) {
        const int32_t *d = p->dims[level - 1];
        return x < d[0] && y < d[1] && z < d[2] ? p->flags[level - 1][x + (int64_t)d[0] * (y + (int64_t)d[1] * z)] : 0;
    }
    const ost_dims d = tool->geometry.dims;
    if (x >= d.x || y >= d.y || z >= d.z)
        return 0;
    return tool->voxels[x + (int64_t)d.x * (y + (int64_t)d.y * z)] == OST_TOOL_CUTTING ? CELL_ANY | CELL_ALL : 0;
}

bool pyramid_init(pyramid *p, const ost_tool_volume *tool)
{
    *p = (pyramid){.levels = 0};
    int32_t d[3] = {tool->geometry.dims.x, tool->geometry.dims.y, tool->geometry.dims.z};
    while (p->levels < PYRAMID_MAX && (d[0] > 1 || d[1] > 1 || d[2] > 1 || p->levels == 0)) {
        const int l = p->levels;
        for (int a = 0; a < 3; a++)
            p->dims[l][a] = d[a] = (d[a] + 1) / 2;
        uint8_t *at = malloc((size_t)d[0] * (size_t)d[1] * (size_t)d[2]);
        p->flags[l] = at;
        if (!at)
            return false;
        p->levels++;
        for (int32_t z = 0; z < d[2]; z++)
            for (int32_t y = 0; y < d[1]; y++)
                for (int32_t x = 0; x < d[0]; x++) {
                    uint8_t any = 0, all = CELL_ALL;
                    for (int c = 0; c < 8; c++) {
                        const uint8_t flags =
                            flags_below(p, l, tool, 2 * x + (c & 1), 2 * y + (c >> 1 & 1), 2 * z + (c >> 2));
                        any |= flags & CELL_ANY;
                        all &= flags;
                    }
                    *at++ = any | all;
                }
    }
    return true;
}

pyramid_found pyramid_content(const pyramid *p, const int32_t lo[3], const int32_t hi[3], const int32_t dims[3])
{
    int32_t span = 0, from[3], to[3];
    bool none = true, all = true;
    for (int a = 0; a < 3; a++) {
        if (hi[a] < 0 || lo[a] >= dims[a])
            return PYRAMID_NONE;
        all = all && lo[a] >= 0 && hi[a] < dims[a];
        from[a] = lo[a] < 0 ? 0 : lo[a];
        to[a] = hi[a] >= dims[a] ? dims[a] - 1 : hi[a];
        span = to[a] - from[a] > span ? to[a] - from[a] : span;
    }
    /*
     * Level l is the lowest level whose cells are at least half as long as the box, so the box overlaps at most three
     * cells along each axis.
     */
    int l = 0;
    while (l + 1 < p->levels && span >> (l + 1) > 1)
        l++;
    const int32_t *d = p->dims[l];
    for (int32_t z = from[2] >> (l + 1); z <= to[2] >> (l + 1); z++)
        for (int32_t y = from[1] >> (l + 1); y <= to[1] >> (l + 1); y++)
            for (int32_t x = from[0] >> (l + 1); x <= to[0] >> (l + 1); x++) {
                const uint8_t flags = p->flags[l][x + (int64_t)d[0] * (y + (int64_t)d[1] * z)];
                none = none && !(flags & CELL_ANY);
                all = all && (flags & CELL_ALL);
                if (!none && !all)
                    return PYRAMID_MIXED;
            }
    return none ? PYRAMID_NONE : PYRAMID_ALL;
}
