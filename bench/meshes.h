/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The meshes of docs/log/0.1.md. Each mesh is scaled to the middle 98 % of a cube.
 *
 *   sphere80k   a tilted sphere of 300 meridians and 135 bands: 80,400 triangles
 *   knot524k    a tube of 2048 x 128 quads around a (2, 3) torus knot: 524,288 triangles
 *   balls       spheres side by side in one mesh
 */
#ifndef OST_BENCH_MESHES_H
#define OST_BENCH_MESHES_H

#include <osteon/mesh.h>

/* bench_sphere and bench_knot create a mesh. On the longest axis, its vertices span 98 % of `side` (picometres). */
ost_status bench_sphere(ost_pm side, ost_mesh *out, ost_error *err);
ost_status bench_knot(ost_pm side, ost_mesh *out, ost_error *err);

/* Creates a mesh of across^3 tilted spheres that do not touch. Each sphere has two poles, meridians * rings other
   vertices, and 2 * meridians * rings triangles. There must be at least 3 meridians and 1 ring. */
ost_status bench_balls(ost_pm side, int across, int meridians, int rings, ost_mesh *out, ost_error *err);

#endif
