/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The bone as a renderer sees it: blocks of 32^3 voxels as bits, and of each
 * block the voxels that have a face to the air.
 *
 *   occupancy words, a row of 32 voxels each --ost_surface_set--> block, dirty
 *   dirty blocks and their six neighbours --ost_surface_update--> surface points
 *
 * A bone of 30 million cells has 1.3 million active voxels and 190,000 of
 * these; nothing else of it can be seen.  Blocks are counted from voxel
 * (0, 0, 0), whatever the chunk size of the bone is.
 *
 * A surface point is two words, one for where it is and one for how it looks:
 *
 *   where   bits   0..4   5..9   10..14   15..20
 *                   x      y       z      which faces are to the air: -x +x -y +y -z +z
 *   look    bits   0..11                  12..19
 *                  normal (octahedral.h)  how open it lies: 255 to all sides, less in a pit
 *
 * The normal is the way out of the bone within two voxels of it.  Both come
 * from the bits alone, so a cut is as smooth as what was there before.
 *
 * One thread at a time; a frame reads and changes nothing.
 */
#ifndef OST_RENDER_SURFACE_H
#define OST_RENDER_SURFACE_H

#include <osteon/grid.h>

enum {
    OST_BLOCK = 32,                  /* voxels on a side */
    OST_BLOCK_ROWS = 32 * 32,        /* row y + 32 z; bit x of it is voxel (x, y, z) */
    OST_BLOCKS_MAX = (1 << 17) - 1,  /* that hold something: an id has 17 bits for the block, and one is "nothing" */
    OST_FACES_SHIFT = 15,
    OST_OPEN_SHIFT = 12,
    OST_LOOK_REACH = 2,              /* voxels about one that its look depends on */
};

typedef enum ost_face { OST_FACE_X0, OST_FACE_X1, OST_FACE_Y0, OST_FACE_Y1, OST_FACE_Z0, OST_FACE_Z1 } ost_face;

typedef struct ost_surface_block {
    int32_t at[3];             /* in blocks */
    bool dirty;
    uint32_t occupancy[OST_BLOCK_ROWS];
    uint32_t count, room;
    uint32_t *points, *looks;  /* owned; count surface points, rows ascending */
} ost_surface_block;

typedef struct ost_surface {
    ost_geometry geometry;     /* of the bone; equal spacing on its axes */
    int32_t blocks[3];         /* the grid in blocks, the last ones perhaps in part outside */
    int32_t *slot_of;          /* owned; of each block of the grid its slot, -1 while it has never held anything */
    ost_surface_block **slot;  /* owned; used of them */
    int32_t used, room;
    uint64_t points;           /* of all blocks, after an update */
} ost_surface;

/* No voxel is active yet. OST_ERR_RANGE when the spacing differs between axes. */
ost_status ost_surface_init(ost_surface *surface, const ost_geometry *geometry, ost_error *err);
void ost_surface_free(ost_surface *surface); /* also of a zeroed one */

/* The block's voxels from now on; bits outside the grid must be 0. OST_ERR_RANGE beyond OST_BLOCKS_MAX blocks. */
ost_status ost_surface_set(ost_surface *surface, const int32_t at[3], const uint32_t occupancy[OST_BLOCK_ROWS], ost_error *err);
/*
 * The same from a chunk of n^3 voxels, at[] in chunks: n is 16, 32 or 64, bit v % 32 of word v / 32 is voxel v = x + n (y + n z).
 * Blocks that were never active and are not now are left out.
 */
ost_status ost_surface_set_chunk(ost_surface *surface, const int32_t at[3], int n, const uint32_t *words, ost_error *err);
/* The same for all blocks: a voxel at or above the threshold is active. */
ost_status ost_surface_set_volume(ost_surface *surface, const ost_volume *volume, int32_t threshold, ost_error *err);

/* Points of every block that was set since the last update, and of the neighbours that it touches. */
ost_status ost_surface_update(ost_surface *surface, ost_error *err);

/* Whether voxels lo to hi, both among them, hold nothing; those outside the grid do not. */
bool ost_surface_is_bare(const ost_surface *surface, const int32_t lo[3], const int32_t hi[3]);

#endif
