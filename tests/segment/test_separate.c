/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Compares the pieces of random small volumes with an oracle that follows the text of the rules. To find the distance
 * of a voxel, the oracle tests all other voxels. To find the markers, it follows all paths. During the flood, it finds
 * the next voxel by a linear search. Further tests check the selection of labels.
 *
 * Covers: AR-SEG-7, AR-SEG-8, AR-SEG-9, AR-SEG-10
 */
#include <osteon/segment.h>

#include "harness.h"

enum { MOST = 10 * 10 * 10 };

static size_t voxel_count(const ost_volume *v)
{
    return (size_t)ost_dims_count(v->geometry.dims);
}

/* Makes a volume of a few boxes with a few holes. The boxes may overlap or touch. */
static void make(ost_volume *ct, test_rng *rng)
{
    ost_error err = {0};
    const ost_geometry g = {
        .dims = {(int32_t)rng_range(rng, 1, 10), (int32_t)rng_range(rng, 1, 10), (int32_t)rng_range(rng, 1, 10)},
        /* 0.1 to 2.5 mm; two thirds of the spacings along x are not whole numbers of micrometres */
        .spacing = {rng_range(rng, 1, 25) * 100000000 + rng_range(rng, 0, 2) * 250000,
                    rng_range(rng, 1, 25) * 100000000, rng_range(rng, 1, 25) * 100000000},
    };
    assert_ok(ost_volume_init(ct, &g, &err));
    const int32_t n[3] = {g.dims.x, g.dims.y, g.dims.z};
    for (int64_t boxes = rng_range(rng, 1, 6); boxes > 0; boxes--) {
        int32_t lo[3], hi[3];
        for (int a = 0; a < 3; a++) {
            lo[a] = (int32_t)rng_range(rng, 0, n[a] - 1);
            hi[a] = (int32_t)rng_range(rng, lo[a], n[a] - 1);
        }
        for (int32_t z = lo[2]; z <= hi[2]; z++)
            for (int32_t y = lo[1]; y <= hi[1]; y++)
                for (int32_t x = lo[0]; x <= hi[0]; x++)
                    ct->voxels[x + n[0] * (y + n[1] * z)] = 500;
    }
    /* Along each axis with more than two voxels, half of the empty voxels are not in the first or the last layer, so
       that they can be holes. */
    for (int64_t empty = rng_range(rng, 0, 8); empty > 0; empty--) {
        const int32_t inner = (int32_t)rng_range(rng, 0, 1);
        size_t at[3];
        for (int a = 0; a < 3; a++) {
            const int32_t edge = n[a] > 2 ? inner : 0;
            at[a] = (size_t)rng_range(rng, edge, n[a] - 1 - edge);
        }
        ct->voxels[at[0] + (size_t)n[0] * (at[1] + (size_t)n[1] * at[2])] = (int16_t)-rng_range(rng, 0, 1);
    }
}

/* ----------------------------------------------------------------- oracle */

typedef struct oracle {
    const ost_volume *labels; /* labels before the separation, with holes closed by close_slices */
    bool closed[MOST];        /* true for voxels that have a label only because a hole of their slice was closed */
    int64_t height[MOST];
    int piece[MOST]; /* piece to which each voxel belongs; -1 if there is none */
    int pieces;
} oracle;

static void position(const ost_volume *v, size_t i, int64_t at[3])
{
    const size_t nx = (size_t)v->geometry.dims.x, ny = (size_t)v->geometry.dims.y;
    at[0] = (int64_t)(i % nx);
    at[1] = (int64_t)(i / nx % ny);
    at[2] = (int64_t)(i / nx / ny);
}

