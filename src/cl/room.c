/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Large buffers that were freed and wait for the next of about their size.
 *
 * A driver takes a large buffer anew from the system, which hands it out page
 * by page at the first touch: for a bone on a CPU that took longer than to
 * fill it.  The queue is in order, so what is given back may still be in use
 * by commands before the next holder's.
 */
#include "cl/cl.h"

enum { LEAST = 1 << 20, MOST = 1 << 28 };

/* The least that holds so much and not much more, or -1. */
static int find(const cl_backend *b, size_t bytes)
{
    int best = -1;
    for (int i = 0; i < OST_CL_SPARES; i++) {
        const size_t has = b->spare[i].bytes;
        if (b->spare[i].buffer && has >= bytes && has - bytes <= bytes / 4 && (best < 0 || has < b->spare[best].bytes))
            best = i;
    }
    return best;
}

ost_status ost_cl_room_take(cl_backend *b, size_t bytes, const char *what, cl_mem *out, size_t *room, ost_error *err)
{
    const int i = bytes >= ost_cl_staging(b, LEAST) ? find(b, bytes) : -1;
    *room = bytes;
    if (i < 0)
        return ost_cl_buffer(b, bytes, NULL, what, out, err);
    b->entered[OST_CL_PATH_BUFFER_REUSED]++;
    *out = b->spare[i].buffer;
    *room = b->spare[i].bytes;
    b->spare[i].buffer = NULL;
    return OST_OK;
}

void ost_cl_room_give(cl_backend *b, cl_mem *buffer, size_t room)
{
    size_t kept = room;
    int empty = -1;
    for (int i = 0; i < OST_CL_SPARES; i++) {
        kept += b->spare[i].buffer ? b->spare[i].bytes : 0;
        empty = b->spare[i].buffer ? empty : i;
    }
    if (!*buffer || room < ost_cl_staging(b, LEAST) || kept > MOST || empty < 0) {
        ost_cl_buffer_free(b, buffer);
        return;
    }
    b->spare[empty].buffer = *buffer;
    b->spare[empty].bytes = room;
    *buffer = NULL;
}

bool ost_cl_room_clear(cl_backend *b)
{
    bool any = false;
    for (int i = 0; i < OST_CL_SPARES; i++) {
        any = any || b->spare[i].buffer;
        ost_cl_buffer_free(b, &b->spare[i].buffer);
    }
    return any;
}
