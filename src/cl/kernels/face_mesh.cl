/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Face meshes (core/face_mesh.h) in the five steps of thesis section 3.3.1. Each launch processes a batch of chunks;
 * the third dimension of the range selects the chunk. This file is OpenCL C 1.2. It is a separate program, because it
 * computes no voxel.
 *
 *   ost_face_pad        words of a chunk and its neighbours -> 34^3 values of 16 bits  an item: one value
 *   ost_face_classify   -> mask of visible faces of each voxel                         an item: one voxel
 *   ost_face_rows       -> active voxels and faces of each row                         an item: one row of 32 voxels
 *   ost_face_slices     -> their prefix sums within a slice                            an item: one slice of 32 rows
 *   ost_face_compact    -> active voxels without gaps, sums of the chunk               an item: one row
 *   ost_face_quads      -> four vertices for each visible face                         an item: one active voxel
 *
 * ost_face_rows and ost_face_slices are one step, the prefix sum. It has two levels: ost_face_slices sums the rows of a
 * slice, and ost_face_compact adds the sums of the preceding slices. Therefore no kernel needs a barrier, and the size
 * of a work group does not affect the results.
 */
#define SIDE 32
#define PADDED 34
#define VOXELS 32768u
#define ROWS 1024u
#define PADDED_VOXELS 39304u
/* number of words of a chunk and its neighbours: 1024 of the chunk, and a layer of 32 words of each neighbour */
#define CLUSTER_WORDS (1024 + 6 * 32)

/*
 * A layer lies across one axis and extends along the other two. The later of these two axes (z or y) selects the word
 * of the layer, and the earlier one (x or y) selects the bit.
 */
__kernel void ost_face_pad(__global const uint *clusters, __global short *padded)
{
    const uint i = (uint)get_global_id(0), chunk = (uint)get_global_id(2);
    if (i >= PADDED_VOXELS)
        return;
    const int x = (int)(i % PADDED) - 1, y = (int)(i / PADDED % PADDED) - 1, z = (int)(i / (PADDED * PADDED)) - 1;
    const bool in_x = x >= 0 && x < SIDE, in_y = y >= 0 && y < SIDE, in_z = z >= 0 && z < SIDE;
    __global const uint *words = clusters + (size_t)chunk * CLUSTER_WORDS, *layers = words + 1024;
    uint bit = 0;
    if (in_x && in_y && in_z)
        bit = words[y + SIDE * z] >> x;
    else if (in_y && in_z)
        bit = layers[SIDE * (x < 0 ? 0 : 1) + z] >> y;
    else if (in_x && in_z)
        bit = layers[SIDE * (y < 0 ? 2 : 3) + z] >> x;
    else if (in_x && in_y)
        bit = layers[SIDE * (z < 0 ? 4 : 5) + y] >> x;
    padded[(size_t)chunk * PADDED_VOXELS + i] = (short)(bit & 1u);
}

__kernel void ost_face_classify(__global const short *padded, __global uchar *visible)
{
    const uint i = (uint)get_global_id(0), chunk = (uint)get_global_id(2);
    if (i >= VOXELS)
        return;
    const uint x = i & 31u, y = i >> 5 & 31u, z = i >> 10;
    __global const short *p = padded + (size_t)chunk * PADDED_VOXELS + (x + 1) + PADDED * ((y + 1) + PADDED * (z + 1));
    uint mask = 0;
    if (p[0])
        mask = (uint)(p[-1] == 0) | (uint)(p[1] == 0) << 1 | (uint)(p[-PADDED] == 0) << 2 |
               (uint)(p[PADDED] == 0) << 3 | (uint)(p[-PADDED * PADDED] == 0) << 4 |
               (uint)(p[PADDED * PADDED] == 0) << 5;
    visible[(size_t)chunk * VOXELS + i] = (uchar)mask;
}

