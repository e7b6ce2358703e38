/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Removal and collision (AR-MAP, AR-REM), in two kernels that do the same: one
 * whose items take rows (for GPUs), one whose items take blocks (for CPUs).
 *
 * By rows: an item takes rows of 16 voxels of a block, each through all poses
 * that may meet the block.
 *
 *   u = base + j step[1] + k step[2]      the row's first voxel in tool cells, times 2^20
 *   while voxels of the row are open
 *     look up the cell of one of them     its class, and its reach: all cells nearer than that have the class
 *     close all that it decides           skip[reach] on either side
 *
 *   row       . . # # # # # # # # # # # . . .     active
 *   tool        void     |   cutting                first look-up in the middle, then from the left
 *
 * Ranges: every sum fits int by AR-MAP-5, as do its parts.  An int coordinate u
 * in [-2^30, 2^31) plus 2^30 is an unsigned one in [0, 3 * 2^30), and
 * shifting that right by 20 gives its tool voxel plus 1024.
 */

#ifndef OST_ROWS
#define OST_ROWS 4
#endif

/* Class and reach of the tool at u. For what is outside see ost_cl_tool: the nearest cell of the grid is no farther from any
   other than u is, so if it is void its reach holds for u too. */
static uint ost_cell_at(__global const uchar *cells, const int dims[3], int ux, int uy, int uz)
{
    const int x = (int)(((uint)ux + 0x40000000u) >> 20) - 1024;
    const int y = (int)(((uint)uy + 0x40000000u) >> 20) - 1024;
    const int z = (int)(((uint)uz + 0x40000000u) >> 20) - 1024;
    const int cx = ost_greatest(0, ost_least(x, dims[0] - 1));
    const int cy = ost_greatest(0, ost_least(y, dims[1] - 1));
    const int cz = ost_greatest(0, ost_least(z, dims[2] - 1));
    const uint cell = cells[cx + dims[0] * (cy + dims[1] * cz)]; /* < 2^30 */
    if (x == cx && y == cy && z == cz)
        return cell;
    const int dx = x > cx ? x - cx : cx - x, dy = y > cy ? y - cy : cy - y, dz = z > cz ? z - cz : cz - z;
    const int away = ost_least(OST_CL_REACH_MAX, ost_greatest(dx, ost_greatest(dy, dz)));
    return (uint)ost_greatest(away, (cell & 3u) == 0 ? (int)(cell >> 2) : 0) << 2;
}

#if OST_FOR & 1
/* Of the open voxels of row (j, k) those that one pose hits, and in *touch also those that it touches. */
static uint ost_hits_of(const ost_cl_entry entry, __global const ost_cl_pose *pose, __global const uchar *cells, const int dims[3],
                        const int first[3], int j, int k, uint open, uint *touch)
{
    const int y = first[1] + j, z = first[2] + k;
    if (y < pose->lo[1] || y >= pose->hi[1] || z < pose->lo[2] || z >= pose->hi[2])
        return 0;
    const int sx = pose->step[0][0], sy = pose->step[0][1], sz = pose->step[0][2];
    const int ux = entry.base[0] + j * pose->step[1][0] + k * pose->step[2][0];
    const int uy = entry.base[1] + j * pose->step[1][1] + k * pose->step[2][1];
    const int uz = entry.base[2] + j * pose->step[1][2] + k * pose->step[2][2];
    uint left = open & ost_bits16(pose->lo[0] - first[0], pose->hi[0] - first[0]);
    uint hit = 0;
    int in_middle = 1;
    while (left != 0) {
        int i = ost_lowest_bit(left);
        if (in_middle)
            i = (i + 31 - (int)clz(left)) / 2;
        in_middle = 0;
        const uint cell = ost_cell_at(cells, dims, ux + i * sx, uy + i * sy, uz + i * sz);
        const int reach = pose->skip[cell >> 2];
        const uint decided = left & ost_bits16(i - reach, i + reach + 1);
        if ((cell & 3u) == 1)
            hit |= decided;
        else if ((cell & 3u) == 2)
            *touch |= decided;
        left &= ~decided;
    }
    return hit;
}

