/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Uses Embree to find the triangles that may cross the rows of a tile (embree.h).
 *
 *   primitive   GROUP consecutive triangles, as user geometry with the bounds of
 *               all of them, enlarged by a unit on every side
 *   packet      16 rays along x through the centres of 4 x 4 rows
 *   callback    lists the primitive's triangles, once per tile; reports no hit, so
 *               that no ray is ever shortened
 *   kernel      vox_mark processes the listed triangles in the tile's rows
 *
 * No crossing is missed.  Coordinates of vertices and of row centres are integers up to 2^20. The bounds with a unit
 * added, and their differences from a ray's origin, are integers below 2^24. All of these numbers are exact as floats.
 * If a triangle owns a row, the row lies within the triangle's bounds in y and z, and therefore at least a unit inside
 * the enlarged bounds. In x, the ray starts left of all bounds and ends right of them. No scaling or rounding in a slab
 * test changes the signs of these exact differences, so the test finds that the ray is inside. The box of an inner node
 * contains the boxes of its children.
 *
 * No crossing is counted twice.  Several packets of a tile may hit a primitive, and
 * one packet may hit it several times.  The first hit stores the tile's number with
 * the primitive and lists its triangles for all rows of the tile, including rows
 * whose rays have not been cast yet.
 *
 * Embree sets the flush-to-zero mode, also in its tasks, and divides by zero.  The caller may have
 * set a rounding mode or traps.  Therefore every use of Embree first sets the floating-point state
 * with which a process starts, and restores the caller's state afterwards.
 */
#include "config.h"

#include "cpu/voxelize/embree.h"

#if !defined HAVE_EMBREE3 && !defined HAVE_EMBREE4

ost_status ost_embree_available(ost_error *err)
{
    return ost_fail(err, OST_ERR_UNAVAILABLE, "backend cpu: voxelizer=embree: osteon was built without Embree; "
                    "install libembree-dev and build again");
}

ost_status ost_embree_new(const ost_snapped_mesh *mesh, int threads, ost_embree **out, ost_error *err)
{
    (void)mesh;
    (void)threads;
    (void)out;
    return ost_embree_available(err);
}

void ost_embree_free(ost_embree *embree)
{
    (void)embree;
}

ost_embree_scratch *ost_embree_scratch_new(const ost_embree *embree)
{
    (void)embree;
    return NULL;
}

void ost_embree_scratch_free(ost_embree_scratch *scratch)
{
    (void)scratch;
}

void ost_embree_mark(const ost_embree *embree, ost_embree_scratch *scratch, ost_vox_tile *tile, ost_vox_mark_fn *mark)
{
    (void)embree;
    (void)scratch;
    (void)tile;
    (void)mark;
}

#else

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#if defined HAVE_EMBREE4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include "core/conditions.h"
#include "core/floats.h"

enum { GROUP = 4, SIDE = 4, PACKET = SIDE * SIDE, CANDIDATES = 1024 };

struct ost_embree {
    const ost_snapped_mesh *mesh;
    RTCDevice device;
    RTCScene scene;
    size_t primitives;
};

struct ost_embree_scratch {
    /* for each primitive, the number of the last tile whose rays hit the primitive; 0 before the first hit */
    uint32_t *last_tile;
    uint32_t tiles;      /* number of the current tile, counted from 1 in the order of processing */
    ost_vox_tile *tile;
    ost_vox_mark_fn *mark;
    size_t count;
    uint32_t candidates[CANDIDATES + GROUP];
};

/* Embree passes a pointer to its own context to a callback. That context is the first member of this struct, so that
   the callback can convert the pointer to a pointer to this struct. */
typedef struct cast_context {
#if defined HAVE_EMBREE4
    struct RTCRayQueryContext base;
#else
    struct RTCIntersectContext base;
#endif
    ost_embree_scratch *scratch;
} cast_context;

