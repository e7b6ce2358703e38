/* SPDX-License-Identifier: Apache-2.0 */
/*
 * One regular file as a stream of bytes, gunzipped on the way when asked:
 * what the volume readers read from.
 *
 *   open -> plain bytes ... gunzip -> the bytes that the rest unpacks to
 *
 * Memory is two buffers, whatever the file.  Only regular files are taken,
 * so that sizes can be checked before anything is allocated, and a pipe or a
 * device cannot hang a reader.
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

/* The file's size, and how much of it has not been taken yet (packed bytes when gunzipping). */
uint64_t ost_input_file_bytes(const ost_input *input);
uint64_t ost_input_file_left(const ost_input *input);

/* Goes to a byte of the file; plain bytes again. */
ost_status ost_input_seek(ost_input *input, uint64_t offset, ost_error *err);
/* From the next byte on the file is gzip (members may follow each other). Unpacked offsets start at 0. */
ost_status ost_input_gunzip(ost_input *input, ost_error *err);

bool ost_input_is_packed(const ost_input *input);
/* At most this many bytes can still come: exact when plain, deflate's limit (1032 to 1) when packed. */
uint64_t ost_input_at_most(const ost_input *input);

/* Fewer than want only at the end. A packed file that breaks off or is damaged is OST_ERR_INPUT. */
ost_status ost_input_read(ost_input *input, void *bytes, size_t want, size_t *got, ost_error *err);
/* One byte, or -1 at the end. */
ost_status ost_input_byte(ost_input *input, int *byte, ost_error *err);
ost_status ost_input_skip(ost_input *input, uint64_t count, ost_error *err);
/* Nothing may follow: neither bytes nor, when packed, a wrong checksum. */
ost_status ost_input_expect_end(ost_input *input, ost_error *err);

/* Of the next byte: in the file, or in what it unpacks to. */
uint64_t ost_input_offset(const ost_input *input);
enum { OST_PLACE_TEXT = 64 };
/* "byte 12" or "byte 12 of the unpacked data", `back` bytes before the next one. Returns text. */
char *ost_input_place(const ost_input *input, uint64_t back, char text[OST_PLACE_TEXT]);

#endif
