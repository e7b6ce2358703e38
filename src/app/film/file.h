/* SPDX-License-Identifier: Apache-2.0 */
/* Writes a video to a folder of pictures, to a .y4m file (YUV4MPEG2, 4:4:4, BT.709), or to a
   program. An output must be used by one thread only. */
#ifndef OST_APP_FILM_FILE_H
#define OST_APP_FILM_FILE_H

#include "app/common/app.h"

typedef struct film_file film_file;

/*
 * Opens the output. Exactly one of `target` and `command` is NULL. `command` is a shell command. If the extension of
 * `target` is known, `target` is a file. If not, `target` is a folder; the function creates the folder if necessary.
 */
ost_status film_file_open(const char *target, const char *command, int fps, film_file **out, ost_error *err);
/* Writes a frame. `pixels` contains rows of `width` pixels. The first frame determines the size of the video. */
ost_status film_file_frame(film_file *file, const uint32_t *pixels, int width, int height, ost_error *err);
/* Repeats the previous frame of the video. */
ost_status film_file_again(film_file *file, ost_error *err);
/*
 * Closes the output and frees `file` in any case; `file` may be NULL. If err is NULL, the output file is discarded. The
 * caller passes NULL if an earlier call failed.
 */
ost_status film_file_close(film_file *file, ost_error *err);

#endif
