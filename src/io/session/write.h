/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writes blocks, one after the other, through a sink: a file, a copy of a session,
 * or in tests a disk that fails on request.
 */
#ifndef OST_IO_SESSION_WRITE_H
#define OST_IO_SESSION_WRITE_H

#include "io/session/layout.h"

typedef struct session_sink {
    void *user;
    /* Appends all bytes; returns 0 or an errno. The bytes that a failed call may have left are removed by cut. */
    int (*append)(void *user, const void *bytes, size_t size);
    /* Truncates the file to size after a failure. */
    int (*cut)(void *user, uint64_t size);
    /* Makes the appended bytes durable, so that they survive a power cut. */
    int (*sync)(void *user);
} session_sink;

typedef struct session_writer {
    session_sink sink;
    uint64_t bytes, sequence, records;
    uint32_t identity;
    bool cut_needed; /* a failed append may have left bytes */
} session_writer;

/* Writes both copies of the header; returns 0 or an errno. */
int ost_session_write_header(session_writer *writer, const unsigned char *payload, uint32_t size);
/*
 * Writes count encoded records, 1 to SESSION_BLOCK_RECORDS, as a block.  The block
 * header is written to the 64 bytes before the records, which the caller must
 * provide.  Returns 0 or an errno; after an error the file is unchanged (or is cut
 * before the next write), and the same call may be repeated.
 */
int ost_session_write_records(session_writer *writer, unsigned char *records, uint32_t count, uint64_t lost);

#endif
