/* SPDX-License-Identifier: Apache-2.0 */
/* Computes the margins of events: the distance from a bone voxel's position in the tool to the nearest tool voxel that
   would give the other result, over the poses of the event. */
#include "validation/margin_parts.h"

#include <stdlib.h>

#include "core/int128.h"
#include "validation/resample.h"

static bool is_cutting(const trace_block_view *tool, const int64_t c[3])
{
    const ost_dims d = tool->dims;
    if (c[0] < 0 || c[1] < 0 || c[2] < 0 || c[0] >= d.x || c[1] >= d.y || c[2] >= d.z)
        return false;
    return tool->voxels[margin_at(d, (int32_t)c[0], (int32_t)c[1], (int32_t)c[2])] == OST_TOOL_CUTTING;
}

static void cell_of(const int64_t u[3], int64_t c[3])
{
    for (int a = 0; a < 3; a++)
        c[a] = ost_floor_div(u[a], MARGIN_ONE);
}

static int64_t gap_to(int64_t u, int64_t cell, int64_t step)
{
    return step > 0 ? (cell + step) * MARGIN_ONE - u : step < 0 ? u - (cell + step + 1) * MARGIN_ONE : 0;
}

/*
 * Returns the Chebyshev distance from u to the nearest tool voxel that cuts or, if `cutting` is false, to the
 * nearest one that does not cut; -1 if there is none. The search visits rings of voxels around the voxel that
 * contains u. The distance from u to a voxel in ring r is at most r, and the distance to a voxel in a later
 * ring is at least r. Therefore the first ring that contains a voxel of the required type contains the
 * nearest one.
 */
static int64_t nearest(const trace_block_view *tool, const int64_t u[3], bool cutting)
{
    const int64_t dims[3] = {tool->dims.x, tool->dims.y, tool->dims.z};
    int64_t cell[3], first = 0, last = 0;
    cell_of(u, cell);
    /* the rings before `first` and after `last` lie outside the grid */
    for (int a = 0; a < 3; a++) {
        const int64_t before = -cell[a], after = cell[a] - (dims[a] - 1);
        const int64_t near = before > after ? before : after,
                      far = cell[a] > dims[a] - 1 - cell[a] ? cell[a] : dims[a] - 1 - cell[a];
        first = near > first ? near : first;
        last = far > last ? far : last;
    }
    if (!cutting)
        first = 0;
    for (int64_t r = first; r <= last + 1; r++) {
        int64_t best = -1, lo[3], hi[3];
        for (int a = 0; a < 3; a++) { /* voxels outside the grid are empty, so one layer of them is sufficient */
            lo[a] = -r < -cell[a] - 1 ? -cell[a] - 1 : -r;
            hi[a] = r > dims[a] - cell[a] ? dims[a] - cell[a] : r;
        }
        for (int64_t z = lo[2]; z <= hi[2]; z++)
            for (int64_t y = lo[1]; y <= hi[1]; y++) {
                const bool side = z == -r || z == r || y == -r || y == r;
                for (int64_t x = side ? lo[0] : -r; x <= hi[0]; x += side ? 1 : 2 * r) {
                    const int64_t c[3] = {cell[0] + x, cell[1] + y, cell[2] + z};
                    if (x < lo[0] || is_cutting(tool, c) != cutting)
                        continue;
                    int64_t gap = gap_to(u[0], cell[0], x);
                    gap = gap_to(u[1], cell[1], y) > gap ? gap_to(u[1], cell[1], y) : gap;
                    gap = gap_to(u[2], cell[2], z) > gap ? gap_to(u[2], cell[2], z) : gap;
                    best = best < 0 || gap < best ? gap : best;
                }
            }
        if (best >= 0)
            return best;
    }
    return -1;
}

/* Maps a voxel by AR-MAP. If the voxel is outside the blocks that can meet the tool, uses the exact map. */
static void mapped(const ost_map *map, const int32_t at[3], int64_t u[3])
{
    int32_t base[3];
    const bool near = ost_map_block_base(
        map, (ost_dims){at[0] / OST_MAP_BLOCK, at[1] / OST_MAP_BLOCK, at[2] / OST_MAP_BLOCK}, base);
    for (int a = 0; a < 3; a++) {
        if (near)
            u[a] = base[a] + (int64_t)(at[0] % OST_MAP_BLOCK) * map->step[0][a] +
                   (int64_t)(at[1] % OST_MAP_BLOCK) * map->step[1][a] +
                   (int64_t)(at[2] % OST_MAP_BLOCK) * map->step[2][a];
        else
            u[a] = (int64_t)ost_rhe_div128(ost_i128_of(map->origin[a]) + at[0] * ost_i128_of(map->column[0][a]) +
                                               at[1] * ost_i128_of(map->column[1][a]) +
                                               at[2] * ost_i128_of(map->column[2][a]),
                                           ost_i128_of(map->divisor));
    }
}

/* Returns an array with one map for each pose of this tick's event. `poses` is the number of poses. Returns NULL if the
   tick has no event or memory is exhausted. */
static ost_map *maps_of(const margin_walk *w, size_t tick, uint64_t poses)
{
    const ost_tick *now = &w->s->path.ticks[tick];
    const ost_geometry bone = {
        w->dims, {w->s->cubic, w->s->cubic, w->s->cubic}, resample_origin(&w->s->rect, w->s->cubic)};
    if (poses < 1 || poses > OST_SWEEP_MAX)
        return NULL;
    ost_map *maps = malloc((size_t)poses * sizeof *maps);
    for (uint64_t k = 1; k <= poses && maps; k++) {
        const ost_pose pose = poses == 1 || w->event_tick < 0 ? now->pose
                                                              : ost_sweep_pose(&w->s->path.ticks[w->event_tick].pose,
                                                                               &now->pose, (int)k, (int)poses);
        if (ost_map_make(&pose, &bone, &w->s->tools[now->tool].cutting.grid, &maps[k - 1], NULL) != OST_OK) {
            free(maps);
            maps = NULL;
        }
    }
    return maps;
}

