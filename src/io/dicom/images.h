/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads the pixels of a stack's slices, in order.
 *
 *   image 0 from process 0, image 1 from process 1, ..., image n from process 0, ...
 *
 * The processes decode in parallel. A process blocks while its pipe is full, so its memory does not grow with the
 * number of images. If several images have the same position, each image after the first is compared with the first
 * and then dropped.
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
    size_t bytes;     /* size of an image in bytes */
    uint16_t *cells;  /* owned; cells of the slice that was read last */
    /* owned; cells of a second image at the same position, for comparison; NULL if no slice has several images */
    uint16_t *other;
} ost_dicom_images;

/* Starts the processes. *out refers to the stack and may be closed even after a failure. */
ost_status ost_dicom_images_open(const ost_dicom_stack *stack, const ost_dicom_launch *launch, ost_dicom_images *out,
                                 ost_error *err);
/* Reads the cells of the next slice into images->cells, and sets *frame to the slice's image. */
ost_status ost_dicom_images_next(ost_dicom_images *images, const ost_dicom_frame **frame, ost_error *err);
void ost_dicom_images_close(ost_dicom_images *images);

#endif
