/* SPDX-License-Identifier: Apache-2.0 */
/* Selects a series of a scan. */
#ifndef OST_IO_DICOM_SERIES_H
#define OST_IO_DICOM_SERIES_H

#include "io/dicom/scan.h"

enum { OST_DICOM_SERIES_NAME = 32 };
/* Writes "series 3", or "the series without a number". Returns text. */
char *ost_dicom_series_name(const ost_dicom_group *group, char text[OST_DICOM_SERIES_NAME]);

/*
 * Selects the series whose number, description or UID is `wanted` or, if wanted is NULL, the only series
 * that is a volume, which has at least two images. Returns OST_ERR_INPUT if there is none, or more than one.
 */
ost_status ost_dicom_series_select(const ost_dicom_scan *scan, const char *wanted, size_t *out, ost_error *err);

#endif
