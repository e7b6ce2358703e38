/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Computes rectangles and outline edges for sixteen voxels at a time. Voxels with small rectangles are then tested
 * sixteen at a time, with one pixel of every rectangle in each step. The covered pixels are collected in a list, and
 * their keys are updated one by one. This avoids stalls: loading a single word that was just stored causes no stall,
 * but loading a register that overlaps this word does. For larger voxels, sixteen pixels are filled at a time, in one
 * row or in two.
 *
 * The file has more than 500 lines, because all steps of one inner loop are inlined into it.
 */
#include "core/conditions.h"
#include "render/points/splat.h"

#include <immintrin.h>

typedef __m512 lanes;
typedef struct lanes3 {
    lanes v[3];
} lanes3;

static inline lanes all(float v)
{
    return _mm512_set1_ps(v);
}

static inline lanes dot(const float axis[3], lanes3 o)
{
    const lanes xy = _mm512_add_ps(_mm512_mul_ps(all(axis[0]), o.v[0]), _mm512_mul_ps(all(axis[1]), o.v[1]));
    return _mm512_add_ps(xy, _mm512_mul_ps(all(axis[2]), o.v[2]));
}

/* Returns, in each lane, half of the sum of |axis[a] - t forward[a]| over the axes a. In the lanes that single[a]
   selects, the term of axis a is omitted. */
static inline lanes spread(const float axis[3], lanes t, const float forward[3], const __mmask16 single[3])
{
    lanes part[3];
    for (int a = 0; a < 3; a++) {
        const lanes off = _mm512_sub_ps(all(axis[a]), _mm512_mul_ps(t, all(forward[a])));
        part[a] = _mm512_maskz_mov_ps((__mmask16)~single[a], _mm512_abs_ps(off));
    }
    return _mm512_mul_ps(all(OST_HALF), _mm512_add_ps(_mm512_add_ps(part[0], part[1]), part[2]));
}

static inline __m512i within(lanes v, int lo, int hi)
{
    return _mm512_cvttps_epi32(_mm512_min_ps(_mm512_max_ps(v, all((float)lo)), all((float)hi)));
}

static inline lanes up(lanes v)
{
    return _mm512_roundscale_ps(v, _MM_FROUND_TO_POS_INF | _MM_FROUND_NO_EXC);
}

static inline lanes down(lanes v)
{
    return _mm512_roundscale_ps(v, _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC);
}

/* Looks up bytes in a table of 32 bytes. `table` contains this table twice, once in each half. */
static inline __m512i turned_at(__m512i table, __m512i index)
{
    return _mm512_permutexvar_epi32(_mm512_and_si512(index, _mm512_set1_epi32(15)), table);
}

static inline __m512i turned_of(const uint8_t turned[OST_BLOCK], __m512i index)
{
    const __m512i low = _mm512_cvtepu8_epi32(_mm_loadu_si128((const void *)turned));
    const __m512i high = _mm512_cvtepu8_epi32(_mm_loadu_si128((const void *)(turned + 16)));
    const __mmask16 upper = _mm512_test_epi32_mask(index, _mm512_set1_epi32(16));
    return _mm512_mask_blend_epi32(upper, turned_at(low, index), turned_at(high, index));
}

uint32_t ost_facing_avx512(const ost_surface_block *block, uint32_t slot, const uint8_t turned[3][OST_BLOCK],
                           ost_chosen *out)
{
    const __m512i one = _mm512_set1_epi32(1);
    const __m512i local = _mm512_set1_epi32((1 << OST_LOCAL_BITS) - 1),
                  high = _mm512_set1_epi32((int)(slot << OST_LOCAL_BITS));
    uint32_t n = 0;
    for (uint32_t i = 0; i < block->count; i += OST_LANES) {
        const uint32_t left = block->count - i;
        const __mmask16 live = left < OST_LANES ? (__mmask16)((1u << left) - 1) : (__mmask16)0xffff;
        const __m512i p = _mm512_maskz_loadu_epi32(live, block->points + i),
                      l = _mm512_maskz_loadu_epi32(live, block->shades + i);
        const __m512i x = turned_of(turned[0], p);
        const __m512i y = turned_of(turned[1], _mm512_srli_epi32(p, 5));
        const __m512i z = turned_of(turned[2], _mm512_srli_epi32(p, 10));
        const __m512i seen = _mm512_and_si512(_mm512_srli_epi32(p, OST_FACES_SHIFT),
                                              _mm512_or_si512(_mm512_or_si512(x, y), z));
        const __mmask16 take = _mm512_test_epi32_mask(seen, seen),
                        several = _mm512_test_epi32_mask(seen, _mm512_sub_epi32(seen, one));
        __m512i only = _mm512_maskz_mov_epi32(_mm512_cmpgt_epi32_mask(seen, _mm512_set1_epi32(3)), one);
        only = _mm512_mask_add_epi32(only, _mm512_cmpgt_epi32_mask(seen, _mm512_set1_epi32(15)), only, one);
        only = _mm512_mask_mov_epi32(only, several, _mm512_set1_epi32(OST_SEVERAL));
        _mm512_storeu_si512(out->id + n,
                            _mm512_maskz_compress_epi32(take, _mm512_or_si512(_mm512_and_si512(p, local), high)));
        _mm512_storeu_si512(out->shade + n, _mm512_maskz_compress_epi32(take, l));
        _mm_storeu_si128((void *)(out->only + n), _mm512_cvtepi32_epi8(_mm512_maskz_compress_epi32(take, only)));
        n += (uint32_t)__builtin_popcount(take);
    }
    return n;
}

