/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Converts the samples of a CT text to the rect grid (AR-CT-4..6), as described in
 * shared.h.  Three launches are needed, because the sample that determines a voxel's
 * density is known only after all samples have been compared.  Each voxel has an element in `owner`:
 *
 *   claim     sets the element to the greatest key of the voxel's samples
 *   place     selects the sample that writes the voxel (for max, also sets a flag)
 *   check     sets the element to 0 again
 *
 * Ranges.  Let p be a coordinate of a sample.  |p|, |origin| <= 8 * 10^12, so
 * |p - origin| < 2^44 and, with spacing <= 10^11, |index * spacing| < 2^45.
 * The offset from the lattice, `off`, is at most spacing / 2, so 8 off < 2^39 and
 * 10^6 off < 2^56.
 */

#define OST_LENGTH_MAX 8000000000000l
/* a flag for duplicates=max; it is greater than all keys, which are below 2^17 with this option */
#define OST_OWNER_FLAG 0x40000000u

typedef struct ost_ct_position {
    ulong voxel;
    uint ppm;
    int read;   /* true if the coordinates are in the allowed range (OST_LENGTH_MAX) */
    int off;    /* true if the sample is more than 1/8 of a voxel away from the lattice */
    int inside; /* true if `read` is true and the sample lies in the grid and close enough to the lattice */
} ost_ct_position;

static ost_ct_position ost_ct_position_of(__global const ost_cl_scatter *scatter, __global const ost_cl_sample *sample)
{
    ost_ct_position position;
    long index[3];
    position.voxel = 0;
    position.ppm = 0;
    position.off = 0;
    position.read = 1;
    for (int a = 0; a < 3; a++)
        if (sample->at[a] < -OST_LENGTH_MAX || sample->at[a] > OST_LENGTH_MAX)
            position.read = 0;
    position.inside = position.read;
    if (!position.read)
        return position;
    for (int a = 0; a < 3; a++) {
        const long spacing = scatter->spacing[a], from = sample->at[a] - scatter->origin[a];
        index[a] = ost_rhe_div(from, spacing);
        const long signed_off = from - index[a] * spacing;
        const long off = signed_off < 0 ? -signed_off : signed_off;
        const uint ppm = (uint)(off * 1000000 / spacing);
        if (ppm > position.ppm)
            position.ppm = ppm;
        if (8 * off > spacing)
            position.off = 1;
        if (8 * off > 3 * spacing || index[a] < 0 || index[a] >= scatter->dims[a])
            position.inside = 0;
    }
    if (position.inside)
        position.voxel = (ulong)index[0] +
                         (ulong)scatter->dims[0] * ((ulong)index[1] + (ulong)scatter->dims[1] * (ulong)index[2]);
    return position;
}

/* Returns the key of a sample, from 1 to 2^31 - 1. Of all samples of a voxel, the sample with the greatest key
   determines the voxel's density. */
static uint ost_key(__global const ost_cl_scatter *scatter, uint i, int density)
{
    if (scatter->duplicates == OST_CL_DUPLICATES_LAST)
        return i + 1;
    if (scatter->duplicates == OST_CL_DUPLICATES_MAX)
        return (uint)(density + 32769);
    return 0x7fffffffu - i;
}

static int ost_is_seen(__global const uint *seen, ulong voxel)
{
    return (int)(seen[voxel / 32] >> (voxel % 32) & 1u);
}

__kernel void ost_ct_claim(__global const ost_cl_scatter *scatter, __global const ost_cl_sample *samples,
                           __global const uint *seen, volatile __global uint *owner,
                           volatile __global ost_cl_scatter_report *report)
{
    const size_t item = get_global_id(0);
    if (item >= scatter->count)
        return;
    const uint i = (uint)item;
    const ost_ct_position position = ost_ct_position_of(scatter, &samples[i]);
    if (position.off)
        atomic_inc(&report->off_lattice);
    if (position.ppm > 0)
        atomic_max(&report->worst_ppm, position.ppm);
    if (!position.inside) {
        atomic_min(&report->rejected_line, samples[i].line);
        return;
    }
    const uint old = atomic_max(&owner[position.voxel], ost_key(scatter, i, samples[i].density));
    if (old != 0 || ost_is_seen(seen, position.voxel))
        atomic_inc(&report->duplicates);
}

