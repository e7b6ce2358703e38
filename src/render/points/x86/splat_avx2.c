/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Implements the method of splat_avx512.c with eight lanes. AVX2 cannot compress lanes, so `facing`
 * is the scalar function.
 *
 * The file has more than 500 lines, because all steps of one inner loop are inlined into it.
 */
#include "core/conditions.h"
#include "render/points/splat.h"

#include <immintrin.h>

enum { EIGHT = 8, SMALL = 4 }; /* SMALL is the maximum width and height of a small rectangle in pixels */

typedef __m256 lanes;
typedef struct lanes3 {
    lanes v[3];
} lanes3;

static inline lanes all(float v)
{
    return _mm256_set1_ps(v);
}

static inline lanes absolute(lanes v)
{
    return _mm256_andnot_ps(all(-0.0f), v);
}

static inline lanes dot(const float axis[3], lanes3 o)
{
    const lanes xy = _mm256_add_ps(_mm256_mul_ps(all(axis[0]), o.v[0]), _mm256_mul_ps(all(axis[1]), o.v[1]));
    return _mm256_add_ps(xy, _mm256_mul_ps(all(axis[2]), o.v[2]));
}

/* Returns, in each lane, half of the sum of |axis[a] - t forward[a]| over the axes a. In the lanes that single[a]
   selects, the term of axis a is omitted. */
static inline lanes spread(const float axis[3], lanes t, const float forward[3], const lanes single[3])
{
    lanes part[3];
    for (int a = 0; a < 3; a++)
        part[a] = _mm256_andnot_ps(single[a], absolute(_mm256_sub_ps(all(axis[a]), _mm256_mul_ps(t, all(forward[a])))));
    return _mm256_mul_ps(all(OST_HALF), _mm256_add_ps(_mm256_add_ps(part[0], part[1]), part[2]));
}

static inline __m256i within(lanes v, int lo, int hi)
{
    return _mm256_cvttps_epi32(_mm256_min_ps(_mm256_max_ps(v, all((float)lo)), all((float)hi)));
}