/*
 * SMALL: maximum width and height of a small rectangle in pixels; TALL: number of rows for which edges are computed at
 * once
 */
enum { SMALL = 4, TALL = 16 };

typedef struct sixteen {
    _Alignas(64) float edge[6][3][OST_LANES]; /* coefficients a, b, c of an edge (splat_scalar.c) */
    _Alignas(64) int32_t x0[OST_LANES], x1[OST_LANES], y0[OST_LANES], y1[OST_LANES];
    _Alignas(64) uint64_t key[OST_LANES];
} sixteen;

/*
 * Computes the edges of sixteen voxels' outlines. The sign bit of negative[a] is set if rays run in the negative
 * direction of axis a. A bit of the mask single[a] is set if only one face is drawn and this face is on axis a.
 */
static inline void edges_of(const ost_splat_eye *s, lanes3 o, const __m512i negative[3], const __mmask16 single[3],
                            sixteen *out)
{
    __mmask16 turn_first[3], turn_second[3];
    for (int a = 0; a < 3; a++) {
        const int b = (a + 1) % 3, c = (a + 2) % 3;
        const unsigned same = _mm512_cmpeq_epi32_mask(negative[b], negative[c]);
        turn_first[a] = (__mmask16)((single[c] & same) | (single[b] & ~same));
        turn_second[a] = (__mmask16)((single[b] & same) | (single[c] & ~same));
    }
    /* Iterations 0, 1 and 2 compute the coefficients a, b and c of each edge from focal * forward, right and up. */
    for (int i = 0; i < 3; i++) {
        lanes m[3];
        for (int a = 0; a < 3; a++)
            m[a] = _mm512_castsi512_ps(_mm512_xor_si512(_mm512_castps_si512(all(s->wide[i][a])), negative[a]));
        for (int a = 0; a < 3; a++) {
            const int b = (a + 1) % 3, c = (a + 2) % 3;
            const lanes n = _mm512_sub_ps(_mm512_mul_ps(o.v[b], all(s->axis[i][c])),
                                          _mm512_mul_ps(o.v[c], all(s->axis[i][b])));
            const lanes both = _mm512_add_ps(m[b], m[c]),
                        turned = _mm512_mask_sub_ps(_mm512_sub_ps(m[c], m[b]), single[b], m[b], m[c]);
            _mm512_store_ps(out->edge[2 * a][i], _mm512_sub_ps(_mm512_mask_mov_ps(both, turn_first[a], turned), n));
            _mm512_store_ps(out->edge[2 * a + 1][i],
                            _mm512_add_ps(_mm512_mask_mov_ps(both, turn_second[a], turned), n));
        }
    }
}

/* Returns a vector whose sign bit is set if at least one of the six values is negative. */
static inline __m512i any_negative(const lanes f[6])
{
    __m512i v[6];
    for (int i = 0; i < 6; i++)
        v[i] = _mm512_castps_si512(f[i]);
    const __m512i first = _mm512_ternarylogic_epi32(v[0], v[1], v[2], 0xfe),
                  second = _mm512_ternarylogic_epi32(v[3], v[4], v[5], 0xfe);
    return _mm512_or_si512(first, second);
}

/* across() and upward() return the coordinates of pixel centres relative to the forward axis, positive to the right and
 * upward. */
static inline lanes across(const ost_splat_eye *s, __m512i x)
{
    return _mm512_sub_ps(_mm512_add_ps(_mm512_cvtepi32_ps(x), all(0.5f)), all(s->eye.half_w));
}

