/* SPDX-License-Identifier: Apache-2.0 */
/* Shows pixels in a window through the current OpenGL context, as a texture on a triangle that covers the window. */
#ifndef OST_WINDOW_SHOWN_H
#define OST_WINDOW_SHOWN_H

#include <stdbool.h>
#include <stdint.h>

#include <epoxy/gl.h>

typedef struct ost_shown {
    /* `nothing` is an empty vertex array object, which the core profile requires */
    GLuint program, texture, nothing;
    int width, height;                /* size of the texture */
} ost_shown;

/* Creates the OpenGL objects. Returns false if the driver rejects the program. */
bool ost_shown_make(ost_shown *shown);
/* Frees the OpenGL objects. Accepts a zero-initialized struct. */
void ost_shown_free(ost_shown *shown);
/* Draws the pixels into a framebuffer of the given size. Returns false if there is no memory for the texture. */
bool ost_shown_draw(ost_shown *shown, const uint32_t *pixels, int stride, int width, int height, int frame_width,
                    int frame_height);

#endif
