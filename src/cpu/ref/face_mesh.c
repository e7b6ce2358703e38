/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Face meshes (core/face_mesh.h) in the steps of thesis section 3.3.1, one voxel after the other:
 *
 *   chunk and neighbours
 *           --pad--> 34^3 densities, so that no neighbour look-up needs a branch
 *           --classify--> a mask of visible faces for each of the 32^3 voxels
 *           --scan--> number of active voxels, and of faces, before each voxel (exclusive prefix sums)
 *           --compact--> the active voxels without gaps, each with the index of its first quad
 *           --quads--> four vertices for each visible face
 *
 * Only the faces of voxels (1, 1, 1) to (32, 32, 32) are read; the edges and corners of the padded chunk stay empty.
 */
#include "cpu/ref/ref.h"

#include <stdlib.h>
#include <string.h>

#include "core/clock.h"

enum { SIDE = OST_FACE_CHUNK, PADDED = OST_FACE_PADDED, VOXELS = OST_FACE_VOXELS, ACTIVE = 1 };

typedef struct scratch {
    int16_t padded[PADDED][PADDED][PADDED]; /* [z][y][x]; ACTIVE or 0 */
    uint8_t visible[VOXELS];     /* visible faces of each voxel; bit f is set if face f is visible */
    uint32_t before[VOXELS];     /* number of active voxels before this voxel */
    uint32_t faces_before[VOXELS];
    uint32_t voxel[VOXELS];      /* numbers of the active voxels, in ascending order */
    uint32_t first[VOXELS];      /* index of the first quad of each active voxel */
    uint32_t vertices[4 * OST_FACE_QUADS_MAX];
    uint32_t count, faces;       /* number of active voxels, and number of visible faces */
} scratch;

static int16_t voxel_of(const uint32_t *words, int x, int y, int z)
{
    return words && words[y + SIDE * z] >> x & 1 ? ACTIVE : 0;
}

static void pad(const ost_face_cluster *cluster, scratch *s)
{
    memset(s->padded, 0, sizeof s->padded);
    for (int z = 0; z < SIDE; z++)
        for (int y = 0; y < SIDE; y++)
            for (int x = 0; x < SIDE; x++)
                s->padded[z + 1][y + 1][x + 1] = voxel_of(cluster->own, x, y, z);
    const uint32_t *const *n = cluster->neighbour;
    for (int v = 0; v < SIDE; v++)
        for (int u = 0; u < SIDE; u++) {
            s->padded[v + 1][u + 1][0] = voxel_of(n[OST_FACE_X0], SIDE - 1, u, v);
            s->padded[v + 1][u + 1][SIDE + 1] = voxel_of(n[OST_FACE_X1], 0, u, v);
            s->padded[v + 1][0][u + 1] = voxel_of(n[OST_FACE_Y0], u, SIDE - 1, v);
            s->padded[v + 1][SIDE + 1][u + 1] = voxel_of(n[OST_FACE_Y1], u, 0, v);
            s->padded[0][v + 1][u + 1] = voxel_of(n[OST_FACE_Z0], u, v, SIDE - 1);
            s->padded[SIDE + 1][v + 1][u + 1] = voxel_of(n[OST_FACE_Z1], u, v, 0);
        }
}

static void classify(scratch *s)
{
    static const int step[6][3] = {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}};
    for (int i = 0; i < VOXELS; i++) {
        const int x = i % SIDE + 1, y = i / SIDE % SIDE + 1, z = i / SIDE / SIDE + 1;
        s->visible[i] = 0;
        for (int f = 0; f < 6 && s->padded[z][y][x]; f++)
            if (!s->padded[z + step[f][2]][y + step[f][1]][x + step[f][0]])
                s->visible[i] |= (uint8_t)(1 << f);
    }
}

static uint32_t faces_in(uint8_t visible)
{
    uint32_t count = 0;
    for (int f = 0; f < 6; f++)
        count += visible >> f & 1;
    return count;
}

static void scan_and_compact(scratch *s)
{
    s->count = s->faces = 0;
    for (int i = 0; i < VOXELS; i++) {
        s->before[i] = s->count;
        s->faces_before[i] = s->faces;
        s->count += s->visible[i] != 0;
        s->faces += faces_in(s->visible[i]);
    }
    for (uint32_t i = 0; i < VOXELS; i++)
        if (s->visible[i]) {
            s->voxel[s->before[i]] = i;
            s->first[s->before[i]] = s->faces_before[i];
        }
}

static void make_quads(scratch *s)
{
    for (uint32_t k = 0; k < s->count; k++) {
        const uint32_t number = s->voxel[k];
        uint32_t *out = s->vertices + 4 * s->first[k];
        for (unsigned f = 0; f < 6; f++)
            if (s->visible[number] >> f & 1)
                for (unsigned corner = 0; corner < 4; corner++)
                    *out++ = ost_face_voxel(number) + ost_face_corner(f, corner);
    }
}

/* Adds the time since *begin to a stage of the mesh, and sets *begin to now. */
static void stage_done(ost_face_mesh *mesh, ost_face_stage stage, int64_t *begin)
{
    const int64_t now = mesh->timed ? ost_clock_ns() : 0;
    mesh->stage_ns[stage] += now - *begin;
    *begin = now;
}

ost_status ost_ref_face_mesh(ost_backend *backend, const ost_face_cluster *clusters, size_t count, ost_face_mesh *mesh,
                             ost_error *err)
{
    ost_status status = OST_OK;
    scratch *s = malloc(sizeof *s);
    (void)backend;
    if (!s)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory to mesh a chunk");
    for (size_t i = 0; i < count && status == OST_OK; i++) {
        int64_t begin = mesh->timed ? ost_clock_ns() : 0;
        pad(&clusters[i], s);
        stage_done(mesh, OST_FACE_STAGE_PAD, &begin);
        classify(s);
        stage_done(mesh, OST_FACE_STAGE_CLASSIFY, &begin);
        scan_and_compact(s);
        stage_done(mesh, OST_FACE_STAGE_COMPACT, &begin);
        make_quads(s);
        stage_done(mesh, OST_FACE_STAGE_QUADS, &begin);
        status = ost_face_mesh_reserve(mesh, count, (size_t)mesh->first[i] + s->faces, err);
        if (status != OST_OK)
            break;
        memcpy(mesh->vertices + 4 * (size_t)mesh->first[i], s->vertices, 4 * sizeof(uint32_t) * s->faces);
        mesh->first[i + 1] = mesh->first[i] + s->faces;
        stage_done(mesh, OST_FACE_STAGE_COPY, &begin);
    }
    free(s);
    return status;
}
