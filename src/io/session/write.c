/* SPDX-License-Identifier: Apache-2.0 */
#include "io/session/write.h"

#include <errno.h>
#include <stdlib.h>

/* Writes a block header and its payload in one append, so that the file does not end between
   them if the process is killed. */
static int put_block(session_writer *writer, session_block *block, unsigned char *bytes)
{
    if (writer->cut_needed) {
        const int error = writer->sink.cut(writer->sink.user, writer->bytes);
        if (error)
            return error;
        writer->cut_needed = false;
    }
    block->sequence = writer->sequence;
    block->first_record = writer->records;
    block->payload_crc = ost_session_crc(bytes + SESSION_BLOCK, block->payload);
    block->identity = writer->identity;
    ost_session_block_encode(block, bytes);
    const int error = writer->sink.append(writer->sink.user, bytes, SESSION_BLOCK + (size_t)block->payload);
    if (error) {
        writer->cut_needed = true;
        return error;
    }
    writer->bytes += SESSION_BLOCK + block->payload;
    writer->sequence++;
    writer->records += block->records;
    return 0;
}

int ost_session_write_header(session_writer *writer, const unsigned char *payload, uint32_t size)
{
    unsigned char *bytes = malloc(SESSION_BLOCK + (size_t)size);
    if (!bytes)
        return ENOMEM;
    memcpy(bytes + SESSION_BLOCK, payload, size);
    writer->identity = ost_session_crc(payload, size);
    int error = 0;
    for (int copy = 0; copy < 2 && !error; copy++)
        error = put_block(writer, &(session_block){.kind = SESSION_KIND_HEADER, .payload = size}, bytes);
    free(bytes);
    return error;
}

int ost_session_write_records(session_writer *writer, unsigned char *records, uint32_t count, uint64_t lost)
{
    session_block block = {
        .kind = SESSION_KIND_RECORDS, .payload = count * SESSION_RECORD, .records = count, .lost = lost};
    return put_block(writer, &block, records - SESSION_BLOCK);
}
