/* SPDX-License-Identifier: Apache-2.0 */
/* As splat_avx512.c, eight lanes wide.  Without a compression of lanes, facing is the scalar one. */
#include "core/conditions.h"
#include "render/points/splat.h"

#include <immintrin.h>

enum { EIGHT = 8 };

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

static inline lanes spread(const float axis[3], lanes t, const float forward[3])
{
    lanes part[3];
    for (int a = 0; a < 3; a++)
        part[a] = absolute(_mm256_sub_ps(all(axis[a]), _mm256_mul_ps(t, all(forward[a]))));
    return _mm256_mul_ps(all(OST_HALF), _mm256_add_ps(_mm256_add_ps(part[0], part[1]), part[2]));
}

static inline __m256i within(lanes v, int lo, int hi)
{
    return _mm256_cvttps_epi32(_mm256_min_ps(_mm256_max_ps(v, all((float)lo)), all((float)hi)));
}

/* The first n lanes, n >= 1. */
static inline __m256i below(int n)
{
    return _mm256_cmpgt_epi32(_mm256_set1_epi32(n), _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
}

static inline void fill(const ost_splat_eye *s, const float o[3], float distance, uint32_t index, int x0, int x1, int y0, int y1,
                        const ost_planes *planes)
{
    float n[3][3];
    for (int i = 0; i < 3; i++) {
        const float *b = s->axis[i];
        n[i][0] = o[1] * b[2] - o[2] * b[1];
        n[i][1] = o[2] * b[0] - o[0] * b[2];
        n[i][2] = o[0] * b[1] - o[1] * b[0];
    }
    const lanes wide = all(OST_HALF_WIDE), far = all(distance), step = _mm256_setr_ps(0, 1, 2, 3, 4, 5, 6, 7);
    for (int x = x0; x <= x1; x += EIGHT) {
        const lanes live = _mm256_castsi256_ps(below(x1 - x + 1));
        const lanes u = _mm256_sub_ps(_mm256_add_ps(_mm256_add_ps(all((float)x), step), all(0.5f)), all(s->eye.half_w));
        lanes un[3], ud[3];
        for (int a = 0; a < 3; a++) {
            un[a] = _mm256_mul_ps(u, all(n[1][a]));
            ud[a] = _mm256_mul_ps(u, all(s->axis[1][a]));
        }
        for (int y = y0; y <= y1; y++) {
            const float v = ((float)y + 0.5f) - s->eye.half_h;
            float *row = planes->distance + (size_t)y * (size_t)planes->stride + (size_t)x;
            const lanes was = _mm256_maskload_ps(row, _mm256_castps_si256(live));
            const lanes nearer = _mm256_and_ps(live, _mm256_cmp_ps(far, was, _CMP_LT_OQ));
            if (_mm256_testz_ps(nearer, nearer))
                continue;
            lanes here_n[3], m[3];
            for (int a = 0; a < 3; a++) {
                here_n[a] = absolute(_mm256_add_ps(all(n[0][a] - v * n[2][a]), un[a]));
                m[a] = absolute(_mm256_add_ps(all(s->axis[0][a] - v * s->axis[2][a]), ud[a]));
            }
            const lanes hit0 = _mm256_cmp_ps(here_n[0], _mm256_mul_ps(wide, _mm256_add_ps(m[1], m[2])), _CMP_LE_OQ);
            const lanes hit1 = _mm256_cmp_ps(here_n[1], _mm256_mul_ps(wide, _mm256_add_ps(m[2], m[0])), _CMP_LE_OQ);
            const lanes hit2 = _mm256_cmp_ps(here_n[2], _mm256_mul_ps(wide, _mm256_add_ps(m[0], m[1])), _CMP_LE_OQ);
            const __m256i hit = _mm256_castps_si256(_mm256_and_ps(_mm256_and_ps(nearer, hit0), _mm256_and_ps(hit1, hit2)));
            _mm256_maskstore_ps(row, hit, far);
            _mm256_maskstore_epi32((int *)planes->index + (row - planes->distance), hit, _mm256_set1_epi32((int)index));
        }
    }
}

typedef struct eight {
    _Alignas(32) float o[3][EIGHT];
    _Alignas(32) float distance[EIGHT];
    _Alignas(32) int32_t x0[EIGHT], x1[EIGHT], y0[EIGHT], y1[EIGHT];
} eight;

static inline unsigned bits(lanes mask)
{
    return (unsigned)_mm256_movemask_ps(mask);
}

static inline unsigned greater(__m256i a, __m256i b)
{
    return bits(_mm256_castsi256_ps(_mm256_cmpgt_epi32(a, b)));
}

/* Which of eight voxels may be seen, and where. */
static inline unsigned rectangles(const ost_splat_eye *s, lanes3 o, unsigned live, int y0, int y1, eight *out)
{
    const ost_eye *e = &s->eye;
    const lanes x = dot(e->right, o), y = dot(e->up, o), z = dot(e->forward, o);
    const lanes nearest = _mm256_sub_ps(z, all(s->reach[2]));
    live &= bits(_mm256_cmp_ps(nearest, all(e->near), _CMP_GT_OQ));
    const lanes inverse = _mm256_div_ps(all(1.0f), z), tx = _mm256_mul_ps(x, inverse), ty = _mm256_mul_ps(y, inverse);
    const lanes k = _mm256_div_ps(all(e->focal), nearest);
    const lanes hx = _mm256_add_ps(_mm256_mul_ps(spread(e->right, tx, e->forward), k), all(0.01f));
    const lanes hy = _mm256_add_ps(_mm256_mul_ps(spread(e->up, ty, e->forward), k), all(0.01f));
    const lanes px = _mm256_add_ps(_mm256_mul_ps(tx, all(e->focal)), all(e->half_w - 0.5f));
    const lanes py = _mm256_sub_ps(all(e->half_h - 0.5f), _mm256_mul_ps(ty, all(e->focal)));
    const __m256i left = within(_mm256_ceil_ps(_mm256_sub_ps(px, hx)), 0, e->width);
    const __m256i right = within(_mm256_floor_ps(_mm256_add_ps(px, hx)), -1, e->width - 1);
    const __m256i top = within(_mm256_ceil_ps(_mm256_sub_ps(py, hy)), y0, y1);
    const __m256i bottom = within(_mm256_floor_ps(_mm256_add_ps(py, hy)), y0 - 1, y1 - 1);
    _mm256_store_si256((void *)out->x0, left);
    _mm256_store_si256((void *)out->x1, right);
    _mm256_store_si256((void *)out->y0, top);
    _mm256_store_si256((void *)out->y1, bottom);
    return live & ~greater(left, right) & ~greater(top, bottom);
}

void ost_splat_avx2(const ost_splat_eye *eye, const ost_visible *visible, uint32_t first, uint32_t count, const ost_planes *planes, int y0,
                    int y1)
{
    const uint32_t *points = visible->id + first;
    if (count == 0)
        return;
    const float *base = visible->bases + 4 * (size_t)(points[0] >> OST_LOCAL_BITS);
    for (uint32_t i = 0; i < count; i += EIGHT) {
        const int n = count - i < EIGHT ? (int)(count - i) : EIGHT;
        const __m256i p = _mm256_maskload_epi32((const int *)points + i, below(n));
        eight r;
        lanes3 o;
        for (int a = 0; a < 3; a++) {
            const __m256i at = _mm256_and_si256(_mm256_srl_epi32(p, _mm_cvtsi32_si128(5 * a)), _mm256_set1_epi32(31));
            o.v[a] = _mm256_add_ps(all(base[a]), _mm256_cvtepi32_ps(at));
            _mm256_store_ps(r.o[a], o.v[a]);
        }
        const lanes xy = _mm256_add_ps(_mm256_mul_ps(o.v[0], o.v[0]), _mm256_mul_ps(o.v[1], o.v[1]));
        _mm256_store_ps(r.distance, _mm256_add_ps(xy, _mm256_mul_ps(o.v[2], o.v[2])));
        for (unsigned left = rectangles(eye, o, (1u << n) - 1, y0, y1, &r); left; left &= left - 1) {
            const int k = __builtin_ctz(left);
            const float at[3] = {r.o[0][k], r.o[1][k], r.o[2][k]};
            fill(eye, at, r.distance[k], first + i + (uint32_t)k, r.x0[k], r.x1[k], r.y0[k], r.y1[k], planes);
        }
    }
}

static inline __m256i lit(__m256i colour, __m256i light)
{
    const __m256i rb = _mm256_set1_epi32(0xff00ff), g = _mm256_set1_epi32(0xff00);
    const __m256i a = _mm256_and_si256(_mm256_srli_epi32(_mm256_mullo_epi32(_mm256_and_si256(colour, rb), light), 8), rb);
    const __m256i b = _mm256_and_si256(_mm256_srli_epi32(_mm256_mullo_epi32(_mm256_and_si256(colour, g), light), 8), g);
    return _mm256_or_si256(a, b);
}

/* The face by which the ray of each pixel enters, and where. */
static inline __m256i enter(const ost_splat_eye *eye, const ost_visible *visible, __m256i id, __m256i any, lanes u, float v, lanes *depth)
{
    const __m256i slot = _mm256_slli_epi32(_mm256_srli_epi32(id, OST_LOCAL_BITS), 2), five = _mm256_set1_epi32(31);
    const lanes zero = _mm256_setzero_ps();
    __m256i face = _mm256_setzero_si256();
    lanes t = zero;
    for (int a = 0; a < 3; a++) {
        const __m256i local = _mm256_and_si256(_mm256_srl_epi32(id, _mm_cvtsi32_si128(5 * a)), five);
        const lanes base = _mm256_mask_i32gather_ps(zero, visible->bases + a, slot, _mm256_castsi256_ps(any), 4);
        const lanes o = _mm256_add_ps(base, _mm256_cvtepi32_ps(local));
        lanes d = _mm256_add_ps(all(eye->axis[0][a] - v * eye->axis[2][a]), _mm256_mul_ps(u, all(eye->axis[1][a])));
        d = _mm256_blendv_ps(d, all(1e-20f), _mm256_cmp_ps(d, zero, _CMP_EQ_OQ));
        const lanes inverse = _mm256_div_ps(all(1.0f), d);
        const lanes in = _mm256_sub_ps(_mm256_mul_ps(o, inverse), _mm256_mul_ps(all(OST_HALF), absolute(inverse)));
        const lanes later = a == 0 ? _mm256_castsi256_ps(_mm256_set1_epi32(-1)) : _mm256_cmp_ps(in, t, _CMP_GT_OQ);
        const __m256i back = _mm256_castps_si256(_mm256_cmp_ps(d, zero, _CMP_LT_OQ));
        t = _mm256_blendv_ps(t, in, later);
        face = _mm256_blendv_epi8(face, _mm256_sub_epi32(_mm256_set1_epi32(2 * a), back), _mm256_castps_si256(later));
    }
    *depth = _mm256_mul_ps(t, all(eye->eye.focal));
    return face;
}

void ost_resolve_avx2(const ost_splat_eye *eye, const ost_visible *visible, const ost_planes *planes, int y)
{
    const float v = ((float)y + 0.5f) - eye->eye.half_h;
    const lanes step = _mm256_setr_ps(0, 1, 2, 3, 4, 5, 6, 7);
    const __m256i lights = _mm256_loadu_si256((const void *)visible->light), zero = _mm256_setzero_si256();
    for (int x = 0; x < planes->stride; x += EIGHT) {
        const size_t at = (size_t)y * (size_t)planes->stride + (size_t)x;
        const __m256i index = _mm256_load_si256((const void *)(planes->index + at));
        const __m256i any = _mm256_xor_si256(_mm256_cmpeq_epi32(index, _mm256_set1_epi32(-1)), _mm256_set1_epi32(-1));
        __m256i face = _mm256_set1_epi32(OST_NO_FACE), colour = _mm256_set1_epi32((int)visible->background);
        if (!_mm256_testz_si256(any, any)) {
            const lanes u = _mm256_sub_ps(_mm256_add_ps(_mm256_add_ps(all((float)x), step), all(0.5f)), all(eye->eye.half_w));
            const __m256i id = _mm256_mask_i32gather_epi32(zero, (const int *)visible->id, index, any, 4);
            const __m256i tint = _mm256_mask_i32gather_epi32(zero, (const int *)visible->tint, index, any, 4);
            lanes depth;
            const __m256i entered = enter(eye, visible, id, any, u, v, &depth);
            face = _mm256_blendv_epi8(face, entered, any);
            colour = _mm256_blendv_epi8(colour, lit(tint, _mm256_permutevar8x32_epi32(lights, entered)), any);
            _mm256_maskstore_ps(planes->depth + at, any, depth);
        }
        _mm256_store_si256((void *)(planes->colour + at), colour);
        const __m128i half = _mm_packus_epi32(_mm256_castsi256_si128(face), _mm256_extracti128_si256(face, 1));
        _mm_storel_epi64((void *)(planes->face + at), _mm_packus_epi16(half, half));
    }
}
