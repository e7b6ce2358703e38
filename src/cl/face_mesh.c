/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Face meshes on a device (core/face_mesh.h). The program kernels/face_mesh.cl is built at the first call.
 *
 *   host    words of a chunk, one layer of each neighbour --write-->
 *   device  34^3 values --> masks --> prefix sums, active voxels --sums of each chunk, read-->
 *   host    buffer for all vertices
 *   device  vertices --read--> host
 *
 * A batch has at most BATCH chunks, which limits the buffers on the device to about 17 MB without the vertices.
 */
#include "cl/objects.h"

#include <stdlib.h>
#include <string.h>

#include "cl/embedded.h"
#include "core/clock.h"

enum {
    BATCH = 64,
    SIDE = OST_FACE_CHUNK,
    LAYERS = 6 * SIDE,
    CLUSTER = OST_FACE_ROWS + LAYERS, /* words of a cluster */
    PADDED = OST_FACE_PADDED * OST_FACE_PADDED * OST_FACE_PADDED,
    GROUP = 64,
};

enum { PAD, CLASSIFY, ROWS, SLICES, COMPACT, QUADS, KERNELS };
static const char *const names[KERNELS] = {"ost_face_pad",    "ost_face_classify", "ost_face_rows",
                                           "ost_face_slices", "ost_face_compact",  "ost_face_quads"};

struct ost_cl_face_program {
    cl_program program;
    cl_kernel kernel[KERNELS];
    size_t group[KERNELS];
    cl_mem clusters, padded, visible, rows, slices, active, sums, first, vertices;
    size_t chunks, quads; /* capacity of the buffers, in chunks and in quads */
    uint32_t words[BATCH * CLUSTER];
};
typedef struct ost_cl_face_program faces;

static void free_buffers(cl_backend *b, faces *f)
{
    cl_mem *const all[] = {&f->clusters, &f->padded, &f->visible, &f->rows,
                           &f->slices,   &f->active, &f->sums,    &f->first};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++)
        ost_cl_buffer_free(b, all[i]);
    f->chunks = 0;
}

void ost_cl_face_free(cl_backend *b)
{
    faces *f = b->faces;
    if (!f)
        return;
    /* Waits even after an error, because a transfer from f->words may not have ended. */
    b->cl->clFinish(b->queue);
    free_buffers(b, f);
    ost_cl_buffer_free(b, &f->vertices);
    for (int k = 0; k < KERNELS; k++)
        if (f->kernel[k])
            b->cl->clReleaseKernel(f->kernel[k]);
    if (f->program)
        b->cl->clReleaseProgram(f->program);
    free(f);
    b->faces = NULL;
}

static ost_status make_kernels(cl_backend *b, faces *f, ost_error *err)
{
    bool from_cache;
    ost_status status = ost_cl_build(b, ost_cl_face_mesh_source, ost_cl_face_mesh_source_count, "-cl-std=CL1.2",
                                     &f->program, &from_cache, err);
    for (int k = 0; k < KERNELS && status == OST_OK; k++) {
        cl_int code = CL_SUCCESS;
        size_t most = 0;
        f->kernel[k] = b->cl->clCreateKernel(f->program, names[k], &code);
        if (!f->kernel[k] || code != CL_SUCCESS)
            return ost_cl_fail(err, b->device.name, code, "clCreateKernel", names[k]);
        code = b->cl->clGetKernelWorkGroupInfo(f->kernel[k], b->device.id, CL_KERNEL_WORK_GROUP_SIZE, sizeof most,
                                               &most, NULL);
        if (code != CL_SUCCESS)
            return ost_cl_fail(err, b->device.name, code, "clGetKernelWorkGroupInfo", names[k]);
        const size_t wanted = b->workgroup ? b->workgroup : GROUP;
        f->group[k] = wanted < most ? wanted : most ? most : 1;
    }
    return status;
}

static ost_status open_faces(cl_backend *b, ost_error *err)
{
    if (b->faces)
        return OST_OK;
    b->faces = calloc(1, sizeof *b->faces);
    if (!b->faces)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for the meshes of backend cl");
    ost_status status = make_kernels(b, b->faces, err);
    if (status != OST_OK)
        ost_cl_face_free(b);
    return status;
}