/* Counts one voxel that is equal in both bones before this tick but not after it. */
static void judge_voxel(margin_walk *w, uint32_t tick, const ost_map *maps, uint64_t poses, const int32_t at[3],
                        bool ref_removed, bool got_removed)
{
    margin_stage *m = &w->out->of[TRACE_TICK];
    const int tool_index = w->s->path.ticks[tick].tool;
    const trace_block_view *tool = &w->tool[0][tool_index], *theirs = &w->tool[w->apart ? 0 : 1][tool_index];
    int64_t margin = -1;
    bool their_answer = false;
    if (!maps || ref_removed == got_removed) {
        margin_other(m, &m->unexplained);
        return;
    }
    for (uint64_t k = 0; k < poses; k++) {
        int64_t u[3], c[3];
        mapped(&maps[k], at, u);
        cell_of(u, c);
        their_answer = their_answer || is_cutting(theirs, c);
        /* A removed voxel would have the other result if all poses that cut it had missed it. A voxel that was not
           removed would have the other result if the nearest pose had cut it. */
        if (ref_removed && is_cutting(tool, c)) {
            const int64_t out = nearest(tool, u, false);
            margin = out > margin ? out : margin;
        } else if (!ref_removed) {
            const int64_t in = nearest(tool, u, true);
            margin = in >= 0 && (margin < 0 || in < margin) ? in : margin;
        }
    }
    if (theirs->voxels != tool->voxels && their_answer == got_removed)
        margin_other(m, &m->inherited);
    else if (margin >= 0)
        margin_decided(m, (uint64_t)margin, tick, at);
    else
        margin_other(m, &m->unexplained);
}

static uint64_t word_of(const trace_record *r, uint64_t index)
{
    uint64_t count;
    const uint8_t *words;
    return trace_words(r, &count, &words) && index < count ? trace_word_at(words, index) : 0;
}

static bool fits(const trace_block_view *b, ost_dims d)
{
    return b->voxel_bytes == 2 && b->lo[0] >= 0 && b->lo[1] >= 0 && b->lo[2] >= 0 && b->lo[0] + b->dims.x <= d.x &&
           b->lo[1] + b->dims.y <= d.y && b->lo[2] + b->dims.z <= d.z;
}

/* Counts the voxels of a record that are equal in both bones before this tick and differ after it. The first
   pass applies the changes of both records and stores the old values. The second pass compares the old and the
   new values. */
ost_status margin_tick(margin_walk *w, const trace_record *a, const trace_record *b, ost_error *err)
{
    const uint32_t tick = a->item;
    const uint64_t poses = word_of(a, 3);
    const trace_record *sides[2] = {a, b};
    if (tick >= w->s->path.count || !w->bone[0])
        return ost_fail(err, OST_ERR_INPUT, "a trace has tick %u, the case has %zu", (unsigned)tick, w->s->path.count);
    ost_map *maps = NULL;
    bool made = false;
    /* A changed voxel and its old values in both bones, which the new values overwrite. */
    typedef struct change {
        size_t at;
        int16_t value[2];
    } change;
    change *changes = NULL;
    size_t count = 0, capacity = 0;
    for (int side = 0; side < 2; side++) {
        size_t walk_at = 0;
        trace_block_view block;
        while (trace_next_block(sides[side], &walk_at, &block)) {
            if (!fits(&block, w->dims))
                continue;
            const size_t n = (size_t)ost_dims_count(block.dims);
            for (size_t i = 0; i < n; i++) {
                int32_t in[3];
                margin_position(block.dims, i, in);
                const size_t at = margin_at(w->dims, block.lo[0] + in[0], block.lo[1] + in[1], block.lo[2] + in[2]);
                const int16_t value = (int16_t)margin_value16(&block, i);
                if (value == w->bone[side][at])
                    continue;
                if (count == capacity) {
                    capacity = capacity ? 2 * capacity : 256;
                    change *grown = realloc(changes, capacity * sizeof *grown);
                    if (!grown) {
                        free(changes);
                        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a tick's changes");
                    }
                    changes = grown;
                }
                changes[count++] = (change){at, {w->bone[0][at], w->bone[1][at]}};
                w->bone[side][at] = value;
            }
        }
    }
    for (size_t i = 0; i < count; i++) {
        const size_t at = changes[i].at;
        const int16_t *was = changes[i].value;
        /* A voxel that both backends changed has two entries. The first entry has the old values of both backends. In
           the second entry, value[0] is already the new value of backend 0. If the old values were equal, value[0] and
           value[1] therefore differ, and the second entry is skipped. */
        if (was[0] != was[1] || w->bone[0][at] == w->bone[1][at])
            continue;
        int32_t position_at[3];
        margin_position(w->dims, at, position_at);
        if (!made) {
            maps = maps_of(w, tick, poses);
            made = true;
        }
        judge_voxel(w, tick, maps, poses, position_at, w->bone[0][at] == 0 && was[0] != 0,
                    w->bone[1][at] == 0 && was[1] != 0);
    }
    /* In the next tick, both backends start from the reference's bone. */
    for (size_t i = 0; i < count && w->apart; i++)
        w->bone[1][changes[i].at] = w->bone[0][changes[i].at];
    free(changes);
    free(maps);
    if (word_of(a, 1) || w->s->path.ticks[tick].rpm == 0)
        w->event_tick = tick;
    return OST_OK;
}
