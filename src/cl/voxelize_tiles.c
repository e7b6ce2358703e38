/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Voxelization (AR-VOX) on devices that are CPUs, by tiles. A tile consists of several
 * rows along y in several slices.
 *
 *   host    finds, for each tile, the triangles whose bounds overlap it (a counting sort)
 *   queue   ost_vox_tiles for the noncutting mesh, then for the cutting mesh
 *   host    waits once, for the counts of the tiles
 *
 * The host and the device are the same processor, so sorting on the host takes no more
 * time than a kernel would, and needs no atomics.
 */
#include "cl/objects.h"

#include <stdlib.h>

enum { TILE_BYTES = 1 << 18, PASS_BYTES = 1 << 19, TILES_BYTES = 1 << 26, BANDS = 8, LISTED = 4 };

/*
 * The size of a tile. Each member is the exponent of a power of two: `height` for the number of rows along y, `depth`
 * for the number of slices, `layer` for the number of slices that share a list, and `pass` for the number of slices
 * that are marked together.
 */
typedef struct tile_size {
    int height, depth, layer, pass;
} tile_size;

/*
 * The indices of the first and the last centre along y and z within the bounds of a vertex or a triangle. If the bounds
 * contain no centre on an axis, the last index is less than the first (for a vertex, by 1).
 */
typedef struct centres {
    int16_t y0, z0, y1, z1;
} centres;

typedef struct mesh_bins {
    const ost_snapped_mesh *mesh; /* NULL if the tool has no mesh of this class (cutting or non-cutting) */
    uint8_t tool_class;
    uint64_t entries; /* sum of the lengths of all lists */
    size_t count;     /* number of triangles whose bounds contain at least one voxel centre */
    /* numbers of the triangles whose bounds contain a centre; `number` and the next four arrays are owned */
    uint32_t *number;
    centres *range;   /* for each triangle in `number`, the ranges of centres in its bounds */
    centres *vertex;
    uint32_t *start;  /* for each list, the index of its first entry in `list`; lists + 1 elements */
    uint32_t *list;
} mesh_bins;

/* Returns the number of tiles along an axis with n rows or slices, if a tile has 2^shift of them. */
static int32_t tiles_of(int32_t n, int shift)
{
    return ((n - 1) >> shift) + 1;
}

static int16_t least(int16_t a, int16_t b)
{
    return a < b ? a : b;
}

static int16_t greatest(int16_t a, int16_t b)
{
    return a > b ? a : b;
}

/* Finds the centres in the bounds of all vertices and triangles; centre i is at (i + 1/2) 2^f. The second loop has no
   branch for triangles whose bounds contain no centre, because the branch would be unpredictable. */
static void find_ranges(mesh_bins *bins, int f)
{
    const ost_snapped_mesh *mesh = bins->mesh;
    const int32_t half = 1 << (f - 1);
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        const int32_t y = mesh->vertices[v][1], z = mesh->vertices[v][2];
        bins->vertex[v] = (centres){(int16_t)((y + half - 1) >> f), (int16_t)((z + half - 1) >> f),
                                    (int16_t)(((y + half) >> f) - 1), (int16_t)(((z + half) >> f) - 1)};
    }
    bins->count = 0;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const uint32_t *of = mesh->triangles[t];
        const centres a = bins->vertex[of[0]], b = bins->vertex[of[1]], c = bins->vertex[of[2]];
        const centres r = {least(least(a.y0, b.y0), c.y0), least(least(a.z0, b.z0), c.z0),
                           greatest(greatest(a.y1, b.y1), c.y1), greatest(greatest(a.z1, b.z1), c.z1)};
        bins->range[bins->count] = r;
        bins->number[bins->count] = (uint32_t)t;
        bins->count += (size_t)((r.y0 <= r.y1) & (r.z0 <= r.z1));
    }
}

static ost_status bins_start(mesh_bins *bins, int f, ost_error *err)
{
    const ost_snapped_mesh *mesh = bins->mesh;
    if (!mesh)
        return OST_OK;
    bins->vertex = malloc(((size_t)mesh->vertex_count + 1) * sizeof *bins->vertex);
    bins->range = malloc(((size_t)mesh->triangle_count + 1) * sizeof *bins->range);
    bins->number = malloc(((size_t)mesh->triangle_count + 1) * sizeof *bins->number);
    if (!bins->vertex || !bins->range || !bins->number)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for the tiles of %zu triangles",
                        (size_t)mesh->triangle_count);
    find_ranges(bins, f);
    return OST_OK;
}

/*
 * Counts the entries of all lists. Returns false if there are more than LISTED entries per triangle plus a constant.
 * The constant is 2^20 or, if it is lower, the value of the option staging=.
 */
