/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads and writes tool grids as uint8 NRRD files: 0 is empty, 1 is cutting, 2 is not cutting.
 *
 * The origin of a NRRD file is the centre of the first voxel, and a tool's corner lies half a voxel before this centre.
 * Half of an odd number of picometres cannot be represented, so the corner itself is also stored, in the key
 * osteon_tool_corner_mm. If the stored corner agrees with the origin to a picometre, it is used. Otherwise, one of the
 * two has been changed, and the file is refused. The key may be missing, because every uint8 NRRD file with cubic
 * voxels is accepted, for example a segmentation from 3D Slicer. The corner is then origin - voxel / 2, where voxel / 2
 * is rounded half to even.
 */
#include <osteon/io.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/integer.h"
#include "io/volume_read.h"
#include "io/volume_write.h"

static ost_pm half(ost_pm voxel)
{
    return ost_rhe_div(voxel, 2);
}

static ost_status read_corner(const char *path, const char *text, ost_pm3 *out, ost_error *err)
{
    ost_pm *to[3] = {&out->x, &out->y, &out->z};
    const char *p = text, *end = text + strlen(text);
    for (int a = 0; a < 3; a++) {
        ost_decimal d;
        p += strspn(p, " ");
        p = ost_decimal_read(p, end, &d);
        if (!p || !ost_decimal_to_pm(&d, to[a], NULL))
            return ost_fail(err, OST_ERR_INPUT, "%s: osteon_" OST_META_TOOL_CORNER
                            " is '%.60s'; expected three lengths in mm", path, text);
    }
    if (*p)
        return ost_fail(err, OST_ERR_INPUT, "%s: osteon_" OST_META_TOOL_CORNER
                        " is '%.60s'; expected three lengths in mm", path, text);
    return OST_OK;
}

static bool near(ost_pm a, ost_pm b)
{
    return a - b <= 1 && b - a <= 1;
}

static ost_status tool_geometry(const char *path, const ost_geometry *g, const ost_meta *meta, ost_tool_geometry *out,
                                ost_error *err)
{
    if (g->spacing.x != g->spacing.y || g->spacing.x != g->spacing.z) {
        char x[OST_PM_TEXT], y[OST_PM_TEXT], z[OST_PM_TEXT];
        return ost_fail(err, OST_ERR_INPUT, "%s: voxels of %s x %s x %s mm; expected cubic voxels", path,
                        ost_pm_format(g->spacing.x, x), ost_pm_format(g->spacing.y, y), ost_pm_format(g->spacing.z,
                        z));
    }
    ost_pm h = half(g->spacing.x);
    *out = (ost_tool_geometry){
        .dims = g->dims, .voxel = g->spacing.x, .corner = {g->origin.x - h, g->origin.y - h, g->origin.z - h}};
    const char *text = ost_meta_get(meta, OST_META_TOOL_CORNER);
    if (!text)
        return OST_OK;
    ost_pm3 corner;
    ost_status status = read_corner(path, text, &corner, err);
    if (status != OST_OK)
        return status;
    if (!near(corner.x, out->corner.x) || !near(corner.y, out->corner.y) || !near(corner.z, out->corner.z))
        return ost_fail(err, OST_ERR_INPUT,
                        "%s: osteon_" OST_META_TOOL_CORNER " '%.60s' does not lie half a voxel before the space origin",
                        path, text);
    out->corner = corner;
    return OST_OK;
}

