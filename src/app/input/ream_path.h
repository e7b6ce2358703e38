/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads the path of a reaming: one or more --path options, joined in the given order.
 *
 *   --tool peg --path builtin:peg-hole --tool reamer --path builtin:glenoid-ream
 *
 * Path k moves tool k. If there is only one tool, every path moves this tool. If the ticks of a file refer to tools
 * other than 0, they move those tools. Each path begins 1 ms after the end of the previous path, and its first tick is
 * lifted (docs/spec/arithmetic.md, AR-PATH-6).
 */
#ifndef OST_APP_INPUT_REAM_PATH_H
#define OST_APP_INPUT_REAM_PATH_H

#include "app/common/options.h"

typedef struct target_options {
    ost_pm3 at;
    bool at_given;
    double axis[3];
    bool axis_given;
    int side; /* index in "left|right" */
    bool side_given;
    size_t press_ticks; /* number of ticks for builtin:glenoid-press; 0 means one minute */
} target_options;

/* Rows for a verb's table of options. about_at is the help text of --at and states the default. */
#define TARGET_OPTIONS(t, about_at)                                                                                    \
    {.name = "at", .kind = OPTION_POINT, .out = &(t).at, .given = &(t).at_given, .value = "X,Y,Z",                     \
     .help = about_at},                                                                                                \
    {.name = "axis", .kind = OPTION_VECTOR, .out = (t).axis, .given = &(t).axis_given, .value = "X,Y,Z",               \
     .help = "direction into the bone at the glenoid's centre (default: as in the file)"},                             \
    {.name = "side", .kind = OPTION_CHOICE, .out = &(t).side, .given = &(t).side_given, .value = "left|right",         \
     .help = "side of the body (default: as in the file, else derived from the axis)"}

/*
 * Finds the glenoid's position, axis and side. Values that are not given by options are read from the bone's header. If
 * neither source contains the side, it is derived from the axis. Returns OST_ERR_USAGE if a value is not set, and
 * OST_ERR_INPUT if the side, the axis and the header contradict each other.
 */
ost_status target_find(const app_state *app, const target_options *options, const ost_meta *meta, const char *bone,
                       ost_glenoid *out, ost_error *err);

/*
 * Finds the side from --side or, without this option, from the header. Returns an error if --side contradicts the
 * header.
 */
ost_status target_side(const target_options *options, const ost_meta *meta, const char *bone, ost_side *out,
                       ost_error *err);

/* Number of gaps in the paths, at which a tool is lifted, and number of rows without a pose. */
typedef struct ream_gaps {
    size_t gaps, lost_rows;
} ream_gaps;

#define MAX_GAP_OPTION(text)                                                                                   \
    {.name = "max-gap", .kind = OPTION_TEXT, .out = &(text), .value = "MS[,MM]",                               \
     .help = "greatest time, and distance, between two rows of a path; farther rows form a gap, across which " \
             "nothing is removed; off: no limit (default: 50 ms and 5 mm, or 10 times the path's medians if "  \
             "these are greater)"}

/* Parses the value of --max-gap; text may be NULL. */
ost_status ream_max_gap(const app_state *app, const char *text, ost_path_options *out, ost_error *err);
void ream_print_gaps(const app_state *app, const ream_gaps *gaps);

ost_status ream_path_make(const app_state *app, const option_list *paths, const target_options *target,
                          const ost_meta *meta, const char *bone, const ost_tool_geometry *const *tools, int tool_count,
                          const ost_path_options *gaps, ost_path *out, ream_gaps *counted, ost_error *err);

/* Computes the period of a removal rate. If no rate is given, the period is 0, and every tick removes bone. */
ost_status ream_period(const app_state *app, const option_decimal *rate, int64_t *period_ns, ost_error *err);

#endif
