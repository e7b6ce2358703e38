/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the inner loops that make points, with every instruction set: the sums from which shades are computed, the
 * occupancy of rows, and the colours of shades under a light. The results for random inputs are compared with sums over
 * single voxels or with the results of the scalar functions.
 *
 * Covers: REQ-RENDER-POINTS
 */
#include "points_volume.h"

#include "render/points/rows.h"
#include "render/points/smooth.h"

/*
 * The inputs and outputs of the functions that compute shades. With every instruction set, the results for random
 * inputs of every size are compared with weighted sums.
 */
typedef struct words {
    uint8_t cells[3][28 * OST_CELLS], mean[OST_CELLS];
    uint16_t bone[OST_FIELD_BONE + 2][OST_FIELD_LINE], down[OST_FIELD_ROWS][OST_FIELD_LINE], line[OST_FIELD_LINE];
    ost_field_slice y[9], field[3], wide[3];
    uint64_t row[OST_FIELD_BONE];
    int16_t density[OST_FIELD_LINE];
} words;

static void fill(test_rng *rng, void *at, size_t count, int most)
{
    uint16_t *v = at;
    for (size_t i = 0; i < count; i++)
        v[i] = (uint16_t)rng_range(rng, 0, most);
}

static const int weight[9] = {1, 2, 3, 4, 5, 4, 3, 2, 1};

static void assert_sums(test_rng *rng, const ost_smooth_kernels *k, words *w)
{
    const int first = (int)rng_range(rng, 0, OST_FIELD_ROWS - 1),
              count = (int)rng_range(rng, 1, OST_FIELD_ROWS - first);
    fill(rng, w->bone, sizeof w->bone / 2, 2600);
    k->down((const uint16_t(*)[OST_FIELD_LINE])w->bone + first, w->down + first, count);
    for (int y = first; y < first + count; y++)
        for (int x = 0; x < OST_FIELD_LINE; x++) {
            int sum = 0;
            for (int j = 0; j < 9; j++)
                sum += weight[j] * w->bone[y + j][x];
            assert_int_equal(w->down[y][x], sum);
        }
    const ost_field_slice *y[9];
    const uint64_t rows = (uint64_t)rng_range(rng, 0, (INT64_C(1) << OST_FIELD_ROWS) - 1);
    for (int z = 0; z < 9; z++)
        y[z] = &w->y[(z + first) % 9];
    fill(rng, w->y, sizeof w->y / 2, 1575);
    memset(w->field[0], 0xff, sizeof w->field[0]);
    k->slice(y, rows, &w->field[0]);
    for (int j = 0; j < OST_FIELD_ROWS; j++)
        for (int x = 0; x < OST_FIELD_ROWS; x++) {
            int sum = 0;
            for (int i = 0; i < 9; i++) {
                int slice = 0;
                for (int z = 0; z < 9; z++)
                    slice += weight[z] * (*y[z])[j][x + 3 + i];
                sum += weight[i] * ((slice + 8) / 16);
            }
            assert_int_equal(w->field[0][j][x], rows >> j & 1 ? sum : 0xffff);
        }
}

static void assert_bone(test_rng *rng, const ost_smooth_kernels *k, words *w, bool wild)
{
    for (int i = 0; i < OST_FIELD_BONE; i++)
        w->row[i] = (uint64_t)rng_range(rng, 0, INT64_MAX) << 1;
    k->bits(w->row, OST_FIELD_BONE, w->bone);
    for (int i = 0; i < OST_FIELD_BONE; i++)
        for (int x = 0; x < OST_FIELD_LINE; x++)
            assert_int_equal(w->bone[i][x], w->row[i] >> (x + 8) & 1 ? 63 : 0);
    const uint64_t row = w->row[0], near = w->row[1] & row << 3;
    for (int i = 0; i < OST_FIELD_LINE; i++)
        w->density[i] = (int16_t)rng_range(rng, wild ? INT16_MIN : -40, wild ? INT16_MAX : 800);
    k->densities(row, near, w->density, w->line);
    for (int i = 0; i < OST_FIELD_LINE; i++) {
        const int v = w->density[i], some = v < 0 ? 15 : v / 16 < 48 ? 15 + v / 16 : 63;
        assert_int_equal(w->line[i], row >> (i + 8) & 1 ? (near >> (i + 8) & 1 ? 63 : some) : 0);
    }
}

/*
 * Compares the results of three functions with simple implementations: `cells` computes means of 2^3 words, `lines`
 * joins the rows of three blocks, and `finer` interpolates between two slices.
 */
