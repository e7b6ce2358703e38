/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests that generated cases are the same on every machine and with every compiler, so that two sites compare the
 * same inputs. A case is generated from its name and the campaign's seed. The digests in this file were computed
 * with gcc 12 on x86-64. Other compilers must compute the same digests. For example, two random draws in one list
 * of arguments would have an order that depends on the compiler.
 *
 * The bone of the `operation` family is a phantom that is generated in floating point. This test does not cover it.
 * Covers: REQ-EVIDENCE
 */
#include "harness.h"

#include "validation/perform.h"
#include "validation/scene_parts.h"

/* Computes the SHA-256 of the digests of a family's cases, in hexadecimal. */
static void family_digest(plan_tier tier, const char *only, int most, char out[2 * sizeof(ost_digest) + 1])
{
    ost_error err = {0};
    ost_hasher *h;
    ost_digest all;
    plan p;
    assert_ok(plan_make(tier, 1, 1, 1, only, NULL, &p, &err));
    assert_ok(ost_hasher_open(&h, &err));
    for (int i = 0; i < p.count && i < most; i++) {
        scene s;
        ost_digest one;
        assert_ok(scene_make(&p.cases[i], &s, &err));
        assert_ok(scene_digest(&s, &one, &err));
        assert_ok(ost_hasher_add(h, one.bytes, sizeof one.bytes, &err));
        scene_free(&s);
    }
    assert_ok(ost_hasher_close(h, &all, &err));
    for (size_t i = 0; i < sizeof all.bytes; i++)
        snprintf(out + 2 * i, 3, "%02x", all.bytes[i]);
    plan_free(&p);
}

static void digests_of_families(void **state)
{
    static const struct {
        plan_tier tier;
        const char *only;
        int most;
        const char *digest;
    } rows[] = {
        {PLAN_SMOKE, "import", 7, "c9d4686acb5fe3b5bc6a0f3a3f20916c4367f84cbc48e1f6981b157eed100c81"},
        /*
         * The following digest was computed by a separate program, which was written from draw.h, the description of
         * the case and the order of fields in scene_digest.
         */
        {PLAN_SMOKE, "import/7", 99, "dd2f0af38ef77641aa8732c2118c60c104c4f61c4ad7f1bc6aca6b3853c0427c"},
        {PLAN_SMOKE, "mesh", 99, "e0382851553eae28b444416d254a92e9df2c634bd5451522f75894491442f8f9"},
        {PLAN_SMOKE, "poses", 4, "ad7a3bd54a76aad6b31ce578bafb8733b38caf68e4538eecdc58ee251fc1a69a"},
        /* The digest of poses/4 was computed in the same way as that of import/7. */
        {PLAN_SMOKE, "poses/4", 99, "140b34ba992cc48acf44abc5c197276580ba6f0736613133e7aae15a3f9ea323"},
        {PLAN_SMOKE, "sweep", 99, "f5c208fdd136cb588c8cf49a5fd0726ca00d9e9ca261eb4a1d184e8f44bff8e7"},
        {PLAN_SMOKE, "session", 99, "869b5fd0f6dc9f6579817553a869f01e8173bfade50f9b44db01916d0dea6d9e"},
        {PLAN_SMOKE, "static/3", 99, "8db0463087c7a16543e82b2fe420c800a42af2c92c03e79611191d9c4b555b65"},
        {PLAN_SMOKE, "reach", 99, "c9ce963b25b7414c4f0b8370e261312556d29288fd7a2ebdda04416b4569c09d"},
        {PLAN_STANDARD, "reach", 99, "4d3e2b2f4421dce9e3d784b083fe56fec3f0080eb8ad5a16bd999ebd7ccd72cc"},
        {PLAN_STANDARD, "mesh", 24, "14d92552144aeb693c438efbb0e733dc9458b96dd9b8e5d4ef83b5ac63d8c252"},
        {PLAN_STANDARD, "poses/1", 2, "9857471d586d01ccf7ebe9a80e9decf423d24b366f19264074f6b75cdd0975dd"},
    };
    int wrong = 0;
    (void)state;
    for (size_t r = 0; r < sizeof rows / sizeof rows[0]; r++) {
        char got[2 * sizeof(ost_digest) + 1];
        family_digest(rows[r].tier, rows[r].only, rows[r].most, got);
        if (strcmp(got, rows[r].digest) != 0) {
            print_error("tier %s, %s: digest %s, expected %s\n", plan_tier_name(rows[r].tier), rows[r].only, got,
                        rows[r].digest);
            wrong++;
        }
    }
    assert_int_equal(wrong, 0);
}

