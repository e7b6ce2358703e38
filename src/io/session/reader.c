/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads a session, even if it is damaged or truncated.
 *
 *   scan, once     checks every block; valid blocks with records are listed,
 *                  all other bytes are counted
 *   next           reads the list, block by block
 *
 * After damage, reading continues at the next valid block. Blocks begin at multiples of 64. A valid block has correct
 * checksums, the identity of the session, and a higher sequence number than the blocks before it. The list for a file
 * of N bytes has at most N / 192 entries of 32 bytes, and only one block at a time is in memory.
 */
#include "io/session/reader.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "core/file.h"

/* ------------------------------------------------------------------ scan */

typedef struct scan {
    ost_session *session;
    uint64_t at, size;      /* current offset, and size of the file */
    uint64_t next_sequence;
    uint64_t next_record;   /* expected number of the next block's first record */
    uint64_t damage_from;   /* start of the damage that ends at the current offset; equal to `size` if there is none */
    bool gap;               /* true if ticks are missing before the current offset; missing notes are ignored */
    bool have_header;
} scan;

/* Reads up to `count` bytes at `offset`. *got is less than `count` only at the end of the file. */
static ost_status read_at(const ost_session *s, uint64_t offset, void *out, size_t count, size_t *got, ost_error *err)
{
    *got = 0;
    while (*got < count) {
        ssize_t n = pread(s->fd, (char *)out + *got, count - *got, (off_t)(offset + *got));
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0)
            return ost_fail(err, OST_ERR_IO, "%s: cannot read at byte %llu: %s", s->path,
                            (unsigned long long)(offset + *got), strerror(errno));
        if (n == 0)
            break;
        *got += (size_t)n;
    }
    return OST_OK;
}

static ost_status store_block(ost_session *s, const session_block *block, uint64_t at, ost_error *err)
{
    if (s->block_count == s->block_capacity) {
        const size_t capacity = s->block_capacity ? 2 * s->block_capacity : 256;
        session_block_place *grown = realloc(s->blocks, capacity * sizeof *grown);
        if (!grown)
            return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for a list of %zu blocks", s->path, capacity);
        s->blocks = grown;
        s->block_capacity = capacity;
    }
    s->blocks[s->block_count++] = (session_block_place){
        .at = at, .first_record = block->first_record, .lost = block->lost, .records = block->records};
    return OST_OK;
}

static void count_ticks(scan *c, const session_block *block)
{
    ost_session *s = c->session;
    ost_session_summary *sum = &s->summary;
    ost_record record;
    for (uint32_t i = 0; i < block->records; i++) {
        if (!ost_session_record_decode(s->payload + (size_t)i * SESSION_RECORD, &record))
            continue;
        if (record.kind == OST_RECORD_END)
            sum->ended = true;
        if (record.kind != OST_RECORD_TICK)
            continue;
        const ost_session_tick *tick = &record.as.tick;
        if (sum->ticks == 0) {
            sum->first_tick = tick->number;
            sum->first_t_ns = tick->tick.t_ns;
        }
        c->gap |= tick->number != (sum->ticks == 0 ? 0 : sum->last_tick + 1);
        sum->last_tick = tick->number;
        sum->last_t_ns = tick->tick.t_ns;
        sum->ticks++;
        sum->complete_ticks += !c->gap;
    }
}

static void end_damage(scan *c)
{
    if (c->damage_from < c->size) {
        c->session->summary.damaged_bytes += c->at - c->damage_from;
        c->damage_from = c->size;
    }
}

/* Processes a valid block whose payload has been read into session->payload. */
static ost_status take_block(scan *c, const session_block *block, ost_error *err)
{
    ost_session *s = c->session;
    end_damage(c);
    c->next_sequence = block->sequence + 1;
    s->summary.blocks++;
    if (block->kind == SESSION_KIND_HEADER) {
        if (!c->have_header) {
            ost_status status = ost_session_header_decode(s->payload, block->payload, &s->header, err);
            if (status != OST_OK) {
                ost_fail_context(err, "%s", s->path);
                return status;
            }
            s->identity = block->identity;
            c->have_header = true;
        }
        s->header_copies++;
        return OST_OK;
    }
    /* The recorder does not number the records that it loses, so they cause no gap in the numbers. */
    if (block->first_record > c->next_record)
        s->summary.missing_records += block->first_record - c->next_record;
    c->next_record = block->first_record + block->records;
    s->summary.records += block->records;
    s->summary.lost_records = block->lost;
    count_ticks(c, block);
    return store_block(s, block, c->at, err);
}

