/* SPDX-License-Identifier: Apache-2.0 */
/* The arguments of `osteon replay`. */
#ifndef OST_APP_REPLAY_ARGS_H
#define OST_APP_REPLAY_ARGS_H

#include "app/input/glenoid_plan.h"
#include "app/replay/film.h"

typedef struct replay_args {
    const char *session, *bone, *out, *debrief;
    option_list tools;
    glenoid_plan_options plan; /* options of the plan, for the debrief */
    replay_film_options film;
    int64_t ticks;
    bool ticks_given, verify, compress;
} replay_args;

#endif