__kernel void ost_remove(__global const ost_cl_event *event, __global const ost_cl_block *blocks, __global const ost_cl_entry *entries,
                         __global const ost_cl_pose *poses, __global const uchar *cells, __global short *density,
                         __global ushort *words, volatile __global ost_cl_block_report *reports)
{
    const size_t index = get_global_id(0) / (256 / OST_ROWS);
    if (index >= event->blocks)
        return;
    const int first_row = (int)(get_global_id(0) % (256 / OST_ROWS)) * OST_ROWS;
    const ost_cl_block block = blocks[index];
    const int n = event->size;
    const int dims[3] = {event->tool_dims[0], event->tool_dims[1], event->tool_dims[2]};
    const ulong corner = (ulong)block.slot * ((ulong)n * (ulong)n * (ulong)n) +
                         (ulong)(block.first[0] % n + n * (block.first[1] % n + n * (block.first[2] % n)));

    /* At least border c (class 0: all): the classes' own are differences. */
    uint voxels[OST_CL_CLASSES], sums[OST_CL_CLASSES], touched = 0;
    for (int c = 0; c < OST_CL_CLASSES; c++)
        voxels[c] = sums[c] = 0;

    for (int row = first_row; row < first_row + OST_ROWS; row++) {
        const int j = row % 16, k = row / 16;
        const ulong v = corner + (ulong)(n * (j + n * k));
        const uint active = words[v / 16];
        uint open = active, touch = 0;
        for (uint e = 0; e < block.entries && open != 0; e++) {
            const ost_cl_entry entry = entries[block.entry + e];
            open &= ~ost_hits_of(entry, &poses[entry.pose], cells, dims, block.first, j, k, open, &touch);
        }
        const uint hit = active & ~open;
        touched += popcount(touch & open);
        if (hit == 0)
            continue;
        for (int c = 0; c < event->classes; c++) {
            const int border = c == 0 ? -32768 : event->border[c];
            uint count = 0, sum = 0;
            for (int i = 0; i < 16; i++) {
                const int d = density[v + (ulong)i];
                const uint counts = (hit >> i & 1u) != 0 && d >= border ? 1u : 0u;
                count += counts;
                sum += counts * (uint)d;
            }
            voxels[c] += count;
            sums[c] += sum;
        }
        if (event->apply) {
            for (int i = 0; i < 16; i++)
                if (hit >> i & 1u)
                    density[v + (ulong)i] = 0;
            words[v / 16] = (ushort)open;
        }
    }

    for (int c = 0; c < event->classes; c++) {
        const int next = c + 1 < event->classes;
        const uint count = voxels[c] - (next ? voxels[c + 1] : 0u);
        if (count == 0)
            continue;
        atomic_add(&reports[index].voxels[c], count);
        atomic_add(&reports[index].density[c], sums[c] - (next ? sums[c + 1] : 0u));
    }
    if (touched > 0)
        atomic_add(&reports[index].touched, touched);
}
#endif

#if OST_FOR & 2
/* ------------------------------------------------------ a block an item */
/*
 *   block 16^3 --- cubes 8^3 --- bricks 4^3 --- 64 voxels
 *
 * At each step the tool's cell at the middle of the cube decides it whole when
 * its reach is that of the pose's whole[] (shared.h), and what has no open
 * voxel is left.  The 64 voxels of a brick are looked up sixteen at once in
 * the packed classes, without a branch, so that compilers make vectors.
 *
 *   four             rows 4 b, 4 b + 1, 4 b + 2, 4 b + 3 of plane k, 16 bits each: number b + 4 k
 *   group b + 4 c    the fours of planes 4 c to 4 c + 3: the rows of a row of bricks
 */
typedef struct ost_block_rows {
    ulong open[64]; /* fours: active and not hit yet */
    ulong touch[64];
    uint any[16];      /* by group: what was open in one of its rows when the pose began */
    uint hit, touched; /* groups in which something was hit, was touched */
    ulong inside[4];   /* four b's part of the pose's box */
    int lo, hi;        /* planes in the box */
} ost_block_rows;

#define OST_EACH_ROW 0x0001000100010001ul

/* What the pose's class c (1, 2) covers of a group: the bits in each of its rows. */
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