__kernel void ost_ct_place(__global const ost_cl_scatter *scatter, __global const ost_cl_sample *samples,
                           __global const uint *seen, volatile __global uint *owner, __global short *voxels,
                           volatile __global ost_cl_scatter_report *report)
{
    const size_t item = get_global_id(0);
    if (item >= scatter->count)
        return;
    const uint i = (uint)item;
    const ost_ct_position position = ost_ct_position_of(scatter, &samples[i]);
    /* The launch of ost_ct_claim has computed worst_ppm, so it is constant here. */
    if (position.ppm > 0 && position.ppm == report->worst_ppm)
        atomic_min(&report->worst_line, samples[i].line);
    if (!position.inside)
        return;

    const short density = (short)samples[i].density;
    const uint key = ost_key(scatter, i, samples[i].density);
    const int seen_before = ost_is_seen(seen, position.voxel);
    if (scatter->duplicates == OST_CL_DUPLICATES_MAX) {
        if ((atomic_or(&owner[position.voxel], 0u) & ~OST_OWNER_FLAG) != key)
            return;
        if (atomic_or(&owner[position.voxel], OST_OWNER_FLAG) & OST_OWNER_FLAG)
            return; /* another sample with the same density has set the flag and writes the voxel */
        if (!seen_before || density > voxels[position.voxel])
            voxels[position.voxel] = density;
        return;
    }
    if (owner[position.voxel] != key)
        return;
    if (!seen_before || scatter->duplicates == OST_CL_DUPLICATES_LAST)
        voxels[position.voxel] = density;
}

/*
 * Returns true if the density of a sample differs from the density of the sample's voxel. Called after all samples of
 * the batch have been placed.
 */
static int ost_differs(__global const ost_cl_sample *sample, const ost_ct_position position,
                       __global const short *voxels)
{
    return position.inside && sample->density != voxels[position.voxel];
}

__kernel void ost_ct_check(__global const ost_cl_scatter *scatter, __global const ost_cl_sample *samples,
                           volatile __global uint *seen, volatile __global uint *owner, __global const short *voxels,
                           volatile __global ost_cl_scatter_report *report)
{
    const size_t item = get_global_id(0);
    if (item >= scatter->count)
        return;
    const uint i = (uint)item;
    const ost_ct_position position = ost_ct_position_of(scatter, &samples[i]);
    if (!position.inside)
        return;
    atomic_xchg(&owner[position.voxel], 0u);
    atomic_or(&seen[position.voxel / 32], 1u << (uint)(position.voxel % 32));
    if (scatter->duplicates == OST_CL_DUPLICATES_ERROR && ost_differs(&samples[i], position, voxels))
        atomic_min(&report->conflict_line, samples[i].line);
}

__kernel void ost_ct_report_first_bad(__global const ost_cl_scatter *scatter, __global const ost_cl_sample *samples,
                                      __global const short *voxels, volatile __global ost_cl_scatter_report *report)
{
    const size_t item = get_global_id(0);
    if (item >= scatter->count)
        return;
    const uint i = (uint)item;
    if (samples[i].line == report->conflict_line &&
        ost_differs(&samples[i], ost_ct_position_of(scatter, &samples[i]), voxels))
        atomic_min(&report->conflict_index, i);
}

__kernel void ost_ct_had(__global const ost_cl_scatter *scatter, __global const ost_cl_sample *samples,
                         __global const short *voxels, __global ost_cl_scatter_report *report)
{
    if (get_global_id(0) > 0 || report->conflict_index >= scatter->count)
        return;
    const ost_ct_position position = ost_ct_position_of(scatter, &samples[report->conflict_index]);
    report->conflict_had = voxels[position.voxel];
}

/* ---------------------------------------------------- rect grid to cubic */

/*
 * Computes the source index and the weight of each cubic voxel on each axis (AR-CUB).
 *
 * Ranges. For voxel i, cubic spacing c and rect spacing s, (2i + 1) c < 2^15 * 2^37 and
 * 2s < 2^38, and the remainder of the division is below 2s, so 2^15 times the remainder
 * is < 2^53. The source index is limited to the grid. A weight is above 0 only if the
 * source is not the last voxel, so the upper neighbour is inside the grid too.
 */
__kernel void ost_cubic_sources(__global const ost_cl_cubic *cubic, __global int *sources)
{
    const size_t axes = (size_t)cubic->dims[0] + (size_t)cubic->dims[1] + (size_t)cubic->dims[2];
    size_t item = get_global_id(0), to = item;
    for (int a = 0; a < 3; a++) {
        const size_t n = (size_t)cubic->dims[a];
        if (item < n) {
            const long i = (long)item, c = cubic->cubic_spacing[a], s = cubic->rect_spacing[a],
                       last = cubic->rect_dims[a] - 1;
            long at, weight = 0;
            if (cubic->rule == OST_CL_RESAMPLE_THESIS) {
                at = ost_floor_div(i * c, s);
            } else if (cubic->rule == OST_CL_RESAMPLE_NEAREST) {
                at = ost_floor_div((2 * i + 1) * c, 2 * s);
            } else {
                const long t = (2 * i + 1) * c - s;
                at = t < 0 ? 0 : ost_floor_div(t, 2 * s);
                if (t > 0 && at < last)
                    weight = ost_rhe_div((t - at * 2 * s) * 32768, 2 * s);
            }
            sources[to] = (int)(at < last ? at : last);
            sources[axes + to] = (int)weight;
            return;
        }
        item -= n;
    }
}

