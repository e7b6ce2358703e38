/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A pyramid of a tool's grid, for octree.c. Each cell of a level has two flags: whether it contains a cutting tool
 * voxel, and whether all its tool voxels are cutting. A cell of level l has 2^(l + 1) tool voxels along each axis.
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

/*
 * The share of cutting voxels in a box of tool voxels: none, all or some. Voxels outside the tool's grid are not
 * cutting.
 */
typedef enum pyramid_found { PYRAMID_NONE, PYRAMID_ALL, PYRAMID_MIXED } pyramid_found;

/* Computes the levels for a tool. Returns false if memory is exhausted. The pyramid must be freed in both cases. */
bool pyramid_init(pyramid *p, const ost_tool_volume *tool);
void pyramid_free(pyramid *p);

/*
 * Returns the content of the box lo <= v <= hi of tool voxels. PYRAMID_NONE and PYRAMID_ALL are exact. PYRAMID_MIXED
 * may be returned for any box. Reads at most 27 cells.
 */
pyramid_found pyramid_content(const pyramid *p, const int32_t lo[3], const int32_t hi[3], const int32_t dims[3]);

#endif
