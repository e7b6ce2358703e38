/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Removal and collision (AR-MAP, AR-REM) by blocks, for CPUs, and the windows of a tool,
 * from which this kernel reads.
 *
 *   block 16^3 --- cubes 8^3 --- bricks 4^3 --- 64 voxels
 *
 * At each step, the tool's cell at the middle of a cube determines the class of the entire cube if the cell's reach is
 * at least the pose's complete[] (shared.h). Eight cubes are looked up at once. The tool voxels that a brick may
 * overlap lie in one window of 8^3 voxels, which has 64 bytes. If the window is full or empty, the brick is also full
 * or empty. Otherwise the bits for the voxels are selected from the window, sixteen at a time, by a tree of selections
 * instead of loads. If the tool's voxels are finer than the bone's, a brick may be larger than a window, and is then
 * looked up voxel by voxel.
 *
 *   word b + 4 k     the rows 4 b, 4 b + 1, 4 b + 2, 4 b + 3 of plane k, 16 bits each (variable `four`)
 *   group b + 4 c    the words b + 4 k of the planes k = 4 c to 4 c + 3: four bricks side by side along x
 *   brick            64 bits: voxel (x, y, z) is bit x + 4 z + 16 y, so that plane z is (bits >> 4 z) & OST_EACH_NIBBLE
 *
 * The vectors are vector types of OpenCL C (uint16, int8), so the compiler need not vectorize loops. The ranges are the
 * same as in remove.cl.
 *
 * The file has more than 500 lines, because all steps of one kernel are inlined into it.
 */
#if OST_FOR & 2

#ifdef __clang__
#if __has_warning("-Wpsabi") /* NVIDIA's compiler is a variant of clang without this warning */
/* Disables a warning about the calling convention for wide vectors. Only functions of this file pass wide vectors. */
#pragma clang diagnostic ignored "-Wpsabi"
#endif
#endif

#define OST_EACH_ROW 0x0001000100010001ul
#define OST_EACH_NIBBLE 0x000f000f000f000ful

__constant uint ost_lane_x[16] = {0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3};
__constant uint ost_lane_y[16] = {0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3};
/* For each lane, the index of its voxel's bit in plane 0, within one 32-bit half of the brick's word. */
__constant uint ost_lane_bit[16] = {0, 1, 2, 3, 16, 17, 18, 19, 0, 1, 2, 3, 16, 17, 18, 19};
__constant uint ost_part_x[8] = {0, 1, 0, 1, 0, 1, 0, 1};
__constant uint ost_part_y[8] = {0, 0, 1, 1, 0, 0, 1, 1};
__constant uint ost_part_z[8] = {0, 0, 0, 0, 1, 1, 1, 1};
__constant ushort ost_column_bit[16] = {1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096, 8192, 16384, 32768};

typedef struct ost_block_rows {
    /* bits of the voxels that were active before the event, four rows per word; valid if `loaded` is 1 */
    ulong active[64];
    ulong open[64];   /* bits of the voxels that are active and not yet hit, four rows per word */
    ulong touch[64];
    int loaded;
    /* one bit per group of rows; set in `hit` if a voxel was hit, and in `touched` if a voxel was touched */
    uint hit, touched;
    /* for rows 4 b to 4 b + 3 of every plane, the voxels whose x and y are in the pose's box */
    ulong inside[4];
    int lo, hi;        /* planes in the box */
    int within;        /* 1 if the pose's box contains the entire block */
} ost_block_rows;

/*
 * The map of a block for one pose. `at` contains the coordinates of the block's first voxel in tool cells, plus 2^30.
 * All numbers are unsigned. AR-MAP-5 gives the ranges of their sums.
 */
typedef struct ost_view {
    /* offsets from a brick's first voxel to the 16 voxels of the brick's first slice, x fastest */
    uint16 along[3];
    /* offsets from the first voxel to the middles of the eight parts: eighths[1] for a block, eighths[0] for a cube of
     * 8^3 voxels */
    uint8 eighths[2][3];
    uint at[3], step[3][3];
    uint lowest[3]; /* offset from the first voxel of a brick to the least coordinate of the brick, on each axis */
    int dims[3], wide[3]; /* dimensions of the tool's grid, and of its windows */
    /* number of planes of a window that a brick may overlap; 0 if a brick may exceed a window */
    int planes;
    uint complete[3];
} ost_view;