static inline lanes upward(const ost_splat_eye *s, __m512i y)
{
    return _mm512_sub_ps(all(s->eye.half_h), _mm512_add_ps(_mm512_cvtepi32_ps(y), all(0.5f)));
}

/*
 * Draws the voxels selected by `which`. Their rectangles have at most SMALL x SMALL pixels. The covered pixels are
 * first listed as index << 4 | lane, which fits into 32 bits because frames have at most 2^26 pixels.
 */
static __attribute__((noinline)) void fill_small(const ost_splat_eye *s, const sixteen *r, __mmask16 which,
                                                 const ost_planes *planes)
{
    uint32_t covered[OST_LANES * SMALL * SMALL + OST_LANES], n = 0;
    const __m512i x0 = _mm512_load_si512(r->x0), y0 = _mm512_load_si512(r->y0);
    const __m512i width = _mm512_sub_epi32(_mm512_load_si512(r->x1), x0),
                  height = _mm512_sub_epi32(_mm512_load_si512(r->y1), y0);
    const __m512i lane = _mm512_set_epi32(15, 14, 13, 12, 11, 10, 9, 8, 7, 6, 5, 4, 3, 2, 1, 0);
    const __m512i offset = _mm512_add_epi32(
        _mm512_mullo_epi32(_mm512_sub_epi32(y0, _mm512_set1_epi32(planes->key_top)), _mm512_set1_epi32(planes->stride)),
        x0);
    const __m512i first = _mm512_or_si512(_mm512_slli_epi32(offset, 4), lane);
    lanes ub[SMALL][6];
    __mmask16 column[SMALL];
    int columns = 0;
    for (; columns < SMALL; columns++) {
        column[columns] = _mm512_mask_cmpge_epi32_mask(which, width, _mm512_set1_epi32(columns));
        if (!column[columns])
            break;
        const lanes u = across(s, _mm512_add_epi32(x0, _mm512_set1_epi32(columns)));
        for (int f = 0; f < 6; f++)
            ub[columns][f] = _mm512_mul_ps(u, _mm512_load_ps(r->edge[f][1]));
    }
    for (int j = 0; j < SMALL; j++) {
        const __mmask16 row = _mm512_mask_cmpge_epi32_mask(which, height, _mm512_set1_epi32(j));
        if (!row)
            break;
        const lanes v = upward(s, _mm512_add_epi32(y0, _mm512_set1_epi32(j)));
        lanes start[6];
        for (int f = 0; f < 6; f++)
            start[f] = _mm512_add_ps(_mm512_load_ps(r->edge[f][0]), _mm512_mul_ps(v, _mm512_load_ps(r->edge[f][2])));
        for (int i = 0; i < columns; i++) {
            lanes value[6];
            for (int f = 0; f < 6; f++)
                value[f] = _mm512_add_ps(start[f], ub[i][f]);
            const __mmask16 out = _mm512_movepi32_mask(any_negative(value)), in = (__mmask16)(row & column[i] & ~out);
            const __m512i here = _mm512_add_epi32(first, _mm512_set1_epi32((j * planes->stride + i) << 4));
            _mm512_storeu_si512(covered + n, _mm512_maskz_compress_epi32(in, here));
            n += (uint32_t)__builtin_popcount(in);
        }
    }
    for (uint32_t i = 0; i < n; i++) {
        uint64_t *was = planes->key + (covered[i] >> 4);
        const uint64_t key = r->key[covered[i] & 15], old = *was;
        *was = key < old ? key : old;
    }
}

/* Updates eight pixels of a row. `in` is the mask of the covered pixels. */
static inline void write_nearest(uint64_t *row, __mmask8 in, __m512i key)
{
    const __mmask8 nearer = _mm512_mask_cmplt_epu64_mask(in, key, _mm512_maskz_loadu_epi64(in, row));
    _mm512_mask_storeu_epi64(row, nearer, key);
}

/* Fills a rectangle of up to eight columns, two rows at a time: one row in the even lanes and the
   other in the odd lanes. */
