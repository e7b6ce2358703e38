/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Compares pictures with golden hashes. A hash is computed from the voxel and the face that each pixel shows. The
 * hashes were computed with the function walk() in this file, which follows a ray through each pixel's middle from
 * voxel to voxel of the dense volume, in doubles. Unlike the renderer, walk() uses no points, rectangles, drawing order
 * or lists. The test repeats the walk, which must give the same hash. The renderer must give the same hash with every
 * instruction set and number of threads. Pixels whose rays pass within a thousandth of a pixel of an edge are not part
 * of the hash. The walk finds these pixels; they are fewer than one in a hundred.
 *
 * Covers: REQ-VIEWER
 */
#include <inttypes.h>
#include <math.h>

#include "harness.h"
#include "render/points/frame.h"

#define MM OST_PM_PER_MM

enum { W = 200, H = 150 };

/* -------------------------------------------------------------------- scene */

static ost_volume volume_of(int x, int y, int z, ost_pm spacing, bool (*solid)(int i, int j, int k))
{
    ost_error err = {0};
    ost_volume v;
    const ost_geometry g = {{x, y, z}, {spacing, spacing, spacing}, {0, 0, 0}};
    assert_ok(ost_volume_init(&v, &g, &err));
    for (int k = 0; k < z; k++)
        for (int j = 0; j < y; j++)
            for (int i = 0; i < x; i++)
                v.voxels[i + (size_t)x * ((size_t)j + (size_t)y * (size_t)k)] = solid(i, j, k) ? 700 : 0;
    return v;
}

static int square(int a)
{
    return a * a;
}

/* Returns true if voxel (i, j, k) belongs to a ball with a bowl at the front, a hole in the bowl, and pores. */
static bool bone(int i, int j, int k)
{
    const uint32_t pore = ((uint32_t)i * 73856093u ^ (uint32_t)j * 19349663u ^ (uint32_t)k * 83492791u) >> 7;
    return square(i - 50) + square(j - 45) + square(k - 55) < square(44) &&
           square(i - 50) + square(j - 2) + square(k - 55) >= square(30) &&
           !(square(i - 50) + square(k - 55) < 36 && j < 60) && pore % 37 != 0;
}

/* Returns true if voxel (i, j, k) belongs to a tool shaped like a mushroom, which consists of a dome and a shaft. */
static bool tool(int i, int j, int k)
{
    const int r = square(i - 30) + square(j - 30);
    return (k < 24 && r + square(24 - k) < square(24)) || (k >= 24 && r < 30);
}

/* ------------------------------------------------------------------- walk() */

typedef struct hit {
    int face;     /* OST_NO_FACE if the ray hits nothing */
    long voxel;
    double depth; /* distance along the eye's forward vector, in voxels */
} hit;

/* Returns the first voxel that the ray through pixel (x, y) hits. x and y may be fractions. */
static hit walk(const ost_volume *v, const ost_eye *e, double x, double y)
{
    const int dims[3] = {v->geometry.dims.x, v->geometry.dims.y, v->geometry.dims.z};
    double d[3], in = 0, out = INFINITY, next[3];
    int at[3], step[3], axis = -1;
    for (int a = 0; a < 3; a++) {
        d[a] = (double)e->focal * (double)e->forward[a] + (x + 0.5 - (double)e->half_w) * (double)e->right[a] -
               (y + 0.5 - (double)e->half_h) * (double)e->up[a];
        const double t0 = (-0.5 - (double)e->at[a]) / d[a], t1 = (dims[a] - 0.5 - (double)e->at[a]) / d[a],
                     first = fmin(t0, t1);
        axis = first > in ? a : axis;
        in = fmax(in, first);
        out = fmin(out, fmax(t0, t1));
    }
    if (!(in < out))
        return (hit){OST_NO_FACE, -1, 0};
    for (int a = 0; a < 3; a++) {
        const double p = (double)e->at[a] + in * d[a] + 0.5;
        step[a] = d[a] < 0 ? -1 : 1;
        at[a] = a == axis ? (d[a] < 0 ? dims[a] - 1 : 0) : (int)floor(p);
        at[a] = at[a] < 0 ? 0 : at[a] < dims[a] ? at[a] : dims[a] - 1;
    }
    for (double t = in;;) {
        const long voxel = at[0] + (long)dims[0] * (at[1] + (long)dims[1] * at[2]);
        if (v->voxels[voxel] >= 120)
            return (hit){2 * axis + (d[axis] < 0), voxel, t * (double)e->focal};
        for (int a = 0; a < 3; a++)
            next[a] = (at[a] + 0.5 * step[a] - (double)e->at[a]) / d[a];
        axis = next[0] < next[1] ? (next[0] < next[2] ? 0 : 2) : next[1] < next[2] ? 1 : 2;
        t = next[axis];
        at[axis] += step[axis];
        if (at[axis] < 0 || at[axis] >= dims[axis])
            return (hit){OST_NO_FACE, -1, 0};
    }
}

