/* SPDX-License-Identifier: Apache-2.0 */
#include "io/dicom/images.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "io/dicom/request.h"

/* Starts process p of n. The process reads the images p, p + n, p + 2 n, ... of the stack. */
static ost_status start(ost_dicom_images *images, const ost_dicom_launch *launch, size_t p, ost_error *err)
{
    static const uint8_t no_salt[OST_DICOM_SALT];
    const ost_dicom_stack *stack = images->stack;
    const size_t most = stack->image_count / images->processes + 1;
    const char **paths = malloc(most * sizeof *paths);
    ost_dicom_image *wanted = malloc(most * sizeof *wanted);
    size_t path_count = 0, count = 0;
    uint32_t file = 0;
    int request = -1;
    ost_status status = OST_OK;
    if (!paths || !wanted)
        status = ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for a list of %zu images", stack->scan->path, most);
    for (size_t i = p; i < stack->image_count && status == OST_OK; i += images->processes) {
        const ost_dicom_frame *f = stack->images[i];
        if (path_count == 0 || f->file != file)
            paths[path_count++] = ost_dicom_path_of(stack, f);
        file = f->file;
        wanted[count++] = (ost_dicom_image){.file = (uint32_t)path_count - 1,
                                            .frame = f->frame,
                                            .columns = (uint32_t)f->columns,
                                            .rows = (uint32_t)f->rows};
    }
    if (status == OST_OK)
        status = ost_dicom_request_open(OST_DICOM_READ, no_salt, paths, path_count, wanted, count, &request, err);
    if (status == OST_OK) {
        status = ost_dicom_process_start(launch, request, count, &images->process[p], err);
        close(request);
    }
    free(paths);
    free(wanted);
    return status;
}

ost_status ost_dicom_images_open(const ost_dicom_stack *stack, const ost_dicom_launch *launch, ost_dicom_images *out,
                                 ost_error *err)
{
    const ost_dicom_frame *first = stack->images[0];
    *out = (ost_dicom_images){.stack = stack, .processes = ost_dicom_process_count(stack->image_count)};
    for (size_t p = 0; p < out->processes; p++)
        out->process[p] = (ost_dicom_process){.pipe = -1};
    out->bytes = (size_t)first->columns * (size_t)first->rows * sizeof *out->cells;
    out->cells = malloc(out->bytes);
    const bool doubles = stack->image_count > stack->slice_count;
    if (doubles)
        out->other = malloc(out->bytes);
    if (!out->cells || (doubles && !out->other))
        return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for a slice of %zu bytes", stack->scan->path,
                        out->bytes);
    ost_status status = OST_OK;
    for (size_t p = 0; p < out->processes && status == OST_OK; p++)
        status = start(out, launch, p, err);
    return status;
}

void ost_dicom_images_close(ost_dicom_images *images)
{
    for (size_t p = 0; p < images->processes; p++)
        ost_dicom_process_end(&images->process[p]);
    free(images->cells);
    free(images->other);
    *images = (ost_dicom_images){0};
}

static ost_status read_image(ost_dicom_images *images, uint16_t *to, ost_error *err)
{
    const size_t at = images->next_image++;
    ost_dicom_process *process = &images->process[at % images->processes];
    const char *path = ost_dicom_path_of(images->stack, images->stack->images[at]);
    ost_dicom_message message;
    uint32_t result;
    ost_status status = ost_dicom_process_next(process, path, images->bytes, &message, err);
    if (status != OST_OK)
        return status;
    if (message.index != at / images->processes ||
        (message.type != OST_DICOM_PIXELS && message.type != OST_DICOM_FILE))
        return ost_dicom_process_nonsense(path, "out of order", err);
    if (message.type == OST_DICOM_PIXELS)
        return ost_dicom_process_read(process, path, to, images->bytes, err);
    status = ost_dicom_process_read(process, path, &result, sizeof result, err);
    return status == OST_OK ? ost_dicom_refuse(path, (ost_dicom_result)result, err) : status;
}

/* Returns true if equal cells in the two images represent equal densities. */
static bool same_meaning(const ost_dicom_frame *a, const ost_dicom_frame *b)
{
    return a->slope == b->slope && a->intercept == b->intercept && a->bits_stored == b->bits_stored &&
           a->high_bit == b->high_bit &&
           (a->flags & OST_DICOM_IMAGE_SIGNED) == (b->flags & OST_DICOM_IMAGE_SIGNED);
}

ost_status ost_dicom_images_next(ost_dicom_images *images, const ost_dicom_frame **frame, ost_error *err)
{
    const ost_dicom_stack *stack = images->stack;
    const ost_dicom_slice *slice = &stack->slices[images->next_slice++];
    *frame = stack->images[slice->image];
    ost_status status = read_image(images, images->cells, err);
    for (size_t d = 1; d <= slice->doubles && status == OST_OK; d++) {
        const ost_dicom_frame *other = stack->images[slice->image + d];
        status = read_image(images, images->other, err);
        if (status == OST_OK &&
            (!same_meaning(*frame, other) || memcmp(images->cells, images->other, images->bytes) != 0))
            status = ost_fail(err, OST_ERR_INPUT,
                              "%s: has the same position as %s and other pixels; keep the images of one acquisition",
                              ost_dicom_path_of(stack, other), ost_dicom_path_of(stack, *frame));
    }
    return status;
}
