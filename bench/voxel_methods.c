/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Makes the models for the measurements of voxel_methods.h, counts their voxels and measures meshing. These
 * measurements do not use OpenGL. voxel_frames.c measures frames.
 *
 * In this file, a chunk is a block of a surface, because a bone with chunks of 32^3 voxels is divided in the same way.
 * A surface stores its blocks in the order of the grid, so the first k chunks are in the slots 0 to k - 1.
 */
#include "bench/voxel_model.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/inputs.h"
#include "core/face_mesh.h"
#include "render/points/extract.h"

const char *bench_voxel_stage_name(bench_voxel_stage stage)
{
    static const char *const names[BENCH_VOXEL_STAGES] = {"copy to padded chunk", "classify active voxels",
                                                          "prefix sum and compaction", "generate quads",
                                                          "copy to chunk mesh"};
    return names[stage];
}

_Static_assert((int)BENCH_VOXEL_STAGES == (int)OST_FACE_STAGES && (int)BENCH_VOXEL_COPY == (int)OST_FACE_STAGE_COPY,
               "the stages of a measurement are those of a face mesh");

/* ------------------------------------------------------------------- model */

static ost_status make_cubic(bench_voxel_model *m, const bench_options *options, ost_error *err)
{
    ost_backend *backend = NULL;
    ost_status status = bench_backend(options, options->threads, &backend, err);
    if (status == OST_OK)
        status = bench_cubic_make(backend, &m->rect, &m->cubic, err);
    ost_backend_close(backend);
    return status;
}

/* Makes the surface of a volume. The voxels are treated as cubes, because the faces do not depend on the spacing. */
static ost_status make_surface(const ost_volume *volume, ost_surface *surface, ost_error *err)
{
    ost_volume cubes = *volume;
    cubes.geometry.spacing.y = cubes.geometry.spacing.z = cubes.geometry.spacing.x;
    ost_status status = ost_surface_init(surface, &cubes.geometry, err);
    if (status == OST_OK)
        status = ost_surface_set_volume(surface, &cubes, BENCH_VOXEL_THRESHOLD, err);
    return status == OST_OK ? ost_surface_update(surface, err) : status;
}

ost_status bench_voxel_open(const bench_options *options, ost_phantom_kind kind, double scale, bench_voxel_model **out,
                            ost_error *err)
{
    const ost_phantom_options how = {.scale = scale * (options->quick ? 0.25 : 1)};
    bench_voxel_model *m = calloc(1, sizeof *m);
    *out = NULL;
    if (!(scale > 0 && scale <= 1)) {
        free(m);
        return ost_fail(err, OST_ERR_USAGE, "a model of scale %g; expected more than 0 and at most 1", scale);
    }
    if (!m)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a model");
    m->radius = fmax(4, BENCH_VOXEL_RADIUS * how.scale);
    ost_status status = ost_phantom_make(kind, &how, &m->rect, err);
    if (status == OST_OK)
        status = make_cubic(m, options, err);
    if (status == OST_OK)
        status = make_surface(&m->cubic, &m->surface, err);
    if (status == OST_OK && m->surface.used == 0)
        status = ost_fail(err, OST_ERR_RANGE, "the phantom %s has no active voxel at this scale",
                          ost_phantom_name(kind));
    if (status != OST_OK) {
        bench_voxel_close(m);
        return status;
    }
    *out = m;
    return OST_OK;
}

void bench_voxel_close(bench_voxel_model *model)
{
    if (!model)
        return;
    ost_surface_free(&model->surface);
    ost_volume_free(&model->cubic);
    ost_volume_free(&model->rect);
    free(model);
}

int32_t bench_voxel_chunks(const bench_voxel_model *model)
{
    return model->surface.used;
}

/* ------------------------------------------------------------------ counts */

