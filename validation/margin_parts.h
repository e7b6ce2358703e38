/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Declarations shared by margin.c and its parts: the state while the records of a case
 * are read, and the functions that count a differing voxel.
 *
 *   margin.c   walk --record by record--> margin_import.c   rect, cubic, chunks
 *                                         margin_tool.c     tools
 *                                         margin_tick.c     events
 */
#ifndef OST_VALIDATION_MARGIN_PARTS_H
#define OST_VALIDATION_MARGIN_PARTS_H

#include <string.h>

#include "validation/margin.h"

/* The state while the records of a case are read: views of the latest complete grids, and the bones after the last
   tick. In each array, index 0 belongs to the reference and index 1 to the other backend. */
typedef struct margin_walk {
    const scene *s;
    bool apart;
    margins *out;
    trace_block_view rect[2], cubic[2], tool[2][SCENE_TOOLS_MAX];
    ost_dims dims;
    int16_t *bone[2];
    /* the tick at whose pose the next sweep begins: the last tick with an event or with the motor off; -1 if there is
       none */
    int64_t event_tick;
} margin_walk;

/* Each of these functions takes two records of one stage and item: `a` is from the reference's trace, and `b` is from
   the other backend's trace. */
ost_status margin_rect(margin_walk *w, const trace_block_view *a, const trace_block_view *b, ost_error *err);
void margin_cubic(margin_walk *w, const trace_block_view *a, const trace_block_view *b);
void margin_chunks(margin_walk *w, const trace_block_view *a, const trace_block_view *b);
void margin_tool(margin_walk *w, uint32_t item, const trace_block_view *a, const trace_block_view *b);
ost_status margin_tick(margin_walk *w, const trace_record *a, const trace_record *b, ost_error *err);

/* These functions count one differing voxel. margin_decided is for a voxel with a margin. margin_other is for a
   voxel without a margin; it increments *why, which must be a member of m. */
void margin_decided(margin_stage *m, uint64_t margin, uint32_t item, const int32_t at[3]);
void margin_other(margin_stage *m, uint64_t *why);

static inline size_t margin_at(ost_dims d, int32_t x, int32_t y, int32_t z)
{
    return (size_t)x + (size_t)d.x * ((size_t)y + (size_t)d.y * (size_t)z);
}

static inline void margin_position(ost_dims d, size_t i, int32_t at[3])
{
    at[0] = (int32_t)(i % (size_t)d.x);
    at[1] = (int32_t)(i / (size_t)d.x % (size_t)d.y);
    at[2] = (int32_t)(i / (size_t)d.x / (size_t)d.y);
}

/* Returns an int16 voxel of a block. Voxels in a trace are not aligned in memory, so the function copies the bytes. */
static inline int32_t margin_value16(const trace_block_view *b, size_t i)
{
    int16_t v;
    memcpy(&v, b->voxels + 2 * i, sizeof v);
    return v;
}

#endif