/* Returns a mask of the first n lanes; n >= 1. */
static inline __m256i below(int n)
{
    return _mm256_cmpgt_epi32(_mm256_set1_epi32(n), _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
}

typedef struct eight {
    _Alignas(32) float edge[6][3][EIGHT]; /* coefficients a, b, c of an edge (splat_scalar.c) */
    _Alignas(32) int32_t x0[EIGHT], x1[EIGHT], y0[EIGHT], y1[EIGHT];
    _Alignas(32) uint64_t key[EIGHT];
} eight;

static inline unsigned bits(lanes mask)
{
    return (unsigned)_mm256_movemask_ps(mask);
}

static inline unsigned greater(__m256i a, __m256i b)
{
    return bits(_mm256_castsi256_ps(_mm256_cmpgt_epi32(a, b)));
}

/* Determines which of eight voxels may be visible, and computes their rectangles. */
static inline unsigned rectangles(const ost_splat_eye *s, lanes3 o, const lanes single[3], unsigned live, eight *out)
{
    static const float origin[3];
    const ost_eye *e = &s->eye;
    live &= bits(_mm256_cmp_ps(_mm256_sub_ps(dot(e->forward, o), all(s->reach[2])), all(e->near), _CMP_GT_OQ));
    for (int a = 0; a < 3; a++) {
        const lanes half = _mm256_or_ps(_mm256_and_ps(o.v[a], all(-0.0f)), all(OST_HALF));
        o.v[a] = _mm256_blendv_ps(o.v[a], _mm256_sub_ps(o.v[a], half), single[a]);
    }
    const lanes x = dot(e->right, o), y = dot(e->up, o), z = dot(e->forward, o);
    const lanes nearest = _mm256_sub_ps(z, spread(e->forward, _mm256_setzero_ps(), origin, single));
    const lanes inverse = _mm256_div_ps(all(1.0f), z), tx = _mm256_mul_ps(x, inverse), ty = _mm256_mul_ps(y, inverse);
    const lanes k = _mm256_div_ps(all(e->focal), nearest);
    const lanes hx = _mm256_add_ps(_mm256_mul_ps(spread(e->right, tx, e->forward, single), k), all(0.01f));
    const lanes hy = _mm256_add_ps(_mm256_mul_ps(spread(e->up, ty, e->forward, single), k), all(0.01f));
    const lanes px = _mm256_add_ps(_mm256_mul_ps(tx, all(e->focal)), all(e->half_w - 0.5f));
    const lanes py = _mm256_sub_ps(all(e->half_h - 0.5f), _mm256_mul_ps(ty, all(e->focal)));
    const __m256i left = within(_mm256_ceil_ps(_mm256_sub_ps(px, hx)), 0, e->width);
    const __m256i right = within(_mm256_floor_ps(_mm256_add_ps(px, hx)), -1, e->width - 1);
    const __m256i top = within(_mm256_ceil_ps(_mm256_sub_ps(py, hy)), 0, e->height);
    const __m256i bottom = within(_mm256_floor_ps(_mm256_add_ps(py, hy)), -1, e->height - 1);
    _mm256_store_si256((void *)out->x0, left);
    _mm256_store_si256((void *)out->x1, right);
    _mm256_store_si256((void *)out->y0, top);
    _mm256_store_si256((void *)out->y1, bottom);
    return live & ~greater(left, right) & ~greater(top, bottom);
}

/*
 * Computes the edges of eight voxels' outlines. The sign bit of negative[a] is set if rays run in the negative
 * direction of axis a. All bits of a lane of single[a] are set if only one face is drawn and this face is on axis a.
 */
static inline void edges_of(const ost_splat_eye *s, lanes3 o, const lanes negative[3], const lanes single[3],
                            eight *out)
{
    lanes turn_first[3], turn_second[3];
    for (int a = 0; a < 3; a++) {
        const int b = (a + 1) % 3, c = (a + 2) % 3;
        const lanes same = _mm256_castsi256_ps(
            _mm256_cmpeq_epi32(_mm256_castps_si256(negative[b]), _mm256_castps_si256(negative[c])));
        turn_first[a] = _mm256_or_ps(_mm256_and_ps(single[c], same), _mm256_andnot_ps(same, single[b]));
        turn_second[a] = _mm256_or_ps(_mm256_and_ps(single[b], same), _mm256_andnot_ps(same, single[c]));
    }
    /* Iterations 0, 1 and 2 compute the coefficients a, b and c of each edge from focal * forward, right and up. */
    for (int i = 0; i < 3; i++) {
        lanes m[3];
        for (int a = 0; a < 3; a++)
            m[a] = _mm256_xor_ps(all(s->wide[i][a]), negative[a]);
        for (int a = 0; a < 3; a++) {
            const int b = (a + 1) % 3, c = (a + 2) % 3;
            const lanes n = _mm256_sub_ps(_mm256_mul_ps(o.v[b], all(s->axis[i][c])),
                                          _mm256_mul_ps(o.v[c], all(s->axis[i][b])));
            const lanes both = _mm256_add_ps(m[b], m[c]);
            const lanes turned = _mm256_blendv_ps(_mm256_sub_ps(m[c], m[b]), _mm256_sub_ps(m[b], m[c]), single[b]);
            _mm256_store_ps(out->edge[2 * a][i], _mm256_sub_ps(_mm256_blendv_ps(both, turned, turn_first[a]), n));
            _mm256_store_ps(out->edge[2 * a + 1][i], _mm256_add_ps(_mm256_blendv_ps(both, turned, turn_second[a]), n));
        }
    }
}

/* Returns the lanes in which all six values are nonnegative. */
static inline unsigned none_negative(const lanes f[6])
{
    const lanes first = _mm256_or_ps(_mm256_or_ps(f[0], f[1]), f[2]),
                second = _mm256_or_ps(_mm256_or_ps(f[3], f[4]), f[5]);
    return ~bits(_mm256_or_ps(first, second)) & 0xff;
}

/* across() and upward() return the coordinates of pixel centres relative to the forward axis, positive to the right and
 * upward. */
static inline lanes across(const ost_splat_eye *s, __m256i x)
{
    return _mm256_sub_ps(_mm256_add_ps(_mm256_cvtepi32_ps(x), all(0.5f)), all(s->eye.half_w));
}

static inline lanes upward(const ost_splat_eye *s, __m256i y)
{
    return _mm256_sub_ps(all(s->eye.half_h), _mm256_add_ps(_mm256_cvtepi32_ps(y), all(0.5f)));
}

static inline unsigned at_least(__m256i a, int b)
{
    return greater(a, _mm256_set1_epi32(b - 1));
}

/* Draws the voxels selected by `which`. Their rectangles have at most SMALL x SMALL pixels. The covered pixels are
   first listed as index << 3 | lane. */
static inline void fill_small(const ost_splat_eye *s, const eight *r, unsigned which, const ost_planes *planes)
{
    uint32_t covered[EIGHT * SMALL * SMALL], n = 0;
    const __m256i x0 = _mm256_load_si256((const void *)r->x0), y0 = _mm256_load_si256((const void *)r->y0);
    const __m256i width = _mm256_sub_epi32(_mm256_load_si256((const void *)r->x1), x0);
    const __m256i height = _mm256_sub_epi32(_mm256_load_si256((const void *)r->y1), y0);
    const __m256i offset = _mm256_add_epi32(
        _mm256_mullo_epi32(_mm256_sub_epi32(y0, _mm256_set1_epi32(planes->key_top)), _mm256_set1_epi32(planes->stride)),
        x0);
    _Alignas(32) uint32_t first[EIGHT];
    _mm256_store_si256((void *)first, offset);
    lanes ub[SMALL][6];
    unsigned column[SMALL];
    int columns = 0;
    for (; columns < SMALL; columns++) {
        column[columns] = which & at_least(width, columns);
        if (!column[columns])
            break;
        const lanes u = across(s, _mm256_add_epi32(x0, _mm256_set1_epi32(columns)));
        for (int f = 0; f < 6; f++)
            ub[columns][f] = _mm256_mul_ps(u, _mm256_load_ps(r->edge[f][1]));
    }
    for (int j = 0; j < SMALL; j++) {
        const unsigned row = which & at_least(height, j);
        if (!row)
            break;
        const lanes v = upward(s, _mm256_add_epi32(y0, _mm256_set1_epi32(j)));
        lanes start[6];
        for (int f = 0; f < 6; f++)
            start[f] = _mm256_add_ps(_mm256_load_ps(r->edge[f][0]), _mm256_mul_ps(v, _mm256_load_ps(r->edge[f][2])));
        for (int i = 0; i < columns; i++) {
            lanes value[6];
            for (int f = 0; f < 6; f++)
                value[f] = _mm256_add_ps(start[f], ub[i][f]);
            for (unsigned in = row & column[i] & none_negative(value); in; in &= in - 1) {
                const unsigned k = (unsigned)__builtin_ctz(in);
                covered[n++] = (first[k] + (uint32_t)(j * planes->stride + i)) << 3 | k;
            }
        }
    }
    for (uint32_t i = 0; i < n; i++) {
        uint64_t *was = planes->key + (covered[i] >> 3);
        const uint64_t key = r->key[covered[i] & 7], old = *was;
        *was = key < old ? key : old;
    }
}

/* Updates four pixels of a row. The sign bit of a lane of `in` is set if the pixel is covered. */
static inline void write_nearest(uint64_t *row, __m128i in, __m256i key)
{
    const __m256i mask = _mm256_cvtepi32_epi64(in), was = _mm256_maskload_epi64((const long long *)row, mask);
    _mm256_maskstore_epi64((long long *)row, _mm256_and_si256(mask, _mm256_cmpgt_epi64(was, key)), key);
}

/* Fills a larger rectangle, eight pixels of a row at a time. The sign bit of keys is 0, so they may be compared as
   signed words. */
static inline void fill(const ost_splat_eye *s, const eight *r, int k, const ost_planes *planes)
{
    const __m256i step = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7), key = _mm256_set1_epi64x((long long)r->key[k]);
    const int x1 = r->x1[k];
    for (int x = r->x0[k]; x <= x1; x += EIGHT) {
        const lanes u = across(s, _mm256_add_epi32(_mm256_set1_epi32(x), step));
        const __m256i live = below(x1 - x + 1);
        lanes ub[6], c[6], a[6];
        for (int f = 0; f < 6; f++) {
            ub[f] = _mm256_mul_ps(u, all(r->edge[f][1][k]));
            a[f] = all(r->edge[f][0][k]);
            c[f] = all(r->edge[f][2][k]);
        }
        for (int y = r->y0[k]; y <= r->y1[k]; y++) {
            const lanes v = upward(s, _mm256_set1_epi32(y));
            lanes value[6];
            for (int f = 0; f < 6; f++)
                value[f] = _mm256_add_ps(_mm256_add_ps(a[f], _mm256_mul_ps(v, c[f])), ub[f]);
            const lanes out = _mm256_or_ps(
                _mm256_or_ps(_mm256_or_ps(value[0], value[1]), _mm256_or_ps(value[2], value[3])),
                _mm256_or_ps(value[4], value[5]));
            const __m256i in = _mm256_andnot_si256(_mm256_srai_epi32(_mm256_castps_si256(out), 31), live);
            if (_mm256_testz_si256(in, in))
                continue;
            uint64_t *row = ost_key_row(planes, y) + x;
            write_nearest(row, _mm256_castsi256_si128(in), key);
            if (x1 - x >= 4)
                write_nearest(row + 4, _mm256_extracti128_si256(in, 1), key);
        }
    }
}

