/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Interprets a NIfTI-1 or -2 header.
 *
 * libnifti converts a raw header to native byte order and a struct. It does not check the header, so every field on
 * which it relies is checked here first. Voxels are never read through libnifti, because it would replace NaN with 0
 * and load the complete file into memory.
 *
 *   orientation   sform if its code is 1 (scanner) or 2 (aligned), otherwise
 *                 qform if its code is > 0, otherwise sform if its code is > 2,
 *                 otherwise only pixdim with origin 0: a file without orientation.
 *                 (Codes above 2 map to a template brain, which does not have the
 *                 patient's size.)  An sform and a qform that both map to the
 *                 patient must agree to within a voxel, unless the caller
 *                 chooses one
 *   lengths       xyzt_units m, mm or um; none means mm.  A float32 represents
 *                 the shortest decimal that rounds to the same float32 (AR-LEN-4)
 *   spacing       for an axis that runs exactly along R, A or S: the component
 *                 of the sform; for an axis within 1/1000 of R, A or S (the
 *                 noise of a quaternion): pixdim, if the lengths agree to 1/10000
 *   values        density = value * slope + intercept; a slope of 0, NaN or
 *                 infinity means density = value
 *
 * header.c computes the affine with only + * / and sqrt of doubles, which IEEE 754 defines exactly. The file is
 * compiled without contraction.
 */
#ifndef OST_IO_NIFTI_HEADER_H
#define OST_IO_NIFTI_HEADER_H

#include <osteon/io.h>

#include "io/label_names.h"
#include "io/volume/element.h"
#include "io/volume/orient.h"
#include "io/volume/input.h"

typedef struct ost_nifti_header {
    int version;
    bool swap;
    bool pair;           /* true if the header and the image are in two files */
    uint64_t image_at;   /* offset of the first voxel in the file that contains the image */
    ost_element element;
    int32_t sizes[3];
    bool scaled;
    ost_binary slope, intercept;
    bool labels;       /* true if the file's intent is NIFTI_INTENT_LABEL, that is, if the voxels are labels */
    bool oriented;
    ost_affine affine; /* transform from voxels to LPS */
    ost_meta meta;     /* header facts from "osteon KEY: VALUE" lines in comments (extension code 6) */
} ost_nifti_header;

/*
 * Reads the header and its extensions. The input must be at the start of the (unpacked) file. Label names are added to
 * *names unless names is NULL.
 */
ost_status ost_nifti_header_read(ost_input *input, ost_nifti_form chosen, ost_label_names *names, ost_nifti_header *out,
                                 ost_error *err);

/*
 * Keys of the lines in which osteon's writer stores exact lengths. The reader uses the exact lengths only if, rounded
 * to float, they equal the lengths in the header.
 */
#define OST_NIFTI_SPACING "spacing_mm"
#define OST_NIFTI_ORIGIN "origin_mm"
enum { OST_NIFTI_COMMENT = 6 };

#endif
