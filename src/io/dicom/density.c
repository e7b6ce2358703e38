/* SPDX-License-Identifier: Apache-2.0 */
#include "io/dicom/density.h"

#include "core/integer.h"

enum { CELL_PADDED = 1, CELL_ROUNDED = 2, CELL_CLAMPED = 4, CELL_BEYOND = 8 };

/*
 * Extracts the pixel value from a pixel cell. The value occupies the `bits_stored` bits up to and including `high_bit`,
 * and is sign-extended if the pixels are signed.
 */
static int32_t value_of(const ost_dicom_frame *f, uint16_t cell)
{
    const int bits = f->bits_stored;
    const int32_t value = cell >> (f->high_bit + 1 - bits) & ((1 << bits) - 1);
    return f->flags & OST_DICOM_IMAGE_SIGNED && value >> (bits - 1) ? value - (1 << bits) : value;
}

/*
 * Returns true if a pixel is padding. The padding values are compared with both the pixel value and the complete cell,
 * because padding values can be too large for the stored bits.
 */
static bool is_padding(const ost_dicom_frame *f, uint16_t cell, int32_t value)
{
    const int32_t complete = f->flags & OST_DICOM_IMAGE_SIGNED ? (int16_t)cell : cell;
    return f->flags & OST_DICOM_IMAGE_PADDED &&
           ((value >= f->padding_first && value <= f->padding_last) ||
            (complete >= f->padding_first && complete <= f->padding_last));
}

static bool is_same(const ost_dicom_frame *a, const ost_dicom_frame *b)
{
    const uint32_t flags = OST_DICOM_IMAGE_SIGNED | OST_DICOM_IMAGE_PADDED;
    return a && a->slope == b->slope && a->intercept == b->intercept && a->bits_stored == b->bits_stored &&
           a->high_bit == b->high_bit && (a->flags & flags) == (b->flags & flags) &&
           a->padding_first == b->padding_first && a->padding_last == b->padding_last;
}

void ost_dicom_table_set(ost_dicom_table *table, const ost_dicom_frame *frame)
{
    if (is_same(table->of, frame))
        return;
    table->of = frame;
    for (int32_t cell = 0; cell < OST_DICOM_CELLS; cell++) {
        const int32_t value = value_of(frame, (uint16_t)cell);
        if (is_padding(frame, (uint16_t)cell, value)) {
            table->density[cell] = OST_DICOM_AIR;
            table->kind[cell] = CELL_PADDED;
            continue;
        }
        /* |value| <= 2^16 and |slope|, |intercept| < 2^63, so |exact| < 2^80. */
        const ost_i128 exact = (ost_i128)value * frame->slope + frame->intercept;
        ost_i128 density = ost_rhe_div128(exact, OST_DICOM_RESCALE_UNIT);
        uint8_t kind = density * OST_DICOM_RESCALE_UNIT != exact ? CELL_ROUNDED : 0;
        if (density < INT16_MIN || density > INT16_MAX) {
            density = density < 0 ? INT16_MIN : INT16_MAX;
            kind = table->clamp ? CELL_CLAMPED : CELL_BEYOND;
        }
        table->density[cell] = (int16_t)density;
        table->kind[cell] = kind;
    }
}

size_t ost_dicom_convert(ost_dicom_table *table, const uint16_t *cells, size_t count, int16_t *out, int32_t *value)
{
    uint8_t kinds = 0;
    for (size_t i = 0; i < count; i++) {
        out[i] = table->density[cells[i]];
        kinds |= table->kind[cells[i]];
    }
    if (kinds == 0)
        return count;
    for (size_t i = 0; i < count; i++) {
        const uint8_t kind = table->kind[cells[i]];
        if (kind & CELL_BEYOND) {
            *value = value_of(table->of, cells[i]);
            return i;
        }
        table->padded += kind == CELL_PADDED;
        table->rounded += kind == CELL_ROUNDED;
        table->clamped += kind == CELL_CLAMPED;
    }
    return count;
}