/* ------------------------------------------------------------------- hashes */

/* Returns the FNV-1a hash extended by the eight bytes of a word. */
static uint64_t hashed(uint64_t hash, uint64_t word)
{
    for (int i = 0; i < 8; i++)
        hash = (hash ^ (word >> (8 * i) & 255)) * UINT64_C(1099511628211);
    return hash;
}

static const uint64_t START = UINT64_C(14695981039346656037);

typedef struct thing {
    ost_volume volume;
    ost_surface surface;
    ost_eye eye;
} thing;

static void make_thing(thing *t, ost_volume v)
{
    ost_error err = {0};
    t->volume = v;
    assert_ok(ost_surface_init(&t->surface, &v.geometry, &err));
    assert_ok(ost_surface_set_volume(&t->surface, &v, 120, &err));
    assert_ok(ost_surface_update(&t->surface, &err));
}

static void free_thing(thing *t)
{
    ost_surface_free(&t->surface);
    ost_volume_free(&t->volume);
}

/*
 * Returns the nearest point at which the ray through (x, y) hits one of the objects (at most two). `scale` is
 * the voxel size of the second object in voxels of the first object.
 */
static hit nearest(const thing *t, int count, double scale, double x, double y)
{
    hit h = walk(&t[0].volume, &t[0].eye, x, y);
    if (count > 1) {
        const hit other = walk(&t[1].volume, &t[1].eye, x, y);
        if (other.face != OST_NO_FACE && (h.face == OST_NO_FACE || other.depth * scale < h.depth))
            h = other;
        h.voxel = -1; /* a frame stores only the voxels of the first object */
    }
    return h;
}

/*
 * The hit of each pixel. If rays at a distance of a thousandth of a pixel hit another voxel or face, the
 * pixel's ray passes close to an edge. Either result is then correct, so the pixel is not `clear` and is
 * not compared.
 */
typedef struct golden {
    hit pixel[H][W];
    bool clear[H][W];
    size_t covered, doubtful;
    uint64_t hash;
} golden;

static void walk_all(const thing *t, int count, double scale, golden *g)
{
    static const double offset[4][2] = {{-1e-3, -1e-3}, {1e-3, -1e-3}, {-1e-3, 1e-3}, {1e-3, 1e-3}};
    g->covered = g->doubtful = 0;
    g->hash = START;
    for (int y = 0; y < H; y++)
        for (int x = 0; x < W; x++) {
            const hit h = nearest(t, count, scale, x, y);
            g->pixel[y][x] = h;
            g->clear[y][x] = true;
            for (int i = 0; i < 4; i++) {
                const hit other = nearest(t, count, scale, x + offset[i][0], y + offset[i][1]);
                g->clear[y][x] &= other.face == h.face && other.voxel == h.voxel;
            }
            g->covered += h.face != OST_NO_FACE;
            g->doubtful += !g->clear[y][x];
            if (g->clear[y][x])
                g->hash = hashed(hashed(g->hash, (uint64_t)h.face), (uint64_t)h.voxel);
        }
}

/* Returns the hash of a frame's clear pixels. */
static uint64_t hash_of(const ost_frame *f, const ost_surface *s, const golden *g)
{
    uint64_t hash = START;
    const ost_dims d = s->geometry.dims;
    for (int y = 0; y < H; y++)
        for (int x = 0; x < W; x++) {
            const size_t at = (size_t)y * (size_t)f->planes.stride + (size_t)x;
            long voxel = -1;
            if (f->planes.face[at] != OST_NO_FACE && f->layers == 1) {
                const uint32_t id = (uint32_t)f->layer[0].visible.seen[ost_visible_index(&f->layer[0].visible,
                                                                                         (uint32_t)f->planes.key[at])];
                const int32_t *b = s->slot[id >> OST_LOCAL_BITS]->at;
                voxel = 32 * b[0] + (long)(id & 31) +
                        (long)d.x *
                            (32 * b[1] + (long)(id >> 5 & 31) + (long)d.y * (32 * b[2] + (long)(id >> 10 & 31)));
            }
            if (g->clear[y][x])
                hash = hashed(hashed(hash, f->planes.face[at]), (uint64_t)voxel);
        }
    return hash;
}

