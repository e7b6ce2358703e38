/* SPDX-License-Identifier: Apache-2.0 */
#include "config.h"

#include "bench/baseline_embree.h"

#if !defined HAVE_EMBREE3 && !defined HAVE_EMBREE4
int64_t ost_baseline_embree(const ost_snapped_mesh *mesh, int threads, bool low_quality, uint64_t *bits,
                            ost_baseline_embree_times *times)
{
    (void)mesh;
    (void)threads;
    (void)low_quality;
    (void)bits;
    (void)times;
    return -1;
}
#else

#include <stddef.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#if defined HAVE_EMBREE4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

enum { SIDE = 4, PACKET = SIDE * SIDE };

/* The first member is Embree's own context. A filter receives a pointer to that member and converts
   it to a pointer to this struct. */
typedef struct packet_context {
#if defined HAVE_EMBREE4
    struct RTCRayQueryContext base;
#else
    struct RTCIntersectContext base;
#endif
    uint64_t *row[PACKET];
    int32_t n;
    float half, per_voxel;
} packet_context;

static double now_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec * 1e3 + (double)t.tv_nsec * 1e-6;
}

/* Indices of two fields of a ray packet. A packet of N rays consists of one array of N elements per
   field, in the order of RTCRay16. The indices are defined here because Embree's accessors exist only
   for C++. */
enum { RAY_TFAR = 8, RAY_ID = 10 };

/* For each hit, toggles the bit of the first voxel whose centre lies beyond the hit on the ray. Rejects the hit,
   so that the ray continues. */
static void note_hit(const struct RTCFilterFunctionNArguments *args)
{
    const packet_context *c = (const packet_context *)args->context;
    for (unsigned int r = 0; r < args->N; r++) {
        if (args->valid[r] != -1)
            continue;
        args->valid[r] = 0;
        const float x = ((const float *)args->ray)[RAY_TFAR * args->N + r] - 1.0f; /* rays start at x = -1 */
        int32_t i = (int32_t)((x - c->half) * c->per_voxel + 1.0f);
        const unsigned int lane = ((const unsigned int *)args->ray)[RAY_ID * args->N + r];
        if (i >= 0 && i < c->n)
            c->row[lane][i / 64] ^= UINT64_C(1) << (i % 64);
    }
}

static uint64_t running_parity(uint64_t x)
{
    x ^= x << 1;
    x ^= x << 2;
    x ^= x << 4;
    x ^= x << 8;
    x ^= x << 16;
    return x ^ x << 32;
}

static int64_t fill(uint64_t *row, int words)
{
    uint64_t carry = 0;
    int64_t count = 0;
    for (int w = 0; w < words; w++) {
        row[w] = row[w] ? running_parity(row[w]) ^ carry : carry;
        carry = -(row[w] >> 63);
        count += row[w] ? __builtin_popcountll(row[w]) : 0;
    }
    return count;
}

static RTCScene make_scene(RTCDevice device, const ost_snapped_mesh *mesh, bool low_quality)
{
    RTCScene scene = rtcNewScene(device);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    float *v = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof *v,
                                       mesh->vertex_count);
    unsigned int *t = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof *t,
                                              mesh->triangle_count);
    if (!v || !t)
        return scene;
    for (size_t i = 0; i < mesh->vertex_count; i++)
        for (int a = 0; a < 3; a++)
            v[3 * i + (size_t)a] = (float)mesh->vertices[i][a];
    memcpy(t, mesh->triangles, mesh->triangle_count * sizeof *mesh->triangles);
    rtcSetGeometryIntersectFilterFunction(geometry, note_hit);
    rtcSetGeometryBuildQuality(geometry, low_quality ? RTC_BUILD_QUALITY_LOW : RTC_BUILD_QUALITY_MEDIUM);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST); /* no filter flag is needed, because the geometry has the filter */
    rtcSetSceneBuildQuality(scene, low_quality ? RTC_BUILD_QUALITY_LOW : RTC_BUILD_QUALITY_MEDIUM);
    rtcCommitScene(scene);
    return scene;
}

