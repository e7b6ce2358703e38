/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The kernels for CPUs that scan, store and load slices. The results are the same as those of ost_chunk_scan,
 * ost_chunk_store and ost_chunk_load (shared.h). An item of ost_chunk_scan_layers processes a row of chunks, and scans
 * equal slices only once. An item of ost_chunk_store_layers processes one chunk. No two items count or store the same
 * chunk, so no atomics are needed.
 */
#if OST_FOR & 2

/* Returns how many of 16 adjacent voxels have at least the density `threshold`. */
static uint ost_count16(__global const short *from, short threshold)
{
    ushort count = 0;
    for (int i = 0; i < 16; i++)
        count = (ushort)(count + (from[i] >= threshold ? 1u : 0u));
    return count;
}

/* Computes 16 weighted means of corresponding voxels of two slices, and returns how many are at least the threshold. A
   mean is never greater than the greater voxel. Therefore no mean is computed if all 32 voxels are below the
   threshold. */
static uint ost_count16_between(__global const short *a, __global const short *b, int weight, short threshold)
{
    short count = 0, any = 0;
    for (int i = 0; i < 16; i++)
        any = (short)(any | (a[i] >= threshold ? 1 : 0) | (b[i] >= threshold ? 1 : 0));
    if (!any)
        return 0;
    for (int i = 0; i < 16; i++)
        count = (short)(count + (ost_mean15(a[i] * (32768 - weight) + b[i] * weight) >= threshold ? 1 : 0));
    return (uint)count;
}

__kernel void ost_chunk_scan_layers(__global const ost_cl_bone *bone, int z0, int z1, int first, int weights,
                                    __global const int *layers, __global const short *slab, __global uint *active)
{
    const int n = bone->size, nx = bone->dims[0];
    if (get_global_id(0) >= (size_t)bone->chunk_dims[1] || get_global_id(1) >= (size_t)bone->chunk_dims[2])
        return;
    const int cy = (int)get_global_id(0), cz = (int)get_global_id(1);
    const int k0 = ost_greatest(cz * n, z0), k1 = ost_least(cz * n + n, z1), y1 = ost_least(cy * n + n, bone->dims[1]);
    const short threshold = (short)bone->threshold;
    const ulong plane = (ulong)nx * (ulong)bone->dims[1];
    __global uint *to = active + (size_t)bone->chunk_dims[0] * ((size_t)cy + (size_t)bone->chunk_dims[1] * (size_t)cz);
    for (int k = k0, same; k < k1; k += same) {
        const int slice = ost_slab_slice(layers, first, k, z0), weight = ost_slab_weight(layers, weights, k, z0);
        same = 1;
        while (k + same < k1 && ost_slab_slice(layers, first, k + same, z0) == slice &&
               ost_slab_weight(layers, weights, k + same, z0) == weight)
            same++;
        for (int y = cy * n; y < y1; y++) {
            __global const short *row = slab + ost_slab_at(bone, 0, y, slice);
            for (int cx = 0; cx < bone->chunk_dims[0]; cx++) {
                const int x1 = ost_least(cx * n + n, nx);
                uint count = 0;
                int x = cx * n;
                if (weight > 0) {
                    for (; x + 16 <= x1; x += 16)
                        count += ost_count16_between(row + x, row + plane + x, weight, threshold);
                    for (; x < x1; x++)
                        count += ost_mean15(row[x] * (32768 - weight) + row[plane + (ulong)x] * weight) >= threshold
                                     ? 1u
                                     : 0u;
                }
                for (; x + 16 <= x1; x += 16)
                    count += ost_count16(row + x, threshold);
                for (; x < x1; x++)
                    count += row[x] >= threshold ? 1u : 0u;
                to[cx] += count * (uint)same;
            }
        }
    }
}

/* Copies 16 voxels, and sets those below the threshold to 0. Bit i of the return value is 1 if the density of voxel i
   is at least the threshold. */
static uint ost_keep16(__global const short *from, __global short *to, short threshold)
{
    ushort bits = 0;
    for (int i = 0; i < 16; i++) {
        const short read = from[i];
        to[i] = read >= threshold ? read : (short)0;
        bits = (ushort)(bits | (read >= threshold ? (ushort)(1u << i) : (ushort)0));
    }
    return bits;
}

/* Writes 16 weighted means of the voxels of two slices and sets means below the threshold to 0. In the result, bit i is
   1 if mean i is at least the threshold. */
static uint ost_keep16_between(__global const short *a, __global const short *b, int weight, __global short *to,
                               short threshold)
{
    ushort bits = 0;
    for (int i = 0; i < 16; i++) {
        const short read = ost_mean15(a[i] * (32768 - weight) + b[i] * weight);
        to[i] = read >= threshold ? read : (short)0;
        bits = (ushort)(bits | (read >= threshold ? (ushort)(1u << i) : (ushort)0));
    }
    return bits;
}

