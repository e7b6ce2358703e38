/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Facts in a NIfTI file: lines "osteon KEY: VALUE" in a header extension with
 * code 6, a comment.
 *
 *   [extender 4] ( [esize int32] [ecode int32] [esize - 8 bytes] )*     up to the voxels
 */
#ifndef OST_IO_NIFTI_EXTENSION_H
#define OST_IO_NIFTI_EXTENSION_H

#include <osteon/grid.h>

#include "io/label_names.h"
#include "io/volume/input.h"

enum { OST_NIFTI_COMMENT_MAX = 1 << 16, OST_NIFTI_NAMES_MAX = 1 << 20 };

/*
 * Reads the extensions from the byte after the header's struct to `end`
 * (UINT64_MAX: the file's end). Extensions of other programs are skipped. An
 * extension whose size does not fit ends the reading without an error, because
 * facts do not affect any voxel.  The names in tables of labels, which programs write with
 * different codes, are added to *names, unless names is NULL.
 */
ost_status ost_nifti_extensions_read(ost_input *input, uint64_t end, bool swap, ost_meta *meta, ost_label_names *names,
                                     ost_error *err);

/*
 * Formats the extender and one extension with these lines. Returns their size in bytes. The voxels begin at the
 * offset 348 + size, which is a multiple of 16.
 */
size_t ost_nifti_extension_format(const ost_meta *meta, const ost_geometry *geometry, unsigned char *out,
                                  size_t capacity);

#endif