/* rows: two words for each row, which are the number of active voxels and the number of visible faces */
__kernel void ost_face_rows(__global const uchar *visible, __global uint *rows)
{
    const uint i = (uint)get_global_id(0), chunk = (uint)get_global_id(2);
    if (i >= ROWS)
        return;
    __global const uchar *from = visible + (size_t)chunk * VOXELS + SIDE * i;
    uint voxels = 0, faces = 0;
    for (int x = 0; x < SIDE; x++) {
        const uint mask = from[x];
        voxels += (uint)(mask != 0u);
        faces += popcount(mask);
    }
    __global uint *to = rows + 2 * ((size_t)chunk * ROWS + i);
    to[0] = voxels;
    to[1] = faces;
}

/* Replaces the numbers of each row with their sums over all preceding rows of the slice. Stores the sums over all rows
   of each slice in `slices`. */
__kernel void ost_face_slices(__global uint *rows, __global uint *slices)
{
    const uint z = (uint)get_global_id(0), chunk = (uint)get_global_id(2);
    if (z >= SIDE)
        return;
    uint voxels = 0, faces = 0;
    for (uint y = 0; y < SIDE; y++) {
        __global uint *row = rows + 2 * ((size_t)chunk * ROWS + SIDE * z + y);
        const uint v = row[0], f = row[1];
        row[0] = voxels;
        row[1] = faces;
        voxels += v;
        faces += f;
    }
    __global uint *to = slices + 2 * ((size_t)chunk * SIDE + z);
    to[0] = voxels;
    to[1] = faces;
}

/*
 * active: two words for each active voxel. The first word is the voxel number | visible faces << 15, and the second
 * word is the index of the voxel's first quad in the chunk. sums: the numbers of active voxels and of faces of each
 * chunk.
 */
__kernel void ost_face_compact(__global const uchar *visible, __global const uint *rows, __global const uint *slices,
                               __global uint *active, __global uint *sums)
{
    const uint i = (uint)get_global_id(0), chunk = (uint)get_global_id(2);
    if (i >= ROWS)
        return;
    __global const uint *row = rows + 2 * ((size_t)chunk * ROWS + i), *slice = slices + 2 * (size_t)chunk * SIDE;
    uint voxels = row[0], faces = row[1];
    for (uint z = 0; z < i / SIDE; z++) {
        voxels += slice[2 * z];
        faces += slice[2 * z + 1];
    }
    __global const uchar *from = visible + (size_t)chunk * VOXELS + SIDE * i;
    __global uint *to = active + 2 * (size_t)chunk * VOXELS;
    for (uint x = 0; x < SIDE; x++) {
        const uint mask = from[x];
        if (mask == 0u)
            continue;
        to[2 * voxels] = (SIDE * i + x) | mask << 15;
        to[2 * voxels + 1] = faces;
        voxels++;
        faces += popcount(mask);
    }
    if (i == ROWS - 1) {
        sums[2 * chunk] = voxels;
        sums[2 * chunk + 1] = faces;
    }
}

/* first: for each chunk, the index of its first quad in the batch. A corner has the format of ost_face_corner. */
__kernel void ost_face_quads(__global const uint *active, __global const uint *sums, __global const uint *first,
                             __global uint *vertices)
{
    const uint k = (uint)get_global_id(0), chunk = (uint)get_global_id(2);
    if (k >= sums[2 * chunk])
        return;
    __global const uint *from = active + 2 * ((size_t)chunk * VOXELS + k);
    __global uint *to = vertices + 4 * ((size_t)first[chunk] + from[1]);
    const uint number = from[0], base = (number & 31u) | (number >> 5 & 31u) << 6 | (number >> 10 & 31u) << 12;
    for (uint face = 0; face < 6; face++) {
        if ((number >> (15 + face) & 1u) == 0u)
            continue;
        const uint axis = face >> 1, side = face & 1u, at_u = 6 * ((axis + 1) % 3), at_v = 6 * ((axis + 2) % 3);
        for (uint i = 0; i < 4; i++) {
            const uint step = side ? i : 3 - i, u = (uint)(step == 1 || step == 2), v = step >> 1;
            to[i] = base + (side << (6 * axis) | u << at_u | v << at_v | face << 18 | u << 21 | v << 22);
        }
        to += 4;
    }
}
