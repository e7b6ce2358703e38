/* SPDX-License-Identifier: Apache-2.0 */
/*
 * AR-VOX on CPUs, by tiles: a tile is some rows along y of some slices.
 *
 *   host    which triangles' bounds meet which tile's slices   a counting sort
 *   queue   ost_vox_tiles for the mesh that does not cut, then for the one that does
 *   host    waits once, for what the tiles have counted
 *
 * The host is the same processor as the device, so that it sorts costs no more
 * than a kernel would, and needs no atomics.
 */
#include "cl/objects.h"

#include <stdlib.h>

enum { TILE_BYTES = 1 << 18, TILES_BYTES = 1 << 26, DEPTH = 4, BANDS = 32, LISTED = 4 };

/* Rows along y and slices of a tile, and slices that share a list, as powers of two. */
typedef struct tile_size {
    int height, depth, layer;
} tile_size;

/* Lists that a triangle's bounds meet, inclusive; y0 > y1 or z0 > z1: none. */
typedef struct tile_range {
    int16_t y0, y1, z0, z1;
} tile_range;

typedef struct mesh_bins {
    const ost_snapped_mesh *mesh; /* NULL: none */
    uint8_t tool_class;
    uint64_t entries;  /* of all lists */
    tile_range *range; /* owned, as are the next two */
    uint32_t *start;   /* lists + 1 */
    uint32_t *list;
} mesh_bins;

/* Tiles along an axis of 2^shift rows or slices each. */
static int32_t tiles_of(int32_t n, int shift)
{
    return ((n - 1) >> shift) + 1;
}

/* First centre not below lo to last one not above hi, in tiles; centres are (i + 1/2) 2^f. */
static void tile_span(int32_t lo, int32_t hi, int f, int shift, int16_t *first, int16_t *last)
{
    const int32_t from = (lo + (1 << (f - 1)) - 1) >> f, to = ((hi + (1 << (f - 1))) >> f) - 1;
    *first = (int16_t)(from > to ? 1 : from >> shift);
    *last = (int16_t)(from > to ? 0 : to >> shift);
}

static int32_t least3(int32_t a, int32_t b, int32_t c)
{
    const int32_t m = a < b ? a : b;
    return m < c ? m : c;
}

static int32_t greatest3(int32_t a, int32_t b, int32_t c)
{
    const int32_t m = a > b ? a : b;
    return m > c ? m : c;
}

static tile_range range_of(const ost_snapped_mesh *mesh, size_t triangle, const tile_size *size, int f)
{
    const uint32_t *t = mesh->triangles[triangle];
    const int32_t *a = mesh->vertices[t[0]], *b = mesh->vertices[t[1]], *c = mesh->vertices[t[2]];
    tile_range r;
    tile_span(least3(a[1], b[1], c[1]), greatest3(a[1], b[1], c[1]), f, size->height, &r.y0, &r.y1);
    tile_span(least3(a[2], b[2], c[2]), greatest3(a[2], b[2], c[2]), f, size->layer, &r.z0, &r.z1);
    return r;
}

/* All triangles' ranges. False when the lists grow out of hand, which is less than four times the triangles and a million. */
static bool find_ranges(mesh_bins *bins, const tile_size *size, int f)
{
    const size_t triangles = bins->mesh ? bins->mesh->triangle_count : 0;
    bins->entries = 0;
    for (size_t t = 0; t < triangles; t++) {
        const tile_range r = bins->range[t] = range_of(bins->mesh, t, size, f);
        if (r.y0 <= r.y1 && r.z0 <= r.z1)
            bins->entries += (uint64_t)(r.y1 - r.y0 + 1) * (uint64_t)(r.z1 - r.z0 + 1);
    }
    return bins->entries <= LISTED * (uint64_t)triangles + (1 << 20);
}

static size_t tile_steps(const ost_cl_tiles *tiles)
{
    return (size_t)tiles->height * ((size_t)tiles->dims[0] + 1);
}

static size_t tile_marks(const ost_cl_tiles *tiles)
{
    return (size_t)tiles->height * (size_t)(tiles->dims[0] / 64 + 1);
}

static size_t tile_count(const ost_cl_tiles *tiles)
{
    return (size_t)tiles->count[0] * (size_t)tiles->count[1];
}

