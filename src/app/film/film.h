/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writes frames to disk on a separate thread, as single pictures and as a video.
 *
 *   renderer --copy--> queue of at most a dozen --writer--> FOLDER/frame-000000.png ...      a folder
 *                            |                              FILE.y4m
 *                            '-- queue full: dropped,       ffmpeg --> FILE.mp4, .mkv, .mov, .webm
 *                                and counted                sh -c COMMAND, which reads a .y4m from its standard input
 *
 * The caller passes the time of each frame. In the video, the previous frame is repeated for each dropped frame and
 * while nothing changes. The video has the size of the first frame; frames of other sizes are scaled to fit.
 *
 * No file is overwritten: a picture gets the next free name. A video file gets its name only when
 * it is complete.
 */
#ifndef OST_APP_FILM_FILM_H
#define OST_APP_FILM_FILM_H

#include "app/common/app.h"

enum { FILM_TEXT = 200 };

typedef struct film_options {
    const char *target, *pipe; /* destination of the video; at most one of `target` and `pipe` is set */
    int64_t fps;
    /* if true, a caller waits for the writer while the queue is full; if false, the frame is dropped */
    bool wait;
} film_options;

typedef struct film_report {
    uint64_t frames;
    uint64_t repeated; /* number of frames in the video that repeat the previous frame, because no new one was ready */
    uint64_t dropped;  /* number of frames that were drawn but not written */
    int width, height;
} film_report;

typedef struct film film;

/* The rows of the video options in a verb's option table. */
#define VIDEO_OPTIONS(v)                                                                                          \
    {.name = "video", .kind = OPTION_OUTPUT, .out = &(v).target, .value = "TARGET",                               \
     .help = "write a video: .mp4, .mkv, .mov or .webm (these need ffmpeg), .y4m, or a folder of numbered PNGs"}, \
    {.name = "video-pipe", .kind = OPTION_TEXT, .out = &(v).pipe, .value = "COMMAND",                             \
     .help = "write the video as YUV4MPEG2 to the standard input of this shell command, such as ffmpeg, x264 "    \
             "or mpv"},                                                                                           \
    {.name = "video-fps", .kind = OPTION_INTEGER, .out = &(v).fps, .min = 1, .max = 240, .value = "N",            \
     .help = "frames per second of the video (default: 30)"}

/* Checks the options before the operation starts. Returns OST_ERR_USAGE if they are invalid. */
ost_status film_check(const app_state *app, const film_options *options, ost_error *err);
/* Opens a film. Returns OST_ERR_UNAVAILABLE if no encoder is found. */
ost_status film_open(const film_options *options, film **out, ost_error *err);

/*
 * The following functions must be called on one thread. `pixels` contains values 0x..BBGGRR in rows of `stride`
 * pixels; the functions copy these values.
 */
/*
 * Returns true if the video has no frame for the time t_ns yet. Times must not decrease from call to call. The first
 * time is the beginning of the video.
 */
bool film_is_due(const film *f, int64_t t_ns);
void film_frame(film *f, int64_t t_ns, const uint32_t *pixels, int stride, int width, int height);
/*
 * Saves a picture in the current folder under the next free name, such as osteon-001.png. film_message reports the
 * result.
 */
void film_still(film *f, const uint32_t *pixels, int stride, int width, int height);
/* Returns the latest message. Returns NULL if there is no new message since the previous call. */
const char *film_message(film *f, char text[FILM_TEXT]);
uint64_t film_dropped(film *f);

/* Writes all queued frames and repeats the last frame until end_ns. Frees f in any case. f and report may be NULL. */
ost_status film_close(film *f, int64_t end_ns, film_report *report, ost_error *err);
/* Prints the report of a video, and adds it to the verb's result as "video". */
void film_print_report(const app_state *app, const film_options *options, const film_report *report);

#endif
