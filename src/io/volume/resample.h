/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Resamples an oblique grid to an axis-aligned grid in LPS, using the nearest voxel. This happens only on request.
 *
 *        file axes           result: the box of the file's voxel centres
 *           / \              +-------+
 *          /   \             |  / \  |   spacing along an LPS axis: the length of
 *          \   /             | /   \ |   the file axis that runs most nearly along it
 *           \ /              +-\---/-+
 *
 * All arithmetic is integer. Columns and origin are in picometres; lengths are floor(sqrt(sum of squares)). The
 * first voxel centre of the result is the corner of the box with the smallest coordinates, and dims = ceil(extent /
 * spacing) + 1. M is the matrix of the columns. A voxel of the result at the position p takes the density of the
 * file voxel adj(M) (p - origin) / det M, computed exactly in 128 bits and rounded half to even. Outside the file, the
 * density is 0, as for voxels without a sample in a text file.
 */
#ifndef OST_IO_VOLUME_RESAMPLE_H
#define OST_IO_VOLUME_RESAMPLE_H

#include "io/volume/orient.h"

ost_status ost_resample_geometry(const ost_affine *affine, const int32_t sizes[3], const ost_placement *placement,
                                 ost_geometry *out, ost_error *err);
/*
 * Stores in each voxel of `out` the density of the nearest voxel of the file. `file` contains the file's voxels, with
 * the file's first axis fastest. `out` must be initialised with the geometry from ost_resample_geometry.
 */
void ost_resample_nearest(const ost_affine *affine, const int32_t sizes[3], const int16_t *file, ost_volume *out);

#endif
