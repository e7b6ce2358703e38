/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Compares the pictures of the renderer mesh (ost_gl_mesh) with those of the points, for bodies and for phantoms.
 *
 * OpenGL rounds the corners of a triangle to 1/256 pixel, whereas points are drawn with an exact ray for each pixel.
 * Pixels may therefore differ where a ray passes an edge closely. For each pixel that differs in colour, face or
 * depth, the ray is moved by at most 1/128 pixel. With one of the moved rays, the processor must draw the colour and
 * the face of the mesh, and the depth of the mesh to within half a voxel. A face that is seen almost along its plane
 * can be narrower than 1/128 pixel. Therefore, a few pixels of the mesh may show a different face if that face is at
 * most 1/128 pixel away. Any other difference is an error.
 *
 * The test is skipped if OpenGL without a display is not available.
 * Covers: REQ-MESH-SAME
 */
#include <math.h>

#include <osteon/phantom.h>

#include "core/backend.h"
#include "gl_scene.h"
#include "render/gl/gl.h"
#include "render/viewer.h"

/* The rays are moved in eight directions by 1/128 and by 1/256 pixel. */
enum { WIDTH = 480, HEIGHT = 270, MOVES = 2, SHIFTS = 8 * MOVES };

static ost_gl *gl;
static ost_backend *mesher;
static char reason[OST_ERROR_TEXT];

static void skip_without_gl(void)
{
    if (!gl) {
        printf("# skipped: %s\n", reason);
        skip();
    }
}

/* Returns true if a pixel has the same colour, face and depth in both frames. Depths may differ by up to `slack`. */
static bool same_pixel(const ost_frame *a, const ost_frame *b, size_t at, float slack)
{
    return a->planes.colour[at] == b->planes.colour[at] && a->planes.face[at] == b->planes.face[at] &&
           (a->planes.face[at] == OST_NO_FACE || fabsf(a->planes.depth[at] - b->planes.depth[at]) <= slack);
}

/* Draws the processor's frame with rays that are moved to the right and down by fractions of a pixel. */
static void draw_moved(ost_frame *frame, const ost_frame_thing *things, int count, float right, float down)
{
    ost_error err = {0};
    ost_frame_thing moved[2];
    assert_true(count <= 2);
    for (int i = 0; i < count; i++) {
        moved[i] = things[i];
        moved[i].eye.half_w -= right;
        moved[i].eye.half_h -= down;
    }
    assert_ok(ost_frame_draw_things(frame, moved, count, &err));
}

static bool active_at(const ost_surface *s, const int v[3])
{
    const int32_t at[3] = {v[0], v[1], v[2]};
    return !ost_surface_is_empty(s, at, at);
}

/* Returns the distance in pixels between the middle of a pixel and a quad, or 0 if the quad contains the middle. */
static double distance_of(const ost_eye *e, double px, double py, const int voxel[3], int face)
{
    double x[4], y[4], least = 1e9;
    int left = 0;
    for (int i = 0; i < 4; i++) {
        const int axis = face / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
        double o[3], along[3] = {0, 0, 0};
        o[axis] = voxel[axis] + (face % 2 ? 0.5 : -0.5) - (double)e->at[axis];
        o[u] = voxel[u] + (i == 1 || i == 2 ? 0.5 : -0.5) - (double)e->at[u];
        o[v] = voxel[v] + (i >= 2 ? 0.5 : -0.5) - (double)e->at[v];
        for (int a = 0; a < 3; a++) {
            along[0] += o[a] * (double)e->right[a];
            along[1] += o[a] * (double)e->up[a];
            along[2] += o[a] * (double)e->forward[a];
        }
        x[i] = (double)e->half_w + along[0] / along[2] * (double)e->focal - px;
        y[i] = (double)e->half_h - along[1] / along[2] * (double)e->focal - py;
    }
    for (int i = 0; i < 4; i++) {
        const int j = (i + 1) % 4;
        const double dx = x[j] - x[i], dy = y[j] - y[i], length = dx * dx + dy * dy;
        const double t = length > 0 ? fmin(fmax(-(x[i] * dx + y[i] * dy) / length, 0), 1) : 0;
        least = fmin(least, hypot(x[i] + t * dx, y[i] + t * dy));
        left += x[i] * dy - y[i] * dx > 0;
    }
    return left == 0 || left == 4 ? 0 : least;
}

