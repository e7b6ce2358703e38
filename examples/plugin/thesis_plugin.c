/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A complete plugin: the function table, the memory of grids, bones and tools, and the reports.
 * The float computations are in thesis_f32.cl and are called through engine.h.
 *
 *   osteon  --table of osteon/plugin.h-->  thesis_plugin.c  --engine.h-->  engine_c.c or engine_cl.c
 *
 * The plugin is an example of the interface and shows the effects of the thesis' arithmetic. It is
 * not meant to be fast. A bone is one dense array. Where the thesis deletes the buffer of a chunk
 * without active voxels, the plugin sets the chunk's part of this array to zero.
 *
 * The file has more than 500 lines, because all slots of the table are in one place.
 */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine.h"
#include "steps.h"

struct ost_plugin_instance {
    engine *e;
};

struct ost_plugin_grid {
    ost_plugin_instance *self;
    ost_plugin_geometry geometry;
    int16_t *voxels;
};

struct ost_plugin_bone {
    ost_plugin_instance *self;
    ost_plugin_geometry geometry;
    int32_t chunk, threshold;
    int16_t *voxels;
};

struct ost_plugin_tool {
    ost_plugin_instance *self;
    ost_plugin_tool_geometry geometry;
    uint8_t *voxels;
};

/* ------------------------------------------------------------------ helpers */

int32_t plugin_fail(ost_plugin_error *error, int32_t status, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    vsnprintf(error->text, error->text_size, format, args);
    va_end(args);
    return status;
}

int option(const char *options, const char *key, char *value, size_t size)
{
    const size_t length = strlen(key);
    value[0] = '\0';
    for (const char *at = options; *at;) {
        const size_t n = strcspn(at, ",");
        if (n > length && strncmp(at, key, length) == 0 && at[length] == '=') {
            if (n - length - 1 >= size)
                return 0;
            memcpy(value, at + length + 1, n - length - 1);
            value[n - length - 1] = '\0';
            return 1;
        }
        at += n;
        at += *at == ',';
    }
    return 1;
}

static int32_t no_memory(ost_plugin_error *error, size_t bytes)
{
    return plugin_fail(error, OST_PLUGIN_MEMORY, "no memory for %zu bytes", bytes);
}

static size_t volume(const int32_t dims[3])
{
    return (size_t)dims[0] * (size_t)dims[1] * (size_t)dims[2];
}

static size_t slice(const int32_t dims[3])
{
    return (size_t)dims[0] * (size_t)dims[1];
}

static float millimetres(double pm)
{
    return (float)(pm / 1e9);
}

/* -------------------------------------------------------------------- choice */

static int32_t plugin_open(const char *options, const ost_plugin_host *host, ost_plugin_instance **out,
                           ost_plugin_error *error)
{
    (void)host; /* this plugin does not need the host's block_base and versions */
    ost_plugin_instance *self = calloc(1, sizeof *self);
    if (!self)
        return no_memory(error, sizeof *self);
    const int32_t status = engine_open(options, &self->e, error);
    if (status != OST_PLUGIN_OK)
        free(self);
    else
        *out = self;
    return status;
}

static void plugin_close(ost_plugin_instance *self)
{
    engine_close(self->e);
    free(self);
}

static int32_t plugin_finish(ost_plugin_instance *self, ost_plugin_error *error)
{
    (void)self;
    (void)error;
    return OST_PLUGIN_OK;
}

/* --------------------------------------------------------------------- grids */

static int32_t grid_create(ost_plugin_instance *self, const ost_plugin_geometry *geometry, ost_plugin_grid **out,
                           ost_plugin_error *error)
{
    const size_t count = volume(geometry->dims);
    ost_plugin_grid *grid = malloc(sizeof *grid);
    int16_t *voxels = calloc(count, sizeof *voxels);
    if (!grid || !voxels) {
        free(grid);
        free(voxels);
        return no_memory(error, count * sizeof *voxels);
    }
    *grid = (ost_plugin_grid){self, *geometry, voxels};
    *out = grid;
    return OST_PLUGIN_OK;
}

static void grid_free(ost_plugin_grid *grid)
{
    free(grid->voxels);
    free(grid);
}

