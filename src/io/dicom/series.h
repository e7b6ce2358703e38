/* SPDX-License-Identifier: Apache-2.0 */
/* Selects one series of a scan. */
#ifndef OST_IO_DICOM_SERIES_H
#define OST_IO_DICOM_SERIES_H

#include "io/dicom/scan.h"

enum { OST_DICOM_SERIES_NAME = 32 };
/* Writes the name of a series, "series 3" or "the series without a number", to `text`. Returns `text`. */
char *ost_dicom_series_name(const ost_dicom_group *group, char text[OST_DICOM_SERIES_NAME]);

/*
 * Selects the series whose number, description or UID equals the string `wanted`. If wanted is NULL, selects the only
 * volume; a volume is a series with at least two images. Returns OST_ERR_INPUT unless exactly one series matches.
 */
ost_status ost_dicom_series_select(const ost_dicom_scan *scan, const char *wanted, size_t *out, ost_error *err);

#endif
