/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Determines the tool voxel of every active bone voxel at one pose (AR-MAP). The bone is processed in blocks, as in
 * docs/spec/arithmetic.md, with 64-bit integers. This code uses neither the rule of far blocks nor the event's boxes.
 * If a backend omits voxels because of a mistake in this rule or in the boxes, its results therefore differ from the
 * results of this code. A block is skipped only if the coordinates of all its corners lie beyond one side of the tool.
 * This test is sufficient because the coordinates are linear.
 */
#include "validation/dense/parts.h"

enum { BLOCK = 16, ONE = 1 << 20 };

/* The map of a pose in the form that this stage uses. It may contain deliberate mistakes. */
typedef struct pose {
    deviant *m;
    const ost_map *map;
    uint64_t number;
    int128 column[3][3];
    int64_t step[3][3]; /* steps of the map, without a mistake */
    int64_t used[3][3]; /* the steps that are used, which a mistake may have changed */
    bool drifting, negative_cut, border_in, all_cuts;
    const ost_voxel_box *tight; /* the mistake omits the last layer of this box; NULL for other mistakes */
} pose;

/* Returns the low 24 bits of v as a signed number. */
static int64_t low24(int64_t v)
{
    return ((v & 0xffffff) ^ 0x800000) - 0x800000;
}

static pose prepare(deviant *m, const ost_map *map, const ost_voxel_box *box, uint64_t number)
{
    pose p = {.m = m, .map = map, .number = number};
    const int128 divisor = dense_int128(map->divisor);
    const bool transposed = deviates(m, DEVIATION_TRANSPOSED_MATRIX, number),
               cut = deviates(m, DEVIATION_TRUNCATED_STEP, number), narrow = deviates(m, DEVIATION_MUL24, number);
    for (int b = 0; b < 3; b++)
        for (int a = 0; a < 3; a++) {
            p.column[b][a] = dense_int128(transposed ? map->column[a][b] : map->column[b][a]);
            p.step[b][a] = (int64_t)dense_nearest(dense_int128(map->column[b][a]), divisor);
            p.used[b][a] = cut ? (int64_t)(dense_int128(map->column[b][a]) / divisor)
                               : (int64_t)dense_nearest(p.column[b][a], divisor);
            if (narrow)
                p.used[b][a] = low24(p.used[b][a]);
            if (p.used[b][a] != p.step[b][a])
                deviant_acted(m, number, NULL);
        }
    p.drifting = deviates(m, DEVIATION_DRIFTING_MAP, 0);
    p.negative_cut = deviates(m, DEVIATION_TRUNCATED_NEGATIVE, number);
    p.border_in = deviates(m, DEVIATION_BORDER_INCLUDED, number);
    p.all_cuts = deviates(m, DEVIATION_NON_CUTTING_CUTS, 0);
    p.tight = deviates(m, DEVIATION_TIGHT_BOX, number) ? box : NULL;
    return p;
}

static int64_t wrapped(int64_t v)
{
    return (int32_t)(uint32_t)(uint64_t)v;
}

/* Computes the base of AR-MAP-4 for the block whose first voxel is f. Sets *wraps to true if, by mistake, the
   coordinates of the block are taken modulo 2^32. */
static void base_of(const pose *p, uint64_t item, const int32_t f[3], int64_t base[3], bool *wraps)
{
    deviant *m = p->m;
    const ost_map *map = p->map;
    const bool cut = deviates(m, DEVIATION_WRONG_MAP_ROUNDING, item), floats = deviates(m, DEVIATION_FLOAT_BASE, item),
               far = deviates(m, DEVIATION_WRAPPED_FAR_BLOCK, item);
    const int128 divisor = dense_int128(map->divisor);
    *wraps = false;
    for (int a = 0; a < 3; a++) {
        const int128 origin = dense_int128(map->origin[a]);
        int128 exact = origin;
        for (int b = 0; b < 3; b++)
            exact += f[b] * dense_int128(map->column[b][a]);
        const int128 made = origin + f[0] * p->column[0][a] + f[1] * p->column[1][a] + f[2] * p->column[2][a];
        const int64_t right = (int64_t)dense_nearest(exact, divisor);
        base[a] = (int64_t)dense_nearest(made, divisor);
        if (cut)
            base[a] = (int64_t)dense_floor(exact, divisor);
        if (p->drifting)
            base[a] = (int64_t)dense_nearest(origin, divisor) + f[0] * p->step[0][a] +
                      f[1] * p->step[1][a] + f[2] * p->step[2][a];
        if (floats) {
            const double by = (double)divisor;
            float sum = (float)((double)origin / by);
            for (int b = 0; b < 3; b++)
                sum += (float)f[b] * (float)((double)dense_int128(map->column[b][a]) / by);
            base[a] = (int64_t)sum;
        }
        if (far && right != wrapped(right))
            *wraps = true;
        if (base[a] != right || *wraps)
            deviant_acted(m, item, f);
    }
}

