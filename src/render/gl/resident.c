/* SPDX-License-Identifier: Apache-2.0 */
#include "render/gl/resident.h"

#include <stdlib.h>
#include <string.h>

#include "core/clock.h"
#include "render/points/extract.h"

enum { BLOCK_VOXELS = OST_BLOCK * OST_BLOCK * OST_BLOCK, BRICKS = 512, ACTIVE = 1000 };

typedef struct brick {
    uint32_t index, low, high, first;
} brick;

void ost_gl_store_init(ost_gl_store *store)
{
    memset(store, 0, sizeof *store);
    ost_gl_pool_init(&store->points, "surface voxels", 2 * sizeof(uint32_t), 8, GL_RG32UI);
    ost_gl_pool_init(&store->bricks, "bricks", sizeof(brick), 5, 0);
    ost_gl_pool_init(&store->shades, "surface voxels", sizeof(uint32_t), 8, GL_R32UI);
    ost_gl_pool_init(&store->voxels, "voxels", sizeof(int16_t), 15, 0);
    ost_gl_pool_init(&store->quads, "visible faces", 4 * sizeof(uint32_t), OST_GL_QUAD_BITS, 0);
}

static void forget(ost_gl_store *store, ost_gl_resident *r)
{
    for (int form = 0; form < OST_GL_FORMS; form++) {
        for (int32_t i = 0; i < r->runs[form]; i++) {
            const ost_gl_run *run = &r->run[form][i];
            if (run->granules)
                ost_gl_pool_give(ost_gl_store_pool(store, (ost_gl_form)form), run->first, run->granules);
            if (run->shade_granules)
                ost_gl_pool_give(&store->shades, run->shade_first, run->shade_granules);
        }
        free(r->run[form]);
    }
    if (r->mesh)
        glDeleteBuffers(1, &r->mesh);
    *r = (ost_gl_resident){0};
}

void ost_gl_store_free(ost_gl_store *store)
{
    for (int i = 0; i < OST_GL_RESIDENTS; i++)
        forget(store, &store->resident[i]);
    ost_gl_pool_free(&store->points);
    ost_gl_pool_free(&store->bricks);
    ost_gl_pool_free(&store->shades);
    ost_gl_pool_free(&store->voxels);
    ost_gl_pool_free(&store->quads);
    ost_gl_store_abandon(store);
}

void ost_gl_store_abandon(ost_gl_store *store)
{
    for (int i = 0; i < OST_GL_RESIDENTS; i++)
        for (int form = 0; form < OST_GL_FORMS; form++)
            free(store->resident[i].run[form]);
    memset(store->resident, 0, sizeof store->resident);
    ost_gl_pool_abandon(&store->points);
    ost_gl_pool_abandon(&store->bricks);
    ost_gl_pool_abandon(&store->shades);
    ost_gl_pool_abandon(&store->voxels);
    ost_gl_pool_abandon(&store->quads);
    ost_face_mesh_free(&store->mesh);
    free(store->clusters);
    free(store->slots);
    store->clusters = NULL;
    store->slots = NULL;
    store->cluster_capacity = 0;
}

ost_gl_pool *ost_gl_store_pool(ost_gl_store *store, ost_gl_form form)
{
    ost_gl_pool *const pools[OST_GL_FORMS] = {&store->points, &store->bricks, &store->voxels, &store->quads};
    return pools[form];
}

/* Returns the surface's entry. If there is none, clears and returns a free entry or, if no entry is free, the least
 * recently used entry. */
static ost_gl_resident *resident_of(ost_gl_store *store, const ost_surface *surface)
{
    ost_gl_resident *oldest = &store->resident[0];
    for (int i = 0; i < OST_GL_RESIDENTS; i++) {
        ost_gl_resident *r = &store->resident[i];
        if (r->surface == surface) {
            r->last = store->frame;
            return r;
        }
        if (!r->surface ? oldest->surface != NULL : oldest->surface && r->last < oldest->last)
            oldest = r;
    }
    forget(store, oldest);
    oldest->surface = surface;
    oldest->last = store->frame;
    return oldest;
}

