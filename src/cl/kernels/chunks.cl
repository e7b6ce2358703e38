/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The kernels that store slices in the pool of chunks (AR-CHK), load slices from the pool and
 * count voxels.  shared.h describes the buffers and the ranges.
 *
 *     table          pool, slots of n^3                    a word of occupancy
 *   chunk 0  -       0  density ... | words ...            n = 16  rows y, y + 1 (y even)
 *   chunk 1  0  -->  1  density ... | words ...            n = 32  a row
 *   chunk 2  1                                             n = 64  half a row
 *
 * Ranges: n <= 64, so a plane of a chunk has at most 2^12 voxels, and a chunk has at most 2^18.
 * dims <= 2^14 and n >= 16, so there are at most 2^30 chunks.  slot * n^3 needs 64 bits.
 */

static ulong ost_chunk_voxels(__global const ost_cl_bone *bone)
{
    return (ulong)bone->size * (ulong)bone->size * (ulong)bone->size;
}

/* Returns the index of voxel (x, y) of a slice within a slab. A slab consists of complete slices. */
static ulong ost_slab_at(__global const ost_cl_bone *bone, int x, int y, int slice)
{
    return (ulong)x + (ulong)bone->dims[0] * ((ulong)y + (ulong)bone->dims[1] * (ulong)slice);
}

/*
 * Returns the index in the slab of the slice from which slice k of the grid is computed. shared.h describes the
 * parameters layers, first and z0.
 */
static int ost_slab_slice(__global const int *layers, int first, int k, int z0)
{
    return first < 0 ? k - z0 : layers[first + k - z0];
}

/* Slice k of the grid is the weighted mean of slice ost_slab_slice(...) of the slab and the next slice of the slab.
   Returns the weight of the next slice in units of 2^-15. */
static int ost_slab_weight(__global const int *layers, int weights, int k, int z0)
{
    return weights < 0 ? 0 : layers[weights + k - z0];
}

#if OST_FOR & 1
/*
 * Returns the voxel *from of a slab or, if weight > 0, the weighted mean of *from and the corresponding voxel of the
 * next slice. The two weights sum to 2^15.
 */
static short ost_slab_read(__global const short *from, ulong plane, int weight)
{
    return weight > 0 ? ost_mean15(from[0] * (32768 - weight) + from[plane] * weight) : from[0];
}

__kernel void ost_chunk_scan(__global const ost_cl_bone *bone, int z0, int z1, int first, int weights,
                             __global const int *layers, __global const short *slab, volatile __global uint *active)
{
    const size_t columns = (size_t)bone->chunk_dims[0] * (size_t)bone->chunk_dims[1];
    if (get_global_id(0) >= (size_t)(z1 - z0) || get_global_id(1) >= columns)
        return;
    const int z = z0 + (int)get_global_id(0), column = (int)get_global_id(1), n = bone->size;
    const int slice = ost_slab_slice(layers, first, z, z0), weight = ost_slab_weight(layers, weights, z, z0);
    const ulong plane = (ulong)bone->dims[0] * (ulong)bone->dims[1];
    const int cx = column % bone->chunk_dims[0], cy = column / bone->chunk_dims[0];
    const int x1 = ost_least(cx * n + n, bone->dims[0]), y1 = ost_least(cy * n + n, bone->dims[1]);
    uint count = 0;
    for (int y = cy * n; y < y1; y++) {
        const ulong row = ost_slab_at(bone, 0, y, slice);
        for (int x = cx * n; x < x1; x++)
            count += ost_slab_read(slab + row + (ulong)x, plane, weight) >= bone->threshold ? 1u : 0u;
    }
    if (count > 0)
        atomic_add(&active[(size_t)column + columns * (size_t)(z / n)], count);
}
#endif

