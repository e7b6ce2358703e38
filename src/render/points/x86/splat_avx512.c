/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Sixteen voxels at a time find their rectangles and what a ray's test needs of
 * them, then one voxel at a time fills sixteen pixels: 4 x 4, or of a row.
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

static inline lanes spread(const float axis[3], lanes t, const float forward[3])
{
    lanes part[3];
    for (int a = 0; a < 3; a++)
        part[a] = _mm512_abs_ps(_mm512_sub_ps(all(axis[a]), _mm512_mul_ps(t, all(forward[a]))));
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

/* Lookup in 32 bytes that lie in both halves of `table`. */
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

uint32_t ost_facing_avx512(const ost_surface_block *block, uint32_t slot, const uint8_t turned[3][OST_BLOCK], uint32_t *id, uint32_t *look)
{
    const __m512i local = _mm512_set1_epi32((1 << OST_LOCAL_BITS) - 1), high = _mm512_set1_epi32((int)(slot << OST_LOCAL_BITS));
    uint32_t n = 0;
    for (uint32_t i = 0; i < block->count; i += OST_LANES) {
        const uint32_t left = block->count - i;
        const __mmask16 live = left < OST_LANES ? (__mmask16)((1u << left) - 1) : (__mmask16)0xffff;
        const __m512i p = _mm512_maskz_loadu_epi32(live, block->points + i), l = _mm512_maskz_loadu_epi32(live, block->looks + i);
        const __m512i x = turned_of(turned[0], p);
        const __m512i y = turned_of(turned[1], _mm512_srli_epi32(p, 5));
        const __m512i z = turned_of(turned[2], _mm512_srli_epi32(p, 10));
        const __m512i seen = _mm512_or_si512(_mm512_or_si512(x, y), z);
        const __mmask16 take = _mm512_test_epi32_mask(_mm512_srli_epi32(p, OST_FACES_SHIFT), seen);
        _mm512_storeu_si512(id + n, _mm512_maskz_compress_epi32(take, _mm512_or_si512(_mm512_and_si512(p, local), high)));
        _mm512_storeu_si512(look + n, _mm512_maskz_compress_epi32(take, l));
        n += (uint32_t)__builtin_popcount(take);
    }
    return n;
}

typedef struct sixteen {
    _Alignas(64) float n[3][3][OST_LANES]; /* o x the axes that a pixel's ray is made of */
    _Alignas(64) float distance[OST_LANES];
    _Alignas(64) int32_t x0[OST_LANES], x1[OST_LANES], y0[OST_LANES], y1[OST_LANES];
} sixteen;

static inline void crosses(const ost_splat_eye *s, lanes3 o, sixteen *out)
{
    for (int i = 0; i < 3; i++)
        for (int a = 0; a < 3; a++) {
            const int b = (a + 1) % 3, c = (a + 2) % 3;
            const lanes left = _mm512_mul_ps(o.v[b], all(s->axis[i][c])), right = _mm512_mul_ps(o.v[c], all(s->axis[i][b]));
            _mm512_store_ps(out->n[i][a], _mm512_sub_ps(left, right));
        }
}

/* Which of sixteen rays meet the voxel: u and v are the pixels' places from the middle of the frame. */
static inline __mmask16 covers(const ost_splat_eye *s, const sixteen *r, int k, lanes u, lanes v, __mmask16 live)
{
    const lanes wide = all(OST_HALF_WIDE);
    lanes n[3], m[3];
    for (int a = 0; a < 3; a++) {
        const lanes row_n = _mm512_sub_ps(all(r->n[0][a][k]), _mm512_mul_ps(v, all(r->n[2][a][k])));
        const lanes row_d = _mm512_sub_ps(all(s->axis[0][a]), _mm512_mul_ps(v, all(s->axis[2][a])));
        n[a] = _mm512_abs_ps(_mm512_add_ps(row_n, _mm512_mul_ps(u, all(r->n[1][a][k]))));
        m[a] = _mm512_abs_ps(_mm512_add_ps(row_d, _mm512_mul_ps(u, all(s->axis[1][a]))));
    }
    live = _mm512_mask_cmp_ps_mask(live, n[0], _mm512_mul_ps(wide, _mm512_add_ps(m[1], m[2])), _CMP_LE_OQ);
    live = _mm512_mask_cmp_ps_mask(live, n[1], _mm512_mul_ps(wide, _mm512_add_ps(m[2], m[0])), _CMP_LE_OQ);
    return _mm512_mask_cmp_ps_mask(live, n[2], _mm512_mul_ps(wide, _mm512_add_ps(m[0], m[1])), _CMP_LE_OQ);
}

/* A rectangle of up to 4 x 4 pixels: a row of it a quarter of the register. */
static inline void fill_small(const ost_splat_eye *s, const sixteen *r, int k, uint32_t index, const ost_planes *planes)
{
    const __m512i column = _mm512_set_epi32(3, 2, 1, 0, 3, 2, 1, 0, 3, 2, 1, 0, 3, 2, 1, 0);
    const __m512i line = _mm512_set_epi32(3, 3, 3, 3, 2, 2, 2, 2, 1, 1, 1, 1, 0, 0, 0, 0);
    const int x = r->x0[k], y = r->y0[k], rows = r->y1[k] - y + 1;
    const unsigned across = (2u << (r->x1[k] - x)) - 1;
    const __mmask8 part = (__mmask8)across;
    const __mmask16 live = (__mmask16)(across * 0x1111u & ((1u << (4 * rows)) - 1));
    const size_t stride = (size_t)planes->stride, at = (size_t)y * stride + (size_t)x;
    /* Rows that are not in it are the first once more, and change nothing. */
    const size_t at1 = rows > 1 ? at + stride : at, at2 = rows > 2 ? at + 2 * stride : at, at3 = rows > 3 ? at + 3 * stride : at;
    lanes was = _mm512_castps128_ps512(_mm_maskz_loadu_ps(part, planes->distance + at));
    was = _mm512_insertf32x4(was, _mm_maskz_loadu_ps(part, planes->distance + at1), 1);
    was = _mm512_insertf32x4(was, _mm_maskz_loadu_ps(part, planes->distance + at2), 2);
    was = _mm512_insertf32x4(was, _mm_maskz_loadu_ps(part, planes->distance + at3), 3);
    const lanes far = all(r->distance[k]);
    __mmask16 hit = _mm512_mask_cmp_ps_mask(live, far, was, _CMP_LT_OQ);
    if (!hit)
        return;
    const lanes px = _mm512_cvtepi32_ps(_mm512_add_epi32(_mm512_set1_epi32(x), column));
    const lanes py = _mm512_cvtepi32_ps(_mm512_add_epi32(_mm512_set1_epi32(y), line));
    const lanes u = _mm512_sub_ps(_mm512_add_ps(px, all(0.5f)), all(s->eye.half_w));
    const lanes v = _mm512_sub_ps(_mm512_add_ps(py, all(0.5f)), all(s->eye.half_h));
    hit = covers(s, r, k, u, v, hit);
    const __m128 far4 = _mm512_castps512_ps128(far);
    const __m128i ids = _mm_set1_epi32((int)index);
    const size_t place[4] = {at, at1, at2, at3};
    for (int i = 0; i < 4; i++) {
        const __mmask8 here = (__mmask8)(hit >> (4 * i) & 15);
        if (here) {
            _mm_mask_storeu_ps(planes->distance + place[i], here, far4);
            _mm_mask_storeu_epi32(planes->index + place[i], here, ids);
        }
    }
}

/* A larger one: sixteen pixels of a row at a time. */
static inline void fill(const ost_splat_eye *s, const sixteen *r, int k, uint32_t index, const ost_planes *planes)
{
    const lanes far = all(r->distance[k]);
    const __m512i ids = _mm512_set1_epi32((int)index);
    const __m512 step = _mm512_set_ps(15, 14, 13, 12, 11, 10, 9, 8, 7, 6, 5, 4, 3, 2, 1, 0);
    const int x1 = r->x1[k];
    for (int x = r->x0[k]; x <= x1; x += OST_LANES) {
        const __mmask16 live = x1 - x < OST_LANES - 1 ? (__mmask16)((2u << (x1 - x)) - 1) : (__mmask16)0xffff;
        const lanes u = _mm512_sub_ps(_mm512_add_ps(_mm512_add_ps(all((float)x), step), all(0.5f)), all(s->eye.half_w));
        for (int y = r->y0[k]; y <= r->y1[k]; y++) {
            float *row = planes->distance + (size_t)y * (size_t)planes->stride + (size_t)x;
            const __mmask16 nearer = _mm512_mask_cmp_ps_mask(live, far, _mm512_maskz_loadu_ps(live, row), _CMP_LT_OQ);
            if (!nearer)
                continue;
            const __mmask16 hit = covers(s, r, k, u, all(((float)y + 0.5f) - s->eye.half_h), nearer);
            _mm512_mask_storeu_ps(row, hit, far);
            _mm512_mask_storeu_epi32(planes->index + (row - planes->distance), hit, ids);
        }
    }
}

/* Which of sixteen voxels may be seen, and where. */
static inline __mmask16 rectangles(const ost_splat_eye *s, lanes3 o, __mmask16 live, int y0, int y1, sixteen *out)
{
    const ost_eye *e = &s->eye;
    const lanes x = dot(e->right, o), y = dot(e->up, o), z = dot(e->forward, o);
    const lanes nearest = _mm512_sub_ps(z, all(s->reach[2]));
    live = _mm512_mask_cmp_ps_mask(live, nearest, all(e->near), _CMP_GT_OQ);
    const lanes inverse = _mm512_div_ps(all(1.0f), z), tx = _mm512_mul_ps(x, inverse), ty = _mm512_mul_ps(y, inverse);
    const lanes k = _mm512_div_ps(all(e->focal), nearest);
    const lanes hx = _mm512_add_ps(_mm512_mul_ps(spread(e->right, tx, e->forward), k), all(0.01f));
    const lanes hy = _mm512_add_ps(_mm512_mul_ps(spread(e->up, ty, e->forward), k), all(0.01f));
    const lanes px = _mm512_add_ps(_mm512_mul_ps(tx, all(e->focal)), all(e->half_w - 0.5f));
    const lanes py = _mm512_sub_ps(all(e->half_h - 0.5f), _mm512_mul_ps(ty, all(e->focal)));
    const __m512i left = within(up(_mm512_sub_ps(px, hx)), 0, e->width), right = within(down(_mm512_add_ps(px, hx)), -1, e->width - 1);
    const __m512i top = within(up(_mm512_sub_ps(py, hy)), y0, y1), bottom = within(down(_mm512_add_ps(py, hy)), y0 - 1, y1 - 1);
    _mm512_store_si512(out->x0, left);
    _mm512_store_si512(out->x1, right);
    _mm512_store_si512(out->y0, top);
    _mm512_store_si512(out->y1, bottom);
    return _mm512_mask_cmple_epi32_mask(_mm512_mask_cmple_epi32_mask(live, left, right), top, bottom);
}

void ost_splat_avx512(const ost_splat_eye *eye, const ost_visible *visible, uint32_t first, uint32_t count, const ost_planes *planes, int y0,
                      int y1)
{
    const uint32_t *points = visible->id + first;
    if (count == 0)
        return;
    const float *base = visible->bases + 4 * (size_t)(points[0] >> OST_LOCAL_BITS);
    const __m512i low = _mm512_set1_epi32(31);
    for (uint32_t i = 0; i < count; i += OST_LANES) {
        const __mmask16 live = count - i < OST_LANES ? (__mmask16)((1u << (count - i)) - 1) : (__mmask16)0xffff;
        const __m512i p = _mm512_maskz_loadu_epi32(live, points + i);
        sixteen r;
        lanes3 o;
        for (int a = 0; a < 3; a++) {
            const __m512i at = _mm512_and_si512(_mm512_srl_epi32(p, _mm_cvtsi32_si128(5 * a)), low);
            o.v[a] = _mm512_add_ps(all(base[a]), _mm512_cvtepi32_ps(at));
        }
        const lanes xy = _mm512_add_ps(_mm512_mul_ps(o.v[0], o.v[0]), _mm512_mul_ps(o.v[1], o.v[1]));
        _mm512_store_ps(r.distance, _mm512_add_ps(xy, _mm512_mul_ps(o.v[2], o.v[2])));
        unsigned left = rectangles(eye, o, live, y0, y1, &r);
        if (left)
            crosses(eye, o, &r);
        for (; left; left &= left - 1) {
            const int k = __builtin_ctz(left);
            if (r.x1[k] - r.x0[k] < 4 && r.y1[k] - r.y0[k] < 4)
                fill_small(eye, &r, k, first + i + (uint32_t)k, planes);
            else
                fill(eye, &r, k, first + i + (uint32_t)k, planes);
        }
    }
}

static inline __m512i lit(__m512i colour, __m512i light)
{
    const __m512i rb = _mm512_set1_epi32(0xff00ff), g = _mm512_set1_epi32(0xff00);
    const __m512i a = _mm512_and_si512(_mm512_srli_epi32(_mm512_mullo_epi32(_mm512_and_si512(colour, rb), light), 8), rb);
    const __m512i b = _mm512_and_si512(_mm512_srli_epi32(_mm512_mullo_epi32(_mm512_and_si512(colour, g), light), 8), g);
    return _mm512_or_si512(a, b);
}

/* The face by which the ray of each pixel enters, and where. */
static inline __m512i enter(const ost_splat_eye *eye, const ost_visible *visible, __m512i id, __mmask16 any, lanes u, float v, lanes *depth)
{
    const __m512i slot = _mm512_slli_epi32(_mm512_srli_epi32(id, OST_LOCAL_BITS), 2), five = _mm512_set1_epi32(31);
    const lanes zero = _mm512_setzero_ps();
    __m512i face = _mm512_setzero_si512();
    lanes t = zero;
    for (int a = 0; a < 3; a++) {
        const __m512i local = _mm512_and_si512(_mm512_srl_epi32(id, _mm_cvtsi32_si128(5 * a)), five);
        const lanes o = _mm512_add_ps(_mm512_mask_i32gather_ps(zero, any, slot, visible->bases + a, 4), _mm512_cvtepi32_ps(local));
        lanes d = _mm512_add_ps(all(eye->axis[0][a] - v * eye->axis[2][a]), _mm512_mul_ps(u, all(eye->axis[1][a])));
        d = _mm512_mask_mov_ps(d, _mm512_cmp_ps_mask(d, zero, _CMP_EQ_OQ), all(1e-20f));
        const lanes inverse = _mm512_div_ps(all(1.0f), d);
        const lanes in = _mm512_sub_ps(_mm512_mul_ps(o, inverse), _mm512_mul_ps(all(OST_HALF), _mm512_abs_ps(inverse)));
        const __mmask16 later = a == 0 ? (__mmask16)0xffff : _mm512_cmp_ps_mask(in, t, _CMP_GT_OQ);
        const __mmask16 back = _mm512_cmp_ps_mask(d, zero, _CMP_LT_OQ);
        t = _mm512_mask_mov_ps(t, later, in);
        face = _mm512_mask_mov_epi32(face, later, _mm512_mask_blend_epi32(back, _mm512_set1_epi32(2 * a), _mm512_set1_epi32(2 * a + 1)));
    }
    *depth = _mm512_mul_ps(t, all(eye->eye.focal));
    return face;
}

void ost_resolve_avx512(const ost_splat_eye *eye, const ost_visible *visible, const ost_planes *planes, int y)
{
    const float v = ((float)y + 0.5f) - eye->eye.half_h;
    const __m512 step = _mm512_set_ps(15, 14, 13, 12, 11, 10, 9, 8, 7, 6, 5, 4, 3, 2, 1, 0);
    const __m512i lights = _mm512_castsi256_si512(_mm256_loadu_si256((const void *)visible->light));
    for (int x = 0; x < planes->stride; x += OST_LANES) {
        const size_t at = (size_t)y * (size_t)planes->stride + (size_t)x;
        const __m512i index = _mm512_load_si512(planes->index + at);
        const __mmask16 any = _mm512_cmpneq_epi32_mask(index, _mm512_set1_epi32(-1));
        __m512i face = _mm512_set1_epi32(OST_NO_FACE), colour = _mm512_set1_epi32((int)visible->background);
        if (any) {
            const lanes u = _mm512_sub_ps(_mm512_add_ps(_mm512_add_ps(all((float)x), step), all(0.5f)), all(eye->eye.half_w));
            /* Gathers take their index as signed, and their scale of 4 makes bytes of it: 2^31 entries are far beyond any list. */
            const __m512i id = _mm512_mask_i32gather_epi32(_mm512_setzero_si512(), any, index, visible->id, 4);
            const __m512i tint = _mm512_mask_i32gather_epi32(_mm512_setzero_si512(), any, index, visible->tint, 4);
            lanes depth;
            const __m512i entered = enter(eye, visible, id, any, u, v, &depth);
            face = _mm512_mask_mov_epi32(face, any, entered);
            colour = _mm512_mask_mov_epi32(colour, any, lit(tint, _mm512_permutexvar_epi32(entered, lights)));
            _mm512_mask_store_ps(planes->depth + at, any, depth);
        }
        _mm512_store_si512(planes->colour + at, colour);
        _mm_store_si128((void *)(planes->face + at), _mm512_cvtepi32_epi8(face));
    }
}
