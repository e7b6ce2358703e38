/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the surface of a volume: the points of its voxels with their visible faces and shades are compared with a
 * simple implementation that visits all voxels. A further test encodes and decodes directions.
 *
 * Covers: REQ-RENDER
 */
#include "points_volume.h"

/* The amount of bone at a position of a grid. */
typedef int amount(const ost_volume *v, int i, int j, int k);

/* Returns 63 if the voxel is active, and 0 otherwise. */
static int voxel(const ost_volume *v, int i, int j, int k)
{
    return active(v, i, j, k) ? 63 : 0;
}

/* Returns the amount of bone in the cell (i, j, k) of 2^3 voxels: 0 if no voxel is active, 63 if all voxels are
   active. */
static int cell(const ost_volume *v, int i, int j, int k)
{
    int sum = 0;
    for (int n = 0; n < 8; n++)
        sum += voxel(v, 2 * i + (n & 1), 2 * j + (n >> 1 & 1), 2 * k + (n >> 2));
    return (sum + 4) / 8;
}

/*
 * Returns the amount of bone around a position: the weighted sum of `at` over the neighbourhood, rounded after each
 * axis, as shading.h specifies.
 */
static int around(amount *at, const ost_volume *v, int i, int j, int k)
{
    static const int weight[9] = {1, 2, 3, 4, 5, 4, 3, 2, 1};
    int sum = 0;
    for (int a = -4; a <= 4; a++) {
        int slice = 0;
        for (int c = -4; c <= 4; c++)
            for (int b = -4; b <= 4; b++)
                slice += at(v, i + a, j + b, k + c) * weight[b + 4] * weight[c + 4];
        sum += (slice + 8) / 16 * weight[a + 4];
    }
    return sum;
}

/*
 * Interpolates the field of cells at a voxel, first along z, then y, then x, and rounds after
 * each axis. Returns a quarter of the interpolated value.
 */
static int wide(const ost_volume *v, int i, int j, int k)
{
    const int c[3] = {i >> 1, j >> 1, k >> 1}, far[3] = {i & 1 ? 1 : -1, j & 1 ? 1 : -1, k & 1 ? 1 : -1};
    int x[2];
    for (int a = 0; a < 2; a++) {
        int y[2];
        for (int b = 0; b < 2; b++) {
            const int at[2] = {c[0] + a * far[0], c[1] + b * far[1]};
            y[b] = (3 * ((around(cell, v, at[0], at[1], c[2]) + 2) / 4) +
                    (around(cell, v, at[0], at[1], c[2] + far[2]) + 2) / 4 + 2) /
                   4;
        }
        x[a] = (3 * y[0] + y[1] + 2) / 4;
    }
    return (3 * x[0] + x[1] + 2) / 4;
}

static uint32_t shade_of(const ost_volume *v, int i, int j, int k)
{
    const uint32_t open = faces(v, i, j, k);
    const float f[3] = {
        (float)(around(voxel, v, i - 1, j, k) - around(voxel, v, i + 1, j, k) +
                160 * ((int)(open >> 1 & 1) - (int)(open & 1))),
        (float)(around(voxel, v, i, j - 1, k) - around(voxel, v, i, j + 1, k) +
                160 * ((int)(open >> 3 & 1) - (int)(open >> 2 & 1))),
        (float)(around(voxel, v, i, j, k - 1) - around(voxel, v, i, j, k + 1) +
                160 * ((int)(open >> 5 & 1) - (int)(open >> 4 & 1)))};
    const float w[3] = {(float)(wide(v, i - 1, j, k) - wide(v, i + 1, j, k)),
                        (float)(wide(v, i, j - 1, k) - wide(v, i, j + 1, k)),
                        (float)(wide(v, i, j, k - 1) - wide(v, i, j, k + 1))};
    return shade_from(f, w, around(voxel, v, i, j, k), wide(v, i, j, k));
}

static void assert_surface(const ost_surface *s, const ost_volume *v)
{
    uint64_t count = 0, found = 0;
    for (int k = 0; k < v->geometry.dims.z; k++)
        for (int j = 0; j < v->geometry.dims.y; j++)
            for (int i = 0; i < v->geometry.dims.x; i++)
                count += active(v, i, j, k) && faces(v, i, j, k);
    for (int32_t b = 0; b < s->used; b++) {
        const ost_surface_block *block = s->slot[b];
        for (uint32_t p = 0; p < block->count; p++, found++) {
            const uint32_t w = block->points[p];
            const int i = 32 * block->at[0] + (int)(w & 31), j = 32 * block->at[1] + (int)(w >> 5 & 31),
                      k = 32 * block->at[2] + (int)(w >> 10 & 31);
            assert_true(active(v, i, j, k));
            assert_int_equal(w >> OST_FACES_SHIFT, faces(v, i, j, k));
            if (p % 199 == 0)
                assert_int_equal(block->shades[p], shade_of(v, i, j, k));
            assert_true(p == 0 || (block->points[p - 1] & 0x7fff) < (w & 0x7fff));
        }
    }
    assert_int_equal(found, count);
    assert_int_equal(s->points, count);
}

static void test_surface(void **state)
{
    (void)state;
    ost_error err = {0};
    test_rng rng = rng_seeded("surface");
    ost_volume v = pitted_ball(&rng, 70, 64, 41);
    ost_surface s;
    assert_ok(ost_surface_init(&s, &v.geometry, &err));
    assert_ok(ost_surface_set_volume(&s, &v, 120, &err));
    assert_ok(ost_surface_update(&s, &err));
    assert_surface(&s, &v);
    /* Complete planes of voxels are removed and restored, so that neighbouring blocks must be updated. */
    for (int round = 0; round < 12; round++) {
        const int axis = (int)rng_range(&rng, 0, 2), at = (int)rng_range(&rng, 0, 63);
        const int16_t value = rng_range(&rng, 0, 2) ? 0 : 500;
        for (int k = 0; k < 41; k++)
            for (int j = 0; j < 64; j++)
                for (int i = 0; i < 70; i++)
                    if ((axis == 0 ? i : axis == 1 ? j : k) == at)
                        v.voxels[i + 70 * (j + 64 * k)] = value;
        assert_ok(ost_surface_set_volume(&s, &v, 120, &err));
        assert_ok(ost_surface_update(&s, &err));
        assert_surface(&s, &v);
    }
    ost_surface_free(&s);
    ost_volume_free(&v);
}

/* A direction that is encoded and decoded may deviate from the original by at most 2.2 degrees. */
static void test_octahedral(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("octahedral");
    for (int i = 0; i < 20000; i++) {
        float v[3], w[3], length = 0, cosine = 0;
        for (int a = 0; a < 3; a++) {
            v[a] = (float)rng_range(&rng, -1000, 1000);
            length += v[a] * v[a];
        }
        if (length == 0)
            continue;
        ost_octahedral_vector(ost_octahedral_of(v), w);
        for (int a = 0; a < 3; a++)
            cosine += v[a] * w[a] / sqrtf(length);
        assert_true(cosine > 0.9993f);
    }
}

static void test_not_cubic(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_geometry g = grid(8, 8, 8);
    ost_surface s;
    g.spacing.z *= 2;
    assert_int_equal(ost_surface_init(&s, &g, &err), OST_ERR_RANGE);
    assert_non_null(strstr(err.text, "cubic"));
    ost_surface_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_surface),
        cmocka_unit_test(test_not_cubic),
        cmocka_unit_test(test_octahedral),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
