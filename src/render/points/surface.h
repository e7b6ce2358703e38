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
 *   look    bits   0..13                  14..21             22..29    30
 *                  normal (octahedral.h)  how open it lies:  paint     bone went
 *                                         255 on an edge,    (ground.h) there just
 *                                         225 on a plane,              now
 *                                         less in a pit
 *
 * Normal and openness come from the bits alone (dress.h), so a cut is as
 * smooth as what was there before.
 *
 *   whole: what is there --clip plane (clip.h)--> occupancy: what is shown of it, and listed
 *
 * One thread at a time; a frame reads and changes nothing.
 */
#ifndef OST_RENDER_SURFACE_H
#define OST_RENDER_SURFACE_H

#include <osteon/grid.h>

enum {
    OST_BLOCK = 32,                  /* voxels on a side */
    OST_BLOCK_ROWS = 32 * 32,        /* row y + 32 z; bit x of it is voxel (x, y, z) */
    OST_BLOCK_POINTS = OST_BLOCK * OST_BLOCK_ROWS, /* at most */
    OST_BLOCKS_MAX = (1 << 17) - 1,  /* that hold something: an id has 17 bits for the block, and one is "nothing" */
    OST_FACES_SHIFT = 15,
    OST_OPEN_SHIFT = 14,
    OST_PAINT_SHIFT = 22,
    OST_LOOK_REACH = 14,             /* voxels about one that its look depends on, at most (renew.c) */
};
#define OST_LOOK_CONTACT (UINT32_C(1) << 30)

typedef enum ost_face { OST_FACE_X0, OST_FACE_X1, OST_FACE_Y0, OST_FACE_Y1, OST_FACE_Z0, OST_FACE_Z1 } ost_face;

typedef struct ost_surface_block {
    int32_t at[3];             /* in blocks */
    bool dirty;                /* to be looked at by the next update: */
    bool unlisted;             /* its points may be others */
    bool anew;                 /* all its looks may be */
    bool unmeasured;           /* its cells may be */
    bool contact;              /* some look has it */
    uint64_t version;          /* of its lists: no two lists of a process have the same; 0 before the first */
    uint32_t occupancy[OST_BLOCK_ROWS]; /* shown */
    uint32_t whole[OST_BLOCK_ROWS];
    uint32_t *changed;         /* owned; of whole, since the last update; NULL: nothing */
    uint32_t *before;          /* owned; as the surface's ground has it; NULL without one */
    uint32_t *fresh, *recent;  /* owned; voxels that went: since the last ost_surface_age, and before that; NULL: none */
    uint16_t *depth;           /* owned; squared distances (ground.h); NULL until one is asked for */
    uint32_t count, room;
    uint8_t cells[OST_BLOCK_ROWS * OST_BLOCK / 8]; /* how much bone is in 2^3 voxels: x, y, z (dress.h) */
    uint32_t *points, *looks;  /* owned; count surface points, rows ascending */
    uint16_t begin[OST_BLOCK_ROWS + 1]; /* of each row its first */
} ost_surface_block;

/* Shown is a voxel v with n . v <= d (clip.h). */
typedef struct ost_clip {
    int32_t n[3];
    int64_t d;
} ost_clip;

typedef struct ost_surface {
    ost_geometry geometry;     /* of the bone; equal spacing on its axes */
    int32_t blocks[3];         /* the grid in blocks, the last ones perhaps in part outside */
    int32_t *slot_of;          /* owned; of each block of the grid its slot, -1 while it has never held anything */
    ost_surface_block **slot;  /* owned; used of them */
    int32_t used, room;
    uint64_t points;           /* of all blocks, after an update */
    int32_t renewals, *renewed; /* owned; slots whose lists the last update made other ones */
    struct ost_ground *ground; /* borrowed; NULL: what was before is not known */
    int colouring;             /* an ost_colouring (palette.h) */
    ost_clip clip;
    bool clipped;              /* by it */
    bool keep_fresh;           /* voxels that go are remembered */
    bool any_fresh, any_recent;
    struct ost_dress_scratch *scratch; /* owned */
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

/* What was there before, of the same grid; and how it is to be painted. All looks are made anew by the next update. */
ost_status ost_surface_set_ground(ost_surface *surface, struct ost_ground *ground, ost_error *err);
void ost_surface_set_colouring(ost_surface *surface, int colouring);
/* With keep_fresh: what is fresh becomes recent, what is recent is forgotten. */
void ost_surface_age(ost_surface *surface);

/* Points and looks that are not what they were at the last update; renewed says of which blocks. */
ost_status ost_surface_update(ost_surface *surface, ost_error *err);

/* Whether voxels lo to hi, both among them, hold nothing; those outside the grid do not. */
bool ost_surface_is_bare(const ost_surface *surface, const int32_t lo[3], const int32_t hi[3]);

#endif
