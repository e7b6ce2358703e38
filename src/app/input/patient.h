/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Stores facts about the patient in the header of a bone or CT: the glenoid's position, the axis into the bone, the
 * side, and the scapula's landmarks.
 *
 *   --landmarks FILE --.                   (--landmarks auto: landmarks are proposed for the bone, proposal.h)
 *   --at --axis ...  ---+--> meta, checked --> header (import)
 *   --set KEY=VALUE  --'                  '--> header, rewritten (info)
 *
 * Options replace the values of a landmarks file. It is an error if a side contradicts the axis or differs from the
 * side that is already in the header.
 */
#ifndef OST_APP_INPUT_PATIENT_H
#define OST_APP_INPUT_PATIENT_H

#include "app/input/glenoid_plan.h"

#include <osteon/io.h>

typedef struct patient_options {
    target_options target;
    ost_pm3 trigonum, inferior;
    bool trigonum_given, inferior_given;
    const char *landmarks, *landmarks_out;
} patient_options;

/* The rows of the patient options in a verb's option table. */
#define PATIENT_OPTIONS(p)                                                                                             \
    {.name = "at",                                                                                                     \
     .kind = OPTION_POINT,                                                                                             \
     .out = &(p).target.at,                                                                                            \
     .given = &(p).target.at_given,                                                                                    \
     .value = "X,Y,Z",                                                                                                 \
     .help = "centre of the glenoid's face"},                                                                          \
        {.name = "axis",                                                                                               \
         .kind = OPTION_VECTOR,                                                                                        \
         .out = (p).target.axis,                                                                                       \
         .given = &(p).target.axis_given,                                                                              \
         .value = "X,Y,Z",                                                                                             \
         .help = "direction into the bone at this centre"},                                                            \
        {.name = "side",                                                                                               \
         .kind = OPTION_CHOICE,                                                                                        \
         .out = &(p).target.side,                                                                                      \
         .given = &(p).target.side_given,                                                                              \
         .value = "left|right",                                                                                        \
         .help = "side of the body (default: as in the file, else derived from the axis)"},                            \
        {.name = "trigonum",                                                                                           \
         .kind = OPTION_POINT,                                                                                         \
         .out = &(p).trigonum,                                                                                         \
         .given = &(p).trigonum_given,                                                                                 \
         .value = "X,Y,Z",                                                                                             \
         .help = "trigonum spinae, where the scapula's spine meets its medial border"},                                \
        {.name = "inferior-angle",                                                                                     \
         .kind = OPTION_POINT,                                                                                         \
         .out = &(p).inferior,                                                                                         \
         .given = &(p).inferior_given,                                                                                 \
         .value = "X,Y,Z",                                                                                             \
         .help = "inferior angle, the scapula's lowest point"},                                                        \
        {.name = "landmarks",                                                                                          \
         .kind = OPTION_TEXT,                                                                                          \
         .out = &(p).landmarks,                                                                                        \
         .value = "FILE|auto",                                                                                         \
         .help = "auto: propose these points for a scapula; or a file with them: .mrk.json or .fcsv of 3D Slicer, or " \
                 "a CSV label,x,y,z (LPS); labels: glenoid, axis (a point inside the bone on the axis), trigonum, "    \
                 "inferior angle"},                                                                                    \
    {                                                                                                                  \
        .name = "landmarks-out", .kind = OPTION_OUTPUT, .out = &(p).landmarks_out, .value = "FILE.mrk.json",           \
        .help = "write these points, to correct them in 3D Slicer and to pass them to --landmarks"                     \
    }

/* Checks the options before the bone is read. */
ost_status patient_check(app_state *app, const patient_options *options, ost_error *err);

/*
 * Adds facts from the options and from the landmarks file to *meta, and then checks all facts in *meta. Reports unknown
 * labels in the landmarks file. With --landmarks auto, landmarks are proposed for `bone`. `name` is the name of the
 * volume, for messages.
 */
ost_status patient_take(const app_state *app, const patient_options *options, const ost_bone *bone, const char *name,
                        const ost_geometry *geometry, ost_meta *meta, ost_error *err);

/*
 * Stores the facts of all options --set KEY=VALUE in meta, in the order of the options. An empty VALUE removes the
 * fact.
 */
ost_status patient_set(const app_state *app, const option_list *sets, const char *name, const ost_geometry *geometry,
                       ost_meta *meta, ost_error *err);

#endif
