/* SPDX-License-Identifier: Apache-2.0 */
#ifndef OST_TESTS_DICOM_DAMAGE_H
#define OST_TESTS_DICOM_DAMAGE_H

#include "series.h"

/*
 * Applies the changes `cut`, `replace`, `append`, `bomb` and `flip` of slice k to the bytes of the slice's file:
 *
 *   cut=K:N            keeps the first N bytes, or removes the last -N bytes if N is negative
 *   replace=K:HEX:HEX  replaces the first occurrence of some bytes
 *   append=K:HEX*N     appends bytes N times
 *   bomb=K:N           replaces a deflated data set with a data set of N attributes; each has 256 MB of
 *                      zeros, which are 256 kB when deflated
 *   flip=K:SEED*N      inverts N bits at positions that follow from the seed
 *
 * Returns false with a message if the file cannot be changed in this way.
 */
bool damage_file(const series &s, int k, const std::string &path, std::string *error);

#endif
