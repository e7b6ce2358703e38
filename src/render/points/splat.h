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
 * Depth is the squared distance from the eye to the voxel's centre.  On a
 * regular grid that orders voxels along every ray: where a ray goes from voxel
 * A to its neighbour across +x, it has d_x > 0 and passes the shared face at
 * x = A_x + 1/2, so (A - E)_x + 1/2 > 0, and the distance grows by
 * (A_x + 1 - E_x)^2 - (A_x - E_x)^2 = 2 (A_x - E_x) + 1 > 0; so for all axes.
 *
 * Ranges: the eye within 2^15 voxels of every voxel, frames up to 2^13 pixels
 * a side, lists of fewer than 2^32 - 1; an id is slot << 15 | z << 10 | y << 5 | x.
 */
#ifndef OST_RENDER_SPLAT_H
#define OST_RENDER_SPLAT_H

#include "core/isa.h"
#include "render/points/camera.h"
#include "render/points/surface.h"

#define OST_NO_VOXEL UINT32_MAX
enum { OST_NO_FACE = 6, OST_LOCAL_BITS = 15, OST_LANES = 16 };

/* A frame's planes; rows begin at multiples of stride, which is one of OST_LANES; 64-byte aligned. */
typedef struct ost_planes {
    float *distance;
    uint32_t *index;  /* in the list; OST_NO_VOXEL */
    float *depth;     /* along forward, in voxels; of pixels with a face */
    uint8_t *face;    /* ost_face, OST_NO_FACE where there is no voxel */
    uint32_t *colour; /* 0xBBGGRR */
    int stride;
} ost_planes;

/* What a frame knows beforehand: all by ost_splat_prepare. */
typedef struct ost_splat_eye {
    ost_eye eye;
    float axis[3][3];     /* focal * forward, right, up */
    float reach[3];       /* half the width of a voxel along right, up, forward */
} ost_splat_eye;

/* A half side, and one that closes the cracks which rounding leaves between neighbours. */
#define OST_HALF 0.5f
#define OST_HALF_WIDE 0.50005f

/* What is to be drawn, and how it looks from here. */
typedef struct ost_visible {
    uint32_t *id, *look, *tint; /* owned by the frame; tint: colour in full light of the face */
    const float *bases;         /* 4 * slot + a: the block's voxel (0, 0, 0) less the eye */
    uint32_t light[8];          /* of a face, in 256ths, at most 256 */
    uint32_t background;
} ost_visible;

typedef struct ost_splat_kernels {
    /*
     * Points that have a face toward the eye, in their order: slot and place
     * into id, and their looks.  turned[a][i]: the faces of axis a that are
     * turned to the eye at coordinate i, as bits of ost_face.  Both outputs
     * have room for count rounded up to OST_LANES.  Returns how many.
     */
    uint32_t (*facing)(const ost_surface_block *block, uint32_t slot, const uint8_t turned[3][OST_BLOCK], uint32_t *id, uint32_t *look);
    /* Entries first to first + count of the list, all of one block, into rows y0 <= y < y1 of distance and index. */
    void (*splat)(const ost_splat_eye *eye, const ost_visible *visible, uint32_t first, uint32_t count, const ost_planes *planes, int y0,
                  int y1);
    /* Face, depth and colour of a row's pixels, up to the next multiple of OST_LANES. */
    void (*resolve)(const ost_splat_eye *eye, const ost_visible *visible, const ost_planes *planes, int y);
} ost_splat_kernels;

ost_splat_eye ost_splat_prepare(const ost_eye *eye);
/* The functions for an instruction set that this machine has. */
ost_splat_kernels ost_splat_kernels_of(ost_isa isa);

#define OST_SPLAT_DECLARE(SET)                                                                                                      \
    uint32_t ost_facing_##SET(const ost_surface_block *block, uint32_t slot, const uint8_t turned[3][OST_BLOCK], uint32_t *id,      \
                              uint32_t *look);                                                                                     \
    void ost_splat_##SET(const ost_splat_eye *eye, const ost_visible *visible, uint32_t first, uint32_t count,                     \
                         const ost_planes *planes, int y0, int y1);                                                                \
    void ost_resolve_##SET(const ost_splat_eye *eye, const ost_visible *visible, const ost_planes *planes, int y);
OST_SPLAT_DECLARE(scalar)
OST_SPLAT_DECLARE(avx2) /* facing is the scalar one */
OST_SPLAT_DECLARE(avx512)

/* Each channel of a colour times light / 256, rounded down. */
static inline uint32_t ost_lit(uint32_t colour, uint32_t light)
{
    return ((colour & 0xff00ff) * light >> 8 & 0xff00ff) | ((colour & 0xff00) * light >> 8 & 0xff00);
}

#endif
