/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Copies the valid blocks of a damaged or truncated session to a new session.
 *
 * Each block keeps the number of its first record, so that readers can still count the missing records. The blocks
 * get new sequence numbers. No record is added: if the session has no end record, its copy has none either.
 */
#include <errno.h>
#include <stdlib.h>

#include "io/outfile.h"
#include "io/session/reader.h"
#include "io/session/write.h"

typedef struct copy {
    ost_outfile *file;
    ost_error *err;
    ost_status status;
} copy;

static int append(void *user, const void *bytes, size_t size)
{
    copy *c = user;
    c->status = ost_outfile_write(c->file, bytes, size, c->err);
    return c->status == OST_OK ? 0 : EIO;
}

static int nothing(void *user)
{
    (void)user;
    return 0;
}

static int cannot_cut(void *user, uint64_t size)
{
    (void)user;
    (void)size;
    return EIO;
}

ost_status ost_session_repair(ost_session *session, const char *out, ost_error *err)
{
    unsigned char *header = NULL, *bytes = malloc(SESSION_BLOCK + SESSION_PAYLOAD_MAX);
    uint32_t header_size;
    copy c = {.err = err};
    ost_status status = bytes ? OST_OK : ost_fail(err, OST_ERR_MEMORY, "out of memory for a block of %d bytes",
                                                  SESSION_PAYLOAD_MAX);
    if (status == OST_OK)
        status = ost_session_header_encode(session->header, &header, &header_size, err);
    if (status == OST_OK)
        status = ost_outfile_open(out, &c.file, err);
    session_writer writer = {.sink = {.user = &c, .append = append, .cut = cannot_cut, .sync = nothing}};
    if (status == OST_OK && ost_session_write_header(&writer, header, header_size) != 0)
        status = c.status != OST_OK ? c.status : ost_fail(err, OST_ERR_MEMORY, "out of memory for a session's header");
    for (size_t b = 0; b < session->block_count && status == OST_OK; b++) {
        const session_block_place *block = &session->blocks[b];
        status = ost_session_load(session, b, err);
        if (status != OST_OK)
            break;
        memcpy(bytes + SESSION_BLOCK, session->payload, (size_t)block->records * SESSION_RECORD);
        writer.records = block->first_record;
        if (ost_session_write_records(&writer, bytes + SESSION_BLOCK, block->records, block->lost) != 0)
            status = c.status;
    }
    ost_session_rewind(session);
    if (status == OST_OK)
        status = ost_outfile_commit(c.file, err);
    else
        ost_outfile_discard(c.file);
    free(header);
    free(bytes);
    return status;
}