/* ------------------------------------------------------------------- forms */

/* Reserves a run for `count` elements. Keeps the current run if it is large enough. */
static ost_status reserve(ost_gl_context *c, ost_gl_pool *pool, uint32_t count, uint32_t *first, uint32_t *granules,
                          ost_error *err)
{
    if ((uint64_t)*granules << pool->bits >= count)
        return OST_OK;
    if (*granules)
        ost_gl_pool_give(pool, *first, *granules);
    *granules = 0;
    return ost_gl_pool_take(c, pool, count, first, granules, err);
}

static ost_status bring_points(ost_gl_context *c, ost_gl_store *store, const ost_surface_block *b, ost_gl_run *run,
                               ost_error *err)
{
    uint32_t pair[2 * 256];
    ost_status status = reserve(c, &store->points, b->count, &run->first, &run->granules, err);
    for (uint32_t i = 0; i < b->count && status == OST_OK; i += 256) {
        const uint32_t count = b->count - i < 256 ? b->count - i : 256;
        for (uint32_t k = 0; k < count; k++) {
            pair[2 * k] = b->points[i + k];
            pair[2 * k + 1] = b->shades[i + k];
        }
        ost_gl_pool_write(&store->points, run->first + i, pair, count);
    }
    run->count = b->count;
    store->uploaded += b->count * sizeof(uint64_t);
    return status;
}

/* Returns the index of the brick that contains a point. */
static uint32_t brick_of(uint32_t p)
{
    return (p >> 2 & 7) | (p >> 7 & 7) << 3 | (p >> 12 & 7) << 6;
}

static uint32_t cell_of(uint32_t p)
{
    return (p & 3) | (p >> 5 & 3) << 2 | (p >> 10 & 3) << 4;
}

static ost_status bring_bricks(ost_gl_context *c, ost_gl_store *store, const ost_surface_block *b, ost_gl_run *run,
                               ost_error *err)
{
    uint64_t mask[BRICKS] = {0};
    uint32_t first[BRICKS], used = 0, shades = 0;
    brick list[BRICKS];
    uint32_t *sorted = malloc((b->count + 1) * sizeof *sorted);
    if (!sorted)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for the bricks of %u voxels", (unsigned)b->count);
    for (uint32_t i = 0; i < b->count; i++)
        mask[brick_of(b->points[i])] |= UINT64_C(1) << cell_of(b->points[i]);
    ost_status status = reserve(c, &store->shades, b->count, &run->shade_first, &run->shade_granules, err);
    for (uint32_t k = 0; k < BRICKS; k++) {
        first[k] = shades;
        if (mask[k])
            list[used++] = (brick){k, (uint32_t)mask[k], (uint32_t)(mask[k] >> 32), run->shade_first + shades};
        shades += (uint32_t)__builtin_popcountll(mask[k]);
    }
    for (uint32_t i = 0; i < b->count; i++) {
        const uint32_t k = brick_of(b->points[i]), cell = cell_of(b->points[i]);
        sorted[first[k] + (uint32_t)__builtin_popcountll(mask[k] & ((UINT64_C(1) << cell) - 1))] = b->shades[i];
    }
    if (status == OST_OK)
        status = reserve(c, &store->bricks, used, &run->first, &run->granules, err);
    if (status == OST_OK) {
        ost_gl_pool_write(&store->shades, run->shade_first, sorted, b->count);
        ost_gl_pool_write(&store->bricks, run->first, list, used);
    }
    run->count = used;
    store->uploaded += b->count * sizeof *sorted + used * sizeof *list;
    free(sorted);
    return status;
}

