/* SPDX-License-Identifier: Apache-2.0 */
#include "core/conditions.h"

#include "anatomy/surface.h"

#include <stdlib.h>

#include "core/vector.h"

enum { POINTS_MAX = 1 << 22 };

static ost_status add(anatomy_surface *s, const anatomy_point *point, ost_error *err)
{
    if (s->count == POINTS_MAX)
        return ost_fail(err, OST_ERR_RANGE,
                        "the surface has more than %d points: raise the threshold, or pass one bone by its label",
                        POINTS_MAX);
    if (s->count == s->capacity) {
        const size_t wanted = s->capacity ? 2 * s->capacity : 4096;
        anatomy_point *grown = realloc(s->points, wanted * sizeof *grown);
        if (!grown)
            return ost_fail(err, OST_ERR_MEMORY, "out of memory for %zu points of a surface", wanted);
        s->points = grown;
        s->capacity = wanted;
    }
    s->points[s->count++] = *point;
    return OST_OK;
}

/*
 * Each surface point receives an area, and the sum of all areas is the area of the surface. Let n be the surface's unit
 * normal, and let A be the area of a cell's face across axis a. One unit of the surface then contains |n_a| / A points
 * along axis a, and each of them receives the area A |n_a|. The sum over the three axes is n_x^2 + n_y^2 + n_z^2 = 1.
 */
ost_status ost_anatomy_surface_make(const anatomy_field *f, anatomy_surface *out, ost_error *err)
{
    const size_t stride[3] = {1, (size_t)f->n[0], (size_t)f->n[0] * (size_t)f->n[1]};
    int32_t c[3];
    size_t i = 0;
    ost_status status = OST_OK;
    *out = (anatomy_surface){.points = NULL};
    for (c[2] = 0; c[2] < f->n[2]; c[2]++)
        for (c[1] = 0; c[1] < f->n[1]; c[1]++)
            for (c[0] = 0; c[0] < f->n[0] && status == OST_OK; c[0]++, i++)
                for (int a = 0; a < 3 && status == OST_OK; a++) {
                    if (c[a] + 1 == f->n[a])
                        continue;
                    const double here = (double)f->share[i], next = (double)f->share[i + stride[a]];
                    if ((here < 0.5) == (next < 0.5))
                        continue;
                    anatomy_point p;
                    for (int k = 0; k < 3; k++)
                        p.at[k] = f->origin[k] + c[k] * f->step[k];
                    p.at[a] += f->step[a] * (0.5 - here) / (next - here);
                    ost_anatomy_field_gradient(f, p.at, p.normal);
                    for (int k = 0; k < 3; k++)
                        p.normal[k] = -p.normal[k];
                    if (ost_vector_unit(p.normal, a) == 0)
                        continue;
                    p.area = f->step[(a + 1) % 3] * f->step[(a + 2) % 3] * fabs(p.normal[a]);
                    status = add(out, &p, err);
                }
    return status;
}

void ost_anatomy_surface_free(anatomy_surface *surface)
{
    free(surface->points);
    *surface = (anatomy_surface){.points = NULL};
}
