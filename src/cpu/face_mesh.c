/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Face meshes (core/face_mesh.h) by bit operations: a row of 32 voxels is one word.
 *
 *   words of a chunk and its neighbours --pad--> 34 rows of 34 words, and the words of both neighbours along x
 *       --classify--> six words for each row: the voxels whose face is visible (core/visible.h)
 *       --compact--> active voxels in ascending order: number | visible faces << 15
 *       --quads--> four vertices for each face: the voxel plus the face's four corners
 *
 * Chunks are processed in batches. Each thread compacts complete chunks; then the numbers of faces are added up, and
 * each thread writes the quads of complete chunks directly to their final position, so quads are never copied.
 */
#include "cpu/face_mesh.h"

#include <stdlib.h>
#include <string.h>

#include "core/clock.h"

enum { SIDE = OST_FACE_CHUNK, PADDED = OST_FACE_PADDED, ROWS = OST_FACE_ROWS, BATCH = 64, FACES_SHIFT = 15 };

static const uint32_t empty[ROWS]; /* the shared empty chunk */

/*
 * The number of set bits of each mask of six faces. A table is used because the baseline instruction set of x86-64 has
 * no instruction that counts bits.
 */
static const uint8_t faces_of_mask[64] = {
    0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4, 1, 2, 2, 3, 2, 3, 3, 4, 2, 3, 3, 4, 3, 4, 4, 5,
    1, 2, 2, 3, 2, 3, 3, 4, 2, 3, 3, 4, 3, 4, 4, 5, 2, 3, 3, 4, 3, 4, 4, 5, 3, 4, 4, 5, 4, 5, 5, 6,
};

/* A padded chunk. row[z + 1][y + 1] is row y of slice z; x0 and x1 are the words of the neighbours along x. */
typedef struct padded {
    uint32_t row[PADDED][PADDED];
    const uint32_t *x0, *x1;
} padded;

typedef struct visible {
    uint32_t face[6][ROWS];
    uint32_t any[ROWS];
} visible;

/* The active voxels of a chunk, as written by compact(). */
typedef struct compacted {
    uint32_t count, faces;
    uint32_t voxel[OST_FACE_VOXELS];
} compacted;

typedef struct thread_scratch {
    padded padded;
    visible visible;
    int64_t stage_ns[OST_FACE_STAGES];
} thread_scratch;

static const uint32_t *words_of(const uint32_t *words)
{
    return words ? words : empty;
}

static void pad(const ost_face_cluster *cluster, padded *p)
{
    const uint32_t *own = words_of(cluster->own), *y0 = words_of(cluster->neighbour[OST_FACE_Y0]),
                   *y1 = words_of(cluster->neighbour[OST_FACE_Y1]), *z0 = words_of(cluster->neighbour[OST_FACE_Z0]),
                   *z1 = words_of(cluster->neighbour[OST_FACE_Z1]);
    p->x0 = words_of(cluster->neighbour[OST_FACE_X0]);
    p->x1 = words_of(cluster->neighbour[OST_FACE_X1]);
    for (int z = 0; z < SIDE; z++) {
        uint32_t *to = p->row[z + 1];
        to[0] = y0[SIDE - 1 + SIDE * z];
        memcpy(to + 1, own + SIDE * z, SIDE * sizeof *to);
        to[SIDE + 1] = y1[SIDE * z];
    }
    memcpy(p->row[0] + 1, z0 + SIDE * (SIDE - 1), SIDE * sizeof(uint32_t));
    memcpy(p->row[SIDE + 1] + 1, z1, SIDE * sizeof(uint32_t));
}

/*
 * Computes the visible faces of one slice. The arrays do not overlap, so the compiler can process several rows at once.
 */
static void classify_slice(const uint32_t *restrict own, const uint32_t *restrict below, const uint32_t *restrict above,
                           const uint32_t *restrict x0, const uint32_t *restrict x1, uint32_t *restrict f0,
                           uint32_t *restrict f1, uint32_t *restrict f2, uint32_t *restrict f3, uint32_t *restrict f4,
                           uint32_t *restrict f5, uint32_t *restrict any)
{
    for (int y = 0; y < SIDE; y++) {
        uint32_t behind[6];
        ost_visible_behind(own[y], x0[y], x1[y], own[y - 1], own[y + 1], below[y], above[y], behind);
        f0[y] = own[y] & ~behind[OST_FACE_X0];
        f1[y] = own[y] & ~behind[OST_FACE_X1];
        f2[y] = own[y] & ~behind[OST_FACE_Y0];
        f3[y] = own[y] & ~behind[OST_FACE_Y1];
        f4[y] = own[y] & ~behind[OST_FACE_Z0];
        f5[y] = own[y] & ~behind[OST_FACE_Z1];
        any[y] = own[y] & ~(behind[0] & behind[1] & behind[2] & behind[3] & behind[4] & behind[5]);
    }
}

static void classify(const padded *p, visible *v)
{
    for (int z = 0; z < SIDE; z++) {
        const int row = SIDE * z;
        classify_slice(p->row[z + 1] + 1, p->row[z] + 1, p->row[z + 2] + 1, p->x0 + row, p->x1 + row, v->face[0] + row,
                       v->face[1] + row, v->face[2] + row, v->face[3] + row, v->face[4] + row, v->face[5] + row,
                       v->any + row);
    }
}

