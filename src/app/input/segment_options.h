/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Options that divide a CT into bones and select some of them, for `osteon segment` and
 * `osteon import`.
 *
 *   CT --growth, cuts--> components --fill, separate--> bones --bone--> label map, facts, report
 */
#ifndef OST_APP_INPUT_SEGMENT_OPTIONS_H
#define OST_APP_INPUT_SEGMENT_OPTIONS_H

#include <osteon/anatomy.h>

#include "app/common/options.h"

typedef struct segment_options {
    option_list bones, balls, planes;
    int64_t growth, air;
    option_decimal min_volume;
    ost_pm separate;
    bool fill, separate_given, air_given;
    const char *head; /* value of --cut-head, "auto" or X,Y,Z; NULL if the option is not given */
} segment_options;

enum { SEGMENT_AIR = -200, SEGMENT_CUTS_MAX = OPTION_LIST_MAX * 2 + 1, SEGMENT_BALL_TEXT = 4 * OST_PM_TEXT };
#define SEGMENT_OPTIONS_DEFAULT {.air = SEGMENT_AIR}

/* The rows of the segmentation options in a verb's option table. */
#define SEGMENT_OPTIONS(s)                                                                                         \
    {.name = "bone", .kind = OPTION_LIST, .out = &(s).bones, .value = "largest|all|X,Y,Z",                         \
     .help = "bone to select: the largest one, all (default), or the one at a position; may be given several "     \
             "times"},                                                                                             \
    {.name = "min-volume", .kind = OPTION_DECIMAL, .out = &(s).min_volume, .value = "MM3",                         \
     .help = "minimum volume of a bone (default: 100)"},                                                           \
    {.name = "growth", .kind = OPTION_INTEGER, .out = &(s).growth, .value = "HU", .min = 1, .max = 32767,          \
     .help = "lowest density of the voxels of a bone, of which at least one reaches the threshold (default: as "   \
             "--threshold)"},                                                                                      \
    {.name = "fill", .kind = OPTION_FLAG, .out = &(s).fill,                                                        \
     .help = "assign holes inside a bone to this bone, unless they contain air"},                                  \
    {.name = "air", .kind = OPTION_INTEGER, .out = &(s).air, .given = &(s).air_given, .value = "HU",               \
     .min = -32768, .max = 32767, .help = "density below which a voxel is air (default: -200)"},                   \
    HEADING("separating bones that touch"),                                                                        \
    {.name = "separate", .kind = OPTION_LENGTH, .out = &(s).separate, .given = &(s).separate_given, .value = "MM", \
     .help = "divide a bone at a neck whose radius is at least MM less than that of the bone on both sides"},      \
    {.name = "cut-head", .kind = OPTION_TEXT, .out = &(s).head, .value = "auto|X,Y,Z",                             \
     .help = "cut by the ball of a humeral head: the only one in the CT, or the one at a position"},               \
    {.name = "cut-ball", .kind = OPTION_LIST, .out = &(s).balls, .value = "X,Y,Z,R",                               \
     .help = "no voxel within R mm of this position belongs to a bone; may be given several times"},               \
    {.name = "cut-plane", .kind = OPTION_LIST, .out = &(s).planes, .value = "X,Y,Z,NX,NY,NZ",                      \
     .help = "no voxel on the side of this plane to which N points belongs to a bone; may be given several times"}

/* The parsed options, and the bones that the segmentation has found. */
typedef struct segment_job {
    const app_state *app;
    const segment_options *options;
    ost_segment_cut cuts[SEGMENT_CUTS_MAX];
    size_t cut_count;
    ost_sphere head;       /* the sphere that was found for --cut-head */
    char head_ball[SEGMENT_BALL_TEXT]; /* the equivalent value of --cut-ball; "" without --cut-head */
    int64_t min_um3;       /* minimum volume of a bone in um3 */
    ost_geometry geometry; /* grid of the CT */
    uint64_t min_voxels;
    ost_segment *segments; /* owned; the selected bones */
    size_t count;
    size_t found;          /* number of bones before --bones selects some of them */
} segment_job;

/* Returns true if at least one of the options is given, so that `osteon import` must divide the CT. */
bool segment_is_given(const segment_options *options);
/* Parses the options. The job borrows app and options. The caller frees the job with segment_job_free. */
ost_status segment_job_init(segment_job *job, const app_state *app, const segment_options *options, ost_error *err);
void segment_job_free(segment_job *job);
/*
 * Makes the label map of the selected bones. Its meta contains the facts whose keys begin with "segment_", but not the
 * facts of the CT. Returns an error if there is no bone at a position of --bone. The caller frees *labels with
 * ost_volume_free.
 */
ost_status segment_job_run(segment_job *job, const ost_volume *ct, int32_t threshold, ost_volume *labels,
                           ost_error *err);
/* Returns the volume in mm3 of the smallest component that the job accepts as a bone. Valid after segment_job_run. */
double segment_job_min_mm3(const segment_job *job);
/* Implements ost_import_labels; `user` is the job. Returns an error if no bone was found. */
ost_status segment_job_labels(void *user, const ost_volume *ct, int32_t threshold, ost_volume *labels, ost_error *err);
/* Prints the selected bones and stores them in the result of the verb as "components" and "segments". */
void segment_job_report(const segment_job *job, const char *what);

#endif