static ost_status bring_voxels(ost_gl_context *c, ost_gl_store *store, const ost_surface_block *b, ost_gl_run *run,
                               ost_error *err)
{
    ost_status status = reserve(c, &store->voxels, BLOCK_VOXELS, &run->first, &run->granules, err);
    for (uint32_t row = 0; row < OST_BLOCK_ROWS && status == OST_OK; row++) {
        int16_t density[OST_BLOCK];
        for (uint32_t x = 0; x < OST_BLOCK; x++)
            density[x] = b->occupancy[row] >> x & 1 ? ACTIVE : 0;
        ost_gl_pool_write(&store->voxels, run->first + OST_BLOCK * row, density, OST_BLOCK);
    }
    run->count = BLOCK_VOXELS;
    store->uploaded += BLOCK_VOXELS * sizeof(int16_t);
    return status;
}

static void find_cells(const ost_surface_block *b, ost_gl_run *run)
{
    memset(run->bricks, 0, sizeof run->bricks);
    run->cells = 0;
    for (uint32_t i = 0; i < b->count; i++) {
        const uint32_t k = brick_of(b->points[i]);
        run->bricks[k >> 6] |= UINT64_C(1) << (k & 63);
        run->cells |= UINT64_C(1) << ost_gl_cell_of_brick(k);
    }
}

static ost_status reserve_slots(ost_gl_resident *r, ost_gl_form form, int32_t slots, ost_error *err)
{
    if (slots <= r->runs[form])
        return OST_OK;
    ost_gl_run *run = realloc(r->run[form], (size_t)slots * sizeof *run);
    if (!run)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %d blocks of a surface", (int)slots);
    memset(run + r->runs[form], 0, (size_t)(slots - r->runs[form]) * sizeof *run);
    r->run[form] = run;
    r->runs[form] = slots;
    return OST_OK;
}

ost_status ost_gl_store_bring(ost_gl_context *context, ost_gl_store *store, const ost_surface *surface,
                              ost_gl_form form, ost_gl_resident **out, ost_error *err)
{
    ost_gl_resident *r = *out = resident_of(store, surface);
    ost_gl_pool *pool = ost_gl_store_pool(store, form);
    ost_status status = reserve_slots(r, form, surface->used, err);
    for (int32_t i = 0; i < surface->used && status == OST_OK; i++) {
        const ost_surface_block *b = surface->slot[i];
        ost_gl_run *run = &r->run[form][i];
        if (run->version == b->version)
            continue;
        status = form == OST_GL_POINTS   ? bring_points(context, store, b, run, err)
                 : form == OST_GL_BRICKS ? bring_bricks(context, store, b, run, err)
                                         : bring_voxels(context, store, b, run, err);
        const int32_t voxel[3] = {OST_BLOCK * b->at[0], OST_BLOCK * b->at[1], OST_BLOCK * b->at[2]};
        find_cells(b, run);
        if (status == OST_OK)
            ost_gl_pool_place(pool, run->first, run->granules, voxel, 0);
        run->hidden = 0;
        run->version = status == OST_OK ? b->version : 0;
    }
    return status;
}

/* ------------------------------------------------------------------- quads */

static ost_status reserve_clusters(ost_gl_store *store, int32_t count, ost_error *err)
{
    if (count <= store->cluster_capacity)
        return OST_OK;
    const int32_t capacity = count + count / 2;
    ost_face_cluster *clusters = realloc(store->clusters, (size_t)capacity * sizeof *clusters);
    if (clusters)
        store->clusters = clusters;
    int32_t *slots = realloc(store->slots, (size_t)capacity * sizeof *slots);
    if (slots)
        store->slots = slots;
    if (!clusters || !slots)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for the meshes of %d blocks", (int)capacity);
    store->cluster_capacity = capacity;
    return OST_OK;
}

/* Returns the occupancy of the block at (x, y, z), or NULL if there is no such block. */
static const uint32_t *words_at(const ost_surface *s, int32_t x, int32_t y, int32_t z)
{
    const ost_surface_block *b = ost_surface_block_at(s, x, y, z);
    return b ? b->occupancy : NULL;
}

