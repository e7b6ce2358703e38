/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests face meshes (core/face_mesh.h) against an oracle that examines every voxel of a volume and shares no code with
 * the backends. The test meshes random chunks of several densities, chunks with and without neighbours, and chunks at
 * the borders of a volume. The vertices of all backends must be bit-identical. The backend cl is tested if there is a
 * device; its kernels are also compiled as C.
 * Covers: REQ-FACE-MESH
 */
#include <math.h>

#include "backends.h"
#include "cl/on_device.h"
#include "core/backend.h"
#include "render/face_mesh_as_c.h"

enum { N = 32, ROWS = 32 * 32, CHUNKS = 3, SIDE = N * CHUNKS };

/* A volume of 3^3 chunks. A chunk for which `present` is false does not exist, and its voxels are not active. */
typedef struct scene {
    uint8_t voxel[SIDE][SIDE][SIDE]; /* [z][y][x] */
    uint32_t words[CHUNKS][CHUNKS][CHUNKS][ROWS];
    bool present[CHUNKS][CHUNKS][CHUNKS];
} scene;

static const int step[6][3] = {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}};

/* The patterns with which the voxels of a scene are filled. */
typedef enum filling { SPARSE, HALF, DENSE, FULL, NOTHING, CHECKERED, BALL, FILLINGS } filling;

static bool fill_voxel(filling how, test_rng *rng, int x, int y, int z)
{
    switch (how) {
    case SPARSE: return rng_range(rng, 0, 99) < 3;
    case HALF: return rng_range(rng, 0, 1);
    case DENSE: return rng_range(rng, 0, 99) < 97;
    case FULL: return true;
    case CHECKERED: return (x + y + z) % 2 == 0;
    case BALL: return hypot(hypot(x - 47.3, y - 48.1), z - 46.6) < 40;
    case NOTHING:
    case FILLINGS: return false;
    }
    return false;
}

static scene *scene_make(filling how, bool gaps, test_rng *rng)
{
    scene *s = calloc(1, sizeof *s);
    assert_non_null(s);
    for (int z = 0; z < SIDE; z++)
        for (int y = 0; y < SIDE; y++)
            for (int x = 0; x < SIDE; x++) {
                const int c[3] = {x / N, y / N, z / N};
                bool *present = &s->present[c[2]][c[1]][c[0]];
                if (x % N == 0 && y % N == 0 && z % N == 0)
                    *present = !gaps || rng_range(rng, 0, 2) != 0;
                const bool active = fill_voxel(how, rng, x, y, z) && *present;
                s->voxel[z][y][x] = active;
                s->words[c[2]][c[1]][c[0]][y % N + N * (z % N)] |= (uint32_t)active << (x % N);
            }
    return s;
}

static bool active_at(const scene *s, int x, int y, int z)
{
    return x >= 0 && y >= 0 && z >= 0 && x < SIDE && y < SIDE && z < SIDE && s->voxel[z][y][x];
}

static const uint32_t *words_at(const scene *s, int x, int y, int z)
{
    const bool inside = x >= 0 && y >= 0 && z >= 0 && x < CHUNKS && y < CHUNKS && z < CHUNKS;
    return inside && s->present[z][y][x] ? s->words[z][y][x] : NULL;
}

/* Stores the clusters of all chunks in `out`, in random order, including those of chunks that do not exist. */
static void clusters_of(const scene *s, test_rng *rng, ost_face_cluster out[27], int order[27])
{
    for (int i = 0; i < 27; i++)
        order[i] = i;
    for (int i = 26; i > 0; i--) {
        const int j = (int)rng_range(rng, 0, i), swap = order[i];
        order[i] = order[j];
        order[j] = swap;
    }
    for (int i = 0; i < 27; i++) {
        const int x = order[i] % 3, y = order[i] / 3 % 3, z = order[i] / 9;
        out[i].own = words_at(s, x, y, z);
        for (int f = 0; f < 6; f++)
            out[i].neighbour[f] = words_at(s, x + step[f][0], y + step[f][1], z + step[f][2]);
    }
}

/*
 * Checks the quads of a chunk. They must be exactly the visible faces of its voxels, in the documented order. Each quad
 * must have the four corners of its face, counter-clockwise as seen from outside.
 */
