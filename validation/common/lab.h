/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Helper functions of the checks. The struct `lab` contains the state of the checks, including the first
 * error. After an error every call returns without effect, so that the code of a check needs no error handling.
 */
#ifndef OST_VALIDATION_COMMON_LAB_H
#define OST_VALIDATION_COMMON_LAB_H

#include <jansson.h>
#include <osteon/backend.h>
#include <osteon/event.h>
#include <osteon/mesh.h>
#include <osteon/tool.h>

#include "validation/draw.h"

#define LAB_MM OST_PM_PER_MM

typedef struct lab {
    ost_backend *backend;
    json_t *checks;
    uint64_t seed;
    ost_status status;
    ost_error *err;
} lab;

/* Adds the result of a check. Names in `requirements` are separated by blanks. Only `passed` determines the result;
   `expected` and `got` are texts for readers. */
void lab_record(lab *l, const char *kind, const char *name, const char *requirements, const char *what, bool passed,
                const char *expected, const char *got, ...) OST_PRINTF(8, 9);

/* Returns a geometry with equal spacing on all axes and its first centre at the origin. */
ost_geometry lab_cube(int32_t nx, int32_t ny, int32_t nz, ost_pm spacing);
/* Makes a tool in which every voxel has the given class. */
ost_tool *lab_tool(lab *l, ost_dims dims, ost_pm voxel, ost_pm3 corner, uint8_t tool_class);
ost_tool *lab_random_tool(lab *l, draw *d, ost_dims dims, ost_pm voxel, ost_pm3 corner);
ost_pose lab_random_pose(lab *l, draw *d, ost_pm size);
/* Fills voxels with random densities: 0 in one voxel out of four, 120 to 1000 in the others. */
void lab_fill(draw *d, int16_t *voxels, int64_t count);

/* Makes a bone of `voxels`, runs one event with these poses, and writes the resulting bone to `voxels`. `report` may
   be NULL. */
void lab_remove(lab *l, const ost_geometry *g, int chunk, int16_t *voxels, const ost_tool *tool, const ost_pose *poses,
                int count, ost_removal_report *report);
uint64_t lab_removed(lab *l, const ost_geometry *g, const ost_tool *tool, const ost_pose *poses, int count,
                     int16_t density);

/* Makes a box of twelve triangles. Seen from outside, their corners are counter-clockwise, or clockwise if inside_out
   is true. */
void lab_box(lab *l, ost_pm3 min, ost_pm3 max, bool inside_out, ost_mesh *out);
/* Voxelizes a mesh on the given grid or, if `grid` is NULL, on the grid of the mesh's bounds. Initialises *out. */
void lab_voxelize(lab *l, const ost_mesh *mesh, const ost_tool_geometry *grid, ost_pm voxel, ost_tool_volume *out);

void lab_golden(lab *l);
void lab_volumes(lab *l);
void lab_relations(lab *l);

#endif
