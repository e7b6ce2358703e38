/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Computes noise from integers, so that the numbers are the same on every machine.
 *
 * A lattice point and a seed are hashed to 64 bits.  Smooth noise is computed from such hashes
 * by additions and multiplications of doubles in a fixed order, for which IEEE 754 defines every
 * bit of the result (no fused multiply-add: conditions.h).
 */
#ifndef OST_PHANTOM_NOISE_H
#define OST_PHANTOM_NOISE_H

#include <stdint.h>

#include "core/conditions.h"

/*
 * Returns a bijective hash of 64 bits without a visible pattern, computed by two rounds of xor-shift and
 * multiplication.
 */
static inline uint64_t ost_mix64(uint64_t v)
{
    v ^= v >> 32;
    v *= UINT64_C(0xd6e8feb86659fd93);
    v ^= v >> 32;
    v *= UINT64_C(0xd6e8feb86659fd93);
    v ^= v >> 32;
    return v;
}

static inline uint64_t ost_hash3(uint64_t seed, int64_t x, int64_t y, int64_t z)
{
    uint64_t h = seed + UINT64_C(0x9e3779b97f4a7c15) * (uint64_t)x;
    h = ost_mix64(h) + UINT64_C(0xc2b2ae3d27d4eb4f) * (uint64_t)y;
    h ^= UINT64_C(0x165667b19e3779f9) * (uint64_t)z;
    return ost_mix64(h);
}

/*
 * Returns a number in [0, 1). The number is a multiple of 2^-24 and therefore exact as a double and as a float.
 * `part`, which is 0 or 1, selects 24 bits of the hash.
 */
static inline double ost_unit(uint64_t hash, int part)
{
    return (double)(hash >> (part * 24) & 0xffffff) * (1.0 / 16777216.0);
}

/* Returns floor(v) for |v| < 2^62, without libm. */
static inline int64_t ost_floor64(double v)
{
    int64_t i = (int64_t)v;
    return i - ((double)i > v);
}

/*
 * A cache for the lattice cell that was used last. Neighbouring positions are mostly in the same cell. The caller
 * zero-initialises the cache, and uses a separate cache for each seed.
 */
typedef struct ost_noise_cell {
    int64_t i, j, k;
    int known;
    double v[8];
} ost_noise_cell;

/*
 * Returns smooth noise in [0, 1). The noise is interpolated between the hashes of the lattice points with the
 * weight 3t^2 - 2t^3. The cached cell saves time and does not affect the result.
 */
static inline double ost_value_noise_in(ost_noise_cell *cell, uint64_t seed, double x, double y, double z)
{
    int64_t i = ost_floor64(x), j = ost_floor64(y), k = ost_floor64(z);
    if (!cell->known || cell->i != i || cell->j != j || cell->k != k) {
        for (int c = 0; c < 8; c++)
            cell->v[c] = ost_unit(ost_hash3(seed, i + (c & 1), j + (c >> 1 & 1), k + (c >> 2)), 0);
        cell->i = i, cell->j = j, cell->k = k;
        cell->known = 1;
    }
    double fx = x - (double)i, fy = y - (double)j, fz = z - (double)k;
    fx = fx * fx * (3 - 2 * fx);
    fy = fy * fy * (3 - 2 * fy);
    fz = fz * fz * (3 - 2 * fz);
    double v[4];
    for (int c = 0; c < 4; c++)
        v[c] = cell->v[2 * c] + fx * (cell->v[2 * c + 1] - cell->v[2 * c]);
    v[0] += fy * (v[1] - v[0]);
    v[2] += fy * (v[3] - v[2]);
    return v[0] + fz * (v[2] - v[0]);
}

static inline double ost_value_noise(uint64_t seed, double x, double y, double z)
{
    ost_noise_cell cell;
    cell.known = 0;
    return ost_value_noise_in(&cell, seed, x, y, z);
}

/*
 * Returns a nearly Gaussian number within +-1.5, with mean 0 and standard deviation 1/2. It is computed from the
 * sum of three uniform numbers, which has a variance of 1/4.
 */
static inline double ost_bell(uint64_t hash)
{
    double a = (double)(hash & 0x1fffff), b = (double)(hash >> 21 & 0x1fffff), c = (double)(hash >> 42 & 0x1fffff);
    return (a + b + c) * (1.0 / 2097152.0) - 1.5;
}

#endif