static __attribute__((noinline)) void fill_pairs(const ost_splat_eye *s, const sixteen *r, int k, int y, int rows,
                                                 float start[6][TALL], const ost_planes *planes)
{
    const __m512i step = _mm512_set_epi32(7, 7, 6, 6, 5, 5, 4, 4, 3, 3, 2, 2, 1, 1, 0, 0),
                  key = _mm512_set1_epi64((long long)r->key[k]);
    const lanes u = across(s, _mm512_add_epi32(_mm512_set1_epi32(r->x0[k]), step));
    const unsigned live = (2u << (r->x1[k] - r->x0[k])) - 1;
    uint64_t *row = ost_key_row(planes, y) + r->x0[k];
    lanes ub[6];
    for (int f = 0; f < 6; f++)
        ub[f] = _mm512_mul_ps(u, all(r->edge[f][1][k]));
    for (int j = 0; j < rows; j += 2, row += 2 * (size_t)planes->stride) {
        lanes value[6];
        for (int f = 0; f < 6; f++)
            value[f] = _mm512_add_ps(
                _mm512_broadcast_f32x2(_mm_castsi128_ps(_mm_loadl_epi64((const void *)&start[f][j]))), ub[f]);
        const unsigned in = ~(unsigned)_mm512_movepi32_mask(any_negative(value));
        write_nearest(row, (__mmask8)(_pext_u32(in, 0x5555) & live), key);
        if (j + 1 < rows)
            write_nearest(row + planes->stride, (__mmask8)(_pext_u32(in, 0xaaaa) & live), key);
    }
}

/* Fills a rectangle row by row, sixteen columns at a time. */
static __attribute__((noinline)) void fill_rows(const ost_splat_eye *s, const sixteen *r, int k, int y, int rows,
                                                float start[6][TALL], const ost_planes *planes)
{
    const __m512i step = _mm512_set_epi32(15, 14, 13, 12, 11, 10, 9, 8, 7, 6, 5, 4, 3, 2, 1, 0),
                  key = _mm512_set1_epi64((long long)r->key[k]);
    const int x1 = r->x1[k];
    for (int x = r->x0[k]; x <= x1; x += OST_LANES) {
        const lanes u = across(s, _mm512_add_epi32(_mm512_set1_epi32(x), step));
        const unsigned live = x1 - x < OST_LANES - 1 ? (2u << (x1 - x)) - 1 : 0xffff;
        uint64_t *row = ost_key_row(planes, y) + x;
        lanes ub[6];
        for (int f = 0; f < 6; f++)
            ub[f] = _mm512_mul_ps(u, all(r->edge[f][1][k]));
        for (int j = 0; j < rows; j++, row += planes->stride) {
            lanes value[6];
            for (int f = 0; f < 6; f++)
                value[f] = _mm512_add_ps(all(start[f][j]), ub[f]);
            const unsigned in = ~(unsigned)_mm512_movepi32_mask(any_negative(value)) & live;
            if (in & 0xff)
                write_nearest(row, (__mmask8)in, key);
            if (in >> 8)
                write_nearest(row + 8, (__mmask8)(in >> 8), key);
        }
    }
}

static inline void fill(const ost_splat_eye *s, const sixteen *r, int k, const ost_planes *planes)
{
    const __m512i step = _mm512_set_epi32(15, 14, 13, 12, 11, 10, 9, 8, 7, 6, 5, 4, 3, 2, 1, 0);
    const int y1 = r->y1[k];
    for (int y = r->y0[k]; y <= y1; y += TALL) {
        _Alignas(64) float start[6][TALL];
        const int rows = y1 - y + 1 < TALL ? y1 - y + 1 : TALL;
        const lanes v = upward(s, _mm512_add_epi32(_mm512_set1_epi32(y), step));
        for (int f = 0; f < 6; f++)
            _mm512_store_ps(start[f], _mm512_add_ps(all(r->edge[f][0][k]), _mm512_mul_ps(v, all(r->edge[f][2][k]))));
        if (r->x1[k] - r->x0[k] < 8)
            fill_pairs(s, r, k, y, rows, start, planes);
        else
            fill_rows(s, r, k, y, rows, start, planes);
    }
}

static inline void fill_all(const ost_splat_eye *s, const sixteen *r, __mmask16 which, const ost_planes *planes)
{
    const __m512i wide = _mm512_sub_epi32(_mm512_load_si512(r->x1), _mm512_load_si512(r->x0));
    const __m512i high = _mm512_sub_epi32(_mm512_load_si512(r->y1), _mm512_load_si512(r->y0));
    const __mmask16 small = _mm512_mask_cmplt_epi32_mask(which, _mm512_max_epi32(wide, high), _mm512_set1_epi32(SMALL));
    if (small)
        fill_small(s, r, small, planes);
    for (unsigned left = which & ~(unsigned)small; left; left &= left - 1)
        fill(s, r, __builtin_ctz(left), planes);
}