static size_t list_count(const ost_cl_tiles *tiles)
{
    return (size_t)tiles->count[0] * (size_t)((tiles->dims[2] - 1) / tiles->layer + 1);
}

static void set_size(ost_cl_tiles *tiles, tile_size size)
{
    tiles->layer = 1 << size.layer;
    tiles->height = 1 << size.height;
    tiles->depth = 1 << size.depth;
    tiles->count[0] = tiles_of(tiles->dims[1], size.height);
    tiles->count[1] = tiles_of(tiles->dims[2], size.depth);
}

/* Rows that the cache holds, slices enough for all threads; more where scratch or lists would grow out of hand. */
static void choose_size(ost_cl_tiles *tiles, mesh_bins bins[2])
{
    const size_t row = ((size_t)tiles->dims[0] + 1) * sizeof(int32_t);
    tile_size size = {0, 0, 0};
    while (1 << size.height < tiles->dims[1] && row << (size.height + 1) <= TILE_BYTES)
        size.height++;
    while (1 << size.depth < DEPTH && tiles->dims[2] >> (size.depth + 1) >= BANDS)
        size.depth++;
    set_size(tiles, size);
    while (tiles->count[1] > 1 && tile_count(tiles) * tile_steps(tiles) * sizeof(int32_t) > TILES_BYTES) {
        size.depth++;
        set_size(tiles, size);
    }
    for (;;) {
        const bool small[2] = {find_ranges(&bins[0], &size, tiles->fraction), find_ranges(&bins[1], &size, tiles->fraction)};
        if ((small[0] && small[1]) || list_count(tiles) == 1)
            return;
        if (tiles->layer < tiles->dims[2])
            size.layer++;
        else
            size.height++;
        set_size(tiles, size);
    }
}

static ost_status bins_make(mesh_bins *bins, const ost_cl_tiles *tiles, ost_error *err)
{
    const size_t count = list_count(tiles);
    bins->start = calloc(count + 2, sizeof *bins->start);
    bins->list = malloc(((size_t)bins->entries + 1) * sizeof *bins->list);
    if (!bins->start || !bins->list)
        return ost_fail(err, OST_ERR_MEMORY, "no memory for lists of %llu triangles", (unsigned long long)bins->entries);
    /* next[t + 1] counts list t, next[t] then is where it begins and, when all are in, where it ends. */
    uint32_t *next = bins->start + 1;
    for (int place = 0; place < 2; place++) {
        for (size_t t = 0; t < bins->mesh->triangle_count; t++) {
            const tile_range r = bins->range[t];
            for (int32_t z = r.z0; z <= r.z1; z++)
                for (int32_t y = r.y0; y <= r.y1; y++) {
                    const size_t list = (size_t)y + (size_t)tiles->count[0] * (size_t)z;
                    if (place)
                        bins->list[next[list]++] = (uint32_t)t;
                    else
                        next[list + 1]++;
                }
        }
        for (size_t t = 0; t < count && !place; t++)
            next[t + 1] += next[t];
    }
    return OST_OK;
}

typedef struct tiled {
    cl_backend *b;
    ost_cl_tiles tiles;
    cl_mem steps, marks, counts;
    size_t steps_room;
} tiled;

static ost_status add_mesh(tiled *v, mesh_bins *bins, cl_mem classes, ost_error *err)
{
    cl_backend *b = v->b;
    const ost_snapped_mesh *mesh = bins->mesh;
    if (!mesh)
        return OST_OK;
    cl_mem tiles = NULL, vertices = NULL, triangles = NULL, start = NULL, list = NULL;
    v->tiles.tool_class = bins->tool_class;
    const size_t count = list_count(&v->tiles);
    ost_status status = bins_make(bins, &v->tiles, err);
    if (status == OST_OK)
        status = ost_cl_buffer(b, sizeof v->tiles, &v->tiles, "voxelization", &tiles, err);
    if (status == OST_OK)
        status = ost_cl_buffer(b, mesh->vertex_count * sizeof mesh->vertices[0], mesh->vertices, "vertices", &vertices, err);
    if (status == OST_OK)
        status = ost_cl_buffer(b, mesh->triangle_count * sizeof mesh->triangles[0], mesh->triangles, "triangles", &triangles, err);
    if (status == OST_OK)
        status = ost_cl_buffer(b, (count + 1) * sizeof *bins->start, bins->start, "triangles of tiles", &start, err);
    if (status == OST_OK)
        status = ost_cl_buffer(b, bins->start[count] * sizeof *bins->list, bins->list, "triangles of tiles", &list, err);
    if (status == OST_OK)
        status = OST_CL_LAUNCH(b, ost_vox_tiles, (size_t)v->tiles.count[0], (size_t)v->tiles.count[1], 1, err, OST_CL_ARG(tiles),
                               OST_CL_ARG(vertices), OST_CL_ARG(triangles), OST_CL_ARG(start), OST_CL_ARG(list), OST_CL_ARG(v->steps),
                               OST_CL_ARG(v->marks), OST_CL_ARG(classes), OST_CL_ARG(v->counts));
    v->tiles.over = 1;
    ost_cl_buffer_free(b, &list);
    ost_cl_buffer_free(b, &start);
    ost_cl_buffer_free(b, &triangles);
    ost_cl_buffer_free(b, &vertices);
    ost_cl_buffer_free(b, &tiles);
    return status;
}