#if OST_FOR & 1
__kernel void ost_chunk_store(__global const ost_cl_bone *bone, int z0, int z1, int first, int weights,
                              __global const int *layers, __global const short *slab, __global const uint *slots,
                              __global short *density, __global uint *words)
{
    const int n = bone->size;
    const size_t columns = (size_t)bone->chunk_dims[0] * (size_t)bone->chunk_dims[1];
    if (get_global_id(0) >= (size_t)(n * n / 32) || get_global_id(1) >= columns ||
        get_global_id(2) >= (size_t)(z1 - z0))
        return;
    const int column = (int)get_global_id(1), z = z0 + (int)get_global_id(2);
    const uint slot = slots[(size_t)column + columns * (size_t)(z / n)];
    if (slot == OST_CL_NONE)
        return;
    const int slice = ost_slab_slice(layers, first, z, z0), weight = ost_slab_weight(layers, weights, z, z0);
    const ulong plane = (ulong)bone->dims[0] * (ulong)bone->dims[1];
    const int first_x = column % bone->chunk_dims[0] * n, first_y = column / bone->chunk_dims[0] * n;
    const int v = 32 * (int)get_global_id(0);
    const ulong to = (ulong)slot * ost_chunk_voxels(bone) + (ulong)(z % n) * (ulong)(n * n) + (ulong)v;
    uint word = 0;
    if (n >= 32 && first_x + v % n + 32 <= bone->dims[0] && first_y + v / n < bone->dims[1]) {
        __global const short *from = slab + ost_slab_at(bone, first_x + v % n, first_y + v / n, slice);
        const short threshold = (short)bone->threshold;
        for (int b = 0; b < 32; b++) {
            const short read = ost_slab_read(from + b, plane, weight);
            density[to + (ulong)b] = read >= threshold ? read : (short)0;
            word |= (read >= threshold ? 1u : 0u) << b;
        }
        words[to / 32] = word;
        return;
    }
    for (int b = 0; b < 32; b++) {
        const int x = first_x + (v + b) % n, y = first_y + (v + b) / n;
        short stored = 0;
        if (x < bone->dims[0] && y < bone->dims[1]) {
            const short read = ost_slab_read(slab + ost_slab_at(bone, x, y, slice), plane, weight);
            if (read >= bone->threshold) {
                stored = read;
                word |= 1u << b;
            }
        }
        density[to + (ulong)b] = stored;
    }
    words[to / 32] = word;
}

__kernel void ost_chunk_load(__global const ost_cl_bone *bone, int z0, int z1, __global const uint *slots,
                             __global const short *density, __global short *slab)
{
    if (get_global_id(0) >= (size_t)bone->dims[0] || get_global_id(1) >= (size_t)bone->dims[1] ||
        get_global_id(2) >= (size_t)(z1 - z0))
        return;
    const int x = (int)get_global_id(0), y = (int)get_global_id(1), slice = (int)get_global_id(2), z = z0 + slice;
    const int cx = bone->chunk_dims[0], cy = bone->chunk_dims[1];
    /* The size of a chunk is a power of two, so shifts replace divisions, which took most of this kernel's time. */
    const int log = 31 - (int)clz((uint)bone->size), low = bone->size - 1;
    const uint slot = slots[(ulong)(x >> log) + (ulong)cx * ((ulong)(y >> log) + (ulong)cy * (ulong)(z >> log))];
    short read = 0;
    if (slot != OST_CL_NONE)
        read = density[((ulong)slot << 3 * log) + (ulong)((x & low) | (y & low) << log | (z & low) << 2 * log)];
    slab[ost_slab_at(bone, x, y, slice)] = read;
}
#endif

__kernel void ost_chunk_count(__global const ost_cl_bone *bone, uint first, uint count, __global const uint *words,
                              volatile __global uint *active)
{
    const int n = bone->size, plane_words = n * n / 32;
    if (get_global_id(0) >= (size_t)n || get_global_id(1) >= count)
        return;
    const ulong slot = (ulong)first + get_global_id(1);
    const ulong from = slot * (ost_chunk_voxels(bone) / 32) + (ulong)get_global_id(0) * (ulong)plane_words;
    uint bits = 0;
    for (int w = 0; w < plane_words; w++)
        bits += popcount(words[from + (ulong)w]);
    if (bits > 0)
        atomic_add(&active[get_global_id(1)], bits);
}
