/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Compares components, cuts and holes of small random volumes with an oracle. The oracle uses a flood fill
 * that visits one voxel at a time, and computes distances as 128-bit integers.
 *
 * Covers: AR-SEG-1, AR-SEG-2, AR-SEG-3, AR-SEG-4, AR-SEG-5
 */
#include <osteon/segment.h>

#include "harness.h"

__extension__ typedef __int128 wide;

enum { MOST = 12 * 12 * 12 };

typedef struct scene {
    ost_volume ct;
    ost_segment_options options;
    ost_segment_cut cuts[3];
} scene;

static size_t voxel_count(const scene *s)
{
    return (size_t)ost_dims_count(s->ct.geometry.dims);
}

static void make(scene *s, test_rng *rng)
{
    ost_error err = {0};
    const ost_geometry g = {
        .dims = {(int32_t)rng_range(rng, 1, 12), (int32_t)rng_range(rng, 1, 12), (int32_t)rng_range(rng, 1, 12)},
        .spacing = {rng_range(rng, 1, 2000) * 1000000, rng_range(rng, 1, 2000) * 1000000,
                    rng_range(rng, 1, 2000) * 1000000},
        .origin = {rng_range(rng, -900, 900) * OST_PM_PER_MM, rng_range(rng, -900, 900) * 1000000, 7}};
    *s = (scene){.options = {.threshold = (int32_t)rng_range(rng, 2, 5)}};
    assert_ok(ost_volume_init(&s->ct, &g, &err));
    const int64_t dense = rng_range(rng, 1, 6); /* on average, `dense` of every 7 voxels have positive densities */
    for (size_t i = 0; i < voxel_count(s); i++)
        s->ct.voxels[i] = (int16_t)(rng_range(rng, 0, 6) < dense ? rng_range(rng, 1, 6) : rng_range(rng, -3, 1));
    s->options.growth = (int32_t)rng_range(rng, 1, s->options.threshold);
    s->options.min_voxels = (uint64_t)rng_range(rng, 0, 4);
    s->options.fill = rng_range(rng, 0, 1);
    s->options.air = (int32_t)rng_range(rng, -3, 1);
    s->options.cuts = s->cuts;
    s->options.cut_count = (size_t)rng_range(rng, 0, 2);
    for (size_t i = 0; i < s->options.cut_count; i++) {
        /*
         * Positions are on voxel centres, and radii are integer numbers of voxels, so that some
         * voxels lie exactly on the border.
         */
        ost_segment_cut *c = &s->cuts[i];
        c->at = (ost_pm3){g.origin.x + rng_range(rng, 0, g.dims.x) * g.spacing.x,
                          g.origin.y + rng_range(rng, 0, g.dims.y) * g.spacing.y,
                          g.origin.z + rng_range(rng, 0, g.dims.z) * g.spacing.z + rng_range(rng, 0, 1)};
        c->radius = rng_range(rng, 0, 2) * g.spacing.x;
        c->normal = (ost_pm3){rng_range(rng, -2, 2), rng_range(rng, -2, 2), rng_range(rng, 1, 2)};
    }
}

/* ----------------------------------------------------------------- oracle */

static bool is_cut(const scene *s, int32_t x, int32_t y, int32_t z)
{
    const ost_geometry *g = &s->ct.geometry;
    for (size_t i = 0; i < s->options.cut_count; i++) {
        const ost_segment_cut *c = &s->cuts[i];
        const wide d[3] = {g->origin.x + x * g->spacing.x - c->at.x, g->origin.y + y * g->spacing.y - c->at.y,
                           g->origin.z + z * g->spacing.z - c->at.z};
        if (c->radius ? d[0] * d[0] + d[1] * d[1] + d[2] * d[2] <= (wide)c->radius * c->radius
                      : d[0] * c->normal.x + d[1] * c->normal.y + d[2] * c->normal.z >= 0)
            return true;
    }
    return false;
}

/* Marks all voxels that have the same flag as voxel `from` and are connected to it through shared faces. */
static size_t flood(const scene *s, const bool *in, size_t from, bool *reached, size_t found[MOST])
{
    const ost_dims d = s->ct.geometry.dims;
    const size_t nx = (size_t)d.x, ny = (size_t)d.y;
    size_t count = 0;
    reached[from] = true;
    found[count++] = from;
    for (size_t at = 0; at < count; at++) {
        const size_t i = found[at], x = i % nx, y = i / nx % ny, z = i / nx / ny;
        const size_t next[6] = {x > 0 ? i - 1 : i,
                                x + 1 < nx ? i + 1 : i,
                                y > 0 ? i - nx : i,
                                y + 1 < ny ? i + nx : i,
                                z > 0 ? i - nx * ny : i,
                                z + 1 < (size_t)d.z ? i + nx * ny : i};
        for (int k = 0; k < 6; k++)
            if (in[next[k]] == in[from] && !reached[next[k]]) {
                reached[next[k]] = true;
                found[count++] = next[k];
            }
    }
    return count;
}