static void check_chunk(const scene *s, int chunk, const uint32_t *vertices, uint32_t quads)
{
    const int c[3] = {chunk % 3, chunk / 3 % 3, chunk / 9};
    uint32_t n = 0;
    for (int z = 0; z < N; z++)
        for (int y = 0; y < N; y++)
            for (int x = 0; x < N; x++) {
                const int at[3] = {N * c[0] + x, N * c[1] + y, N * c[2] + z}, local[3] = {x, y, z};
                if (!active_at(s, at[0], at[1], at[2]))
                    continue;
                for (int f = 0; f < 6; f++) {
                    if (active_at(s, at[0] + step[f][0], at[1] + step[f][1], at[2] + step[f][2]))
                        continue;
                    assert_true(n < quads);
                    int p[4][3], seen = 0;
                    for (int i = 0; i < 4; i++) {
                        const uint32_t v = vertices[4 * n + (uint32_t)i];
                        assert_int_equal(v >> 18 & 7, f);
                        for (int a = 0; a < 3; a++) {
                            p[i][a] = (int)(v >> (6 * a) & 63) - local[a];
                            assert_in_range(p[i][a], 0, 1);
                        }
                        assert_int_equal(p[i][f / 2], f % 2);
                        assert_int_equal(v >> 21 & 1, p[i][(f / 2 + 1) % 3]);
                        assert_int_equal(v >> 22 & 1, p[i][(f / 2 + 2) % 3]);
                        assert_int_equal(v >> 23, 0);
                        seen |= 1 << (p[i][(f / 2 + 1) % 3] + 2 * p[i][(f / 2 + 2) % 3]);
                    }
                    assert_int_equal(seen, 15); /* each of the four corners of the face occurs once */
                    /* the normal is the cross product of two edges */
                    int e[2][3], normal[3];
                    for (int a = 0; a < 3; a++) {
                        e[0][a] = p[1][a] - p[0][a];
                        e[1][a] = p[2][a] - p[1][a];
                    }
                    for (int a = 0; a < 3; a++)
                        normal[a] = e[0][(a + 1) % 3] * e[1][(a + 2) % 3] - e[0][(a + 2) % 3] * e[1][(a + 1) % 3];
                    for (int a = 0; a < 3; a++)
                        assert_int_equal(normal[a], step[f][a]);
                    n++;
                }
            }
    assert_int_equal(n, quads);
}

static void check_scene(ost_backend *backend, filling how, bool gaps, test_rng *rng, ost_face_mesh *mesh)
{
    ost_error err = {0};
    ost_face_cluster clusters[27];
    int order[27];
    scene *s = scene_make(how, gaps, rng);
    clusters_of(s, rng, clusters, order);
    assert_ok(ost_backend_face_mesh(backend, clusters, 27, mesh, &err));
    assert_int_equal(mesh->count, 27);
    assert_int_equal(mesh->first[0], 0);
    for (int i = 0; i < 27; i++)
        check_chunk(s, order[i], mesh->vertices + 4 * (size_t)mesh->first[i], mesh->first[i + 1] - mesh->first[i]);
    free(s);
}

static void test_against_oracle(void **state)
{
    test_rng rng = rng_seeded("faces of random chunks");
    ost_face_mesh mesh = {0};
    for (int i = 0; i < 2 * FILLINGS; i++)
        check_scene(*state, (filling)(i % FILLINGS), i >= FILLINGS, &rng, &mesh);
    ost_face_mesh_free(&mesh);
}

/*
 * Tests one full chunk without neighbours and with one full neighbour at a time. Only the faces at this neighbour may
 * disappear.
 */
static void test_missing_neighbours(void **state)
{
    static uint32_t full[ROWS];
    ost_error err = {0};
    ost_face_mesh mesh = {0};
    memset(full, 0xff, sizeof full);
    const ost_face_cluster nothing = {0}, alone = {.own = full};
    assert_ok(ost_backend_face_mesh(*state, &nothing, 1, &mesh, &err));
    assert_int_equal(mesh.first[1], 0);
    assert_ok(ost_backend_face_mesh(*state, &alone, 1, &mesh, &err));
    assert_int_equal(mesh.first[1], 6 * N * N);
    for (int f = 0; f < 6; f++) {
        ost_face_cluster c = alone;
        c.neighbour[f] = full;
        assert_ok(ost_backend_face_mesh(*state, &c, 1, &mesh, &err));
        assert_int_equal(mesh.first[1], 5 * N * N);
        for (uint32_t q = 0; q < mesh.first[1]; q++)
            assert_int_not_equal(mesh.vertices[4 * q] >> 18 & 7, f);
    }
    assert_ok(ost_backend_face_mesh(*state, NULL, 0, &mesh, &err));
    assert_int_equal(mesh.first[0], 0);
    assert_int_equal(ost_backend_face_mesh(NULL, &alone, 1, &mesh, &err), OST_ERR_USAGE);
    assert_int_equal(ost_backend_face_mesh(*state, NULL, 1, &mesh, &err), OST_ERR_USAGE);
    ost_face_mesh_free(&mesh);
}

