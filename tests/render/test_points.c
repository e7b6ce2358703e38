/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests points drawn through a camera. The surface is compared with a simple implementation that visits all
 * voxels. The picture is compared with the intersections of each pixel's ray with every voxel. The results
 * of instruction sets and threads are compared with those of the scalar functions.
 *
 * Covers: REQ-RENDER
 */
#include <math.h>
#include <stdlib.h>

#include "harness.h"
#include "render/points/frame.h"
#include "render/points/octahedral.h"
#include "render/points/rows.h"
#include "render/points/smooth.h"

static ost_geometry grid(int x, int y, int z)
{
    return (ost_geometry){
        {x, y, z}, {OST_PM_PER_MM, OST_PM_PER_MM, OST_PM_PER_MM}, {-3 * OST_PM_PER_MM, 0, 7 * OST_PM_PER_MM}};
}

/*
 * Makes a ball with holes of single voxels, so that there are also surfaces inside the ball. A ball that is larger than
 * a block extends over blocks that are adjacent along every axis.
 */
static ost_volume pitted_ball(test_rng *rng, int x, int y, int z)
{
    ost_error err = {0};
    ost_volume v;
    const ost_geometry g = grid(x, y, z);
    assert_ok(ost_volume_init(&v, &g, &err));
    const double r = 0.48 * (x < y ? (x < z ? x : z) : (y < z ? y : z));
    for (int k = 0; k < z; k++)
        for (int j = 0; j < y; j++)
            for (int i = 0; i < x; i++) {
                const double a = i - 0.5 * (x - 1), b = j - 0.5 * (y - 1), c = k - 0.5 * (z - 1);
                v.voxels[i + (size_t)x * (size_t)(j + y * k)] = a * a + b * b + c * c < r * r &&
                                                                        rng_range(rng, 0, 39) != 0
                                                                    ? 700
                                                                    : 0;
            }
    return v;
}

static bool active(const ost_volume *v, int i, int j, int k)
{
    const ost_dims d = v->geometry.dims;
    return i >= 0 && j >= 0 && k >= 0 && i < d.x && j < d.y && k < d.z &&
           v->voxels[i + (size_t)d.x * ((size_t)j + (size_t)d.y * (size_t)k)] >= 120;
}

static uint32_t faces(const ost_volume *v, int i, int j, int k)
{
    static const int step[6][3] = {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}};
    uint32_t mask = 0;
    for (int f = 0; f < 6; f++)
        mask |= (uint32_t)!active(v, i + step[f][0], j + step[f][1], k + step[f][2]) << f;
    return mask;
}

/*
 * Returns the amount of bone around a voxel. The amount is a sum over the voxel's neighbourhood and is
 * rounded after each axis, as shading.h specifies.
 */
static int field(const ost_volume *v, int i, int j, int k)
{
    static const int weight[9] = {1, 2, 3, 4, 5, 4, 3, 2, 1};
    int sum = 0;
    for (int a = -4; a <= 4; a++) {
        int slice = 0;
        for (int c = -4; c <= 4; c++)
            for (int b = -4; b <= 4; b++)
                slice += active(v, i + a, j + b, k + c) ? 63 * weight[b + 4] * weight[c + 4] : 0;
        sum += (slice + 8) / 16 * weight[a + 4];
    }
    return sum;
}

/* Returns the amount of bone in the cell (i, j, k) of 2^3 voxels: 0 if no voxel is active, 63 if all voxels are
   active. */
static int cell(const ost_volume *v, int i, int j, int k)
{
    int sum = 0;
    for (int n = 0; n < 8; n++)
        sum += active(v, 2 * i + (n & 1), 2 * j + (n >> 1 & 1), 2 * k + (n >> 2)) ? 63 : 0;
    return (sum + 4) / 8;
}

static int field_of_cells(const ost_volume *v, int i, int j, int k)
{
    static const int weight[9] = {1, 2, 3, 4, 5, 4, 3, 2, 1};
    int sum = 0;
    for (int a = -4; a <= 4; a++) {
        int slice = 0;
        for (int c = -4; c <= 4; c++)
            for (int b = -4; b <= 4; b++)
                slice += cell(v, i + a, j + b, k + c) * weight[b + 4] * weight[c + 4];
        sum += (slice + 8) / 16 * weight[a + 4];
    }
    return sum;
}

/*
 * Interpolates the field of cells at a voxel, first along z, then y, then x, and rounds after
 * each axis. Returns a quarter of the interpolated value.
 */
static int wide(const ost_volume *v, int i, int j, int k)
{
    const int c[3] = {i >> 1, j >> 1, k >> 1}, far[3] = {i & 1 ? 1 : -1, j & 1 ? 1 : -1, k & 1 ? 1 : -1};
    int x[2];
    for (int a = 0; a < 2; a++) {
        int y[2];
        for (int b = 0; b < 2; b++) {
            const int at[2] = {c[0] + a * far[0], c[1] + b * far[1]};
            y[b] = (3 * ((field_of_cells(v, at[0], at[1], c[2]) + 2) / 4) +
                    (field_of_cells(v, at[0], at[1], c[2] + far[2]) + 2) / 4 + 2) /
                   4;
        }
        x[a] = (3 * y[0] + y[1] + 2) / 4;
    }
    return (3 * x[0] + x[1] + 2) / 4;
}

static int openness(int value)
{
    const int beyond = value - 36915, bright = 225 - beyond * (beyond > 0 ? 470 : 120) / 61525;
    return bright < 40 ? 40 : bright > 255 ? 255 : bright;
}

/*
 * Mixes the slopes of the coarse-scale average (w) and the fine-scale average (f). If they are at
 * most 45 degrees apart, w alone is used; if they are at least 53 degrees apart, f alone is used.
 */