/*
 * Returns true if a pixel of the mesh has the face and the depth of a visible face that is at most 1/128 pixel away
 * from the pixel's middle.
 */
static bool shows_near_face(const ost_frame *mesh, int x, int y, const ost_frame_thing *things, int count)
{
    const size_t at = (size_t)y * (size_t)mesh->planes.stride + (size_t)x;
    const int face = mesh->planes.face[at], axis = face / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (int i = 0; i < count && face != OST_NO_FACE; i++) {
        const ost_surface *s = things[i].surface;
        const ost_eye *e = &things[i].eye;
        const double scale = (double)s->geometry.spacing.x / (double)things[0].surface->geometry.spacing.x;
        const double depth = (double)mesh->planes.depth[at] / scale, px = x + 0.5, py = y + 0.5;
        double p[3];
        for (int a = 0; a < 3; a++)
            p[a] = (double)e->at[a] + depth * ((double)e->forward[a] +
                                               ((px - (double)e->half_w) * (double)e->right[a] -
                                                (py - (double)e->half_h) * (double)e->up[a]) / (double)e->focal);
        for (int k = 0; k < 9; k++) {
            int voxel[3];
            voxel[axis] = (int)lround(p[axis] + (face % 2 ? -0.5 : 0.5));
            voxel[u] = (int)lround(p[u]) + k % 3 - 1;
            voxel[v] = (int)lround(p[v]) + k / 3 - 1;
            int beside[3] = {voxel[0], voxel[1], voxel[2]};
            beside[axis] += face % 2 ? 1 : -1;
            if (active_at(s, voxel) && !active_at(s, beside) && distance_of(e, px, py, voxel, face) <= 1 / 128.0)
                return true;
        }
    }
    return false;
}

/*
 * Compares the mesh with the points of the processor and of OpenGL. Differences from OpenGL's points are only counted.
 * Every difference from the processor's points must be explained.
 */
static void check(const char *name, const ost_frame_thing *things, int count, ost_style style)
{
    ost_error err = {0};
    ost_frame points, mesh, gl_points, moved;
    const int w = things[0].eye.width, h = things[0].eye.height;
    ost_frame *const all[] = {&points, &mesh, &gl_points, &moved};
    for (int i = 0; i < 4; i++)
        assert_ok(ost_frame_init(all[i], w, h, style, OST_ISA_SCALAR, 0, &err));
    assert_ok(ost_frame_draw_things(&points, things, count, &err));
    ost_gl_variant list = ost_gl_ours;
    list.choose = false;
    assert_ok(ost_gl_draw(gl, &list, things, count, style, &err));
    assert_ok(ost_gl_read(gl, &gl_points, true, &err));
    assert_ok(ost_gl_draw(gl, &ost_gl_mesh, things, count, style, &err));
    const ost_gl_counts did = ost_gl_counts_get(gl);
    assert_ok(ost_gl_read(gl, &mesh, true, &err));

    const size_t stride = (size_t)points.planes.stride;
    bool *open = calloc(stride * (size_t)h, sizeof *open);
    int covered = 0, differ = 0, left = 0;
    assert_non_null(open);
    for (int y = 0; y < h; y++)
        for (int x = 0; x < w; x++) {
            const size_t at = (size_t)y * stride + (size_t)x;
            covered += points.planes.face[at] != OST_NO_FACE;
            open[at] = !same_pixel(&points, &mesh, at, 1e-5f * points.planes.depth[at]);
            differ += open[at];
        }
    left = differ;
    for (int i = 0; i < SHIFTS && left; i++) {
        static const int direction[8][2] = {{-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-1, -1}, {1, -1}, {-1, 1}, {1, 1}};
        /* the larger distance comes first, because most of the differing pixels agree at this distance */
        const float by = (float)(MOVES - i / 8) / (128 * MOVES);
        left = 0;
        draw_moved(&moved, things, count, by * (float)direction[i % 8][0], by * (float)direction[i % 8][1]);
        for (int y = 0; y < h; y++)
            for (int x = 0; x < w; x++) {
                const size_t at = (size_t)y * stride + (size_t)x;
                open[at] = open[at] && !same_pixel(&moved, &mesh, at, 0.5f);
                left += open[at];
            }
    }
    int narrow = 0;
    for (size_t i = 0; i < stride * (size_t)h && left; i++) {
        if (!open[i])
            continue;
        const bool near = shows_near_face(&mesh, (int)(i % stride), (int)(i / stride), things, count);
        narrow += near;
        left -= near;
        if (!near)
            printf("# pixel (%d, %d): points 0x%06x, face %d, depth %.3f; mesh 0x%06x, face %d, depth %.3f\n",
                   (int)(i % stride), (int)(i / stride), (unsigned)points.planes.colour[i], points.planes.face[i],
                   (double)points.planes.depth[i], (unsigned)mesh.planes.colour[i], mesh.planes.face[i],
                   (double)mesh.planes.depth[i]);
    }
    const difference d = compare(&gl_points, &mesh);
    printf("# %-24s %6d pixels covered, %6d faces, %2u chunks meshed: %d pixels differ from the processor's points, %d "
           "at narrow faces, %d unexplained; %d pixels differ from OpenGL's points\n",
           name, covered, (int)did.quads, (unsigned)did.meshed, differ, narrow, left, d.colour);
    assert_true(covered > 500);
    assert_int_equal(left, 0);
    assert_in_range(narrow, 0, differ / 20 + 1);
    /*
     * For about one in 64 pixels along an edge, the ray passes within 1/128 pixel of the edge. A picture of bone has
     * edges everywhere.
     */
    assert_in_range(differ, 0, covered / 50 + 10);
    free(open);
    for (int i = 0; i < 4; i++)
        ost_frame_free(all[i]);
}

