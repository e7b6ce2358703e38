/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Removal and collision (AR-MAP, AR-REM) by rows, for GPUs.  remove_cpu.cl computes the same results by
 * blocks, for CPUs.  A work item processes rows of 16 voxels of a block, and for each row all poses at which
 * the tool may overlap the block.
 *
 *   u = base + j step[1] + k step[2]      the row's first voxel in tool cells, times 2^20
 *   while the class of some voxels of the row is unknown
 *     look up the cell of one such voxel  the cell has a class and a reach: all nearer cells have this class
 *     mark all voxels of this class       skip[reach] voxels on either side
 *
 *   row       . . # # # # # # # # # # # . . .     active
 *   tool        empty    |   cutting                first look-up in the middle, then from the left
 *
 * Ranges: by AR-MAP-5, every sum and every part of a sum fits in an int. A coordinate u is in [-2^30, 2^31), so
 * u + 2^30 is an unsigned number in [0, 3 * 2^30), and (u + 2^30) >> 20 is the index of the tool voxel plus 1024.
 */

#ifndef OST_ROWS
#define OST_ROWS 4
#endif

/*
 * Returns the class and the reach of the tool at the coordinates u, in the format of a cell. Outside the grid, the tool
 * is empty. Let c be the grid cell nearest to u. Every cell of the grid is at least as far from u as from c. Therefore,
 * if c is empty, the reach of c is valid for u too.
 */
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

/*
 * The functions ost_poses_of, ost_blocks_of and ost_entries_of return the arrays that follow the struct in its buffer.
 */
static __global const ost_cl_pose *ost_poses_of(__global const ost_cl_event *event)
{
    return (__global const ost_cl_pose *)(__global const void *)((__global const uchar *)event + event->poses_at);
}

static __global const ost_cl_block *ost_blocks_of(__global const ost_cl_event *event)
{
    return (__global const ost_cl_block *)(__global const void *)((__global const uchar *)event + event->blocks_at);
}

static __global const ost_cl_entry *ost_entries_of(__global const ost_cl_event *event)
{
    return (__global const ost_cl_entry *)(__global const void *)((__global const uchar *)event + event->entries_at);
}

#if OST_FOR & 1
/*
 * Returns the open voxels of row (j, k) that are hit by the tool at one pose. Adds the open voxels of the row that are
 * touched by the tool to *touch.
 */
static uint ost_hits_of(const ost_cl_entry entry, __global const ost_cl_pose *pose, __global const uchar *cells,
                        const int dims[3], const int first[3], int j, int k, uint open, uint *touch)
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

__kernel void ost_remove(__global const ost_cl_event *event, __global const uchar *cells, __global short *density,
                         __global ushort *words, volatile __global ost_cl_block_report *reports)
{
    const size_t index = get_global_id(0) / (256 / OST_ROWS);
    if (index >= event->blocks)
        return;
    __global const ost_cl_block *blocks = ost_blocks_of(event);
    __global const ost_cl_entry *entries = ost_entries_of(event);
    __global const ost_cl_pose *poses = ost_poses_of(event);
    const int first_row = (int)(get_global_id(0) % (256 / OST_ROWS)) * OST_ROWS;
    const ost_cl_block block = blocks[index];
    const int n = event->size;
    const int dims[3] = {event->tool_dims[0], event->tool_dims[1], event->tool_dims[2]};
    const ulong corner = (ulong)block.slot * ((ulong)n * (ulong)n * (ulong)n) +
                         (ulong)(block.first[0] % n + n * (block.first[1] % n + n * (block.first[2] % n)));

    /*
     * Element 0 counts all hit voxels and sums their densities. For c > 0, element c counts and sums only the hit
     * voxels whose density is at least border c. The result of a class is the difference between two neighbouring
     * elements.
     */
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
