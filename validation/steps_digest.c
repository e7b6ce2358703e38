/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Computes the digests of a snapped mesh (AR-DIG-7) and of a bone (AR-DIG-2 to AR-DIG-5). The code was written only
 * from the text of docs/spec/arithmetic.md; the bytes have the order of the tables in that document. Only the hash
 * function is shared with the library.
 */
#include "validation/steps_record.h"

#include <osteon/digest.h>
#include <osteon/status.h>
#include <string.h>

enum {
    HEADER = 84,
    LEAF_SIDE = 32,
    LEAF_BYTES = 1 + 2 * LEAF_SIDE * LEAF_SIDE * LEAF_SIDE,
    ROOT_HEADER = 1 + 128,
    LEVELS = 40 /* levels of the tree; sufficient, because a grid has fewer than 2^39 leaves */
};

static size_t little_endian(uint8_t *at, uint64_t value, size_t bytes)
{
    for (size_t i = 0; i < bytes; i++)
        at[i] = (uint8_t)(value >> 8 * i);
    return bytes;
}

static ost_status add_triples(ost_hasher *hasher, const void *triples, size_t count, ost_error *err)
{
    const uint32_t(*from)[3] = triples;
    ost_status status = OST_OK;
    for (size_t i = 0; i < count && status == OST_OK; i++) {
        uint8_t bytes[12];
        for (size_t a = 0; a < 3; a++)
            little_endian(bytes + 4 * a, from[i][a], 4);
        status = ost_hasher_add(hasher, bytes, sizeof bytes, err);
    }
    return status;
}

ost_status steps_mesh_digest(const ost_snapped_mesh *mesh, ost_digest *out, ost_error *err)
{
    static const char magic[8] = {'O', 'S', 'T', 'E', 'O', 'N', 'M', '1'};
    const ost_tool_geometry *g = &mesh->grid;
    const struct {
        uint64_t value;
        size_t bytes;
    } fields[] = {
        {OST_ARITHMETIC_VERSION, 4},
        {(uint64_t)g->dims.x, 4},
        {(uint64_t)g->dims.y, 4},
        {(uint64_t)g->dims.z, 4},
        {(uint64_t)g->voxel, 8},
        {(uint64_t)g->corner.x, 8},
        {(uint64_t)g->corner.y, 8},
        {(uint64_t)g->corner.z, 8},
        {(uint64_t)mesh->fraction_bits, 4},
        {(uint64_t)mesh->vertex_count, 8},
        {(uint64_t)mesh->triangle_count, 8},
        {(uint64_t)mesh->dropped_triangles, 8},
    };
    uint8_t header[HEADER];
    size_t used = 0;
    for (; used < sizeof magic; used++)
        header[used] = (uint8_t)magic[used];
    for (size_t i = 0; i < sizeof fields / sizeof fields[0]; i++)
        used += little_endian(header + used, fields[i].value, fields[i].bytes);
    ost_hasher *hasher;
    ost_status status = ost_hasher_open(&hasher, err);
    if (status != OST_OK)
        return status;
    status = ost_hasher_add(hasher, header, used, err);
    if (status == OST_OK)
        status = add_triples(hasher, mesh->vertices, mesh->vertex_count, err);
    if (status == OST_OK)
        status = add_triples(hasher, mesh->triangles, mesh->triangle_count, err);
    const ost_status closed = ost_hasher_close(hasher, status == OST_OK ? out : NULL, status == OST_OK ? err : NULL);
    return status != OST_OK ? status : closed;
}

/* -------------------------------------------------------- digest of a bone */