/* Returns true if a block with this valid header can follow the previous blocks. */
static bool may_follow(const scan *c, const session_block *block)
{
    if (block->sequence < c->next_sequence)
        return false;
    if (c->have_header && block->identity != c->session->identity)
        return false;
    return block->kind == SESSION_KIND_HEADER || block->first_record >= c->next_record;
}

static ost_status scan_one(scan *c, bool *done, ost_error *err)
{
    ost_session *s = c->session;
    unsigned char own[SESSION_BLOCK];
    session_block block;
    size_t got;
    ost_status status = read_at(s, c->at, own, sizeof own, &got, err);
    if (status != OST_OK)
        return status;
    if (got < sizeof own) {
        *done = true;
        return OST_OK;
    }
    uint64_t step = SESSION_ALIGN;
    if (ost_session_block_decode(own, &block) && may_follow(c, &block)) {
        status = read_at(s, c->at + SESSION_BLOCK, s->payload, block.payload, &got, err);
        if (status != OST_OK)
            return status;
        const bool complete = got == block.payload && ost_session_crc(s->payload, block.payload) == block.payload_crc &&
                           (block.kind != SESSION_KIND_HEADER || block.identity == block.payload_crc);
        if (complete) {
            status = take_block(c, &block, err);
            c->at += SESSION_BLOCK + block.payload;
            return status;
        }
        /* The header's checksum is valid, so the payload size is correct and no block begins within the payload. */
        if (got == block.payload)
            step = SESSION_BLOCK + block.payload;
    }
    if (c->damage_from == c->size)
        c->damage_from = c->at;
    c->at += step;
    return OST_OK;
}

static ost_status scan_all(ost_session *s, uint64_t size, ost_error *err)
{
    scan c = {.session = s, .size = size, .damage_from = size};
    bool done = false;
    ost_status status = OST_OK;
    /* The file may still grow. The scan ends at the size that the file had when it was opened. */
    while (!done && c.at < c.size && status == OST_OK)
        status = scan_one(&c, &done, err);
    if (status != OST_OK)
        return status;
    const uint64_t complete_to = c.damage_from < c.size ? c.damage_from : c.at < c.size ? c.at : c.size;
    s->summary.cut_bytes = c.size - complete_to;
    s->summary.file_bytes = c.size;
    s->summary.header_damaged = s->header_copies < 2;
    if (!c.have_header && s->summary.blocks == 0 && s->summary.cut_bytes == c.size) {
        return ost_fail(err, OST_ERR_INPUT,
                        c.size > 0 ? "%s: not a session, or both copies of its header are damaged"
                                   : "%s: file is empty; expected a session",
                        s->path);
    }
    if (!c.have_header)
        return ost_fail(err, OST_ERR_INPUT, "%s: both copies of the session's header are damaged; the session cannot "
                        "be used without one", s->path);
    return OST_OK;
}

/* ----------------------------------------------------------- the interface */

ost_status ost_session_open(const char *path, ost_session **out, ost_error *err)
{
    *out = NULL;
    ost_session *s = calloc(1, sizeof *s);
    if (!s)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a session");
    s->fd = -1;
    s->path = strdup(path);
    s->payload = malloc(SESSION_PAYLOAD_MAX);
    ost_file file;
    ost_status status = OST_OK;
    if (!s->path || !s->payload)
        status = ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for a block of %d bytes", path,
                          SESSION_PAYLOAD_MAX);
    else
        status = ost_file_open(path, &file, err);
    if (status == OST_OK) {
        s->fd = file.fd;
        status = scan_all(s, (uint64_t)file.size, err);
    }
    if (status != OST_OK) {
        ost_session_close(s);
        return status;
    }
    ost_session_rewind(s);
    *out = s;
    return OST_OK;
}

void ost_session_close(ost_session *session)
{
    if (!session)
        return;
    if (session->fd >= 0)
        close(session->fd);
    ost_session_header_free(session->header);
    free(session->blocks);
    free(session->payload);
    free(session->path);
    free(session);
}

const ost_session_header *ost_session_header_of(const ost_session *session)
{
    return session->header;
}

const ost_session_summary *ost_session_summary_of(const ost_session *session)
{
    return &session->summary;
}

