/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A volume's data as one stream, though it may lie in several files.
 *
 *   part 0: one file, data_bytes of it -> part 1 -> ... -> part count - 1
 *
 * Every part is looked at before anything is allocated: a plain one must hold
 * exactly its bytes, a packed one must be able to.  Then they are opened one
 * after the other, so that one file is open at a time.  Data that go on where
 * the sizes say they end are an error: either the sizes are wrong or the file is.
 */
#ifndef OST_IO_VOLUME_PARTS_H
#define OST_IO_VOLUME_PARTS_H

#include "io/volume/input.h"

typedef struct ost_parts {
    /* Opens part `index` with the next byte the first of its data. */
    ost_status (*open)(void *user, uint64_t index, ost_input **out, ost_error *err);
    void *user;
    uint64_t count;
    uint64_t part_bytes; /* of data in each, unpacked */
    bool text;           /* lengths are not known in advance: part_bytes is the least */
    /* below: kept by the functions */
    ost_input *input;
    uint64_t index; /* of the next part to open */
    uint64_t left;  /* bytes of the open part still to come */
} ost_parts;

/* Before allocating: whether every part is there and can hold its data. */
ost_status ost_parts_check(const ost_parts *parts, ost_error *err);
/* Exactly size bytes, or an error that says where they ended. Not for text. */
ost_status ost_parts_read(ost_parts *parts, void *bytes, size_t size, ost_error *err);
/* After the last byte: nothing may follow. */
ost_status ost_parts_end(ost_parts *parts, ost_error *err);
void ost_parts_close(ost_parts *parts);

/* Opens the next part when none is open. For readers of text, which then read parts->input themselves. */
ost_status ost_parts_ready(ost_parts *parts, ost_error *err);

#endif
