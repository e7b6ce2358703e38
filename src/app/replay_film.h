/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A video of a session that is done again: each of its frames at its moment
 * of the operation, none left out, whatever the machine takes for it.
 */
#ifndef OST_APP_REPLAY_FILM_H
#define OST_APP_REPLAY_FILM_H

#include "app/appearance.h"
#include "app/film.h"
#include "app/replay.h"

typedef struct replay_film_options {
    film_options video;
    const char *size;
    int view, style, width, height;
    appearance_options look;
    bool contact; /* where bone went just then is shown */
} replay_film_options;

/* Rows for a verb's table of options. */
#define REPLAY_FILM_OPTIONS(f)                                                                                                            \
    VIDEO_OPTIONS((f).video),                                                                                                             \
    {.name = "view", .kind = OPTION_CHOICE, .out = &(f).view, .value = "operator|en-face|lateral|anterior|posterior|superior|tool|whole", \
     .help = "of the video: where it looks from (default: operator)"},                                                                   \
    {.name = "size", .kind = OPTION_TEXT, .out = &(f).size, .value = "WxH", .help = "of the video, in pixels (default: 1280x720)"},        \
    {.name = "style", .kind = OPTION_CHOICE, .out = &(f).style, .value = "smooth|faces",                                                  \
     .help = "of the video: lit by the surface's normals (default), or the thesis'\nflat faces"},                                        \
    APPEARANCE_OPTIONS((f).look),                                                                                                         \
    {.name = "contact", .kind = OPTION_FLAG, .out = &(f).contact, .help = "of the video: show where bone went just then"}

typedef struct replay_film replay_film;

ost_status replay_film_check(const app_state *app, replay_film_options *options, ost_error *err);
/* Nothing when no video is asked for. plan NULL: none is known. r's ticks then go into it. */
ost_status replay_film_begin(const app_state *app, const replay_film_options *options, replay *r, const ost_metrics_plan *plan, replay_film **out,
                             ost_error *err);
/* The video is whole, and said. */
ost_status replay_film_end(const app_state *app, replay_film *f, ost_error *err);
void replay_film_free(replay_film *f); /* NULL is allowed */

#endif
