/* SPDX-License-Identifier: Apache-2.0 */
/* Where a video goes: a folder of pictures, a .y4m (YUV4MPEG2, 4:4:4, BT.709), or what a program makes of one. One thread. */
#ifndef OST_APP_FILM_FILE_H
#define OST_APP_FILM_FILE_H

#include "app/app.h"

typedef struct film_file film_file;

/* target: by its name's end a file, else a folder, which is made if need be; or a shell's command. */
ost_status film_file_open(const char *target, const char *command, int fps, film_file **out, ost_error *err);
/* pixels: width a row. The first says the video's size. */
ost_status film_file_frame(film_file *file, const uint32_t *pixels, int width, int height, ost_error *err);
/* The one before once more. */
ost_status film_file_again(film_file *file, ost_error *err);
/* Frees it in any case; NULL is allowed. err NULL: it failed before, and no file is to be left. */
ost_status film_file_close(film_file *file, ost_error *err);

#endif
