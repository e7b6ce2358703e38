/* SPDX-License-Identifier: Apache-2.0 */
/* Makes image records like those that osteon-dicom sends, so that the library can be tested without DCMTK. */
#ifndef OST_TESTS_IO_DICOM_RECORDS_H
#define OST_TESTS_IO_DICOM_RECORDS_H

#include "io/dicom/protocol.h"

#include <stdio.h>
#include <string.h>

/*
 * Returns an axial image of 4 x 3 pixels of 0.5 x 0.75 mm at (-10, 20, z) mm in series 7. `z` is a decimal number as
 * text.
 */
static inline ost_dicom_record record_at(const char *z)
{
    ost_dicom_record r;
    memset(&r, 0, sizeof r);
    static const char *const directions[6] = {"1", "0", "0", "0", "1", "0"};
    r.flags = OST_DICOM_IMAGE_NUMBERED;
    r.columns = 4;
    r.rows = 3;
    r.bits_allocated = 16;
    r.bits_stored = 12;
    r.high_bit = 11;
    r.series_number = 7;
    memset(r.patient, 1, sizeof r.patient);
    memset(r.study, 2, sizeof r.study);
    memset(r.reference, 3, sizeof r.reference);
    snprintf(r.position[0], sizeof r.position[0], "-10");
    snprintf(r.position[1], sizeof r.position[1], "20");
    snprintf(r.position[2], sizeof r.position[2], "%s", z);
    for (int i = 0; i < 6; i++)
        snprintf(r.orientation[i], sizeof r.orientation[i], "%s", directions[i]);
    snprintf(r.spacing[0], sizeof r.spacing[0], "0.75");
    snprintf(r.spacing[1], sizeof r.spacing[1], "0.5");
    snprintf(r.slope, sizeof r.slope, "1");
    snprintf(r.intercept, sizeof r.intercept, "-1024");
    snprintf(r.syntax, sizeof r.syntax, "1.2.840.10008.1.2.1");
    snprintf(r.series_uid, sizeof r.series_uid, "1.2.3");
    snprintf(r.description, sizeof r.description, "Shoulder");
    snprintf(r.modality, sizeof r.modality, "CT");
    return r;
}

#endif