static int32_t grid_upload(ost_plugin_grid *grid, int32_t z0, int32_t count, const int16_t *voxels,
                           ost_plugin_error *error)
{
    const size_t n = slice(grid->geometry.dims);
    (void)error;
    memcpy(grid->voxels + n * (size_t)z0, voxels, n * (size_t)count * sizeof *voxels);
    return OST_PLUGIN_OK;
}

static int32_t grid_download(const ost_plugin_grid *grid, int32_t z0, int32_t count, int16_t *voxels,
                             ost_plugin_error *error)
{
    const size_t n = slice(grid->geometry.dims);
    (void)error;
    memcpy(voxels, grid->voxels + n * (size_t)z0, n * (size_t)count * sizeof *voxels);
    return OST_PLUGIN_OK;
}

/* -------------------------------------------------------------------- import */

/*
 * Implements Algs. 2.2 to 2.4. In the grid that the host requests, every lattice point of the samples has a voxel. The
 * dims of Alg. 2.3 are smaller by one on each axis on which all positions are multiples of the voxel size. The index
 * that Alg. 1.1 computes from these smaller dims is therefore converted to an index in the host's grid.
 */
static int32_t ct_to_rect(ost_plugin_grid *grid, const ost_plugin_samples *samples, ost_plugin_scatter_report *report,
                          ost_plugin_error *error)
{
    const ost_plugin_geometry *g = &grid->geometry;
    const size_t count = (size_t)samples->count;
    float *four = malloc((count ? count : 1) * 4 * sizeof *four), bounds[9];
    int *index = malloc((count ? count : 1) * sizeof *index);
    thesis_rect rect;
    int32_t status = four && index ? OST_PLUGIN_OK : no_memory(error, count * 5 * sizeof *four);
    if (status == OST_PLUGIN_OK) {
        for (int a = 0; a < 3; a++) {
            bounds[3 * a] = millimetres((double)g->origin_pm[a]);
            bounds[3 * a + 1] = millimetres((double)(g->origin_pm[a] + (g->dims[a] - 1) * g->spacing_pm[a]));
            bounds[3 * a + 2] = millimetres((double)g->spacing_pm[a]);
        }
        for (size_t s = 0; s < count; s++) {
            const ost_plugin_sample *one = &samples->sample[s];
            four[4 * s] = millimetres((double)one->x_pm);
            four[4 * s + 1] = millimetres((double)one->y_pm);
            four[4 * s + 2] = millimetres((double)one->z_pm);
            four[4 * s + 3] = (float)one->density;
        }
        status = engine_index(grid->self->e, bounds, four, count, &rect, index, error);
    }
    for (size_t s = 0; s < count && status == OST_PLUGIN_OK; s++) {
        if (index[s] < 0)
            continue; /* the thesis' code does not test this and would write outside its array */
        const int x = index[s] % rect.axis[0].dims, y = index[s] / rect.axis[0].dims % rect.axis[1].dims,
                  z = index[s] / rect.axis[0].dims / rect.axis[1].dims;
        if (x < g->dims[0] && y < g->dims[1] && z < g->dims[2])
            grid->voxels[(size_t)x + (size_t)g->dims[0] * ((size_t)y + (size_t)g->dims[1] * (size_t)z)] = (int16_t)
                four[4 * s + 3];
    }
    report->samples += count; /* the other counts remain 0, because the thesis' algorithm does not compute them */
    free(index);
    free(four);
    return status;
}

/* Implements Alg. 2.5, which resamples only along z. */
static int32_t rect_to_cubic(const ost_plugin_grid *rect, const ost_plugin_geometry *cubic, int32_t rule,
                             ost_plugin_grid **out, ost_plugin_error *error)
{
    const int32_t *from = rect->geometry.dims, *to = cubic->dims;
    (void)rule; /* the argument `rule` is ignored, because the thesis has only one rule */
    int32_t status = grid_create(rect->self, cubic, out, error);
    if (status != OST_PLUGIN_OK)
        return status;
    int *layer = malloc((size_t)to[2] * sizeof *layer);
    status = layer ? engine_layers(rect->self->e, millimetres((double)cubic->spacing_pm[2]),
                                   millimetres((double)rect->geometry.spacing_pm[2]), (size_t)to[2], layer, error)
                   : no_memory(error, (size_t)to[2] * sizeof *layer);
    for (int32_t z = 0; z < to[2] && status == OST_PLUGIN_OK; z++)
        for (int32_t y = 0; y < to[1]; y++)
            for (int32_t x = 0; x < to[0]; x++)
                if (x < from[0] && y < from[1] && layer[z] >= 0 && layer[z] < from[2])
                    (*out)->voxels[(size_t)x + (size_t)to[0] * ((size_t)y + (size_t)to[1] * (size_t)z)] =
                        rect->voxels[(size_t)x + (size_t)from[0] * ((size_t)y + (size_t)from[1] * (size_t)layer[z])];
    free(layer);
    if (status != OST_PLUGIN_OK) {
        grid_free(*out);
        *out = NULL;
    }
    return status;
}

