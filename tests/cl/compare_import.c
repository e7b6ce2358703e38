/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Compares the import kernels with the reference. The tests compare rect grids and their reports, cubic grids, and
 * chunks (word by word).
 */
#include "cl/machine.h"

#include "core/backend.h"
#include "core/chunk_grid.h"
#include "core/integer.h"
#include "cpu/ref/ref.h"

static ost_backend *open_ref(void)
{
    ost_error err = {0};
    ost_backend *ref;
    assert_ok(ost_backend_open("ref", &ref, &err));
    return ref;
}

static void *zeros(size_t count, size_t size)
{
    void *p = calloc(count ? count : 1, size);
    assert_non_null(p);
    return p;
}

/* -------------------------------------------------------------- scatter */

_Static_assert(sizeof(ost_sample) == sizeof(ost_cl_sample) &&
                   offsetof(ost_sample, density) == offsetof(ost_cl_sample, density) &&
                   offsetof(ost_sample, line) == offsetof(ost_cl_sample, line),
               "a batch goes to the device as it is");

static bool before(int64_t line, int64_t recorded)
{
    return recorded == 0 || line < recorded;
}

/* Adds the report of a batch to a total, by the rules in shared.h. */
static void add_report(ost_scatter_report *to, const ost_cl_scatter_report *part, const ost_sample *samples,
                       size_t count, int64_t first_line)
{
    to->samples += count;
    to->duplicates += part->duplicates;
    to->off_lattice += part->off_lattice;
    const int64_t worst = first_line + part->worst_line, rejected = first_line + part->rejected_line;
    if (part->worst_ppm > to->worst_offset_ppm ||
        (part->worst_ppm > 0 && part->worst_ppm == to->worst_offset_ppm && before(worst, to->worst_line))) {
        to->worst_offset_ppm = part->worst_ppm;
        to->worst_line = worst;
    }
    if (part->rejected_line != OST_CL_NONE && before(rejected, to->rejected_line))
        to->rejected_line = rejected;
    const int64_t conflict = first_line + part->conflict_line;
    if (part->conflict_line != OST_CL_NONE && before(conflict, to->conflict_line)) {
        to->conflict_line = conflict;
        to->conflict_had = (int16_t)part->conflict_had;
        to->conflict_has = (int16_t)samples[part->conflict_index].density;
    }
}

typedef struct scatter_grid {
    ost_geometry geometry;
    size_t voxels;
    uint32_t *seen, *owner;
    int16_t *density;
} scatter_grid;

static void scatter_batch(machine *m, const scatter_grid *g, const ost_sample *samples, size_t count,
                          int64_t first_line, ost_duplicates duplicates, ost_scatter_report *report)
{
    const ost_geometry *geometry = &g->geometry;
    const ost_cl_scatter scatter = {
        .origin = {geometry->origin.x, geometry->origin.y, geometry->origin.z},
        .spacing = {geometry->spacing.x, geometry->spacing.y, geometry->spacing.z},
        .dims = {geometry->dims.x, geometry->dims.y, geometry->dims.z},
        .duplicates = (int)duplicates,
        .count = (uint32_t)count,
    };
    ost_cl_scatter_report part = {.worst_line = OST_CL_NONE,
                                  .rejected_line = OST_CL_NONE,
                                  .conflict_line = OST_CL_NONE,
                                  .conflict_index = OST_CL_NONE};
    const kernel_arg s = ONE(&scatter), b = BUFFER(samples, count), seen = BUFFER(g->seen, (g->voxels + 31) / 32),
                     owner = BUFFER(g->owner, g->voxels), voxels = BUFFER(g->density, g->voxels), r = ONE(&part);
    LAUNCH(m, ost_ct_claim, count, 1, 1, s, b, seen, owner, r);
    LAUNCH(m, ost_ct_place, count, 1, 1, s, b, seen, owner, voxels, r);
    LAUNCH(m, ost_ct_check, count, 1, 1, s, b, seen, owner, voxels, r);
    if (part.conflict_line != OST_CL_NONE) {
        LAUNCH(m, ost_ct_report_first_bad, count, 1, 1, s, b, voxels, r);
        LAUNCH(m, ost_ct_had, 1, 1, 1, s, b, voxels, r);
    }
    add_report(report, &part, samples, count, first_line);
    for (size_t v = 0; v < g->voxels; v++)
        assert_int_equal(g->owner[v], 0);
}