/* Computes the digest of the leaf whose first voxel is (x0, y0, z0). Voxels beyond the grid are 0 (AR-DIG-2). */
static ost_status leaf_digest(const int16_t *voxels, ost_dims d, int32_t x0, int32_t y0, int32_t z0, ost_digest *out,
                              ost_error *err)
{
    uint8_t bytes[LEAF_BYTES] = {0};
    for (int32_t z = z0; z < z0 + LEAF_SIDE && z < d.z; z++)
        for (int32_t y = y0; y < y0 + LEAF_SIDE && y < d.y; y++)
            for (int32_t x = x0; x < x0 + LEAF_SIDE && x < d.x; x++) {
                const size_t to = (size_t)(x - x0) + LEAF_SIDE * ((size_t)(y - y0) + LEAF_SIDE * (size_t)(z - z0));
                const size_t from = (size_t)x + (size_t)d.x * ((size_t)y + (size_t)d.y * (size_t)z);
                little_endian(bytes + 1 + 2 * to, (uint16_t)voxels[from], 2);
            }
    return ost_digest_bytes(bytes, sizeof bytes, out, err);
}

/* Replaces *left with the digest of the node above *left and *right (AR-DIG-3). */
static ost_status join(ost_digest *left, const ost_digest *right, ost_error *err)
{
    uint8_t bytes[1 + 2 * OST_DIGEST_BYTES] = {1};
    memcpy(bytes + 1, left->bytes, OST_DIGEST_BYTES);
    memcpy(bytes + 1 + OST_DIGEST_BYTES, right->bytes, OST_DIGEST_BYTES);
    return ost_digest_bytes(bytes, sizeof bytes, left, err);
}

/* Computes the digest of a grid from the digest of its tree (AR-DIG-4). */
static ost_status root_digest(const ost_geometry *g, int32_t threshold, uint64_t leaves, const ost_digest *tree,
                              ost_digest *out, ost_error *err)
{
    enum { BONE = 3 };
    uint8_t bytes[ROOT_HEADER + OST_DIGEST_BYTES] = "\2OSTEONG1";
    const uint64_t lengths[] = {(uint64_t)g->spacing.x, (uint64_t)g->spacing.y, (uint64_t)g->spacing.z,
                                (uint64_t)g->origin.x,  (uint64_t)g->origin.y,  (uint64_t)g->origin.z};
    const int32_t dims[] = {g->dims.x, g->dims.y, g->dims.z};
    uint8_t *const header = bytes + 1;
    little_endian(header + 8, OST_ARITHMETIC_VERSION, 4);
    little_endian(header + 12, BONE, 4);
    for (size_t a = 0; a < 3; a++)
        little_endian(header + 16 + 4 * a, (uint64_t)dims[a], 4);
    for (size_t i = 0; i < 6; i++)
        little_endian(header + 32 + 8 * i, lengths[i], 8);
    little_endian(header + 80, (uint64_t)threshold, 4);
    little_endian(header + 84, LEAF_SIDE, 4);
    little_endian(header + 88, leaves, 8);
    memcpy(bytes + ROOT_HEADER, tree->bytes, OST_DIGEST_BYTES);
    return ost_digest_bytes(bytes, sizeof bytes, out, err);
}

/*
 * Computes the digest of a bone by adding its leaves one by one. The array `pending` has one tree of 2^k leaves for
 * each set bit k of `leaves`, the largest tree first. When two trees have the same size, they are joined.
 */
ost_status steps_bone_digest(const ost_geometry *g, int32_t threshold, const int16_t *voxels, ost_digest *out,
                             ost_error *err)
{
    ost_digest pending[LEVELS];
    size_t count = 0;
    uint64_t leaves = 0;
    ost_status status = OST_OK;
    for (int32_t z = 0; z < g->dims.z; z += LEAF_SIDE)
        for (int32_t y = 0; y < g->dims.y; y += LEAF_SIDE)
            for (int32_t x = 0; x < g->dims.x && status == OST_OK; x += LEAF_SIDE) {
                status = leaf_digest(voxels, g->dims, x, y, z, &pending[count++], err);
                leaves++;
                for (uint64_t pairs = leaves; pairs % 2 == 0 && status == OST_OK; pairs /= 2, count--)
                    status = join(&pending[count - 2], &pending[count - 1], err);
            }
    for (; count > 1 && status == OST_OK; count--)
        status = join(&pending[count - 2], &pending[count - 1], err);
    return status == OST_OK ? root_digest(g, threshold, leaves, &pending[0], out, err) : status;
}
