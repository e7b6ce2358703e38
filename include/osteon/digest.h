/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Digests of grids (docs/spec/arithmetic.md, AR-DIG).
 *
 * Digests identify grids in files. Two grids in memory are compared with memcmp instead. The digest of a grid is the
 * SHA-256 of a canonical form that does not depend on the chunk size or the backend:
 *
 *   leaf    SHA-256(0x00 || 32^3 voxels, x fastest, little-endian, zero outside the grid)
 *   node    SHA-256(0x01 || left || right)      a tree over the leaves in x-fastest
 *                                               order, split as in RFC 6962 section 2.1
 *   digest  SHA-256(0x02 || header of 128 bytes || tree)
 *
 * The leaves contain no positions; their order in the tree determines the positions.  The header contains the kind,
 * dims, spacing, origin and threshold, so grids with different geometries have different digests.
 *
 * Errors: the functions return OST_ERR_MEMORY if memory is exhausted or if libcrypto was built without SHA-256.
 *
 * Threads: the functions share no state; an object may be used by one thread at a time, or read by several.
 */
#ifndef OSTEON_DIGEST_H
#define OSTEON_DIGEST_H

#include <osteon/grid.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { OST_DIGEST_BYTES = 32, OST_DIGEST_HEX = 65, OST_LEAF = 32 };

/* A SHA-256 digest. */
typedef struct ost_digest {
    uint8_t bytes[OST_DIGEST_BYTES];
} ost_digest;

/* Kinds of grids. The header contains the kind as a uint32. */
typedef enum ost_grid_kind {
    OST_GRID_RECT = 1,
    OST_GRID_CUBIC = 2,
    OST_GRID_BONE = 3,
    OST_GRID_TOOL = 4
} ost_grid_kind;

/* Returns the number of 32^3 leaves along each axis. */
OST_API ost_dims ost_leaf_dims(ost_dims dims);

/* Computes the digest of a leaf of 32^3 int16 voxels, x fastest. The only error is OST_ERR_MEMORY. */
OST_API ost_status ost_digest_leaf16(const int16_t voxels[OST_LEAF * OST_LEAF * OST_LEAF], ost_digest *out,
                                     ost_error *err);
/* Computes the digest of a leaf of 32^3 uint8 voxels, x fastest. The only error is OST_ERR_MEMORY. */
OST_API ost_status ost_digest_leaf8(const uint8_t voxels[OST_LEAF * OST_LEAF * OST_LEAF], ost_digest *out,
                                    ost_error *err);

/*
 * Computes the digest of a grid from the digests of its leaves, in x-fastest order. threshold must be 0 unless kind is
 * OST_GRID_BONE. Returns OST_ERR_USAGE if count is not the number of leaves of the grid.
 */
OST_API ost_status ost_digest_root(ost_grid_kind kind, const ost_geometry *geometry, int32_t threshold,
                                   const ost_digest *leaves, size_t count, ost_digest *out, ost_error *err);

/* Computes the digest of a dense grid, which must have voxels. kind is OST_GRID_RECT or OST_GRID_CUBIC. The only error
 * is OST_ERR_MEMORY. */
OST_API ost_status ost_digest_volume(ost_grid_kind kind, const ost_volume *volume, ost_digest *out, ost_error *err);

/*
 * Computes the digest of a dense array of voxels, each of which has voxel_size bytes (1 or 2). For a tool, kind is
 * OST_GRID_TOOL, the spacing on all axes is the tool's voxel size, and the origin is the tool's corner. The only error
 * is OST_ERR_MEMORY.
 */
OST_API ost_status ost_digest_dense(ost_grid_kind kind, const ost_geometry *geometry, const void *voxels,
                                    size_t voxel_size, ost_digest *out, ost_error *err);

/* Computes the SHA-256 of `size` bytes, as the program sha256sum does. The only error is OST_ERR_MEMORY. */
OST_API ost_status ost_digest_bytes(const void *bytes, size_t size, ost_digest *out, ost_error *err);

/* Writes the digest as 64 lower-case hexadecimal digits and a NUL. Returns hex. */
OST_API char *ost_digest_hex(const ost_digest *digest, char hex[OST_DIGEST_HEX]);
/* Returns true if two digests have the same bytes. */
OST_API bool ost_digest_equal(const ost_digest *a, const ost_digest *b);

/*
 * An incremental SHA-256 for streams, such as the samples of a text file. The type is opaque. A hasher is owned by
 * the caller that opened it.
 */
typedef struct ost_hasher ost_hasher;
/* Creates a hasher. The only error is OST_ERR_MEMORY. The caller frees *out with ost_hasher_close. */
OST_API ost_status ost_hasher_open(ost_hasher **out, ost_error *err);
/* Adds bytes to the hash. The only error is OST_ERR_MEMORY. After an error, only ost_hasher_close may be called. */
OST_API ost_status ost_hasher_add(ost_hasher *hasher, const void *bytes, size_t size, ost_error *err);
/* Writes the digest to *out, unless out is NULL, and frees the hasher, even after an error. The only error is
 * OST_ERR_MEMORY. NULL is allowed for hasher. */
OST_API ost_status ost_hasher_close(ost_hasher *hasher, ost_digest *out, ost_error *err);

#ifdef __cplusplus
}
#endif
#endif