static void assert_cells(test_rng *rng, const ost_smooth_kernels *k, words *w)
{
    const int count = (int)rng_range(rng, 1, 26), odd = (int)rng_range(rng, 0, 1);
    fill(rng, w->bone, sizeof w->bone / 2, 63);
    k->cells((const uint16_t(*)[OST_FIELD_LINE])w->bone, (const uint16_t(*)[OST_FIELD_LINE])w->bone + 7, w->mean);
    for (int x = 0; x < OST_CELLS; x++) {
        int sum = 0;
        for (int i = 0; i < 8; i++)
            sum += w->bone[(i & 1) + 7 * (i >> 1 & 1)][8 + 2 * x + (i >> 2)];
        assert_int_equal(w->mean[x], (sum + 4) / 8);
    }
    for (int i = 0; i < 3; i++)
        for (int c = 0; c < 28 * OST_CELLS; c++)
            w->cells[i][c] = (uint8_t)rng_range(rng, 0, 63);
    k->lines(w->cells[0], w->cells[1], w->cells[2], count, w->bone);
    for (int row = 0; row < count; row++)
        for (int x = -5; x < OST_CELLS + 5; x++)
            assert_int_equal(w->bone[row][x + 8], w->cells[(x + 16) / 16][OST_CELLS * row + (x & 15)]);
    const ost_field_slice *const both[2] = {&w->y[4], &w->y[2]};
    const uint64_t rows = (uint64_t)rng_range(rng, 1, (INT64_C(1) << OST_FIELD_ROWS) - 1);
    fill(rng, w->y, sizeof w->y / 2, 61525);
    memset(w->field[0], 0xff, sizeof w->field[0]);
    k->finer(both, odd, rows, &w->field[0]);
    for (int y = 0; y < OST_FIELD_ROWS; y++)
        for (int x = 0; x < OST_FIELD_ROWS; x++) {
            int value[2][2][2]; /* indices x, y, z; 0 is the nearer cell, 1 the farther cell */
            for (int i = 0; i < 8; i++)
                value[i & 1][i >> 1 & 1][i >> 2] =
                    ((*both[(i >> 2) ^ odd])[y / 2 + ((i >> 1 & 1) ^ (y & 1))][x / 2 + ((i & 1) ^ (x & 1))] + 2) / 4;
            int along_x[2];
            for (int i = 0; i < 2; i++) {
                const int along_z[2] = {(3 * value[i][0][0] + value[i][0][1] + 2) / 4,
                                        (3 * value[i][1][0] + value[i][1][1] + 2) / 4};
                along_x[i] = (3 * along_z[0] + along_z[1] + 2) / 4;
            }
            assert_int_equal(w->field[0][y][x], rows >> y & 1 ? (3 * along_x[0] + along_x[1] + 2) / 4 : 0xffff);
        }
}

/*
 * Compares shades for slopes of all sizes, including zero. The two slopes agree in some cases and disagree
 * in others. The number of points per call is random.
 */
static void assert_shades(test_rng *rng, const ost_smooth_kernels *k, words *w, int flat)
{
    enum { COUNT = 53 };
    uint32_t points[COUNT], shades[COUNT + OST_SHADING_SLACK];
    const ost_field_slice *const fine[3] = {&w->field[0], &w->field[1], &w->field[2]}, *const coarse[3] = {&w->wide[0],
                                                                                                           &w->wide[1],
                                                                                                           &w->wide[2]};
    const int count = (int)rng_range(rng, 1, COUNT);
    fill(rng, w->field, sizeof w->field / 2, flat ? flat : 61525);
    for (size_t i = 0; i < sizeof w->wide / 2; i++) {
        const uint16_t *from = &w->field[0][0][0];
        ((uint16_t *)w->wide)[i] = (uint16_t)(from[i] / 4 * (flat > 1 ? 0.5 : 0.7) +
                                              (double)rng_range(rng, 0, flat > 1 ? 40 : 4000));
    }
    for (int i = 0; i < count; i++)
        points[i] = (uint32_t)rng_range(rng, 0, (1 << 21) - 1);
    k->shades(points, count, fine, coarse, shades);
    for (int i = 0; i < count; i++) {
        const int x = 1 + (int)(points[i] & 31), y = 1 + (int)(points[i] >> 5 & 31),
                  f = (int)(points[i] >> OST_FACES_SHIFT);
        const float out[3] = {
            (float)(w->field[1][y][x - 1] - w->field[1][y][x + 1] + 160 * ((f >> 1 & 1) - (f & 1))),
            (float)(w->field[1][y - 1][x] - w->field[1][y + 1][x] + 160 * ((f >> 3 & 1) - (f >> 2 & 1))),
            (float)(w->field[0][y][x] - w->field[2][y][x] + 160 * ((f >> 5 & 1) - (f >> 4 & 1)))};
        const float broad[3] = {(float)(w->wide[1][y][x - 1] - w->wide[1][y][x + 1]),
                                (float)(w->wide[1][y - 1][x] - w->wide[1][y + 1][x]),
                                (float)(w->wide[0][y][x] - w->wide[2][y][x])};
        assert_int_equal(shades[i], shade_from(out, broad, w->field[1][y][x], w->wide[1][y][x]));
    }
}

