/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads the data of a volume as one stream, even if the data are distributed over several files.
 *
 *   part 0: one file, data_bytes of it -> part 1 -> ... -> part count - 1
 *
 * Every part is checked before anything is allocated: a plain part must contain exactly its bytes, and a packed part
 * must be large enough to unpack to its bytes. The parts are then opened one after the other, so only one file is open
 * at a time. Further data are an error, because either the sizes or the file is wrong.
 */
#ifndef OST_IO_VOLUME_PARTS_H
#define OST_IO_VOLUME_PARTS_H

#include "io/volume/input.h"

typedef struct ost_parts {
    /* Opens part `index` and positions *out at the first byte of its data. */
    ost_status (*open)(void *user, uint64_t index, ost_input **out, ost_error *err);
    void *user;
    uint64_t count;
    uint64_t part_bytes; /* size in bytes of the unpacked data of each part */
    bool text; /* true if the data are text; their length is not known in advance, and part_bytes is the minimum */
    /* The functions below set the following members. */
    ost_input *input;
    uint64_t index; /* index of the next part to open */
    uint64_t left;  /* remaining bytes of the open part */
} ost_parts;

/* Checks that every part exists and can contain its data. Called before memory is allocated. */
ost_status ost_parts_check(const ost_parts *parts, ost_error *err);
/*
 * Reads exactly `size` bytes. If the data end earlier, the error message states the offset of their end. Must not be
 * called for text.
 */
ost_status ost_parts_read(ost_parts *parts, void *bytes, size_t size, ost_error *err);
/* Returns an error if further data follow. Must be called after the last byte has been read. */
ost_status ost_parts_end(ost_parts *parts, ost_error *err);
void ost_parts_close(ost_parts *parts);

/* Opens the next part if no part is open. Called by readers of text, which then read directly from parts->input. */
ost_status ost_parts_ready(ost_parts *parts, ost_error *err);

#endif
