/* SPDX-License-Identifier: Apache-2.0 */
#include "io/dicom/frame.h"

#include <stdio.h>
#include <string.h>

#include <osteon/grid.h>

/* Computes text * factor, rounded half to even. Returns false if the text is not exactly one decimal within +-limit. */
static bool read_decimal(const char *text, int64_t factor, int64_t limit, int64_t *out)
{
    const char *end = text + strlen(text);
    ost_decimal value;
    return ost_decimal_read(text, end, &value) == end && ost_decimal_scale(&value, (uint64_t)factor, out, NULL) &&
           *out <= limit && *out >= -limit;
}

/*
 * Reads `count` decimals of an attribute. If a decimal is missing or invalid, sets frame->bad, unless an earlier
 * attribute has set it.
 */
static void read_attribute(ost_dicom_frame *frame, ost_dicom_attribute attribute,
                           const char (*texts)[OST_DICOM_DECIMAL], int count, int64_t factor, int64_t limit,
                           int64_t *out)
{
    for (int i = 0; i < count; i++) {
        if (read_decimal(texts[i], factor, limit, &out[i]))
            continue;
        if (frame->bad == OST_DICOM_NO_ATTRIBUTE) {
            frame->bad = attribute;
            snprintf(frame->bad_value, sizeof frame->bad_value, "%s", texts[i]);
        }
        return;
    }
}

static uint8_t small(uint32_t value)
{
    return value < UINT8_MAX ? (uint8_t)value : UINT8_MAX;
}

static const char *encoding_of(const char *syntax)
{
    static const struct {
        const char *uid, *name;
    } encodings[] = {
        {"1.2.840.10008.1.2", "raw"},           {"1.2.840.10008.1.2.1", "raw"},
        {"1.2.840.10008.1.2.2", "raw"},         {"1.2.840.10008.1.2.1.99", "deflate"},
        {"1.2.840.10008.1.2.4.50", "JPEG"},     {"1.2.840.10008.1.2.4.51", "JPEG"},
        {"1.2.840.10008.1.2.4.57", "JPEG"},     {"1.2.840.10008.1.2.4.70", "JPEG"},
        {"1.2.840.10008.1.2.4.80", "JPEG-LS"},  {"1.2.840.10008.1.2.4.81", "JPEG-LS"},
        {"1.2.840.10008.1.2.4.90", "JPEG 2000"}, {"1.2.840.10008.1.2.4.91", "JPEG 2000"},
        {"1.2.840.10008.1.2.5", "RLE"},
    };
    for (size_t i = 0; i < sizeof encodings / sizeof encodings[0]; i++)
        if (strcmp(syntax, encodings[i].uid) == 0)
            return encodings[i].name;
    return "other";
}

void ost_dicom_frame_of(const ost_dicom_record *record, ost_dicom_frame *out)
{
    *out = (ost_dicom_frame){
        .frame = record->frame,
        .flags = record->flags,
        .result = (ost_dicom_result)record->result,
        .encoding = encoding_of(record->syntax),
        .columns = record->columns <= OST_DICOM_SIDE_MAX ? (int32_t)record->columns : OST_DICOM_SIDE_MAX + 1,
        .rows = record->rows <= OST_DICOM_SIDE_MAX ? (int32_t)record->rows : OST_DICOM_SIDE_MAX + 1,
        .bits_allocated = small(record->bits_allocated),
        .bits_stored = small(record->bits_stored),
        .high_bit = small(record->high_bit),
        .padding_first = record->padding_first,
        .padding_last = record->padding_last,
        .slope = OST_DICOM_RESCALE_UNIT,
    };
    memcpy(out->patient, record->patient, sizeof out->patient);
    memcpy(out->study, record->study, sizeof out->study);
    memcpy(out->reference, record->reference, sizeof out->reference);
    int64_t spacing[2] = {0, 0};
    read_attribute(out, OST_DICOM_POSITION, record->position, 3, OST_PM_PER_MM, OST_LENGTH_MAX, out->position);
    read_attribute(out, OST_DICOM_ORIENTATION, record->orientation, 6, OST_DICOM_UNIT, 2 * OST_DICOM_UNIT,
                   &out->direction[0][0]);
    read_attribute(out, OST_DICOM_SPACING, record->spacing, 2, OST_PM_PER_MM, OST_SPACING_MAX, spacing);
    for (int i = 0; i < 2; i++)
        if (out->bad == OST_DICOM_NO_ATTRIBUTE && spacing[i] < OST_SPACING_MIN) {
            out->bad = OST_DICOM_SPACING;
            snprintf(out->bad_value, sizeof out->bad_value, "%s", record->spacing[i]);
        }
    /* PixelSpacing states the distance between rows first, but spacing[0] is the distance between columns. */
    out->spacing[0] = spacing[1];
    out->spacing[1] = spacing[0];
    if (!read_decimal(record->thickness, OST_PM_PER_MM, OST_LENGTH_MAX, &out->thickness) || out->thickness < 0)
        out->thickness = 0;
    out->rescaled = record->slope[0] || record->intercept[0];
    if (record->slope[0])
        read_attribute(out, OST_DICOM_SLOPE, &record->slope, 1, OST_DICOM_RESCALE_UNIT, INT64_MAX, &out->slope);
    if (record->intercept[0])
        read_attribute(out, OST_DICOM_INTERCEPT, &record->intercept, 1, OST_DICOM_RESCALE_UNIT, INT64_MAX,
                       &out->intercept);
}
