/* SPDX-License-Identifier: Apache-2.0 */
#include "segment/runs.h"

#include <stdlib.h>

static ost_status add_row(segment_runs *runs, const bool *in, int32_t nx, ost_error *err)
{
    for (int32_t x = 0; x < nx; x++) {
        if (!in[x])
            continue;
        if (runs->count == runs->capacity) {
            const size_t wanted = runs->capacity ? 2 * runs->capacity : 4096;
            segment_run *grown = runs->count < UINT32_MAX / 2 ? realloc(runs->items, wanted * sizeof *grown) : NULL;
            if (!grown)
                return ost_fail(err, OST_ERR_MEMORY, "out of memory for %zu rows of dense voxels", wanted);
            runs->items = grown;
            runs->capacity = wanted;
        }
        segment_run *run = &runs->items[runs->count];
        *run = (segment_run){.begin = x, .component = (uint32_t)runs->count++};
        while (x < nx && in[x])
            x++;
        run->end = x;
    }
    return OST_OK;
}

static uint32_t root(segment_run *items, uint32_t i)
{
    while (items[i].component != i) {
        items[i].component = items[items[i].component].component; /* halves the length of the path to the root */
        i = items[i].component;
    }
    return i;
}

/* Joins two components. The earlier of their first runs becomes the root. */
static void join(segment_run *items, uint32_t a, uint32_t b)
{
    a = root(items, a);
    b = root(items, b);
    if (a < b)
        items[b].component = a;
    else
        items[a].component = b;
}

/*
 * Joins the components of runs that overlap in x. The runs [from, to) lie in one row, and the runs [other, end) in a
 * neighbouring row.
 */
static void join_rows(segment_run *items, size_t from, size_t to, size_t other, size_t end)
{
    while (from < to && other < end) {
        const segment_run *a = &items[from], *b = &items[other];
        if (a->begin < b->end && b->begin < a->end)
            join(items, (uint32_t)from, (uint32_t)other);
        if (a->end < b->end)
            from++;
        else
            other++;
    }
}

ost_status ost_segment_runs_make(ost_dims dims, segment_row *row, void *user, segment_runs *out, ost_error *err)
{
    const size_t rows = (size_t)dims.y * (size_t)dims.z;
    bool *in = malloc((size_t)dims.x * sizeof *in);
    *out = (segment_runs){.rows_count = rows, .rows = malloc((rows + 1) * sizeof *out->rows)};
    ost_status status = in && out->rows ? OST_OK : ost_fail(err, OST_ERR_MEMORY, "out of memory for %zu rows", rows);
    for (size_t i = 0; i < rows && status == OST_OK; i++) {
        out->rows[i] = out->count;
        for (int32_t x = 0; x < dims.x; x++)
            in[x] = false;
        row(user, (int32_t)(i % (size_t)dims.y), (int32_t)(i / (size_t)dims.y), in);
        status = add_row(out, in, dims.x, err);
        if (status != OST_OK)
            break;
        if (i % (size_t)dims.y > 0)
            join_rows(out->items, out->rows[i], out->count, out->rows[i - 1], out->rows[i]);
        if (i >= (size_t)dims.y)
            join_rows(out->items, out->rows[i], out->count, out->rows[i - (size_t)dims.y],
                      out->rows[i - (size_t)dims.y + 1]);
    }
    free(in);
    if (status != OST_OK)
        return status;
    out->rows[rows] = out->count;
    /* A root receives the next number. Any other run copies the number from an earlier run of its component. */
    for (size_t i = 0; i < out->count; i++) {
        segment_run *run = &out->items[i];
        run->component = run->component == i ? out->components++ : out->items[run->component].component;
    }
    return OST_OK;
}

void ost_segment_runs_free(segment_runs *runs)
{
    free(runs->items);
    free(runs->rows);
    *runs = (segment_runs){.items = NULL};
}