static uint32_t shade_from(const float f[3], const float w[3], int fine, int wide_value)
{
    const float a = sqrtf((f[0] * f[0] + f[1] * f[1]) + f[2] * f[2]),
                b = sqrtf((w[0] * w[0] + w[1] * w[1]) + w[2] * w[2]);
    const float along = (f[0] * w[0] + f[1] * w[1]) + f[2] * w[2];
    float t = b < 120 ? 0 : (along / (a * b > 1 ? a * b : 1) - 0.6f) * 10.0f, out[3];
    t = t > 1 ? 1 : t > 0 ? t : 0;
    for (int i = 0; i < 3; i++)
        out[i] = t > 0 ? f[i] * ((1 - t) * b) + w[i] * (t * a) : f[i];
    const int open = openness(fine), both = openness(8 * wide_value - fine + 6152);
    return ost_octahedral_of(out) | (uint32_t)((float)open + (float)(both - open) * t + 0.5f) << OST_OPEN_SHIFT;
}

static uint32_t shade_of(const ost_volume *v, int i, int j, int k)
{
    const uint32_t open = faces(v, i, j, k);
    const float f[3] = {
        (float)(field(v, i - 1, j, k) - field(v, i + 1, j, k) + 160 * ((int)(open >> 1 & 1) - (int)(open & 1))),
        (float)(field(v, i, j - 1, k) - field(v, i, j + 1, k) + 160 * ((int)(open >> 3 & 1) - (int)(open >> 2 & 1))),
        (float)(field(v, i, j, k - 1) - field(v, i, j, k + 1) + 160 * ((int)(open >> 5 & 1) - (int)(open >> 4 & 1)))};
    const float w[3] = {(float)(wide(v, i - 1, j, k) - wide(v, i + 1, j, k)),
                        (float)(wide(v, i, j - 1, k) - wide(v, i, j + 1, k)),
                        (float)(wide(v, i, j, k - 1) - wide(v, i, j, k + 1))};
    return shade_from(f, w, field(v, i, j, k), wide(v, i, j, k));
}

static void assert_surface(const ost_surface *s, const ost_volume *v)
{
    uint64_t count = 0, found = 0;
    for (int k = 0; k < v->geometry.dims.z; k++)
        for (int j = 0; j < v->geometry.dims.y; j++)
            for (int i = 0; i < v->geometry.dims.x; i++)
                count += active(v, i, j, k) && faces(v, i, j, k);
    for (int32_t b = 0; b < s->used; b++) {
        const ost_surface_block *block = s->slot[b];
        for (uint32_t p = 0; p < block->count; p++, found++) {
            const uint32_t w = block->points[p];
            const int i = 32 * block->at[0] + (int)(w & 31), j = 32 * block->at[1] + (int)(w >> 5 & 31),
                      k = 32 * block->at[2] + (int)(w >> 10 & 31);
            assert_true(active(v, i, j, k));
            assert_int_equal(w >> OST_FACES_SHIFT, faces(v, i, j, k));
            if (p % 199 == 0)
                assert_int_equal(block->shades[p], shade_of(v, i, j, k));
            assert_true(p == 0 || (block->points[p - 1] & 0x7fff) < (w & 0x7fff));
        }
    }
    assert_int_equal(found, count);
    assert_int_equal(s->points, count);
}

static void test_surface(void **state)
{
    (void)state;
    ost_error err = {0};
    test_rng rng = rng_seeded("surface");
    ost_volume v = pitted_ball(&rng, 70, 64, 41);
    ost_surface s;
    assert_ok(ost_surface_init(&s, &v.geometry, &err));
    assert_ok(ost_surface_set_volume(&s, &v, 120, &err));
    assert_ok(ost_surface_update(&s, &err));
    assert_surface(&s, &v);
    /* Complete planes of voxels are removed and restored, so that neighbouring blocks must be updated. */
    for (int round = 0; round < 12; round++) {
        const int axis = (int)rng_range(&rng, 0, 2), at = (int)rng_range(&rng, 0, 63);
        const int16_t value = rng_range(&rng, 0, 2) ? 0 : 500;
        for (int k = 0; k < 41; k++)
            for (int j = 0; j < 64; j++)
                for (int i = 0; i < 70; i++)
                    if ((axis == 0 ? i : axis == 1 ? j : k) == at)
                        v.voxels[i + 70 * (j + 64 * k)] = value;
        assert_ok(ost_surface_set_volume(&s, &v, 120, &err));
        assert_ok(ost_surface_update(&s, &err));
        assert_surface(&s, &v);
    }
    ost_surface_free(&s);
    ost_volume_free(&v);
}

/* A direction that is encoded and decoded may deviate from the original by at most 2.2 degrees. */
static void test_octahedral(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("octahedral");
    for (int i = 0; i < 20000; i++) {
        float v[3], w[3], length = 0, cosine = 0;
        for (int a = 0; a < 3; a++) {
            v[a] = (float)rng_range(&rng, -1000, 1000);
            length += v[a] * v[a];
        }
        if (length == 0)
            continue;
        ost_octahedral_vector(ost_octahedral_of(v), w);
        for (int a = 0; a < 3; a++)
            cosine += v[a] * w[a] / sqrtf(length);
        assert_true(cosine > 0.9993f);
    }
}

static void test_not_cubic(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_geometry g = grid(8, 8, 8);
    ost_surface s;
    g.spacing.z *= 2;
    assert_int_equal(ost_surface_init(&s, &g, &err), OST_ERR_RANGE);
    assert_non_null(strstr(err.text, "cubic"));
    ost_surface_free(&s);
}

/* ---------------------------------------------------------------- pictures */