/* Stores the indices of voxel i's neighbours in next[], in the order of AR-SEG-9. Returns their number. */
static int neighbours(const ost_volume *v, size_t i, size_t next[6])
{
    const size_t step[3] = {1, (size_t)v->geometry.dims.x, (size_t)v->geometry.dims.x * (size_t)v->geometry.dims.y};
    const int64_t n[3] = {v->geometry.dims.x, v->geometry.dims.y, v->geometry.dims.z};
    int64_t at[3];
    int count = 0;
    position(v, i, at);
    for (int a = 0; a < 3; a++) {
        if (at[a] > 0 && v->voxels[i - step[a]] == v->voxels[i])
            next[count++] = i - step[a];
        if (at[a] + 1 < n[a] && v->voxels[i + step[a]] == v->voxels[i])
            next[count++] = i + step[a];
    }
    return count;
}

/* Converts a positive length from picometres to micrometres, rounding half to even. */
static int64_t to_um(ost_pm pm)
{
    const int64_t um = pm / 1000000, rest = pm % 1000000;
    return um + (rest > 500000 || (rest == 500000 && um % 2 == 1));
}

/* Closes the holes of each slice. A voxel without a label is in a hole if neither the border of the slice nor air can
   be reached from it. Such a voxel gets the label of the surrounding voxels. */
static void close_slices(oracle *o, const ost_volume *ct, ost_volume *labels, int32_t air)
{
    const int64_t nx = ct->geometry.dims.x, ny = ct->geometry.dims.y;
    bool seen[MOST] = {false};
    memset(o->closed, 0, sizeof o->closed);
    for (size_t i = 0; i < voxel_count(ct); i++) {
        static size_t list[MOST];
        size_t count = 0, next[6];
        bool hole = true;
        if (labels->voxels[i] || seen[i])
            continue;
        list[count++] = i;
        seen[i] = true;
        for (size_t k = 0; k < count; k++) {
            int64_t p[3], q[3];
            position(ct, list[k], p);
            hole = hole && p[0] > 0 && p[0] < nx - 1 && p[1] > 0 && p[1] < ny - 1 && ct->voxels[list[k]] >= air;
            for (int n = neighbours(labels, list[k], next) - 1; n >= 0; n--) {
                position(ct, next[n], q);
                if (q[2] == p[2] && !seen[next[n]]) {
                    seen[next[n]] = true;
                    list[count++] = next[n];
                }
            }
        }
        for (size_t k = 0; k < count && hole; k++)
            o->closed[list[k]] = true;
    }
    for (size_t i = 0; i < voxel_count(ct); i++)
        if (o->closed[i]) /* the previous voxel already has its label */
            labels->voxels[i] = labels->voxels[i - 1];
    o->labels = labels;
}

static void compute_heights(oracle *o)
{
    const ost_pm3 s = o->labels->geometry.spacing;
    const int64_t um[3] = {to_um(s.x), to_um(s.y), to_um(s.z)}, limit = INT64_C(65535) * 65535;
    for (size_t i = 0; i < voxel_count(o->labels); i++) {
        int64_t least = limit, p[3], q[3];
        position(o->labels, i, p);
        for (size_t k = 0; k < voxel_count(o->labels); k++) {
            int64_t sum = 0;
            if (o->labels->voxels[k])
                continue;
            position(o->labels, k, q);
            for (int a = 0; a < 3; a++)
                sum += um[a] * (p[a] - q[a]) * um[a] * (p[a] - q[a]);
            least = sum < least ? sum : least;
        }
        int64_t r = 0;
        while ((r + 1) * (r + 1) <= least)
            r += (r + 1000) * (r + 1000) <= least ? 1000 : 1;
        o->height[i] = r;
    }
}

static bool comes_before(const oracle *o, size_t a, size_t b)
{
    return o->height[a] > o->height[b] || (o->height[a] == o->height[b] && a < b);
}

/* Follows all paths from voxel `from` on which all heights are at least t. Returns true if a path reaches a voxel
   that precedes `from` in the order of the flood. */
static bool reaches_higher(const oracle *o, size_t from, int64_t t)
{
    static size_t list[MOST];
    bool seen[MOST] = {false};
    size_t count = 0, next[6];
    list[count++] = from;
    seen[from] = true;
    for (size_t k = 0; k < count; k++) {
        if (comes_before(o, list[k], from))
            return true;
        for (int n = neighbours(o->labels, list[k], next) - 1; n >= 0; n--)
            if (!seen[next[n]] && o->height[next[n]] >= t) {
                seen[next[n]] = true;
                list[count++] = next[n];
            }
    }
    return false;
}

