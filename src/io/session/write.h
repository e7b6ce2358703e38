/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Blocks, one behind the other, through a sink: a file, a copy of one, or in
 * tests a disk that fails when it is told to.
 */
#ifndef OST_IO_SESSION_WRITE_H
#define OST_IO_SESSION_WRITE_H

#include "io/session/layout.h"

typedef struct session_sink {
    void *user;
    /* All of it at the end, or an errno; what a failed call left behind is taken back by cut. */
    int (*append)(void *user, const void *bytes, size_t size);
    /* Makes the file end at size again after a failure. */
    int (*cut)(void *user, uint64_t size);
    /* What was appended survives a power cut. */
    int (*sync)(void *user);
} session_sink;

typedef struct session_writer {
    session_sink sink;
    uint64_t bytes, sequence, records;
    uint32_t identity;
    bool cut_needed; /* a failed append may have left bytes */
} session_writer;

/* Both copies of the header; 0 or an errno. */
int ost_session_write_header(session_writer *writer, const unsigned char *payload, uint32_t size);
/*
 * count encoded records, 1 to SESSION_BLOCK_RECORDS, as a block, whose own
 * bytes go to the 64 before them: there must be room.  0 or an errno, and then
 * nothing has happened and the same call may be tried again.
 */
int ost_session_write_records(session_writer *writer, unsigned char *records, uint32_t count, uint64_t lost);

#endif
