/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests frames whose unchanged parts are not drawn again. Such a frame must be bit-identical to a frame
 * that is drawn completely. Frames are drawn after removals, after motions of the tool and of the camera,
 * after changes of colours, clip plane, ghost or lines, and after the last frame was overwritten.
 * Half of the frames are antialiased. Pixels that change must be in the cells that the frame reports as changed.
 * Covers: REQ-FRAME-KEPT, REQ-ANTIALIAS
 */
#include <math.h>

#include <osteon/phantom.h>

#include "harness.h"
#include "render/viewer.h"

#define MM OST_PM_PER_MM
enum { NX = 100, NY = 70, NZ = 68, COUNT = NX * NY * NZ };

static size_t index_of(int i, int j, int k)
{
    return (size_t)i + (size_t)NX * ((size_t)j + (size_t)NY * (size_t)k);
}

static void ball(ost_volume *v, const int at[3], int radius, int16_t value)
{
    for (int k = at[2] - radius; k <= at[2] + radius; k++)
        for (int j = at[1] - radius; j <= at[1] + radius; j++)
            for (int i = at[0] - radius; i <= at[0] + radius; i++) {
                const int away = (i - at[0]) * (i - at[0]) + (j - at[1]) * (j - at[1]) + (k - at[2]) * (k - at[2]);
                if (i >= 0 && j >= 0 && k >= 0 && i < NX && j < NY && k < NZ && away <= radius * radius)
                    v->voxels[index_of(i, j, k)] = value;
            }
}

/* Makes a body in the middle of its grid, so that some blocks of the grid never contain an active voxel. */
static ost_volume make_bone(test_rng *rng)
{
    ost_error err = {0};
    ost_volume v;
    const ost_geometry g = {{NX, NY, NZ}, {MM, MM, MM}, {0, 0, 0}};
    assert_ok(ost_volume_init(&v, &g, &err));
    for (int i = 0; i < 12; i++)
        ball(&v, (int[3]){(int)rng_range(rng, 25, 75), (int)rng_range(rng, 25, 45), (int)rng_range(rng, 25, 43)},
             (int)rng_range(rng, 6, 16), (int16_t)rng_range(rng, 200, 1400));
    return v;
}

static ost_tool_volume rod(void)
{
    ost_error err = {0};
    ost_tool_volume t;
    const ost_tool_geometry g = {{16, 16, 50}, MM / 2, {-4 * MM, -4 * MM, 0}};
    assert_ok(ost_tool_volume_init(&t, &g, &err));
    memset(t.voxels, OST_TOOL_CUTTING, 16 * 16 * 50);
    return t;
}

static ost_pose pose_of(test_rng *rng)
{
    double q[4], n = 0;
    ost_error err = {0};
    ost_pose pose;
    for (int a = 0; a < 4; a++) {
        q[a] = (double)rng_range(rng, -1000, 1000) + 0.5;
        n += q[a] * q[a];
    }
    for (int a = 0; a < 4; a++)
        q[a] /= sqrt(n);
    const double position[3] = {(double)rng_range(rng, 10, 90), (double)rng_range(rng, 5, 60),
                                (double)rng_range(rng, 5, 60)};
    assert_ok(ost_pose_from_doubles(position, q, &pose, &err));
    return pose;
}

static ost_camera camera_of(test_rng *rng, int width, int height)
{
    ost_error err = {0};
    ost_camera c = {.focal_milli = (int32_t)(1000 * width), .width = width, .height = height};
    /* in some rounds the camera is near enough for the voxels to fill the frame */
    const double far = rng_range(rng, 0, 4) ? 1 : 0.3;
    const double to[3] = {50, 35, 34};
    double from[3];
    do
        for (int a = 0; a < 3; a++)
            from[a] = to[a] + far * (double)rng_range(rng, -120, 120);
    while (hypot(from[0] - to[0], from[1] - to[1]) < 20);
    assert_ok(ost_camera_look_at(from, to, (double[3]){0, 0, 1}, &c, &err));
    return c;
}