typedef struct waiting {
    size_t voxel;
    int64_t level;
    bool done;
} waiting;

static void flood(oracle *o, int64_t depth)
{
    static waiting list[MOST];
    static size_t order[MOST];
    const size_t all = voxel_count(o->labels);
    size_t voxels = 0, count = 0;
    for (size_t i = 0; i < all; i++) {
        o->piece[i] = -1;
        if (!o->labels->voxels[i])
            continue;
        size_t at = voxels++;
        for (; at > 0 && comes_before(o, i, order[at - 1]); at--)
            order[at] = order[at - 1];
        order[at] = i;
    }
    o->pieces = 0;
    /* a voxel is a marker if no path above its height minus `depth` leads to a preceding voxel */
    for (size_t k = 0; k < voxels; k++)
        if (!reaches_higher(o, order[k], o->height[order[k]] - depth + 1)) {
            o->piece[order[k]] = o->pieces++;
            list[count++] = (waiting){order[k], o->height[order[k]], false};
        }
    for (;;) {
        size_t best = count, next[6];
        for (size_t k = 0; k < count; k++)
            if (!list[k].done && (best == count || list[k].level > list[best].level))
                best = k;
        if (best == count)
            return;
        list[best].done = true;
        const int near = neighbours(o->labels, list[best].voxel, next);
        for (int n = 0; n < near; n++)
            if (o->piece[next[n]] < 0) {
                const int64_t h = o->height[next[n]];
                o->piece[next[n]] = o->piece[list[best].voxel];
                list[count++] = (waiting){next[n], h < list[best].level ? h : list[best].level, false};
            }
    }
}

/* ------------------------------------------------------------------ tests */

static void check_pieces(const oracle *o, const ost_volume *ct, const ost_segment_options *options,
                         const ost_volume *labels, const ost_segment *segments, size_t count)
{
    const size_t all = voxel_count(ct);
    size_t voxels[MOST] = {0}, filled[MOST] = {0}, first[MOST], found = 0;
    int of_piece[MOST];
    for (size_t i = all; i-- > 0;)
        if (o->piece[i] >= 0 && !o->closed[i]) {
            const bool dense = ct->voxels[i] >= options->growth;
            voxels[o->piece[i]] += dense;
            filled[o->piece[i]] += !dense;
            if (dense)
                first[o->piece[i]] = i;
        }
    for (int p = 0; p < o->pieces; p++) {
        of_piece[p] = 0;
        if (voxels[p] < 1 || voxels[p] < options->min_voxels)
            continue;
        int rank = 1; /* one plus the number of pieces before this piece */
        for (int q = 0; q < o->pieces; q++)
            rank += voxels[q] > voxels[p] || (voxels[q] == voxels[p] && voxels[q] && first[q] < first[p]);
        of_piece[p] = rank;
        found++;
        assert_true((size_t)rank <= count);
        assert_int_equal(segments[rank - 1].voxels, voxels[p]);
        assert_int_equal(segments[rank - 1].filled, filled[p]);
        int64_t at[3];
        position(ct, first[p], at);
        for (int a = 0; a < 3; a++)
            assert_int_equal(segments[rank - 1].first[a], at[a]);
    }
    assert_int_equal(found, count);
    for (size_t i = 0; i < all; i++)
        assert_int_equal(labels->voxels[i], o->piece[i] < 0 || o->closed[i] ? 0 : of_piece[o->piece[i]]);
}