static void ost_load_rows(ost_block_rows *rows, __global const ushort *words, ulong corner, int n)
{
    if (rows->loaded)
        return;
    rows->loaded = 1;
    for (int k = 0; k < 16; k++)
        for (int b = 0; b < 4; b++) {
            const ulong at = (corner + (ulong)(n * (4 * b + n * k))) / 16, row = (ulong)n / 16;
            const ulong four = (ulong)words[at] | (ulong)words[at + row] << 16 | (ulong)words[at + 2 * row] << 32 |
                               (ulong)words[at + 3 * row] << 48;
            rows->active[b + 4 * k] = four;
            rows->open[b + 4 * k] = four;
            rows->touch[b + 4 * k] = 0;
        }
}

/*
 * Marks those voxels of a group that are covered by tool voxels of class c (1 or 2). The parameter `bits` contains the
 * covered voxels of each row.
 */
static void ost_mark_group(ost_block_rows *rows, uint c, ulong bits, int group)
{
    const int z = group / 4 * 4, z0 = ost_greatest(z, rows->lo), z1 = ost_least(z + 4, rows->hi);
    ulong changed = 0;
    for (int k = z0; k < z1; k++) {
        const ulong covered = rows->open[group % 4 + 4 * k] & rows->inside[group % 4] & bits;
        changed |= covered;
        if (c == 1)
            rows->open[group % 4 + 4 * k] ^= covered;
        else
            rows->touch[group % 4 + 4 * k] |= covered;
    }
    if (changed != 0 && c == 1)
        rows->hit |= 1u << group;
    else if (changed != 0)
        rows->touched |= 1u << group;
}

/* Marks all voxels of a cube of 4, 8 or 16 voxels per edge. The entire cube is covered by tool voxels of class c. */
static void ost_mark_cube(ost_block_rows *rows, uint c, int x, int y, int z, int edge)
{
    const uint bits = ((1u << edge) - 1u) << x;
    for (int k = z; k < z + edge; k += 4)
        for (int j = y / 4; j < (y + edge) / 4; j++)
            ost_mark_group(rows, c, bits * OST_EACH_ROW, j + k);
}

/* ------------------------------------------------------------- distances */

/*
 * Returns the class of all tool voxels that cover the block, or 3 if the cell at the block's middle does not determine
 * this class.
 */
static uint ost_block_class(const ost_view *view, __global const uchar *cells)
{
    int u[3];
    for (int a = 0; a < 3; a++) {
        const int sum = (int)view->step[0][a] + (int)view->step[1][a] + (int)view->step[2][a];
        u[a] = (int)(view->at[a] - 0x40000000u) + 15 * sum / 2;
    }
    const uint cell = ost_cell_at(cells, view->dims, u[0], u[1], u[2]);
    return cell >> 2 >= view->complete[2] ? cell & 3u : 3u;
}

/* Returns the offsets on axis a from a cube's first voxel to the middles of the cube's eight parts of edge^3 voxels. */
static uint8 ost_middles(const ost_view *view, int a, int edge)
{
    const int sum = (int)view->step[0][a] + (int)view->step[1][a] + (int)view->step[2][a];
    return vload8(0, ost_part_x) * ((uint)edge * view->step[0][a]) +
           vload8(0, ost_part_y) * ((uint)edge * view->step[1][a]) +
           vload8(0, ost_part_z) * ((uint)edge * view->step[2][a]) + (uint)((edge - 1) * sum / 2);
}

/*
 * Sets classes[p] for each of the eight parts of a cube to the class of the tool voxels that cover the part entirely,
 * or to 3 if the cells do not determine this class. (ux, uy, uz) are the coordinates of the cube's first voxel. The
 * parts have 8^3 voxels (level 1) or 4^3 voxels (level 0). Cells outside the grid have the values that ost_cell_at
 * returns. Returns 0 if all classes are 0.
 */