/*
 * Returns a random coordinate: on the lattice, at a random distance from the lattice, outside the grid, or
 * beyond the range of lengths.
 */
static int64_t some_coordinate(test_rng *rng, ost_pm origin, ost_pm spacing, int32_t n, bool clean)
{
    const int64_t at = origin + rng_range(rng, 0, n - 1) * spacing;
    switch (clean ? 0 : rng_range(rng, 0, 40)) {
    case 0: return at + rng_range(rng, -spacing / 2, spacing / 2);
    case 1: return at + rng_range(rng, -spacing / 8, spacing / 8) / 8 * 8;
    case 2: return origin + rng_range(rng, -2, n + 2) * spacing;
    case 3: return rng_range(rng, INT64_MIN, INT64_MAX);
    case 4: return rng_range(rng, 0, 1) ? OST_LENGTH_MAX : -OST_LENGTH_MAX - rng_range(rng, 0, 1);
    case 5: return at + 3 * (spacing / 8);
    case 6: return at - spacing / 8;
    default: return at;
    }
}

static void scatter_round(machine *m, test_rng *rng, ost_backend *ref)
{
    ost_error err = {0};
    scatter_grid g = {
        .geometry = {
            .dims = {(int32_t)rng_range(rng, 1, 12), (int32_t)rng_range(rng, 1, 12), (int32_t)rng_range(rng, 1, 9)},
            .spacing = {rng_range(rng, 1000000, 3000000), 470000000, rng_range(rng, 1, 80) * 1000000},
            .origin = {rng_range(rng, -8000, 6800) * OST_PM_PER_MM, -57340000000, rng_range(rng, -5, 5)},
        }};
    if (rng_range(rng, 0, 9) == 0)
        g.geometry.spacing = (ost_pm3){OST_SPACING_MAX, OST_SPACING_MIN, 8};
    if (g.geometry.spacing.z < OST_SPACING_MIN)
        g.geometry.spacing.z = OST_SPACING_MIN;
    g.voxels = (size_t)ost_dims_count(g.geometry.dims);
    g.seen = zeros((g.voxels + 31) / 32, 4);
    g.owner = zeros(g.voxels, 4);
    g.density = zeros(g.voxels, 2);
    ost_grid *expected;
    assert_ok(ost_grid_create(ref, &g.geometry, &expected, &err));
    ost_scatter_report report = {0}, expected_report = {0};

    const int batches = (int)rng_range(rng, 1, 3);
    ost_duplicates duplicates = (ost_duplicates)rng_range(rng, 0, 3);
    const bool clean = rng_range(rng, 0, 2) == 0, mixed = rng_range(rng, 0, 4) == 0;
    int64_t line = 1;
    for (int b = 0; b < batches; b++) {
        const size_t count = (size_t)rng_range(rng, 1, m->small ? 60 : 400);
        ost_sample *samples = zeros(count, sizeof *samples);
        /* The densities are from the complete range of int16, or only from -3 to 2. */
        const int spread = rng_range(rng, 0, 1) ? 32767 : 2;
        for (size_t i = 0; i < count; i++) {
            samples[i].x = some_coordinate(rng, g.geometry.origin.x, g.geometry.spacing.x, g.geometry.dims.x, clean);
            samples[i].y = some_coordinate(rng, g.geometry.origin.y, g.geometry.spacing.y, g.geometry.dims.y, clean);
            samples[i].z = some_coordinate(rng, g.geometry.origin.z, g.geometry.spacing.z, g.geometry.dims.z, clean);
            samples[i].density = (int32_t)rng_range(rng, -spread - 1, spread);
            /* In a mixed batch, several samples may have the same line. */
            samples[i].line = (uint32_t)(mixed ? rng_range(rng, 0, 20) : (int64_t)i);
        }
        if (mixed)
            duplicates = (ost_duplicates)rng_range(rng, 0, 3);
        assert_ok(ost_ct_to_rect(expected, samples, count, line, duplicates, &expected_report, &err));
        scatter_batch(m, &g, samples, count, line, duplicates, &report);
        line += (int64_t)count;
        free(samples);
    }
    if (memcmp(g.density, ((ref_grid *)expected)->voxels, g.voxels * 2) != 0)
        fail_msg("%s: the rect grid differs from the reference", m->name);
    for (size_t v = 0; v < g.voxels; v++)
        assert_int_equal(g.seen[v / 32] >> (v % 32) & 1, ((ref_grid *)expected)->seen[v / 8] >> (v % 8) & 1);
    assert_int_equal(report.samples, expected_report.samples);
    assert_int_equal(report.duplicates, expected_report.duplicates);
    assert_int_equal(report.off_lattice, expected_report.off_lattice);
    assert_int_equal(report.worst_offset_ppm, expected_report.worst_offset_ppm);
    assert_int_equal(report.worst_line, expected_report.worst_line);
    assert_int_equal(report.rejected_line, expected_report.rejected_line);
    assert_int_equal(report.conflict_line, expected_report.conflict_line);
    assert_int_equal(report.conflict_had, expected_report.conflict_had);
    assert_int_equal(report.conflict_has, expected_report.conflict_has);
    ost_grid_free(expected);
    free(g.seen);
    free(g.owner);
    free(g.density);
}

