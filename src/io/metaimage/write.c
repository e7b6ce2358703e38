/* SPDX-License-Identifier: Apache-2.0 */
#include "io/metaimage/write.h"

#include <stdio.h>
#include <string.h>

#include <osteon/length.h>

ost_status ost_metaimage_write_header(ost_volume_writer *writer, const ost_geometry *geometry, const ost_meta *meta,
                                      ost_error *err)
{
    char text[1024], o[3][OST_PM_TEXT], s[3][OST_PM_TEXT];
    snprintf(text, sizeof text,
             "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
             "CompressedData = False\nTransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = %s %s %s\n"
             "CenterOfRotation = 0 0 0\nElementSpacing = %s %s %s\nDimSize = %d %d %d\n",
             ost_pm_format(geometry->origin.x, o[0]), ost_pm_format(geometry->origin.y, o[1]),
             ost_pm_format(geometry->origin.z, o[2]), ost_pm_format(geometry->spacing.x, s[0]),
             ost_pm_format(geometry->spacing.y, s[1]), ost_pm_format(geometry->spacing.z, s[2]), geometry->dims.x,
             geometry->dims.y, geometry->dims.z);
    ost_status status = ost_volume_writer_bytes(writer, text, strlen(text), err);
    for (int i = 0; i < meta->count && status == OST_OK; i++) {
        if (ost_meta_key_is_geometry(meta->entry[i].key))
            continue;
        snprintf(text, sizeof text, "osteon_%s = %s\n", meta->entry[i].key, meta->entry[i].value);
        status = ost_volume_writer_bytes(writer, text, strlen(text), err);
    }
    static const char last[] = "ElementType = MET_SHORT\nElementDataFile = LOCAL\n";
    return status == OST_OK ? ost_volume_writer_bytes(writer, last, sizeof last - 1, err) : status;
}