/*
 * Compares meshes of random chunks with the reference's meshes. The numbers of chunks are below and above the size of a
 * batch, some calls are timed, and all calls reuse the same mesh.
 */
static void test_same_words(void **state)
{
    enum { MOST = 150 };
    static const struct {
        size_t count;
        bool timed;
    } calls[] = {{1, false}, {MOST, true}, {65, false}, {64, false}, {MOST, false}, {3, true}};
    test_rng rng = rng_seeded("the reference's words");
    ost_error err = {0};
    ost_backend *ref;
    ost_face_mesh ours = {0}, theirs = {0};
    ost_face_cluster *clusters = calloc(MOST, sizeof *clusters);
    uint32_t(*words)[ROWS] = calloc(MOST, sizeof *words);
    assert_true(clusters && words);
    assert_ok(ost_backend_open("ref", &ref, &err));
    for (int i = 0; i < MOST; i++) {
        const uint64_t mask = (uint64_t)rng_range(&rng, 0, 3);
        for (int row = 0; row < ROWS; row++)
            words[i][row] = (uint32_t)(mask == 0   ? rng_next(&rng)
                                       : mask == 1 ? rng_next(&rng) & rng_next(&rng) & rng_next(&rng)
                                       : mask == 2 ? rng_next(&rng) | rng_next(&rng) | rng_next(&rng)
                                                   : 0);
    }
    for (int i = 0; i < MOST; i++) {
        clusters[i].own = words[i];
        for (int f = 0; f < 6; f++)
            clusters[i].neighbour[f] = rng_range(&rng, 0, 2) ? words[rng_range(&rng, 0, MOST - 1)] : NULL;
    }
    for (size_t i = 0; i < sizeof calls / sizeof *calls; i++) {
        ours.timed = theirs.timed = calls[i].timed;
        assert_ok(ost_backend_face_mesh(*state, clusters, calls[i].count, &ours, &err));
        assert_ok(ost_backend_face_mesh(ref, clusters, calls[i].count, &theirs, &err));
        assert_memory_equal(ours.first, theirs.first, (calls[i].count + 1) * sizeof *ours.first);
        assert_memory_equal(ours.vertices, theirs.vertices,
                            4 * sizeof *ours.vertices * (size_t)theirs.first[calls[i].count]);
        int64_t ns = 0;
        for (int s = 0; s < OST_FACE_STAGES; s++)
            ns += ours.stage_ns[s];
        assert_true(calls[i].timed ? ns > 0 : ns == 0);
    }
    ost_backend_close(ref);
    ost_face_mesh_free(&ours);
    ost_face_mesh_free(&theirs);
    free(clusters);
    free(words);
}

/* Compares the OpenCL kernels, which are compiled as C and run their items in random order, with the reference. */
static void test_kernels_as_c(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("kernels as C");
    ost_error err = {0};
    ost_backend *ref;
    assert_ok(ost_backend_open("ref", &ref, &err));
    for (int i = 0; i < FILLINGS; i++) {
        ost_face_mesh ours, theirs = {0};
        ost_face_cluster clusters[27];
        int order[27];
        scene *s = scene_make((filling)i, true, &rng);
        const uint32_t count = (uint32_t)rng_range(&rng, 1, 4);
        clusters_of(s, &rng, clusters, order);
        face_mesh_as_c(clusters, count, rng_next(&rng), &ours);
        assert_ok(ost_backend_face_mesh(ref, clusters, count, &theirs, &err));
        assert_memory_equal(ours.first, theirs.first, (count + 1) * sizeof *ours.first);
        assert_memory_equal(ours.vertices, theirs.vertices, 4 * sizeof *ours.vertices * (size_t)theirs.first[count]);
        ost_face_mesh_free(&ours);
        ost_face_mesh_free(&theirs);
        free(s);
    }
    ost_backend_close(ref);
}

static int open_device(void **state)
{
    ost_error err = {0};
    if (ost_backend_open(device_spec(), (ost_backend **)state, &err) == OST_OK)
        return 0;
    print_error("%s\n", err.text);
    return 1;
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_against_oracle), cmocka_unit_test(test_missing_neighbours),
                                       cmocka_unit_test(test_same_words)};
    const struct CMUnitTest kernels[] = {cmocka_unit_test(test_kernels_as_c)};
    int failed = run_on_backends(tests, open_test_backend, close_test_backend);
    failed += cmocka_run_group_tests(kernels, NULL, NULL);
    if (!failed && device_missing() == 0)
        failed = cmocka_run_group_tests_name("cl", tests, open_device, close_test_backend);
    return failed;
}