static int ost_part_classes(const ost_view *view, __global const uchar *cells, uint ux, uint uy, uint uz, int level,
                            int classes[8])
{
    const uint first[3] = {ux, uy, uz};
    int index_of[8], cell[8];
    int8 index = OST_ALL8(0), away = OST_ALL8(0);
    for (int a = 2; a >= 0; a--) {
        const int8 v = as_int8((view->eighths[level][a] + first[a]) >> 20u) - 1024;
        const int8 above = v & ~(v < 0), over = above > view->dims[a] - 1;
        const int8 c = (above & ~over) | (over & (view->dims[a] - 1));
        const int8 d = v - c, sign = d < 0, far = (d ^ sign) - sign, farther = far > away;
        index = index * view->dims[a] + c;
        away = (away & ~farther) | (far & farther);
    }
    vstore8(index, 0, index_of);
    for (int p = 0; p < 8; p++)
        cell[p] = cells[index_of[p]];
    const int8 found = vload8(0, cell), beyond = away > OST_CL_REACH_MAX, outside = away > 0;
    away = (away & ~beyond) | (beyond & OST_CL_REACH_MAX);
    int8 reach = found >> 2, kind = found & 3;
    const int8 of_void = reach & (kind == 0), nearer = away > of_void;
    reach = (reach & ~outside) | (((away & nearer) | (of_void & ~nearer)) & outside);
    kind = kind & ~outside;
    const int8 decided = reach >= (int)view->complete[level];
    const int8 result = (kind & decided) | (~decided & 3);
    vstore8(result, 0, classes);
    int any = 0;
    for (int p = 0; p < 8; p++)
        any |= classes[p];
    return any;
}

/* --------------------------------------------------------------- windows */

/* Returns the index, in the windows of a class, of the byte that contains tool voxel (x - 8, y - 8, z - 8). */
static int ost_window_index(const ost_view *view, int x, int y, int z)
{
    return y + view->wide[1] * (z + view->wide[2] * (x >> 1)); /* < 2^30 */
}

/* The window of a brick: a part of the tool's grid that contains all tool voxels that the brick may overlap. */
typedef struct ost_window {
    ulong plane[8];
    uint from[3]; /* position of the brick's first voxel in the window */
    ulong any, all;
} ost_window;

/* Loads the window of a brick. u is the coordinate of the brick's first voxel, plus 2^30. */
static void ost_open_window(ost_window *w, const ost_view *view, __global const uchar *windows, const uint u[3])
{
    int begin[3];
    /* The index may be clamped: all windows that lie entirely outside the grid are empty. */
    for (int a = 0; a < 3; a++)
        begin[a] = ost_least(ost_greatest((int)((u[a] + view->lowest[a]) >> 20) - 1016, 0), view->dims[a] + 8);
    begin[0] &= ~1;
    for (int a = 0; a < 3; a++)
        w->from[a] = u[a] - ((uint)(begin[a] + 1016) << 20);
    __global const uchar *from = windows + ost_window_index(view, begin[0], begin[1], begin[2]);
    ulong any = 0, all = ~0ul;
    for (int p = 0; p < 6; p++) {
        w->plane[p] = as_ulong(vload8(0, from + p * view->wide[1]));
        any |= w->plane[p];
        all &= w->plane[p];
    }
    w->plane[6] = w->plane[7] = 0;
    for (int p = 6; p < view->planes; p++) {
        w->plane[p] = as_ulong(vload8(0, from + p * view->wide[1]));
        any |= w->plane[p];
        all &= w->plane[p];
    }
    w->any = any;
    w->all = all;
}

/*
 * Returns the set of those voxels of a brick that are covered by tool voxels of the window's class. All coordinates
 * relative to the window must be in [0, 2^23).
 */
static ulong ost_lookup_window(const ost_view *view, const ost_window *w)
{
    if (w->any == 0 || w->all == ~0ul)
        return w->all;
    const ulong *plane = w->plane;
    const uint rx = w->from[0], ry = w->from[1], rz = w->from[2];
    const uint16 lane_bit = vload16(0, ost_lane_bit);
    uint16 bits = OST_ALL16(0u);
    for (uint k = 0; k < 4; k++) {
        const uint16 x = view->along[0] + (rx + k * view->step[2][0]), y = view->along[1] + (ry + k * view->step[2][1]);
        const uint16 z = view->along[2] + (rz + k * view->step[2][2]);
        const int16 z0 = (z & 0x100000u) != 0u, z1 = (z & 0x200000u) != 0u, z2 = (z & 0x400000u) != 0u,
                    y2 = (y & 0x400000u) != 0u;
        uint16 part[2];
        for (uint h = 0; h < 2; h++) {
            const uint16 p01 = select(OST_ALL16((uint)(plane[0] >> 32 * h)), OST_ALL16((uint)(plane[1] >> 32 * h)), z0);
            const uint16 p23 = select(OST_ALL16((uint)(plane[2] >> 32 * h)), OST_ALL16((uint)(plane[3] >> 32 * h)), z0);
            uint16 upper = select(OST_ALL16((uint)(plane[4] >> 32 * h)), OST_ALL16((uint)(plane[5] >> 32 * h)), z0);
            if (view->planes > 6)
                upper = select(upper,
                               select(OST_ALL16((uint)(plane[6] >> 32 * h)), OST_ALL16((uint)(plane[7] >> 32 * h)), z0),
                               z1);
            part[h] = select(select(p01, p23, z1), upper, z2);
        }
        const uint16 row = select(part[0], part[1], y2), bit = (y >> 17u & 0x18u) | x >> 20u;
        bits |= (row >> bit & 1u) << (lane_bit + 4u * k);
    }
    uint of[16], low = 0, high = 0;
    vstore16(bits, 0, of);
    for (int v = 0; v < 8; v++) {
        low |= of[v];
        high |= of[8 + v];
    }
    return (ulong)high << 32 | low;
}

