/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The voxelizer for CPUs (AR-VOX). A work item processes a tile of rows, with lists of the
 * triangles whose bounds overlap the slices of the tile (cl/voxelize_tiles.c). Therefore no
 * atomics are needed.
 *
 *   for each group of a few slices of the tile
 *     marks[row]      bit i: the row has crossings between centres i - 1 and i
 *     steps[row][i]   the sum of these crossings, valid if bit i is set
 *                     (eight triangles are processed at once)
 *     fill            fills from one mark to the next; rows that leak stay empty
 *
 * The ranges are the same as in voxelize.cl. The rows and lists of a tile have 64-bit indices.
 */
#if OST_FOR & 2

#ifdef __clang__
#if __has_warning("-Wpsabi") /* NVIDIA's compiler is a variant of clang without this warning */
/* Disables a warning about the calling convention for wide vectors. Only functions of this file pass wide vectors. */
#pragma clang diagnostic ignored "-Wpsabi"
#endif
#endif

static int ost_lowest_mark(ulong word)
{
    return 63 - (int)clz(word & (0ul - word));
}

__constant int ost_lane[8] = {0, 1, 2, 3, 4, 5, 6, 7};

static inline int8 ost_least8(int8 a, int8 b)
{
    const int8 less = a < b;
    return (a & less) | (b & ~less);
}

static inline int8 ost_greatest8(int8 a, int8 b)
{
    const int8 more = a > b;
    return (a & more) | (b & ~more);
}

static inline int ost_most_of8(int8 v)
{
    int lane[8], most;
    vstore8(v, 0, lane);
    most = lane[0];
    for (int l = 1; l < 8; l++)
        most = ost_greatest(most, lane[l]);
    return most;
}

static inline long8 ost_shifted8(long8 v, int f)
{
    return as_long8(as_ulong8(v) << (ulong)f);
}

/*
 * Returns, for each lane, 0 if the triangle owns the edge, and -1 otherwise. The caller adds the result to E. A point
 * is owned if and only if the sum is not negative.
 */
static inline long8 ost_edge_bias8(long8 dy, long8 dz)
{
    return ~((dz < 0) | ((dz == 0) & (dy > 0)));
}

/* The rows and slices that are marked in one pass, and the dimensions of the scratch memory. */
typedef struct ost_pass {
    int j0, j1, k0, k1; /* ranges of rows, j0 <= j < j1, and of slices, k0 <= k < k1 */
    int height;         /* number of rows per slice in the scratch memory of the tile */
    int f;
    size_t row_steps, row_words;
} ost_pass;

/*
 * Adds the crossings of count <= 8 triangles, one triangle per lane. All lanes process as many rows as the triangle
 * with the most rows in its bounds. E and the position of the crossing are linear functions of row and slice, so they
 * are updated by additions. Let R = K - nx 2^f i_first. The crossing is at the least q >= 0 with nx 2^f q >= R, which
 * is found bit by bit.
 *
 * Ranges. A lane with fewer rows continues up to 2^12 rows, or 2^20 units, beyond its bounds, so
 * |E| <= 2 * 2^20 * 2^21 + 1. As |n| <= 2^40, |R| < 3 * 2^61. A step of R is at most 2 * 2^50, a step of E is at most
 * 2^30, and nx 2^f 2^12 <= 2^62.
 */
