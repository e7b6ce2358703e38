/* SPDX-License-Identifier: Apache-2.0 */
/* Makes the tools, grids and cuts that several measurements share. */
#ifndef OST_BENCH_INPUTS_H
#define OST_BENCH_INPUTS_H

#include <osteon/backend.h>
#include <osteon/phantom.h>

#include "render/points/surface.h"

/* Voxelizes a parametric tool on a backend, with cubic voxels whose edge length is `voxel`. If `options` is NULL, the
   tool has its default size. The caller frees *out before it closes the backend. */
ost_status bench_tool_make(ost_backend *backend, ost_tool_kind kind, const ost_tool_options *options, ost_pm voxel,
                           ost_tool **out, ost_error *err);
/*
 * Voxelizes a parametric tool of the default size on the backend that the string `spec` selects, and copies the tool to
 * host memory. The caller frees *out.
 */
ost_status bench_tool_volume(const char *spec, ost_tool_kind kind, ost_pm voxel, ost_tool_volume *out, ost_error *err);

/* Converts a rect grid to cubic voxels by linear interpolation on a backend. The caller frees *out. */
ost_status bench_cubic_make(ost_backend *backend, const ost_volume *rect, ost_volume *out, ost_error *err);

/* Removes the voxels inside a ball from a surface. The ball's centre `at` and its `radius` are in voxels. *changed
   receives the number of changed blocks. */
ost_status bench_carve(ost_surface *surface, const double at[3], double radius, int32_t *changed, ost_error *err);

#endif