static inline void fill_all(const ost_splat_eye *s, const eight *r, unsigned which, const ost_planes *planes)
{
    const __m256i wide = _mm256_sub_epi32(_mm256_load_si256((const void *)r->x1),
                                          _mm256_load_si256((const void *)r->x0));
    const __m256i high = _mm256_sub_epi32(_mm256_load_si256((const void *)r->y1),
                                          _mm256_load_si256((const void *)r->y0));
    const unsigned small = which & ~at_least(_mm256_max_epi32(wide, high), SMALL);
    if (small)
        fill_small(s, r, small, planes);
    for (unsigned left = which & ~small; left; left &= left - 1)
        fill(s, r, __builtin_ctz(left), planes);
}

static inline void keys_of(lanes3 o, uint32_t first, eight *out)
{
    const lanes xy = _mm256_add_ps(_mm256_mul_ps(o.v[0], o.v[0]), _mm256_mul_ps(o.v[1], o.v[1]));
    const __m256i distance = _mm256_castps_si256(_mm256_add_ps(xy, _mm256_mul_ps(o.v[2], o.v[2])));
    const __m256i number = _mm256_add_epi32(_mm256_set1_epi32((int)first), _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
    const __m256i a = _mm256_unpacklo_epi32(number, distance), b = _mm256_unpackhi_epi32(number, distance);
    _mm256_store_si256((void *)out->key, _mm256_permute2x128_si256(a, b, 0x20));
    _mm256_store_si256((void *)(out->key + 4), _mm256_permute2x128_si256(a, b, 0x31));
}

/*
 * Draws again those voxels that are so close to the eye that their rays run in both directions of an axis. Each
 * iteration uses a different combination of the signs of these directions.
 */
static inline void fill_inside(const ost_splat_eye *s, lanes3 o, const unsigned inside[3], const lanes single[3],
                               unsigned live, eight *r, const ost_planes *planes)
{
    for (unsigned turned = 1; turned < 8; turned++) {
        unsigned which = live;
        lanes negative[3];
        for (int a = 0; a < 3; a++) {
            const bool turn = turned >> a & 1;
            const lanes down = _mm256_and_ps(o.v[a], all(-0.0f));
            negative[a] = turn ? _mm256_xor_ps(down, all(-0.0f)) : down;
            which = turn ? which & inside[a] : which;
        }
        if (which) {
            edges_of(s, o, negative, single, r);
            fill_all(s, r, which, planes);
        }
    }
}

/* Clips rectangles to the rows of `part`. Returns the lanes whose rectangles contain pixels of `part`. */
static inline unsigned into_part(eight *r, unsigned live, const ost_extent *part)
{
    const __m256i top = _mm256_max_epi32(_mm256_load_si256((const void *)r->y0), _mm256_set1_epi32(part->y0));
    const __m256i bottom = _mm256_min_epi32(_mm256_load_si256((const void *)r->y1), _mm256_set1_epi32(part->y1 - 1));
    _mm256_store_si256((void *)r->y0, top);
    _mm256_store_si256((void *)r->y1, bottom);
    live &= ~at_least(_mm256_load_si256((const void *)r->x0), part->x1) &
            at_least(_mm256_load_si256((const void *)r->x1), part->x0);
    return live & ~greater(top, bottom);
}

/* Extends *e to contain the rectangles of the live lanes. */
static inline void widen(const eight *r, unsigned live, ost_extent *e)
{
    for (; live; live &= live - 1) {
        const int k = __builtin_ctz(live);
        e->x0 = r->x0[k] < e->x0 ? r->x0[k] : e->x0;
        e->x1 = r->x1[k] + 1 > e->x1 ? r->x1[k] + 1 : e->x1;
        e->y0 = r->y0[k] < e->y0 ? r->y0[k] : e->y0;
        e->y1 = r->y1[k] + 1 > e->y1 ? r->y1[k] + 1 : e->y1;
    }
}

/* Draws up to eight entries of a list, from `offset` on. Extends *extent to contain their rectangles. */
static inline void splat_some(const ost_splat_eye *eye, const ost_visible *visible, uint32_t slot, uint32_t offset,
                              int count, const ost_planes *planes, const ost_extent *part, ost_extent *extent)
{
    const uint32_t first = visible->begin[slot] + offset;
    const float *base = visible->bases + 4 * (size_t)slot;
    const __m256i even = _mm256_setr_epi32(0, 2, 4, 6, 0, 2, 4, 6);
    const __m256i start = _mm256_permutevar8x32_epi32(_mm256_loadu_si256((const void *)(visible->seen + first)), even);
    const __m256i end = _mm256_permutevar8x32_epi32(_mm256_loadu_si256((const void *)(visible->seen + first + 4)),
                                                    even);
    const __m256i p = _mm256_blend_epi32(start, end, 0xf0);
    const __m256i only = _mm256_cvtepu8_epi32(_mm_loadl_epi64((const void *)(visible->only + first)));
    eight r;
    lanes3 o;
    lanes negative[3], single[3];
    unsigned inside[3];
    for (int a = 0; a < 3; a++) {
        const __m256i at = _mm256_and_si256(_mm256_srl_epi32(p, _mm_cvtsi32_si128(5 * a)), _mm256_set1_epi32(31));
        o.v[a] = _mm256_add_ps(all(base[a]), _mm256_cvtepi32_ps(at));
        negative[a] = _mm256_and_ps(o.v[a], all(-0.0f));
        inside[a] = bits(_mm256_cmp_ps(absolute(o.v[a]), all(OST_FACE_HALF), _CMP_LE_OQ));
        single[a] = _mm256_castsi256_ps(_mm256_cmpeq_epi32(only, _mm256_set1_epi32(a)));
    }
    unsigned live = rectangles(eye, o, single, (1u << count) - 1, &r);
    widen(&r, live, extent);
    live = into_part(&r, live, part);
    if (!live)
        return;
    keys_of(o, ost_number(slot, offset), &r);
    edges_of(eye, o, negative, single, &r);
    fill_all(eye, &r, live, planes);
    if (live & (inside[0] | inside[1] | inside[2]))
        fill_inside(eye, o, inside, single, live, &r, planes);
}

void ost_splat_avx2(const ost_splat_eye *eye, const ost_visible *visible, uint32_t slot, uint32_t count,
                    const ost_planes *planes, const ost_extent *part)
{
    for (uint32_t i = 0; i < count; i += OST_LANES) {
        _Atomic uint64_t *extent = &visible->extent[(visible->begin[slot] + i) / OST_LANES];
        const uint64_t known = atomic_load_explicit(extent, memory_order_relaxed);
        ost_extent e = {eye->eye.width, 0, eye->eye.height, 0};
        if (ost_extent_misses(known, part))
            continue;
        for (uint32_t j = i; j < i + OST_LANES && j < count; j += EIGHT)
            splat_some(eye, visible, slot, j, count - j < EIGHT ? (int)(count - j) : EIGHT, planes, part, &e);
        if (known == OST_EXTENT_UNKNOWN)
            atomic_store_explicit(extent, e.y0 < e.y1 ? ost_extent_word(e.x0, e.x1, e.y0, e.y1) : OST_EXTENT_NONE,
                                  memory_order_relaxed);
    }
}

static inline __m256i lit(__m256i colour, __m256i light)
{
    const __m256i rb = _mm256_set1_epi32(0xff00ff), g = _mm256_set1_epi32(0xff00);
    const __m256i a = _mm256_and_si256(_mm256_srli_epi32(_mm256_mullo_epi32(_mm256_and_si256(colour, rb), light), 8),
                                       rb);
    const __m256i b = _mm256_and_si256(_mm256_srli_epi32(_mm256_mullo_epi32(_mm256_and_si256(colour, g), light), 8), g);
    return _mm256_or_si256(a, b);
}

/* For each pixel, computes the vector from the eye to the block of the pixel's voxel, and the voxel's index in the
   lists. */
static inline __m256i lookup(const ost_visible *visible, __m256i number, __m256i any, lanes3 *o)
{
    const __m256i slot = _mm256_srli_epi32(number, OST_LOCAL_BITS);
    __m256i begin = _mm256_setzero_si256();
    _Alignas(32) uint32_t slots[EIGHT];
    *o = (lanes3){{_mm256_setzero_ps(), _mm256_setzero_ps(), _mm256_setzero_ps()}};
    _mm256_store_si256((void *)slots, slot);
    for (unsigned left = bits(_mm256_castsi256_ps(any)); left;) {
        const uint32_t one = slots[__builtin_ctz(left)];
        const __m256i here = _mm256_cmpeq_epi32(slot, _mm256_set1_epi32((int)one));
        for (int a = 0; a < 3; a++)
            o->v[a] = _mm256_blendv_ps(o->v[a], all(visible->bases[4 * (size_t)one + (size_t)a]),
                                       _mm256_castsi256_ps(here));
        begin = _mm256_blendv_epi8(begin, _mm256_set1_epi32((int)visible->begin[one]), here);
        left &= ~bits(_mm256_castsi256_ps(here));
    }
    return _mm256_add_epi32(begin, _mm256_and_si256(number, _mm256_set1_epi32((1 << OST_LOCAL_BITS) - 1)));
}

static inline __m256i four(const uint64_t *from, const uint32_t at[4])
{
    const __m128d low = _mm_loadh_pd(_mm_castsi128_pd(_mm_loadl_epi64((const void *)(from + at[0]))),
                                     (const void *)(from + at[1]));
    const __m128d high = _mm_loadh_pd(_mm_castsi128_pd(_mm_loadl_epi64((const void *)(from + at[2]))),
                                      (const void *)(from + at[3]));
    return _mm256_castpd_si256(_mm256_insertf128_pd(_mm256_castpd128_pd256(low), high, 1));
}

/* Computes the vectors from the eye to the voxels. */
static inline lanes3 places(lanes3 o, __m256i id)
{
    const __m256i five = _mm256_set1_epi32(31);
    for (int a = 0; a < 3; a++)
        o.v[a] = _mm256_add_ps(
            o.v[a], _mm256_cvtepi32_ps(_mm256_and_si256(_mm256_srl_epi32(id, _mm_cvtsi32_si128(5 * a)), five)));
    return o;
}

/* Computes the face through which each pixel's ray enters the voxel, and the depth there. */
static inline __m256i enter(const ost_splat_eye *eye, lanes3 o, lanes u, float v, lanes *depth)
{
    lanes near[3], d[3];
    for (int a = 0; a < 3; a++) {
        near[a] = _mm256_sub_ps(absolute(o.v[a]), all(OST_HALF));
        d[a] = absolute(
            _mm256_add_ps(all(eye->axis[0][a] + v * eye->axis[2][a]), _mm256_mul_ps(u, all(eye->axis[1][a]))));
    }
    lanes best_near = near[0], best_d = d[0], best_o = o.v[0];
    __m256i best = _mm256_setzero_si256();
    for (int a = 1; a < 3; a++) {
        const lanes later = _mm256_cmp_ps(_mm256_mul_ps(near[a], best_d), _mm256_mul_ps(best_near, d[a]), _CMP_GT_OQ);
        best_near = _mm256_blendv_ps(best_near, near[a], later);
        best_d = _mm256_blendv_ps(best_d, d[a], later);
        best_o = _mm256_blendv_ps(best_o, o.v[a], later);
        best = _mm256_blendv_epi8(best, _mm256_set1_epi32(2 * a), _mm256_castps_si256(later));
    }
    *depth = _mm256_mul_ps(_mm256_div_ps(best_near, _mm256_max_ps(best_d, all(1e-20f))), all(eye->eye.focal));
    return _mm256_or_si256(best, _mm256_srli_epi32(_mm256_castps_si256(best_o), 31));
}

void ost_resolve_avx2(const ost_splat_eye *eye, const ost_visible *visible, const ost_planes *planes, int y, int x0,
                      int x1)
{
    const float v = eye->eye.half_h - ((float)y + 0.5f);
    const __m256i step = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7), even = _mm256_setr_epi32(0, 2, 4, 6, 0, 2, 4, 6);
    const __m256i odd = _mm256_setr_epi32(1, 3, 5, 7, 1, 3, 5, 7);
    const __m256i lights = _mm256_loadu_si256((const void *)visible->light);
    for (int x = x0; x < x1; x += EIGHT) {
        const size_t at = ost_row(planes, y) + (size_t)x;
        const uint64_t *key = ost_key_row(planes, y) + x;
        const __m256i low = _mm256_load_si256((const void *)key), high = _mm256_load_si256((const void *)(key + 4));
        const __m256i distance = _mm256_blend_epi32(_mm256_permutevar8x32_epi32(low, odd),
                                                    _mm256_permutevar8x32_epi32(high, odd), 0xf0);
        const __m256i any = _mm256_xor_si256(_mm256_cmpeq_epi32(distance, _mm256_set1_epi32((int)OST_NO_DISTANCE)),
                                             _mm256_set1_epi32(-1));
        __m256i face = _mm256_set1_epi32(OST_NO_FACE), colour = _mm256_set1_epi32((int)visible->background);
        if (!_mm256_testz_si256(any, any)) {
            const lanes u = across(eye, _mm256_add_epi32(_mm256_set1_epi32(x), step));
            const __m256i number = _mm256_blend_epi32(_mm256_permutevar8x32_epi32(low, even),
                                                      _mm256_permutevar8x32_epi32(high, even), 0xf0);
            lanes3 o;
            const __m256i index = lookup(visible, number, any, &o);
            _Alignas(32) uint32_t at_list[EIGHT];
            _mm256_store_si256((void *)at_list, _mm256_and_si256(any, index));
            const __m256i first = four(visible->seen, at_list), second = four(visible->seen, at_list + 4);
            const __m256i id = _mm256_blend_epi32(_mm256_permutevar8x32_epi32(first, even),
                                                  _mm256_permutevar8x32_epi32(second, even), 0xf0);
            const __m256i tint = _mm256_blend_epi32(_mm256_permutevar8x32_epi32(first, odd),
                                                    _mm256_permutevar8x32_epi32(second, odd), 0xf0);
            lanes depth;
            const __m256i entered = enter(eye, places(o, id), u, v, &depth);
            face = _mm256_blendv_epi8(face, entered, any);
            colour = _mm256_blendv_epi8(colour, lit(tint, _mm256_permutevar8x32_epi32(lights, entered)), any);
            _mm256_maskstore_ps(planes->depth + at, any, depth);
        }
        _mm256_store_si256((void *)(planes->colour + at), colour);
        const __m128i half = _mm_packus_epi32(_mm256_castsi256_si128(face), _mm256_extracti128_si256(face, 1));
        _mm_storel_epi64((void *)(planes->face + at), _mm_packus_epi16(half, half));
    }
}