/* Stores the voxels x to x + 15 of a row of nx voxels or, if weight > 0, their weighted means with the voxels of the
   next plane. Values below the threshold become 0. Returns 16 bits; bit i is 1 if value i is at least the threshold. */
static uint ost_store16(__global const short *row, ulong plane, int weight, int x, int nx, __global short *to,
                        short threshold)
{
    if (x + 16 <= nx)
        return weight > 0 ? ost_keep16_between(row + x, row + plane + x, weight, to, threshold)
                          : ost_keep16(row + x, to, threshold);
    uint bits = 0;
    for (int i = 0; i < 16; i++) {
        short read = 0;
        if (x + i < nx)
            read = weight > 0 ? ost_mean15(row[x + i] * (32768 - weight) + row[plane + (ulong)(x + i)] * weight)
                              : row[x + i];
        /* beyond the grid (x >= nx), `read` is 0 and therefore below the threshold */
        to[i] = read >= threshold ? read : (short)0;
        bits |= (read >= threshold ? 1u : 0u) << i;
    }
    return bits;
}

__kernel void ost_chunk_store_layers(__global const ost_cl_bone *bone, int z0, int z1, int first, int weights,
                                     __global const int *layers, __global const short *slab, __global const uint *slots,
                                     __global short *density, __global uint *words)
{
    const int n = bone->size, nx = bone->dims[0], ny = bone->dims[1];
    const size_t columns = (size_t)bone->chunk_dims[0] * (size_t)bone->chunk_dims[1];
    if (get_global_id(0) >= columns || get_global_id(1) >= (size_t)bone->chunk_dims[2])
        return;
    const int column = (int)get_global_id(0), cz = (int)get_global_id(1);
    const uint slot = slots[(size_t)column + columns * (size_t)cz];
    if (slot == OST_CL_NONE)
        return;
    const int x0 = column % bone->chunk_dims[0] * n, y0 = column / bone->chunk_dims[0] * n;
    const int k0 = ost_greatest(cz * n, z0), k1 = z1 == bone->dims[2] ? cz * n + n : ost_least(cz * n + n, z1);
    const short threshold = (short)bone->threshold;
    const ulong plane = (ulong)nx * (ulong)ny;
    const int half_words = n / 16;
    for (int k = k0; k < k1; k++) {
        const ulong from = (ulong)slot * ost_chunk_voxels(bone) + (ulong)(k - cz * n) * (ulong)(n * n);
        __global short *to = density + from;
        __global ushort *bits = (__global ushort *)words + from / 16; /* devices are little-endian (choice.c) */
        const int slice = k < z1 ? ost_slab_slice(layers, first, k, z0) : 0;
        const int weight = k < z1 ? ost_slab_weight(layers, weights, k, z0) : 0;
        for (int y = 0; y < n; y++) {
            __global const short *row = slab + ost_slab_at(bone, 0, y0 + y < ny ? y0 + y : 0, slice);
            const int end = k < z1 && y0 + y < ny ? nx : 0;
            for (int h = 0; h < half_words; h++)
                bits[y * half_words + h] = (ushort)ost_store16(row, plane, weight, x0 + 16 * h, end,
                                                               to + y * n + 16 * h, threshold);
        }
    }
}

static void ost_copy16(__global const short *from, __global short *to)
{
    for (int i = 0; i < 16; i++)
        to[i] = from[i];
}

__kernel void ost_chunk_load_rows(__global const ost_cl_bone *bone, int z0, int z1, __global const uint *slots,
                                  __global const short *density, __global short *slab)
{
    const int n = bone->size, nx = bone->dims[0];
    if (get_global_id(0) >= (size_t)bone->chunk_dims[1] || get_global_id(1) >= (size_t)(z1 - z0))
        return;
    const int cy = (int)get_global_id(0), slice = (int)get_global_id(1), z = z0 + slice;
    const int y1 = ost_least(cy * n + n, bone->dims[1]);
    for (int cx = 0; cx < bone->chunk_dims[0]; cx++) {
        const uint slot =
            slots[(ulong)cx + (ulong)bone->chunk_dims[0] * ((ulong)cy + (ulong)bone->chunk_dims[1] * (ulong)(z / n))];
        const int count = ost_least(n, nx - cx * n);
        for (int y = cy * n; y < y1; y++) {
            __global short *to = slab + ost_slab_at(bone, cx * n, y, slice);
            if (slot == OST_CL_NONE) {
                for (int x = 0; x < count; x++)
                    to[x] = 0;
                continue;
            }
            __global const short *from = density + (ulong)slot * ost_chunk_voxels(bone) +
                                         (ulong)(n * (y - cy * n + n * (z % n)));
            int x = 0;
            for (; x + 16 <= count; x += 16)
                ost_copy16(from + x, to + x);
            for (; x < count; x++)
                to[x] = from[x];
        }
    }
}
#endif