typedef struct scene {
    ost_volume volume;
    ost_surface surface;
} scene;

static void make_scene(scene *s, test_rng *rng, int x, int y, int z)
{
    ost_error err = {0};
    s->volume = pitted_ball(rng, x, y, z);
    assert_ok(ost_surface_init(&s->surface, &s->volume.geometry, &err));
    assert_ok(ost_surface_set_volume(&s->surface, &s->volume, 120, &err));
    assert_ok(ost_surface_update(&s->surface, &err));
}

static void free_scene(scene *s)
{
    ost_surface_free(&s->surface);
    ost_volume_free(&s->volume);
}

static ost_camera camera_at(const ost_volume *v, test_rng *rng, double distance, int width, int height,
                            int32_t focal_milli)
{
    ost_error err = {0};
    ost_camera c = {.focal_milli = focal_milli, .width = width, .height = height};
    const ost_dims d = v->geometry.dims;
    const double centre[3] = {0.5 * d.x - 3, 0.5 * d.y, 0.5 * d.z + 7};
    double from[3], up[3];
    for (int a = 0; a < 3; a++) {
        from[a] = centre[a] + distance * ((double)rng_range(rng, 0, 2000) / 1000.0 - 1);
        up[a] = (double)rng_range(rng, 0, 2000) / 1000.0 - 1;
    }
    from[0] += distance;
    assert_ok(ost_camera_look_at(from, centre, up, &c, &err));
    assert_ok(ost_camera_check(&c, &err));
    return c;
}

/*
 * Returns true if the complete cube around voxel v lies beyond the near plane by more than `by` voxels,
 * so that the voxel is drawn.
 */
static bool beyond_near(const ost_eye *e, const int v[3], double by)
{
    double z = -(double)e->near;
    for (int a = 0; a < 3; a++)
        z += (v[a] - (double)e->at[a]) * (double)e->forward[a] - 0.5 * fabs((double)e->forward[a]);
    return z > by;
}

/*
 * Returns true if the ray of a pixel, computed in doubles, intersects the cube around voxel v, enlarged by
 * `grow`.
 */
static bool meets(const ost_eye *e, double x, double y, const int v[3], double grow)
{
    double in = -1e300, out = 1e300;
    for (int a = 0; a < 3; a++) {
        const double d = (double)e->focal * (double)e->forward[a] +
                         (x + 0.5 - (double)e->half_w) * (double)e->right[a] -
                         (y + 0.5 - (double)e->half_h) * (double)e->up[a];
        const double o = v[a] - (double)e->at[a], t0 = (o - 0.5 - grow) / d, t1 = (o + 0.5 + grow) / d;
        in = fmax(in, fmin(t0, t1));
        out = fmin(out, fmax(t0, t1));
    }
    return in <= out;
}

/* Returns true if the ray enters the cube well inside a face. Near an edge, either of the two faces would be
   correct. */
static bool clear_of_edges(const ost_eye *e, double x, double y, const int v[3])
{
    double best = -1e300, second = -1e300, square = 0;
    for (int a = 0; a < 3; a++) {
        const double d = (double)e->focal * (double)e->forward[a] +
                         (x + 0.5 - (double)e->half_w) * (double)e->right[a] -
                         (y + 0.5 - (double)e->half_h) * (double)e->up[a];
        const double in = (v[a] - (double)e->at[a]) / d - 0.5 / fabs(d);
        second = in > best ? best : fmax(second, in);
        best = fmax(best, in);
        square += d * d;
    }
    return (best - second) * sqrt(square) > 1e-2;
}

enum { NO_VOXEL = 0x7fffffff };

/* Returns the number of the voxel that the pixel `at` shows, or NO_VOXEL if the pixel shows no face. */
static uint32_t id_at(const ost_frame *f, size_t at)
{
    const ost_visible *v = &f->layer[0].visible;
    return f->planes.face[at] == OST_NO_FACE ? NO_VOXEL
                                             : (uint32_t)v->seen[ost_visible_index(v, (uint32_t)f->planes.key[at])];
}

/*
 * Compares each pixel with the nearest voxel on the pixel's ray. If slightly smaller and slightly larger
 * cubes give different voxels, the result depends on rounding, and the pixel is not compared. There are few
 * such pixels.
 */
