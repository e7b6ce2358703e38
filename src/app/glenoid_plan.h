/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What was planned: where the glenoid is, which way in, how deep, and the
 * scapula's landmarks.  What the user says goes before what a session says,
 * and that before what the bone's file says.
 *
 *   options --.
 *   session ---+--> plan --> debrief
 *   bone -----'       '----> session, keys plan.* (docs/session.md)
 */
#ifndef OST_APP_GLENOID_PLAN_H
#define OST_APP_GLENOID_PLAN_H

#include "app/ream_path.h"

#include <osteon/metrics.h>

typedef struct glenoid_plan_options {
    target_options target;
    option_decimal depth;
    ost_pm3 trigonum, inferior;
    bool trigonum_given, inferior_given;
} glenoid_plan_options;

/* Rows for a verb's table of options; --at, --axis and --side are its own. */
#define GLENOID_PLAN_OPTIONS(p)                                                                                                      \
    {.name = "planned", .kind = OPTION_DECIMAL, .out = &(p).depth, .value = "MM",                                            \
     .help = "planned depth at the glenoid's centre (default: 3)"},                                                          \
    {.name = "trigonum", .kind = OPTION_POINT, .out = &(p).trigonum, .given = &(p).trigonum_given, .value = "X,Y,Z",         \
     .help = "where the scapula's spine meets its medial border, for version and\ninclination in its own frame (default: the file's)"}, \
    {.name = "inferior-angle", .kind = OPTION_POINT, .out = &(p).inferior, .given = &(p).inferior_given, .value = "X,Y,Z",   \
     .help = "the scapula's lowest point, for the same"}

/*
 * header: of a session, named session, or NULL.  *known is false when nobody
 * says where the glenoid is: an error if needed, or if a part of the plan is given.
 * What it gives is what a session can hold, to the bit.
 */
ost_status glenoid_plan_find(const app_state *app, const glenoid_plan_options *options, const char *session, const ost_session_header *header, const ost_meta *meta,
                     const char *bone, bool needed, ost_metrics_plan *out, bool *known, ost_error *err);

/* Into the header of a new session. */
ost_status glenoid_plan_set(ost_session_header *header, const ost_metrics_plan *plan, ost_error *err);

#endif