/* Writes the label of each voxel and returns the number of labels. sizes[k] is the number of voxels of label k + 1. */
static size_t expected_labels(const scene *s, int16_t *labels, uint64_t sizes[MOST], uint64_t filled[MOST])
{
    static size_t members[MOST], starts[MOST];
    const ost_dims d = s->ct.geometry.dims;
    const size_t all = voxel_count(s), nx = (size_t)d.x, ny = (size_t)d.y;
    bool in[MOST], reached[MOST] = {false};
    size_t count = 0;
    for (size_t i = 0; i < all; i++) {
        labels[i] = 0;
        in[i] = s->ct.voxels[i] >= s->options.growth &&
                !is_cut(s, (int32_t)(i % nx), (int32_t)(i / nx % ny), (int32_t)(i / nx / ny));
    }
    for (size_t i = 0; i < all; i++) {
        if (!in[i] || reached[i])
            continue;
        const size_t size = flood(s, in, i, reached, members);
        bool dense = false;
        for (size_t m = 0; m < size; m++)
            dense = dense || s->ct.voxels[members[m]] >= s->options.threshold;
        if (!dense || size < s->options.min_voxels)
            continue;
        size_t rank = count++; /* the component is inserted after all components of the same or a greater size */
        for (; rank > 0 && sizes[rank - 1] < size; rank--) {
            sizes[rank] = sizes[rank - 1];
            starts[rank] = starts[rank - 1];
        }
        sizes[rank] = size;
        starts[rank] = i;
    }
    for (size_t k = 0; k < count; k++) {
        bool again[MOST] = {false};
        const size_t size = flood(s, in, starts[k], again, members);
        for (size_t m = 0; m < size; m++)
            labels[members[m]] = (int16_t)(k + 1);
        filled[k] = 0;
    }
    if (!s->options.fill)
        return count;
    int16_t result[MOST];
    bool labelled[MOST], seen[MOST] = {false};
    for (size_t i = 0; i < all; i++) {
        labelled[i] = labels[i] != 0;
        result[i] = labels[i];
    }
    for (size_t i = 0; i < all; i++) {
        if (labelled[i] || seen[i])
            continue;
        const size_t size = flood(s, labelled, i, seen, members);
        bool closed = true;
        for (size_t m = 0; m < size; m++) {
            const size_t x = members[m] % nx, y = members[m] / nx % ny, z = members[m] / nx / ny;
            closed = closed && x > 0 && x + 1 < nx && y > 0 && y + 1 < ny && z > 0 && z + 1 < (size_t)d.z &&
                     s->ct.voxels[members[m]] >= s->options.air;
        }
        for (size_t m = 0; m < size && closed; m++)
            result[members[m]] = labels[i - 1];
        if (closed)
            filled[labels[i - 1] - 1] += size;
    }
    memcpy(labels, result, all * sizeof *labels);
    return count;
}

/* ------------------------------------------------------------------ tests */

static void volumes_equal_the_oracle(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("segment");
    size_t with_holes = 0, with_cuts = 0, several = 0;
    for (int round = 0; round < 3000; round++) {
        scene s;
        ost_error err = {0};
        ost_volume labels;
        ost_segment *segments;
        size_t count;
        int16_t expected[MOST];
        uint64_t sizes[MOST], filled[MOST];
        make(&s, &rng);
        assert_ok(ost_segment_volume(&s.ct, &s.options, &labels, &segments, &count, &err));
        assert_int_equal(count, expected_labels(&s, expected, sizes, filled));
        assert_memory_equal(labels.voxels, expected, voxel_count(&s) * sizeof *expected);
        for (size_t k = 0; k < count; k++) {
            assert_int_equal(segments[k].voxels, sizes[k]);
            assert_int_equal(segments[k].filled, s.options.fill ? filled[k] : 0);
            with_holes += segments[k].filled > 0;
        }
        with_cuts += s.options.cut_count > 0;
        several += count > 1;
        ost_segments_free(segments);
        ost_volume_free(&labels);
        ost_volume_free(&s.ct);
    }
    assert_true(with_holes > 20 && with_cuts > 1000 && several > 300);
}