/* --------------------------------------------------------------------- bones */

typedef struct chunk_box {
    int32_t lo[3], hi[3];
} chunk_box;

static int32_t chunks_along(const ost_plugin_bone *bone, int a)
{
    return (bone->geometry.dims[a] + bone->chunk - 1) / bone->chunk;
}

static chunk_box chunk_at(const ost_plugin_bone *bone, int32_t cx, int32_t cy, int32_t cz)
{
    const int32_t c[3] = {cx, cy, cz};
    chunk_box box;
    for (int a = 0; a < 3; a++) {
        box.lo[a] = c[a] * bone->chunk;
        box.hi[a] = box.lo[a] + bone->chunk < bone->geometry.dims[a] ? box.lo[a] + bone->chunk : bone->geometry.dims[a];
    }
    return box;
}

static size_t at(const ost_plugin_bone *bone, int32_t x, int32_t y, int32_t z)
{
    const int32_t *d = bone->geometry.dims;
    return (size_t)x + (size_t)d[0] * ((size_t)y + (size_t)d[1] * (size_t)z);
}

static int64_t active_in(const ost_plugin_bone *bone, const chunk_box *box)
{
    int64_t active = 0;
    for (int32_t z = box->lo[2]; z < box->hi[2]; z++)
        for (int32_t y = box->lo[1]; y < box->hi[1]; y++)
            for (int32_t x = box->lo[0]; x < box->hi[0]; x++)
                active += bone->voxels[at(bone, x, y, z)] >= bone->threshold;
    return active;
}

/* Deletes a chunk that has no active voxels, by setting its densities to zero. */
static void delete_if_empty(ost_plugin_bone *bone, const chunk_box *box)
{
    if (active_in(bone, box) > 0)
        return;
    for (int32_t z = box->lo[2]; z < box->hi[2]; z++)
        for (int32_t y = box->lo[1]; y < box->hi[1]; y++)
            memset(bone->voxels + at(bone, box->lo[0], y, z), 0,
                   (size_t)(box->hi[0] - box->lo[0]) * sizeof *bone->voxels);
}

static int32_t bone_create(ost_plugin_instance *self, const ost_plugin_geometry *geometry, int32_t chunk_size,
                           int32_t threshold, ost_plugin_bone **out, ost_plugin_error *error)
{
    const size_t count = volume(geometry->dims);
    ost_plugin_bone *bone = malloc(sizeof *bone);
    int16_t *voxels = calloc(count, sizeof *voxels);
    if (!bone || !voxels) {
        free(bone);
        free(voxels);
        return no_memory(error, count * sizeof *voxels);
    }
    *bone = (ost_plugin_bone){self, *geometry, chunk_size, threshold, voxels};
    *out = bone;
    return OST_PLUGIN_OK;
}

static void bone_free(ost_plugin_bone *bone)
{
    free(bone->voxels);
    free(bone);
}

/* Implements Alg. 2.6, which also copies densities below the threshold. */
static int32_t cubic_to_chunks(const ost_plugin_grid *cubic, int32_t chunk_size, int32_t threshold,
                               ost_plugin_bone **out, ost_plugin_error *error)
{
    const int32_t status = bone_create(cubic->self, &cubic->geometry, chunk_size, threshold, out, error);
    if (status != OST_PLUGIN_OK)
        return status;
    memcpy((*out)->voxels, cubic->voxels, volume(cubic->geometry.dims) * sizeof *cubic->voxels);
    for (int32_t z = 0; z < chunks_along(*out, 2); z++)
        for (int32_t y = 0; y < chunks_along(*out, 1); y++)
            for (int32_t x = 0; x < chunks_along(*out, 0); x++) {
                const chunk_box box = chunk_at(*out, x, y, z);
                delete_if_empty(*out, &box);
            }
    return OST_PLUGIN_OK;
}

