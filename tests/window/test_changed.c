/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests ost_changed_copy, which copies a picture over the previous one and returns boxes around the pixels that
 * differ. After any change, a screen that receives only these boxes must show the picture. Cells that are not
 * marked as changed must not be read.
 * Covers: REQ-WINDOW
 */
#include <stdlib.h>
#include <string.h>

#include "harness.h"
#include "window/changed.h"

enum { SIDE = 700, MARGIN = 3 };

static uint32_t drawn[SIDE * (SIDE + MARGIN)], shared[SIDE * SIDE], screen[SIDE * SIDE];
static uint64_t cells[SIDE * SIDE / 64];
static unsigned seed = 1;

static int random_below(int n)
{
    seed = seed * 1664525 + 1013904223;
    return (int)((uint64_t)(seed >> 8) * (uint64_t)n >> 24);
}

static uint32_t screen_colour(uint32_t v)
{
    return (v & 0xff00) | (v >> 16 & 255) | (v & 255) << 16;
}

/*
 * Copies the boxes to the simulated screen, as the X server does. Every pixel of the screen must then equal the pixel
 * of the picture. Returns the number of copied pixels.
 */
static int64_t copy_to_screen(const ost_window_picture *p, bool everything)
{
    ost_changed_box box[OST_CHANGED_BOXES];
    const int count = ost_changed_copy(p, everything, shared, box);
    int64_t area = 0;
    assert_in_range(count, 0, OST_CHANGED_BOXES);
    for (int i = 0; i < count; i++) {
        const ost_changed_box *b = &box[i];
        assert_true(b->x >= 0 && b->y >= 0 && b->width > 0 && b->height > 0 && b->x + b->width <= p->width &&
                    b->y + b->height <= p->height);
        assert_true(i == 0 || b->y >= box[i - 1].y + box[i - 1].height);
        area += b->width * b->height;
        for (int y = b->y; y < b->y + b->height; y++)
            memcpy(screen + y * p->width + b->x, shared + y * p->width + b->x, (size_t)b->width * sizeof *screen);
    }
    for (int y = 0; y < p->height; y++)
        for (int x = 0; x < p->width; x++)
            if (screen[y * p->width + x] != screen_colour(drawn[y * p->stride + x]))
                fail_msg("%d x %d: pixel %d, %d of the screen differs from the picture", p->width, p->height, x, y);
    return area;
}

/* Changes the colours of a box and marks its cells. */
static void change(const ost_window_picture *p)
{
    const int w = 1 + random_below(random_below(3) ? 20 : p->width),
              h = 1 + random_below(random_below(3) ? 20 : p->height), x = random_below(p->width),
              y = random_below(p->height);
    for (int j = y; j < y + h && j < p->height; j++)
        for (int i = x; i < x + w && i < p->width; i++) {
            drawn[j * p->stride + i] ^= (uint32_t)(1 + random_below(0xffffff)) |
                                        0xff000000u * (unsigned)random_below(2);
            const int cell = i / OST_WINDOW_CELL_WIDTH;
            cells[j / OST_WINDOW_CELL_HEIGHT * p->changed_words + cell / 64] |= UINT64_C(1) << cell % 64;
        }
}

static void screen_equals_picture(void **state)
{
    static const int sizes[][2] = {{1, 1}, {16, 8}, {15, 7}, {17, 9}, {640, 3}, {3, 640}, {333, 517}, {700, 700}};
    (void)state;
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++)
        for (int with_cells = 0; with_cells < 2; with_cells++) {
            const int width = sizes[s][0], height = sizes[s][1], words = 1 + width / 1024;
            const ost_window_picture p = {drawn, width + MARGIN, width, height, with_cells ? cells : NULL, words};
            memset(shared, 0x55, sizeof shared);
            memset(screen, 0xaa, sizeof screen);
            assert_int_equal(copy_to_screen(&p, true), width * height);
            assert_int_equal(copy_to_screen(&p, false), 0);
            for (int frame = 0; frame < 30; frame++) {
                memset(cells, 0, sizeof cells);
                for (int n = random_below(12); n > 0; n--)
                    change(&p);
                copy_to_screen(&p, false);
            }
            /* Simulates a screen that has lost its contents. */
            memset(screen, 0, sizeof screen);
            memset(cells, 0, sizeof cells);
            assert_int_equal(copy_to_screen(&p, true), width * height);
        }
}

static void unmarked_cells_are_not_read(void **state)
{
    (void)state;
    ost_changed_box box[OST_CHANGED_BOXES];
    ost_window_picture p = {drawn, SIDE, SIDE, SIDE, cells, 1};
    memset(cells, 0, sizeof cells);
    ost_changed_copy(&p, true, shared, box);
    for (int i = 0; i < SIDE * SIDE; i++)
        drawn[i] ^= 0xff;
    assert_int_equal(ost_changed_copy(&p, false, shared, box), 0);
    /* Two cells that are far from each other must give two boxes, each of the size of a cell. */
    cells[2] = 1 << 3;
    cells[80] = 1 << 30;
    assert_int_equal(ost_changed_copy(&p, false, shared, box), 2);
    assert_int_equal(box[0].x, 48);
    assert_int_equal(box[0].y, 16);
    assert_int_equal(box[0].width, 16);
    assert_int_equal(box[0].height, 8);
    assert_int_equal(box[1].x, 480);
    assert_int_equal(box[1].y, 640);
    /* The cells are still marked as changed, but they equal the previous picture. Therefore there must be no box. */
    assert_int_equal(ost_changed_copy(&p, false, shared, box), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(screen_equals_picture),
        cmocka_unit_test(unmarked_cells_are_not_read),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