/*
 * Copies a run of voxels from their sources. If the spacings along x are equal, voxel i has the source i or, beyond the
 * end of the rect grid, the last source. From one voxel to the next, the source index then increases by 1 or 0. If it
 * increases by count - 1 over the run, the sources are adjacent.
 */
__kernel void ost_cubic_gather(__global const ost_cl_cubic *cubic, __global const int *sources,
                               __global const short *rect, __global short *out)
{
    const size_t nx = (size_t)cubic->dims[0], ny = (size_t)cubic->dims[1];
    const size_t first = OST_RUN * get_global_id(0), j = get_global_id(1), slice = get_global_id(2);
    if (first >= nx || j >= ny || slice >= (size_t)(cubic->z1 - cubic->z0))
        return;
    const size_t k = slice + (size_t)cubic->z0;
    const int count = (int)(nx - first < OST_RUN ? nx - first : OST_RUN), from = sources[first];
    __global const short *row = rect +
                                (ulong)cubic->rect_dims[0] *
                                    ((ulong)sources[nx + j] + (ulong)cubic->rect_dims[1] * (ulong)sources[nx + ny + k]);
    __global short *to = out + (first + (ulong)nx * (j + (ulong)ny * (cubic->slab ? slice : k)));
    if (cubic->cubic_spacing[0] == cubic->rect_spacing[0] && sources[first + (size_t)count - 1] - from == count - 1) {
        for (int i = 0; i < count; i++)
            to[i] = row[from + i];
    } else {
        for (int i = 0; i < count; i++)
            to[i] = row[sources[first + (size_t)i]];
    }
}

/*
 * Interpolates a run of voxels.  For each of four rows, the sum along x, at most 2^30, is multiplied
 * by the product of the row's weights along y and z.  The four results are added.  The four
 * products of weights sum to 2^30.  A neighbour with weight 0 may lie outside the grid; the voxel
 * itself is then read instead of the neighbour.
 */
__kernel void ost_cubic_linear(__global const ost_cl_cubic *cubic, __global const int *sources,
                               __global const short *rect, __global short *out)
{
    const size_t nx = (size_t)cubic->dims[0], ny = (size_t)cubic->dims[1], axes = nx + ny + (size_t)cubic->dims[2];
    const size_t first = OST_RUN * get_global_id(0), j = get_global_id(1), slice = get_global_id(2);
    if (first >= nx || j >= ny || slice >= (size_t)(cubic->z1 - cubic->z0))
        return;
    const size_t k = slice + (size_t)cubic->z0;
    const int count = (int)(nx - first < OST_RUN ? nx - first : OST_RUN);
    const int y = sources[axes + nx + j], z = sources[axes + nx + ny + k];
    const ulong row = (ulong)cubic->rect_dims[0], plane = row * (ulong)cubic->rect_dims[1];
    const ulong down = y > 0 ? row : 0, up = z > 0 ? plane : 0;
    __global const short *row00 = rect + row * (ulong)sources[nx + j] + plane * (ulong)sources[nx + ny + k];
    __global const short *row01 = row00 + down, *row10 = row00 + up, *row11 = row10 + down;
    const int w00 = (32768 - y) * (32768 - z), w01 = y * (32768 - z), w10 = (32768 - y) * z, w11 = y * z;
    __global const int *at = sources + first, *weights = sources + axes + first;
    __global short *to = out + (first + (ulong)nx * (j + (ulong)ny * (cubic->slab ? slice : k)));
    for (int i = 0; i < count; i++) {
        const int a = at[i], upper = weights[i], b = a + (upper > 0 ? 1 : 0), lower = 32768 - upper;
        long sum = (long)(row00[a] * lower + row00[b] * upper) * w00;
        sum += (long)(row01[a] * lower + row01[b] * upper) * w01;
        sum += (long)(row10[a] * lower + row10[b] * upper) * w10;
        sum += (long)(row11[a] * lower + row11[b] * upper) * w11;
        to[i] = ost_mean45(sum);
    }
}