static void test_bodies(void **state)
{
    (void)state;
    skip_without_gl();
    static const struct {
        const char *name;
        double x, y, z, distance, aside;
    } views[] = {{"whole", 0.2, -1, 0.3, 2.1, 0},       {"oblique", 1, -0.7, 0.6, 2.3, 0},
                 {"along an axis", 0, -1, 0, 2, 0},     {"far", -0.3, 1, -0.2, 6, 0},
                 {"across the frame's edge", 0, -1, 0.1, 1.2, 0.45}, {"close up", 0.3, -1, 0.2, 0.55, 0.1}};
    test_rng rng = rng_seeded("bodies");
    ost_error err = {0};
    enum { N = 96 };
    ost_volume v = body(&rng, N, OST_PM_PER_MM / 2), t = body(&rng, 40, OST_PM_PER_MM / 3);
    ost_surface bone = surface_of(&v), tool = surface_of(&t);
    const double q[4] = {0.8, 0.3, -0.4, 0.33}, at[3] = {20, 8, 30};
    ost_pose pose;
    assert_ok(ost_pose_from_doubles(at, q, &pose, &err));
    for (size_t i = 0; i < sizeof views / sizeof *views; i++) {
        const ost_camera c = look(&v.geometry, views[i].x, views[i].y, views[i].z, views[i].distance * N,
                                  views[i].aside * N, WIDTH, HEIGHT);
        const ost_frame_thing things[2] = {
            {.surface = &bone, .eye = ost_eye_make(&c, &v.geometry), .paint = OST_PAINT_BONE},
            {.surface = &tool, .eye = ost_eye_make_from(&c, &t.geometry, &pose), .paint = OST_PAINT_STEEL}};
        check(views[i].name, things, 1 + (int)(i % 2), i % 3 ? OST_STYLE_SMOOTH : OST_STYLE_FACES);
    }
    ost_surface_free(&bone);
    ost_surface_free(&tool);
    ost_volume_free(&v);
    ost_volume_free(&t);
}

