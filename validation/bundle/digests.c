/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/bundle/digests.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Computes the digest of the leaf whose first voxel is at `from` in the block. Voxels outside the block count as
   zero. */
static ost_status leaf_of(const trace_block_view *b, const int32_t from[3], ost_digest *out, ost_error *err)
{
    static _Thread_local union {
        int16_t wide[OST_LEAF * OST_LEAF * OST_LEAF];
        uint8_t narrow[OST_LEAF * OST_LEAF * OST_LEAF];
    } leaf;
    const size_t size = b->voxel_bytes, wide = (size_t)b->dims.x, high = (size_t)b->dims.y;
    const int32_t n = b->dims.x - from[0] < OST_LEAF ? b->dims.x - from[0] : OST_LEAF;
    /* two-byte voxels are in `wide`, one-byte voxels in `narrow`; both begin at this address */
    uint8_t *bytes = (uint8_t *)&leaf;
    memset(&leaf, 0, sizeof leaf);
    for (int32_t k = 0; k < OST_LEAF && from[2] + k < b->dims.z; k++)
        for (int32_t j = 0; j < OST_LEAF && from[1] + j < b->dims.y; j++)
            memcpy(bytes + size * (size_t)(OST_LEAF * (j + OST_LEAF * k)),
                   b->voxels + size * ((size_t)from[0] + wide * ((size_t)(from[1] + j) + high * (size_t)(from[2] + k))),
                   size * (size_t)n);
    return size == 1 ? ost_digest_leaf8(leaf.narrow, out, err) : ost_digest_leaf16(leaf.wide, out, err);
}

static ost_status add_leaves(const trace_block_view *b, bool numbered, ost_dims bone, json_t *leaves, ost_error *err)
{
    const ost_dims count = ost_leaf_dims(b->dims), all = ost_leaf_dims(bone);
    for (int32_t z = 0; z < count.z; z++)
        for (int32_t y = 0; y < count.y; y++)
            for (int32_t x = 0; x < count.x; x++) {
                const int32_t from[3] = {x * OST_LEAF, y * OST_LEAF, z * OST_LEAF};
                char hex[OST_DIGEST_HEX];
                ost_digest digest;
                ost_status status = leaf_of(b, from, &digest, err);
                if (status != OST_OK)
                    return status;
                ost_digest_hex(&digest, hex);
                const int64_t number = (b->lo[0] + from[0]) / OST_LEAF +
                                       (int64_t)all.x * ((b->lo[1] + from[1]) / OST_LEAF +
                                                         (int64_t)all.y * ((b->lo[2] + from[2]) / OST_LEAF));
                if (json_array_append_new(leaves, numbered ? json_pack("[I,s]", (json_int_t)number, hex)
                                                           : json_string(hex)) != 0)
                    return ost_fail(err, OST_ERR_MEMORY, "out of memory for digests");
            }
    return OST_OK;
}

/* Adds the words of a record to the digest. Words that are bounds are added as 0, because the arithmetic does not
   prescribe their values (trace_word_is_bound). */
static ost_status add_words(ost_hasher *h, trace_stage stage, const uint8_t *words, uint64_t count, ost_error *err)
{
    enum { AT_ONCE = 64 };
    static const uint8_t zero[8];
    uint8_t some[8 * AT_ONCE];
    ost_status status = OST_OK;
    for (uint64_t i = 0; i < count && status == OST_OK;) {
        size_t n = 0;
        for (; n < AT_ONCE && i < count; n++, i++)
            memcpy(some + 8 * n, trace_word_is_bound(stage, (size_t)i) ? zero : words + 8 * i, 8);
        status = ost_hasher_add(h, some, 8 * n, err);
    }
    return status;
}

static ost_status digest_without_bounds(const trace_record *r, const uint8_t *words, uint64_t count, ost_digest *out,
                                        ost_error *err)
{
    ost_hasher *h;
    ost_status status = ost_hasher_open(&h, err);
    if (status != OST_OK)
        return status;
    const uint8_t *behind = words + 8 * count;
    status = ost_hasher_add(h, r->body, 8, err);
    if (status == OST_OK)
        status = add_words(h, r->stage, words, count, err);
    if (status == OST_OK)
        status = ost_hasher_add(h, behind, (size_t)(r->body + r->body_bytes - behind), err);
    if (status == OST_OK)
        return ost_hasher_close(h, out, err);
    ost_hasher_close(h, NULL, NULL);
    return status;
}

/* Computes the digest of the compared part of a record. Words that are bounds count as 0. In the record of a
   failed stage, only the status is included. */
static ost_status digest_of_record(const trace_record *r, ost_digest *out, ost_error *err)
{
    uint64_t count;
    const uint8_t *words;
    if ((r->stage == TRACE_STEPS || r->stage == TRACE_TICK) && trace_words(r, &count, &words))
        return digest_without_bounds(r, words, count, out, err);
    const bool refusal = r->stage == TRACE_FAILED && trace_words(r, &count, &words);
    return ost_digest_bytes(r->body, refusal ? 8 + 8 * (size_t)count : (size_t)r->body_bytes, out, err);
}

/* Reads the digest of a case's input, which is stored in the words of the case's first record. */
static void input_of(const trace_record *r, ost_digest *out)
{
    uint64_t count;
    const uint8_t *words;
    *out = (ost_digest){{0}};
    if (trace_words(r, &count, &words) && count >= sizeof out->bytes / 8)
        memcpy(out->bytes, words, sizeof out->bytes);
}

ost_status digests_of_case(const trace *t, compare_range range, char **lines, ost_digest *of_lines, ost_error *err)
{
    enum { LINE = 24 + OST_DIGEST_HEX };
    ost_status status = OST_OK;
    size_t used = 0;
    *lines = malloc(range.count * LINE + 1);
    if (!*lines)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for the digests of %zu records", range.count);
    (*lines)[0] = '\0';
    for (size_t k = 0; k < range.count && status == OST_OK; k++) {
        const trace_record *r = &t->records[range.first + k];
        char hex[OST_DIGEST_HEX] = "-";
        ost_digest digest;
        if (r->stage == TRACE_CASE)
            input_of(r, &digest);
        else if (!(r->flags & TRACE_STAND_IN))
            status = digest_of_record(r, &digest, err);
        if (!(r->flags & TRACE_STAND_IN))
            ost_digest_hex(&digest, hex);
        used += (size_t)snprintf(*lines + used, LINE, "%s %u %s\n", trace_stage_name(r->stage), r->item, hex);
    }
    if (status == OST_OK)
        status = ost_digest_bytes(*lines, used, of_lines, err);
    if (status != OST_OK) {
        free(*lines);
        *lines = NULL;
    }
    return status;
}

ost_status digests_of_record(const trace_record *r, ost_dims bone, json_t **out, ost_error *err)
{
    char hex[OST_DIGEST_HEX];
    ost_digest body;
    size_t at = 0;
    trace_block_view block;
    *out = NULL;
    json_t *leaves = json_array();
    ost_status status = digest_of_record(r, &body, err);
    while (status == OST_OK && trace_next_block(r, &at, &block))
        status = add_leaves(&block, r->stage == TRACE_TICK, bone, leaves, err);
    if (status == OST_OK)
        *out = json_pack("{s:s,s:I,s:s}", "stage", trace_stage_name(r->stage), "item", (json_int_t)r->item, "sha256",
                         ost_digest_hex(&body, hex));
    if (*out && json_array_size(leaves) > 0)
        json_object_set(*out, "leaves", leaves);
    json_decref(leaves);
    return status != OST_OK || *out ? status : ost_fail(err, OST_ERR_MEMORY, "out of memory for digests");
}
