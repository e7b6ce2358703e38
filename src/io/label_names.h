/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The names of the labels of a label map.
 *
 *   NRRD of 3D Slicer     SegmentK_Name:=scapula, SegmentK_LabelValue:=3
 *   NIfTI extension       <Label Key="3" ...><![CDATA[scapula]]></Label>  (TotalSegmentator, Caret)
 *   a file of names       lines "3 scapula", "3,scapula" (CSV, tables of 3D Slicer and ITK-SNAP),
 *                         or a JSON object {"3": "scapula"} or {"scapula": 3}
 *
 * A name has at most OST_LABEL_NAME - 1 bytes; a longer one is truncated.  Characters that a
 * terminal does not only display become '?'.
 */
#ifndef OST_IO_LABEL_NAMES_H
#define OST_IO_LABEL_NAMES_H

#include <osteon/io.h>

enum { OST_LABEL_NAME = 64, OST_LABEL_NAMES_MAX = 1024 };

typedef struct ost_label_names ost_label_names;

typedef struct ost_label_name {
    int32_t segment; /* K of SegmentK; -1 if the name has no such number */
    int32_t value;   /* -1 until the value is read */
    char name[OST_LABEL_NAME];
} ost_label_name;

/* Zero-initialise the struct before use. */
struct ost_label_names {
    ost_label_name *items; /* owned */
    int count;             /* names after the first OST_LABEL_NAMES_MAX are ignored */
};

/* Adds the names in the header of a label map. A MetaImage has no names. */
ost_status ost_label_names_read(const char *path, ost_nifti_form form, ost_label_names *names, ost_error *err);
/* Adds a name of `length` bytes. */
ost_status ost_label_names_add(ost_label_names *names, int32_t value, const char *name, size_t length, ost_error *err);
/* Adds the name or the value of a segment from a key and value of a NRRD header; ignores all other keys. */
ost_status ost_label_names_add_segment(ost_label_names *names, const char *key, const char *value, ost_error *err);
/* Adds the names of all elements <Label Key="N"> of a text, which is terminated by NUL. */
ost_status ost_label_names_add_xml(ost_label_names *names, const char *text, ost_error *err);
/* Adds the names in a file of names. */
ost_status ost_label_names_add_file(ost_label_names *names, const char *path, ost_error *err);

/*
 * Stores the value of a name, without regard to case.  Returns OST_ERR_INPUT with the existing names if there is no
 * such name, or if two labels have it.  mask is the label map, for messages.
 */
ost_status ost_label_names_find(const ost_label_names *names, const char *mask, const char *name, int16_t *value,
                                ost_error *err);
void ost_label_names_free(ost_label_names *names);

#endif