/* Returns the class of the tool voxel at a coordinate. Voxels outside the tool's grid are empty. */
static uint8_t class_at(const pose *p, const dense_tool *tool, const int64_t u[3], const int32_t v[3])
{
    const ost_dims dims = tool->base.geometry.dims;
    const int32_t d[3] = {dims.x, dims.y, dims.z};
    int64_t at[3];
    for (int a = 0; a < 3; a++) {
        at[a] = u[a] >> 20; /* floor(u / 2^20) (AR-CC-1) */
        const int64_t right = at[a];
        if (p->negative_cut)
            at[a] = u[a] / ONE;
        if (at[a] < 0 || at[a] >= d[a] + p->border_in)
            return OST_TOOL_VOID;
        if (at[a] != right || at[a] == d[a])
            deviant_acted(p->m, p->number, v);
    }
    const int64_t index = dense_at(dims, at[0], at[1], at[2]);
    uint8_t found = index < ost_dims_count(dims) ? tool->voxels[index] : OST_TOOL_VOID;
    if (p->all_cuts && found == OST_TOOL_NONCUTTING) {
        deviant_acted(p->m, 0, v);
        found = OST_TOOL_CUTTING;
    }
    return found;
}

/* Returns true if the voxel is outside the box p->tight or in the last layer of this box along an axis. Returns false
   if p->tight is NULL. */
static bool left_out(const pose *p, const int32_t v[3])
{
    if (!p->tight)
        return false;
    for (int a = 0; a < 3; a++)
        if (v[a] < p->tight->lo[a] || v[a] >= p->tight->hi[a] - 1) {
            deviant_acted(p->m, p->number, v);
            return true;
        }
    return false;
}

/* Returns true if, along one axis, all coordinates of the block lie on one side of the tool. No voxel of the block can
   then be in the tool. */
static bool apart(const pose *p, const dense_tool *tool, const int64_t base[3])
{
    const ost_dims dims = tool->base.geometry.dims;
    const int64_t d[3] = {dims.x, dims.y, dims.z};
    for (int a = 0; a < 3; a++) {
        int64_t least = base[a], greatest = base[a];
        for (int b = 0; b < 3; b++) {
            const int64_t way = (BLOCK - 1) * p->used[b][a];
            *(way < 0 ? &least : &greatest) += way;
        }
        if (greatest < (p->negative_cut ? -ONE : 0) || least >= (d[a] + p->border_in) * ONE)
            return true;
    }
    return false;
}

/* Marks the voxels of a block. `previous` is the base of the previous block, which the mistake MISSED_BARRIER uses. */
static void map_block(const pose *p, const dense_bone *bone, const dense_tool *tool, uint64_t item, const int32_t f[3],
                      const int64_t base[3], const int64_t previous[3], bool wraps, dense_marks marks)
{
    const ost_dims d = bone->base.geometry.dims;
    const bool early = deviates(p->m, DEVIATION_MISSED_BARRIER, item);
    if (!early && !wraps && apart(p, tool, base))
        return;
    for (int32_t dz = 0; dz < BLOCK && f[2] + dz < d.z; dz++)
        for (int32_t dy = 0; dy < BLOCK && f[1] + dy < d.y; dy++)
            for (int32_t dx = 0; dx < BLOCK && f[0] + dx < d.x; dx++) {
                const int32_t v[3] = {f[0] + dx, f[1] + dy, f[2] + dz};
                const int64_t at = dense_at(d, v[0], v[1], v[2]);
                int64_t u[3];
                if (p->m ? !bone->active[at] : bone->density[at] == 0)
                    continue;
                const bool stale = early && dz >= BLOCK / 2;
                for (int a = 0; a < 3; a++) {
                    u[a] = (stale ? previous[a] : base[a]) + dx * p->used[0][a] + dy * p->used[1][a] +
                           dz * p->used[2][a];
                    if (wraps)
                        u[a] = wrapped(u[a]);
                }
                if (stale)
                    deviant_acted(p->m, item, v);
                const uint8_t found = class_at(p, tool, u, v);
                if (found != OST_TOOL_VOID && !left_out(p, v))
                    dense_mark(bone, marks, v, found);
            }
}

void dense_map_pose(deviant *m, const dense_bone *bone, const dense_tool *tool, const ost_map *map,
                    const ost_voxel_box *box, int number, dense_marks marks)
{
    const ost_dims d = bone->base.geometry.dims;
    const pose p = prepare(m, map, box, (uint64_t)number);
    int64_t base[3], previous[3] = {0, 0, 0};
    uint64_t item = (uint64_t)number << 32;
    for (int32_t z = 0; z < d.z; z += BLOCK)
        for (int32_t y = 0; y < d.y; y += BLOCK)
            for (int32_t x = 0; x < d.x; x += BLOCK, item++) {
                const int32_t f[3] = {x, y, z};
                bool wraps;
                base_of(&p, item, f, base, &wraps);
                map_block(&p, bone, tool, item, f, base, previous, wraps, marks);
                for (int a = 0; a < 3; a++)
                    previous[a] = base[a];
            }
}
