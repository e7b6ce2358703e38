/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the smooth mesh of a tool. Its normals are compared with those of a sphere and of a cylinder. Its picture is
 * compared with the intersections of each pixel's ray with every triangle. There must be no gap between triangles that
 * share an edge, and the picture of a sphere must be a disc whose brightness changes gradually.
 * Covers: REQ-SMOOTH-TOOL
 */
#include <math.h>

#include "harness.h"
#include "render/points/triangles.h"

#define MM OST_PM_PER_MM
#define PI 3.14159265358979323846

enum { WIDTH = 160, HEIGHT = 120, STRIDE = 160 };

static const ost_tool_geometry grid = {{10, 10, 10}, MM, {-5 * MM, -5 * MM, -5 * MM}};

/* ------------------------------------------------------------------ meshes */

static void set(ost_mesh *m, size_t vertex, double x, double y, double z)
{
    m->vertices[vertex] = (ost_pm3){(ost_pm)(x * (double)MM), (ost_pm)(y * (double)MM), (ost_pm)(z * (double)MM)};
}

/* Adds a triangle with vertices of its own, as in an STL file. */
static void add(ost_mesh *m, size_t *count, const double a[3], const double b[3], const double c[3])
{
    const double *const corners[3] = {a, b, c};
    for (int i = 0; i < 3; i++) {
        set(m, 3 * *count + (size_t)i, corners[i][0], corners[i][1], corners[i][2]);
        m->triangles[*count][i] = (uint32_t)(3 * *count + (size_t)i);
    }
    ++*count;
}

static void on_sphere(double radius, int i, int n, int j, int m, double out[3])
{
    const double polar = PI * i / n, angle = 2 * PI * (j % m) / m;
    out[0] = i == 0 || i == n ? 0 : radius * sin(polar) * cos(angle);
    out[1] = i == 0 || i == n ? 0 : radius * sin(polar) * sin(angle);
    out[2] = radius * cos(polar);
}

static ost_mesh sphere(double radius, int n, int m)
{
    ost_error err = {0};
    ost_mesh mesh;
    size_t count = 0;
    const size_t triangles = (size_t)(2 * m * (n - 1));
    assert_ok(ost_mesh_init(&mesh, 3 * triangles, triangles, &err));
    for (int i = 0; i < n; i++)
        for (int j = 0; j < m; j++) {
            double v[4][3];
            on_sphere(radius, i, n, j, m, v[0]);
            on_sphere(radius, i + 1, n, j, m, v[1]);
            on_sphere(radius, i + 1, n, j + 1, m, v[2]);
            on_sphere(radius, i, n, j + 1, m, v[3]);
            if (i < n - 1)
                add(&mesh, &count, v[0], v[1], v[2]);
            if (i > 0)
                add(&mesh, &count, v[0], v[2], v[3]);
        }
    assert_int_equal(count, triangles);
    return mesh;
}

/* Makes a cylinder along z that is closed by two discs. */
static ost_mesh cylinder(double radius, double z0, double z1, int m)
{
    ost_error err = {0};
    ost_mesh mesh;
    size_t count = 0;
    assert_ok(ost_mesh_init(&mesh, (size_t)(12 * m), (size_t)(4 * m), &err));
    for (int j = 0; j < m; j++) {
        const double a = 2 * PI * j / m, b = 2 * PI * ((j + 1) % m) / m;
        const double x[2] = {radius * cos(a), radius * cos(b)}, y[2] = {radius * sin(a), radius * sin(b)};
        add(&mesh, &count, (double[]){x[0], y[0], z0}, (double[]){x[1], y[1], z0}, (double[]){x[1], y[1], z1});
        add(&mesh, &count, (double[]){x[0], y[0], z0}, (double[]){x[1], y[1], z1}, (double[]){x[0], y[0], z1});
        add(&mesh, &count, (double[]){0, 0, z1}, (double[]){x[0], y[0], z1}, (double[]){x[1], y[1], z1});
        add(&mesh, &count, (double[]){0, 0, z0}, (double[]){x[1], y[1], z0}, (double[]){x[0], y[0], z0});
    }
    return mesh;
}

