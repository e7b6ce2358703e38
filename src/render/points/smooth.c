/* SPDX-License-Identifier: Apache-2.0 */
#include "config.h"

#include "core/conditions.h"
#include "render/points/cell_loops.h"
#include "render/points/slopes.h"

enum { LINE = OST_FIELD_LINE };

void ost_field_bits_scalar(const uint64_t *rows, int count, uint16_t (*out)[LINE])
{
    for (int row = 0; row < count; row++)
        for (int i = 0; i < LINE; i++)
            out[row][i] = (uint16_t)(OST_FIELD_ALL * (rows[row] >> (i + OST_LINE_SHIFT) & 1));
}

void ost_field_densities_scalar(uint64_t row, uint64_t near, const int16_t density[LINE], uint16_t out[LINE])
{
    for (int i = 0; i < LINE; i++) {
        const int v = density[i], some = OST_FIELD_LEAST + (v < 0 ? 0 : v / 16), bit = i + OST_LINE_SHIFT;
        const int bone = near >> bit & 1 || v >= OST_FIELD_DENSE ? OST_FIELD_ALL : some;
        out[i] = (uint16_t)(row >> bit & 1 ? bone : 0);
    }
}

static inline unsigned nine(const uint16_t *a, ptrdiff_t step)
{
    const unsigned outer = (unsigned)a[0] + a[8 * step] + 2u * ((unsigned)a[step] + a[7 * step]);
    const unsigned inner = 3u * ((unsigned)a[2 * step] + a[6 * step]) + 4u * ((unsigned)a[3 * step] + a[5 * step]) +
                           5u * a[4 * step];
    return outer + inner;
}

void ost_field_down_scalar(const uint16_t (*in)[LINE], uint16_t (*out)[LINE], int count)
{
    for (int row = 0; row < count; row++)
        for (int i = 0; i < LINE; i++)
            out[row][i] = (uint16_t)nine(&in[row][i], LINE);
}

void ost_field_slice_scalar(const ost_field_slice *const y[9], uint64_t rows, ost_field_slice *out)
{
    for (; rows; rows &= rows - 1) {
        const int row = __builtin_ctzll(rows);
        uint16_t z[LINE];
        for (int i = 0; i < LINE; i++) {
            uint16_t a[9];
            for (int k = 0; k < 9; k++)
                a[k] = (*y[k])[row][i];
            z[i] = (uint16_t)((nine(a, 1) + 8) >> 4);
        }
        for (int i = 0; i < OST_FIELD_ROWS; i++)
            (*out)[row][i] = (uint16_t)nine(&z[i + OST_LINE_SKIP], 1);
    }
}

OST_CELLS_DEFINE(scalar)

/* Returns (3 near + far) / 4, rounded to nearest. Both arguments must be less than 2^14. */
static inline uint16_t between(uint16_t near, uint16_t far)
{
    return (uint16_t)((3 * near + far + 2) >> 2);
}

/*
 * On each axis, position 2m of a field lies at 1/4 of the way from cell m to cell m + 1, and position 2m + 1 lies at
 * 3/4. Positions and cells are counted from -1, like all rows of a field.
 */
void ost_field_finer_scalar(const ost_field_slice *const cells[2], bool odd, uint64_t rows, ost_field_slice *out)
{
    enum { LANES = 32, PAIRS = OST_FIELD_ROWS / 2 };
    const ost_field_slice *restrict near = cells[odd], *restrict far = cells[!odd];
    uint16_t z[OST_FIELD_ROWS / 2 + 1][LANES], y[LANES];
    for (int row = __builtin_ctzll(rows) / 2, last = (63 - __builtin_clzll(rows)) / 2 + 1; row <= last; row++)
        for (int i = 0; i < LANES; i++)
            z[row][i] = between((uint16_t)(((*near)[row][i] + 2) >> 2), (uint16_t)(((*far)[row][i] + 2) >> 2));
    for (; rows; rows &= rows - 1) {
        const int row = __builtin_ctzll(rows);
        const uint16_t *restrict a = z[row / 2 + row % 2], *restrict b = z[row / 2 + !(row % 2)];
        for (int i = 0; i < LANES; i++)
            y[i] = between(a[i], b[i]);
        for (int i = 0; i < PAIRS; i++) {
            (*out)[row][2 * i] = between(y[i], y[i + 1]);
            (*out)[row][2 * i + 1] = between(y[i + 1], y[i]);
        }
    }
}

static inline float size_of(const float v[3])
{
    return sqrtf((v[0] * v[0] + v[1] * v[1]) + v[2] * v[2]);
}

/* Returns the weight of the wide slope in the normal, from 0 to 1. */
static inline float share_of(const float fine[3], const float wide[3], float fine_size, float wide_size)
{
    const float both = fine_size * wide_size, dot = (fine[0] * wide[0] + fine[1] * wide[1]) + fine[2] * wide[2];
    const float t = (dot / (both > 1 ? both : 1) - OST_AGREE_LEAST) * OST_AGREE_STEEP;
    return wide_size < OST_WIDE_LEAST || !(t > 0) ? 0 : t < 1 ? t : 1;
}

void ost_field_shades_scalar(const uint32_t *points, int count, const ost_field_slice *const fine[3],
                             const ost_field_slice *const wide[3], uint32_t *shades)
{
    for (int i = 0; i < count; i++) {
        ost_slopes s;
        float f[3], w[3], out[3];
        ost_slope_at(points[i], fine, wide, &s, 0);
        for (int a = 0; a < 3; a++) {
            f[a] = (float)ost_slope_with_faces(s.fine[a][0], s.faces[0], a);
            w[a] = (float)s.wide[a][0];
        }
        const float fine_size = size_of(f), wide_size = size_of(w), t = share_of(f, w, fine_size, wide_size);
        const float of_fine = t > 0 ? (1 - t) * wide_size : 1, of_wide = t * fine_size;
        for (int a = 0; a < 3; a++)
            out[a] = f[a] * of_fine + w[a] * of_wide;
        const int open = ost_openness(s.value[0][0]),
                  both = ost_openness(2 * OST_WIDE_PART * s.value[1][0] - s.value[0][0] + OST_WIDE_PLANE);
        const float mixed = (float)open + (float)(both - open) * t;
        shades[i] = ost_octahedral_of(out) | (uint32_t)(int)(mixed + 0.5f) << OST_OPEN_SHIFT;
    }
}

#define OF(SET, FINER)                                                                                                 \
    {                                                                                                                  \
        ost_field_bits_##SET, ost_field_densities_##SET, ost_field_down_##SET, ost_field_slice_##SET,                  \
            ost_field_cells_##SET, ost_field_lines_##SET, FINER, ost_field_shades_##SET                                \
    }

ost_smooth_kernels ost_smooth_kernels_of(ost_isa isa)
{
    ost_smooth_kernels k = OF(scalar, ost_field_finer_scalar);
#if HAVE_AVX2_BUILD
    if (ost_isa_includes(isa, OST_ISA_AVX2))
        k = (ost_smooth_kernels)OF(avx2, ost_field_finer_avx2);
#endif
#if HAVE_AVX512_BUILD
    if (ost_isa_includes(isa, OST_ISA_AVX512))
        k = (ost_smooth_kernels)OF(avx512, k.finer);
#endif
    (void)isa;
    return k;
}