/* A cube's of 4, 8 or 16 voxels. */
static void ost_mark_cube(ost_block_rows *rows, uint c, int x, int y, int z, int edge)
{
    const uint bits = ((1u << edge) - 1u) << x;
    for (int k = z; k < z + edge; k += 4)
        for (int j = y / 4; j < (y + edge) / 4; j++)
            if ((rows->any[j + k] & bits) != 0)
                ost_mark_group(rows, c, bits * OST_EACH_ROW, j + k);
}

/* Sixteen bits to four rows, four bits each. */
static ulong ost_to_rows(ulong bits)
{
    return (bits & 0xful) | (bits & 0xf0ul) << 12 | (bits & 0xf00ul) << 24 | (bits & 0xf000ul) << 36;
}

/* The block's first voxel in tool cells plus 2^30, and the steps: all as unsigned numbers, whose sums are those of AR-MAP-5. */
typedef struct ost_view {
    uint at[3], step[3][3];
    uint along[3][16]; /* from a brick's first voxel to those of its first slice, x fastest */
    uint limit[3];     /* 1024 + dims[a]: the void behind the tool */
    int width[2];      /* words in packed along x and y */
} ost_view;

/* The 64 voxels of a brick. */
static void ost_match_brick(ost_block_rows *rows, const ost_view *view, volatile __global const uint *packed, int x, int y, int z)
{
    const ulong mask = 0xful * OST_EACH_ROW << x & rows->inside[y / 4];
    const uint ux = view->at[0] + (uint)x * view->step[0][0] + (uint)y * view->step[1][0] + (uint)z * view->step[2][0];
    const uint uy = view->at[1] + (uint)x * view->step[0][1] + (uint)y * view->step[1][1] + (uint)z * view->step[2][1];
    const uint uz = view->at[2] + (uint)x * view->step[0][2] + (uint)y * view->step[1][2] + (uint)z * view->step[2][2];
    const int z1 = ost_least(z + 4, rows->hi);
    ulong hits = 0, touches = 0;
    for (int k = ost_greatest(z, rows->lo); k < z1; k++) {
        const int four = y / 4 + 4 * k;
        const ulong open = rows->open[four] & mask;
        if (open == 0)
            continue;
        const uint up = (uint)(k - z);
        const uint kx = ux + up * view->step[2][0], ky = uy + up * view->step[2][1], kz = uz + up * view->step[2][2];
        int place[16];
        uint bit[16], word[16], covered = 0;
        for (uint v = 0; v < 16; v++) {
            const uint px = (kx + view->along[0][v]) >> 20, py = (ky + view->along[1][v]) >> 20, pz = (kz + view->along[2][v]) >> 20;
            const uint tx = (px < 1023u ? 1023u : px > view->limit[0] ? view->limit[0] : px) - 1023u;
            const uint ty = (py < 1023u ? 1023u : py > view->limit[1] ? view->limit[1] : py) - 1023u;
            const uint tz = (pz < 1023u ? 1023u : pz > view->limit[2] ? view->limit[2] : pz) - 1023u;
            place[v] = (int)(tx >> 2) + view->width[0] * ((int)(ty >> 1) + view->width[1] * (int)(tz >> 1)); /* < 2^27 */
            bit[v] = (tx & 3u) + 4u * (ty & 1u) + 8u * (tz & 1u);
        }
        for (int v = 0; v < 16; v += 4) { /* volatile: one by one, which is faster than a processor's gathering load */
            word[v] = packed[place[v]];
            word[v + 1] = packed[place[v + 1]];
            word[v + 2] = packed[place[v + 2]];
            word[v + 3] = packed[place[v + 3]];
        }
        for (uint v = 0; v < 16; v++)
            covered |= (word[v] >> bit[v] & 0x10001u) << v;
        const ulong hit = ost_to_rows(covered & 0xffffu) << x & open, met = ost_to_rows(covered >> 16) << x & open;
        rows->open[four] ^= hit;
        rows->touch[four] |= met;
        hits |= hit;
        touches |= met;
    }
    const uint group = 1u << (y / 4 + z);
    rows->hit |= hits != 0 ? group : 0u;
    rows->touched |= touches != 0 ? group : 0u;
}

