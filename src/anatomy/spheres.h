/* SPDX-License-Identifier: Apache-2.0 */
#ifndef OST_ANATOMY_SPHERES_H
#define OST_ANATOMY_SPHERES_H

#include "anatomy/surface.h"

/* Finds spheres on a surface, as ost_spheres_find does. *count may be 0. The options must be within their ranges. */
ost_status ost_anatomy_spheres(const anatomy_surface *surface, const ost_sphere_options *options, ost_sphere *out,
                               int most, int *count, ost_error *err);
/* Sets both radii to their defaults if both are 0, and checks the ranges of all options. */
ost_status ost_anatomy_sphere_options(ost_sphere_options *options, ost_error *err);
/* Returns OST_ERR_USAGE if the bone has no voxels, and OST_ERR_RANGE if its densities or its geometry are invalid. */
ost_status ost_anatomy_bone_check(const ost_anatomy_bone *bone, ost_error *err);

#endif
