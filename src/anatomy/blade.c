/* SPDX-License-Identifier: Apache-2.0 */
#include "core/conditions.h"

#include "anatomy/blade.h"

#include <math.h>
#include <stdlib.h>

#include "core/fit.h"
#include "core/vector.h"

enum {
    CELLS_MAX = 1 << 21, /* maximum number of cells; a scapula has about 40,000 cells of 1.5 mm */
    BINS = 50,
    ROWS = 60,
    /* the bins [MIDDLE_LO, MIDDLE_HI) are 30 to 72 mm medial of the face, where the spine is always prominent */
    MIDDLE_LO = 10,
    MIDDLE_HI = 24,
    STRAY_ROWS = 3  /* maximum difference in rows between the crest's positions in neighbouring bins */
};
/* width of a bin in the medial direction; ROW_MM is the width of a row in the superior direction */
#define BIN_MM 3.0
#define ROW_MM 2.0
#define VALLEY_MM 24.0
/* minimum share of bone in a cell of the blade; the value is low, so that a plate 2 mm thick has no holes */
#define CELL_SHARE 0.3f
#define NONE (-1e9)
#define PROMINENT_MM 2.0 /* minimum prominence that counts as the spine */

/* The coordinate frame of the blade. Its origin is the centre of the glenoid's face. */
typedef struct frame {
    double origin[3], medial[3], superior[3], normal[3];
} frame;

/* ------------------------------------------------------------------- cells */

ost_status ost_anatomy_cells_make(const anatomy_field *f, anatomy_cells *out, ost_error *err)
{
    const size_t cells = (size_t)f->n[0] * (size_t)f->n[1] * (size_t)f->n[2];
    size_t count = 0;
    for (size_t i = 0; i < cells; i++)
        count += f->share[i] >= CELL_SHARE;
    *out = (anatomy_cells){.at = NULL};
    if (count > CELLS_MAX)
        return ost_fail(err, OST_ERR_INPUT, "the bone fills %zu cells of %.2g mm; expected one scapula, at most %d",
                        count, f->step[0], CELLS_MAX);
    *out = (anatomy_cells){.at = malloc((count + 1) * sizeof *out->at)};
    if (!out->at)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %zu cells", count);
    int32_t c[3];
    size_t i = 0;
    for (c[2] = 0; c[2] < f->n[2]; c[2]++)
        for (c[1] = 0; c[1] < f->n[1]; c[1]++)
            for (c[0] = 0; c[0] < f->n[0]; c[0]++, i++) {
                if (f->share[i] < CELL_SHARE)
                    continue;
                for (int a = 0; a < 3; a++)
                    out->at[out->count][a] = f->origin[a] + c[a] * f->step[a];
                out->count++;
            }
    return OST_OK;
}

void ost_anatomy_cells_free(anatomy_cells *cells)
{
    free(cells->at);
    *cells = (anatomy_cells){.at = NULL};
}

/* Returns the distance from the point `from` to the farthest cell, and stores this cell's index in *index. */
static double farthest_cell(const anatomy_cells *cells, const double from[3], size_t *index)
{
    double most = -1;
    for (size_t i = 0; i < cells->count; i++) {
        const double d[3] = {cells->at[i][0] - from[0], cells->at[i][1] - from[1], cells->at[i][2] - from[2]};
        const double square = ost_vector_dot(d, d);
        if (square > most) {
            most = square;
            *index = i;
        }
    }
    return most > 0 ? sqrt(most) : 0;
}

/* ------------------------------------------------------------------- frame */

static void to_frame(const frame *f, const double p[3], double out[3])
{
    const double d[3] = {p[0] - f->origin[0], p[1] - f->origin[1], p[2] - f->origin[2]};
    out[0] = ost_vector_dot(d, f->medial);
    out[1] = ost_vector_dot(d, f->superior);
    out[2] = ost_vector_dot(d, f->normal);
}

/*
 * Makes the medial and the superior direction perpendicular to the normal. The medial direction is the one
 * closest to the inward axis; the superior direction points away from the inferior angle.
 */
static void align(frame *f, const double inward[3], const double inferior[3])
{
    const double along = ost_vector_dot(inward, f->normal);
    for (int a = 0; a < 3; a++)
        f->medial[a] = inward[a] - along * f->normal[a];
    (void)ost_vector_unit(f->medial, 0);
    ost_vector_cross(f->normal, f->medial, f->superior);
    const double d[3] = {inferior[0] - f->origin[0], inferior[1] - f->origin[1], inferior[2] - f->origin[2]};
    const double sign = ost_vector_dot(d, f->superior) > 0 ? -1 : 1;
    for (int a = 0; a < 3; a++)
        f->superior[a] *= sign;
}

/*
 * Fits a plane to the infraspinous part of the blade, because this part has no processes. The part consists of the
 * cells more than 25 mm below the face and more than 20 mm medial of the face.
 */