ost_status ost_tool_volume_read(const char *path, ost_tool_volume *out, ost_error *err)
{
    ost_volume volume;
    ost_geometry geometry;
    ost_meta meta;
    ost_volume_report report;
    ost_element element;
    ost_tool_geometry tool;
    memset(out, 0, sizeof *out);
    /* The header is read first, so that a file that is not a tool is refused before any voxel is read. */
    ost_status status = ost_volume_read_any(path, NULL, NULL, &geometry, &meta, &report, &element, err);
    if (status == OST_OK && element != OST_ELEMENT_UINT8)
        status = ost_fail(err, OST_ERR_INPUT,
                          "%s: voxels are %s; a tool has uint8 voxels (0 void, 1 cutting, 2 not cutting)", path,
                          report.type);
    if (status == OST_OK)
        status = tool_geometry(path, &geometry, &meta, &tool, err);
    if (status != OST_OK)
        return status;
    const ost_target target = {.volume = &volume};
    status = ost_volume_read_any(path, NULL, &target, &geometry, &meta, &report, &element, err);
    int64_t count = ost_dims_count(tool.dims);
    if (status == OST_OK && (element != OST_ELEMENT_UINT8 || ost_dims_count(geometry.dims) != count))
        status = ost_fail(err, OST_ERR_INPUT, "%s: file changed while it was read", path);
    if (status == OST_OK && (status = ost_tool_volume_init(out, &tool, err)) != OST_OK)
        ost_fail_context(err, "%s", path);
    for (int64_t i = 0; status == OST_OK && i < count; i++) {
        if (volume.voxels[i] > OST_TOOL_NONCUTTING)
            status = ost_fail(err, OST_ERR_INPUT, "%s: voxel (%lld, %lld, %lld) is %d; expected 0 (void), 1 "
                              "(cutting) or 2 (not cutting)", path, (long long)(i % tool.dims.x),
                              (long long)(i / tool.dims.x % tool.dims.y), (long long)(i / tool.dims.x / tool.dims.y),
                              volume.voxels[i]);
        else
            out->voxels[i] = (uint8_t)volume.voxels[i];
    }
    ost_volume_free(&volume);
    out->meta = meta;
    if (status != OST_OK)
        ost_tool_volume_free(out);
    return status;
}

ost_status ost_tool_volume_write(const char *path, const ost_tool_volume *tool, ost_error *err)
{
    const ost_tool_geometry *t = &tool->geometry;
    if (ost_volume_format_of(path) != OST_FORMAT_NRRD)
        return ost_fail(err, OST_ERR_USAGE, "%s: a tool grid is written as NRRD; expected a name that ends in .nrrd",
                        path);
    if (!tool->voxels)
        return ost_fail(err, OST_ERR_USAGE, "%s: the tool to write has no voxels", path);
    char x[OST_PM_TEXT], y[OST_PM_TEXT], z[OST_PM_TEXT], corner[3 * OST_PM_TEXT + 3], arithmetic[16];
    snprintf(corner, sizeof corner, "%s %s %s", ost_pm_format(t->corner.x, x), ost_pm_format(t->corner.y, y),
             ost_pm_format(t->corner.z, z));
    snprintf(arithmetic, sizeof arithmetic, "%d", OST_ARITHMETIC_VERSION);
    ost_meta meta = tool->meta;
    ost_status status = ost_meta_set(&meta, OST_META_KIND, "tool", err);
    if (status == OST_OK)
        status = ost_meta_set(&meta, OST_META_ARITHMETIC, arithmetic, err);
    if (status == OST_OK)
        status = ost_meta_set(&meta, OST_META_TOOL_CORNER, corner, err);
    if (status != OST_OK)
        return status;
    ost_pm h = t->voxel / 2;
    const ost_geometry geometry = {.dims = t->dims,
                                   .spacing = {t->voxel, t->voxel, t->voxel},
                                   .origin = {t->corner.x + h, t->corner.y + h, t->corner.z + h}};
    ost_volume_writer *writer;
    const ost_write_options options = {.compress = true};
    status = ost_volume_writer_open(path, &geometry, &meta, NULL, OST_ELEMENT_UINT8, t->voxel % 2 != 0, &options,
                                    &writer,
                                    err);
    if (status != OST_OK)
        return status;
    status = ost_volume_writer_put(writer, tool->voxels, (size_t)ost_dims_count(t->dims), err);
    if (status == OST_OK)
        return ost_volume_writer_commit(writer, err);
    ost_volume_writer_discard(writer);
    return status;
}
