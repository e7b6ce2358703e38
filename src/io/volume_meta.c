/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Replaces the header facts of an existing volume.
 *
 *   NRRD    the header lines are copied, except those of the form osteon_KEY:=VALUE; the new facts follow, and then
 *           the empty line and every byte after it
 *   NIfTI   a file that was written by osteon is read, and written again with the new facts
 *
 * In both formats, the result is written through an output file (outfile.h), so the old file remains until the new
 * file is complete.
 */
#include <osteon/io.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/nrrd/header.h"
#include "io/nrrd/write.h"
#include "io/outfile.h"
#include "io/volume/input.h"

/*
 * Reads one line, including its newline if there is one. At the end of the file, *size is 0. When the header was
 * checked, all lines fitted in the buffer. If a line does not fit now, the file has changed.
 */
static ost_status next_line(ost_input *input, char *line, size_t capacity, size_t *size, ost_error *err)
{
    *size = 0;
    for (;;) {
        int byte;
        ost_status status = ost_input_byte(input, &byte, err);
        if (status != OST_OK || byte < 0)
            return status;
        if (*size + 1 >= capacity)
            return ost_fail(err, OST_ERR_INPUT, "%s: header changed while it was read", ost_input_path(input));
        line[(*size)++] = (char)byte;
        line[*size] = 0;
        if (byte == '\n')
            return OST_OK;
    }
}

static ost_status put_facts(ost_outfile *out, const ost_meta *meta, ost_error *err)
{
    char text[OST_NRRD_FACT];
    ost_status status = OST_OK;
    for (int i = 0; i < meta->count && status == OST_OK; i++) {
        ost_nrrd_fact(meta->entry[i].key, meta->entry[i].value, text);
        status = ost_outfile_write(out, text, strlen(text), err);
    }
    return status;
}

static ost_status copy_nrrd(ost_input *input, const ost_meta *meta, ost_outfile *out, char *block, ost_error *err)
{
    size_t size;
    bool ended = false;
    ost_status status = OST_OK;
    while (status == OST_OK && !ended) {
        status = next_line(input, block, OST_HEADER_MAX, &size, err);
        if (status != OST_OK)
            return status;
        ended = size == 0 || block[0] == '\n' || strcmp(block, "\r\n") == 0;
        if (ended)
            status = put_facts(out, meta, err);
        if (status == OST_OK && (strncmp(block, "osteon_", 7) != 0 || !strstr(block, ":=")))
            status = ost_outfile_write(out, block, size, err);
        /* The last line of a detached header may have no newline. */
        if (status == OST_OK && size > 0 && block[size - 1] != '\n')
            status = ost_outfile_write(out, "\n", 1, err);
    }
    while (status == OST_OK) {
        status = ost_input_read(input, block, OST_HEADER_MAX, &size, err);
        if (status != OST_OK || size == 0)
            return status;
        status = ost_outfile_write(out, block, size, err);
    }
    return status;
}

static ost_status write_nrrd(const char *path, const ost_meta *meta, ost_error *err)
{
    ost_input *input = NULL;
    ost_outfile *out = NULL;
    char *block = malloc(OST_HEADER_MAX);
    if (!block)
        return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for a copy of its header", path);
    ost_status status = ost_input_open(path, &input, err);
    if (status == OST_OK)
        status = ost_outfile_open(path, &out, err);
    if (status == OST_OK)
        status = copy_nrrd(input, meta, out, block, err);
    if (status == OST_OK)
        status = ost_outfile_commit(out, err);
    else
        ost_outfile_discard(out);
    ost_input_close(input);
    free(block);
    return status;
}

static ost_status write_nifti(const char *path, const ost_meta *meta, ost_error *err)
{
    ost_volume volume;
    ost_volume_report report;
    ost_status status = ost_volume_read(path, NULL, &volume, &report, err);
    if (status != OST_OK)
        return status;
    if (!ost_meta_get(&volume.meta, OST_META_KIND) || strcmp(report.type, "int16") != 0 || report.reoriented ||
        report.rounded_values)
        status = ost_fail(err, OST_ERR_INPUT, "%s: cannot change a NIfTI header that osteon did not write; pass "
                          "these values to 'osteon import'", path);
    if (status == OST_OK) {
        volume.meta = *meta;
        status = ost_volume_write(path, &volume, NULL, err);
    }
    ost_volume_free(&volume);
    return status;
}

ost_status ost_volume_write_meta(const char *path, const ost_meta *meta, ost_error *err)
{
    ost_file_kind kind;
    ost_status status = ost_file_kind_find(path, &kind, err);
    if (status == OST_OK && kind == OST_FILE_NRRD &&
        (status = ost_volume_read_header(path, NULL, NULL, NULL, err)) == OST_OK)
        return write_nrrd(path, meta, err);
    if (status == OST_OK && kind == OST_FILE_NIFTI)
        return write_nifti(path, meta, err);
    return status != OST_OK ? status
                            : ost_fail(err, OST_ERR_INPUT, "%s: cannot set values in this format; expected NRRD or "
                                       "NIfTI; pass the values to 'osteon import'", path);
}
