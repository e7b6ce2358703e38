/* SPDX-License-Identifier: Apache-2.0 */
/* Checks dims and geometries, and manages the memory of dense volumes (AR-GRID). */
#include "core/conditions.h"

#include <osteon/grid.h>

#include <stdlib.h>

#include "core/huge_pages.h"

int64_t ost_dims_count(ost_dims dims)
{
    return (int64_t)dims.x * dims.y * dims.z;
}

bool ost_geometry_equal(const ost_geometry *a, const ost_geometry *b)
{
    return a->dims.x == b->dims.x && a->dims.y == b->dims.y && a->dims.z == b->dims.z && a->spacing.x == b->spacing.x &&
           a->spacing.y == b->spacing.y && a->spacing.z == b->spacing.z && a->origin.x == b->origin.x &&
           a->origin.y == b->origin.y && a->origin.z == b->origin.z;
}

/* (dims - 1) * spacing < 2^14 * 10^11 < 2^51, so there is no overflow before the comparison. */
ost_status ost_geometry_check(const ost_geometry *geometry, const char *what, ost_error *err)
{
    const int32_t dims[3] = {geometry->dims.x, geometry->dims.y, geometry->dims.z};
    const int64_t spacing[3] = {geometry->spacing.x, geometry->spacing.y, geometry->spacing.z};
    const int64_t origin[3] = {geometry->origin.x, geometry->origin.y, geometry->origin.z};
    for (int a = 0; a < 3; a++) {
        if (dims[a] < 1 || dims[a] > OST_DIM_MAX)
            return ost_fail(err, OST_ERR_RANGE, "%s: %d voxels along %c; expected 1 to %d", what, (int)dims[a],
                            "xyz"[a], OST_DIM_MAX);
        if (spacing[a] < OST_SPACING_MIN || spacing[a] > OST_SPACING_MAX)
            return ost_fail(err, OST_ERR_RANGE, "%s: spacing of %.9g mm along %c; expected 0.001 to 100 mm", what,
                            ost_pm_to_mm(spacing[a]), "xyz"[a]);
        if (origin[a] < -OST_LENGTH_MAX || origin[a] > OST_LENGTH_MAX ||
            origin[a] + (dims[a] - 1) * spacing[a] > OST_LENGTH_MAX)
            return ost_fail(err, OST_ERR_RANGE,
                            "%s: voxel centres from %.6g to %.6g mm along %c; supported is within 8000 mm of 0", what,
                            ost_pm_to_mm(origin[a]), ost_pm_to_mm(origin[a]) + (dims[a] - 1) * ost_pm_to_mm(spacing[a]),
                            "xyz"[a]);
    }
    if (ost_dims_count(geometry->dims) > INT64_C(1) << 36)
        return ost_fail(err, OST_ERR_RANGE, "%s: %d x %d x %d voxels; expected at most 2^36", what, (int)dims[0],
                        (int)dims[1], (int)dims[2]);
    return OST_OK;
}

ost_status ost_volume_init(ost_volume *volume, const ost_geometry *geometry, ost_error *err)
{
    *volume = (ost_volume){.geometry = *geometry};
    ost_status status = ost_geometry_check(geometry, "grid", err);
    if (status != OST_OK)
        return status;
    size_t count = (size_t)ost_dims_count(geometry->dims);
    volume->voxels = calloc(count, sizeof *volume->voxels);
    if (!volume->voxels)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a grid of %d x %d x %d voxels (%zu bytes)",
                        (int)geometry->dims.x, (int)geometry->dims.y, (int)geometry->dims.z,
                        count * sizeof *volume->voxels);
    ost_request_huge_pages(volume->voxels, count * sizeof *volume->voxels);
    return OST_OK;
}

void ost_volume_free(ost_volume *volume)
{
    if (!volume)
        return;
    free(volume->voxels);
    volume->voxels = NULL;
}
