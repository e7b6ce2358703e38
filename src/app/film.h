/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Frames to the disk, by a thread of its own: single pictures, and a video.
 *
 *   who draws --copy--> at most a dozen that wait --writer--> FOLDER/frame-000000.png ...      a folder
 *                           |                              FILE.y4m
 *                           '-- no room: left out,         ffmpeg --> FILE.mp4, .mkv, .mov, .webm
 *                               and counted                sh -c COMMAND, which gets a .y4m on its standard input
 *
 * A video goes by the clock it is given: what was left out, and what nobody
 * drew because nothing changed, is the frame before once more.  Its size is
 * the first frame's; others are fitted into it.
 *
 * Nothing is written over: pictures take the next name that is free.  A file
 * has its name when it is whole.
 */
#ifndef OST_APP_FILM_H
#define OST_APP_FILM_H

#include "app/app.h"

enum { FILM_TEXT = 200 };

typedef struct film_options {
    const char *target, *pipe; /* of a video: one of them, or neither */
    int64_t fps;               /* of it */
    bool wait;                 /* for the writer, rather than leave a frame out */
} film_options;

typedef struct film_report {
    uint64_t frames;   /* of the video */
    uint64_t repeated; /* of these, the one before once more */
    uint64_t dropped;  /* that were drawn and left out */
    int width, height;
} film_report;

typedef struct film film;

/* Rows for a verb's table of options. */
#define VIDEO_OPTIONS(v)                                                                                                                  \
    {.name = "video", .kind = OPTION_TEXT, .out = &(v).target, .value = "TARGET",                                                  \
     .help = "a video: .mp4, .mkv, .mov or .webm by ffmpeg, .y4m without it,\nor a folder of numbered PNGs"},                     \
    {.name = "video-pipe", .kind = OPTION_TEXT, .out = &(v).pipe, .value = "COMMAND",                                              \
     .help = "the same to a shell's command, which gets YUV4MPEG2 on its standard\ninput, as ffmpeg, x264 and mpv read it"},      \
    {.name = "video-fps", .kind = OPTION_INTEGER, .out = &(v).fps, .min = 1, .max = 240, .value = "N", .help = "frames a second of it (default: 30)"}

/* Usage that can be refused before anything is done. */
ost_status film_check(const app_state *app, const film_options *options, ost_error *err);
/* OST_ERR_UNAVAILABLE when there is no encoder. */
ost_status film_open(const film_options *options, film **out, ost_error *err);

/* pixels: 0x..BBGGRR, rows of stride, copied. The calls that follow are one thread's. */
/* Whether the video has no frame for t_ns yet; times ascend, the first is the video's beginning. */
bool film_wants(const film *f, int64_t t_ns);
void film_frame(film *f, int64_t t_ns, const uint32_t *pixels, int stride, int width, int height);
/* Into the folder at hand, as osteon-001.png and on; what became of it is said later. */
void film_still(film *f, const uint32_t *pixels, int stride, int width, int height);
/* What there is to say since it was asked last, or NULL. */
const char *film_said(film *f, char text[FILM_TEXT]);
uint64_t film_dropped(film *f);

/* All that waits is written; the last frame stays until end_ns. Frees it in any case; report may be NULL, and f. */
ost_status film_close(film *f, int64_t end_ns, film_report *report, ost_error *err);
/* To people, and as "video" in the verb's result. */
void film_say(const app_state *app, const film_options *options, const film_report *report);

#endif
