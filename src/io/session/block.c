/* SPDX-License-Identifier: Apache-2.0 */
/* Encodes and decodes the 64 bytes of a block header. */
#include "io/session/layout.h"

#include <zlib.h>

uint32_t ost_session_crc(const void *bytes, size_t size)
{
    return (uint32_t)crc32_z(0, bytes, size);
}

void ost_session_block_encode(const session_block *block, unsigned char out[SESSION_BLOCK])
{
    memset(out, 0, SESSION_BLOCK);
    memcpy(out, session_magic, SESSION_MAGIC);
    put32(out + 8, block->kind);
    put32(out + 12, block->payload);
    put64(out + 16, block->sequence);
    put64(out + 24, block->first_record);
    put32(out + 32, block->records);
    put32(out + 36, block->payload_crc);
    put32(out + 40, block->identity);
    put32(out + 44, SESSION_VERSION);
    put64(out + 48, block->lost);
    put32(out + 60, ost_session_crc(out, 60));
}

bool ost_session_block_decode(const unsigned char in[SESSION_BLOCK], session_block *out)
{
    if (memcmp(in, session_magic, SESSION_MAGIC) != 0 || get32(in + 60) != ost_session_crc(in, 60))
        return false;
    *out = (session_block){
        .kind = get32(in + 8),
        .payload = get32(in + 12),
        .sequence = get64(in + 16),
        .first_record = get64(in + 24),
        .records = get32(in + 32),
        .payload_crc = get32(in + 36),
        .identity = get32(in + 40),
        .lost = get64(in + 48),
    };
    const uint32_t version = get32(in + 44);
    if (version < SESSION_VERSION_MIN || version > SESSION_VERSION || get32(in + 56) != 0 ||
        out->payload % SESSION_ALIGN != 0)
        return false;
    switch (out->kind) {
    case SESSION_KIND_HEADER:
        return out->payload > 0 && out->records == 0 && out->payload <= SESSION_PAYLOAD_MAX;
    case SESSION_KIND_RECORDS:
        return out->records > 0 && out->records <= SESSION_BLOCK_RECORDS &&
               out->payload == out->records * SESSION_RECORD;
    default:
        return false;
    }
}