/* The class that covers the cube wholly, or 3. */
static uint ost_cube_class(const ost_view *view, __global const uchar *cells, const int dims[3], uint whole, int x, int y, int z, int edge)
{
    int u[3];
    for (int a = 0; a < 3; a++) {
        const int sum = (int)view->step[0][a] + (int)view->step[1][a] + (int)view->step[2][a];
        u[a] = (int)(view->at[a] - 0x40000000u + (uint)x * view->step[0][a] + (uint)y * view->step[1][a] + (uint)z * view->step[2][a]) +
               (edge - 1) * sum / 2;
    }
    const uint cell = ost_cell_at(cells, dims, u[0], u[1], u[2]);
    return cell >> 2 >= whole ? cell & 3u : 3u;
}

static void ost_run_pose(ost_block_rows *rows, const ost_cl_entry entry, __global const ost_cl_pose *pose, __global const uchar *cells,
                         volatile __global const uint *packed, const int dims[3], const int first[3])
{
    ost_view view;
    for (int a = 0; a < 3; a++) {
        view.at[a] = (uint)entry.base[a] + 0x40000000u;
        for (int b = 0; b < 3; b++)
            view.step[b][a] = (uint)pose->step[b][a];
        view.limit[a] = 1024u + (uint)dims[a];
    }
    const uint across = ost_bits16(pose->lo[0] - first[0], pose->hi[0] - first[0]);
    for (int b = 0; b < 4; b++) {
        rows->inside[b] = 0;
        for (int j = 4 * b; j < 4 * b + 4; j++)
            if (first[1] + j >= pose->lo[1] && first[1] + j < pose->hi[1])
                rows->inside[b] |= (ulong)across << (16 * (j % 4));
    }
    rows->lo = pose->lo[2] - first[2];
    rows->hi = pose->hi[2] - first[2];
    const uint c16 = ost_cube_class(&view, cells, dims, pose->whole[2], 0, 0, 0, 16);
    if (c16 == 1 || c16 == 2)
        ost_mark_cube(rows, c16, 0, 0, 0, 16);
    if (c16 != 3)
        return;

    view.width[0] = OST_CL_PACKED_X(dims[0]);
    view.width[1] = OST_CL_PACKED_Y(dims[1]);
    for (int a = 0; a < 3; a++)
        for (uint v = 0; v < 16; v++)
            view.along[a][v] = v % 4 * view.step[0][a] + v / 4 * view.step[1][a];
    for (int cube = 0; cube < 8; cube++) {
        const int x = cube % 2 * 8, y = cube / 2 % 2 * 8, z = cube / 4 * 8, g = y / 4 + z;
        if (((rows->any[g] | rows->any[g + 1] | rows->any[g + 4] | rows->any[g + 5]) >> x & 0xffu) == 0)
            continue;
        const uint c8 = ost_cube_class(&view, cells, dims, pose->whole[1], x, y, z, 8);
        if (c8 == 1 || c8 == 2)
            ost_mark_cube(rows, c8, x, y, z, 8);
        if (c8 != 3)
            continue;
        for (int brick = 0; brick < 8; brick++) {
            const int bx = x + brick % 2 * 4, by = y + brick / 2 % 2 * 4, bz = z + brick / 4 * 4;
            if ((rows->any[by / 4 + bz] >> bx & 0xfu) == 0)
                continue;
            const uint c4 = ost_cube_class(&view, cells, dims, pose->whole[0], bx, by, bz, 4);
            if (c4 == 3)
                ost_match_brick(rows, &view, packed, bx, by, bz);
            else if (c4 != 0)
                ost_mark_cube(rows, c4, bx, by, bz, 4);
        }
    }
}

/* Brings any[] of the groups up to date. */
static void ost_gather_groups(ost_block_rows *rows, uint groups)
{
    for (int g = 0; g < 16; g++) {
        if ((groups >> g & 1u) == 0)
            continue;
        const int at = g % 4 + g / 4 * 16;
        const ulong all = rows->open[at] | rows->open[at + 4] | rows->open[at + 8] | rows->open[at + 12];
        const uint any = (uint)(all >> 32 | all);
        rows->any[g] = (any >> 16 | any) & 0xffffu;
    }
}

