/* SPDX-License-Identifier: Apache-2.0 */
/* What brings pixels to a window: a texture on a triangle that covers it, in the context that is current. */
#ifndef OST_WINDOW_SHOWN_H
#define OST_WINDOW_SHOWN_H

#include <stdbool.h>
#include <stdint.h>

#include <epoxy/gl.h>

typedef struct ost_shown {
    GLuint program, texture, nothing; /* nothing: a vertex array, which a core profile asks for */
    int width, height;                /* of the texture */
} ost_shown;

/* False when the driver does not take the program. */
bool ost_shown_make(ost_shown *shown);
void ost_shown_free(ost_shown *shown); /* also of a zeroed one */
/* Into a frame of frame_width x frame_height. False when there is no memory for the texture. */
bool ost_shown_draw(ost_shown *shown, const uint32_t *pixels, int stride, int width, int height, int frame_width, int frame_height);

#endif
