/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The header of a NRRD file (teem.sourceforge.net/nrrd/format.html), versions 1 to 5.
 *
 *   NRRD0005
 *   # comment
 *   field: description
 *   key:=value
 *   <empty line>              then the data, unless `data file` names them
 *
 * Fields are accepted in any order, although the format requires `dimension` first.
 * The header is read in two steps: header.c splits the text into fields, and
 * meaning.c interprets the fields. Unknown fields and repeated fields are errors, because they are more likely mistakes
 * than extensions.
 */
#ifndef OST_IO_NRRD_HEADER_H
#define OST_IO_NRRD_HEADER_H

#include <osteon/io.h>

#include "io/label_names.h"
#include "io/volume/data_files.h"
#include "io/volume/element.h"
#include "io/volume/header_lines.h"
#include "io/volume/orient.h"
#include "io/volume/input.h"

/*
 * Applies X(identifier, spellings separated by |) to each field that the reader uses. IGNORED lists the fields that the
 * reader ignores.
 */
#define OST_NRRD_FIELDS(X)                         \
    X(DIMENSION, "dimension")                      \
    X(TYPE, "type")                                \
    X(ENCODING, "encoding")                        \
    X(ENDIAN, "endian")                            \
    X(SIZES, "sizes")                              \
    X(SPACINGS, "spacings")                        \
    X(UNITS, "units")                              \
    X(KINDS, "kinds")                              \
    X(SPACE, "space")                              \
    X(SPACE_DIMENSION, "space dimension")          \
    X(SPACE_UNITS, "space units")                  \
    X(SPACE_ORIGIN, "space origin")                \
    X(SPACE_DIRECTIONS, "space directions")        \
    X(LINE_SKIP, "line skip|lineskip")             \
    X(BYTE_SKIP, "byte skip|byteskip")             \
    X(DATA_FILE, "data file|datafile")             \
    X(IGNORED, "content|number|block size|blocksize|min|max|old min|oldmin|old max|oldmax|sample units|sampleunits|" \
               "thicknesses|axis mins|axismins|axis maxs|axismaxs|centers|centerings|labels|measurement frame")

typedef enum ost_nrrd_field {
#define OST_NRRD_FIELD_ENUM(name, spellings) OST_NRRD_##name,
    OST_NRRD_FIELDS(OST_NRRD_FIELD_ENUM)
#undef OST_NRRD_FIELD_ENUM
    OST_NRRD_FIELD_COUNT
} ost_nrrd_field;

/* The text of a header, split into fields. */
typedef struct ost_nrrd_text {
    ost_header_lines lines;
    struct {
        char *value; /* value of the field; NULL if the field is absent */
        long line;
    } field[OST_NRRD_FIELD_COUNT];
    const char *list; /* file names of `data file: LIST`, one per line, each terminated by NUL */
    size_t list_bytes;
    ost_meta meta; /* header facts from lines osteon_KEY:=VALUE */
    bool labels;   /* true if there is a key Segment0_..., which marks a segmentation of 3D Slicer */
} ost_nrrd_text;

/*
 * Reads a header from the start of the file and leaves the input at the first byte after the header. *out is
 * initialised in all cases and can always be freed. Label names of a segmentation are added to *names unless `names` is
 * NULL.
 */
ost_status ost_nrrd_text_read(ost_input *input, ost_label_names *names, ost_nrrd_text *out, ost_error *err);
void ost_nrrd_text_free(ost_nrrd_text *text);

/* The header of a NRRD file after its fields have been interpreted. */
typedef struct ost_nrrd_header {
    ost_element element;
    ost_data_form encoding;
    bool swap;
    int32_t sizes[3];
    ost_affine affine; /* transform from voxels to LPS */
    bool oriented;     /* true if the space is one of the patient's spaces: RAS, LAS or LPS */
    uint64_t line_skip;
    int64_t byte_skip; /* bytes to skip before the data; -1 if the data end at the end of the file */
} ost_nrrd_header;

ost_status ost_nrrd_header_mean(const char *path, const ost_nrrd_text *text, ost_nrrd_header *out, ost_error *err);

#endif
