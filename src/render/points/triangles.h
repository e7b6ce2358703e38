/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Draws a smooth mesh into the planes of a frame, over the objects that are already drawn.
 *
 *   triangle --near plane, projection--> corners in 256ths of a pixel --a row's span of pixels--> depth, normal
 *                                                     nearer than the frame's depth --light--> colour
 *
 * Integer arithmetic determines whether a triangle covers the centre of a pixel, so there are no gaps between triangles
 * that share an edge. Depths and normals are computed with floats in a fixed order, without fused operations. The
 * triangles at a pixel are drawn in the order of the mesh, and a pixel belongs to one band. The picture is therefore
 * bit-identical for every instruction set and number of threads.
 */
#ifndef OST_RENDER_TRIANGLES_H
#define OST_RENDER_TRIANGLES_H

#include "render/points/cells.h"
#include "render/points/light.h"
#include "render/points/smooth_mesh.h"
#include "render/points/splat.h"

enum { OST_PIXEL_PARTS = 256 }; /* number of units per pixel of coordinates in the picture */

/* The position of a corner in the camera's frame and, if it is beyond the near plane, in the picture. */
typedef struct ost_flat_corner {
    float at[3];             /* position along the camera's axes right, up and forward */
    float inverse;           /* 1 / at[2] */
    int32_t x, y;            /* position in 256ths of a pixel, from the left and top edges of the picture */
} ost_flat_corner;

/* A triangle in the picture. The order of the corners makes the area positive. */
typedef struct ost_flat_triangle {
    int32_t x[3], y[3];      /* positions of the corners in 256ths of a pixel (ost_flat_corner) */
    float whole;             /* 1 / (2 * area of the triangle), with the area in units of (1/256 pixel)^2 */
    ost_extent pixels;       /* range of pixels whose centres the triangle may cover */
    float inverse[3];        /* reciprocal of each corner's distance along the forward axis, in voxels */
    float normal[3][3];      /* normal of each corner, turned to the eye and multiplied by `inverse` */
} ost_flat_triangle;

typedef struct ost_triangles {
    ost_flat_triangle *triangle; /* owned */
    size_t count, capacity;
    ost_flat_corner *corner; /* owned; projected corner for each position of the mesh */
    size_t corner_capacity;
    int y0, y1;              /* half-open range of rows that the triangles may cover */
    ost_lamps lamps;
    uint32_t colour;
    /* gloss: gloss of the paint; scale: edge length of the mesh's voxels, in units of the frame's depth */
    float gloss, scale;
} ost_triangles;

/* Draws the rows y0 <= y < y1 of a triangle, in the pixels where it is nearer than the depth in `planes`. Adds the
   cells of changed pixels to `over`. */
typedef void ost_triangle_rows(const ost_triangles *t, const ost_flat_triangle *f, const ost_planes *planes, int y0,
                               int y1, const ost_cells *over);
ost_triangle_rows ost_triangle_rows_scalar, ost_triangle_rows_avx2;
ost_triangle_rows *ost_triangle_rows_for(ost_isa isa);

/* Projects those triangles of a mesh that may be visible. Memory is reused from frame to frame. */
ost_status ost_triangles_project(ost_triangles *t, const ost_smooth_mesh *mesh, const ost_eye *eye, ost_paint paint,
                                 float scale, ost_error *err);
/* Draws the rows y0 <= y < y1 of all triangles. Adds the cells of changed pixels to `over`. */
void ost_triangles_draw(const ost_triangles *t, ost_triangle_rows *rows, const ost_planes *planes, int y0, int y1,
                        const ost_cells *over);
void ost_triangles_free(ost_triangles *t);

#endif
