/* SPDX-License-Identifier: Apache-2.0 */
/* The function table of the dense backend. Only dense_open opens this backend, because no list of backends contains
   it. */
#include "validation/dense/parts.h"

#include <stdlib.h>

static bool available(char *reason, size_t size)
{
    if (size)
        reason[0] = 0;
    return true;
}

static ost_status open_right(const char *options, ost_backend **out, ost_error *err)
{
    if (options[0])
        return ost_fail(err, OST_ERR_USAGE, "backend dense takes no options");
    return dense_open(NULL, out, err);
}

static void close_dense(ost_backend *backend)
{
    free(backend);
}

static ost_backend_settings settings(const ost_backend *backend)
{
    (void)backend;
    return (ost_backend_settings){.isa = "", .threads = 1};
}

static ost_status finish(ost_backend *backend, ost_error *err)
{
    (void)backend;
    (void)err;
    return OST_OK;
}

static const ost_backend_ops table = {
    .name = "dense",
    .description = "second implementation of docs/spec/arithmetic.md: dense arrays, plain loops",
    .available = available,
    .devices = ost_no_devices,
    .open = open_right,
    .close = close_dense,
    .settings = settings,
    .finish = finish,
    .paths = ost_no_paths,
    .grid_create = dense_grid_create,
    .grid_free = dense_grid_free,
    .grid_upload = dense_grid_upload,
    .grid_download = dense_grid_download,
    .ct_to_rect = dense_ct_to_rect,
    .rect_to_cubic = dense_rect_to_cubic,
    .cubic_to_chunks = dense_cubic_to_chunks,
    .bone_create = dense_bone_create,
    .bone_free = dense_bone_free,
    .bone_stats = dense_bone_stats,
    .bone_upload = dense_bone_upload,
    .bone_download = dense_bone_download,
    .bone_sample = ost_no_sample,
    .bone_occupancy = ost_no_occupancy,
    .bone_leaves = dense_bone_leaves,
    .voxelize = dense_voxelize,
    .tool_upload = dense_tool_upload,
    .tool_download = dense_tool_download,
    .tool_free = dense_tool_free,
    .remove = dense_remove,
    .collide = dense_collide,
};

ost_status dense_open(const deviation *how, ost_backend **out, ost_error *err)
{
    *out = NULL;
    if (how && ((int)how->kind < 0 || how->kind >= DEVIATION_KINDS))
        return ost_fail(err, OST_ERR_USAGE, "there is no deviation number %d", (int)how->kind);
    dense *d = calloc(1, sizeof *d);
    if (!d)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for backend dense");
    d->base.ops = &table;
    if (how && how->kind != DEVIATION_NONE) {
        d->own.how = *how;
        d->deviant = &d->own;
    }
    *out = &d->base;
    return OST_OK;
}

deviation_record dense_record(ost_backend *backend)
{
    dense *d = dense_of(backend);
    if (d->unsettled)
        dense_grid_finish(d->unsettled);
    return d->own.record;
}
