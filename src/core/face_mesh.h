/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Face meshes: the visible faces of a chunk's active voxels as quads (thesis section 3.3.1).
 *
 *   chunk, six neighbours --pad--> 34^3 voxels --classify--> visible faces of each voxel
 *       --prefix sum, compact--> active voxels, first quad of each voxel --quads--> four vertices per face
 *       --copy--> mesh
 *
 * A face is visible if the neighbour at this face is not active. In the lists of the stages, "active voxel" means a
 * voxel with at least one visible face. If a neighbouring chunk does not exist, the shared empty chunk, which has no
 * active voxels, is used instead.
 *
 * The quads of a chunk are in ascending order of the voxel number x + 32 (y + 32 z), and the quads of a voxel are in
 * the order of ost_face. A vertex is one word:
 *
 *   bits  0..5   6..11   12..17   18..20      21         22
 *         x      y       z        ost_face    corner along the face's first and second axis
 *
 * x, y and z are the corner's coordinates, 0 to 32, in units of voxels from the chunk's first corner. If the face is
 * perpendicular to axis a, its first axis is a + 1 and its second axis is a + 2 (modulo 3). The four corners go around
 * the face counter-clockwise as seen from outside. Every backend computes the same words.
 */
#ifndef OST_CORE_FACE_MESH_H
#define OST_CORE_FACE_MESH_H

#include <stddef.h>

#include <osteon/backend.h>

#include "core/visible.h"

enum {
    OST_FACE_CHUNK = 32,       /* edge length of a chunk, in voxels */
    OST_FACE_PADDED = 34,      /* edge length of a chunk with one layer of its neighbours on each side, in voxels */
    OST_FACE_ROWS = 32 * 32,   /* number of words of a chunk's occupancy; bit x of word y + 32 z is voxel (x, y, z) */
    OST_FACE_VOXELS = 32 * 32 * 32,
    /* maximum number of quads of a chunk, reached if half of the voxels have six visible faces */
    OST_FACE_QUADS_MAX = 3 * OST_FACE_VOXELS,
    OST_FACE_CLUSTERS_MAX = 1 << 20, /* maximum number of chunks that one call meshes */
};

/*
 * A chunk and its neighbours, in the order of ost_face. A NULL pointer stands for the shared empty chunk. The words are
 * borrowed.
 */
typedef struct ost_face_cluster {
    const uint32_t *own;
    const uint32_t *neighbour[6];
} ost_face_cluster;

typedef enum ost_face_stage {
    OST_FACE_STAGE_PAD, /* padding a chunk; on a device, includes the transfer of the occupancy words */
    OST_FACE_STAGE_CLASSIFY,
    OST_FACE_STAGE_COMPACT,
    OST_FACE_STAGE_QUADS,
    OST_FACE_STAGE_COPY, /* copying the vertices; on a device, includes their transfer */
    OST_FACE_STAGES
} ost_face_stage;

/* The meshes of several chunks. Must be zero-initialized before its first use. Memory is reused by later calls. */
typedef struct ost_face_mesh {
    size_t count;         /* number of chunks */
    /*
     * owned; count + 1 entries; entry i is the index of the first quad of chunk i, and the last entry is the number of
     * quads
     */
    uint32_t *first;
    uint32_t *vertices;   /* owned; four 32-bit words per quad */
    size_t chunk_capacity, quad_capacity;
    /* Set by the caller: if true, the times of the stages are measured, which makes a call slower. */
    bool timed;
    /* duration of each stage of the last call in ns, summed over chunks and threads */
    int64_t stage_ns[OST_FACE_STAGES];
} ost_face_mesh;

void ost_face_mesh_free(ost_face_mesh *mesh); /* accepts a zero-initialized mesh */
/* Ensures capacity for `chunks` chunks and `quads` quads in total. The content is not changed. */
ost_status ost_face_mesh_reserve(ost_face_mesh *mesh, size_t chunks, size_t quads, ost_error *err);

/*
 * Meshes `count` chunks. Returns OST_ERR_UNAVAILABLE if the backend cannot make face meshes or if its device fails; the
 * mesh is then undefined. One thread at a time may use a backend.
 */
ost_status ost_backend_face_mesh(ost_backend *backend, const ost_face_cluster *clusters, size_t count,
                                 ost_face_mesh *mesh, ost_error *err);

/*
 * Returns the word for corner i of a face, relative to the voxel. The vertex is the sum of this word and
 * ost_face_voxel. On a face in the positive direction of its axis, the corners are (0, 0), (1, 0), (1, 1), (0, 1) along
 * the face's two axes; on a face in the negative direction, their order is reversed.
 */
static inline uint32_t ost_face_corner(unsigned face, unsigned i)
{
    const unsigned axis = face >> 1, side = face & 1, step = side ? i : 3 - i, u = (step == 1) | (step == 2),
                   v = step >> 1;
    const unsigned at_u = 6 * ((axis + 1) % 3), at_v = 6 * ((axis + 2) % 3);
    return side << (6 * axis) | u << at_u | v << at_v | face << 18 | u << 21 | v << 22;
}

/* Returns the coordinates of voxel x + 32 (y + 32 z) in the form of a vertex. */
static inline uint32_t ost_face_voxel(uint32_t number)
{
    return (number & 31) | (number >> 5 & 31) << 6 | (number >> 10 & 31) << 12;
}

#endif
