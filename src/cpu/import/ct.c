/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Converts samples to a rect grid (AR-CT-4 to AR-CT-6). The samples are processed in batches,
 * and each batch in two steps:
 *
 *   place    sample -> voxel or -1, and the sample's part of the report      any thread for any sample
 *   put      voxel <- density, duplicates in file order                      a range of voxels per thread
 *
 * In the second step, each thread reads the complete batch and processes the samples in
 * its range of voxels. Therefore one thread processes all samples of a voxel, in order.
 *
 * Quotients.  On each axis, the index of a voxel is RHE((p - o) / s), where p is the sample's position, o the origin
 * and s the spacing. The floor of the quotient is first estimated in floating point. The floor is then changed by 1 and
 * the remainder by s until 0 <= remainder < s, so that the result does not depend on the estimate. Finally, the
 * remainder is compared with s / 2 to round half to even (RHE).
 */
#include "core/conditions.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "cpu/import/grid.h"
#include "cpu/import/import.h"

/* The number of samples of a full batch is between BLOCK_MIN and BLOCK. */
enum { BLOCK = 1 << 16, BLOCK_MIN = 1 << 10 };

typedef struct axis {
    ost_pm origin, spacing;
    int64_t dim;
    double inverse;
} axis;

typedef struct axis_position {
    int64_t index;
    int64_t off; /* distance of the sample from the nearest lattice point, in picometres */
} axis_position;

/*
 * Finds the lattice point that is nearest to p on one axis. |p| and |origin| are at most 8 m < 2^43 pm, so
 * the difference and all products are below 2^45.
 */
static inline axis_position axis_position_of(const axis *a, ost_pm p)
{
    int64_t n = p - a->origin;
    int64_t q = (int64_t)((double)n * a->inverse);
    int64_t remainder = n - q * a->spacing;
    for (; remainder < 0; q--)
        remainder += a->spacing;
    for (; remainder >= a->spacing; q++)
        remainder -= a->spacing;
    int64_t other = a->spacing - remainder;
    bool up = remainder > other || (remainder == other && (q & 1));
    return up ? (axis_position){q + 1, other} : (axis_position){q, remainder};
}

static bool readable(const ost_sample *s)
{
    return s->x >= -OST_LENGTH_MAX && s->x <= OST_LENGTH_MAX && s->y >= -OST_LENGTH_MAX && s->y <= OST_LENGTH_MAX &&
           s->z >= -OST_LENGTH_MAX && s->z <= OST_LENGTH_MAX;
}

static bool before(int64_t line, int64_t recorded)
{
    return recorded == 0 || line < recorded;
}

static void reject(int64_t line, ost_scatter_report *report)
{
    if (before(line, report->rejected_line))
        report->rejected_line = line;
}

/*
 * Updates the worst offset in the report with the offset of one sample. In picometres, off * 10^6 <= 5 * 10^10 * 10^6 <
 * 2^56 and worst * spacing <= 5 * 10^5 * 10^11 < 2^56.
 */
static void note_worst(const axis axes[3], const axis_position at[3], int64_t line, ost_scatter_report *report)
{
    for (int a = 0; a < 3; a++) {
        if (at[a].off * 1000000 < (int64_t)report->worst_offset_ppm * axes[a].spacing)
            continue;
        uint64_t ppm = (uint64_t)(at[a].off * 1000000 / axes[a].spacing);
        if (ppm > report->worst_offset_ppm ||
            (ppm > 0 && ppm == report->worst_offset_ppm && before(line, report->worst_line))) {
            report->worst_offset_ppm = ppm;
            report->worst_line = line;
        }
    }
}

static bool beyond(const axis axes[3], const axis_position at[3], int eighths)
{
    return 8 * at[0].off > eighths * axes[0].spacing || 8 * at[1].off > eighths * axes[1].spacing ||
           8 * at[2].off > eighths * axes[2].spacing;
}

/* Returns the index of the voxel nearest to the sample, or -1 if the sample is rejected. */
static int64_t place_sample(const axis axes[3], const ost_sample *sample, int64_t line, ost_scatter_report *report)
{
    if (!readable(sample)) {
        reject(line, report);
        return -1;
    }
    const axis_position at[3] = {axis_position_of(&axes[0], sample->x), axis_position_of(&axes[1], sample->y),
                                 axis_position_of(&axes[2], sample->z)};
    note_worst(axes, at, line, report);
    if (beyond(axes, at, 1)) {
        report->off_lattice++;
        if (beyond(axes, at, 3)) {
            reject(line, report);
            return -1;
        }
    }
    for (int a = 0; a < 3; a++)
        if (at[a].index < 0 || at[a].index >= axes[a].dim) {
            reject(line, report);
            return -1;
        }
    return at[0].index + axes[0].dim * (at[1].index + axes[1].dim * at[2].index);
}

/* Handles a sample whose voxel already has a sample (AR-CT-6). Two samples with equal densities are never a
   conflict, regardless of `duplicates`. */
static void meet_again(int16_t *voxel, int16_t density, int64_t line, ost_duplicates duplicates,
                       ost_scatter_report *report)
{
    report->duplicates++;
    if (duplicates == OST_DUPLICATES_ERROR && density != *voxel && before(line, report->conflict_line)) {
        report->conflict_line = line;
        report->conflict_had = *voxel;
        report->conflict_has = density;
    }
    if (duplicates == OST_DUPLICATES_LAST || (duplicates == OST_DUPLICATES_MAX && density > *voxel))
        *voxel = density;
}

