/* SPDX-License-Identifier: Apache-2.0 */
/*
 * An oblique grid onto an axis-aligned one in LPS, by nearest voxel, on request.
 *
 *        file axes           result: the box of the file's voxel centres
 *           / \              +-------+
 *          /   \             |  / \  |   spacing along an LPS axis: the length of
 *          \   /             | /   \ |   the file axis that runs most nearly along it
 *           \ /              +-\---/-+
 *
 * All in integers.  Columns and origin are picometres; lengths are
 * floor(sqrt(sum of squares)).  The result's first centre is the least corner
 * of the box, dims = ceil(extent / spacing) + 1.  A result voxel at p takes
 * the file voxel RHE(adj(M) (p - origin) / det M) per axis, the exact inverse
 * in 128 bits; where that lies outside the file, the density is 0, as for
 * voxels that a text does not mention.
 */
#ifndef OST_IO_VOLUME_RESAMPLE_H
#define OST_IO_VOLUME_RESAMPLE_H

#include "io/volume/orient.h"

ost_status ost_resample_geometry(const ost_affine *affine, const int32_t sizes[3], const ost_placement *placement, ost_geometry *out,
                                 ost_error *err);
/* file has the file's voxels, its first axis fastest; out is initialised with the geometry from above. */
void ost_resample_nearest(const ost_affine *affine, const int32_t sizes[3], const int16_t *file, ost_volume *out);

#endif
