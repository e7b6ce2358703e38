/* SPDX-License-Identifier: Apache-2.0 */
/* An open session, shared by the source files that read sessions. reader.c fills the struct. */
#ifndef OST_IO_SESSION_READER_H
#define OST_IO_SESSION_READER_H

#include "io/session/layout.h"

typedef struct session_block_place {
    uint64_t at, first_record, lost;
    uint32_t records;
} session_block_place;

struct ost_session {
    int fd;
    char *path;                 /* owned */
    ost_session_header *header; /* owned */
    int header_copies;
    uint32_t identity;
    ost_session_summary summary;
    session_block_place *blocks; /* owned; the valid blocks that contain records */
    size_t block_count, block_capacity;
    unsigned char *payload;     /* owned; payload of the block that was read last */
    /* The next call of ost_session_next returns the record with the index `record` in `payload`. After the last of the
       `records` records in `payload`, the call loads block `next_block`. */
    size_t next_block;
    uint32_t record, records;
};

/* Reads the records of a block into session->payload and checks them again. */
ost_status ost_session_load(ost_session *session, size_t block, ost_error *err);

#endif