static bool count_entries(const cl_backend *b, mesh_bins *bins, const tile_size *size)
{
    uint64_t entries = 0;
    for (size_t n = 0; n < bins->count; n++) {
        const centres r = bins->range[n];
        entries += (uint64_t)((r.y1 >> size->height) - (r.y0 >> size->height) + 1) *
                   (uint64_t)((r.z1 >> size->layer) - (r.z0 >> size->layer) + 1);
    }
    bins->entries = entries;
    return entries <= LISTED * (uint64_t)bins->count + ost_cl_staging(b, 1 << 20);
}

static size_t tile_steps(const ost_cl_tiles *tiles)
{
    return (size_t)tiles->pass * (size_t)tiles->height * ((size_t)tiles->dims[0] + 1);
}

static size_t tile_marks(const ost_cl_tiles *tiles)
{
    return (size_t)tiles->pass * (size_t)tiles->height * (size_t)(tiles->dims[0] / 64 + 1);
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
    tiles->pass = 1 << size.pass;
    tiles->height = 1 << size.height;
    tiles->depth = 1 << size.depth;
    tiles->count[0] = tiles_of(tiles->dims[1], size.height);
    tiles->count[1] = tiles_of(tiles->dims[2], size.depth);
}

/*
 * Chooses the size of tiles. The number of rows of a tile and the number of slices of a pass are chosen so that the
 * scratch memory of a pass fits into the cache. The number of slices of a tile is chosen so that there are at least
 * BANDS tiles along z, if the grid has enough slices. Tiles and layers are then enlarged until the scratch memory of
 * all tiles and the lists are small enough.
 */
static tile_size choose_size(const cl_backend *b, ost_cl_tiles *tiles, mesh_bins bins[2])
{
    const size_t tile_bytes = ost_cl_staging(b, TILE_BYTES), pass_bytes = ost_cl_staging(b, PASS_BYTES);
    const size_t row = ((size_t)tiles->dims[0] + 1) * sizeof(int32_t);
    tile_size size = {0, 0, 0, 0};
    while (1 << size.height < tiles->dims[1] && row << (size.height + 1) <= tile_bytes)
        size.height++;
    while (tiles->dims[2] >> (size.depth + 1) >= BANDS)
        size.depth++;
    while (size.pass < size.depth && row << (size.height + size.pass + 1) <= pass_bytes)
        size.pass++;
    size.layer = size.pass;
    set_size(tiles, size);
    while (tiles->count[1] > 1 && tile_count(tiles) * tile_steps(tiles) * sizeof(int32_t) > TILES_BYTES) {
        size.depth++;
        set_size(tiles, size);
    }
    for (;;) {
        const bool small[2] = {count_entries(b, &bins[0], &size), count_entries(b, &bins[1], &size)};
        if ((small[0] && small[1]) || list_count(tiles) == 1)
            return size;
        if (tiles->layer < tiles->dims[2])
            size.layer++;
        else
            size.height++;
        set_size(tiles, size);
    }
}

/*
 * Sets next[l + 1] to the number of triangles of each list l.  The lists to which a triangle
 * belongs form a rectangle along y and z.  First, +1 or -1 is added to `change` at the four corners
 * of each rectangle, so that `change` contains the differences between neighbouring lists.  The
 * sums of the differences along both axes are the numbers of triangles.  Intermediate values are
 * modulo 2^32.
 */
static void count_lists(const mesh_bins *bins, uint32_t *change, size_t wide, size_t high, const tile_size *size,
                        uint32_t *next)
{
    const size_t row = wide + 1;
    for (size_t n = 0; n < bins->count; n++) {
        const centres r = bins->range[n];
        const size_t y0 = (size_t)(r.y0 >> size->height), y1 = (size_t)(r.y1 >> size->height) + 1;
        const size_t z0 = (size_t)(r.z0 >> size->layer) * row, z1 = ((size_t)(r.z1 >> size->layer) + 1) * row;
        change[z0 + y0]++;
        change[z0 + y1]--;
        change[z1 + y0]--;
        change[z1 + y1]++;
    }
    for (size_t z = 0; z < high; z++)
        for (size_t y = 0, along = 0; y < wide; y++) {
            along += change[z * row + y];
            next[z * wide + y + 1] = (uint32_t)along + (z ? next[(z - 1) * wide + y + 1] : 0);
        }
}

static ost_status bins_make(mesh_bins *bins, const ost_cl_tiles *tiles, const tile_size *size, ost_error *err)
{
    const size_t count = list_count(tiles), wide = (size_t)tiles->count[0], high = count / wide;
    uint32_t *change = calloc((wide + 1) * (high + 1), sizeof *change);
    bins->start = calloc(count + 2, sizeof *bins->start);
    bins->list = malloc(((size_t)bins->entries + 1) * sizeof *bins->list);
    if (!change || !bins->start || !bins->list) {
        free(change);
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for lists of %llu triangles",
                        (unsigned long long)bins->entries);
    }
    /* At first, next[l + 1] is the number of entries of list l. After the sums below, next[l] is the index at which
       list l begins. When the list has been filled, next[l] is the index at which list l ends. */
    uint32_t *next = bins->start + 1;
    count_lists(bins, change, wide, high, size, next);
    free(change);
    for (size_t l = 0; l < count; l++)
        next[l + 1] += next[l];
    for (size_t n = 0; n < bins->count; n++) {
        const centres r = bins->range[n];
        const size_t y0 = (size_t)(r.y0 >> size->height), y1 = (size_t)(r.y1 >> size->height);
        for (size_t z = (size_t)(r.z0 >> size->layer); z <= (size_t)(r.z1 >> size->layer); z++)
            for (size_t list = y0 + wide * z; list <= y1 + wide * z; list++)
                bins->list[next[list]++] = bins->number[n];
    }
    return OST_OK;
}