static void ost_mark_eight(const ost_pass *pass, __global const int *vertices, __global const uint *triangles,
                           __global const uint *list, int count, __global int *steps, __global ulong *marks)
{
    int corner[9][8];
    for (int l = 0; l < 8; l++) {
        __global const uint *t = triangles + 3 * (size_t)list[l < count ? l : 0];
        for (int c = 0; c < 3; c++)
            for (int a = 0; a < 3; a++)
                corner[3 * c + a][l] = vertices[3 * (size_t)t[c] + (size_t)a];
    }
    const int f = pass->f, mid = 1 << (f - 1);
    int8 least[3], most[3];
    for (int a = 0; a < 3; a++) {
        const int8 p = vload8(0, corner[a]), q = vload8(0, corner[3 + a]), r = vload8(0, corner[6 + a]);
        least[a] = (ost_least8(ost_least8(p, q), r) + (mid - 1)) >> f;
        most[a] = ((ost_greatest8(ost_greatest8(p, q), r) + mid) >> f) - 1;
    }
    const int8 j_first = ost_greatest8(least[1], OST_ALL8(pass->j0)),
               k_first = ost_greatest8(least[2], OST_ALL8(pass->k0));
    const int8 j_more = ost_least8(most[1], OST_ALL8(pass->j1 - 1)) - j_first,
               k_more = ost_least8(most[2], OST_ALL8(pass->k1 - 1)) - k_first;
    const int8 none = ~((j_more >= 0) & (k_more >= 0) & (vload8(0, ost_lane) < count));
    const int rows = ost_most_of8(j_more | none), slices = ost_most_of8(k_more | none);
    if (slices < 0)
        return;

    const long8 ax = convert_long8(vload8(0, corner[0])), ay = convert_long8(vload8(0, corner[1])),
                az = convert_long8(vload8(0, corner[2]));
    long8 by = convert_long8(vload8(0, corner[4])), bz = convert_long8(vload8(0, corner[5]));
    long8 cy = convert_long8(vload8(0, corner[7])), cz = convert_long8(vload8(0, corner[8]));
    const long8 abx = convert_long8(vload8(0, corner[3])) - ax, acx = convert_long8(vload8(0, corner[6])) - ax;
    long8 nx = (by - ay) * (cz - az) - (bz - az) * (cy - ay);
    long8 ny = (bz - az) * acx - abx * (cz - az);
    long8 nz = abx * (cy - ay) - (by - ay) * acx;
    /* -1 in the lanes in which the outward normal points to low x, so that the line enters the mesh */
    const long8 turn = nx < 0;
    nx = (nx ^ turn) - turn;
    ny = (ny ^ turn) - turn;
    nz = (nz ^ turn) - turn;
    const long8 swap_y = (by ^ cy) & turn, swap_z = (bz ^ cz) & turn;
    by ^= swap_y;
    cy ^= swap_y;
    bz ^= swap_z;
    cz ^= swap_z;

    const long8 dy0 = by - ay, dz0 = bz - az, dy1 = cy - by, dz1 = cz - bz, dy2 = ay - cy, dz2 = az - cz;
    const long8 y = ost_shifted8(convert_long8(j_first), f) + (long)mid,
                z = ost_shifted8(convert_long8(k_first), f) + (long)mid;
    const long8 rows_of = convert_long8(j_more | none) | (nx == 0), slices_of = convert_long8(k_more);
    long8 e0 = dy0 * (z - az) - dz0 * (y - ay) + ost_edge_bias8(dy0, dz0);
    long8 e1 = dy1 * (z - bz) - dz1 * (y - by) + ost_edge_bias8(dy1, dz1);
    long8 e2 = dy2 * (z - cz) - dz2 * (y - cy) + ost_edge_bias8(dy2, dz2);
    long8 residual = nx * (ax - (long)mid - ost_shifted8(convert_long8(least[0]), f)) - ny * (y - ay) - nz * (z - az);
    const long8 e0_k = ost_shifted8(dy0, f), e1_k = ost_shifted8(dy1, f), e2_k = ost_shifted8(dy2, f),
                residual_k = ost_shifted8(nz, f);
    const long8 e0_j = ost_shifted8(dz0, f), e1_j = ost_shifted8(dz1, f), e2_j = ost_shifted8(dz2, f),
                residual_j = ost_shifted8(ny, f);
    const long8 wide = ost_shifted8(nx, f);
    /* upper bound on q - 1 in all lanes, because crossings lie within the bounds along x */
    const int furthest = ost_most_of8((most[0] - least[0]) & ~none);
    const int bits = furthest > 0 ? 32 - (int)clz((uint)furthest) : 0;
    int row[8], row_at[8], step[8];
    vstore8(j_first - pass->j0 + pass->height * (k_first - pass->k0), 0, row);
    vstore8(-2 * convert_int8(turn) - 1, 0, step);

    for (int k = 0; k <= slices; k++) {
        const long8 rows_here = rows_of | (slices_of < (long)k);
        long8 at0 = e0, at1 = e1, at2 = e2, at_residual = residual;
        for (int j = 0; j <= rows; j++) {
            ulong owned = as_ulong(convert_char8(((at0 | at1 | at2) >= 0) & (rows_here >= (long)j)));
            if (owned != 0) {
                long8 left = at_residual, q = left & 0;
                for (int b = bits - 1; b >= 0; b--) {
                    const long8 part = ost_shifted8(wide, b), beyond = left > part;
                    left -= part & beyond;
                    q |= beyond & (1l << b);
                }
                vstore8(least[0] + convert_int8(q - (left > 0)), 0, row_at);
                for (; owned != 0;) {
                    const int l = ost_lowest_mark(owned) / 8, i = row_at[l];
                    const size_t r = (size_t)(row[l] + j + pass->height * k);
                    __global ulong *word = marks + r * pass->row_words + (size_t)(i / 64);
                    __global int *sum = steps + r * pass->row_steps + (size_t)i;
                    const ulong bit = 1ul << (uint)(i % 64);
                    *sum = (*word & bit) != 0 ? *sum + step[l] : step[l];
                    *word |= bit;
                    owned &= ~(0xfful << (uint)(8 * l));
                }
            }
            at0 -= e0_j;
            at1 -= e1_j;
            at2 -= e2_j;
            at_residual -= residual_j;
        }
        e0 += e0_k;
        e1 += e1_k;
        e2 += e2_k;
        residual -= residual_k;
    }
}

