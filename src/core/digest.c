/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Computes the leaves, the tree and the root of a digest (AR-DIG) with the SHA-256 of libcrypto.
 *
 *   leaves in x-fastest order   L0 L1 L2 L3 L4
 *   split at the greatest power  \  / \  /   |
 *   of two below the count        N    N     |
 *                                  \  /      |
 *                                   N        |
 *                                    \       |
 *                                      N ----'  -> root = H(2 || header || N)
 */
#include "core/conditions.h"

#include <osteon/digest.h>

#include <openssl/evp.h>
#include <stdlib.h>
#include <string.h>

enum {
    PREFIX_LEAF = 0,
    PREFIX_NODE = 1,
    PREFIX_ROOT = 2,
    HEADER_BYTES = 128,
    LEAF_VOXELS = OST_LEAF * OST_LEAF * OST_LEAF
};

struct ost_hasher {
    EVP_MD_CTX *context;
};

ost_status ost_hasher_open(ost_hasher **out, ost_error *err)
{
    ost_hasher *hasher = malloc(sizeof *hasher);
    *out = NULL;
    if (!hasher)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a SHA-256 context");
    hasher->context = EVP_MD_CTX_new();
    if (!hasher->context || EVP_DigestInit_ex(hasher->context, EVP_sha256(), NULL) != 1) {
        EVP_MD_CTX_free(hasher->context);
        free(hasher);
        return ost_fail(err, OST_ERR_MEMORY, "libcrypto: out of memory for SHA-256, or built without it");
    }
    *out = hasher;
    return OST_OK;
}

ost_status ost_hasher_add(ost_hasher *hasher, const void *bytes, size_t size, ost_error *err)
{
    if (EVP_DigestUpdate(hasher->context, bytes, size) != 1)
        return ost_fail(err, OST_ERR_MEMORY, "libcrypto: out of memory for the hash of %zu bytes", size);
    return OST_OK;
}

ost_status ost_hasher_close(ost_hasher *hasher, ost_digest *out, ost_error *err)
{
    ost_status status = OST_OK;
    if (!hasher)
        return status;
    unsigned length = 0;
    ost_digest digest;
    if (EVP_DigestFinal_ex(hasher->context, digest.bytes, &length) != 1 || length != OST_DIGEST_BYTES)
        status = ost_fail(err, OST_ERR_MEMORY, "libcrypto: out of memory for a digest");
    else if (out)
        *out = digest;
    EVP_MD_CTX_free(hasher->context);
    free(hasher);
    return status;
}

/* Computes the SHA-256 of the concatenation of up to three pieces. */
static ost_status hash_pieces(const void *const piece[], const size_t size[], int count, ost_digest *out,
                              ost_error *err)
{
    ost_hasher *hasher;
    ost_status status = ost_hasher_open(&hasher, err);
    if (status != OST_OK)
        return status;
    for (int i = 0; i < count && status == OST_OK; i++)
        status = ost_hasher_add(hasher, piece[i], size[i], err);
    ost_status closed = ost_hasher_close(hasher, status == OST_OK ? out : NULL, status == OST_OK ? err : NULL);
    return status == OST_OK ? closed : status;
}

ost_status ost_digest_bytes(const void *bytes, size_t size, ost_digest *out, ost_error *err)
{
    return hash_pieces((const void *const[]){bytes}, (const size_t[]){size}, 1, out, err);
}

static ost_status hash_prefixed(uint8_t prefix, const void *a, size_t a_size, const void *b, size_t b_size,
                                ost_digest *out, ost_error *err)
{
    return hash_pieces((const void *const[]){&prefix, a, b}, (const size_t[]){1, a_size, b_size}, 3, out, err);
}

/* Hashes the voxels as they lie in memory, because conditions.h accepts only little-endian machines. */
ost_status ost_digest_leaf16(const int16_t voxels[LEAF_VOXELS], ost_digest *out, ost_error *err)
{
    return hash_prefixed(PREFIX_LEAF, voxels, LEAF_VOXELS * sizeof *voxels, "", 0, out, err);
}

ost_status ost_digest_leaf8(const uint8_t voxels[LEAF_VOXELS], ost_digest *out, ost_error *err)
{
    return hash_prefixed(PREFIX_LEAF, voxels, LEAF_VOXELS, "", 0, out, err);
}

ost_dims ost_leaf_dims(ost_dims dims)
{
    return (ost_dims){(dims.x + OST_LEAF - 1) / OST_LEAF, (dims.y + OST_LEAF - 1) / OST_LEAF,
                      (dims.z + OST_LEAF - 1) / OST_LEAF};
}

/* Computes the root of the tree over `count` leaves. The depth of the recursion is log2(count), at most 36. */
static ost_status tree(const ost_digest *leaves, size_t count, ost_digest *out, ost_error *err)
{
    if (count == 1) {
        *out = leaves[0];
        return OST_OK;
    }
    size_t left_count = 1;
    while (left_count * 2 < count)
        left_count *= 2;
    ost_digest left, right;
    ost_status status = tree(leaves, left_count, &left, err);
    if (status == OST_OK)
        status = tree(leaves + left_count, count - left_count, &right, err);
    if (status == OST_OK)
        status = hash_prefixed(PREFIX_NODE, left.bytes, sizeof left.bytes, right.bytes, sizeof right.bytes, out, err);
    return status;
}

static void put32(uint8_t *p, uint32_t v)
{
    memcpy(p, &v, sizeof v);
}

