/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures and drawing on them (canvas.h). */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "render/canvas.h"

enum { PICTURE_SIDE_MAX = 16384 };

ost_status ost_picture_init(ost_picture *picture, int width, int height, ost_error *err)
{
    memset(picture, 0, sizeof *picture);
    if (width < 1 || height < 1 || width > PICTURE_SIDE_MAX || height > PICTURE_SIDE_MAX)
        return ost_fail(err, OST_ERR_RANGE, "a picture of %d x %d pixels: expected 1 to %d a side", width, height, PICTURE_SIDE_MAX);
    size_t bytes = (size_t)width * (size_t)height * 3;
    picture->rgb = calloc(bytes, 1);
    if (!picture->rgb)
        return ost_fail(err, OST_ERR_MEMORY, "no memory for a picture of %zu bytes", bytes);
    picture->width = width;
    picture->height = height;
    return OST_OK;
}

void ost_picture_free(ost_picture *picture)
{
    if (!picture)
        return;
    free(picture->rgb);
    memset(picture, 0, sizeof *picture);
}

void ost_canvas_blend(ost_picture *picture, int x, int y, ost_rgb colour, double alpha)
{
    if (x < 0 || y < 0 || x >= picture->width || y >= picture->height)
        return;
    uint8_t *p = picture->rgb + 3 * ((size_t)y * (size_t)picture->width + (size_t)x);
    p[0] = (uint8_t)(p[0] + alpha * (colour.r - p[0]) + 0.5);
    p[1] = (uint8_t)(p[1] + alpha * (colour.g - p[1]) + 0.5);
    p[2] = (uint8_t)(p[2] + alpha * (colour.b - p[2]) + 0.5);
}

void ost_canvas_rect(ost_picture *picture, int x, int y, int width, int height, ost_rgb colour, double alpha)
{
    for (int j = y < 0 ? 0 : y; j < y + height && j < picture->height; j++)
        for (int i = x < 0 ? 0 : x; i < x + width && i < picture->width; i++)
            ost_canvas_blend(picture, i, j, colour, alpha);
}

int ost_canvas_text_width(const char *text, int scale)
{
    size_t n = strlen(text);
    return n ? ((int)n * OST_GLYPH_ADVANCE - 1) * scale : 0;
}

void ost_canvas_text(ost_picture *picture, int x, int y, int scale, ost_rgb colour, const char *text)
{
    for (; *text; text++, x += OST_GLYPH_ADVANCE * scale) {
        const uint8_t *rows = ost_font_glyph(*text);
        for (int j = 0; rows && j < OST_GLYPH_HEIGHT; j++)
            for (int i = 0; i < OST_GLYPH_WIDTH; i++)
                if (rows[j] >> (OST_GLYPH_WIDTH - 1 - i) & 1)
                    ost_canvas_rect(picture, x + i * scale, y + j * scale, scale, scale, colour, 1);
    }
}

void ost_canvas_scale_bar(ost_picture *picture, int x, int y, int max_pixels, double mm_per_pixel, int scale, ost_rgb colour)
{
    double room = max_pixels * mm_per_pixel, length = 0;
    for (double decade = 1e-3; decade < 1e5; decade *= 10)
        for (int step = 1; step <= 5; step += step == 1 ? 1 : 3) /* 1, 2, 5 */
            if (step * decade <= room)
                length = step * decade;
    if (!(length > 0))
        return;
    int pixels = (int)(length / mm_per_pixel + 0.5);
    ost_canvas_rect(picture, x, y - scale, pixels, scale, colour, 1);
    ost_canvas_rect(picture, x, y - 4 * scale, scale, 3 * scale, colour, 1);
    ost_canvas_rect(picture, x + pixels - scale, y - 4 * scale, scale, 3 * scale, colour, 1);
    char text[32];
    snprintf(text, sizeof text, "%g mm", length);
    ost_canvas_text(picture, x + (pixels - ost_canvas_text_width(text, scale)) / 2, y - (6 + OST_GLYPH_HEIGHT) * scale, scale, colour,
                    text);
}

void ost_orientation_letters(const double direction[3], char letters[4])
{
    static const char names[3][2] = {{'R', 'L'}, {'A', 'P'}, {'I', 'S'}};
    double size[3], length2 = 0;
    for (int a = 0; a < 3; a++) {
        size[a] = direction[a] < 0 ? -direction[a] : direction[a];
        length2 += size[a] * size[a];
    }
    int n = 0;
    bool used[3] = {false, false, false};
    while (n < 3) {
        int best = -1;
        for (int a = 0; a < 3; a++)
            if (!used[a] && (best < 0 || size[a] > size[best]))
                best = a;
        if (n > 0 && size[best] * size[best] < 0.12 * length2) /* less than 20 degrees from the picture's own axis */
            break;
        used[best] = true;
        letters[n++] = names[best][direction[best] > 0];
    }
    letters[n] = '\0';
}
