/* SPDX-License-Identifier: Apache-2.0 */
/* Reads the label names from the header of a label map. */
#include "config.h"

#include "io/label_names.h"

#include <string.h>

#include "io/nifti/header.h"
#include "io/nifti/read.h"
#include "io/nrrd/header.h"

static ost_status read_nifti(ost_input *input, ost_nifti_form form, ost_label_names *names, ost_error *err)
{
#ifdef HAVE_NIFTI
    ost_nifti_header header;
    return ost_nifti_header_read(input, form, names, &header, err);
#else
    (void)input, (void)form, (void)names, (void)err;
    return OST_OK; /* no error is returned, because the reader of the voxels later reports that libnifti is missing */
#endif
}

static ost_status read_nrrd(ost_input *input, ost_label_names *names, ost_error *err)
{
    ost_nrrd_text text;
    const ost_status status = ost_nrrd_text_read(input, names, &text, err);
    ost_nrrd_text_free(&text);
    return status;
}

ost_status ost_label_names_read(const char *path, ost_nifti_form form, ost_label_names *names, ost_error *err)
{
    unsigned char head[OST_NIFTI_SNIFF];
    size_t got;
    ost_input *input;
    ost_status status = ost_input_open(path, &input, err);
    if (status != OST_OK)
        return status;
    status = ost_input_read(input, head, sizeof head, &got, err);
    const bool is_packed = status == OST_OK && got >= 2 && head[0] == 0x1f && head[1] == 0x8b;
    if (status == OST_OK)
        status = ost_input_seek(input, 0, err);
    if (is_packed && status == OST_OK)
        status = ost_input_gunzip(input, err);
    if (is_packed && status == OST_OK)
        status = ost_input_read(input, head, sizeof head, &got, err);
    if (is_packed && status == OST_OK)
        status = ost_input_seek(input, 0, err);
    if (is_packed && status == OST_OK)
        status = ost_input_gunzip(input, err);
    if (status == OST_OK && !is_packed && got >= 4 && memcmp(head, "NRRD", 4) == 0)
        status = read_nrrd(input, names, err);
    else if (status == OST_OK && ost_nifti_sniff(head, got) != 0)
        status = read_nifti(input, form, names, err);
    ost_input_close(input);
    return status;
}
