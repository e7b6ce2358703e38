/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A volume as the thesis' text: every voxel a line "x y z density", x fastest.
 *
 *   # osteon dims: 256 234 201
 *   # osteon spacing_mm: 0.47 0.47 1
 *   # osteon origin_mm: -57.34 12.2 3
 *   # osteon kind: ct                     and the other meta
 *   -57.34 12.20 3.00 1043
 *
 * With its comments it reads back as the same volume, whatever the decimals;
 * dims let a reader see that the file is whole.
 */
#ifndef OST_IO_TEXT_WRITE_H
#define OST_IO_TEXT_WRITE_H

#include <osteon/grid.h>

/*
 * decimals: digits after the point, 1 to 9; 0 = as many as the positions
 * need.  OST_ERR_USAGE when they are so few that a position would end more
 * than 1/8 of a voxel off.
 */
ost_status ost_text_write_volume(const char *path, const ost_volume *volume, int decimals, ost_error *err);

#endif