static ost_face_cluster cluster_of(const ost_surface *s, const int32_t at[3])
{
    const int32_t x = at[0], y = at[1], z = at[2];
    return (ost_face_cluster){.own = words_at(s, x, y, z),
                              .neighbour = {words_at(s, x - 1, y, z), words_at(s, x + 1, y, z),
                                            words_at(s, x, y - 1, z), words_at(s, x, y + 1, z),
                                            words_at(s, x, y, z - 1), words_at(s, x, y, z + 1)}};
}

/* Makes the quads of all blocks whose visible faces have changed, in one call of the mesher. */
static ost_status mesh_changed(ost_gl_context *c, ost_gl_store *store, const ost_surface *s, ost_gl_run *runs,
                               ost_error *err)
{
    int32_t n = 0;
    ost_status status = reserve_clusters(store, s->used, err);
    for (int32_t i = 0; i < s->used && status == OST_OK; i++)
        if (runs[i].listed != s->slot[i]->listed) {
            store->clusters[n] = cluster_of(s, s->slot[i]->at);
            store->slots[n++] = i;
        }
    if (status != OST_OK || n == 0)
        return status;
    const int64_t begin = ost_clock_ns();
    status = ost_backend_face_mesh(store->mesher, store->clusters, (size_t)n, &store->mesh, err);
    const int64_t made = ost_clock_ns();
    for (int32_t i = 0; i < n && status == OST_OK; i++) {
        ost_gl_run *run = &runs[store->slots[i]];
        const uint32_t first = store->mesh.first[i], count = store->mesh.first[i + 1] - first;
        run->listed = 0;
        status = reserve(c, &store->quads, count, &run->first, &run->granules, err);
        if (status != OST_OK)
            break;
        if (count)
            ost_gl_pool_write(&store->quads, run->first, store->mesh.vertices + 4 * (size_t)first, count);
        run->count = count;
        run->listed = s->slot[store->slots[i]]->listed;
        run->version = 0; /* the shades must be written again */
        store->uploaded += count * 4 * sizeof(uint32_t);
    }
    store->meshed += (uint32_t)n;
    store->mesh_ns += made - begin;
    store->copy_ns += ost_clock_ns() - made;
    return status;
}

/*
 * Writes the shades of a block's faces. The shade of a face is that of its voxel. The voxels of points and quads are in
 * the same order.
 */
static ost_status bring_face_shades(ost_gl_context *c, ost_gl_store *store, const ost_surface_block *b, ost_gl_run *run,
                                    ost_error *err)
{
    uint32_t list[256 + 6], n = 0, written = 0, faces = 0;
    for (uint32_t i = 0; i < b->count; i++)
        faces += (uint32_t)__builtin_popcount(b->points[i] >> OST_FACES_SHIFT & 63);
    if (faces != run->count)
        return ost_fail(err, OST_ERR_INTERNAL, "a block has %u visible faces and %u quads", (unsigned)faces,
                        (unsigned)run->count);
    ost_status status = reserve(c, &store->shades, faces, &run->shade_first, &run->shade_granules, err);
    for (uint32_t i = 0; i < b->count && status == OST_OK; i++) {
        for (uint32_t left = b->points[i] >> OST_FACES_SHIFT & 63; left; left &= left - 1)
            list[n++] = b->shades[i];
        if (n >= 256 || i + 1 == b->count) {
            ost_gl_pool_write(&store->shades, run->shade_first + written, list, n);
            written += n;
            n = 0;
        }
    }
    store->uploaded += faces * sizeof *list;
    return status;
}