void ost_session_rewind(ost_session *session)
{
    session->next_block = 0;
    session->record = session->records = 0;
}

ost_status ost_session_load(ost_session *s, size_t block, ost_error *err)
{
    const session_block_place *offset = &s->blocks[block];
    const size_t bytes = (size_t)offset->records * SESSION_RECORD;
    unsigned char own[SESSION_BLOCK];
    session_block head;
    size_t got = 0;
    ost_status status = read_at(s, offset->at, own, sizeof own, &got, err);
    if (status == OST_OK && got == sizeof own)
        status = read_at(s, offset->at + SESSION_BLOCK, s->payload, bytes, &got, err);
    if (status != OST_OK)
        return status;
    if (got != bytes || !ost_session_block_decode(own, &head) || ost_session_crc(s->payload, bytes) != head.payload_crc)
        return ost_fail(err, OST_ERR_IO, "%s: changed at byte %llu while it was read", s->path,
                        (unsigned long long)offset->at);
    return OST_OK;
}

ost_status ost_session_next(ost_session *s, ost_record *out, bool *more, ost_error *err)
{
    for (;;) {
        while (s->record < s->records)
            if (ost_session_record_decode(s->payload + (size_t)s->record++ * SESSION_RECORD, out)) {
                *more = true;
                return OST_OK;
            }
        *more = false;
        if (s->next_block == s->block_count)
            return OST_OK;
        ost_status status = ost_session_load(s, s->next_block, err);
        if (status != OST_OK)
            return status;
        s->records = s->blocks[s->next_block++].records;
        s->record = 0;
    }
}

static void add(char text[OST_SESSION_MISSING], const char *format, ...) OST_PRINTF(2, 3);

static void add(char text[OST_SESSION_MISSING], const char *format, ...)
{
    size_t used = strlen(text);
    if (used)
        used += (size_t)snprintf(text + used, OST_SESSION_MISSING - used, "; ");
    va_list args;
    va_start(args, format);
    if (used < OST_SESSION_MISSING)
        vsnprintf(text + used, OST_SESSION_MISSING - used, format, args);
    va_end(args);
}

const char *ost_session_missing(const ost_session *session, char text[OST_SESSION_MISSING])
{
    const ost_session_summary *s = &session->summary;
    text[0] = '\0';
    if (!s->ended && s->ticks)
        add(text, "the recording is incomplete: it was cut off after tick %llu, counted from 0",
            (unsigned long long)s->last_tick);
    else if (!s->ended)
        add(text, "the recording is incomplete: it was cut off before the first tick");
    if (s->cut_bytes)
        add(text, "%llu bytes at the end are an incomplete block", (unsigned long long)s->cut_bytes);
    if (s->damaged_bytes)
        add(text, "%llu bytes are damaged", (unsigned long long)s->damaged_bytes);
    if (s->missing_records)
        add(text, "%llu records are missing there", (unsigned long long)s->missing_records);
    if (s->lost_records)
        add(text, "%llu records were lost while it was recorded", (unsigned long long)s->lost_records);
    if (s->complete_ticks < s->ticks)
        add(text, "only the first %llu of the %llu ticks in the file can be replayed",
            (unsigned long long)s->complete_ticks, (unsigned long long)s->ticks);
    if (s->header_damaged)
        add(text, "one of the two copies of its header is damaged");
    return text;
}

ost_status ost_session_path(ost_session *session, ost_path *out, ost_error *err)
{
    const uint64_t count = session->summary.complete_ticks;
    *out = (ost_path){0};
    if (count == 0 || count > OST_PATH_TICKS_MAX)
        return ost_fail(err, OST_ERR_INPUT, "%s: %llu ticks can be replayed; expected 1 to %d", session->path,
                        (unsigned long long)count, OST_PATH_TICKS_MAX);
    ost_status status = ost_path_init(out, (size_t)count, err);
    ost_session_rewind(session);
    for (size_t i = 0; i < count && status == OST_OK;) {
        ost_record record;
        bool more;
        status = ost_session_next(session, &record, &more, err);
        if (status == OST_OK && !more)
            status = ost_fail(err, OST_ERR_IO, "%s: the file became shorter while it was read", session->path);
        if (status == OST_OK && record.kind == OST_RECORD_TICK)
            out->ticks[i++] = record.as.tick.tick;
    }
    ost_session_rewind(session);
    if (status != OST_OK)
        ost_path_free(out);
    return status;
}
