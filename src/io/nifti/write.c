/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writes a NIfTI-1 file: one file with int16 voxels, little-endian. The sform and the qform are the same transform,
 * from LPS+ voxels to RAS millimetres.
 *
 *   x = -(origin.x + i * spacing.x)      quaternion (0; 0, 0, 1): half a turn about z
 *   y = -(origin.y + j * spacing.y)
 *   z =   origin.z + k * spacing.z
 *
 * The lengths in a NIfTI header are float32. A comment in the header therefore contains the exact lengths, together
 * with the header facts (nifti/extension.h).
 */
#include "config.h"

#include "io/nifti/write.h"

#ifdef HAVE_NIFTI

#include <stdlib.h>
#include <string.h>

#include <nifti2_io.h>

#include "core/conditions.h"
#include "io/nifti/extension.h"

/*
 * Maximum size of the extension in bytes: OST_META_MAX lines of the greatest possible size, the lines with the exact
 * spacing and origin, and the fields of the extension itself.
 */
enum { EXTENSION_CAPACITY = OST_META_MAX * (OST_META_KEY + OST_META_VALUE + 16) + 512 };

static void fill_header(const ost_geometry *geometry, size_t extension, bool labels, nifti_1_header *h)
{
    const ost_pm3 s = geometry->spacing, o = geometry->origin;
    memset(h, 0, sizeof *h);
    h->sizeof_hdr = sizeof *h;
    h->regular = 'r';
    h->dim[0] = 3;
    h->dim[1] = (short)geometry->dims.x;
    h->dim[2] = (short)geometry->dims.y;
    h->dim[3] = (short)geometry->dims.z;
    for (int a = 4; a < 8; a++)
        h->dim[a] = 1;
    h->intent_code = labels ? NIFTI_INTENT_LABEL : NIFTI_INTENT_NONE;
    h->datatype = DT_INT16;
    h->bitpix = 16;
    h->pixdim[0] = 1;
    h->pixdim[1] = (float)ost_pm_to_mm(s.x);
    h->pixdim[2] = (float)ost_pm_to_mm(s.y);
    h->pixdim[3] = (float)ost_pm_to_mm(s.z);
    h->vox_offset = (float)(sizeof *h + extension);
    h->scl_slope = 1;
    h->xyzt_units = NIFTI_UNITS_MM;
    h->qform_code = h->sform_code = NIFTI_XFORM_SCANNER_ANAT;
    h->quatern_d = 1;
    /* 0 - x is used instead of -x, because -x could be a negative zero. */
    h->qoffset_x = h->srow_x[3] = (float)ost_pm_to_mm(0 - o.x);
    h->qoffset_y = h->srow_y[3] = (float)ost_pm_to_mm(0 - o.y);
    h->qoffset_z = h->srow_z[3] = (float)ost_pm_to_mm(o.z);
    h->srow_x[0] = -h->pixdim[1];
    h->srow_y[1] = -h->pixdim[2];
    h->srow_z[2] = h->pixdim[3];
    memcpy(h->magic, "n+1", 4);
}

ost_status ost_nifti_write_header(ost_volume_writer *writer, const ost_geometry *geometry, const ost_meta *meta,
                                  bool compress, ost_error *err)
{
    unsigned char *extension = malloc(EXTENSION_CAPACITY);
    if (!extension)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a NIfTI header");
    size_t size = ost_nifti_extension_format(meta, geometry, extension, EXTENSION_CAPACITY);
    nifti_1_header header;
    const char *kind = ost_meta_get(meta, OST_META_KIND);
    fill_header(geometry, size, kind && strcmp(kind, "labels") == 0, &header);
    ost_status status = compress ? ost_volume_writer_pack(writer, err) : OST_OK;
    if (status == OST_OK)
        status = ost_volume_writer_bytes(writer, &header, sizeof header, err);
    if (status == OST_OK)
        status = ost_volume_writer_bytes(writer, extension, size, err);
    free(extension);
    return status;
}

#else

ost_status ost_nifti_write_header(ost_volume_writer *writer, const ost_geometry *geometry, const ost_meta *meta,
                                  bool compress, ost_error *err)
{
    (void)writer, (void)geometry, (void)meta, (void)compress;
    return ost_fail(err, OST_ERR_UNAVAILABLE,
                    "cannot write NIfTI: osteon was built without libnifti; install libnifti (Debian: libnifti-dev) "
                    "and build again");
}

#endif
