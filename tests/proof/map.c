/* SPDX-License-Identifier: Apache-2.0 */
#include "proof.h"

#include <string.h>

#include "core/divider.h"

/* Returns any value as the quotient, because check_bounds.py proves the bounds of the division. */
#define ost_rhe_div128(n, d) nondet_int128()
#include "core/map.c"

/*
 * Proves for any base of a near block (AR-MAP-5) that no partial sum of base and the products d * step overflows. The
 * proof uses a copy of the expression, because the code is in loops of remove.c.
 */
void map_coordinate(void)
{
    const int64_t most = 29058992; /* floor(sqrt(3) * 2^24 + 3/2), proved by check_bounds.py */
    const int32_t base = any32(-(1 << 29), (1 << 30) + (1 << 29) - 1);
    int32_t step[3];
    int64_t sum = 0;
    for (int b = 0; b < 3; b++) {
        step[b] = any32(-(1 << 24), 1 << 24);
        sum += step[b] < 0 ? -step[b] : step[b];
    }
    ASSUME(sum <= most << 2 * WIDER);
    const int32_t i = any32(0, 15), j = any32(0, 15), k = any32(0, 15);
    const int32_t u = base + i * step[0] + j * step[1] + k * step[2];
    ASSERT(u > -(1 << 30));
}

/*
 * Proves that the function returns false for a far block and that the base of a near block fits in int32, for
 * any result of the division.
 */
void map_base(void)
{
    ost_map map;
    int32_t base[3];
    memset(&map, 0, sizeof map);
    if (ost_map_block_base(&map, (ost_dims){0, 0, 0}, base))
        for (int a = 0; a < 3; a++)
            ASSERT(base[a] >= -(1 << 29) && base[a] < (1 << 30) + (1 << 29 >> WIDER));
}