static int32_t bone_stats(const ost_plugin_bone *bone, ost_plugin_bone_stats *stats, ost_plugin_error *error)
{
    const int64_t bytes = (int64_t)bone->chunk * bone->chunk * bone->chunk * 2;
    (void)error;
    stats->active_chunks = stats->active_voxels = 0;
    for (int32_t z = 0; z < chunks_along(bone, 2); z++)
        for (int32_t y = 0; y < chunks_along(bone, 1); y++)
            for (int32_t x = 0; x < chunks_along(bone, 0); x++) {
                const chunk_box box = chunk_at(bone, x, y, z);
                const int64_t active = active_in(bone, &box);
                stats->active_voxels += active;
                stats->active_chunks += active > 0;
            }
    stats->chunk_bytes = stats->active_chunks * bytes;
    stats->resident_bytes = (int64_t)(volume(bone->geometry.dims) * sizeof *bone->voxels);
    return OST_PLUGIN_OK;
}

static int32_t bone_upload(ost_plugin_bone *bone, int32_t z0, int32_t count, const int16_t *voxels,
                           ost_plugin_error *error)
{
    const size_t n = slice(bone->geometry.dims);
    (void)error;
    for (size_t v = 0; v < n * (size_t)count; v++)
        bone->voxels[n * (size_t)z0 + v] = voxels[v] >= bone->threshold ? voxels[v] : 0;
    return OST_PLUGIN_OK;
}

static int32_t bone_download(const ost_plugin_bone *bone, int32_t z0, int32_t count, int16_t *voxels,
                             ost_plugin_error *error)
{
    const size_t n = slice(bone->geometry.dims);
    (void)error;
    memcpy(voxels, bone->voxels + n * (size_t)z0, n * (size_t)count * sizeof *voxels);
    return OST_PLUGIN_OK;
}

/* --------------------------------------------------------------------- tools */

static int32_t tool_upload(ost_plugin_instance *self, const ost_plugin_tool_geometry *geometry, const uint8_t *voxels,
                           ost_plugin_tool **out, ost_plugin_error *error)
{
    const size_t count = volume(geometry->dims);
    ost_plugin_tool *tool = malloc(sizeof *tool);
    uint8_t *own = calloc(count, 1);
    if (!tool || !own) {
        free(tool);
        free(own);
        return no_memory(error, count);
    }
    if (voxels)
        memcpy(own, voxels, count);
    *tool = (ost_plugin_tool){self, *geometry, own};
    *out = tool;
    return OST_PLUGIN_OK;
}

static int32_t tool_download(const ost_plugin_tool *tool, uint8_t *voxels, ost_plugin_error *error)
{
    (void)error;
    memcpy(voxels, tool->voxels, volume(tool->geometry.dims));
    return OST_PLUGIN_OK;
}

static void tool_free(ost_plugin_tool *tool)
{
    free(tool->voxels);
    free(tool);
}

/* Returns the corners in millimetres, as nine floats per triangle. Stores the minimum on each axis in `least`. */
static float *corners_of(const ost_plugin_tool_geometry *g, const ost_plugin_mesh *mesh, float least[3],
                         ost_plugin_error *error)
{
    const double unit = (double)g->voxel_pm / (double)(1 << mesh->fraction_bits);
    float *corners = malloc((size_t)(mesh->triangle_count ? mesh->triangle_count : 1) * 9 * sizeof *corners);
    if (!corners) {
        no_memory(error, (size_t)mesh->triangle_count * 9 * sizeof *corners);
        return NULL;
    }
    for (uint64_t t = 0; t < 3 * mesh->triangle_count; t++)
        for (int a = 0; a < 3; a++) {
            const float x = millimetres((double)g->corner_pm[a] +
                                        mesh->vertices[3 * (size_t)mesh->triangles[t] + (size_t)a] * unit);
            corners[3 * t + (uint64_t)a] = x;
            least[a] = x < least[a] ? x : least[a];
        }
    return corners;
}

