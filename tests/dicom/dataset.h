/* SPDX-License-Identifier: Apache-2.0 */
#ifndef OST_TESTS_DICOM_DATASET_H
#define OST_TESTS_DICOM_DATASET_H

#include "series.h"

/*
 * Writes a file with the given frames: one slice, or all slices of an enhanced multi-frame image. Applies
 * the changes `set` and `remove` of the first frame's slice. Returns false with a message on failure.
 */
bool write_file(const series &s, const std::vector<slice> &frames, const std::string &path, std::string *error);

/* Registers and releases DCMTK's encoders. */
void open_encoders(const series &s);
void close_encoders();

#endif