/* Tests the scenes that the sensitivity proof uses. */
static void digests_of_small_scenes(void **state)
{
    static const char *const digests[] = {"b989fb0af4513d73", "2523469b8e032ca3", "e6a459417cda61eb",
                                          "1bfe2db7b8e63aef", "663d0bbe1934039a", "4cf546754dbeb75f"};
    int wrong = 0;
    (void)state;
    for (int number = 0; number < (int)(sizeof digests / sizeof digests[0]); number++) {
        const plan_case c = {.family = PLAN_SMALL,
                             .number = number,
                             .seed = 1,
                             .id = {'s', 'm', 'a', 'l', 'l', '/', (char)('0' + number)}};
        ost_error err = {0};
        char got[17];
        ost_digest one;
        scene s;
        assert_ok(scene_make(&c, &s, &err));
        assert_ok(scene_digest(&s, &one, &err));
        for (size_t i = 0; i < 8; i++)
            snprintf(got + 2 * i, 3, "%02x", one.bytes[i]);
        if (strcmp(got, digests[number]) != 0) {
            print_error("%s: digest %s, expected %s\n", c.id, got, digests[number]);
            wrong++;
        }
        scene_free(&s);
    }
    assert_int_equal(wrong, 0);
}

/*
 * Bones of the `small` family must be small enough to be downloaded completely after each tick, even if their
 * voxels are much smaller than the distance between the layers of the CT. A difference is then located in the
 * tick in which it occurs.
 */
static void small_bones_are_downloaded_completely(void **state)
{
    (void)state;
    for (int number = 170; number < 190; number++) { /* case 182 has voxels of 32 um in layers of 1 mm */
        plan_case c = {.family = PLAN_SMALL, .number = number, .seed = 1};
        ost_error err = {0};
        ost_map map;
        scene s;
        snprintf(c.id, sizeof c.id, "small/%d", number);
        assert_ok(scene_make(&c, &s, &err));
        const ost_geometry *g = &s.rect;
        const ost_pm n = s.cubic, x = (g->dims.x * g->spacing.x + n - 1) / n,
                     y = (g->dims.y * g->spacing.y + n - 1) / n, z = (g->dims.z * g->spacing.z + n - 1) / n;
        const ost_geometry bone = {{(int32_t)x, (int32_t)y, (int32_t)z}, {n, n, n}, g->origin};
        assert_true(x * y * z <= PERFORM_ALL_VOXELS);
        for (size_t i = 0; i < s.path.count; i++) /* no tick may be refused because of the size of the tool's voxels */
            assert_ok(
                ost_map_make(&s.path.ticks[i].pose, &bone, &s.tools[s.path.ticks[i].tool].cutting.grid, &map, &err));
        scene_free(&s);
    }
}

/*
 * Counts the voxels along one axis whose source voxel is wrong if it is computed in floating point, in single or double
 * precision. The computation multiplies the index by the ratio of the spacings and truncates the product.
 */
static int decided_by_ratio(const scene *s, ost_pm rect, int32_t n, bool single)
{
    const double ratio = single ? (double)((float)s->cubic / (float)rect) : (double)s->cubic / (double)rect;
    const int64_t count = (n * rect + s->cubic - 1) / s->cubic;
    const bool nearest = s->resample == OST_RESAMPLE_NEAREST;
    int other = 0;
    for (int64_t i = 0; i < count; i++) {
        const int64_t right = nearest ? (2 * i + 1) * s->cubic / (2 * rect) : i * s->cubic / rect;
        const double at = ((double)i + (nearest ? 0.5 : 0)) * ratio;
        other += (int64_t)(single ? (double)(float)at : at) != right;
    }
    return other;
}

