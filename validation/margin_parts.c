/* SPDX-License-Identifier: Apache-2.0 */
/* Counts the voxels in which two backends differ, and stores the greatest margin. */
#include "validation/margin_parts.h"

void margin_decided(margin_stage *m, uint64_t margin, uint32_t item, const int32_t at[3])
{
    int bin = 0;
    while (bin < MARGIN_BINS - 1 && margin >> bin)
        bin++;
    m->voxels++;
    m->bins[bin]++;
    if (margin > m->max || m->decided == 0) {
        m->max = margin;
        m->max_item = item;
        memcpy(m->max_voxel, at, sizeof m->max_voxel);
    }
    m->decided++;
}

void margin_other(margin_stage *m, uint64_t *why)
{
    m->voxels++;
    ++*why;
}