typedef struct tiled {
    cl_backend *b;
    ost_cl_tiles tiles;
    tile_size size;
    cl_mem steps, marks, counts;
    size_t steps_capacity;
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
    ost_status status = bins_make(bins, &v->tiles, &v->size, err);
    if (status == OST_OK)
        status = ost_cl_buffer(b, sizeof v->tiles, &v->tiles, "voxelization", &tiles, err);
    if (status == OST_OK)
        status = ost_cl_buffer(b, mesh->vertex_count * sizeof mesh->vertices[0], mesh->vertices, "vertices", &vertices,
                               err);
    if (status == OST_OK)
        status = ost_cl_buffer(b, mesh->triangle_count * sizeof mesh->triangles[0], mesh->triangles, "triangles",
                               &triangles, err);
    if (status == OST_OK)
        status = ost_cl_buffer(b, (count + 1) * sizeof *bins->start, bins->start, "triangles of tiles", &start, err);
    if (status == OST_OK)
        status = ost_cl_buffer(b, bins->start[count] * sizeof *bins->list, bins->list, "triangles of tiles", &list,
                               err);
    if (status == OST_OK)
        status = OST_CL_LAUNCH(b, ost_vox_tiles, (size_t)v->tiles.count[0], (size_t)v->tiles.count[1], 1, err,
                               OST_CL_ARG(tiles), OST_CL_ARG(vertices), OST_CL_ARG(triangles), OST_CL_ARG(start),
                               OST_CL_ARG(list), OST_CL_ARG(v->steps), OST_CL_ARG(v->marks), OST_CL_ARG(classes),
                               OST_CL_ARG(v->counts));
    v->tiles.over = 1;
    ost_cl_buffer_free(b, &list);
    ost_cl_buffer_free(b, &start);
    ost_cl_buffer_free(b, &triangles);
    ost_cl_buffer_free(b, &vertices);
    ost_cl_buffer_free(b, &tiles);
    return status;
}

ost_status ost_cl_voxelize_tiles(ost_backend *backend, const ost_snapped_mesh *cutting,
                                 const ost_snapped_mesh *noncutting, ost_fill_rule rule, ost_voxelize_report *report,
                                 ost_tool **out, ost_error *err)
{
    const ost_dims dims = cutting->grid.dims;
    tiled v = {.b = (cl_backend *)backend,
               .tiles = {.dims = {dims.x, dims.y, dims.z}, .fraction = cutting->fraction_bits, .rule = (int32_t)rule}};
    mesh_bins bins[2] = {{.mesh = noncutting, .tool_class = OST_TOOL_NONCUTTING},
                         {.mesh = cutting, .tool_class = OST_TOOL_CUTTING}};
    cl_tool *tool = NULL;
    uint64_t *counts = NULL;
    size_t count = 0;
    ost_status status = OST_OK;
    for (int m = 0; m < 2 && status == OST_OK; m++)
        status = bins_start(&bins[m], v.tiles.fraction, err);
    if (status == OST_OK) {
        v.size = choose_size(v.b, &v.tiles, bins);
        v.b->entered[OST_CL_PATH_LISTS_SHARED] += v.tiles.layer > v.tiles.pass;
        count = tile_count(&v.tiles);
        counts = malloc(3 * count * sizeof *counts);
        if (!counts)
            status = ost_fail(err, OST_ERR_MEMORY, "out of memory for the counts of %zu tiles", count);
    }
    if (status == OST_OK)
        status = ost_cl_tool_create(backend, &cutting->grid, &tool, err);
    if (status == OST_OK)
        status = ost_cl_spare_take(v.b, count * tile_steps(&v.tiles) * sizeof(int32_t), "steps of rows", &v.steps,
                                   &v.steps_capacity, err);
    if (status == OST_OK)
        status = ost_cl_buffer(v.b, count * tile_marks(&v.tiles) * sizeof(uint64_t), NULL, "marks of rows", &v.marks,
                               err);
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
    ost_cl_spare_return(v.b, &v.steps, v.steps_capacity);
    ost_cl_buffer_free(v.b, &v.marks);
    ost_cl_buffer_free(v.b, &v.counts);
    for (int m = 0; m < 2; m++) {
        free(bins[m].vertex);
        free(bins[m].range);
        free(bins[m].number);
        free(bins[m].start);
        free(bins[m].list);
    }
    free(counts);
    return status;
}