/*
 * For each of the two rules that truncate, the smoke tier must have a case in which double precision selects a wrong
 * source voxel, and a case in which single precision does. This must hold for any seed.
 */
static void ratio_selects_wrong_voxel(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("ratios");
    for (int round = 0; round < 2; round++) {
        bool seen[2][2] = {{false}};
        ost_error err = {0};
        plan p;
        assert_ok(plan_make(PLAN_SMOKE, round ? rng_next(&rng) >> 1 : 1, 1, 1, "import", NULL, &p, &err));
        for (int i = 0; i < p.count; i++) {
            scene s;
            assert_ok(scene_make(&p.cases[i], &s, &err));
            for (int single = 0; single < 2 && s.resample != OST_RESAMPLE_LINEAR; single++)
                seen[s.resample == OST_RESAMPLE_THESIS][single] |=
                    decided_by_ratio(&s, s.rect.spacing.x, s.rect.dims.x, single) > 0 ||
                    decided_by_ratio(&s, s.rect.spacing.z, s.rect.dims.z, single) > 0;
            scene_free(&s);
        }
        plan_free(&p);
        assert_true(seen[0][0] && seen[1][0] && seen[0][1] && seen[1][1]);
    }
}

/*
 * Tests the case import/7. Only y is interpolated, and the bone has 32 or 31 voxels along each
 * axis. The spacing is an odd number of picometres. The offsets of the samples increase, take odd
 * and even values in ppm of the spacing, and stay below 2.2 um.
 */
static void drifting_samples(void **state)
{
    ost_error err = {0};
    plan_case c;
    scene s;
    (void)state;
    assert_true(plan_find(PLAN_SMOKE, 1, "import/7", NULL, &c));
    assert_ok(scene_make(&c, &s, &err));
    const ost_geometry *g = &s.rect;
    ost_pm before = 0;
    int changes = 0;
    assert_true(g->spacing.x == s.cubic && g->spacing.z == s.cubic && g->spacing.y != s.cubic);
    assert_int_equal(s.cubic % 2, 1);
    assert_int_equal(s.resample, OST_RESAMPLE_LINEAR);
    assert_int_equal((g->dims.y * g->spacing.y + s.cubic - 1) / s.cubic, 32);
    assert_true(g->dims.x == 31 && g->dims.z == 32);
    for (size_t n = 0; n < s.sample_count; n++) {
        const ost_pm off = s.samples[n].x - g->origin.x - s.cubic * (ost_pm)(n % (size_t)g->dims.x);
        assert_true(off >= before && off * 1000000 < INT64_C(1) << 41);
        changes += off * 1000000 / s.cubic % 2 != before * 1000000 / s.cubic % 2;
        before = off;
    }
    assert_int_equal(before, SCENE_DRIFT);
    assert_true(changes > 1000);
    scene_free(&s);
}

/* Converts a position to coordinates in voxels of a tool. The corner of the tool's grid is at the origin. */
static void in_tool(const ost_tick *tick, ost_pm voxel, const ost_pm at[3], double out[3])
{
    const ost_pose *p = &tick->pose;
    const double w = (double)p->qw, v[3] = {-(double)p->qx, -(double)p->qy, -(double)p->qz},
                 r[3] = {(double)(at[0] - p->t.x), (double)(at[1] - p->t.y), (double)(at[2] - p->t.z)},
                 norm = w * w + v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    double once[3];
    for (int a = 0; a < 3; a++) {
        const int b = (a + 1) % 3, c = (a + 2) % 3;
        once[a] = v[b] * r[c] - v[c] * r[b] + w * r[a];
    }
    for (int a = 0; a < 3; a++) {
        const int b = (a + 1) % 3, c = (a + 2) % 3;
        out[a] = (r[a] + 2 * (v[b] * once[c] - v[c] * once[b]) / norm) / (double)voxel;
    }
}