static void make(ost_viewer *v, const ost_volume *bone, ost_isa isa, int threads)
{
    ost_error err = {0};
    const ost_density_classes classes = ost_density_classes_default();
    ost_volume before;
    ost_tool_volume tool = rod();
    ost_mesh parts[2];
    assert_ok(ost_viewer_init(v, &bone->geometry, OST_STYLE_SMOOTH, ost_isa_name(isa), threads, &err));
    assert_ok(ost_volume_init(&before, &bone->geometry, &err));
    memcpy(before.voxels, bone->voxels, COUNT * sizeof *bone->voxels);
    assert_ok(ost_viewer_set_uncut(v, &before, 120, &classes, NULL, NULL, &err));
    assert_ok(ost_surface_set_volume(&v->bone, bone, 120, &err));
    assert_ok(ost_viewer_add_tool(v, &tool, &err));
    /* the second tool is drawn as a smooth mesh */
    assert_ok(ost_viewer_add_tool(v, &tool, &err));
    for (int i = 0; i < 2; i++)
        assert_ok(ost_tool_make(OST_TOOL_BURR, &(ost_tool_options){.part = i ? OST_TOOL_SHAFT : OST_TOOL_HEAD},
                                &parts[i], &err));
    assert_ok(ost_viewer_smooth_tool(v, parts, 2, &err));
    for (int i = 0; i < 2; i++)
        ost_mesh_free(&parts[i]);
    assert_ok(ost_viewer_set_ghost(v, &tool, &(ost_pose){.t = {60 * MM, 10 * MM, 20 * MM}, .qw = OST_Q30_ONE}, &err));
    v->show_ghost = false;
    ost_tool_volume_free(&tool);
}

/* Makes a random change of a kind that can occur between two frames. */
static void change(ost_viewer *v, ost_volume *bone, test_rng *rng, ost_camera *camera)
{
    ost_error err = {0};
    const int64_t what = rng_range(rng, 0, 39);
    int at[3];
    for (int tries = 0; tries < 50; tries++) {
        for (int a = 0; a < 3; a++)
            at[a] = (int)rng_range(rng, 10, a ? 60 : 90);
        if (bone->voxels[index_of(at[0], at[1], at[2])])
            break;
    }
    if (what < 16)
        ball(bone, at, (int)rng_range(rng, 1, 6), 0);
    else if (what < 26)
        v->state = (ost_live_state){.ticks = 1, .pose = pose_of(rng), .tool = (int32_t)rng_range(rng, 0, 1)};
    else if (what == 26)
        ball(bone, at, (int)rng_range(rng, 1, 5), 800);
    else if (what < 29)
        *camera = camera_of(rng, camera->width, camera->height);
    else if (what == 29)
        ost_viewer_set_colouring(v, (ost_colouring)rng_range(rng, 0, OST_COLOUR_COUNT - 1));
    else if (what == 30) {
        ost_clip clip;
        const double to[3] = {50, 35, 34}, normal[3] = {(double)rng_range(rng, 1, 9), (double)rng_range(rng, -9, 9),
                                                        (double)rng_range(rng, -9, 9)};
        assert_ok(ost_clip_make(&v->bone.geometry, to, normal, &clip, &err));
        ost_viewer_set_clip(v, rng_range(rng, 0, 1) ? &clip : NULL);
    } else if (what == 31)
        v->show_ghost = !v->show_ghost;
    else if (what == 32)
        v->overlays ^= 1u << rng_range(rng, 0, OST_OVERLAY_COUNT - 1);
    else if (what == 33)
        v->style = v->style == OST_STYLE_SMOOTH ? OST_STYLE_FACES : OST_STYLE_SMOOTH;
    else if (what == 34)
        ost_viewer_set_contact(v, !v->bone.shows_contact);
    else if (what == 35)
        ost_surface_age(&v->bone);
    else if (what == 36)
        v->has_state = !v->has_state;
    if (what < 16 || what == 26)
        assert_ok(ost_surface_set_volume(&v->bone, bone, 120, &err));
}

/*
 * Writes over a part of the frame, as a window does with its HUD, and sometimes over the complete
 * frame, as another renderer does.
 */
static void write_over(ost_frame *f, test_rng *rng)
{
    const ost_sheet sheet = ost_frame_sheet(f);
    if (rng_range(rng, 0, 1))
        ost_sheet_box(&sheet, (int)rng_range(rng, -20, f->width), (int)rng_range(rng, -20, f->height),
                      (int)rng_range(rng, 1, 90), (int)rng_range(rng, 1, 40), 0x123456, 128);
    if (rng_range(rng, 0, 15))
        return;
    const size_t count = (size_t)f->planes.stride * (size_t)f->height;
    memset(f->planes.colour, 0x55, count * sizeof *f->planes.colour);
    memset(f->planes.depth, 0x55, count * sizeof *f->planes.depth);
    memset(f->planes.face, 1, count);
    ost_frame_overwritten(f);
}