static void test_smooth(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("smooth");
    words *w = calloc(1, sizeof *w);
    assert_non_null(w);
    for (int isa = 0; isa < OST_ISA_COUNT; isa++) {
        if (!ost_isa_available((ost_isa)isa))
            continue;
        const ost_smooth_kernels k = ost_smooth_kernels_of((ost_isa)isa);
        for (int round = 0; round < 60; round++) {
            assert_sums(&rng, &k, w);
            assert_bone(&rng, &k, w, round % 2);
            assert_cells(&rng, &k, w);
            assert_shades(&rng, &k, w, round % 3 ? 0 : round % 2 ? 300 : 1);
        }
    }
    free(w);
}

/* Returns the occupancy bit of voxel (x, y, z). The voxel may lie in the middle block or in one of its neighbours. */
static bool bit_at(uint32_t block[3][3][3][OST_BLOCK_ROWS], int x, int y, int z)
{
    return block[(z + 32) / 32][(y + 32) / 32][(x + 32) / 32][(y & 31) + 32 * (z & 31)] >> (x & 31) & 1;
}

static void test_rows(void **state)
{
    (void)state;
    static const int reaches[] = {1, 3, 11, 14},
                     step[6][3] = {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}};
    static uint32_t block[3][3][3][OST_BLOCK_ROWS], points[32 * OST_BLOCK_ROWS + OST_POINT_SLACK],
        behind[OST_BLOCK_ROWS];
    static ost_rows rows, other, first;
    static ost_faces faces;
    static ost_rim rim;
    test_rng rng = rng_seeded("rows");
    for (int round = 0; round < 4; round++) {
        for (int i = 0; i < 27; i++)
            /* the block has many holes, is nearly solid, or is nearly empty */
            for (int row = 0; row < OST_BLOCK_ROWS; row++) {
                uint32_t w = (uint32_t)rng_range(&rng, 0, UINT32_MAX);
                for (int more = 0; more < 4; more++)
                    w = round == 1  ? w | (uint32_t)rng_range(&rng, 0, UINT32_MAX)
                        : round > 1 ? w & (uint32_t)rng_range(&rng, 0, UINT32_MAX)
                                    : w;
                block[i / 9][i / 3 % 3][i % 3][row] = round == 3 && rng_range(&rng, 0, 60) ? 0 : w;
            }
        rim.left = block[1][1][0];
        rim.right = block[1][1][2];
        for (int z = -1; z <= 32; z++)
            for (int y = -1; y <= 32; y++)
                rim.row[z + 1][y + 1] = block[(z + 32) / 32][(y + 32) / 32][1][(y & 31) + 32 * (z & 31)];
        for (int isa = 0; isa < OST_ISA_COUNT; isa++) {
            if (!ost_isa_available((ost_isa)isa))
                continue;
            const ost_row_kernels k = ost_row_kernels_of((ost_isa)isa);
            k.faces(&rim, &faces);
            k.behind(&rim, &faces, behind);
            k.points(&faces, points);
            uint32_t count = 0;
            for (int row = 0; row < OST_BLOCK_ROWS; row++) {
                assert_int_equal(faces.begin[row], count);
                for (int x = 0; x < 32; x++) {
                    uint32_t mask = 0;
                    for (int f = 0; f < 6 && bit_at(block, x, row % 32, row / 32); f++)
                        mask |= (uint32_t)!bit_at(block, x + step[f][0], row % 32 + step[f][1], row / 32 + step[f][2])
                                << f;
                    if (mask)
                        assert_int_equal(points[count++], (uint32_t)x | (uint32_t)row << 5 | mask << OST_FACES_SHIFT);
                    assert_int_equal(faces.any[row] >> x & 1, mask != 0);
                }
                assert_int_equal(behind[row], 0);
            }
            assert_int_equal(faces.begin[OST_BLOCK_ROWS], count);
            /* If all faces are marked as bordering on air, `behind` must contain exactly the voxels with an active
               neighbour. */
            memset(faces.face, 0xff, sizeof faces.face);
            k.behind(&rim, &faces, behind);
            for (int cell = 0; cell < 32 * OST_BLOCK_ROWS; cell += 5) {
                const int x = cell % 32, y = cell / 32 % 32, z = cell / 1024;
                bool any = false;
                for (int f = 0; f < 6; f++)
                    any |= bit_at(block, x + step[f][0], y + step[f][1], z + step[f][2]);
                assert_int_equal(behind[y + 32 * z] >> x & 1, any);
            }
            for (int z = -8; z < 40; z++)
                for (int y = -8; y < 40; y += 8) {
                    const uint32_t(*const n)[OST_BLOCK_ROWS] = (const uint32_t(*)[OST_BLOCK_ROWS])
                        block[(z + 32) / 32][(y + 32) / 32];
                    const int row = (y & 31) + 32 * (z & 31);
                    k.join(n[0] + row, n[1] + row, n[2] + row, rows.row[z + OST_SHADING_REACH] + y + OST_SHADING_REACH,
                           8);
                }
            for (int i = 0; i < 2000; i++) {
                const int x = (int)rng_range(&rng, -16, 47), y = (int)rng_range(&rng, -8, 39),
                          z = (int)rng_range(&rng, -8, 39);
                assert_int_equal(rows.row[z + OST_SHADING_REACH][y + OST_SHADING_REACH] >> (x + 16) & 1,
                                 bit_at(block, x, y, z));
            }
            const int reach = reaches[(round + isa) % 4];
            memset(&rows, 0, sizeof rows);
            for (int i = 0; i < 30 << 2 * round; i++)
                rows.row[rng_range(&rng, 0, OST_SEEN - 1)][rng_range(&rng, 0, OST_SEEN - 1)] |= UINT64_C(1)
                                                                                                << rng_range(&rng, 0,
                                                                                                             63);
            first = rows;
            k.spread(&rows, &other, reach);
            for (int z = reach; z < OST_SEEN - reach; z++)
                for (int y = reach; y < OST_SEEN - reach; y++) {
                    uint64_t near = 0;
                    for (int i = -reach; i <= reach; i++)
                        for (int j = -reach; j <= reach; j++)
                            near |= first.row[z + i][y + j];
                    uint64_t wide = near;
                    for (int x = 1; x <= reach; x++)
                        wide |= near << x | near >> x;
                    assert_true(rows.row[z][y] << reach >> 2 * reach == wide << reach >> 2 * reach);
                }
        }
    }
}

