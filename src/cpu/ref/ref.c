/* SPDX-License-Identifier: Apache-2.0 */
/* The function table of the `ref` backend, which has no options and is available on every machine. */
#include "cpu/ref/ref.h"

#include <stdlib.h>
#include <string.h>

static bool available(char *reason, size_t size)
{
    if (size)
        reason[0] = 0;
    return true;
}

static ost_status open_ref(const char *options, ost_backend **out, ost_error *err)
{
    if (options[0])
        return ost_fail(err, OST_ERR_USAGE, "backend ref: unknown option '%.*s'; it has no options",
                        (int)strcspn(options, "=,"), options);
    ref_backend *backend = calloc(1, sizeof *backend);
    int16_t *zeros = calloc(OST_LEAF * OST_LEAF * OST_LEAF, sizeof *zeros);
    ost_status status = OST_OK;
    if (!backend || !zeros)
        status = ost_fail(err, OST_ERR_MEMORY, "out of memory for backend ref");
    else
        status = ost_digest_leaf16(zeros, &backend->empty_leaf, err);
    free(zeros);
    if (status != OST_OK) {
        free(backend);
        return status;
    }
    *out = &backend->base;
    return OST_OK;
}

static void close_ref(ost_backend *backend)
{
    free(backend);
}

static ost_backend_settings settings(const ost_backend *backend)
{
    (void)backend;
    return (ost_backend_settings){.isa = "", .threads = 1, .platform = -1, .device = -1};
}

/* Does nothing: every function of this backend has finished its work when it returns. */
static ost_status finish(ost_backend *backend, ost_error *err)
{
    (void)backend;
    (void)err;
    return OST_OK;
}

const ost_backend_ops ost_backend_ref = {
    .name = "ref",
    .description = "scalar reference: plain, serial, the executable form of docs/spec/arithmetic.md",
    .available = available,
    .devices = ost_no_devices,
    .open = open_ref,
    .close = close_ref,
    .settings = settings,
    .finish = finish,
    .paths = ost_no_paths,
    .grid_create = ost_ref_grid_create,
    .grid_free = ost_ref_grid_free,
    .grid_upload = ost_ref_grid_upload,
    .grid_download = ost_ref_grid_download,
    .ct_to_rect = ost_ref_ct_to_rect,
    .rect_to_cubic = ost_ref_rect_to_cubic,
    .cubic_to_chunks = ost_ref_cubic_to_chunks,
    .bone_create = ost_ref_bone_create,
    .bone_free = ost_ref_bone_free,
    .bone_stats = ost_ref_bone_stats,
    .bone_upload = ost_ref_bone_upload,
    .bone_download = ost_ref_bone_download,
    .bone_sample = ost_ref_bone_sample,
    .bone_occupancy = ost_ref_bone_occupancy,
    .bone_leaves = ost_ref_bone_leaves,
    .voxelize = ost_ref_voxelize_tool,
    .tool_upload = ost_ref_tool_upload,
    .tool_download = ost_ref_tool_download,
    .tool_free = ost_ref_tool_free,
    .remove = ost_ref_remove,
    .collide = ost_ref_collide,
    .face_mesh = ost_ref_face_mesh,
};
