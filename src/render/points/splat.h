/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The inner loops of a frame: surface points into pixels, and pixels into faces.
 *
 *   points of a block --facing--> a list of those that show a face to the eye
 *          --splat--> of each pixel the nearest voxel: its distance, its number in the list
 *          --resolve--> the face that the pixel's ray enters by, how deep, which colour
 *
 * All floats are IEEE single, each operation rounded once and in the order
 * that splat_scalar.c has, none fused: so every variant gives the same bits.
 * A pixel belongs to one band, and a band takes blocks in one order: so the
 * number of threads shows nowhere.
 *
 * What a pixel keeps is one word, its key: the squared distance from the eye to
 * the voxel's centre, as the bits of a float, above the voxel's number: its
 * block's slot << 15 | its place in that block's list.  The least key stays, so
 * neither the order in which voxels come shows anywhere nor where lists lie.  On a regular grid that distance orders voxels along every ray: where
 * a ray goes from voxel A to its neighbour across +x, it has d_x > 0 and passes
 * the shared face at x = A_x + 1/2, so (A - E)_x + 1/2 > 0, and the distance
 * grows by (A_x + 1 - E_x)^2 - (A_x - E_x)^2 = 2 (A_x - E_x) + 1 > 0; so for
 * all axes.
 *
 * Ranges: the eye within 2^15 voxels of every voxel, frames up to 2^13 pixels
 * a side, lists of fewer than 2^31 in all; an id is slot << 15 | z << 10 | y << 5 | x.
 */
#ifndef OST_RENDER_SPLAT_H
#define OST_RENDER_SPLAT_H

#include <stdatomic.h>
#include <string.h>

#include "core/isa.h"
#include "render/points/camera.h"
#include "render/points/surface.h"

/* Of a pixel without a voxel: each byte of its key is OST_EMPTY_BYTE, which as a distance is beyond all of them. */
#define OST_EMPTY_BYTE 0x7f
#define OST_NO_DISTANCE UINT32_C(0x7f7f7f7f)
enum { OST_NO_FACE = 6, OST_LOCAL_BITS = 15, OST_LANES = 16, OST_TILE = 8, OST_SEVERAL = 3 };

/*
 * What is known of pixels; rows begin at multiples of stride, which is one of
 * OST_LANES; 64-byte aligned.  Planes may begin below the frame's first row, so
 * that a band's keys stay in a cache: row `top` of the frame is their first,
 * key_top that of the keys.
 */
typedef struct ost_planes {
    uint64_t *key;    /* distance << 32 | number; known where something may have been drawn */
    float *depth;     /* along forward, in voxels; of pixels with a face */
    uint8_t *face;    /* ost_face, OST_NO_FACE where there is no voxel */
    uint32_t *colour; /* 0xBBGGRR */
    int stride;
    int top, key_top;
} ost_planes;

static inline size_t ost_row(const ost_planes *planes, int y)
{
    return (size_t)(y - planes->top) * (size_t)planes->stride;
}

static inline uint64_t *ost_key_row(const ost_planes *planes, int y)
{
    return planes->key + (size_t)(y - planes->key_top) * (size_t)planes->stride;
}

/* What a frame knows beforehand: all by ost_splat_prepare. */
typedef struct ost_splat_eye {
    ost_eye eye;
    float axis[3][3];     /* focal * forward, right, up: a pixel's ray is [0] + u [1] + v [2] */
    float wide[3][3];     /* the same, times OST_HALF_WIDE */
    float reach[3];       /* half the width of a voxel along right, up, forward */
} ost_splat_eye;

/* A half side, and one that closes the cracks which rounding leaves between neighbours. */
#define OST_HALF 0.5f
#define OST_HALF_WIDE 0.50005f
/* An axis on which the eye is no farther than this from a voxel's middle is one along which rays to it go both ways. */
#define OST_BESIDE 0.501f

/* Pixels x0 <= x < x1, y0 <= y < y1. */
typedef struct ost_extent {
    int x0, x1, y0, y1;
} ost_extent;

/* The same in a word. */
#define OST_EXTENT_UNKNOWN UINT64_C(0)
#define OST_EXTENT_NONE UINT64_C(0xffff0000ffff0000)

/* Points of a block that have a face toward the eye: one that a thread makes lists with. */
typedef struct ost_chosen {
    uint32_t id[OST_BLOCK_POINTS + OST_LANES], look[OST_BLOCK_POINTS + OST_LANES];
    uint8_t only[OST_BLOCK_POINTS + OST_LANES]; /* the axis of the one face that is to the air and turned to the eye, OST_SEVERAL */
} ost_chosen;

/* What is to be drawn, and how it looks from here. */
typedef struct ost_visible {
    uint64_t *seen;             /* owned by the frame; tint << 32 | id: a pixel finds both at once. tint: colour in full light of the face */
    uint8_t *only;              /* likewise; as above */
    /*
     * Of OST_LANES entries what they cover, as ost_extent_word has it, or
     * OST_EXTENT_UNKNOWN until they have been drawn once.  Whoever draws them
     * finds the same, so threads need not wait for each other.
     */
    _Atomic uint64_t *extent;
    uint32_t *begin;            /* owned by the frame; of each slot, where the block's list begins */
    const float *bases;         /* 4 * slot + a: the block's voxel (0, 0, 0) less the eye */
    uint32_t light[8];          /* of a face, in 256ths, at most 256 */
    uint32_t background;
} ost_visible;