static uint64_t draw(const thing *t, int count, const golden *g, ost_isa isa, int threads, uint64_t *colours)
{
    ost_error err = {0};
    ost_frame f;
    ost_frame_thing things[2];
    for (int i = 0; i < count; i++)
        things[i] = (ost_frame_thing){
            .surface = &t[i].surface, .eye = t[i].eye, .paint = i ? OST_PAINT_STEEL : OST_PAINT_BONE};
    assert_ok(ost_frame_init(&f, W, H, OST_STYLE_SMOOTH, isa, threads, &err));
    assert_ok(ost_frame_store_keys(&f, &err));
    assert_ok(ost_frame_draw_things(&f, things, count, &err));
    const uint64_t hash = hash_of(&f, &t[0].surface, g);
    *colours = START;
    for (int y = 0; y < H; y++)
        for (int x = 0; x < W; x++)
            *colours = hashed(*colours, f.planes.colour[(size_t)y * (size_t)f.planes.stride + (size_t)x]);
    ost_frame_free(&f);
    return hash;
}

/* --------------------------------------------------------------------- views */

typedef struct view {
    const char *name;
    double from[3], at[3];
    int32_t focal_milli;
    bool with_tool;
    uint64_t hash; /* hash of the picture that walk() computed */
} view;

static const view views[] = {
    {"whole", {-70.3, -160.7, 120.9}, {50, 45, 55}, 460000, false, UINT64_C(0xd935688ab37565e0)},
    {"far", {350.1, 900.9, -300.3}, {50, 45, 55}, 900000, false, UINT64_C(0x64f7e95a473b4898)},
    {"the bowl, en face", {50.3, -45.1, 55.7}, {50, 45, 55}, 170000, false, UINT64_C(0xb22eb3cd74db41a6)},
    {"close up", {44.3, -1.2, 61.7}, {53, 45, 50}, 180000, false, UINT64_C(0xfbb4d24337bfad60)},
    {"at the frame's edges", {20.2, -75.3, 10.4}, {80, 40, 95}, 300000, false, UINT64_C(0xef1c65ed1a262410)},
    {"with a tool", {-40.4, -110.8, 110.2}, {50, 20, 55}, 330000, true, UINT64_C(0x249bad310b01f2d2)},
};

static void test_golden(void **state)
{
    (void)state;
    ost_error err = {0};
    thing t[2];
    static golden g;
    make_thing(&t[0], volume_of(100, 90, 110, MM, bone));
    make_thing(&t[1], volume_of(61, 61, 70, MM / 2, tool));
    /* The tool's dome is in the bowl, and its shaft points obliquely toward the viewer. */
    const double position[3] = {38, 16, 70}, turn[4] = {0.5, 0.7, 0.5, -0.1};
    ost_pose pose;
    assert_ok(ost_pose_from_doubles(position, turn, &pose, &err));
    for (size_t i = 0; i < sizeof views / sizeof *views; i++) {
        const view *v = &views[i];
        const double up[3] = {0.1, 0.2, 1};
        ost_camera c = {.focal_milli = v->focal_milli, .width = W, .height = H};
        const int count = v->with_tool ? 2 : 1;
        uint64_t colours, first = 0;
        assert_ok(ost_camera_look_at(v->from, v->at, up, &c, &err));
        t[0].eye = ost_eye_make(&c, &t[0].volume.geometry);
        t[1].eye = ost_eye_make_from(&c, &t[1].volume.geometry, &pose);
        walk_all(t, count, 0.5, &g);
        printf("# %-22s %5zu pixels covered, %2zu not compared, hash 0x%016" PRIx64 "\n", v->name, g.covered,
               g.doubtful, g.hash);
        assert_true(g.covered > 1000 && 100 * g.doubtful < g.covered);
        assert_int_equal(g.hash, v->hash);
        for (int isa = 0; isa < OST_ISA_COUNT; isa++)
            for (int threads = 1; threads <= 3 && ost_isa_available((ost_isa)isa); threads++) {
                assert_int_equal(draw(t, count, &g, (ost_isa)isa, threads, &colours), v->hash);
                first = first ? first : colours;
                assert_int_equal(colours, first);
            }
    }
    free_thing(&t[0]);
    free_thing(&t[1]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_golden)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
