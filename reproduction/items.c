/* SPDX-License-Identifier: Apache-2.0 */
/* The list of items, in the order of the thesis, and the list of tables and figures that are not reproduced. */
#include <ctype.h>
#include <stdio.h>
#include <string.h>

#include "reproduction/item.h"

#define TIMES REPRODUCTION_TIMES
#define COUNTS REPRODUCTION_COUNTS
#define PICTURES REPRODUCTION_PICTURES

const reproduction_item reproduction_items[] = {
    {"figure-1.3", "The scapula as voxels", PICTURES, item_scapula},
    {"figure-1.4", "The five models as voxels", PICTURES, item_samples},
    {"figure-2.1", "The chunks of a scapula", PICTURES, item_partition},
    {"table-2.1", "Time of voxelizing the tools", TIMES, item_voxelize},
    {"figure-2.2", "Voxels of the CT before and after the transfer to the cubic grid", PICTURES, item_cubic},
    {"table-2.2", "Time of constructing the chunk grid from a CT", TIMES, item_import},
    {"figure-2.3", "Intersection of the boxes of bone and tool, and the chunks in it", PICTURES, item_boxes},
    {"figure-3.1", "Active and inactive chunks of the scapula", PICTURES, item_active_chunks},
    {"table-3.1", "Voxel grids of the models", COUNTS, item_model_grids},
    {"table-3.2", "Chunk grids of the models", COUNTS, item_model_chunks},
    {"figure-3.2", "Memory of the models by data structure", COUNTS, item_model_memory},
    {"figure-3.3", "Removal by the chunk system: bone voxels are compared with the tool", PICTURES, item_bone_to_tool},
    {"figure-3.4", "Removal from tool to bone: tool voxels are compared with the bone", PICTURES, item_tool_to_bone},
    {"figure-3.5", "Removal of a peg hole and of the glenoid's surface", PICTURES, item_removal},
    {"figure-3.6", "Static event of the reamer on the glenoid", TIMES, item_static_reamer},
    {"table-3.3", "Static event of the reamer, by size of the chunks", TIMES, item_event_reamer},
    {"figure-3.7", "Static event of the peg drill in the glenoid", TIMES, item_static_peg},
    {"table-3.4", "Static event of the peg drill, by size of the chunks", TIMES, item_event_peg},
    {"table-3.5", "Static event of the reamer, by size of the tool's voxels", TIMES, item_tool_voxels},
    {"table-3.6", "Machines of the measurements", COUNTS, item_machines},
    {"figure-3.8", "Event of the peg drill, by number of chunks", TIMES, item_chunk_counts},
    {"figure-3.9", "Event of the reamer by number of voxels, against other methods", TIMES, item_voxel_counts},
    {"section-3.2.3", "Voxels that the methods from tool to bone miss", COUNTS, item_holes},
    {"figure-3.10", "Chunks against the method of Reza", TIMES, item_reza},
    {"figure-3.11", "Chunks against the method of Zheng", TIMES, item_zheng},
    {"figure-3.12", "Chunks against the method of Yau", TIMES, item_yau},
    {"section-3.2.6", "Accuracy of the cut, by size of the tool's voxels", COUNTS, item_accuracy},
    {"table-3.7", "Memory of the scapula by method of drawing", COUNTS, item_render_memory},
    {"figure-3.13", "Frames of triangle meshes, by number of chunks", TIMES, item_mesh_frames},
    {"figure-3.14", "Frames of points, by number of chunks", TIMES, item_point_frames},
    {"figure-3.15", "Active voxels of the models", COUNTS, item_active_ratio},
    {"table-3.8", "Stages of generating the mesh of a chunk", TIMES, item_mesh_stages},
    {"section-3.3.3", "Frames while bone is removed, by method of drawing", TIMES, item_removal_frames},
    {"figure-3.16", "Frames of the cellular foam, by number of chunks", TIMES, item_foam_frames},
    {.id = NULL},
};

const reproduction_absent reproduction_missing[] = {
    {"figure-1.1", "Replacement of the joint", "a drawing of the anatomy, which the engine does not make"},
    {"figure-1.2", "Resurfacing of the glenoid", "a drawing of the operation, which the engine does not make"},
    {"figure-2.4", "Flow chart of the loops",
     "a drawing; ARCHITECTURE.md and docs/design/servo-loop.md show the loops of osteon"},
    {.id = NULL},
};

/* -------------------------------------------------------------------- names */

/* Converts a name to an id, for example "Table 3.3" to "table-3.3" and "fig 3.3" to "figure-3.3". */
static void normalise(const char *name, char out[RESULT_KEY])
{
    size_t at = 0;
    for (const char *c = name; *c && at + 1 < RESULT_KEY; c++)
        out[at++] = *c == ' ' || *c == '_' ? '-' : (char)tolower((unsigned char)*c);
    out[at] = 0;
    static const char *const shorts[] = {"fig.-", "fig-", "figure", "table", "fig"};
    for (size_t i = 0; i < sizeof shorts / sizeof shorts[0]; i++) {
        const size_t length = strlen(shorts[i]);
        if (strncmp(out, shorts[i], length) != 0)
            continue;
        char rest[RESULT_KEY];
        snprintf(rest, sizeof rest, "%s", out + length + (out[length] == '-'));
        snprintf(out, RESULT_KEY, "%s-%.32s", *shorts[i] == 't' ? "table" : "figure", rest);
        return;
    }
}

const reproduction_item *reproduction_find(const char *name)
{
    char id[RESULT_KEY];
    const reproduction_item *found = NULL;
    normalise(name, id);
    for (const reproduction_item *i = reproduction_items; i->id; i++) {
        if (strcmp(i->id, id) == 0)
            return i;
        const char *number = strchr(i->id, '-');
        if (number && strcmp(number + 1, id) == 0) {
            if (found)
                return NULL;
            found = i;
        }
    }
    return found;
}