static void assert_picture(const scene *s, const ost_frame *f, const ost_eye *e, int *checked, int *doubtful)
{
    for (int y = 0; y < f->height; y++)
        for (int x = 0; x < f->width; x++) {
            double best[2] = {1e300, 1e300};
            int who[2][3] = {{-1, -1, -1}, {-1, -1, -1}};
            for (int32_t b = 0; b < s->surface.used; b++)
                for (uint32_t p = 0; p < s->surface.slot[b]->count; p++) {
                    const uint32_t w = s->surface.slot[b]->points[p];
                    const int32_t *at = s->surface.slot[b]->at;
                    const int v[3] = {32 * at[0] + (int)(w & 31), 32 * at[1] + (int)(w >> 5 & 31),
                                      32 * at[2] + (int)(w >> 10 & 31)};
                    double square = 0;
                    for (int a = 0; a < 3; a++)
                        square += (v[a] - (double)e->at[a]) * (v[a] - (double)e->at[a]);
                    for (int grown = 0; grown < 2; grown++)
                        if (square < best[grown] && beyond_near(e, v, grown ? -1e-3 : 1e-3) &&
                            meets(e, x, y, v, grown ? 2e-3 : -2e-3)) {
                            best[grown] = square;
                            memcpy(who[grown], v, sizeof v);
                        }
                }
            if (memcmp(who[0], who[1], sizeof who[0]) != 0) {
                ++*doubtful;
                continue;
            }
            const size_t at = (size_t)y * (size_t)f->planes.stride + (size_t)x;
            const uint32_t id = id_at(f, at);
            if (who[0][0] < 0) {
                assert_int_equal(id, NO_VOXEL);
                assert_int_equal(f->planes.face[at], OST_NO_FACE);
                continue;
            }
            ++*checked;
            assert_int_not_equal(id, NO_VOXEL);
            const int32_t *block = s->surface.slot[id >> OST_LOCAL_BITS]->at;
            assert_int_equal(32 * block[0] + (int)(id & 31), who[0][0]);
            assert_int_equal(32 * block[1] + (int)(id >> 5 & 31), who[0][1]);
            assert_int_equal(32 * block[2] + (int)(id >> 10 & 31), who[0][2]);
            /* The face must border on air, and the depth of the pixel must be a depth on this face. */
            const int face = f->planes.face[at];
            assert_in_range(face, 0, 5);
            if (clear_of_edges(e, x, y, who[0]))
                assert_true(faces(&s->volume, who[0][0], who[0][1], who[0][2]) >> face & 1);
            const double along = (double)f->planes.depth[at] / (double)e->focal;
            const double d = (double)e->focal * (double)e->forward[face / 2] +
                             (x + 0.5 - (double)e->half_w) * (double)e->right[face / 2] -
                             (y + 0.5 - (double)e->half_h) * (double)e->up[face / 2];
            assert_float_equal((float)((double)e->at[face / 2] + along * d),
                               (float)(who[0][face / 2] + (face % 2 ? 0.5 : -0.5)), 2e-3f);
        }
}

static void test_against_rays(void **state)
{
    (void)state;
    ost_error err = {0};
    test_rng rng = rng_seeded("rays");
    scene s;
    int checked = 0, doubtful = 0;
    make_scene(&s, &rng, 37, 34, 40);
    for (int round = 0; round < 5; round++) {
        static const double distance[5] = {60, 30, 22, 300, 16};
        ost_camera c;
        ost_eye e;
        /* The camera is outside the body. Inside the body, the near plane would expose faces that do not border on
           air. */
        do {
            c = camera_at(&s.volume, &rng, distance[round], 33 + 7 * round, 29, round == 3 ? 300000 : 30000);
            e = ost_eye_make(&c, &s.volume.geometry);
        } while (hypotf(e.at[0] - 18, hypotf(e.at[1] - 17, e.at[2] - 20)) < 22);
        ost_frame f;
        assert_ok(ost_frame_init(&f, c.width, c.height, OST_STYLE_SMOOTH, OST_ISA_SCALAR, 1, &err));
        assert_ok(ost_frame_store_keys(&f, &err));
        assert_ok(ost_frame_draw(&f, &s.surface, &e, &err));
        assert_picture(&s, &f, &e, &checked, &doubtful);
        ost_frame_free(&f);
    }
    assert_true(checked > 300);
    assert_true(doubtful * 10 < checked);
    free_scene(&s);
}

static void assert_same(const ost_frame *a, const ost_frame *b)
{
    for (int y = 0; y < a->height; y++) {
        const size_t at = (size_t)y * (size_t)a->planes.stride, n = (size_t)a->width;
        assert_memory_equal(a->planes.colour + at, b->planes.colour + at, n * sizeof *a->planes.colour);
        assert_memory_equal(a->planes.face + at, b->planes.face + at, n);
        for (size_t x = 0; x < n; x++)
            if (a->planes.face[at + x] != OST_NO_FACE) {
                if (a->planes.key && b->planes.key)
                    assert_memory_equal(a->planes.key + at + x, b->planes.key + at + x, sizeof(uint64_t));
                assert_memory_equal(a->planes.depth + at + x, b->planes.depth + at + x, sizeof(float));
            }
    }
}

/* The camera is far from the body, near it, at its edge, or inside it. With every instruction set and number of
   threads, the picture must equal that of the scalar functions. */
static void test_sets_and_threads(void **state)
{
    (void)state;
    ost_error err = {0};
    test_rng rng = rng_seeded("sets");
    scene s;
    make_scene(&s, &rng, 90, 75, 101);
    for (int round = 0; round < 24; round++) {
        const double distance = round % 4 == 0 ? 400 : round % 4 == 1 ? 120 : round % 4 == 2 ? 40 : 8;
        const ost_camera c = camera_at(&s.volume, &rng, distance, 17 + (int)rng_range(&rng, 0, 299),
                                       11 + (int)rng_range(&rng, 0, 199), 20000 + (int)rng_range(&rng, 0, 399999));
        const ost_eye e = ost_eye_make(&c, &s.volume.geometry);
        const ost_style style = round % 5 ? OST_STYLE_SMOOTH : OST_STYLE_FACES;
        ost_frame scalar;
        assert_ok(ost_frame_init(&scalar, c.width, c.height, style, OST_ISA_SCALAR, 1, &err));
        assert_ok(ost_frame_store_keys(&scalar, &err));
        assert_ok(ost_frame_draw(&scalar, &s.surface, &e, &err));
        for (int isa = 0; isa < OST_ISA_COUNT; isa++) {
            if (!ost_isa_available((ost_isa)isa))
                continue;
            ost_frame f;
            assert_ok(ost_frame_init(&f, c.width, c.height, style, (ost_isa)isa, 1 + round % 3, &err));
            for (int again = 0; again < 2; again++) {
                assert_ok(ost_frame_draw(&f, &s.surface, &e, &err));
                if (again == 0) {
                    assert_same(&scalar, &f);
                    assert_ok(ost_frame_store_keys(&f, &err));
                }
            }
            assert_same(&scalar, &f);
            ost_frame_free(&f);
        }
        ost_frame_free(&scalar);
    }
    free_scene(&s);
}