static void ost_fill_16(__global uchar *classes, uchar tool_class)
{
    for (int b = 0; b < 16; b++)
        classes[b] = tool_class;
}

/* Sets the class of the voxels from <= i < to of a row. Uses runs of sixteen voxels, which compilers vectorize. The
   last run may overlap the run before it. */
static void ost_fill_run(__global uchar *classes, int from, int to, uchar tool_class)
{
    int i = from;
    for (; i + 16 <= to; i += 16)
        ost_fill_16(classes + i, tool_class);
    if (i < to && to - from >= 16) {
        ost_fill_16(classes + to - 16, tool_class);
        return;
    }
    for (; i < to; i++)
        classes[i] = tool_class;
}

/* Fills a row from its marks and returns the number of its solid voxels. If tiles->over is 1, the class of empty
   voxels does not change. Increments *leaks if the row leaks. */
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

__kernel void ost_vox_tiles(__global const ost_cl_tiles *tiles, __global const int *vertices,
                            __global const uint *triangles, __global const uint *start, __global const uint *list,
                            __global int *steps, __global ulong *marks, __global uchar *classes, __global ulong *counts)
{
    if (get_global_id(0) >= (size_t)tiles->count[0] || get_global_id(1) >= (size_t)tiles->count[1])
        return;
    const size_t tile = get_global_id(0) + (size_t)tiles->count[0] * get_global_id(1);
    const int nx = tiles->dims[0], ny = tiles->dims[1];
    const int j0 = tiles->height * (int)get_global_id(0), j1 = ost_least(j0 + tiles->height, ny);
    const int k0 = tiles->depth * (int)get_global_id(1), k1 = ost_least(k0 + tiles->depth, tiles->dims[2]);
    const size_t row_steps = (size_t)nx + 1, row_words = (size_t)(nx / 64 + 1);
    ulong solid = 0, cutting = 0, leaks = tiles->over ? counts[3 * tile + 2] : 0;
    const size_t rows = (size_t)tiles->pass * (size_t)tiles->height;
    steps += tile * rows * row_steps;
    marks += tile * rows * row_words;
    for (int k = k0, end; k < k1; k = end) {
        const size_t bin = get_global_id(0) + (size_t)tiles->count[0] * (size_t)(k / tiles->layer);
        end = ost_least(ost_least(k + tiles->pass, k1), (k / tiles->layer + 1) * tiles->layer);
        const ost_pass pass = {j0, j1, k, end, tiles->height, tiles->fraction, row_steps, row_words};
        for (size_t w = 0; w < (size_t)tiles->height * (size_t)(end - k) * row_words; w++)
            marks[w] = 0;
        for (uint e = start[bin], last = start[bin + 1]; e < last; e += 8)
            ost_mark_eight(&pass, vertices, triangles, list + e, last - e < 8 ? (int)(last - e) : 8, steps, marks);
        for (int slice = k; slice < end; slice++)
            for (int j = j0; j < j1; j++) {
                const size_t r = (size_t)(j - j0) + (size_t)tiles->height * (size_t)(slice - k);
                __global uchar *row = classes + (size_t)nx * ((size_t)j + (size_t)ny * (size_t)slice);
                uint leaking = 0;
                const uint count = ost_fill_row(tiles, steps + r * row_steps, marks + r * row_words, row, &leaking);
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
