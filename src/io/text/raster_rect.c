/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Converts a raster scan to the rect grid. Each axis of the scan is mapped to the voxels of the grid. If the order of
 * the scan is the order of the grid, all densities are copied at once. Otherwise, they are copied slice by slice
 * through the maps.
 */
#include "core/conditions.h"

#include "io/text/raster.h"

#include <stdlib.h>

#include "core/integer.h"

/* Maps the coordinates of one axis of the scan to voxel indices, and records their distances from the voxel centres. */
typedef struct axis_map {
    int32_t count;     /* number of coordinates within the crop */
    int32_t from;      /* index of the first of these coordinates */
    int32_t *index;    /* owned; for each coordinate, the index of its voxel in the complete grid */
    ost_pm spacing;
    int64_t good;      /* number of coordinates within the crop that are at most 1/8 of a voxel from the voxel centre */
    int64_t worst;     /* maximum distance of these coordinates from their voxel centres, in millionths of a voxel */
    int32_t worst_at;  /* index of the first coordinate with this distance */
} axis_map;

static void maps_free(axis_map maps[3])
{
    for (int i = 0; i < 3; i++)
        free(maps[i].index);
}

/*
 * Maps one axis. Returns false if two coordinates share a voxel, if a coordinate is outside the grid or too far from
 * its voxel centre, or if memory is exhausted. Ranges: |p|, the distance from the origin, is below 2^54. off, the
 * distance from the voxel centre, is at most half of the spacing, so off * 10^6 < 2^56.
 */
static bool map_axis(const ost_text_raster *raster, int rank, const ost_geometry *full, const ost_voxel_box *crop,
                     axis_map *map)
{
    int a = raster->axis[rank];
    const int64_t origin[3] = {full->origin.x, full->origin.y, full->origin.z};
    const int64_t spacing[3] = {full->spacing.x, full->spacing.y, full->spacing.z};
    const int32_t dims[3] = {full->dims.x, full->dims.y, full->dims.z};
    int32_t lo = crop ? crop->lo[a] : 0, hi = crop ? crop->hi[a] : dims[a], count = raster->count[rank];
    *map = (axis_map){
        .spacing = spacing[a], .from = -1, .worst = -1, .index = malloc((size_t)count * sizeof *map->index)};
    for (int32_t i = 0; i < count && map->index; i++) {
        int64_t p = raster->at[rank][i] - origin[a], index = ost_rhe_div(p, spacing[a]), off = p - index * spacing[a];
        off = off < 0 ? -off : off;
        if (index < 0 || index >= dims[a] || 8 * off > 3 * spacing[a] || (i > 0 && index == map->index[i - 1]))
            return false;
        map->index[i] = (int32_t)index;
        if (index < lo || index >= hi)
            continue;
        map->from = map->from < 0 ? i : map->from;
        map->count++;
        map->good += 8 * off <= spacing[a];
        int64_t ppm = off * 1000000 / spacing[a];
        if (ppm > map->worst) {
            map->worst = ppm;
            map->worst_at = i;
        }
    }
    return map->index != NULL;
}

static bool map_all(const ost_text_raster *raster, const ost_geometry *full, const ost_voxel_box *crop,
                    axis_map maps[3])
{
    bool good = true;
    for (int rank = 0; rank < 3; rank++)
        maps[rank] = (axis_map){0};
    for (int rank = 0; rank < 3 && good; rank++)
        good = map_axis(raster, rank, full, crop, &maps[rank]);
    return good;
}

/* Computes the same report as ost_text_to_rect. Each coordinate must have a voxel of its own. */
static void report_of(const ost_text_raster *raster, const axis_map maps[3], ost_scatter_report *report)
{
    *report = (ost_scatter_report){0};
    int64_t samples = (int64_t)maps[0].count * maps[1].count * maps[2].count;
    if (samples == 0)
        return;
    report->samples = (uint64_t)samples;
    report->off_lattice = (uint64_t)(samples - maps[0].good * maps[1].good * maps[2].good);
    for (int rank = 0; rank < 3; rank++) {
        /* Finds the first line within the crop whose coordinate has the maximum distance from its voxel centre. */
        int64_t line = raster->first_line;
        for (int other = 0; other < 3; other++)
            line += (other == rank ? maps[other].worst_at : maps[other].from) * ost_text_raster_stride(raster, other);
        uint64_t ppm = (uint64_t)maps[rank].worst;
        if (ppm > report->worst_offset_ppm ||
            (ppm > 0 && ppm == report->worst_offset_ppm && line < report->worst_line)) {
            report->worst_offset_ppm = ppm;
            report->worst_line = line;
        }
    }
}