/*
 * Computes the result of ost_lookup_window by sixteen loads per plane, for a brick that may be larger than a window.
 * The pointer is volatile so that the loads stay separate, which is faster than the processor's gather instruction.
 */
static ulong ost_lookup(const ost_view *view, volatile __global const uchar *windows, const uint u[3])
{
    ulong bits = 0;
    for (uint k = 0; k < 4; k++) {
        const uint kx = u[0] + k * view->step[2][0], ky = u[1] + k * view->step[2][1], kz = u[2] + k * view->step[2][2];
        uint x[16], y[16], z[16], found[16];
        vstore16((view->along[0] + kx) >> 20u, 0, x);
        vstore16((view->along[1] + ky) >> 20u, 0, y);
        vstore16((view->along[2] + kz) >> 20u, 0, z);
        /* clamps coordinates outside the grid to the empty border of the table, so that each look-up is valid */
        for (int v = 0; v < 16; v++) {
            x[v] = ost_clamped(x[v], 1023u, 1024u + (uint)view->dims[0]) - 1016u;
            y[v] = ost_clamped(y[v], 1023u, 1024u + (uint)view->dims[1]) - 1016u;
            z[v] = ost_clamped(z[v], 1023u, 1024u + (uint)view->dims[2]) - 1016u;
            y[v] = (uint)ost_window_index(view, (int)x[v], (int)y[v], (int)z[v]);
        }
        for (int v = 0; v < 16; v++)
            found[v] = windows[y[v]];
        for (int v = 0; v < 16; v++)
            bits |= (ulong)(found[v] >> (x[v] & 1u) & 1u) << (v % 4 + 16 * (v / 4) + 4 * (int)k);
    }
    return bits;
}

/* Returns the set of those voxels of a brick that are open and lie in the pose's box. */
static ulong ost_open_of(const ost_block_rows *rows, int x, int y, int z)
{
    const int four = y / 4 + 4 * z;
    ulong open = 0;
    for (int k = 0; k < 4; k++)
        open |= (rows->open[four + 4 * k] >> x & OST_EACH_NIBBLE) << (4 * k);
    if (!rows->within) {
        const ulong row = (rows->inside[y / 4] >> x & OST_EACH_NIBBLE) * 0x1111ul;
        const uint planes = ost_bits16(rows->lo - z, rows->hi - z) & 0xfu;
        const ulong cut = (planes & 1u ? 0xful : 0ul) | (planes & 2u ? 0xf0ul : 0ul) | (planes & 4u ? 0xf00ul : 0ul) |
                          (planes & 8u ? 0xf000ul : 0ul);
        open &= row & cut * OST_EACH_ROW;
    }
    return open;
}

/*
 * At most eight bricks that are looked up in the windows, because no cell determines their class. `open` contains the
 * open voxels of each brick.
 */
typedef struct ost_bricks {
    int count;
    int at[8][3];
    uint u[8][3]; /* coordinates of each brick's first voxel, plus 2^30 */
    ulong open[8];
    ost_window window[8];
} ost_bricks;

/*
 * In the listed bricks, marks the voxels that are covered by tool voxels of class c. `windows` contains the windows of
 * this class. All windows are loaded before the first one is used, because they are far apart in memory.
 */
