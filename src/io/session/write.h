/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writes consecutive blocks through a sink: a file, a copy of a session or, in tests, a simulated disk that fails on
 * request.
 */
#ifndef OST_IO_SESSION_WRITE_H
#define OST_IO_SESSION_WRITE_H

#include "io/session/layout.h"

typedef struct session_sink {
    void *user;
    /* Appends all bytes. Returns 0 or an errno. After a failure, `cut` removes the bytes that were already appended. */
    int (*append)(void *user, const void *bytes, size_t size);
    /* Truncates the file to `size` bytes after a failed append. */
    int (*cut)(void *user, uint64_t size);
    /* Makes the appended bytes durable, so that they survive a power cut. */
    int (*sync)(void *user);
} session_sink;

typedef struct session_writer {
    session_sink sink;
    uint64_t bytes, sequence, records;
    uint32_t identity;
    bool cut_needed; /* true if a failed append may have left partial data at the end of the file */
} session_writer;

/* Writes both copies of the session's header. Returns 0 or an errno. */
int ost_session_write_header(session_writer *writer, const unsigned char *payload, uint32_t size);
/*
 * Writes `count` encoded records (1 to SESSION_BLOCK_RECORDS) as one block. The block header is written to the 64 bytes
 * before `records`, which the caller must reserve. Returns 0 or an errno. After an error, the call may be repeated,
 * because partial data are cut off before the next write.
 */
int ost_session_write_records(session_writer *writer, unsigned char *records, uint32_t count, uint64_t lost);

#endif
