/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writes a NRRD file that 3D Slicer, ITK and pynrrd can read:
 *
 *   NRRD0005
 *   type: int16
 *   dimension: 3
 *   space: left-posterior-superior
 *   sizes: 256 234 201
 *   space directions: (0.47,0,0) (0,0.47,0) (0,0,1)
 *   kinds: domain domain domain
 *   endian: little
 *   encoding: raw
 *   space units: "mm" "mm" "mm"
 *   space origin: (-57.34,0,12)
 *   osteon_kind:=ct
 *   <empty line>, voxels
 *
 * Lengths are exact decimals of at most nine places; a tool's origin may need ten.
 */
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "io/nrrd/write.h"

static ost_status put_text(ost_volume_writer *writer, const char *text, ost_error *err)
{
    return ost_volume_writer_bytes(writer, text, strlen(text), err);
}

void ost_nrrd_escape(const char *value, char out[2 * OST_META_VALUE])
{
    for (; *value; value++) {
        if (*value == '\\')
            *out++ = '\\';
        *out++ = *value;
    }
    *out = 0;
}

void ost_nrrd_fact(const char *key, const char *value, char text[OST_NRRD_FACT])
{
    char escaped[2 * OST_META_VALUE];
    text[0] = 0;
    if (ost_meta_key_is_geometry(key))
        return;
    ost_nrrd_escape(value, escaped);
    snprintf(text, OST_NRRD_FACT, "osteon_%s:=%s\n", key, escaped);
}

/*
 * Formats a position of (value + 1/2) pm in millimetres with ten decimals, that is, value * 10 + 5 in units of 10^-10
 * mm. Requires |value| <= 8 * 10^12.
 */
static void format_half(ost_pm value, char text[OST_PM_TEXT])
{
    int64_t tenths = value * 10 + 5;
    uint64_t magnitude = (uint64_t)(tenths < 0 ? -tenths : tenths), unit = UINT64_C(10000000000);
    snprintf(text, OST_PM_TEXT, "%s%" PRIu64 ".%010" PRIu64, tenths < 0 ? "-" : "", magnitude / unit, magnitude % unit);
}

ost_status ost_nrrd_write_header(ost_volume_writer *writer, const ost_geometry *geometry, const ost_meta *meta,
                                 const char *fields, ost_element element, bool odd_voxel, bool compress,
                                 ost_error *err)
{
    char length[6][OST_PM_TEXT], text[1024];
    const ost_pm lengths[6] = {geometry->spacing.x, geometry->spacing.y, geometry->spacing.z,
                               geometry->origin.x,  geometry->origin.y,  geometry->origin.z};
    for (int i = 0; i < 6; i++) {
        if (odd_voxel && i >= 3)
            format_half(lengths[i], length[i]);
        else
            ost_pm_format(lengths[i], length[i]);
    }
    snprintf(text, sizeof text,
             "NRRD0005\n"
             "type: %s\n"
             "dimension: 3\n"
             "space: left-posterior-superior\n"
             "sizes: %d %d %d\n"
             "space directions: (%s,0,0) (0,%s,0) (0,0,%s)\n"
             "kinds: domain domain domain\n"
             "endian: little\n"
             "encoding: %s\n"
             "space units: \"mm\" \"mm\" \"mm\"\n"
             "space origin: (%s,%s,%s)\n",
             ost_element_name(element), geometry->dims.x, geometry->dims.y, geometry->dims.z, length[0], length[1],
             length[2], compress ? "gzip" : "raw", length[3], length[4], length[5]);
    ost_status status = put_text(writer, text, err);
    for (int i = 0; status == OST_OK && i < meta->count; i++) {
        ost_nrrd_fact(meta->entry[i].key, meta->entry[i].value, text);
        status = put_text(writer, text, err);
    }
    if (status == OST_OK && fields)
        status = put_text(writer, fields, err);
    if (status == OST_OK)
        status = put_text(writer, "\n", err);
    if (status == OST_OK && compress)
        status = ost_volume_writer_pack(writer, err);
    return status;
}
