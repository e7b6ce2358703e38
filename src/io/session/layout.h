/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The binary format of a session; docs/spec/session.md is the normative text.
 *
 *   | block | block | block | ...        a block: a block header of 64 bytes, then a payload whose size
 *     head    head    records            is a multiple of 64, so all offsets are multiples of 64
 *
 *   offsets in the block header
 *    0  magic, 8 bytes         32  u32 records in the payload
 *    8  u32 kind               36  u32 CRC-32 of the payload
 *   12  u32 payload's bytes    40  u32 CRC-32 of the header's text, the session's identity
 *   16  u64 sequence, from 0   44  u32 version of the format
 *   24  u64 first record       48  u64 records lost so far
 *                              56  u32 0     60  u32 CRC-32 of bytes 0 to 59
 *
 * All integers are little-endian.
 */
#ifndef OST_IO_SESSION_LAYOUT_H
#define OST_IO_SESSION_LAYOUT_H

#include <string.h>

#include <osteon/session.h>

enum {
    SESSION_VERSION = 2, /* version of files that are written; version 1, without motor speeds, can also be read */
    SESSION_VERSION_MIN = 1,
    SESSION_ALIGN = 64,
    SESSION_BLOCK = 64,   /* size of the block header */
    SESSION_RECORD = 128,
    SESSION_BLOCK_RECORDS = 4096,
    SESSION_PAYLOAD_MAX = SESSION_BLOCK_RECORDS * SESSION_RECORD,
    SESSION_KIND_HEADER = 1,
    SESSION_KIND_RECORDS = 2,
    SESSION_MAGIC = 8
};

static const unsigned char session_magic[SESSION_MAGIC] = {0x89, 'O', 'S', 'T', 'S', 'E', 'S', '\n'};

typedef struct session_block {
    uint32_t kind, payload;
    uint64_t sequence, first_record;
    uint32_t records, payload_crc, identity;
    uint64_t lost;
} session_block;

static inline void put16(unsigned char *p, uint16_t v)
{
    p[0] = (unsigned char)v;
    p[1] = (unsigned char)(v >> 8);
}

static inline void put32(unsigned char *p, uint32_t v)
{
    put16(p, (uint16_t)v);
    put16(p + 2, (uint16_t)(v >> 16));
}

static inline void put64(unsigned char *p, uint64_t v)
{
    put32(p, (uint32_t)v);
    put32(p + 4, (uint32_t)(v >> 32));
}

static inline uint16_t get16(const unsigned char *p)
{
    return (uint16_t)(p[0] | p[1] << 8);
}

static inline uint32_t get32(const unsigned char *p)
{
    return get16(p) | (uint32_t)get16(p + 2) << 16;
}

static inline uint64_t get64(const unsigned char *p)
{
    return get32(p) | (uint64_t)get32(p + 4) << 32;
}

/* ---------------------------------------------------------------- block.c */

uint32_t ost_session_crc(const void *bytes, size_t size);
void ost_session_block_encode(const session_block *block, unsigned char out[SESSION_BLOCK]);
/* Decodes a block header. Returns false if its magic, checksum, version or sizes are not valid. */
bool ost_session_block_decode(const unsigned char in[SESSION_BLOCK], session_block *out);

/* --------------------------------------------------------------- record.c */

void ost_session_record_encode(const ost_record *record, unsigned char out[SESSION_RECORD]);
/*
 * Decodes a record. Returns false if the kind of the record is unknown; the caller then skips the record. Only newer
 * versions of osteon write unknown kinds.
 */
bool ost_session_record_decode(const unsigned char in[SESSION_RECORD], ost_record *out);

/* --------------------------------------------------------------- header.c */

/* Encodes the payload of the header, including its padding. The caller frees *out. */
ost_status ost_session_header_encode(const ost_session_header *header, unsigned char **out, uint32_t *size,
                                     ost_error *err);
ost_status ost_session_header_decode(const unsigned char *in, size_t size, ost_session_header **out, ost_error *err);

#endif