static void assert_same(const ost_frame *a, const ost_frame *b)
{
    for (int y = 0; y < a->height; y++) {
        const size_t at = (size_t)y * (size_t)a->planes.stride, n = (size_t)a->width;
        assert_memory_equal(a->planes.colour + at, b->planes.colour + at, n * sizeof *a->planes.colour);
        assert_memory_equal(a->planes.face + at, b->planes.face + at, n);
        for (size_t x = at; x < at + n; x++)
            if (a->planes.face[x] != OST_NO_FACE)
                assert_memory_equal(a->planes.depth + x, b->planes.depth + x, sizeof(float));
    }
}

static size_t cells_in(const ost_cells *c)
{
    size_t count = 0;
    for (int i = 0; i < c->words * c->rows; i++)
        count += (size_t)__builtin_popcountll(c->bit[i]);
    return count;
}

typedef struct drawn {
    int frames, parts; /* number of frames, and number of frames that were drawn only in part */
    size_t smooth;     /* number of pixels that antialiasing or a line changed */
    size_t cells;      /* number of cells drawn in all frames that were drawn only in part */
} drawn;

/* Pixels that differ from the previous frame must be in the cells that the frame reports as changed. */
static void check_changed(const ost_frame *f, uint32_t *previous, bool follows)
{
    ost_cells changed;
    assert_true(ost_cells_init(&changed, f->width, f->height));
    ost_frame_changed(f, &changed);
    for (int y = 0; y < f->height; y++)
        for (int x = 0; x < f->width; x++) {
            const uint32_t colour = f->planes.colour[(size_t)y * (size_t)f->planes.stride + (size_t)x];
            uint32_t *was = &previous[(size_t)y * (size_t)f->width + (size_t)x];
            assert_true(!follows || *was == colour || ost_cells_has(&changed, x, y));
            *was = colour;
        }
    ost_cells_free(&changed);
}

/* Draws a frame and compares it with the same picture drawn in a new frame, and with the previous picture. */
static void draw(ost_viewer *v, const ost_camera *camera, uint32_t *previous, bool follows, drawn *d)
{
    ost_error err = {0};
    assert_ok(ost_viewer_update(v, &err));
    assert_ok(ost_viewer_draw(v, camera, &err));
    check_changed(&v->frame, previous, follows);
    if (v->antialiased)
        for (int y = 0; y < v->frame.height; y++)
            for (int x = 0; x < v->frame.width; x++) {
                const size_t i = (size_t)y * (size_t)v->frame.planes.stride + (size_t)x;
                d->smooth += v->frame.planes.colour[i] != v->frame.drawn.colour[i];
            }
    const ost_frame stored = v->frame;
    v->frame = (ost_frame){0};
    assert_ok(ost_viewer_draw(v, camera, &err));
    assert_same(&v->frame, &stored);
    d->frames++;
    const size_t cells = cells_in(&stored.part);
    if (cells < (size_t)(stored.part.across * stored.part.rows)) {
        d->parts++;
        d->cells += cells;
    }
    ost_frame_free(&v->frame);
    v->frame = stored;
}

static void partial_frames_equal_complete_frames(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("kept");
    drawn d = {0};
    for (int round = 0; round < 9; round++) {
        const ost_isa isas[3] = {OST_ISA_SCALAR, OST_ISA_AVX2, OST_ISA_AVX512};
        ost_volume bone = make_bone(&rng);
        ost_viewer v;
        if (ost_isa_available(isas[round % 3])) {
            make(&v, &bone, isas[round % 3], 1 + round / 3);
            v.antialiased = round % 2 == 0;
            ost_camera camera = camera_of(&rng, (int)rng_range(&rng, 100, 200), (int)rng_range(&rng, 70, 120));
            v.has_state = true;
            v.state = (ost_live_state){.ticks = 1, .pose = pose_of(&rng)};
            uint32_t *previous = malloc((size_t)camera.width * (size_t)camera.height * sizeof *previous);
            assert_non_null(previous);
            for (int i = 0; i < 60; i++) {
                draw(&v, &camera, previous, i > 0, &d);
                write_over(&v.frame, &rng);
                for (int64_t n = rng_range(&rng, 0, 2); n > 0; n--)
                    change(&v, &bone, &rng, &camera);
            }
            free(previous);
            ost_viewer_free(&v);
        }
        ost_volume_free(&bone);
    }
    printf("# %d frames, %d of them drawn only in part, with a mean of %zu cells\n", d.frames, d.parts,
           d.cells / (size_t)d.parts);
    assert_true(2 * d.parts > d.frames && d.smooth > 1000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(partial_frames_equal_complete_frames)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
