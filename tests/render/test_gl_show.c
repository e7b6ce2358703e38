/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests pictures that OpenGL shows in a framebuffer without reading them back. The smoothed colours must be
 * bit-identical to those of the processor's antialiasing, with and without a sheet of letters over the picture. The
 * renderer must draw the same picture in its own context and in a context that the caller made current, and must leave
 * no OpenGL error in the caller's context. The test is skipped if OpenGL without a display is not available.
 * Covers: REQ-GL-SHOW
 */
#include "config.h"

#include <stdlib.h>
#include <string.h>

#include "gl_scene.h"
#include "render/gl/gl.h"
#include "render/lettering.h"

#ifdef HAVE_GL
#include <epoxy/gl.h>

static ost_gl *gl;
static char reason[OST_ERROR_TEXT];

static void skip_without_gl(void)
{
    if (!gl) {
        printf("# skipped: %s\n", reason);
        skip();
    }
}

typedef struct scene {
    ost_volume bone_voxels, tool_voxels;
    ost_surface bone, tool;
    ost_frame_thing thing[2];
    int width, height;
} scene;

static scene scene_of(const char *seed, int width, int height)
{
    test_rng rng = rng_seeded(seed);
    ost_error err = {0};
    scene s = {.bone_voxels = body(&rng, 90, OST_PM_PER_MM),
               .tool_voxels = body(&rng, 40, OST_PM_PER_MM / 3),
               .width = width,
               .height = height};
    const double q[4] = {0.8, 0.3, -0.4, 0.33}, at[3] = {50, 2, 40};
    ost_pose pose;
    assert_ok(ost_pose_from_doubles(at, q, &pose, &err));
    s.bone = surface_of(&s.bone_voxels);
    s.tool = surface_of(&s.tool_voxels);
    const ost_camera c = look(&s.bone_voxels.geometry, 0.3, -1, 0.3, 140, 5, width, height);
    s.thing[0] = (ost_frame_thing){.eye = ost_eye_make(&c, &s.bone_voxels.geometry), .paint = OST_PAINT_BONE};
    s.thing[1] = (ost_frame_thing){.eye = ost_eye_make_from(&c, &s.tool_voxels.geometry, &pose),
                                   .paint = OST_PAINT_STEEL};
    return s;
}

/* Sets the pointers to the surfaces of the scene. This is also necessary for each copy of a scene. */
static void set_surfaces(scene *s)
{
    s->thing[0].surface = &s->bone;
    s->thing[1].surface = &s->tool;
}

static void scene_free(scene *s)
{
    ost_surface_free(&s->bone);
    ost_surface_free(&s->tool);
    ost_volume_free(&s->bone_voxels);
    ost_volume_free(&s->tool_voxels);
}

/* A sheet, and the cells in which it may differ from the sheet that was shown last. */
typedef struct layer {
    uint32_t *pixels;
    ost_cells cells;
    ost_sheet sheet;
} layer;

static layer layer_of(int width, int height)
{
    layer l = {.pixels = calloc((size_t)width * (size_t)height, sizeof *l.pixels)};
    assert_non_null(l.pixels);
    assert_true(ost_cells_init(&l.cells, width, height));
    l.sheet = (ost_sheet){.pixels = l.pixels, .stride = width, .width = width, .height = height};
    return l;
}

static void layer_free(layer *l)
{
    free(l->pixels);
    ost_cells_free(&l->cells);
}

/* A texture in which the renderer shows its last picture, and the pixels that are read from it. */
typedef struct screen {
    ost_gl *gl;
    bool antialiased;
    const ost_gl_sheet *sheet;
    int width, height;
    uint32_t *pixels; /* rows from top to bottom */
    GLuint texture, framebuffer;
    GLenum error;
} screen;

static ost_status make_target(void *user, ost_error *err)
{
    screen *s = user;
    (void)err;
    glGenTextures(1, &s->texture);
    glBindTexture(GL_TEXTURE_2D, s->texture);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, s->width, s->height, 0, GL_RGBA, GL_UNSIGNED_BYTE, NULL);
    glGenFramebuffers(1, &s->framebuffer);
    glBindFramebuffer(GL_FRAMEBUFFER, s->framebuffer);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, s->texture, 0);
    return OST_OK;
}

static ost_status read_target(void *user, ost_error *err)
{
    screen *s = user;
    (void)err;
    glBindFramebuffer(GL_FRAMEBUFFER, s->framebuffer);
    for (int y = 0; y < s->height; y++)
        glReadPixels(0, s->height - 1 - y, s->width, 1, GL_RGBA, GL_UNSIGNED_BYTE, s->pixels + s->width * y);
    glDeleteFramebuffers(1, &s->framebuffer);
    glDeleteTextures(1, &s->texture);
    s->error = glGetError();
    return OST_OK;
}

