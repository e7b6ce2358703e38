/* SPDX-License-Identifier: Apache-2.0 */
/* Encodes pictures as PNG, with a choice between small files and fast encoding. */
#ifndef OST_RENDER_PNG_H
#define OST_RENDER_PNG_H

#include <osteon/picture.h>

typedef enum ost_png_effort { OST_PNG_SMALL, OST_PNG_FAST } ost_png_effort;

/* Encodes a picture as ost_picture_encode_png does. `effort` selects a small file or fast encoding. */
ost_status ost_png_encode(const ost_picture *picture, ost_png_effort effort, uint8_t **bytes, size_t *size,
                          ost_error *err);

#endif
