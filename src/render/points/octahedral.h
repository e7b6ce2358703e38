/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Encodes directions in fourteen bits: the octahedron |x| + |y| + |z| = 1 is unfolded into a square of 128 x 128 cells
 * (Cigolle et al. 2014). A direction is within two degrees of the middle of its cell.
 *
 *      upper half: u = x, v = y             the lower half's corners are
 *      lower half: u = (1 - |y|) sign x     folded outwards
 *                  v = (1 - |x|) sign y
 */
#ifndef OST_RENDER_OCTAHEDRAL_H
#define OST_RENDER_OCTAHEDRAL_H

#include <math.h>
#include <stdint.h>

enum { OST_OCTAHEDRAL_SIDE = 128, OST_OCTAHEDRAL_COUNT = 128 * 128 };

/* Returns the cell that contains the direction of v, a vector of any length. Returns the cell of +z for a zero
   vector. */
static inline uint32_t ost_octahedral_of(const float v[3])
{
    const float sum = (fabsf(v[0]) + fabsf(v[1])) + fabsf(v[2]);
    float p[2] = {0, 0};
    if (sum > 0) {
        p[0] = v[0] / sum;
        p[1] = v[1] / sum;
        if (v[2] < 0) {
            const float x = p[0], y = p[1];
            p[0] = x < 0 ? fabsf(y) - 1 : 1 - fabsf(y);
            p[1] = y < 0 ? fabsf(x) - 1 : 1 - fabsf(x);
        }
    }
    uint32_t cell[2];
    for (int a = 0; a < 2; a++) {
        const int c = (int)((p[a] + 1) * (OST_OCTAHEDRAL_SIDE / 2));
        cell[a] = (uint32_t)(c < 0 ? 0 : c > OST_OCTAHEDRAL_SIDE - 1 ? OST_OCTAHEDRAL_SIDE - 1 : c);
    }
    return cell[0] | cell[1] * OST_OCTAHEDRAL_SIDE;
}

/* Computes the unit vector at the centre of a cell. */
static inline void ost_octahedral_vector(uint32_t cell, float v[3])
{
    const float u = ((float)(cell % OST_OCTAHEDRAL_SIDE) + 0.5f) / (OST_OCTAHEDRAL_SIDE / 2) - 1;
    const float w = ((float)(cell / OST_OCTAHEDRAL_SIDE) + 0.5f) / (OST_OCTAHEDRAL_SIDE / 2) - 1;
    v[0] = u;
    v[1] = w;
    v[2] = 1 - fabsf(u) - fabsf(w);
    if (v[2] < 0) {
        v[0] = u < 0 ? fabsf(w) - 1 : 1 - fabsf(w);
        v[1] = w < 0 ? fabsf(u) - 1 : 1 - fabsf(u);
    }
    const float length = sqrtf((v[0] * v[0] + v[1] * v[1]) + v[2] * v[2]);
    for (int a = 0; a < 3; a++)
        v[a] /= length;
}

#endif