/* Blocks are dealt out like cards, so that cores which take neighbouring items get work from everywhere. */
__kernel void ost_remove_blocks(__global const ost_cl_event *event, __global const ost_cl_block *blocks,
                                __global const ost_cl_entry *entries, __global const ost_cl_pose *poses, __global const uchar *cells,
                                volatile __global const uint *packed, __global short *density, __global ushort *words,
                                __global ost_cl_block_report *reports)
{
    const size_t hand = (event->blocks + OST_CL_HANDS - 1) / OST_CL_HANDS;
    if (hand == 0 || get_global_id(0) / hand >= OST_CL_HANDS)
        return;
    const size_t index = get_global_id(0) % hand * OST_CL_HANDS + get_global_id(0) / hand;
    if (index >= event->blocks)
        return;
    const ost_cl_block block = blocks[index];
    const int n = event->size, classes = event->classes;
    const int dims[3] = {event->tool_dims[0], event->tool_dims[1], event->tool_dims[2]};
    const ulong corner = (ulong)block.slot * ((ulong)n * (ulong)n * (ulong)n) +
                         (ulong)(block.first[0] % n + n * (block.first[1] % n + n * (block.first[2] % n)));
    ost_block_rows rows;
    for (int k = 0; k < 16; k++)
        for (int b = 0; b < 4; b++) {
            const ulong at = (corner + (ulong)(n * (4 * b + n * k))) / 16, row = (ulong)n / 16;
            rows.open[b + 4 * k] = (ulong)words[at] | (ulong)words[at + row] << 16 | (ulong)words[at + 2 * row] << 32 |
                                   (ulong)words[at + 3 * row] << 48;
            rows.touch[b + 4 * k] = 0;
        }
    rows.hit = rows.touched = 0;
    for (uint e = 0, stale = 0xffffu; e < block.entries; e++) {
        const ost_cl_entry entry = entries[block.entry + e];
        ost_gather_groups(&rows, stale);
        ost_run_pose(&rows, entry, &poses[entry.pose], cells, packed, dims, block.first);
        stale = rows.hit;
    }

    /* At least border c (class 0: all), by column: the classes' own are differences of the columns' sums. */
    ushort count[OST_CL_CLASSES][16]; /* <= 256 */
    uint sum[OST_CL_CLASSES][16], touched = 0;
    for (int c = 0; c < OST_CL_CLASSES; c++)
        for (int i = 0; i < 16; i++) {
            count[c][i] = 0;
            sum[c][i] = 0;
        }
    for (int g = 0; g < 16; g++) {
        if (((rows.hit | rows.touched) >> g & 1u) == 0)
            continue;
        for (int r = 0; r < 16; r++) {
            const int j = g % 4 * 4 + r % 4, k = g / 4 * 4 + r / 4, four = g % 4 + 4 * k, shift = 16 * (r % 4);
            const ulong v = corner + (ulong)(n * (j + n * k));
            const uint open = (uint)(rows.open[four] >> shift) & 0xffffu, hit = words[v / 16] & ~open;
            touched += popcount((uint)(rows.touch[four] >> shift) & open);
            if (hit == 0)
                continue;
            ushort is_hit[16];
            for (int i = 0; i < 16; i++)
                is_hit[i] = (ushort)(hit >> i & 1u);
            for (int c = 0; c < classes; c++) {
                const short border = (short)(c == 0 ? -32768 : event->border[c]);
                for (int i = 0; i < 16; i++) {
                    const short d = density[v + (ulong)i];
                    const ushort counts = d >= border ? is_hit[i] : (ushort)0;
                    count[c][i] = (ushort)(count[c][i] + counts);
                    sum[c][i] += counts != 0 ? (uint)(int)d : 0u;
                }
            }
            if (event->apply) {
                for (int i = 0; i < 16; i++) {
                    const short d = density[v + (ulong)i];
                    density[v + (ulong)i] = is_hit[i] != 0 ? (short)0 : d;
                }
                words[v / 16] = (ushort)open;
            }
        }
    }

    uint above = 0, above_sum = 0; /* of the class above */
    for (int c = OST_CL_CLASSES - 1; c >= 0; c--) {
        uint all = 0, all_sum = 0;
        for (int i = 0; i < 16; i++) {
            all += count[c][i];
            all_sum += sum[c][i];
        }
        reports[index].voxels[c] = all - above;
        reports[index].density[c] = all_sum - above_sum;
        above = all;
        above_sum = all_sum;
    }
    reports[index].touched = touched;
    for (int i = 0; i < 3; i++)
        reports[index].unused[i] = 0;
}
#endif
