/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads the pixels of a stack's slices, in order.
 *
 *   image 0 from process 0, image 1 from process 1, ..., image n from process 0, ...
 *
 * The processes decode at the same time. Each one waits when its pipe is full, so their memory does not
 * depend on the number of images. Doubled images are compared with their slice and dropped.
 */
#ifndef OST_IO_DICOM_IMAGES_H
#define OST_IO_DICOM_IMAGES_H

#include "io/dicom/process.h"
#include "io/dicom/stack.h"

typedef struct ost_dicom_images {
    const ost_dicom_stack *stack;
    ost_dicom_process process[OST_DICOM_PROCESSES_MAX];
    size_t processes;
    size_t next_image, next_slice;
    size_t bytes;     /* of an image */
    uint16_t *cells;  /* owned; the last slice that was read */
    uint16_t *other;  /* owned; a doubled image; NULL if there are none */
} ost_dicom_images;

/* Starts the processes. *out is initialised here, uses the stack, and may be closed after a failure. */
ost_status ost_dicom_images_open(const ost_dicom_stack *stack, const ost_dicom_launch *launch, ost_dicom_images *out,
                                 ost_error *err);
/* Reads the next slice into images->cells, and sets *frame to its image. */
ost_status ost_dicom_images_next(ost_dicom_images *images, const ost_dicom_frame **frame, ost_error *err);
void ost_dicom_images_close(ost_dicom_images *images);

#endif