static void put64(uint8_t *p, uint64_t v)
{
    memcpy(p, &v, sizeof v);
}

/* Writes the header of a digest, with the layout of AR-DIG-4. */
static void fill_header(uint8_t header[HEADER_BYTES], ost_grid_kind kind, const ost_geometry *geometry,
                        int32_t threshold, size_t count)
{
    memset(header, 0, HEADER_BYTES);
    memcpy(header, "OSTEONG1", 8);
    put32(header + 8, OST_ARITHMETIC_VERSION);
    put32(header + 12, (uint32_t)kind);
    put32(header + 16, (uint32_t)geometry->dims.x);
    put32(header + 20, (uint32_t)geometry->dims.y);
    put32(header + 24, (uint32_t)geometry->dims.z);
    put64(header + 32, (uint64_t)geometry->spacing.x);
    put64(header + 40, (uint64_t)geometry->spacing.y);
    put64(header + 48, (uint64_t)geometry->spacing.z);
    put64(header + 56, (uint64_t)geometry->origin.x);
    put64(header + 64, (uint64_t)geometry->origin.y);
    put64(header + 72, (uint64_t)geometry->origin.z);
    put32(header + 80, (uint32_t)threshold);
    put32(header + 84, OST_LEAF);
    put64(header + 88, count);
}

ost_status ost_digest_root(ost_grid_kind kind, const ost_geometry *geometry, int32_t threshold,
                           const ost_digest *leaves, size_t count, ost_digest *out, ost_error *err)
{
    ost_dims expected = ost_leaf_dims(geometry->dims);
    if (count == 0 || (int64_t)count != ost_dims_count(expected))
        return ost_fail(err, OST_ERR_USAGE, "%zu leaves given for a grid that has %lld", count,
                        (long long)ost_dims_count(expected));
    uint8_t header[HEADER_BYTES];
    fill_header(header, kind, geometry, threshold, count);
    ost_digest top;
    ost_status status = tree(leaves, count, &top, err);
    if (status == OST_OK)
        status = hash_prefixed(PREFIX_ROOT, header, sizeof header, top.bytes, sizeof top.bytes, out, err);
    return status;
}

ost_status ost_digest_volume(ost_grid_kind kind, const ost_volume *volume, ost_digest *out, ost_error *err)
{
    return ost_digest_dense(kind, &volume->geometry, volume->voxels, sizeof *volume->voxels, out, err);
}

/* Copies the voxels of the leaf with the indices (lx, ly, lz). Voxels outside the grid are 0. */
static void gather_leaf(const uint8_t *voxels, size_t voxel_size, ost_dims dims, int32_t lx, int32_t ly, int32_t lz,
                        uint8_t *leaf)
{
    memset(leaf, 0, LEAF_VOXELS * voxel_size);
    int32_t x0 = lx * OST_LEAF;
    int32_t width = dims.x - x0 < OST_LEAF ? dims.x - x0 : OST_LEAF;
    for (int32_t z = 0; z < OST_LEAF && lz * OST_LEAF + z < dims.z; z++)
        for (int32_t y = 0; y < OST_LEAF && ly * OST_LEAF + y < dims.y; y++) {
            int64_t from = x0 + (int64_t)dims.x * (ly * OST_LEAF + y + (int64_t)dims.y * (lz * OST_LEAF + z));
            memcpy(leaf + (size_t)(OST_LEAF * (y + OST_LEAF * z)) * voxel_size, voxels + (size_t)from * voxel_size,
                   (size_t)width * voxel_size);
        }
}

ost_status ost_digest_dense(ost_grid_kind kind, const ost_geometry *geometry, const void *voxels, size_t voxel_size,
                            ost_digest *out, ost_error *err)
{
    ost_dims count = ost_leaf_dims(geometry->dims);
    size_t total = (size_t)ost_dims_count(count);
    ost_digest *leaves = malloc(total * sizeof *leaves);
    uint8_t *leaf = malloc(LEAF_VOXELS * voxel_size);
    ost_status status = OST_OK;
    if (!leaves || !leaf) {
        status = ost_fail(err, OST_ERR_MEMORY, "out of memory for %zu digests", total);
        goto cleanup;
    }
    size_t n = 0;
    for (int32_t z = 0; z < count.z; z++)
        for (int32_t y = 0; y < count.y; y++)
            for (int32_t x = 0; x < count.x && status == OST_OK; x++, n++) {
                gather_leaf(voxels, voxel_size, geometry->dims, x, y, z, leaf);
                status = hash_prefixed(PREFIX_LEAF, leaf, LEAF_VOXELS * voxel_size, "", 0, &leaves[n], err);
            }
    if (status == OST_OK)
        status = ost_digest_root(kind, geometry, 0, leaves, total, out, err);
cleanup:
    free(leaves);
    free(leaf);
    return status;
}

char *ost_digest_hex(const ost_digest *digest, char hex[OST_DIGEST_HEX])
{
    static const char digits[] = "0123456789abcdef";
    for (int i = 0; i < OST_DIGEST_BYTES; i++) {
        hex[2 * i] = digits[digest->bytes[i] >> 4];
        hex[2 * i + 1] = digits[digest->bytes[i] & 15];
    }
    hex[2 * OST_DIGEST_BYTES] = 0;
    return hex;
}

bool ost_digest_equal(const ost_digest *a, const ost_digest *b)
{
    return memcmp(a->bytes, b->bytes, sizeof a->bytes) == 0;
}