/* ------------------------------------------------------------- hierarchy */

static void bounds_of(const struct RTCBoundsFunctionArguments *args)
{
    const ost_snapped_mesh *mesh = args->geometryUserPtr;
    const size_t first = (size_t)args->primID * GROUP;
    const size_t end = first + GROUP < mesh->triangle_count ? first + GROUP : mesh->triangle_count;
    int32_t lo[3] = {INT32_MAX, INT32_MAX, INT32_MAX}, hi[3] = {INT32_MIN, INT32_MIN, INT32_MIN};
    for (size_t t = first; t < end; t++)
        for (int i = 0; i < 3; i++) {
            const int32_t *v = mesh->vertices[mesh->triangles[t][i]];
            for (int a = 0; a < 3; a++) {
                lo[a] = v[a] < lo[a] ? v[a] : lo[a];
                hi[a] = v[a] > hi[a] ? v[a] : hi[a];
            }
        }
    *args->bounds_o = (struct RTCBounds){.lower_x = (float)(lo[0] - 1),
                                         .lower_y = (float)(lo[1] - 1),
                                         .lower_z = (float)(lo[2] - 1),
                                         .upper_x = (float)(hi[0] + 1),
                                         .upper_y = (float)(hi[1] + 1),
                                         .upper_z = (float)(hi[2] + 1)};
}

static void mark_candidates(ost_embree_scratch *scratch)
{
    scratch->mark(scratch->tile, scratch->candidates, scratch->count);
    scratch->count = 0;
}

static void note_primitive(const struct RTCIntersectFunctionNArguments *args)
{
    ost_embree_scratch *scratch = ((cast_context *)args->context)->scratch;
    if (scratch->last_tile[args->primID] == scratch->tiles)
        return;
    scratch->last_tile[args->primID] = scratch->tiles;
    const ost_snapped_mesh *mesh = args->geometryUserPtr;
    const size_t first = (size_t)args->primID * GROUP;
    for (size_t t = first; t < first + GROUP && t < mesh->triangle_count; t++)
        scratch->candidates[scratch->count++] = (uint32_t)t;
    if (scratch->count > CANDIDATES)
        mark_candidates(scratch);
}

