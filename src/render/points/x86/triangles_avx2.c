/* SPDX-License-Identifier: Apache-2.0 */
/* The inner loop of triangles.c for AVX2. */
#include "core/conditions.h"
#include "render/points/triangle_row.h"

bool ost_triangle_row_avx2(const ost_triangles *t, const ost_flat_triangle *f, const ost_triangle_span *span, int y,
                           const ost_planes *planes)
{
    return ost_row_draw(t, f, span, y, planes);
}
