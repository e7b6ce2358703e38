/* SPDX-License-Identifier: Apache-2.0 */
#include "render/points/clip.h"

#include <math.h>
#include <string.h>

#include "core/conditions.h"
#include "core/integer.h"

enum { SIDE = OST_BLOCK, ROWS = OST_BLOCK_ROWS };

ost_status ost_clip_make(const ost_geometry *g, const double at_mm[3], const double normal[3], ost_clip *out,
                         ost_error *err)
{
    const double length = sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
    const ost_pm origin[3] = {g->origin.x, g->origin.y, g->origin.z};
    double d = 0;
    if (!(length > 1e-9) || !isfinite(length))
        return ost_fail(err, OST_ERR_RANGE, "the direction of a clip plane is zero");
    for (int a = 0; a < 3; a++) {
        out->n[a] = (int32_t)floor(normal[a] / length * OST_CLIP_UNIT + 0.5);
        d += out->n[a] * ((at_mm[a] * 1e9 - (double)origin[a]) / (double)g->spacing.x);
    }
    if (!(fabs(d) < 1e12))
        return ost_fail(err, OST_ERR_RANGE, "a clip plane is too far away from the bone");
    out->d = (int64_t)floor(d + 0.5);
    return OST_OK;
}

/* Returns a word in which bit x is 1 if n * x <= remainder. */
static uint32_t row_mask(int64_t n, int64_t remainder)
{
    if (n == 0)
        return remainder >= 0 ? UINT32_MAX : 0;
    if (n > 0) { /* bits x <= floor(remainder / n) are set */
        const int64_t last = remainder < 0 ? -1 : remainder / n;
        return last < 0 ? 0 : last >= SIDE - 1 ? UINT32_MAX : (UINT32_C(2) << last) - 1;
    }
    const int64_t first = remainder >= 0 ? 0 : (-remainder - n - 1) / -n; /* bits x >= ceil(-remainder / -n) are set */
    return first >= SIDE ? 0 : UINT32_MAX << first;
}

void ost_clip_words(const ost_clip *clip, const int32_t block[3], const uint32_t occupied[OST_BLOCK_ROWS],
                    uint32_t shown[OST_BLOCK_ROWS])
{
    int64_t remainder = clip->d, least = 0, most = 0;
    for (int a = 0; a < 3; a++) {
        remainder -= (int64_t)clip->n[a] * SIDE * block[a];
        const int64_t reach = (int64_t)clip->n[a] * (SIDE - 1);
        least += reach < 0 ? reach : 0;
        most += reach > 0 ? reach : 0;
    }
    if (most <= remainder)
        memcpy(shown, occupied, ROWS * sizeof *shown);
    else if (least > remainder)
        memset(shown, 0, ROWS * sizeof *shown);
    else
        for (int row = 0; row < ROWS; row++)
            shown[row] = occupied[row]
                             ? occupied[row] & row_mask(clip->n[0], remainder - (int64_t)clip->n[1] * (row % SIDE) -
                                                                        (int64_t)clip->n[2] * (row / SIDE))
                             : 0;
}