static void pieces_equal_the_oracle(void **state)
{
    (void)state;
    static oracle o;
    test_rng rng = rng_seeded("separate");
    size_t divided = 0, with_holes = 0;
    for (int round = 0; round < 2500; round++) {
        ost_volume ct, whole, labels;
        ost_segment *segments;
        size_t before, count;
        ost_error err = {0};
        make(&ct, &rng);
        ost_segment_options options = {.threshold = 100,
                                       .growth = 100,
                                       .fill = rng_range(&rng, 0, 1),
                                       .air = (int32_t)rng_range(&rng, -1, 0),
                                       .min_voxels = (uint64_t)rng_range(&rng, 0, 3)};
        assert_ok(ost_segment_volume(&ct, &options, &whole, &segments, &before, &err));
        ost_segments_free(segments);
        options.separate = rng_range(&rng, 1, 20) * OST_PM_PER_MM / 20 + rng_range(&rng, 0, 1) * 500000;
        assert_ok(ost_segment_volume(&ct, &options, &labels, &segments, &count, &err));
        close_slices(&o, &ct, &whole, options.air);
        compute_heights(&o);
        flood(&o, to_um(options.separate));
        check_pieces(&o, &ct, &options, &labels, segments, count);
        divided += count > before;
        for (size_t k = 0; k < count; k++)
            with_holes += segments[k].filled > 0;
        ost_segments_free(segments);
        ost_volume_free(&labels);
        ost_volume_free(&whole);
        ost_volume_free(&ct);
    }
    printf("# %zu volumes were divided, %zu pieces had holes\n", divided, with_holes);
    /* About twelve of 2,500 draws give a piece with holes. If there were none, holes would not be tested. */
    assert_true(divided > 150 && with_holes > 4);
}

/* Tests the example of docs/spec/arithmetic.md: two squares of 3 x 3 voxels of 1 mm, connected by a bridge of one
   voxel. */
static void squares_with_a_bridge(void **state)
{
    (void)state;
    static const char *const rows[5] = {".........", ".###.###.", ".#######.", ".###.###.", "........."},
                            *const two[5] = {".........", ".111.222.", ".1111222.", ".111.222.", "........."};
    const ost_geometry g = {.dims = {9, 5, 1}, .spacing = {OST_PM_PER_MM, OST_PM_PER_MM, OST_PM_PER_MM}};
    ost_segment_options options = {.separate = OST_PM_PER_MM};
    ost_error err = {0};
    ost_volume ct, labels;
    ost_segment *segments;
    size_t count;
    assert_ok(ost_volume_init(&ct, &g, &err));
    for (int i = 0; i < 45; i++)
        ct.voxels[i] = rows[i / 9][i % 9] == '#' ? 500 : 0;
    assert_ok(ost_segment_volume(&ct, &options, &labels, &segments, &count, &err));
    assert_int_equal(count, 2);
    assert_int_equal(segments[0].voxels, 10);
    assert_int_equal(segments[1].voxels, 9);
    for (int i = 0; i < 45; i++)
        assert_int_equal(labels.voxels[i], two[i / 9][i % 9] == '.' ? 0 : two[i / 9][i % 9] - '0');
    ost_segments_free(segments);
    ost_volume_free(&labels);
    options.separate += OST_PM_PER_MM / 1000;
    assert_ok(ost_segment_volume(&ct, &options, &labels, &segments, &count, &err));
    assert_int_equal(count, 1);
    assert_int_equal(segments[0].voxels, 19);
    ost_segments_free(segments);
    ost_volume_free(&labels);
    ost_volume_free(&ct);
}

/* If all distances exceed 65.535 mm, or if there is no voxel outside the bone, all heights are equal and nothing is
   divided. */
static void large_distances(void **state)
{
    (void)state;
    const ost_geometry g = {.dims = {5, 3, 2}, .spacing = {OST_SPACING_MAX, OST_SPACING_MAX, OST_SPACING_MAX}};
    const ost_segment_options options = {.separate = OST_PM_PER_MM / 1000};
    ost_error err = {0};
    ost_volume ct, labels;
    ost_segment *segments;
    size_t count;
    assert_ok(ost_volume_init(&ct, &g, &err));
    for (int hole = 0; hole < 2; hole++) {
        for (int i = 0; i < 30; i++)
            ct.voxels[i] = hole && i == 7 ? 0 : 500;
        assert_ok(ost_segment_volume(&ct, &options, &labels, &segments, &count, &err));
        assert_int_equal(count, 1);
        assert_int_equal(segments[0].voxels, hole ? 29 : 30);
        ost_segments_free(segments);
        ost_volume_free(&labels);
    }
    ost_volume_free(&ct);
}

