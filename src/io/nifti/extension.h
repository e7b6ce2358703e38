/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads and writes the header facts of a NIfTI file. They are lines "osteon KEY: VALUE" in a header extension with
 * code 6, which means a comment.
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
 * Reads the extensions from the byte after the header's struct up to the offset `end`; UINT64_MAX means the end of the
 * file. Extensions of other programs are skipped, except tables of label names, which have various codes. These names
 * are added to *names unless `names` is NULL. If an extension has an invalid size, reading ends without an error,
 * because header facts do not affect voxels.
 */
ost_status ost_nifti_extensions_read(ost_input *input, uint64_t end, bool swap, ost_meta *meta, ost_label_names *names,
                                     ost_error *err);

/*
 * Formats the extender and one extension that contains the header facts. Returns their size in bytes. The voxels
 * begin at the offset 348 + size, which is a multiple of 16.
 */
size_t ost_nifti_extension_format(const ost_meta *meta, const ost_geometry *geometry, unsigned char *out,
                                  size_t capacity);

#endif
