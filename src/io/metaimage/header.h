/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The header of a MetaImage file, .mha or .mhd (itk.org/Wiki/MetaIO/Documentation).
 *
 *   Key = Value              in any order; keys that have no effect are ignored
 *   osteon_KEY = VALUE       a fact (AR-FILE-8)
 *   ElementDataFile = ...    the last key: LOCAL (the data follow) or the names of files (volume/data_files.h)
 *
 * As in ITK, positions are in millimetres in LPS, each row of TransformMatrix is the direction of one axis of the grid,
 * and Offset is the centre of the first voxel. AnatomicalOrientation is ignored, as in ITK, because many programs write
 * it without regard to the matrix. A spacing is rounded half to even to picometres before it is multiplied by a
 * direction, and the product is rounded again. Without BinaryDataByteOrderMSB, numbers are little-endian on every host.
 */
#ifndef OST_IO_METAIMAGE_HEADER_H
#define OST_IO_METAIMAGE_HEADER_H

#include <osteon/io.h>

#include "io/volume/data_files.h"
#include "io/volume/element.h"
#include "io/volume/header_lines.h"
#include "io/volume/orient.h"

typedef struct ost_metaimage_header {
    ost_header_lines lines; /* owned; lines of the header, to which `names` refers */
    ost_data_names names;
    ost_element element;
    ost_data_form form;     /* OST_DATA_RAW or OST_DATA_ZLIB */
    bool swap;
    int32_t sizes[3];
    int64_t byte_skip;      /* bytes to skip before the data; -1 if the data end at the end of the file */
    ost_affine affine;      /* transform from voxels to LPS */
    bool oriented;          /* true if the header has a TransformMatrix */
    ost_meta meta;          /* facts from the lines osteon_KEY = VALUE */
} ost_metaimage_header;

/* Returns true if a file that starts with these bytes is a MetaImage header. */
bool ost_metaimage_sniff(const unsigned char *head, size_t size);

/*
 * Reads the header from the start of the input and leaves the input at the first byte after the header. *out is
 * initialised in all cases, and may be passed to ost_metaimage_header_free even after a failure.
 */
ost_status ost_metaimage_header_read(ost_input *input, ost_metaimage_header *out, ost_error *err);
void ost_metaimage_header_free(ost_metaimage_header *header);

#endif
