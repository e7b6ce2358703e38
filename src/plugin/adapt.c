/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The function table of core/backend.h over a plugin's.
 *
 *   ost_grid, ost_bone, ost_tool   hold the plugin's object and what the host knows of it
 *   call --convert--> slot --check status, object, report--> result
 *
 * Leaf digests are made here from downloaded slices: a plugin has no need of
 * SHA-256, and nobody could compare digests that it invented.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "config.h"

#include "plugin/plugin.h"

typedef struct plugin_backend {
    ost_backend base;
    ost_plugin table;
    ost_plugin_instance *self;
    char name[PLUGIN_NAME];
} plugin_backend;

/* lost: a call failed in the middle; nothing but free is asked of it any more. */
typedef struct plugin_grid {
    ost_grid base;
    ost_plugin_grid *own;
    bool lost;
} plugin_grid;

typedef struct plugin_bone {
    ost_bone base;
    ost_plugin_bone *own;
    bool lost;
} plugin_bone;

typedef struct plugin_tool {
    ost_tool base;
    ost_plugin_tool *own;
} plugin_tool;

_Static_assert(sizeof(ost_plugin_sample) == 32 && sizeof(ost_sample) == sizeof(ost_plugin_sample), "samples are handed over as they are");
_Static_assert(offsetof(ost_sample, density) == offsetof(ost_plugin_sample, density) && offsetof(ost_sample, line) == offsetof(ost_plugin_sample, line),
               "samples are handed over as they are");

static plugin_backend *backend_of(const ost_backend *backend)
{
    return (plugin_backend *)(uintptr_t)backend;
}

static const ost_plugin *table_of(const ost_backend *backend)
{
    return &backend_of(backend)->table;
}

/* ---------------------------------------------------------------- errors */

/* Room for a text that a plugin may fill, and mistake for longer than it is. */
typedef struct told {
    ost_plugin_error error;
    char text[400];
} told;

static told *listening(told *t)
{
    *t = (told){.error = {.size = sizeof t->error, .text_size = sizeof t->text, .text = t->text}};
    return t;
}

static ost_status heard(const plugin_backend *b, const char *slot, int32_t status, told *t, bool *lost, ost_error *err)
{
    static const ost_status statuses[] = {[OST_PLUGIN_OK] = OST_OK, [OST_PLUGIN_USAGE] = OST_ERR_USAGE, [OST_PLUGIN_RANGE] = OST_ERR_RANGE,
                                          [OST_PLUGIN_MEMORY] = OST_ERR_MEMORY, [OST_PLUGIN_UNAVAILABLE] = OST_ERR_UNAVAILABLE,
                                          [OST_PLUGIN_FAILED] = OST_ERR_UNAVAILABLE, [OST_PLUGIN_LOST] = OST_ERR_UNAVAILABLE};
    t->text[sizeof t->text - 1] = '\0';
    if (status == OST_PLUGIN_OK)
        return OST_OK;
    if (status < 0 || status > OST_PLUGIN_LOST)
        return ost_fail(err, OST_ERR_UNAVAILABLE, "plugin %s: %s returned %d, which is no status of the plugin interface", b->name, slot, (int)status);
    if (status == OST_PLUGIN_LOST && lost)
        *lost = true;
    return ost_fail(err, statuses[status], "plugin %s: %s: %s", b->name, slot, t->text[0] ? t->text : "failed without a word");
}

static ost_status no_object(const plugin_backend *b, const char *slot, ost_error *err)
{
    return ost_fail(err, OST_ERR_UNAVAILABLE, "plugin %s: %s said that all is well and gave no object", b->name, slot);
}

static ost_status is_lost(const plugin_backend *b, ost_error *err)
{
    return ost_fail(err, OST_ERR_UNAVAILABLE, "plugin %s: an earlier call failed in the middle and the object was lost", b->name);
}

/* ------------------------------------------------------------------- host */

static ost_int128 joined(ost_plugin_int128 value)
{
    return (ost_int128)value.high * ((ost_int128)1 << 64) + value.low;
}