/*
 * The inputs and outputs of the functions that compute shades. With every instruction set, the results for random
 * inputs of every size are compared with weighted sums.
 */
typedef struct words {
    uint8_t cells[3][28 * OST_CELLS], mean[OST_CELLS];
    uint16_t bone[OST_FIELD_BONE + 2][OST_FIELD_LINE], down[OST_FIELD_ROWS][OST_FIELD_LINE], line[OST_FIELD_LINE];
    ost_field_slice y[9], field[3], wide[3];
    uint64_t row[OST_FIELD_BONE];
    int16_t density[OST_FIELD_LINE];
} words;

static void fill(test_rng *rng, void *at, size_t count, int most)
{
    uint16_t *v = at;
    for (size_t i = 0; i < count; i++)
        v[i] = (uint16_t)rng_range(rng, 0, most);
}

static const int weight[9] = {1, 2, 3, 4, 5, 4, 3, 2, 1};

static void assert_sums(test_rng *rng, const ost_smooth_kernels *k, words *w)
{
    const int first = (int)rng_range(rng, 0, OST_FIELD_ROWS - 1),
              count = (int)rng_range(rng, 1, OST_FIELD_ROWS - first);
    fill(rng, w->bone, sizeof w->bone / 2, 2600);
    k->down((const uint16_t(*)[OST_FIELD_LINE])w->bone + first, w->down + first, count);
    for (int y = first; y < first + count; y++)
        for (int x = 0; x < OST_FIELD_LINE; x++) {
            int sum = 0;
            for (int j = 0; j < 9; j++)
                sum += weight[j] * w->bone[y + j][x];
            assert_int_equal(w->down[y][x], sum);
        }
    const ost_field_slice *y[9];
    const uint64_t rows = (uint64_t)rng_range(rng, 0, (INT64_C(1) << OST_FIELD_ROWS) - 1);
    for (int z = 0; z < 9; z++)
        y[z] = &w->y[(z + first) % 9];
    fill(rng, w->y, sizeof w->y / 2, 1575);
    memset(w->field[0], 0xff, sizeof w->field[0]);
    k->slice(y, rows, &w->field[0]);
    for (int j = 0; j < OST_FIELD_ROWS; j++)
        for (int x = 0; x < OST_FIELD_ROWS; x++) {
            int sum = 0;
            for (int i = 0; i < 9; i++) {
                int slice = 0;
                for (int z = 0; z < 9; z++)
                    slice += weight[z] * (*y[z])[j][x + 3 + i];
                sum += weight[i] * ((slice + 8) / 16);
            }
            assert_int_equal(w->field[0][j][x], rows >> j & 1 ? sum : 0xffff);
        }
}

static void assert_bone(test_rng *rng, const ost_smooth_kernels *k, words *w, bool wild)
{
    for (int i = 0; i < OST_FIELD_BONE; i++)
        w->row[i] = (uint64_t)rng_range(rng, 0, INT64_MAX) << 1;
    k->bits(w->row, OST_FIELD_BONE, w->bone);
    for (int i = 0; i < OST_FIELD_BONE; i++)
        for (int x = 0; x < OST_FIELD_LINE; x++)
            assert_int_equal(w->bone[i][x], w->row[i] >> (x + 8) & 1 ? 63 : 0);
    const uint64_t row = w->row[0], near = w->row[1] & row << 3;
    for (int i = 0; i < OST_FIELD_LINE; i++)
        w->density[i] = (int16_t)rng_range(rng, wild ? INT16_MIN : -40, wild ? INT16_MAX : 800);
    k->densities(row, near, w->density, w->line);
    for (int i = 0; i < OST_FIELD_LINE; i++) {
        const int v = w->density[i], some = v < 0 ? 15 : v / 16 < 48 ? 15 + v / 16 : 63;
        assert_int_equal(w->line[i], row >> (i + 8) & 1 ? (near >> (i + 8) & 1 ? 63 : some) : 0);
    }
}

/*
 * Compares the results of three functions with simple implementations: `cells` computes means of 2^3 words, `lines`
 * joins the rows of three blocks, and `finer` interpolates between two slices.
 */
static void assert_cells(test_rng *rng, const ost_smooth_kernels *k, words *w)
{
    const int count = (int)rng_range(rng, 1, 26), odd = (int)rng_range(rng, 0, 1);
    fill(rng, w->bone, sizeof w->bone / 2, 63);
    k->cells((const uint16_t(*)[OST_FIELD_LINE])w->bone, (const uint16_t(*)[OST_FIELD_LINE])w->bone + 7, w->mean);
    for (int x = 0; x < OST_CELLS; x++) {
        int sum = 0;
        for (int i = 0; i < 8; i++)
            sum += w->bone[(i & 1) + 7 * (i >> 1 & 1)][8 + 2 * x + (i >> 2)];
        assert_int_equal(w->mean[x], (sum + 4) / 8);
    }
    for (int i = 0; i < 3; i++)
        for (int c = 0; c < 28 * OST_CELLS; c++)
            w->cells[i][c] = (uint8_t)rng_range(rng, 0, 63);
    k->lines(w->cells[0], w->cells[1], w->cells[2], count, w->bone);
    for (int row = 0; row < count; row++)
        for (int x = -5; x < OST_CELLS + 5; x++)
            assert_int_equal(w->bone[row][x + 8], w->cells[(x + 16) / 16][OST_CELLS * row + (x & 15)]);
    const ost_field_slice *const both[2] = {&w->y[4], &w->y[2]};
    const uint64_t rows = (uint64_t)rng_range(rng, 1, (INT64_C(1) << OST_FIELD_ROWS) - 1);
    fill(rng, w->y, sizeof w->y / 2, 61525);
    memset(w->field[0], 0xff, sizeof w->field[0]);
    k->finer(both, odd, rows, &w->field[0]);
    for (int y = 0; y < OST_FIELD_ROWS; y++)
        for (int x = 0; x < OST_FIELD_ROWS; x++) {
            int value[2][2][2]; /* indices x, y, z; 0 is the nearer cell, 1 the farther cell */
            for (int i = 0; i < 8; i++)
                value[i & 1][i >> 1 & 1][i >> 2] =
                    ((*both[(i >> 2) ^ odd])[y / 2 + ((i >> 1 & 1) ^ (y & 1))][x / 2 + ((i & 1) ^ (x & 1))] + 2) / 4;
            int along_x[2];
            for (int i = 0; i < 2; i++) {
                const int along_z[2] = {(3 * value[i][0][0] + value[i][0][1] + 2) / 4,
                                        (3 * value[i][1][0] + value[i][1][1] + 2) / 4};
                along_x[i] = (3 * along_z[0] + along_z[1] + 2) / 4;
            }
            assert_int_equal(w->field[0][y][x], rows >> y & 1 ? (3 * along_x[0] + along_x[1] + 2) / 4 : 0xffff);
        }
}

