/* SPDX-License-Identifier: Apache-2.0 */
/* Parses frame sizes such as "1280x720", or "800" for a square. */
#ifndef OST_APP_FILM_FRAME_SIZE_H
#define OST_APP_FILM_FRAME_SIZE_H

#include "app/common/app.h"

/*
 * Parses the text of a frame size. If text is NULL, the size is 1280 x 720. Width and height must be from 1 to
 * OST_FRAME_MAX.
 */
ost_status frame_size(const app_state *app, const char *text, int *width, int *height, ost_error *err);

#endif
