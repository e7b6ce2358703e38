/* SPDX-License-Identifier: Apache-2.0 */
#include "io/dicom/request.h"

#include <assert.h>
#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

ost_status ost_dicom_request_open(ost_dicom_action action, const uint8_t *salt, const char *const *paths,
                                  size_t path_count, const ost_dicom_image *images, size_t image_count, int *out,
                                  ost_error *err)
{
    ost_dicom_request request = {
        .magic = OST_DICOM_MAGIC,
        .version = OST_DICOM_VERSION,
        .action = action,
        .paths = (uint32_t)path_count,
        .images = (uint32_t)image_count,
    };
    assert(path_count <= OST_DICOM_FILES_MAX && image_count <= OST_DICOM_IMAGES_MAX);
    memcpy(request.salt, salt, sizeof request.salt);
    *out = -1;
    const int fd = memfd_create("osteon-dicom", MFD_CLOEXEC);
    const int own = fd >= 0 ? dup(fd) : -1; /* owned by the stream; shares the file position of fd */
    FILE *stream = own >= 0 ? fdopen(own, "w") : NULL;
    bool written = stream && fwrite(&request, sizeof request, 1, stream) == 1;
    for (size_t i = 0; i < path_count && written; i++) {
        const uint32_t length = (uint32_t)strlen(paths[i]);
        written = fwrite(&length, sizeof length, 1, stream) == 1 && fwrite(paths[i], 1, length, stream) == length;
    }
    if (written && image_count)
        written = fwrite(images, sizeof *images, image_count, stream) == image_count;
    if (stream)
        written = fclose(stream) == 0 && written;
    else if (own >= 0)
        close(own);
    if (written && lseek(fd, 0, SEEK_SET) == 0) {
        *out = fd;
        return OST_OK;
    }
    const int error = errno;
    if (fd >= 0)
        close(fd);
    return ost_fail(err, OST_ERR_IO, "cannot write a request to the DICOM parser: %s", strerror(error));
}