/* Determines which of sixteen voxels may be visible, and computes their rectangles. */
static inline __mmask16 rectangles(const ost_splat_eye *s, lanes3 o, const __mmask16 single[3], __mmask16 live,
                                   sixteen *out)
{
    static const float origin[3];
    const ost_eye *e = &s->eye;
    const __m512i sign = _mm512_set1_epi32(INT32_MIN);
    live = _mm512_mask_cmp_ps_mask(live, _mm512_sub_ps(dot(e->forward, o), all(s->reach[2])), all(e->near), _CMP_GT_OQ);
    for (int a = 0; a < 3; a++) {
        const __m512i half = _mm512_or_si512(_mm512_and_si512(_mm512_castps_si512(o.v[a]), sign),
                                             _mm512_castps_si512(all(OST_HALF)));
        o.v[a] = _mm512_mask_sub_ps(o.v[a], single[a], o.v[a], _mm512_castsi512_ps(half));
    }
    const lanes x = dot(e->right, o), y = dot(e->up, o), z = dot(e->forward, o);
    const lanes nearest = _mm512_sub_ps(z, spread(e->forward, _mm512_setzero_ps(), origin, single));
    const lanes inverse = _mm512_div_ps(all(1.0f), z), tx = _mm512_mul_ps(x, inverse), ty = _mm512_mul_ps(y, inverse);
    const lanes k = _mm512_div_ps(all(e->focal), nearest);
    const lanes hx = _mm512_add_ps(_mm512_mul_ps(spread(e->right, tx, e->forward, single), k), all(0.01f));
    const lanes hy = _mm512_add_ps(_mm512_mul_ps(spread(e->up, ty, e->forward, single), k), all(0.01f));
    const lanes px = _mm512_add_ps(_mm512_mul_ps(tx, all(e->focal)), all(e->half_w - 0.5f));
    const lanes py = _mm512_sub_ps(all(e->half_h - 0.5f), _mm512_mul_ps(ty, all(e->focal)));
    const __m512i left = within(up(_mm512_sub_ps(px, hx)), 0, e->width),
                  right = within(down(_mm512_add_ps(px, hx)), -1, e->width - 1);
    const __m512i top = within(up(_mm512_sub_ps(py, hy)), 0, e->height),
                  bottom = within(down(_mm512_add_ps(py, hy)), -1, e->height - 1);
    _mm512_store_si512(out->x0, left);
    _mm512_store_si512(out->x1, right);
    _mm512_store_si512(out->y0, top);
    _mm512_store_si512(out->y1, bottom);
    return _mm512_mask_cmple_epi32_mask(_mm512_mask_cmple_epi32_mask(live, left, right), top, bottom);
}

static inline void keys_of(lanes3 o, uint32_t first, sixteen *out)
{
    const __m512i step = _mm512_set_epi32(15, 14, 13, 12, 11, 10, 9, 8, 7, 6, 5, 4, 3, 2, 1, 0);
    const __m512i low = _mm512_set_epi32(23, 7, 22, 6, 21, 5, 20, 4, 19, 3, 18, 2, 17, 1, 16, 0),
                  high = _mm512_add_epi32(low, _mm512_set1_epi32(8));
    const lanes xy = _mm512_add_ps(_mm512_mul_ps(o.v[0], o.v[0]), _mm512_mul_ps(o.v[1], o.v[1]));
    const __m512i distance = _mm512_castps_si512(_mm512_add_ps(xy, _mm512_mul_ps(o.v[2], o.v[2])));
    const __m512i number = _mm512_add_epi32(_mm512_set1_epi32((int)first), step);
    _mm512_store_si512(out->key, _mm512_permutex2var_epi32(number, low, distance));
    _mm512_store_si512(out->key + 8, _mm512_permutex2var_epi32(number, high, distance));
}

/*
 * Draws again those voxels that are so close to the eye that their rays run in both directions of an axis. Each
 * iteration uses a different combination of the signs of these directions.
 */
static inline void fill_inside(const ost_splat_eye *s, lanes3 o, const __mmask16 inside[3], const __mmask16 single[3],
                               __mmask16 live, sixteen *r, const ost_planes *planes)
{
    for (unsigned turned = 1; turned < 8; turned++) {
        __mmask16 which = live;
        __m512i negative[3];
        for (int a = 0; a < 3; a++) {
            const bool turn = turned >> a & 1;
            const __m512i sign = _mm512_set1_epi32(INT32_MIN),
                          down = _mm512_and_si512(_mm512_castps_si512(o.v[a]), sign);
            negative[a] = turn ? _mm512_xor_si512(down, sign) : down;
            which = (__mmask16)(turn ? which & inside[a] : which);
        }
        if (which) {
            edges_of(s, o, negative, single, r);
            fill_all(s, r, which, planes);
        }
    }
}

