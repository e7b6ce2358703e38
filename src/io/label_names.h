/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The names of the labels of a label map.
 *
 *   NRRD of 3D Slicer     SegmentK_Name:=scapula, SegmentK_LabelValue:=3
 *   NIfTI extension       <Label Key="3" ...><![CDATA[scapula]]></Label>  (TotalSegmentator, Caret)
 *   a file of names       lines "3 scapula", "3,scapula" (CSV, tables of 3D Slicer and ITK-SNAP),
 *                         or a JSON object {"3": "scapula"} or {"scapula": 3}
 *
 * A name has at most OST_LABEL_NAME - 1 bytes; a longer one is truncated. Control characters, which could change the
 * state of a terminal, are replaced by '?'.
 */
#ifndef OST_IO_LABEL_NAMES_H
#define OST_IO_LABEL_NAMES_H

#include <osteon/io.h>

enum { OST_LABEL_NAME = 64, OST_LABEL_NAMES_MAX = 1024 };

typedef struct ost_label_names ost_label_names;

typedef struct ost_label_name {
    int32_t segment; /* number K of the key SegmentK; -1 if the name comes from another source */
    int32_t value;   /* value of the label; -1 until it has been read */
    char name[OST_LABEL_NAME];
} ost_label_name;

/* The names of the labels. The struct must be zero-initialised before its first use. */
struct ost_label_names {
    ost_label_name *items; /* owned */
    int count;             /* number of names, at most OST_LABEL_NAMES_MAX; further names are ignored */
};

/* Adds the names that the header of a label map contains. A MetaImage contains no names. */
ost_status ost_label_names_read(const char *path, ost_nifti_form form, ost_label_names *names, ost_error *err);
/*
 * Adds the name or the value of a segment, given the key and the value of a line in a NRRD header. Ignores all other
 * keys.
 */
ost_status ost_label_names_add_segment(ost_label_names *names, const char *key, const char *value, ost_error *err);
/* Adds the names of all elements <Label Key="N"> in a NUL-terminated text. */
ost_status ost_label_names_add_xml(ost_label_names *names, const char *text, ost_error *err);
/* Adds all names from a file of names. */
ost_status ost_label_names_add_file(ost_label_names *names, const char *path, ost_error *err);

/*
 * Stores in *value the label with the given name; case is ignored. Returns OST_ERR_INPUT if several labels have this
 * name, or if none has; in the latter case, the message lists the existing names. `mask` is the path of the label map,
 * for the message.
 */
ost_status ost_label_names_find(const ost_label_names *names, const char *mask, const char *name, int16_t *value,
                                ost_error *err);
void ost_label_names_free(ost_label_names *names);

#endif
