/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The densities of all elements of one or two bytes, computed in advance.
 *
 *   each of the 2^8 or 2^16 elements --ost_convert--> table;  element of the file --look-up--> density
 *
 * Computing the exact density of a scaled element takes about ten times as long as reading it from a table. A table is
 * worth computing for a volume that has more voxels than the table has entries.
 */
#ifndef OST_IO_ELEMENT_TABLE_H
#define OST_IO_ELEMENT_TABLE_H

#include "io/volume/element.h"

typedef struct ost_element_table ost_element_table;

/*
 * Returns the table of a converter for a volume of `voxels` voxels. The converter must not be changed afterwards.
 * Returns NULL if a table is not possible or not worth computing, or if memory is exhausted. The caller frees the
 * table with free().
 */
ost_element_table *ost_element_table_make(const ost_converter *converter, int64_t voxels);

/* Produces the same results as ost_convert, including the counts of the converter. `table` may be NULL. */
size_t ost_element_table_convert(const ost_element_table *table, ost_converter *converter, const void *bytes,
                                 size_t count, int16_t *out, ost_bad *bad);

#endif
