/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The inner loops of a frame, which draw surface points into pixels and compute the visible face of each pixel.
 *
 *   points of a block --facing--> a list of those that have a face toward the eye
 *          --splat--> the nearest voxel of each pixel: its distance, its number in the list
 *          --resolve--> the face by which the pixel's ray enters, its depth and its colour
 *
 * All floats are IEEE single. Each operation is rounded once, in the order of splat_scalar.c, and no operations are
 * fused, so all variants are bit-identical. A pixel belongs to one band, and a band draws blocks in a fixed order, so
 * the result does not depend on the number of threads.
 *
 * For each pixel, one word is stored: the key. The upper half is the squared distance from the eye to the voxel's
 * centre, as the bits of a float. The lower half is the voxel's number: its block's slot << 15 | its index in that
 * block's list. The smallest key of a pixel is kept, so the result depends neither on the order of the voxels nor on
 * the positions of the lists. On a regular grid, the distance of centres orders voxels along every ray. Proof: let a
 * ray from the eye E pass from voxel A to its neighbour across +x. The ray then runs in the direction of +x and passes
 * the shared face at x = A_x + 1/2, so A_x + 1/2 > E_x. The squared distance therefore increases, by (A_x + 1 - E_x)^2
 * - (A_x - E_x)^2 = 2 (A_x - E_x) + 1 > 0. The same applies to all axes.
 *
 * Ranges: the eye is within 2^15 voxels of every voxel; frames have up to 2^13 pixels per side; all lists together have
 * fewer than 2^31 entries; an id is slot << 15 | z << 10 | y << 5 | x.
 */
#ifndef OST_RENDER_SPLAT_H
#define OST_RENDER_SPLAT_H

#include <stdatomic.h>
#include <string.h>

#include "core/isa.h"
#include "render/points/camera.h"
#include "render/points/surface.h"

/* Every byte of an empty pixel's key has this value. The distance in such a key is greater than all others. */
#define OST_EMPTY_BYTE 0x7f
#define OST_NO_DISTANCE UINT32_C(0x7f7f7f7f)
enum { OST_NO_FACE = 6, OST_LOCAL_BITS = 15, OST_LANES = 16, OST_TILE = 8, OST_SEVERAL = 3 };

/*
 * Planes of pixels. Rows begin at multiples of `stride`, which is a multiple of OST_LANES. The planes are 64-byte
 * aligned. To fit into a cache, planes may cover only a band of the frame: their first row is row `top` of the frame,
 * and the first row of the keys is row `key_top`.
 */
