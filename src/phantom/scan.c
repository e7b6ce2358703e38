/* SPDX-License-Identifier: Apache-2.0 */
#include "phantom/scan.h"

ost_status ost_scan_blocks(const ost_scan *scan, double mm,
                           void (*block)(void *user, const int lo[3], const int hi[3]), void *user, ost_error *err)
{
    const ost_phantom_options *o = scan->options;
    const ost_geometry *g = &scan->volume->geometry;
    const int dims[3] = {g->dims.x, g->dims.y, g->dims.z};
    const ost_pm spacing[3] = {g->spacing.x, g->spacing.y, g->spacing.z};
    int size[3], count[3];
    for (int a = 0; a < 3; a++) {
        size[a] = (int)ost_clamp(mm * scan->scale / ost_pm_to_mm(spacing[a]), 1, 64);
        count[a] = (dims[a] + size[a] - 1) / size[a];
    }
    for (int k = 0; k < dims[2]; k += size[2]) {
        if (o->progress && !o->progress(o->progress_user, "generating", (double)k / dims[2]))
            return ost_fail(err, OST_ERR_CANCELLED, "generating the phantom was cancelled");
        /* The schedule is dynamic, because blocks that contain bone take more time than other blocks. */
#pragma omp parallel for schedule(dynamic, 8)
        for (int n = 0; n < count[0] * count[1]; n++) {
            const int lo[3] = {n % count[0] * size[0], n / count[0] * size[1], k};
            int hi[3];
            for (int a = 0; a < 3; a++)
                hi[a] = lo[a] + size[a] < dims[a] ? lo[a] + size[a] : dims[a];
            block(user, lo, hi);
        }
    }
    return OST_OK;
}