/* Clips rectangles to the rows of `part`. Returns the lanes whose rectangles contain pixels of `part`. */
static inline __mmask16 into_part(sixteen *r, __mmask16 live, const ost_extent *part)
{
    const __m512i top = _mm512_max_epi32(_mm512_load_si512(r->y0), _mm512_set1_epi32(part->y0));
    const __m512i bottom = _mm512_min_epi32(_mm512_load_si512(r->y1), _mm512_set1_epi32(part->y1 - 1));
    _mm512_store_si512(r->y0, top);
    _mm512_store_si512(r->y1, bottom);
    live = _mm512_mask_cmplt_epi32_mask(live, _mm512_load_si512(r->x0), _mm512_set1_epi32(part->x1));
    live = _mm512_mask_cmpge_epi32_mask(live, _mm512_load_si512(r->x1), _mm512_set1_epi32(part->x0));
    return _mm512_mask_cmple_epi32_mask(live, top, bottom);
}

static inline uint64_t extent_of(const sixteen *r, __mmask16 live)
{
    if (!live)
        return OST_EXTENT_NONE;
    return ost_extent_word(_mm512_mask_reduce_min_epi32(live, _mm512_load_si512(r->x0)),
                           _mm512_mask_reduce_max_epi32(live, _mm512_load_si512(r->x1)) + 1,
                           _mm512_mask_reduce_min_epi32(live, _mm512_load_si512(r->y0)),
                           _mm512_mask_reduce_max_epi32(live, _mm512_load_si512(r->y1)) + 1);
}

void ost_splat_avx512(const ost_splat_eye *eye, const ost_visible *visible, uint32_t slot, uint32_t count,
                      const ost_planes *planes, const ost_extent *part)
{
    const uint32_t first = visible->begin[slot];
    const uint64_t *points = visible->seen + first;
    const float *base = visible->bases + 4 * (size_t)slot;
    const __m512i low = _mm512_set1_epi32(31), sign = _mm512_set1_epi32(INT32_MIN);
    const __m512i even = _mm512_set_epi32(30, 28, 26, 24, 22, 20, 18, 16, 14, 12, 10, 8, 6, 4, 2, 0);
    for (uint32_t i = 0; i < count; i += OST_LANES) {
        _Atomic uint64_t *extent = &visible->extent[(first + i) / OST_LANES];
        const uint64_t known = atomic_load_explicit(extent, memory_order_relaxed);
        if (ost_extent_misses(known, part))
            continue;
        __mmask16 live = count - i < OST_LANES ? (__mmask16)((1u << (count - i)) - 1) : (__mmask16)0xffff, inside[3];
        const __m512i p = _mm512_permutex2var_epi32(_mm512_loadu_si512(points + i), even,
                                                    _mm512_loadu_si512(points + i + 8));
        const __m512i only = _mm512_cvtepu8_epi32(_mm_loadu_si128((const void *)(visible->only + first + i)));
        sixteen r;
        lanes3 o;
        __m512i negative[3];
        __mmask16 single[3];
        for (int a = 0; a < 3; a++) {
            const __m512i at = _mm512_and_si512(_mm512_srl_epi32(p, _mm_cvtsi32_si128(5 * a)), low);
            o.v[a] = _mm512_add_ps(all(base[a]), _mm512_cvtepi32_ps(at));
            negative[a] = _mm512_and_si512(_mm512_castps_si512(o.v[a]), sign);
            inside[a] = _mm512_cmp_ps_mask(_mm512_abs_ps(o.v[a]), all(OST_FACE_HALF), _CMP_LE_OQ);
            single[a] = _mm512_cmpeq_epi32_mask(only, _mm512_set1_epi32(a));
        }
        live = rectangles(eye, o, single, live, &r);
        if (known == OST_EXTENT_UNKNOWN)
            atomic_store_explicit(extent, extent_of(&r, live), memory_order_relaxed);
        live = into_part(&r, live, part);
        if (!live)
            continue;
        keys_of(o, ost_number(slot, i), &r);
        edges_of(eye, o, negative, single, &r);
        fill_all(eye, &r, live, planes);
        if (live & (inside[0] | inside[1] | inside[2]))
            fill_inside(eye, o, inside, single, live, &r, planes);
    }
}