/*
 * Tests the case poses/4, whose tools consist of one voxel (validation/scene_corner.c). Each tool must contain
 * the centre of exactly one of the eight corner voxels of the cube [8, 16)^3. Let R be the distance from the
 * cube's middle to this centre, and r the distance from the tool to the cell of 2^3 tool voxels in which the
 * middle lies, both in tool voxels. R must be greater than r but less than the next multiple of 1/8 above r.
 */
static void corners_of_cubes(void **state)
{
    static const int32_t squares[] = {34, 20, 26, 30};
    ost_error err = {0};
    plan_case c;
    scene s;
    (void)state;
    assert_true(plan_find(PLAN_SMOKE, 1, "poses/4", NULL, &c));
    assert_ok(scene_make(&c, &s, &err));
    assert_int_equal(s.tool_count, 4);
    assert_int_equal((int)s.path.count, 4);
    for (int i = 0; i < 4; i++) {
        const ost_tool_geometry *tool = &s.tools[i].cutting.grid;
        const ost_pm3 o = s.rect.origin;
        const double ratio = (double)s.cubic / (double)tool->voxel, squared = 3 * 3.5 * 3.5 * ratio * ratio;
        double middle[3], at[3];
        assert_true(tool->dims.x == 1 && tool->dims.y == 1 && tool->dims.z == 1);
        assert_true(tool->corner.x == 0 && tool->corner.y == 0 && tool->corner.z == 0);
        assert_true(ratio > 0.5 && ratio <= 1);
        in_tool(&s.path.ticks[i], tool->voxel,
                (const ost_pm[]){o.x + s.cubic * 23 / 2, o.y + s.cubic * 23 / 2, o.z + s.cubic * 23 / 2}, middle);
        int64_t square = 0;
        for (int a = 0; a < 3; a++) {
            int64_t cell = 2 * (int64_t)(middle[a] / 2); /* first tool voxel of the cell */
            cell -= middle[a] < (double)cell ? 2 : 0;
            const int64_t gap = cell > 0 ? cell - 1 : cell < 0 ? -(cell + 2) : 0;
            square += gap * gap;
        }
        assert_int_equal(square, squares[i]);
        int eighths = 0;
        while (eighths * eighths < 64 * square)
            eighths++;
        assert_true(squared > (double)square + 0.01 && 64 * squared < (double)(eighths * eighths) - 0.01);
        int inside = 0;
        for (int corner = 0; corner < 8; corner++) {
            in_tool(&s.path.ticks[i], tool->voxel,
                    (const ost_pm[]){o.x + s.cubic * (corner & 1 ? 15 : 8), o.y + s.cubic * (corner & 2 ? 15 : 8),
                                     o.z + s.cubic * (corner & 4 ? 15 : 8)},
                    at);
            bool in = true;
            for (int a = 0; a < 3; a++)
                in = in && at[a] > 0.001 && at[a] < 0.999;
            inside += in;
        }
        assert_int_equal(inside, 1);
    }
    scene_free(&s);
}

/*
 * Tests that each case of the `reach` family has the properties for which it is designed. The expected
 * numbers are those in the description of the case.
 */
