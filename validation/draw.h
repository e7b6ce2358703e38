/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The random number generator for a campaign's inputs: splitmix64, which returns the same numbers on every
 * machine. Each stream has a name, so that a case added to a campaign does not change any other case.
 *
 * Several calls of draw functions in one statement are allowed only if &&, ?: or the commas between declarators define
 * their order. In f(draw(), draw()) and {draw(), draw()} the compiler chooses the order. gcc and clang choose
 * differently, so the same name would give different cases. tests/validation/test_scene checks the digests of the
 * results.
 */
#ifndef OST_VALIDATION_DRAW_H
#define OST_VALIDATION_DRAW_H

#include <stdbool.h>
#include <stdint.h>

#include <osteon/grid.h>

typedef struct draw {
    uint64_t state;
} draw;

static inline uint64_t draw_bits(draw *d)
{
    uint64_t z = (d->state += UINT64_C(0x9e3779b97f4a7c15));
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return z ^ (z >> 31);
}

/* Returns a random number in [lo, hi]. Requires hi - lo < 2^63. */
static inline int64_t draw_between(draw *d, int64_t lo, int64_t hi)
{
    return lo + (int64_t)(draw_bits(d) % ((uint64_t)hi - (uint64_t)lo + 1));
}

static inline bool draw_one_in(draw *d, int n)
{
    return draw_bits(d) % (uint64_t)n == 0;
}

/* Returns lo + k (hi - lo) / 2^53 for a random integer k, 0 <= k < 2^53. */
static inline double draw_real(draw *d, double lo, double hi)
{
    return lo + (hi - lo) * ((double)(draw_bits(d) >> 11) * 0x1p-53);
}

static inline ost_pm3 draw_point(draw *d, ost_pm lo, ost_pm hi)
{
    ost_pm3 p;
    p.x = draw_between(d, lo, hi);
    p.y = draw_between(d, lo, hi);
    p.z = draw_between(d, lo, hi);
    return p;
}

static inline ost_dims draw_dims(draw *d, int32_t lo, int32_t hi)
{
    ost_dims n;
    n.x = (int32_t)draw_between(d, lo, hi);
    n.y = (int32_t)draw_between(d, lo, hi);
    n.z = (int32_t)draw_between(d, lo, hi);
    return n;
}

/* Returns the random stream of this name, which depends only on the name and the campaign's seed. */
static inline draw draw_named(uint64_t seed, const char *name)
{
    draw d = {seed};
    for (; *name; name++) {
        d.state ^= (uint64_t)(unsigned char)*name;
        d.state = draw_bits(&d);
    }
    return d;
}

#endif
