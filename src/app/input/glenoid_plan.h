/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Finds the plan. It consists of the glenoid's position, the axis into the bone, the depth, and the scapula's
 * landmarks. If several sources contain a value, options take precedence over the header of a session, and the header
 * takes precedence over the bone's file.
 *
 *   options --.
 *   session ---+--> plan --> debrief
 *   bone -----'       '----> session, keys plan.* (docs/spec/session.md)
 */
#ifndef OST_APP_INPUT_GLENOID_PLAN_H
#define OST_APP_INPUT_GLENOID_PLAN_H

#include "app/input/ream_path.h"

#include <osteon/metrics.h>

typedef struct glenoid_plan_options {
    target_options target;
    option_decimal depth;
    ost_pm3 trigonum, inferior;
    bool trigonum_given, inferior_given;
} glenoid_plan_options;

/* The rows of the plan's options in a verb's option table, except --at, --axis and --side. */
#define GLENOID_PLAN_OPTIONS(p)                                                                                        \
    {.name = "planned",                                                                                                \
     .kind = OPTION_DECIMAL,                                                                                           \
     .out = &(p).depth,                                                                                                \
     .value = "MM",                                                                                                    \
     .help = "planned reaming depth at the glenoid's centre (default: 3)"},                                            \
        {.name = "trigonum",                                                                                           \
         .kind = OPTION_POINT,                                                                                         \
         .out = &(p).trigonum,                                                                                         \
         .given = &(p).trigonum_given,                                                                                 \
         .value = "X,Y,Z",                                                                                             \
         .help = "trigonum spinae, where the scapula's spine meets its medial border; with it, version and "           \
                 "inclination are measured in the scapula's frame (default: as in the file)"},                         \
    {                                                                                                                  \
        .name = "inferior-angle", .kind = OPTION_POINT, .out = &(p).inferior, .given = &(p).inferior_given,            \
        .value = "X,Y,Z", .help = "inferior angle, the scapula's lowest point: likewise (default: as in the file)"     \
    }

/*
 * Finds the plan. `header` is the header of the session named `session`, or NULL. If no source contains the glenoid's
 * position, sets *known to false. If `needed` is true or another part of the plan is given, a missing position is an
 * error. The values are rounded to values that a session can store.
 */
ost_status glenoid_plan_find(const app_state *app, const glenoid_plan_options *options, const char *session,
                             const ost_session_header *header, const ost_meta *meta, const char *bone, bool needed,
                             ost_metrics_plan *out, bool *known, ost_error *err);

/* Stores a plan in the header of a session before the session is written. */
ost_status glenoid_plan_set(ost_session_header *header, const ost_metrics_plan *plan, ost_error *err);

#endif
