/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The bone as renderers draw it: blocks of 32^3 voxels as bits, and for each block a list of its surface voxels.
 *
 *   occupancy words, a row of 32 voxels each --ost_surface_set--> block, dirty
 *   dirty blocks and their six neighbours --ost_surface_update--> surface points
 *
 * A bone of 30 million voxels has 1.3 million active voxels and 190,000 surface voxels. Only surface voxels can be
 * visible. Blocks are counted from voxel (0, 0, 0), independently of the bone's chunk size.
 *
 * A surface point consists of two words, one for its position and one for its appearance:
 *
 *   where   bits   0..4   5..9   10..14   15..20
 *                   x      y       z      exposed faces: -x +x -y +y -z +z
 *   look    bits   0..13                  14..21    22..29           30
 *                  normal (octahedral.h)  openness  paint (uncut.h)  1 if bone was just removed there
 *
 * A face of a voxel is exposed if the neighbour at this face is not shown. Openness is 255 on an edge, 225 on a plane,
 * and less in a pit.
 *
 * Normal and openness are computed from the bits (shading.h), so a cut is drawn as smoothly as the uncut surface.
 *
 *   occupied: all active voxels --clip plane (clip.h)--> occupancy: those that are shown and listed
 *
 * Only one thread at a time may use a surface. Drawing a frame only reads the surface.
 */
#ifndef OST_RENDER_SURFACE_H
#define OST_RENDER_SURFACE_H

#include <osteon/grid.h>

#include "core/visible.h"

enum {
    OST_BLOCK = 32, /* voxels per side */
    /* number of rows per block; voxel (x, y, z) is bit x of row y + 32 * z */
    OST_BLOCK_ROWS = 32 * 32,
    OST_BLOCK_POINTS = OST_BLOCK * OST_BLOCK_ROWS, /* maximum number of points of a block */
    /* maximum number of blocks with a slot; an id has 17 bits for the slot, and one value of these bits means "none" */
    OST_BLOCKS_MAX = (1 << 17) - 1,
    OST_FACES_SHIFT = 15,
    OST_OPEN_SHIFT = 14,
    OST_PAINT_SHIFT = 22,
    /* the shade of a point depends only on voxels at most this number of voxels away (renew.c) */
    OST_SHADING_REACH = 14,
};
#define OST_SHADE_CONTACT (UINT32_C(1) << 30)

typedef struct ost_surface_block {
    int32_t at[3];             /* in blocks */
    /* true if the next update must process the block; the next three fields state why */
    bool dirty;
    bool unlisted;             /* true if the block's list of points may have changed */
    bool remade;               /* true if all shades of the block may have changed */
    bool unmeasured;           /* true if the block's cells may have changed */
    bool contact;              /* true if at least one shade of the block has OST_SHADE_CONTACT */
    /* version of the points and shades, unique within the process; 0 before the first list */
    uint64_t version;
    uint64_t listed;           /* value of `version` when the list of points last changed */
    uint32_t occupancy[OST_BLOCK_ROWS]; /* active voxels that are shown */
    uint32_t occupied[OST_BLOCK_ROWS];  /* all active voxels */
    /* owned; voxels of `occupied` that changed since the last update; NULL if none */
    uint32_t *changed;
    uint32_t *before;          /* owned; voxels of the uncut bone; NULL if the surface has no reference */
    /* fresh: voxels removed since the last call of ost_surface_age; recent: voxels removed between the last two calls.
       Both are owned, and NULL if there are no such voxels */
    uint32_t *fresh, *recent;
    uint16_t *depth;           /* owned; squared depths (uncut.h); NULL until needed */
    /* count: number of points; capacity: number of points for which memory is allocated */
    uint32_t count, capacity;
    /* amount of bone in each cell of 2^3 voxels (shading.h); x runs fastest */
    uint8_t cells[OST_BLOCK_ROWS * OST_BLOCK / 8];
    uint32_t *points, *shades; /* owned; `count` points and their looks, in ascending order of rows */
    uint16_t begin[OST_BLOCK_ROWS + 1]; /* index of the first point of each row */
} ost_surface_block;

/* A clip plane. A voxel v is shown if n . v <= d (clip.h). */
typedef struct ost_clip {
    int32_t n[3];
    int64_t d;
} ost_clip;

typedef struct ost_surface {
    ost_geometry geometry;     /* geometry of the bone; the spacing is equal on all axes */
    int32_t blocks[3];         /* number of blocks along each axis; the last block may extend beyond the grid */
    /* owned; slot of each block in the grid; -1 if the block has never contained an active voxel */
    int32_t *slot_of;
    ost_surface_block **slot;  /* owned; the block of each slot; `used` entries */
    int32_t used, capacity;
    uint64_t points;           /* number of points of all blocks; valid after an update */
    /* renewed: slots whose points or shades the last update changed (owned); renewals: number of these slots */
    int32_t renewals, *renewed;
    struct ost_uncut *reference; /* uncut bone; borrowed; NULL if unknown */
    int colouring;             /* an ost_colouring (palette.h) */
    ost_clip clip;
    bool clipped;              /* true if `clip` is in use */
    bool shows_contact;        /* true if removed voxels are recorded in `fresh` */
    bool any_fresh, any_recent;
    struct ost_shading_scratch *scratch; /* owned */
} ost_surface;

/* Creates a surface without active voxels. Returns OST_ERR_RANGE if the spacing differs between axes. */
ost_status ost_surface_init(ost_surface *surface, const ost_geometry *geometry, ost_error *err);
/* Frees the surface's memory. Accepts a zero-initialized surface. */
void ost_surface_free(ost_surface *surface);

/*
 * Replaces the active voxels of a block. at[] is its position in units of blocks. Bits outside the grid must be 0.
 * Returns OST_ERR_RANGE if this would need more than OST_BLOCKS_MAX slots.
 */
ost_status ost_surface_set(ost_surface *surface, const int32_t at[3], const uint32_t occupancy[OST_BLOCK_ROWS],
                           ost_error *err);
/*
 * Replaces the active voxels of a chunk of n^3 voxels, where n is 16, 32 or 64. at[] is its position in units of
 * chunks. Voxel v = x + n * (y + n * z) is bit v % 32 of word v / 32. Allocates no memory for blocks that have never
 * contained an active voxel.
 */
ost_status ost_surface_set_chunk(ost_surface *surface, const int32_t at[3], int n, const uint32_t *words,
                                 ost_error *err);
/* Sets the active voxels of all blocks from a volume. A voxel is active if its density is at least the threshold. */
ost_status ost_surface_set_volume(ost_surface *surface, const ost_volume *volume, int32_t threshold, ost_error *err);

/*
 * ost_surface_set_uncut sets the uncut bone, which is borrowed and must have the same grid. ost_surface_set_colouring
 * sets the colouring. If one of them changes, the next update recomputes all shades.
 */
ost_status ost_surface_set_uncut(ost_surface *surface, struct ost_uncut *reference, ost_error *err);
void ost_surface_set_colouring(ost_surface *surface, int colouring);
/* Starts a new interval for highlighting removed voxels: fresh voxels become recent, and recent voxels are no longer
   highlighted. Has no effect if shows_contact is false. */
void ost_surface_age(ost_surface *surface);

/*
 * Recomputes the points and shades that have changed since the last update, and lists the changed blocks in `renewed`.
 */
ost_status ost_surface_update(ost_surface *surface, ost_error *err);

/* Returns true if none of the voxels `lo` to `hi` (inclusive) is shown. Voxels outside the grid count as not shown. */
bool ost_surface_is_empty(const ost_surface *surface, const int32_t lo[3], const int32_t hi[3]);

#endif