static uint32_t *show_and_read(ost_gl *from, bool antialiased, const layer *l, bool partly)
{
    ost_error err = {0};
    const ost_gl_sheet sheet = {
        .pixels = l->pixels, .stride = l->sheet.stride, .changed = partly ? &l->cells : NULL};
    screen s = {.gl = from, .width = l->sheet.width, .height = l->sheet.height};
    s.pixels = calloc((size_t)s.width * (size_t)s.height, sizeof *s.pixels);
    assert_non_null(s.pixels);
    assert_ok(ost_gl_do(from, make_target, &s, &err));
    assert_ok(ost_gl_show(from, s.framebuffer, antialiased, &sheet, &err));
    assert_ok(ost_gl_do(from, read_target, &s, &err));
    assert_int_equal(s.error, GL_NO_ERROR);
    return s.pixels;
}

/* Returns the colours of the picture after the processor has smoothed them. */
static void read_frame(ost_frame *frame, const scene *s, bool antialiased)
{
    ost_error err = {0};
    assert_ok(ost_frame_init(frame, s->width, s->height, OST_STYLE_SMOOTH, OST_ISA_SCALAR, 1, &err));
    if (antialiased)
        assert_ok(ost_frame_antialias(frame, OST_ISA_SCALAR, &err));
    assert_ok(ost_gl_read(gl, frame, false, &err));
    ost_frame_overwritten(frame);
}

static int differences(const ost_frame *frame, const uint32_t *pixels, int least)
{
    int count = 0;
    for (int y = 0; y < frame->height; y++)
        for (int x = 0; x < frame->width; x++) {
            const uint32_t a = frame->planes.colour[(size_t)y * (size_t)frame->planes.stride + (size_t)x],
                           b = pixels[frame->width * y + x];
            bool differs = false;
            for (int channel = 0; channel < 24; channel += 8)
                differs |= abs((int)(a >> channel & 255) - (int)(b >> channel & 255)) >= least;
            count += differs;
        }
    return count;
}

/* Widths and heights of frames. Most of them are not multiples of the width and the height of a cell. */
static const int sizes[][2] = {{333, 187}, {64, 48}, {17, 9}, {480, 270}};

static void test_smoothed_colours(void **state)
{
    (void)state;
    skip_without_gl();
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        ost_error err = {0};
        scene s = scene_of("smoothed colours", sizes[i][0], sizes[i][1]);
        layer empty = layer_of(s.width, s.height);
        ost_frame frame, rough;
        set_surfaces(&s);
        assert_ok(ost_gl_draw(gl, &ost_gl_ours, s.thing, 2, OST_STYLE_SMOOTH, &err));
        read_frame(&frame, &s, true);
        read_frame(&rough, &s, false);
        uint32_t *smooth = show_and_read(gl, true, &empty, false), *plain = show_and_read(gl, false, &empty, false);
        const int changed = differences(&rough, smooth, 1);
        printf("# %dx%d: antialiasing changes %d pixels\n", s.width, s.height, changed);
        assert_true(changed > s.width);
        assert_int_equal(differences(&frame, smooth, 1), 0);
        assert_int_equal(differences(&rough, plain, 1), 0);
        free(smooth);
        free(plain);
        ost_frame_free(&frame);
        ost_frame_free(&rough);
        layer_free(&empty);
        scene_free(&s);
    }
}

/* Draws letters and boxes, as a HUD does. */
static void draw_letters(const ost_sheet *sheet, const ost_lettering *letters, int step)
{
    ost_sheet_box(sheet, 20 + 7 * step, 30, 200, 60, 0x0e0c0a, 200);
    ost_lettering_draw(letters, sheet, 30 + 7 * step, 60, "Reamer 12.5 N", 0xf4f1ee);
    ost_sheet_box(sheet, sheet->width - 90, sheet->height - 30, 200, 60, 0x2040c0, 256);
    ost_lettering_draw(letters, sheet, sheet->width - 80, sheet->height - 10 - step, "10 mm", 0xb9b2aa);
}