static inline __m512i lit(__m512i colour, __m512i light)
{
    const __m512i rb = _mm512_set1_epi32(0xff00ff), g = _mm512_set1_epi32(0xff00);
    const __m512i a = _mm512_and_si512(_mm512_srli_epi32(_mm512_mullo_epi32(_mm512_and_si512(colour, rb), light), 8),
                                       rb);
    const __m512i b = _mm512_and_si512(_mm512_srli_epi32(_mm512_mullo_epi32(_mm512_and_si512(colour, g), light), 8), g);
    return _mm512_or_si512(a, b);
}

/*
 * For each pixel, computes the vector from the eye to the block of the pixel's voxel, and the voxel's index in the
 * lists. Works block by block, because the voxels in a register belong to few blocks.
 */
static inline __m512i lookup(const ost_visible *visible, __m512i number, __mmask16 any, lanes3 *o)
{
    const __m512i slots = _mm512_srli_epi32(number, OST_LOCAL_BITS);
    __m512i begin = _mm512_setzero_si512();
    *o = (lanes3){{_mm512_setzero_ps(), _mm512_setzero_ps(), _mm512_setzero_ps()}};
    for (unsigned left = any; left;) {
        const __m512i one = _mm512_maskz_compress_epi32((__mmask16)left, slots);
        const uint32_t slot = (uint32_t)_mm512_cvtsi512_si32(one);
        const __mmask16 here = _mm512_mask_cmpeq_epi32_mask((__mmask16)left, slots, _mm512_set1_epi32((int)slot));
        for (int a = 0; a < 3; a++)
            o->v[a] = _mm512_mask_mov_ps(o->v[a], here, all(visible->bases[4 * (size_t)slot + (size_t)a]));
        begin = _mm512_mask_mov_epi32(begin, here, _mm512_set1_epi32((int)visible->begin[slot]));
        left &= ~(unsigned)here;
    }
    return _mm512_add_epi32(begin, _mm512_and_si512(number, _mm512_set1_epi32((1 << OST_LOCAL_BITS) - 1)));
}

static inline __m128i two(const uint64_t *from, uint32_t a, uint32_t b)
{
    return _mm_castpd_si128(
        _mm_loadh_pd(_mm_castsi128_pd(_mm_loadl_epi64((const void *)(from + a))), (const void *)(from + b)));
}

static inline __m256i four(const uint64_t *from, const uint32_t at[4])
{
    return _mm256_inserti128_si256(_mm256_castsi128_si256(two(from, at[0], at[1])), two(from, at[2], at[3]), 1);
}

static inline __m512i eight(const uint64_t *from, const uint32_t at[8])
{
    return _mm512_inserti64x4(_mm512_castsi256_si512(four(from, at)), four(from, at + 4), 1);
}

/* Computes the vectors from the eye to the voxels. */
static inline lanes3 places(lanes3 o, __m512i id)
{
    const __m512i five = _mm512_set1_epi32(31);
    for (int a = 0; a < 3; a++)
        o.v[a] = _mm512_add_ps(
            o.v[a], _mm512_cvtepi32_ps(_mm512_and_si512(_mm512_srl_epi32(id, _mm_cvtsi32_si128(5 * a)), five)));
    return o;
}

/* Computes the face through which each pixel's ray enters the voxel, and the depth there. */
static inline __m512i enter(const ost_splat_eye *eye, lanes3 o, lanes u, float v, lanes *depth)
{
    lanes near[3], d[3];
    for (int a = 0; a < 3; a++) {
        near[a] = _mm512_sub_ps(_mm512_abs_ps(o.v[a]), all(OST_HALF));
        d[a] = _mm512_abs_ps(
            _mm512_add_ps(all(eye->axis[0][a] + v * eye->axis[2][a]), _mm512_mul_ps(u, all(eye->axis[1][a]))));
    }
    const __m512i two = _mm512_set1_epi32(2);
    lanes best_near = near[0], best_d = d[0], best_o = o.v[0];
    __m512i best = _mm512_setzero_si512();
    for (int a = 1; a < 3; a++) {
        const __mmask16 later = _mm512_cmp_ps_mask(_mm512_mul_ps(near[a], best_d), _mm512_mul_ps(best_near, d[a]),
                                                   _CMP_GT_OQ);
        best_near = _mm512_mask_mov_ps(best_near, later, near[a]);
        best_d = _mm512_mask_mov_ps(best_d, later, d[a]);
        best_o = _mm512_mask_mov_ps(best_o, later, o.v[a]);
        best = _mm512_mask_mov_epi32(best, later, a == 1 ? two : _mm512_set1_epi32(4));
    }
    *depth = _mm512_mul_ps(_mm512_div_ps(best_near, _mm512_max_ps(best_d, all(1e-20f))), all(eye->eye.focal));
    return _mm512_or_si512(best, _mm512_srli_epi32(_mm512_castps_si512(best_o), 31));
}