static void put(cpu_grid *grid, int64_t v, const ost_sample *sample, int64_t line, ost_duplicates duplicates,
                ost_scatter_report *report)
{
    uint8_t bit = (uint8_t)(1u << (v % 8));
    int16_t *voxel = &grid->store->voxels[v];
    if (grid->seen[v / 8] & bit) {
        meet_again(voxel, (int16_t)sample->density, line, duplicates, report);
    } else {
        grid->seen[v / 8] |= bit;
        *voxel = (int16_t)sample->density;
    }
}

/*
 * The report of one thread. `conflict` is the index, within the batch, of the conflicting sample in line
 * sums.conflict_line. If this line has several conflicting samples, `conflict` is the lowest of their indices.
 */
typedef struct part_report {
    ost_scatter_report sums;
    int conflict;
} part_report;

/*
 * Merges the report of one thread into *to: adds the counts, keeps the lower line numbers of rejected and conflicting
 * samples, and keeps the line with the greater offset. *conflict is the index in the batch of the conflicting sample
 * whose line is in *to, or -1 if that sample is in an earlier batch.
 */
static void merge(ost_scatter_report *to, int *conflict, const part_report *from)
{
    const ost_scatter_report *part = &from->sums;
    to->duplicates += part->duplicates;
    to->off_lattice += part->off_lattice;
    if (part->worst_offset_ppm > to->worst_offset_ppm ||
        (part->worst_offset_ppm == to->worst_offset_ppm && part->worst_line &&
         before(part->worst_line, to->worst_line))) {
        to->worst_offset_ppm = part->worst_offset_ppm;
        to->worst_line = part->worst_line;
    }
    if (part->rejected_line)
        reject(part->rejected_line, to);
    bool earlier = part->conflict_line == to->conflict_line && from->conflict < *conflict;
    if (part->conflict_line && (earlier || before(part->conflict_line, to->conflict_line))) {
        *conflict = from->conflict;
        to->conflict_line = part->conflict_line;
        to->conflict_had = part->conflict_had;
        to->conflict_has = part->conflict_has;
    }
}

typedef struct batch {
    cpu_grid *grid;
    axis axes[3];
    int64_t voxels, first_line;
    ost_duplicates duplicates;
    /* index of the voxel of each sample in the batch, or -1 if the sample is rejected; BLOCK elements */
    int64_t *at;
} batch;

static void scatter(const batch *b, ost_team *team, const ost_sample *samples, int count, ost_scatter_report *report)
{
    const int threads = team->threads;
    int conflict = -1;
    report->samples += (uint64_t)count;
#pragma omp parallel num_threads(threads)
    {
        part_report mine = {0};
        (void)ost_team_join(team);
#pragma omp for schedule(static)
        for (int i = 0; i < count; i++)
            b->at[i] = place_sample(b->axes, &samples[i], b->first_line + samples[i].line, &mine.sums);
        /* Each range of voxels ends at a multiple of 8, so each byte of `seen` is written by only one thread. */
#pragma omp for schedule(static, 1) nowait
        for (int part = 0; part < threads; part++) {
            int64_t each = (b->voxels / threads / 8 + 1) * 8, lo = each * part, hi = lo + each;
            for (int i = 0; i < count; i++)
                if (b->at[i] >= lo && b->at[i] < hi) {
                    int64_t had = mine.sums.conflict_line;
                    put(b->grid, b->at[i], &samples[i], b->first_line + samples[i].line, b->duplicates, &mine.sums);
                    if (mine.sums.conflict_line != had)
                        mine.conflict = i;
                }
        }
#pragma omp critical
        merge(report, &conflict, &mine);
    }
}

static axis axis_of(ost_pm origin, ost_pm spacing, int32_t dim)
{
    return (axis){origin, spacing, dim, 1.0 / (double)spacing};
}

ost_status ost_cpu_ct_to_rect(ost_grid *rect, const ost_sample *samples, size_t count, int64_t first_line,
                              ost_duplicates duplicates, ost_scatter_report *report, ost_error *err)
{
    cpu_grid *grid = (cpu_grid *)rect;
    const cpu_backend *backend = (const cpu_backend *)rect->backend;
    const ost_geometry *g = &rect->geometry;
    batch b = {
        .grid = grid,
        .axes = {axis_of(g->origin.x, g->spacing.x, g->dims.x), axis_of(g->origin.y, g->spacing.y, g->dims.y),
                 axis_of(g->origin.z, g->spacing.z, g->dims.z)},
        .voxels = ost_dims_count(g->dims),
        .first_line = first_line,
        .duplicates = duplicates,
    };
    ost_status status = ost_cpu_grid_own(grid, err);
    if (status != OST_OK)
        return status;
    if (!grid->seen && !(grid->seen = calloc((size_t)(b.voxels + 7) / 8, 1)))
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for the set of voxels that have a value (%lld bytes)",
                        (long long)(b.voxels + 7) / 8);
    b.at = malloc(BLOCK * sizeof *b.at);
    if (!b.at)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory to place %d samples", (int)BLOCK);
    const int64_t most = backend->sharing->least[OST_PATH_BLOCKS] - 1;
    const size_t block = (size_t)(most < BLOCK_MIN ? BLOCK_MIN : most > BLOCK ? BLOCK : most);
    if (count > block)
        ost_cpu_enters(backend->sharing, OST_PATH_BLOCKS, INT64_MAX);
    while (count > 0) {
        const int part = (int)(count < block ? count : block);
        ost_team team = ost_team_of(backend->sharing, backend->threads, OST_PATH_SCATTER, part, part, 0);
        scatter(&b, &team, samples, part, report);
        ost_team_end(backend->sharing, &team);
        samples += part;
        count -= (size_t)part;
    }
    free(b.at);
    return OST_OK;
}