static void test_sheet(void **state)
{
    (void)state;
    skip_without_gl();
    ost_error err = {0};
    scene s = scene_of("sheet", 333, 187);
    ost_lettering *letters;
    set_surfaces(&s);
    assert_ok(ost_lettering_create(14, &letters, &err));
    assert_ok(ost_gl_draw(gl, &ost_gl_ours, s.thing, 2, OST_STYLE_SMOOTH, &err));
    layer l = layer_of(s.width, s.height);
    l.sheet.written = &l.cells;
    for (int step = 0; step < 4; step++) {
        /* The changed cells are those of the previous sheet and those of the new one. */
        memset(l.pixels, 0, (size_t)s.width * (size_t)s.height * sizeof *l.pixels);
        draw_letters(&l.sheet, letters, step);
        uint32_t *partly = show_and_read(gl, true, &l, step > 0), *completely = show_and_read(gl, true, &l, false);
        assert_memory_equal(partly, completely, (size_t)s.width * (size_t)s.height * sizeof *partly);
        ost_frame frame;
        read_frame(&frame, &s, true);
        const ost_sheet over = ost_frame_sheet(&frame);
        const int bare = differences(&frame, partly, 3);
        draw_letters(&over, letters, step);
        assert_true(bare > 10000);
        assert_int_equal(differences(&frame, partly, 3), 0); /* blending rounds down once for each of two layers */
        ost_frame_free(&frame);
        free(partly);
        free(completely);
        ost_cells_clear(&l.cells);
        draw_letters(&l.sheet, letters, step);
    }
    layer_free(&l);
    ost_lettering_free(letters);
    scene_free(&s);
}

typedef struct guest {
    scene *s;
    uint32_t *pixels;
    ost_gl_info info;
} guest;

static ost_status draw_in_current_context(void *user, ost_error *out)
{
    guest *g = user;
    ost_error err = {0};
    (void)out;
    const ost_gl_options options = {.current = true};
    ost_gl *here;
    layer empty = layer_of(g->s->width, g->s->height);
    assert_ok(ost_gl_open(&options, &here, &err));
    g->info = ost_gl_info_get(here);
    assert_ok(ost_gl_draw(here, &ost_gl_ours, g->s->thing, 2, OST_STYLE_SMOOTH, &err));
    g->pixels = show_and_read(here, true, &empty, false);
    ost_gl_close(here);
    assert_int_equal(glGetError(), GL_NO_ERROR);
    /* A renderer whose context was destroyed is freed without OpenGL calls. In this test, the context still exists, so
       the renderer's objects remain in it. */
    assert_ok(ost_gl_open(&options, &here, &err));
    assert_ok(ost_gl_draw(here, &ost_gl_ours, g->s->thing, 2, OST_STYLE_SMOOTH, &err));
    ost_gl_abandon(here);
    layer_free(&empty);
    return OST_OK;
}

static void test_current_context(void **state)
{
    (void)state;
    skip_without_gl();
    ost_error err = {0};
    scene s = scene_of("current context", 200, 120);
    layer empty = layer_of(s.width, s.height);
    guest g = {.s = &s};
    set_surfaces(&s);
    assert_ok(ost_gl_draw(gl, &ost_gl_ours, s.thing, 2, OST_STYLE_SMOOTH, &err));
    uint32_t *before = show_and_read(gl, true, &empty, false);
    assert_ok(ost_gl_do(gl, draw_in_current_context, &g, &err));
    assert_string_equal(g.info.way, "the window's context");
    assert_string_equal(g.info.driver, ost_gl_info_get(gl).driver);
    assert_memory_equal(before, g.pixels, (size_t)s.width * (size_t)s.height * sizeof *before);
    /* The renderer with its own context must still draw the same picture. */
    assert_ok(ost_gl_draw(gl, &ost_gl_ours, s.thing, 2, OST_STYLE_SMOOTH, &err));
    uint32_t *after = show_and_read(gl, true, &empty, false);
    assert_memory_equal(before, after, (size_t)s.width * (size_t)s.height * sizeof *before);
    free(before);
    free(after);
    free(g.pixels);
    layer_free(&empty);
    scene_free(&s);
}

static int begin(void **state)
{
    (void)state;
    ost_error err = {0};
    const ost_gl_options options = {.debug = true};
    if (getenv("OST_UNDER_VALGRIND"))
        snprintf(reason, sizeof reason, "valgrind cannot check the code of an OpenGL driver");
    else if (ost_gl_open(&options, &gl, &err) != OST_OK)
        memcpy(reason, err.text, sizeof reason);
    return 0;
}

static int end(void **state)
{
    (void)state;
    ost_gl_close(gl);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_smoothed_colours),
        cmocka_unit_test(test_sheet),
        cmocka_unit_test(test_current_context),
    };
    const int failed = cmocka_run_group_tests(tests, begin, end);
    return failed ? failed : *reason ? 77 : 0;
}
#else
int main(void)
{
    puts("# skipped: built without OpenGL (libepoxy)");
    return 77;
}
#endif
