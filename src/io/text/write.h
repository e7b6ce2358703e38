/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writes a volume in the text form of the thesis: one line "x y z density" per voxel, x fastest.
 *
 *   # osteon dims: 256 234 201
 *   # osteon spacing_mm: 0.47 0.47 1
 *   # osteon origin_mm: -57.34 12.2 3
 *   # osteon kind: ct                     and the other facts
 *   -57.34 12.20 3.00 1043
 *
 * The comments state the exact geometry, so the file is read back as the same volume for any number of decimals. The
 * dims allow a reader to detect an incomplete file.
 */
#ifndef OST_IO_TEXT_WRITE_H
#define OST_IO_TEXT_WRITE_H

#include <osteon/io.h>

/*
 * Writes a volume as text. options->text_decimals is the number of digits after the point, 1 to 9; 0 selects the
 * smallest number that represents all positions exactly. Returns OST_ERR_USAGE if rounding to this number of digits
 * would change a position by more than 1/8 of a voxel.
 *
 * If options->omit_empty is set, voxels of density 0 and the dims comment are omitted. A reader then takes the bounding
 * box of the remaining voxels as the grid, so origin_mm is the lower corner of this box. Returns OST_ERR_INPUT if every
 * voxel is 0. options may be NULL.
 */
ost_status ost_text_write_volume(const char *path, const ost_volume *volume, const ost_write_options *options,
                                 ost_error *err);

#endif
