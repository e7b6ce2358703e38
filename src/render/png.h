/* SPDX-License-Identifier: Apache-2.0 */
/* PNG at a price: small, or soon. */
#ifndef OST_RENDER_PNG_H
#define OST_RENDER_PNG_H

#include <osteon/picture.h>

typedef enum ost_png_effort { OST_PNG_SMALL, OST_PNG_FAST } ost_png_effort;

/* As ost_picture_encode_png, which takes its time. */
ost_status ost_png_encode(const ost_picture *picture, ost_png_effort effort, uint8_t **bytes, size_t *size, ost_error *err);

#endif
