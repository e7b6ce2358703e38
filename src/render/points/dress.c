/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The smoothing is a sum of nine neighbours an axis (smooth.h).
 *
 *            z, y: -5 .. 36      x: -8 .. 39, of which the first and last few serve only as neighbours
 *   bone    [42][42][48]   0 .. 63
 *     y     [42][34][48]   0 .. 63 * 25
 *     z     [34][34][48]   0 .. 63 * 625 = 39375, then a sixteenth of it, rounded
 *     x     [34][34][34]   0 .. 2461 * 25 = 61525
 *
 * How much bone a voxel is: none, or all of it where nothing is known but the
 * bits.  Where the CT is known it is from a quarter to all of it, by density:
 * a voxel at the border that is bone by half is half as dense, and so the
 * normal of a gentle slope does not see its steps.  Within three voxels of
 * what was cut it is all again: inside, density is not how much bone there is.
 */
#include "render/points/dress.h"

#include <stdlib.h>
#include <string.h>

#include "core/conditions.h"
#include "render/points/extract.h"
#include "render/points/ground.h"
#include "render/points/octahedral.h"
#include "render/points/smooth.h"

enum {
    SIDE = OST_BLOCK,
    REACH = 5,                  /* of the smoothing, and one more for a gradient */
    NEAR = 3,                   /* what is so near to a cut counts as bone, whatever its density */
    WIDE = SIDE + 2 * REACH,    /* rows and slices that are looked at */
    INNER = WIDE - 8,           /* after a sum: the block and one voxel about it */
    SEEN = WIDE + 2 * NEAR,     /* rows and slices of bits */
    LINE = OST_FIELD_LINE, LEFT = 8, /* a row begins at x = -LEFT */
    FLAT = OST_FIELD_FULL / 5 * 3, /* of a plane */
};

_Static_assert(INNER == SIDE + 2, "a gradient needs one voxel on each side");
_Static_assert(REACH + NEAR == OST_LOOK_REACH, "blocks so far from a change are made anew");
_Static_assert(INNER * LINE % OST_FIELD_LANES == 0, "slices are whole vectors");

struct ost_dress_scratch {
    /* [z][y], from -REACH - NEAR on: bits x = -16 .. 47; what is there, what went, what is near that. */
    uint64_t row[SEEN][SEEN], cut[SEEN][SEEN], near[SEEN][SEEN];
    uint16_t bone[WIDE * WIDE * LINE], y[WIDE * INNER * LINE];
    uint16_t z[INNER * INNER * LINE + 2 * LINE], field[INNER * INNER * LINE]; /* z: sums along x look beyond its last line */
    ost_smooth_kernels kernels;
};

/* ------------------------------------------------------------------- field */

typedef const uint32_t *words_of(const ost_surface_block *block);

static const uint32_t *before_of(const ost_surface_block *b) { return b->before; }
static const uint32_t *whole_of(const ost_surface_block *b) { return b->whole; }
static const uint32_t *fresh_of(const ost_surface_block *b) { return b->fresh; }
static const uint32_t *recent_of(const ost_surface_block *b) { return b->recent; }

static void gather(const ost_surface *s, const ost_surface_block *b, words_of *which, uint64_t out[SEEN][SEEN])
{
    static const uint32_t nothing[OST_BLOCK_ROWS];
    const uint32_t *near[3][3][3]; /* z, y, x */
    for (int i = 0; i < 27; i++) {
        const ost_surface_block *n = ost_surface_block_at(s, b->at[0] + i % 3 - 1, b->at[1] + i / 3 % 3 - 1, b->at[2] + i / 9 - 1);
        const uint32_t *words = n ? which(n) : NULL;
        near[i / 9][i / 3 % 3][i % 3] = words ? words : nothing;
    }
    for (int k = 0; k < SEEN; k++)
        for (int j = 0; j < SEEN; j++) {
            const int y = j - OST_LOOK_REACH, z = k - OST_LOOK_REACH;
            const uint32_t *const *n = near[(z >= 0) + (z >= SIDE)][(y >= 0) + (y >= SIDE)];
            const int row = (y & (SIDE - 1)) + SIDE * (z & (SIDE - 1));
            out[k][j] = n[0][row] >> 16 | (uint64_t)n[1][row] << 16 | (uint64_t)n[2][row] << 48;
        }
}