/* Returns true if the lines contain the complete grid in its memory order. */
static bool is_plain(const ost_text_raster *raster, const axis_map maps[3], ost_dims dims)
{
    const int32_t counts[3] = {dims.x, dims.y, dims.z};
    for (int rank = 0; rank < 3; rank++) {
        if (raster->axis[rank] != rank || raster->count[rank] != counts[rank])
            return false;
        for (int32_t i = 0; i < counts[rank]; i++)
            if (maps[rank].index[i] != i)
                return false;
    }
    return true;
}

/* Uploads the grid slice by slice, for any order of the voxels in the file. */
static ost_status upload_mapped(const char *path, const ost_text_raster *raster, const axis_map maps[3],
                                const ost_voxel_box *crop, ost_grid *rect, ost_error *err)
{
    const ost_dims dims = ost_grid_geometry(rect)->dims;
    const int32_t counts[3] = {dims.x, dims.y, dims.z};
    /* The index of a voxel in raster->voxels is the sum of three offsets, one for its position along each axis. An
     * offset is -1 if the file has no coordinate for this position. */
    int64_t *offset[3] = {NULL, NULL, NULL};
    int16_t *slice = malloc((size_t)dims.x * (size_t)dims.y * sizeof *slice);
    bool enough = slice != NULL;
    for (int rank = 0; rank < 3; rank++) {
        int a = raster->axis[rank];
        int32_t lo = crop ? crop->lo[a] : 0;
        offset[a] = malloc((size_t)counts[a] * sizeof *offset[a]);
        enough = enough && offset[a];
        for (int32_t i = 0; i < counts[a] && enough; i++)
            offset[a][i] = -1;
        for (int32_t i = 0; i < raster->count[rank] && enough; i++) {
            int32_t index = maps[rank].index[i] - lo;
            if (index >= 0 && index < counts[a])
                offset[a][index] = i * ost_text_raster_stride(raster, rank);
        }
    }
    ost_status status = OST_OK;
    if (!enough)
        status = ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for a slice of %d x %d voxels", path, (int)dims.x,
                          (int)dims.y);
    for (int32_t z = 0; z < dims.z && status == OST_OK; z++) {
        int16_t *to = slice;
        for (int32_t y = 0; y < dims.y; y++)
            for (int32_t x = 0; x < dims.x; x++) {
                bool there = offset[0][x] >= 0 && offset[1][y] >= 0 && offset[2][z] >= 0;
                *to++ = there ? raster->voxels[offset[0][x] + offset[1][y] + offset[2][z]] : 0;
            }
        status = ost_grid_upload(rect, z, 1, slice, err);
    }
    for (int a = 0; a < 3; a++)
        free(offset[a]);
    free(slice);
    return status;
}

ost_status ost_text_raster_to_rect(const char *path, const ost_text_raster *raster,
                                   const ost_text_rect_options *options, ost_grid *rect, ost_scatter_report *report,
                                   ost_error *err)
{
    axis_map maps[3];
    ost_status status = OST_OK;
    if (options->progress && !options->progress(options->user, "rect", 0))
        return ost_fail(err, OST_ERR_CANCELLED, "%s: reading was cancelled", path);
    if (!map_all(raster, options->full, options->crop, maps)) {
        maps_free(maps);
        return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for the coordinates along an axis", path);
    }
    report_of(raster, maps, report);
    if (!options->crop && is_plain(raster, maps, ost_grid_geometry(rect)->dims))
        status = ost_grid_upload(rect, 0, ost_grid_geometry(rect)->dims.z, raster->voxels, err);
    else
        status = upload_mapped(path, raster, maps, options->crop, rect, err);
    maps_free(maps);
    return status;
}

bool ost_text_raster_fits(const ost_text_raster *raster, const ost_geometry *full)
{
    axis_map maps[3];
    const bool fits = map_all(raster, full, NULL, maps);
    maps_free(maps);
    return fits;
}
