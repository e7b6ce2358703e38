/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Resamples an oblique grid to an axis-aligned one in LPS by nearest voxel, on request.
 *
 *        file axes           result: the box of the file's voxel centres
 *           / \              +-------+
 *          /   \             |  / \  |   spacing along an LPS axis: the length of
 *          \   /             | /   \ |   the file axis that runs most nearly along it
 *           \ /              +-\---/-+
 *
 * All arithmetic is integer.  Columns and origin are in picometres; lengths are
 * floor(sqrt(sum of squares)).  The first centre of the result is the least corner
 * of the box, dims = ceil(extent / spacing) + 1.  A voxel of the result at p takes
 * the file voxel RHE(adj(M) (p - origin) / det M) on each axis, the exact inverse
 * in 128 bits; outside the file the density is 0, as for voxels without a sample
 * in a text file.
 */
#ifndef OST_IO_VOLUME_RESAMPLE_H
#define OST_IO_VOLUME_RESAMPLE_H

#include "io/volume/orient.h"

ost_status ost_resample_geometry(const ost_affine *affine, const int32_t sizes[3], const ost_placement *placement,
                                 ost_geometry *out, ost_error *err);
/*
 * Stores in each voxel of out the nearest voxel of the file. file: the file's voxels, with the file's first axis
 * fastest. out must be initialised with the geometry from ost_resample_geometry.
 */
void ost_resample_nearest(const ost_affine *affine, const int32_t sizes[3], const int16_t *file, ost_volume *out);

#endif