static int32_t block_base(const ost_plugin_map *map, const int32_t block[3], int32_t base[3])
{
    ost_map m = {.divisor = joined(map->divisor)};
    for (int a = 0; a < 3; a++) {
        m.origin[a] = joined(map->origin[a]);
        for (int b = 0; b < 3; b++)
            m.column[b][a] = joined(map->column[b][a]);
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
        return ost_fail(err, OST_ERR_MEMORY, "no memory for a plugin");
    ost_status status = ost_plugin_load(file, &b->table, b->name, err);
    if (status == OST_OK) {
        told t;
        status = heard(b, "open", b->table.open(options[length] ? options + length + 1 : "", &host, &b->self, &listening(&t)->error), &t, NULL, err);
        if (status == OST_OK && !b->self)
            status = no_object(b, "open", err);
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
    plugin_backend *b = backend_of(backend);
    b->table.close(b->self);
    free(b);
}

static ost_backend_settings settings(const ost_backend *backend)
{
    (void)backend;
    return (ost_backend_settings){.isa = "", .threads = 1};
}

static ost_status finish(ost_backend *backend, ost_error *err)
{
    plugin_backend *b = backend_of(backend);
    told t;
    return heard(b, "finish", b->table.finish(b->self, &listening(&t)->error), &t, NULL, err);
}

/* ------------------------------------------------------------------ grids */

static ost_plugin_geometry geometry_of(const ost_geometry *g)
{
    return (ost_plugin_geometry){.size = sizeof(ost_plugin_geometry),
                                 .dims = {g->dims.x, g->dims.y, g->dims.z},
                                 .spacing_pm = {g->spacing.x, g->spacing.y, g->spacing.z},
                                 .origin_pm = {g->origin.x, g->origin.y, g->origin.z}};
}

static ost_status new_grid(ost_backend *backend, const ost_geometry *geometry, plugin_grid **out, ost_error *err)
{
    *out = calloc(1, sizeof **out);
    if (!*out)
        return ost_fail(err, OST_ERR_MEMORY, "no memory for a grid");
    (*out)->base = (ost_grid){.backend = backend, .geometry = *geometry};
    return OST_OK;
}

/* The object that a slot made, or not. */
static ost_status made_grid(plugin_grid *grid, const char *slot, ost_status status, ost_grid **out, ost_error *err)
{
    if (status == OST_OK && !grid->own)
        status = no_object(backend_of(grid->base.backend), slot, err);
    if (status != OST_OK) {
        free(grid);
        return status;
    }
    *out = &grid->base;
    return OST_OK;
}

static ost_status grid_create(ost_backend *backend, const ost_geometry *geometry, ost_grid **out, ost_error *err)
{
    plugin_backend *b = backend_of(backend);
    const ost_plugin_geometry g = geometry_of(geometry);
    plugin_grid *grid;
    told t;
    ost_status status = new_grid(backend, geometry, &grid, err);
    if (status != OST_OK)
        return status;
    status = heard(b, "grid_create", b->table.grid_create(b->self, &g, &grid->own, &listening(&t)->error), &t, NULL, err);
    return made_grid(grid, "grid_create", status, out, err);
}

static void grid_free(ost_grid *base)
{
    plugin_grid *grid = (plugin_grid *)base;
    table_of(base->backend)->grid_free(grid->own);
    free(grid);
}

static ost_status grid_upload(ost_grid *base, int32_t z0, int32_t count, const int16_t *voxels, ost_error *err)
{
    plugin_grid *grid = (plugin_grid *)base;
    plugin_backend *b = backend_of(base->backend);
    told t;
    if (grid->lost)
        return is_lost(b, err);
    return heard(b, "grid_upload", b->table.grid_upload(grid->own, z0, count, voxels, &listening(&t)->error), &t, &grid->lost, err);
}

static ost_status grid_download(const ost_grid *base, int32_t z0, int32_t count, int16_t *voxels, ost_error *err)
{
    const plugin_grid *grid = (const plugin_grid *)base;
    plugin_backend *b = backend_of(base->backend);
    told t;
    if (grid->lost)
        return is_lost(b, err);
    return heard(b, "grid_download", b->table.grid_download(grid->own, z0, count, voxels, &listening(&t)->error), &t, NULL, err);
}

/* ----------------------------------------------------------------- import */

static ost_status ct_to_rect(ost_grid *rect, const ost_sample *samples, size_t count, int64_t first_line, ost_duplicates duplicates,
                             ost_scatter_report *report, ost_error *err)
{
    plugin_grid *grid = (plugin_grid *)rect;
    plugin_backend *b = backend_of(rect->backend);
    ost_plugin_scatter_report r = {.size = sizeof r, .conflict_had = report->conflict_had, .conflict_has = report->conflict_has,
                                   .samples = report->samples, .duplicates = report->duplicates, .off_lattice = report->off_lattice,
                                   .worst_offset_ppm = report->worst_offset_ppm, .worst_line = report->worst_line,
                                   .rejected_line = report->rejected_line, .conflict_line = report->conflict_line};
    const ost_plugin_samples batch = {.size = sizeof batch, .duplicates = (int32_t)duplicates, .count = count, .first_line = first_line,
                                      .sample = (const ost_plugin_sample *)(const void *)samples};
    told t;
    if (grid->lost)
        return is_lost(b, err);
    ost_status status = heard(b, "ct_to_rect", b->table.ct_to_rect(grid->own, &batch, &r, &listening(&t)->error), &t, &grid->lost, err);
    if (status == OST_OK)
        *report = (ost_scatter_report){.samples = r.samples, .duplicates = r.duplicates, .off_lattice = r.off_lattice,
                                       .worst_offset_ppm = r.worst_offset_ppm, .worst_line = r.worst_line, .rejected_line = r.rejected_line,
                                       .conflict_line = r.conflict_line, .conflict_had = r.conflict_had, .conflict_has = r.conflict_has};
    return status;
}

static ost_status rect_to_cubic(const ost_grid *rect, const ost_geometry *geometry, ost_resample rule, ost_grid **out, ost_error *err)
{
    const plugin_grid *from = (const plugin_grid *)rect;
    plugin_backend *b = backend_of(rect->backend);
    const ost_plugin_geometry g = geometry_of(geometry);
    plugin_grid *grid;
    told t;
    ost_status status = from->lost ? is_lost(b, err) : new_grid(rect->backend, geometry, &grid, err);
    if (status != OST_OK)
        return status;
    status = heard(b, "rect_to_cubic", b->table.rect_to_cubic(from->own, &g, rule == OST_RESAMPLE_NEAREST, &grid->own, &listening(&t)->error), &t, NULL, err);
    return made_grid(grid, "rect_to_cubic", status, out, err);
}

/* ------------------------------------------------------------------ bones */

static ost_status new_bone(ost_backend *backend, const ost_geometry *geometry, int chunk_size, int32_t threshold, plugin_bone **out, ost_error *err)
{
    *out = calloc(1, sizeof **out);
    if (!*out)
        return ost_fail(err, OST_ERR_MEMORY, "no memory for a bone");
    (*out)->base = (ost_bone){.backend = backend, .geometry = *geometry, .chunk_size = chunk_size, .threshold = threshold};
    return OST_OK;
}

static ost_status made_bone(plugin_bone *bone, const char *slot, ost_status status, ost_bone **out, ost_error *err)
{
    if (status == OST_OK && !bone->own)
        status = no_object(backend_of(bone->base.backend), slot, err);
    if (status != OST_OK) {
        free(bone);
        return status;
    }
    *out = &bone->base;
    return OST_OK;
}

static ost_status cubic_to_chunks(const ost_grid *cubic, int chunk_size, int32_t threshold, ost_bone **out, ost_error *err)
{
    const plugin_grid *from = (const plugin_grid *)cubic;
    plugin_backend *b = backend_of(cubic->backend);
    plugin_bone *bone;
    told t;
    ost_status status = from->lost ? is_lost(b, err) : new_bone(cubic->backend, &cubic->geometry, chunk_size, threshold, &bone, err);
    if (status != OST_OK)
        return status;
    status = heard(b, "cubic_to_chunks", b->table.cubic_to_chunks(from->own, chunk_size, threshold, &bone->own, &listening(&t)->error), &t, NULL, err);
    return made_bone(bone, "cubic_to_chunks", status, out, err);
}

static ost_status bone_create(ost_backend *backend, const ost_geometry *geometry, int chunk_size, int32_t threshold, ost_bone **out, ost_error *err)
{
    plugin_backend *b = backend_of(backend);
    const ost_plugin_geometry g = geometry_of(geometry);
    plugin_bone *bone;
    told t;
    ost_status status = new_bone(backend, geometry, chunk_size, threshold, &bone, err);
    if (status != OST_OK)
        return status;
    status = heard(b, "bone_create", b->table.bone_create(b->self, &g, chunk_size, threshold, &bone->own, &listening(&t)->error), &t, NULL, err);
    return made_bone(bone, "bone_create", status, out, err);
}

static void bone_free(ost_bone *base)
{
    plugin_bone *bone = (plugin_bone *)base;
    table_of(base->backend)->bone_free(bone->own);
    free(bone);
}

static ost_status bone_stats(const ost_bone *base, ost_bone_info *info, ost_error *err)
{
    const plugin_bone *bone = (const plugin_bone *)base;
    plugin_backend *b = backend_of(base->backend);
    ost_plugin_bone_stats s = {.size = sizeof s};
    told t;
    ost_status status = bone->lost ? is_lost(b, err)
                                   : heard(b, "bone_stats", b->table.bone_stats(bone->own, &s, &listening(&t)->error), &t, NULL, err);
    if (status == OST_OK && (s.active_chunks < 0 || s.active_chunks > info->chunks || s.active_voxels < 0 ||
                             s.active_voxels > ost_dims_count(info->geometry.dims)))
        status = ost_fail(err, OST_ERR_UNAVAILABLE, "plugin %s: bone_stats: %lld active chunks with %lld active voxels; the bone has %lld chunks and %lld voxels",
                          b->name, (long long)s.active_chunks, (long long)s.active_voxels, (long long)info->chunks,
                          (long long)ost_dims_count(info->geometry.dims));
    if (status != OST_OK)
        return status;
    info->active_chunks = s.active_chunks;
    info->active_voxels = s.active_voxels;
    info->chunk_bytes = s.chunk_bytes;
    info->resident_bytes = s.resident_bytes;
    return OST_OK;
}

static ost_status bone_upload(ost_bone *base, int32_t z0, int32_t count, const int16_t *voxels, ost_error *err)
{
    plugin_bone *bone = (plugin_bone *)base;
    plugin_backend *b = backend_of(base->backend);
    told t;
    if (bone->lost)
        return is_lost(b, err);
    return heard(b, "bone_upload", b->table.bone_upload(bone->own, z0, count, voxels, &listening(&t)->error), &t, &bone->lost, err);
}

static ost_status bone_download(const ost_bone *base, int32_t z0, int32_t count, int16_t *voxels, ost_error *err)
{
    const plugin_bone *bone = (const plugin_bone *)base;
    plugin_backend *b = backend_of(base->backend);
    told t;
    if (bone->lost)
        return is_lost(b, err);
    return heard(b, "bone_download", b->table.bone_download(bone->own, z0, count, voxels, &listening(&t)->error), &t, NULL, err);
}

static int32_t least(int32_t a, int32_t b)
{
    return a < b ? a : b;
}

/* The leaf at (x, y) of a slab that begins at its own z, zero beyond the grid. */
static void cut_leaf(const int16_t *slab, ost_dims d, int32_t depth, int32_t x, int32_t y, int16_t leaf[OST_LEAF * OST_LEAF * OST_LEAF])
{
    const int32_t wide = least(OST_LEAF, d.x - x), high = least(OST_LEAF, d.y - y);
    memset(leaf, 0, OST_LEAF * OST_LEAF * OST_LEAF * sizeof *leaf);
    for (int32_t k = 0; k < depth; k++)
        for (int32_t j = 0; j < high; j++)
            memcpy(leaf + OST_LEAF * (j + OST_LEAF * k), slab + (size_t)x + (size_t)d.x * ((size_t)(y + j) + (size_t)d.y * (size_t)k),
                   (size_t)wide * sizeof *leaf);
}

static ost_status bone_leaves(const ost_bone *base, ost_digest *leaves, ost_error *err)
{
    const ost_dims d = base->geometry.dims;
    const size_t bytes = (size_t)d.x * (size_t)d.y * OST_LEAF * sizeof(int16_t);
    int16_t *slab = malloc(bytes), *leaf = malloc(OST_LEAF * OST_LEAF * OST_LEAF * sizeof *leaf);
    ost_status status = slab && leaf ? OST_OK : ost_fail(err, OST_ERR_MEMORY, "no memory for %zu bytes of slices", bytes);
    for (int32_t z = 0; z < d.z && status == OST_OK; z += OST_LEAF) {
        const int32_t depth = least(OST_LEAF, d.z - z);
        status = bone_download(base, z, depth, slab, err);
        for (int32_t y = 0; y < d.y && status == OST_OK; y += OST_LEAF)
            for (int32_t x = 0; x < d.x && status == OST_OK; x += OST_LEAF) {
                cut_leaf(slab, d, depth, x, y, leaf);
                status = ost_digest_leaf16(leaf, leaves++, err);
            }
    }
    free(leaf);
    free(slab);
    return status;
}

/* ------------------------------------------------------------------ tools */

static ost_plugin_tool_geometry tool_geometry_of(const ost_tool_geometry *g)
{
    return (ost_plugin_tool_geometry){.size = sizeof(ost_plugin_tool_geometry), .dims = {g->dims.x, g->dims.y, g->dims.z}, .voxel_pm = g->voxel,
                                      .corner_pm = {g->corner.x, g->corner.y, g->corner.z}};
}

static ost_status new_tool(ost_backend *backend, const ost_tool_geometry *geometry, plugin_tool **out, ost_error *err)
{
    *out = calloc(1, sizeof **out);
    if (!*out)
        return ost_fail(err, OST_ERR_MEMORY, "no memory for a tool");
    (*out)->base = (ost_tool){.backend = backend, .geometry = *geometry};
    return OST_OK;
}

static ost_status made_tool(plugin_tool *tool, const char *slot, ost_status status, ost_tool **out, ost_error *err)
{
    if (status == OST_OK && !tool->own)
        status = no_object(backend_of(tool->base.backend), slot, err);
    if (status != OST_OK) {
        free(tool);
        return status;
    }
    *out = &tool->base;
    return OST_OK;
}

static ost_plugin_mesh mesh_of(const ost_snapped_mesh *m)
{
    return (ost_plugin_mesh){.size = sizeof(ost_plugin_mesh), .fraction_bits = m->fraction_bits, .vertex_count = m->vertex_count,
                             .triangle_count = m->triangle_count, .vertices = m->vertex_count ? m->vertices[0] : NULL,
                             .triangles = m->triangle_count ? m->triangles[0] : NULL};
}

static ost_status voxelize(ost_backend *backend, const ost_snapped_mesh *cutting, const ost_snapped_mesh *noncutting, ost_fill_rule rule,
                           ost_voxelize_report *report, ost_tool **out, ost_error *err)
{
    plugin_backend *b = backend_of(backend);
    const ost_plugin_tool_geometry g = tool_geometry_of(&cutting->grid);
    const ost_plugin_mesh first = mesh_of(cutting), second = noncutting ? mesh_of(noncutting) : (ost_plugin_mesh){.size = sizeof second};
    ost_plugin_voxelize_report r = {.size = sizeof r};
    plugin_tool *tool;
    told t;
    ost_status status = new_tool(backend, &cutting->grid, &tool, err);
    if (status != OST_OK)
        return status;
    status = heard(b, "voxelize",
                   b->table.voxelize(b->self, &g, &first, noncutting ? &second : NULL, rule == OST_FILL_PARITY, &r, &tool->own, &listening(&t)->error), &t,
                   NULL, err);
    *report = (ost_voxelize_report){.solid_voxels = r.solid_voxels, .cutting_voxels = r.cutting_voxels, .leaking_rows = r.leaking_rows};
    return made_tool(tool, "voxelize", status, out, err);
}

static ost_status tool_upload(ost_backend *backend, const ost_tool_volume *volume, ost_tool **out, ost_error *err)
{
    plugin_backend *b = backend_of(backend);
    const ost_plugin_tool_geometry g = tool_geometry_of(&volume->geometry);
    plugin_tool *tool;
    told t;
    ost_status status = new_tool(backend, &volume->geometry, &tool, err);
    if (status != OST_OK)
        return status;
    status = heard(b, "tool_upload", b->table.tool_upload(b->self, &g, volume->voxels, &tool->own, &listening(&t)->error), &t, NULL, err);
    return made_tool(tool, "tool_upload", status, out, err);
}

static ost_status tool_download(const ost_tool *base, ost_tool_volume *volume, ost_error *err)
{
    const plugin_tool *tool = (const plugin_tool *)base;
    plugin_backend *b = backend_of(base->backend);
    told t;
    return heard(b, "tool_download", b->table.tool_download(tool->own, volume->voxels, &listening(&t)->error), &t, NULL, err);
}

static void tool_free(ost_tool *base)
{
    plugin_tool *tool = (plugin_tool *)base;
    table_of(base->backend)->tool_free(tool->own);
    free(tool);
}

/* ----------------------------------------------------------------- events */

static ost_plugin_int128 split(ost_int128 value)
{
    return (ost_plugin_int128){.low = (uint64_t)value, .high = (int64_t)(value >> 64)};
}

static ost_plugin_map map_of(const ost_map *m, const ost_voxel_box *box)
{
    ost_plugin_map to = {.size = sizeof to, .divisor = split(m->divisor)};
    const long double unit = (long double)m->divisor * (1 << OST_MAP_FRACTION);
    for (int a = 0; a < 3; a++) {
        to.origin[a] = split(m->origin[a]);
        to.affine[a][3] = (double)((long double)m->origin[a] / unit);
        to.box_lo[a] = box->lo[a];
        to.box_hi[a] = box->hi[a];
        for (int b = 0; b < 3; b++) {
            to.column[b][a] = split(m->column[b][a]);
            to.step[b][a] = m->step[b][a];
            to.affine[a][b] = (double)((long double)m->column[b][a] / unit);
        }
    }
    return to;
}

/* Where a plugin's report goes; the first wrong line of it is kept. */
typedef struct sink {
    const plugin_backend *b;
    ost_report *report;
    int64_t chunks, last;
    int64_t chunk_voxels;
    int classes;
    ost_status status;
    ost_error *err;
} sink;

static int32_t add_chunk(void *user, int32_t chunk, const uint32_t *voxels, const int64_t *density)
{
    sink *s = user;
    ost_chunk_report line = {.chunk = chunk};
    int64_t total = 0;
    if (s->status != OST_OK)
        return OST_PLUGIN_FAILED;
    if (chunk < 0 || chunk >= s->chunks || chunk <= s->last || !voxels || !density) {
        s->status = ost_fail(s->err, OST_ERR_UNAVAILABLE, "plugin %s: reported chunk %d after chunk %lld; the bone has %lld, and they come ascending",
                             s->b->name, (int)chunk, (long long)s->last, (long long)s->chunks);
        return OST_PLUGIN_FAILED;
    }
    for (int c = 0; c < s->classes; c++) {
        line.voxels[c] = voxels[c];
        line.density[c] = density[c];
        total += voxels[c];
    }
    if (total < 1 || total > s->chunk_voxels) {
        s->status = ost_fail(s->err, OST_ERR_UNAVAILABLE, "plugin %s: reported %lld voxels in chunk %d; a chunk has 1 to %lld to report", s->b->name,
                             (long long)total, (int)chunk, (long long)s->chunk_voxels);
        return OST_PLUGIN_FAILED;
    }
    s->last = chunk;
    s->status = ost_report_add(s->report, &line, s->err);
    return s->status == OST_OK ? OST_PLUGIN_OK : OST_PLUGIN_MEMORY;
}

static ost_status run_event(ost_bone *base, const ost_tool *tool, const ost_event *event, bool apply, ost_report *report, ost_error *err)
{
    plugin_bone *bone = (plugin_bone *)base;
    plugin_backend *b = backend_of(base->backend);
    const ost_dims d = base->geometry.dims;
    const int32_t n = base->chunk_size;
    ost_plugin_map one, *maps = event->pose_count == 1 ? &one : malloc((size_t)event->pose_count * sizeof *maps);
    if (bone->lost || !maps) {
        if (maps != &one)
            free(maps);
        return bone->lost ? is_lost(b, err) : ost_fail(err, OST_ERR_MEMORY, "no memory for the maps of %d poses", event->pose_count);
    }
    for (int p = 0; p < event->pose_count; p++)
        maps[p] = map_of(&event->maps[p], &event->boxes[p]);
    const ost_plugin_event e = {.size = sizeof e, .map_count = event->pose_count, .stride = sizeof *maps, .maps = maps,
                                .class_count = event->classes->count, .class_from = event->classes->border};
    sink s = {.b = b, .report = report, .chunks = (int64_t)((d.x + n - 1) / n) * ((d.y + n - 1) / n) * ((d.z + n - 1) / n), .last = -1,
              .chunk_voxels = (int64_t)n * n * n, .classes = event->classes->count, .err = err};
    ost_plugin_report r = {.size = sizeof r, .sink = &s, .add = add_chunk};
    told t;
    listening(&t);
    const int32_t said = apply ? b->table.remove(bone->own, ((const plugin_tool *)tool)->own, &e, &r, &t.error)
                               : b->table.collide(bone->own, ((const plugin_tool *)tool)->own, &e, &r, &t.error);
    if (maps != &one)
        free(maps);
    if (s.status != OST_OK) { /* voxels may be gone that nobody was told of */
        bone->lost = apply;
        return s.status;
    }
    report->touched_voxels = r.touched_voxels;
    return heard(b, apply ? "remove" : "collide", said, &t, &bone->lost, err);
}

static ost_status run_remove(ost_bone *bone, const ost_tool *tool, const ost_event *event, ost_report *report, ost_error *err)
{
    return run_event(bone, tool, event, true, report, err);
}

static ost_status run_collide(const ost_bone *bone, const ost_tool *tool, const ost_event *event, ost_report *report, ost_error *err)
{
    return run_event((ost_bone *)(uintptr_t)bone, tool, event, false, report, err);
}

const ost_backend_ops ost_backend_plugin = {
    .name = "plugin",
    .description = "somebody else's implementation, loaded from a file: plugin:FILE.so",
    .available = available,
    .devices = ost_no_devices,
    .open = open_plugin,
    .close = close_plugin,
    .settings = settings,
    .finish = finish,
    .grid_create = grid_create,
    .grid_free = grid_free,
    .grid_upload = grid_upload,
    .grid_download = grid_download,
    .ct_to_rect = ct_to_rect,
    .rect_to_cubic = rect_to_cubic,
    .cubic_to_chunks = cubic_to_chunks,
    .bone_create = bone_create,
    .bone_free = bone_free,
    .bone_stats = bone_stats,
    .bone_upload = bone_upload,
    .bone_download = bone_download,
    .bone_leaves = bone_leaves,
    .voxelize = voxelize,
    .tool_upload = tool_upload,
    .tool_download = tool_download,
    .tool_free = tool_free,
    .remove = run_remove,
    .collide = run_collide,
};
