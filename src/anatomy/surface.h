/* SPDX-License-Identifier: Apache-2.0 */
/* Represents the surface of a field by points with outward normals. On the surface, the share of bone is 0.5. */
#ifndef OST_ANATOMY_SURFACE_H
#define OST_ANATOMY_SURFACE_H

#include "anatomy/field.h"

typedef struct anatomy_point {
    double at[3], normal[3]; /* position in mm, and outward unit vector */
    double area;             /* area in mm2 that the point represents */
} anatomy_point;

typedef struct anatomy_surface {
    anatomy_point *points; /* owned */
    size_t count, capacity;
} anatomy_surface;

/*
 * Finds the surface points. A point lies between two neighbouring cells, where the linearly interpolated share is 0.5.
 * Returns OST_ERR_RANGE if there are more than 2^22 points. The caller frees *out with ost_anatomy_surface_free, even
 * after a failure.
 */
ost_status ost_anatomy_surface_make(const anatomy_field *field, anatomy_surface *out, ost_error *err);
void ost_anatomy_surface_free(anatomy_surface *surface);

#endif