static inline __m256i greater_key(__m256i a, __m256i b)
{
    return _mm256_blendv_epi8(a, b, _mm256_cmpgt_epi64(b, a));
}

uint64_t ost_farthest_avx2(const ost_planes *planes, int x, int y, int rows)
{
    const uint64_t *row = ost_key_row(planes, y) + x;
    __m256i most = _mm256_setzero_si256();
    _Alignas(32) uint64_t part[4];
    for (int j = 0; j < rows; j++, row += planes->stride)
        most = greater_key(
            most, greater_key(_mm256_load_si256((const void *)row), _mm256_load_si256((const void *)(row + 4))));
    _mm256_store_si256((void *)part, most);
    const uint64_t a = part[0] > part[1] ? part[0] : part[1], b = part[2] > part[3] ? part[2] : part[3];
    return a > b ? a : b;
}

void ost_merge_avx2(const ost_planes *to, const ost_planes *from, float scale, int y, int x0, int x1, uint64_t *taken)
{
    const __m256i none = _mm256_set1_epi32(OST_NO_FACE);
    for (int x = x0; x < x1; x += EIGHT) {
        const size_t i = ost_row(from, y) + (size_t)x, at = ost_row(to, y) + (size_t)x;
        const __m256i theirs = _mm256_cvtepu8_epi32(_mm_loadl_epi64((const void *)(from->face + i)));
        const __m256i missing = _mm256_cmpeq_epi32(theirs, none);
        if (_mm256_movemask_epi8(missing) == -1)
            continue;
        const __m256i ours = _mm256_cvtepu8_epi32(_mm_loadl_epi64((const void *)(to->face + at)));
        const lanes depth = _mm256_mul_ps(_mm256_load_ps(from->depth + i), all(scale));
        const __m256i nearer = _mm256_castps_si256(_mm256_cmp_ps(depth, _mm256_load_ps(to->depth + at), _CMP_LT_OQ));
        const __m256i take = _mm256_andnot_si256(missing, _mm256_or_si256(nearer, _mm256_cmpeq_epi32(ours, none)));
        if (_mm256_testz_si256(take, take))
            continue;
        ost_taken(taken, x);
        const __m256i face = _mm256_blendv_epi8(ours, theirs, take);
        const __m128i half = _mm_packus_epi32(_mm256_castsi256_si128(face), _mm256_extracti128_si256(face, 1));
        _mm256_maskstore_ps(to->depth + at, take, depth);
        _mm_storel_epi64((void *)(to->face + at), _mm_packus_epi16(half, half));
        _mm256_maskstore_epi32((int *)to->colour + at, take, _mm256_load_si256((const void *)(from->colour + i)));
    }
}