static ost_status reserve_chunks(cl_backend *b, faces *f, size_t chunks, ost_error *err)
{
    if (chunks <= f->chunks)
        return OST_OK;
    free_buffers(b, f);
    const size_t pair = 2 * sizeof(uint32_t);
    const struct {
        cl_mem *buffer;
        size_t bytes;
    } list[] = {
        {&f->clusters, CLUSTER * sizeof(uint32_t)},
        {&f->padded, PADDED * sizeof(int16_t)},
        {&f->visible, OST_FACE_VOXELS},
        {&f->rows, OST_FACE_ROWS * pair},
        {&f->slices, SIDE * pair},
        {&f->active, OST_FACE_VOXELS * pair},
        {&f->sums, pair},
        {&f->first, sizeof(uint32_t)},
    };
    ost_status status = OST_OK;
    for (size_t i = 0; i < sizeof list / sizeof *list && status == OST_OK; i++)
        status = ost_cl_buffer(b, chunks * list[i].bytes, NULL, "meshes", list[i].buffer, err);
    f->chunks = status == OST_OK ? chunks : 0;
    return status;
}

static ost_status reserve_quads(cl_backend *b, faces *f, size_t quads, ost_error *err)
{
    if (quads <= f->quads)
        return OST_OK;
    const size_t capacity = quads + quads / 2;
    ost_cl_buffer_free(b, &f->vertices);
    f->quads = 0;
    ost_status status = ost_cl_buffer(b, capacity * 4 * sizeof(uint32_t), NULL, "vertices", &f->vertices, err);
    f->quads = status == OST_OK ? capacity : 0;
    return status;
}

/* Launches kernel k for a number of chunks, with `range` work items per chunk. */
static ost_status launch(cl_backend *b, int k, size_t range, size_t chunks, const cl_mem *const *args, cl_uint count,
                         ost_error *err)
{
    const faces *f = b->faces;
    for (cl_uint i = 0; i < count; i++) {
        const cl_int code = b->cl->clSetKernelArg(f->kernel[k], i, sizeof *args[i], args[i]);
        if (code != CL_SUCCESS)
            return ost_cl_fail(err, b->device.name, code, "clSetKernelArg", names[k]);
    }
    const size_t local[3] = {f->group[k], 1, 1};
    const size_t global[3] = {(range + local[0] - 1) / local[0] * local[0], 1, chunks};
    const cl_int code = b->cl->clEnqueueNDRangeKernel(b->queue, f->kernel[k], 3, NULL, global, local, 0, NULL, NULL);
    return code == CL_SUCCESS ? OST_OK : ost_cl_fail(err, b->device.name, code, "clEnqueueNDRangeKernel", names[k]);
}
#define LAUNCH(b, k, range, chunks, err, ...)                                               \
    launch(b, k, range, chunks, (const cl_mem *const[]){__VA_ARGS__},                       \
           sizeof((const cl_mem *const[]){__VA_ARGS__}) / sizeof(const cl_mem *), err)

/* Ends the timing of a stage, which requires waiting for the device. Does nothing if stages are not timed. */
static ost_status stage_done(cl_backend *b, ost_face_mesh *mesh, ost_face_stage stage, int64_t *begin, ost_error *err)
{
    if (!mesh->timed)
        return OST_OK;
    ost_status status = ost_cl_finish(b, err);
    const int64_t now = ost_clock_ns();
    mesh->stage_ns[stage] += now - *begin;
    *begin = now;
    return status;
}

/* Writes the words of a chunk and of one layer of each neighbour, in the layout of kernels/face_mesh.cl. */
static void pack(const ost_face_cluster *cluster, uint32_t words[CLUSTER])
{
    const uint32_t *const *n = cluster->neighbour;
    memset(words, 0, CLUSTER * sizeof *words);
    if (cluster->own)
        memcpy(words, cluster->own, OST_FACE_ROWS * sizeof *words);
    uint32_t *layers = words + OST_FACE_ROWS;
    for (int v = 0; v < SIDE; v++) {
        for (int u = 0; u < SIDE; u++) {
            if (n[OST_FACE_X0])
                layers[SIDE * OST_FACE_X0 + v] |= (n[OST_FACE_X0][u + SIDE * v] >> (SIDE - 1)) << u;
            if (n[OST_FACE_X1])
                layers[SIDE * OST_FACE_X1 + v] |= (n[OST_FACE_X1][u + SIDE * v] & 1) << u;
        }
        if (n[OST_FACE_Y0])
            layers[SIDE * OST_FACE_Y0 + v] = n[OST_FACE_Y0][SIDE - 1 + SIDE * v];
        if (n[OST_FACE_Y1])
            layers[SIDE * OST_FACE_Y1 + v] = n[OST_FACE_Y1][SIDE * v];
        if (n[OST_FACE_Z0])
            layers[SIDE * OST_FACE_Z0 + v] = n[OST_FACE_Z0][v + SIDE * (SIDE - 1)];
        if (n[OST_FACE_Z1])
            layers[SIDE * OST_FACE_Z1 + v] = n[OST_FACE_Z1][v];
    }
}