/* Tests a row of six voxels, of which three have a label. A position half-way between two voxels belongs to the
   first of them. */
static void labels_are_selected(void **state)
{
    (void)state;
    const ost_geometry g = {.dims = {6, 1, 1}, .spacing = {2 * OST_PM_PER_MM, OST_PM_PER_MM, OST_PM_PER_MM}};
    const int16_t densities[6] = {500, 0, 500, 0, 0, 500};
    const ost_pm centres[3] = {0, 4000000000, 10000000000};
    const struct {
        ost_pm x;
        int at, near;
    } rows[] = {{0, 1, 1}, {999999999, 1, 1}, {1000000000, 0, 1}, {2000000000, 0, 1}, {2000000001, 0, 2},
                {7000000000, 0, 2}, {7000000001, 0, 3}, {10999999999, 3, 3}, {11000000000, -1, 3}, {-1000000000, 1, 1},
                {-1000000001, -1, 1}, {-OST_LENGTH_MAX, -1, 1}, {OST_LENGTH_MAX, -1, 3}};
    ost_error err = {0};
    ost_volume ct, labels;
    ost_segment *segments;
    ost_pm3 found;
    size_t count;
    assert_ok(ost_volume_init(&ct, &g, &err));
    memcpy(ct.voxels, densities, sizeof densities);
    assert_ok(ost_segment_volume(&ct, NULL, &labels, &segments, &count, &err));
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        assert_int_equal(ost_segment_label_at(&labels, (ost_pm3){rows[i].x, 0, 0}), rows[i].at);
        assert_int_equal(ost_segment_label_near(&labels, (ost_pm3){rows[i].x, 0, 0}, &found), rows[i].near);
        assert_int_equal(found.x, centres[rows[i].near - 1]);
    }
    const bool keep[3] = {true, false, true};
    assert_ok(ost_segments_keep(&labels, segments, &count, keep, &err));
    const int16_t kept[6] = {1, 0, 0, 0, 0, 2};
    assert_int_equal(count, 2);
    assert_int_equal(segments[1].first[0], 5);
    assert_memory_equal(labels.voxels, kept, sizeof kept);
    const bool none[2] = {false, false};
    assert_ok(ost_segments_keep(&labels, segments, &count, none, &err));
    assert_int_equal(ost_segment_label_near(&labels, (ost_pm3){0, 0, 0}, &found), 0);
    ost_segments_free(segments);
    ost_volume_free(&labels);
    ost_volume_free(&ct);
}

static void depth_out_of_range(void **state)
{
    (void)state;
    const ost_pm wrong[3] = {-1, OST_PM_PER_MM / 1000 - 1, OST_SEGMENT_SEPARATE_MAX + 1};
    const ost_geometry g = {.dims = {2, 2, 2}, .spacing = {OST_PM_PER_MM, OST_PM_PER_MM, OST_PM_PER_MM}};
    ost_error err = {0};
    ost_volume ct, labels;
    ost_segment *segments;
    size_t count;
    assert_ok(ost_volume_init(&ct, &g, &err));
    for (int i = 0; i < 3; i++) {
        const ost_segment_options options = {.separate = wrong[i]};
        assert_int_equal(ost_segment_volume(&ct, &options, &labels, &segments, &count, &err), OST_ERR_RANGE);
        assert_non_null(strstr(err.text, "expected 0.001 to 65 mm"));
    }
    ost_volume_free(&ct);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pieces_equal_the_oracle),
        cmocka_unit_test(squares_with_a_bridge),
        cmocka_unit_test(large_distances),
        cmocka_unit_test(labels_are_selected),
        cmocka_unit_test(depth_out_of_range),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