static int32_t fill(ost_plugin_tool *tool, const float minimum[3], const ost_plugin_mesh *mesh, const float *corners,
                    int32_t parity, int mark, ost_plugin_error *error)
{
    const ost_plugin_tool_geometry *g = &tool->geometry;
    const thesis_grid grid = {.minimum = {minimum[0], minimum[1], minimum[2]},
                              .size = millimetres((double)g->voxel_pm),
                              .dims = {g->dims[0], g->dims[1], g->dims[2]},
                              .parity = parity,
                              .triangles = (int)mesh->triangle_count};
    return engine_solid(tool->self->e, &grid, corners, mark, tool->voxels, error);
}

static int32_t voxelize(ost_plugin_instance *self, const ost_plugin_tool_geometry *geometry,
                        const ost_plugin_mesh *cutting, const ost_plugin_mesh *noncutting, int32_t parity,
                        ost_plugin_voxelize_report *report, ost_plugin_tool **out, ost_plugin_error *error)
{
    float least[3] = {3e38f, 3e38f, 3e38f}, minimum[3] = {0, 0, 0};
    int32_t status = tool_upload(self, geometry, NULL, out, error);
    if (status != OST_PLUGIN_OK)
        return status;
    float *cut = corners_of(geometry, cutting, least, error),
          *other = noncutting ? corners_of(geometry, noncutting, least, error) : NULL;
    if (!cut || (noncutting && !other))
        status = OST_PLUGIN_MEMORY;
    if (status == OST_PLUGIN_OK && least[0] < 3e38f)
        status = engine_minimum(self->e, least, millimetres((double)geometry->voxel_pm), minimum, error);
    if (status == OST_PLUGIN_OK && noncutting)
        status = fill(*out, minimum, noncutting, other, parity, 2, error);
    if (status == OST_PLUGIN_OK)
        status = fill(*out, minimum, cutting, cut, parity, 1, error);
    free(cut);
    free(other);
    if (status != OST_PLUGIN_OK) {
        tool_free(*out);
        *out = NULL;
        return status;
    }
    for (size_t v = 0; v < volume(geometry->dims); v++) {
        report->solid_voxels += (*out)->voxels[v] != 0;
        report->cutting_voxels += (*out)->voxels[v] == 1;
    }
    return OST_PLUGIN_OK; /* leaking_rows remains 0, because the thesis does not detect leaks */
}

/* -------------------------------------------------------------------- events */

/* Converts the host's map, which is in units of voxels, to the thesis' matrix, which is in millimetres relative to the
   centres of the boxes. */
static thesis_boxes boxes_of(const ost_plugin_bone *bone, const ost_plugin_tool *tool, const ost_plugin_map *map)
{
    const double bone_mm = (double)bone->geometry.spacing_pm[0] / 1e9, tool_mm = (double)tool->geometry.voxel_pm / 1e9;
    thesis_boxes x = {.bone_voxel = (float)bone_mm, .tool_voxel = (float)tool_mm, .chunk_size = bone->chunk};
    for (int a = 0; a < 3; a++) {
        double centre = map->affine[a][3];
        x.bone_dims[a] = bone->geometry.dims[a];
        x.tool_dims[a] = tool->geometry.dims[a];
        x.bone[a] = (float)x.bone_dims[a] * x.bone_voxel / 2;
        x.tool[a] = (float)x.tool_dims[a] * x.tool_voxel / 2;
        for (int b = 0; b < 3; b++) {
            x.matrix[4 * a + b] = (float)(map->affine[a][b] * tool_mm / bone_mm);
            centre += (bone->geometry.dims[b] - 1) * 0.5 * map->affine[a][b];
        }
        x.matrix[4 * a + 3] = (float)((centre - x.tool_dims[a] * 0.5) * tool_mm);
    }
    return x;
}

static int class_of(const ost_plugin_event *event, int16_t density)
{
    int c = event->class_count - 1;
    while (c > 0 && density < event->class_from[c])
        c--;
    return c;
}