/* Finds the active voxels of a batch. Sets sums[] to the numbers of active voxels and of faces of each chunk. */
static ost_status find_active(cl_backend *b, const ost_face_cluster *clusters, size_t chunks, ost_face_mesh *mesh,
                              uint32_t sums[2 * BATCH], int64_t *begin, ost_error *err)
{
    faces *f = b->faces;
    for (size_t i = 0; i < chunks; i++)
        pack(&clusters[i], f->words + CLUSTER * i);
    ost_status status = ost_cl_write_later(b, f->clusters, chunks * CLUSTER * sizeof *f->words, f->words, err);
    if (status == OST_OK)
        status = LAUNCH(b, PAD, PADDED, chunks, err, &f->clusters, &f->padded);
    if (status == OST_OK)
        status = stage_done(b, mesh, OST_FACE_STAGE_PAD, begin, err);
    if (status == OST_OK)
        status = LAUNCH(b, CLASSIFY, OST_FACE_VOXELS, chunks, err, &f->padded, &f->visible);
    if (status == OST_OK)
        status = stage_done(b, mesh, OST_FACE_STAGE_CLASSIFY, begin, err);
    if (status == OST_OK)
        status = LAUNCH(b, ROWS, OST_FACE_ROWS, chunks, err, &f->visible, &f->rows);
    if (status == OST_OK)
        status = LAUNCH(b, SLICES, SIDE, chunks, err, &f->rows, &f->slices);
    if (status == OST_OK)
        status = LAUNCH(b, COMPACT, OST_FACE_ROWS, chunks, err, &f->visible, &f->rows, &f->slices, &f->active,
                        &f->sums);
    if (status == OST_OK)
        status = ost_cl_read(b, f->sums, 0, chunks * 2 * sizeof *sums, sums, err);
    return status == OST_OK ? stage_done(b, mesh, OST_FACE_STAGE_COMPACT, begin, err) : status;
}

static ost_status mesh_batch(cl_backend *b, const ost_face_cluster *clusters, size_t from, size_t chunks,
                             ost_face_mesh *mesh, ost_error *err)
{
    faces *f = b->faces;
    uint32_t sums[2 * BATCH], first[BATCH], *begins = mesh->first + from;
    size_t most = 0;
    int64_t begin = mesh->timed ? ost_clock_ns() : 0;
    ost_status status = find_active(b, clusters + from, chunks, mesh, sums, &begin, err);
    if (status != OST_OK)
        return status;
    for (size_t i = 0; i < chunks; i++) {
        /* A faulty device may return counts that exceed the buffers, so they are checked. */
        if (sums[2 * i] > OST_FACE_VOXELS || sums[2 * i + 1] > OST_FACE_QUADS_MAX)
            return ost_fail(err, OST_ERR_UNAVAILABLE, "OpenCL device '%.120s' counts %u visible faces of a chunk",
                            b->device.name, (unsigned)sums[2 * i + 1]);
        first[i] = begins[i] - begins[0];
        begins[i + 1] = begins[i] + sums[2 * i + 1];
        most = sums[2 * i] > most ? sums[2 * i] : most;
    }
    const size_t quads = begins[chunks] - begins[0];
    status = ost_face_mesh_reserve(mesh, mesh->count, begins[chunks], err);
    /* `begins` is invalid from here on, because ost_face_mesh_reserve may have moved its array. */
    if (status != OST_OK || quads == 0)
        return status;
    status = reserve_quads(b, f, quads, err);
    if (status == OST_OK)
        status = ost_cl_write(b, f->first, 0, chunks * sizeof *first, first, err);
    if (status == OST_OK)
        status = LAUNCH(b, QUADS, most, chunks, err, &f->active, &f->sums, &f->first, &f->vertices);
    if (status == OST_OK)
        status = stage_done(b, mesh, OST_FACE_STAGE_QUADS, &begin, err);
    if (status == OST_OK)
        status = ost_cl_read(b, f->vertices, 0, quads * 4 * sizeof *mesh->vertices,
                             mesh->vertices + 4 * (size_t)mesh->first[from], err);
    return status == OST_OK ? stage_done(b, mesh, OST_FACE_STAGE_COPY, &begin, err) : status;
}

ost_status ost_cl_face_mesh(ost_backend *base, const ost_face_cluster *clusters, size_t count, ost_face_mesh *mesh,
                            ost_error *err)
{
    cl_backend *b = (cl_backend *)base;
    ost_status status = open_faces(b, err);
    if (status == OST_OK)
        status = reserve_chunks(b, b->faces, count < BATCH ? count : BATCH, err);
    for (size_t from = 0; from < count && status == OST_OK; from += BATCH)
        status = mesh_batch(b, clusters, from, count - from < BATCH ? count - from : BATCH, mesh, err);
    return status;
}