void compare_scatter(machine *m, test_rng *rng, int rounds)
{
    ost_backend *ref = open_ref();
    for (int i = 0; i < rounds; i++)
        scatter_round(m, rng, ref);
    ost_backend_close(ref);
}

/* ---------------------------------------------------------------- cubic */

void compare_cubic(machine *m, test_rng *rng, int rounds)
{
    static const ost_pm steps[] = {470000000, 1000000000, 333333333, 300000000, 2900000000, 488281250, OST_SPACING_MAX};
    ost_error err = {0};
    ost_backend *ref = open_ref();
    const int32_t most = m->small ? 5 : 20;
    for (int i = 0; i < rounds; i++) {
        const ost_geometry geometry = {
            .dims = {(int32_t)rng_range(rng, 1, most), (int32_t)rng_range(rng, 1, most),
                     (int32_t)rng_range(rng, 1, most)},
            .spacing = {steps[rng_range(rng, 0, 5)], steps[rng_range(rng, 0, 5)], steps[rng_range(rng, 0, 5)]},
        };
        const ost_pm cubic_spacing = steps[rng_range(rng, 0, rng_range(rng, 0, 9) ? 5 : 6)];
        const ost_resample rule = (ost_resample)rng_range(rng, 0, 2);
        const size_t count = (size_t)ost_dims_count(geometry.dims);
        ost_grid *rect, *expected;
        int16_t *voxels = zeros(count, 2);
        for (size_t v = 0; v < count; v++)
            voxels[v] = (int16_t)rng_range(rng, INT16_MIN, INT16_MAX);
        assert_ok(ost_grid_create(ref, &geometry, &rect, &err));
        assert_ok(ost_grid_upload(rect, 0, geometry.dims.z, voxels, &err));
        assert_ok(ost_rect_to_cubic(rect, cubic_spacing, rule, &expected, &err));
        const ost_dims d = ost_grid_geometry(expected)->dims;
        const size_t slice = (size_t)d.x * (size_t)d.y;
        ost_cl_cubic cubic = {
            .rect_spacing = {geometry.spacing.x, geometry.spacing.y, geometry.spacing.z},
            .cubic_spacing = {cubic_spacing, cubic_spacing, cubic_spacing},
            .rect_dims = {geometry.dims.x, geometry.dims.y, geometry.dims.z},
            .dims = {d.x, d.y, d.z},
            .rule = (int)rule,
        };
        const size_t axes = (size_t)d.x + (size_t)d.y + (size_t)d.z;
        int32_t *sources = zeros(2 * axes, 4);
        LAUNCH(m, ost_cubic_sources, axes, 1, 1, ONE(&cubic), BUFFER(sources, 2 * axes));
        int16_t *out = zeros(slice * (size_t)d.z, 2);
        const int32_t middle = (int32_t)rng_range(rng, 0, d.z);
        cubic.slab = (int32_t)rng_range(rng, 0, 1);
        for (int part = 0; part < 2; part++) {
            cubic.z0 = part ? middle : 0;
            cubic.z1 = part ? d.z : middle;
            const size_t from = cubic.slab ? slice * (size_t)cubic.z0 : 0;
            const size_t size = cubic.slab ? slice * (size_t)(cubic.z1 - cubic.z0) : slice * (size_t)d.z;
            if (cubic.z1 > cubic.z0 && rule == OST_RESAMPLE_LINEAR)
                LAUNCH(m, ost_cubic_linear, d.x, d.y, cubic.z1 - cubic.z0, ONE(&cubic), BUFFER(sources, 2 * axes),
                       BUFFER(voxels, count), BUFFER(out + from, size));
            else if (cubic.z1 > cubic.z0)
                LAUNCH(m, ost_cubic_gather, d.x, d.y, cubic.z1 - cubic.z0, ONE(&cubic), BUFFER(sources, 2 * axes),
                       BUFFER(voxels, count), BUFFER(out + from, size));
        }
        if (memcmp(out, ((ref_grid *)expected)->voxels, slice * (size_t)d.z * 2) != 0)
            fail_msg("%s: the cubic grid differs from the reference", m->name);
        free(out);
        free(sources);
        free(voxels);
        ost_grid_free(rect);
        ost_grid_free(expected);
    }
    ost_backend_close(ref);
}