/* Counts the marks of one chunk. If `apply` is true, also removes the marked voxels. */
static int32_t take_chunk(ost_plugin_bone *bone, const ost_plugin_event *event, const uint8_t *marks, int32_t number,
                          const chunk_box *box, int apply, ost_plugin_report *report)
{
    uint32_t voxels[8] = {0};
    int64_t density[8] = {0};
    uint32_t total = 0;
    for (int32_t z = box->lo[2]; z < box->hi[2]; z++)
        for (int32_t y = box->lo[1]; y < box->hi[1]; y++)
            for (int32_t x = box->lo[0]; x < box->hi[0]; x++) {
                const size_t v = at(bone, x, y, z);
                const int active = bone->voxels[v] >= bone->threshold;
                report->touched_voxels += active && marks[v] == 2;
                if (marks[v] != 1)
                    continue;
                if (active) {
                    const int c = class_of(event, bone->voxels[v]);
                    voxels[c]++;
                    density[c] += bone->voxels[v];
                    total++;
                }
                if (apply)
                    bone->voxels[v] = 0;
            }
    if (apply)
        delete_if_empty(bone, box);
    return total ? report->add(report->sink, number, voxels, density) : OST_PLUGIN_OK;
}

static int32_t run_event(ost_plugin_bone *bone, const ost_plugin_tool *tool, const ost_plugin_event *event, int apply,
                         ost_plugin_report *report, ost_plugin_error *error)
{
    const size_t count = volume(bone->geometry.dims);
    uint8_t *marks = calloc(count, 1);
    int lo[3] = {1 << 30, 1 << 30, 1 << 30}, hi[3] = {0, 0, 0};
    int32_t status = marks ? OST_PLUGIN_OK : no_memory(error, count);
    for (int32_t p = 0; p < event->map_count && status == OST_PLUGIN_OK; p++) {
        const ost_plugin_map *map = (const ost_plugin_map *)(const void *)((const char *)event->maps +
                                                                           (size_t)p * event->stride);
        thesis_boxes x = boxes_of(bone, tool, map);
        status = engine_pose(bone->self->e, &x, tool->voxels, marks, error);
        for (int a = 0; a < 3; a++) {
            lo[a] = x.chunk_lo[a] < lo[a] ? x.chunk_lo[a] : lo[a];
            hi[a] = x.chunk_hi[a] > hi[a] ? x.chunk_hi[a] : hi[a];
        }
    }
    for (int a = 0; a < 3; a++) {
        lo[a] = lo[a] < 0 ? 0 : lo[a];
        hi[a] = hi[a] > chunks_along(bone, a) ? chunks_along(bone, a) : hi[a];
    }
    for (int32_t z = lo[2]; z < hi[2] && status == OST_PLUGIN_OK; z++)
        for (int32_t y = lo[1]; y < hi[1] && status == OST_PLUGIN_OK; y++)
            for (int32_t x = lo[0]; x < hi[0] && status == OST_PLUGIN_OK; x++) {
                const chunk_box box = chunk_at(bone, x, y, z);
                status = take_chunk(bone, event, marks, x + chunks_along(bone, 0) * (y + chunks_along(bone, 1) * z),
                                    &box, apply, report);
            }
    free(marks);
    return status;
}

static int32_t run_remove(ost_plugin_bone *bone, const ost_plugin_tool *tool, const ost_plugin_event *event,
                          ost_plugin_report *report, ost_plugin_error *error)
{
    const int32_t status = run_event(bone, tool, event, 1, report, error);
    return status == OST_PLUGIN_OK ? status : OST_PLUGIN_LOST;
}

/* The slot collide runs the event without removing voxels. */
static int32_t run_collide(const ost_plugin_bone *bone, const ost_plugin_tool *tool, const ost_plugin_event *event,
                           ost_plugin_report *report, ost_plugin_error *error)
{
    return run_event((ost_plugin_bone *)(uintptr_t)bone, tool, event, 0, report, error);
}

/* --------------------------------------------------------------------- table */

static const ost_plugin table = {
    .size = sizeof table,
    .abi = OST_PLUGIN_ABI,
    .arithmetic = 0, /* this plugin follows the thesis instead of docs/spec/arithmetic.md */
    .name = engine_name,
    .description = engine_about,
    .open = plugin_open,
    .close = plugin_close,
    .finish = plugin_finish,
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
    .voxelize = voxelize,
    .tool_upload = tool_upload,
    .tool_download = tool_download,
    .tool_free = tool_free,
    .remove = run_remove,
    .collide = run_collide,
    .snap = example_snap,
    .steps = example_steps,
};

OST_PLUGIN_EXPORT const ost_plugin *ost_plugin_entry(uint32_t host_abi);

const ost_plugin *ost_plugin_entry(uint32_t host_abi)
{
    return host_abi == OST_PLUGIN_ABI ? &table : NULL;
}
