/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The digest of a snapped mesh (AR-DIG-7) from docs/spec/arithmetic.md alone: bytes in the order of its
 * table, hashed by the library.
 */
#include "validation/steps_record.h"

#include <osteon/digest.h>
#include <osteon/status.h>

enum { HEADER = 84 };

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