static void build(ost_embree *e)
{
    RTCGeometry geometry = rtcNewGeometry(e->device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, (unsigned int)e->primitives);
    union {
        const ost_snapped_mesh *in;
        void *out;
    } mesh = {.in = e->mesh}; /* The callbacks of Embree take a pointer to non-const, but do not write to the mesh. */
    rtcSetGeometryUserData(geometry, mesh.out);
    rtcSetGeometryBoundsFunction(geometry, bounds_of, NULL);
    rtcSetGeometryIntersectFunction(geometry, note_primitive);
    rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_LOW);
    rtcCommitGeometry(geometry);
    e->scene = rtcNewScene(e->device);
    rtcAttachGeometry(e->scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcSetSceneFlags(e->scene, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(e->scene, RTC_BUILD_QUALITY_LOW);
    rtcCommitScene(e->scene);
}

ost_status ost_embree_available(ost_error *err)
{
    (void)err;
    return OST_OK;
}

ost_status ost_embree_new(const ost_snapped_mesh *mesh, int threads, ost_embree **out, ost_error *err)
{
    char config[60];
    ost_embree *e = calloc(1, sizeof *e);
    if (!e)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for Embree");
    const ost_floats state = ost_floats_enter();
    e->mesh = mesh;
    e->primitives = (mesh->triangle_count + GROUP - 1) / GROUP;
    snprintf(config, sizeof config, "threads=%d,set_affinity=0", threads);
    e->device = rtcNewDevice(config);
    enum RTCError error = e->device ? RTC_ERROR_NONE : rtcGetDeviceError(NULL);
    if (e->device) {
        build(e);
        error = rtcGetDeviceError(e->device);
    }
    ost_floats_leave(state);
    if (!e->device || error != RTC_ERROR_NONE) {
        ost_embree_free(e);
        return error == RTC_ERROR_OUT_OF_MEMORY
                   ? ost_fail(err, OST_ERR_MEMORY, "Embree: out of memory for %zu triangles",
                              mesh->triangle_count) : ost_fail(err, OST_ERR_UNAVAILABLE,
                              "Embree cannot start (error %d)", (int)error);
    }
    *out = e;
    return OST_OK;
}

void ost_embree_free(ost_embree *e)
{
    if (!e)
        return;
    const ost_floats state = ost_floats_enter();
    if (e->scene)
        rtcReleaseScene(e->scene);
    if (e->device)
        rtcReleaseDevice(e->device);
    ost_floats_leave(state);
    free(e);
}

/* ------------------------------------------------------------------ rays */

ost_embree_scratch *ost_embree_scratch_new(const ost_embree *embree)
{
    ost_embree_scratch *scratch = calloc(1, sizeof *scratch);
    if (scratch)
        scratch->last_tile = calloc(embree->primitives + 1, sizeof *scratch->last_tile);
    if (scratch && !scratch->last_tile) {
        free(scratch);
        scratch = NULL;
    }
    return scratch;
}

void ost_embree_scratch_free(ost_embree_scratch *scratch)
{
    if (!scratch)
        return;
    free(scratch->last_tile);
    free(scratch);
}

/* Casts a ray through each row (j, k) with j0 <= j < j0 + SIDE and k0 <= k < k0 + SIDE that belongs to the tile. */
static void cast(const ost_embree *e, ost_embree_scratch *scratch, int32_t j0, int32_t k0)
{
    const ost_vox_tile *tile = scratch->tile;
    const int32_t half = 1 << (tile->f - 1);
    int valid[PACKET] __attribute__((aligned(64)));
    struct RTCRayHit16 rays __attribute__((aligned(64)));
    cast_context c = {.scratch = scratch};
    memset(&rays, 0, sizeof rays);
    for (int r = 0; r < PACKET; r++) {
        const int32_t j = j0 + r % SIDE, k = k0 + r / SIDE;
        valid[r] = j < tile->j1 && k < tile->k1 ? -1 : 0;
        rays.ray.org_x[r] = -4;
        rays.ray.org_y[r] = (float)((j << tile->f) + half);
        rays.ray.org_z[r] = (float)((k << tile->f) + half);
        rays.ray.dir_x[r] = 1;
        rays.ray.tfar[r] = 1 << 22;
        rays.ray.mask[r] = UINT32_MAX;
        rays.ray.id[r] = (unsigned int)r;
        rays.hit.geomID[r] = RTC_INVALID_GEOMETRY_ID;
        rays.hit.instID[0][r] = RTC_INVALID_GEOMETRY_ID;
    }
#if defined HAVE_EMBREE4
    struct RTCIntersectArguments arguments;
    rtcInitRayQueryContext(&c.base);
    rtcInitIntersectArguments(&arguments);
    arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
    arguments.context = &c.base;
    rtcIntersect16(valid, e->scene, &rays, &arguments);
#else
    rtcInitIntersectContext(&c.base);
    c.base.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    rtcIntersect16(valid, e->scene, &c.base, &rays);
#endif
}

void ost_embree_mark(const ost_embree *e, ost_embree_scratch *scratch, ost_vox_tile *tile, ost_vox_mark_fn *mark)
{
    scratch->tile = tile;
    scratch->mark = mark;
    /* `tiles` cannot overflow, because a grid has at most 2^24 rows and therefore at most 2^24 tiles. */
    scratch->tiles++;
    for (int32_t k = tile->k0; k < tile->k1; k += SIDE)
        for (int32_t j = tile->j0; j < tile->j1; j += SIDE)
            cast(e, scratch, j, k);
    mark_candidates(scratch);
}

#endif