static void count(const ost_surface *s, const ost_geometry *geometry, bench_voxel_grid *out)
{
    *out = (bench_voxel_grid){.geometry = *geometry,
                              .chunks = (int64_t)s->blocks[0] * s->blocks[1] * s->blocks[2],
                              .active_chunks = s->used,
                              .voxels = ost_dims_count(geometry->dims)};
    for (int32_t i = 0; i < s->used; i++) {
        const ost_surface_block *b = s->slot[i];
        for (int row = 0; row < OST_BLOCK_ROWS; row++)
            out->active_voxels += __builtin_popcount(b->occupancy[row]);
        out->surface_voxels += b->count;
        for (uint32_t p = 0; p < b->count; p++)
            out->faces += __builtin_popcount(b->points[p] >> OST_FACES_SHIFT & 63);
    }
    out->voxel_bytes = out->active_chunks * OST_FACE_VOXELS * (int64_t)sizeof(int16_t);
    out->mesh_bytes = out->faces * 4 * (int64_t)sizeof(uint32_t);
    out->look_bytes = out->faces * (int64_t)sizeof(uint32_t);
    out->point_bytes = out->surface_voxels * 2 * (int64_t)sizeof(uint32_t);
}

ost_status bench_voxel_memory(const bench_voxel_model *model, bench_voxel_counts *out, ost_error *err)
{
    ost_surface rect = {0};
    count(&model->surface, &model->cubic.geometry, &out->cubic);
    ost_status status = make_surface(&model->rect, &rect, err);
    if (status == OST_OK)
        count(&rect, &model->rect.geometry, &out->rect);
    ost_surface_free(&rect);
    return status;
}

/* ------------------------------------------------------------------ stages */

static const uint32_t *words_at(const ost_surface *s, int32_t x, int32_t y, int32_t z)
{
    const ost_surface_block *b = ost_surface_block_at(s, x, y, z);
    return b ? b->occupancy : NULL;
}

static ost_face_cluster *clusters_of(const ost_surface *s)
{
    ost_face_cluster *list = calloc((size_t)s->used, sizeof *list);
    for (int32_t i = 0; i < s->used && list; i++) {
        const int32_t *at = s->slot[i]->at, x = at[0], y = at[1], z = at[2];
        list[i] = (ost_face_cluster){.own = s->slot[i]->occupancy,
                                     .neighbour = {words_at(s, x - 1, y, z), words_at(s, x + 1, y, z),
                                                   words_at(s, x, y - 1, z), words_at(s, x, y + 1, z),
                                                   words_at(s, x, y, z - 1), words_at(s, x, y, z + 1)}};
    }
    return list;
}

typedef struct naming {
    const char *spec;
    char *device;
} naming;

static void name_device(const ost_device_info *device, void *user)
{
    const naming *n = user;
    if (strcmp(device->spec, n->spec) == 0)
        snprintf(n->device, BENCH_TEXT, "%.*s", BENCH_TEXT - 1, device->name);
}

/* Writes the name of the device or, for a backend without devices, of the processor. */
static void describe(const ost_backend *backend, bench_voxel_stages *out)
{
    const ost_backend_settings s = ost_backend_settings_get(backend);
    char spec[64];
    ost_error ignored = {0};
    bench_cpu_model(out->device);
    if (s.platform < 0)
        return;
    snprintf(spec, sizeof spec, "cl:platform=%d,device=%d", s.platform, s.device);
    naming n = {spec, out->device};
    for (int i = 0; i < ost_backend_count(); i++) {
        ost_backend_info info;
        if (ost_backend_describe(i, &info, &ignored) == OST_OK && strcmp(info.name, "cl") == 0)
            ost_backend_devices(i, name_device, &n, &ignored);
    }
}

/* The times of one measurement in nanoseconds per chunk. */
typedef struct stage_series {
    bench_series stage[BENCH_VOXEL_STAGES], total, elapsed;
    uint64_t faces;
} stage_series;

/*
 * Meshes all chunks and adds the times of the stages to `ns`. The parameter `some` is the number of chunks per call.
 * The last stage includes copying each chunk's vertices to `own`, a buffer for one chunk.
 */
static ost_status mesh_all(ost_backend *backend, const ost_face_cluster *clusters, int32_t chunks, int32_t some,
                           ost_face_mesh *mesh, uint32_t *own, double ns[BENCH_VOXEL_STAGES], uint64_t *faces,
                           ost_error *err)
{
    ost_status status = OST_OK;
    *faces = 0;
    for (int32_t from = 0; from < chunks && status == OST_OK; from += some) {
        const size_t n = (size_t)(chunks - from < some ? chunks - from : some);
        status = ost_backend_face_mesh(backend, clusters + from, n, mesh, err);
        if (status != OST_OK)
            break;
        *faces += mesh->first[n];
        if (!mesh->timed)
            continue;
        for (int s = 0; s < BENCH_VOXEL_STAGES; s++)
            ns[s] += (double)mesh->stage_ns[s];
        const int64_t begin = bench_now();
        for (size_t i = 0; i < n; i++)
            memcpy(own, mesh->vertices + 4 * (size_t)mesh->first[i],
                   4 * sizeof *own * (size_t)(mesh->first[i + 1] - mesh->first[i]));
        ns[BENCH_VOXEL_COPY] += (double)(bench_now() - begin);
    }
    return status;
}