/* Tests the bounds and the first voxel of each component in a volume drawn by hand. */
static void bounds_and_first_voxels(void **state)
{
    (void)state;
    static const char *const rows[2][3] = {{"#..#.", "#..#.", "....#"}, {".....", ".###.", "....#"}};
    const ost_geometry g = {.dims = {5, 3, 2}, .spacing = {OST_PM_PER_MM, OST_PM_PER_MM, OST_PM_PER_MM}};
    ost_error err = {0};
    ost_volume ct, labels;
    ost_segment *segments;
    size_t count;
    assert_ok(ost_volume_init(&ct, &g, &err));
    for (int z = 0; z < 2; z++)
        for (int y = 0; y < 3; y++)
            for (int x = 0; x < 5; x++)
                ct.voxels[x + 5 * (y + 3 * z)] = rows[z][y][x] == '#' ? 120 : 119;
    assert_ok(ost_segment_volume(&ct, NULL, &labels, &segments, &count, &err));
    assert_int_equal(count, 3);
    /*
     * The first component has 5 voxels: (3, 0, 0), (3, 1, 0) and the row at z = 1. Two components
     * of 2 voxels follow, in order of their first voxels.
     */
    assert_int_equal(segments[0].voxels, 5);
    assert_int_equal(segments[1].voxels, 2);
    assert_int_equal(segments[2].voxels, 2);
    const int32_t first[3][3] = {{3, 0, 0}, {0, 0, 0}, {4, 2, 0}}, lo[3][3] = {{1, 0, 0}, {0, 0, 0}, {4, 2, 0}},
                  hi[3][3] = {{4, 2, 2}, {1, 2, 1}, {5, 3, 2}};
    for (int k = 0; k < 3; k++) {
        assert_memory_equal(segments[k].first, first[k], sizeof first[k]);
        assert_memory_equal(segments[k].box.lo, lo[k], sizeof lo[k]);
        assert_memory_equal(segments[k].box.hi, hi[k], sizeof hi[k]);
    }
    ost_segments_free(segments);
    ost_volume_free(&labels);
    ost_volume_free(&ct);
}

/* 32,768 single voxels are one component too many. If the smallest size is 2, there is no component. */
static void too_many_components(void **state)
{
    (void)state;
    const ost_geometry g = {.dims = {128, 64, 8}, .spacing = {OST_PM_PER_MM, OST_PM_PER_MM, OST_PM_PER_MM}};
    ost_error err = {0};
    ost_volume ct, labels;
    ost_segment *segments;
    size_t count;
    assert_ok(ost_volume_init(&ct, &g, &err));
    for (int z = 0; z < 8; z++)
        for (int y = 0; y < 64; y++)
            for (int x = 0; x < 128; x++)
                ct.voxels[x + 128 * (y + 64 * z)] = (x + y + z) % 2 ? 500 : 0;
    assert_int_equal(ost_segment_volume(&ct, NULL, &labels, &segments, &count, &err), OST_ERR_RANGE);
    assert_non_null(strstr(err.text, "32768 components; at most 32767"));
    assert_null(labels.voxels);
    const ost_segment_options two = {.min_voxels = 2};
    assert_ok(ost_segment_volume(&ct, &two, &labels, &segments, &count, &err));
    assert_int_equal(count, 0);
    ost_segments_free(segments);
    ost_volume_free(&labels);
    ost_volume_free(&ct);
}

static void options_out_of_range(void **state)
{
    (void)state;
    const ost_geometry g = {.dims = {2, 2, 2}, .spacing = {OST_PM_PER_MM, OST_PM_PER_MM, OST_PM_PER_MM}};
    const ost_segment_cut far = {.at = {OST_LENGTH_MAX + 1, 0, 0}, .radius = 1},
                          large = {.radius = 1001 * OST_PM_PER_MM}, negative = {.radius = -1},
                          no_normal = {.radius = 0}, long_normal = {.normal = {0, 0, INT64_MIN}};
    const struct {
        ost_segment_options options;
        const char *text;
    } rows[] = {{{.threshold = -1}, "a threshold of -1"},
                {{.threshold = 32768}, "a threshold of 32768"},
                {{.threshold = 100, .growth = 101}, "growth from 101"},
                {{.threshold = 100, .growth = -5}, "growth from -5"},
                {{.cuts = &far, .cut_count = 1}, "8 m away"},
                {{.cuts = &large, .cut_count = 1}, "a ball of 1001 mm"},
                {{.cuts = &negative, .cut_count = 1}, "a ball of -1e-09 mm"},
                {{.cuts = &no_normal, .cut_count = 1}, "a plane whose normal"},
                {{.cuts = &long_normal, .cut_count = 1}, "a plane whose normal"}};
    ost_error err = {0};
    ost_volume ct, labels;
    ost_segment *segments;
    size_t count;
    assert_ok(ost_volume_init(&ct, &g, &err));
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        assert_int_equal(ost_segment_volume(&ct, &rows[i].options, &labels, &segments, &count, &err), OST_ERR_RANGE);
        if (!strstr(err.text, rows[i].text))
            fail_msg("the error '%s' does not contain '%s'", err.text, rows[i].text);
        assert_null(labels.voxels);
    }
    ost_volume_free(&ct);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(volumes_equal_the_oracle),
        cmocka_unit_test(bounds_and_first_voxels),
        cmocka_unit_test(too_many_components),
        cmocka_unit_test(options_out_of_range),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