ost_status ost_gl_store_bring_quads(ost_gl_context *context, ost_gl_store *store, const ost_surface *surface,
                                    ost_gl_resident **out, ost_error *err)
{
    ost_gl_resident *r = *out = resident_of(store, surface);
    if (!store->mesher)
        return ost_fail(err, OST_ERR_USAGE, "the mesh renderer needs a backend that makes meshes");
    ost_status status = reserve_slots(r, OST_GL_QUADS, surface->used, err);
    if (status == OST_OK)
        status = mesh_changed(context, store, surface, r->run[OST_GL_QUADS], err);
    const int64_t begin = ost_clock_ns();
    for (int32_t i = 0; i < surface->used && status == OST_OK; i++) {
        const ost_surface_block *b = surface->slot[i];
        ost_gl_run *run = &r->run[OST_GL_QUADS][i];
        if (run->version == b->version)
            continue;
        run->version = 0;
        status = bring_face_shades(context, store, b, run, err);
        const int32_t voxel[3] = {OST_BLOCK * b->at[0], OST_BLOCK * b->at[1], OST_BLOCK * b->at[2]};
        if (status != OST_OK)
            break;
        ost_gl_pool_place(&store->quads, run->first, run->granules, voxel, (int32_t)(run->shade_first - run->first));
        run->version = b->version;
    }
    store->copy_ns += ost_clock_ns() - begin;
    return status;
}

/* -------------------------------------------------------------------- mesh */

typedef struct vertex {
    float at[3], out[3];
} vertex;

/* Appends the two triangles of one face of the voxel whose centre is (x, y, z). */
static void add_face(vertex *v, const float at[3], unsigned face)
{
    static const int corner[6][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, -1}, {1, 1}, {-1, 1}};
    const unsigned axis = face / 2, j = (axis + 1) % 3, k = (axis + 2) % 3;
    for (int i = 0; i < 6; i++) {
        v[i] = (vertex){{at[0], at[1], at[2]}, {0, 0, 0}};
        v[i].out[axis] = face % 2 ? 1 : -1;
        v[i].at[axis] += 0.5f * v[i].out[axis];
        v[i].at[j] += 0.5f * (float)corner[i][0];
        v[i].at[k] += 0.5f * (float)corner[i][1];
    }
}

ost_status ost_gl_store_bring_mesh(ost_gl_context *context, ost_gl_store *store, const ost_surface *surface,
                                   ost_gl_resident **out, ost_error *err)
{
    ost_gl_resident *r = *out = resident_of(store, surface);
    uint64_t version = 1;
    size_t faces = 0;
    for (int32_t i = 0; i < surface->used; i++) {
        const ost_surface_block *b = surface->slot[i];
        version += b->version;
        for (uint32_t p = 0; p < b->count; p++)
            faces += (size_t)__builtin_popcount(b->points[p] >> OST_FACES_SHIFT & 63);
    }
    if (r->mesh && r->mesh_version == version)
        return OST_OK;
    vertex *list = malloc((6 * faces + 1) * sizeof *list);
    if (!list)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for the %zu faces of a tool", faces);
    size_t n = 0;
    for (int32_t i = 0; i < surface->used; i++) {
        const ost_surface_block *b = surface->slot[i];
        for (uint32_t p = 0; p < b->count; p++) {
            const uint32_t w = b->points[p];
            const float at[3] = {(float)(OST_BLOCK * b->at[0] + (int)(w & 31)),
                                 (float)(OST_BLOCK * b->at[1] + (int)(w >> 5 & 31)),
                                 (float)(OST_BLOCK * b->at[2] + (int)(w >> 10 & 31))};
            for (unsigned face = 0; face < 6; face++)
                if (w >> (OST_FACES_SHIFT + face) & 1) {
                    add_face(list + n, at, face);
                    n += 6;
                }
        }
    }
    if (!r->mesh)
        glGenBuffers(1, &r->mesh);
    glBindBuffer(GL_ARRAY_BUFFER, r->mesh);
    glBufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(n * sizeof *list), list, GL_STATIC_DRAW);
    free(list);
    r->mesh_version = version;
    r->mesh_vertices = (uint32_t)n;
    store->uploaded += n * sizeof *list;
    return ost_gl_context_check(context, "takes a tool's triangles", err);
}
