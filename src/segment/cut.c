/* SPDX-License-Identifier: Apache-2.0 */
#include "core/conditions.h"

#include "segment/cut.h"

__extension__ typedef __int128 wide;

static bool is_within(ost_pm v, ost_pm most)
{
    return v >= -most && v <= most;
}

ost_status ost_segment_cut_check(const ost_segment_cut *cut, ost_error *err)
{
    const ost_pm metre = INT64_C(1000000000000);
    const ost_pm3 n = cut->normal;
    if (!is_within(cut->at.x, OST_LENGTH_MAX) || !is_within(cut->at.y, OST_LENGTH_MAX) ||
        !is_within(cut->at.z, OST_LENGTH_MAX))
        return ost_fail(err, OST_ERR_RANGE, "a cut is more than 8 m away");
    if (cut->radius < 0 || cut->radius > metre)
        return ost_fail(err, OST_ERR_RANGE, "a ball of %.9g mm; expected a radius of at most 1000 mm",
                        ost_pm_to_mm(cut->radius));
    if (cut->radius == 0 && ((n.x == 0 && n.y == 0 && n.z == 0) || !is_within(n.x, metre) || !is_within(n.y, metre) ||
                             !is_within(n.z, metre)))
        return ost_fail(err, OST_ERR_RANGE, "a plane whose normal is 0 or longer than 1000");
    return OST_OK;
}

/*
 * On each axis, a distance is below 2^44 (AR-GRID-3, AR-LEN-1). A sum of squares is therefore below 2^90, and
 * the product with a normal is below 2^86.
 */
void ost_segment_cut_row(const ost_segment_cut *cut, const ost_geometry *g, int32_t y, int32_t z, bool *in)
{
    const wide dy = (wide)g->origin.y + (wide)y * g->spacing.y - cut->at.y,
               dz = (wide)g->origin.z + (wide)z * g->spacing.z - cut->at.z;
    const wide beyond = (wide)cut->radius * cut->radius - dy * dy - dz * dz,
               side = dy * cut->normal.y + dz * cut->normal.z;
    if (cut->radius && beyond < 0)
        return;
    for (int32_t x = 0; x < g->dims.x; x++) {
        const wide dx = (wide)g->origin.x + (wide)x * g->spacing.x - cut->at.x;
        if (cut->radius ? dx * dx <= beyond : dx * cut->normal.x + side >= 0)
            in[x] = false;
    }
}