/* False when nothing went: then near is not made; else it is, of all rows but the outer NEAR. */
static bool find_near(const ost_surface *s, const ost_surface_block *b, struct ost_dress_scratch *k)
{
    uint64_t any = 0;
    gather(s, b, before_of, k->cut);
    for (int z = 0; z < SEEN; z++)
        for (int y = 0; y < SEEN; y++)
            any |= k->cut[z][y] &= ~k->row[z][y];
    for (int z = 0; z < SEEN && any; z++)
        for (int y = 0; y < SEEN; y++) {
            uint64_t w = k->cut[z][y];
            w |= w << 1 | w >> 1;
            w |= w << 2 | w >> 2;
            k->near[z][y] = w;
        }
    for (int z = 0; z < SEEN && any; z++)
        for (int y = NEAR; y < SEEN - NEAR; y++) {
            uint64_t w = 0;
            for (int i = -NEAR; i <= NEAR; i++)
                w |= k->near[z][y + i];
            k->cut[z][y] = w;
        }
    for (int z = NEAR; z < SEEN - NEAR && any; z++)
        for (int y = NEAR; y < SEEN - NEAR; y++) {
            uint64_t w = 0;
            for (int i = -NEAR; i <= NEAR; i++)
                w |= k->cut[z + i][y];
            k->near[z][y] = w;
        }
    return any != 0;
}

/* Voxels first to first + LINE - 1 of a row of `size`; beyond it is no bone, whatever is said here. */
static const int16_t *line_of(const int16_t *voxels, int first, int size, int16_t copy[LINE])
{
    if (first >= 0 && first + LINE <= size)
        return voxels + first;
    for (int i = 0; i < LINE; i++)
        copy[i] = first + i >= 0 && first + i < size ? voxels[first + i] : OST_FIELD_DENSE;
    return copy;
}

static void measure(const ost_surface *s, const ost_surface_block *b, struct ost_dress_scratch *k)
{
    gather(s, b, whole_of, k->row);
    const ost_ground *g = s->ground;
    const bool cut = g && find_near(s, b, k);
    const ost_dims d = s->geometry.dims;
    for (int z = 0; z < WIDE; z++)
        for (int y = 0; y < WIDE; y++) {
            const uint64_t row = k->row[z + NEAR][y + NEAR] >> (16 - LEFT);
            uint16_t *out = k->bone + (z * WIDE + y) * LINE;
            const int32_t at[2] = {SIDE * b->at[1] + y - REACH, SIDE * b->at[2] + z - REACH};
            int16_t copy[LINE];
            if (g && at[0] >= 0 && at[1] >= 0 && at[0] < d.y && at[1] < d.z)
                k->kernels.densities(row, cut ? k->near[z + NEAR][y + NEAR] >> (16 - LEFT) : 0,
                                     line_of(g->volume.voxels + (size_t)d.x * ((size_t)at[0] + (size_t)d.y * (size_t)at[1]),
                                             SIDE * b->at[0] - LEFT, d.x, copy),
                                     out);
            else
                k->kernels.bits(row, out);
        }
}

static void smooth(struct ost_dress_scratch *k)
{
    enum { SLICE = INNER * LINE };
    for (int z = 0; z < WIDE; z++)
        k->kernels.nine(k->bone + z * WIDE * LINE, k->y + z * SLICE, SLICE, LINE, false);
    for (int z = 0; z < INNER; z++)
        k->kernels.nine(k->y + z * SLICE, k->z + z * SLICE, SLICE, SLICE, true);
    /* Place i of a line is then x = i - 1: it began at -8, and the sum took four on the left. What is beyond INNER nobody asks for. */
    k->kernels.nine(k->z + LEFT - REACH, k->field, INNER * SLICE, 1, false);
}

uint32_t ost_openness(int field)
{
    const int beyond = field - FLAT;
    const int open = beyond > 0 ? 225 - beyond * 470 / OST_FIELD_FULL : 225 - beyond * 120 / OST_FIELD_FULL;
    return (uint32_t)(open < 40 ? 40 : open > 255 ? 255 : open);
}

/* In the middle of a plate as thin as a voxel the field has no slope; there the open faces decide. */
static inline uint32_t look(const struct ost_dress_scratch *k, uint32_t point)
{
    enum { Y = LINE, Z = INNER * LINE, BY_FACES = 160 };
    const uint16_t *at = k->field + ((point >> 10 & 31) + 1) * Z + ((point >> 5 & 31) + 1) * Y + (point & 31) + 1;
    const int faces = (int)(point >> OST_FACES_SHIFT);
    const float out[3] = {(float)(at[-1] - at[1] + BY_FACES * ((faces >> 1 & 1) - (faces & 1))),
                          (float)(at[-Y] - at[Y] + BY_FACES * ((faces >> 3 & 1) - (faces >> 2 & 1))),
                          (float)(at[-Z] - at[Z] + BY_FACES * ((faces >> 5 & 1) - (faces >> 4 & 1)))};
    return ost_octahedral_of(out) | ost_openness(at[0]) << OST_OPEN_SHIFT;
}

