/* SPDX-License-Identifier: Apache-2.0 */
#include "cpu/kernels.h"

void ost_gather_row_scalar(const int16_t *from, const int32_t *map, int count, int16_t *to)
{
    for (int i = 0; i < count; i++)
        to[i] = from[map[i]];
}