static bool fit_blade(const anatomy_cells *cells, const double inward[3], const double inferior[3], frame *f)
{
    double(*points)[3] = malloc((cells->count + 1) * sizeof *points), normal[3], mean[3];
    bool good = points != NULL;
    for (int round = 0; round < 3 && good; round++) {
        size_t count = 0;
        for (size_t i = 0; i < cells->count; i++) {
            double p[3];
            to_frame(f, cells->at[i], p);
            if (p[0] < 20 || p[1] > -25)
                continue;
            for (int a = 0; a < 3; a++)
                points[count][a] = cells->at[i][a];
            count++;
        }
        good = count >= 50 && ost_fit_plane((const double(*)[3])points, count, f->normal, normal, mean);
        for (int a = 0; a < 3 && good; a++)
            f->normal[a] = normal[a];
        if (good)
            align(f, inward, inferior);
    }
    free(points);
    return good;
}

/*
 * Finds the extreme point of the bone in the direction of the unit vector `way`. Computes the mean position of the
 * cells in the last `within` mm along this direction, and moves the mean along `way` to the coordinate of the extreme
 * cell.
 */
static void extreme(const anatomy_cells *cells, const double way[3], double within, double out[3])
{
    double most = -1e30, sum[3] = {0};
    size_t count = 0;
    for (size_t i = 0; i < cells->count; i++)
        most = ost_vector_dot(cells->at[i], way) > most ? ost_vector_dot(cells->at[i], way) : most;
    for (size_t i = 0; i < cells->count; i++) {
        if (ost_vector_dot(cells->at[i], way) < most - within)
            continue;
        count++;
        for (int a = 0; a < 3; a++)
            sum[a] += cells->at[i][a];
    }
    for (int a = 0; a < 3; a++)
        out[a] = sum[a] / (double)count;
    const double inside = most - ost_vector_dot(out, way);
    for (int a = 0; a < 3; a++)
        out[a] += inside * way[a];
}

/* ---------------------------------------------------------------- trigonum */

/*
 * Heights of one side of the blade, in bins along the medial direction and rows along the superior direction.
 * Within a bin, each position has two valleys, which are the lowest heights within VALLEY_MM above and below it. The
 * prominence of the position is its height over the higher valley.
 */
typedef struct relief {
    double height[BINS][ROWS]; /* height of the highest cell above the blade's plane; NONE if there is no bone */
    double prominence[BINS][ROWS];
} relief;

/*
 * The crest of the spine. seen[b] is true if the crest was followed through bin b; superior[b] is its superior
 * coordinate in this bin.
 */
typedef struct crest {
    bool seen[BINS];
    double superior[BINS];
} crest;

static void find_relief(const anatomy_cells *cells, const frame *f, double side, relief *out)
{
    for (int b = 0; b < BINS; b++)
        for (int r = 0; r < ROWS; r++) {
            out->height[b][r] = NONE;
            out->prominence[b][r] = 0;
        }
    for (size_t i = 0; i < cells->count; i++) {
        double p[3];
        to_frame(f, cells->at[i], p);
        const double row = p[1] / ROW_MM + 0.5 * ROWS;
        const int b = p[0] > 0 && p[0] < BINS * BIN_MM ? (int)(p[0] / BIN_MM) : BINS;
        if (b == BINS || row < 0 || row >= ROWS)
            continue;
        double *const h = &out->height[b][(int)row];
        *h = side * p[2] > *h ? side * p[2] : *h;
    }
    const int reach = (int)(VALLEY_MM / ROW_MM);
    for (int b = 0; b < BINS; b++)
        for (int r = reach; r < ROWS - reach; r++) {
            double valley[2] = {-NONE, -NONE};
            if (out->height[b][r] <= NONE)
                continue;
            for (int k = 1; k <= reach; k++)
                for (int way = 0; way < 2; way++) {
                    const double h = out->height[b][way ? r + k : r - k];
                    if (h > NONE)
                        valley[way] = h < valley[way] ? h : valley[way];
                }
            const double higher = valley[0] > valley[1] ? valley[0] : valley[1];
            out->prominence[b][r] = out->height[b][r] > higher ? out->height[b][r] - higher : 0;
        }
}

/* Returns the row from lo to hi that has the greatest prominence in bin b. */
static int most_prominent(const relief *s, int b, int lo, int hi)
{
    int best = lo < 0 ? 0 : lo;
    for (int r = best; r <= hi && r < ROWS; r++)
        best = s->prominence[b][r] > s->prominence[b][best] ? r : best;
    return best;
}

/* Finds the greatest prominence in each bin 30 to 72 mm medial of the face, and returns the mean of these values. */
static double mean_prominence(const relief *s)
{
    double sum = 0;
    for (int b = MIDDLE_LO; b < MIDDLE_HI; b++)
        sum += s->prominence[b][most_prominent(s, b, 0, ROWS - 1)] / (MIDDLE_HI - MIDDLE_LO);
    return sum;
}