typedef struct ost_splat_kernels {
    /*
     * Points that have a face toward the eye, in their order.  turned[a][i]: the
     * faces of axis a that are turned to the eye at coordinate i, as bits of
     * ost_face.  Returns how many.
     */
    uint32_t (*facing)(const ost_surface_block *block, uint32_t slot, const uint8_t turned[3][OST_BLOCK], ost_chosen *out);
    /* The list of a block, into the keys of part; of its rows also into others, if any, that hold nothing worth knowing. */
    void (*splat)(const ost_splat_eye *eye, const ost_visible *visible, uint32_t slot, uint32_t count, const ost_planes *planes,
                  const ost_extent *part);
    /* Face, depth and colour of pixels x0 <= x < x1 of a row, both multiples of OST_LANES. */
    void (*resolve)(const ost_splat_eye *eye, const ost_visible *visible, const ost_planes *planes, int y, int x0, int x1);
    /* The greatest key of rows y to y + rows - 1, up to OST_TILE of them, in the OST_TILE columns from x on, a multiple of it. */
    uint64_t (*farthest)(const ost_planes *planes, int x, int y, int rows);
    /*
     * Of each of those pixels what is nearer, into `to`; of the same depth what
     * was there.  from's depths are times scale.  Keys stay.  Where one of the
     * OST_LANES pixels from x on is from's, bit x / OST_LANES of taken is set.
     */
    void (*merge)(const ost_planes *to, const ost_planes *from, float scale, int y, int x0, int x1, uint64_t *taken);
} ost_splat_kernels;

ost_splat_eye ost_splat_prepare(const ost_eye *eye);
/* The functions for an instruction set that this machine has. */
ost_splat_kernels ost_splat_kernels_of(ost_isa isa);

#define OST_SPLAT_DECLARE(SET)                                                                                                      \
    uint32_t ost_facing_##SET(const ost_surface_block *block, uint32_t slot, const uint8_t turned[3][OST_BLOCK], ost_chosen *out);  \
    void ost_splat_##SET(const ost_splat_eye *eye, const ost_visible *visible, uint32_t slot, uint32_t count,                      \
                         const ost_planes *planes, const ost_extent *part);                                                        \
    void ost_resolve_##SET(const ost_splat_eye *eye, const ost_visible *visible, const ost_planes *planes, int y, int x0, int x1);                \
    uint64_t ost_farthest_##SET(const ost_planes *planes, int x, int y, int rows);                                                  \
    void ost_merge_##SET(const ost_planes *to, const ost_planes *from, float scale, int y, int x0, int x1, uint64_t *taken);
OST_SPLAT_DECLARE(scalar)
OST_SPLAT_DECLARE(avx2) /* facing is the scalar one */
OST_SPLAT_DECLARE(avx512)

static inline uint64_t ost_key(float distance, uint32_t number)
{
    uint32_t bits;
    memcpy(&bits, &distance, sizeof bits);
    return (uint64_t)bits << 32 | number;
}

static inline void ost_taken(uint64_t *taken, int x)
{
    taken[x / OST_LANES / 64] |= UINT64_C(1) << (x / OST_LANES % 64);
}

static inline uint32_t ost_number(uint32_t slot, uint32_t place)
{
    return slot << OST_LOCAL_BITS | place;
}

/* Where a number's entry is. */
static inline uint32_t ost_visible_index(const ost_visible *visible, uint32_t number)
{
    return visible->begin[number >> OST_LOCAL_BITS] + (number & ((1u << OST_LOCAL_BITS) - 1));
}

/* Frames have at most 2^13 pixels a side. */
static inline uint64_t ost_extent_word(int x0, int x1, int y0, int y1)
{
    return (uint64_t)(uint32_t)x0 << 48 | (uint64_t)(uint32_t)x1 << 32 | (uint64_t)(uint32_t)y0 << 16 | (uint64_t)(uint32_t)y1;
}

/* Whether it is known to miss part. */
static inline bool ost_extent_misses(uint64_t word, const ost_extent *part)
{
    return word != OST_EXTENT_UNKNOWN && ((int)(word >> 16 & 0xffff) >= part->y1 || (int)(word & 0xffff) <= part->y0 ||
                                          (int)(word >> 48) >= part->x1 || (int)(word >> 32 & 0xffff) <= part->x0);
}

#define OST_EMPTY_KEY (UINT64_C(0x0101010101010101) * OST_EMPTY_BYTE)

/* Each channel of a colour times light / 256, rounded down. */
static inline uint32_t ost_lit(uint32_t colour, uint32_t light)
{
    return ((colour & 0xff00ff) * light >> 8 & 0xff00ff) | ((colour & 0xff00) * light >> 8 & 0xff00);
}

#endif