/* --------------------------------------------------------------- chunks */

typedef struct pool {
    ost_cl_bone bone;
    size_t chunks, used, voxels; /* number of chunks, of chunks in use, and of voxels per chunk */
    uint32_t *slots, *words;
    int16_t *density;
} pool;

typedef struct slab {
    int32_t z0, z1, first, weights;
    int16_t *voxels; /* The slab owns `voxels` and `layers`. */
    int32_t *layers;
    size_t count, layer_count;
} slab;

/*
 * Makes a slab of slices z0 <= k < z1 of a grid. If `first` is negative, the slab stores its slices in order.
 * Otherwise, it has a list of slices, which begins at element `first`, and a slice that equals the previous slice is
 * stored only once.
 */
static slab slab_of(const int16_t *voxels, size_t slice, int32_t z0, int32_t z1, int32_t first)
{
    slab s = {.z0 = z0,
              .z1 = z1,
              .first = first,
              .weights = -1,
              .layer_count = (size_t)(z1 - z0) + (size_t)(first < 0 ? 1 : first)};
    s.voxels = zeros(slice * (size_t)(z1 - z0) + 1, 2);
    s.layers = zeros(s.layer_count + 1, 4);
    int32_t kept = 0;
    for (int32_t k = z0; k < z1; k++) {
        const int16_t *from = voxels + slice * (size_t)k;
        if (first < 0 || k == z0 || memcmp(from, from - slice, slice * 2) != 0)
            memcpy(s.voxels + slice * (size_t)kept++, from, slice * 2);
        if (first >= 0)
            s.layers[first + k - z0] = kept - 1;
    }
    s.count = slice * (size_t)kept + (kept == 0);
    s.layer_count += s.layer_count == 0;
    return s;
}

/*
 * Makes a slab that stores random slices. Stores the weighted means of these slices (AR-CUB-2) in
 * the slices z0 <= k < z1 of `voxels`.
 */
static slab slab_between(test_rng *rng, int16_t *voxels, size_t slice, int32_t z0, int32_t z1, int32_t first)
{
    const int32_t count = z1 - z0, own = 2 + count / 2;
    slab s = {.z0 = z0,
              .z1 = z1,
              .first = first,
              .weights = first + count + 1,
              .layer_count = (size_t)(first + 2 * count + 2)};
    s.count = slice * (size_t)own;
    s.voxels = zeros(s.count, 2);
    s.layers = zeros(s.layer_count, 4);
    for (size_t v = 0; v < s.count; v++)
        s.voxels[v] =
            voxels[(size_t)rng_range(rng, 0, (int64_t)slice - 1) + slice * (size_t)rng_range(rng, z0, z1 - 1)];
    int32_t at = 0;
    for (int32_t k = 0; k < count; k++) {
        at += (int32_t)rng_range(rng, 0, at + 1 < own);
        const int32_t choices[] = {0, 1, 16384, 32767, 32768, (int32_t)rng_range(rng, 0, 32768)};
        const int32_t weight = at + 1 < own ? choices[rng_range(rng, 0, 5)] : 0;
        s.layers[first + k] = at;
        s.layers[s.weights + k] = weight;
        for (size_t v = 0; v < slice; v++) {
            const int64_t upper = weight > 0 ? s.voxels[slice * (size_t)(at + 1) + v] : 0;
            const int64_t sum = s.voxels[slice * (size_t)at + v] * (INT64_C(32768) - weight) + upper * weight;
            voxels[slice * (size_t)(z0 + k) + v] = (int16_t)ost_rhe_div(sum, 32768);
        }
    }
    return s;
}