/* Writes the list of the active voxels of a chunk to *out. */
static void compact(const visible *v, compacted *out)
{
    uint32_t count = 0, faces = 0;
    for (uint32_t row = 0; row < ROWS; row++) {
        uint32_t left = v->any[row];
        if (!left)
            continue;
        const uint32_t f[6] = {v->face[0][row], v->face[1][row], v->face[2][row],
                               v->face[3][row], v->face[4][row], v->face[5][row]};
        for (; left; left &= left - 1) {
            const int x = __builtin_ctz(left);
            const uint32_t mask = (f[0] >> x & 1) | (f[1] >> x & 1) << 1 | (f[2] >> x & 1) << 2 | (f[3] >> x & 1) << 3 |
                                  (f[4] >> x & 1) << 4 | (f[5] >> x & 1) << 5;
            out->voxel[count++] = (uint32_t)x | row << 5 | mask << FACES_SHIFT;
            faces += faces_of_mask[mask];
        }
    }
    out->count = count;
    out->faces = faces;
}

static void make_quads(const compacted *from, const uint32_t corners[6][4], uint32_t *restrict out)
{
    for (uint32_t k = 0; k < from->count; k++) {
        const uint32_t number = from->voxel[k], base = ost_face_voxel(number);
        for (uint32_t left = number >> FACES_SHIFT; left; left &= left - 1) {
            const uint32_t *corner = corners[__builtin_ctz(left)];
            for (int i = 0; i < 4; i++)
                out[i] = base + corner[i];
            out += 4;
        }
    }
}

static void stage_done(thread_scratch *t, bool timed, ost_face_stage stage, int64_t *begin)
{
    const int64_t now = timed ? ost_clock_ns() : 0;
    t->stage_ns[stage] += now - *begin;
    *begin = now;
}

static void find_active(const ost_face_cluster *cluster, bool timed, thread_scratch *t, compacted *out)
{
    int64_t begin = timed ? ost_clock_ns() : 0;
    pad(cluster, &t->padded);
    stage_done(t, timed, OST_FACE_STAGE_PAD, &begin);
    classify(&t->padded, &t->visible);
    stage_done(t, timed, OST_FACE_STAGE_CLASSIFY, &begin);
    compact(&t->visible, out);
    stage_done(t, timed, OST_FACE_STAGE_COMPACT, &begin);
}

/* Computes the meshes of up to BATCH chunks, starting with clusters[from]. */
static ost_status mesh_batch(const ost_face_cluster *clusters, size_t from, int count, const uint32_t corners[6][4],
                             int threads, compacted *list, ost_face_mesh *mesh, ost_error *err)
{
    const bool timed = mesh->timed;
    int64_t total[OST_FACE_STAGES] = {0};
#pragma omp parallel num_threads(threads) if (count > 1)
    {
        thread_scratch t;
        memset(t.stage_ns, 0, sizeof t.stage_ns);
#pragma omp for schedule(dynamic, 1)
        for (int i = 0; i < count; i++)
            find_active(&clusters[from + (size_t)i], timed, &t, &list[i]);
#pragma omp critical(ost_cpu_face_mesh)
        for (int s = 0; s < OST_FACE_STAGES; s++)
            total[s] += t.stage_ns[s];
    }
    uint32_t *first = mesh->first + from;
    for (int i = 0; i < count; i++)
        first[i + 1] = first[i] + list[i].faces;
    ost_status status = ost_face_mesh_reserve(mesh, mesh->count, first[count], err);
    if (status != OST_OK)
        return status;
    int64_t quads_ns = 0;
#pragma omp parallel for num_threads(threads) if (count > 1) schedule(dynamic, 1) reduction(+ : quads_ns)
    for (int i = 0; i < count; i++) {
        const int64_t begin = timed ? ost_clock_ns() : 0;
        make_quads(&list[i], corners, mesh->vertices + 4 * (size_t)mesh->first[from + (size_t)i]);
        quads_ns += timed ? ost_clock_ns() - begin : 0;
    }
    for (int s = 0; s < OST_FACE_STAGES; s++)
        mesh->stage_ns[s] += total[s];
    mesh->stage_ns[OST_FACE_STAGE_QUADS] += quads_ns;
    return OST_OK;
}

ost_status ost_cpu_face_mesh(ost_backend *base, const ost_face_cluster *clusters, size_t count, ost_face_mesh *mesh,
                             ost_error *err)
{
    const cpu_backend *backend = (const cpu_backend *)base;
    const size_t batch = count < BATCH ? count : BATCH;
    ost_status status = OST_OK;
    uint32_t corners[6][4];
    for (unsigned f = 0; f < 6; f++)
        for (unsigned i = 0; i < 4; i++)
            corners[f][i] = ost_face_corner(f, i);
    compacted *list = malloc(batch * sizeof *list);
    if (!list)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory to mesh %zu chunks", count);
    for (size_t from = 0; from < count && status == OST_OK; from += batch) {
        const size_t some = count - from < batch ? count - from : batch;
        status = mesh_batch(clusters, from, (int)some, corners, backend->threads, list, mesh, err);
    }
    free(list);
    return status;
}