/*
 * Compares shades for slopes of all sizes, including zero. The two slopes agree in some cases and disagree
 * in others. The number of points per call is random.
 */
static void assert_shades(test_rng *rng, const ost_smooth_kernels *k, words *w, int flat)
{
    enum { COUNT = 53 };
    uint32_t points[COUNT], shades[COUNT + OST_SHADING_SLACK];
    const ost_field_slice *const fine[3] = {&w->field[0], &w->field[1], &w->field[2]}, *const coarse[3] = {&w->wide[0],
                                                                                                           &w->wide[1],
                                                                                                           &w->wide[2]};
    const int count = (int)rng_range(rng, 1, COUNT);
    fill(rng, w->field, sizeof w->field / 2, flat ? flat : 61525);
    for (size_t i = 0; i < sizeof w->wide / 2; i++) {
        const uint16_t *from = &w->field[0][0][0];
        ((uint16_t *)w->wide)[i] = (uint16_t)(from[i] / 4 * (flat > 1 ? 0.5 : 0.7) +
                                              (double)rng_range(rng, 0, flat > 1 ? 40 : 4000));
    }
    for (int i = 0; i < count; i++)
        points[i] = (uint32_t)rng_range(rng, 0, (1 << 21) - 1);
    k->shades(points, count, fine, coarse, shades);
    for (int i = 0; i < count; i++) {
        const int x = 1 + (int)(points[i] & 31), y = 1 + (int)(points[i] >> 5 & 31),
                  f = (int)(points[i] >> OST_FACES_SHIFT);
        const float out[3] = {
            (float)(w->field[1][y][x - 1] - w->field[1][y][x + 1] + 160 * ((f >> 1 & 1) - (f & 1))),
            (float)(w->field[1][y - 1][x] - w->field[1][y + 1][x] + 160 * ((f >> 3 & 1) - (f >> 2 & 1))),
            (float)(w->field[0][y][x] - w->field[2][y][x] + 160 * ((f >> 5 & 1) - (f >> 4 & 1)))};
        const float broad[3] = {(float)(w->wide[1][y][x - 1] - w->wide[1][y][x + 1]),
                                (float)(w->wide[1][y - 1][x] - w->wide[1][y + 1][x]),
                                (float)(w->wide[0][y][x] - w->wide[2][y][x])};
        assert_int_equal(shades[i], shade_from(out, broad, w->field[1][y][x], w->wide[1][y][x]));
    }
}

static void test_smooth(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("smooth");
    words *w = calloc(1, sizeof *w);
    assert_non_null(w);
    for (int isa = 0; isa < OST_ISA_COUNT; isa++) {
        if (!ost_isa_available((ost_isa)isa))
            continue;
        const ost_smooth_kernels k = ost_smooth_kernels_of((ost_isa)isa);
        for (int round = 0; round < 60; round++) {
            assert_sums(&rng, &k, w);
            assert_bone(&rng, &k, w, round % 2);
            assert_cells(&rng, &k, w);
            assert_shades(&rng, &k, w, round % 3 ? 0 : round % 2 ? 300 : 1);
        }
    }
    free(w);
}

/* Returns the occupancy bit of voxel (x, y, z). The voxel may lie in the middle block or in one of its neighbours. */
static bool bit_at(uint32_t block[3][3][3][OST_BLOCK_ROWS], int x, int y, int z)
{
    return block[(z + 32) / 32][(y + 32) / 32][(x + 32) / 32][(y & 31) + 32 * (z & 31)] >> (x & 31) & 1;
}