static void ost_match_bricks(ost_block_rows *rows, const ost_view *view, __global const uchar *windows,
                             ost_bricks *bricks, int c)
{
    for (int i = 0; i < bricks->count && view->planes > 0; i++)
        ost_open_window(&bricks->window[i], view, windows, bricks->u[i]);
    for (int i = 0; i < bricks->count; i++) {
        const int x = bricks->at[i][0], y = bricks->at[i][1], z = bricks->at[i][2], four = y / 4 + 4 * z;
        const ulong met = bricks->open[i] & (view->planes ? ost_lookup_window(view, &bricks->window[i])
                                                          : ost_lookup(view, windows, bricks->u[i]));
        if (met == 0)
            continue;
        const uint group = 1u << (y / 4 + z);
        rows->hit |= c == 1 ? group : 0u;
        rows->touched |= c == 1 ? 0u : group;
        for (int k = 0; k < 4; k++) {
            const ulong part = (met >> (4 * k) & OST_EACH_NIBBLE) << x;
            if (c == 1)
                rows->open[four + 4 * k] ^= part;
            else
                rows->touch[four + 4 * k] |= part;
        }
    }
}

/* ---------------------------------------------------------------- a pose */

static void ost_view_make(ost_view *view, const ost_cl_entry *entry, __global const ost_cl_pose *pose,
                          __global const ost_cl_event *event)
{
    for (int a = 0; a < 3; a++) {
        view->at[a] = (uint)entry->base[a] + 0x40000000u;
        view->dims[a] = event->tool_dims[a];
        view->lowest[a] = 0;
        for (int b = 0; b < 3; b++) {
            view->step[b][a] = (uint)pose->step[b][a];
            view->lowest[a] += pose->step[b][a] < 0 ? 3u * view->step[b][a] : 0u;
        }
        view->complete[a] = pose->complete[a];
    }
    view->wide[0] = OST_CL_WINDOWS_X(view->dims[0]);
    view->wide[1] = OST_CL_WINDOWS_Y(view->dims[1]);
    view->wide[2] = OST_CL_WINDOWS_Z(view->dims[2]);
    view->planes = pose->planes;
}

static void ost_box_make(ost_block_rows *rows, __global const ost_cl_pose *pose, const int first[3])
{
    const uint across = ost_bits16(pose->lo[0] - first[0], pose->hi[0] - first[0]);
    const uint along = ost_bits16(pose->lo[1] - first[1], pose->hi[1] - first[1]);
    for (int b = 0; b < 4; b++) {
        rows->inside[b] = 0;
        for (int j = 0; j < 4; j++)
            rows->inside[b] |= along >> (4 * b + j) & 1u ? (ulong)across << (16 * j) : 0ul;
    }
    rows->lo = pose->lo[2] - first[2];
    rows->hi = pose->hi[2] - first[2];
    rows->within = across == 0xffffu && along == 0xffffu && rows->lo <= 0 && rows->hi >= 16;
}

