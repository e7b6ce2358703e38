/* SPDX-License-Identifier: Apache-2.0 */
/* Section 3.2.3: the bone voxels that tool-to-bone methods miss, as a table and as a picture. */
#include <stdio.h>
#include <stdlib.h>

#include "core/memory_stream.h"
#include "reproduction/item.h"

enum { HOLES_CASE, HOLES_RATIO, HOLES_POINTS, HOLES_EXPECTED, HOLES_MISSED, HOLES_INSIDE };

static ost_status add_holes(result *out, ost_tool_kind tool, methods_points points, int poses, const char *label,
                            ost_error *err)
{
    static const double ratios[] = {0.25, 0.5, 0.75, 1, 1.25, 1.5, 2, 3};
    enum { RATIOS = sizeof ratios / sizeof ratios[0] };
    methods_sample samples[RATIOS];
    ost_status status = methods_sampling(tool, points, poses, ratios, RATIOS, samples, err);
    for (int i = 0; i < RATIOS && status == OST_OK; i++) {
        result_add_row(out);
        result_set_text(out, HOLES_CASE, "%s", label);
        result_set(out, HOLES_RATIO, samples[i].ratio);
        result_set(out, HOLES_POINTS, (double)samples[i].tool_points);
        result_set(out, HOLES_EXPECTED, (double)samples[i].expected);
        result_set(out, HOLES_MISSED, 100 * samples[i].missed_share);
        result_set(out, HOLES_INSIDE, 100 * samples[i].missed_inside_share);
    }
    return status;
}

/* Adds a drawing of one slice, in which each removed voxel is a square. */
static ost_status add_slice(result *out, double ratio, ost_error *err)
{
    enum { CELL = 7, MARGIN = 8 };
    static const char *const fill[] = {NULL, "#56B4E9", "#E69F00", "#8B2500", "#000000"};
    methods_slice slice;
    ost_memory_stream memory;
    char caption[RESULT_TEXT];
    ost_status status = methods_sampling_slice(OST_TOOL_PEG, METHODS_POINTS_SOLID, 1, ratio, &slice, err);
    if (status != OST_OK)
        return status;
    FILE *to = ost_memory_stream_open(&memory);
    if (!to) {
        methods_slice_free(&slice);
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a slice");
    }
    const int width = slice.width * CELL + 2 * MARGIN, height = slice.height * CELL + 2 * MARGIN;
    fprintf(to,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%d\" height=\"%d\" viewBox=\"0 0 %d %d\" "
            "role=\"img\"><title>voxels that tool points miss</title><rect width=\"%d\" height=\"%d\" "
            "fill=\"#ffffff\"/><g stroke=\"#ffffff\" stroke-width=\"0.6\">\n",
            width, height, width, height, width, height);
    for (int32_t y = 0; y < slice.height; y++)
        for (int32_t x = 0; x < slice.width; x++) {
            const uint8_t value = slice.values[x + slice.width * y];
            if (value != METHODS_SLICE_NONE)
                fprintf(to, "<rect x=\"%d\" y=\"%d\" width=\"%d\" height=\"%d\" fill=\"%s\"/>\n", MARGIN + x * CELL,
                        MARGIN + (slice.height - 1 - y) * CELL, CELL, CELL, fill[value]);
        }
    fputs("</g></svg>\n", to);
    methods_slice_free(&slice);
    if (!ost_memory_stream_close(to, &memory))
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a slice");
    snprintf(caption, sizeof caption,
             "A slice of the hole that the peg drill cuts, with tool voxels %.3g times as long as bone voxels and a "
             "point in "
             "every tool voxel. Light blue: removed by both; orange: missed by the points at the rim; dark red: "
             "missed, with "
             "all neighbours in the tool; black: removed by the points only.",
             ratio);
    result_add_picture(out, "section-3.2.3-slice.svg", caption, (uint8_t *)memory.bytes, memory.size);
    return OST_OK;
}

ost_status item_holes(reproduction *r, result *out, ost_error *err)
{
    enum { POSES = 24, POSES_QUICK = 4 };
    const int poses = r->bench.quick ? POSES_QUICK : POSES;
    result_add_column(out, "case", "tool points", "text");
    result_add_column(out, "ratio", "tool voxel / bone voxel", "");
    result_add_column(out, "points", "points", "");
    result_add_column(out, "expected_voxels", "voxels in the tool", "");
    result_add_column(out, "missed_percent", "missed", "%");
    result_add_column(out, "missed_inside_percent", "missed, surrounded", "%");
    reproduction_show(r, "holes of sampling", 0);
    ost_status status = add_holes(out, OST_TOOL_PEG, METHODS_POINTS_SOLID, 1, "peg drill, all voxels, one pose", err);
    if (status == OST_OK)
        status = add_holes(out, OST_TOOL_PEG, METHODS_POINTS_SURFACE, 1, "peg drill, surface, one pose", err);
    if (status == OST_OK)
        status = add_holes(out, OST_TOOL_PEG, METHODS_POINTS_SURFACE, poses, "peg drill, surface, moving", err);
    if (status == OST_OK)
        status = add_slice(out, 1.25, err);
    result_add_remark(out,
                      "The methods of Zheng, Yau and Reza remove the bone voxels that contain a point of the tool. The "
                      "thesis compares their times, but not their results. A missed voxel is one whose centre is in "
                      "the tool and that contains no point; `surrounded` ones have six removed neighbours in osteon's "
                      "result, so that they are holes and not parts of the rim. Moving: %d poses along the tool's "
                      "axis, half a bone voxel apart.",
                      poses);
    result_plot *p = result_add_plot(out, RESULT_PLOT_LINES, "Voxels that tool points miss", "tool voxel / bone voxel",
                                     "missed voxels (%)");
    p->x = HOLES_RATIO;
    p->group = HOLES_CASE;
    p->value[p->values++] = HOLES_MISSED;
    return status;
}