/* Follows the crest from its most prominent position in the middle of the blade to the medial border. */
static void follow_crest(const relief *s, crest *out)
{
    int from = MIDDLE_LO, row = 0, missed = 0;
    *out = (crest){.seen = {false}};
    for (int b = MIDDLE_LO; b < MIDDLE_HI; b++) {
        const int r = most_prominent(s, b, 0, ROWS - 1);
        if (s->prominence[b][r] > s->prominence[from][row]) {
            from = b;
            row = r;
        }
    }
    for (int b = from; b < BINS && missed < 3; b++) {
        const int r = most_prominent(s, b, row - STRAY_ROWS, row + STRAY_ROWS);
        if (s->prominence[b][r] < PROMINENT_MM) {
            missed++;
            continue;
        }
        missed = 0;
        row = r;
        out->seen[b] = true;
        out->superior[b] = (r + 0.5 - 0.5 * ROWS) * ROW_MM;
    }
}

/*
 * Returns the medial coordinate of the blade's border at a given superior coordinate. Sets *across to the mean
 * coordinate of the border's cells along the blade's normal.
 */
static double border(const anatomy_cells *cells, const frame *f, double superior, double *across)
{
    double most = 0, sum = 0;
    size_t count = 0;
    for (int pass = 0; pass < 2; pass++)
        for (size_t i = 0; i < cells->count; i++) {
            double p[3];
            to_frame(f, cells->at[i], p);
            if (fabs(p[1] - superior) > 2.5)
                continue;
            if (!pass) {
                most = p[0] > most ? p[0] : most;
            } else if (p[0] > most - 3) {
                count++;
                sum += p[2];
            }
        }
    *across = count ? sum / (double)count : 0;
    return most;
}

/*
 * Finds the trigonum by extending the crest to the medial border. Returns false if the spine is too low or too
 * short.
 */
static bool find_trigonum(const anatomy_cells *cells, const frame *f, const crest *c, double out[3])
{
    double across, at = 0, medial = border(cells, f, 0, &across);
    for (int round = 0; round < 4; round++) {
        double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
        for (int b = 0; b < BINS; b++) {
            const double x = (b + 0.5) * BIN_MM - medial;
            if (x > -5 || x < -45 || !c->seen[b])
                continue;
            n++;
            sx += x;
            sy += c->superior[b];
            sxx += x * x;
            sxy += x * c->superior[b];
        }
        const double det = n * sxx - sx * sx;
        if (n < 5 || det <= 0)
            return false;
        at = (sy * sxx - sx * sxy) / det;
        medial = border(cells, f, at, &across);
        if (medial < 50)
            return false;
    }
    for (int a = 0; a < 3; a++)
        out[a] = f->origin[a] + medial * f->medial[a] + at * f->superior[a] + across * f->normal[a];
    return true;
}

/* ----------------------------------------------------------------- public */

ost_status ost_anatomy_blade_find(const anatomy_cells *cells, const double centre[3], const double inward[3],
                                  double step, anatomy_blade *out, ost_error *err)
{
    frame f;
    size_t farthest = 0;
    if (!(farthest_cell(cells, centre, &farthest) > 90))
        return ost_fail(err, OST_ERR_INPUT, "the bone ends within 90 mm of the glenoid; expected a complete scapula");
    const double *low = cells->at[farthest];
    const double d[3] = {low[0] - centre[0], low[1] - centre[1], low[2] - centre[2]};
    for (int a = 0; a < 3; a++)
        f.origin[a] = centre[a];
    ost_vector_cross(inward, d, f.normal);
    if (!(ost_vector_unit(f.normal, 0) > 40))
        return ost_fail(err, OST_ERR_INPUT,
                        "the bone extends along the axis of the glenoid; expected a scapula, whose inferior angle "
                        "lies below it");
    align(&f, inward, low);
    if (!fit_blade(cells, inward, low, &f))
        return ost_fail(err, OST_ERR_INPUT, "the bone has no flat blade below the glenoid; expected a scapula");
    double way[3];
    for (int a = 0; a < 3; a++)
        way[a] = 0.34 * f.medial[a] - 0.94 * f.superior[a];
    (void)ost_vector_unit(way, 0);
    extreme(cells, way, 1.5 * step, out->inferior);

    relief sides[2];
    for (int side = 0; side < 2; side++)
        find_relief(cells, &f, side ? -1 : 1, &sides[side]);
    const double height[2] = {mean_prominence(&sides[0]), mean_prominence(&sides[1])};
    const int posterior = height[1] > height[0];
    if (height[posterior] < 8 || height[posterior] < height[!posterior] + 3)
        return ost_fail(err, OST_ERR_INPUT,
                        "the blade has no spine: it rises %.1f mm on one side and %.1f mm on the other",
                        height[posterior], height[!posterior]);
    crest spine;
    follow_crest(&sides[posterior], &spine);
    if (!find_trigonum(cells, &f, &spine, out->trigonum))
        return ost_fail(err, OST_ERR_INPUT, "the spine does not reach the medial border: the scapula is not complete");
    /* On a right scapula, lateral x superior is the posterior direction. */
    double lateral[3], across[3];
    for (int a = 0; a < 3; a++)
        lateral[a] = -f.medial[a];
    ost_vector_cross(lateral, f.superior, across);
    out->left = (ost_vector_dot(across, f.normal) > 0) != (posterior == 0);
    for (int a = 0; a < 3; a++)
        out->superior[a] = f.superior[a];
    return OST_OK;
}