static ost_smooth_mesh smooth(ost_mesh *mesh)
{
    ost_error err = {0};
    ost_smooth_mesh out;
    assert_ok(ost_smooth_mesh_make(mesh, 1, &grid, &out, &err));
    ost_mesh_free(mesh);
    return out;
}

/* ----------------------------------------------------------------- normals */

static double dot(const float a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void sphere_has_radial_normals(void **state)
{
    (void)state;
    ost_mesh mesh = sphere(4, 40, 80);
    ost_smooth_mesh s = smooth(&mesh);
    assert_int_equal(s.count, 2 * 80 * 39);
    /* the vertices of the triangles are not shared, but their positions are */
    assert_int_equal(s.positions, 80 * 39 + 2);
    assert_true(s.closed);
    double worst = 1;
    for (size_t t = 0; t < s.count; t++)
        for (int c = 0; c < 3; c++) {
            double radial[3], length = 0;
            for (int a = 0; a < 3; a++) { /* the middle of the grid is at 4.5 voxels */
                radial[a] = s.triangle[t].corner[c].at[a] - 4.5;
                length += radial[a] * radial[a];
            }
            assert_true(fabs(sqrt(length) - 4) < 1e-5);
            worst = fmin(worst, dot(s.triangle[t].corner[c].normal, radial) / sqrt(length));
        }
    print_message("largest deviation of a normal, degrees: %.3f\n", acos(worst) * 180 / PI);
    assert_true(worst > cos(1.0 * PI / 180)); /* the triangles are 4.5 degrees wide */
    ost_smooth_mesh_free(&s);
}

static void normals_of_cylinder_change_at_edge(void **state)
{
    (void)state;
    ost_mesh mesh = cylinder(3, -4, 4, 64);
    ost_smooth_mesh s = smooth(&mesh);
    for (size_t t = 0; t < s.count; t++)
        for (int c = 0; c < 3; c++) {
            const float *n = s.triangle[t].corner[c].normal;
            const double x = s.triangle[t].corner[c].at[0] - 4.5, y = s.triangle[t].corner[c].at[1] - 4.5;
            if (t % 4 < 2) /* the first two of four triangles belong to the side */
                assert_true(dot(n, (double[]){x / 3, y / 3, 0}) > cos(2.0 * PI / 180));
            else
                assert_true(n[2] == (t % 4 == 2 ? 1.0f : -1.0f));
        }
    ost_smooth_mesh_free(&s);
}

static void unusual_meshes_are_handled(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_smooth_mesh out;
    ost_mesh mesh;
    /* a mesh without triangles */
    assert_ok(ost_smooth_mesh_make(NULL, 0, &grid, &out, &err));
    assert_int_equal(out.count, 0);
    ost_smooth_mesh_free(&out);
    /* zero-area triangles: equal vertices, and vertices on a line */
    assert_ok(ost_mesh_init(&mesh, 4, 3, &err));
    for (size_t i = 0; i < 4; i++)
        set(&mesh, i, (double)i, i == 3, 0);
    const uint32_t triangles[3][3] = {{0, 0, 1}, {0, 1, 2}, {0, 1, 3}};
    memcpy(mesh.triangles, triangles, sizeof triangles);
    assert_ok(ost_smooth_mesh_make(&mesh, 1, &grid, &out, &err));
    assert_int_equal(out.count, 1);
    assert_false(out.closed);
    assert_true(out.triangle[0].corner[0].normal[2] == 1.0f);
    ost_smooth_mesh_free(&out);
    mesh.triangles[1][2] = 4;
    assert_int_equal(ost_smooth_mesh_make(&mesh, 1, &grid, &out, &err), OST_ERR_USAGE);
    ost_mesh_free(&mesh);
    /* too many triangles */
    assert_ok(ost_mesh_init(&mesh, 3, OST_SMOOTH_TRIANGLES_MAX + 1, &err));
    assert_ok(ost_smooth_mesh_make(&mesh, 1, &grid, &out, &err));
    assert_int_equal(out.count, 0);
    ost_mesh_free(&mesh);
}

/* ---------------------------------------------------------------- pictures */

typedef struct picture {
    ost_planes planes;
    ost_cells over;
    float depth[STRIDE * HEIGHT];
    uint8_t face[STRIDE * HEIGHT];
    uint32_t colour[STRIDE * HEIGHT];
} picture;

static picture *draw(const ost_smooth_mesh *mesh, const ost_eye *eye, int band, ost_isa isa)
{
    ost_error err = {0};
    ost_triangles t = {.triangle = NULL};
    picture *p = malloc(sizeof *p);
    assert_non_null(p);
    assert_true(ost_cells_init(&p->over, WIDTH, HEIGHT));
    p->planes = (ost_planes){.depth = p->depth, .face = p->face, .colour = p->colour, .stride = STRIDE};
    memset(p->face, OST_NO_FACE, sizeof p->face);
    memset(p->depth, 0, sizeof p->depth);
    memset(p->colour, 0, sizeof p->colour);
    assert_ok(ost_triangles_project(&t, mesh, eye, OST_PAINT_STEEL, 1, &err));
    for (int y = 0; y < HEIGHT; y += band)
        ost_triangles_draw(&t, ost_triangle_rows_for(isa), &p->planes, y, y + band < HEIGHT ? y + band : HEIGHT,
                           &p->over);
    ost_triangles_free(&t);
    return p;
}

static void picture_free(picture *p)
{
    ost_cells_free(&p->over);
    free(p);
}

static ost_eye eye_at(const double from[3], double focal)
{
    ost_error err = {0};
    ost_camera camera = {.focal_milli = (int32_t)(1000 * focal), .width = WIDTH, .height = HEIGHT};
    const ost_geometry g = {{10, 10, 10}, {MM, MM, MM}, {0, 0, 0}};
    assert_ok(ost_camera_look_at(from, (double[]){4.5, 4.5, 4.5}, (double[]){0.1, 1, 0.2}, &camera, &err));
    return ost_eye_make(&camera, &g);
}

static double determinant(const double a[3], const double b[3], const double c[3])
{
    return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
}

/*
 * Intersects the ray at a position in the picture with a triangle. Returns the depth, or 0 if they do not meet. *margin
 * is the smallest barycentric coordinate of the intersection: it is negative outside the triangle and 0 on a side.
 */
static double intersect(const ost_eye *e, const ost_smooth_triangle *t, double x, double y, double *margin)
{
    const double u = x - e->half_w, v = e->half_h - y;
    double d[3], o[3][3], minus[3];
    for (int a = 0; a < 3; a++) {
        d[a] = (double)e->focal * e->forward[a] + u * e->right[a] + v * e->up[a];
        minus[a] = -d[a];
        for (int c = 0; c < 3; c++)
            o[c][a] = (double)t->corner[c].at[a] - e->at[a];
    }
    /* Solves o0 + b (o1 - o0) + c (o2 - o0) = s d for b, c and s. */
    double b[3], c[3];
    for (int a = 0; a < 3; a++) {
        b[a] = o[1][a] - o[0][a];
        c[a] = o[2][a] - o[0][a];
    }
    const double whole = determinant(b, c, minus), from[3] = {-o[0][0], -o[0][1], -o[0][2]};
    if (fabs(whole) < 1e-12)
        return 0;
    const double beta = determinant(from, c, minus) / whole, gamma = determinant(b, from, minus) / whole,
                 s = determinant(b, c, from) / whole;
    *margin = fmin(fmin(beta, gamma), 1 - beta - gamma);
    return s * e->focal;
}

/*
 * The intersection of a pixel's ray with a triangle. Corners are rounded to 256ths of a pixel, which changes the depth
 * by up to `slack`. If the margin is less than `doubt`, a side of the triangle is so close that rounding decides
 * whether the triangle covers the pixel. The margins of a narrow triangle change fast from pixel to pixel.
 */
typedef struct candidate {
    double depth, slack, margin, doubt;
} candidate;

static candidate candidate_at(const ost_eye *e, const ost_smooth_triangle *t, int x, int y)
{
    double margin[3] = {-1, -1, -1};
    const double depth = intersect(e, t, x + 0.5, y + 0.5, &margin[0]),
                 right = intersect(e, t, x + 0.51, y + 0.5, &margin[1]),
                 below = intersect(e, t, x + 0.5, y + 0.51, &margin[2]);
    return (candidate){.depth = depth,
                       .slack = 0.0001 * depth + fabs(right - depth) + fabs(below - depth),
                       .margin = margin[0],
                       .doubt = fmax(0.02, fabs(margin[1] - margin[0]) + fabs(margin[2] - margin[0]))};
}

/* Returns a mesh of random triangles. Some of them share positions. */
static ost_smooth_mesh random_mesh(test_rng *rng, size_t triangles)
{
    ost_smooth_mesh m = {.triangle = calloc(triangles, sizeof *m.triangle),
                         .position = calloc(3 * triangles, sizeof *m.position),
                         .place = calloc(triangles, sizeof *m.place),
                         .count = triangles,
                         .positions = 2 * triangles};
    assert_non_null(m.triangle);
    assert_non_null(m.position);
    assert_non_null(m.place);
    for (size_t p = 0; p < m.positions; p++)
        for (int a = 0; a < 3; a++)
            m.position[p][a] = (float)rng_range(rng, -2000, 11000) / 1000.0f;
    for (size_t t = 0; t < triangles; t++)
        for (int c = 0; c < 3; c++) {
            m.place[t][c] = (uint32_t)rng_range(rng, 0, (int64_t)m.positions - 1);
            memcpy(m.triangle[t].corner[c].at, m.position[m.place[t][c]], sizeof m.triangle[t].corner[c].at);
            m.triangle[t].corner[c].normal[c] = 1;
        }
    return m;
}

/* Compares the picture of random triangles with rays. Pixels whose ray passes close to a side are not compared. */
static void pixels_show_nearest_triangle(void **state)
{
    (void)state;
    enum { TRIANGLES = 30, ROUNDS = 25 };
    test_rng rng = rng_seeded("triangles");
    int compared = 0, covered = 0, clipped = 0;
    for (int round = 0; round < ROUNDS; round++) {
        ost_smooth_mesh mesh = random_mesh(&rng, TRIANGLES);
        /* in every fifth round, the eye is among the triangles, and the near plane divides some of them */
        const double far = round % 5 ? 30 : 3;
        const double from[3] = {4.5 + far, 4.5 + (double)rng_range(&rng, -20, 20) / 10, 4.5 + far / 3};
        ost_eye eye = eye_at(from, 150);
        eye.near = round % 5 ? eye.near : 2;
        picture *p = draw(&mesh, &eye, HEIGHT, OST_ISA_SCALAR);
        for (int y = 0; y < HEIGHT; y++)
            for (int x = 0; x < WIDTH; x++) {
                candidate found[TRIANGLES];
                double nearest = 1e30; /* upper bound on the depth of the nearest triangle */
                int candidates = 0;
                bool clear = true, shown = false;
                for (int t = 0; t < TRIANGLES; t++) {
                    const candidate k = candidate_at(&eye, &mesh.triangle[t], x, y);
                    clear &= !(fabs(k.margin) < k.doubt || fabs(k.depth - eye.near) < k.slack + 0.01);
                    clipped += k.depth > 0 && k.depth < eye.near && k.margin > 0;
                    if (!(k.margin > 0 && k.depth > eye.near))
                        continue;
                    found[candidates++] = k;
                    nearest = fmin(nearest, k.depth + k.slack);
                }
                if (!clear)
                    continue;
                const float depth = p->depth[y * STRIDE + x];
                const bool drawn = p->face[y * STRIDE + x] != OST_NO_FACE;
                for (int i = 0; i < candidates; i++)
                    shown |= fabs(depth - found[i].depth) <= found[i].slack &&
                             found[i].depth - found[i].slack <= nearest;
                if (drawn != (candidates > 0) || (drawn && !shown))
                    fail_msg("round %d, pixel (%d, %d): depth %g (0 if nothing is drawn), expected at most %g; the ray "
                             "meets %d triangles",
                             round, x, y, drawn ? depth : 0.0, nearest, candidates);
                assert_true(!drawn || ost_cells_has(&p->over, x, y));
                compared++;
                covered += drawn;
            }
        picture_free(p);
        ost_smooth_mesh_free(&mesh);
    }
    print_message("%d pixels compared, %d covered\n", compared, covered);
    assert_true(compared > 100000 && covered > 20000 && clipped > 0);
}

static void assert_same(const picture *a, const picture *b)
{
    assert_memory_equal(a->colour, b->colour, sizeof a->colour);
    assert_memory_equal(a->depth, b->depth, sizeof a->depth);
    assert_memory_equal(a->face, b->face, sizeof a->face);
    assert_memory_equal(a->over.bit, b->over.bit, (size_t)a->over.words * (size_t)a->over.rows * sizeof *a->over.bit);
}

/* Draws triangles around the eye. Some corners are so far away that their positions in the picture are clamped. Every
   instruction set and every division into bands must give the same picture. */
static void distant_corners_are_clamped(void **state)
{
    (void)state;
    enum { TRIANGLES = 40, ROUNDS = 40 };
    test_rng rng = rng_seeded("far corners");
    int covered = 0;
    for (int round = 0; round < ROUNDS; round++) {
        ost_smooth_mesh mesh = random_mesh(&rng, TRIANGLES);
        for (size_t p = 0; p < mesh.positions; p++)
            for (int a = 0; a < 3; a++)
                mesh.position[p][a] *= rng_range(&rng, 0, 3) ? 1 : 1e6f;
        const double from[3] = {5, 5, (double)rng_range(&rng, -20, 40) / 10};
        const ost_eye eye = eye_at(from, (double)rng_range(&rng, 10, 5000));
        ost_error err = {0};
        ost_isa best;
        assert_ok(ost_isa_choose(NULL, &best, &err));
        picture *p = draw(&mesh, &eye, HEIGHT, OST_ISA_SCALAR),
                *bands = draw(&mesh, &eye, (int)rng_range(&rng, 1, 3) * 8, best);
        assert_same(p, bands);
        for (int i = 0; i < STRIDE * HEIGHT; i++)
            covered += p->face[i] != OST_NO_FACE;
        picture_free(p);
        picture_free(bands);
        ost_smooth_mesh_free(&mesh);
    }
    print_message("%d pixels covered\n", covered);
    assert_true(covered > 10000);
}

/* Draws a sphere in a single call with the scalar loop, and in bands of 8 rows with the loop for this processor's
   instruction set. No pixel inside the sphere's outline may be missing. */
static void picture_of_sphere_is_smooth(void **state)
{
    (void)state;
    ost_mesh mesh = sphere(4, 60, 120);
    ost_smooth_mesh s = smooth(&mesh);
    const double from[3] = {4.5, 4.5, 34.5};
    const ost_eye eye = eye_at(from, 300);
    ost_error err = {0};
    ost_isa best;
    assert_ok(ost_isa_choose(NULL, &best, &err));
    picture *p = draw(&s, &eye, HEIGHT, OST_ISA_SCALAR), *bands = draw(&s, &eye, 8, best);
    assert_same(p, bands);
    /* a sphere of radius r at distance d is a disc of radius f r / sqrt(d^2 - r^2) */
    const double radius = 300 * 4 / sqrt(30 * 30 - 4 * 4);
    int steepest = 0;
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            const double away = hypot(x + 0.5 - WIDTH / 2.0, y + 0.5 - HEIGHT / 2.0);
            const int i = y * STRIDE + x;
            assert_true(away > radius - 0.5 || p->face[i] != OST_NO_FACE);
            assert_true(away < radius + 0.01 || p->face[i] == OST_NO_FACE);
            if (away < radius - 3) {
                const int green = (int)(p->colour[i] >> 8 & 255), beside = (int)(p->colour[i + 1] >> 8 & 255);
                steepest = green - beside > steepest ? green - beside : beside - green > steepest ? beside - green
                                                                                                  : steepest;
            }
        }
    print_message("largest difference of neighbouring pixels: %d of 255\n", steepest);
    assert_true(steepest < 20);
    picture_free(p);
    picture_free(bands);
    ost_smooth_mesh_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sphere_has_radial_normals),
        cmocka_unit_test(normals_of_cylinder_change_at_edge),
        cmocka_unit_test(unusual_meshes_are_handled),
        cmocka_unit_test(pixels_show_nearest_triangle),
        cmocka_unit_test(distant_corners_are_clamped),
        cmocka_unit_test(picture_of_sphere_is_smooth),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
