/* SPDX-License-Identifier: Apache-2.0 */
#include "io/volume/orient.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/conditions.h"
#include "core/integer.h"

static const int permutations[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};

enum { LEAST_STEPS = 64, STRAIGHT_SHARE = 8 };

/*
 * Returns the greatest magnitude of a component. If it is at most 100 mm, which is below 2^37 pm, products of three
 * components fit into 128 bits.
 */
static ost_pm greatest_component(const ost_affine *affine)
{
    ost_pm greatest = 0;
    for (int a = 0; a < 3; a++)
        for (int w = 0; w < 3; w++)
            greatest = llabs(affine->column[a][w]) > greatest ? llabs(affine->column[a][w]) : greatest;
    return greatest;
}

static ost_i128 determinant(const ost_affine *m)
{
    ost_i128 sum = 0;
    for (int a = 0; a < 3; a++) {
        int b = (a + 1) % 3, c = (a + 2) % 3;
        sum += (ost_i128)m->column[0][a] * m->column[1][b] * m->column[2][c];
        sum -= (ost_i128)m->column[0][a] * m->column[1][c] * m->column[2][b];
    }
    return sum;
}

static void find_permutation(const ost_affine *affine, int to[3])
{
    ost_i128 best = -1;
    for (int p = 0; p < 6; p++) {
        ost_i128 product = 1;
        for (int a = 0; a < 3; a++)
            product *= llabs(affine->column[a][permutations[p][a]]);
        if (product > best) {
            best = product;
            for (int a = 0; a < 3; a++)
                to[a] = permutations[p][a];
        }
    }
}

static bool is_straight(const ost_affine *affine, const int32_t sizes[3], const int to[3])
{
    for (int w = 0; w < 3; w++) {
        ost_i128 off = 0;
        ost_pm spacing = 0;
        for (int a = 0; a < 3; a++) {
            if (to[a] == w) {
                spacing = llabs(affine->column[a][w]);
            } else {
                int64_t steps = sizes[a] - 1 > LEAST_STEPS ? sizes[a] - 1 : LEAST_STEPS;
                off += (ost_i128)llabs(affine->column[a][w]) * steps;
            }
        }
        if (off * STRAIGHT_SHARE > spacing)
            return false;
    }
    return true;
}

static double greatest_angle(const ost_affine *affine, const int to[3])
{
    double greatest = 0;
    for (int a = 0; a < 3; a++) {
        double along = 0, across = 0;
        for (int w = 0; w < 3; w++) {
            double c = (double)affine->column[a][w];
            if (to[a] == w)
                along = fabs(c);
            else
                across += c * c;
        }
        double degrees = atan2(sqrt(across), along) * 57.29577951308232;
        if (degrees > greatest)
            greatest = degrees;
    }
    return greatest;
}

bool ost_affine_restate(ost_affine *affine, const char code[4])
{
    /* letters i and i + 3 are the positive and the negative direction of LPS axis i */
    static const char letters[] = "LPSRAI";
    const ost_affine from = *affine;
    ost_affine to = {{{0}}, {0}};
    bool seen[3] = {false, false, false};
    if (strlen(code) != 3)
        return false;
    for (int c = 0; c < 3; c++) {
        const char *letter = strchr(letters, code[c]);
        if (!letter)
            return false;
        const int w = (int)(letter - letters) % 3, sign = letter - letters < 3 ? 1 : -1;
        if (seen[w])
            return false;
        seen[w] = true;
        to.origin[w] = sign * from.origin[c];
        for (int a = 0; a < 3; a++)
            to.column[a][w] = sign * from.column[a][c];
    }
    *affine = to;
    return true;
}

ost_status ost_orient(const ost_affine *affine, const int32_t sizes[3], ost_placement *out, ost_error *err)
{
    static const char toward[3][2] = {{'L', 'R'}, {'P', 'A'}, {'S', 'I'}};
    *out = (ost_placement){0};
    if (greatest_component(affine) > OST_SPACING_MAX)
        return ost_fail(err, OST_ERR_RANGE, "a voxel is %.6g mm long, more than 100 mm; check the spacing and its unit",
                        ost_pm_to_mm(greatest_component(affine)));
    if (determinant(affine) == 0)
        return ost_fail(err, OST_ERR_INPUT,
                        "its three axes do not span space: a spacing is 0, or two axes are parallel");
    find_permutation(affine, out->to);
    out->oblique = !is_straight(affine, sizes, out->to);
    if (out->oblique)
        out->degrees = greatest_angle(affine, out->to);

    int32_t dims[3];
    ost_pm spacing[3], origin[3] = {affine->origin[0], affine->origin[1], affine->origin[2]};
    for (int a = 0; a < 3; a++) {
        int w = out->to[a];
        ost_pm step = affine->column[a][w];
        out->flip[a] = step < 0;
        out->code[a] = toward[w][step < 0];
        out->reoriented |= w != a || step < 0;
        dims[w] = sizes[a];
        spacing[w] = llabs(step);
        /*
         * If an axis is flipped, the origin moves to the other end of this axis. All components of the origin change,
         * because a tilted axis has components along the other two axes. The results are below 2^43 + 3 * 2^37 * 2^14.
         */
        for (int v = 0; v < 3 && step < 0; v++)
            origin[v] += affine->column[a][v] * (sizes[a] - 1);
    }
    out->geometry = (ost_geometry){
        .dims = {dims[0], dims[1], dims[2]},
        .spacing = {spacing[0], spacing[1], spacing[2]},
        .origin = {origin[0], origin[1], origin[2]},
    };
    const int64_t along[3] = {1, dims[0], (int64_t)dims[0] * dims[1]};
    for (int a = 0; a < 3; a++) {
        out->stride[a] = out->flip[a] ? -along[out->to[a]] : along[out->to[a]];
        if (out->flip[a])
            out->base += along[out->to[a]] * (sizes[a] - 1);
    }
    return out->oblique ? OST_OK : ost_geometry_check(&out->geometry, "the volume", err);
}