void ost_resolve_avx512(const ost_splat_eye *eye, const ost_visible *visible, const ost_planes *planes, int y, int x0,
                        int x1)
{
    const float v = eye->eye.half_h - ((float)y + 0.5f);
    const __m512i step = _mm512_set_epi32(15, 14, 13, 12, 11, 10, 9, 8, 7, 6, 5, 4, 3, 2, 1, 0);
    const __m512i even = _mm512_add_epi32(step, step), odd = _mm512_add_epi32(even, _mm512_set1_epi32(1));
    const __m512i lights = _mm512_castsi256_si512(_mm256_loadu_si256((const void *)visible->light));
    for (int x = x0; x < x1; x += OST_LANES) {
        const size_t at = ost_row(planes, y) + (size_t)x;
        const uint64_t *key = ost_key_row(planes, y) + x;
        const __m512i low = _mm512_load_si512(key), high = _mm512_load_si512(key + 8);
        const __mmask16 any = _mm512_cmpneq_epi32_mask(_mm512_permutex2var_epi32(low, odd, high),
                                                       _mm512_set1_epi32((int)OST_NO_DISTANCE));
        __m512i face = _mm512_set1_epi32(OST_NO_FACE), colour = _mm512_set1_epi32((int)visible->background);
        if (any) {
            const lanes u = across(eye, _mm512_add_epi32(_mm512_set1_epi32(x), step));
            lanes3 o;
            const __m512i index = lookup(visible, _mm512_permutex2var_epi32(low, even, high), any, &o);
            /* Single loads are faster than a gather. The asm statement keeps the compiler from extracting the
               indices from the register a second time. */
            _Alignas(64) uint32_t at_list[OST_LANES];
            _mm512_store_si512(at_list, _mm512_maskz_mov_epi32(any, index));
            __asm__("" : "+m"(at_list));
            const __m512i first = eight(visible->seen, at_list), second = eight(visible->seen, at_list + 8);
            const __m512i id = _mm512_permutex2var_epi32(first, even, second),
                          tint = _mm512_permutex2var_epi32(first, odd, second);
            lanes depth;
            const __m512i entered = enter(eye, places(o, id), u, v, &depth);
            face = _mm512_mask_mov_epi32(face, any, entered);
            colour = _mm512_mask_mov_epi32(colour, any, lit(tint, _mm512_permutexvar_epi32(entered, lights)));
            _mm512_mask_store_ps(planes->depth + at, any, depth);
        }
        _mm512_store_si512(planes->colour + at, colour);
        _mm_store_si128((void *)(planes->face + at), _mm512_cvtepi32_epi8(face));
    }
}

uint64_t ost_farthest_avx512(const ost_planes *planes, int x, int y, int rows)
{
    const uint64_t *row = ost_key_row(planes, y) + x;
    __m512i most = _mm512_load_si512(row);
    for (int j = 1; j < rows; j++)
        most = _mm512_max_epu64(most, _mm512_load_si512(row += planes->stride));
    return _mm512_reduce_max_epu64(most);
}

void ost_merge_avx512(const ost_planes *to, const ost_planes *from, float scale, int y, int x0, int x1, uint64_t *taken)
{
    const __m128i none = _mm_set1_epi8(OST_NO_FACE);
    for (int x = x0; x < x1; x += OST_LANES) {
        const size_t i = ost_row(from, y) + (size_t)x, at = ost_row(to, y) + (size_t)x;
        const __m128i face = _mm_load_si128((const void *)(from->face + i));
        const __mmask16 any = _mm_cmpneq_epi8_mask(face, none);
        if (!any)
            continue;
        const __mmask16 bare = _mm_cmpeq_epi8_mask(_mm_load_si128((const void *)(to->face + at)), none);
        const lanes depth = _mm512_mul_ps(_mm512_load_ps(from->depth + i), all(scale));
        const __mmask16 nearer = _mm512_cmp_ps_mask(depth, _mm512_load_ps(to->depth + at), _CMP_LT_OQ);
        const __mmask16 take = (__mmask16)(any & (bare | nearer));
        if (!take)
            continue;
        ost_taken(taken, x);
        _mm512_mask_store_ps(to->depth + at, take, depth);
        _mm_mask_storeu_epi8(to->face + at, take, face);
        _mm512_mask_store_epi32(to->colour + at, take, _mm512_load_si512(from->colour + i));
    }
}
