/* SPDX-License-Identifier: Apache-2.0 */
#include "app/picture/implant.h"

#include <math.h>

enum { WIDE = 64, HIGH = 88, DEEP = 60, VOXEL_UM = 400 };
/* Dimensions of the implant in mm. */
static const double HALF_WIDTH = 12.5, HALF_HEIGHT = 17, BACK = 27, FRONT = 32, THICK = 4, PEG = 3, PEG_LENGTH = 14;

static bool solid(double x, double y, double z)
{
    const double square = x * x + y * y, dome = BACK - sqrt(BACK * BACK - square),
                 dish = FRONT - sqrt(FRONT * FRONT - square);
    /* The implant is an oval that is wider at its inferior end. */
    const double half = HALF_WIDTH * (1 - 0.16 * y / HALF_HEIGHT),
                 oval = x * x / (half * half) + y * y / (HALF_HEIGHT * HALF_HEIGHT);
    const double tip = square <= PEG * PEG ? PEG - sqrt(PEG * PEG - square) : 0;
    return (oval <= 1 && z >= dome && z <= THICK + dish) || (square <= PEG * PEG && z <= 1 && z >= tip - PEG_LENGTH);
}

ost_status implant_make(ost_tool_volume *out, ost_error *err)
{
    const ost_pm voxel = (ost_pm)VOXEL_UM * (OST_PM_PER_MM / 1000);
    const ost_tool_geometry g = {{WIDE, HIGH, DEEP}, voxel, {-WIDE / 2 * voxel, -HIGH / 2 * voxel, -38 * voxel}};
    ost_status status = ost_tool_volume_init(out, &g, err);
    const double mm = VOXEL_UM * 1e-3;
    for (int64_t i = 0; status == OST_OK && i < (int64_t)WIDE * HIGH * DEEP; i++) {
        const double x = ((double)(i % WIDE) + 0.5 - WIDE / 2) * mm,
                     y = ((double)(i / WIDE % HIGH) + 0.5 - HIGH / 2) * mm;
        out->voxels[i] = solid(x, y, ((double)(i / WIDE / HIGH) + 0.5 - 38) * mm) ? OST_TOOL_NONCUTTING : OST_TOOL_VOID;
    }
    return status;
}