ost_status ost_cl_voxelize_tiles(ost_backend *backend, const ost_snapped_mesh *cutting, const ost_snapped_mesh *noncutting,
                                 ost_fill_rule rule, ost_voxelize_report *report, ost_tool **out, ost_error *err)
{
    const ost_dims dims = cutting->grid.dims;
    tiled v = {.b = (cl_backend *)backend,
               .tiles = {.dims = {dims.x, dims.y, dims.z}, .fraction = cutting->fraction_bits, .rule = (int32_t)rule}};
    mesh_bins bins[2] = {{.mesh = noncutting, .tool_class = OST_TOOL_NONCUTTING}, {.mesh = cutting, .tool_class = OST_TOOL_CUTTING}};
    cl_tool *tool = NULL;
    uint64_t *counts = NULL;
    size_t count = 0;
    ost_status status = OST_OK;
    for (int m = 0; m < 2; m++)
        if (bins[m].mesh && !(bins[m].range = malloc((bins[m].mesh->triangle_count + 1) * sizeof *bins[m].range)))
            status = ost_fail(err, OST_ERR_MEMORY, "no memory for the tiles of %zu triangles", (size_t)bins[m].mesh->triangle_count);
    if (status == OST_OK) {
        choose_size(&v.tiles, bins);
        count = tile_count(&v.tiles);
        counts = malloc(3 * count * sizeof *counts);
        if (!counts)
            status = ost_fail(err, OST_ERR_MEMORY, "no memory for the counts of %zu tiles", count);
    }
    if (status == OST_OK)
        status = ost_cl_tool_create(backend, &cutting->grid, &tool, err);
    if (status == OST_OK)
        status = ost_cl_room_take(v.b, count * tile_steps(&v.tiles) * sizeof(int32_t), "steps of rows", &v.steps, &v.steps_room, err);
    if (status == OST_OK)
        status = ost_cl_buffer(v.b, count * tile_marks(&v.tiles) * sizeof(uint64_t), NULL, "marks of rows", &v.marks, err);
    if (status == OST_OK)
        status = ost_cl_buffer(v.b, 3 * count * sizeof *counts, NULL, "counts", &v.counts, err);
    for (int m = 0; m < 2 && status == OST_OK; m++)
        status = add_mesh(&v, &bins[m], tool->classes, err);
    if (status == OST_OK)
        status = ost_cl_read(v.b, v.counts, 0, 3 * count * sizeof *counts, counts, err);
    if (status == OST_OK) {
        *report = (ost_voxelize_report){.leaking_rows = 0};
        for (size_t t = 0; t < count; t++) {
            report->solid_voxels += counts[3 * t];
            report->cutting_voxels += counts[3 * t + 1];
            report->leaking_rows += counts[3 * t + 2];
        }
        tool->touches = noncutting != NULL;
        *out = &tool->base;
    } else if (tool) {
        ost_cl_tool_free(&tool->base);
    }
    ost_cl_room_give(v.b, &v.steps, v.steps_room);
    ost_cl_buffer_free(v.b, &v.marks);
    ost_cl_buffer_free(v.b, &v.counts);
    for (int m = 0; m < 2; m++) {
        free(bins[m].range);
        free(bins[m].start);
        free(bins[m].list);
    }
    free(counts);
    return status;
}