/*
 * For every instruction set, compares the light and the colours of random shades with the results of the scalar
 * functions.
 */
static void test_tints(void **state)
{
    (void)state;
    enum { COUNT = 16 * 64 };
    ost_error err = {0};
    test_rng rng = rng_seeded("tints");
    static ost_light light, other;
    static ost_directions directions;
    uint32_t palette[OST_PAINTS], shade_of[COUNT], one[COUNT], many[COUNT];
    ost_camera c = {.focal_milli = 100000, .width = 64, .height = 64};
    const ost_geometry g = grid(8, 8, 8);
    ost_eye eye;
    ost_directions_make(&directions);
    ost_light_shade_of *const plain = directions.shade;
    for (int i = 0; i < OST_PAINTS; i++)
        palette[i] = (uint32_t)rng_range(&rng, 0, 0xffffff);
    for (int round = 0; round < 40; round++) {
        const double from[3] = {(double)rng_range(&rng, 10, 90), (double)rng_range(&rng, -90, 90),
                                (double)rng_range(&rng, -90, 90)};
        assert_ok(ost_camera_look_at(from, (double[3]){0, 0, 0}, (double[3]){0, 0, 1}, &c, &err));
        eye = ost_eye_make(&c, &g);
        directions.shade = plain;
        ost_light_make(&light, &directions, &eye, round % 5 ? OST_STYLE_SMOOTH : OST_STYLE_FACES,
                       round % 2 ? OST_PAINT_STEEL : OST_PAINT_BONE, round % 3 ? palette : NULL);
        for (int i = 0; i < COUNT; i++)
            shade_of[i] = (uint32_t)rng_range(&rng, 0, round % 4 ? INT32_MAX : (1 << OST_PAINT_SHIFT) - 1);
        ost_light_tint(&light, shade_of, COUNT, one);
        for (int isa = 0; isa < OST_ISA_COUNT; isa++)
            if (ost_isa_available((ost_isa)isa)) {
                directions.shade = ost_light_shade_for((ost_isa)isa);
                other.made = false;
                ost_light_make(&other, &directions, &eye, OST_STYLE_SMOOTH,
                               round % 2 ? OST_PAINT_STEEL : OST_PAINT_BONE, NULL);
                assert_memory_equal(light.shade, other.shade, sizeof light.shade);
                ost_light_tint_for((ost_isa)isa)(&light, shade_of, COUNT, many);
                assert_memory_equal(one, many, sizeof one);
            }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_smooth),
        cmocka_unit_test(test_rows),
        cmocka_unit_test(test_tints),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