static void test_rows(void **state)
{
    (void)state;
    static const int reaches[] = {1, 3, 11, 14},
                     step[6][3] = {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}};
    static uint32_t block[3][3][3][OST_BLOCK_ROWS], points[32 * OST_BLOCK_ROWS + OST_POINT_SLACK],
        behind[OST_BLOCK_ROWS];
    static ost_rows rows, other, first;
    static ost_faces faces;
    static ost_rim rim;
    test_rng rng = rng_seeded("rows");
    for (int round = 0; round < 4; round++) {
        for (int i = 0; i < 27; i++)
            /* the block has many holes, is nearly solid, or is nearly empty */
            for (int row = 0; row < OST_BLOCK_ROWS; row++) {
                uint32_t w = (uint32_t)rng_range(&rng, 0, UINT32_MAX);
                for (int more = 0; more < 4; more++)
                    w = round == 1  ? w | (uint32_t)rng_range(&rng, 0, UINT32_MAX)
                        : round > 1 ? w & (uint32_t)rng_range(&rng, 0, UINT32_MAX)
                                    : w;
                block[i / 9][i / 3 % 3][i % 3][row] = round == 3 && rng_range(&rng, 0, 60) ? 0 : w;
            }
        rim.left = block[1][1][0];
        rim.right = block[1][1][2];
        for (int z = -1; z <= 32; z++)
            for (int y = -1; y <= 32; y++)
                rim.row[z + 1][y + 1] = block[(z + 32) / 32][(y + 32) / 32][1][(y & 31) + 32 * (z & 31)];
        for (int isa = 0; isa < OST_ISA_COUNT; isa++) {
            if (!ost_isa_available((ost_isa)isa))
                continue;
            const ost_row_kernels k = ost_row_kernels_of((ost_isa)isa);
            k.faces(&rim, &faces);
            k.behind(&rim, &faces, behind);
            k.points(&faces, points);
            uint32_t count = 0;
            for (int row = 0; row < OST_BLOCK_ROWS; row++) {
                assert_int_equal(faces.begin[row], count);
                for (int x = 0; x < 32; x++) {
                    uint32_t mask = 0;
                    for (int f = 0; f < 6 && bit_at(block, x, row % 32, row / 32); f++)
                        mask |= (uint32_t)!bit_at(block, x + step[f][0], row % 32 + step[f][1], row / 32 + step[f][2])
                                << f;
                    if (mask)
                        assert_int_equal(points[count++], (uint32_t)x | (uint32_t)row << 5 | mask << OST_FACES_SHIFT);
                    assert_int_equal(faces.any[row] >> x & 1, mask != 0);
                }
                assert_int_equal(behind[row], 0);
            }
            assert_int_equal(faces.begin[OST_BLOCK_ROWS], count);
            /* If all faces are marked as bordering on air, `behind` must contain exactly the voxels with an active
               neighbour. */
            memset(faces.face, 0xff, sizeof faces.face);
            k.behind(&rim, &faces, behind);
            for (int cell = 0; cell < 32 * OST_BLOCK_ROWS; cell += 5) {
                const int x = cell % 32, y = cell / 32 % 32, z = cell / 1024;
                bool any = false;
                for (int f = 0; f < 6; f++)
                    any |= bit_at(block, x + step[f][0], y + step[f][1], z + step[f][2]);
                assert_int_equal(behind[y + 32 * z] >> x & 1, any);
            }
            for (int z = -8; z < 40; z++)
                for (int y = -8; y < 40; y += 8) {
                    const uint32_t(*const n)[OST_BLOCK_ROWS] = (const uint32_t(*)[OST_BLOCK_ROWS])
                        block[(z + 32) / 32][(y + 32) / 32];
                    const int row = (y & 31) + 32 * (z & 31);
                    k.join(n[0] + row, n[1] + row, n[2] + row, rows.row[z + OST_SHADING_REACH] + y + OST_SHADING_REACH,
                           8);
                }
            for (int i = 0; i < 2000; i++) {
                const int x = (int)rng_range(&rng, -16, 47), y = (int)rng_range(&rng, -8, 39),
                          z = (int)rng_range(&rng, -8, 39);
                assert_int_equal(rows.row[z + OST_SHADING_REACH][y + OST_SHADING_REACH] >> (x + 16) & 1,
                                 bit_at(block, x, y, z));
            }
            const int reach = reaches[(round + isa) % 4];
            memset(&rows, 0, sizeof rows);
            for (int i = 0; i < 30 << 2 * round; i++)
                rows.row[rng_range(&rng, 0, OST_SEEN - 1)][rng_range(&rng, 0, OST_SEEN - 1)] |= UINT64_C(1)
                                                                                                << rng_range(&rng, 0,
                                                                                                             63);
            first = rows;
            k.spread(&rows, &other, reach);
            for (int z = reach; z < OST_SEEN - reach; z++)
                for (int y = reach; y < OST_SEEN - reach; y++) {
                    uint64_t near = 0;
                    for (int i = -reach; i <= reach; i++)
                        for (int j = -reach; j <= reach; j++)
                            near |= first.row[z + i][y + j];
                    uint64_t wide = near;
                    for (int x = 1; x <= reach; x++)
                        wide |= near << x | near >> x;
                    assert_true(rows.row[z][y] << reach >> 2 * reach == wide << reach >> 2 * reach);
                }
        }
    }
}

/*
 * For every instruction set, compares the light and the colours of random shades with the results of the scalar
 * functions.
 */
