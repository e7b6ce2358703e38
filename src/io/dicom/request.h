/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writes the request for an osteon-dicom process to a file in memory. The request is complete before the process
 * starts, so the library and the process can never deadlock by each waiting for the other to read.
 */
#ifndef OST_IO_DICOM_REQUEST_H
#define OST_IO_DICOM_REQUEST_H

#include <stddef.h>

#include <osteon/status.h>

#include "io/dicom/protocol.h"

/*
 * Creates a request for `paths` and, to read pixels, for `images`. The field `file` of an image is an index into
 * `paths`. salt has OST_DICOM_SALT bytes. Sets *out to a close-on-exec descriptor at position 0. The caller closes
 * the descriptor.
 */
ost_status ost_dicom_request_open(ost_dicom_action action, const uint8_t *salt, const char *const *paths,
                                  size_t path_count, const ost_dicom_image *images, size_t image_count, int *out,
                                  ost_error *err);

#endif