/* Returns the cubic grid of a phantom. */
static ost_volume phantom(ost_phantom_kind kind, double scale)
{
    ost_error err = {0};
    const ost_phantom_options options = {.scale = scale};
    ost_volume ct, cubic;
    ost_grid *rect, *out;
    assert_ok(ost_phantom_make(kind, &options, &ct, &err));
    assert_ok(ost_grid_create(mesher, &ct.geometry, &rect, &err));
    assert_ok(ost_grid_upload(rect, 0, ct.geometry.dims.z, ct.voxels, &err));
    assert_ok(ost_rect_to_cubic(rect, ct.geometry.spacing.x, OST_RESAMPLE_LINEAR, &out, &err));
    assert_ok(ost_volume_init(&cubic, ost_grid_geometry(out), &err));
    assert_ok(ost_grid_download(out, 0, cubic.geometry.dims.z, cubic.voxels, &err));
    ost_grid_free(rect);
    ost_grid_free(out);
    ost_volume_free(&ct);
    return cubic;
}

static ost_camera camera_of(const ost_geometry *g, double x, double y, double z, double distance)
{
    ost_error err = {0};
    ost_camera c = {.focal_milli = (int32_t)(1207.10678 * HEIGHT), .width = WIDTH, .height = HEIGHT};
    const double mm = 1e-9 * (double)g->spacing.x, length = sqrt(x * x + y * y + z * z), up[3] = {0, 0, 1};
    const double far = distance * mm * fmax(g->dims.x, fmax(g->dims.y, g->dims.z));
    const double at[3] = {1e-9 * (double)g->origin.x + 0.5 * mm * g->dims.x,
                          1e-9 * (double)g->origin.y + 0.5 * mm * g->dims.y,
                          1e-9 * (double)g->origin.z + 0.5 * mm * g->dims.z};
    const double from[3] = {at[0] + far * x / length, at[1] + far * y / length, at[2] + far * z / length};
    assert_ok(ost_camera_look_at(from, at, up, &c, &err));
    return c;
}

static void test_phantoms(void **state)
{
    (void)state;
    skip_without_gl();
    static const struct {
        ost_phantom_kind kind;
        double scale;
    } list[] = {{OST_PHANTOM_SCAPULA, 0.4}, {OST_PHANTOM_GLENOID, 1},     {OST_PHANTOM_TRABECULAR, 0.4},
                {OST_PHANTOM_FOAM, 0.2},    {OST_PHANTOM_TRABECULAR2, 0.2}};
    for (size_t i = 0; i < sizeof list / sizeof *list; i++) {
        ost_volume v = phantom(list[i].kind, list[i].scale);
        ost_surface s = surface_of(&v);
        for (int k = 0; k < 2; k++) {
            char name[64];
            const ost_camera c = camera_of(&v.geometry, k ? 0.7 : 0.1, -1, 0.4, k ? 0.9 : 1.7);
            const ost_frame_thing thing = {
                .surface = &s, .eye = ost_eye_make(&c, &v.geometry), .paint = OST_PAINT_BONE};
            snprintf(name, sizeof name, "%s, %s", ost_phantom_name(list[i].kind), k ? "near" : "whole");
            check(name, &thing, 1, k ? OST_STYLE_SMOOTH : OST_STYLE_FACES);
        }
        ost_surface_free(&s);
        ost_volume_free(&v);
    }
}

static void draw_mesh(const ost_surface *s, const ost_camera *c, ost_frame *frame)
{
    ost_error err = {0};
    const ost_frame_thing thing = {
        .surface = s, .eye = ost_eye_make(c, &s->geometry), .paint = OST_PAINT_BONE};
    assert_ok(ost_gl_draw(gl, &ost_gl_mesh, &thing, 1, OST_STYLE_SMOOTH, &err));
    assert_ok(ost_gl_read(gl, frame, true, &err));
}

static bool same_frames(const ost_frame *a, const ost_frame *b)
{
    const difference d = compare(a, b);
    return d.colour + d.face + d.depth == 0;
}

static uint64_t faces_of(const ost_surface_block *b)
{
    uint64_t count = 0;
    for (uint32_t i = 0; i < b->count; i++)
        count += (uint64_t)__builtin_popcount(b->points[i] >> OST_FACES_SHIFT & 63);
    return count;
}

