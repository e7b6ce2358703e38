/* SPDX-License-Identifier: Apache-2.0 */
#ifndef OST_TESTS_DICOM_JPEG2000_H
#define OST_TESTS_DICOM_JPEG2000_H

#include <cstdint>
#include <vector>

/*
 * Encodes a frame as a JPEG 2000 codestream with OpenJPEG. Pixels have 8 or 16 bits allocated, in the host's byte
 * order. Returns an empty vector on failure.
 */
std::vector<uint8_t> encode_jpeg2000(const std::vector<uint8_t> &pixels, int columns, int rows, int allocated, int bits,
                                     bool is_signed, bool lossless);

#endif