/* ------------------------------------------------------------------- paint */

static bool any_bit(const uint32_t *words, int x, int y, int z)
{
    return words && words[y + SIDE * z] >> x & 1;
}

/* Of the voxel beyond a face of voxel x, y, z. */
static bool beyond(const ost_surface *s, const ost_surface_block *b, int x, int y, int z, int face, words_of *which)
{
    const int step = face % 2 ? 1 : -1;
    const int at[3] = {x + (face / 2 == 0 ? step : 0), y + (face / 2 == 1 ? step : 0), z + (face / 2 == 2 ? step : 0)};
    const int32_t block[3] = {at[0] < 0 ? -1 : at[0] >= SIDE, at[1] < 0 ? -1 : at[1] >= SIDE, at[2] < 0 ? -1 : at[2] >= SIDE};
    if (block[0] | block[1] | block[2])
        b = ost_surface_block_at(s, b->at[0] + block[0], b->at[1] + block[1], b->at[2] + block[2]);
    return b && any_bit(which(b), at[0] & (SIDE - 1), at[1] & (SIDE - 1), at[2] & (SIDE - 1));
}

static bool any_beyond(const ost_surface *s, const ost_surface_block *b, uint32_t point, words_of *which)
{
    for (uint32_t left = point >> OST_FACES_SHIFT; left; left &= left - 1)
        if (beyond(s, b, (int)(point & 31), (int)(point >> 5 & 31), (int)(point >> 10 & 31), __builtin_ctz(left), which))
            return true;
    return false;
}

static uint32_t paint(const ost_surface *s, const ost_surface_block *b, uint32_t point)
{
    const int32_t at[3] = {SIDE * b->at[0] + (int32_t)(point & 31), SIDE * b->at[1] + (int32_t)(point >> 5 & 31),
                           SIDE * b->at[2] + (int32_t)(point >> 10 & 31)};
    uint32_t bits = 0;
    if ((s->any_fresh && any_beyond(s, b, point, fresh_of)) || (s->any_recent && any_beyond(s, b, point, recent_of)))
        bits = OST_LOOK_CONTACT;
    if (s->clipped && any_beyond(s, b, point, whole_of))
        return ost_ground_cap(s->ground, s->colouring, at) << OST_PAINT_SHIFT;
    if (s->ground && s->colouring != OST_COLOUR_BONE && (s->ground->uncut || any_beyond(s, b, point, before_of)))
        bits |= ost_ground_paint(s->ground, s->colouring, at, b->depth ? b->depth[point & 0x7fff] : 0) << OST_PAINT_SHIFT;
    return bits;
}


/* ------------------------------------------------------------------- block */

/* A depth is needed where something was cut at the block's points. */
static ost_status need_depth(ost_surface *s, ost_surface_block *b, ost_error *err)
{
    if (s->colouring != OST_COLOUR_DEPTH || !s->ground || b->depth)
        return OST_OK;
    bool cut = false;
    for (uint32_t i = 0; i < b->count && !cut; i++)
        cut = any_beyond(s, b, b->points[i], before_of);
    return cut ? ost_ground_depth(s, b, err) : OST_OK;
}

static ost_status make_scratch(ost_surface *s, ost_error *err)
{
    ost_isa isa;
    if (s->scratch)
        return OST_OK;
    ost_status status = ost_isa_choose(NULL, &isa, err);
    if (status != OST_OK)
        return status;
    s->scratch = calloc(1, sizeof *s->scratch);
    if (!s->scratch)
        return ost_fail(err, OST_ERR_MEMORY, "no memory to light a surface");
    s->scratch->kernels = ost_smooth_kernels_of(isa);
    return OST_OK;
}

ost_status ost_surface_dress(ost_surface *surface, ost_surface_block *block, ost_error *err)
{
    ost_status status = make_scratch(surface, err);
    if (status != OST_OK || block->count == 0)
        return status;
    status = need_depth(surface, block, err);
    if (status != OST_OK)
        return status;
    struct ost_dress_scratch *k = surface->scratch;
    measure(surface, block, k);
    smooth(k);
    for (uint32_t i = 0; i < block->count; i++)
        block->looks[i] = look(k, block->points[i]);
    if (surface->clipped || surface->any_fresh || surface->any_recent || (surface->ground && surface->colouring != OST_COLOUR_BONE))
        for (uint32_t i = 0; i < block->count; i++)
            block->looks[i] |= paint(surface, block, block->points[i]);
    return OST_OK;
}
