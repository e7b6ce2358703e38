/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A pyramid of a tool's grid, for octree.c: each cell of a level states whether its tool voxels include a cutting one,
 * and whether all of them are cutting. Cells of level l have 2^(l + 1) tool voxels along each axis.
 */
#ifndef OST_REPRODUCTION_METHODS_PYRAMID_H
#define OST_REPRODUCTION_METHODS_PYRAMID_H

#include <osteon/tool.h>

enum { PYRAMID_MAX = 11 };

typedef struct pyramid {
    uint8_t *flags[PYRAMID_MAX]; /* owned; x fastest */
    int32_t dims[PYRAMID_MAX][3];
    int levels;
} pyramid;

/* The cutting voxels in a box of tool voxels. Voxels outside the tool's grid are not cutting. */
typedef enum pyramid_found { PYRAMID_NONE, PYRAMID_ALL, PYRAMID_MIXED } pyramid_found;

/* Makes the levels of a tool. Returns false if there is no memory; the pyramid must be freed in any case. */
bool pyramid_init(pyramid *p, const ost_tool_volume *tool);
void pyramid_free(pyramid *p);

/*
 * Returns the content of the box lo <= v <= hi of tool voxels. PYRAMID_MIXED is always a possible result; the other
 * results are exact. Reads at most 27 cells.
 */
pyramid_found pyramid_content(const pyramid *p, const int32_t lo[3], const int32_t hi[3], const int32_t dims[3]);

#endif
