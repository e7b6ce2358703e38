/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Draws a smooth mesh into the planes of a frame, over the objects that are already drawn.
 *
 *   triangle --near plane, projection--> corners in 256ths of a pixel --a row's span of pixels--> depth, normal
 *                                                     nearer than the frame's depth --light--> colour
 *
 * Whether a triangle covers the middle of a pixel is decided by integers, so there is no gap between triangles that
 * share an edge. A pixel's depth and normal are computed by floats in a fixed order, without fused operations. The
 * triangles of a pixel are drawn in the order of the mesh, and a pixel belongs to one band. The picture is therefore
 * bit-identical for every instruction set and number of threads.
 */
#ifndef OST_RENDER_TRIANGLES_H
#define OST_RENDER_TRIANGLES_H

#include "render/points/cells.h"
#include "render/points/light.h"
#include "render/points/smooth_mesh.h"
#include "render/points/splat.h"

/* A triangle in the picture. The corners are in such an order that the triangle's area is positive. */
typedef struct ost_flat_triangle {
    int32_t x[3], y[3];      /* 256ths of a pixel from the picture's left and top edges */
    ost_extent pixels;       /* pixels whose middles the triangle may cover */
    float inverse[3];        /* 1 / distance along the forward axis, in voxels */
    float normal[3][3];      /* times `inverse`; turned to the eye */
} ost_flat_triangle;

typedef struct ost_triangles {
    ost_flat_triangle *triangle; /* owned */
    size_t count, capacity;
    int y0, y1;              /* half-open range of rows that the triangles may cover */
    ost_lamps lamps;
    uint32_t colour;
    float gloss, scale;      /* `scale`: side of the mesh's voxels in units of the frame's depth */
} ost_triangles;

/* The pixels from <= x < to of a row. The shares of corners 1 and 2 are b and c at `from`, and change from pixel to
   pixel by the steps. */
typedef struct ost_triangle_span {
    int from, to;
    float b, b_step, c, c_step;
} ost_triangle_span;

/* Draws a span of row y where it is nearer than the planes. Returns true if a pixel has changed. */
typedef bool ost_triangle_row(const ost_triangles *t, const ost_flat_triangle *f, const ost_triangle_span *span, int y,
                              const ost_planes *planes);
ost_triangle_row ost_triangle_row_scalar, ost_triangle_row_avx2;
ost_triangle_row *ost_triangle_row_for(ost_isa isa);

/* Projects the triangles of a mesh that may be visible. The memory is reused from frame to frame. */
ost_status ost_triangles_project(ost_triangles *t, const ost_smooth_mesh *mesh, const ost_eye *eye, ost_paint paint,
                                 float scale, ost_error *err);
/* Draws the rows y0 <= y < y1. Adds the cells of the spans in which a pixel changes to `over`. */
void ost_triangles_draw(const ost_triangles *t, ost_triangle_row *row, const ost_planes *planes, int y0, int y1,
                        const ost_cells *over);
void ost_triangles_free(ost_triangles *t);

#endif
