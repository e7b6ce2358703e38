/* SPDX-License-Identifier: Apache-2.0 */
/* The inner loop of triangles.c for AVX2. */
#include "core/conditions.h"
#include "render/points/triangle_row.h"

void ost_triangle_rows_avx2(const ost_triangles *t, const ost_flat_triangle *f, const ost_planes *planes, int y0,
                            int y1, const ost_cells *over)
{
    ost_row_triangle(t, f, planes, y0, y1, over);
}