static void ost_run_pose(ost_block_rows *rows, const ost_cl_entry *entry, __global const ost_cl_event *event,
                         __global const uchar *cells, __global const uchar *windows, __global const ushort *words,
                         ulong corner, const int first[3])
{
    __global const ost_cl_pose *pose = &ost_poses_of(event)[entry->pose];
    int cubes[8], parts[8][8];
    ost_bricks bricks;
    ost_view view;
    ost_view_make(&view, entry, pose, event);
    const uint c16 = ost_block_class(&view, cells);
    if (c16 == 0)
        return;
    if (c16 != 3) {
        ost_load_rows(rows, words, corner, event->size);
        ost_box_make(rows, pose, first);
        ost_mark_cube(rows, c16, 0, 0, 0, 16);
        return;
    }
    for (int a = 0; a < 3; a++)
        view.eighths[1][a] = ost_middles(&view, a, 8);
    if (!ost_part_classes(&view, cells, view.at[0], view.at[1], view.at[2], 1, cubes))
        return;
    ost_load_rows(rows, words, corner, event->size);
    ost_box_make(rows, pose, first);
    for (int a = 0; a < 3; a++) {
        view.eighths[0][a] = ost_middles(&view, a, 4);
        view.along[a] = vload16(0, ost_lane_x) * view.step[0][a] + vload16(0, ost_lane_y) * view.step[1][a];
    }
    const ulong second = event->touches ? (ulong)view.wide[0] * (ulong)view.wide[1] * (ulong)view.wide[2] : 0ul;
    for (int cube = 0; cube < 8; cube++) {
        const int x = cube % 2 * 8, y = cube / 2 % 2 * 8, z = cube / 4 * 8;
        uint u[3];
        if (cubes[cube] == 1 || cubes[cube] == 2)
            ost_mark_cube(rows, (uint)cubes[cube], x, y, z, 8);
        for (int a = 0; a < 3; a++)
            u[a] = view.at[a] + (uint)x * view.step[0][a] + (uint)y * view.step[1][a] + (uint)z * view.step[2][a];
        if (cubes[cube] == 3 && !ost_part_classes(&view, cells, u[0], u[1], u[2], 0, parts[cube]))
            cubes[cube] = 0;
    }
    for (int cube = 0; cube < 8; cube++) {
        if (cubes[cube] != 3)
            continue;
        bricks.count = 0;
        for (int part = 0; part < 8; part++) {
            const int x = cube % 2 * 8 + part % 2 * 4, y = cube / 2 % 2 * 8 + part / 2 % 2 * 4,
                      z = cube / 4 * 8 + part / 4 * 4;
            if (parts[cube][part] == 1 || parts[cube][part] == 2)
                ost_mark_cube(rows, (uint)parts[cube][part], x, y, z, 4);
            if (parts[cube][part] != 3)
                continue;
            const int i = bricks.count;
            bricks.open[i] = ost_open_of(rows, x, y, z);
            bricks.at[i][0] = x;
            bricks.at[i][1] = y;
            bricks.at[i][2] = z;
            for (int a = 0; a < 3; a++)
                bricks.u[i][a] = view.at[a] + (uint)x * view.step[0][a] + (uint)y * view.step[1][a] +
                                 (uint)z * view.step[2][a];
            bricks.count += bricks.open[i] != 0;
        }
        ost_match_bricks(rows, &view, windows, &bricks, 1);
        if (second != 0)
            ost_match_bricks(rows, &view, windows + second, &bricks, 2);
    }
}

/* ---------------------------------------------------------------- a block */

/* The rows of the block that have hits, with their offsets in the pool and the voxels that are hit. */
typedef struct ost_hit_rows {
    int count;
    uint touched; /* number of voxels that are touched but not hit */
    ushort hit[256], left[256];
    uint row[256]; /* for each row, its offset in voxels from the block's first voxel */
} ost_hit_rows;

static void ost_list_hits(const ost_block_rows *rows, int n, ost_hit_rows *list)
{
    list->count = 0;
    list->touched = 0;
    for (int g = 0; g < 16; g++) {
        if (((rows->hit | rows->touched) >> g & 1u) == 0)
            continue;
        for (int k = g / 4 * 4; k < g / 4 * 4 + 4; k++) {
            const int four = g % 4 + 4 * k;
            const ulong open = rows->open[four], hit = rows->active[four] ^ open;
            list->touched += (uint)popcount(rows->touch[four] & open);
            if (hit == 0)
                continue;
            for (int r = 0; r < 4; r++) {
                list->hit[list->count] = (ushort)(hit >> 16 * r);
                list->left[list->count] = (ushort)(open >> 16 * r);
                list->row[list->count] = (uint)(n * (g % 4 * 4 + r + n * k));
                list->count += list->hit[list->count] != 0;
            }
        }
    }
}

/*
 * Counts the hit voxels whose density is at least `border`, and sums their densities. If `all` is true, `border` is
 * ignored, and all hit voxels are counted and summed.
 */
static void ost_sum_hits(const ost_hit_rows *list, __global const short *density, int all, short border, uint *voxels,
                         uint *sum)
{
    const ushort16 column = vload16(0, ost_column_bit);
    short16 count = as_short16(column ^ column);
    int16 sums = as_int16(OST_ALL16(0u));
    for (int i = 0; i < list->count; i++) {
        const short16 d = vload16(0, density + list->row[i]);
        short16 counts = (column & list->hit[i]) != (ushort)0;
        if (!all)
            counts &= d >= border;
        count -= counts; /* a lane counts at most 256 voxels */
        sums += convert_int16(d & counts);
    }
    short counted[16];
    int summed[16];
    vstore16(count, 0, counted);
    vstore16(sums, 0, summed);
    *voxels = *sum = 0;
    for (int i = 0; i < 16; i++) {
        *voxels += (uint)counted[i];
        *sum += (uint)summed[i];
    }
}