static void test_tints(void **state)
{
    (void)state;
    enum { COUNT = 16 * 64 };
    ost_error err = {0};
    test_rng rng = rng_seeded("tints");
    static ost_light light, other;
    static ost_directions directions;
    uint32_t palette[OST_PAINTS], shade_of[COUNT], one[COUNT], many[COUNT];
    ost_camera c = {.focal_milli = 100000, .width = 64, .height = 64};
    const ost_geometry g = grid(8, 8, 8);
    ost_eye eye;
    ost_directions_make(&directions);
    ost_light_shade_of *const plain = directions.shade;
    for (int i = 0; i < OST_PAINTS; i++)
        palette[i] = (uint32_t)rng_range(&rng, 0, 0xffffff);
    for (int round = 0; round < 40; round++) {
        const double from[3] = {(double)rng_range(&rng, 10, 90), (double)rng_range(&rng, -90, 90),
                                (double)rng_range(&rng, -90, 90)};
        assert_ok(ost_camera_look_at(from, (double[3]){0, 0, 0}, (double[3]){0, 0, 1}, &c, &err));
        eye = ost_eye_make(&c, &g);
        directions.shade = plain;
        ost_light_make(&light, &directions, &eye, round % 5 ? OST_STYLE_SMOOTH : OST_STYLE_FACES,
                       round % 2 ? OST_PAINT_STEEL : OST_PAINT_BONE, round % 3 ? palette : NULL);
        for (int i = 0; i < COUNT; i++)
            shade_of[i] = (uint32_t)rng_range(&rng, 0, round % 4 ? INT32_MAX : (1 << OST_PAINT_SHIFT) - 1);
        ost_light_tint(&light, shade_of, COUNT, one);
        for (int isa = 0; isa < OST_ISA_COUNT; isa++)
            if (ost_isa_available((ost_isa)isa)) {
                directions.shade = ost_light_shade_for((ost_isa)isa);
                other.made = false;
                ost_light_make(&other, &directions, &eye, OST_STYLE_SMOOTH,
                               round % 2 ? OST_PAINT_STEEL : OST_PAINT_BONE, NULL);
                assert_memory_equal(light.shade, other.shade, sizeof light.shade);
                ost_light_tint_for((ost_isa)isa)(&light, shade_of, COUNT, many);
                assert_memory_equal(one, many, sizeof one);
            }
    }
}

static void test_camera(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_camera c = {.focal_milli = 1000000, .width = 100, .height = 100};
    const double origin[3] = {0, 0, 0}, up[3] = {0, 0, 1};
    assert_ok(ost_camera_look_at((double[3]){0, -10, 0}, origin, up, &c, &err));
    const ost_geometry g = {{4, 4, 4}, {OST_PM_PER_MM / 2, OST_PM_PER_MM / 2, OST_PM_PER_MM / 2}, {0, 0, 0}};
    const ost_eye e = ost_eye_make(&c, &g);
    const float at[3] = {0, -20, 0}, right[3] = {1, 0, 0}, above[3] = {0, 0, 1}, forward[3] = {0, 1, 0};
    for (int a = 0; a < 3; a++) {
        assert_float_equal(e.at[a], at[a], 0);
        assert_float_equal(e.right[a], right[a], 1e-6f);
        assert_float_equal(e.up[a], above[a], 1e-6f);
        assert_float_equal(e.forward[a], forward[a], 1e-6f);
    }
    assert_int_equal(ost_camera_look_at(origin, origin, up, &c, &err), OST_ERR_RANGE);
    assert_int_equal(ost_camera_look_at((double[3]){0, 0, 5}, origin, up, &c, &err), OST_ERR_RANGE);
    c.focal_milli = 999;
    assert_int_equal(ost_camera_check(&c, &err), OST_ERR_RANGE);
    c.focal_milli = 1000;
    c.width = OST_FRAME_MAX + 1;
    assert_int_equal(ost_camera_check(&c, &err), OST_ERR_RANGE);
}

static void test_picture(void **state)
{
    (void)state;
    ost_error err = {0};
    test_rng rng = rng_seeded("picture");
    ost_volume v = pitted_ball(&rng, 40, 40, 40);
    ost_camera c = {.focal_milli = 100000, .width = 64, .height = 48};
    ost_picture smooth, faces;
    ost_points_options options = {.style = OST_STYLE_FACES, .threads = 2};
    assert_ok(ost_camera_look_at((double[3]){17, -60, 27}, (double[3]){17, 20, 27}, (double[3]){0, 0, 1}, &c, &err));
    assert_ok(ost_picture_points(&v, &c, NULL, &smooth, &err));
    assert_ok(ost_picture_points(&v, &c, &options, &faces, &err));
    /* The ball is in the middle, and the corners are background; the light comes from the upper left. */
    const size_t middle = 3 * (24 * 64 + 32), corner = 0, lit = 3 * (16 * 64 + 24), dark = 3 * (34 * 64 + 42);
    assert_memory_equal(smooth.rgb + corner, ((uint8_t[3]){0x16, 0x18, 0x1c}), 3);
    assert_true(smooth.rgb[middle] > 90 && faces.rgb[middle] > 90);
    assert_true(smooth.rgb[lit] > smooth.rgb[dark]);
    assert_memory_not_equal(smooth.rgb, faces.rgb, (size_t)3 * 64 * 48);
    ost_picture_free(&smooth);
    ost_picture_free(&faces);
    /* If no voxel reaches the threshold, there must be only background. */
    options.threshold = 2000;
    assert_ok(ost_picture_points(&v, &c, &options, &faces, &err));
    for (size_t i = 0; i < (size_t)64 * 48; i++)
        assert_memory_equal(faces.rgb + 3 * i, ((uint8_t[3]){0x16, 0x18, 0x1c}), 3);
    ost_picture_free(&faces);
    options.isa = "mmx";
    assert_int_equal(ost_picture_points(&v, &c, &options, &faces, &err), OST_ERR_USAGE);
    assert_null(faces.rgb);
    c.pose.t.x = 4000 * OST_PM_PER_MM;
    v.geometry.spacing = (ost_pm3){OST_PM_PER_MM / 20, OST_PM_PER_MM / 20, OST_PM_PER_MM / 20};
    assert_int_equal(ost_picture_points(&v, &c, NULL, &faces, &err), OST_ERR_RANGE);
    assert_non_null(strstr(err.text, "voxels away"));
    ost_volume_free(&v);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_surface),      cmocka_unit_test(test_not_cubic),
        cmocka_unit_test(test_camera),       cmocka_unit_test(test_octahedral),
        cmocka_unit_test(test_smooth),       cmocka_unit_test(test_rows),
        cmocka_unit_test(test_tints),        cmocka_unit_test(test_picture),
        cmocka_unit_test(test_against_rays), cmocka_unit_test(test_sets_and_threads),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
