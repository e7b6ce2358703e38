/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/steps_record.h"

#include <string.h>

enum { SNAP_VERTICES = 65536 };

static void put_int(trace_writer *w, int64_t value)
{
    trace_word(w, (uint64_t)value);
}

static void put_int128(trace_writer *w, ost_int128 value)
{
    trace_word(w, value.low);
    put_int(w, value.high);
}

static ost_status put_mesh(trace_writer *w, bool second, const ost_snapped_mesh *m, ost_error *err)
{
    const ost_tool_geometry *g = &m->grid;
    const int64_t words[] = {g->dims.x,
                             g->dims.y,
                             g->dims.z,
                             g->voxel,
                             g->corner.x,
                             g->corner.y,
                             g->corner.z,
                             m->fraction_bits,
                             (int64_t)m->vertex_count,
                             (int64_t)m->triangle_count,
                             (int64_t)m->dropped_triangles};
    ost_digest digest;
    const ost_status status = second ? steps_mesh_digest(m, &digest, err) : ost_snapped_mesh_digest(m, &digest, err);
    for (size_t i = 0; i < sizeof words / sizeof words[0]; i++)
        put_int(w, words[i]);
    for (size_t i = 0; i < sizeof digest.bytes && status == OST_OK; i += 8) {
        uint64_t word;
        memcpy(&word, digest.bytes + i, 8);
        trace_word(w, word);
    }
    return status;
}

ost_status steps_put_snap(trace_writer *w, bool second, const ost_snapped_mesh *parts, ost_error *err)
{
    if (!parts)
        return OST_OK;
    ost_status status = put_mesh(w, second, &parts[0], err);
    if (status == OST_OK)
        status = put_mesh(w, second, &parts[1], err);
    for (size_t v = 0; v < parts[0].vertex_count && v < SNAP_VERTICES && status == OST_OK; v++) {
        const int32_t *p = parts[0].vertices[v]; /* coordinates are at most 2^20, so they fit in an int32 */
        put_int(w, p[0] | (int64_t)p[1] << 21 | (int64_t)p[2] << 42);
    }
    return status;
}

void steps_blocks(ost_dims bone, int32_t first[3][3])
{
    const int32_t n[3] = {bone.x, bone.y, bone.z};
    for (int a = 0; a < 3; a++) {
        first[0][a] = 0;
        first[1][a] = n[a] / 2 / OST_MAP_BLOCK * OST_MAP_BLOCK;
        first[2][a] = (n[a] - 1) / OST_MAP_BLOCK * OST_MAP_BLOCK;
    }
}

static void put_pose(trace_writer *w, const ost_pose *p)
{
    const int64_t words[] = {p->t.x, p->t.y, p->t.z, p->qw, p->qx, p->qy, p->qz};
    for (size_t i = 0; i < sizeof words / sizeof words[0]; i++)
        put_int(w, words[i]);
}

void steps_put_tick(trace_writer *w, bool refused, bool removal, int count, const ost_tick *tick)
{
    put_int(w, refused ? 2 : removal);
    put_int(w, count);
    put_int(w, tick->t_ns);
    put_int(w, tick->rpm);
    put_pose(w, &tick->pose);
}

void steps_put_pose(trace_writer *w, const steps_pose *p)
{
    put_pose(w, &p->pose);
    put_int128(w, p->map.divisor);
    for (int a = 0; a < 3; a++)
        put_int128(w, p->map.origin[a]);
    for (int b = 0; b < 3; b++)
        for (int a = 0; a < 3; a++)
            put_int128(w, p->map.column[b][a]);
    for (int b = 0; b < 3; b++)
        for (int a = 0; a < 3; a++)
            put_int(w, p->map.step[b][a]);
    for (int k = 0; k < 3; k++) {
        put_int(w, p->near[k]);
        for (int a = 0; a < 3; a++)
            put_int(w, p->near[k] ? p->base[k][a] : 0);
    }
    put_int(w, p->reaches);
    for (int a = 0; a < 3; a++)
        put_int(w, p->reaches ? p->box.lo[a] : 0);
    for (int a = 0; a < 3; a++)
        put_int(w, p->reaches ? p->box.hi[a] : 0);
}
