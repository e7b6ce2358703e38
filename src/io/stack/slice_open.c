/* SPDX-License-Identifier: Apache-2.0 */
/* Opens a slice with the reader for its format. */
#include "io/stack/slice.h"

#include <errno.h>
#include <string.h>
#include <unistd.h>

#include "core/file.h"

ost_status ost_slice_sniff_file(const char *path, ost_slice_kind *kind, ost_error *err)
{
    unsigned char head[8];
    ost_file file;
    *kind = OST_SLICE_NONE;
    ost_status status = ost_file_open(path, &file, err);
    if (status != OST_OK)
        return status;
    const ssize_t n = pread(file.fd, head, sizeof head, 0);
    if (n < 0)
        status = ost_fail(err, OST_ERR_IO, "%s: cannot read: %s", path, strerror(errno));
    else
        *kind = ost_slice_sniff(head, (size_t)n);
    close(file.fd);
    return status;
}

ost_status ost_slice_open(const char *path, ost_slice **out, ost_error *err)
{
    ost_slice_kind kind;
    *out = NULL;
    const ost_status status = ost_slice_sniff_file(path, &kind, err);
    if (status != OST_OK)
        return status;
    switch (kind) {
    case OST_SLICE_TIFF: return ost_slice_open_tiff(path, out, err);
    case OST_SLICE_PNG: return ost_slice_open_png(path, out, err);
    case OST_SLICE_NONE: break;
    }
    return ost_fail(err, OST_ERR_INPUT, "%s: is neither a TIFF nor a PNG file", path);
}
