/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The input of the volume readers. It reads a regular file as a stream of bytes and, on request, unpacks gzip or zlib
 * data.
 *
 *   open -> plain bytes ... gunzip -> the unpacked form of the remaining bytes
 *
 * The memory for two buffers is sufficient for files of any size. Only regular files are accepted, so that sizes can
 * be checked before anything is allocated, and so that a pipe or a device cannot block a reader.
 */
#ifndef OST_IO_VOLUME_INPUT_H
#define OST_IO_VOLUME_INPUT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <osteon/status.h>

typedef struct ost_input ost_input;

ost_status ost_input_open(const char *path, ost_input **out, ost_error *err);
void ost_input_close(ost_input *input); /* NULL is allowed */
const char *ost_input_path(const ost_input *input);

/* Returns the file's size in bytes. */
uint64_t ost_input_file_bytes(const ost_input *input);
/* Returns the number of file bytes that have not been read yet. In a packed file, these are packed bytes. */
uint64_t ost_input_file_left(const ost_input *input);

/* Moves to an offset in the file and switches to reading plain bytes. */
ost_status ost_input_seek(ost_input *input, uint64_t offset, ost_error *err);
/* Treats the following bytes as gzip data, which may have several members. Offsets in the unpacked data start at 0. */
ost_status ost_input_gunzip(ost_input *input, ost_error *err);
/*
 * Treats the following bytes as one zlib stream (RFC 1950) or as gzip data, either of which a MetaImage file may
 * contain. Offsets in the unpacked data start at 0.
 */
ost_status ost_input_inflate(ost_input *input, ost_error *err);

bool ost_input_is_packed(const ost_input *input);
/*
 * Returns an upper limit on the number of bytes that can still be read. It is exact for plain bytes; for packed bytes,
 * it follows from deflate's maximum ratio of 1032 to 1.
 */
uint64_t ost_input_at_most(const ost_input *input);

/*
 * Reads `wanted` bytes. *got is less than `wanted` only at the end of the input. Returns OST_ERR_INPUT if packed data
 * are truncated or damaged.
 */
ost_status ost_input_read(ost_input *input, void *bytes, size_t wanted, size_t *got, ost_error *err);
/* Reads one byte. At the end of the input, *byte becomes -1. */
ost_status ost_input_byte(ost_input *input, int *byte, ost_error *err);
ost_status ost_input_skip(ost_input *input, uint64_t count, ost_error *err);
/*
 * Checks that the input ends here. Returns an error if further bytes follow, or if packed data have a wrong checksum.
 */
ost_status ost_input_expect_end(ost_input *input, ost_error *err);

/*
 * Returns the offset of the next byte. The offset refers to the file or, after gunzip or inflate, to the unpacked
 * data.
 */
uint64_t ost_input_offset(const ost_input *input);
enum { OST_LOCATION_TEXT = 64 };
/* Formats the offset of the next byte minus `back`, as "byte 12" or "byte 12 of the unpacked data". Returns `text`. */
char *ost_input_location(const ost_input *input, uint64_t back, char text[OST_LOCATION_TEXT]);

#endif