static ost_status measure(ost_backend *backend, const ost_face_cluster *clusters, int32_t chunks, int32_t some,
                          int repeat, stage_series *series, ost_error *err)
{
    ost_face_mesh mesh = {0};
    uint32_t *own = malloc(4 * sizeof *own * OST_FACE_QUADS_MAX);
    ost_status status = own ? OST_OK : ost_fail(err, OST_ERR_MEMORY, "out of memory for a chunk's mesh");
    /* The first repetition is not counted, because it builds kernels and allocates memory. */
    for (int i = -1; i < repeat && status == OST_OK; i++) {
        double ns[BENCH_VOXEL_STAGES] = {0}, sum = 0;
        mesh.timed = true;
        status = mesh_all(backend, clusters, chunks, some, &mesh, own, ns, &series->faces, err);
        mesh.timed = false;
        const int64_t begin = bench_now();
        if (status == OST_OK)
            status = mesh_all(backend, clusters, chunks, some, &mesh, own, ns, &series->faces, err);
        const int64_t end = bench_now();
        for (int s = 0; s < BENCH_VOXEL_STAGES && i >= 0; s++) {
            bench_series_add(&series->stage[s], ns[s] / chunks);
            sum += ns[s];
        }
        if (i >= 0) {
            bench_series_add(&series->total, sum / chunks);
            bench_series_add(&series->elapsed, (double)(end - begin) / chunks);
        }
    }
    free(own);
    ost_face_mesh_free(&mesh);
    return status;
}

bench_figures bench_voxel_figures(bench_series *series, double unit)
{
    const bench_figures f = {.count = series->count,
                             .median = bench_series_at(series, 0.5) / unit,
                             .min = bench_series_at(series, 0) / unit,
                             .max = bench_series_at(series, 1) / unit};
    bench_series_free(series);
    return f;
}

ost_status bench_voxel_mesh(const bench_voxel_model *model, const char *backend, bool one, int repeat,
                            bench_voxel_stages *out, ost_error *err)
{
    enum { US = 1000 };
    stage_series series = {0};
    ost_backend *b = NULL;
    ost_error why = {0};
    const int32_t chunks = model->surface.used;
    *out = (bench_voxel_stages){.chunks = chunks, .at_a_time = one ? 1 : chunks};
    snprintf(out->backend, sizeof out->backend, "%.*s", BENCH_NAME - 1, backend);
    if (repeat < 1)
        return ost_fail(err, OST_ERR_USAGE, "%d repetitions; expected at least 1", repeat);
    ost_status status = ost_backend_open(backend, &b, &why);
    if (status == OST_ERR_UNAVAILABLE) {
        snprintf(out->reason, sizeof out->reason, "%.*s", BENCH_TEXT - 1, why.text);
        return OST_OK;
    }
    if (status != OST_OK)
        return ost_fail(err, status, "%s", why.text);
    describe(b, out);
    ost_face_cluster *clusters = clusters_of(&model->surface);
    status = clusters ? measure(b, clusters, chunks, out->at_a_time, repeat, &series, &why)
                      : ost_fail(&why, OST_ERR_MEMORY, "out of memory for %d chunks", (int)chunks);
    for (int s = 0; s < BENCH_VOXEL_STAGES; s++)
        out->stage[s] = bench_voxel_figures(&series.stage[s], US);
    out->total = bench_voxel_figures(&series.total, US);
    out->elapsed = bench_voxel_figures(&series.elapsed, US);
    out->faces_per_chunk = (double)series.faces / chunks;
    free(clusters);
    ost_backend_close(b);
    if (status == OST_ERR_UNAVAILABLE) {
        *out = (bench_voxel_stages){.chunks = chunks};
        snprintf(out->reason, sizeof out->reason, "%.*s", BENCH_TEXT - 1, why.text);
        return OST_OK;
    }
    return status == OST_OK ? OST_OK : ost_fail(err, status, "%s", why.text);
}
