/* SPDX-License-Identifier: Apache-2.0 */
/* Opens and closes the backend `plugin`, and defines its function table. */
#include "plugin/adapt.h"

#include <stdlib.h>
#include <string.h>

#include "config.h"

/* ------------------------------------------------------------------- host */

static int32_t block_base(const ost_plugin_map *map, const int32_t block[3], int32_t base[3])
{
    ost_map m = {.divisor = ost_int128_of_plugin(map->divisor)};
    for (int a = 0; a < 3; a++) {
        m.origin[a] = ost_int128_of_plugin(map->origin[a]);
        for (int b = 0; b < 3; b++)
            m.column[b][a] = ost_int128_of_plugin(map->column[b][a]);
    }
    return ost_map_block_base(&m, (ost_dims){block[0], block[1], block[2]}, base);
}

static const ost_plugin_host host = {
    .size = sizeof host,
    .abi = OST_PLUGIN_ABI,
    .arithmetic = OST_ARITHMETIC_VERSION,
    .version = PACKAGE_VERSION,
    .block_base = block_base,
};

/* ----------------------------------------------------------------- choice */

static bool available(char *reason, size_t size)
{
    if (size)
        reason[0] = 0;
    return true;
}

static ost_status open_plugin(const char *options, ost_backend **out, ost_error *err)
{
    char file[2048];
    const size_t length = strcspn(options, ",");
    if (length == 0)
        return ost_fail(err, OST_ERR_USAGE, "backend plugin needs a file: plugin:FILE.so or plugin:FILE.so,KEY=VALUE");
    if (length >= sizeof file)
        return ost_fail(err, OST_ERR_USAGE, "plugin '%.60s...': the name is too long", options);
    memcpy(file, options, length);
    file[length] = '\0';
    plugin_backend *b = calloc(1, sizeof *b);
    if (!b)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a plugin");
    ost_status status = ost_plugin_load(file, &b->table, b->name, err);
    if (status == OST_OK) {
        plugin_error_sink t;
        status = ost_adapt_heard(
            b, "open",
            b->table.open(options[length] ? options + length + 1 : "", &host, &b->self, &adapt_listening(&t)->error),
            &t, NULL, err);
        if (status == OST_OK && !b->self)
            status = ost_adapt_no_object(b, "open", err);
    }
    if (status != OST_OK) {
        free(b);
        return status;
    }
    *out = &b->base;
    return OST_OK;
}

static void close_plugin(ost_backend *backend)
{
    plugin_backend *b = adapt_backend(backend);
    b->table.close(b->self);
    free(b);
}

static ost_backend_settings settings(const ost_backend *backend)
{
    (void)backend;
    return (ost_backend_settings){.isa = "", .threads = 1, .platform = -1, .device = -1};
}

static ost_status finish(ost_backend *backend, ost_error *err)
{
    plugin_backend *b = adapt_backend(backend);
    plugin_error_sink t;
    return ost_adapt_heard(b, "finish", b->table.finish(b->self, &adapt_listening(&t)->error), &t, NULL, err);
}

const ost_backend_ops ost_backend_plugin = {
    .name = "plugin",
    .description = "an external implementation, loaded from a file: plugin:FILE.so",
    .available = available,
    .devices = ost_no_devices,
    .open = open_plugin,
    .close = close_plugin,
    .settings = settings,
    .finish = finish,
    .paths = ost_no_paths,
    .grid_create = ost_adapt_grid_create,
    .grid_free = ost_adapt_grid_free,
    .grid_upload = ost_adapt_grid_upload,
    .grid_download = ost_adapt_grid_download,
    .ct_to_rect = ost_adapt_ct_to_rect,
    .rect_to_cubic = ost_adapt_rect_to_cubic,
    .cubic_to_chunks = ost_adapt_cubic_to_chunks,
    .bone_create = ost_adapt_bone_create,
    .bone_free = ost_adapt_bone_free,
    .bone_stats = ost_adapt_bone_stats,
    .bone_upload = ost_adapt_bone_upload,
    .bone_download = ost_adapt_bone_download,
    .bone_sample = ost_no_sample,
    .bone_occupancy = ost_no_occupancy,
    .bone_leaves = ost_adapt_bone_leaves,
    .voxelize = ost_adapt_voxelize,
    .tool_upload = ost_adapt_tool_upload,
    .tool_download = ost_adapt_tool_download,
    .tool_free = ost_adapt_tool_free,
    .remove = ost_adapt_remove,
    .collide = ost_adapt_collide,
    .snap = ost_adapt_snap,
    .steps = ost_adapt_steps,
};