/* Traces a packet of 4 x 4 rays, one per row. A measurement showed that a packet for sixteen rows of
   one slice is slower, because its rays diverge sooner. */
static void trace_packet(RTCScene scene, const ost_snapped_mesh *mesh, int32_t j0, int32_t k0, int words,
                         uint64_t *bits)
{
    const ost_dims dims = mesh->grid.dims;
    const int f = mesh->fraction_bits;
    int valid[PACKET] __attribute__((aligned(64)));
    struct RTCRayHit16 rays __attribute__((aligned(64)));
    packet_context c = {.n = dims.x, .half = (float)(1 << (f - 1)), .per_voxel = 1.0f / (float)(1 << f)};
#if defined HAVE_EMBREE4
    struct RTCIntersectArguments arguments;
    rtcInitRayQueryContext(&c.base);
    rtcInitIntersectArguments(&arguments);
    arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
    arguments.context = &c.base;
#else
    rtcInitIntersectContext(&c.base);
    c.base.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
#endif
    for (int r = 0; r < PACKET; r++) {
        const int32_t j = j0 + r % SIDE, k = k0 + r / SIDE;
        valid[r] = j < dims.y && k < dims.z ? -1 : 0;
        c.row[r] = bits + ((size_t)k * (size_t)dims.y + (size_t)j) * (size_t)words;
        rays.ray.org_x[r] = -1.0f;
        rays.ray.org_y[r] = (float)((j << f) + (1 << (f - 1)));
        rays.ray.org_z[r] = (float)((k << f) + (1 << (f - 1)));
        rays.ray.tnear[r] = 0.0f;
        rays.ray.dir_x[r] = 1.0f;
        rays.ray.dir_y[r] = rays.ray.dir_z[r] = 0.0f;
        rays.ray.time[r] = 0.0f;
        rays.ray.tfar[r] = 4e6f;
        rays.ray.mask[r] = UINT32_MAX;
        rays.ray.id[r] = (unsigned int)r;
        rays.ray.flags[r] = 0;
        rays.hit.geomID[r] = RTC_INVALID_GEOMETRY_ID;
        rays.hit.instID[0][r] = RTC_INVALID_GEOMETRY_ID;
    }
#if defined HAVE_EMBREE4
    rtcIntersect16(valid, scene, &rays, &arguments);
#else
    rtcIntersect16(valid, scene, &c.base, &rays);
#endif
}

int64_t ost_baseline_embree(const ost_snapped_mesh *mesh, int threads, bool low_quality, uint64_t *bits,
                            ost_baseline_embree_times *times)
{
    const ost_dims dims = mesh->grid.dims;
    const int words = (dims.x + 63) / 64;
    char config[40];
    snprintf(config, sizeof config, "threads=%d", threads);
    RTCDevice device = rtcNewDevice(config);
    if (!device)
        return -1;
    const double t0 = now_ms();
    RTCScene scene = make_scene(device, mesh, low_quality);
    const double t1 = now_ms();
    int64_t solid = 0;
    if (rtcGetDeviceError(device) != RTC_ERROR_NONE) {
        solid = -1;
    } else {
#pragma omp parallel for num_threads(threads) schedule(dynamic, 1) reduction(+ : solid)
        for (int32_t k = 0; k < dims.z; k += SIDE) {
            const size_t rows = (size_t)dims.y * (size_t)(dims.z - k < SIDE ? dims.z - k : SIDE);
            uint64_t *slab = bits + (size_t)k * (size_t)dims.y * (size_t)words;
            memset(slab, 0, rows * (size_t)words * sizeof *slab);
            for (int32_t j = 0; j < dims.y; j += SIDE)
                trace_packet(scene, mesh, j, k, words, bits);
            for (size_t r = 0; r < rows; r++)
                solid += fill(slab + r * (size_t)words, words);
        }
    }
    *times = (ost_baseline_embree_times){.build_ms = t1 - t0, .trace_ms = now_ms() - t1};
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
    return solid;
}
#endif