static void ost_clear_hits(const ost_hit_rows *list, __global short *density, __global ushort *words)
{
    const ushort16 column = vload16(0, ost_column_bit);
    for (int i = 0; i < list->count; i++) {
        const short16 hit = (column & list->hit[i]) != (ushort)0;
        vstore16(vload16(0, density + list->row[i]) & ~hit, 0, density + list->row[i]);
        words[list->row[i] / 16] = list->left[i];
    }
}

/*
 * Consecutive work items process blocks whose indices differ by OST_CL_BATCHES. Therefore a core that processes a range
 * of items processes blocks from all parts of the event.
 */
__kernel void ost_remove_blocks(__global const ost_cl_event *event, __global const uchar *cells,
                                __global const uchar *windows, __global short *density, __global ushort *words,
                                __global ost_cl_block_report *reports)
{
    const size_t batch = (event->blocks + OST_CL_BATCHES - 1) / OST_CL_BATCHES;
    if (batch == 0 || get_global_id(0) / batch >= OST_CL_BATCHES)
        return;
    const size_t index = get_global_id(0) % batch * OST_CL_BATCHES + get_global_id(0) / batch;
    if (index >= event->blocks)
        return;
    const ost_cl_block block = ost_blocks_of(event)[index];
    const int n = event->size, classes = event->classes;
    const ulong corner = (ulong)block.slot * ((ulong)n * (ulong)n * (ulong)n) +
                         (ulong)(block.first[0] % n + n * (block.first[1] % n + n * (block.first[2] % n)));
    ost_block_rows rows;
    ost_hit_rows list;
    rows.loaded = 0;
    rows.hit = rows.touched = 0;
    for (uint e = 0; e < block.entries; e++) {
        const ost_cl_entry entry = ost_entries_of(event)[block.entry + e];
        ost_run_pose(&rows, &entry, event, cells, windows, words, corner, block.first);
    }
    ost_list_hits(&rows, n, &list);

    /*
     * The sums for c cover the hit voxels whose density is at least border c; the sums for c = 0 cover all hit voxels.
     * The result of class c is the sums for c minus the sums for c + 1.
     */
    uint above = 0, above_sum = 0; /* the sums for c + 1 */
    for (int c = OST_CL_CLASSES - 1; c >= 0; c--) {
        uint voxels = 0, sum = 0;
        if (c == 0)
            ost_sum_hits(&list, density + corner, 1, 0, &voxels, &sum);
        else if (c < classes && list.count > 0)
            ost_sum_hits(&list, density + corner, 0, (short)event->border[c], &voxels, &sum);
        reports[index].voxels[c] = voxels - above;
        reports[index].density[c] = sum - above_sum;
        above = voxels;
        above_sum = sum;
    }
    reports[index].touched = list.touched;
    for (int i = 0; i < 3; i++)
        reports[index].unused[i] = 0;
    if (event->apply)
        ost_clear_hits(&list, density + corner, words + corner / 16);
}

/* ------------------------------------------------- the tool's windows */
__kernel void ost_tool_windows(__global const ost_cl_tool *tool, __global const uchar *classes, __global uchar *windows)
{
    const int nx = tool->dims[0], ny = tool->dims[1], nz = tool->dims[2];
    const size_t wx = (size_t)OST_CL_WINDOWS_X(nx), wy = (size_t)OST_CL_WINDOWS_Y(ny),
                 wz = (size_t)OST_CL_WINDOWS_Z(nz);
    if (get_global_id(0) >= wy || get_global_id(1) >= wz || get_global_id(2) >= wx * (size_t)tool->axis)
        return;
    const int second = get_global_id(2) >= wx;
    const int x = 2 * (int)(get_global_id(2) - (second ? wx : 0)) - 8, y = (int)get_global_id(0) - 8,
              z = (int)get_global_id(1) - 8;
    uint byte = 0;
    if (y >= 0 && y < ny && z >= 0 && z < nz)
        for (int b = ost_greatest(0, -x); b < ost_least(8, nx - x); b++)
            byte |= (classes[(ulong)(x + b) + (ulong)nx * ((ulong)y + (ulong)ny * (ulong)z)] == (second ? 2 : 1) ? 1u
                                                                                                                 : 0u)
                    << b;
    windows[get_global_id(0) + wy * (get_global_id(1) + wz * get_global_id(2))] = (uchar)byte;
}
#endif
