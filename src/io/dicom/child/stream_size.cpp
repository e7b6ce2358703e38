// SPDX-License-Identifier: Apache-2.0
//
// Checks that a compressed frame has the size that its data set states. DCMTK's decoders of JPEG and RLE omit this
// check: if the data set states a larger image, they leave the remaining pixels undefined; if it states a smaller one,
// they omit the pixels that do not fit. They also pack pixels of 8 bits into pixels of 16 bits.
#include "io/dicom/child/child.h"

// Returns true if a segment of RLE (PackBits) decodes to exactly `expected` bytes. A pad byte may follow.
static bool is_segment(const uint8_t *at, const uint8_t *end, size_t expected)
{
    size_t decoded = 0;
    while (at < end && decoded < expected) {
        const size_t count = *at++;
        if (count < 128) { // count + 1 bytes as they are
            if (static_cast<size_t>(end - at) <= count)
                return false;
            at += count + 1;
            decoded += count + 1;
        } else if (count > 128) { // one byte, 257 - count times
            if (at == end)
                return false;
            at++;
            decoded += 257 - count;
        }
    }
    return decoded == expected && end - at <= 1;
}

static uint32_t little_endian(const uint8_t *p)
{
    return p[0] | uint32_t{p[1]} << 8 | uint32_t{p[2]} << 16 | uint32_t{p[3]} << 24;
}

// An RLE frame begins with 16 numbers: the number of segments, and the offset of each segment. There is one segment for
// each byte of a pixel.
bool is_rle_of_size(const std::vector<uint8_t> &stream, uint32_t columns, uint32_t rows, uint32_t bytes)
{
    enum { HEAD = 64 };
    if (stream.size() < HEAD || little_endian(stream.data()) != bytes)
        return false;
    for (uint32_t s = 0; s < bytes; s++) {
        const size_t from = little_endian(stream.data() + 4 * (s + 1)),
                     to = s + 1 < bytes ? little_endian(stream.data() + 4 * (s + 2)) : stream.size();
        if (from < HEAD || from > to || to > stream.size() ||
            !is_segment(stream.data() + from, stream.data() + to, size_t{columns} * rows))
            return false;
    }
    return true;
}

// A stream of JPEG or JPEG-LS is a sequence of markers with their lengths. The marker of a frame (SOF) contains the
// number of bits per sample and the size of the frame.
bool is_jpeg_of_size(const std::vector<uint8_t> &stream, uint32_t columns, uint32_t rows, uint32_t bytes)
{
    for (size_t at = 2; at + 9 <= stream.size();) {
        if (stream[at] != 0xff)
            return false;
        const unsigned marker = stream[at + 1];
        if (marker == 0xff) { // fill byte
            at++;
            continue;
        }
        const uint8_t *p = stream.data() + at + 2;
        if (marker == 0xf7 ||
            (marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc))
            return bytes == (p[2] + 7U) / 8 && rows == (uint32_t{p[3]} << 8 | p[4]) &&
                   columns == (uint32_t{p[5]} << 8 | p[6]);
        at += 2 + (size_t{p[0]} << 8 | p[1]);
    }
    return false;
}
