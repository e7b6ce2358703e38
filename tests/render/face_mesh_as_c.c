/* SPDX-License-Identifier: Apache-2.0 */
#include "render/face_mesh_as_c.h"

#include "harness.h"

#include "cl/opencl_c.h" /* included after the system headers, because it defines macros such as select */

#include "cl/kernels/face_mesh.cl"

typedef struct buffers {
    uint32_t *clusters, *rows, *slices, *active, *sums, *first, *vertices;
    int16_t *padded;
    uint8_t *visible;
} buffers;

static void *allocate(size_t bytes)
{
    void *p = malloc(bytes ? bytes : 1);
    assert_non_null(p);
    memset(p, 0xa5, bytes); /* a kernel must not depend on the initial contents of a buffer */
    return p;
}

typedef enum kernel { K_PAD, K_CLASSIFY, K_ROWS, K_SLICES, K_COMPACT, K_QUADS } kernel;

static void call(kernel k, const buffers *b)
{
    switch (k) {
    case K_PAD: ost_face_pad(b->clusters, b->padded); break;
    case K_CLASSIFY: ost_face_classify(b->padded, b->visible); break;
    case K_ROWS: ost_face_rows(b->visible, b->rows); break;
    case K_SLICES: ost_face_slices(b->rows, b->slices); break;
    case K_COMPACT: ost_face_compact(b->visible, b->rows, b->slices, b->active, b->sums); break;
    case K_QUADS: ost_face_quads(b->active, b->sums, b->first, b->vertices); break;
    }
}

/*
 * Runs the kernel for all items of the range and for up to 63 additional items per chunk. Successive items are a
 * constant step apart. The step and the number of items are coprime, so every item runs once.
 */
static void run(kernel k, uint32_t range, uint32_t chunks, test_rng *rng, const buffers *b)
{
    const uint64_t across = (uint64_t)range + (uint64_t)rng_range(rng, 0, 63), all = across * chunks;
    uint64_t step, at = (uint64_t)rng_range(rng, 0, (int64_t)all - 1);
    for (bool found = false; !found;) {
        uint64_t x = step = (uint64_t)rng_range(rng, 1, (int64_t)all), y = all;
        while (y) {
            const uint64_t rest = x % y;
            x = y;
            y = rest;
        }
        found = x == 1;
    }
    for (uint64_t i = 0; i < all; i++, at = (at + step) % all) {
        test_item[0] = at % across;
        test_item[1] = 0;
        test_item[2] = at / across;
        call(k, b);
    }
}

/* Packs a cluster voxel by voxel, in the layout that is documented in the kernel. */
static void pack(const ost_face_cluster *c, uint32_t words[CLUSTER_WORDS])
{
    memset(words, 0, CLUSTER_WORDS * sizeof *words);
    for (int i = 0; i < 1024 && c->own; i++)
        words[i] = c->own[i];
    for (int f = 0; f < 6; f++)
        for (int v = 0; v < SIDE && c->neighbour[f]; v++)
            for (int u = 0; u < SIDE; u++) {
                const int edge = f % 2 ? 0 : SIDE - 1;
                const int x = f / 2 == 0 ? edge : u, y = f / 2 == 0 ? u : f / 2 == 1 ? edge : v,
                          z = f / 2 == 2 ? edge : v;
                words[1024 + SIDE * f + v] |= (c->neighbour[f][y + SIDE * z] >> x & 1) << u;
            }
}

void face_mesh_as_c(const ost_face_cluster *clusters, uint32_t count, uint64_t seed, ost_face_mesh *mesh)
{
    ost_error err = {0};
    test_rng rng = {seed};
    const size_t n = count, word = sizeof(uint32_t);
    buffers b = {
        .clusters = allocate(n * CLUSTER_WORDS * word),
        .rows = allocate(n * ROWS * 2 * word),
        .slices = allocate(n * SIDE * 2 * word),
        .active = allocate(n * VOXELS * 2 * word),
        .sums = allocate(n * 2 * word),
        .first = allocate(n * word),
        .padded = allocate(n * PADDED_VOXELS * sizeof(int16_t)),
        .visible = allocate(n * VOXELS),
    };
    uint32_t most = 0;
    for (size_t i = 0; i < n; i++)
        pack(&clusters[i], b.clusters + CLUSTER_WORDS * i);
    run(K_PAD, PADDED_VOXELS, count, &rng, &b);
    run(K_CLASSIFY, VOXELS, count, &rng, &b);
    run(K_ROWS, ROWS, count, &rng, &b);
    run(K_SLICES, SIDE, count, &rng, &b);
    run(K_COMPACT, ROWS, count, &rng, &b);
    *mesh = (ost_face_mesh){.count = n};
    assert_ok(ost_face_mesh_reserve(mesh, n, 1, &err));
    mesh->first[0] = 0;
    for (size_t i = 0; i < n; i++) {
        b.first[i] = mesh->first[i];
        mesh->first[i + 1] = mesh->first[i] + b.sums[2 * i + 1];
        most = b.sums[2 * i] > most ? b.sums[2 * i] : most;
    }
    b.vertices = allocate(mesh->first[n] * 4 * word);
    if (most)
        run(K_QUADS, most, count, &rng, &b);
    assert_ok(ost_face_mesh_reserve(mesh, n, mesh->first[n] + 1, &err));
    memcpy(mesh->vertices, b.vertices, mesh->first[n] * 4 * word);
    void *const all[] = {b.clusters, b.rows, b.slices, b.active, b.sums, b.first, b.vertices, b.padded, b.visible};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++)
        free(all[i]);
}