static void chunks_round(machine *m, test_rng *rng)
{
    ost_error err = {0};
    const int most = m->small ? 20 : rng_range(rng, 0, 5) ? 40 : 100;
    const ost_dims d = {(int32_t)rng_range(rng, 1, most), (int32_t)rng_range(rng, 1, most),
                        (int32_t)rng_range(rng, 1, most)};
    const int n = 16 << rng_range(rng, 0, m->small ? 1 : 2);
    const int32_t threshold = (int32_t)(rng_range(rng, 0, 2) ? 120 : rng_range(rng, 1, 32767));
    const size_t count = (size_t)ost_dims_count(d), slice = (size_t)d.x * (size_t)d.y;
    /* The voxels consist of runs of random length. Runs of kind 0 are empty. In the other runs, about `solid` out of
       every 21 voxels are active. */
    const int solid = (int)rng_range(rng, 0, 20);
    int16_t *voxels = zeros(count, 2);
    for (size_t v = 0, left = 0, kind = 0; v < count; v++, left--) {
        if (left == 0) {
            left = (size_t)rng_range(rng, 1, 2000);
            kind = (size_t)rng_range(rng, 0, 2);
        }
        voxels[v] = (int16_t)(kind == 0                       ? 0
                              : rng_range(rng, 0, 20) < solid ? rng_range(rng, threshold, 32767)
                                                              : rng_range(rng, -32768, threshold));
    }
    ost_chunk_grid grid;
    for (int32_t k = 1; k < d.z; k++) /* Makes some slices equal to the previous slice. */
        if (rng_range(rng, 0, 2) == 0)
            memcpy(voxels + slice * (size_t)k, voxels + slice * (size_t)(k - 1), slice * 2);
    /* The volume is uploaded as one slab, or as two slabs that meet at a random slice. A slab stores its slices in one
       of three ways: in order; with a list, so that equal slices are stored only once; or with a list and weights, so
       that each slice is the weighted mean of two stored slices. */
    const int32_t ends[3] = {0, (int32_t)rng_range(rng, 0, d.z), d.z};
    const int how = (int)rng_range(rng, 0, 2);
    const int32_t lead = (int32_t)rng_range(rng, 0, 3); /* number of unused elements before the list of slices */
    slab slabs[2];
    for (int part = 0; part < 2; part++)
        slabs[part] = how == 2 && ends[part] < ends[part + 1]
                          ? slab_between(rng, voxels, slice, ends[part], ends[part + 1], lead)
                          : slab_of(voxels, slice, ends[part], ends[part + 1], how ? lead : -1);
    assert_ok(ost_chunk_grid_init(&grid, d, n, threshold, &err));
    assert_ok(ost_chunk_grid_upload(&grid, 0, d.z, voxels, &err));

    pool p = {.bone = {.dims = {d.x, d.y, d.z}, .size = n, .threshold = threshold},
              .voxels = (size_t)n * (size_t)n * (size_t)n};
    p.bone.chunk_dims[0] = grid.chunk_dims.x;
    p.bone.chunk_dims[1] = grid.chunk_dims.y;
    p.bone.chunk_dims[2] = grid.chunk_dims.z;
    p.chunks = (size_t)grid.count;
    p.slots = zeros(p.chunks, 4);
    uint32_t *active = zeros(p.chunks, 4);
    const int32_t columns = grid.chunk_dims.x * grid.chunk_dims.y;
    const bool by_items = m->brief || rng_range(rng, 0, 1);
    for (int part = 0; part < 2; part++) {
        const slab *s = &slabs[part];
        const kernel_arg args[] = {ONE(&p.bone),
                                   number_arg(s->z0),
                                   number_arg(s->z1),
                                   number_arg(s->first),
                                   number_arg(s->weights),
                                   BUFFER(s->layers, s->layer_count),
                                   BUFFER(s->voxels, s->count),
                                   BUFFER(active, p.chunks)};
        if (s->z0 < s->z1 && by_items)
            m->launch(m, K_ost_chunk_scan, args, 8, (const size_t[3]){(size_t)(s->z1 - s->z0), (size_t)columns, 1});
        else if (s->z0 < s->z1)
            m->launch(m, K_ost_chunk_scan_layers, args, 8,
                      (const size_t[3]){(size_t)grid.chunk_dims.y, (size_t)grid.chunk_dims.z, 1});
    }
    for (size_t c = 0; c < p.chunks; c++)
        p.slots[c] = active[c] > 0 ? (uint32_t)p.used++ : OST_CL_NONE;
    const size_t capacity = p.used ? p.used : 1;
    p.density = zeros(capacity * p.voxels, 2);
    p.words = zeros(capacity * p.voxels / 32, 4);
    if (!by_items) { /* ost_chunk_store_layers must write every element of a slot. */
        memset(p.density, 0x55, capacity * p.voxels * 2);
        memset(p.words, 0x55, capacity * p.voxels / 8);
    }
    for (int part = 0; part < 2; part++) {
        const slab *s = &slabs[part];
        const kernel_arg args[] = {ONE(&p.bone),
                                   number_arg(s->z0),
                                   number_arg(s->z1),
                                   number_arg(s->first),
                                   number_arg(s->weights),
                                   BUFFER(s->layers, s->layer_count),
                                   BUFFER(s->voxels, s->count),
                                   BUFFER(p.slots, p.chunks),
                                   BUFFER(p.density, capacity * p.voxels),
                                   BUFFER(p.words, capacity * p.voxels / 32)};
        if (s->z0 < s->z1 && by_items)
            m->launch(m, K_ost_chunk_store, args, 10,
                      (const size_t[3]){(size_t)(n * n / 32), (size_t)columns, (size_t)(s->z1 - s->z0)});
        else if (s->z0 < s->z1)
            m->launch(m, K_ost_chunk_store_layers, args, 10,
                      (const size_t[3]){(size_t)columns, (size_t)grid.chunk_dims.z, 1});
        free(s->voxels);
        free(s->layers);
    }

    uint32_t next = 0, *counted = zeros(capacity, 4);
    if (p.used)
        LAUNCH(m, ost_chunk_count, n, p.used, 1, ONE(&p.bone), number_arg(0), number_arg((int64_t)p.used),
               BUFFER(p.words, p.used * p.voxels / 32), BUFFER(counted, p.used));
    for (size_t c = 0; c < p.chunks; c++) {
        const ost_chunk *chunk = &grid.chunks[c];
        assert_int_equal(active[c], chunk->active);
        assert_int_equal(p.slots[c], chunk->density ? next : OST_CL_NONE);
        if (!chunk->density)
            continue;
        assert_int_equal(counted[next], chunk->active);
        if (memcmp(p.density + next * p.voxels, chunk->density, p.voxels * 2) != 0 ||
            memcmp(p.words + next * p.voxels / 32, chunk->occupancy, p.voxels / 8) != 0)
            fail_msg("%s: chunk %zu of %d^3 voxels differs from the reference", m->name, c, n);
        next++;
    }
    assert_int_equal(next, p.used);

    int16_t *stored = zeros(count, 2), *loaded = zeros(count, 2);
    ost_chunk_grid_download(&grid, 0, d.z, stored);
    memset(loaded, 0x5a, count * 2);
    for (int part = 0; part < 2; part++) {
        const size_t slices = (size_t)(ends[part + 1] - ends[part]);
        const kernel_arg args[] = {ONE(&p.bone),
                                   number_arg(ends[part]),
                                   number_arg(ends[part + 1]),
                                   BUFFER(p.slots, p.chunks),
                                   BUFFER(p.density, capacity * p.voxels),
                                   BUFFER(loaded + slice * (size_t)ends[part], slice * slices)};
        if (slices && by_items)
            m->launch(m, K_ost_chunk_load, args, 6, (const size_t[3]){(size_t)d.x, (size_t)d.y, slices});
        else if (slices)
            m->launch(m, K_ost_chunk_load_rows, args, 6, (const size_t[3]){(size_t)grid.chunk_dims.y, slices, 1});
    }
    if (memcmp(stored, loaded, count * 2) != 0)
        fail_msg("%s: slices read from chunks of %d^3 voxels differ from the volume", m->name, n);
    ost_chunk_grid_free(&grid);
    free(voxels);
    free(stored);
    free(loaded);
    free(active);
    free(counted);
    free(p.slots);
    free(p.density);
    free(p.words);
}

void compare_chunks(machine *m, test_rng *rng, int rounds)
{
    for (int i = 0; i < rounds; i++)
        chunks_round(m, rng);
}
