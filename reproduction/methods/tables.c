/* SPDX-License-Identifier: Apache-2.0 */
/* The cases of the thesis' figures: chunk counts and resolutions. */
#include <stdio.h>

#include "reproduction/methods/measure.h"

#define HALF_MM (OST_PM_PER_MM / 2)
enum { CHUNK = 32 };

static void show(const methods_options *options, const char *text)
{
    if (options->show)
        options->show(options->user, text);
}

/* Appends the rows of a case whose scene cannot be made. The rows contain the error's text. Returns an error if there
   is no memory for the rows. */
static ost_status not_made(const methods_options *options, ost_tool_kind tool, const methods_row *scene,
                           methods_table *table, ost_error *err)
{
    const ost_error reason = *err;
    methods_row row = *scene;
    row.tool = ost_tool_kind_name(tool);
    *err = (ost_error){.status = OST_OK};
    return methods_not_measured(options, &row, reason.text, table, err);
}

/*
 * Returns the number of voxels along each axis of a bone in which the tool enters at least 64 chunks. A peg is smaller
 * than a reamer, so its bone needs more voxels.
 */
static int32_t counts_side(ost_tool_kind tool)
{
    return tool == OST_TOOL_REAMER ? 2 * SCENE_SIDE : 4 * SCENE_SIDE;
}

ost_status methods_chunk_counts(const methods_options *options, ost_tool_kind tool, const int *counts, int count,
                                methods_table *table, ost_error *err)
{
    const int32_t side = counts_side(tool);
    const methods_row row_of_case = {.tool_voxel = HALF_MM * SCENE_SIDE / side, .bone_side = side, .chunk_size = CHUNK,
                                     .bone_voxel = SCENE_SIDE * SCENE_SPACING / side};
    ost_status status = methods_check(options, err);
    for (int c = 0; c < count && status == OST_OK; c++) {
        methods_row row = row_of_case;
        methods_scene scene = {.voxels = NULL};
        char text[BENCH_TEXT];
        if (counts[c] < 1)
            return ost_fail(err, OST_ERR_USAGE, "a number of chunks is %d; it must be at least 1", counts[c]);
        row.chunks = counts[c];
        snprintf(text, sizeof text, "%s, %d chunks", ost_tool_kind_name(tool), counts[c]);
        show(options, text);
        status = methods_scene_middle(&scene, tool, row.tool_voxel, side, CHUNK, counts[c], err);
        if (status == OST_OK)
            status = methods_measure(options, &scene, CHUNK, table, err);
        else
            status = not_made(options, tool, &row, table, err);
        methods_scene_free(&scene);
    }
    return status;
}

/* Returns the edge length of tool voxels for which the longest side of the tool's grid has about `side` voxels. The
   grid is a few voxels larger than the tool. */
static ost_pm tool_voxel_of(ost_tool_kind tool, int32_t side)
{
    const ost_pm longest = tool == OST_TOOL_REAMER ? 36 * OST_PM_PER_MM : 30 * OST_PM_PER_MM;
    const int32_t inner = side > 8 ? side - 4 : side;
    return (longest + inner - 1) / inner;
}

static ost_status resolution(const methods_options *options, ost_tool_kind tool, int32_t tool_side, int32_t bone_side,
                             methods_table *table, ost_error *err)
{
    const double t = tool_side, b = bone_side;
    /* The memory in bytes for the bone's densities, and for the tool and its voxelization. */
    const double bytes = 2 * b * b * b + 4 * t * t * t;
    const methods_row row = {.tool_voxel = tool_voxel_of(tool, tool_side), .tool_side = tool_side,
                             .bone_side = bone_side, .bone_voxel = SCENE_SIDE * SCENE_SPACING / bone_side,
                             .chunk_size = CHUNK};
    methods_scene scene = {.voxels = NULL};
    ost_status status = OST_OK;
    if (bytes > (double)bench_memory())
        status = ost_fail(err, OST_ERR_MEMORY, "the bone and the tool take %.1f GB; less is free here", bytes * 1e-9);
    if (status == OST_OK)
        status = methods_scene_static(&scene, tool, row.tool_voxel, bone_side, err);
    if (status == OST_OK)
        status = methods_measure(options, &scene, CHUNK, table, err);
    else
        status = not_made(options, tool, &row, table, err);
    methods_scene_free(&scene);
    return status;
}

ost_status methods_resolutions(const methods_options *options, ost_tool_kind tool, const int32_t *tool_sides,
                               int tool_count, const int32_t *bone_sides, int bone_count, methods_table *table,
                               ost_error *err)
{
    ost_status status = methods_check(options, err);
    for (int b = 0; b < bone_count && status == OST_OK; b++)
        for (int t = 0; t < tool_count && status == OST_OK; t++) {
            char text[BENCH_TEXT];
            if (tool_sides[t] < 8 || tool_sides[t] > OST_TOOL_DIM_REMOVE_MAX || bone_sides[b] < 8)
                return ost_fail(err, OST_ERR_USAGE, "a tool of %d^3 and a bone of %d^3 voxels; 8 to %d, and at least 8",
                                tool_sides[t], bone_sides[b], OST_TOOL_DIM_REMOVE_MAX);
            snprintf(text, sizeof text, "%s of %d^3, bone of %d^3", ost_tool_kind_name(tool), tool_sides[t],
                     bone_sides[b]);
            show(options, text);
            status = resolution(options, tool, tool_sides[t], bone_sides[b], table, err);
        }
    return status;
}
