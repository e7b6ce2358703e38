/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writes a video of a replayed session. Each frame shows the operation at the time of the frame. No frame is dropped,
 * even if rendering is slow.
 */
#ifndef OST_APP_REPLAY_FILM_H
#define OST_APP_REPLAY_FILM_H

#include "app/picture/appearance.h"
#include "app/film/film.h"
#include "app/replay/replay.h"

typedef struct replay_film_options {
    film_options video;
    const char *size;
    int view, style, width, height;
    appearance_options look;
    bool contact; /* true if voxels that were just removed are highlighted */
} replay_film_options;

/* Rows for a verb's table of options. */
#define REPLAY_FILM_OPTIONS(f)                                                                                    \
    VIDEO_OPTIONS((f).video),                                                                                     \
    {.name = "view", .kind = OPTION_CHOICE, .out = &(f).view, .value = OST_VIEW_NAMES,                            \
     .help = "direction of view (default: operator)"},                                                            \
    {.name = "size", .kind = OPTION_TEXT, .out = &(f).size, .value = "WxH",                                       \
     .help = "size of the frames in pixels (default: 1280x720)"},                                                 \
    {.name = "style", .kind = OPTION_CHOICE, .out = &(f).style, .value = "smooth|faces",                          \
     .help = "shade by the surface's normals and smooth the edges (default), or draw flat faces as in the "       \
             "thesis"},                                                                                           \
    APPEARANCE_OPTIONS((f).look),                                                                                 \
    {.name = "contact", .kind = OPTION_FLAG, .out = &(f).contact, .help = "highlight bone that was just removed"}

typedef struct replay_film replay_film;

ost_status replay_film_check(const app_state *app, replay_film_options *options, ost_error *err);
/*
 * Begins the video. After this call, the ticks that `r` replays are drawn. Does nothing if no video is requested.
 * `plan` is NULL if there is none.
 */
ost_status replay_film_begin(const app_state *app, const replay_film_options *options, replay *r,
                             const ost_metrics_plan *plan, replay_film **out, ost_error *err);
/* Completes the video and prints its report. */
ost_status replay_film_end(const app_state *app, replay_film *f, ost_error *err);
void replay_film_free(replay_film *f); /* f may be NULL */

#endif