/*
 * After bone is removed, exactly the chunks whose visible faces changed must be meshed again, and the picture must
 * equal that of a new surface. A chunk in which only the shades changed must not be meshed.
 */
static void test_removal(void **state)
{
    (void)state;
    skip_without_gl();
    enum { N = 90, ROUNDS = 6 };
    test_rng rng = rng_seeded("removal");
    ost_error err = {0};
    ost_volume v = body(&rng, N, OST_PM_PER_MM);
    ost_surface s = surface_of(&v);
    const ost_camera c = look(&v.geometry, 0.3, -1, 0.3, 170, 0, WIDTH, HEIGHT);
    ost_frame kept, fresh;
    assert_ok(ost_frame_init(&kept, WIDTH, HEIGHT, OST_STYLE_SMOOTH, OST_ISA_SCALAR, 0, &err));
    assert_ok(ost_frame_init(&fresh, WIDTH, HEIGHT, OST_STYLE_SMOOTH, OST_ISA_SCALAR, 0, &err));
    draw_mesh(&s, &c, &kept);
    assert_int_equal(ost_gl_counts_get(gl).meshed, s.used);
    draw_mesh(&s, &c, &kept);
    assert_int_equal(ost_gl_counts_get(gl).meshed, 0);
    assert_int_equal(ost_gl_counts_get(gl).uploaded, 0);
    for (int round = 0; round < ROUNDS; round++) {
        uint32_t expected = 0;
        uint64_t faces = 0, looks = 0;
        uint32_t *was[64];
        uint64_t version[64];
        uint32_t counts[64];
        assert_true(s.used <= 64);
        for (int32_t i = 0; i < s.used; i++) {
            const ost_surface_block *b = s.slot[i];
            was[i] = malloc((b->count + 1) * sizeof *was[i]);
            assert_non_null(was[i]);
            memcpy(was[i], b->points, b->count * sizeof *was[i]);
            counts[i] = b->count;
            version[i] = b->version;
        }
        /*
         * the first cube is at a chunk's corner, the second at a chunk's face, and the others are at random positions
         */
        int at[3];
        for (int a = 0; a < 3; a++)
            at[a] = round == 0 ? 28 : round == 1 && a == 0 ? 30 : (int)rng_range(&rng, 20, 62);
        for (int i = 0; i < 6 * 6 * 6; i++)
            v.voxels[at[0] + i % 6 + N * (at[1] + i / 6 % 6 + N * (at[2] + i / 36))] = 0;
        assert_ok(ost_surface_set_volume(&s, &v, 120, &err));
        assert_ok(ost_surface_update(&s, &err));
        const int32_t before = s.used;
        for (int32_t i = 0; i < before; i++) {
            const ost_surface_block *b = s.slot[i];
            const bool changed = b->count != counts[i] || memcmp(was[i], b->points, b->count * sizeof *was[i]) != 0;
            expected += changed;
            faces += changed ? faces_of(b) : 0;
            looks += b->version != version[i] ? faces_of(b) : 0;
            free(was[i]);
        }
        draw_mesh(&s, &c, &kept);
        assert_int_equal(ost_gl_counts_get(gl).meshed, expected);
        assert_int_equal(ost_gl_counts_get(gl).uploaded, 16 * faces + 4 * looks);
        printf("# round %d: %u of %d chunks meshed again\n", round, (unsigned)expected, (int)before);
        assert_true((int32_t)expected < before);
        ost_surface again = surface_of(&v);
        draw_mesh(&again, &c, &fresh);
        assert_true(same_frames(&kept, &fresh));
        ost_surface_free(&again);
    }
    const ost_clip clip = {.n = {0, 1 << 14, 0}, .d = (int64_t)40 << 14};
    ost_surface_clip(&s, &clip);
    assert_ok(ost_surface_update(&s, &err));
    draw_mesh(&s, &c, &kept);
    const uint32_t clipped = ost_gl_counts_get(gl).meshed;
    assert_in_range(clipped, 1, s.used);
    ost_frame_free(&kept);
    ost_frame_free(&fresh);
    ost_surface_free(&s);
    ost_volume_free(&v);
}