typedef struct ost_planes {
    /* squared distance << 32 | number of the voxel; valid only for pixels that may have been drawn to */
    uint64_t *key;
    float *depth;     /* depth along the forward axis, in voxels; valid only for pixels with a face */
    uint8_t *face;    /* a value of ost_face; OST_NO_FACE if the pixel shows no voxel */
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

/* Values that are constant during a frame, computed by ost_splat_prepare. */
typedef struct ost_splat_eye {
    ost_eye eye;
    /* axis[0]: focal * forward; axis[1]: right; axis[2]: up. The ray of pixel (u, v) is axis[0] + u * axis[1] + v *
     * axis[2] */
    float axis[3][3];
    float wide[3][3];     /* axis multiplied by OST_HALF_WIDE */
    float reach[3];       /* half the width of a voxel along right, up and forward */
} ost_splat_eye;

/*
 * OST_HALF is half of a voxel's side. OST_HALF_WIDE is slightly greater, so that rounding leaves no gaps between
 * voxels.
 */
#define OST_HALF 0.5f
#define OST_HALF_WIDE 0.50005f
/* If an eye is within OST_FACE_HALF of a voxel's centre along an axis, the rays to this voxel may run in both
   directions of the axis. */
#define OST_FACE_HALF 0.501f

/* A range of pixels: x0 <= x < x1 and y0 <= y < y1. */
typedef struct ost_extent {
    int x0, x1, y0, y1;
} ost_extent;

/* Special values of an extent that is stored as one word (ost_extent_word). */
#define OST_EXTENT_UNKNOWN UINT64_C(0)
#define OST_EXTENT_NONE UINT64_C(0xffff0000ffff0000)

/*
 * The points of a block that have a face toward the eye. Each thread that computes lists has one such struct as
 * scratch.
 */
typedef struct ost_chosen {
    uint32_t id[OST_BLOCK_POINTS + OST_LANES], shade[OST_BLOCK_POINTS + OST_LANES];
    /* axis of the exposed face that is turned to the eye; OST_SEVERAL if there is more than one */
    uint8_t only[OST_BLOCK_POINTS + OST_LANES];
} ost_chosen;

/* The lists of voxels that have a face toward the eye, with their colours. */
typedef struct ost_visible {
    /* owned by the frame; tint << 32 | id, so that one load reads both; the tint is the voxel's colour in full light */
    uint64_t *seen;
    /* owned by the frame; for each entry, the axis of its only face to draw, as in ost_chosen.only */
    uint8_t *only;
    /*
     * Pixels that each group of OST_LANES entries covers (ost_extent_word), or OST_EXTENT_UNKNOWN until a thread has
     * drawn the group. All threads would store the same value, so they need not wait for each other.
     */
    _Atomic uint64_t *extent;
    /* owned by the frame; for each slot, the index at which its block's list begins */
    uint32_t *begin;
    /* element 4 * slot + a is component a of the vector from the eye to voxel (0, 0, 0) of the slot's block */
    const float *bases;
    uint32_t light[8];          /* light on each face in 256ths, at most 256 */
    uint32_t background;
} ost_visible;

typedef struct ost_splat_kernels {
    /*
     * Selects the points that have a face toward the eye, and returns their number. Preserves their order. turned[a][i]
     * contains, as bits of ost_face, the faces perpendicular to axis a that are turned to the eye at coordinate i.
     */
    uint32_t (*facing)(const ost_surface_block *block, uint32_t slot, const uint8_t turned[3][OST_BLOCK],
                       ost_chosen *out);
    /*
     * Draws a block's list into the keys of the pixels in `part`. In the rows of `part`, keys outside `part` are
     * undefined afterwards.
     */
    void (*splat)(const ost_splat_eye *eye, const ost_visible *visible, uint32_t slot, uint32_t count,
                  const ost_planes *planes, const ost_extent *part);
    /* Computes face, depth and colour of the pixels x0 <= x < x1 of a row. x0 and x1 must be multiples of OST_LANES. */
    void (*resolve)(const ost_splat_eye *eye, const ost_visible *visible, const ost_planes *planes, int y, int x0,
                    int x1);
    /* Returns the greatest key in the tile of up to OST_TILE rows and OST_TILE columns that begins at (x, y). x must
       be a multiple of OST_TILE. */
    uint64_t (*farthest)(const ost_planes *planes, int x, int y, int rows);
    /*
     * Merges the pixels x0 <= x < x1 of row y: copies each pixel that is nearer in the source planes `from` than in the
     * target planes `to`. The depths of `from` are first multiplied by `scale`. Keys are not copied. Sets bit x /
     * OST_LANES of `taken` for each copied pixel.
     */
    void (*merge)(const ost_planes *to, const ost_planes *from, float scale, int y, int x0, int x1, uint64_t *taken);
} ost_splat_kernels;

ost_splat_eye ost_splat_prepare(const ost_eye *eye);
/* Returns the functions for an instruction set, which this machine must support. */
ost_splat_kernels ost_splat_kernels_of(ost_isa isa);

#define OST_SPLAT_DECLARE(SET)                                                                                         \
    uint32_t ost_facing_##SET(const ost_surface_block *block, uint32_t slot, const uint8_t turned[3][OST_BLOCK],       \
                              ost_chosen *out);                                                                        \
    void ost_splat_##SET(const ost_splat_eye *eye, const ost_visible *visible, uint32_t slot, uint32_t count,          \
                         const ost_planes *planes, const ost_extent *part);                                            \
    void ost_resolve_##SET(const ost_splat_eye *eye, const ost_visible *visible, const ost_planes *planes, int y,      \
                           int x0, int x1);                                                                            \
    uint64_t ost_farthest_##SET(const ost_planes *planes, int x, int y, int rows);                                     \
    void ost_merge_##SET(const ost_planes *to, const ost_planes *from, float scale, int y, int x0, int x1,             \
                         uint64_t *taken);
OST_SPLAT_DECLARE(scalar)
OST_SPLAT_DECLARE(avx2) /* `facing` is the scalar function even for AVX2 */
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

static inline uint32_t ost_number(uint32_t slot, uint32_t local)
{
    return slot << OST_LOCAL_BITS | local;
}

/* Returns the index of the list entry with the given voxel number. */
static inline uint32_t ost_visible_index(const ost_visible *visible, uint32_t number)
{
    return visible->begin[number >> OST_LOCAL_BITS] + (number & ((1u << OST_LOCAL_BITS) - 1));
}

/* Packs an extent into one word. 16 bits per coordinate suffice, because frames have at most 2^13 pixels per side. */
static inline uint64_t ost_extent_word(int x0, int x1, int y0, int y1)
{
    return (uint64_t)(uint32_t)x0 << 48 | (uint64_t)(uint32_t)x1 << 32 | (uint64_t)(uint32_t)y0 << 16 |
           (uint64_t)(uint32_t)y1;
}

/* Returns true if `word` is known (not OST_EXTENT_UNKNOWN) and its extent does not overlap `part`. */
static inline bool ost_extent_misses(uint64_t word, const ost_extent *part)
{
    return word != OST_EXTENT_UNKNOWN && ((int)(word >> 16 & 0xffff) >= part->y1 || (int)(word & 0xffff) <= part->y0 ||
                                          (int)(word >> 48) >= part->x1 || (int)(word >> 32 & 0xffff) <= part->x0);
}

#define OST_EMPTY_KEY (UINT64_C(0x0101010101010101) * OST_EMPTY_BYTE)

/* Multiplies each channel of a colour by light / 256, rounded down. */
static inline uint32_t ost_lit(uint32_t colour, uint32_t light)
{
    return ((colour & 0xff00ff) * light >> 8 & 0xff00ff) | ((colour & 0xff00) * light >> 8 & 0xff00);
}

#endif
