/* SPDX-License-Identifier: Apache-2.0 */
#include "io/volume/element_table.h"

#include <stdlib.h>
#include <string.h>

enum { ENTRIES = 1 << 16, ROUNDED = 1, CLAMPED = 2, BAD = 4 };

struct ost_element_table {
    int16_t density[ENTRIES];
    uint8_t kind[ENTRIES]; /* flags ROUNDED, CLAMPED and BAD; 0 if the density is exact */
};

ost_element_table *ost_element_table_make(const ost_converter *converter, int64_t voxels)
{
    const ost_element element = converter->element;
    const size_t bytes = ost_element_bytes(element);
    const int32_t entries = bytes == 1 ? 1 << 8 : ENTRIES;
    if (bytes < 1 || bytes > 2 || voxels < entries || !(converter->scaled || element == OST_ELEMENT_UINT16))
        return NULL;
    ost_element_table *table = malloc(sizeof *table);
    for (int32_t i = 0; table && i < entries; i++) {
        ost_converter own = *converter;
        ost_bad bad;
        const uint8_t narrow = (uint8_t)i;
        const uint16_t wide = (uint16_t)i;
        own.rounded = own.clamped = 0;
        table->density[i] = 0;
        table->kind[i] = BAD;
        if (ost_convert(&own, bytes == 1 ? (const void *)&narrow : &wide, 1, &table->density[i], &bad) == 1)
            table->kind[i] = (uint8_t)((own.rounded > 0) * ROUNDED | (own.clamped > 0) * CLAMPED);
    }
    return table;
}

static uint16_t element_at(const unsigned char *bytes, size_t i, bool wide)
{
    uint16_t element = bytes[i];
    if (wide)
        memcpy(&element, bytes + 2 * i, sizeof element);
    return element;
}

/* Looks up the densities of `count` elements and returns the flags of all of them. */
static uint8_t look_up(const ost_element_table *table, const unsigned char *bytes, bool wide, size_t count,
                       int16_t *out)
{
    uint8_t kinds = 0;
    for (size_t i = 0; i < count; i++) {
        const uint16_t element = element_at(bytes, i, wide);
        out[i] = table->density[element];
        kinds |= table->kind[element];
    }
    return kinds;
}

size_t ost_element_table_convert(const ost_element_table *table, ost_converter *converter, const void *bytes,
                                 size_t count, int16_t *out, ost_bad *bad)
{
    if (!table)
        return ost_convert(converter, bytes, count, out, bad);
    const bool wide = ost_element_bytes(converter->element) == 2;
    *bad = (ost_bad){.kind = OST_BAD_NONE};
    if (look_up(table, bytes, wide, count, out) == 0)
        return count;
    for (size_t i = 0; i < count; i++) {
        const uint8_t kind = table->kind[element_at(bytes, i, wide)];
        if (kind & BAD) {
            /* describes the element in *bad */
            (void)ost_convert(converter, (const unsigned char *)bytes + i * (wide ? 2 : 1), 1, &out[i], bad);
            return i;
        }
        converter->rounded += (kind & ROUNDED) != 0;
        converter->clamped += (kind & CLAMPED) != 0;
    }
    return count;
}