/* All backends must make the same mesh, so that pictures are bit-identical. */
static void test_backends(void **state)
{
    (void)state;
    skip_without_gl();
    static const char *const specs[] = {"ref", "cpu:threads=1", "cpu:threads=3", "cl"};
    test_rng rng = rng_seeded("backends");
    ost_error err = {0};
    ost_volume v = body(&rng, 70, OST_PM_PER_MM);
    const ost_camera c = look(&v.geometry, 0.3, -1, 0.3, 140, 0, WIDTH, HEIGHT);
    ost_frame first, other;
    assert_ok(ost_frame_init(&first, WIDTH, HEIGHT, OST_STYLE_SMOOTH, OST_ISA_SCALAR, 0, &err));
    assert_ok(ost_frame_init(&other, WIDTH, HEIGHT, OST_STYLE_SMOOTH, OST_ISA_SCALAR, 0, &err));
    for (int i = 0; i < 4; i++) {
        ost_surface s = surface_of(&v);
        ost_backend *backend = NULL;
        if (ost_backend_open(specs[i], &backend, &err) == OST_OK) {
            ost_gl_set_mesher(gl, backend);
            draw_mesh(&s, &c, i ? &other : &first);
            assert_true(i == 0 || same_frames(&first, &other));
        } else {
            printf("# %s\n", err.text);
            assert_int_equal(i, 3);
        }
        ost_gl_set_mesher(gl, mesher);
        ost_backend_close(backend);
        ost_surface_free(&s);
    }
    ost_frame_free(&first);
    ost_frame_free(&other);
    ost_volume_free(&v);
}

/* Drawing must be refused if no mesher is set. A backend without meshes must be refused with a reason. */
static void test_refusals(void **state)
{
    (void)state;
    skip_without_gl();
    test_rng rng = rng_seeded("refusals");
    ost_error err = {0};
    ost_volume v = body(&rng, 40, OST_PM_PER_MM);
    ost_surface s = surface_of(&v);
    const ost_camera c = look(&v.geometry, 0.3, -1, 0.3, 90, 0, 64, 64);
    const ost_frame_thing thing = {.surface = &s, .eye = ost_eye_make(&c, &v.geometry), .paint = OST_PAINT_BONE};
    ost_gl_set_mesher(gl, NULL);
    assert_int_equal(ost_gl_draw(gl, &ost_gl_mesh, &thing, 1, OST_STYLE_SMOOTH, &err), OST_ERR_USAGE);
    ost_gl_set_mesher(gl, mesher);
    ost_backend_ops ops = *mesher->ops;
    ops.face_mesh = NULL;
    ost_backend without = {.ops = &ops};
    ost_viewer viewer;
    assert_ok(ost_viewer_init(&viewer, &v.geometry, OST_STYLE_SMOOTH, NULL, 1, &err));
    assert_int_equal(ost_viewer_use_mesh(&viewer, &without, &err), OST_ERR_UNAVAILABLE);
    assert_non_null(strstr(err.text, "makes no meshes"));
    ost_viewer_free(&viewer);
    ost_surface_free(&s);
    ost_volume_free(&v);
}

static int begin(void **state)
{
    (void)state;
    ost_error err = {0};
    const ost_gl_options options = {.debug = true};
    if (ost_backend_open("cpu:threads=2", &mesher, &err) != OST_OK) {
        print_error("%s\n", err.text);
        return 1;
    }
    if (getenv("OST_UNDER_VALGRIND"))
        snprintf(reason, sizeof reason, "valgrind cannot check the code of an OpenGL driver");
    else if (ost_gl_open(&options, &gl, &err) != OST_OK)
        memcpy(reason, err.text, sizeof reason);
    if (gl)
        ost_gl_set_mesher(gl, mesher);
    return 0;
}

static int end(void **state)
{
    (void)state;
    ost_gl_close(gl);
    ost_backend_close(mesher);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_bodies), cmocka_unit_test(test_phantoms),
                                       cmocka_unit_test(test_removal), cmocka_unit_test(test_backends),
                                       cmocka_unit_test(test_refusals)};
    const int failed = cmocka_run_group_tests(tests, begin, end);
    return failed ? failed : *reason ? 77 : 0;
}
