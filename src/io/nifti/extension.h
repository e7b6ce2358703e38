/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Meta in a NIfTI file: lines "osteon KEY: VALUE" in a header extension of
 * code 6, a comment.
 *
 *   [extender 4] ( [esize int32] [ecode int32] [esize - 8 bytes] )*     up to the voxels
 */
#ifndef OST_IO_NIFTI_EXTENSION_H
#define OST_IO_NIFTI_EXTENSION_H

#include <osteon/grid.h>

#include "io/volume/input.h"

enum { OST_NIFTI_COMMENT_MAX = 1 << 16 };

/*
 * From the byte after the header's struct to `end` (UINT64_MAX: the file's
 * end).  Extensions of others are passed over; a chain that does not fit is
 * where they end, since they decide nothing.
 */
ost_status ost_nifti_extensions_read(ost_input *input, uint64_t end, bool swap, ost_meta *meta, ost_error *err);

/* Extender and one extension with these lines: a multiple of 16 less 348 bytes, so that 348 + size is the voxels' offset. */
size_t ost_nifti_extension_format(const ost_meta *meta, const ost_geometry *geometry, unsigned char *out, size_t room);

#endif