static void reach_cases_have_designed_properties(void **state)
{
    ost_error err = {0};
    plan p;
    (void)state;
    assert_ok(plan_make(PLAN_STANDARD, 1, 1, 1, "reach", NULL, &p, &err));
    assert_int_equal(p.count, 12);
    for (int i = 0; i < p.count; i++) {
        scene s;
        assert_ok(scene_make(&p.cases[i], &s, &err));
        const ost_dims d = s.rect.dims;
        if (i % 6 == 0) {
            const int64_t z = (d.z * s.rect.spacing.z + s.cubic - 1) / s.cubic;
            assert_true(d.x * (int64_t)d.y * z > 1 << 22);
            assert_int_equal(d.x % 1024, 1);
            assert_int_equal(d.y % 64, 1);
            assert_int_equal(z % 64, 1);
            assert_true(s.batch > 2 << 16);
            assert_true(s.tools[0].cutting.grid.dims.x > 512);
            assert_true(s.tools[1].cutting.grid.dims.x == 257);
            assert_true(s.tools[0].noncutting.triangle_count > 0);
            /*
             * The distance from a voxel's middle to the bar's end must be half a unit of the map, so that rounding
             * it is a tie.
             */
            for (size_t n = 0; n < 3; n++) {
                const ost_tool_geometry *bar = &s.tools[0].cutting.grid;
                const ost_pm end = s.path.ticks[n].pose.t.x + bar->corner.x + bar->dims.x * bar->voxel -
                                   s.rect.origin.x;
                const ost_pm block = (end + s.cubic) / (OST_MAP_BLOCK * s.cubic) * OST_MAP_BLOCK * s.cubic;
                assert_int_equal((end - block) * 2 << OST_MAP_FRACTION, bar->voxel);
            }
        } else if (i % 6 == 1) {
            assert_true(s.slices > 0 && d.z % s.slices != 0);
            assert_true(s.rect.origin.x + d.x * s.rect.spacing.x > OST_LENGTH_MAX - 20 * OST_PM_PER_MM);
            assert_int_equal((int64_t)s.sample_count, ost_dims_count(d));
            assert_int_equal(s.world.classes.count, i == 1 ? 1 : 8);
            const ost_dims bar = s.tools[3].cutting.grid.dims;
            assert_true(bar.x > 64 && bar.x <= 128 && bar.y % 64 == 3 && bar.z % 64 == 3 &&
                        s.tools[3].noncutting.triangle_count > 0);
            /* greatest and lowest density of the first and of the second chunk along x */
            int32_t most[2] = {0}, least[2] = {INT16_MAX, INT16_MAX};
            for (size_t n = 0; n < s.sample_count; n++) {
                const int part = (int32_t)(n % (size_t)d.x) >= s.chunk_size;
                const int32_t density = s.samples[n].density;
                most[part] = density > most[part] ? density : most[part];
                least[part] = density < least[part] ? density : least[part];
            }
            assert_true(least[0] > 16384 && least[1] > 4095 && most[1] > 12287 && most[1] < 16384);
        } else if (i % 6 == 3) {
            const scene_tool *plates = &s.tools[0];
            const ost_mesh *m = &plates->raw[0];
            size_t on_a_line = 0;
            assert_int_equal((d.x * s.rect.spacing.x + s.cubic - 1) / s.cubic % 8, 1);
            assert_int_equal(d.x * s.rect.spacing.x % s.cubic, 0);
            /* counts triangles whose corners are distinct but lie on a line */
            for (size_t t = 0; t < m->triangle_count; t++) {
                int64_t e[2][3];
                for (int k = 0; k < 2; k++) {
                    const ost_pm3 a = m->vertices[m->triangles[t][0]], b = m->vertices[m->triangles[t][k + 1]];
                    e[k][0] = (b.x - a.x) / (s.cubic / 2);
                    e[k][1] = (b.y - a.y) / (s.cubic / 2);
                    e[k][2] = (b.z - a.z) / (s.cubic / 2);
                }
                on_a_line += e[0][0] && e[1][0] && e[0][0] != e[1][0] && e[0][0] * e[1][1] == e[0][1] * e[1][0] &&
                             e[0][1] * e[1][2] == e[0][2] * e[1][1] && e[0][0] * e[1][2] == e[0][2] * e[1][0];
            }
            /* These zero-area triangles are dropped when the mesh is snapped. */
            assert_int_equal(m->triangle_count - plates->cutting.triangle_count, 4);
            assert_int_equal(on_a_line, 4);
            assert_int_equal(plates->noncutting.triangle_count, 10); /* a box without one face */
            /* At the end of its last sweep, the tool is beyond the end of the bone along x. */
            assert_true(s.path.ticks[2].pose.t.x + plates->cutting.grid.corner.x >
                        s.rect.origin.x + d.x * s.rect.spacing.x);
            for (int n = 3; n < 5; n++) {
                const ost_tick *tick = &s.path.ticks[n];
                assert_int_equal(s.path.ticks[5].pose.t.x - tick->pose.t.x,
                                 s.tools[tick->tool].cutting.grid.voxel << (n + 8));
            }
            /* The rotated bar ends within a block. The first voxel of this block has a coordinate beyond 2^30. */
            const ost_tool_geometry *bar = &s.tools[3].cutting.grid;
            const ost_pm end = s.path.ticks[6].pose.t.x + bar->corner.x - s.rect.origin.x;
            assert_int_equal(bar->dims.x, OST_TOOL_DIM_REMOVE_MAX);
            assert_true(s.tools[3].noncutting.triangle_count > 0);
            assert_true(end > s.cubic && end < (OST_MAP_BLOCK - 1) * s.cubic);
        } else if (i % 6 == 4) {
            uint8_t active[65] = {0}, places[64] = {0};
            for (size_t n = 0; n < s.sample_count; n++) {
                const int32_t x = (int32_t)(n % (size_t)d.x);
                active[x / 64] += s.samples[n].density >= s.threshold;
                places[x % 64] += s.samples[n].density >= s.threshold;
            }
            for (int c = 0; c <= 64; c++)
                assert_int_equal(active[c], 1);
            for (int c = 0; c < 64; c++)
                assert_int_equal(places[c], 1 + (c == d.x % 64 - 1));
            /*
             * More than 2^16 triangles must have the centre of a row within their bounds along y and z. Half a
             * voxel is 2^9 units.
             */
            const ost_snapped_mesh *fine = &s.tools[0].cutting;
            int64_t with_rows = 0;
            for (size_t t = 0; t < fine->triangle_count; t++) {
                bool both = true;
                for (int a = 1; a < 3; a++) {
                    int32_t lo = INT32_MAX, hi = 0;
                    for (int c = 0; c < 3; c++) {
                        const int32_t at = fine->vertices[fine->triangles[t][c]][a];
                        lo = at < lo ? at : lo;
                        hi = at > hi ? at : hi;
                    }
                    both = both && (hi + 512) / 1024 > (lo + 511) / 1024;
                }
                with_rows += both;
            }
            assert_int_equal(fine->fraction_bits, 10);
            assert_true(with_rows > 1 << 16);
        } else if (i % 6 == 5) {
            bool any = false;
            for (size_t n = 0; n < s.sample_count; n++)
                any = any || s.samples[n].density >= s.threshold;
            assert_int_equal(any, i != 5);
            const ost_snapped_mesh *thin = &s.tools[1].cutting;
            int least = 0;
            for (size_t t = 0; t < thin->triangle_count; t++) {
                const int32_t *v[3];
                for (int c = 0; c < 3; c++)
                    v[c] = thin->vertices[thin->triangles[t][c]];
                const int64_t area = (v[1][1] - v[0][1]) * (int64_t)(v[2][2] - v[0][2]) -
                                     (v[2][1] - v[0][1]) * (int64_t)(v[1][2] - v[0][2]);
                least += area == 1 || area == -1;
            }
            assert_int_equal(least, 6 * 8);
            assert_true(thin->grid.dims.y * thin->grid.dims.z > 1 << 16);
        } else {
            int64_t beyond = 0;
            for (size_t n = 0; n < s.sample_count; n++) {
                const ost_pm off = s.samples[n].y - s.rect.origin.y, spacing = s.rect.spacing.y,
                             remainder = ((off % spacing) + spacing) % spacing;
                beyond += remainder > 3 * spacing / 8 && remainder < spacing - 3 * spacing / 8;
            }
            assert_true(i == 2 ? beyond > 0 : beyond == 0);
            assert_int_equal(s.duplicates, OST_DUPLICATES_ERROR);
        }
        scene_free(&s);
    }
    plan_free(&p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(digests_of_families),
        cmocka_unit_test(digests_of_small_scenes),
        cmocka_unit_test(reach_cases_have_designed_properties),
        cmocka_unit_test(small_bones_are_downloaded_completely),
        cmocka_unit_test(ratio_selects_wrong_voxel),
        cmocka_unit_test(drifting_samples),
        cmocka_unit_test(corners_of_cubes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
