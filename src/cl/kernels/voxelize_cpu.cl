/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The voxelizer for CPUs (AR-VOX): an item has a tile of rows and lists of the
 * triangles whose bounds meet its slices (cl/voxelize_tiles.c), so nothing is atomic.
 *
 *   for each slice of the tile
 *     steps[row][i]   sums of what crosses before centre i      where marked
 *     marks[row]      bit i: something does
 *     fill            from mark to mark; rows that leak stay void
 *
 * Ranges as in voxelize.cl; a tile's rows and lists have 64-bit indices.
 */
#if OST_FOR & 2

static int ost_lowest_mark(ulong word)
{
    return 63 - (int)clz(word & (0ul - word));
}

/* One triangle's crossings with the tile's rows j0 <= j < j1 of slice k. */
static void ost_mark_triangle(const ost_triangle *t, int j0, int j1, int k, int f, __global int *steps, size_t row_steps,
                              __global ulong *marks, size_t row_words)
{
    const int first = ost_greatest(t->j_first, j0), last = ost_least(t->j_last, j1 - 1);
    for (int j = first; j <= last; j++) {
        const int i = ost_triangle_crossing(t, j, k, f);
        if (i < 0)
            continue;
        __global ulong *word = marks + (size_t)(j - j0) * row_words + (size_t)(i / 64);
        __global int *sum = steps + (size_t)(j - j0) * row_steps + (size_t)i;
        const ulong bit = 1ul << (uint)(i % 64);
        *sum = (*word & bit) != 0 ? *sum + t->step : t->step;
        *word |= bit;
    }
}

/* Voxels from <= i < to of a row; by sixteen, which compilers make a vector. */
static void ost_fill_run(__global uchar *classes, int from, int to, uchar tool_class)
{
    int i = from;
    for (; i + 16 <= to; i += 16)
        for (int b = 0; b < 16; b++)
            classes[i + b] = tool_class;
    for (; i < to; i++)
        classes[i] = tool_class;
}

/* A row from its marks: solid voxels; over: void ones stay as they are. *leaks is raised when it leaks. */
static uint ost_fill_row(__global const ost_cl_tiles *tiles, __global const int *steps, __global const ulong *marks,
                         __global uchar *classes, uint *leaks)
{
    const int n = tiles->dims[0], parity = tiles->rule == OST_CL_FILL_PARITY, over = tiles->over, words = n / 64 + 1;
    int total = 0;
    for (int w = 0; w < words; w++)
        for (ulong left = marks[w]; left != 0; left &= left - 1)
            total += steps[64 * w + ost_lowest_mark(left)];
    if (parity ? total % 2 != 0 : total != 0) {
        *leaks += 1;
        if (!over)
            ost_fill_run(classes, 0, n, 0);
        return 0;
    }
    int winding = 0, from = 0, solid = 0;
    uint count = 0;
    for (int w = 0; w < words; w++)
        for (ulong left = marks[w]; left != 0; left &= left - 1) {
            const int i = 64 * w + ost_lowest_mark(left);
            winding += steps[i];
            const int then = parity ? winding % 2 != 0 : winding != 0;
            if (then == solid)
                continue;
            if (solid || !over)
                ost_fill_run(classes, from, i, (uchar)(solid ? tiles->tool_class : 0));
            count += solid ? (uint)(i - from) : 0u;
            solid = then;
            from = i;
        }
    if (!over)
        ost_fill_run(classes, from, n, 0);
    return count;
}

__kernel void ost_vox_tiles(__global const ost_cl_tiles *tiles, __global const int *vertices, __global const uint *triangles,
                            __global const uint *start, __global const uint *list, __global int *steps, __global ulong *marks,
                            __global uchar *classes, __global ulong *counts)
{
    if (get_global_id(0) >= (size_t)tiles->count[0] || get_global_id(1) >= (size_t)tiles->count[1])
        return;
    const size_t tile = get_global_id(0) + (size_t)tiles->count[0] * get_global_id(1);
    const int nx = tiles->dims[0], ny = tiles->dims[1], f = tiles->fraction;
    const int j0 = tiles->height * (int)get_global_id(0), j1 = ost_least(j0 + tiles->height, ny);
    const int k0 = tiles->depth * (int)get_global_id(1), k1 = ost_least(k0 + tiles->depth, tiles->dims[2]);
    const size_t row_steps = (size_t)nx + 1, row_words = (size_t)(nx / 64 + 1);
    ulong solid = 0, cutting = 0, leaks = tiles->over ? counts[3 * tile + 2] : 0;
    steps += tile * (size_t)tiles->height * row_steps;
    marks += tile * (size_t)tiles->height * row_words;
    for (int k = k0; k < k1; k++) {
        for (size_t w = 0; w < (size_t)(j1 - j0) * row_words; w++)
            marks[w] = 0;
        const size_t bin = get_global_id(0) + (size_t)tiles->count[0] * (size_t)(k / tiles->layer);
        for (uint e = start[bin]; e < start[bin + 1]; e++) {
            ost_triangle t;
            if (ost_triangle_load(&t, vertices, triangles, list[e], f, k, k + 1))
                ost_mark_triangle(&t, j0, j1, k, f, steps, row_steps, marks, row_words);
        }
        for (int j = j0; j < j1; j++) {
            __global uchar *row = classes + (size_t)nx * ((size_t)j + (size_t)ny * (size_t)k);
            uint leaking = 0;
            const uint count = ost_fill_row(tiles, steps + (size_t)(j - j0) * row_steps, marks + (size_t)(j - j0) * row_words, row, &leaking);
            leaks += leaking;
            if (!tiles->over) {
                solid += count;
                cutting += tiles->tool_class == 1 ? count : 0u;
                continue;
            }
            uint any = 0, ones = 0;
            for (int i = 0; i < nx; i++) {
                any += row[i] != 0 ? 1u : 0u;
                ones += row[i] == 1 ? 1u : 0u;
            }
            solid += any;
            cutting += ones;
        }
    }
    counts[3 * tile] = solid;
    counts[3 * tile + 1] = cutting;
    counts[3 * tile + 2] = leaks;
}
#endif
